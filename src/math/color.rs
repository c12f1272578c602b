//! Linear colour.

/// A triple of linear Rec.709 values: radiance, power, albedo, optical thickness or transmittance
/// per channel, as the name of the variable says.
pub type Rgb = glam::DVec3;

/// Whether all channels are the same.
pub fn is_grey(c: Rgb) -> bool {
    c.x == c.y && c.y == c.z
}

/// Whether no texel of a picture has a colour.
pub fn are_grey(texels: &[[f32; 3]]) -> bool {
    texels.iter().all(|[r, g, b]| r == g && g == b)
}

/// Luminance Y of a linear Rec.709 colour (ITU-R BT.709-6, section 3.2), in the unit of the colour.
pub fn luminance(c: Rgb) -> f64 {
    c.dot(Rgb::new(0.2126, 0.7152, 0.0722))
}
