//! Passes over the film: the order in which pixels get their rays.

use std::iter::successors;
use std::ops::Range;

use crate::cache::SamplePass;

/// Ratio of the rays that a pixel has after a pass to those before it.
///
/// Unit: none. Derivation: each pass halves the noise.
const GROWTH: u32 = 4;

/// Rays of a pixel in the first of the [`SamplePass`]es.
///
/// Unit: count. Definition: all before the second pass begins.
pub const FIRST_RAYS: u32 = GROWTH;

/// Spacing, in pixels, of those that get their first ray before all do, pass by pass: a render that is cut
/// short early shows the whole film coarsely.
///
/// Unit: pixels. Derivation: from pass to pass shorter by [`GROWTH`]; the first shows a side of 1000
/// pixels by some thirty.
const SPARSE: [u32; 3] = [32, 8, 2];

/// A pass over the film.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pass {
    /// Rays of a pixel before it.
    pub begin: u32,
    /// Rays of a pixel after it.
    pub end: u32,
    /// Spacing along each side, in pixels, of those that get them.
    pub every: u32,
}

impl Pass {
    /// Whether no ray was shot before it.
    pub fn is_first(&self) -> bool {
        self.every == SPARSE[0]
    }
}

/// The passes over a film whose pixels get up to `most` rays.
pub fn passes(most: u32) -> impl Iterator<Item = Pass> {
    let sparse = SPARSE.into_iter().map(|every| Pass { begin: 0, end: 1, every });
    let ends = successors(Some(1_u32), |end| end.checked_mul(GROWTH));
    let ends = ends.take_while(move |end| *end < most).chain([most]);
    let begins = [0].into_iter().chain(ends.clone());
    let whole = begins.zip(ends).map(|(begin, end)| Pass { begin, end, every: 1 });
    sparse.chain(whole).take_while(move |_| most > 0)
}

/// The pass that `sample` of a pixel with up to `rays` rays belongs to. The sparse passes count as part of
/// the first. Where there is a `pilot` of so many rays, that is the first pass, and all other rays are the second.
pub fn sample_pass(sample: u32, rays: u32, pilot: u32) -> SamplePass {
    if pilot > 0 {
        let is_after = sample >= pilot;
        let rays = if is_after { rays.saturating_sub(pilot) } else { pilot };
        return SamplePass { index: is_after.into(), rays, first: 0, shot: rays };
    }
    let index = sample.max(1).ilog(GROWTH);
    let end = |index: u32| GROWTH.checked_pow(index + 1).map_or(rays, |end| end.min(rays));
    let rays = end(index) - index.checked_sub(1).map_or(0, end);
    SamplePass { index, rays, first: 0, shot: rays }
}

/// The samples of a pixel with up to `rays` rays, `pilot` of them a pilot's, that belong to each [`sample_pass`].
pub fn sample_passes(rays: u32, pilot: u32) -> Vec<Range<u32>> {
    let mut passes = Vec::new();
    let mut start = 0;
    while start < rays {
        let end = start + sample_pass(start, rays, pilot).rays;
        passes.push(start..end);
        start = end;
    }
    passes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sample_passes_are_whole_passes() {
        for most in [1, 3, 4, 5, 16, 40, 1000, u32::MAX] {
            let mut shot = 0;
            for (index, pass) in (0..).zip(sample_passes(most, 0)) {
                let rays = pass.len() as u32;
                assert_eq!(
                    [pass.start, pass.end - 1].map(|sample| sample_pass(sample, most, 0)),
                    [SamplePass { index, rays, first: 0, shot: rays }; 2]
                );
                assert_eq!(pass.start, shot);
                shot = pass.end;
                assert!(passes(most).any(|pass| pass.end == shot));
            }
            assert_eq!(shot, most);
        }
    }

    #[test]
    fn a_pilot_is_a_pass_and_all_others_are_one() {
        assert_eq!(sample_passes(64, 4), [0..4, 4..64]);
        assert_eq!(sample_passes(4, 4), [Range { start: 0, end: 4 }]);
        for (pass, index) in [(0..4, 0), (4..64, 1)] {
            let rays = pass.len() as u32;
            for sample in pass {
                let expected = SamplePass { index, rays, first: 0, shot: rays };
                assert_eq!(sample_pass(sample, 64, 4), expected);
            }
        }
    }

    #[test]
    fn passes_grow_to_all_rays() {
        let full = |most| {
            let sparse = |pass: &Pass| pass.every > 1;
            passes(most).skip_while(sparse).map(|pass| pass.end).collect::<Vec<_>>()
        };
        assert_eq!(passes(0).count(), 0);
        assert_eq!(passes(1).map(|pass| pass.every).collect::<Vec<_>>(), [32, 8, 2, 1]);
        assert_eq!(full(1), [1]);
        assert_eq!(full(16), [1, 4, 16]);
        assert_eq!(full(40), [1, 4, 16, 40]);
        assert_eq!(full(u32::MAX).last(), Some(&u32::MAX));
    }
}
