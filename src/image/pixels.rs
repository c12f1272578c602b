//! The pixel buffer.

use std::path::Path;

use glam::DVec2;

use crate::error::{Error, Result};
use crate::math::{Rgb, luminance};

/// The most pixels that a picture may have: 2^27, as many as a 16384 x 8192 environment map. A file
/// that claims more is refused before memory is taken for it.
pub const MAX_PIXELS: usize = 1 << 27;

/// A picture of linear Rec.709 values, row 0 on top.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    width: usize,
    height: usize,
    pixels: Vec<[f32; 3]>,
}

impl Image {
    /// A picture of `pixels` row by row from the top.
    ///
    /// # Panics
    /// Where there are no pixels or not `width * height` of them.
    pub fn new(width: usize, height: usize, pixels: Vec<[f32; 3]>) -> Self {
        assert!(!pixels.is_empty(), "an image has at least one pixel");
        assert_eq!(width.checked_mul(height), Some(pixels.len()), "{width} x {height} pixels");
        Self { width, height, pixels }
    }

    /// Pixels in a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// All pixels, row by row from the top.
    pub fn pixels(&self) -> &[[f32; 3]] {
        &self.pixels
    }

    /// The luminance of each pixel, row by row from the top.
    pub fn luminances(&self) -> impl Iterator<Item = f64> + '_ {
        self.pixels.iter().map(|pixel| luminance(Rgb::from(pixel.map(f64::from))))
    }

    /// Red, green and blue by themselves, row by row from the top.
    pub fn channels(&self) -> [Vec<f32>; 3] {
        [0, 1, 2].map(|channel| self.pixels.iter().map(|pixel| pixel[channel]).collect())
    }

    /// The pixel in column `x` from the left and row `y` from the top.
    ///
    /// # Panics
    /// Where the pixel lies outside the picture.
    pub fn get(&self, x: usize, y: usize) -> Rgb {
        assert!(x < self.width, "column {x} of {}", self.width);
        Rgb::from_array(self.pixels[y * self.width + x].map(f64::from))
    }

    /// Checks that no value is NaN or infinite; `path` names the picture in the message.
    ///
    /// # Errors
    /// Where one is.
    pub fn check_finite(&self, path: &Path) -> Result<()> {
        let Some(index) = self.pixels.iter().position(|p| p.iter().any(|v| !v.is_finite())) else {
            return Ok(());
        };
        let (x, y) = (index % self.width, index / self.width);
        let value = self.pixels[index];
        Err(Error::file(path, format!("pixel {x}, {y} is {value:?}; every value must be finite")))
    }

    /// The pixel whose area holds `uv`. u grows to the right and v up, (0, 0) is the lower left
    /// corner, as in OBJ; the picture repeats in both.
    pub fn sample_nearest(&self, uv: DVec2) -> Rgb {
        let at = self.wrapped(uv);
        self.repeated(at.x.floor(), at.y.floor())
    }

    /// The bilinear mix of the four pixels whose centres surround `uv`, placed and repeated as in
    /// [`sample_nearest`](Self::sample_nearest).
    pub fn sample(&self, uv: DVec2) -> Rgb {
        let at = self.wrapped(uv) - 0.5;
        let corner = at.floor();
        let mix = at - corner;
        let row = |y: f64| self.repeated(corner.x, y).lerp(self.repeated(corner.x + 1.0, y), mix.x);
        row(corner.y).lerp(row(corner.y + 1.0), mix.y)
    }

    /// Pixel coordinates, y down, of `uv` inside the picture; those that are not finite count as 0.
    fn wrapped(&self, uv: DVec2) -> DVec2 {
        let uv = uv.map(|c| if c.is_finite() { c.rem_euclid(1.0) } else { 0.0 });
        DVec2::new(uv.x * self.width as f64, (1.0 - uv.y) * self.height as f64)
    }

    fn repeated(&self, x: f64, y: f64) -> Rgb {
        let index = |c: f64, size: usize| (c as isize).rem_euclid(size as isize) as usize;
        self.get(index(x, self.width), index(y, self.height))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Top row 1 2, bottom row 3 4.
    fn four() -> Image {
        Image::new(2, 2, [1.0_f32, 2.0, 3.0, 4.0].map(|v| [v; 3]).to_vec())
    }

    fn uv(u: f64, v: f64) -> DVec2 {
        DVec2::new(u, v)
    }

    #[test]
    fn lower_left_is_the_origin() {
        assert_eq!(four().sample_nearest(uv(0.1, 0.1)).x, 3.0);
        assert_eq!(four().sample_nearest(uv(0.9, 0.1)).x, 4.0);
        assert_eq!(four().sample_nearest(uv(0.1, 0.9)).x, 1.0);
        assert_eq!(four().sample(uv(0.25, 0.25)).x, 3.0);
        assert_eq!(four().sample(uv(0.75, 0.75)).x, 2.0);
    }

    #[test]
    fn bilinear_mixes_and_repeats() {
        assert_eq!(four().sample(uv(0.5, 0.5)).x, 2.5);
        assert_eq!(four().sample(uv(0.0, 0.25)).x, 3.5); // half of the left, half of the right end
        assert_eq!(four().sample(uv(-2.75, 5.25)).x, 3.0);
    }

    #[test]
    fn no_coordinate_breaks_it() {
        for c in [0.0, 1.0, -1e-300, 1e300, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(four().sample(uv(c, c)).is_finite(), "{c}");
            assert!(four().sample_nearest(uv(c, -c)).is_finite(), "{c}");
        }
    }
}
