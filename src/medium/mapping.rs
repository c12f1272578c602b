//! From a grid's values to densities.

use super::transfer::Transfer;

/// What a medium makes of a grid's values.
pub(super) trait Mapping: Copy + std::fmt::Debug {
    /// Of one value.
    fn value(self, v: f64) -> f64;
    /// Bounds of what values from one to another become.
    fn range(self, range: [f64; 2]) -> [f64; 2];
}

/// Values as they are.
#[derive(Debug, Clone, Copy)]
pub(super) struct AsItIs;

impl Mapping for AsItIs {
    #[inline]
    fn value(self, v: f64) -> f64 {
        v
    }

    #[inline]
    fn range(self, range: [f64; 2]) -> [f64; 2] {
        range
    }
}

impl Mapping for &Transfer<f64> {
    #[inline]
    fn value(self, v: f64) -> f64 {
        self.at(v)
    }

    fn range(self, range: [f64; 2]) -> [f64; 2] {
        Transfer::range(self, range)
    }
}
