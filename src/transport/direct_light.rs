//! Next-event estimation: direct light at a point in a medium or on a surface.
//!
//! Camera rays, caches and final gathers use all of it. The reference samples lights by
//! [`sample_lights`] too, but estimates transmittance by ratio tracking of its own: that keeps it
//! unbiased whatever the march does.

use glam::DVec3;

use crate::light::{EmitterHit, Light, LightSample};
use crate::math::{GOLDEN_RATIO, Ray, Rgb, Span, Spectrum, World, WorldPoint};
use crate::medium::{Media, Phase};
use crate::surface::{SurfaceHit, TransportMode};

use crate::scene::Scene;

use super::PathContext;

/// Shadow rays end at this fraction of the distance to a light, so that they do not meet the light's own
/// surface. The margin exceeds the rounding of an intersection in f64 by orders of magnitude.
///
/// Unit: none. Derivation: f64 rounds by 1e-16, and a blocker within 1e-7 of the distance to a light
/// touches it.
const SHORT_OF_LIGHT: f64 = 1.0 - 1e-7;

/// A phase function with its weight at a point, often the albedo of its medium.
pub type Scatterer<'a, S = Rgb> = (&'a Phase, S);

/// Radiance that the surface at `hit` emits back along `ray`, W/(m² sr).
pub fn emitted(scene: &Scene, ray: &Ray<World>, hit: &SurfaceHit<'_>) -> Rgb {
    hit.light.map_or(Rgb::ZERO, |light| {
        scene.lights.lights[light as usize].radiance_from(ray.direction, Some(emitter(hit)))
    })
}

/// The emitter that a ray has hit: what the density of sampling it by its light depends on.
pub fn emitter(hit: &SurfaceHit<'_>) -> EmitterHit {
    EmitterHit { distance: hit.t, normal: hit.normal }
}

/// The closest surface that `ray` (unit direction) hits.
pub fn first_surface<'s>(
    scene: &'s Scene,
    ray: &Ray<World>,
    ctx: &mut PathContext,
) -> Option<SurfaceHit<'s>> {
    if !ctx.needs.surfaces {
        return None;
    }
    ctx.work.intersections += 1;
    scene.surfaces.intersect(ray, Span::AHEAD)
}

/// Radiance, W/(m² sr), that `ray` (unit direction) sees of lights infinitely far away.
pub fn environment(scene: &Scene, ray: &Ray<World>, ctx: &mut PathContext) -> Rgb {
    if !ctx.needs.environment {
        return Rgb::ZERO;
    }
    ctx.work.environment_lookups += 1;
    scene.lights.environment_radiance(ray.direction)
}

/// Samples lights as seen from `at` and sums `contribution`, which gets the light's index, the
/// sample, and the probability of choosing the light. `position` gives the two numbers that choose a
/// position on a light.
pub fn sample_lights<S: Spectrum>(
    scene: &Scene,
    at: WorldPoint,
    ctx: &mut PathContext,
    position: impl Fn(usize, &mut PathContext) -> [f64; 2],
    mut contribution: impl FnMut(usize, &LightSample, f64, &mut PathContext) -> S,
) -> S {
    let u = ctx.rng.uniform();
    let mut of = |index: usize, probability: f64, ctx: &mut PathContext| {
        let sample = scene.lights.lights[index].sample(at, position(index, ctx));
        let light = sample.filter(LightSample::shines);
        light.map_or(S::ZERO, |light| contribution(index, &light, probability, ctx))
    };
    if !ctx.needs.light_choice {
        return if scene.lights.lights.is_empty() { S::ZERO } else { of(0, 1.0, ctx) };
    }
    let mut sum = S::ZERO;
    for (index, probability) in scene.lights.pick(at, u) {
        ctx.work.light_choices += u64::from(probability < 1.0);
        sum += of(index, probability, ctx);
    }
    sum
}

/// Independent numbers for a position on a light, for [`sample_lights`].
pub fn independent_position(_light: usize, ctx: &mut PathContext) -> [f64; 2] {
    ctx.rng.uniform2()
}

/// Whether no surface blocks the shadow ray `ray` before a sampled light.
pub fn is_visible(
    scene: &Scene,
    ray: &Ray<World>,
    light: &LightSample,
    ctx: &mut PathContext,
) -> bool {
    is_clear(scene, ray, light.distance * SHORT_OF_LIGHT, ctx)
}

/// Whether no surface stands within `distance` metres along `ray` (unit direction).
pub fn is_clear(scene: &Scene, ray: &Ray<World>, distance: f64, ctx: &mut PathContext) -> bool {
    if !ctx.needs.surfaces {
        return true;
    }
    ctx.work.shadow_rays += 1;
    !scene.surfaces.occluded(ray, Span::new(0.0, distance))
}

/// In-scattered direct light at `p` in a medium toward the unit direction `wo`, per unit of the
/// scatterers' weights: with weights sigma_s / sigma_t a source function, W/(m² sr). The light of
/// each light is divided by `count` of its index and the probability of choosing it.
///
/// Lights that a ray can hit are sampled by the light or by the phase function, half of the time
/// each, where the phase function is not isotropic, with the balance heuristic for one sample (Veach
/// 1997, section 9.2.4).
pub fn direct_in_medium<S: Spectrum>(
    scene: &Scene,
    p: WorldPoint,
    wo: DVec3,
    scatterers: &[Scatterer<'_, S>],
    count: impl Fn(usize, f64) -> f64,
    ctx: &mut PathContext,
) -> S {
    // Phase functions are symmetric, so directions to lights are sampled from the viewing direction.
    let sampled_phase = match scatterers {
        [(phase, _)] if !phase.is_isotropic() && scene.lights.has_extended() => Some(*phase),
        _ => None,
    };
    if let Some(phase) = sampled_phase.filter(|_| ctx.rng.uniform() >= 0.5) {
        let (direction, pdf) = phase.sample(-wo, ctx.rng.uniform2());
        if pdf <= 0.0 {
            return S::ZERO;
        }
        let ray = Ray::new(p, direction);
        let mis_weight =
            |index, choice, light_pdf| 2.0 / (choice * light_pdf + pdf) / count(index, choice);
        return light_along::<S>(scene, &ray, mis_weight, ctx) * scatterers[0].1 * pdf;
    }
    sample_lights(scene, p, ctx, independent_position, |index, light, choice, ctx| {
        let light_pdf = choice * light.pdf;
        let pdf = match sampled_phase {
            None => light_pdf,
            Some(_) if light.delta => 0.5 * light_pdf,
            Some(phase) => 0.5 * light_pdf + 0.5 * phase.eval(-light.direction.dot(wo)),
        };
        in_scattered(scene, p, wo, scatterers, light, ctx) / (pdf * count(index, choice))
    })
}

/// In-scattered light of one light sample, not divided by its density: what of it is scattered at `p`
/// in a medium toward the unit direction `wo`, per unit of the scatterers' weights.
pub fn in_scattered<S: Spectrum>(
    scene: &Scene,
    p: WorldPoint,
    wo: DVec3,
    scatterers: &[Scatterer<'_, S>],
    light: &LightSample,
    ctx: &mut PathContext,
) -> S {
    let cosine = -light.direction.dot(wo);
    let phase: S = scatterers.iter().map(|(phase, weight)| *weight * phase.eval(cosine)).sum();
    let ray = Ray::new(p, light.direction);
    if phase == S::ZERO || !is_visible(scene, &ray, light, ctx) {
        return S::ZERO;
    }
    let span = Span::new(0.0, light.distance);
    let transmittance: S = scene.media.transmittance_counted(&ray, span, &mut ctx.work);
    S::from_rgb(light.radiance) * phase * transmittance
}

/// Radiance of the lights that `ray` hits, through media, each times `weight` of its index, the
/// probability of choosing it and the density with which its own sampling has this direction.
fn light_along<S: Spectrum>(
    scene: &Scene,
    ray: &Ray<World>,
    weight: impl Fn(usize, f64, f64) -> f64,
    ctx: &mut PathContext,
) -> S {
    ctx.work.shadow_rays += 1;
    let hit = scene.surfaces.intersect(ray, Span::AHEAD);
    let at = hit.as_ref().map(emitter);
    let lights = &scene.lights;
    let mut radiance = S::ZERO;
    for (index, light) in lights.lights.iter().enumerate() {
        let is_hit = match &hit {
            Some(hit) => hit.light == Some(index as u32),
            None => light.is_infinite(),
        };
        if is_hit {
            let emitted = light.radiance_from(ray.direction, at);
            if emitted != Rgb::ZERO {
                let choice = lights.pick_probability(ray.origin, index);
                radiance +=
                    S::from_rgb(emitted) * weight(index, choice, light.pdf(ray.direction, at));
            }
        }
    }
    if radiance == S::ZERO {
        return radiance;
    }
    let end = hit.map_or(f64::INFINITY, |h| h.t);
    let span = Span::new(0.0, end);
    radiance * scene.media.transmittance_counted::<S>(ray, span, &mut ctx.work)
}

/// Direct light that the diffuse surface at `hit` reflects back along the unit `incoming`, through
/// `media` (those of the scene, or none), W/(m² sr). `stratified` are the two numbers for a position on a
/// light, shared by all lights; independent ones where it is `None`. An environment is sampled by
/// itself or by the surface, half of the time each, with the balance heuristic for one sample (Veach
/// 1997, section 9.2.4), other lights by themselves.
pub fn direct_on_surface<S: Spectrum>(
    scene: &Scene,
    media: &Media,
    incoming: DVec3,
    hit: &SurfaceHit<'_>,
    stratified: Option<[f64; 2]>,
    ctx: &mut PathContext,
) -> S {
    let material = hit.material;
    let reflected = |direction: DVec3| {
        material.eval(incoming, direction, hit, TransportMode::Radiance)
            * direction.dot(hit.shading_normal).abs()
    };
    let position = |index, ctx: &mut PathContext| match stratified {
        // Decorrelates lights that share one stratified number.
        Some(u) => u.map(|u| (u + index as f64 * GOLDEN_RATIO).fract()),
        None => ctx.rng.uniform2(),
    };
    sample_lights(scene, hit.point, ctx, position, |index, light, choice, ctx| {
        let light_pdf = choice * light.pdf;
        let kind = &scene.lights.lights[index];
        let Light::Environment(sky) = kind else {
            let weight = reflected(light.direction) / light_pdf;
            return unoccluded(scene, media, hit, light, weight, ctx);
        };
        if ctx.rng.uniform() < 0.5 {
            let surface_pdf = material.pdf(incoming, light.direction, hit);
            let weight = reflected(light.direction) / (0.5 * (light_pdf + surface_pdf));
            return unoccluded(scene, media, hit, light, weight, ctx);
        }
        let u = std::array::from_fn(|_| ctx.rng.uniform());
        let scattered = material.scatter(incoming, hit, u, TransportMode::Radiance);
        let Some(scattered) = scattered else { return S::ZERO };
        let direction = scattered.direction;
        let sampled = LightSample { direction, radiance: sky.radiance(direction), ..*light };
        let light_pdf = choice * kind.pdf(direction, None);
        let weight = scattered.weight * scattered.pdf / (0.5 * (light_pdf + scattered.pdf));
        unoccluded(scene, media, hit, &sampled, weight, ctx)
    })
}

/// `weight` times the radiance of a light sample that arrives at `hit`: 0 behind surfaces, attenuated by
/// `media`.
fn unoccluded<S: Spectrum>(
    scene: &Scene,
    media: &Media,
    hit: &SurfaceHit<'_>,
    light: &LightSample,
    weight: Rgb,
    ctx: &mut PathContext,
) -> S {
    let ray = hit.leave(light.direction);
    let weight = S::from_rgb(weight);
    if weight == S::ZERO || !is_visible(scene, &ray, light, ctx) {
        return S::ZERO;
    }
    if media.is_empty() || !ctx.needs.media {
        return S::from_rgb(light.radiance) * weight;
    }
    let span = Span::new(0.0, light.distance);
    S::from_rgb(light.radiance)
        * weight
        * media.transmittance_counted::<S>(&ray, span, &mut ctx.work)
}
