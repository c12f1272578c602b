//! A diffuse base under a rough dielectric coat.
//!
//! What the coat does not reflect gets to the base, and out again, so that light is neither made nor lost but by the
//! base: its reflectance times the [diffuse lobe](Albedos::diffuse) of the coat's albedos.

use std::sync::Arc;

use glam::DVec3;

use super::albedo::Albedos;
use super::ggx::{Fresnel, Ggx, local};
use super::scattered::{facing, reflects};
use super::{Scattered, SurfaceHit, Texture};
use crate::math::{Frame, Rgb, warp};

/// A diffuse base under a rough dielectric coat, on both sides.
#[derive(Debug, Clone)]
pub struct Plastic {
    /// Of the base, in [0, 1].
    reflectance: Texture,
    coat: Ggx<'static>,
    /// Of the coat.
    albedos: Arc<Albedos>,
}

impl Plastic {
    /// A base of this reflectance under a coat with the index of refraction `ior` > 1, whose slopes have the width
    /// `alpha` in (0, 1].
    pub fn new(reflectance: Texture, ior: f64, alpha: f64) -> Self {
        let coat = Ggx { alpha, fresnel: Fresnel::Dielectric(ior), multiple: None };
        Self { reflectance, coat, albedos: Arc::new(Albedos::new(|wo, u| coat.weight(wo, u))) }
    }

    /// The coat.
    pub(super) const fn coat(&self) -> Ggx<'static> {
        self.coat
    }

    /// The base's colour.
    pub(super) const fn reflectance(&self) -> &Texture {
        &self.reflectance
    }

    /// Share of light from `incoming` reversed that the base reflects, into all directions.
    pub(super) fn base_albedo(&self, incoming: DVec3, hit: &SurfaceHit<'_>) -> Rgb {
        let cosine = -incoming.dot(facing(incoming, hit).1);
        self.reflectance.at(hit.uv) * (1.0 - self.albedos.at(cosine))
    }

    /// Share of the light along `incoming` that reaches the base, over its mean for even light.
    pub(super) fn base_share(&self, incoming: DVec3, hit: &SurfaceHit<'_>) -> f64 {
        self.albedos.rest(-incoming.dot(facing(incoming, hit).1))
    }

    /// Value of the base without the cosine, 1/sr.
    pub(super) fn base(&self, incoming: DVec3, outgoing: DVec3, hit: &SurfaceHit<'_>) -> Rgb {
        let Some([wo, wi]) = local(incoming, outgoing, hit) else { return Rgb::ZERO };
        self.reflectance.at(hit.uv) * self.albedos.diffuse([wi.z, wo.z])
    }

    pub(super) fn eval(&self, incoming: DVec3, outgoing: DVec3, hit: &SurfaceHit<'_>) -> Rgb {
        self.coat.eval(incoming, outgoing, hit) + self.base(incoming, outgoing, hit)
    }

    pub(super) fn pdf(&self, incoming: DVec3, outgoing: DVec3, hit: &SurfaceHit<'_>) -> f64 {
        if !reflects(incoming, outgoing, hit) {
            return 0.0;
        }
        let share = self.share_of_coat(incoming, hit);
        let base = warp::cosine_hemisphere_pdf(outgoing.dot(facing(incoming, hit).1));
        share * self.coat.pdf(incoming, outgoing, hit) + (1.0 - share) * base
    }

    /// Samples the coat or the base, by what they reflect.
    pub(super) fn scatter(
        &self,
        incoming: DVec3,
        hit: &SurfaceHit<'_>,
        u: [f64; 3],
    ) -> Option<Scattered> {
        let (_, ns) = facing(incoming, hit);
        let direction = if u[2] < self.share_of_coat(incoming, hit) {
            self.coat.scatter(incoming, hit, [u[0], u[1]])?.direction
        } else {
            Frame::around(ns).to_world(warp::cosine_hemisphere([u[0], u[1]]))
        };
        let pdf = self.pdf(incoming, direction, hit);
        if pdf <= 0.0 {
            return None;
        }
        let weight = self.eval(incoming, direction, hit) * (direction.dot(ns) / pdf);
        Some(Scattered { direction, weight, specular: false, pdf, crossing: 0 })
    }

    /// Probability of sampling the coat.
    fn share_of_coat(&self, incoming: DVec3, hit: &SurfaceHit<'_>) -> f64 {
        let coat = self.albedos.at(-incoming.dot(facing(incoming, hit).1));
        let base = self.base_albedo(incoming, hit).max_element();
        if coat + base > 0.0 { coat / (coat + base) } else { 1.0 }
    }
}
