//! The maps of photons that are gathered.

use crate::math::{Spectrum, WorldPoint, warp};
use crate::scene::Scene;

use super::camera_importance::CameraImportance;
use super::extents::Extents;
use super::maps::THINNING;
use super::path::Deposits;
use super::radius::{self, Radii};
use super::{BeamMap, Photon, PhotonAt, PhotonDirection, PhotonSettings, SurfaceMap};
use crate::strategy::PhaseSplit;

/// The map of the photons in media and thinned ones of it, with the gather radius in metres that is
/// typical of what the camera sees. They are scattered by `scatterings`.
pub(super) fn in_media<S: Spectrum, H: PhotonDirection>(
    scene: &Scene,
    shooting: &PhotonSettings,
    extents: &Extents,
    visible: &CameraImportance,
    scatterings: &[PhaseSplit],
    deposits: &Deposits<S, H>,
) -> (Vec<BeamMap<S, H>>, f64) {
    let Extents { origin, depth, margin, .. } = *extents;
    let photons = &deposits.volume;
    let radii = match extents.radius {
        Some(radius) => Radii::constant(radius, photons.len()),
        None => {
            let weight =
                |p: &PhotonAt<S, H>| toward_camera(scene, scatterings, p.at(origin), &p.photon);
            let independent = deposits.independent.iter();
            let independent: Vec<PhotonAt<S, H>> =
                independent.map(|index| photons[*index]).collect();
            let seen = &visible.media;
            Radii::adaptive(origin, photons, &independent, seen, depth, weight, margin)
        }
    };
    (thinned_maps(origin, photons, &radii.each, shooting.levels), radii.typical)
}

/// The map of the photons on surfaces.
pub(super) fn on_surfaces<S: Spectrum>(
    extents: &Extents,
    photons: &[PhotonAt<S>],
) -> SurfaceMap<S> {
    let radii = match extents.radius {
        Some(radius) => vec![radius as f32; photons.len()],
        None => radius::on_surfaces(extents.origin, photons, 0.1 * extents.of_surfaces()),
    };
    SurfaceMap::new(extents.origin, photons, &radii)
}

/// The map of all `photons`, and as many `levels` more of fewer and wider ones.
fn thinned_maps<S: Spectrum, H: PhotonDirection>(
    origin: WorldPoint,
    photons: &[PhotonAt<S, H>],
    radii: &[f32],
    levels: u32,
) -> Vec<BeamMap<S, H>> {
    let map = |level: u32| {
        let (step, wider) = (THINNING.pow(level), (1_u32 << level) as f32);
        let left: Vec<PhotonAt<S, H>> = photons.iter().step_by(step).copied().collect();
        let radii: Vec<f32> = radii.iter().step_by(step).map(|r| r * wider).collect();
        BeamMap::new(origin, &left, &radii)
    };
    let all = BeamMap::new(origin, photons, radii);
    std::iter::once(all).chain((1..=levels).map(map)).collect()
}

/// How much more a photon's light scatters toward the camera than if it were spread evenly, by the
/// most peaked phase function.
fn toward_camera<S: Spectrum, H: PhotonDirection>(
    scene: &Scene,
    scatterings: &[PhaseSplit],
    p: WorldPoint,
    photon: &Photon<S, H>,
) -> f64 {
    let (heading, toward) = (photon.heading(), scene.camera.toward(p));
    let phases = scatterings.iter().map(|scattering| &scattering.phase);
    let most = phases.map(|phase| heading.spread(phase, toward)).fold(0.0, f64::max);
    most / warp::uniform_sphere_pdf()
}
