//! The picture as an sRGB display shows it.

use crate::image::{Image, View, ViewTransform, srgb_encode};
use crate::math::Rgb;

/// Linear values in units of the display's white, each 0 to 1: radiance exposed by `exposure`
/// stops, what lies outside clipped.
pub(super) fn display_linear(image: &Image, exposure: f64) -> impl Iterator<Item = Rgb> + '_ {
    let gain = exposure.exp2();
    let exposed = image.pixels().iter().map(move |p| Rgb::from_array(p.map(f64::from)) * gain);
    exposed.map(|c| c.clamp(Rgb::ZERO, Rgb::ONE))
}

/// sRGB code values, 0 to 1, not rounded.
pub(super) fn encoded(image: &Image, exposure: f64) -> Vec<[f64; 3]> {
    display_linear(image, exposure).map(|c| c.to_array().map(srgb_encode)).collect()
}

/// sRGB code values rounded to 8 bit.
pub(super) fn bytes(image: &Image, exposure: f64) -> Vec<[u8; 3]> {
    let view = View { exposure, transform: ViewTransform::Srgb };
    image.pixels().iter().map(|p| view.develop(Rgb::from_array(p.map(f64::from)))).collect()
}
