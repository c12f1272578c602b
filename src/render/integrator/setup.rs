//! What the estimators of one render share: scene, photon maps, caches, and what is known of media and
//! lights before the first ray.

use smallvec::SmallVec;

use crate::cache::Caches;
use crate::light::LightBounds;
use crate::math::{Rgb, Spectrum, WorldPoint};
use crate::medium::Phase;
use crate::photon::{PhotonDirection, PhotonMaps};
use crate::scene::Scene;
use crate::scene::plan::Needs;
use crate::strategy::Choice;
use crate::transport::camera_position;

use super::emission_nee::EmissionNee;
use super::light_lobes::LightLobes;
use super::ray_estimators::{RayEstimators, handled_by_gather};

/// Phase functions with their weights at a point.
pub(super) type Scatterers<'a, S> = SmallVec<[(&'a Phase, S); 1]>;

/// Radiance of an estimate, W/(m² sr).
#[derive(Debug, Clone, Copy)]
pub(super) struct Estimate<S> {
    /// All of it.
    pub radiance: S,
    /// The part of it that is indirect light estimated for other rays of the pixel too.
    pub indirect: S,
}

impl<S: Spectrum> Estimate<S> {
    /// No light.
    pub const ZERO: Self = Self { radiance: S::ZERO, indirect: S::ZERO };
}

/// Estimates the radiance along camera rays through a scene lit by its photon maps. It does not change
/// while rays are traced.
///
/// [`radiance`](Self::radiance) is the entrance; the call path of a ray reads from there:
/// `camera_path`, `in_scattering`, and the estimators that this sums.
#[derive(Debug)]
pub struct Integrator<'a, S: Spectrum, H: PhotonDirection> {
    pub(super) scene: &'a Scene,
    /// Where the camera is.
    pub(super) eye: WorldPoint,
    pub(super) maps: &'a PhotonMaps<S, H>,
    pub(super) caches: &'a Caches<S>,
    pub(super) choice: &'a Choice,
    pub(super) needs: Needs,
    pub(super) media: MediumTraits,
    /// Emissive media that final gathers sample, where there are any.
    pub(super) emission: Option<EmissionNee<'a>>,
    /// Mask of the lights that final gathers hit with their own rays.
    pub(super) handled_by_gather: Vec<bool>,
    /// Mask of the lights that shine from within media.
    pub(super) lamps_in_media: Vec<bool>,
    /// Estimators for rays from the camera.
    pub(super) from_camera: RayEstimators,
    /// Estimators for all other rays.
    pub(super) elsewhere: RayEstimators,
}

/// What is known of the media of a scene before rays are traced.
#[derive(Debug)]
pub(super) struct MediumTraits {
    /// Phase function of each medium.
    phases: Vec<Phase>,
    /// Grid lookups of [`Integrator::albedos`].
    pub albedo_lookups: u64,
    /// Whether camera rays are deflected by the forward peak of any phase function.
    pub has_forward_peak: bool,
    /// For each medium the lobes that send final gathers toward lights.
    pub light_lobes: Vec<LightLobes>,
    /// Scatterings after which a path that was sent toward a light ends.
    pub sent_reach: usize,
    /// For each medium whether final gathers can end there.
    pub holds_moments: Vec<bool>,
}

impl<'a, S: Spectrum, H: PhotonDirection> Integrator<'a, S, H> {
    /// The integrator of `scene` by these photons and caches, as far as `needs` say that it is needed.
    pub fn new(
        scene: &'a Scene,
        maps: &'a PhotonMaps<S, H>,
        caches: &'a Caches<S>,
        choice: &'a Choice,
        needs: Needs,
    ) -> Self {
        let media = MediumTraits::new(scene, choice);
        let handled_by_gather = handled_by_gather(scene, choice);
        let makes_gathers = choice.media.iter().any(|medium| medium.strategy.makes_gathers());
        let emission = (needs.emission && makes_gathers).then(|| EmissionNee::new(scene)).flatten();
        let [from_camera, elsewhere] = [true, false].map(|from_camera| {
            RayEstimators::new(scene, choice, caches, &handled_by_gather, from_camera)
        });
        Self {
            scene,
            eye: camera_position(scene),
            maps,
            caches,
            choice,
            needs,
            media,
            emission,
            handled_by_gather,
            lamps_in_media: lamps_in_media(scene),
            from_camera,
            elsewhere,
        }
    }

    /// The albedo sigma_s / sigma_t at `p`, divided among the media that scatter there: index and part
    /// of each.
    pub(super) fn albedos(&self, p: WorldPoint) -> SmallVec<[(usize, S); 1]> {
        let media = &self.scene.media;
        if media.len() == 1 {
            let albedo = S::from_rgb(media.get(0).albedo.at(p));
            return (albedo != S::ZERO).then_some((0, albedo)).into_iter().collect();
        }
        let sigma_t = media.sigma_t_at(p);
        let mixture = media.mixture_at(p);
        mixture.iter().map(|(medium, sigma_s)| (*medium, albedo_of(*sigma_s, sigma_t))).collect()
    }

    /// The phase functions of the media that scatter at `p`, of all or of those in the mask `media`,
    /// each weighed by its part of the albedo.
    pub(super) fn scatterers(&self, p: WorldPoint, media: Option<&[bool]>) -> Scatterers<'_, S> {
        let is_included = |(medium, _): &(usize, S)| media.is_none_or(|mask| mask[*medium]);
        let scatterer = |(medium, albedo): (usize, S)| (&self.media.phases[medium], albedo);
        self.albedos(p).into_iter().filter(is_included).map(scatterer).collect()
    }
}

impl MediumTraits {
    fn new(scene: &Scene, choice: &Choice) -> Self {
        let media = &scene.media;
        let lookups = media.scattering_grids();
        // The albedo of a single medium does not depend on its density.
        let albedo_lookups = match media.len() {
            1 => lookups - media.density_grids(),
            _ => lookups + media.density_grids(),
        };
        let light_lobes: Vec<_> = media.iter().map(|m| LightLobes::new(&m.phase)).collect();
        Self {
            phases: media.iter().map(|m| m.phase).collect(),
            albedo_lookups,
            has_forward_peak: choice.splits.iter().any(|split| split.peak.is_some()),
            sent_reach: light_lobes.iter().map(LightLobes::reach).max().unwrap_or(0),
            light_lobes,
            holds_moments: choice.media.iter().map(|m| m.strategy.holds_moments()).collect(),
        }
    }
}

/// For each light whether it shines from within the box round all media.
fn lamps_in_media(scene: &Scene) -> Vec<bool> {
    let media = &scene.media;
    let is_inside = |bounds: LightBounds| media.is_endless() || bounds.touches(&media.bounds());
    let lights = scene.lights.lights.iter();
    lights.map(|light| !media.is_empty() && light.bounds().is_some_and(is_inside)).collect()
}

/// sigma_s / sigma_t; 0 where there is no extinction.
fn albedo_of<S: Spectrum>(sigma_s: Rgb, sigma_t: Rgb) -> S {
    S::from_rgb(Rgb::select(sigma_t.cmpgt(Rgb::ZERO), sigma_s / sigma_t, Rgb::ZERO))
}

/// One of `parts`, chosen in proportion to its weight's sum over channels, with the weight divided
/// by the probability of that; `None` where all weights are 0. `u` is uniform in [0, 1).
pub(super) fn choose<T, S: Spectrum>(parts: SmallVec<[(T, S); 1]>, u: f64) -> Option<(T, S)> {
    let total: f64 = parts.iter().map(|(_, weight)| weight.element_sum()).sum();
    let mut left = u * total;
    let (part, weight) = parts.into_iter().find(|(_, weight)| {
        left -= weight.element_sum();
        left < 0.0
    })?;
    Some((part, weight * (total / weight.element_sum())))
}

#[cfg(test)]
mod tests {
    use smallvec::smallvec;

    use super::*;

    /// Over the strata of u each part comes in proportion to its weight, and the mean of the weights
    /// over probabilities is the sum of all.
    #[test]
    fn a_chosen_part_stands_for_all() {
        let parts: SmallVec<[(usize, Rgb); 1]> = smallvec![
            (0, Rgb::new(0.1, 0.2, 0.3)),
            (1, Rgb::ZERO),
            (2, Rgb::new(0.5, 0.3, 0.1)),
            (3, Rgb::new(0.0, 0.0, 0.1)),
        ];
        let total: Rgb = parts.iter().map(|(_, weight)| *weight).sum();
        let count = 16_000;
        let (mut times, mut sum) = ([0; 4], Rgb::ZERO);
        for index in 0..count {
            let u = (f64::from(index) + 0.5) / f64::from(count);
            let (part, weight) = choose(parts.clone(), u).unwrap();
            times[part] += 1;
            sum += weight / f64::from(count);
        }
        assert_eq!(times, [6000, 0, 9000, 1000]);
        assert!((sum - total).abs().max_element() < 1e-9, "{sum} not {total}");
        assert!(choose::<usize, Rgb>(smallvec![(0, Rgb::ZERO)], 0.5).is_none());
    }
}
