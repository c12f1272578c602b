//! Choices among numbered things in proportion to weights.

/// A discrete distribution over `0..n`, sampled by inverting its cumulative weights (Pharr, Jakob and
/// Humphreys 2023, "Physically Based Rendering", `SampleDiscrete`).
#[derive(Debug, Clone, PartialEq)]
pub struct Cdf {
    /// The sum of the weights up to and including each index, in the unit of the weights.
    sums: Vec<f64>,
}

impl Cdf {
    /// The distribution in proportion to `weights`, which must be finite and not negative; `None` where
    /// their sum is not above 0 and finite.
    pub fn new(weights: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut total = 0.0;
        let add = |weight: f64| {
            total += weight;
            total
        };
        let sums: Vec<f64> = weights.into_iter().map(add).collect();
        (total > 0.0 && total.is_finite()).then_some(Self { sums })
    }

    /// The sum of the weights, in their unit.
    pub fn total(&self) -> f64 {
        self.sums[self.sums.len() - 1]
    }

    /// Probability of `index`.
    pub fn probability(&self, index: usize) -> f64 {
        (self.sums[index] - self.below(index)) / self.total()
    }

    /// The index that `u` in [0, 1) chooses, of positive weight, and `u` remapped to [0, 1), again
    /// uniform.
    pub fn sample(&self, u: f64) -> (usize, f64) {
        let total = self.total();
        let last = self.sums.len() - 1;
        let index = self.sums.partition_point(|&sum| sum / total <= u).min(last);
        let share = self.sums[index] / total;
        let probability = share - self.below(index) / total;
        let below = share - probability;
        (index, ((u - below) / probability).clamp(0.0, 1.0 - f64::EPSILON))
    }

    /// The sum of the weights before `index`.
    fn below(&self, index: usize) -> f64 {
        if index == 0 { 0.0 } else { self.sums[index - 1] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAST: f64 = 1.0 - f64::EPSILON / 2.0;

    /// Evenly spaced numbers choose each index as often as its weight says, and come out evenly spaced.
    #[test]
    fn choices_follow_weights() {
        let weights = [0.0, 3.0, 0.0, 1.0, 4.0, 0.0];
        let cdf = Cdf::new(weights).unwrap();
        assert_eq!(cdf.total(), 8.0);
        let count = 800;
        let mut remapped = vec![Vec::new(); weights.len()];
        for i in 0..count {
            let (index, u) = cdf.sample((f64::from(i) + 0.5) / f64::from(count));
            remapped[index].push(u);
        }
        for (index, weight) in weights.into_iter().enumerate() {
            assert_eq!(cdf.probability(index), weight / 8.0);
            let times = remapped[index].len();
            assert_eq!(times as f64, 100.0 * weight);
            for (i, u) in remapped[index].iter().enumerate() {
                assert!((u - (i as f64 + 0.5) / times as f64).abs() < 1e-12, "{index}: {u}");
            }
        }
    }

    #[test]
    fn ends_of_the_interval_choose_positive_weights() {
        for scale in [f64::MIN_POSITIVE, f64::from_bits(1), 1.0, 1e300] {
            let cdf = Cdf::new([0.0, 2.0 * scale, 3.0 * scale, 0.0]).unwrap();
            assert_eq!(cdf.sample(0.0), (1, 0.0), "{scale}");
            let (index, u) = cdf.sample(LAST);
            assert!(index == 2 && (0.0..1.0).contains(&u), "{scale}: {index} {u}");
        }
    }

    #[test]
    fn weights_without_a_finite_sum_above_0_have_no_distribution() {
        for weights in [[].as_slice(), &[0.0, 0.0], &[1.0, f64::INFINITY], &[f64::NAN], &[1e308; 2]]
        {
            assert_eq!(Cdf::new(weights.iter().copied()), None, "{weights:?}");
        }
    }
}
