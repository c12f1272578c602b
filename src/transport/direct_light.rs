//! Direct light at a place in a medium or on a surface of a scene.

use glam::DVec3;

use crate::light::{EmitterHit, Light, LightSample};
use crate::math::{Ray, Rgb, Span, Spectrum, World, WorldPoint};
use crate::medium::{Media, Phase};
use crate::surface::{SurfaceHit, TransportMode};

use crate::scene::Scene;

use super::{PathContext, SobolPoint};

/// Shadow rays end this share short of a light that is a surface itself.
const SHORT_OF_LIGHT: f64 = 1.0 - 1e-7;

/// The golden ratio, multiples of which lie evenly between whole numbers.
const GOLDEN: f64 = 1.618_033_988_749_895;

/// A phase function at a place with its weight there.
pub type Scatterer<'a, S = Rgb> = (&'a Phase, S);

/// Radiance that the surface at `hit` emits back along `ray`, W/(m² sr).
pub fn emitted(scene: &Scene, ray: &Ray<World>, hit: &SurfaceHit<'_>) -> Rgb {
    hit.light.map_or(Rgb::ZERO, |light| {
        scene.lights.lights[light as usize].radiance_from(ray.direction, Some(emitter(hit)))
    })
}

/// The part of a hit that its light asks for.
pub fn emitter(hit: &SurfaceHit<'_>) -> EmitterHit {
    EmitterHit { distance: hit.t, normal: hit.normal }
}

/// The nearest surface that `ray` (unit direction) meets.
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

/// Sums `contribution` over samples of the lights picked for `at`: it is given the light's index,
/// the sample, and the probability of picking the light. `place` gives the numbers that choose a
/// place on a light.
pub fn each_light<S: Spectrum>(
    scene: &Scene,
    at: WorldPoint,
    ctx: &mut PathContext,
    place: impl Fn(usize, &mut PathContext) -> [f64; 2],
    mut contribution: impl FnMut(usize, &LightSample, f64, &mut PathContext) -> S,
) -> S {
    let u = ctx.rng.uniform();
    let mut of = |index: usize, probability: f64, ctx: &mut PathContext| {
        let sample = scene.lights.lights[index].sample(at, place(index, ctx));
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

/// Whether no surface stands on `ray` before a sampled light.
pub fn is_visible(
    scene: &Scene,
    ray: &Ray<World>,
    light: &LightSample,
    ctx: &mut PathContext,
) -> bool {
    if !ctx.needs.surfaces {
        return true;
    }
    ctx.work.shadow_rays += 1;
    let span = Span::new(0.0, light.distance * SHORT_OF_LIGHT);
    !scene.surfaces.occluded(ray, span)
}

/// Direct light scattered at `p` in a medium into the unit direction `toward`, per unit of the
/// scatterers' weights: with weights sigma_s / sigma_t a source function, W/(m² sr). The part of
/// each light is divided by `count` of its index and the probability of picking it.
///
/// Light that a ray can find by chance is sampled by the light and by the phase function in turn
/// where that is not isotropic, weighed by the balance heuristic for one sample (Veach 1997,
/// section 9.2.4).
pub fn in_medium<S: Spectrum>(
    scene: &Scene,
    p: WorldPoint,
    toward: DVec3,
    scatterers: &[Scatterer<'_, S>],
    count: impl Fn(usize, f64) -> f64,
    ctx: &mut PathContext,
) -> S {
    // The phase function is symmetric, so light towards the eye is sampled from the eye.
    let rival = match scatterers {
        [(phase, _)] if !phase.is_isotropic() && scene.lights.has_extended() => Some(*phase),
        _ => None,
    };
    if let Some(phase) = rival.filter(|_| ctx.rng.uniform() >= 0.5) {
        let (direction, pdf) = phase.sample(-toward, ctx.rng.uniform2());
        if pdf <= 0.0 {
            return S::ZERO;
        }
        let ray = Ray::new(p, direction);
        let share = |index, choice, own| 2.0 / (choice * own + pdf) / count(index, choice);
        return found::<S>(scene, &ray, share, ctx) * scatterers[0].1 * pdf;
    }
    let anywhere = |_, ctx: &mut PathContext| ctx.rng.uniform2();
    each_light(scene, p, ctx, anywhere, |index, light, choice, ctx| {
        let own = choice * light.pdf;
        let pdf = match rival {
            None => own,
            Some(_) if light.delta => 0.5 * own,
            Some(phase) => 0.5 * own + 0.5 * phase.eval(-light.direction.dot(toward)),
        };
        scattered(scene, p, toward, scatterers, light, ctx) / (pdf * count(index, choice))
    })
}

/// Light of one sample, not divided by its density, that is scattered at `p` in a medium into the
/// unit direction `toward`, per unit of the scatterers' weights.
pub fn scattered<S: Spectrum>(
    scene: &Scene,
    p: WorldPoint,
    toward: DVec3,
    scatterers: &[Scatterer<'_, S>],
    light: &LightSample,
    ctx: &mut PathContext,
) -> S {
    let cosine = -light.direction.dot(toward);
    let spread: S = scatterers.iter().map(|(phase, weight)| *weight * phase.eval(cosine)).sum();
    let ray = Ray::new(p, light.direction);
    if spread == S::ZERO || !is_visible(scene, &ray, light, ctx) {
        return S::ZERO;
    }
    let span = Span::new(0.0, light.distance);
    let transmittance: S = scene.media.transmittance_counted(&ray, span, &mut ctx.work);
    S::from_rgb(light.radiance) * spread * transmittance
}

/// Radiance of lights that `ray` finds by chance, each times `share` of its index, the probability
/// of picking it and the density with which its sampling would have found it.
fn found<S: Spectrum>(
    scene: &Scene,
    ray: &Ray<World>,
    share: impl Fn(usize, f64, f64) -> f64,
    ctx: &mut PathContext,
) -> S {
    ctx.work.shadow_rays += 1;
    let hit = scene.surfaces.intersect(ray, Span::AHEAD);
    let at = hit.as_ref().map(emitter);
    let lights = &scene.lights;
    let mut radiance = S::ZERO;
    for (index, light) in lights.lights.iter().enumerate() {
        let shines = match &hit {
            Some(hit) => hit.light == Some(index as u32),
            None => light.is_infinite(),
        };
        if shines {
            let seen = light.radiance_from(ray.direction, at);
            if seen != Rgb::ZERO {
                let choice = lights.pick_probability(ray.origin, index);
                radiance += S::from_rgb(seen) * share(index, choice, light.pdf(ray.direction, at));
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

/// Direct light that the diffuse surface at `hit` reflects back along the unit `incoming`, seen
/// through `media` (those of the scene, or none), W/(m² sr). An environment is found by sampling it
/// and the surface in turn, weighed by the balance heuristic for one sample, other lights by
/// sampling them.
pub fn on_surface<S: Spectrum>(
    scene: &Scene,
    media: &Media,
    incoming: DVec3,
    hit: &SurfaceHit<'_>,
    ctx: &mut PathContext,
) -> S {
    let material = hit.material;
    let reflected = |direction: DVec3| {
        material.eval(incoming, direction, hit, TransportMode::Radiance)
            * direction.dot(hit.shading_normal).abs()
    };
    let even = ctx.lights.take().map(SobolPoint::light);
    let place = |index, ctx: &mut PathContext| match even {
        // The same numbers for all lights, each set off against the others.
        Some(u) => u.map(|u| (u + index as f64 * GOLDEN).fract()),
        None => ctx.rng.uniform2(),
    };
    each_light(scene, hit.point, ctx, place, |index, light, picked, ctx| {
        let own = picked * light.pdf;
        let kind = &scene.lights.lights[index];
        let Light::Environment(sky) = kind else {
            return arriving(scene, media, hit, light, reflected(light.direction) / own, ctx);
        };
        if ctx.rng.uniform() < 0.5 {
            let other = material.pdf(incoming, light.direction, hit);
            let share = reflected(light.direction) / (0.5 * (own + other));
            return arriving(scene, media, hit, light, share, ctx);
        }
        let u = std::array::from_fn(|_| ctx.rng.uniform());
        let scattered = material.scatter(incoming, hit, u, TransportMode::Radiance);
        let Some(scattered) = scattered else { return S::ZERO };
        let direction = scattered.direction;
        let found = LightSample { direction, radiance: sky.radiance(direction), ..*light };
        let other = picked * kind.pdf(direction, None);
        let share = scattered.weight * scattered.pdf / (0.5 * (other + scattered.pdf));
        arriving(scene, media, hit, &found, share, ctx)
    })
}

/// `share` of a sampled light's radiance, as far as it arrives at `hit`.
fn arriving<S: Spectrum>(
    scene: &Scene,
    media: &Media,
    hit: &SurfaceHit<'_>,
    light: &LightSample,
    share: Rgb,
    ctx: &mut PathContext,
) -> S {
    let ray = hit.leave(light.direction);
    let share = S::from_rgb(share);
    if share == S::ZERO || !is_visible(scene, &ray, light, ctx) {
        return S::ZERO;
    }
    if media.is_empty() || !ctx.needs.media {
        return S::from_rgb(light.radiance) * share;
    }
    let span = Span::new(0.0, light.distance);
    S::from_rgb(light.radiance)
        * share
        * media.transmittance_counted::<S>(&ray, span, &mut ctx.work)
}
