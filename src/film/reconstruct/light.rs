//! Light of a picture, all of it or a part: as its rays bring it, filtered, and of single pixels by component.

use std::borrow::Cow;
use std::ops::{Add, Mul, Sub};

use glam::{Vec3, Vec3A};

use crate::film::components::{ComponentFilm, LightPart, LightSums};

/// The light of both halves of the pixel of this index, as sums over its rays.
pub(super) type LightOf<'a> = &'a (dyn Fn(usize) -> [LightSums; 2] + Sync);

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
    pub(super) emission: &'a [[f32; 3]],
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
