//! From photons to maps.

use crate::math::{Spectrum, WorldPoint, warp};
use crate::medium::Phase;
use crate::scene::Scene;

use super::camera_importance::CameraImportance;
use super::extents::Extents;
use super::maps::THINNING;
use super::path::Deposits;
use super::radius::{self, Probes, Radii};
use super::traced::{PathSample, ShotPart, TracedPhotons};
use super::{BeamMap, Photon, PhotonAt, PhotonDirection, PhotonMaps, SurfaceMap};

/// Largest radius of a surface photon, as a share of the diagonal of all surfaces and media.
///
/// Unit: none. Limit: on how far a photon without neighbours spreads, and on the places that find it.
const MAX_SURFACE_RADIUS: f64 = 0.1;

/// What maps are built with: the scene, and what its camera sees.
#[derive(Debug)]
pub struct MapBuilder<'a> {
    pub(super) scene: &'a Scene,
    pub(super) extents: Extents,
    pub(super) importance: CameraImportance,
}

/// Where rays gather photons in media: in a ball round this centre, of a radius in metres.
#[derive(Debug, Clone, Copy)]
pub struct GatherBall {
    /// Its centre.
    pub center: WorldPoint,
    /// Its radius.
    pub radius: f64,
}

/// What the maps of some photons depend on beside those.
struct MapSettings {
    /// What positions are relative to.
    origin: WorldPoint,
    /// Number of photons that each stands for: radii on surfaces are chosen for all of those.
    represents: f64,
    /// Where rays gather photons in media, if not everywhere.
    ball: Option<GatherBall>,
}

impl<'a> MapBuilder<'a> {
    /// For photons that were shot before, in `scene`, of which the camera sees what `importance` tells. Radii
    /// are `radius` metres where that is given.
    pub fn new(scene: &'a Scene, importance: CameraImportance, radius: Option<f64>) -> Self {
        let extents = Extents::new(scene, &importance, radius);
        Self { scene, extents, importance }
    }

    /// The maps of the photons that the paths of `part` left, which are freed. `phases` scatter those of each medium
    /// when they are gathered. Where rays gather only in a `ball`, photons whose kernels do not reach it are left out.
    pub fn build<S: Spectrum, H: PhotonDirection>(
        &self,
        phases: &[Phase],
        part: &PathSample,
        traced: TracedPhotons<S, H>,
        ball: Option<GatherBall>,
    ) -> ShotPart<S, H> {
        let TracedPhotons { deposits, origin, units } = traced;
        let PathSample { represents, levels, .. } = *part;
        let of = MapSettings { origin, represents, ball };
        let ((volume, [volume_radius, radius_of_all]), surface) = rayon::join(
            || self.in_media(&of, levels, phases, &deposits),
            || self.on_surfaces(&of, &deposits.surface),
        );
        let [volume_unit, surface_unit] =
            [units.volume, units.surface].map(|unit| unit * represents);
        let free_paths = match self.extents.radius {
            Some(_) => f64::INFINITY,
            None => volume_radius / radius_of_all,
        };
        let maps =
            PhotonMaps { volume, volume_radius, free_paths, surface, volume_unit, surface_unit };
        ShotPart { maps, work: deposits.work, radius_of_all }
    }

    /// The map of the photons in media with `levels` thinned ones, and the gather radii in metres that
    /// are typical of what the camera sees: of these photons, and of all that they stand for. `phases` scatter
    /// the photons of each medium.
    fn in_media<S: Spectrum, H: PhotonDirection>(
        &self,
        of: &MapSettings,
        levels: u32,
        phases: &[Phase],
        deposits: &Deposits<S, H>,
    ) -> (Vec<BeamMap<S, H>>, [f64; 2]) {
        let Extents { depth, margin, .. } = self.extents;
        let origin = of.origin;
        let photons = &deposits.volume;
        let radii = match self.extents.radius {
            Some(radius) => Radii::constant(radius, photons.len()),
            None => {
                let weight =
                    |p: &PhotonAt<S, H>| toward_camera(self.scene, phases, p.at(origin), &p.photon);
                let independent = deposits.independent.iter();
                let independent: Vec<PhotonAt<S, H>> =
                    independent.map(|index| photons[*index]).collect();
                let probes = of.probes(&independent, photons.len());
                let visible = &self.importance.media;
                Radii::adaptive(origin, photons, &probes, visible, depth, weight, margin)
            }
        };
        let typical = [radii.typical, radii.typical_of_all];
        (of.thinned_maps(photons, &radii.each, levels), typical)
    }

    /// The map of the photons on surfaces.
    fn on_surfaces<S: Spectrum>(&self, of: &MapSettings, photons: &[PhotonAt<S>]) -> SurfaceMap<S> {
        let origin = of.origin;
        let radii = match self.extents.radius {
            Some(radius) => vec![radius as f32; photons.len()],
            None => {
                let most = MAX_SURFACE_RADIUS * self.extents.full_size();
                let probes = of.probes(photons, photons.len());
                radius::on_surfaces(origin, photons, &probes, most)
            }
        };
        SurfaceMap::new(origin, photons, &radii)
    }
}

impl MapSettings {
    /// Photons that sample the distribution of `count`, each of which represents as many.
    fn probes<'a, S: Spectrum, H>(
        &self,
        photons: &'a [PhotonAt<S, H>],
        count: usize,
    ) -> Probes<'a, S, H> {
        let count = count as f64;
        Probes { photons, count, all: count * self.represents }
    }

    /// The map of all `photons`, and as many `levels` more of fewer and wider ones.
    fn thinned_maps<S: Spectrum, H: PhotonDirection>(
        &self,
        photons: &[PhotonAt<S, H>],
        radii: &[f32],
        levels: u32,
    ) -> Vec<BeamMap<S, H>> {
        let map = |level: u32| {
            let (step, widening) = (THINNING.pow(level), (1_u32 << level) as f32);
            let all = photons.iter().zip(radii.iter().map(|radius| radius * widening));
            let (thinned, radii): (Vec<_>, Vec<_>) =
                all.step_by(step).filter(|(photon, radius)| self.reaches(photon, *radius)).unzip();
            BeamMap::new(self.origin, &thinned, &radii)
        };
        let all = match self.ball {
            None => BeamMap::new(self.origin, photons, radii),
            Some(_) => map(0),
        };
        std::iter::once(all).chain((1..=levels).map(map)).collect()
    }

    /// Whether rays gather a photon that has this radius.
    fn reaches<S: Spectrum, H: PhotonDirection>(
        &self,
        photon: &PhotonAt<S, H>,
        radius: f32,
    ) -> bool {
        self.ball.is_none_or(|ball| {
            (photon.at(self.origin) - ball.center).length() <= ball.radius + f64::from(radius)
        })
    }
}

/// Ratio of the light that a photon scatters toward the camera to that of an isotropic phase function,
/// by the most peaked of `phases`.
fn toward_camera<S: Spectrum, H: PhotonDirection>(
    scene: &Scene,
    phases: &[Phase],
    p: WorldPoint,
    photon: &Photon<S, H>,
) -> f64 {
    let (direction, wo) = (photon.stored_direction(), scene.camera.toward(p));
    let most = phases.iter().map(|phase| direction.scattered(phase, wo)).fold(0.0, f64::max);
    most / warp::uniform_sphere_pdf()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Ray, Rgb, Span, Stage, Stream};
    use crate::photon::maps::Response;
    use crate::photon::{AimedPhotons, Octahedral, PhotonSettings, Recording};
    use crate::scene::plan::Needs;

    /// Rays in a ball round the camera find the same light whether all photons are kept or those alone that reach it.
    #[test]
    fn photons_that_no_ray_gathers_are_left_out() {
        let scene = Scene::of_text(
            "
            [camera]
            position = [0.0, 0.0, 3.0]
            target = [0.0, 0.0, 0.0]
            [film]
            size = [16, 16]
            [[medium]]
            region = { box = { min = [-5.0, -5.0, -5.0], max = [5.0, 5.0, 5.0] } }
            sigma_t = 0.5
            albedo = 0.95
            phase = { type = 'henyey-greenstein', g = 0.5 }
            [[light]]
            type = 'point'
            position = [0.0, 2.0, 0.0]
            intensity = 10.0
            ",
        );
        let needs = Needs::EVERYTHING;
        let settings = PhotonSettings {
            photons: 20_000,
            traced: None,
            seed: 1,
            max_scatter: None,
            radius: None,
            levels: 1,
            needs,
            any_camera: false,
        };
        let importance = CameraImportance::look(&scene, needs);
        let mut aimed =
            AimedPhotons::new::<Rgb, Octahedral>(&scene, &settings, importance, false).unwrap();
        let part = aimed.all(&settings);
        let (center, radius) = (WorldPoint::new(0.0, 0.0, 3.0), 0.7);
        let phases = [scene.media.get(0).phase];
        let [all, near] = [None, Some(GatherBall { center, radius })].map(|ball| {
            let flights = &mut |_: &[&[_]]| ();
            let recording = Recording { volume_photons: true, flight_bounds: None, flights };
            let traced = aimed.trace::<Rgb, Octahedral>(recording, &part, &|_| ());
            aimed.builder().build(&phases, &part, traced, ball).maps
        });
        for level in [0, 1] {
            let [all, near] = [&all, &near].map(|maps| maps.volume[level].len());
            assert!(0 < near && near < all / 2, "{near} of {all} at level {level}");
        }
        let mut rng = Stream::new(1, Stage::Test, 0, 0);
        for index in 0..64 {
            let direction = warp::uniform_sphere(rng.uniform2());
            let ray = Ray::new(center, direction);
            let widening = f64::from(1 + index % 2);
            let [all, near] = [&all, &near].map(|maps| {
                let respond =
                    |_| Some(Response { sigma_t: 0.5, scatterers: [(&phases[0], Rgb::ONE)] });
                let (span, width) = (Span::new(0.0, radius), widening * maps.volume_radius);
                maps.along(&ray, span, width, &mut 0, respond)
            });
            assert!(
                all.x > 0.0 && (near / all - 1.0).abs().max_element() < 1e-5,
                "{near} of {all}"
            );
        }
    }
}
