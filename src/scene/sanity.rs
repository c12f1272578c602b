//! What of a scene can hardly be meant.

use super::camera::Camera;
use crate::math::{Ray, Rgb, luminance};
use crate::medium::blackbody::blackbody_radiance;
use crate::medium::{Emission, Media, Medium};

/// Mean free paths across a medium beyond which its unit of length or density is likely another.
const MOST_FREE_PATHS: f64 = 1e4;
/// Radiance, in W/(m² sr), below which a blackbody does not glow.
const DARK: f64 = 1e-6;
/// A camera is in solid density where this optical thickness
const HIDDEN: f64 = 5.0;
/// is reached within this share of the size of the media.
const NEAR: f64 = 0.02;

/// What can hardly be meant, one line each, with what to do.
pub(super) fn notes(media: &Media, camera: &Camera) -> Vec<String> {
    let each = media.iter().enumerate();
    let of_media = each.flat_map(|(i, medium)| [cold(i, medium), thick(i, medium)]);
    of_media.flatten().chain(inside(media, camera)).collect()
}

/// A blackbody that glows nowhere.
fn cold(index: usize, medium: &Medium) -> Option<String> {
    let Some(Emission::Blackbody { grid, ramp, kelvin_scale, kelvin_offset, scale, .. }) =
        &medium.emission
    else {
        return None;
    };
    let range = [0.0, f64::from(grid.max_value())];
    let hottest = ramp.as_ref().map_or(range[1], |ramp| ramp.range(range)[1]);
    let kelvin = kelvin_scale * hottest + kelvin_offset;
    (*scale > 0.0 && scale * luminance(blackbody_radiance(kelvin)) < DARK).then(|| {
        format!(
            "medium[{index}].emission: its hottest place has {kelvin:.4} K and does not glow; give \
             kelvin_scale and kelvin_offset that make kelvin of the grid's values"
        )
    })
}

/// A medium of far more mean free paths than any picture shows.
fn thick(index: usize, medium: &Medium) -> Option<String> {
    let size = medium.density.bounds()?.size().max_element();
    let paths = medium.sigma_t.max_element() * medium.density.maximum() * size;
    (paths > MOST_FREE_PATHS).then(|| {
        format!(
            "medium[{index}].sigma_t: up to {paths:.1e} mean free paths across; it renders as if it were \
             solid: give a smaller sigma_t, or a scale if its unit of length is not the metre"
        )
    })
}

/// A camera that sees nothing but what is right before it.
fn inside(media: &Media, camera: &Camera) -> Option<String> {
    let size = media.bounds().size().max_element();
    let eye = camera.place()?;
    let place = eye + camera.forward() * camera.near(&Ray::new(eye, camera.forward()));
    let sigma_t: Rgb = media.sigma_t_at(place);
    let thickness = sigma_t.max_element() * NEAR * size;
    (thickness.is_finite() && !media.is_endless() && thickness > HIDDEN).then(|| {
        format!(
            "camera.position: stands in solid density, of which it sees {:.1e} m; move it out of the \
             medium",
            1.0 / sigma_t.max_element()
        )
    })
}
