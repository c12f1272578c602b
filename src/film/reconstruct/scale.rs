//! Which level of the filter each pixel takes.

use std::ops::{AddAssign, Range};

use glam::{Vec3A, Vec4};
use rayon::prelude::*;

use super::levels::Candidate;

/// Pixels on each side over which errors, and the light they are relative to, are averaged.
///
/// Unit: pixels. Limit: on the noise of errors: 49 pixels of two halves each tell them to a fifth.
pub(super) const ERROR_RADIUS: usize = 3;

/// Pixels on each side over which levels are averaged.
///
/// Unit: pixels. Limit: on seams between levels.
pub(super) const LEVEL_RADIUS: usize = 2;

/// Squared light, over the mean of the pixels around, below which errors are no longer relative.
///
/// Unit: none. Limit: on the weight of pixels that are nearly black.
pub(super) const DARKEST: f32 = 1e-3;

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
    let errors: Vec<Vec<f32>> =
        candidates.iter().map(|of| errors(width, of, raw, &scales)).collect();
    let pixels = scales.len();
    let best = |pixel: usize| {
        let levels = 0..candidates.len();
        let error = |level: &usize| errors[*level][pixel];
        levels.min_by(|a, b| error(a).total_cmp(&error(b))).unwrap_or(0) as f32
    };
    let best: Vec<f32> = (0..pixels).into_par_iter().map(best).collect();
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

/// The [relative errors](relative_errors) of a candidate, averaged over neighbours.
fn errors(width: usize, candidate: &Candidate, raw: &Candidate, scales: &[f32]) -> Vec<f32> {
    // Sum and number of those that both halves tell, and of those that one does.
    let by_kind = |error: Option<(f32, bool)>| match error {
        Some((error, true)) => Vec4::new(error, 1.0, 0.0, 0.0),
        Some((error, false)) => Vec4::new(0.0, 0.0, error, 1.0),
        None => Vec4::ZERO,
    };
    let errors: Vec<Vec4> =
        relative_errors(candidate, raw, scales).into_iter().map(by_kind).collect();
    let mean = |of_both: Vec4| {
        let [whole, wholes, partial, partials] = of_both.to_array();
        let (sum, count) = if wholes > 0.0 { (whole, wholes) } else { (partial, partials) };
        if count > 0.0 { sum / count } else { f32::INFINITY }
    };
    box_sums(width, &errors, ERROR_RADIUS).into_iter().map(mean).collect()
}

/// Squared light relative to which errors of pixels are, by the `widest` candidate.
pub(super) fn scales(width: usize, widest: &Candidate) -> Vec<f32> {
    let pixels = widest.halves[0].len();
    let typical = |pixel: usize| widest.mean(pixel).map_or(0.0, Vec3A::length_squared);
    let typical: Vec<f32> = (0..pixels).map(typical).collect();
    let around = box_means(width, &typical, ERROR_RADIUS);
    typical.iter().zip(around).map(|(typical, around)| typical + DARKEST * around).collect()
}

/// The squared error of the mean of both halves of a candidate in each pixel, relative to `scales`, and
/// whether both halves tell it; `None` where neither does.
///
/// The error of one filtered half against the other, raw one, less the noise of the latter, is that of the filtered
/// half, its bias included; half of the filtered halves' own noise goes from that to their mean's. Where pixels have
/// rays in one half alone, noise of the raw half stays in, and all but the raw candidate can be compared.
pub(super) fn relative_errors(
    candidate: &Candidate,
    raw: &Candidate,
    scales: &[f32],
) -> Vec<Option<(f32, bool)>> {
    let squared = |x: Vec4, y: Vec4| (Vec3A::from_vec4(x) - Vec3A::from_vec4(y)).length_squared();
    let error = |(pixel, &scale): (usize, &f32)| {
        let [[a, b], [fa, fb]] =
            [raw, candidate].map(|of| [0, 1].map(|half| of.halves[half][pixel]));
        if scale == 0.0 || fa.w == 0.0 || fb.w == 0.0 {
            return None;
        }
        let error = match (a.w > 0.0, b.w > 0.0) {
            (true, true) => {
                let across = squared(fa, b) + squared(fb, a) - squared(a, b);
                0.5 * (across - 0.5 * squared(fa, fb))
            }
            (true, false) => squared(fb, a),
            (false, true) => squared(fa, b),
            (false, false) => return None,
        };
        // Squares of light near the largest number of an f32 are infinite.
        error.is_finite().then_some((error / scale, a.w > 0.0 && b.w > 0.0))
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
