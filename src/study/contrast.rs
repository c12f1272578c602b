//! Whether a ratio is told from 1, and how many seeds would tell.

use serde::{Deserialize, Serialize};

use super::statistics::{Interval, students_t};

/// How far from 1 a ratio may be and still count as equal.
pub const EQUAL: f64 = 0.1;

/// The most seeds that are suggested.
pub const MOST_SEEDS: u32 = 1000;

/// The fewest seeds that give an interval worth a look.
pub(super) const FEWEST_SEEDS: u32 = 3;

/// What an interval says of a ratio.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// The interval lies above 1.
    Above,
    /// The interval lies below 1.
    Below,
    /// The interval lies from 1 - [`EQUAL`] to 1 + [`EQUAL`] (equivalence, by two one-sided tests:
    /// Schuirmann 1987).
    Equal,
    /// Neither.
    Open,
}

impl Outcome {
    /// The outcome of a ratio with this interval; equality comes first.
    pub fn from_interval(ratio: &Interval) -> Self {
        match ratio.range {
            Some([low, high]) if low >= 1.0 - EQUAL && high <= 1.0 + EQUAL => Self::Equal,
            Some([low, _]) if low > 1.0 => Self::Above,
            Some([_, high]) if high < 1.0 => Self::Below,
            _ => Self::Open,
        }
    }
}

/// The fewest seeds, more than there are, at which the interval of `ratio` would tell: its mean and
/// the deviation of its logarithms stay, its half width is t(n - 1) s / sqrt(n). Nothing where
/// [`MOST_SEEDS`] would not, or the deviation is not known.
pub fn seeds_to_settle(ratio: &Interval) -> Option<u32> {
    let Some([low, high]) = ratio.range else { return Some(FEWEST_SEEDS) };
    let now = u32::try_from(ratio.samples).ok()?;
    let mean = ratio.estimate.ln();
    let half = 0.5 * (high / low).ln();
    let t = |n: u32| students_t(f64::from(n) - 1.0);
    let deviation = half * f64::from(now).sqrt() / t(now)?;
    let to_the_bounds = ((1.0 + EQUAL).ln() - mean).min(mean - (1.0 - EQUAL).ln());
    let margin = mean.abs().max(to_the_bounds);
    let tells = |n: u32| t(n).is_some_and(|t| t * deviation / f64::from(n).sqrt() < margin);
    // The half width falls with every seed.
    let (mut open, mut settled) = (now, MOST_SEEDS);
    if !deviation.is_finite() || now >= MOST_SEEDS || !tells(settled) {
        return None;
    }
    while settled - open > 1 {
        let middle = u32::midpoint(open, settled);
        *(if tells(middle) { &mut settled } else { &mut open }) = middle;
    }
    Some(settled)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `n` values whose logarithms have this mean and, with n - 1 under the sum, this deviation.
    fn ratio(mean: f64, deviation: f64, n: u32) -> Interval {
        let off = deviation * (f64::from(n - 1) / f64::from(n)).sqrt();
        let value = |i: u32| (mean + if i.is_multiple_of(2) { off } else { -off }).exp();
        Interval::from_values(&(0..n).map(value).collect::<Vec<_>>()).unwrap()
    }

    #[test]
    fn outcomes_of_made_ratios() {
        assert_eq!(Outcome::from_interval(&ratio(0.7, 0.1, 4)), Outcome::Above);
        assert_eq!(Outcome::from_interval(&ratio(-0.7, 0.1, 4)), Outcome::Below);
        assert_eq!(
            Outcome::from_interval(&ratio(0.05, 0.01, 4)),
            Outcome::Equal,
            "5 % for sure are equal"
        );
        assert_eq!(Outcome::from_interval(&ratio(0.05, 0.2, 4)), Outcome::Open);
        assert_eq!(Outcome::from_interval(&Interval::from_values(&[2.0]).unwrap()), Outcome::Open);
    }

    #[test]
    fn seeds_to_settle_are_those_of_the_closed_form() {
        // With many seeds t is 1.96: n = (1.96 s / margin)². A mean of 0 is settled by equality,
        // whose nearer bound is ln 1.1 away.
        for (mean, deviation, margin) in
            [(0.1, 0.6, 0.1), (0.0, 0.7, 1.1_f64.ln()), (-0.2, 1.4, 0.2)]
        {
            let told = f64::from(seeds_to_settle(&ratio(mean, deviation, 8)).unwrap());
            let expected = (1.959_96 * deviation / margin).powi(2);
            assert!((expected..1.03 * expected + 3.0).contains(&told), "{told} of {expected}");
        }
        // From there on it is told, and one seed earlier it is not.
        let n = seeds_to_settle(&ratio(0.1, 0.3, 4)).unwrap();
        assert_ne!(Outcome::from_interval(&widened(0.1, 0.3, n)), Outcome::Open);
        assert_eq!(Outcome::from_interval(&widened(0.1, 0.3, n - 1)), Outcome::Open);
        assert_eq!(seeds_to_settle(&Interval::from_values(&[2.0]).unwrap()), Some(FEWEST_SEEDS));
        assert_eq!(seeds_to_settle(&ratio(0.0, 9.0, 4)), None);
    }

    /// The interval of `n` values with this mean and deviation of logarithms, by its formula.
    fn widened(mean: f64, deviation: f64, n: u32) -> Interval {
        let half = students_t(f64::from(n) - 1.0).unwrap() * deviation / f64::from(n).sqrt();
        let range = Some([(mean - half).exp(), (mean + half).exp()]);
        Interval { estimate: mean.exp(), range, median: mean.exp(), samples: n as usize }
    }
}
