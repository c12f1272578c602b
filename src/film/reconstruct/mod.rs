//! Reconstruction: less noise in a finished picture, by its components and their two halves.
//!
//! 1. Outliers are clamped to their neighbours.
//! 2. Light of surfaces is divided by their reflectance and averaged over neighbours on the same plane, level by level
//!    with wider gaps (à-trous wavelets, Dammertz et al. 2010, "Edge-Avoiding À-Trous Wavelet Transform for fast Global
//!    Illumination Filtering").
//! 3. Light of media is regressed on place and opacity over neighbours at the same distance, on the same levels
//!    (local linear regression as in Bitterli et al. 2016, "Nonlinearly Weighted First-order Regression for Denoising
//!    Monte Carlo Renderings").
//! 4. Which level a pixel takes follows from the error of each, which the halves tell: one predicts the other
//!    (Rousselle, Knaus and Zwicker 2012, "Adaptive Rendering with Non-Local Means Filtering"). Local means of the
//!    errors are shrunk toward those of a larger region.
//! 5. Pixels at edges of surfaces and media are antialiased by visibility rays, which look up filtered light of what they
//!    see in the pixels around (Ragan-Kelley et al. 2011, "Decoupled Sampling for Graphics Pipelines").
//!
//! Weights come from what pixels see, and not from their light: each level is linear in the light, so that noise does
//! not bias it. Emission and what mirrors and glass show stay as they are.

mod antialias;
mod edges;
mod filter;
mod levels;
mod light;
mod media;
mod noise;
mod parts;
mod scale;
mod surfaces;
mod visibility;

use glam::{Vec3A, Vec4};

pub use antialias::Antialiased;
pub use light::{PART_BYTES, PictureLight, PixelLight};
pub use noise::FilmNoise;
pub use visibility::VisibilityRay;

use super::components::ComponentFilm;
use crate::image::Image;
use filter::Filter;
use light::FilteredLight;
use surfaces::SurfaceFeatures;

/// Bytes of a pixel that reconstruction takes beside its components at most: selected light of two components, and those
/// of surfaces at all levels, in two halves, with sums, errors and gains, what is seen, and factors and levels of three components.
///
/// Unit: bytes. Derivation: from the sizes of what is held.
pub const RECONSTRUCTION_BYTES: usize = 2 * 2 * (levels::LEVELS as usize + 1) * size_of::<Vec4>()
    + surfaces::SUMS_BYTES
    + scale::GAINS_BYTES
    + size_of::<Option<SurfaceFeatures>>()
    + 3 * 3 * size_of::<f32>()
    + 3 * size_of::<[Vec3A; 3]>();

/// Pixels on each side on which a reconstructed pixel depends.
///
/// Unit: pixels. Derivation: the radii of all that is looked at, one from the other: outliers or spacings, the taps of all
/// levels, errors and the light they are relative to, levels, the neighbours of edges, and agreement with what that is relative to.
pub const RECONSTRUCTION_REACH: usize = 1
    + 2 * ((1 << levels::LEVELS) - 1)
    + scale::REGION_RADIUS
    + scale::ERROR_RADIUS
    + scale::LEVEL_RADIUS
    + 1
    + 2 * antialias::AGREEMENT_RADIUS;

/// The components of a picture with less noise.
#[derive(Debug)]
pub struct Reconstruction<'a> {
    film: &'a ComponentFilm,
    /// The surfaces that pixels see.
    surfaces: Vec<Option<SurfaceFeatures>>,
    filter: Filter,
    /// All light.
    filtered: FilteredLight,
}

impl<'a> Reconstruction<'a> {
    /// Takes the noise off the components of `film`.
    pub fn new(film: &'a ComponentFilm) -> Self {
        let surfaces = surfaces::surfaces(film);
        let (filter, filtered) = Filter::new(film, &surfaces);
        Self { film, surfaces, filter, filtered }
    }

    /// The picture, which as it was rendered is `raw`, with pixels that are `antialiased`, each by so much of its
    /// [residual](Self::residual_shares).
    ///
    /// # Panics
    /// Where they differ in size.
    pub fn image(&self, raw: &Image, antialiased: &[Antialiased], shares: &[f32]) -> Image {
        assert_eq!(self.film.pixels.len(), raw.pixels().len(), "one a pixel");
        let pixels = raw.pixels().iter().enumerate();
        let changed = pixels.map(|(index, raw)| Vec3A::from_array(*raw) + self.change(index));
        let mut pixels: Vec<Vec3A> = changed.collect();
        for (antialiased, share) in antialiased.iter().zip(shares) {
            pixels[antialiased.pixel] = antialiased.corrected(*share).total();
        }
        // Noise of moments makes light negative.
        let pixels = pixels.into_iter().map(|pixel| pixel.max(Vec3A::ZERO).to_array());
        Image::new(raw.width(), raw.height(), pixels.collect())
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::light::mean_components;
    use super::*;
    use crate::film::PixelComponents;
    use crate::film::{Components, Sample, Seen, VisibleSurface};
    use crate::math::{Rgb, Stage, Stream};

    pub const SIZE: [usize; 2] = [48, 32];

    fn reconstruct(film: &ComponentFilm, raw: &Image) -> Image {
        Reconstruction::new(film).image(raw, &[], &[])
    }

    /// No emission in any pixel.
    pub const DARK: &[[f32; 3]] = &[[0.0; 3]; SIZE[0] * SIZE[1]];

    /// All light that a film of `reconstruction` has, without mirrors.
    pub fn all_light<'a>(reconstruction: &'a Reconstruction<'_>) -> PictureLight<'a> {
        reconstruction.all_light(&raw(reconstruction.film), DARK)
    }

    /// A film whose rays are `sample(x, y, noise)`, `rays` of each half, where `noise` has the mean 1 and so much variance.
    pub fn film(
        rays: u32,
        variance: f64,
        seed: u64,
        sample: impl Fn(f64, f64, f64) -> Sample,
    ) -> ComponentFilm {
        let [width, height] = SIZE;
        let pixel = |index: usize| {
            let mut rng = Stream::new(seed, Stage::March, index as u64, 0);
            let mut pixel = PixelComponents::default();
            for ray in 0..2 * rays {
                // The sum of twelve uniform numbers is nearly normal.
                let normal: f64 = (0..12).map(|_| rng.uniform()).sum::<f64>() - 6.0;
                let [x, y] = [index % width, index / width].map(|at| at as f64);
                let sample = sample(x, y, 1.0 + variance.sqrt() * normal);
                let light = sample.components;
                let radiance =
                    light.media + light.direct + light.indirect + sample.visible_emission;
                pixel.add((ray % 2) as usize, &Sample { radiance, ..sample });
            }
            pixel
        };
        ComponentFilm { width, pixels: (0..width * height).map(pixel).collect(), parts: Vec::new() }
    }

    /// The picture itself.
    pub fn raw(film: &ComponentFilm) -> Image {
        let mean = |pixel: &PixelComponents| {
            mean_components(&pixel.light(), pixel.rays()).total().to_array()
        };
        let pixels = film.pixels.iter().map(mean).collect();
        Image::new(film.width, film.pixels.len() / film.width, pixels)
    }

    /// Mean of the squared differences from `truth(x, y)`.
    fn squared_error(image: &Image, truth: impl Fn(f64, f64) -> f64) -> f64 {
        let squares = image.pixels().iter().enumerate().map(|(index, pixel)| {
            let [x, y] = [index % SIZE[0], index / SIZE[0]].map(|at| at as f64);
            (f64::from(pixel[1]) - truth(x, y)).powi(2)
        });
        squares.sum::<f64>() / image.pixels().len() as f64
    }

    /// Media of this light, opacity and distance.
    pub fn medium(light: f64, opacity: f64, distance: f64) -> Sample {
        Sample {
            components: Components { media: Rgb::splat(light), ..Components::default() },
            seen: Seen { media_distance: Some(distance), ..Seen::default() },
            transmittance: 1.0 - opacity,
            ..Sample::default()
        }
    }

    /// A surface of this direct light, offset, normal and reflectance.
    pub fn surface(light: f64, offset: DVec3, normal: DVec3, reflectance: f64) -> Sample {
        let reflectance = Rgb::splat(reflectance);
        let direct = reflectance * light;
        Sample {
            components: Components { direct, ..Components::default() },
            seen: Seen {
                surface: Some(VisibleSurface { offset, normal, reflectance }),
                ..Seen::default()
            },
            ..Sample::default()
        }
    }

    /// A floor under the pixel.
    pub fn floor(x: f64, y: f64) -> DVec3 {
        DVec3::new(x, 10.0, y)
    }

    /// Smooth light in noise: the error falls at least tenfold, for media as for surfaces.
    #[test]
    fn noise_of_smooth_light_falls_tenfold() {
        let light = |x: f64, y: f64| 1.0 + 0.3 * (0.05 * x).sin() + 0.2 * (0.07 * y).cos();
        let hazy = film(2, 0.25, 1, |x, y, noise| medium(noise * light(x, y), 0.5, 4.0));
        let lit = film(2, 0.25, 2, |x, y, noise| {
            surface(2.0 * noise * light(x, y), floor(x, y), DVec3::Y, 0.5)
        });
        for film in [hazy, lit] {
            let raw = raw(&film);
            let errors = [&raw, &reconstruct(&film, &raw)].map(|image| squared_error(image, light));
            assert!(errors[1] < 0.1 * errors[0], "{errors:?}");
        }
    }

    /// Detail without noise stays: a pattern that no feature tells of is not averaged.
    #[test]
    fn detail_without_noise_stays() {
        let light = |x: f64, y: f64| {
            if (x / 3.0).floor() % 2.0 == (y / 3.0).floor() % 2.0 { 2.0 } else { 1.0 }
        };
        let film =
            film(2, 0.0, 3, |x, y, _| surface(2.0 * light(x, y), floor(x, y), DVec3::Y, 0.5));
        let raw = raw(&film);
        let error = squared_error(&reconstruct(&film, &raw), light);
        assert!(error < 1e-6, "{error}");
    }

    /// A shadow's edge in noise: less noise beside it, and no more error at it than the noise was.
    #[test]
    fn edges_of_shadows_are_found_in_noise() {
        let light = |x: f64, y: f64| if x + 0.4 * y < 24.0 { 1.0 } else { 0.2 };
        let film = film(8, 0.04, 4, |x, y, noise| {
            surface(2.0 * noise * light(x, y), floor(x, y), DVec3::Y, 0.5)
        });
        let raw = raw(&film);
        let errors = [&raw, &reconstruct(&film, &raw)].map(|image| squared_error(image, light));
        assert!(errors[1] < 0.7 * errors[0], "{errors:?}");
    }

    /// Errors that halves tell are those from the truth: over 40 films the mean of their differences is within 4 standard
    /// errors, which false alarms exceed once in 5000 runs of the five levels.
    #[test]
    fn halves_tell_the_error_of_each_level() {
        let light = |x: f64, y: f64| 1.0 + 0.5 * (0.8 * x).sin() * (0.6 * y).sin();
        let mut differences: Vec<Vec<f64>> = Vec::new();
        for seed in 0..40 {
            let film =
                film(4, 0.2, 100 + seed, |x, y, noise| medium(noise * light(x, y), 0.5, 4.0));
            // Outliers are clamped by both halves, which would not be independent.
            let all = |pixel: usize| film.pixels[pixel].light();
            let candidates = media::levels(&film, media::pixels(&film, &all));
            let [raw, .., widest] = candidates.as_slice() else { unreachable!() };
            let scales = scale::scales(SIZE[0], widest);
            let told = candidates.iter().map(|candidate| {
                let errors = scale::relative_errors(candidate, raw, &scales);
                let differences =
                    errors.iter().zip(&scales).enumerate().map(|(index, (told, scale))| {
                        let [x, y] = [index % SIZE[0], index / SIZE[0]].map(|at| at as f64);
                        let mean = candidate.mean(index).unwrap();
                        let error = (mean - Vec3A::splat(light(x, y) as f32)).length_squared();
                        f64::from(told.unwrap() - error / scale)
                    });
                differences.sum::<f64>() / film.pixels.len() as f64
            });
            differences.push(told.collect());
        }
        for level in 0..differences[0].len() {
            let of_level: Vec<f64> = differences.iter().map(|film| film[level]).collect();
            let count = of_level.len() as f64;
            let mean = of_level.iter().sum::<f64>() / count;
            let variance = of_level.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (count - 1.0);
            let error = (variance / count).sqrt();
            assert!(mean.abs() < 4.0 * error + 1e-4, "level {level}: {mean} +- {error}");
        }
    }

    /// One bright ray among dark ones goes; a bright pixel that both halves see stays.
    #[test]
    fn outliers_go_and_highlights_stay() {
        let spark = |x: f64, y: f64| x == 20.0 && y == 10.0;
        let film = |both: bool| {
            let mut film =
                film(2, 0.0, 5, |x, y, _| medium(1.0, 0.5, if spark(x, y) { 4.0 } else { 4.01 }));
            let pixel = &mut film.pixels[10 * SIZE[0] + 20];
            pixel.halves[0].media *= 100.0;
            if both {
                pixel.halves[1].media *= 100.0;
            }
            film
        };
        let [one, both] = [film(false), film(true)].map(|film| {
            let raw = raw(&film);
            reconstruct(&film, &raw).pixels()[10 * SIZE[0] + 20][1]
        });
        assert!((one - 1.0).abs() < 0.01, "{one}");
        assert!((both - 100.0).abs() < 1.0, "{both}");
    }

    /// Pixels of one ray, which belong to the halves by turns, are averaged as others are.
    #[test]
    fn pixels_of_one_ray_are_averaged() {
        let mut film = film(1, 0.25, 6, |x, _, noise| medium(noise * (1.0 + 0.01 * x), 0.5, 4.0));
        for (index, pixel) in film.pixels.iter_mut().enumerate() {
            let [x, y] = [index % SIZE[0], index / SIZE[0]];
            pixel.halves[(x + y) % 2] = Default::default();
            pixel.seen.media *= 0.5;
            pixel.seen.log_distance *= 0.5;
        }
        let raw = raw(&film);
        let light = |x: f64, _| 1.0 + 0.01 * x;
        let errors = [&raw, &reconstruct(&film, &raw)].map(|image| squared_error(image, light));
        assert!(errors[1] < 0.1 * errors[0], "{errors:?}");
    }

    /// Light of any size stays finite, and of its size.
    #[test]
    fn light_of_any_size_stays_what_it_is() {
        for size in [1e-35, 1e-18, 1e18, 1e35] {
            let film = film(1, 0.01, 7, |_, _, noise| medium(noise * size, 0.5, 4.0));
            let raw = raw(&film);
            for pixel in reconstruct(&film, &raw).pixels() {
                let relative = f64::from(pixel[1]) / size;
                assert!((0.5..1.5).contains(&relative), "{relative} of {size}");
            }
        }
    }

    /// A film without a ray, and one of a single pixel, are no trouble.
    #[test]
    fn nothing_and_one_pixel_stay_what_they_are() {
        let empty = ComponentFilm {
            width: 3,
            pixels: vec![PixelComponents::default(); 6],
            parts: Vec::new(),
        };
        let image = Image::new(3, 2, vec![[0.5; 3]; 6]);
        assert_eq!(reconstruct(&empty, &image).pixels(), image.pixels());
        let mut pixel = PixelComponents::default();
        for half in 0..2 {
            pixel.add(half, &medium(2.0, 0.5, 1.0));
        }
        let one = reconstruct(
            &ComponentFilm { width: 1, pixels: vec![pixel], parts: Vec::new() },
            &Image::new(1, 1, vec![[2.0; 3]]),
        );
        assert!((one.pixels()[0][0] - 2.0).abs() < 1e-5, "{:?}", one.pixels());
    }
}
