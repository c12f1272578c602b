//! Light of a picture and of its parts, filtered by the same weights.

use std::borrow::Cow;

use glam::Vec3A;

use super::Reconstruction;
use super::light::{LightOf, PictureLight, PixelLight, mean_components};
use crate::film::components::{LightPart, PixelComponents};
use crate::image::Image;

impl<'a> Reconstruction<'a> {
    /// All light of the picture `raw`, of which `emission` is visible emission, W/(m² sr).
    pub fn all_light(&'a self, raw: &Image, emission: &'a [[f32; 3]]) -> PictureLight<'a> {
        let sums = |pixel: usize| self.film.pixels[pixel].light();
        let specular = self.specular_light(&sums, |pixel| raw.pixels()[pixel].into(), emission);
        let filtered = Cow::Borrowed(&self.filtered);
        PictureLight { part: None, emission, filtered, specular }
    }

    /// A part of the light of the picture.
    pub fn light_of(&self, part: &'a LightPart) -> PictureLight<'a> {
        let sums = |pixel: usize| part.sums[pixel];
        let radiance = |pixel: usize| {
            let [a, b] = part.sums[pixel];
            Vec3A::from(a.radiance + b.radiance) / self.film.pixels[pixel].rays()
        };
        let specular = self.specular_light(&sums, radiance, &part.emission);
        let filtered = Cow::Owned(self.filter.apply(self.film, &self.surfaces, &sums));
        PictureLight { part: Some(part), emission: &part.emission, filtered, specular }
    }

    /// What mirrors and glass show in each pixel of light with these `sums`, whose mean is `radiance` with the visible
    /// `emission`, W/(m² sr).
    fn specular_light(
        &self,
        sums: LightOf<'_>,
        radiance: impl Fn(usize) -> Vec3A,
        emission: &[[f32; 3]],
    ) -> Vec<Vec3A> {
        let rest = |(index, (pixel, emission)): (usize, (&PixelComponents, &[f32; 3]))| {
            if pixel.seen.specular == 0.0 {
                return Vec3A::ZERO;
            }
            let components = mean_components(&sums(index), pixel.rays()).total();
            radiance(index) - Vec3A::from_array(*emission) - components
        };
        self.film.pixels.iter().zip(emission).enumerate().map(rest).collect()
    }

    /// How many pixels there are.
    pub fn pixels(&self) -> usize {
        self.film.pixels.len()
    }

    /// A pixel of `light` where it is not [antialiased](Self::antialiased); `None` where it has no ray.
    pub fn pixel(&self, light: &PictureLight<'_>, pixel: usize) -> Option<PixelLight> {
        let emission = light.emission[pixel].into();
        let components = light.filtered.mean.of_pixel(pixel);
        let specular = light.specular[pixel];
        let is_known = self.film.pixels[pixel].rays() > 0.0;
        is_known.then_some(PixelLight { emission, specular, ..components })
    }

    /// What reconstruction adds to a pixel of all light where it is not antialiased.
    pub(super) fn change(&self, pixel: usize) -> Vec3A {
        let components = &self.film.pixels[pixel];
        if components.rays() == 0.0 {
            return Vec3A::ZERO;
        }
        let rendered = mean_components(&components.light(), components.rays());
        (self.filtered.mean.of_pixel(pixel) - rendered).total()
    }
}

#[cfg(test)]
mod tests {
    use std::ops::Add;

    use glam::DVec3;

    use super::*;
    use crate::film::components::{ComponentFilm, LightSums};
    use crate::film::reconstruct::tests::{SIZE, film, floor, raw};
    use crate::film::{Components, Sample, Seen, VisibleSurface};
    use crate::math::{Rgb, Stage, Stream};

    /// Smoke before a floor, half of it a mirror, in noise.
    fn scene(x: f64, y: f64, noise: f64) -> Sample {
        let reflectance = Rgb::splat(0.5);
        let surface = VisibleSurface { offset: floor(x, y), normal: DVec3::Y, reflectance };
        let is_mirror = x < 12.0;
        let light = |light: f64| if is_mirror { Rgb::ZERO } else { Rgb::splat(light * noise) };
        Sample {
            components: Components {
                media: Rgb::new(noise, 0.5 * noise, 0.02 * x * noise),
                direct: light(0.7),
                indirect: light(0.1 + 0.01 * y),
            },
            seen: Seen {
                surface: (!is_mirror).then_some(surface),
                specular: is_mirror,
                media_distance: Some(4.0 + 0.1 * x),
            },
            transmittance: 0.5 + 0.005 * y,
            ..Sample::default()
        }
    }

    /// Three parts of the light of a film, by random shares of each pixel, half and component; those of the last are negative in
    /// some. Together they are all of it.
    fn parts(film: &ComponentFilm) -> Vec<LightPart> {
        let mut parts = [0, 1, 2].map(|number| LightPart::new(number, film.pixels.len()));
        let mut rng = Stream::new(31, Stage::Test, 0, 0);
        for (pixel, of_pixel) in film.pixels.iter().enumerate() {
            for (half, light) in of_pixel.light().into_iter().enumerate() {
                let mut left = light;
                for part in &mut parts[..2] {
                    let mut share = || 0.6 * rng.uniform() as f32;
                    let sums = &mut part.sums[pixel][half];
                    sums.media = left.media * share();
                    sums.direct = left.direct * share();
                    sums.indirect = left.indirect * share();
                    sums.radiance = sums.media + sums.direct + sums.indirect;
                    left.media -= sums.media;
                    left.direct -= sums.direct;
                    left.indirect -= sums.indirect;
                }
                left.radiance = left.media + left.direct + left.indirect;
                parts[2].sums[pixel][half] = left;
            }
        }
        parts.into()
    }

    #[test]
    fn parts_add_up_to_the_light_that_is_reconstructed() {
        let mut film = film(2, 0.3, 30, scene);
        // Outliers are darkened in parts as in the whole.
        film.pixels[7 * SIZE[0] + 30].halves[0].media *= 50.0;
        film.pixels[9 * SIZE[0] + 20].halves[1].direct *= 50.0;
        let (reconstruction, parts) = (Reconstruction::new(&film), parts(&film));
        let dark = vec![[0.0; 3]; film.pixels.len()];
        let raw = raw(&film);
        let all = reconstruction.all_light(&raw, &dark);
        let parts: Vec<_> = parts.iter().map(|part| reconstruction.light_of(part)).collect();
        for pixel in 0..film.pixels.len() {
            let whole = reconstruction.pixel(&all, pixel).unwrap();
            let light = parts.iter().map(|part| reconstruction.pixel(part, pixel).unwrap());
            let off = whole - light.fold(PixelLight::default(), Add::add);
            for off in [off.media, off.direct, off.indirect, off.emission, off.specular] {
                assert!(off.abs().max_element() < 1e-4 * whole.total().max_element(), "{off}");
            }
        }
    }

    /// A part with the same share of all light everywhere is that share of what the whole becomes.
    #[test]
    fn parts_take_the_weights_of_the_whole() {
        let film = film(2, 0.3, 32, scene);
        let reconstruction = Reconstruction::new(&film);
        let mut part = LightPart::new(0, film.pixels.len());
        for (sums, pixel) in part.sums.iter_mut().zip(&film.pixels) {
            *sums = pixel.light().map(|light| LightSums {
                radiance: 0.25 * light.radiance,
                media: 0.25 * light.media,
                direct: 0.25 * light.direct,
                indirect: 0.25 * light.indirect,
            });
        }
        let dark = vec![[0.0; 3]; film.pixels.len()];
        let raw = raw(&film);
        let (all, part) = (reconstruction.all_light(&raw, &dark), reconstruction.light_of(&part));
        for pixel in 0..film.pixels.len() {
            let [whole, part] = [&all, &part].map(|of| reconstruction.pixel(of, pixel).unwrap());
            let off = part.total() - 0.25 * whole.total();
            assert!(off.abs().max_element() < 1e-5 * whole.total().max_element(), "{off}");
        }
    }
}
