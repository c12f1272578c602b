//! FLIP, the difference seen when flipping between two pictures, by the crate `flip-rs`.
//!
//! LDR: Andersson et al. 2020, "FLIP: A Difference Evaluator for Alternating Images". HDR:
//! Andersson et al. 2021, "Visualizing Errors in Rendered High Dynamic Range Images".

use flip_rs::{DEFAULT_PPD, ErrorMap, FlipError, HdrOptions, RgbImage, hdr_flip, ldr_flip};

use super::{Map, shown};
use crate::error::{Error, Result};
use crate::image::Image;
use crate::math::{Rgb, luminance};

/// Pixels a degree that NVIDIA's tool takes where nothing is said, 67.02: a display 0.7 m wide with
/// 3840 pixels, seen from 0.7 m. Published figures are nearly always for this one.
pub fn default_pixels_per_degree() -> f64 {
    f64::from(DEFAULT_PPD)
}

/// LDR-FLIP of sRGB codes, not rounded, at an exposure in stops: 0 to 1 a pixel.
///
/// # Errors
/// Where the pixels a degree are so few, or pixels so many, that FLIP cannot be taken.
pub fn flip_ldr_map(
    reference: &Image,
    test: &Image,
    exposure: f64,
    pixels_per_degree: f64,
) -> Result<Map> {
    let [r, t] = [reference, test].map(|image| {
        let codes = shown::encoded(image, exposure);
        rgb(image, codes.as_flattened().iter().map(|&v| v as f32).collect())
    });
    ldr_flip(&r?, &t?, pixels_per_degree as f32).map(map).map_err(|e| refused(&e))
}

/// HDR-FLIP of linear radiance: the worst LDR-FLIP over exposures that NVIDIA's defaults choose
/// from the reference, under the ACES curve. 0 to 1 a pixel; `None` where the reference is black,
/// which leaves no exposure to choose.
///
/// # Errors
/// As [`flip_ldr_map`], and where the reference spans more than 128 exposures.
pub fn flip_hdr_map(
    reference: &Image,
    test: &Image,
    pixels_per_degree: f64,
) -> Result<Option<Map>> {
    let bright = |p: &[f32; 3]| luminance(Rgb::from_array(p.map(f64::from))) > 0.0;
    if !reference.pixels().iter().any(bright) {
        return Ok(None);
    }
    let [r, t] = [reference, test].map(|i| rgb(i, i.pixels().as_flattened().to_vec()));
    let mut options = HdrOptions::default();
    options.ppd = pixels_per_degree as f32;
    let result = hdr_flip(&r?, &t?, options).map_err(|e| refused(&e))?;
    Ok(Some(map(result.error_map)))
}

fn rgb(image: &Image, values: Vec<f32>) -> Result<RgbImage<f32>> {
    RgbImage::new(image.width(), image.height(), values).map_err(|e| refused(&e))
}

fn map(errors: ErrorMap) -> Map {
    Map { width: errors.width(), height: errors.height(), values: errors.into_pixels() }
}

fn refused(error: &FlipError) -> Error {
    Error::Usage(format!("FLIP cannot be taken: {error}"))
}
