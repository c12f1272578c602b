//! Light that surfaces reflect, over their reflectance, averaged over neighbours on the same plane.

use glam::{Vec3A, Vec4};
use rayon::prelude::*;

use super::levels::{
    Candidate, LEVELS, OutlierFactors, around, biweight, for_each_tap, outlier_factors,
};
use super::light::LightOf;
use crate::film::components::{ComponentFilm, PixelComponents};

/// Distance from a pixel's plane, in spacings of the taps, beyond which a neighbour does not count.
///
/// Unit: none. Derivation: planes of neighbours at 45 degrees differ by as much.
const PLANE_DISTANCE: f32 = 1.0;

/// Power of the cosine between normals by which neighbours count.
///
/// Unit: none. Source: Schied et al. 2017, "Spatiotemporal Variance-Guided Filtering", section 4.4.
const NORMAL_POWER: i32 = 128;

/// The surface that a pixel sees.
#[derive(Debug, Clone, Copy)]
pub(super) struct SurfaceFeatures {
    /// Where it is, in metres from the camera.
    pub offset: Vec3A,
    /// Its normal.
    pub normal: Vec3A,
    /// Distance in metres to the nearest of the neighbours' surfaces.
    pub spacing: f32,
}

impl SurfaceFeatures {
    /// How much `other`, `steps` spacings away, lies on the same plane: 1 where it does, 0 where it does not.
    pub fn likeness(&self, other: &Self, steps: f32) -> f32 {
        let between = other.offset - self.offset;
        let off = self.normal.dot(between).abs().max(other.normal.dot(between).abs());
        let facing = self.normal.dot(other.normal).max(0.0).powi(NORMAL_POWER);
        // One on its own has no spacing, and lies on its own plane.
        let near =
            if off == 0.0 { 1.0 } else { biweight(off / (PLANE_DISTANCE * self.spacing * steps)) };
        near * facing
    }
}

/// Bytes of a pixel's sums in both halves, before and after a level.
///
/// Unit: bytes. Derivation: from the sizes of what is held.
pub(super) const SUMS_BYTES: usize = 2 * size_of::<[Sums; 2]>();

/// Sums of one half over pixels.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    direct: Vec3A,
    indirect: Vec3A,
    reflectance: Vec3A,
}

impl Sums {
    fn add(&mut self, weight: f32, other: &Self) {
        self.direct += weight * other.direct;
        self.indirect += weight * other.indirect;
        self.reflectance += weight * other.reflectance;
    }
}

/// Sums of the pixels themselves.
fn pixels(film: &ComponentFilm, light: LightOf<'_>) -> Vec<[Sums; 2]> {
    let of_pixel = |(index, pixel): (usize, &PixelComponents)| {
        let light = light(index);
        [0, 1].map(|half| {
            let [direct, indirect] = [light[half].direct, light[half].indirect].map(Vec3A::from);
            Sums { direct, indirect, reflectance: pixel.halves[half].reflectance.into() }
        })
    };
    film.pixels.par_iter().enumerate().map(of_pixel).collect()
}

/// Direct and indirect `light` of surfaces at all levels, from that of the pixels on, with `outliers` of each darkened.
pub(super) fn candidates(
    film: &ComponentFilm,
    surfaces: &[Option<SurfaceFeatures>],
    light: LightOf<'_>,
    outliers: [&OutlierFactors; 2],
) -> [Vec<Candidate>; 2] {
    let size = film.size();
    let mut sums = pixels(film, light);
    for half in 0..2 {
        let factors = outliers[0][half].iter().zip(&outliers[1][half]);
        for (sums, (direct, indirect)) in sums.iter_mut().zip(factors) {
            sums[half].direct *= *direct;
            sums[half].indirect *= *indirect;
        }
    }
    let mut all = [Vec::new(), Vec::new()];
    let mut push = |sums: &[[Sums; 2]], filtered: bool| {
        all[0].push(candidate(film, sums, |sums| sums.direct, filtered));
        all[1].push(candidate(film, sums, |sums| sums.indirect, filtered));
    };
    push(&sums, false);
    for level in 0..LEVELS {
        let step = 1 << level;
        let averaged = |pixel: usize| average(surfaces, &sums, size, pixel, step);
        sums = (0..film.pixels.len()).into_par_iter().map(averaged).collect();
        push(&sums, true);
    }
    all
}

/// The surfaces that pixels see.
pub(super) fn surfaces(film: &ComponentFilm) -> Vec<Option<SurfaceFeatures>> {
    let size = film.size();
    let seen = |pixel: &PixelComponents| {
        let seen = &pixel.seen;
        let normal = Vec3A::from(seen.normal).try_normalize()?;
        Some(SurfaceFeatures {
            offset: Vec3A::from(seen.offset) / seen.surfaces,
            normal,
            spacing: 0.0,
        })
    };
    let mut surfaces: Vec<Option<SurfaceFeatures>> = film.pixels.par_iter().map(seen).collect();
    let spacing = |pixel: usize| {
        let here = surfaces[pixel]?.offset;
        let beside = around(size, pixel).filter(|(_, [x, y])| x.abs() + y.abs() == 1.0);
        let distances = beside.filter_map(|(near, _)| Some(surfaces[near]?.offset.distance(here)));
        distances.min_by(f32::total_cmp)
    };
    let spacings: Vec<Option<f32>> = (0..film.pixels.len()).into_par_iter().map(spacing).collect();
    for (surface, spacing) in surfaces.iter_mut().zip(spacings) {
        if let (Some(surface), Some(spacing)) = (surface, spacing) {
            surface.spacing = spacing;
        }
    }
    surfaces
}

/// Factors by which outliers of direct and of indirect light of surfaces are darkened.
pub(super) fn outliers(film: &ComponentFilm) -> [OutlierFactors; 2] {
    let sums = pixels(film, &|pixel| film.pixels[pixel].light());
    let light: [fn(&Sums) -> Vec3A; 2] = [|sums| sums.direct, |sums| sums.indirect];
    light.map(|light| {
        let irradiance = |half: usize| {
            let known = |(pixel, sums): (&PixelComponents, &[Sums; 2])| {
                let sums = &sums[half];
                ratio(light(sums), sums.reflectance).extend(pixel.halves[half].rays)
            };
            film.pixels.iter().zip(&sums).map(known).collect::<Vec<Vec4>>()
        };
        outlier_factors(film.width, &[irradiance(0), irradiance(1)])
    })
}

/// The average of what neighbours on the plane of `pixel` have.
fn average(
    surfaces: &[Option<SurfaceFeatures>],
    sums: &[[Sums; 2]],
    size: [usize; 2],
    pixel: usize,
    step: usize,
) -> [Sums; 2] {
    let Some(here) = surfaces[pixel] else { return sums[pixel] };
    let (mut total, mut all) = (0.0, [Sums::default(); 2]);
    for_each_tap(size, pixel, step, |tap| {
        let Some(there) = &surfaces[tap.pixel] else { return };
        let weight = tap.weight * here.likeness(there, step as f32);
        if weight > 0.0 {
            total += weight;
            all.iter_mut().zip(&sums[tap.pixel]).for_each(|(all, sums)| all.add(weight, sums));
        }
    });
    all.map(|sums| Sums {
        direct: sums.direct / total,
        indirect: sums.indirect / total,
        reflectance: sums.reflectance / total,
    })
}

/// Light that pixels reflect of `sums` of irradiance.
fn candidate(
    film: &ComponentFilm,
    sums: &[[Sums; 2]],
    light: impl Fn(&Sums) -> Vec3A + Sync,
    filtered: bool,
) -> Candidate {
    let halves = [0, 1].map(|half| {
        let reflected = |(pixel, sums): (&PixelComponents, &[Sums; 2])| {
            let [a, b] = pixel.halves.each_ref();
            let rays = pixel.rays();
            let reflectance = Vec3A::from(a.reflectance + b.reflectance) / rays.max(1.0);
            let own = pixel.halves[half].rays;
            let Sums { reflectance: sum, .. } = sums[half];
            let is_known = rays > 0.0 && (sum.max_element() > 0.0 || own > 0.0);
            let known = match (is_known, filtered) {
                (false, _) => 0.0,
                (true, true) => 1.0,
                (true, false) => own,
            };
            (reflectance * ratio(light(&sums[half]), sum)).extend(known)
        };
        film.pixels.par_iter().zip(sums).map(reflected).collect()
    });
    Candidate { halves }
}

/// `light` over `reflectance`, 0 where that is.
pub(super) fn ratio(light: Vec3A, reflectance: Vec3A) -> Vec3A {
    Vec3A::select(reflectance.cmpgt(Vec3A::ZERO), light / reflectance, Vec3A::ZERO)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::film::reconstruct::tests::{SIZE, film, floor, surface};

    /// Direct light of `film` at all levels.
    fn direct(film: &ComponentFilm) -> Vec<Candidate> {
        let [direct, indirect] = outliers(film);
        let all = |pixel: usize| film.pixels[pixel].light();
        let [direct, _] = candidates(film, &surfaces(film), &all, [&direct, &indirect]);
        direct
    }

    /// Reflectance is not averaged: a floor of checks under even light stays sharp.
    #[test]
    fn textures_of_surfaces_stay_sharp() {
        let albedo = |x: f64, y: f64| if (x + y) % 2.0 == 0.0 { 0.8 } else { 0.1 };
        let film = film(1, 0.0, 0, |x, y, _| surface(3.0, floor(x, y), DVec3::Y, albedo(x, y)));
        for candidate in direct(&film) {
            for index in 0..film.pixels.len() {
                let [x, y] = [index % SIZE[0], index / SIZE[0]].map(|at| at as f64);
                let found = f64::from(candidate.mean(index).unwrap().y);
                assert!((found - 3.0 * albedo(x, y)).abs() < 1e-4, "{found} at {x}, {y}");
            }
        }
    }

    /// No light crosses the edge between a floor and a wall, or between floors one above the other.
    #[test]
    fn no_light_crosses_from_surface_to_surface() {
        let wall = |x: f64, y: f64| (DVec3::new(x, 10.0 - y, 0.0), DVec3::Z);
        let step = |x: f64, y: f64| (floor(x, y) + DVec3::Y * 40.0, DVec3::Y);
        let other: [&dyn Fn(f64, f64) -> (DVec3, DVec3); 2] = [&wall, &step];
        for other in other {
            let film = film(1, 0.0, 0, |x, y, _| {
                let (offset, normal) = if x < 20.0 { other(x, y) } else { (floor(x, y), DVec3::Y) };
                surface(if x < 20.0 { 100.0 } else { 1.0 }, offset, normal, 0.5)
            });
            for candidate in direct(&film) {
                for index in 0..film.pixels.len() {
                    let expected = if index % SIZE[0] < 20 { 50.0 } else { 0.5 };
                    let found = candidate.mean(index).unwrap().y;
                    assert!((found / expected - 1.0).abs() < 1e-3, "{found} at {index}");
                }
            }
        }
    }
}
