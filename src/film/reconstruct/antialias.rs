//! Antialiasing of pixels at edges: visibility rays look up filtered light in the pixels around, and rays of the picture
//! correct what is systematically wrong with it.

use glam::Vec3A;

use super::edges::mean_reflectance;
use super::levels::around;
use super::media::OPACITY_STEP;
use super::scale::{DARKEST, box_means, box_sums};
use super::surfaces::{SurfaceFeatures, ratio};
use super::{FilteredLight, Reconstruction};
use crate::film::sample::VisibleSurface;

/// Likeness of all neighbours of a surface below which its light is not known from them.
///
/// Unit: none. Limit: on what the light of another surface counts.
const LEAST_LIKENESS: f32 = 1e-3;

/// Pixels on each side over which the agreement of both halves is averaged.
///
/// Unit: pixels. Limit: on how far an edge decides for others: a contact shadow is as narrow.
pub(super) const AGREEMENT_RADIUS: usize = 2;

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
    /// Opacity of media.
    pub opacity: f32,
}

/// A pixel by visibility rays.
#[derive(Debug, Clone, Copy)]
pub struct Antialiased {
    /// Its index.
    pub pixel: usize,
    /// Its radiance, W/(m² sr).
    pub radiance: Vec3A,
    /// What rays of each half of the picture have brought less what looking up along the same rays gives, W/(m² sr);
    /// `None` without rays.
    residuals: [Option<Vec3A>; 2],
}

/// A pixel and how much it counts.
struct Neighbour {
    pixel: usize,
    weight: f32,
}

impl Reconstruction<'_> {
    /// The radiance of `pixel` along `rays`, some of which may be rays of the picture; `specular` is [what mirrors and
    /// glass show](Self::specular_light). `None` where no pixel around has the light of what a ray hits.
    pub fn antialiased(
        &self,
        pixel: usize,
        rays: &[VisibilityRay],
        specular: &[Vec3A],
    ) -> Option<Antialiased> {
        let sees_specular = rays.iter().any(|ray| ray.specular);
        let specular = if sees_specular { self.specular_of(pixel, specular) } else { None };
        let mut radiance = Vec3A::ZERO;
        let mut of_halves = [(Vec3A::ZERO, 0.0); 2];
        for ray in rays {
            radiance += self.radiance_along(&self.mean, pixel, ray, specular)?;
            if let Some(half) = ray.half {
                let (sum, count) = &mut of_halves[half];
                *sum += self.radiance_along(&self.halves[half], pixel, ray, specular)?;
                *count += 1.0;
            }
        }
        let residual = |half: usize| {
            let (sums, (sum, count)) = (&self.film.pixels[pixel].halves[half], of_halves[half]);
            let rendered = Vec3A::from(sums.radiance) / sums.rays;
            (count > 0.0 && sums.rays > 0.0).then(|| rendered - sum / count)
        };
        let residuals = [residual(0), residual(1)];
        Some(Antialiased { pixel, radiance: radiance / rays.len() as f32, residuals })
    }

    /// The radiance of `all` with a share of the mean residual of both halves: the product of their residuals, which is the
    /// squared bias in the mean, less its standard error, over the square of their mean, which holds the noise too, both
    /// summed over the pixels around (shrinkage by James and Stein 1961, "Estimation with Quadratic Loss").
    pub(super) fn corrected(&self, all: &[Antialiased]) -> Vec<Vec3A> {
        let none = vec![0.0; self.film.pixels.len()];
        let around = |of: Vec<f32>| box_sums(self.film.width, &of, AGREEMENT_RADIUS);
        let mut squares = none.clone();
        all.iter().for_each(|of| squares[of.pixel] = of.radiance.length_squared());
        let squares = box_means(self.film.width, &squares, AGREEMENT_RADIUS);
        let [mut agreed, mut agreed_squares, mut noisy] = [none.clone(), none.clone(), none];
        for &Antialiased { pixel, radiance, residuals } in all {
            let [Some(a), Some(b)] = residuals else { continue };
            let scale = radiance.length_squared() + DARKEST * squares[pixel];
            let product = a.dot(b) / scale;
            let square = (0.5 * (a + b)).length_squared() / scale;
            if (product * product).is_finite() && square.is_finite() {
                (agreed[pixel], agreed_squares[pixel]) = (product, product * product);
                noisy[pixel] = square;
            }
        }
        let [agreed, agreed_squares, noisy] = [agreed, agreed_squares, noisy].map(around);
        let corrected = |of: &Antialiased| {
            let sure = agreed[of.pixel] - agreed_squares[of.pixel].sqrt();
            let share = if sure > 0.0 { (sure / noisy[of.pixel]).min(1.0) } else { 0.0 };
            let [a, b] = of.residuals.map(|residual| residual.unwrap_or(Vec3A::ZERO));
            of.radiance + share * 0.5 * (a + b)
        };
        all.iter().map(corrected).collect()
    }

    /// The radiance along a ray through `pixel` by `filtered` light, W/(m² sr).
    fn radiance_along(
        &self,
        filtered: &FilteredLight,
        pixel: usize,
        ray: &VisibilityRay,
        specular: Option<Vec3A>,
    ) -> Option<Vec3A> {
        let light = ray.emission + self.media_along(filtered, pixel, ray);
        Some(match &ray.surface {
            Some(surface) => {
                let reflectance = Vec3A::from(surface.reflectance.as_vec3());
                light + reflectance * self.irradiance(filtered, pixel, surface, ray.place)?
            }
            None if ray.specular => light + specular?,
            None => light,
        })
    }

    /// The pixels of 3 x 3 around `pixel`, of which those further from `place` count less.
    fn near(&self, pixel: usize, place: [f32; 2]) -> impl Iterator<Item = Neighbour> {
        around(self.film.size(), pixel).map(move |(pixel, at)| {
            let [x, y] = [0, 1].map(|axis| (REACH - (at[axis] - place[axis]).abs()).max(0.0));
            Neighbour { pixel, weight: x * y }
        })
    }

    /// Light of media along a ray through `pixel`.
    fn media_along(&self, filtered: &FilteredLight, pixel: usize, ray: &VisibilityRay) -> Vec3A {
        let (mut sum, mut weights) = (Vec3A::ZERO, 0.0);
        for Neighbour { pixel, weight } in self.near(pixel, ray.place) {
            let opacity = self.film.pixels[pixel].opacity();
            let steps = (ray.opacity - opacity) / OPACITY_STEP;
            let weight = weight / (1.0 + steps * steps);
            // Media that only emit have none.
            let taken = if opacity > 0.0 { ray.opacity / opacity } else { 1.0 };
            sum += weight * taken.min(MOST_OPACITY) * filtered.media[pixel];
            weights += weight;
        }
        sum / weights
    }

    /// Reflected light over reflectance at a surface that a ray through `pixel` sees at `place`.
    fn irradiance(
        &self,
        filtered: &FilteredLight,
        pixel: usize,
        surface: &VisibleSurface,
        place: [f32; 2],
    ) -> Option<Vec3A> {
        let [offset, normal] =
            [surface.offset, surface.normal].map(|vector| Vec3A::from(vector.as_vec3()));
        let (mut light, mut reflectance, mut weights) = (Vec3A::ZERO, Vec3A::ZERO, 0.0);
        for Neighbour { pixel, weight } in self.near(pixel, place) {
            let Some(there) = &self.surfaces[pixel] else { continue };
            let here = SurfaceFeatures { offset, normal, spacing: there.spacing };
            let weight = weight * here.likeness(there, 1.0);
            light += weight * filtered.reflected[pixel];
            reflectance += weight * mean_reflectance(&self.film.pixels[pixel]);
            weights += weight;
        }
        if weights > LEAST_LIKENESS {
            return Some(ratio(light, reflectance));
        }
        let own = &self.film.pixels[pixel];
        (own.seen.surfaces > 0.0).then(|| {
            let light = own.halves[0].direct + own.halves[0].indirect;
            let light = light + own.halves[1].direct + own.halves[1].indirect;
            ratio(light.into(), own.rays() * mean_reflectance(own))
        })
    }

    /// What a mirror or glass in `pixel` shows, or in the pixels around where it sees none.
    fn specular_of(&self, pixel: usize, specular: &[Vec3A]) -> Option<Vec3A> {
        let add = |(sum, count): (Vec3A, f32), pixel: usize| {
            let components = &self.film.pixels[pixel];
            (sum + specular[pixel] * components.rays(), count + components.seen.specular)
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

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::super::tests::{SIZE, film, floor, medium, raw, surface};
    use super::*;
    use crate::film::{ComponentFilm, Sample};
    use crate::image::Image;
    use crate::math::{Stage, Stream};

    /// What is seen at a place of the film.
    type Scene<'a> = &'a dyn Fn(f64, f64) -> Sample;

    /// A film of one ray of each half in the centre of each pixel.
    fn coarse(scene: Scene<'_>) -> ComponentFilm {
        film(1, 0.0, 0, |x, y, _| scene(x, y))
    }

    /// Visibility rays through a pixel, on a grid of 4 x 4.
    fn rays(scene: Scene<'_>, pixel: usize) -> Vec<VisibilityRay> {
        let ray = |index: usize| {
            let place = [index % 4, index / 4].map(|at| (at as f32 + 0.5) / 4.0 - 0.5);
            let [x, y] = [pixel % SIZE[0], pixel / SIZE[0]].map(|at| at as f64);
            let Sample { seen, transmittance, visible_emission, .. } =
                scene(x + f64::from(place[0]), y + f64::from(place[1]));
            VisibilityRay {
                half: None,
                place,
                surface: seen.surface,
                specular: seen.specular,
                emission: visible_emission.as_vec3().into(),
                opacity: (1.0 - transmittance) as f32,
            }
        };
        (0..16).map(ray).collect()
    }

    /// Mean radiance of the same rays.
    fn expected(scene: Scene<'_>, pixel: usize) -> f64 {
        let [x, y] = [pixel % SIZE[0], pixel / SIZE[0]].map(|at| at as f64);
        let at = |index: usize| {
            let [right, down] = [index % 4, index / 4].map(|at| (at as f64 + 0.5) / 4.0 - 0.5);
            let sample = scene(x + right, y + down);
            let light = sample.components;
            (light.media + light.direct + light.indirect + sample.visible_emission).x
        };
        (0..16).map(at).sum::<f64>() / 16.0
    }

    /// A wall above a slanted line, and a floor below it.
    fn corner(x: f64, y: f64) -> Sample {
        if y + 0.3 * x < 20.0 {
            surface(5.0, DVec3::new(x, 0.0, 30.0), DVec3::Z, 0.2)
        } else {
            surface(2.0, floor(x, y), DVec3::Y, 0.6)
        }
    }

    /// The same wall in front of a sky.
    fn roof(x: f64, y: f64) -> Sample {
        let sky = Sample { visible_emission: crate::math::Rgb::splat(7.0), ..Sample::default() };
        if y + 0.3 * x < 20.0 { sky } else { corner(x, y - 40.0) }
    }

    /// Fog between the camera and both of them, thicker in front of the sky.
    fn fog(x: f64, y: f64) -> Sample {
        let (solid, opacity) = (roof(x, y), if y + 0.3 * x < 20.0 { 0.5 } else { 0.25 });
        let fog = medium(3.0 * opacity, opacity, 4.0);
        let mut sample = Sample { transmittance: fog.transmittance, ..solid };
        sample.components.media = fog.components.media;
        sample.seen.media_distance = fog.seen.media_distance;
        sample
    }

    /// A glow before them that hides nothing.
    fn glow(x: f64, y: f64) -> Sample {
        let mut sample = roof(x, y);
        sample.components.media = crate::math::Rgb::splat(2.0);
        sample.seen.media_distance = Some(4.0);
        sample
    }

    #[test]
    fn pixels_at_edges_show_what_their_rays_see() {
        let scenes: [Scene<'_>; 4] = [&corner, &roof, &fog, &glow];
        for scene in scenes {
            let film = coarse(scene);
            let reconstruction = Reconstruction::new(&film);
            let edges = reconstruction.edges();
            assert!((SIZE[0]..4 * SIZE[0]).contains(&edges.len()), "{} edges", edges.len());
            for pixel in edges {
                let antialiased = reconstruction.antialiased(pixel, &rays(scene, pixel), &[]);
                let found = antialiased.unwrap().radiance;
                let expected = expected(scene, pixel);
                let error = (f64::from(found.x) - expected).abs();
                assert!(error < 1e-3 * expected, "{found} for {expected} at {pixel}");
            }
        }
    }

    /// In a shadow as narrow as half a pixel, in noise: light that rays fetch is not theirs, which both halves tell.
    #[test]
    fn shadows_that_only_edges_see_are_kept() {
        let scene = |x: f64, y: f64, noise: f64| {
            if y < 15.75 {
                surface(1.0, DVec3::new(x, 0.0, 30.0), DVec3::Z, 0.5)
            } else {
                surface(if y < 16.5 { 0.1 } else { 4.0 } * noise, floor(x, y), DVec3::Y, 0.5)
            }
        };
        let clean: Scene<'_> = &|x, y| scene(x, y, 1.0);
        // Rays of each half on both sides of the edge.
        let mut film = film(1, 0.0, 10, |x, y, _| clean(x, y - 0.25));
        let mut rng = Stream::new(11, Stage::Test, 0, 0);
        for (index, pixel) in film.pixels.iter_mut().enumerate() {
            let [x, y] = [index % SIZE[0], index / SIZE[0]].map(|at| at as f64);
            for half in 0..2 {
                let sample = scene(x, y + 0.25, 0.9 + 0.2 * rng.uniform());
                let radiance = sample.components.direct;
                pixel.add(half, &Sample { radiance, ..sample });
            }
        }
        let reconstruction = Reconstruction::new(&film);
        let mut errors = [0.0; 2];
        let edges = reconstruction.edges();
        let all: Vec<Antialiased> = edges
            .iter()
            .map(|&pixel| {
                let mut rays = rays(clean, pixel);
                for (place, half) in [(-0.25, 0), (0.25, 0), (-0.25, 1), (0.25, 1)] {
                    let [x, y] = [pixel % SIZE[0], pixel / SIZE[0]].map(|at| at as f64);
                    let surface = clean(x, y + place).seen.surface;
                    let place = [0.0, place as f32];
                    rays.push(VisibilityRay { half: Some(half), place, surface, ..rays[0] });
                }
                reconstruction.antialiased(pixel, &rays, &[]).unwrap()
            })
            .collect();
        for (of, corrected) in all.iter().zip(reconstruction.corrected(&all)) {
            let expected = expected(clean, of.pixel);
            for (error, found) in errors.iter_mut().zip([of.radiance, corrected]) {
                *error += (f64::from(found.x) - expected).powi(2);
            }
        }
        assert!(errors[1] < 0.2 * errors[0], "{errors:?}");
    }

    #[test]
    fn mirrors_count_by_what_is_seen_of_them() {
        let scene = |x: f64, y: f64| {
            let mut sample = corner(x, y);
            if y + 0.3 * x < 20.0 {
                sample.seen = crate::film::Seen { specular: true, ..Default::default() };
                sample.components = Default::default();
            }
            sample
        };
        let film = coarse(&scene);
        let reconstruction = Reconstruction::new(&film);
        let solid = raw(&film);
        let mut pixels = solid.pixels().to_vec();
        for (light, pixel) in pixels.iter_mut().zip(&film.pixels) {
            let mirrored = 4.0 * pixel.seen.specular / pixel.rays();
            *light = light.map(|light| light + mirrored);
        }
        let raw = Image::new(SIZE[0], SIZE[1], pixels);
        let specular = reconstruction.specular_light(&raw, &[[0.0; 3]; SIZE[0] * SIZE[1]]);
        for pixel in reconstruction.edges() {
            let rays = rays(&scene, pixel);
            let share = rays.iter().filter(|ray| ray.specular).count() as f64 / rays.len() as f64;
            let expected = 4.0 * share + expected(&scene, pixel);
            let found = reconstruction.antialiased(pixel, &rays, &specular).unwrap().radiance;
            assert!((f64::from(found.x) - expected).abs() < 1e-3 * expected, "{found}, {expected}");
        }
    }

    #[test]
    fn a_surface_that_no_pixel_has_seen_leaves_its_pixel() {
        let film = coarse(&|_, _| Sample::default());
        let reconstruction = Reconstruction::new(&film);
        assert!(reconstruction.edges().is_empty());
        assert!(reconstruction.antialiased(100, &rays(&corner, 100), &[]).is_none());
    }
}
