//! Which level of the filter each pixel takes.

use std::ops::{AddAssign, Range};

use glam::{Vec3A, Vec4};
use rayon::prelude::*;

use super::levels::{Candidate, LEVELS};

/// Pixels on each side over which errors, and the light they are relative to, are averaged.
///
/// Unit: pixels. Limit: on the noise of errors: 49 pixels of two halves each tell them to a fifth.
pub(super) const ERROR_RADIUS: usize = 3;

/// Pixels on each side over which errors are averaged to which those of few pixels are drawn.
///
/// Unit: pixels. Limit: on how far pixels decide for others: about the standard deviation of the widest level.
pub(super) const FAR_RADIUS: usize = 8;

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
        let known =
            gains.iter().enumerate().rev().map_while(|(level, of)| Some((level, of[pixel]?)));
        // Where no error is known nothing is averaged.
        let (mut gain, mut most, mut best) = (0.0, 0.0, None);
        for (level, of_level) in known {
            best = best.or(Some(gains.len()));
            gain += of_level;
            if gain > most {
                (most, best) = (gain, Some(level));
            }
        }
        best.unwrap_or(0) as f32
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
/// Few pixels around tell little of it: so far as their mean differs by chance from that of many around those, it is drawn
/// to the latter (shrinkage by James and Stein 1961, "Estimation with Quadratic Loss"). Otherwise chance would choose narrow
/// levels here and there, where noise stays in spots.
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
    let near = box_sums(width, &gains, ERROR_RADIUS);
    let far = box_sums(width, &gains, FAR_RADIUS);
    let drawn = |(near, far): (&Vec3A, &Vec3A)| {
        let [count, sum, squares] = near.to_array();
        if count == 0.0 {
            return None;
        }
        let (mean, far) = (sum / count, far.y / far.x);
        let variance = SHARED_NOISE * (squares / count - mean * mean).max(0.0) / count;
        let off = mean - far;
        let kept = 1.0 - variance / (off * off);
        // Where both are the same it is not a number.
        Some(if kept > 0.0 { far + kept * off } else { far })
    };
    near.par_iter().zip(&far).map(drawn).collect()
}

/// Squared light relative to which errors of pixels are, by the `widest` candidate.
pub(super) fn scales(width: usize, widest: &Candidate) -> Vec<f32> {
    let pixels = widest.halves[0].len();
    let typical = |pixel: usize| widest.mean(pixel).map_or(0.0, Vec3A::length_squared);
    let typical: Vec<f32> = (0..pixels).map(typical).collect();
    let around = box_means(width, &typical, ERROR_RADIUS);
    typical.iter().zip(around).map(|(typical, around)| typical + DARKEST * around).collect()
}

/// The squared error of the mean of both halves of a candidate in each pixel, relative to `scales`; `None` where no half tells
/// it.
///
/// The error of one filtered half against the other, raw one, less the noise of the latter, is that of the filtered
/// half, its bias included; half of the filtered halves' own noise goes from that to their mean's. Where pixels have
/// rays in one half alone, noise of the raw half stays in, which is the same for all candidates; the raw one itself is not told.
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

    const SIDE: usize = 64;

    /// Pixels of which each tells a gain of -.15 with a standard deviation of 1: 49 of them are positive by chance in 15 of 100
    /// pixels, what they are drawn to in less than 3. A square where narrow levels are better by far stays as it is.
    #[test]
    fn chance_does_not_choose_levels() {
        let mut rng = Stream::new(31, Stage::Test, 0, 0);
        let mut normal = || (0..12).map(|_| rng.uniform() as f32).sum::<f32>() - 6.0;
        let is_within = |pixel: usize, [from, to]: [usize; 2]| {
            [pixel % SIDE, pixel / SIDE].iter().all(|at| (from..to).contains(at))
        };
        let gain = |pixel| normal() + if is_within(pixel, [40, 56]) { 5.0 } else { -0.15 };
        let wider: Vec<f32> = (0..SIDE * SIDE).map(gain).collect();
        let by_near = box_means(SIDE, &wider, ERROR_RADIUS);
        let known: Vec<Option<f32>> = wider.into_iter().map(Some).collect();
        let drawn = narrowing_gains(SIDE, &vec![Some(0.0); SIDE * SIDE], &known);
        let pixels = |span| (0..SIDE * SIDE).filter(move |pixel| is_within(*pixel, span));
        let far = || pixels([0, 32]);
        let share = |is: &dyn Fn(usize) -> bool| {
            far().filter(|pixel| is(*pixel)).count() as f32 / far().count() as f32
        };
        let [near, drawn_far] =
            [share(&|pixel| by_near[pixel] > 0.0), share(&|pixel| drawn[pixel] > Some(0.0))];
        assert!(near > 0.1 && drawn_far < 0.03, "{near} and {drawn_far}");
        for pixel in pixels([43, 53]) {
            let found = drawn[pixel].unwrap();
            assert!((found - 5.0).abs() < 1.0, "{found}");
        }
    }

    /// Where no error is known nothing is averaged, and where one half has rays in turn errors are known of all but the first.
    #[test]
    fn levels_follow_from_what_is_known() {
        let light = |known: f32| vec![glam::Vec4::new(1.0, 1.0, 1.0, known); SIDE];
        let unknown = Candidate { halves: [light(0.0), light(0.0)] };
        let levels = best_levels(8, &vec![unknown; 5]);
        assert!(levels.iter().all(|level| *level == 0.0), "{levels:?}");
        let by_turns = |half: usize| {
            let of = |pixel: usize| glam::Vec4::new(1.0, 1.0, 1.0, ((pixel + half) % 2) as f32);
            (0..SIDE).map(of).collect()
        };
        let raw = Candidate { halves: [by_turns(0), by_turns(1)] };
        let filtered = Candidate { halves: [light(1.0), light(1.0)] };
        let all = [&raw, &filtered, &filtered, &filtered, &filtered].map(Clone::clone);
        let levels = best_levels(8, &all);
        assert!(levels.iter().all(|level| *level == 4.0), "{levels:?}");
    }
}
