//! Mean and variance of the samples of one pixel.

use crate::math::{Rgb, luminance};

/// What one camera ray brought.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Radiance, W/(m² sr).
    pub radiance: Rgb,
    /// Coverage, 0 to 1.
    pub alpha: f64,
    /// Transmittance to the first surface, or to infinity where there is none.
    pub transmittance: f64,
    /// Distance to the first surface in metres, positive infinity where there is none.
    pub depth: f64,
}

impl Sample {
    /// Whether it can be stored: no NaN, and nothing that an f32 cannot hold but an infinite depth.
    fn is_sound(&self) -> bool {
        let sound = |v: f64| v.abs() <= f64::from(f32::MAX); // false for NaN
        self.radiance.to_array().into_iter().all(sound)
            && sound(self.alpha)
            && sound(self.transmittance)
            && !self.depth.is_nan()
    }
}

/// Gathers the samples of one pixel, in f64 by Welford's update (Welford 1962, "Note on a Method
/// for Calculating Corrected Sums of Squares and Products"): the variance does not suffer where
/// the mean is large.
#[derive(Clone, Debug, Default)]
pub struct Accumulator {
    count: u64,
    dropped: u64,
    mean: Rgb,
    squares: Rgb,
    luminance_squares: f64,
    alpha: f64,
    transmittance: f64,
    depth: Option<f64>,
}

impl Accumulator {
    /// Takes a sample in. One with a NaN, an infinity or a value beyond the range of f32 (an
    /// infinite depth aside) is counted by [`dropped`](Self::dropped) and otherwise ignored.
    pub fn add(&mut self, sample: Sample) {
        if !sample.is_sound() {
            self.dropped += 1;
            return;
        }
        self.count += 1;
        let weight = 1.0 / self.count as f64;
        let before = sample.radiance - self.mean;
        self.mean += before * weight;
        let after = sample.radiance - self.mean;
        self.squares += before * after;
        self.luminance_squares += luminance(before) * luminance(after);
        self.alpha += (sample.alpha - self.alpha) * weight;
        self.transmittance += (sample.transmittance - self.transmittance) * weight;
        self.depth = Some(self.depth.map_or(sample.depth, |depth| depth.min(sample.depth)));
    }

    /// How many samples were taken in.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// How many samples were not finite and left out.
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Mean radiance, W/(m² sr); 0 without a sample.
    pub fn mean(&self) -> Rgb {
        self.mean
    }

    /// Mean coverage; 0 without a sample.
    pub fn alpha(&self) -> f64 {
        self.alpha
    }

    /// Mean transmittance; 0 without a sample.
    pub fn transmittance(&self) -> f64 {
        self.transmittance
    }

    /// Distance to the nearest surface that a sample met, in metres; positive infinity where none
    /// did. Distances are not averaged: between two surfaces there is nothing.
    pub fn depth(&self) -> f64 {
        self.depth.unwrap_or(f64::INFINITY)
    }

    /// Variance of the mean per channel, in radiance squared; 0 below two samples, which tell
    /// nothing about it.
    pub fn variance(&self) -> Rgb {
        self.squares * self.per_mean()
    }

    /// Variance of the mean's luminance, as [`variance`](Self::variance).
    pub fn luminance_variance(&self) -> f64 {
        self.luminance_squares * self.per_mean()
    }

    /// From a sum of squared deviations to the variance of the mean: 1 / (n (n - 1)).
    fn per_mean(&self) -> f64 {
        let n = self.count as f64;
        if self.count < 2 { 0.0 } else { 1.0 / (n * (n - 1.0)) }
    }
}
