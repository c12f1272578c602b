//! Toward what photons are emitted.

use crate::error::{Error, Result};
use crate::light::{EmissionTarget, TargetSphere};
use crate::scene::Scene;
use crate::surface::Material;

use super::camera_importance::CameraImportance;
use super::extents::{ENDLESS, Extents, middle};
use crate::strategy::is_before;

/// Radii of the scene, or heights over an infinite plane, within which ground counts as near.
const GROUND: f64 = 4.0;

/// Radii of the scene from which an infinite plane is at most thought to be away.
const HIGHEST: f64 = 1e4;

/// Radius of the halo round what is seen of a medium that the eye is inside of, in radii.
const HALO: f64 = 4.0;

/// What photons should reach: above all what the camera sees of the media, and round it all media
/// and finite surfaces, with the ground about them where a plane is infinite; everything where a
/// medium is endless.
pub(super) fn reach(
    scene: &Scene,
    visible: &CameraImportance,
    extents: &Extents,
) -> Result<EmissionTarget> {
    let bounds = extents.everything.grown(extents.margin);
    let seen = visible.sphere();
    let (center, radius) = seen.unwrap_or_else(|| (middle(bounds), 0.0));
    let all = bounds.corners().iter().fold(radius, |r, c| r.max((*c - center).length()));
    if scene.media.is_endless() || !(all > 0.0 && all.is_finite()) {
        return EmissionTarget::new(center, ENDLESS).map_err(Error::Usage);
    }
    let away = scene.surfaces.infinite_feet(center).map(|(_, foot)| (foot - center).length());
    let height = away.min_by(f64::total_cmp).map(|height| height.min(HIGHEST * all));
    let outer = height.map_or(all, |height| GROUND * all.max(height));
    // Where nothing is seen all counts alike.
    let radius = if seen.is_some() { radius.clamp(1e-3 * all, all) } else { all };
    let reach = EmissionTarget::with_ring(center, radius, outer).map_err(Error::Usage)?;
    let reach = reach.over_ground(height);
    let mut foci = visible.foci();
    if !scene.media.iter().all(|medium| is_before(scene, medium)) {
        // Light beside what is seen is a scattering away from it.
        let halo = |focus: &TargetSphere| TargetSphere { radius: HALO * focus.radius, ..*focus };
        foci.extend(foci.clone().iter().map(halo));
    }
    let images: Vec<TargetSphere> = foci.iter().flat_map(|focus| images(scene, focus)).collect();
    foci.extend(images);
    Ok(reach.focused_on(foci))
}

/// The images of a focus in infinite mirrors and panes, behind which light for it has to aim.
fn images(scene: &Scene, focus: &TargetSphere) -> impl Iterator<Item = TargetSphere> {
    let feet = scene.surfaces.infinite_feet(focus.center);
    let mirrors = feet.filter(|(surface, _)| surface.materials().iter().any(Material::is_specular));
    mirrors.map(|(_, foot)| TargetSphere { center: foot + (foot - focus.center), ..*focus })
}
