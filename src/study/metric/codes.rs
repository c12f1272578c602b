//! The pixel errors of Anson et al. 2006, "Efficient Selective Rendering of Participating Media".
//!
//! The paper doesn't say what it counts. Here both figures are of the pictures as a display gets
//! them: 8-bit sRGB codes of the exposed radiance, clipped, rounded to nearest, without dither.

use super::shown;
use crate::image::Image;

/// Errors of 8-bit sRGB codes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CodeErrors {
    /// Mean squared difference of codes over pixels and channels, as a share of 255².
    pub mse: f64,
    /// Share of pixels in error: those of which at least one channel differs by at least one code.
    pub share: f64,
}

/// Counts the errors of codes at an exposure in stops.
pub fn code_errors(reference: &Image, test: &Image, exposure: f64) -> CodeErrors {
    let [r, t] = [reference, test].map(|image| shown::bytes(image, exposure));
    let channels = r.as_flattened().iter().zip(t.as_flattened());
    let squares: u64 = channels.map(|(r, t)| u64::from(r.abs_diff(*t)).pow(2)).sum();
    let wrong = r.iter().zip(&t).filter(|(r, t)| r != t).count();
    let pixels = r.len() as f64;
    CodeErrors {
        mse: squares as f64 / (3.0 * pixels * 255.0 * 255.0),
        share: wrong as f64 / pixels,
    }
}
