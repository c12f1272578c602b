//! The unbiased reference: null-collision path tracing with next-event estimation.
//!
//! It shares the scene and the path engine with the march, and none of its estimators: collisions come
//! from null-collision tracking and transmittance from ratio tracking over majorants (Novák et al.
//! 2018, sections 4 and 5), where the march integrates optical thickness. Light that can be sampled in
//! two ways is combined by the balance heuristic (Veach 1997, section 9.2.2): lights that a ray can
//! hit, and punctual lights, whose light scattered along a ray is sampled at collisions and
//! equiangularly (Kulla and Fajardo 2012). Where phase functions have sharp peaks rays are also sampled
//! near punctual lights: a peak there and a wide scattering before it are sampled as one (after
//! Georgiev et al. 2013, "Joint Importance Sampling of Low-Order Volumetric Scattering").

use glam::DVec3;

use crate::film::Sample;
use crate::light::LightSample;
use crate::math::{Ray, Rgb, Span, Spectrum, World, WorldPoint, luminance};
use crate::scene::Scene;
use crate::surface::{SurfaceHit, TransportMode};
use crate::transport::tracking::{self, Absorption, FlightEnd, FlightStep};
use crate::transport::{
    EquiangularLights, LightNumbers, MAX_EVENTS, PathContext, PathState, PunctualDirections,
    Scattering, direct_light, survives_roulette,
};

/// [`concentration`](crate::medium::Phase::concentration) of a phase function above which
/// rays are sampled near punctual lights, without unit: lobes of fog. Broader ones hit the surroundings of
/// lights by themselves.
const PEAKED: f64 = 50.0;

/// Events of a path before Russian roulette begins: early roulette only adds variance.
const SURE_EVENTS: u32 = 8;

/// Traces camera paths through a scene.
#[derive(Debug)]
pub struct PathTracer<'a> {
    scene: &'a Scene,
    max_scatter: u32,
    /// Whether rays are sampled near punctual lights.
    samples_near_lights: bool,
}

/// A path in progress.
struct ReferencePath<S> {
    state: PathState<S>,
    /// Where its next flight ends at the latest, in metres: where the camera ceases to see, then nowhere.
    end: f64,
    /// Order of volume scattering so far.
    order: u32,
    /// MIS weight of punctual lights where their light is scattered next along the ray, against rays
    /// sampled near them.
    punctual_weight: f64,
}

impl<'a> PathTracer<'a> {
    /// Traces `scene` with volume scattering up to the order `max_scatter`.
    pub fn new(scene: &'a Scene, max_scatter: Option<u32>) -> Self {
        let has_punctual = scene.lights.lights.iter().any(|light| light.position().is_some());
        let is_peaked = scene.media.iter().any(|m| m.phase.concentration() > PEAKED);
        let samples_near_lights = has_punctual && is_peaked;
        Self { scene, max_scatter: max_scatter.unwrap_or(u32::MAX), samples_near_lights }
    }

    /// An estimate of the light that arrives along `ray`, one of the camera's, at its origin.
    pub fn radiance<S: Spectrum>(&self, ray: Ray<World>, ctx: &mut PathContext) -> Sample {
        let seen = self.scene.camera.end(&ray);
        let first = direct_light::first_surface_before(self.scene, &ray, seen, ctx).map(|h| h.t);
        let end = first.unwrap_or(seen);
        let transmittance = luminance(self.transmittance::<S>(&ray, end, ctx).rgb());
        let state = PathState::<S>::new(ray);
        let mut path = ReferencePath { state, end: seen, order: 0, punctual_weight: 1.0 };
        let ended = (0..MAX_EVENTS).any(|event| {
            let goes_on = self.step(&mut path, ctx);
            let throughput = &mut path.state.throughput;
            !goes_on || (event >= SURE_EVENTS && !survives_roulette(throughput, &mut ctx.rng))
        });
        ctx.work.capped_paths += u64::from(!ended);
        Sample {
            radiance: path.state.radiance.rgb(),
            alpha: if first.is_some() { 1.0 } else { 1.0 - transmittance },
            depth: first.map_or(f64::INFINITY, |t| self.scene.camera.near(&ray) + t),
            transmittance,
            ..Sample::default()
        }
    }

    fn transmittance<S: Spectrum>(&self, ray: &Ray<World>, end: f64, ctx: &mut PathContext) -> S {
        let span = Span::new(0.0, end);
        self.scene.media.ratio_tracking(ray, span, &mut ctx.rng, &mut ctx.work)
    }

    /// Traces the path to the next scattering or surface and through it; whether it goes on.
    fn step<S: Spectrum>(&self, path: &mut ReferencePath<S>, ctx: &mut PathContext) -> bool {
        let seen = std::mem::replace(&mut path.end, f64::INFINITY);
        let hit = direct_light::first_surface_before(self.scene, &path.state.ray, seen, ctx);
        let end = hit.as_ref().map_or(seen, |h| h.t);
        if path.state.solids.is_none() {
            let punctual = self.punctual_lights(&path.state.ray, end);
            self.add_equiangular(path, &punctual, ctx);
            match self.fly(&mut path.state, end, ctx) {
                FlightEnd::Through => (),
                FlightEnd::Scattered { t, medium } => {
                    return self.scatter_in_medium(path, t, medium, &punctual, ctx);
                }
                FlightEnd::Absorbed(_) => return false,
            }
        }
        self.add_emitters(&mut path.state, hit.as_ref());
        hit.is_some_and(|hit| self.scatter_at_surface(path, &hit, ctx))
    }

    /// Adds the light of the emitters that the path's ray hits: a surface or environments.
    fn add_emitters<S: Spectrum>(&self, path: &mut PathState<S>, hit: Option<&SurfaceHit<'_>>) {
        let at = hit.map(direct_light::emitter);
        for (index, light) in self.scene.lights.lights.iter().enumerate() {
            let is_hit = hit.map_or(light.is_infinite(), |h| h.light == Some(index as u32));
            if !is_hit {
                continue;
            }
            let radiance = light.radiance_from(path.ray.direction, at);
            if radiance == Rgb::ZERO {
                continue;
            }
            let weight = path.scattering.map_or(1.0, |last| {
                let choice = self.scene.lights.pick_probability(last.position, index);
                last.pdf / (last.pdf + choice * light.pdf(path.ray.direction, at))
            });
            path.radiance += path.throughput * S::from_rgb(radiance) * weight;
        }
    }

    /// Flies through the media as far as `end` metres and adds what they emit.
    fn fly<S: Spectrum>(
        &self,
        path: &mut PathState<S>,
        end: f64,
        ctx: &mut PathContext,
    ) -> FlightEnd {
        let PathState { ray, throughput, radiance, .. } = path;
        let media = &self.scene.media;
        let visit = |step: &FlightStep<S>, ctx: &mut PathContext| {
            tracking::add_emission(radiance, media, ray, step, |_, _| 1.0, ctx);
        };
        tracking::fly(media, ray, end, throughput, Absorption::Sampled, ctx, visit)
    }

    /// Samples lights where `medium` scatters the path at the distance `t`, and a new direction;
    /// whether the path goes on.
    fn scatter_in_medium<S: Spectrum>(
        &self,
        path: &mut ReferencePath<S>,
        t: f64,
        medium: usize,
        punctual: &EquiangularLights<'_>,
        ctx: &mut PathContext,
    ) -> bool {
        path.order += 1;
        if path.order > self.max_scatter {
            return false;
        }
        let phase = &self.scene.media.get(medium).phase;
        let (p, incoming) = (path.state.ray.at(t), path.state.ray.direction);
        let flux = self.collision_density::<S>(&path.state.ray, t, punctual, ctx);
        let punctual_weight = path.punctual_weight;
        let phase_and_weight = |index: usize, choice: f64, light: &LightSample| {
            let value = phase.eval(incoming.dot(light.direction));
            let equiangular = punctual.pdf(index, &light.origin(p), t);
            let weight =
                if equiangular > 0.0 { choice * flux / (choice * flux + equiangular) } else { 1.0 };
            let is_punctual = self.scene.lights.lights[index].position().is_some();
            let other = if is_punctual { punctual_weight } else { 1.0 };
            (S::splat(value * weight * other), value)
        };
        let light = self.next_event(p, |d| Ray::new(p, d), phase_and_weight, ctx);
        path.state.radiance += path.state.throughput * light;
        let eval = |direction| {
            let value = phase.eval(incoming.dot(direction));
            (S::splat(value), value)
        };
        let near_lights = self.directions_near_lights(p);
        self.add_near_lights(path, near_lights.as_ref(), |d| Ray::new(p, d), eval, ctx);
        let (direction, pdf) = phase.sample(incoming, ctx.rng.uniform2());
        path.punctual_weight = near_lights.map_or(1.0, |near| near.mis_weight(direction, pdf));
        path.state.scattering = Some(Scattering { position: p, pdf, medium: Some(medium) });
        path.state.ray = Ray::new(p, direction);
        true
    }

    /// Equiangular distributions of punctual lights over the part of `ray` before `end` that is in
    /// media.
    fn punctual_lights(&self, ray: &Ray<World>, end: f64) -> EquiangularLights<'_> {
        let media = &self.scene.media;
        let all = Span::new(0.0, end);
        let span = if media.is_endless() { all } else { media.bounds().clip(ray).intersect(all) };
        EquiangularLights::punctual(&self.scene.lights, ray, span)
    }

    /// Density of collisions at the distance `t` along `ray`, 1/m, mean over channels: what collision
    /// sampling of the light of `punctual` has in the balance heuristic. Without those it is 0.
    fn collision_density<S: Spectrum>(
        &self,
        ray: &Ray<World>,
        t: f64,
        punctual: &EquiangularLights<'_>,
        ctx: &mut PathContext,
    ) -> f64 {
        if punctual.is_empty() {
            return 0.0;
        }
        let media = &self.scene.media;
        let span = Span::new(0.0, t);
        let transmittance: S = media.transmittance_counted(ray, span, &mut ctx.work);
        ctx.work.grid_lookups += media.density_grids();
        (transmittance * S::from_rgb(media.sigma_t_at(ray.at(t)))).element_sum() / 3.0
    }

    /// Directions from `at` near punctual lights, where rays are sampled along them.
    fn directions_near_lights(&self, at: WorldPoint) -> Option<PunctualDirections> {
        self.samples_near_lights.then(|| PunctualDirections::new(&self.scene.lights, at))
    }

    /// Adds light of punctual lights that is scattered once along a ray sampled near one of them, and
    /// again where the path is; `scatter` gives phase function or BSDF times cosine for a direction,
    /// and the density with which that would have been sampled.
    fn add_near_lights<S: Spectrum>(
        &self,
        path: &mut ReferencePath<S>,
        near_lights: Option<&PunctualDirections>,
        leave: impl Fn(DVec3) -> Ray<World>,
        scatter: impl Fn(DVec3) -> (S, f64),
        ctx: &mut PathContext,
    ) {
        let Some(near_lights) = near_lights else { return };
        if !path.state.solids.is_none() || path.order >= self.max_scatter {
            return;
        }
        let sample = near_lights.sample(ctx.rng.uniform(), ctx.rng.uniform2());
        let Some((direction, pdf)) = sample else { return };
        let (value, scatter_pdf) = scatter(direction);
        if value == S::ZERO {
            return;
        }
        let ray = leave(direction);
        let hit = direct_light::first_surface(self.scene, &ray, ctx);
        let punctual = self.punctual_lights(&ray, hit.map_or(f64::INFINITY, |hit| hit.t));
        let light: S = self.equiangular_light(&ray, &punctual, |_, _, _, _| 0.0, ctx);
        path.state.radiance += path.state.throughput * value * light / (pdf + scatter_pdf);
    }

    /// Adds the light of `punctual` that is scattered next along the path's ray, sampled equiangularly,
    /// with the balance heuristic against collisions.
    fn add_equiangular<S: Spectrum>(
        &self,
        path: &mut ReferencePath<S>,
        punctual: &EquiangularLights<'_>,
        ctx: &mut PathContext,
    ) {
        if path.order >= self.max_scatter {
            return;
        }
        let ray = path.state.ray;
        let at_collisions = |index: usize, p: WorldPoint, t: f64, ctx: &mut PathContext| {
            let flux = self.collision_density::<S>(&ray, t, punctual, ctx);
            self.scene.lights.pick_probability(p, index) * flux
        };
        let light: S = self.equiangular_light(&ray, punctual, at_collisions, ctx);
        path.state.radiance += path.state.throughput * light * path.punctual_weight;
    }

    /// Light of `punctual` that is scattered once along `ray` to its origin, sampled equiangularly, W/(m²
    /// sr); `other_pdf` gives for a light's index, a point and its distance the density, 1/m, with
    /// which another estimator samples the light there.
    fn equiangular_light<S: Spectrum>(
        &self,
        ray: &Ray<World>,
        punctual: &EquiangularLights<'_>,
        other_pdf: impl Fn(usize, WorldPoint, f64, &mut PathContext) -> f64,
        ctx: &mut PathContext,
    ) -> S {
        let (media, lights) = (&self.scene.media, &self.scene.lights);
        let mut sum = S::ZERO;
        for sampled in punctual.pick(ctx.rng.uniform()) {
            let index = sampled.index;
            let (t_number, u) = (ctx.rng.uniform(), ctx.rng.uniform2());
            let light = &lights.lights[index];
            let Some(origin) = light.origin(u) else { continue };
            let Some(distances) = punctual.distances(sampled, &origin) else { continue };
            let t = distances.sample(t_number);
            let p = ray.at(t);
            let Some(light) = light.sample(p, u) else { continue };
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
            let pdf = punctual.pdf(index, &origin, t) + other_pdf(index, p, t, ctx);
            sum += S::from_rgb(light.radiance) * through * scattering / pdf;
        }
        sum
    }

    /// Direct light at `at` from sampled lights, with ratio-tracked transmittance; `scatter` gives, for
    /// a light's index, the probability of choosing it and its sample, phase function or BSDF times
    /// cosine with other weights, and the density with which scattering would have sampled the
    /// direction.
    fn next_event<S: Spectrum>(
        &self,
        at: WorldPoint,
        leave: impl Fn(DVec3) -> Ray<World>,
        scatter: impl Fn(usize, f64, &LightSample) -> (S, f64),
        ctx: &mut PathContext,
    ) -> S {
        let (among, u) = (ctx.rng.uniform(), ctx.rng.uniform2());
        let at_lights = LightNumbers::varied(among, u);
        direct_light::sample_lights(self.scene, at, at_lights, ctx, |index, light, choice, ctx| {
            let light_pdf = choice * light.pdf;
            let (value, scatter_pdf) = scatter(index, choice, light);
            let ray = leave(light.direction);
            if value == S::ZERO || !direct_light::is_visible(self.scene, &ray, light, ctx) {
                return S::ZERO;
            }
            let transmittance: S = self.transmittance(&ray, light.distance, ctx);
            let pdf = if light.delta { light_pdf } else { light_pdf + scatter_pdf };
            S::from_rgb(light.radiance) * transmittance * value / pdf
        })
    }

    /// Samples lights at a surface, and a new direction; whether the path goes on.
    fn scatter_at_surface<S: Spectrum>(
        &self,
        path: &mut ReferencePath<S>,
        hit: &SurfaceHit<'_>,
        ctx: &mut PathContext,
    ) -> bool {
        let incoming = path.state.ray.direction;
        let near_lights = self.directions_near_lights(hit.point);
        if !hit.material.is_specular() {
            let eval = |direction: DVec3| {
                let cosine = direction.dot(hit.shading_normal).abs();
                let bsdf = hit.material.eval(incoming, direction, hit, TransportMode::Radiance);
                (S::from_rgb(bsdf * cosine), hit.material.pdf(incoming, direction, hit))
            };
            let at_light = |_, _, light: &LightSample| eval(light.direction);
            let light = self.next_event(hit.point, |d| hit.leave(d), at_light, ctx);
            path.state.radiance += path.state.throughput * light;
            self.add_near_lights(path, near_lights.as_ref(), |d| hit.leave(d), eval, ctx);
        }
        let u = std::array::from_fn(|_| ctx.rng.uniform());
        let scattered = hit.material.scatter(incoming, hit, u, TransportMode::Radiance);
        let Some(scattered) = scattered else { return false };
        let state = &mut path.state;
        state.throughput *= S::from_rgb(scattered.weight);
        let scattering = Scattering { position: hit.point, pdf: scattered.pdf, medium: None };
        state.scattering = (!scattered.specular).then_some(scattering);
        path.punctual_weight = near_lights
            .filter(|_| !scattered.specular)
            .map_or(1.0, |near| near.mis_weight(scattered.direction, scattered.pdf));
        state.solids = state.solids.after(scattered.crossing);
        state.ray = hit.leave(scattered.direction);
        state.throughput != S::ZERO
    }
}
