//! Which level of the filter each pixel takes.

use std::ops::{AddAssign, Range};

use glam::{Vec3A, Vec4};
use rayon::prelude::*;

use super::levels::{Candidate, LEVELS};

/// Pixels on each side over which errors, and the light they are relative to, are averaged.
///
/// Unit: pixels. Limit: on the noise of errors: 49 pixels of two halves each tell them to a fifth.
pub(super) const ERROR_RADIUS: usize = 3;

/// Pixels on each side of the region toward whose mean that of the pixels within [`ERROR_RADIUS`] is shrunk.
///
/// Unit: pixels. Limit: on how far pixels decide for others: about the standard deviation of the widest level.
pub(super) const REGION_RADIUS: usize = 8;

/// Variance of the mean of errors of pixels around over that of as many independent ones.
///
/// Unit: none. Limit: on what chance decides: pixels of filtered light share noise, and errors have heavy tails.
const SHARED_NOISE: f32 = 2.0;

/// Pixels on each side over which levels are averaged.
///
/// Unit: pixels. Limit: on seams between levels.
pub(super) const LEVEL_RADIUS: usize = 2;

/// Squared light, over the mean of the pixels around, below which errors are no longer relative.
///
/// Unit: none. Limit: on the weight of pixels that are nearly black.
pub(super) const DARKEST: f32 = 1e-3;

/// Bytes of a pixel that levels are chosen by: errors of all, gains between them, and what those are averaged of.
///
/// Unit: bytes. Derivation: from the sizes of what is held.
pub(super) const GAINS_BYTES: usize =
    (2 * LEVELS as usize + 1) * size_of::<Option<f32>>() + 4 * size_of::<Vec3A>();

/// A component in all pixels, each at the level of least error, W/(m² sr).
#[derive(Debug)]
pub(super) struct Selected {
    /// By both halves.
    pub mean: Vec<Vec3A>,
    /// By each half, and by both where it has no ray.
    pub halves: [Vec<Vec3A>; 2],
}

/// The level of least error of each pixel, between those of these `candidates`, from that of the pixels on.
pub(super) fn best_levels(width: usize, candidates: &[Candidate]) -> Vec<f32> {
    let [raw, .., widest] = candidates else { unreachable!("there are several levels") };
    let scales = scales(width, widest);
    let errors: Vec<_> = candidates.iter().map(|of| relative_errors(of, raw, &scales)).collect();
    let gains: Vec<_> =
        errors.windows(2).map(|pair| narrowing_gains(width, &pair[0], &pair[1])).collect();
    let best = |pixel: usize| {
        // Where no error is known, nothing is averaged.
        if gains.last().is_none_or(|of| of[pixel].is_none()) {
            return 0.0;
        }
        let (mut best, mut total, mut most) = (gains.len(), 0.0, 0.0);
        for (level, of) in gains.iter().enumerate().rev() {
            let Some(gain) = of[pixel] else { break };
            total += gain;
            if total > most {
                (best, most) = (level, total);
            }
        }
        best as f32
    };
    let best: Vec<f32> = (0..scales.len()).into_par_iter().map(best).collect();
    box_means(width, &best, LEVEL_RADIUS)
}

/// The component of these `candidates`, in each pixel at the one of these `levels`.
pub(super) fn select(candidates: &[Candidate], levels: &[f32]) -> Selected {
    let pixels = levels.len();
    let blend = |at: &(dyn Fn(usize, usize) -> Option<Vec3A> + Sync), pixel: usize| {
        let level = levels[pixel];
        let below = (level as usize).min(candidates.len() - 1);
        let above = (below + 1).min(candidates.len() - 1);
        let raw = at(0, pixel);
        let [below, above] = [below, above].map(|level| at(level, pixel).or(raw));
        Some(below?.lerp(above?, level.fract()))
    };
    let of_both = |level: usize, pixel: usize| candidates[level].mean(pixel);
    let mean: Vec<Vec3A> = (0..pixels)
        .into_par_iter()
        .map(|pixel| blend(&of_both, pixel).unwrap_or(Vec3A::ZERO))
        .collect();
    let halves = [0, 1].map(|half| {
        let of_half = |level: usize, pixel: usize| {
            let light = candidates[level].halves[half][pixel];
            (light.w > 0.0).then(|| Vec3A::from_vec4(light))
        };
        let at = |pixel: usize| blend(&of_half, pixel).unwrap_or(mean[pixel]);
        (0..pixels).into_par_iter().map(at).collect()
    });
    Selected { mean, halves }
}

/// By how much the `narrower` of two levels has the smaller [error](relative_errors) in each pixel; `None` where that is
/// not known.
///
/// The mean over the few pixels around is noisy, and alone would choose narrow levels by chance, which leaves spots of noise. It
/// is shrunk toward the mean of a larger region, as far as its variance explains the difference of the two (James and
/// Stein 1961, "Estimation with Quadratic Loss").
fn narrowing_gains(
    width: usize,
    narrower: &[Option<f32>],
    wider: &[Option<f32>],
) -> Vec<Option<f32>> {
    // Number, sum and sum of squares.
    let sums = |(narrower, wider): (&Option<f32>, &Option<f32>)| {
        let gain = narrower.zip(*wider).map(|(narrower, wider)| wider - narrower);
        gain.map_or(Vec3A::ZERO, |gain| Vec3A::new(1.0, gain, gain * gain))
    };
    let gains: Vec<Vec3A> = narrower.par_iter().zip(wider).map(sums).collect();
    let local = box_sums(width, &gains, ERROR_RADIUS);
    let regional = box_sums(width, &gains, REGION_RADIUS);
    let shrunk = |(local, regional): (&Vec3A, &Vec3A)| {
        let [count, sum, squares] = local.to_array();
        if count == 0.0 {
            return None;
        }
        let (mean, regional) = (sum / count, regional.y / regional.x);
        let variance = SHARED_NOISE * (squares / count - mean * mean).max(0.0) / count;
        let difference = mean - regional;
        let kept = 1.0 - variance / (difference * difference);
        // Where both means are the same it is not a number.
        Some(if kept > 0.0 { regional + kept * difference } else { regional })
    };
    local.par_iter().zip(&regional).map(shrunk).collect()
}

/// Squared light relative to which errors of pixels are, by the `widest` candidate.
pub(super) fn scales(width: usize, widest: &Candidate) -> Vec<f32> {
    let pixels = widest.halves[0].len();
    let typical = |pixel: usize| widest.mean(pixel).map_or(0.0, Vec3A::length_squared);
    let typical: Vec<f32> = (0..pixels).map(typical).collect();
    let around = box_means(width, &typical, ERROR_RADIUS);
    typical.iter().zip(around).map(|(typical, around)| typical + DARKEST * around).collect()
}

/// The squared error of the mean of both halves of a candidate in each pixel, relative to `scales`; `None` where it is
/// unknown.
///
/// The error of one filtered half against the other, raw one, less the noise of the latter, is that of the filtered
/// half, its bias included; half of the filtered halves' own noise goes from that to their mean's. Where pixels have
/// rays in one half alone, the raw half's noise stays in, the same for all candidates, and the raw candidate's error is unknown.
pub(super) fn relative_errors(
    candidate: &Candidate,
    raw: &Candidate,
    scales: &[f32],
) -> Vec<Option<f32>> {
    let squared = |x: Vec4, y: Vec4| (Vec3A::from_vec4(x) - Vec3A::from_vec4(y)).length_squared();
    let error = |(pixel, &scale): (usize, &f32)| {
        let [[a, b], [fa, fb]] =
            [raw, candidate].map(|of| [0, 1].map(|half| of.halves[half][pixel]));
        if scale == 0.0 || fa.w == 0.0 || fb.w == 0.0 {
            return None;
        }
        let of_halves = match (a.w > 0.0, b.w > 0.0) {
            (true, true) => squared(fa, b) + squared(fb, a) - squared(a, b),
            (true, false) => 2.0 * squared(fb, a),
            (false, true) => 2.0 * squared(fa, b),
            (false, false) => return None,
        };
        let error = 0.5 * (of_halves - 0.5 * squared(fa, fb));
        // Squares of light near the largest number of an f32 are infinite.
        error.is_finite().then_some(error / scale)
    };
    scales.par_iter().enumerate().map(error).collect()
}

/// Means over squares of `radius` pixels to each side, as far as there are pixels.
pub(super) fn box_means(width: usize, values: &[f32], radius: usize) -> Vec<f32> {
    let height = values.len() / width;
    let [columns, rows] = [width, height].map(|count| {
        let within = |at: usize| window(at, radius, count).len() as f32;
        (0..count).map(within).collect::<Vec<f32>>()
    });
    let mut means = box_sums(width, values, radius);
    for (row, rows) in means.chunks_exact_mut(width).zip(rows) {
        row.iter_mut().zip(&columns).for_each(|(mean, columns)| *mean /= rows * columns);
    }
    means
}

/// Sums over squares of `radius` pixels to each side. They do not depend on where the picture begins.
pub(super) fn box_sums<T>(width: usize, values: &[T], radius: usize) -> Vec<T>
where
    T: Copy + Default + AddAssign + Send + Sync,
{
    let height = values.len() / width;
    let along_row = |(index, sum): (usize, &mut T)| {
        let (row, column) = (index / width * width, index % width);
        let within = window(column, radius, width);
        values[row + within.start..row + within.end].iter().for_each(|value| *sum += *value);
    };
    let mut rows = vec![T::default(); values.len()];
    rows.par_iter_mut().enumerate().for_each(along_row);
    let mut sums = vec![T::default(); values.len()];
    sums.par_chunks_exact_mut(width).enumerate().for_each(|(row, sums)| {
        for near in window(row, radius, height) {
            let near = &rows[near * width..(near + 1) * width];
            sums.iter_mut().zip(near).for_each(|(sum, value)| *sum += *value);
        }
    });
    sums
}

/// Those of `count` places in a line that are at most `radius` from the one `at`.
fn window(at: usize, radius: usize, count: usize) -> Range<usize> {
    at.saturating_sub(radius)..(at + radius + 1).min(count)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Stage, Stream};

    /// Gains of mean -.15 and standard deviation 1: the local mean is positive by chance in 15 of 100 pixels, the shrunk one in
    /// fewer than 3. A square where narrow levels are better by far keeps its gain. The bounds are 5, 14 and 7 standard
    /// deviations away: one false alarm in a million at this fixed seed.
    #[test]
    fn chance_does_not_choose_levels() {
        const SIDE: usize = 512;
        let mut rng = Stream::new(31, Stage::Test, 0, 0);
        let mut normal = || (0..12).map(|_| rng.uniform() as f32).sum::<f32>() - 6.0;
        let is_within = |pixel: usize, [from, to]: [usize; 2]| {
            [pixel % SIDE, pixel / SIDE].iter().all(|at| (from..to).contains(at))
        };
        let gain = |pixel| normal() + if is_within(pixel, [40, 56]) { 5.0 } else { -0.15 };
        let wider: Vec<f32> = (0..SIDE * SIDE).map(gain).collect();
        let local = box_means(SIDE, &wider, ERROR_RADIUS);
        let known: Vec<Option<f32>> = wider.into_iter().map(Some).collect();
        let shrunk = narrowing_gains(SIDE, &vec![Some(0.0); SIDE * SIDE], &known);
        let far = || (0..SIDE * SIDE).filter(|pixel| !is_within(*pixel, [0, 80]));
        let share = |is: &dyn Fn(usize) -> bool| {
            far().filter(|pixel| is(*pixel)).count() as f32 / far().count() as f32
        };
        let [local_share, shrunk_share] =
            [share(&|pixel| local[pixel] > 0.0), share(&|pixel| shrunk[pixel] > Some(0.0))];
        assert!(local_share > 0.1 && shrunk_share < 0.03, "{local_share} and {shrunk_share}");
        for pixel in (0..SIDE * SIDE).filter(|pixel| is_within(*pixel, [43, 53])) {
            let found = shrunk[pixel].unwrap();
            assert!((found - 5.0).abs() < 1.0, "{found}");
        }
    }

    /// Where no error is known nothing is averaged, and where one half has rays in turn errors are known of all but the raw one.
    #[test]
    fn levels_follow_from_what_is_known() {
        const SIDE: usize = 8;
        let light = |known: f32| vec![Vec4::new(1.0, 1.0, 1.0, known); SIDE * SIDE];
        let unknown = Candidate { halves: [light(0.0), light(0.0)] };
        let levels = best_levels(SIDE, &vec![unknown; 5]);
        assert!(levels.iter().all(|level| *level == 0.0), "{levels:?}");
        let by_turns = |half: usize| {
            let of = |pixel: usize| Vec4::new(1.0, 1.0, 1.0, ((pixel + half) % 2) as f32);
            (0..SIDE * SIDE).map(of).collect()
        };
        let raw = Candidate { halves: [by_turns(0), by_turns(1)] };
        let filtered = Candidate { halves: [light(1.0), light(1.0)] };
        let all = [&raw, &filtered, &filtered, &filtered, &filtered].map(Clone::clone);
        let levels = best_levels(SIDE, &all);
        assert!(levels.iter().all(|level| *level == 4.0), "{levels:?}");
    }
}
