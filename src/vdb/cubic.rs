//! The trilinear value along a piece of a ray in one cell.

use smallvec::SmallVec;

/// Half the distance between the two nodes of Gauss-Legendre quadrature on [-1, 1]: 1/sqrt(3).
const NODE: f64 = 0.577_350_269_189_625_8;

/// Iterations that halve an interval down to rounding, at most.
const HALVINGS: u32 = 64;

/// A cubic polynomial of u, which runs from 0 to 1 along the piece.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cubic {
    coefficients: [f64; 4],
}

impl Cubic {
    /// The same value everywhere.
    pub const fn flat(value: f64) -> Self {
        Self { coefficients: [value, 0.0, 0.0, 0.0] }
    }

    /// The polynomial with these values at u = 0, 1/3, 2/3 and 1.
    pub fn through([a, b, c, d]: [f64; 4]) -> Self {
        if a == b && b == c && c == d {
            return Self::flat(a);
        }
        let (b, c, d) = (b - a, c - a, d - a);
        Self {
            coefficients: [
                a,
                9.0 * b - 4.5 * c + d,
                -22.5 * b + 18.0 * c - 4.5 * d,
                13.5 * (b - c) + 4.5 * d,
            ],
        }
    }

    /// The value at `u`.
    #[inline]
    pub fn at(&self, u: f64) -> f64 {
        let [a, b, c, d] = self.coefficients;
        a + u * (b + u * (c + u * d))
    }

    /// The values at the two places between `start` and `end` whose mean is the mean of the cubic
    /// there.
    #[inline]
    pub fn at_nodes(&self, start: f64, end: f64) -> [f64; 2] {
        let (middle, half) = (0.5 * (start + end), 0.5 * (end - start));
        [self.at(middle - NODE * half), self.at(middle + NODE * half)]
    }

    /// The straight line through [`at_nodes`](Self::at_nodes) of 0 and 1: its mean, which is that of the
    /// cubic, and by how much it rises from there to its end.
    pub fn line(&self) -> [f64; 2] {
        let [first, last] = self.at_nodes(0.0, 1.0);
        [0.5 * (first + last), (last - first) * (0.5 / NODE)]
    }

    /// A bound of how far the integral from 0 to any u is from that of [`line`](Self::line).
    pub fn bow(&self) -> f64 {
        // With x = 2 u - 1 it is above the line by q (x² - 1/3) + r (x³ - x/3). The integrals over u from
        // x = -1 are q (x³ - x)/6 and r ((x⁴ - 1)/4 - (x² - 1)/6)/2, both the largest at x = -1/sqrt(3).
        let [_, _, c, d] = self.coefficients;
        let (q, r) = (0.25 * c + 0.375 * d, 0.125 * d);
        q.abs() * NODE / 9.0 + r.abs() / 18.0
    }

    /// The ends of the parts of [0, 1] in which it only rises or only falls: 0, turning points, 1.
    pub fn monotone_parts(&self) -> SmallVec<[f64; 4]> {
        let [_, b, c, d] = self.coefficients;
        let mut ends = SmallVec::from_slice(&[0.0]);
        // b + 2 c u + 3 d u², by the form without cancellation.
        let discriminant = c * c - 3.0 * d * b;
        if discriminant > 0.0 {
            let q = -(c + discriminant.sqrt().copysign(c));
            let mut roots = [q / (3.0 * d), b / q];
            roots.sort_unstable_by(f64::total_cmp);
            ends.extend(roots.into_iter().filter(|u| *u > 0.0 && *u < 1.0));
        }
        ends.push(1.0);
        ends
    }

    /// Where between `start` and `end`, in which it only rises or only falls, it has `value`: an end
    /// where it does not reach it. By Newton's method within a bracket that shrinks.
    pub fn crossing(&self, value: f64, start: f64, end: f64) -> f64 {
        let [_, b, c, d] = self.coefficients;
        let sign = if self.at(end) >= self.at(start) { 1.0 } else { -1.0 };
        let off = |u: f64| sign * (self.at(u) - value);
        if off(start) >= 0.0 {
            return start;
        }
        if off(end) <= 0.0 {
            return end;
        }
        let (mut low, mut high) = (start, end);
        let mut u = 0.5 * (low + high);
        for _ in 0..HALVINGS {
            let here = off(u);
            if here < 0.0 {
                low = u;
            } else {
                high = u;
            }
            let slope = sign * (b + u * (2.0 * c + u * 3.0 * d));
            let newton = u - here / slope;
            let middle = 0.5 * (low + high);
            let next = if newton > low && newton < high { newton } else { middle };
            if next == u || high - low <= f64::EPSILON {
                break;
            }
            u = next;
        }
        u
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const THIRDS: [f64; 4] = [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0];

    proptest! {
        #[test]
        fn it_passes_through_its_values(values in prop::array::uniform4(-5.0..5.0f64)) {
            let cubic = Cubic::through(values);
            for (u, value) in THIRDS.into_iter().zip(values) {
                prop_assert!((cubic.at(u) - value).abs() < 1e-12);
            }
            let nodes = cubic.at_nodes(0.0, 1.0);
            let [a, b, c, d] = values;
            let simpson = (a + 3.0 * b + 3.0 * c + d) / 8.0; // exact for cubics
            prop_assert!((0.5 * (nodes[0] + nodes[1]) - simpson).abs() < 1e-12);
        }

        #[test]
        fn its_bow_bounds_how_far_the_line_is_off(
            values in prop::array::uniform4(-5.0..5.0f64),
            end in 0.0..=1.0f64,
        ) {
            let cubic = Cubic::through(values);
            let [mean, rise] = cubic.line();
            let [a, b] = cubic.at_nodes(0.0, end);
            let exact = 0.5 * (a + b) * end;
            let line = end * (mean + rise * (end - 1.0));
            let (off, bound) = ((exact - line).abs(), cubic.bow());
            prop_assert!(off <= bound + 1e-12, "{off} above {bound}");
        }

        /// Along a line through a cell whose corners are nowhere below 0 the Bernstein coefficients are not.
        #[test]
        fn a_line_that_is_kept_above_0_is_off_by_a_quarter_at_most(
            bernstein in prop::array::uniform4(0.0..5.0f64),
            zeros in 0..16u32,
            end in 0.0..=1.0f64,
        ) {
            let [a, b, c, d] = [0, 1, 2, 3].map(|k| {
                if zeros >> k & 1 == 1 { 0.0 } else { bernstein[k as usize] }
            });
            let value = |u: f64| {
                let v = 1.0 - u;
                a * v.powi(3) + 3.0 * u * v * (b * v + c * u) + d * u.powi(3)
            };
            let cubic = Cubic::through(THIRDS.map(value));
            let [mean, rise] = cubic.line();
            let rise = rise.clamp(-mean.max(0.0), mean.max(0.0));
            let [first, last] = cubic.at_nodes(0.0, end);
            let (exact, line) = (0.5 * (first + last) * end, end * (mean + rise * (end - 1.0)));
            let off = (exact - line).abs();
            prop_assert!(off <= 0.25 * mean + 1e-12, "{off} of {mean}");
        }

        #[test]
        fn it_crosses_every_value_of_a_part_once(
            values in prop::array::uniform4(-5.0..5.0f64),
            share in 0.0..=1.0f64,
        ) {
            let cubic = Cubic::through(values);
            let ends = cubic.monotone_parts();
            for part in ends.windows(2) {
                let (a, b) = (cubic.at(part[0]), cubic.at(part[1]));
                let value = a + (b - a) * share;
                let u = cubic.crossing(value, part[0], part[1]);
                prop_assert!(part[0] <= u && u <= part[1]);
                prop_assert!((cubic.at(u) - value).abs() < 1e-11, "{} at {u}", cubic.at(u));
                // Between the ends of a part lies nothing beyond them.
                let within = cubic.at(part[0] + (part[1] - part[0]) * share);
                prop_assert!(within >= a.min(b) - 1e-9 && within <= a.max(b) + 1e-9);
            }
        }
    }

    #[test]
    fn what_is_not_reached_is_crossed_at_an_end() {
        let rising = Cubic::through(THIRDS);
        assert_eq!(rising.crossing(-1.0, 0.0, 1.0), 0.0);
        assert_eq!(rising.crossing(2.0, 0.0, 1.0), 1.0);
        assert_eq!(rising.monotone_parts()[..], [0.0, 1.0]);
    }
}
