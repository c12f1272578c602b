//! A decoded texture.

use super::{Image, srgb};

/// A picture file, decoded.
#[derive(Debug, Clone, PartialEq)]
pub struct DecodedTexture {
    /// Linear Rec.709 values, without alpha.
    pub image: Image,
    /// How the file held them.
    pub encoding: Encoding,
}

/// How a picture file holds light.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    /// Linear, without an upper end: EXR, HDR and TIFF of floats.
    Linear,
    /// As sRGB codes that end at white: PNG, JPEG and TIFF of integers.
    Srgb {
        /// Bits a sample.
        bits: u8,
    },
}

/// The linear value of every sRGB code from 0 to `white`.
pub(super) fn srgb_codes(white: u16) -> Vec<f32> {
    (0..=white).map(|code| srgb::decode(f64::from(code) / f64::from(white)) as f32).collect()
}
