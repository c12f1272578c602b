//! Rays sent nearly at lights, beside those that a final gather scatters.
//!
//! A peaked phase function scatters a light's light back along few directions, those that lead
//! nearly at it, and there much of it: rays that are scattered without knowing of lights find it
//! seldom, and the picture has grain. So wherever one is scattered another is sent nearly at a light,
//! off it as far as the phase function deflects, and what both may find is weighed by the balance
//! heuristic (Veach 1997, section 9.2.2): a scattering there and the next are sampled as one (after
//! Georgiev et al. 2013, "Joint Importance Sampling of Low-Order Volumetric Scattering").

use glam::DVec3;

use crate::light::LightSample;
use crate::math::{Ray, Spectrum, World, WorldPoint, warp};
use crate::medium::Phase;
use crate::photon::PhotonDirection;
use crate::transport::{PathContext, direct_light};

use super::final_gather::{Flown, Scattered, Walk};
use super::in_scattering::Marcher;

/// Where on a light is aimed.
const MIDDLE: [f64; 2] = [0.5; 2];

impl<S: Spectrum, H: PhotonDirection> Marcher<'_, S, H> {
    /// Light that comes straight from lights and is scattered twice, the second time at `p` by
    /// `medium`, back along a ray that came there along the unit `incoming`: what of it rays sent
    /// nearly at lights find, W/(m² sr).
    pub(super) fn sent_at_lights(
        &self,
        p: WorldPoint,
        incoming: DVec3,
        medium: usize,
        ctx: &mut PathContext,
    ) -> S {
        let phase = &self.scene.media.get(medium).phase;
        if !self.aims[medium] {
            return S::ZERO;
        }
        let middle = |_, _: &mut PathContext| MIDDLE;
        direct_light::each_light(self.scene, p, ctx, middle, |index, light, choice, ctx| {
            if self.found[index] {
                return S::ZERO;
            }
            let (direction, aimed) = phase.sample(light.direction, ctx.rng.uniform2());
            let value = phase.eval(incoming.dot(direction));
            let share = value / (value + choice * aimed);
            // About what is found, over what isotropic scattering would leave of the light.
            let survival = (share * aimed / warp::uniform_sphere_pdf()).min(1.0);
            if ctx.rng.uniform() >= survival {
                return S::ZERO;
            }
            let ray = Ray::new(p, direction);
            self.scattered_once(&ray, index, ctx) * (share / survival)
        })
    }

    /// Light that comes straight from the light `index` and is scattered once along `ray`, W/(m² sr).
    fn scattered_once(&self, ray: &Ray<World>, index: usize, ctx: &mut PathContext) -> S {
        let hit = direct_light::first_surface(self.scene, ray, ctx);
        let mut walk = Walk::along(*ray);
        let flown = self.fly(&mut walk, hit.map_or(f64::INFINITY, |hit| hit.t), ctx);
        let Flown::Scattered(t, medium) = flown else { return S::ZERO };
        let p = ray.at(t);
        let light = self.scene.lights.lights[index].sample(p, ctx.rng.uniform2());
        let Some(light) = light.filter(LightSample::shines) else { return S::ZERO };
        let scatterers: [(&Phase, S); 1] = [(&self.scene.media.get(medium).phase, S::ONE)];
        let light =
            direct_light::scattered(self.scene, p, -ray.direction, &scatterers, &light, ctx)
                / light.pdf;
        walk.throughput * light
    }

    /// Share of the light that comes straight from the light `index`, and is scattered back along the
    /// unit `direction`, that is left to a ray that was `scattered` there.
    pub(super) fn left_to(&self, scattered: &Scattered, direction: DVec3, index: usize) -> f64 {
        let Scattered { at, medium, pdf } = *scattered;
        let lights = &self.scene.lights;
        if !self.aims[medium] || self.found[index] {
            return 1.0;
        }
        let middle = lights.lights[index].sample(at, MIDDLE).filter(LightSample::shines);
        let Some(middle) = middle else { return 1.0 };
        let aimed = self.scene.media.get(medium).phase.eval(middle.direction.dot(direction));
        pdf / (pdf + lights.pick_probability(at, index) * aimed)
    }
}
