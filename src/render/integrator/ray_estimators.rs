//! Which estimators bring the light that each medium scatters along a ray.

use crate::cache::Caches;
use crate::light::{Light, LightRegion};
use crate::math::Spectrum;
use crate::scene::Scene;
use crate::strategy::{Choice, Strategy, away_from_camera};

/// Estimators for one kind of ray: caches hold light scattered toward the camera, so that they serve rays
/// from there, and all rays where a medium scatters isotropically.
#[derive(Debug)]
pub(super) struct RayEstimators {
    /// The strategy of each medium for these rays.
    strategies: Vec<Strategy>,
    /// Distance along rays, in metres, within which they gather photons in each medium.
    beams_within: Vec<f64>,
    /// For each medium whether rays sample its direct light in the cache.
    pub caches_direct: Vec<bool>,
    /// Media whose direct light is sampled along rays, grouped by the lights that bring it.
    pub direct: Vec<DirectLightGroup>,
}

/// Media whose direct light from the same lights is sampled along rays.
#[derive(Debug)]
pub(super) struct DirectLightGroup {
    /// Mask of the media.
    pub media: Vec<bool>,
    /// Where each light is sampled; other estimators bring the rest.
    pub regions: Vec<LightRegion>,
}

impl RayEstimators {
    /// For rays from the camera, or others. `handled_by_gather` is the mask of lights that final gathers
    /// hit with their own rays.
    pub fn new<S: Spectrum>(
        scene: &Scene,
        choice: &Choice,
        caches: &Caches<S>,
        handled_by_gather: &[bool],
        from_camera: bool,
    ) -> Self {
        let lights = &scene.lights.lights;
        let mut estimators = Self {
            strategies: Vec::new(),
            beams_within: Vec::new(),
            caches_direct: Vec::new(),
            direct: Vec::new(),
        };
        for (index, medium) in scene.media.iter().enumerate() {
            let is_cached = from_camera || medium.phase.is_isotropic();
            let strategy = choice.media.get(index).map_or(Strategy::Beams, |m| m.strategy);
            let strategy = if is_cached { strategy } else { away_from_camera(strategy) };
            let cache = caches.direct.get(index).and_then(Option::as_ref).filter(|_| is_cached);
            let except = |is_elsewhere: bool| match is_elsewhere {
                true => LightRegion::Nowhere,
                false => LightRegion::Everywhere,
            };
            let region = |(index, light): (usize, &Light)| match (light.is_environment(), strategy)
            {
                (false, _) => cache.map_or(LightRegion::Everywhere, |cache| cache.uncached(index)),
                (true, Strategy::Beams) => LightRegion::Everywhere,
                // Flights straight from the sky are in the grid.
                (true, Strategy::FluenceTowardEye) => except(choice.records_sky),
                (true, _) => except(handled_by_gather[index]),
            };
            let regions = lights.iter().enumerate().map(region).collect();
            let beams_within = match strategy {
                Strategy::Beams => f64::INFINITY,
                _ => choice.beams_within[index],
            };
            estimators.strategies.push(strategy);
            estimators.beams_within.push(beams_within);
            estimators.caches_direct.push(cache.is_some());
            estimators.sample_along_rays(index, scene.media.iter().len(), regions);
        }
        estimators
    }

    /// Adds a medium of this index, of `count`, to the group of those whose lights are sampled at the same places.
    fn sample_along_rays(&mut self, index: usize, count: usize, regions: Vec<LightRegion>) {
        if regions.iter().all(|region| *region == LightRegion::Nowhere) {
            return;
        }
        match self.direct.iter_mut().find(|group| group.regions == regions) {
            Some(group) => group.media[index] = true,
            None => {
                let media = (0..count).map(|medium| medium == index).collect();
                self.direct.push(DirectLightGroup { media, regions });
            }
        }
    }

    /// Whether each ray makes a final gather in this medium.
    pub fn gathers(&self, medium: usize) -> bool {
        matches!(self.strategies[medium], Strategy::Moments | Strategy::Traced)
    }

    /// Whether any medium is like that.
    pub fn any(&self, is: impl Fn(usize) -> bool) -> bool {
        (0..self.strategies.len()).any(is)
    }

    /// Whether rays read light of this medium in caches.
    pub fn reads_caches(&self, medium: usize) -> bool {
        self.caches_direct[medium]
            || matches!(
                self.strategies[medium],
                Strategy::FluenceTowardEye | Strategy::SharedGathers
            )
    }

    /// The strategy of a medium `t` metres along a ray.
    pub fn strategy_at(&self, medium: usize, t: f64) -> Strategy {
        if t < self.beams_within[medium] { Strategy::Beams } else { self.strategies[medium] }
    }

    /// Distance along rays, in metres, within which they gather photons in any medium.
    pub fn beams_end(&self) -> f64 {
        self.beams_within.iter().copied().fold(0.0, f64::max)
    }
}

/// Mask of the lights that final gathers hit with their own rays: environments, where any medium has
/// gathers and none of the grids that they end at lacks the sky's straight light.
pub(super) fn handled_by_gather(scene: &Scene, choice: &Choice) -> Vec<bool> {
    let any = |is: fn(Strategy) -> bool| choice.media.iter().any(|medium| is(medium.strategy));
    let is_handled =
        any(Strategy::makes_gathers) && (choice.records_sky || !any(Strategy::holds_moments));
    scene.lights.lights.iter().map(|light| is_handled && light.is_environment()).collect()
}
