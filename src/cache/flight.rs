//! What one flight adds to the cells of a brick: its length in each, weighed by a phase function or as
//! moments.

use std::ops::Range;

use glam::{DVec3, IVec3};

use crate::math::{Spectrum, warp};
use crate::medium::{BRICK, VOLUME, cell_index};

use super::cell_walk::{Line, Steps};
use super::moments::of_flight;

/// Largest relative change of the phase function's value along a flight through a brick up to which it
/// is interpolated linearly between the ends.
///
/// Unit: none. Derivation: a smooth function that changes by a tenth over a length is off by less than
/// a hundredth where it is interpolated linearly.
const MAX_LINEAR_CHANGE: f64 = 0.1;

/// A flight in cell coordinates.
pub(super) struct Flight<S: Spectrum> {
    pub line: Line,
    /// Unit direction.
    pub direction: DVec3,
    /// Power times length in cells.
    pub power: S::F32,
}

impl<S: Spectrum> Flight<S> {
    /// The cells of a brick that the part of the line from `from` to `to` crosses.
    fn steps(&self, brick: IVec3, from: f64, to: f64) -> Steps {
        let (low, high) = (brick << BRICK, (brick + 1) << BRICK);
        Steps::new(&self.line, from, to, low, high, 0)
    }

    /// Adds light that is scattered isotropically, in cells that are `seen` where the line crosses them.
    pub fn add_isotropic(
        &self,
        sums: &mut [S::F32],
        brick: IVec3,
        [from, to]: [f64; 2],
        seen: impl Fn(usize, f64) -> bool,
    ) {
        let even = self.power * warp::uniform_sphere_pdf() as f32;
        for (cell, from, to) in self.steps(brick, from, to) {
            let cell = cell_index(cell - (brick << BRICK));
            if seen(cell, 0.5 * (from + to)) {
                sums[cell] += even * (to - from) as f32;
            }
        }
    }

    /// Adds the moments of these numbers.
    pub fn add_moments(
        &self,
        sums: &mut [S::F32],
        brick: IVec3,
        from: f64,
        to: f64,
        numbers: Range<usize>,
    ) {
        let even = self.power * warp::uniform_sphere_pdf() as f32;
        let of_flight = of_flight(self.direction).map(|m| m as f32);
        let moments = &of_flight[numbers];
        for (cell, from, to) in self.steps(brick, from, to) {
            let cell = cell_index(cell - (brick << BRICK));
            let power = even * (to - from) as f32;
            for (plane, moment) in moments.iter().enumerate() {
                sums[plane * VOLUME + cell] += power * *moment;
            }
        }
    }

    /// Adds light that is scattered toward the camera, for which the phase function has this `value`
    /// along the line, in cells that are `seen` where that crosses them.
    pub fn add_scattered(
        &self,
        sums: &mut [S::F32],
        brick: IVec3,
        [from, to]: [f64; 2],
        seen: impl Fn(usize, f64) -> bool,
        value: impl Fn(f64) -> f64,
    ) {
        let (first, last) = (value(from), value(to));
        let slope = (last - first) / (to - from);
        let linear = (last - first).abs() <= MAX_LINEAR_CHANGE * first.min(last);
        for (cell, begin, end) in self.steps(brick, from, to) {
            let middle = 0.5 * (begin + end);
            let cell = cell_index(cell - (brick << BRICK));
            if !seen(cell, middle) {
                continue;
            }
            let share = if linear { first + slope * (middle - from) } else { value(middle) };
            sums[cell] += self.power * ((end - begin) * share) as f32;
        }
    }
}
