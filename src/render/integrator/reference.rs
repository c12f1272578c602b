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

use crate::film::{CaughtShadow, Components, Sample};
use crate::light::LightSample;
use crate::math::{Ray, Rgb, Spectrum, World, luminance};
use crate::render::pixel_sampling::Workspace;
use crate::surface::{SurfaceHit, TransportMode};
use crate::transport::tracking::{self, Absorption, FlightEnd, FlightStep};
use crate::transport::{
    EquiangularLights, MAX_EVENTS, PathContext, PathState, Scattering, camera_view, direct_light,
    survives_roulette,
};

use super::reference_lights::{PathTracer, ReferencePath, Sight};

/// Events of a path before Russian roulette begins: early roulette only adds variance.
const SURE_EVENTS: u32 = 8;

impl PathTracer<'_> {
    /// An estimate of the light that arrives along `ray`, one of the camera's, at its origin.
    pub fn radiance<S: Spectrum>(&self, ray: Ray<World>, workspace: &mut Workspace<S>) -> Sample {
        let Workspace { ctx, parts, .. } = workspace;
        let hit = camera_view::first_surface(self.scene, &ray, ctx);
        let end = camera_view::span_before(self.scene, &ray, hit.as_ref()).end;
        let transmittance = luminance(self.transmittance::<S>(&ray, end, ctx).rgb());
        let state = PathState::<S>::new(ray);
        let sight = Sight::Camera;
        let mut path = ReferencePath {
            state,
            order: 0,
            punctual_weight: 1.0,
            sight,
            caught: None,
            before_surface: None,
        };
        let ended = (0..MAX_EVENTS).any(|event| {
            let goes_on = self.step(&mut path, ctx);
            let throughput = &mut path.state.throughput;
            !goes_on || (event >= SURE_EVENTS && !survives_roulette(throughput, &mut ctx.rng))
        });
        ctx.work.capped_paths += u64::from(!ended);
        let is_covered = hit.is_some_and(|hit| camera_view::covers(self.scene, &hit));
        let catches = hit.is_some_and(|hit| camera_view::catches_shadows(self.scene, &hit));
        let [shadowed, unshadowed] = path.caught.unwrap_or_default().map(luminance);
        let seen = if catches { transmittance } else { 0.0 };
        let radiance = path.state.radiance;
        let of_media = path.before_surface.unwrap_or(radiance);
        let components = [of_media, S::ZERO, S::ZERO, S::ZERO];
        *parts = self.scene.groups.told_apart(radiance, components);
        Sample {
            radiance: radiance.rgb(),
            components: Components { media: of_media.rgb(), ..Components::default() },
            alpha: if is_covered { 1.0 } else { 1.0 - transmittance },
            caught: CaughtShadow { seen, shadowed, unshadowed },
            depth: hit.map_or(f64::INFINITY, |hit| self.scene.camera.near(&ray) + hit.t),
            transmittance,
            ..Sample::default()
        }
    }

    /// Traces the path to the next scattering or surface and through it; whether it goes on.
    fn step<S: Spectrum>(&self, path: &mut ReferencePath<S>, ctx: &mut PathContext) -> bool {
        let sight = path.sight;
        path.sight = Sight::All;
        let from_camera = sight == Sight::Camera;
        let hit = camera_view::surface_along(self.scene, &path.state.ray, from_camera, ctx);
        let seen = if from_camera { self.scene.camera.end(&path.state.ray) } else { f64::INFINITY };
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
        if from_camera {
            path.before_surface = Some(path.state.radiance);
        }
        if from_camera && hit.is_some_and(|hit| camera_view::is_holdout(self.scene, &hit)) {
            return false;
        }
        if sight != Sight::NoLights {
            self.add_emitters(&mut path.state, hit.as_ref(), from_camera);
        }
        let Some(hit) = hit else { return false };
        let catches = from_camera && camera_view::catches_shadows(self.scene, &hit);
        self.scatter_at_surface(path, &hit, catches, ctx)
    }

    /// Adds the light of the emitters that the path's ray hits: a surface or environments; `from_camera` those that the
    /// camera sees.
    fn add_emitters<S: Spectrum>(
        &self,
        path: &mut PathState<S>,
        hit: Option<&SurfaceHit<'_>>,
        from_camera: bool,
    ) {
        let at = hit.map(direct_light::emitter);
        for (index, light) in self.scene.lights.lights.iter().enumerate() {
            let is_hit = hit.map_or(light.is_infinite(), |h| h.light == Some(index as u32));
            let is_hidden = from_camera && self.scene.lights.hidden.contains(&index);
            if !is_hit || is_hidden {
                continue;
            }
            let radiance = light.radiance_from(path.ray.direction, at);
            if radiance == Rgb::ZERO {
                continue;
            }
            let weight = path.scattering.map_or(1.0, |last| {
                let choice = self.scene.lights.pick_probability(last.position, index);
                last.pdf / (last.pdf + choice * light.pdf(last.position, path.ray.direction, at))
            });
            let radiance = S::of_group(radiance, self.scene.groups.of_light(index));
            path.radiance += path.throughput * radiance * weight;
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
        path.state.throughput = self.scene.groups.scattered(path.state.throughput);
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

    /// Samples lights at a surface, and a new direction; whether the path goes on. Direct light of a surface that `catches`
    /// shadows is kept apart from other light.
    fn scatter_at_surface<S: Spectrum>(
        &self,
        path: &mut ReferencePath<S>,
        hit: &SurfaceHit<'_>,
        catches: bool,
        ctx: &mut PathContext,
    ) -> bool {
        let incoming = path.state.ray.direction;
        let near_lights = self.directions_near_lights(hit.point);
        path.state.throughput = self.scene.groups.reflected(path.state.throughput);
        if !hit.material.is_specular() {
            let eval = |direction: DVec3| {
                let cosine = direction.dot(hit.shading_normal).abs();
                let bsdf = hit.material.eval(incoming, direction, hit, TransportMode::Radiance);
                (S::from_rgb(bsdf * cosine), hit.material.pdf(incoming, direction, hit))
            };
            if catches {
                let throughput = path.state.throughput;
                let light = self.with_and_without_shadow::<S>(hit, |d| eval(d).0, ctx);
                path.caught = Some(light.map(|light| (throughput * light).rgb()));
                path.sight = Sight::NoLights;
            } else {
                let at_light = |_, _, light: &LightSample| eval(light.direction);
                let light = self.next_event(hit.point, |d| hit.leave(d), at_light, ctx);
                path.state.radiance += path.state.throughput * light;
            }
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
