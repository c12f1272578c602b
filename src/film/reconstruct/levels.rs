//! Levels of the filter: a component at one of them, the taps by which the next is made, and outliers of the first.

use glam::{Vec3A, Vec4};
use rayon::prelude::*;

use crate::math::luminance;

/// Number of levels.
///
/// Unit: count. Limit: on how far light is averaged. The widest has a standard deviation of 9 pixels, the root of
/// 1 + 4 + 16 + 64.
pub(super) const LEVELS: u32 = 4;

/// Weights of a tap by its distance in steps.
///
/// Unit: none. Source: Dammertz et al. 2010, section 3: a cubic B-spline.
const SPLINE: [f32; 3] = [3.0 / 8.0, 1.0 / 4.0, 1.0 / 16.0];

/// A component of all pixels, row by row, at one level. Of each half the light in `xyz`, W/(m² sr), and in `w` the
/// number of rays that it is the mean of: 0 where it is not known. Filtered light counts as one ray.
#[derive(Debug, Clone)]
pub(super) struct Candidate {
    /// Both halves.
    pub halves: [Vec<Vec4>; 2],
}

impl Candidate {
    /// The light of both halves of a pixel.
    pub fn mean(&self, pixel: usize) -> Option<Vec3A> {
        let [a, b] = [0, 1].map(|half| self.halves[half][pixel]);
        let rays = a.w + b.w;
        (rays > 0.0).then(|| (Vec3A::from_vec4(a) * a.w + Vec3A::from_vec4(b) * b.w) / rays)
    }
}

/// A pixel near another.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tap {
    /// Its index.
    pub pixel: usize,
    /// How many steps it is to the right and down.
    pub offset: [f32; 2],
    /// Its weight.
    pub weight: f32,
}

/// Calls `f` with each tap around `pixel` of a film, itself among them, `step` pixels apart, row by row.
pub(super) fn for_each_tap(
    [width, height]: [usize; 2],
    pixel: usize,
    step: usize,
    mut f: impl FnMut(Tap),
) {
    let (x, y) = (pixel % width, pixel / width);
    let inside = |at: usize, count: usize| {
        let [before, after] =
            [at / step, (count - 1 - at) / step].map(|steps| steps.min(2) as isize);
        -before..=after
    };
    let columns = inside(x, width);
    for down in inside(y, height) {
        let row = pixel as isize + down * (step * width) as isize;
        for right in columns.clone() {
            f(Tap {
                pixel: (row + right * step as isize) as usize,
                offset: [right as f32, down as f32],
                weight: SPLINE[right.unsigned_abs()] * SPLINE[down.unsigned_abs()],
            });
        }
    }
}

/// The pixels of 3 x 3 around `pixel` of a film, itself among them, with how many columns and rows it is to each.
pub(super) fn around(
    [width, height]: [usize; 2],
    pixel: usize,
) -> impl Iterator<Item = (usize, [f32; 2])> {
    let (x, y) = (pixel % width, pixel / width);
    (y.saturating_sub(1)..height.min(y + 2)).flat_map(move |row| {
        (x.saturating_sub(1)..width.min(x + 2)).map(move |column| {
            let offset = [column as f32 - x as f32, row as f32 - y as f32];
            (row * width + column, offset)
        })
    })
}

/// 1 where `x` is 0, falling to 0 where it is 1 or more: Tukey's biweight.
pub(super) fn biweight(x: f32) -> f32 {
    let left = (1.0 - x * x).max(0.0);
    left * left
}

/// Standard deviations of noise above its neighbours by which a pixel is no outlier.
///
/// Unit: none. Derivation: of noise with a normal distribution one value in a thousand lies higher.
const DEVIATIONS: f32 = 3.0;

/// Factors by which outliers are darkened: of each half of each pixel, 1 where it is none.
pub(super) type OutlierFactors = [Vec<f32>; 2];

/// The factor by which each pixel of each half is to be darkened, so that it is hardly brighter than the brightest of its eight
/// neighbours, in either half, and itself in the other half: by [`DEVIATIONS`] of the differences of the neighbours' halves.
/// Without these the noise of what is brighter than all around it would be cut on one side.
pub(super) fn outlier_factors(width: usize, halves: &[Vec<Vec4>; 2]) -> OutlierFactors {
    let luminance = |pixel: Vec4| luminance(pixel.truncate().as_dvec3()) as f32;
    let size = [width, halves[0].len() / width];
    [0, 1].map(|half| {
        let factor = |pixel: usize| {
            let own = luminance(halves[half][pixel]);
            let mut most = f32::NEG_INFINITY;
            let [mut squares, mut count] = [0.0, 0.0];
            for (near, _) in around(size, pixel) {
                let [a, b] = [0, 1].map(|half| halves[half][near]);
                if near != pixel && a.w > 0.0 && b.w > 0.0 {
                    squares += (luminance(a) - luminance(b)).powi(2);
                    count += 1.0;
                }
                for (other, values) in halves.iter().enumerate() {
                    if (near, other) != (pixel, half) && values[near].w > 0.0 {
                        most = most.max(luminance(values[near]));
                    }
                }
            }
            let allowed = most + DEVIATIONS * (squares / f32::max(count, 1.0)).sqrt();
            if own > allowed && most >= 0.0 { allowed / own } else { 1.0 }
        };
        (0..halves[half].len()).into_par_iter().map(factor).collect()
    })
}
