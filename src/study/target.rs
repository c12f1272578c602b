//! What pictures are measured against, and how far it can be trusted.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::metric::{Errors, Options, compare};
use super::trial::Trial;
use crate::error::{Error, Result};
use crate::image::{Image, read_exr};

/// The most of a measured error that the target's own error may be.
const TRUST: f64 = 1.0 / 3.0;

/// What pictures are measured against: the mean of several renders.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Target {
    /// `gold` or `reference`.
    pub name: String,
    /// How many renders it is the mean of.
    pub renders: usize,
    /// Rays a pixel in all of them.
    pub rays: u64,
    /// Mean seconds of one of them.
    pub seconds: f64,
    /// Its own error, as half of the renders show it: their mean differs from the mean of all just
    /// as that differs from the truth, if noise is all that is wrong.
    pub own: Errors,
    /// The file of the mean.
    pub exr: String,
}

impl Target {
    /// Whether an `error` stands far enough above the target's `own`, both by one metric.
    pub fn is_trusted(own: f64, error: f64) -> bool {
        own <= TRUST * error
    }

    /// By which factor more renders the `own` error would be trusted beside `error`, at least 1.
    pub(super) fn renders_wanted(own: f64, error: f64) -> f64 {
        (own / (TRUST * error)).max(1.0)
    }

    /// The squared error of the half that the render of `round` is measured against, where that of
    /// the whole is `own`: both halves count alike in the whole, whatever number they are of.
    pub(super) fn own_of_other_half(&self, own: f64, round: u32) -> f64 {
        let even = self.renders.div_ceil(2) as f64;
        let odd = (self.renders / 2) as f64;
        let other = if round.is_multiple_of(2) { odd } else { even };
        4.0 * own / (1.0 / even + 1.0 / odd) / other
    }
}

/// A target with its pictures.
#[derive(Debug)]
pub(super) struct Pictures {
    /// The mean of all renders.
    pub(super) mean: Image,
    /// The mean of the other half of the renders, for each half.
    others: [Image; 2],
}

impl Pictures {
    /// The mean of two halves of `trials` in `folder`, and its own error.
    pub(super) fn of(
        folder: &Path,
        trials: &[&Trial],
        options: &Options,
    ) -> Result<(Self, Errors)> {
        let images: Vec<Image> =
            trials.iter().map(|t| read_exr(&folder.join(&t.exr))).collect::<Result<_>>()?;
        let half = |parity: usize| {
            let images: Vec<&Image> = images.iter().skip(parity).step_by(2).collect();
            mean(&images).ok_or_else(|| Error::file(folder, "has too few pictures for a target"))
        };
        let halves = [half(0)?, half(1)?];
        let whole = mean(&[&halves[0], &halves[1]])
            .ok_or_else(|| Error::file(folder, "has pictures of more than one size"))?;
        let own = compare(&whole, &halves[0], options)?.errors;
        let [even, odd] = halves;
        Ok((Self { mean: whole, others: [odd, even] }, own))
    }

    /// What the render of `round`, itself part of the target, is measured against.
    pub(super) fn without(&self, round: u32) -> &Image {
        &self.others[round as usize % 2]
    }
}

/// The mean of pictures of one size.
pub(super) fn mean(images: &[&Image]) -> Option<Image> {
    let first = images.first()?;
    let size = (first.width(), first.height());
    if images.iter().any(|image| (image.width(), image.height()) != size) {
        return None;
    }
    let n = images.len() as f64;
    let at = |i: usize| {
        [0, 1, 2].map(|c| {
            let sum: f64 = images.iter().map(|image| f64::from(image.pixels()[i][c])).sum();
            (sum / n) as f32
        })
    };
    Some(Image::new(size.0, size.1, (0..first.pixels().len()).map(at).collect()))
}
