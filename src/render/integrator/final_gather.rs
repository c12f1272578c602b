//! Final gathers: paths that media scatter, until moments of the photons' fluence say the rest.
//!
//! [`GatherTermination`](crate::strategy::GatherTermination) says when. Each gather flies on as phase
//! functions say, by null-collision tracking. At each scattering direct light is sampled, and so are
//! [places that glow](super::emission_nee), and a [second path](super::sent_path) is sent toward a light; an
//! environment is hit where the path leaves the media, with the balance heuristic against sampling it (Veach
//! 1997, section 9.2.2) unless it is constant. A diffuse surface ends the path, with its direct light and its
//! photons' (Jensen 1996, "Global Illumination using Photon Maps").

use glam::DVec3;

use crate::cache::FluenceGrid;
use crate::math::{Rgb, Spectrum, WorldPoint, warp};
use crate::medium::{Collision, Phase};
use crate::photon::PhotonDirection;
use crate::surface::{Ggx, SurfaceHit};
use crate::transport::specular::scatter_specular;
use crate::transport::tracking::{self, Absorption, FlightEnd, FlightStep};
use crate::transport::{
    EquiangularLights, LightNumbers, MAX_EVENTS, PathContext, PathState, Scattering, direct_light,
    surface_light, survives_roulette,
};

use super::light_lobes::SentRatios;
use super::sent_path::MediumWalk;
use super::setup::{Estimate, Integrator};

/// A final gather in progress.
pub(super) struct GatherPath<S> {
    walk: MediumWalk<S>,
    /// Level of the fluence grids that are looked up.
    level: usize,
    /// Weight of the indirect light of surfaces.
    indirect_weight: f64,
    /// Indirect light found on surfaces, W/(m² sr).
    indirect: S,
}

impl<S: Spectrum> GatherPath<S> {
    /// A gather along `path` that has not been scattered yet.
    pub(super) const fn new(path: PathState<S>, level: usize, indirect_weight: f64) -> Self {
        Self { walk: MediumWalk::new(path), level, indirect_weight, indirect: S::ZERO }
    }
}

impl<S: Spectrum, H: PhotonDirection> Integrator<'_, S, H> {
    /// The light of one gather that `medium` scatters first at `p`; `u` chooses the direction.
    pub(super) fn trace_gather(
        &self,
        mut gather: GatherPath<S>,
        p: WorldPoint,
        medium: usize,
        u: [f64; 2],
        ctx: &mut PathContext,
    ) -> Estimate<S> {
        if self.scatter_or_look_up(&mut gather, p, medium, u, ctx) {
            let ended = (0..MAX_EVENTS).any(|_| !self.gather_step(&mut gather, ctx));
            ctx.work.capped_rays += u64::from(!ended);
        }
        Estimate { radiance: gather.walk.path.radiance, indirect: gather.indirect }
    }

    /// Ends the gather in the fluence grid at `p`, or scatters it there; whether it goes on.
    fn scatter_or_look_up(
        &self,
        gather: &mut GatherPath<S>,
        p: WorldPoint,
        medium: usize,
        u: [f64; 2],
        ctx: &mut PathContext,
    ) -> bool {
        let termination = &self.choice.termination;
        let GatherPath { walk, level, .. } = gather;
        let MediumWalk { path, unresolved, .. } = walk;
        let phase = &self.scene.media.get(medium).phase;
        let incoming = path.ray.direction;
        let is_first = *unresolved == 1.0;
        if !is_first {
            path.throughput = self.scene.groups.scattered(path.throughput);
        }
        *unresolved = termination.after(*unresolved, medium);
        if !is_first && self.media.holds_moments[medium] && termination.ends(*unresolved, medium) {
            let grid = self.caches.fluence[medium].as_ref();
            let scattered = |grid: &FluenceGrid<S>| {
                grid.scattered(p, *level, -incoming, termination.legendre(medium))
            };
            path.radiance += path.throughput * grid.map_or(S::ZERO, scattered);
            return false;
        }
        path.radiance += path.throughput * self.sampled_environment(p, -incoming, phase, ctx);
        if let Some(nee) = &self.emission {
            let emitted: S = nee.sample(self.scene, p, incoming, phase, ctx);
            path.radiance += path.throughput * emitted;
        }
        let (direction, pdf) = phase.sample(incoming, u);
        let toward_lights = self.toward_lights(p, medium);
        if let Some(toward) = &toward_lights {
            walk.path.radiance += self.sent_light(*walk, p, medium, toward, ctx);
        }
        let sent = toward_lights.map_or(0.0, |toward| toward.density(direction));
        walk.turn(p, medium, direction, [pdf, sent]);
        true
    }

    /// Traces the gather to the next scattering or surface; whether it goes on.
    fn gather_step(&self, gather: &mut GatherPath<S>, ctx: &mut PathContext) -> bool {
        let MediumWalk { path, sent_ratios, .. } = &mut gather.walk;
        let hit = direct_light::first_surface(self.scene, &path.ray, ctx);
        if path.solids.is_none() {
            let end = hit.as_ref().map_or(f64::INFINITY, |hit| hit.t);
            let lamps = self.lamps_along(&path.ray, end);
            let weight = sent_ratios.weight(self.media.sent_reach);
            path.radiance += path.throughput * self.sampled_lamps(path, &lamps, ctx) * weight;
            let flown = self.fly(path, end, ctx);
            if !survives_roulette(&mut path.throughput, &mut ctx.rng) {
                return false;
            }
            if let FlightEnd::Scattered { t, medium } = flown {
                path.radiance += self.sampled_direct(path, weight, t, medium, &lamps, ctx);
                let p = path.ray.at(t);
                let u = ctx.rng.uniform2();
                return self.scatter_or_look_up(gather, p, medium, u, ctx);
            }
        }
        let Some(hit) = hit else {
            self.add_environment(path, ctx);
            return false;
        };
        let emitted = match &path.scattering {
            None => direct_light::emitted(self.scene, &path.ray, &hit),
            Some(from) if from.medium.is_none() => {
                surface_light::emission_after(self.scene, from, &path.ray, Some(&hit), ctx)
            }
            Some(_) => S::ZERO,
        };
        path.radiance += path.throughput * emitted;
        path.throughput = self.scene.groups.reflected(path.throughput);
        if hit.material.is_specular() {
            // Paths that are sent toward lights end at mirrors and glass.
            *sent_ratios = SentRatios::NONE;
            return follow_specular(path, &hit, ctx);
        }
        let reflected = self.reflected(&path.ray, &hit, gather.indirect_weight, ctx);
        path.radiance += path.throughput * reflected.radiance;
        gather.indirect += reflected.indirect * path.throughput;
        hit.material.rough(&hit).is_some_and(|rough| {
            *sent_ratios = SentRatios::NONE;
            follow_rough(path, &hit, &rough, ctx)
        })
    }

    /// Flies through the media as far as `end` metres and adds what they emit. A gather is never
    /// absorbed.
    fn fly(&self, path: &mut PathState<S>, end: f64, ctx: &mut PathContext) -> FlightEnd {
        // A rough surface does not sample places that glow.
        let last = path.scattering.filter(|last| last.medium.is_some());
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

    /// Direct light that `medium` scatters at the distance `t` back along the path's ray, from lights that gathers
    /// do not hit themselves, times the path's throughput and `weight`; of `lamps` the part that the balance heuristic
    /// leaves.
    pub(super) fn sampled_direct(
        &self,
        path: &PathState<S>,
        weight: f64,
        t: f64,
        medium: usize,
        lamps: &EquiangularLights<'_>,
        ctx: &mut PathContext,
    ) -> S {
        let p = path.ray.at(t);
        let phase = &self.scene.media.get(medium).phase;
        let scatterers = [(phase, S::ONE)];
        let wo = -path.ray.direction;
        let u = LightNumbers::varied(ctx.rng.uniform(), ctx.rng.uniform2());
        let throughput = self.scene.groups.scattered(path.throughput) * S::splat(weight);
        direct_light::sample_lights(self.scene, p, u, ctx, |index, light, choice, ctx| {
            if self.handled_by_gather[index] {
                return S::ZERO;
            }
            // Roulette before the shadow ray, by the light over that of isotropic scattering.
            let value = throughput.max_element() * phase.eval(-light.direction.dot(wo));
            let survival = (value / warp::uniform_sphere_pdf()).min(1.0);
            if ctx.rng.uniform() >= survival {
                return S::ZERO;
            }
            let light_in = direct_light::in_scattered(self.scene, p, wo, &scatterers, light, ctx);
            let origin = light.origin(p);
            let weight = self.weight_at_scattering(path, t, lamps, (index, &origin, choice), ctx);
            throughput * light_in * (weight / (survival * choice * light.pdf))
        })
    }

    /// Light of environments that are not constant which is scattered at `p` toward the unit direction
    /// `wo`: light sampling's part by the balance heuristic. The path's own ray has the rest.
    fn sampled_environment(
        &self,
        p: WorldPoint,
        wo: DVec3,
        phase: &Phase,
        ctx: &mut PathContext,
    ) -> S {
        let lights = &self.scene.lights.lights;
        let is_sampled = |index: usize| self.handled_by_gather[index] && !lights[index].is_even();
        if !(0..lights.len()).any(is_sampled) {
            return S::ZERO;
        }
        let scatterers = [(phase, S::ONE)];
        let u = LightNumbers::varied(ctx.rng.uniform(), ctx.rng.uniform2());
        direct_light::sample_lights(self.scene, p, u, ctx, |index, light, choice, ctx| {
            if !is_sampled(index) {
                return S::ZERO;
            }
            let phase_pdf = phase.eval(-light.direction.dot(wo));
            let light_in = direct_light::in_scattered(self.scene, p, wo, &scatterers, light, ctx);
            light_in / (choice * light.pdf + phase_pdf)
        })
    }

    /// Adds the environments that the path's ray hits.
    fn add_environment(&self, path: &mut PathState<S>, ctx: &mut PathContext) {
        let Some(last) = path.scattering else {
            let radiance: S = direct_light::environment(self.scene, &path.ray, ctx);
            path.radiance += path.throughput * radiance;
            return;
        };
        if last.medium.is_none() {
            let radiance: S =
                surface_light::emission_after(self.scene, &last, &path.ray, None, ctx);
            path.radiance += path.throughput * radiance;
            return;
        }
        let lights = &self.scene.lights;
        for (index, light) in lights.lights.iter().enumerate() {
            if !self.handled_by_gather[index] {
                continue;
            }
            ctx.work.environment_lookups += 1;
            let direction = path.ray.direction;
            let choice = lights.pick_probability(last.position, index);
            let light_pdf = if light.is_even() {
                0.0
            } else {
                choice * light.pdf(last.position, direction, None)
            };
            let radiance = light.radiance_from(direction, None);
            let radiance = S::of_group(radiance, self.scene.groups.of_light(index));
            path.radiance += path.throughput * radiance * (last.pdf / (last.pdf + light_pdf));
        }
    }
}

/// Follows the path through a mirror or glass; whether it goes on.
fn follow_specular<S: Spectrum>(
    path: &mut PathState<S>,
    hit: &SurfaceHit<'_>,
    ctx: &mut PathContext,
) -> bool {
    let Some(step) = scatter_specular(&path.ray, hit, &mut ctx.rng) else { return false };
    ctx.work.specular_bounces += 1;
    path.solids = path.solids.after(step.crossing);
    path.throughput *= S::from_rgb(step.weight);
    path.ray = step.ray;
    path.scattering = None;
    survives_roulette(&mut path.throughput, &mut ctx.rng)
}

/// Follows the path by what the `rough` surface at `hit` reflects; whether it goes on.
fn follow_rough<S: Spectrum>(
    path: &mut PathState<S>,
    hit: &SurfaceHit<'_>,
    rough: &Ggx<'_>,
    ctx: &mut PathContext,
) -> bool {
    let scattered = rough.scatter(path.ray.direction, hit, ctx.rng.uniform2());
    let Some(scattered) = scattered else { return false };
    ctx.work.specular_bounces += 1;
    path.throughput *= S::from_rgb(scattered.weight);
    path.ray = hit.leave(scattered.direction);
    path.scattering = Some(Scattering { position: hit.point, pdf: scattered.pdf, medium: None });
    survives_roulette(&mut path.throughput, &mut ctx.rng)
}
