//! Conditions on numbers.

/// A condition on a number, with the words that say what would be right.
#[derive(Debug, Clone, Copy)]
pub struct Range {
    holds: fn(f64) -> bool,
    words: &'static str,
}

impl Range {
    pub(in crate::scene) const ANY: Self = Self { holds: |_| true, words: "a finite number" };
    pub(in crate::scene) const POSITIVE: Self =
        Self { holds: |x| x > 0.0, words: "a number above 0" };
    pub(in crate::scene) const NOT_NEGATIVE: Self =
        Self { holds: |x| x >= 0.0, words: "a number of at least 0" };
    pub(in crate::scene) const NOT_ZERO: Self =
        Self { holds: |x| x != 0.0, words: "a number other than 0" };
    pub(in crate::scene) const UNIT: Self =
        Self { holds: |x| (0.0..=1.0).contains(&x), words: "a number from 0 to 1" };

    pub(in crate::scene) const fn new(holds: fn(f64) -> bool, words: &'static str) -> Self {
        Self { holds, words }
    }

    /// Whether `x` meets it.
    pub fn holds(&self, x: f64) -> bool {
        (self.holds)(x)
    }

    /// What would be right.
    pub const fn words(&self) -> &'static str {
        self.words
    }
}
