//! How far a picture is from its reference, by every measure that the report uses.
//!
//! [`compare`] takes them all; each is also a function of its own. A file holds one metric.
//!
//! | figures | of what |
//! | --- | --- |
//! | MSE, RMSE, MAE, relative MSE, bias | linear radiance, as stored |
//! | error of codes ([`code_errors`]) | 8-bit sRGB codes |
//! | [`ssim()`], LDR-FLIP, ColorVideoVDP | sRGB codes, not rounded |
//! | HDR-FLIP | linear radiance |
//! | VDP ([`vdp_map`]), localised VDP ([`vdp_localized_map`]) | luminance on the display |
//!
//! All but the first row and HDR-FLIP depend on the exposure. No row does without the others: a
//! VDP, which tells whether noise is visible, barely sees a global shift of brightness, and
//! ColorVideoVDP little more; the mean ratio shows it.

mod check;
mod codes;
mod colorvideovdp;
mod display;
mod flip;
mod map;
mod radiance;
mod relative;
mod shown;
mod ssim;
mod vdp;

use serde::{Deserialize, Serialize};

pub use check::check_pair;
pub use codes::{CodeErrors, code_errors};
pub use colorvideovdp::{DEFAULT_DISPLAY, jod};
pub use display::Display;
pub use flip::{default_pixels_per_degree, flip_hdr_map, flip_ldr_map};
pub use map::Map;
pub use radiance::{mae, mean_difference, mean_ratio, mse};
pub use relative::{TRIM, default_epsilon, relative_map};
pub use ssim::ssim;
pub use vdp::{VISIBLE, vdp_localized_map, vdp_map};

use crate::error::Result;
use crate::image::Image;

/// How pictures are shown and errors counted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Options {
    /// Exposure of what is shown, in stops.
    pub exposure: f64,
    /// Epsilon of the relative error, a radiance above 0; [`default_epsilon`] where it is `None`.
    pub epsilon: Option<f64>,
    /// The display that the VDP is for.
    pub display: Display,
    /// Pixels a degree that FLIP is for.
    pub flip_pixels_per_degree: f64,
    /// The display model that ColorVideoVDP is for, by its authors' name.
    pub colorvideovdp_display: String,
}

impl Default for Options {
    /// FLIP and ColorVideoVDP as their authors' programs have them, so that figures compare with
    /// published ones; the VDP on the display of Anson et al. 2006.
    fn default() -> Self {
        Self {
            exposure: 0.0,
            epsilon: None,
            display: Display::default(),
            flip_pixels_per_degree: default_pixels_per_degree(),
            colorvideovdp_display: DEFAULT_DISPLAY.into(),
        }
    }
}

/// Every figure of one comparison. What cannot be told for a pair of pictures is `None`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// Mean squared error of radiance.
    pub mse: f64,
    /// Its root, a radiance.
    pub rmse: f64,
    /// Mean absolute error, a radiance.
    pub mae: f64,
    /// Signed bias, a radiance: [`mean_difference`].
    pub mean_difference: f64,
    /// Signed bias as a ratio: [`mean_ratio`]. `None` where the reference is black.
    pub mean_ratio: Option<f64>,
    /// Epsilon of the relative errors, a radiance. `None` where the reference is black and none was
    /// set.
    pub epsilon: Option<f64>,
    /// Mean of [`relative_map`].
    pub relative_mse: Option<f64>,
    /// The same without its worst 0.1 % of pixels, [`TRIM`].
    pub relative_mse_trimmed: Option<f64>,
    /// Average MSE error in % of the full range, after Anson et al. 2006:
    /// [`CodeErrors::mse`].
    pub code_mse_percent: f64,
    /// Pixels in error in %: [`CodeErrors::share`].
    pub code_pixels_percent: f64,
    /// Average of [`vdp_map`] in %, after Anson et al. 2006.
    pub vdp_mean_percent: f64,
    /// Pixels with P > 0.75 in [`vdp_map`], in %.
    pub vdp_visible_percent: f64,
    /// Average of [`vdp_localized_map`] in %, over all pixels.
    pub vdp_localized_mean_percent: f64,
    /// Pixels with P > 0.75 in [`vdp_localized_map`], in % of all pixels.
    pub vdp_localized_visible_percent: f64,
    /// [`ssim()`], 1 for the same picture. `None` below 11 x 11 pixels.
    pub ssim: Option<f64>,
    /// Mean LDR-FLIP, 0 to 1.
    pub flip_ldr: f64,
    /// Mean HDR-FLIP, 0 to 1. `None` where the reference is black.
    pub flip_hdr: Option<f64>,
    /// ColorVideoVDP, 10 for the same picture. `None` below 4 x 4 pixels.
    pub colorvideovdp_jod: Option<f64>,
}

/// Figures, and where in the picture the error lies.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Every figure.
    pub errors: Errors,
    /// [`relative_map`], where there is an epsilon.
    pub relative: Option<Map>,
    /// [`flip_ldr_map`].
    pub flip_ldr: Map,
    /// [`flip_hdr_map`].
    pub flip_hdr: Option<Map>,
    /// [`vdp_map`].
    pub vdp: Map,
    /// [`vdp_localized_map`].
    pub vdp_localized: Map,
}

/// Compares a picture with its reference by every metric.
///
/// # Errors
/// Where the pictures differ in size or hold a value that is not finite, and where an option is
/// out of range; see [`check_pair`] for messages that name files.
pub fn compare(reference: &Image, test: &Image, options: &Options) -> Result<Comparison> {
    check_pair((reference, "reference".as_ref()), (test, "test".as_ref()))?;
    check::check_options(options)?;
    let Options { exposure, flip_pixels_per_degree: density, display, .. } = *options;

    let mse = mse(reference, test);
    let epsilon = options.epsilon.or_else(|| default_epsilon(reference));
    let relative = epsilon.map(|epsilon| relative_map(reference, test, epsilon));
    let codes = code_errors(reference, test, exposure);
    let flip_ldr = flip_ldr_map(reference, test, exposure, density)?;
    let flip_hdr = flip_hdr_map(reference, test, density)?;
    let vdp = vdp_map(reference, test, exposure, &display);
    let vdp_localized = vdp_localized_map(&vdp, reference, test, exposure, &display);
    let errors = Errors {
        mse,
        rmse: mse.sqrt(),
        mae: mae(reference, test),
        mean_difference: mean_difference(reference, test),
        mean_ratio: mean_ratio(reference, test),
        epsilon,
        relative_mse: relative.as_ref().map(Map::mean),
        relative_mse_trimmed: relative.as_ref().map(|map| map.trimmed_mean(TRIM)),
        code_mse_percent: 100.0 * codes.mse,
        code_pixels_percent: 100.0 * codes.share,
        vdp_mean_percent: 100.0 * vdp.mean(),
        vdp_visible_percent: 100.0 * vdp.share_above(VISIBLE),
        vdp_localized_mean_percent: 100.0 * vdp_localized.mean(),
        vdp_localized_visible_percent: 100.0 * vdp_localized.share_above(VISIBLE),
        ssim: ssim(reference, test, exposure),
        flip_ldr: flip_ldr.mean(),
        flip_hdr: flip_hdr.as_ref().map(Map::mean),
        colorvideovdp_jod: jod(reference, test, exposure, &options.colorvideovdp_display)?,
    };
    Ok(Comparison { errors, relative, flip_ldr, flip_hdr, vdp, vdp_localized })
}
