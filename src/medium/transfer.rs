//! Transfer functions: what a grid's value stands for, after interpolation.
//!
//! A value is remapped to a place, as a Map Range node does, and a ramp gives a value to that place,
//! as a Color Ramp node does. Both together are one piecewise-linear function with jumps.

use std::ops::ControlFlow;

use crate::math::{Rgb, Spectrum, is_grey};

/// How far a remapped place may be off where a gamma is made of straight lines.
pub const GAMMA_TOLERANCE: f64 = 1e-4;

/// Gammas that can be asked for.
const GAMMAS: std::ops::RangeInclusive<f64> = 0.05..=20.0;

/// From a value to a place on a ramp: ((value - min) / (max - min))^gamma.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Remap {
    /// The value whose place is 0.
    pub min: f64,
    /// The value whose place is 1; above `min`.
    pub max: f64,
    /// Whether places end at 0 and 1; else they go on beyond them.
    pub clamp: bool,
    /// The exponent, from 0.05 to 20; other than 1 it has no places below 0, and straight lines
    /// stand for it to [`GAMMA_TOLERANCE`].
    pub gamma: f64,
}

impl Default for Remap {
    /// A value is its own place.
    fn default() -> Self {
        Self { min: 0.0, max: 1.0, clamp: false, gamma: 1.0 }
    }
}

impl Remap {
    fn check(&self) -> Result<(), String> {
        let Self { min, max, gamma, .. } = *self;
        if !(min.is_finite() && max.is_finite() && min < max) {
            return Err(format!("values from {min} to {max}; give a smaller number first"));
        }
        if !GAMMAS.contains(&gamma) {
            let (least, most) = (GAMMAS.start(), GAMMAS.end());
            return Err(format!("a gamma of {gamma}; give a number from {least} to {most}"));
        }
        Ok(())
    }

    /// The value at a place that is not below 0 where there is a gamma.
    fn value_of(&self, place: f64) -> f64 {
        let linear = if self.gamma == 1.0 { place } else { place.powf(1.0 / self.gamma) };
        self.min + (self.max - self.min) * linear
    }

    /// Places between `a` and `b` at which straight lines meet that are as near to the power as
    /// [`GAMMA_TOLERANCE`], in their order.
    fn subdivide(&self, a: f64, b: f64, places: &mut Vec<f64>) {
        let gamma = self.gamma;
        let [from, to] = [a, b].map(|place| place.powf(1.0 / gamma));
        let slope = (b - a) / (to - from);
        // Where the power runs along the chord it is farthest from it.
        let farthest = (slope / gamma).powf(1.0 / (gamma - 1.0));
        let place = farthest.powf(gamma);
        let off = (place - (a + slope * (farthest - from))).abs();
        if gamma != 1.0 && off > GAMMA_TOLERANCE && place > a && place < b {
            self.subdivide(a, place, places);
            places.push(place);
            self.subdivide(place, b, places);
        }
    }
}

/// A piecewise-linear function of a grid's value, with jumps: never below 0, finite, constant below
/// its first knot. At a jump it has the value above.
#[derive(Debug, Clone, PartialEq)]
pub struct Transfer<V> {
    knots: Vec<Knot<V>>,
    /// Rise per unit beyond the last knot.
    beyond: V,
}

/// Where straight lines meet.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Knot<V> {
    at: f64,
    below: V,
    above: V,
}

/// A straight line: `value` at `at`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line<V> {
    at: f64,
    value: V,
    slope: V,
}

impl<V: Spectrum> Line<V> {
    /// The value at `v`.
    #[inline]
    pub(super) fn value(&self, v: f64) -> V {
        self.value + self.slope * (v - self.at)
    }
}

impl<V: Spectrum> Transfer<V> {
    /// The ramp through `stops` (place and value, places in ascending order), constant before the
    /// first and after the last, of values as `remap` places them. Two stops at one place make a
    /// jump.
    ///
    /// # Errors
    /// In words, where there is no stop, places go back or values are negative or not finite.
    pub fn new(remap: Remap, stops: &[(f64, V)]) -> Result<Self, String> {
        remap.check()?;
        let (Some(first), Some(last)) = (stops.first(), stops.last()) else {
            return Err("no stops; give at least one".into());
        };
        for &(place, value) in stops {
            let is_right = |channel| {
                let value = value.channel(channel);
                value.is_finite() && value >= 0.0
            };
            if !place.is_finite() || !(0..V::CHANNELS).all(is_right) {
                return Err(format!(
                    "the value {:?} at {place}; give numbers from 0 on",
                    value.rgb().to_array()
                ));
            }
        }
        if let Some(pair) = stops.windows(2).find(|pair| pair[0].0 > pair[1].0) {
            return Err(format!(
                "a stop at {} after one at {}; give them in ascending order",
                pair[1].0, pair[0].0
            ));
        }
        let mut ramp = Self { knots: Vec::new(), beyond: V::ZERO };
        for &(at, value) in stops {
            match ramp.knots.last_mut().filter(|knot| knot.at == at) {
                Some(knot) => knot.above = value,
                None => ramp.knots.push(Knot { at, below: value, above: value }),
            }
        }
        let low = if remap.clamp || remap.gamma != 1.0 { 0.0 } else { first.0 };
        let high = if remap.clamp { 1.0 } else { last.0.max(low) };
        Ok(ramp.of_places(&remap, low, high))
    }

    /// This function of places, those below `low` and above `high` taken as these, as a function of
    /// the values that have the places.
    fn of_places(&self, remap: &Remap, low: f64, high: f64) -> Self {
        let end = |at| Knot { at, below: self.at(at), above: self.at(at) };
        let inner = self.knots.iter().filter(|knot| knot.at > low && knot.at < high).copied();
        let at_high = self.knots.iter().find(|knot| knot.at == high);
        let mut borders: Vec<Knot<V>> = std::iter::once(end(low)).chain(inner).collect();
        if high > low {
            borders.push(Knot { below: at_high.map_or(self.at(high), |k| k.below), ..end(high) });
        }
        if !(remap.clamp || remap.gamma != 1.0)
            && let Some(first) = self.knots.first()
        {
            borders[0].below = first.below;
        }
        let mut places = Vec::new();
        let mut knots = vec![borders[0]];
        for pair in borders.windows(2) {
            places.clear();
            remap.subdivide(pair[0].at, pair[1].at, &mut places);
            knots.extend(places.iter().map(|at| end(*at)));
            knots.push(pair[1]);
        }
        for knot in &mut knots {
            knot.at = remap.value_of(knot.at);
        }
        knots.dedup_by(|next, knot| {
            let is_same = next.at <= knot.at; // closer than rounding can tell
            if is_same {
                knot.above = next.above;
            }
            is_same
        });
        Self { knots, beyond: V::ZERO }
    }

    /// What the value `v` stands for.
    #[inline]
    pub fn at(&self, v: f64) -> V {
        self.line(self.after(v)).value(v)
    }

    /// How many knots are at or below `v`: the number of the line that holds there.
    #[inline]
    fn after(&self, v: f64) -> usize {
        self.knots.partition_point(|knot| knot.at <= v)
    }

    /// The line before the knot `index`, or after the last.
    fn line(&self, index: usize) -> Line<V> {
        let above = self.knots.get(index);
        match (index.checked_sub(1).map(|below| &self.knots[below]), above) {
            (Some(a), Some(b)) => {
                let slope = (b.below - a.above) / (b.at - a.at);
                Line { at: a.at, value: a.above, slope }
            }
            (Some(last), None) => Line { at: last.at, value: last.above, slope: self.beyond },
            (None, first) => {
                let (at, value) = first.map_or((0.0, V::ZERO), |first| (first.at, first.below));
                Line { at, value, slope: V::ZERO }
            }
        }
    }

    /// Calls `f` with values among which are, in each channel, the least and the greatest that any
    /// number from `low` to `high` stands for.
    pub(super) fn for_each_extreme(&self, [low, high]: [f64; 2], mut f: impl FnMut(V)) {
        f(self.at(low));
        f(self.at(high));
        let (first, end) = (self.after(low), self.after(high));
        for knot in &self.knots[first.min(end)..end] {
            f(knot.below);
            f(knot.above);
        }
    }

    /// The largest channel of what any number from `low` to `high` stands for.
    pub fn peak(&self, range: [f64; 2]) -> f64 {
        let mut peak = 0.0f64;
        self.for_each_extreme(range, |value| peak = peak.max(value.max_element()));
        peak
    }

    /// The line that holds for all numbers from `low` to `high`, where one does.
    pub(super) fn only_line(&self, [low, high]: [f64; 2]) -> Option<Line<V>> {
        let index = self.after(low);
        (index == self.after(high)).then(|| self.line(index))
    }

    /// Calls `f` for each part between `start` and `end` of a piece of a ray along which the value
    /// only rises or only falls, from `from` to `to`, with the line that holds there; `crossing`
    /// says where, between two places, the value is a knot's.
    pub(super) fn for_each_line(
        &self,
        (start, end): (f64, f64),
        [from, to]: [f64; 2],
        crossing: impl Fn(f64, f64, f64) -> f64,
        f: &mut impl FnMut(f64, f64, Line<V>) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let (low, high) = (from.min(to), from.max(to));
        let first = self.after(low);
        let last = self.knots.partition_point(|knot| knot.at < high).max(first);
        let mut here = start;
        for passed in 0..last - first {
            let rises = from <= to;
            let (line, knot) = if rises {
                (first + passed, first + passed)
            } else {
                (last - passed, last - passed - 1)
            };
            let there = crossing(self.knots[knot].at, here, end);
            if there > here {
                f(here, there, self.line(line))?;
                here = there;
            }
        }
        if end > here {
            let line = if from <= to { last } else { first };
            f(here, end, self.line(line))?;
        }
        ControlFlow::Continue(())
    }
}

impl Transfer<f64> {
    /// Values as `remap` places them, without a ramp; 0 for those below 0.
    ///
    /// # Errors
    /// In words, where `remap` cannot be, or has a gamma and no end.
    pub fn remapped(remap: Remap) -> Result<Self, String> {
        if remap.gamma != 1.0 && !remap.clamp {
            return Err("a gamma without clamp; give `clamp = true`, or a ramp".into());
        }
        let mut transfer = Self::new(remap, &[(0.0, 0.0), (1.0, 1.0)])?;
        if !remap.clamp {
            transfer.beyond = 1.0 / (remap.max - remap.min);
        }
        Ok(transfer)
    }

    /// Bounds of what numbers from `low` to `high` stand for.
    pub fn range(&self, range: [f64; 2]) -> [f64; 2] {
        let mut found = [f64::INFINITY, f64::NEG_INFINITY];
        self.for_each_extreme(range, |v| found = [found[0].min(v), found[1].max(v)]);
        found
    }
}

impl Transfer<Rgb> {
    /// Whether all that values can stand for is grey.
    pub fn is_grey(&self) -> bool {
        let grey = |knot: &Knot<Rgb>| is_grey(knot.below) && is_grey(knot.above);
        self.knots.iter().all(grey) && is_grey(self.beyond)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn jump() -> Transfer<f64> {
        let stops = [(0.0, 0.0), (0.25, 1.0), (0.5, 1.0), (0.5, 3.0), (1.0, 2.0)];
        let remap = Remap { min: 1.0, max: 5.0, clamp: true, gamma: 1.0 };
        Transfer::new(remap, &stops).unwrap()
    }

    #[test]
    fn a_ramp_is_linear_between_its_stops() {
        let transfer = jump();
        for (v, expected) in [
            (-9.0, 0.0),
            (1.0, 0.0),
            (1.5, 0.5),
            (2.0, 1.0),
            (2.999, 1.0),
            (3.0, 3.0),
            (4.0, 2.5),
            (5.0, 2.0),
            (9.0, 2.0),
        ] {
            assert!((transfer.at(v) - expected).abs() < 1e-12, "{v}: {}", transfer.at(v));
        }
    }

    #[test]
    fn without_clamp_stops_beyond_0_and_1_count() {
        let stops = [(-1.0, 4.0), (0.0, 0.0), (2.0, 6.0)];
        let open = Transfer::new(Remap::default(), &stops).unwrap();
        let closed = Transfer::new(Remap { clamp: true, ..Remap::default() }, &stops).unwrap();
        for (v, a, b) in [(-2.0, 4.0, 0.0), (-0.5, 2.0, 0.0), (0.5, 1.5, 1.5), (3.0, 6.0, 3.0)] {
            assert_eq!((open.at(v), closed.at(v)), (a, b), "{v}");
        }
        let linear = Transfer::remapped(Remap { min: 1.0, max: 3.0, ..Remap::default() }).unwrap();
        for (v, expected) in [(0.0, 0.0), (1.0, 0.0), (2.0, 0.5), (3.0, 1.0), (7.0, 3.0)] {
            assert_eq!(linear.at(v), expected, "{v}");
        }
    }

    #[test]
    fn what_cannot_be_is_told() {
        let new = |remap, stops: &[(f64, f64)]| Transfer::new(remap, stops).unwrap_err();
        let remap = Remap::default();
        assert!(new(remap, &[]).contains("no stops"));
        assert!(new(remap, &[(0.0, -1.0)]).contains("from 0 on"));
        assert!(new(remap, &[(1.0, 1.0), (0.0, 1.0)]).contains("ascending"));
        assert!(new(Remap { min: 1.0, ..remap }, &[(0.0, 1.0)]).contains("smaller number"));
        assert!(new(Remap { gamma: 0.0, ..remap }, &[(0.0, 1.0)]).contains("gamma"));
        let endless = Transfer::remapped(Remap { gamma: 2.0, ..remap }).unwrap_err();
        assert!(endless.contains("clamp"), "{endless}");
    }

    proptest! {
        #[test]
        fn a_gamma_is_met_to_its_tolerance(gamma in 0.05..20.0f64, v in -0.2..1.2f64) {
            let remap = Remap { clamp: true, gamma, ..Remap::default() };
            let transfer = Transfer::remapped(remap).unwrap();
            let expected = v.clamp(0.0, 1.0).powf(gamma);
            prop_assert!((transfer.at(v) - expected).abs() <= 1.001 * GAMMA_TOLERANCE);
            prop_assert!(transfer.knots.len() < 500, "{} knots", transfer.knots.len());
        }

        #[test]
        fn bounds_hold(a in -1.0..7.0f64, b in -1.0..7.0f64, share in 0.0..=1.0f64) {
            let transfer = jump();
            let [low, high] = transfer.range([a.min(b), a.max(b)]);
            let value = transfer.at(a + (b - a) * share);
            prop_assert!(low <= value + 1e-12 && value <= high + 1e-12, "{value}");
            prop_assert_eq!(transfer.peak([a.min(b), a.max(b)]), high);
        }
    }
}
