//! Light of media, regressed on place and opacity over neighbours at the same distance.

use glam::{Vec3A, Vec4};
use rayon::prelude::*;
use smallvec::SmallVec;

use super::levels::{Candidate, LEVELS, Tap, biweight, outlier_factors, taps};
use crate::film::components::{ComponentFilm, PixelComponents};

/// Difference of the logarithms of distances beyond which a neighbour does not count.
///
/// Unit: none. Derivation: light of a lamp falls to two fifths where distance grows by as much; closer ones are told
/// apart by opacity.
const LOG_DISTANCE: f32 = 0.5;

/// Difference of opacities that weighs as much as a step to the next tap.
///
/// Unit: none. Derivation: opacity of a silhouette rises by as much from pixel to pixel.
const OPACITY_STEP: f32 = 0.05;

/// Part of the weight of all taps by which slopes are drawn to 0.
///
/// Unit: none. Limit: on slopes in opacity where that is nearly the same everywhere.
const RIDGE: f32 = 0.01;

/// The media that a pixel sees.
#[derive(Debug, Clone, Copy)]
struct MediaFeatures {
    opacity: f32,
    log_distance: f32,
}

/// Light of media at all levels, from that of the pixels on, without outliers.
pub(super) fn candidates(film: &ComponentFilm) -> Vec<Candidate> {
    let mut light = pixels(film);
    let factors = outlier_factors(film.width, &light);
    for (light, factors) in light.iter_mut().zip(factors) {
        for (light, factor) in light.iter_mut().zip(factors) {
            *light = (Vec3A::from_vec4(*light) * factor).extend(light.w);
        }
    }
    levels(film, light)
}

/// The `light` of both halves at all levels.
pub(super) fn levels(film: &ComponentFilm, mut light: [Vec<Vec4>; 2]) -> Vec<Candidate> {
    let size = [film.width, film.pixels.len() / film.width];
    let features: Vec<_> = film.pixels.par_iter().map(media_features).collect();
    let mut all = vec![Candidate { halves: light.clone() }];
    for level in 0..LEVELS {
        let fitted = |pixel: usize| fit(&features, &light, size, pixel, 1 << level);
        let fitted: Vec<[Vec4; 2]> = (0..film.pixels.len()).into_par_iter().map(fitted).collect();
        light = [0, 1].map(|half| fitted.iter().map(|halves| halves[half]).collect());
        all.push(Candidate { halves: light.clone() });
    }
    all
}

/// The media that a pixel sees, where it sees any.
fn media_features(pixel: &PixelComponents) -> Option<MediaFeatures> {
    let seen = &pixel.seen;
    (seen.media > 0.0).then(|| MediaFeatures {
        opacity: seen.opacity / pixel.rays(),
        log_distance: seen.log_distance / seen.media,
    })
}

/// Light of the pixels themselves.
pub(super) fn pixels(film: &ComponentFilm) -> [Vec<Vec4>; 2] {
    [0, 1].map(|half| {
        let mean = |pixel: &PixelComponents| {
            let sums = &pixel.halves[half];
            (Vec3A::from(sums.media) / sums.rays.max(1.0)).extend(sums.rays)
        };
        film.pixels.par_iter().map(mean).collect()
    })
}

/// The value at `pixel` of the plane that fits the light of its neighbours best, in each half.
fn fit(
    features: &[Option<MediaFeatures>],
    light: &[Vec<Vec4>; 2],
    size: [usize; 2],
    pixel: usize,
    step: usize,
) -> [Vec4; 2] {
    let Some(here) = features[pixel] else { return [0, 1].map(|half| light[half][pixel]) };
    let near = |tap: Tap| {
        let there = features[tap.pixel]?;
        let far = (there.log_distance - here.log_distance).abs() / LOG_DISTANCE;
        let weight = tap.weight * biweight(far);
        let [right, down] = tap.offset;
        let x = Vec4::new(1.0, right, down, (there.opacity - here.opacity) / OPACITY_STEP);
        (weight > 0.0).then_some((tap.pixel, weight, x))
    };
    let near: SmallVec<[(usize, f32, Vec4); 25]> =
        taps(size, pixel, step).filter_map(near).collect();
    [0, 1].map(|half| {
        let light = &light[half];
        let mut normal = glam::Mat4::ZERO;
        for &(there, weight, x) in &near {
            let weighted = weight * light[there].w * x;
            normal.x_axis += weighted * x.x;
            normal.y_axis += weighted * x.y;
            normal.z_axis += weighted * x.z;
            normal.w_axis += weighted * x.w;
        }
        let total = normal.x_axis.x;
        if total <= 0.0 {
            return Vec4::ZERO;
        }
        // Of weights whose sum is 1, lest the determinant be too small for an f32.
        normal *= 1.0 / total;
        normal.y_axis.y += RIDGE;
        normal.z_axis.z += RIDGE;
        normal.w_axis.w += RIDGE;
        let row = normal.inverse().row(0) / total;
        if !row.is_finite() {
            return light[pixel];
        }
        let mut value = Vec3A::ZERO;
        for &(there, weight, x) in &near {
            value += weight * light[there].w * row.dot(x) * Vec3A::from_vec4(light[there]);
        }
        value.extend(1.0)
    })
}
