//! The final gather: rays that media scatter, followed until moments of photons' light say the rest.
//!
//! See [`GatherTermination`] for when that is. Where a lattice keeps what is found, rays start at its cells; see
//! [`FinalGatherCache`](crate::photon::FinalGatherCache). Else each is scattered at a place spread by
//! opacity along the eye's. It flies on as the phase function says, by null-collision tracking. Wherever
//! it is scattered again, light that comes straight from lights is sampled, of which rays sent nearly at
//! those find a part; light from all around is found where it leaves the media, weighed by the balance
//! heuristic (Veach 1997, section 9.2.2) unless it is the same on all sides; a diffuse surface ends
//! it, with the light that photons brought there.

use glam::DVec3;

use crate::math::{Ray, Span, Spectrum, World, WorldPoint, warp};
use crate::medium::{Phase, Profile};
use crate::photon::PhotonDirection;
use crate::strategy::GatherTermination;
use crate::surface::{SurfaceHit, TransportMode};
use crate::transport::MAX_EVENTS;
use crate::transport::{PathContext, SobolPoint, direct_light};

use super::in_scattering::Marcher;
use crate::render::exposure::State;

/// A ray on its way.
pub(super) struct Walk<S> {
    ray: Ray<World>,
    /// What its light counts.
    pub(super) throughput: S,
    light: S,
    /// What is left of the first moment that lattices do not hold.
    left: f64,
    /// Which of the lattices' levels is asked.
    level: usize,
    /// What the last scattering chose; nothing behind a mirror.
    scattered: Option<Scattered>,
    /// How many solids of glass it is inside of.
    inside: i32,
}

impl<S: Spectrum> Walk<S> {
    /// Starts along `ray`.
    pub(super) const fn along(ray: Ray<World>) -> Self {
        Self {
            ray,
            throughput: S::ONE,
            light: S::ZERO,
            left: 1.0,
            level: 0,
            scattered: None,
            inside: 0,
        }
    }
}

/// How the last scattering chose a ray's direction.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scattered {
    pub(super) at: WorldPoint,
    pub(super) medium: usize,
    /// Density of the direction, 1/sr.
    pub(super) pdf: f64,
}

/// Where a flight led.
pub(super) enum Flown {
    /// As far as there is.
    Through,
    /// Scattered at this distance by this medium.
    Scattered(f64, usize),
}

impl<S: Spectrum, H: PhotonDirection> Marcher<'_, S, H> {
    /// Light that media scatter along `ray` to its origin, but for that which comes straight from
    /// lights other than the sky, where lattices hold moments, W/(m² sr).
    pub(super) fn gathered(
        &self,
        gather: &GatherTermination,
        ray: &Ray<World>,
        profile: &Profile<S>,
        radius: f64,
        state: &mut State<S>,
    ) -> S {
        let even = state.ctx.scattering.take().map(SobolPoint::scattering);
        let [a, b, c, d] = even.unwrap_or_else(|| [(); 4].map(|()| state.ctx.rng.uniform()));
        let Some(place) = profile.sample([a, b]) else { return S::ZERO };
        let p = ray.at(place.t);
        let Some((medium, share)) = self.scatterer(p, state) else { return S::ZERO };
        state.ctx.work.gathers += 1;
        let walk = Walk { level: self.maps.level(radius), ..Walk::along(*ray) };
        // What stands in for the light of other rays is told for the whole ray.
        let told = std::mem::take(&mut state.stands_in);
        let light = self.walked(gather, walk, p, medium, [c, d], state);
        let weight = place.weight * share;
        state.stands_in = told + weight * state.stands_in;
        weight * light.not_negative()
    }

    /// The light of a walk that a medium scatters first at `p`.
    pub(super) fn walked(
        &self,
        gather: &GatherTermination,
        mut walk: Walk<S>,
        p: WorldPoint,
        medium: usize,
        u: [f64; 2],
        state: &mut State<S>,
    ) -> S {
        if self.scatter(gather, &mut walk, p, medium, u, &mut state.ctx) {
            let ended = (0..MAX_EVENTS).any(|_| !self.step(gather, &mut walk, state));
            state.ctx.work.capped_rays += u64::from(!ended);
        }
        walk.light
    }

    /// A medium at `p`, chosen by what it scatters, and the share of the extinction there for which
    /// it stands.
    fn scatterer(&self, p: WorldPoint, state: &mut State<S>) -> Option<(usize, S)> {
        state.ctx.work.grid_lookups += self.lookups;
        let shares = self.shares(p);
        if let [only] = shares[..] {
            return Some(only);
        }
        let total: f64 = shares.iter().map(|(_, share)| share.element_sum()).sum();
        let mut left = state.ctx.rng.uniform() * total;
        let (medium, share) = shares.into_iter().find(|(_, share)| {
            left -= share.element_sum();
            left < 0.0
        })?;
        Some((medium, share * (total / share.element_sum())))
    }

    /// Asks the lattices at `p`, or scatters the ray there; whether it goes on.
    fn scatter(
        &self,
        gather: &GatherTermination,
        walk: &mut Walk<S>,
        p: WorldPoint,
        medium: usize,
        u: [f64; 2],
        ctx: &mut PathContext,
    ) -> bool {
        let phase = &self.scene.media.get(medium).phase;
        let incoming = walk.ray.direction;
        let Some(left) = gather.after(walk.left, medium) else {
            let lattice = &self.maps.lattices[medium];
            let light = lattice.toward(p, walk.level, -incoming, gather.legendre(medium));
            walk.light += walk.throughput * light;
            return false;
        };
        walk.left = left;
        walk.light += walk.throughput * self.skylight(p, -incoming, phase, ctx);
        walk.light += walk.throughput * self.sent_at_lights(p, incoming, medium, ctx);
        let (direction, pdf) = phase.sample(incoming, u);
        walk.ray = Ray::new(p, direction);
        walk.scattered = Some(Scattered { at: p, medium, pdf });
        true
    }

    /// Flies to the next scattering or surface; whether the ray goes on.
    fn step(&self, gather: &GatherTermination, walk: &mut Walk<S>, state: &mut State<S>) -> bool {
        let hit = direct_light::first_surface(self.scene, &walk.ray, &mut state.ctx);
        if walk.inside == 0 {
            let end = hit.as_ref().map_or(f64::INFINITY, |hit| hit.t);
            let flown = self.fly(walk, end, &mut state.ctx);
            if !survives(walk, &mut state.ctx) {
                return false;
            }
            if let Flown::Scattered(t, medium) = flown {
                let p = walk.ray.at(t);
                walk.light += walk.throughput * self.straight(walk, p, medium, state);
                let u = state.ctx.rng.uniform2();
                return self.scatter(gather, walk, p, medium, u, &mut state.ctx);
            }
        }
        let Some(hit) = hit else {
            self.sky(walk, &mut state.ctx);
            return false;
        };
        if walk.scattered.is_none() {
            let emitted = direct_light::emitted(self.scene, &walk.ray, &hit);
            walk.light += walk.throughput * S::from_rgb(emitted);
        }
        if hit.material.is_specular() {
            return mirror(walk, &hit, &mut state.ctx);
        }
        walk.light += walk.throughput * self.reflected(&walk.ray, &hit, state);
        state.stands_in *= walk.throughput;
        false
    }

    /// Flies through the media as far as `end`, and adds what they give off.
    pub(super) fn fly(&self, walk: &mut Walk<S>, end: f64, ctx: &mut PathContext) -> Flown {
        let media = &self.scene.media;
        let span = Span::new(0.0, end);
        let mut flights = media.flights(&walk.ray, span, walk.throughput, &mut ctx.rng);
        let mut at = 0.0;
        loop {
            let next = flights.next(&mut ctx.rng);
            ctx.work.grid_lookups += flights.take_lookups();
            if ctx.needs.emission {
                let flown = Span::new(at, next.map_or(end, |c| c.t));
                for medium in media.iter().filter(|m| m.emission.is_some()) {
                    ctx.work.emission_lookups += 1;
                    let emission = medium.emission_apart(&walk.ray, flown);
                    walk.light += walk.throughput * S::from_rgb(emission);
                }
            }
            let Some(c) = next else { return Flown::Through };
            ctx.work.collisions += 1;
            at = c.t;
            let p = walk.ray.at(c.t);
            let medium = media.get(c.medium);
            ctx.work.grid_lookups += u64::from(!medium.albedo.is_constant());
            if ctx.needs.emission {
                let emission = S::from_rgb(medium.emission_of(c.density, p));
                walk.light += walk.throughput * emission / c.majorant;
            }
            let null = S::splat(c.majorant) - S::from_rgb(medium.sigma_t) * c.density;
            let null = walk.throughput * null.not_negative();
            let p_null = null.element_sum() / (walk.throughput.element_sum() * c.majorant);
            if ctx.rng.uniform() >= p_null {
                let scattering = walk.throughput * S::from_rgb(media.sigma_s(&c, p));
                walk.throughput = scattering / (c.majorant * (1.0 - p_null));
                return Flown::Scattered(c.t, c.medium);
            }
            ctx.work.null_collisions += 1;
            walk.throughput = null / (c.majorant * p_null);
            flights.carry_on(walk.throughput, c.t, &mut ctx.rng);
        }
    }

    /// Light that comes straight from lights to `p` and is scattered there along the ray, but for
    /// that of the sky where the ray finds it.
    fn straight(&self, walk: &Walk<S>, p: WorldPoint, medium: usize, state: &mut State<S>) -> S {
        let phase = &self.scene.media.get(medium).phase;
        let scatterers = [(phase, S::ONE)];
        let toward = -walk.ray.direction;
        let anywhere = |_, ctx: &mut PathContext| ctx.rng.uniform2();
        let ctx = &mut state.ctx;
        direct_light::each_light(self.scene, p, ctx, anywhere, |index, light, choice, ctx| {
            if self.found[index] {
                return S::ZERO;
            }
            let left = walk.scattered.map_or(1.0, |s| self.left_to(&s, -toward, index));
            // Light from where the phase function lets little come is seldom asked for.
            let value = left * phase.eval(-light.direction.dot(toward));
            let survival = (value / warp::uniform_sphere_pdf()).min(1.0);
            if ctx.rng.uniform() >= survival {
                return S::ZERO;
            }
            let of = direct_light::scattered(self.scene, p, toward, &scatterers, light, ctx);
            of * (left / (survival * choice * light.pdf))
        })
    }

    /// Light of a sky that is brighter in places which is scattered at `p` into the unit direction
    /// `toward`, as far as the ray that is scattered there does not find it.
    fn skylight(&self, p: WorldPoint, toward: DVec3, phase: &Phase, ctx: &mut PathContext) -> S {
        let lights = &self.scene.lights.lights;
        let asks = |index: usize| self.found[index] && !lights[index].is_even();
        if !(0..lights.len()).any(asks) {
            return S::ZERO;
        }
        let scatterers = [(phase, S::ONE)];
        let anywhere = |_, ctx: &mut PathContext| ctx.rng.uniform2();
        direct_light::each_light(self.scene, p, ctx, anywhere, |index, light, choice, ctx| {
            if !asks(index) {
                return S::ZERO;
            }
            let other = phase.eval(-light.direction.dot(toward));
            let of = direct_light::scattered(self.scene, p, toward, &scatterers, light, ctx);
            of / (choice * light.pdf + other)
        })
    }

    /// Adds what the ray sees of the sky.
    fn sky(&self, walk: &mut Walk<S>, ctx: &mut PathContext) {
        let Some(Scattered { pdf, at: from, .. }) = walk.scattered else {
            let sky = direct_light::environment(self.scene, &walk.ray, ctx);
            walk.light += walk.throughput * S::from_rgb(sky);
            return;
        };
        for (index, light) in self.scene.lights.lights.iter().enumerate() {
            if self.found[index] {
                ctx.work.environment_lookups += 1;
                let direction = walk.ray.direction;
                let choice = self.scene.lights.pick_probability(from, index);
                let other = if light.is_even() { 0.0 } else { choice * light.pdf(direction, None) };
                let radiance = S::from_rgb(light.radiance_from(direction, None));
                walk.light += walk.throughput * radiance * (pdf / (pdf + other));
            }
        }
    }
}

/// Follows the ray through a mirror or glass; whether it goes on.
fn mirror<S: Spectrum>(walk: &mut Walk<S>, hit: &SurfaceHit<'_>, ctx: &mut PathContext) -> bool {
    let u = std::array::from_fn(|_| ctx.rng.uniform());
    let scattered = hit.material.scatter(walk.ray.direction, hit, u, TransportMode::Radiance);
    let Some(scattered) = scattered else { return false };
    ctx.work.specular_bounces += 1;
    walk.inside = (walk.inside + i32::from(scattered.crossing)).max(0);
    walk.throughput *= S::from_rgb(scattered.weight);
    walk.ray = hit.leave(scattered.direction);
    walk.scattered = None;
    survives(walk, ctx)
}

/// Russian roulette on the throughput.
fn survives<S: Spectrum>(walk: &mut Walk<S>, ctx: &mut PathContext) -> bool {
    let survival = walk.throughput.max_element().min(1.0);
    if ctx.rng.uniform() >= survival {
        return false;
    }
    walk.throughput /= survival;
    true
}
