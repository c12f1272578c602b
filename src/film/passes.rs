//! Passes over the film: the order in which pixels get their rays.

use std::iter::successors;

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
/// the first.
pub fn sample_pass(sample: u32, rays: u32) -> SamplePass {
    let index = sample.max(1).ilog(GROWTH);
    let end = |index: u32| GROWTH.checked_pow(index + 1).map_or(rays, |end| end.min(rays));
    let rays = end(index) - index.checked_sub(1).map_or(0, end);
    SamplePass { index, rays, first: 0, shot: rays }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sample_passes_are_whole_passes() {
        for most in [1, 3, 4, 5, 16, 40, 1000, u32::MAX] {
            let mut shot = 0;
            for index in 0.. {
                let SamplePass { rays, .. } = sample_pass(shot, most);
                assert_eq!(
                    [sample_pass(shot, most), sample_pass(shot + rays - 1, most)],
                    [SamplePass { index, rays, first: 0, shot: rays }; 2]
                );
                shot += rays;
                assert!(passes(most).any(|pass| pass.end == shot));
                if shot == most {
                    break;
                }
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
