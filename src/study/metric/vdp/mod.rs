//! The visible differences predictor: Daly 1993, "The Visible Differences Predictor: An Algorithm
//! for the Assessment of Image Fidelity", in Watson (ed.), *Digital Images and Human Vision*.
//!
//! It gives, for every pixel, the probability that a viewer sees a difference of luminance there;
//! colour does not enter:
//!
//! 1. luminance on the display, and the retina's response to it (`retina`);
//! 2. the contrast sensitivity function, as a filter (`csf`);
//! 3. the cortex transform into 31 bands of frequency and orientation (`cortex`);
//! 4. in each band the difference of the two pictures against a threshold that their common
//!    texture raises, and from it a probability; all bands together (`detect`).
//!
//! # Two maps
//! [`vdp_map`] is the model as published. It spreads the difference of a pixel over its neighbours.
//! [`vdp_localized_map`] is the same map with 0 where the pictures are the same (`localized`).
//!
//! # Never alone
//! A VDP barely sees a global shift of brightness: the eye adapts, and the sensitivity to a
//! frequency of zero is zero. Bias of a photon map looks like just that. Read these figures beside
//! [`mean_ratio`](super::mean_ratio).
//!
//! # Where the chapter leaves a choice
//! - Response is brought back to contrast by its slope at the adaptation level (`retina`), not by
//!   the mean of the base band. The threshold of a grating on a grey field is then the reciprocal of
//!   the contrast sensitivity for it, at any luminance, and one figure serves both pictures.
//! - The adaptation level, for that and for the sensitivity, is the reference's mean luminance.
//! - A contrast at threshold is seen with probability 1/2. That holds in the middle of a band: a
//!   grating between two is halved by either, and its threshold is 1.6 times as high for it; between
//!   four it is 2.7 times as high.
//! - Phase uncertainty, which the chapter leaves out, is left out.

mod cortex;
mod csf;
mod detect;
mod localized;
mod retina;
mod spectrum;

use rayon::prelude::*;
use rustfft::num_complex::Complex64;

use self::cortex::Band;
use self::csf::Viewing;
use self::detect::{Detector, probability};
pub use self::localized::vdp_localized_map;
use self::retina::{contrast_slope, response};
use self::spectrum::Spectrum;
use super::{Display, Map, shown};
use crate::image::Image;

/// The probability above which a difference counts as seen, the bound of Anson et al. 2006.
pub const VISIBLE: f32 = 0.75;

/// The probability, 0 to 1, that the difference is seen, for every pixel: radiance is exposed by
/// `exposure` stops and shown on `display`, clipped at its white. The pictures are continued by
/// their mirror image, so that no border rings.
pub fn vdp_map(reference: &Image, test: &Image, exposure: f64, display: &Display) -> Map {
    let (width, height) = (reference.width(), reference.height());
    let [seen, tested] =
        [reference, test].map(|image| luminances(image, exposure, display).collect::<Vec<_>>());
    let adaptation = seen.iter().sum::<f64>() / seen.len() as f64;
    let to_contrast = 1.0 / contrast_slope(adaptation);

    // The reference and what the test adds to it, as one complex picture: every filter is real and
    // even, so the two parts never mix. The second is all 0 where the pictures are the same.
    let pairs = seen.iter().zip(&tested).map(|(&seen, &tested)| {
        let [seen, tested] = [seen, tested].map(|l| to_contrast * response(l));
        Complex64::new(seen, tested - seen)
    });
    let mut spectrum = Spectrum::from_image(pairs.collect(), width, height);

    let viewing = Viewing::new(display, adaptation, width, height);
    spectrum.multiply(|fx, fy| viewing.sensitivity(fx, fy));

    let mut evidence = vec![0.0; width * height];
    for band in Band::all() {
        let responses = spectrum.filtered(|fx, fy| band.gain(fx, fy));
        let detector = Detector::new(band.masking_slope());
        evidence.par_iter_mut().zip(responses).for_each(|(sum, response)| {
            *sum += detector.evidence(response.re, response.re + response.im);
        });
    }
    let values = evidence.into_par_iter().map(|e| probability(e) as f32).collect();
    Map { width, height, values }
}

/// Luminance in cd/m² of every pixel on `display`.
fn luminances(image: &Image, exposure: f64, display: &Display) -> impl Iterator<Item = f64> {
    shown::display_linear(image, exposure).map(|c| display.luminance(c))
}

#[cfg(test)]
mod tests;
