//! Joint next-event estimation: two scatterings, the nearer to the light sampled first.
//!
//! A peaked phase function scatters a light's light back along the few directions that lead nearly at
//! it, and there much of it. Phase-function sampling seldom finds them. So at each scattering of a
//! final gather a second ray is sampled from the phase function round the direction to a light, and
//! both are combined by the balance heuristic (Veach 1997, section 9.2.2); after Georgiev et al. 2013,
//! "Joint Importance Sampling of Low-Order Volumetric Scattering".

use glam::DVec3;

use crate::light::LightSample;
use crate::math::{Ray, Rgb, Spectrum, World, WorldPoint, warp};
use crate::medium::{Collision, Phase};
use crate::photon::PhotonDirection;
use crate::transport::tracking::{self, Absorption, FlightEnd, FlightStep};
use crate::transport::{LightNumbers, PathContext, PathState, Scattering, direct_light};

use super::setup::Integrator;

/// The two numbers for the position on a light that directions are sampled round.
const MIDDLE: [f64; 2] = [0.5; 2];

impl<S: Spectrum, H: PhotonDirection> Integrator<'_, S, H> {
    /// Direct light that is scattered twice, the second time at `p` by `medium`, back along a ray that
    /// arrived along the unit `incoming`, W/(m² sr): the part of it that joint sampling has by the
    /// balance heuristic.
    pub(super) fn sample_joint(
        &self,
        p: WorldPoint,
        incoming: DVec3,
        medium: usize,
        ctx: &mut PathContext,
    ) -> S {
        let phase = &self.scene.media.get(medium).phase;
        if !self.media.joint_nee[medium] {
            return S::ZERO;
        }
        let middle = LightNumbers { among: ctx.rng.uniform(), position: MIDDLE, turn: 0.0 };
        direct_light::sample_lights(self.scene, p, middle, ctx, |index, light, choice, ctx| {
            if self.handled_by_gather[index] {
                return S::ZERO;
            }
            let (direction, pdf) = phase.sample(light.direction, ctx.rng.uniform2());
            let value = phase.eval(incoming.dot(direction));
            let weight = value / (value + choice * pdf);
            // Roulette by what is found, about, over what isotropic scattering would leave of it.
            let survival = (weight * pdf / warp::uniform_sphere_pdf()).min(1.0);
            if ctx.rng.uniform() >= survival {
                return S::ZERO;
            }
            let ray = Ray::new(p, direction);
            self.single_scattering(&ray, index, ctx) * (weight / survival)
        })
    }

    /// Direct light of the light `index` that is scattered once along `ray`, W/(m² sr).
    fn single_scattering(&self, ray: &Ray<World>, index: usize, ctx: &mut PathContext) -> S {
        let hit = direct_light::first_surface(self.scene, ray, ctx);
        let mut path = PathState::new(*ray);
        let end = self.fly(&mut path, hit.map_or(f64::INFINITY, |hit| hit.t), ctx);
        let FlightEnd::Scattered { t, medium } = end else { return S::ZERO };
        let p = ray.at(t);
        let light = self.scene.lights.lights[index].sample(p, ctx.rng.uniform2());
        let Some(light) = light.filter(LightSample::shines) else { return S::ZERO };
        let scatterers: [(&Phase, S); 1] = [(&self.scene.media.get(medium).phase, S::ONE)];
        let wo = -ray.direction;
        let light =
            direct_light::in_scattered(self.scene, p, wo, &scatterers, &light, ctx) / light.pdf;
        path.throughput * light
    }

    /// MIS weight of direct light from the light `index` that phase-function sampling at `last`
    /// finds, scattered back along the unit `direction`, against [`sample_joint`](Self::sample_joint).
    pub(super) fn mis_weight(&self, last: &Scattering, direction: DVec3, index: usize) -> f64 {
        let Some(medium) = last.medium else { return 1.0 };
        let lights = &self.scene.lights;
        if !self.media.joint_nee[medium] || self.handled_by_gather[index] {
            return 1.0;
        }
        let middle = lights.lights[index].sample(last.position, MIDDLE);
        let Some(middle) = middle.filter(LightSample::shines) else { return 1.0 };
        let pdf = self.scene.media.get(medium).phase.eval(middle.direction.dot(direction));
        last.pdf / (last.pdf + lights.pick_probability(last.position, index) * pdf)
    }

    /// Flies through the media as far as `end` metres and adds what they emit. A gather is never
    /// absorbed.
    pub(super) fn fly(
        &self,
        path: &mut PathState<S>,
        end: f64,
        ctx: &mut PathContext,
    ) -> FlightEnd {
        let last = path.scattering;
        let PathState { ray, throughput, radiance, .. } = path;
        let media = &self.scene.media;
        let weight = |collision: &Collision, emission: Rgb| {
            let (Some(nee), Some(last)) = (&self.emission, last) else { return 1.0 };
            let &Collision { t, medium, density, .. } = collision;
            let sigma_t = media.get(medium).sigma_t * density;
            nee.weight_of_hit(&last, medium, ray.at(t), emission, sigma_t)
        };
        let visit = |step: &FlightStep<S>, ctx: &mut PathContext| {
            if ctx.needs.emission {
                tracking::add_emission(radiance, media, ray, step, weight, ctx);
            }
        };
        tracking::fly(media, ray, end, throughput, Absorption::Weighted, ctx, visit)
    }
}
