//! A choice among numbered things by weight.

/// Cumulative distribution over `0..n`.
#[derive(Debug, Clone)]
pub(super) struct Cdf {
    /// Share of the weight up to and including each thing; the last is 1.
    upto: Vec<f64>,
    /// Sum of the weights.
    total: f64,
}

impl Cdf {
    /// By these weights, or nothing where none is above 0. Weights must be finite and not
    /// negative.
    pub(super) fn new(weights: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut total = 0.0;
        let mut upto: Vec<f64> = weights
            .into_iter()
            .map(|w| {
                total += w;
                total
            })
            .collect();
        if !(total > 0.0 && total.is_finite()) {
            return None;
        }
        for share in &mut upto {
            *share /= total;
        }
        Some(Self { upto, total })
    }

    pub(super) const fn total(&self) -> f64 {
        self.total
    }

    /// Probability of `index`.
    pub(super) fn probability(&self, index: usize) -> f64 {
        self.upto[index] - if index == 0 { 0.0 } else { self.upto[index - 1] }
    }

    /// A thing of positive weight, its probability, and what of `u` in [0, 1) is left to use,
    /// again uniform in [0, 1).
    pub(super) fn sample(&self, u: f64) -> (usize, f64, f64) {
        // u is below the last share, 1, so that the index is in range and its probability not 0.
        let index = self.upto.partition_point(|&share| share <= u).min(self.upto.len() - 1);
        let probability = self.probability(index);
        let below = self.upto[index] - probability;
        let left = ((u - below) / probability).clamp(0.0, 1.0 - f64::EPSILON);
        (index, probability, left)
    }
}
