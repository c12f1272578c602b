//! Passes of rays: which rays of a pixel read cells together, and the gathers that they have of one.

use std::ops::Range;

use super::directed_rays::DirectedRays;

/// Most gathers of a cell in one pass: they take less than a second, and the Sobol points of their
/// first deflections last for as many.
///
/// Unit: count. Limit: on the time of one cell.
pub(super) const MAX_GATHERS: f64 = 65_536.0;

/// Some of the rays of each pixel, which are shot together before others are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SamplePass {
    /// Number of passes before.
    pub index: u32,
    /// Rays of a pixel that belong to it, at most.
    pub rays: u32,
    /// How many of them other renders shoot before those of this one.
    pub first: u32,
    /// How many of them this render shoots.
    pub shot: u32,
}

impl SamplePass {
    /// Whether other renders shoot some of its rays.
    pub(super) const fn is_shared(&self) -> bool {
        self.shot < self.rays
    }

    /// The number of gathers nearest to `all` that can be shared evenly, at least one each, among renders that shoot as many rays
    /// as this one. Their pictures have the same weight, so that one with fewer gathers than others would add noise.
    pub(super) fn even(&self, all: f64) -> u32 {
        let renders = (f64::from(self.rays.max(1)) / f64::from(self.shot.max(1))).round();
        let each = (all / renders).round().min((MAX_GATHERS / renders).floor());
        (each.max(1.0) * renders) as u32
    }

    /// The numbers of the gathers that its rays have of `all` in a cell: in proportion to the rays that are shot, and at
    /// least one.
    pub(super) fn gathers(&self, all: u32) -> Range<u32> {
        let before =
            |rays: u32| (u64::from(all) * u64::from(rays) / u64::from(self.rays.max(1))) as u32;
        let start = before(self.first).min(all.saturating_sub(1));
        start..before(self.first + self.shot).max(start + 1)
    }
}

/// Rays that read cells.
#[derive(Debug, Clone, Copy)]
pub struct ReadingRays<'a> {
    /// Their pass.
    pub pass: SamplePass,
    /// Where a director gave rays, those of all pixels.
    pub directed: Option<&'a DirectedRays>,
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// Renders that share the rays of a pass have the gathers of a cell once between them, where each can have one.
        #[test]
        fn gathers_are_shared_as_rays_are(all in 1_u32..100_000, shares in prop::collection::vec(1_u32..50, 1..12)) {
            let rays = shares.iter().sum();
            let (mut first, mut made) = (0, 0);
            let mut numbers = Vec::new();
            for shot in shares.iter().copied() {
                let own = SamplePass { index: 0, rays, first, shot }.gathers(all);
                prop_assert!(!own.is_empty() && own.end <= all);
                made += own.len() as u32;
                first += shot;
                numbers.push(own);
            }
            prop_assert_eq!((numbers[0].start, numbers.last().map(|own| own.end)), (0, Some(all)));
            if shares.iter().all(|shot| all * shot >= rays) {
                prop_assert_eq!(made, all);
                prop_assert!(numbers.windows(2).all(|pair| pair[0].end == pair[1].start));
            }
            let whole = SamplePass { index: 2, rays, first: 0, shot: rays };
            prop_assert_eq!(whole.gathers(all), 0..all);
        }

        /// Renders with as many rays have as many gathers of a cell, each of them once, and in all of them together hardly more or
        /// fewer than in one render.
        #[test]
        fn even_parts_have_as_many_gathers(
            all in 4.0..=MAX_GATHERS, shot in 1_u32..50, renders in 1_u32..40,
        ) {
            let pass = |first| SamplePass { index: 0, rays: renders * shot, first, shot };
            let even = pass(0).even(all);
            prop_assert!(f64::from(even) <= MAX_GATHERS);
            let each = even / renders;
            prop_assert!(each == 1 || f64::from(even) - all >= -f64::from(renders));
            prop_assert!(each == 1 || f64::from(even) - all <= 0.5 * f64::from(renders));
            for render in 0..renders {
                prop_assert_eq!(pass(render * shot).gathers(even), render * each..(render + 1) * each);
            }
        }
    }
}
