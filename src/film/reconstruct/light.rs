//! Light of a picture, all of it or a part: as its rays bring it, filtered, and of single pixels by component.

use std::borrow::Cow;
use std::ops::{Add, Mul, Sub};

use glam::{Vec3, Vec3A};

use super::Reconstruction;
use crate::film::components::{ComponentFilm, LightSums, PixelComponents};
use crate::image::Image;

/// The light of both halves of the pixel of this index, as sums over its rays.
pub(super) type LightOf<'a> = &'a (dyn Fn(usize) -> [LightSums; 2] + Sync);

/// A part of the light of a picture as its rays bring it: that of a group of emitters, or of an order of scattering.
#[derive(Debug, Clone)]
pub struct LightPart {
    /// Its number among the parts.
    pub number: usize,
    /// Light of each pixel, row by row from the top.
    pub sums: Vec<[LightSums; 2]>,
    /// Mean visible emission of each pixel, W/(m² sr).
    pub emission: Vec<[f32; 3]>,
}

impl LightPart {
    /// The part of this number of a picture of this many pixels, without light.
    pub fn new(number: usize, pixels: usize) -> Self {
        let sums = vec![Default::default(); pixels];
        Self { number, sums, emission: vec![[0.0; 3]; pixels] }
    }
}

/// Bytes of a pixel that each part of the light takes beside what reconstruction takes of all light: its sums, filtered light of
/// three components in mean and halves, and what mirrors and glass show.
///
/// Unit: bytes. Derivation: from the sizes of what is held.
pub const PART_BYTES: usize =
    2 * size_of::<LightSums>() + size_of::<[f32; 3]>() + (3 * 3 + 1) * size_of::<Vec3A>();

/// Light of each pixel with less noise, W/(m² sr).
#[derive(Debug, Clone)]
pub(super) struct FilteredLight {
    /// By both halves.
    pub mean: FilteredComponents,
    /// By each half.
    pub halves: [FilteredComponents; 2],
}

/// Light of each pixel with less noise, by component, W/(m² sr).
#[derive(Debug, Clone)]
pub(super) struct FilteredComponents {
    /// Of media.
    pub media: Vec<Vec3A>,
    /// That surfaces reflect straight from lights.
    pub direct: Vec<Vec3A>,
    /// That surfaces reflect of photons.
    pub indirect: Vec<Vec3A>,
}

impl FilteredComponents {
    /// What the surface in this pixel reflects.
    pub fn reflected(&self, pixel: usize) -> Vec3A {
        self.direct[pixel] + self.indirect[pixel]
    }

    /// Light of a pixel.
    pub fn of_pixel(&self, pixel: usize) -> PixelLight {
        let [media, direct, indirect] =
            [&self.media, &self.direct, &self.indirect].map(|light| light[pixel]);
        PixelLight { media, direct, indirect, ..PixelLight::default() }
    }
}

/// Light of a picture, all of it or a part, as it is rendered and filtered.
#[derive(Debug)]
pub struct PictureLight<'a> {
    /// The part, where it is one.
    pub(super) part: Option<&'a LightPart>,
    /// Mean visible emission of each pixel, W/(m² sr).
    emission: &'a [[f32; 3]],
    pub(super) filtered: Cow<'a, FilteredLight>,
    /// What mirrors and glass show in each pixel, W/(m² sr).
    pub(super) specular: Vec<Vec3A>,
}

impl PictureLight<'_> {
    /// Sums over the rays of both halves of a pixel, of whose picture `film` has the components.
    pub(super) fn sums(&self, film: &ComponentFilm, pixel: usize) -> [LightSums; 2] {
        self.part.map_or_else(|| film.pixels[pixel].light(), |part| part.sums[pixel])
    }
}

/// Light of one pixel or ray by component, W/(m² sr).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PixelLight {
    /// Of media.
    pub media: Vec3A,
    /// Direct light of surfaces.
    pub direct: Vec3A,
    /// Indirect light of surfaces.
    pub indirect: Vec3A,
    /// Visible emission of surfaces and of the environment.
    pub emission: Vec3A,
    /// What mirrors and glass show.
    pub specular: Vec3A,
}

impl PixelLight {
    /// Of all components.
    pub fn total(self) -> Vec3A {
        self.emission + self.media + (self.direct + self.indirect) + self.specular
    }

    /// `f` of each component of both.
    fn each(self, other: Self, f: impl Fn(Vec3A, Vec3A) -> Vec3A) -> Self {
        Self {
            media: f(self.media, other.media),
            direct: f(self.direct, other.direct),
            indirect: f(self.indirect, other.indirect),
            emission: f(self.emission, other.emission),
            specular: f(self.specular, other.specular),
        }
    }
}

impl Add for PixelLight {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        self.each(other, Add::add)
    }
}

impl Sub for PixelLight {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self.each(other, Sub::sub)
    }
}

impl Mul<f32> for PixelLight {
    type Output = Self;
    fn mul(self, factor: f32) -> Self {
        self.each(self, |light, _| light * factor)
    }
}

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

/// Mean light of each component in the `sums` over so many rays.
pub(super) fn mean_components([a, b]: &[LightSums; 2], rays: f32) -> PixelLight {
    let mean = |a: Vec3, b: Vec3| Vec3A::from(a + b) / rays;
    PixelLight {
        media: mean(a.media, b.media),
        direct: mean(a.direct, b.direct),
        indirect: mean(a.indirect, b.indirect),
        ..PixelLight::default()
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
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
