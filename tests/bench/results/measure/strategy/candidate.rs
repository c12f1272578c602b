//! A strategy that was asked for, or chosen, with its pictures over the seeds.

use fogbow::scene::{Strategy, StrategyRequest};

use super::super::halves::{Halves, Pixels, mean, trimmed_mean};
use crate::pages::strategy::{Figures, Measured};

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
        let errors = self.pictures.iter().map(|picture| truth.errors_of(picture));
        let (trimmed, whole) = errors.map(|[trimmed, whole]| (trimmed, whole)).unzip();
        [trimmed, whole]
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
