//! A diffuse base under a rough dielectric coat.
//!
//! What the coat does not reflect gets to the base, and out again, so that light is neither made nor lost but by the
//! base: (1 - E(i)) (1 - E(o)) / (pi (1 - E_mean)) times its reflectance, with the coat's albedo E (Kelemen and
//! Szirmay-Kalos 2001, "A Microfacet Based Coupled Specular-Matte BRDF Model with Importance Sampling").

use std::f64::consts::PI;
use std::sync::Arc;

use glam::DVec3;

use super::ggx::{Fresnel, Ggx, local};
use super::scattered::{facing, reflects};
use super::{Scattered, SurfaceHit, Texture};
use crate::math::{Frame, Rgb, warp};

/// Cosines at which the albedo of a coat is kept.
///
/// Unit: count. Derivation: between two of them the albedo of the smoothest coat bends by less than 1e-2.
const COSINES: usize = 48;

/// Facets along each axis of their disk by which one albedo is found.
///
/// Unit: count. Derivation: the midpoint rule over a smooth function is then within 1e-3.
const FACETS: u32 = 24;

/// A diffuse base under a rough dielectric coat, on both sides.
#[derive(Debug, Clone)]
pub struct Plastic {
    /// Of the base, in [0, 1].
    reflectance: Texture,
    coat: Ggx,
    /// Albedo of the coat at the cosines (i / (COSINES - 1))².
    albedos: Arc<[f64; COSINES]>,
    /// Its mean over the hemisphere, weighted by the cosine.
    mean: f64,
}

impl Plastic {
    /// A base of this reflectance under a coat with the index of refraction `ior` > 1, whose slopes have the width
    /// `alpha` in (0, 1].
    pub fn new(reflectance: Texture, ior: f64, alpha: f64) -> Self {
        let coat = Ggx { alpha, fresnel: Fresnel::Dielectric(ior) };
        let root = |index: usize| index as f64 / (COSINES - 1) as f64;
        let albedos: [f64; COSINES] = std::array::from_fn(|index| match index {
            0 => 1.0,
            _ => albedo(&coat, root(index) * root(index)),
        });
        let mut plastic = Self { reflectance, coat, albedos: Arc::new(albedos), mean: 0.0 };
        let steps = 16 * COSINES;
        let middles = (0..steps).map(|step| (step as f64 + 0.5) / steps as f64);
        // Over cosines c from 0 to 1 it is the integral of 2 c E(c), here over squared cosines.
        plastic.mean =
            middles.map(|squared| plastic.albedo(squared.sqrt())).sum::<f64>() / steps as f64;
        plastic
    }

    /// Albedo of the coat at this cosine.
    fn albedo(&self, cosine: f64) -> f64 {
        let at = cosine.clamp(0.0, 1.0).sqrt() * (COSINES - 1) as f64;
        let index = (at as usize).min(COSINES - 2);
        let [before, behind] = [self.albedos[index], self.albedos[index + 1]];
        before + (behind - before) * (at - index as f64)
    }

    /// The coat.
    pub(super) const fn coat(&self) -> Ggx {
        self.coat
    }

    /// The base's colour.
    pub(super) const fn reflectance(&self) -> &Texture {
        &self.reflectance
    }

    /// Share of light from `incoming` reversed that the base reflects, into all directions.
    pub(super) fn base_albedo(&self, incoming: DVec3, hit: &SurfaceHit<'_>) -> Rgb {
        let cosine = -incoming.dot(facing(incoming, hit).1);
        self.reflectance.at(hit.uv) * (1.0 - self.albedo(cosine))
    }

    /// Value of the base without the cosine, 1/sr.
    pub(super) fn base(&self, incoming: DVec3, outgoing: DVec3, hit: &SurfaceHit<'_>) -> Rgb {
        let Some([wo, wi]) = local(incoming, outgoing, hit) else { return Rgb::ZERO };
        let through = (1.0 - self.albedo(wo.z)) * (1.0 - self.albedo(wi.z));
        self.reflectance.at(hit.uv) * (through / (PI * (1.0 - self.mean)))
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
        let coat = self.albedo(-incoming.dot(facing(incoming, hit).1));
        let base = self.base_albedo(incoming, hit).max_element();
        if coat + base > 0.0 { coat / (coat + base) } else { 1.0 }
    }
}

/// Share of light that `coat` reflects at this cosine, over a grid of visible facets.
fn albedo(coat: &Ggx, cosine: f64) -> f64 {
    let wo = DVec3::new((1.0 - cosine * cosine).max(0.0).sqrt(), 0.0, cosine);
    let middle = |index: u32| (f64::from(index) + 0.5) / f64::from(FACETS);
    let facets = (0..FACETS * FACETS).map(|i| [middle(i / FACETS), middle(i % FACETS)]);
    let reflected = facets.filter_map(|u| coat.sample(wo, u)).map(|(_, weight, _)| weight.x);
    reflected.sum::<f64>() / f64::from(FACETS * FACETS)
}
