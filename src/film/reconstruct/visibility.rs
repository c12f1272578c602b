//! What visibility rays see, and the light along them: filtered light of the pixels around.

use glam::Vec3A;

use super::Reconstruction;
use super::edges::mean_reflectance;
use super::levels::around;
use super::light::{FilteredComponents, PictureLight, PixelLight};
use super::media::OPACITY_STEP;
use super::surfaces::{SurfaceFeatures, ratio};
use crate::film::sample::VisibleSurface;
use crate::math::GroupParts;

/// Likeness of all neighbours of a surface below which its light is not known from them.
///
/// Unit: none. Limit: on what the light of another surface counts.
const LEAST_LIKENESS: f32 = 1e-3;

/// Distance along each axis from a ray beyond which pixels do not count.
///
/// Unit: pixels. Definition: of the square of 3 x 3 around a pixel.
const REACH: f32 = 1.5;

/// Factor up to which light of media is taken to another opacity.
///
/// Unit: none. Limit: on what is known of a medium that neighbours hardly see.
const MOST_OPACITY: f32 = 2.0;

/// What a visibility ray sees.
#[derive(Debug, Clone, Copy)]
pub struct VisibilityRay {
    /// The half of the picture that has a ray along it too, where one has.
    pub half: Option<usize>,
    /// Where it passes through the film, in pixels from the centre of its pixel.
    pub place: [f32; 2],
    /// The first surface, where it is diffuse.
    pub surface: Option<VisibleSurface>,
    /// Whether the first surface is a mirror or glass.
    pub specular: bool,
    /// Emission of surfaces and of the environment, W/(m² sr).
    pub emission: Vec3A,
    /// The parts of that, where light is told apart.
    pub emission_parts: Option<GroupParts>,
    /// Opacity of media.
    pub opacity: f32,
}

impl VisibilityRay {
    /// The emission that is in `light`.
    fn emission_in(&self, light: &PictureLight<'_>) -> Vec3A {
        let Some(part) = light.part else { return self.emission };
        self.emission_parts.map_or(Vec3A::ZERO, |parts| parts[part.number].into())
    }
}

/// A pixel and how much it counts.
struct Neighbour {
    pixel: usize,
    weight: f32,
}

impl Reconstruction<'_> {
    /// The `light` along a ray through `pixel`, by what is `filtered` of it, without that of mirrors and glass.
    pub(super) fn light_along(
        &self,
        light: &PictureLight<'_>,
        filtered: &FilteredComponents,
        pixel: usize,
        ray: &VisibilityRay,
    ) -> Option<PixelLight> {
        let mut along = PixelLight {
            emission: ray.emission_in(light),
            media: self.media_along(filtered, pixel, ray),
            ..PixelLight::default()
        };
        if let Some(surface) = &ray.surface {
            let reflectance = Vec3A::from(surface.reflectance.as_vec3());
            let irradiance = self.irradiance(light, filtered, pixel, (surface, ray.place))?;
            [along.direct, along.indirect] = irradiance.map(|light| reflectance * light);
        }
        Some(along)
    }

    /// The pixels of 3 x 3 around `pixel`, of which those further from `place` count less.
    fn near(&self, pixel: usize, place: [f32; 2]) -> impl Iterator<Item = Neighbour> {
        around(self.film.size(), pixel).map(move |(pixel, at)| {
            let [x, y] = [0, 1].map(|axis| (REACH - (at[axis] - place[axis]).abs()).max(0.0));
            Neighbour { pixel, weight: x * y }
        })
    }

    /// Light of media along a ray through `pixel`.
    fn media_along(
        &self,
        filtered: &FilteredComponents,
        pixel: usize,
        ray: &VisibilityRay,
    ) -> Vec3A {
        let (mut sum, mut weights) = (Vec3A::ZERO, 0.0);
        for Neighbour { pixel, weight } in self.near(pixel, ray.place) {
            let opacity = self.film.pixels[pixel].opacity();
            let sees_media = opacity > 0.0 || filtered.media[pixel] != Vec3A::ZERO;
            if !sees_media && ray.opacity > 0.0 {
                continue;
            }
            let steps = (ray.opacity - opacity) / OPACITY_STEP;
            let weight = weight / (1.0 + steps * steps);
            // Media that only emit have none.
            let taken = if opacity > 0.0 { ray.opacity / opacity } else { 1.0 };
            sum += weight * taken.min(MOST_OPACITY) * filtered.media[pixel];
            weights += weight;
        }
        if weights > 0.0 { sum / weights } else { filtered.media[pixel] }
    }

    /// Reflected `light`, direct and indirect, over reflectance at a surface that a ray through `pixel` sees at a place.
    fn irradiance(
        &self,
        light: &PictureLight<'_>,
        filtered: &FilteredComponents,
        pixel: usize,
        (surface, place): (&VisibleSurface, [f32; 2]),
    ) -> Option<[Vec3A; 2]> {
        let [offset, normal] =
            [surface.offset, surface.normal].map(|vector| Vec3A::from(vector.as_vec3()));
        let (mut sums, mut reflectance, mut weights) = ([Vec3A::ZERO; 2], Vec3A::ZERO, 0.0);
        for Neighbour { pixel, weight } in self.near(pixel, place) {
            let Some(there) = &self.surfaces[pixel] else { continue };
            let here = SurfaceFeatures { offset, normal, spacing: there.spacing };
            let weight = weight * here.likeness(there, 1.0);
            sums[0] += weight * filtered.direct[pixel];
            sums[1] += weight * filtered.indirect[pixel];
            reflectance += weight * mean_reflectance(&self.film.pixels[pixel]);
            weights += weight;
        }
        if weights > LEAST_LIKENESS {
            return Some(sums.map(|sum| ratio(sum, reflectance)));
        }
        let own = &self.film.pixels[pixel];
        (own.seen.surfaces > 0.0).then(|| {
            let [a, b] = light.sums(self.film, pixel);
            let reflectance = own.rays() * mean_reflectance(own);
            [a.direct + b.direct, a.indirect + b.indirect].map(|sum| ratio(sum.into(), reflectance))
        })
    }

    /// What a mirror or glass in `pixel` shows, or in the pixels around where it sees none.
    pub(super) fn specular_of(&self, light: &PictureLight<'_>, pixel: usize) -> Option<Vec3A> {
        let add = |(sum, count): (Vec3A, f32), pixel: usize| {
            let components = &self.film.pixels[pixel];
            (sum + light.specular[pixel] * components.rays(), count + components.seen.specular)
        };
        let none = (Vec3A::ZERO, 0.0);
        let (mut sum, mut count) = add(none, pixel);
        if count == 0.0 {
            let near = around(self.film.size(), pixel).map(|(near, _)| near);
            (sum, count) = near.fold(none, add);
        }
        (count > 0.0).then(|| sum / count)
    }
}
