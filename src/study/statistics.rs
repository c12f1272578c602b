//! Estimates with intervals from few values above 0.

use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, StudentsT};
use statrs::statistics::{Data, OrderStatistics};

/// The share of intervals that hold the true value.
pub const CONFIDENCE: f64 = 0.95;

/// By which factor places must differ for a slope.
pub const APART: f64 = 1.5;

/// What several seeds say of one quantity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    /// The geometric mean, since times, errors and their ratios spread by factors.
    pub estimate: f64,
    /// Student's t interval of the mean logarithm at [`CONFIDENCE`], taken back to the quantity's
    /// unit. Nothing for fewer than two values.
    pub range: Option<[f64; 2]>,
    /// The median of the values.
    pub median: f64,
    /// How many values there were.
    pub samples: usize,
}

impl Interval {
    /// The interval of finite `values` of at least 0, nothing where there are none or one is no
    /// such number. A value of 0 has no logarithm: then mean and interval are of the values
    /// themselves, the interval cut off at 0.
    pub fn from_values(values: &[f64]) -> Option<Self> {
        if values.is_empty() || values.iter().any(|v| !v.is_finite() || *v < 0.0) {
            return None;
        }
        let (estimate, range) = if values.iter().all(|v| *v > 0.0) {
            let logarithms: Vec<f64> = values.iter().map(|v| v.ln()).collect();
            let (mean, half) = mean_and_half_width(&logarithms);
            (mean.exp(), half.map(|half| [(mean - half).exp(), (mean + half).exp()]))
        } else {
            let (mean, half) = mean_and_half_width(values);
            (mean, half.map(|half| [(mean - half).max(0.0), mean + half]))
        };
        Some(Self {
            estimate,
            range,
            median: Data::new(values.to_vec()).median(),
            samples: values.len(),
        })
    }
}

/// The mean, and half the width of Student's t interval where there are two values.
fn mean_and_half_width(values: &[f64]) -> (f64, Option<f64>) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let freedom = n - 1.0;
    let half = students_t(freedom).map(|t| {
        let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / freedom;
        t * (variance / n).sqrt()
    });
    (mean, half)
}

/// Student's t with these degrees of freedom that bounds the two-sided interval at [`CONFIDENCE`];
/// `None` without any degree of freedom.
pub(super) fn students_t(freedom: f64) -> Option<f64> {
    let student = StudentsT::new(0.0, 1.0, freedom).ok()?;
    Some(student.inverse_cdf(0.5 + CONFIDENCE / 2.0))
}

/// The slope of the least-squares line through the logarithms of `points` above 0: -1 for the
/// squared error of independent samples against their number. Nothing where no two places are a
/// factor of `APART` apart: noise would decide.
pub fn slope(points: &[(f64, f64)]) -> Option<f64> {
    let logarithms: Vec<(f64, f64)> = points
        .iter()
        .filter(|(x, y)| *x > 0.0 && *y > 0.0)
        .map(|(x, y)| (x.ln(), y.ln()))
        .collect();
    let ends = logarithms.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (x, _)| {
        (low.min(*x), high.max(*x))
    });
    if ends.1 - ends.0 < APART.ln() || logarithms.is_empty() {
        return None;
    }
    let n = logarithms.len() as f64;
    let (x, y) = logarithms.iter().fold((0.0, 0.0), |sum, p| (sum.0 + p.0 / n, sum.1 + p.1 / n));
    let across: f64 = logarithms.iter().map(|p| (p.0 - x).powi(2)).sum();
    let along: f64 = logarithms.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    Some(along / across)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: f64, b: f64) -> bool {
        (a - b).abs() <= 1e-4 * b.abs()
    }

    #[test]
    fn intervals_against_values_worked_by_hand() {
        // Logarithms 0, ln 2, 2 ln 2: mean ln 2, deviation ln 2, t of 2 degrees 4.30265.
        let interval = Interval::from_values(&[1.0, 4.0, 2.0]).unwrap();
        assert!(near(interval.estimate, 2.0) && interval.median == 2.0 && interval.samples == 3);
        let factor = (4.302_65 / 3f64.sqrt() * 2f64.ln()).exp();
        let [low, high] = interval.range.unwrap();
        assert!(near(low, 2.0 / factor) && near(high, 2.0 * factor), "{low} {high}");
        // With a 0: 0, 1, 2, 3 has mean 1.5, deviation 1.29099, t of 3 degrees 3.18245.
        let [low, high] = Interval::from_values(&[0.0, 3.0, 1.0, 2.0]).unwrap().range.unwrap();
        assert!(low == 0.0 && near(high, 1.5 + 3.182_45 * 1.290_99 / 2.0), "{high}");
    }

    #[test]
    fn what_cannot_be_told_is_not() {
        assert_eq!(Interval::from_values(&[]), None);
        assert_eq!(Interval::from_values(&[1.0, f64::NAN]), None);
        assert_eq!(Interval::from_values(&[3.0]).unwrap().range, None);
        assert_eq!(slope(&[(1.0, 2.0), (1.2, 3.0)]), None);
    }

    #[test]
    fn slope_of_a_power_law() {
        let law = [1.0, 2.0, 8.0].map(|x: f64| (x, 3.0 * x.powf(-4.0 / 7.0)));
        assert!(near(slope(&law).unwrap(), -4.0 / 7.0));
    }
}
