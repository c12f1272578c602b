//! Errors and seconds of pictures of several seeds, and how two ways of rendering compare by them.

use std::ops::Range;

use fogbow::math::{Stage, Stream};

use crate::pages::strategy::Figures;

/// Samples of the bootstrap.
const RESAMPLED: u64 = 10_000;

/// Shares of them below the ends of an interval of 95 %.
const ENDS: [f64; 2] = [0.025, 0.975];

/// Errors and seconds of one way of rendering over the seeds.
pub struct Series<'a> {
    pub errors: &'a [f64],
    pub seconds: &'a [f64],
}

impl Series<'_> {
    /// Means over these seeds.
    pub fn figures(&self, seeds: &[usize]) -> Figures {
        let mean = |values: &[f64]| {
            seeds.iter().map(|&seed| values[seed]).sum::<f64>() / seeds.len() as f64
        };
        Figures { error: mean(self.errors), seconds: mean(self.seconds) }
    }
}

/// The cost of `own` over that of `other` on these seeds, with the interval of 95 % of a bootstrap
/// (Efron 1979, "Bootstrap Methods: Another Look at the Jackknife"; percentiles): seeds are drawn with
/// replacement, figures of both together, for a seed shoots the same photons for both.
pub fn cost_ratio(own: &Series<'_>, other: &Series<'_>, seeds: Range<usize>) -> (f64, [f64; 2]) {
    let seeds: Vec<usize> = seeds.collect();
    let ratio = |seeds: &[usize]| own.figures(seeds).cost() / other.figures(seeds).cost();
    let resampled = |sample: u64| {
        let mut random = Stream::new(0, Stage::Test, 0, sample);
        let drawn = seeds.iter().map(|_| (random.uniform() * seeds.len() as f64) as usize);
        ratio(&drawn.map(|index| seeds[index]).collect::<Vec<_>>())
    };
    let mut ratios: Vec<f64> = (0..RESAMPLED).map(resampled).collect();
    ratios.sort_unstable_by(f64::total_cmp);
    (ratio(&seeds), ENDS.map(|share| ratios[(share * (RESAMPLED - 1) as f64).round() as usize]))
}
