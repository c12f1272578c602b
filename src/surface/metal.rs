//! Rough metal.

use std::sync::Arc;

use super::albedo::Albedos;
use super::ggx::{Fresnel, Ggx, Multiple};
use super::{SurfaceHit, Texture};
use crate::math::Rgb;

/// A rough metal, on both sides.
#[derive(Debug, Clone)]
pub struct Metal {
    /// At normal incidence, in [0, 1].
    reflectance: Texture,
    alpha: f64,
    /// Of facets that reflect everything.
    albedos: Arc<Albedos>,
}

impl Metal {
    /// A metal of this reflectance at normal incidence, whose slopes have the width `alpha` in (0, 1].
    pub fn new(reflectance: Texture, alpha: f64) -> Self {
        let white = Ggx { alpha, fresnel: Fresnel::Metal(Rgb::ONE), multiple: None };
        Self { reflectance, alpha, albedos: Arc::new(Albedos::new(|wo, u| white.weight(wo, u))) }
    }

    /// What it reflects at `hit`.
    pub(super) fn rough(&self, hit: &SurfaceHit<'_>) -> Ggx<'_> {
        let normal = self.reflectance.at(hit.uv);
        // Its mean over the hemisphere, by the cosine, and the series of further reflections (Kulla and Conty 2017).
        let mean = normal + (Rgb::ONE - normal) / 21.0;
        let share = mean * mean * self.albedos.mean / (Rgb::ONE - mean * (1.0 - self.albedos.mean));
        let multiple = Some(Multiple { albedos: &self.albedos, share });
        Ggx { alpha: self.alpha, fresnel: Fresnel::Metal(normal), multiple }
    }

    /// Its colour.
    pub(super) const fn reflectance(&self) -> &Texture {
        &self.reflectance
    }
}
