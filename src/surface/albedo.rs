//! The albedo of a rough surface by the cosine, in a table.
//!
//! What facets do not reflect at once, 1 - E(i) of the light from i with their albedo E, is reflected diffusely by
//! (1 - E(i)) (1 - E(o)) / (pi (1 - E_mean)): the lobe is reciprocal and neither makes nor loses light (Kelemen and
//! Szirmay-Kalos 2001, "A Microfacet Based Coupled Specular-Matte BRDF Model with Importance Sampling").

use std::f64::consts::PI;

use glam::DVec3;

/// Cosines at which the albedo of a rough surface is kept.
///
/// Unit: count. Derivation: between two of them the albedo of the smoothest coat bends by less than 1e-2.
const COSINES: usize = 48;

/// Facets along each axis of their disk by which one albedo is found.
///
/// Unit: count. Derivation: the midpoint rule is then within 3e-3 for any roughness.
const FACETS: u32 = 24;

/// Albedos of a rough surface.
#[derive(Debug, Clone)]
pub(super) struct Albedos {
    /// At the cosines (i / (COSINES - 1))².
    table: [f64; COSINES],
    /// Their mean over the hemisphere, weighted by the cosine.
    pub(super) mean: f64,
}

impl Albedos {
    /// Those of a surface whose facets reflect once: `weight` is that of the direction which they reflect, for the direction to
    /// the viewer in the frame of the surface and two uniform numbers, or nothing where they lose the light.
    pub(super) fn new(weight: impl Fn(DVec3, [f64; 2]) -> Option<f64>) -> Self {
        let root = |index: usize| index as f64 / (COSINES - 1) as f64;
        let table = std::array::from_fn(|index| match index {
            0 => 1.0,
            _ => albedo(&weight, root(index) * root(index)),
        });
        let mut albedos = Self { table, mean: 0.0 };
        let steps = 16 * COSINES;
        let middles = (0..steps).map(|step| (step as f64 + 0.5) / steps as f64);
        // Over cosines c from 0 to 1 it is the integral of 2 c E(c), here over squared cosines.
        albedos.mean =
            middles.map(|squared| albedos.at(squared.sqrt())).sum::<f64>() / steps as f64;
        albedos
    }

    /// The albedo at this cosine.
    pub(super) fn at(&self, cosine: f64) -> f64 {
        let at = cosine.clamp(0.0, 1.0).sqrt() * (COSINES - 1) as f64;
        let index = (at as usize).min(COSINES - 2);
        let [before, behind] = [self.table[index], self.table[index + 1]];
        before + (behind - before) * (at - index as f64)
    }

    /// Share of the light at this cosine that is not reflected at once, over its mean.
    pub(super) fn rest(&self, cosine: f64) -> f64 {
        (1.0 - self.at(cosine)) / (1.0 - self.mean)
    }

    /// Value without the cosine, 1/sr, of the diffuse lobe that reflects the rest, for the cosines of both directions.
    pub(super) fn diffuse(&self, [i, o]: [f64; 2]) -> f64 {
        let through = (1.0 - self.at(o)) * (1.0 - self.at(i));
        through / (PI * (1.0 - self.mean))
    }
}

/// Share of light that is reflected at this cosine, over a grid of visible facets of this `weight`.
fn albedo(weight: &impl Fn(DVec3, [f64; 2]) -> Option<f64>, cosine: f64) -> f64 {
    let wo = DVec3::new((1.0 - cosine * cosine).max(0.0).sqrt(), 0.0, cosine);
    let middle = |index: u32| (f64::from(index) + 0.5) / f64::from(FACETS);
    // Denser toward the rim of the disk, where the few steep facets are that lose most.
    let reflected = (0..FACETS * FACETS).map(|i| {
        let left = 1.0 - middle(i / FACETS);
        let found = weight(wo, [1.0 - left * left, middle(i % FACETS)]);
        found.map_or(0.0, |weight| 2.0 * left * weight)
    });
    reflected.sum::<f64>() / f64::from(FACETS * FACETS)
}

#[cfg(test)]
mod tests {
    use super::super::ggx::{Fresnel, Ggx};
    use super::*;
    use crate::math::Rgb;

    /// What facets as steep as can be reflect at once, seen straight, in closed form.
    #[test]
    fn the_steepest_facets_lose_the_logarithm_of_two() {
        let steepest = Ggx { alpha: 1.0, fresnel: Fresnel::Metal(Rgb::ONE), multiple: None };
        let albedo = Albedos::new(|wo, u| steepest.weight(wo, u)).at(1.0);
        assert!((albedo - (1.0 - 2.0_f64.ln())).abs() < 1e-3, "{albedo}");
    }
}
