//! 8-bit pictures to look at, with text on them.

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

use super::{Image, View};
use crate::math::Rgb;

/// Pixels from one line of text to the next.
pub const LINE: usize = RasterHeight::Size16.val();

/// An 8-bit sRGB picture, row 0 on top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    width: usize,
    height: usize,
    bytes: Vec<u8>,
}

impl Picture {
    /// A picture of one colour.
    ///
    /// # Panics
    /// Where it has no pixels.
    pub fn filled(width: usize, height: usize, color: [u8; 3]) -> Self {
        assert!(width > 0 && height > 0, "{width} x {height} pixels");
        Self { width, height, bytes: color.repeat(width * height) }
    }

    /// `image` as `view` shows it.
    pub fn developed(image: &Image, view: &View) -> Self {
        let develop = |p: &[f32; 3]| view.develop(Rgb::from_array(p.map(f64::from)));
        let bytes = image.pixels().iter().flat_map(develop).collect();
        Self { width: image.width(), height: image.height(), bytes }
    }

    /// Pixels in a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Red, green and blue of all pixels, row by row from the top.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// The pixel in column `x` and row `y`, or nothing outside the picture.
    pub fn get(&self, x: usize, y: usize) -> Option<[u8; 3]> {
        let at = self.offset(x, y)?;
        Some([self.bytes[at], self.bytes[at + 1], self.bytes[at + 2]])
    }

    /// Sets a pixel; outside the picture nothing happens.
    pub fn set(&mut self, x: usize, y: usize, color: [u8; 3]) {
        if let Some(at) = self.offset(x, y) {
            self.bytes[at..at + 3].copy_from_slice(&color);
        }
    }

    /// Lays `other` over this one, its upper left pixel at column `x` and row `y`; what reaches
    /// beyond the border is left out.
    pub fn paste(&mut self, other: &Self, x: usize, y: usize) {
        let visible = 3 * other.width.min(self.width.saturating_sub(x));
        let rows = other.bytes.chunks_exact(3 * other.width).zip(y..self.height);
        for (row, target) in rows.filter(|_| visible > 0) {
            let at = 3 * (target * self.width + x);
            self.bytes[at..at + visible].copy_from_slice(&row[..visible]);
        }
    }

    /// Writes one line of `text`, its upper left corner at column `x` and row `y`, in Noto Sans Mono
    /// over what is there. A character beyond ASCII becomes a question mark.
    pub fn write_text(&mut self, x: usize, y: usize, text: &str, color: [u8; 3]) {
        for (i, c) in text.chars().enumerate() {
            let left = x + i * character_width();
            for (row, line) in glyph(c).enumerate() {
                for (column, &coverage) in line.iter().enumerate() {
                    self.blend(left + column, y + row, color, coverage);
                }
            }
        }
    }

    fn blend(&mut self, x: usize, y: usize, color: [u8; 3], coverage: u8) {
        if let Some(under) = self.get(x, y) {
            let f = f32::from(coverage) / 255.0;
            let mix = |c: usize| f32::from(under[c]) * (1.0 - f) + f32::from(color[c]) * f;
            self.set(x, y, [mix(0), mix(1), mix(2)].map(|v| v.round() as u8));
        }
    }

    fn offset(&self, x: usize, y: usize) -> Option<usize> {
        (x < self.width && y < self.height).then_some(3 * (y * self.width + x))
    }
}

/// Pixels that `text` takes in a row.
pub fn text_width(text: &str) -> usize {
    text.chars().count() * character_width()
}

fn character_width() -> usize {
    get_raster_width(FontWeight::Regular, RasterHeight::Size16)
}

/// Rows of coverage.
fn glyph(c: char) -> impl Iterator<Item = &'static [u8]> {
    let raster = |c| get_raster(c, FontWeight::Regular, RasterHeight::Size16);
    raster(c).or_else(|| raster('?')).into_iter().flat_map(|glyph| glyph.rows())
}
