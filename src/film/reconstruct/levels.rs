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

/// Root mean squares of the difference between a neighbour's halves by which a half may be brighter than all around it.
///
/// Unit: none. Limit: on how much noise is cut: differences have twice the variance of a half, so that it may be brighter by 4.2
/// standard deviations.
const OUTLIER_DEVIATIONS: f32 = 3.0;

/// Factors by which outliers are darkened: of each half of each pixel, 1 where it is none.
pub(super) type OutlierFactors = [Vec<f32>; 2];

/// The factor by which each pixel of each half is to be darkened, so that it is not much brighter than the brightest of its eight
/// neighbours, in either half, and itself in the other half: no more than the noise of the neighbours explains. Without that
/// margin, noise would be cut on one side, which darkens the picture.
pub(super) fn outlier_factors(width: usize, halves: &[Vec<Vec4>; 2]) -> OutlierFactors {
    let luminances = |pixel: usize| {
        halves.each_ref().map(|half| luminance(half[pixel].truncate().as_dvec3()) as f32)
    };
    let is_known = |pixel: usize| halves.each_ref().map(|half| half[pixel].w > 0.0);
    let size = [width, halves[0].len() / width];
    let factors = |pixel: usize| {
        let mut brightest = f32::NEG_INFINITY;
        let [mut squares, mut count] = [0.0, 0.0];
        for (near, _) in around(size, pixel).filter(|(near, _)| *near != pixel) {
            let ([a, b], known) = (luminances(near), is_known(near));
            for (luminance, known) in [a, b].into_iter().zip(known) {
                if known {
                    brightest = brightest.max(luminance);
                }
            }
            if known == [true; 2] {
                squares += (a - b).powi(2);
                count += 1.0;
            }
        }
        let margin = OUTLIER_DEVIATIONS * (squares / f32::max(count, 1.0)).sqrt();
        let (own, known) = (luminances(pixel), is_known(pixel));
        let factor = |half: usize| {
            let other = 1 - half;
            let most = if known[other] { brightest.max(own[other]) } else { brightest };
            let allowed = most + margin;
            if own[half] > allowed && most >= 0.0 { allowed / own[half] } else { 1.0 }
        };
        (factor(0), factor(1))
    };
    let (first, second) = (0..halves[0].len()).into_par_iter().map(factors).unzip();
    [first, second]
}
