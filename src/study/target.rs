//! Targets: the means of renders that pictures are measured against, with their own error.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::job::Run;
use super::metric::{Errors, Options, compare};
use crate::error::{Error, Result};
use crate::image::{Image, read_exr};

/// Largest ratio of the target's own error to a measured one for a verdict.
const TRUST: f64 = 1.0 / 3.0;

/// The mean of several renders, against which pictures are measured.
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
    /// Its own error, estimated from one half of the renders: where the error is noise, the half's mean
    /// differs from the mean of all as that differs from the truth.
    pub own: Errors,
    /// The file of the mean.
    pub exr: String,
}

impl Target {
    /// Whether the target's `own` error is small enough beside a measured `error`, both by one metric.
    pub fn is_trusted(own: f64, error: f64) -> bool {
        own <= TRUST * error
    }

    /// Ratio of the renders for which `own` would be small enough beside `error` to those there are, at
    /// least 1.
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

/// The pictures of a target.
#[derive(Debug)]
pub(super) struct TargetImages {
    /// The mean of all renders.
    pub(super) mean: Image,
    /// The mean of the other half of the renders, for each half.
    others: [Image; 2],
}

impl TargetImages {
    /// The mean of two halves of `runs` in `folder`, and its own error.
    pub(super) fn from_runs(
        folder: &Path,
        runs: &[&Run],
        options: &Options,
    ) -> Result<(Self, Errors)> {
        let half = |parity: usize| {
            // One after the other: there can be many, and large ones.
            let mut sum = Sum::default();
            for run in runs.iter().skip(parity).step_by(2) {
                sum.add(&read_exr(&folder.join(&run.exr))?);
            }
            sum.mean().ok_or_else(|| {
                Error::file(folder, "has too few pictures for a target, or of several sizes")
            })
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

/// The mean of pictures of one size, nothing where there are none or of several sizes.
pub(super) fn mean(images: &[&Image]) -> Option<Image> {
    let mut sum = Sum::default();
    images.iter().for_each(|image| sum.add(image));
    sum.mean()
}

/// A sum of pictures.
#[derive(Debug, Default)]
struct Sum {
    /// Width and height of all of them.
    size: Option<[usize; 2]>,
    pixels: Vec<[f64; 3]>,
    count: u32,
    has_several_sizes: bool,
}

impl Sum {
    fn add(&mut self, image: &Image) {
        let size = [image.width(), image.height()];
        if *self.size.get_or_insert(size) != size {
            self.has_several_sizes = true;
            return;
        }
        self.pixels.resize(image.pixels().len(), [0.0; 3]);
        for (sum, pixel) in self.pixels.iter_mut().zip(image.pixels()) {
            *sum = [0, 1, 2].map(|c| sum[c] + f64::from(pixel[c]));
        }
        self.count += 1;
    }

    fn mean(&self) -> Option<Image> {
        let [width, height] = self.size.filter(|_| !self.has_several_sizes)?;
        let n = f64::from(self.count);
        let pixels = self.pixels.iter().map(|sum| sum.map(|v| (v / n) as f32)).collect();
        Some(Image::new(width, height, pixels))
    }
}
