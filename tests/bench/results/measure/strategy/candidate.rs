//! A strategy that was asked for, or chosen, with its pictures over the seeds.

use std::ops::Range;

use fogbow::math::{Stage, Stream};
use fogbow::scene::{Strategy, StrategyRequest};

use super::super::halves::{Halves, Pixels, mean, trimmed_mean};
use crate::pages::ratio::Ratio;
use crate::pages::strategy::{Figures, Measured};

/// Samples of the bootstrap.
const RESAMPLED: u64 = 10_000;

/// Shares of them below the ends of an interval of 95 %.
const ENDS: [f64; 2] = [0.025, 0.975];

/// A request, and what it gave.
pub struct Candidate {
    /// Who decided.
    pub request: StrategyRequest,
    /// The strategy that each medium has with the seed of the scene.
    pub media: Vec<Strategy>,
    /// Seeds with which the media have others: what is chosen can depend on the pilot's paths.
    pub other_seeds: usize,
    /// One a seed.
    pub pictures: Vec<Pixels>,
    /// Processor seconds of each picture, of all threads.
    pub seconds: Vec<f64>,
}

impl Candidate {
    /// Whether its strategy was asked for by name.
    pub fn is_asked(&self) -> bool {
        matches!(self.request, StrategyRequest::Asked(_))
    }

    /// Trimmed and untrimmed relative squared errors of each picture.
    pub fn errors(&self, truth: &Halves) -> [Vec<f64>; 2] {
        truth.errors_of_each(&self.pictures)
    }

    /// What is told of all pictures together.
    pub fn measured(&self, truth: &Halves) -> Measured {
        let [trimmed, whole] = self.errors(truth);
        Measured {
            request: self.request.name().into(),
            media: self.media.clone(),
            other_seeds: self.other_seeds,
            figures: Figures { error: mean(&trimmed), seconds: mean(&self.seconds) },
            untrimmed: mean(&whole),
            bias: trimmed_mean(truth.squared_bias(self.pictures.iter())),
            brighter_percent: truth.brighter_percent(&self.pictures),
        }
    }
}

/// Errors and seconds of a candidate over the seeds.
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

/// A figure of one series over that of another on these seeds, with the interval of 95 % of a bootstrap
/// (Efron 1979, "Bootstrap Methods: Another Look at the Jackknife"; percentiles): seeds are drawn with
/// replacement, both series' figures together, for a seed shoots the same photons for both.
pub fn ratio(
    of: &Series<'_>,
    over: &Series<'_>,
    seeds: Range<usize>,
    figure: impl Fn(Figures) -> f64,
) -> Ratio {
    let seeds: Vec<usize> = seeds.collect();
    let ratio = |seeds: &[usize]| figure(of.figures(seeds)) / figure(over.figures(seeds));
    let resampled = |sample: u64| {
        let mut random = Stream::new(0, Stage::Test, 0, sample);
        let drawn = seeds.iter().map(|_| (random.uniform() * seeds.len() as f64) as usize);
        ratio(&drawn.map(|index| seeds[index]).collect::<Vec<_>>())
    };
    let mut ratios: Vec<f64> = (0..RESAMPLED).map(resampled).collect();
    ratios.sort_unstable_by(f64::total_cmp);
    let end = |share: f64| ratios[(share * (RESAMPLED - 1) as f64).round() as usize];
    Ratio { ratio: ratio(&seeds), interval: ENDS.map(end) }
}
