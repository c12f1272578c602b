//! Order statistics of a few values.

/// The value of `values` that `rank` of the others are not above, counted from 0; `None` where there are
/// no more than `rank`. NaN counts as the largest.
pub fn nth_smallest(mut values: Vec<f64>, rank: usize) -> Option<f64> {
    (rank < values.len()).then(|| *values.select_nth_unstable_by(rank, f64::total_cmp).1)
}

/// The `share` quantile of `values`, 0 to 1, without interpolation: of n values that of the rank
/// floor(n `share`), counted from 0. Its median of two values is the larger. `None` where there are none.
pub fn quantile(values: Vec<f64>, share: f64) -> Option<f64> {
    let last = values.len().checked_sub(1)?;
    let rank = (values.len() as f64 * share) as usize;
    nth_smallest(values, rank.min(last))
}

/// Values with weights, by value.
#[derive(Debug)]
pub struct WeightedValues(Vec<(f64, f64)>);

impl WeightedValues {
    /// The pairs of a value and its weight, which is not negative.
    pub fn new(values: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let mut values: Vec<_> = values.into_iter().collect();
        values.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self(values)
    }

    /// The sum of the weights.
    pub fn total(&self) -> f64 {
        self.0.iter().map(|(_, weight)| weight).sum()
    }

    /// The least value up to which `share` of the weight lies, 0 to 1; `None` where there is no weight.
    pub fn quantile(&self, share: f64) -> Option<f64> {
        let needed = share * self.total();
        let mut sum = 0.0;
        let reached = self.0.iter().find(|(_, weight)| {
            sum += weight;
            sum > 0.0 && sum >= needed
        });
        reached.map(|(value, _)| *value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_of_four_values() {
        let at = |share| quantile(vec![3.0, 1.0, 4.0, 2.0], share);
        assert_eq!(
            [0.0, 0.2, 0.25, 0.5, 0.9, 1.0].map(at),
            [1.0, 1.0, 2.0, 3.0, 4.0, 4.0].map(Some)
        );
        assert_eq!(quantile(Vec::new(), 0.5), None);
        assert_eq!(nth_smallest(vec![5.0, f64::NAN, -1.0], 1), Some(5.0));
        assert_eq!(nth_smallest(vec![5.0], 1), None);
    }

    #[test]
    fn weights_decide_how_far_a_quantile_lies() {
        let values = WeightedValues::new([(3.0, 1.0), (1.0, 0.0), (2.0, 7.0), (5.0, 2.0)]);
        assert_eq!(values.total(), 10.0);
        let at = |share| values.quantile(share);
        assert_eq!([0.0, 0.7, 0.75, 0.85, 1.0].map(at), [2.0, 2.0, 3.0, 5.0, 5.0].map(Some));
        assert_eq!(WeightedValues::new([(1.0, 0.0)]).quantile(0.5), None);
    }
}
