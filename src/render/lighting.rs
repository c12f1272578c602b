//! Direct light at a place in a medium or on a surface.

use glam::DVec3;

use crate::light::{EmitterHit, Light, LightSample};
use crate::math::{Ray, Rgb, Span, World, WorldPoint};
use crate::medium::Phase;
use crate::scene::Scene;
use crate::surface::{SurfaceHit, TransportMode};

use super::expose::State;

/// Shadow rays end this share short of a light that is a surface itself.
const SHORT_OF_LIGHT: f64 = 1.0 - 1e-7;

/// A phase function at a place with its weight there.
pub type Scatterer<'a> = (&'a Phase, Rgb);

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

/// Sums `contribution` over samples of the lights picked for `at`: it is given the light's index,
/// the sample, and the probability of picking the light.
pub fn each_light(
    scene: &Scene,
    at: WorldPoint,
    state: &mut State,
    mut contribution: impl FnMut(usize, &LightSample, f64, &mut State) -> Rgb,
) -> Rgb {
    let mut sum = Rgb::ZERO;
    for (index, probability) in scene.lights.pick(at, state.rng.uniform()) {
        let sample = scene.lights.lights[index].sample(at, state.rng.uniform2());
        if let Some(light) = sample.filter(|s| s.pdf > 0.0 && s.radiance != Rgb::ZERO) {
            sum += contribution(index, &light, probability, state);
        }
    }
    sum
}

/// Whether no surface stands on `ray` before a sampled light.
pub fn is_visible(scene: &Scene, ray: &Ray<World>, light: &LightSample, state: &mut State) -> bool {
    if scene.surfaces.is_empty() {
        return true;
    }
    state.work.shadow_rays += 1;
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
pub fn in_medium(
    scene: &Scene,
    p: WorldPoint,
    toward: DVec3,
    scatterers: &[Scatterer<'_>],
    count: impl Fn(usize, f64) -> f64,
    state: &mut State,
) -> Rgb {
    // The phase function is symmetric, so light towards the eye is sampled from the eye.
    let rival = match scatterers {
        [(phase, _)] if !phase.is_isotropic() && scene.lights.has_extended() => Some(*phase),
        _ => None,
    };
    if let Some(phase) = rival.filter(|_| state.rng.uniform() >= 0.5) {
        let (direction, pdf) = phase.sample(-toward, state.rng.uniform2());
        if pdf <= 0.0 {
            return Rgb::ZERO;
        }
        let ray = Ray::new(p, direction);
        let share = |index, choice, own| 2.0 / (choice * own + pdf) / count(index, choice);
        return found(scene, &ray, share, state) * scatterers[0].1 * pdf;
    }
    each_light(scene, p, state, |index, light, choice, state| {
        let own = choice * light.pdf;
        let pdf = match rival {
            None => own,
            Some(_) if light.delta => 0.5 * own,
            Some(phase) => 0.5 * own + 0.5 * phase.eval(-light.direction.dot(toward)),
        };
        scattered(scene, p, toward, scatterers, light, state) / (pdf * count(index, choice))
    })
}

/// Light of one sample, not divided by its density, that is scattered at `p` in a medium into the
/// unit direction `toward`, per unit of the scatterers' weights.
pub fn scattered(
    scene: &Scene,
    p: WorldPoint,
    toward: DVec3,
    scatterers: &[Scatterer<'_>],
    light: &LightSample,
    state: &mut State,
) -> Rgb {
    let cosine = -light.direction.dot(toward);
    let spread: Rgb = scatterers.iter().map(|(phase, weight)| *weight * phase.eval(cosine)).sum();
    let ray = Ray::new(p, light.direction);
    if spread == Rgb::ZERO || !is_visible(scene, &ray, light, state) {
        return Rgb::ZERO;
    }
    state.work.marches += 1;
    light.radiance * spread * scene.media.transmittance(&ray, Span::new(0.0, light.distance))
}

/// Radiance of lights that `ray` finds by chance, each times `share` of its index, the probability
/// of picking it and the density with which its sampling would have found it.
fn found(
    scene: &Scene,
    ray: &Ray<World>,
    share: impl Fn(usize, f64, f64) -> f64,
    state: &mut State,
) -> Rgb {
    state.work.shadow_rays += 1;
    let hit = scene.surfaces.intersect(ray, Span::AHEAD);
    let at = hit.as_ref().map(emitter);
    let lights = &scene.lights;
    let mut radiance = Rgb::ZERO;
    for (index, light) in lights.lights.iter().enumerate() {
        let shines = match &hit {
            Some(hit) => hit.light == Some(index as u32),
            None => light.is_infinite(),
        };
        if shines {
            let seen = light.radiance_from(ray.direction, at);
            if seen != Rgb::ZERO {
                let choice = lights.pick_probability(ray.origin, index);
                radiance += seen * share(index, choice, light.pdf(ray.direction, at));
            }
        }
    }
    if radiance == Rgb::ZERO {
        return radiance;
    }
    state.work.marches += 1;
    let end = hit.map_or(f64::INFINITY, |h| h.t);
    radiance * scene.media.transmittance(ray, Span::new(0.0, end))
}

/// Direct light that the diffuse surface at `hit` reflects back along the unit `incoming`,
/// W/(m² sr). An environment is found by sampling it and the surface in turn, weighed by the
/// balance heuristic for one sample, other lights by sampling them.
pub fn on_surface(scene: &Scene, incoming: DVec3, hit: &SurfaceHit<'_>, state: &mut State) -> Rgb {
    let material = hit.material;
    let reflected = |direction: DVec3| {
        material.eval(incoming, direction, hit, TransportMode::Radiance)
            * direction.dot(hit.shading_normal).abs()
    };
    each_light(scene, hit.point, state, |index, light, picked, state| {
        let own = picked * light.pdf;
        let kind = &scene.lights.lights[index];
        let Light::Environment(sky) = kind else {
            return arriving(scene, hit, light, reflected(light.direction) / own, state);
        };
        if state.rng.uniform() < 0.5 {
            let other = material.pdf(incoming, light.direction, hit);
            let share = reflected(light.direction) / (0.5 * (own + other));
            return arriving(scene, hit, light, share, state);
        }
        let u = std::array::from_fn(|_| state.rng.uniform());
        let scattered = material.scatter(incoming, hit, u, TransportMode::Radiance);
        let Some(scattered) = scattered else { return Rgb::ZERO };
        let direction = scattered.direction;
        let found = LightSample { direction, radiance: sky.radiance(direction), ..*light };
        let other = picked * kind.pdf(direction, None);
        let share = scattered.weight * scattered.pdf / (0.5 * (other + scattered.pdf));
        arriving(scene, hit, &found, share, state)
    })
}

/// `share` of a sampled light's radiance, as far as it arrives at `hit`.
fn arriving(
    scene: &Scene,
    hit: &SurfaceHit<'_>,
    light: &LightSample,
    share: Rgb,
    state: &mut State,
) -> Rgb {
    let ray = hit.leave(light.direction);
    if share == Rgb::ZERO || !is_visible(scene, &ray, light, state) {
        return Rgb::ZERO;
    }
    if scene.media.is_empty() {
        return light.radiance * share;
    }
    state.work.marches += 1;
    light.radiance * share * scene.media.transmittance(&ray, Span::new(0.0, light.distance))
}
