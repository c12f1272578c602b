//! Colours that may vary over a surface.

use std::sync::Arc;

use glam::DVec2;

use crate::image::Image;
use crate::math::Rgb;

/// A reflectance, the same everywhere or looked up in an image.
#[derive(Debug, Clone)]
pub enum Texture {
    /// The same everywhere.
    Constant(Rgb),
    /// From an image, repeated in both directions.
    Image(Arc<TextureImage>),
}

/// An image in linear Rec.709, looked up by texture coordinates.
#[derive(Debug, Clone)]
pub struct TextureImage(Image);

impl Texture {
    /// The value at `uv`; v counts upward.
    pub fn at(&self, uv: DVec2) -> Rgb {
        match self {
            Self::Constant(color) => *color,
            Self::Image(image) => image.at(uv),
        }
    }
}

impl TextureImage {
    /// The image of `width` times `height` pixels, rows from the top, or nothing where their
    /// number is 0 or another one.
    pub fn new(width: usize, height: usize, pixels: Vec<[f32; 3]>) -> Option<Self> {
        let fits = width.checked_mul(height) == Some(pixels.len()) && !pixels.is_empty();
        fits.then(|| Self(Image::new(width, height, pixels)))
    }

    /// Bilinear between pixel centres, repeated in both directions; (0, 0) is the lower left corner.
    pub fn at(&self, uv: DVec2) -> Rgb {
        self.0.sample(uv)
    }
}
