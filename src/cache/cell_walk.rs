//! The cells that a line crosses, by a 3D-DDA (Amanatides and Woo 1987, "A Fast Voxel Traversal
//! Algorithm for Ray Tracing"). The trees of voxel grids have a walk of their own
//! (`vdb/walk.rs`), which descends nodes of several sizes and skips empty ones: it shares no step with
//! this one over dense bricks of one size.

use glam::{DVec3, IVec3};

/// Component of a line, in cells, below which it does not move along an axis.
///
/// Unit: none. Limit: on inverses, whose products with positions are to be finite.
const MIN_DIRECTION: f64 = 1e-12;

/// A line segment in cell coordinates, of parameter 0 to 1.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line {
    start: DVec3,
    /// From the start to the end.
    pub direction: DVec3,
    /// Infinite along an axis that the line does not move on.
    inverse: DVec3,
}

impl Line {
    pub fn new(start: DVec3, direction: DVec3) -> Self {
        let still = direction.abs().cmplt(DVec3::splat(MIN_DIRECTION));
        let inverse = DVec3::select(still, DVec3::INFINITY, direction.recip());
        let direction = DVec3::select(still, DVec3::ZERO, direction);
        Self { start, direction, inverse }
    }

    pub fn at(&self, u: f64) -> DVec3 {
        self.start + self.direction * u
    }

    /// The part inside the box from `low` to `high`.
    pub fn within(&self, low: DVec3, high: DVec3) -> (f64, f64) {
        let (mut from, mut to) = (0.0_f64, 1.0_f64);
        for axis in 0..3 {
            let (a, b) = (low[axis] - self.start[axis], high[axis] - self.start[axis]);
            if self.direction[axis] == 0.0 {
                if a > 0.0 || b <= 0.0 {
                    return (0.0, 0.0);
                }
                continue;
            }
            let (a, b) = (a * self.inverse[axis], b * self.inverse[axis]);
            from = from.max(a.min(b));
            to = to.min(a.max(b));
        }
        (from, to)
    }
}

/// The cubes that a line crosses, each with the part of the line inside. The cube is an integer along
/// each axis and only moves onward, so that the walk ends whatever rounding does.
pub(super) struct Steps {
    cube: [i32; 3],
    /// The first cube beyond the box along each axis.
    out: [i32; 3],
    step: [i32; 3],
    /// Parameter at which the line crosses the next face along each axis.
    next: [f64; 3],
    between: [f64; 3],
    at: f64,
    to: f64,
    done: bool,
}

impl Steps {
    /// The cubes of 2^`log2` cells along the part of `line` from `from` to `to`, which lies in the
    /// box of the cubes from `low` up to `high`.
    pub fn new(line: &Line, from: f64, to: f64, low: IVec3, high: IVec3, log2: i32) -> Self {
        let edge = f64::from(1 << log2);
        let first = (line.at(from) / edge).floor().as_ivec3().clamp(low, high - 1);
        let (mut step, mut out, mut next, mut between) = ([0; 3], [0; 3], [0.0; 3], [0.0; 3]);
        for axis in 0..3 {
            let forward = line.direction[axis] >= 0.0;
            step[axis] = if forward { 1 } else { -1 };
            out[axis] = if forward { high[axis] } else { low[axis] - 1 };
            let face = f64::from(first[axis] + i32::from(forward)) * edge - line.start[axis];
            let still = line.direction[axis] == 0.0;
            next[axis] = if still { f64::INFINITY } else { face * line.inverse[axis] };
            between[axis] = edge * line.inverse[axis].abs();
        }
        Self { cube: first.to_array(), out, step, next, between, at: from, to, done: to <= from }
    }
}

impl Iterator for Steps {
    type Item = (IVec3, f64, f64);

    #[inline]
    fn next(&mut self) -> Option<Self::Item> {
        while !self.done {
            let [x, y, z] = self.next;
            let axis = if x <= y && x <= z {
                0
            } else if y <= z {
                1
            } else {
                2
            };
            let (cube, from) = (IVec3::from(self.cube), self.at);
            let until = self.next[axis].min(self.to);
            if until < self.to {
                self.cube[axis] += self.step[axis];
                self.next[axis] += self.between[axis];
                self.done = self.cube[axis] == self.out[axis];
            } else {
                self.done = true;
            }
            if until > from {
                self.at = until;
                return Some((cube, from, until));
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn place() -> impl Strategy<Value = DVec3> {
        let number = prop_oneof![-40.0..40.0, (-4..4).prop_map(f64::from), Just(1e-13)];
        [number.clone(), number.clone(), number].prop_map(DVec3::from)
    }

    proptest! {
        #[test]
        fn cubes_follow_the_line_without_gaps(from in place(), to in place(), log2 in 0..4) {
            let line = Line::new(from, to - from);
            let edge = f64::from(1 << log2);
            let (low, high) = (IVec3::splat(-3), IVec3::new(2, 4, 3));
            let (first, last) = line.within(low.as_dvec3() * edge, high.as_dvec3() * edge);
            let mut at = first;
            for (cube, begin, end) in Steps::new(&line, first, last, low, high, log2) {
                prop_assert!(begin == at && end > begin, "from {begin} to {end} after {at}");
                let middle = line.at(0.5 * (begin + end)) / edge - cube.as_dvec3();
                prop_assert!(middle.cmpge(DVec3::splat(-1e-9)).all(), "{middle} of {cube}");
                prop_assert!(middle.cmple(DVec3::splat(1.0 + 1e-9)).all(), "{middle} of {cube}");
                at = end;
            }
            prop_assert!(last <= first || (at - last).abs() < 1e-9, "ended at {at}, not {last}");
        }
    }
}
