//! ColorVideoVDP in JOD, by the crate `colorvideovdp`: Mantiuk, Hanji, Ashraf, Asano and Chapiro
//! 2024, "ColorVideoVDP: A visual difference predictor for image, video and display distortions",
//! base model 0.5.7.

use colorvideovdp::{Color, Cvvdp, DisplayModel, Image as Picture, Options};

use super::shown;
use crate::error::{Error, Result};
use crate::image::Image;

/// The display that the authors' program takes where none is named: 30 inch, 3840 x 2160, 200
/// cd/m², in an office, seen from 0.75 m.
pub const DEFAULT_DISPLAY: &str = "standard_4k";

/// Pixels that a side must have at least.
const MIN_SIDE: usize = 4;

/// Quality in just-objectionable differences: 10 is no visible difference, 9 means that 75 % of
/// viewers prefer the reference. Taken on sRGB codes, not rounded, at an exposure in stops, on one
/// of the authors' display models. `None` where a side has fewer than 4 pixels.
///
/// # Errors
/// Where there is no display model of that name.
pub fn jod(reference: &Image, test: &Image, exposure: f64, display: &str) -> Result<Option<f64>> {
    let model = DisplayModel::from_name(display).map_err(|_| unknown(display))?;
    if reference.width().min(reference.height()) < MIN_SIDE {
        return Ok(None);
    }
    let [r, t] = [reference, test].map(|image| {
        let codes = shown::encoded(image, exposure);
        let values = codes.as_flattened().iter().map(|&v| v as f32).collect();
        Picture::new(image.width(), image.height(), 3, values)
    });
    // The picture's size has been checked when it was read; the crate's own bound is lower.
    let options = Options::default().with_memory_limit_bytes(usize::MAX);
    let predict = || Cvvdp::new(model, options)?.predict_image(&t?, &r?, Color::Srgb);
    match predict() {
        Ok(prediction) => Ok(Some(f64::from(prediction.jod))),
        Err(e) => Err(Error::Usage(format!("ColorVideoVDP cannot be taken: {e}"))),
    }
}

fn unknown(display: &str) -> Error {
    let names = DisplayModel::names().unwrap_or_default().join(", ");
    Error::Usage(format!("ColorVideoVDP knows no display \"{display}\"; use one of {names}"))
}
