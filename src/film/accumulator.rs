//! Mean and variance of the samples of one pixel.

use super::sample::Sample;
use crate::image::FilmPixel;
use crate::math::{Rgb, luminance};

/// Words of the state that hold two numbers of 32 bits each.
///
/// Unit: count. Definition: of the format of checkpoints.
const PAIRS: usize = 6;

/// Sums up the samples of one pixel, in f64 by Welford's update (Welford 1962, "Note on a Method
/// for Calculating Corrected Sums of Squares and Products"): the variance does not suffer where
/// the mean is large.
#[derive(Clone, Debug, PartialEq)]
pub struct Accumulator {
    count: u32,
    dropped: u32,
    indirect: [f32; 3],
    visible_emission: [f32; 3],
    /// Means of [`CaughtShadow::to_array`](super::CaughtShadow::to_array).
    caught: [f32; 3],
    mean: Rgb,
    squares: Rgb,
    luminance_squares: f64,
    alpha: f64,
    transmittance: f64,
    depth: f64,
}

impl Default for Accumulator {
    /// No sample yet.
    fn default() -> Self {
        Self {
            count: 0,
            dropped: 0,
            indirect: [0.0; 3],
            visible_emission: [0.0; 3],
            caught: [0.0; 3],
            mean: Rgb::ZERO,
            squares: Rgb::ZERO,
            luminance_squares: 0.0,
            alpha: 0.0,
            transmittance: 0.0,
            depth: f64::INFINITY,
        }
    }
}

impl Accumulator {
    /// Number of 64-bit words of [`to_bits`](Self::to_bits).
    ///
    /// Unit: count. Definition: of the format of checkpoints.
    pub const WORDS: usize = 16;

    /// Adds a sample. One with a NaN, an infinity or a value beyond the range of f32 (an
    /// infinite depth aside) is counted by [`dropped`](Self::dropped) and otherwise ignored. Features
    /// are left to a [`FeatureMean`](super::FeatureMean).
    pub fn add(&mut self, sample: Sample) {
        if !sample.is_sound() {
            self.dropped += 1;
            return;
        }
        self.count += 1;
        let weight = 1.0 / f64::from(self.count);
        let before = sample.radiance - self.mean;
        self.mean += before * weight;
        let after = sample.radiance - self.mean;
        self.squares += before * after;
        self.luminance_squares += luminance(before) * luminance(after);
        let indirect = self.indirect().lerp(sample.indirect, weight);
        self.indirect = indirect.as_vec3().to_array();
        self.visible_emission =
            self.visible_emission().lerp(sample.visible_emission, weight).as_vec3().to_array();
        for (mean, value) in self.caught.iter_mut().zip(sample.caught.to_array()) {
            let before = f64::from(*mean);
            *mean = (before + (value - before) * weight) as f32;
        }
        self.alpha += (sample.alpha - self.alpha) * weight;
        self.transmittance += (sample.transmittance - self.transmittance) * weight;
        self.depth = self.depth.min(sample.depth);
    }

    /// Number of samples in the mean.
    pub fn count(&self) -> u64 {
        self.count.into()
    }

    /// Number of samples that were dropped.
    pub fn dropped(&self) -> u64 {
        self.dropped.into()
    }

    /// Number of samples that were given, dropped ones included.
    pub fn given(&self) -> u64 {
        self.count() + self.dropped()
    }

    /// The state as the bits of its numbers, for checkpoints.
    pub fn to_bits(&self) -> [u64; Self::WORDS] {
        let [[r, g, b], [u, v, w]] = [self.mean, self.squares].map(|rgb| rgb.to_array());
        let numbers =
            [r, g, b, u, v, w, self.luminance_squares, self.alpha, self.transmittance, self.depth];
        let pair = |low: u32, high: u32| u64::from(low) | u64::from(high) << 32;
        let [[x, y, z], [i, j, k], [c, s, u]] =
            [self.indirect, self.visible_emission, self.caught].map(|rgb| rgb.map(f32::to_bits));
        let mut bits = [0; Self::WORDS];
        bits[..PAIRS].copy_from_slice(&[
            pair(self.count, self.dropped),
            pair(x, y),
            pair(z, i),
            pair(j, k),
            pair(c, s),
            pair(u, 0),
        ]);
        for (word, number) in bits[PAIRS..].iter_mut().zip(numbers) {
            *word = number.to_bits();
        }
        bits
    }

    /// Restores the state from [`to_bits`](Self::to_bits).
    pub fn from_bits(bits: &[u64; Self::WORDS]) -> Self {
        let number = |index: usize| f64::from_bits(bits[PAIRS + index]);
        let [low, high] = [|word: u64| word as u32, |word: u64| (word >> 32) as u32];
        Self {
            count: low(bits[0]),
            dropped: high(bits[0]),
            indirect: [low(bits[1]), high(bits[1]), low(bits[2])].map(f32::from_bits),
            visible_emission: [high(bits[2]), low(bits[3]), high(bits[3])].map(f32::from_bits),
            caught: [low(bits[4]), high(bits[4]), low(bits[5])].map(f32::from_bits),
            mean: Rgb::new(number(0), number(1), number(2)),
            squares: Rgb::new(number(3), number(4), number(5)),
            luminance_squares: number(6),
            alpha: number(7),
            transmittance: number(8),
            depth: number(9),
        }
    }

    /// Mean radiance, W/(m² sr); 0 without a sample.
    pub fn mean(&self) -> Rgb {
        self.mean
    }

    /// Mean of [`Sample::indirect`]; 0 without a sample.
    pub fn indirect(&self) -> Rgb {
        Rgb::from_array(self.indirect.map(f64::from))
    }

    /// Mean of [`Sample::visible_emission`]; 0 without a sample.
    pub fn visible_emission(&self) -> Rgb {
        Rgb::from_array(self.visible_emission.map(f64::from))
    }

    /// Mean coverage; 0 without a sample. A shadow on a catcher covers as much as the ratio of sums over all samples
    /// of its light with and without shadow says, since the mean of ratios of single ones is another.
    pub fn alpha(&self) -> f64 {
        let [seen, shadowed, unshadowed] = self.caught.map(f64::from);
        if unshadowed == 0.0 {
            return self.alpha;
        }
        (self.alpha + seen * (1.0 - shadowed / unshadowed)).clamp(0.0, 1.0)
    }

    /// Mean transmittance; 0 without a sample.
    pub fn transmittance(&self) -> f64 {
        self.transmittance
    }

    /// Least [depth](Sample::depth) of a sample, in metres; positive infinity where none met anything.
    /// Distances are not averaged: between two surfaces there is nothing.
    pub fn depth(&self) -> f64 {
        self.depth
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
        let n = f64::from(self.count);
        if self.count < 2 { 0.0 } else { 1.0 / (n * (n - 1.0)) }
    }
}

impl From<&Accumulator> for FilmPixel {
    /// The pixel of these samples; saliency, xs, radius and step are 0, for the caller to set.
    fn from(samples: &Accumulator) -> Self {
        Self {
            radiance: samples.mean(),
            visible_emission: samples.visible_emission(),
            alpha: samples.alpha(),
            depth: samples.depth(),
            transmittance: samples.transmittance(),
            rays: (samples.count() + samples.dropped()) as f64,
            variance: samples.luminance_variance(),
            ..Self::default()
        }
    }
}
