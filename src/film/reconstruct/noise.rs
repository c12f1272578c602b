//! Noise and bias of a reconstructed picture, as its two halves tell them.

use glam::Vec3A;
use rayon::prelude::*;

use super::Reconstruction;
use super::edges::mean_reflectance;
use super::scale::box_sums;
use super::surfaces::ratio;
use crate::film::components::{HalfSums, PixelComponents};
use crate::math::luminance;

/// Pixels on each side over which the noise that neighbours share is averaged: light of few photons is off in all of
/// them, and no ray mends it.
///
/// Unit: pixels. Limit: on how much of the rays' own noise is taken for that.
const SHARED_RADIUS: usize = 1;

/// Estimates of the error of the luminance of each pixel, radiance squared. One pixel tells a variance to a factor: averages
/// over pixels that are alike tell it better.
#[derive(Debug)]
pub struct FilmNoise {
    /// Of the pixels as they are reconstructed.
    pub reconstructed: Vec<f32>,
    /// Of the pixels as their rays render them.
    pub rendered: Vec<f32>,
    /// Squared bias of the reconstruction, of any sign: much noisier than the variances.
    pub squared_bias: Vec<f32>,
    /// The noise that pixels around share, before and after reconstruction, of any sign: of photons, and of gathers in cells.
    pub shared: [Vec<f32>; 2],
}

impl Reconstruction<'_> {
    /// The noise that rays leave in each pixel, before and after reconstruction: a quarter of the squared difference of
    /// both halves, without what pixels around share, which is told apart. 0 where a pixel has rays in one half alone.
    ///
    /// What mirrors and glass show is not reconstructed. Coverage at edges, and emission behind them, are left out of the noise
    /// after reconstruction, as visibility rays find them.
    ///
    /// With the filter F and the halves A and B, whose noise is independent, the mean of (F(A) - A)(F(B) - B) is the
    /// squared bias, less what the scales hide of it that both halves choose. Both are of the light that is filtered.
    pub fn noise(&self) -> FilmNoise {
        let mut is_edge = vec![false; self.film.pixels.len()];
        self.edges().into_iter().for_each(|pixel| is_edge[pixel] = true);
        // Differences of the halves after and before reconstruction, and the product of what it changes in each.
        let of_pixel = |pixel: usize| {
            let components = &self.film.pixels[pixel];
            if !is_in_both_halves(components) {
                return [0.0; 3];
            }
            let filtered = self.filtered(pixel, is_edge[pixel]);
            let [rendered, rest] =
                [as_rendered, rest].map(|of| components.halves.each_ref().map(of));
            let changed = |half: usize| filtered[half] + rest[half] - rendered[half];
            let is_rest_seen = is_edge[pixel] && components.seen.specular == 0.0;
            let unfiltered = if is_rest_seen { 0.0 } else { rest[0] - rest[1] };
            let reconstructed = filtered[0] - filtered[1] + unfiltered;
            [reconstructed, rendered[0] - rendered[1], changed(0) * changed(1)]
        };
        let pixels = (0..self.film.pixels.len()).into_par_iter();
        let pixels: Vec<[f32; 3]> = pixels.map(of_pixel).collect();
        let [filtered, rendered, squared_bias] =
            [0, 1, 2].map(|part| pixels.iter().map(|pixel| pixel[part]).collect::<Vec<f32>>());
        let own = [&rendered, &filtered].map(|differences| self.variances(differences));
        let shared = [(&rendered, &own[0]), (&filtered, &own[1])].map(|(differences, own)| {
            let squares = differences.iter().map(|difference| (0.5 * difference).powi(2));
            squares.zip(own).map(|(square, own)| square - own).collect()
        });
        let [rendered, reconstructed] = own;
        FilmNoise { reconstructed, rendered, squared_bias, shared }
    }

    /// Luminance of media and surfaces in both halves of a pixel once they are filtered; `is_edge` where visibility rays
    /// tell what the pixel sees. Elsewhere its own rays do: filtered light is in proportion to the opacity and
    /// reflectance that those of each half find.
    fn filtered(&self, pixel: usize, is_edge: bool) -> [f32; 2] {
        let components = &self.film.pixels[pixel];
        let light = |half: usize| {
            let (sums, filtered) = (&components.halves[half], &self.filtered.halves[half]);
            let (mut media, mut reflected) = (filtered.media[pixel], filtered.reflected(pixel));
            if !is_edge {
                let opacity = components.opacity();
                if opacity > 0.0 {
                    media *= sums.opacity / sums.rays / opacity;
                }
                let seen = Vec3A::from(sums.reflectance) / sums.rays;
                reflected *= ratio(seen, mean_reflectance(components));
            }
            media + reflected
        };
        [0, 1].map(|half| luminance(light(half).as_dvec3()) as f32)
    }

    /// Squares whose mean is the variance of the mean of two halves with these differences, without what pixels around
    /// share.
    fn variances(&self, differences: &[f32]) -> Vec<f32> {
        let width = self.film.width;
        let known: Vec<f32> = self
            .film
            .pixels
            .iter()
            .map(|pixel| f32::from(u8::from(is_in_both_halves(pixel))))
            .collect();
        let [sums, counts] = [differences, &known].map(|of| box_sums(width, of, SHARED_RADIUS));
        let own = |pixel: usize| {
            // The mean over n independent differences takes 1/n of their variance with it.
            let count = counts[pixel];
            if known[pixel] == 0.0 || count < 2.0 {
                return 0.0;
            }
            let apart = differences[pixel] - sums[pixel] / count;
            (0.5 * apart).powi(2) * count / (count - 1.0)
        };
        (0..differences.len()).into_par_iter().map(own).collect()
    }
}

/// Whether a pixel has rays in both halves.
fn is_in_both_halves(pixel: &PixelComponents) -> bool {
    pixel.halves.iter().all(|half| half.rays > 0.0)
}

/// Luminance of a half of a pixel as it is rendered.
fn as_rendered(half: &HalfSums) -> f32 {
    luminance((half.radiance / half.rays).as_dvec3()) as f32
}

/// That of it which is in no component: emission, and what mirrors and glass show.
fn rest(half: &HalfSums) -> f32 {
    let rest = half.radiance - half.media - half.direct - half.indirect;
    luminance((rest / half.rays).as_dvec3()) as f32
}

#[cfg(test)]
mod tests {
    use super::super::tests::{SIZE, film, floor, medium, surface};
    use super::*;
    use crate::film::{ComponentFilm, Sample};
    use crate::math::Rgb;
    use glam::DVec3;

    fn means(film: &ComponentFilm) -> [f64; 2] {
        let noise = Reconstruction::new(film).noise();
        let mean = |of: Vec<f32>| of.iter().map(|v| f64::from(*v)).sum::<f64>() / of.len() as f64;
        [mean(noise.reconstructed), mean(noise.rendered)]
    }

    /// Rays of variance v: the mean of r in each half has v / 2r, told within 4 standard errors of 1536 squares (one
    /// false alarm in 16 000 at this fixed seed), and far less is left after the filter.
    #[test]
    fn variance_of_rays_is_told() {
        for (rays, variance) in [(1, 0.04), (2, 0.09)] {
            let film = film(rays, variance, 21, |_, _, noise| medium(noise, 0.5, 4.0));
            let [reconstructed, rendered] = means(&film);
            let right = variance / f64::from(2 * rays);
            let error = 4.0 * (2.0 / 1536.0_f64).sqrt();
            assert!((rendered / right - 1.0).abs() < error, "{rendered} for {right}");
            assert!(reconstructed < 0.1 * rendered, "{reconstructed} of {rendered}");
        }
    }

    /// Waves that no feature shows, finer than the filter: both halves tell a third of its squared bias or more. Without waves
    /// there is none, within 4 standard errors of 1536 products (one false alarm in 16 000 at this fixed seed).
    #[test]
    fn bias_of_the_filter_is_told() {
        let variance = 0.25;
        for depth in [0.6, 0.0] {
            let truth = |x: f64| 1.0 + depth * (2.0 * x).sin();
            let film = film(1, variance, 23, |x, _, noise| medium(truth(x) * noise, 0.5, 4.0));
            let reconstruction = Reconstruction::new(&film);
            let told = reconstruction.noise().squared_bias;
            let right = |pixel: usize| {
                let truth = truth((pixel % SIZE[0]) as f64);
                let [a, b] = reconstruction.filtered(pixel, false);
                (f64::from(a) - truth) * (f64::from(b) - truth)
            };
            let mean = |of: &dyn Fn(usize) -> f64| {
                (0..told.len()).map(of).sum::<f64>() / told.len() as f64
            };
            let (told, right) = (mean(&|pixel| told[pixel].into()), mean(&right));
            let error = 4.0 * (variance + 0.5 * depth * depth) / 1536.0_f64.sqrt();
            if depth > 0.0 {
                assert!(right > error, "{right}");
                assert!(told > right / 3.0 && told < right + error, "{told} for {right}");
            } else {
                assert!(told.abs() < error && right.abs() < error, "{told} for {right}");
            }
        }
    }

    /// Light that one half has too much of everywhere is the photons' noise, which no ray mends.
    #[test]
    fn what_pixels_share_is_left_out() {
        let mut film = film(1, 0.0, 22, |_, _, _| medium(1.0, 0.5, 4.0));
        for pixel in &mut film.pixels {
            pixel.halves[0].media *= 1.3;
            pixel.halves[0].radiance *= 1.3;
        }
        assert!(means(&film).iter().all(|noise| *noise < 1e-9), "{:?}", means(&film));
    }

    /// Rays of the halves see different parts of a soft silhouette: that is noise where media have it, and not at edges of
    /// surfaces, which visibility rays find.
    #[test]
    fn coverage_is_noise_where_no_visibility_ray_finds_it() {
        let mut smoke = film(1, 0.0, 23, |_, _, _| medium(1.0, 0.5, 4.0));
        let factors =
            (0..).map(|index| if (index / SIZE[0] + index).is_multiple_of(3) { 0.7 } else { 1.0 });
        for (pixel, factor) in smoke.pixels.iter_mut().zip(factors) {
            let half = &mut pixel.halves[0];
            half.media *= factor;
            half.radiance *= factor;
            half.opacity *= factor;
        }
        let [reconstructed, rendered] = means(&smoke);
        assert!(reconstructed > 0.5 * rendered, "{reconstructed} of {rendered}");
        let wall = |x: f64, y: f64| {
            surface(2.0, DVec3::new(x, 0.0, 30.0), DVec3::Z, if y < 15.0 { 0.2 } else { 0.6 })
        };
        let mut edge = film(1, 0.0, 24, |x, y, _| {
            if y < 16.0 { wall(x, y) } else { surface(2.0, floor(x, y), DVec3::Y, 0.6) }
        });
        for pixel in &mut edge.pixels[15 * SIZE[0]..16 * SIZE[0]] {
            let half = &mut pixel.halves[0];
            half.direct *= 3.0;
            half.radiance *= 3.0;
            half.reflectance *= 3.0;
        }
        let [reconstructed, rendered] = means(&edge);
        assert!(reconstructed < 1e-3 * rendered, "{reconstructed} of {rendered}");
    }

    /// A wall before a bright sky, and smoke before it: visibility rays find the sky beside both, which the filter changes in neither.
    #[test]
    fn emission_behind_edges_is_no_bias() {
        let sky = |light: f64| Sample { visible_emission: Rgb::splat(light), ..Sample::default() };
        let wall = film(1, 0.0, 25, |x, y, _| {
            if y < 16.0 { sky(7.0) } else { surface(2.0, floor(x, y), DVec3::Y, 0.6) }
        });
        let smoke =
            film(1, 0.0, 26, |_, y, _| if y < 16.0 { sky(7.0) } else { medium(1.0, 0.5, 4.0) });
        for film in [wall, smoke] {
            let reconstruction = Reconstruction::new(&film);
            assert!(!reconstruction.edges().is_empty());
            let bias = reconstruction.noise().squared_bias;
            assert!(bias.iter().all(|bias| bias.abs() < 1e-6), "{bias:?}");
        }
    }
}
