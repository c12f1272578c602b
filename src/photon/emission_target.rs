//! Where photons are aimed.

use crate::error::{Error, Result};
use crate::light::{EmissionTarget, TargetSphere};
use crate::scene::Scene;
use crate::transport::is_camera_outside;

use super::camera_importance::CameraImportance;
use super::extents::{ENDLESS, Extents, middle};

/// Radius of the surroundings that are aimed at for the light that they scatter on: of the ground round a
/// point over an infinite plane, in radii of the scene or in heights over the plane, whichever is more; of
/// the halo round what is seen of a medium that the camera is in or near, in radii of that.
///
/// Unit: none. Derivation: a disk whose radius is four heights gives 16/17 of the irradiance of an endless
/// ground, 4² / (1 + 4²).
const SURROUNDINGS_RADIUS: f64 = 4.0;

/// Largest height over an infinite plane that counts, in radii of the scene.
///
/// Unit: none. Limit: on the target of a scene that hangs far over a plane.
const MAX_HEIGHT: f64 = 1e4;

/// Smallest radius of the sphere round what the camera sees, in radii of the scene.
///
/// Unit: none. Limit: on the density of emission where what is seen is a point.
const MIN_VISIBLE_RADIUS: f64 = 1e-3;

/// What photons are aimed at: above all what the camera sees of the media, and round it all media and
/// finite surfaces, with the ground about them where a plane is infinite; everything where a medium is
/// unbounded. Emission by what the camera sees is that of Peter and Pietrek 1998, "Importance Driven
/// Construction of Photon Maps", with balls round the visible places in place of an importance map.
pub(super) fn emission_target(
    scene: &Scene,
    importance: &CameraImportance,
    extents: &Extents,
) -> Result<EmissionTarget> {
    let bounds = extents.everything.grown(extents.margin);
    let visible = importance.sphere();
    let (center, radius) = visible.unwrap_or_else(|| (middle(bounds), 0.0));
    let all = bounds.corners().iter().fold(radius, |r, c| r.max((*c - center).length()));
    if scene.media.is_endless() || !(all > 0.0 && all.is_finite()) {
        return EmissionTarget::new(center, ENDLESS).map_err(Error::Usage);
    }
    let away = scene.surfaces.infinite_feet(center).map(|(_, foot)| (foot - center).length());
    let height = away.min_by(f64::total_cmp).map(|height| height.min(MAX_HEIGHT * all));
    let outer = height.map_or(all, |height| SURROUNDINGS_RADIUS * all.max(height));
    // Where nothing is seen all counts alike.
    let radius = if visible.is_some() { radius.clamp(MIN_VISIBLE_RADIUS * all, all) } else { all };
    let target = EmissionTarget::with_ring(center, radius, outer).map_err(Error::Usage)?;
    let target = target.over_ground(height);
    let mut foci = importance.foci();
    if !scene.media.iter().all(|medium| is_camera_outside(scene, medium)) {
        // Light beside what is seen is one scattering away from it.
        let halo = |focus: &TargetSphere| TargetSphere {
            radius: SURROUNDINGS_RADIUS * focus.radius,
            ..*focus
        };
        foci.extend(foci.clone().iter().map(halo));
    }
    let images: Vec<TargetSphere> = foci.iter().flat_map(|focus| images(scene, focus)).collect();
    foci.extend(images);
    Ok(target.focused_on(foci))
}

/// The images of a focus in infinite mirrors and panes: light that they reflect to it is aimed there.
fn images(scene: &Scene, focus: &TargetSphere) -> impl Iterator<Item = TargetSphere> {
    let feet = scene.surfaces.infinite_feet(focus.center);
    let mirrors = feet.filter(|(surface, _)| {
        surface.materials().iter().any(|material| material.is_specular() || material.is_rough())
    });
    mirrors.map(|(_, foot)| TargetSphere { center: foot + (foot - focus.center), ..*focus })
}
