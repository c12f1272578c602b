//! Colours that may vary over a surface.

use std::sync::Arc;

use glam::{DVec2, Vec3};

use crate::math::Rgb;

/// A reflectance, the same everywhere or looked up in an image.
#[derive(Debug, Clone)]
pub enum Texture {
    /// The same everywhere.
    Constant(Rgb),
    /// From an image, repeated in both directions.
    Image(Arc<TextureImage>),
}

/// An image in linear Rec.709, rows from the top.
#[derive(Debug, Clone)]
pub struct TextureImage {
    width: usize,
    height: usize,
    pixels: Vec<[f32; 3]>,
}

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
        fits.then_some(Self { width, height, pixels })
    }

    /// Bilinear between pixel centres, repeated in both directions; (0, 0) is the lower left corner.
    pub fn at(&self, uv: DVec2) -> Rgb {
        let size = DVec2::new(self.width as f64, self.height as f64);
        let place = DVec2::new(uv.x, 1.0 - uv.y).fract_gl() * size - 0.5;
        let low = place.floor();
        let f = place - low;
        let pixel = |dx: i64, dy: i64| {
            let x = (low.x as i64 + dx).rem_euclid(self.width as i64) as usize;
            let y = (low.y as i64 + dy).rem_euclid(self.height as i64) as usize;
            Vec3::from(self.pixels[y * self.width + x]).as_dvec3()
        };
        let row = |dy| pixel(0, dy).lerp(pixel(1, dy), f.x);
        row(0).lerp(row(1), f.y)
    }
}
