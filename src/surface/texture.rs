//! Colours that may vary over a surface.

use std::sync::Arc;

use glam::DVec2;

use crate::image::Image;
use crate::math::{Rgb, are_grey, is_grey};

/// A reflectance, the same everywhere or looked up in an image.
#[derive(Debug, Clone)]
pub enum Texture {
    /// The same everywhere.
    Constant(Rgb),
    /// From an image, bilinear between pixel centres and repeated in both directions.
    Image(Arc<Image>),
}

impl Texture {
    /// Whether it has no colour anywhere.
    pub fn is_grey(&self) -> bool {
        match self {
            Self::Constant(color) => is_grey(*color),
            Self::Image(image) => are_grey(image.pixels()),
        }
    }

    /// The value at `uv`; v counts upward and (0, 0) is the lower left corner of an image.
    pub fn at(&self, uv: DVec2) -> Rgb {
        match self {
            Self::Constant(color) => *color,
            Self::Image(image) => image.sample(uv),
        }
    }
}
