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

/// What the maps of some photons depend on beside those.
struct MapSettings {
    /// What positions are relative to.
    origin: WorldPoint,
    /// Number of photons that each stands for: radii on surfaces are chosen for all of those.
    represents: f64,
}

impl<'a> MapBuilder<'a> {
    /// For photons that were shot before, in `scene`, of which the camera sees what `importance` tells. Radii
    /// are `radius` metres where that is given.
    pub fn new(scene: &'a Scene, importance: CameraImportance, radius: Option<f64>) -> Self {
        let extents = Extents::new(scene, &importance, radius);
        Self { scene, extents, importance }
    }

    /// The maps of the photons that the paths of `part` left, which are freed. `phases` scatter those of each medium
    /// when they are gathered.
    pub fn build<S: Spectrum, H: PhotonDirection>(
        &self,
        phases: &[Phase],
        part: &PathSample,
        traced: TracedPhotons<S, H>,
    ) -> ShotPart<S, H> {
        let TracedPhotons { deposits, origin, units } = traced;
        let PathSample { represents, levels, .. } = *part;
        let of = MapSettings { origin, represents };
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
        (thinned_maps(origin, photons, &radii.each, levels), typical)
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
}

/// The map of all `photons`, and as many `levels` more of fewer and wider ones.
fn thinned_maps<S: Spectrum, H: PhotonDirection>(
    origin: WorldPoint,
    photons: &[PhotonAt<S, H>],
    radii: &[f32],
    levels: u32,
) -> Vec<BeamMap<S, H>> {
    let map = |level: u32| {
        let (step, widening) = (THINNING.pow(level), (1_u32 << level) as f32);
        let thinned: Vec<PhotonAt<S, H>> = photons.iter().step_by(step).copied().collect();
        let radii: Vec<f32> = radii.iter().step_by(step).map(|r| r * widening).collect();
        BeamMap::new(origin, &thinned, &radii)
    };
    let all = BeamMap::new(origin, photons, radii);
    std::iter::once(all).chain((1..=levels).map(map)).collect()
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
