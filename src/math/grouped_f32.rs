//! Light told apart by the group of its emitters or the order of its scattering, in f32.

use std::array;
use std::iter::Sum;
use std::ops::{Add, AddAssign, Div, Mul};

use super::{Group, MOST_NUMBERS};

/// [`GroupedRgb`](super::GroupedRgb) in f32: the whole, then each part, of which all are 0 in a coefficient.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct GroupedF32(pub(super) [f32; MOST_NUMBERS]);

impl GroupedF32 {
    fn each(self, f: impl Fn(f32) -> f32) -> Self {
        Self(self.0.map(f))
    }
}

impl Add for GroupedF32 {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(array::from_fn(|index| self.0[index] + other.0[index]))
    }
}

impl AddAssign for GroupedF32 {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sum for GroupedF32 {
    fn sum<I: Iterator<Item = Self>>(values: I) -> Self {
        values.fold(Self::default(), Add::add)
    }
}

impl Mul<f32> for GroupedF32 {
    type Output = Self;
    fn mul(self, factor: f32) -> Self {
        self.each(|number| number * factor)
    }
}

impl Div<f32> for GroupedF32 {
    type Output = Self;
    fn div(self, divisor: f32) -> Self {
        self.each(|number| number / divisor)
    }
}

/// Light of one group in f32.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SingleGroup {
    pub(super) light: [f32; 3],
    pub(super) group: Group,
}
