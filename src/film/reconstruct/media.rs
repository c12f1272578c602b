//! Light of media, regressed on place and opacity over neighbours at the same distance.

use glam::{Vec3A, Vec4};
use rayon::prelude::*;
use smallvec::SmallVec;

use super::levels::{
    Candidate, LEVELS, OutlierFactors, Tap, biweight, for_each_tap, outlier_factors,
};
use super::light::LightOf;
use crate::film::components::{ComponentFilm, PixelComponents};

/// Difference of the logarithms of distances beyond which a neighbour does not count.
///
/// Unit: none. Derivation: light of a lamp falls to two fifths where distance grows by as much; closer ones are told
/// apart by opacity.
const LOG_DISTANCE: f32 = 0.5;

/// Difference of opacities that weighs as much as a step to the next tap.
///
/// Unit: none. Derivation: opacity of a silhouette rises by as much from pixel to pixel.
pub(super) const OPACITY_STEP: f32 = 0.05;

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

/// Factors by which outliers of light of media are darkened.
pub(super) fn outliers(film: &ComponentFilm) -> OutlierFactors {
    outlier_factors(film.width, &pixels(film, &|pixel| film.pixels[pixel].light()))
}

/// `light` of media at all levels, from that of the pixels on, with `outliers` darkened.
pub(super) fn candidates(
    film: &ComponentFilm,
    light: LightOf<'_>,
    outliers: &OutlierFactors,
) -> Vec<Candidate> {
    let mut light = pixels(film, light);
    for (light, factors) in light.iter_mut().zip(outliers) {
        for (light, factor) in light.iter_mut().zip(factors) {
            *light = (Vec3A::from_vec4(*light) * *factor).extend(light.w);
        }
    }
    levels(film, light)
}

/// The `light` of both halves at all levels.
pub(super) fn levels(film: &ComponentFilm, mut light: [Vec<Vec4>; 2]) -> Vec<Candidate> {
    let size = film.size();
    let features: Vec<_> = film.pixels.par_iter().map(media_features).collect();
    // Fitted light is that at the mean opacity of both halves.
    let of_halves: Vec<[f32; 2]> = film.pixels.par_iter().map(half_opacities).collect();
    let of_both: Vec<[f32; 2]> = film.pixels.par_iter().map(|p| [p.opacity(); 2]).collect();
    let mut all = vec![Candidate { halves: light.clone() }];
    for level in 0..LEVELS {
        let opacities = if level == 0 { &of_halves } else { &of_both };
        let fit = Fit { features: &features, opacities, light: &light, size };
        let at_pixel = |pixel: usize| fit.at(pixel, 1 << level);
        let fitted: Vec<[Vec4; 2]> = (0..film.pixels.len()).into_par_iter().map(at_pixel).collect();
        light = [0, 1].map(|half| fitted.iter().map(|halves| halves[half]).collect());
        all.push(Candidate { halves: light.clone() });
    }
    all
}

/// Mean opacity that the rays of each half of a pixel see.
fn half_opacities(pixel: &PixelComponents) -> [f32; 2] {
    pixel.halves.each_ref().map(|half| half.opacity / half.rays.max(1.0))
}

/// The media that a pixel sees, where it sees any.
fn media_features(pixel: &PixelComponents) -> Option<MediaFeatures> {
    let seen = &pixel.seen;
    (seen.media > 0.0).then(|| MediaFeatures {
        opacity: pixel.opacity(),
        log_distance: seen.log_distance / seen.media,
    })
}

/// `light` of the pixels themselves.
pub(super) fn pixels(film: &ComponentFilm, light: LightOf<'_>) -> [Vec<Vec4>; 2] {
    [0, 1].map(|half| {
        let mean = |(index, pixel): (usize, &PixelComponents)| {
            let rays = pixel.halves[half].rays;
            (Vec3A::from(light(index)[half].media) / rays.max(1.0)).extend(rays)
        };
        film.pixels.par_iter().enumerate().map(mean).collect()
    })
}

/// What light of media is fitted to.
struct Fit<'a> {
    features: &'a [Option<MediaFeatures>],
    /// Opacity that the light of each half belongs to.
    opacities: &'a [[f32; 2]],
    /// Light of both halves.
    light: &'a [Vec<Vec4>; 2],
    size: [usize; 2],
}

impl Fit<'_> {
    /// The value at `pixel` of the plane that fits the light of its neighbours best, in each half.
    fn at(&self, pixel: usize, step: usize) -> [Vec4; 2] {
        let own = |half: usize| self.light[half][pixel];
        let Some(here) = self.features[pixel] else { return [0, 1].map(own) };
        let mut near: SmallVec<[Tap; 25]> = SmallVec::new();
        let mut are_alike = true;
        for_each_tap(self.size, pixel, step, |tap| {
            let Some(there) = &self.features[tap.pixel] else { return };
            let far = (there.log_distance - here.log_distance).abs() / LOG_DISTANCE;
            let weight = tap.weight * biweight(far);
            if weight > 0.0 {
                near.push(Tap { weight, ..tap });
                let [a, b] = self.opacities[tap.pixel];
                are_alike &= a == b && self.light[0][tap.pixel].w == self.light[1][tap.pixel].w;
            }
        });
        // Weights follow from rays and opacities: halves that are alike in both share them.
        let first = self.weights(0, &near, here.opacity);
        let second = (!are_alike).then(|| self.weights(1, &near, here.opacity));
        let value = |(half, weights): (usize, &Weights)| match weights {
            Weights::None => Vec4::ZERO,
            Weights::Unknown => own(half),
            Weights::Of(weights) => {
                let light = near.iter().map(|near| Vec3A::from_vec4(self.light[half][near.pixel]));
                let value: Vec3A = light.zip(weights).map(|(light, weight)| *weight * light).sum();
                value.extend(1.0)
            }
        };
        [(0, &first), (1, second.as_ref().unwrap_or(&first))].map(value)
    }

    /// The weights of the neighbours' light of `half` in the value where the opacity is `opacity`.
    fn weights(&self, half: usize, near: &[Tap], opacity: f32) -> Weights {
        let light = &self.light[half];
        let x = |near: &Tap| {
            let [right, down] = near.offset;
            let denser = self.opacities[near.pixel][half] - opacity;
            Vec4::new(1.0, right, down, denser / OPACITY_STEP)
        };
        let mut normal = glam::Mat4::ZERO;
        for near in near {
            let x = x(near);
            let weighted = near.weight * light[near.pixel].w * x;
            normal.x_axis += weighted * x.x;
            normal.y_axis += weighted * x.y;
            normal.z_axis += weighted * x.z;
            normal.w_axis += weighted * x.w;
        }
        let total = normal.x_axis.x;
        if total <= 0.0 {
            return Weights::None;
        }
        // Of weights whose sum is 1, lest the determinant be too small for an f32.
        normal *= 1.0 / total;
        normal.y_axis.y += RIDGE;
        normal.z_axis.z += RIDGE;
        normal.w_axis.w += RIDGE;
        let row = normal.inverse().row(0) / total;
        if !row.is_finite() {
            return Weights::Unknown;
        }
        let weight = |near: &Tap| near.weight * light[near.pixel].w * row.dot(x(near));
        Weights::Of(near.iter().map(weight).collect())
    }
}

/// Weights of neighbours in a fit.
#[derive(Debug)]
enum Weights {
    /// No neighbour has light.
    None,
    /// Numbers do not tell them.
    Unknown,
    /// One a neighbour.
    Of(SmallVec<[f32; 25]>),
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::reconstruct::tests::{SIZE, film, medium, raw};
    use crate::math::{Stage, Stream};

    /// Light that is linear in place and opacity stays what it is at all levels, up to the ridge.
    #[test]
    fn media_that_are_linear_stay_as_they_are() {
        let opacity = |x: f64, y: f64| 0.4 + 0.3 * (0.3 * x).sin() * (0.2 * y).cos();
        let light = |x: f64, y: f64| 2.0 + 0.02 * x - 0.01 * y + 1.5 * opacity(x, y);
        let film = film(1, 0.0, 0, |x, y, _| medium(light(x, y), opacity(x, y), 5.0));
        let all = |pixel: usize| film.pixels[pixel].light();
        let candidates = candidates(&film, &all, &outliers(&film));
        for (level, candidate) in candidates.iter().enumerate() {
            for (index, _) in film.pixels.iter().enumerate() {
                let [x, y] = [index % SIZE[0], index / SIZE[0]].map(|at| at as f64);
                let found = f64::from(candidate.mean(index).unwrap().y);
                assert!((found / light(x, y) - 1.0).abs() < 0.02, "{level}: {found} at {x}, {y}");
            }
        }
    }

    /// Noise of even light is no outlier: where halves have a standard deviation of a third of the light, clamping takes less
    /// than a thousandth of it.
    #[test]
    fn noise_is_hardly_darkened() {
        let film = film(2, 0.25, 10, |_, _, noise| medium(noise, 0.5, 4.0));
        let all = |pixel: usize| film.pixels[pixel].light();
        let sum = |factors: Option<&OutlierFactors>| -> f32 {
            let halves = pixels(&film, &all);
            let of = |half: usize, pixel: usize| {
                halves[half][pixel].y * factors.map_or(1.0, |factors| factors[half][pixel])
            };
            (0..film.pixels.len()).map(|pixel| of(0, pixel) + of(1, pixel)).sum()
        };
        let kept = sum(Some(&outliers(&film))) / sum(None);
        assert!((0.999..=1.0).contains(&kept), "{kept}");
    }

    /// Rays of the halves see a silhouette differently; light that follows opacity stays what it is, up to the ridge.
    #[test]
    fn opacity_of_each_half_is_told_apart() {
        let mut film = film(1, 0.0, 8, |_, _, _| medium(1.0, 0.5, 4.0));
        let mut rng = Stream::new(9, Stage::Test, 0, 0);
        for pixel in &mut film.pixels {
            for half in &mut pixel.halves {
                half.opacity = rng.uniform() as f32;
                half.media = glam::Vec3::splat(2.0 * half.opacity);
            }
        }
        let raw = raw(&film);
        let all = |pixel: usize| film.pixels[pixel].light();
        for candidate in levels(&film, pixels(&film, &all)) {
            for (pixel, raw) in raw.pixels().iter().enumerate() {
                let found = candidate.mean(pixel).unwrap().y;
                assert!((found - raw[1]).abs() < 0.01, "{found:?} for {raw:?}");
            }
        }
    }
}
