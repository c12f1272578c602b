//! Antialiasing of pixels at edges: visibility rays look up filtered light in the pixels around, and rays of the picture
//! correct what is systematically wrong with it.

use glam::{Vec3, Vec3A};

use super::Reconstruction;
use super::light::{FilteredComponents, PictureLight, PixelLight};
use super::scale::{DARKEST, box_means, box_sums};
use super::visibility::VisibilityRay;

/// Pixels on each side over which the agreement of both halves is averaged.
///
/// Unit: pixels. Limit: on how far an edge decides for others: a contact shadow is as narrow.
pub(super) const AGREEMENT_RADIUS: usize = 2;

/// A pixel by visibility rays.
#[derive(Debug, Clone, Copy)]
pub struct Antialiased {
    /// Its index.
    pub pixel: usize,
    /// Its light.
    light: PixelLight,
    /// What rays of each half of the picture have brought less what looking up along the same rays gives; `None` without
    /// rays.
    residuals: [Option<PixelLight>; 2],
}

impl Antialiased {
    /// Its light with a share of the mean residual of both halves.
    pub fn corrected(&self, share: f32) -> PixelLight {
        let [a, b] = self.residuals.map(Option::unwrap_or_default);
        self.light + (a + b) * (0.5 * share)
    }
}

impl Reconstruction<'_> {
    /// The `light` of `pixel` along `rays`, some of which may be rays of the picture. `None` where no pixel around has the
    /// light of what a ray hits.
    pub fn antialiased(
        &self,
        light: &PictureLight<'_>,
        pixel: usize,
        rays: &[VisibilityRay],
    ) -> Option<Antialiased> {
        let sees_specular = rays.iter().any(|ray| ray.specular);
        let specular = if sees_specular { self.specular_of(light, pixel) } else { None };
        let along = |filtered: &FilteredComponents, ray: &VisibilityRay| {
            let mut along = self.light_along(light, filtered, pixel, ray)?;
            if ray.specular {
                along.specular = specular?;
            }
            Some(along)
        };
        let mut sum = PixelLight::default();
        let mut of_halves = [(PixelLight::default(), 0.0); 2];
        for ray in rays {
            sum = sum + along(&light.filtered.mean, ray)?;
            if let Some(half) = ray.half {
                let (sum, count) = &mut of_halves[half];
                *sum = *sum + along(&light.filtered.halves[half], ray)?;
                *count += 1.0;
            }
        }
        let residual = |half: usize| {
            let (sum, count) = of_halves[half];
            let rays = self.film.pixels[pixel].halves[half].rays;
            let rendered = || self.rendered(light, pixel, half);
            (count > 0.0 && rays > 0.0).then(|| rendered() - sum * (1.0 / count))
        };
        let residuals = [residual(0), residual(1)];
        Some(Antialiased { pixel, light: sum * (1.0 / rays.len() as f32), residuals })
    }

    /// The `light` of `pixel` as rays of a half bring it. What is in no component is of mirrors or glass where the pixel
    /// sees any.
    fn rendered(&self, light: &PictureLight<'_>, pixel: usize, half: usize) -> PixelLight {
        let components = &self.film.pixels[pixel];
        let sums = light.sums(self.film, pixel)[half];
        let mean = |sum: Vec3| Vec3A::from(sum) / components.halves[half].rays;
        let rest = mean(sums.radiance - sums.media - sums.direct - sums.indirect);
        let [emission, specular] =
            if components.seen.specular > 0.0 { [Vec3A::ZERO, rest] } else { [rest, Vec3A::ZERO] };
        let [media, direct, indirect] = [sums.media, sums.direct, sums.indirect].map(mean);
        PixelLight { media, direct, indirect, emission, specular }
    }

    /// The share of the mean residual of both halves that each of `all` takes of all light: the product of their residuals,
    /// which is the squared bias in the mean, less its standard error, over the square of their mean, which holds the noise
    /// too, both summed over the pixels around (shrinkage by James and Stein 1961, "Estimation with Quadratic Loss").
    pub fn residual_shares(&self, all: &[Antialiased]) -> Vec<f32> {
        let none = vec![0.0; self.film.pixels.len()];
        let around = |of: Vec<f32>| box_sums(self.film.width, &of, AGREEMENT_RADIUS);
        let mut squares = none.clone();
        all.iter().for_each(|of| squares[of.pixel] = of.light.total().length_squared());
        let squares = box_means(self.film.width, &squares, AGREEMENT_RADIUS);
        let [mut agreed, mut agreed_squares, mut noisy] = [none.clone(), none.clone(), none];
        for &Antialiased { pixel, light, residuals } in all {
            let [Some(a), Some(b)] = residuals.map(|of| of.map(PixelLight::total)) else {
                continue;
            };
            let scale = light.total().length_squared() + DARKEST * squares[pixel];
            let product = a.dot(b) / scale;
            let square = (0.5 * (a + b)).length_squared() / scale;
            if (product * product).is_finite() && square.is_finite() {
                (agreed[pixel], agreed_squares[pixel]) = (product, product * product);
                noisy[pixel] = square;
            }
        }
        let [agreed, agreed_squares, noisy] = [agreed, agreed_squares, noisy].map(around);
        let share = |of: &Antialiased| {
            let sure = agreed[of.pixel] - agreed_squares[of.pixel].sqrt();
            if sure > 0.0 { (sure / noisy[of.pixel]).min(1.0) } else { 0.0 }
        };
        all.iter().map(share).collect()
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::super::tests::{DARK, SIZE, all_light, film, floor, medium, raw, surface};
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
                emission_parts: None,
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

    /// Smoke with a hard edge in front of a sky.
    fn smoke(x: f64, y: f64) -> Sample {
        let sky = |transmittance: f64| crate::math::Rgb::splat(7.0 * transmittance);
        if y + 0.3 * x < 20.0 {
            Sample { visible_emission: sky(0.2), ..medium(3.0 * 0.8, 0.8, 4.0) }
        } else {
            Sample { visible_emission: sky(1.0), ..Sample::default() }
        }
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
        let scenes: [Scene<'_>; 5] = [&corner, &roof, &fog, &smoke, &glow];
        for scene in scenes {
            let film = coarse(scene);
            let reconstruction = Reconstruction::new(&film);
            let light = all_light(&reconstruction);
            let edges = reconstruction.edges();
            assert!((SIZE[0]..4 * SIZE[0]).contains(&edges.len()), "{} edges", edges.len());
            for pixel in edges {
                let antialiased = reconstruction.antialiased(&light, pixel, &rays(scene, pixel));
                let found = antialiased.unwrap().corrected(0.0).total();
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
        let light = all_light(&reconstruction);
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
                reconstruction.antialiased(&light, pixel, &rays).unwrap()
            })
            .collect();
        for (of, share) in all.iter().zip(reconstruction.residual_shares(&all)) {
            let expected = expected(clean, of.pixel);
            for (error, share) in errors.iter_mut().zip([0.0, share]) {
                let found = of.corrected(share).total();
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
        let light = reconstruction.all_light(&raw, DARK);
        for pixel in reconstruction.edges() {
            let rays = rays(&scene, pixel);
            let share = rays.iter().filter(|ray| ray.specular).count() as f64 / rays.len() as f64;
            let expected = 4.0 * share + expected(&scene, pixel);
            let found = reconstruction.antialiased(&light, pixel, &rays);
            let found = found.unwrap().corrected(0.0).total();
            assert!((f64::from(found.x) - expected).abs() < 1e-3 * expected, "{found}, {expected}");
        }
    }

    #[test]
    fn a_surface_that_no_pixel_has_seen_leaves_its_pixel() {
        let film = coarse(&|_, _| Sample::default());
        let reconstruction = Reconstruction::new(&film);
        assert!(reconstruction.edges().is_empty());
        let light = all_light(&reconstruction);
        assert!(reconstruction.antialiased(&light, 100, &rays(&corner, 100)).is_none());
    }
}
