//! A smooth dielectric.

use glam::DVec3;
use smallvec::{SmallVec, smallvec};

use super::scattered::facing;
use super::{Scattered, SurfaceHit, TransportMode, mirror};
use crate::math::Rgb;

/// A solid dielectric in air.
#[derive(Debug, Clone, Copy)]
pub struct Glass {
    /// Index of refraction of the solid over that of its surroundings, above 0.
    pub ior: f64,
    /// Multiplies what is refracted, at each crossing, in [0, 1].
    pub tint: Rgb,
}

impl Glass {
    /// Reflects with the probability of the Fresnel reflectance, otherwise refracts. Radiance that
    /// is refracted scales with (eta_i / eta_t)², power does not (Veach 1997, section 5.2).
    pub(super) fn scatter(
        &self,
        incoming: DVec3,
        hit: &SurfaceHit<'_>,
        u: f64,
        mode: TransportMode,
    ) -> Scattered {
        let (reflectance, refracted) = self.split(incoming, hit, mode);
        match refracted {
            Some(refracted) if u >= reflectance => refracted,
            _ => mirror::scatter(Rgb::ONE, incoming, hit),
        }
    }

    /// What is reflected and what is refracted, each weighed by its part of the Fresnel equations.
    pub(super) fn branches(
        &self,
        incoming: DVec3,
        hit: &SurfaceHit<'_>,
        mode: TransportMode,
    ) -> SmallVec<[Scattered; 2]> {
        let (reflectance, refracted) = self.split(incoming, hit, mode);
        let Some(refracted) = refracted else {
            return smallvec![mirror::scatter(Rgb::ONE, incoming, hit)];
        };
        let reflected = mirror::scatter(Rgb::splat(reflectance), incoming, hit);
        let weight = refracted.weight * (1.0 - reflectance);
        smallvec![reflected, Scattered { weight, ..refracted }]
    }

    /// The Fresnel reflectance, and what is refracted unless all is reflected.
    pub(super) fn split(
        &self,
        incoming: DVec3,
        hit: &SurfaceHit<'_>,
        mode: TransportMode,
    ) -> (f64, Option<Scattered>) {
        let enters = incoming.dot(hit.normal) <= 0.0;
        // eta_i / eta_t, from the side of the incoming ray to the other
        let ratio = if enters { 1.0 / self.ior } else { self.ior };
        let (ng, ns) = facing(incoming, hit);
        let normal = if incoming.dot(ns) < 0.0 { ns } else { ng };
        let refracted = refract(incoming, normal, ratio).filter(|d| d.dot(ng) < 0.0);
        let reflectance = dielectric_reflectance(-incoming.dot(normal), ratio);
        let scattered = |direction| Scattered {
            direction,
            weight: match mode {
                TransportMode::Radiance => self.tint * (ratio * ratio),
                TransportMode::Importance => self.tint,
            },
            specular: true,
            pdf: 0.0,
            crossing: if enters { 1 } else { -1 },
        };
        (reflectance, refracted.map(scattered))
    }
}

/// The refracted direction (Snell's law), or nothing at total internal reflection. `normal` is on
/// the side of `incoming`, `ratio` is eta_i / eta_t.
fn refract(incoming: DVec3, normal: DVec3, ratio: f64) -> Option<DVec3> {
    let cos_i = -incoming.dot(normal);
    let sin2_t = ratio * ratio * (1.0 - cos_i * cos_i).max(0.0);
    if sin2_t >= 1.0 {
        return None;
    }
    let cos_t = (1.0 - sin2_t).sqrt();
    Some((incoming * ratio + normal * (ratio * cos_i - cos_t)).normalize())
}

/// Reflectance of a smooth dielectric for unpolarised light by Fresnel's equations (Pharr, Jakob
/// and Humphreys 2023, section 9.3.5). `cos_i` >= 0 is the cosine of the angle of incidence,
/// `ratio` the index of refraction on that side over that on the other; 1 at total internal
/// reflection.
pub fn dielectric_reflectance(cos_i: f64, ratio: f64) -> f64 {
    let cos_i = cos_i.clamp(0.0, 1.0);
    let sin2_t = ratio * ratio * (1.0 - cos_i * cos_i);
    if sin2_t >= 1.0 {
        return 1.0;
    }
    let cos_t = (1.0 - sin2_t).sqrt();
    let parallel = (cos_i - ratio * cos_t) / (cos_i + ratio * cos_t);
    let perpendicular = (ratio * cos_i - cos_t) / (ratio * cos_i + cos_t);
    0.5 * (parallel * parallel + perpendicular * perpendicular)
}
