//! Direct light at a place in a medium or on a surface of a scene.

use std::time::Duration;

use glam::DVec3;

use crate::light::{EmitterHit, Light, LightSample};
use crate::math::{Ray, Rgb, Span, Spectrum, Stream, World, WorldPoint};
use crate::medium::{Media, Phase};
use crate::surface::{SurfaceHit, TransportMode};
use crate::work::Work;

use super::Scene;
use super::plan::Needs;

/// Shadow rays end this share short of a light that is a surface itself.
const SHORT_OF_LIGHT: f64 = 1.0 - 1e-7;

/// The golden ratio, multiples of which lie evenly between whole numbers.
const GOLDEN: f64 = 1.618_033_988_749_895;

/// Random numbers to draw from, and a count of the work done with them.
#[derive(Debug, Clone)]
pub struct Draws {
    /// Random numbers of one ray.
    pub rng: Stream,
    /// Work done so far.
    pub work: Work,
    /// What is needed.
    pub needs: Needs,
    /// For places on lights, for the first surface that asks.
    pub lights: Option<Even>,
    /// For where and how a medium first scatters the ray.
    pub scattering: Option<Even>,
    /// Time that went into what is found once and kept for all who ask later.
    pub once: Duration,
}

impl Draws {
    /// From these random numbers, with no work done yet, for what `needs` say.
    pub fn new(rng: Stream, needs: Needs) -> Self {
        let (lights, scattering) = (None, None);
        Self { rng, work: Work::default(), needs, lights, scattering, once: Duration::ZERO }
    }
}

/// Numbers spread evenly over the rays of a pixel: one point of an Owen-scrambled Sobol sequence
/// (Burley 2020), whose dimensions are asked for as they are needed.
#[derive(Debug, Clone, Copy)]
pub struct Even {
    /// Which point, below 2^16.
    pub index: u32,
    /// Which scrambling.
    pub scramble: u32,
}

impl Even {
    /// Of the place on the film and on the lens.
    pub fn place(self) -> [f64; 4] {
        sobol_burley::sample_4d(self.index, 0, self.scramble).map(f64::from)
    }

    /// Of the place on a light.
    pub fn light(self) -> [f64; 2] {
        let number = |dimension| sobol_burley::sample(self.index, dimension, self.scramble);
        [4, 5].map(|dimension| f64::from(number(dimension)))
    }

    /// Of the place where a ray is scattered, the channel that chooses it, and the deflection.
    pub fn scattering(self) -> [f64; 4] {
        sobol_burley::sample_4d(self.index, 2, self.scramble).map(f64::from)
    }
}

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
    draws: &mut Draws,
) -> Option<SurfaceHit<'s>> {
    if !draws.needs.surfaces {
        return None;
    }
    draws.work.intersections += 1;
    scene.surfaces.intersect(ray, Span::AHEAD)
}

/// Radiance, W/(m² sr), that `ray` (unit direction) sees of lights infinitely far away.
pub fn environment(scene: &Scene, ray: &Ray<World>, draws: &mut Draws) -> Rgb {
    if !draws.needs.environment {
        return Rgb::ZERO;
    }
    draws.work.environment_lookups += 1;
    scene.lights.environment_radiance(ray.direction)
}

/// Sums `contribution` over samples of the lights picked for `at`: it is given the light's index,
/// the sample, and the probability of picking the light. `place` gives the numbers that choose a
/// place on a light.
pub fn each_light<S: Spectrum>(
    scene: &Scene,
    at: WorldPoint,
    draws: &mut Draws,
    place: impl Fn(usize, &mut Draws) -> [f64; 2],
    mut contribution: impl FnMut(usize, &LightSample, f64, &mut Draws) -> S,
) -> S {
    let u = draws.rng.uniform();
    let mut of = |index: usize, probability: f64, draws: &mut Draws| {
        let sample = scene.lights.lights[index].sample(at, place(index, draws));
        let light = sample.filter(LightSample::shines);
        light.map_or(S::ZERO, |light| contribution(index, &light, probability, draws))
    };
    if !draws.needs.light_choice {
        return if scene.lights.lights.is_empty() { S::ZERO } else { of(0, 1.0, draws) };
    }
    let mut sum = S::ZERO;
    for (index, probability) in scene.lights.pick(at, u) {
        draws.work.light_choices += u64::from(probability < 1.0);
        sum += of(index, probability, draws);
    }
    sum
}

/// Whether no surface stands on `ray` before a sampled light.
pub fn is_visible(scene: &Scene, ray: &Ray<World>, light: &LightSample, draws: &mut Draws) -> bool {
    if !draws.needs.surfaces {
        return true;
    }
    draws.work.shadow_rays += 1;
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
    draws: &mut Draws,
) -> S {
    // The phase function is symmetric, so light towards the eye is sampled from the eye.
    let rival = match scatterers {
        [(phase, _)] if !phase.is_isotropic() && scene.lights.has_extended() => Some(*phase),
        _ => None,
    };
    if let Some(phase) = rival.filter(|_| draws.rng.uniform() >= 0.5) {
        let (direction, pdf) = phase.sample(-toward, draws.rng.uniform2());
        if pdf <= 0.0 {
            return S::ZERO;
        }
        let ray = Ray::new(p, direction);
        let share = |index, choice, own| 2.0 / (choice * own + pdf) / count(index, choice);
        return found::<S>(scene, &ray, share, draws) * scatterers[0].1 * pdf;
    }
    let anywhere = |_, draws: &mut Draws| draws.rng.uniform2();
    each_light(scene, p, draws, anywhere, |index, light, choice, draws| {
        let own = choice * light.pdf;
        let pdf = match rival {
            None => own,
            Some(_) if light.delta => 0.5 * own,
            Some(phase) => 0.5 * own + 0.5 * phase.eval(-light.direction.dot(toward)),
        };
        scattered(scene, p, toward, scatterers, light, draws) / (pdf * count(index, choice))
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
    draws: &mut Draws,
) -> S {
    let cosine = -light.direction.dot(toward);
    let spread: S = scatterers.iter().map(|(phase, weight)| *weight * phase.eval(cosine)).sum();
    let ray = Ray::new(p, light.direction);
    if spread == S::ZERO || !is_visible(scene, &ray, light, draws) {
        return S::ZERO;
    }
    let span = Span::new(0.0, light.distance);
    let transmittance: S = scene.media.transmittance_counted(&ray, span, &mut draws.work);
    S::of(light.radiance) * spread * transmittance
}

/// Radiance of lights that `ray` finds by chance, each times `share` of its index, the probability
/// of picking it and the density with which its sampling would have found it.
fn found<S: Spectrum>(
    scene: &Scene,
    ray: &Ray<World>,
    share: impl Fn(usize, f64, f64) -> f64,
    draws: &mut Draws,
) -> S {
    draws.work.shadow_rays += 1;
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
                radiance += S::of(seen) * share(index, choice, light.pdf(ray.direction, at));
            }
        }
    }
    if radiance == S::ZERO {
        return radiance;
    }
    let end = hit.map_or(f64::INFINITY, |h| h.t);
    let span = Span::new(0.0, end);
    radiance * scene.media.transmittance_counted::<S>(ray, span, &mut draws.work)
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
    draws: &mut Draws,
) -> S {
    let material = hit.material;
    let reflected = |direction: DVec3| {
        material.eval(incoming, direction, hit, TransportMode::Radiance)
            * direction.dot(hit.shading_normal).abs()
    };
    let even = draws.lights.take().map(Even::light);
    let place = |index, draws: &mut Draws| match even {
        // The same numbers for all lights, each set off against the others.
        Some(u) => u.map(|u| (u + index as f64 * GOLDEN).fract()),
        None => draws.rng.uniform2(),
    };
    each_light(scene, hit.point, draws, place, |index, light, picked, draws| {
        let own = picked * light.pdf;
        let kind = &scene.lights.lights[index];
        let Light::Environment(sky) = kind else {
            return arriving(scene, media, hit, light, reflected(light.direction) / own, draws);
        };
        if draws.rng.uniform() < 0.5 {
            let other = material.pdf(incoming, light.direction, hit);
            let share = reflected(light.direction) / (0.5 * (own + other));
            return arriving(scene, media, hit, light, share, draws);
        }
        let u = std::array::from_fn(|_| draws.rng.uniform());
        let scattered = material.scatter(incoming, hit, u, TransportMode::Radiance);
        let Some(scattered) = scattered else { return S::ZERO };
        let direction = scattered.direction;
        let found = LightSample { direction, radiance: sky.radiance(direction), ..*light };
        let other = picked * kind.pdf(direction, None);
        let share = scattered.weight * scattered.pdf / (0.5 * (other + scattered.pdf));
        arriving(scene, media, hit, &found, share, draws)
    })
}

/// `share` of a sampled light's radiance, as far as it arrives at `hit`.
fn arriving<S: Spectrum>(
    scene: &Scene,
    media: &Media,
    hit: &SurfaceHit<'_>,
    light: &LightSample,
    share: Rgb,
    draws: &mut Draws,
) -> S {
    let ray = hit.leave(light.direction);
    let share = S::of(share);
    if share == S::ZERO || !is_visible(scene, &ray, light, draws) {
        return S::ZERO;
    }
    if media.is_empty() || !draws.needs.media {
        return S::of(light.radiance) * share;
    }
    let span = Span::new(0.0, light.distance);
    S::of(light.radiance) * share * media.transmittance_counted::<S>(&ray, span, &mut draws.work)
}
