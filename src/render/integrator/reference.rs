//! The unbiased reference: null-collision path tracing with next-event estimation.
//!
//! It shares nothing with the march but the scene: transmittance is estimated by ratio tracking
//! over majorants, collisions by null-collision tracking (Novák et al. 2018, sections 4 and 5;
//! coloured media by the history-aware probabilities of Kutz et al. 2017). Light that can be found
//! in two ways is weighed between them by the balance heuristic (Veach 1997): lights that a ray can
//! meet by chance, and lamps, whose light scattered along a ray is found at collisions and at places
//! dense near the lamp (Kulla and Fajardo 2012). Where phase functions have sharp peaks such rays are
//! also sent nearly at lamps: a peak there and a wide scattering before it are sampled as one
//! (after Georgiev et al. 2013, "Joint Importance Sampling of Low-Order Volumetric Scattering").

use glam::DVec3;

use crate::film::Sample;
use crate::light::LightSample;
use crate::math::{Ray, Rgb, Span, Spectrum, World, WorldPoint, luminance};
use crate::scene::Scene;
use crate::surface::{SurfaceHit, TransportMode};
use crate::transport::MAX_EVENTS;
use crate::transport::{PathContext, direct_light};

use crate::transport::EquiangularLights;
use crate::transport::PunctualDirections;

/// [`concentration`](crate::medium::Phase::concentration) of a phase function from which rays are
/// sent nearly at lamps.
const PEAKED: f64 = 50.0;

/// Events before Russian roulette begins.
const SURE_EVENTS: u32 = 8;

/// Traces camera paths through a scene.
#[derive(Debug)]
pub struct PathTracer<'a> {
    scene: &'a Scene,
    max_scatter: u32,
    /// Whether rays are sent nearly at lamps.
    aims: bool,
}

/// A path on its way.
struct Path<S> {
    ray: Ray<World>,
    throughput: S,
    radiance: S,
    /// Order of volume scattering so far.
    scattered: u32,
    /// Density with which the last scattering chose the direction, and its place, unless light
    /// sampling there could not have found what the ray finds.
    scatter_pdf: Option<(f64, WorldPoint)>,
    /// How many solids of glass the path is inside of; media do not fill them.
    inside: i32,
    /// Share of the light of lamps, scattered next along the ray, that is not found by rays sent
    /// nearly at them.
    lamp_share: f64,
}

impl<'a> PathTracer<'a> {
    /// Traces `scene` with volume scattering up to the order `max_scatter`.
    pub fn new(scene: &'a Scene, max_scatter: Option<u32>) -> Self {
        let has_lamps = scene.lights.lights.iter().any(|light| light.place().is_some());
        let is_peaked = scene.media.iter().any(|m| m.phase.concentration() > PEAKED);
        let aims = has_lamps && is_peaked;
        Self { scene, max_scatter: max_scatter.unwrap_or(u32::MAX), aims }
    }

    /// An estimate of the light that arrives along `ray` (unit direction) at its origin.
    pub fn radiance<S: Spectrum>(&self, ray: Ray<World>, ctx: &mut PathContext) -> Sample {
        let first = direct_light::first_surface(self.scene, &ray, ctx).map(|h| h.t);
        let end = first.unwrap_or(f64::INFINITY);
        let transmittance = luminance(self.transmittance::<S>(&ray, end, ctx).rgb());
        let mut path = Path {
            ray,
            throughput: S::ONE,
            radiance: S::ZERO,
            scattered: 0,
            scatter_pdf: None,
            inside: 0,
            lamp_share: 1.0,
        };
        let ended = (0..MAX_EVENTS).any(|event| {
            let goes_on = self.step(&mut path, ctx);
            !goes_on || (event >= SURE_EVENTS && !survives(&mut path, ctx))
        });
        ctx.work.capped_paths += u64::from(!ended);
        Sample {
            radiance: path.radiance.rgb(),
            shared: Rgb::ZERO,
            calm: Rgb::ZERO,
            alpha: if first.is_some() { 1.0 } else { 1.0 - transmittance },
            depth: first.unwrap_or(f64::INFINITY),
            transmittance,
            features: None,
        }
    }

    fn transmittance<S: Spectrum>(&self, ray: &Ray<World>, end: f64, ctx: &mut PathContext) -> S {
        let span = Span::new(0.0, end);
        self.scene.media.ratio_tracking(ray, span, &mut ctx.rng, &mut ctx.work)
    }

    /// Flies to the next scattering or surface and through it; whether the path goes on.
    fn step<S: Spectrum>(&self, path: &mut Path<S>, ctx: &mut PathContext) -> bool {
        let hit = direct_light::first_surface(self.scene, &path.ray, ctx);
        let end = hit.as_ref().map_or(f64::INFINITY, |h| h.t);
        if path.inside == 0 {
            match self.fly(path, end, ctx) {
                Flight::Through => (),
                Flight::Scattered => return true,
                Flight::Ended => return false,
            }
        }
        let Some(hit) = hit else {
            self.find(path, None);
            return false;
        };
        self.find(path, Some(&hit));
        self.bounce(path, &hit, ctx)
    }

    /// Adds the light of what the path's ray found: an emitter or the surroundings.
    fn find<S: Spectrum>(&self, path: &mut Path<S>, hit: Option<&SurfaceHit<'_>>) {
        let at = hit.map(direct_light::emitter);
        for (index, light) in self.scene.lights.lights.iter().enumerate() {
            let shines = hit.map_or(light.is_infinite(), |h| h.light == Some(index as u32));
            if !shines {
                continue;
            }
            let radiance = light.radiance_from(path.ray.direction, at);
            if radiance == Rgb::ZERO {
                continue;
            }
            let weight = path.scatter_pdf.map_or(1.0, |(pdf, from)| {
                let choice = self.scene.lights.pick_probability(from, index);
                pdf / (pdf + choice * light.pdf(path.ray.direction, at))
            });
            path.radiance += path.throughput * S::from_rgb(radiance) * weight;
        }
    }

    /// Flies through the media as far as `end`.
    fn fly<S: Spectrum>(&self, path: &mut Path<S>, end: f64, ctx: &mut PathContext) -> Flight {
        let media = &self.scene.media;
        let lamps = self.lamps(&path.ray, end);
        if path.scattered < self.max_scatter {
            let at_collisions = |index: usize, p: WorldPoint, t: f64, ctx: &mut PathContext| {
                let flux = self.flux::<S>(&path.ray, t, &lamps, ctx);
                self.scene.lights.pick_probability(p, index) * flux
            };
            let light: S = self.beside_lamps(&path.ray, &lamps, at_collisions, ctx);
            path.radiance += path.throughput * light * path.lamp_share;
        }
        let mut flights =
            media.flights(&path.ray, Span::new(0.0, end), path.throughput, &mut ctx.rng);
        let mut at = 0.0;
        loop {
            let next = flights.next(&mut ctx.rng);
            ctx.work.grid_lookups += flights.take_lookups();
            let flown = Span::new(at, next.map_or(end, |c| c.t));
            for medium in media.iter().filter(|m| m.emission.is_some()) {
                ctx.work.emission_lookups += 1;
                let emission = medium.emission_apart(&path.ray, flown);
                path.radiance += path.throughput * S::from_rgb(emission);
            }
            let Some(c) = next else { return Flight::Through };
            ctx.work.collisions += 1;
            at = c.t;
            let p = path.ray.at(c.t);
            let medium = media.get(c.medium);
            ctx.work.grid_lookups += u64::from(!medium.albedo.is_constant());
            let emission = S::from_rgb(medium.emission_of(c.density, p));
            path.radiance += path.throughput * emission / c.majorant;
            let scattering = path.throughput * S::from_rgb(media.sigma_s(&c, p));
            let null = S::splat(c.majorant) - S::from_rgb(medium.sigma_t) * c.density;
            let null = path.throughput * null.not_negative();
            let rate = path.throughput.element_sum() * c.majorant;
            let (p_scatter, p_null) = (scattering.element_sum() / rate, null.element_sum() / rate);
            let u = ctx.rng.uniform();
            if u < p_scatter {
                path.throughput = scattering / (c.majorant * p_scatter);
                path.scattered += 1;
                if path.scattered > self.max_scatter {
                    return Flight::Ended;
                }
                let incoming = path.ray.direction;
                let flux = self.flux::<S>(&path.ray, c.t, &lamps, ctx);
                let lamp_share = path.lamp_share;
                let lit = |index: usize, choice: f64, light: &LightSample| {
                    let value = medium.phase.eval(incoming.dot(light.direction));
                    let beside = lamps.pdf(index, c.t);
                    let weight =
                        if beside > 0.0 { choice * flux / (choice * flux + beside) } else { 1.0 };
                    let is_lamp = self.scene.lights.lights[index].place().is_some();
                    let share = if is_lamp { lamp_share } else { 1.0 };
                    (S::splat(value * weight * share), value)
                };
                let light = self.next_event(p, |d| Ray::new(p, d), lit, ctx);
                path.radiance += path.throughput * light;
                let eval = |direction| {
                    let value = medium.phase.eval(incoming.dot(direction));
                    (S::splat(value), value)
                };
                let toward = self.toward_lamps(p);
                self.send_at_lamps(path, toward.as_ref(), |d| Ray::new(p, d), eval, ctx);
                let (direction, pdf) = medium.phase.sample(incoming, ctx.rng.uniform2());
                path.lamp_share = toward.map_or(1.0, |toward| toward.left(direction, pdf));
                path.scatter_pdf = Some((pdf, p));
                path.ray = Ray::new(p, direction);
                return Flight::Scattered;
            } else if u < p_scatter + p_null {
                ctx.work.null_collisions += 1;
                path.throughput = null / (c.majorant * p_null);
                flights.carry_on(path.throughput, c.t, &mut ctx.rng);
            } else {
                return Flight::Ended;
            }
        }
    }

    /// The lamps along the part of `ray` before `end` that leads through media.
    fn lamps(&self, ray: &Ray<World>, end: f64) -> EquiangularLights {
        let media = &self.scene.media;
        let all = Span::new(0.0, end);
        let span = if media.is_endless() { all } else { media.bounds().clip(ray).intersect(all) };
        EquiangularLights::beside(&self.scene.lights, ray, span)
    }

    /// About the density of collisions at the distance `t` along `ray`, 1/m, which weighs the two
    /// ways of finding the light of `lamps`.
    fn flux<S: Spectrum>(
        &self,
        ray: &Ray<World>,
        t: f64,
        lamps: &EquiangularLights,
        ctx: &mut PathContext,
    ) -> f64 {
        if lamps.is_empty() {
            return 0.0;
        }
        let media = &self.scene.media;
        let span = Span::new(0.0, t);
        let transmittance: S = media.transmittance_counted(ray, span, &mut ctx.work);
        ctx.work.grid_lookups += media.density_grids();
        (transmittance * S::from_rgb(media.sigma_t_at(ray.at(t)))).element_sum() / 3.0
    }

    /// Directions nearly at lamps from `at`, where rays are sent along them.
    fn toward_lamps(&self, at: WorldPoint) -> Option<PunctualDirections> {
        self.aims.then(|| PunctualDirections::new(&self.scene.lights, at))
    }

    /// Adds the light of lamps that comes to the path's end on a ray nearly from one of them,
    /// scattered once along it, and goes on along the path; `scatter` gives the share that does and
    /// the density with which scattering would have chosen the direction.
    fn send_at_lamps<S: Spectrum>(
        &self,
        path: &mut Path<S>,
        toward: Option<&PunctualDirections>,
        leave: impl Fn(DVec3) -> Ray<World>,
        scatter: impl Fn(DVec3) -> (S, f64),
        ctx: &mut PathContext,
    ) {
        let Some(toward) = toward else { return };
        if path.inside > 0 || path.scattered >= self.max_scatter {
            return;
        }
        let sample = toward.sample(ctx.rng.uniform(), ctx.rng.uniform2());
        let Some((direction, pdf)) = sample else { return };
        let (share, scatter_pdf) = scatter(direction);
        if share == S::ZERO {
            return;
        }
        let ray = leave(direction);
        let hit = direct_light::first_surface(self.scene, &ray, ctx);
        let lamps = self.lamps(&ray, hit.map_or(f64::INFINITY, |hit| hit.t));
        let light: S = self.beside_lamps(&ray, &lamps, |_, _, _, _| 0.0, ctx);
        path.radiance += path.throughput * share * light / (pdf + scatter_pdf);
    }

    /// Light of `lamps` that is scattered once along `ray` to its origin, found at places dense
    /// near them; `other` tells for a lamp, a place and its distance with which density, 1/m, the
    /// light is found there in another way.
    fn beside_lamps<S: Spectrum>(
        &self,
        ray: &Ray<World>,
        lamps: &EquiangularLights,
        other: impl Fn(usize, WorldPoint, f64, &mut PathContext) -> f64,
        ctx: &mut PathContext,
    ) -> S {
        let (media, lights) = (&self.scene.media, &self.scene.lights);
        let mut sum = S::ZERO;
        for (index, distances) in lamps.pick(ctx.rng.uniform()) {
            let t = distances.sample(ctx.rng.uniform());
            let p = ray.at(t);
            let Some(light) = lights.lights[*index].sample(p, ctx.rng.uniform2()) else {
                continue;
            };
            let direction = light.direction;
            let scattering = |(medium, sigma_s): &(usize, Rgb)| {
                S::from_rgb(*sigma_s) * media.get(*medium).phase.eval(ray.direction.dot(direction))
            };
            let scattering: S = media.mixture_at(p).iter().map(scattering).sum();
            ctx.work.grid_lookups += media.scattering_grids();
            let shadow = Ray::new(p, direction);
            if scattering == S::ZERO || !direct_light::is_visible(self.scene, &shadow, &light, ctx)
            {
                continue;
            }
            let through: S = self.transmittance(ray, t, ctx);
            let through = through * self.transmittance::<S>(&shadow, light.distance, ctx);
            let pdf = lamps.pdf(*index, t) + other(*index, p, t, ctx);
            sum += S::from_rgb(light.radiance) * through * scattering / pdf;
        }
        sum
    }

    /// Direct light at `at` from a sampled light; `scatter` gives, for the light's index, the
    /// probability of picking it and its sample, the share that goes on along the path and the
    /// density with which scattering would have chosen the direction.
    fn next_event<S: Spectrum>(
        &self,
        at: WorldPoint,
        leave: impl Fn(DVec3) -> Ray<World>,
        scatter: impl Fn(usize, f64, &LightSample) -> (S, f64),
        ctx: &mut PathContext,
    ) -> S {
        let anywhere = |_, ctx: &mut PathContext| ctx.rng.uniform2();
        direct_light::each_light(self.scene, at, ctx, anywhere, |index, light, choice, ctx| {
            let (own, (share, scatter_pdf)) = (choice * light.pdf, scatter(index, choice, light));
            let ray = leave(light.direction);
            if share == S::ZERO || !direct_light::is_visible(self.scene, &ray, light, ctx) {
                return S::ZERO;
            }
            let transmittance: S = self.transmittance(&ray, light.distance, ctx);
            let pdf = if light.delta { own } else { own + scatter_pdf };
            S::from_rgb(light.radiance) * transmittance * share / pdf
        })
    }

    /// Scatters the path at a surface; whether it goes on.
    fn bounce<S: Spectrum>(
        &self,
        path: &mut Path<S>,
        hit: &SurfaceHit<'_>,
        ctx: &mut PathContext,
    ) -> bool {
        let incoming = path.ray.direction;
        let toward = self.toward_lamps(hit.point);
        if !hit.material.is_specular() {
            let share = |direction: DVec3| {
                let cosine = direction.dot(hit.shading_normal).abs();
                let share = hit.material.eval(incoming, direction, hit, TransportMode::Radiance);
                (S::from_rgb(share * cosine), hit.material.pdf(incoming, direction, hit))
            };
            let lit = |_, _, light: &LightSample| share(light.direction);
            let light = self.next_event(hit.point, |d| hit.leave(d), lit, ctx);
            path.radiance += path.throughput * light;
            self.send_at_lamps(path, toward.as_ref(), |d| hit.leave(d), share, ctx);
        }
        let u = std::array::from_fn(|_| ctx.rng.uniform());
        let scattered = hit.material.scatter(incoming, hit, u, TransportMode::Radiance);
        let Some(scattered) = scattered else { return false };
        path.throughput *= S::from_rgb(scattered.weight);
        path.scatter_pdf = (!scattered.specular).then_some((scattered.pdf, hit.point));
        path.lamp_share = toward
            .filter(|_| !scattered.specular)
            .map_or(1.0, |toward| toward.left(scattered.direction, scattered.pdf));
        path.inside = (path.inside + i32::from(scattered.crossing)).max(0);
        path.ray = hit.leave(scattered.direction);
        path.throughput != S::ZERO
    }
}

/// Russian roulette on the throughput.
fn survives<S: Spectrum>(path: &mut Path<S>, ctx: &mut PathContext) -> bool {
    let survival = path.throughput.max_element().min(1.0);
    if ctx.rng.uniform() >= survival {
        return false;
    }
    path.throughput /= survival;
    true
}

/// How a flight through media ended.
enum Flight {
    Through,
    Scattered,
    Ended,
}
