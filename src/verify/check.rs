//! One number held against its bounds.

use serde::Serialize;

/// A number that was found, and the bounds that it must keep.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Check {
    /// What the number is.
    pub what: String,
    /// What was found.
    pub found: f64,
    /// Smallest value that holds; nothing where any small one does.
    pub low: Option<f64>,
    /// Largest value that holds.
    pub high: f64,
}

impl Check {
    /// `found` must be within `tolerance` of `expected`.
    pub fn near(what: impl Into<String>, found: f64, expected: f64, tolerance: f64) -> Self {
        Self::within(what, found, expected - tolerance, expected + tolerance)
    }

    /// `found` must be from `low` to `high`.
    pub fn within(what: impl Into<String>, found: f64, low: f64, high: f64) -> Self {
        Self { what: what.into(), found, low: Some(low), high }
    }

    /// `found`, a size or a count that is best where it is 0, must be at most `high`.
    pub fn at_most(what: impl Into<String>, found: f64, high: f64) -> Self {
        Self { what: what.into(), found, low: None, high }
    }

    /// Whether the bounds are kept; NaN keeps none.
    pub fn holds(&self) -> bool {
        self.found <= self.high && self.low.is_none_or(|low| self.found >= low)
    }

    /// How much of the bounds is used: 0 in the middle of them, or at 0 where there is only an
    /// upper one; 1 at their ends; more outside; infinite for what is not finite.
    pub fn strain(&self) -> f64 {
        if !self.found.is_finite() {
            return f64::INFINITY;
        }
        let low = self.low.unwrap_or(-self.high);
        let (middle, half) = (0.5 * (low + self.high), 0.5 * (self.high - low));
        let off = (self.found - middle).abs();
        match (self.holds(), half > 0.0) {
            (true, true) => (off / half).min(1.0), // rounding must not fail what holds
            (true, false) => 0.0,
            (false, true) => (off / half).max(1.0 + f64::EPSILON),
            (false, false) => f64::INFINITY,
        }
    }
}

impl std::fmt::Display for Check {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { what, found, low, high } = self;
        match low {
            Some(low) => write!(f, "{what}: {found:.6e} in {low:.6e} to {high:.6e}"),
            None => write!(f, "{what}: {found:.6e} up to {high:.6e}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_hold_at_their_ends_and_nan_keeps_none() {
        assert!(Check::within("", 1.0, 1.0, 2.0).holds());
        assert_eq!(Check::within("", 2.0, 1.0, 2.0).strain(), 1.0);
        assert_eq!(Check::near("", 3.0, 3.0, 0.0).strain(), 0.0);
        assert!(Check::near("", 3.5, 3.0, 0.1).strain() > 4.0);
        let nan = Check::within("", f64::NAN, 0.0, 1.0);
        assert!(!nan.holds() && nan.strain() == f64::INFINITY);
    }

    #[test]
    fn what_is_best_at_zero_is_not_strained_there() {
        assert_eq!(Check::at_most("", 0.0, 2.0).strain(), 0.0);
        assert_eq!(Check::at_most("", 0.0, 0.0).strain(), 0.0);
        assert!((Check::at_most("", 1.5, 2.0).strain() - 0.75).abs() < 1e-12);
        assert!(!Check::at_most("", 1.0, 0.0).holds());
    }
}
