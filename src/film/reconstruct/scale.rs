//! Which level of the filter each pixel takes.

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
    let errors = relative_errors(candidate, raw, scales);
    let [whole, partial] = [true, false].map(|whole| {
        let of_kind = |error: &Option<(f32, bool)>| error.filter(|error| error.1 == whole);
        let values: Vec<f32> = errors.iter().map(|e| of_kind(e).map_or(0.0, |e| e.0)).collect();
        let counts: Vec<f32> =
            errors.iter().map(|e| f32::from(u8::from(of_kind(e).is_some()))).collect();
        let [sums, counts] = [values, counts].map(|of| box_sums(width, &of, ERROR_RADIUS));
        sums.into_iter().zip(counts).collect::<Vec<(f32, f32)>>()
    });
    let mean = |(whole, partial): (&(f32, f32), &(f32, f32))| {
        let (sum, count) = if whole.1 > 0.0 { whole } else { partial };
        if *count > 0.0 { sum / count } else { f32::INFINITY }
    };
    whole.iter().zip(&partial).map(mean).collect()
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
    let ones = vec![1.0; values.len()];
    let [sums, counts] = [values, &ones].map(|of| box_sums(width, of, radius));
    sums.into_iter().zip(counts).map(|(sum, count)| sum / count).collect()
}

/// Sums over squares of `radius` pixels to each side.
pub(super) fn box_sums(width: usize, values: &[f32], radius: usize) -> Vec<f32> {
    let height = values.len() / width;
    let along = |values: &[f32], pixel: usize, stride: usize, at: usize, count: usize| {
        let (first, last) = (at.saturating_sub(radius), (at + radius).min(count - 1));
        let start = pixel - (at - first) * stride;
        (0..=last - first).map(|index| values[start + index * stride]).sum::<f32>()
    };
    let rows: Vec<f32> = (0..values.len())
        .into_par_iter()
        .map(|pixel| along(values, pixel, 1, pixel % width, width))
        .collect();
    (0..values.len())
        .into_par_iter()
        .map(|pixel| along(&rows, pixel, width, pixel / width, height))
        .collect()
}
