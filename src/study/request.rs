//! The request of a study.

use serde::{Deserialize, Serialize};

use super::candidate::CANDIDATES;
use super::contrast::MOST_SEEDS;
use super::metric::Errors;
use crate::error::{Error, Result};
use crate::scene::MAX_RAYS;

/// The request of a study: what it compares, and how much it renders.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Request {
    /// Names out of [`CANDIDATES`]; all where there are none.
    pub candidates: Vec<String>,
    /// Ceilings of rays a pixel; where there are none the scene's, its half and so on down to 1.
    pub budgets: Vec<u32>,
    /// Seeds of every candidate at every budget; the most of them where `seconds` is given.
    pub seeds: u32,
    /// Camera rays a pixel of the unbiased reference, both halves together.
    pub reference: Option<u32>,
    /// Seconds that the study takes, by which budgets, candidates and seeds are chosen.
    pub seconds: Option<f64>,
    /// The error that the answers are about.
    pub metric: Metric,
    /// Errors for which the time to reach them is reported.
    pub errors: Vec<f64>,
}

impl Default for Request {
    /// All candidates and budgets with five seeds, against the gold standard.
    fn default() -> Self {
        Self {
            candidates: Vec::new(),
            budgets: Vec::new(),
            seeds: 5,
            reference: None,
            seconds: None,
            metric: Metric::default(),
            errors: Vec::new(),
        }
    }
}

impl Request {
    /// Checks every field.
    ///
    /// # Errors
    /// Where one is out of range.
    pub fn check(&self) -> Result<()> {
        let known = |name: &&String| CANDIDATES.iter().any(|(known, _)| known == name);
        if let Some(name) = self.candidates.iter().find(|name| !known(name)) {
            let names = CANDIDATES.map(|(name, _)| name).join(", ");
            return Err(Error::Usage(format!(
                "candidate \"{name}\" is unknown; there are {names}"
            )));
        }
        let rays = 1..=MAX_RAYS;
        if let Some(budget) = self.budgets.iter().find(|budget| !rays.contains(*budget)) {
            return Err(Error::Usage(format!("budget {budget}: give rays from 1 to {MAX_RAYS}")));
        }
        if self.seeds == 0 || self.seeds > MOST_SEEDS {
            let seeds = self.seeds;
            return Err(Error::Usage(format!("{seeds} seeds: give from 1 to {MOST_SEEDS}")));
        }
        if let Some(n) = self.reference.filter(|n| !(2..=MAX_RAYS).contains(n)) {
            return Err(Error::Usage(format!(
                "a reference of {n} rays: give from 2 to {MAX_RAYS}, for its two halves"
            )));
        }
        let sound = |v: &f64| v.is_finite() && *v > 0.0;
        if !self.seconds.iter().chain(&self.errors).all(sound) {
            return Err(Error::Usage("time and errors of a study must be above 0".into()));
        }
        Ok(())
    }
}

/// An error of a picture, 0 for none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Metric {
    /// [`Errors::mse`].
    Mse,
    /// [`Errors::relative_mse`].
    #[default]
    RelativeMse,
    /// [`Errors::relative_mse_trimmed`].
    RelativeMseTrimmed,
    /// [`Errors::code_mse_percent`].
    CodeMse,
    /// [`Errors::code_pixels_percent`].
    CodePixels,
    /// [`Errors::vdp_mean_percent`].
    VdpMean,
    /// [`Errors::vdp_visible_percent`].
    VdpVisible,
    /// [`Errors::vdp_localized_mean_percent`].
    VdpLocalizedMean,
    /// [`Errors::vdp_localized_visible_percent`].
    VdpLocalizedVisible,
    /// 1 - [`Errors::ssim`].
    Dssim,
    /// [`Errors::flip_ldr`].
    Flip,
    /// [`Errors::flip_hdr`].
    HdrFlip,
    /// 10 - [`Errors::colorvideovdp_jod`].
    JodLost,
}

impl Metric {
    /// Each by its name, with its title.
    pub const ALL: &[(&str, Self, &str)] = &[
        ("mse", Self::Mse, "MSE"),
        ("relative-mse", Self::RelativeMse, "relative MSE"),
        ("relative-mse-trimmed", Self::RelativeMseTrimmed, "relative MSE, trimmed"),
        ("code-mse", Self::CodeMse, "MSE of 8-bit codes, %"),
        ("code-pixels", Self::CodePixels, "pixels in error, %"),
        ("vdp-mean", Self::VdpMean, "VDP average, %"),
        ("vdp-visible", Self::VdpVisible, "VDP P > 0.75, %"),
        ("vdp-localized-mean", Self::VdpLocalizedMean, "localised VDP average, %"),
        ("vdp-localized-visible", Self::VdpLocalizedVisible, "localised VDP P > 0.75, %"),
        ("dssim", Self::Dssim, "1 - SSIM"),
        ("flip", Self::Flip, "LDR-FLIP"),
        ("hdr-flip", Self::HdrFlip, "HDR-FLIP"),
        ("jod-lost", Self::JodLost, "JOD lost"),
    ];

    /// Whether it is a mean of squares of radiance, so that independent errors add up.
    pub fn is_squared(self) -> bool {
        matches!(self, Self::Mse | Self::RelativeMse)
    }

    /// Its name on the command line and in files.
    pub fn name(self) -> &'static str {
        self.row().0
    }

    /// Its name for people, with the unit where there is one.
    pub fn title(self) -> &'static str {
        self.row().2
    }

    /// The metric's value in `errors`, at least 0; `None` where it was not measured.
    pub fn value(self, errors: &Errors) -> Option<f64> {
        match self {
            Self::Mse => Some(errors.mse),
            Self::RelativeMse => errors.relative_mse,
            Self::RelativeMseTrimmed => errors.relative_mse_trimmed,
            Self::CodeMse => Some(errors.code_mse_percent),
            Self::CodePixels => Some(errors.code_pixels_percent),
            Self::VdpMean => Some(errors.vdp_mean_percent),
            Self::VdpVisible => Some(errors.vdp_visible_percent),
            Self::VdpLocalizedMean => Some(errors.vdp_localized_mean_percent),
            Self::VdpLocalizedVisible => Some(errors.vdp_localized_visible_percent),
            Self::Dssim => errors.ssim.map(|ssim| (1.0 - ssim).max(0.0)),
            Self::Flip => Some(errors.flip_ldr),
            Self::HdrFlip => errors.flip_hdr,
            Self::JodLost => errors.colorvideovdp_jod.map(|jod| (10.0 - jod).max(0.0)),
        }
    }

    fn row(self) -> &'static (&'static str, Self, &'static str) {
        Self::ALL.iter().find(|row| row.1 == self).unwrap_or(&Self::ALL[0])
    }
}
