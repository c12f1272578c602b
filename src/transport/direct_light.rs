//! Next-event estimation: direct light at a point in a medium or on a surface.
//!
//! Camera rays, caches and final gathers use all of it. The reference samples lights by
//! [`sample_lights`] too, but estimates transmittance by ratio tracking of its own: that keeps it
//! unbiased whatever the march does.

use std::ops::Add;

use glam::DVec3;

use crate::light::{EmitterHit, LightOrigin, LightSample};
use crate::math::{GOLDEN_RATIO, Ray, Rgb, Span, Spectrum, World, WorldPoint};
use crate::medium::{Media, Phase};
use crate::surface::SurfaceHit;

use crate::scene::Scene;

use super::PathContext;

/// Shadow rays end at this fraction of the distance to a light, so that they do not meet the light's own
/// surface. The margin exceeds the rounding of an intersection in f64 by orders of magnitude.
///
/// Unit: none. Derivation: f64 rounds by 1e-16, and a blocker within 1e-7 of the distance to a light
/// touches it.
const SHORT_OF_LIGHT: f64 = 1.0 - 1e-7;

/// Uniform numbers that choose a light and a position on it.
#[derive(Debug, Clone, Copy)]
pub struct LightNumbers {
    /// Which light, where there are too many to sample all.
    pub among: f64,
    /// The position on the first light.
    pub position: [f64; 2],
    /// What is added to both numbers from light to light.
    pub turn: f64,
}

impl LightNumbers {
    /// Numbers for positions that are not alike on different lights.
    pub const fn varied(among: f64, position: [f64; 2]) -> Self {
        Self { among, position, turn: GOLDEN_RATIO }
    }

    /// The numbers for the position on the light of this index.
    pub fn position(&self, light: usize) -> [f64; 2] {
        self.position.map(|u| (u + light as f64 * self.turn).fract())
    }
}

/// A phase function with its weight at a point, often the albedo of its medium.
pub type Scatterer<'a, S = Rgb> = (&'a Phase, S);

/// Radiance that the surface at `hit` emits back along `ray`, W/(m² sr).
pub fn emitted<S: Spectrum>(scene: &Scene, ray: &Ray<World>, hit: &SurfaceHit<'_>) -> S {
    hit.light.map_or(S::ZERO, |light| {
        let light = light as usize;
        let emits = &scene.lights.lights[light];
        let radiance = emits.radiance_from(ray.direction, Some(emitter(hit)));
        S::of_group(radiance, scene.groups.of_light(light))
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
pub fn environment<S: Spectrum>(scene: &Scene, ray: &Ray<World>, ctx: &mut PathContext) -> S {
    if !ctx.needs.environment {
        return S::ZERO;
    }
    ctx.work.environment_lookups += 1;
    environment_radiance(scene, ray, |_| true)
}

/// Radiance, W/(m² sr), that `ray` (unit direction) sees of those lights infinitely far away that `is_seen` says of their
/// index.
pub(super) fn environment_radiance<S: Spectrum>(
    scene: &Scene,
    ray: &Ray<World>,
    is_seen: impl Fn(usize) -> bool,
) -> S {
    let lights = scene.lights.lights.iter().enumerate().filter(|(index, _)| is_seen(*index));
    let radiance = lights.map(|(index, light)| {
        S::of_group(light.radiance_from(ray.direction, None), scene.groups.of_light(index))
    });
    radiance.fold(S::ZERO, Add::add)
}

/// Samples lights as seen from `at` and sums `contribution`, which gets the light's index, the
/// sample, and the probability of choosing the light.
pub fn sample_lights<S: Spectrum>(
    scene: &Scene,
    at: WorldPoint,
    u: LightNumbers,
    ctx: &mut PathContext,
    mut contribution: impl FnMut(usize, &LightSample, f64, &mut PathContext) -> S,
) -> S {
    let mut of = |index: usize, probability: f64, ctx: &mut PathContext| {
        let sample = scene.lights.lights[index].sample(at, u.position(index));
        let light = sample.filter(LightSample::shines);
        let sum = light.map_or(S::ZERO, |light| contribution(index, &light, probability, ctx));
        sum.in_group(scene.groups.of_light(index))
    };
    if !ctx.needs.light_choice {
        return if scene.lights.lights.is_empty() { S::ZERO } else { of(0, 1.0, ctx) };
    }
    let mut sum = S::ZERO;
    for (index, probability) in scene.lights.pick(at, u.among) {
        ctx.work.light_choices += u64::from(probability < 1.0);
        sum += of(index, probability, ctx);
    }
    sum
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

/// A place on a light as [`MediumNee`] samples it from a point.
#[derive(Debug, Clone, Copy)]
pub struct Connection {
    /// Index of the light.
    pub light: usize,
    /// Where its light comes from; infinitely far of lights that are.
    pub origin: LightOrigin,
    /// Density of [`Light::sample`](crate::light::Light::sample) there, 1/sr; 1 for a delta light.
    pub light_pdf: f64,
    /// Density with which the point's own sampling takes this connection, 1/sr; for a delta light a
    /// probability.
    pub pdf: f64,
}

/// Next-event estimation from a point in a medium.
///
/// Lights that a ray can hit are sampled by the light or by the phase function, half of the time
/// each, where the phase function is not isotropic, with the balance heuristic for one sample (Veach
/// 1997, section 9.2.4).
#[derive(Debug, Clone, Copy)]
pub struct MediumNee<'a, S> {
    scene: &'a Scene,
    p: WorldPoint,
    wo: DVec3,
    scatterers: &'a [Scatterer<'a, S>],
    /// The phase function that is sampled too.
    sampled: Option<&'a Phase>,
}

impl<'a, S: Spectrum> MediumNee<'a, S> {
    /// At `p`, for light toward the unit direction `wo`.
    pub fn new(
        scene: &'a Scene,
        p: WorldPoint,
        wo: DVec3,
        scatterers: &'a [Scatterer<'a, S>],
    ) -> Self {
        // Phase functions are symmetric, so directions to lights are sampled from the viewing direction.
        let sampled = match scatterers {
            [(phase, _)] if !phase.is_isotropic() && scene.lights.has_extended() => Some(*phase),
            _ => None,
        };
        Self { scene, p, wo, scatterers, sampled }
    }

    /// The connection by a sample of the light of this index, which is chosen with the probability `choice`.
    pub fn connection(&self, light: usize, sample: &LightSample, choice: f64) -> Connection {
        let chosen_pdf = choice * sample.pdf;
        let pdf = match self.sampled {
            None => chosen_pdf,
            Some(_) if sample.delta => 0.5 * chosen_pdf,
            Some(phase) => 0.5 * chosen_pdf + 0.5 * phase.eval(-sample.direction.dot(self.wo)),
        };
        Connection { light, origin: sample.origin(self.p), light_pdf: sample.pdf, pdf }
    }

    /// In-scattered direct light, per unit of the scatterers' weights: with weights sigma_s / sigma_t a source
    /// function, W/(m² sr). The light of each connection is divided by `density` of it, its pdf where there
    /// is no other way to sample the same. Of the uniform numbers `u` two choose a position on each light, or
    /// a direction, one which of both, and one among many lights.
    pub fn direct(
        &self,
        u: [f64; 4],
        density: impl Fn(&Connection) -> f64,
        ctx: &mut PathContext,
    ) -> S {
        let [x, y, way, among] = u;
        if let Some(phase) = self.sampled.filter(|_| way >= 0.5) {
            return self.direct_by_phase(phase, [x, y], density, ctx);
        }
        let u = LightNumbers::varied(among, [x, y]);
        sample_lights(self.scene, self.p, u, ctx, |index, light, choice, ctx| {
            let density = density(&self.connection(index, light, choice));
            if density.is_infinite() { S::ZERO } else { self.in_scattered(light, ctx) / density }
        })
    }

    /// Light from a direction sampled by the phase function.
    fn direct_by_phase(
        &self,
        phase: &Phase,
        u: [f64; 2],
        density: impl Fn(&Connection) -> f64,
        ctx: &mut PathContext,
    ) -> S {
        let (direction, pdf) = phase.sample(-self.wo, u);
        if pdf <= 0.0 {
            return S::ZERO;
        }
        let ray = Ray::new(self.p, direction);
        let mis_weight = |light: usize, hit: Option<EmitterHit>| {
            let lights = &self.scene.lights;
            let light_pdf = lights.lights[light].pdf(self.p, direction, hit);
            let choice = lights.pick_probability(self.p, light);
            let distance = hit.map_or(f64::INFINITY, |hit| hit.distance);
            let position = self.p + direction * distance;
            let origin = LightOrigin { position, normal: hit.map(|hit| hit.normal) };
            let pdf = 0.5 * choice * light_pdf + 0.5 * pdf;
            1.0 / density(&Connection { light, origin, light_pdf, pdf })
        };
        light_along::<S>(self.scene, &ray, mis_weight, ctx) * self.scatterers[0].1 * pdf
    }

    /// Light of one light sample, not divided by its density.
    pub fn in_scattered(&self, light: &LightSample, ctx: &mut PathContext) -> S {
        in_scattered(self.scene, self.p, self.wo, self.scatterers, light, ctx)
    }
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

/// Radiance of the lights at the first surface `hit` by `ray`, or infinitely far where there is none, each times
/// `weight` of its index and where on its surface it is hit, W/(m² sr).
pub(super) fn emitters_behind<S: Spectrum>(
    scene: &Scene,
    ray: &Ray<World>,
    hit: Option<&SurfaceHit<'_>>,
    weight: impl Fn(usize, Option<EmitterHit>) -> f64,
) -> S {
    let at = hit.map(emitter);
    let mut radiance = S::ZERO;
    for (index, light) in scene.lights.lights.iter().enumerate() {
        let is_hit = match hit {
            Some(hit) => hit.light == Some(index as u32),
            None => light.is_infinite(),
        };
        if is_hit {
            let emitted = light.radiance_from(ray.direction, at);
            if emitted != Rgb::ZERO {
                let emitted = S::of_group(emitted, scene.groups.of_light(index));
                radiance += emitted * weight(index, at);
            }
        }
    }
    radiance
}

/// Radiance of the lights that `ray` hits, through media, each times `weight` of its index and where on
/// its surface it is hit.
fn light_along<S: Spectrum>(
    scene: &Scene,
    ray: &Ray<World>,
    weight: impl Fn(usize, Option<EmitterHit>) -> f64,
    ctx: &mut PathContext,
) -> S {
    ctx.work.shadow_rays += 1;
    let hit = scene.surfaces.intersect(ray, Span::AHEAD);
    let radiance = emitters_behind::<S>(scene, ray, hit.as_ref(), weight);
    if radiance == S::ZERO {
        return radiance;
    }
    let end = hit.map_or(f64::INFINITY, |h| h.t);
    let span = Span::new(0.0, end);
    radiance * scene.media.transmittance_counted::<S>(ray, span, &mut ctx.work)
}

/// `weight` times the radiance of a light sample that arrives at `hit`: 0 behind surfaces, attenuated by
/// `media`.
pub(super) fn unoccluded<S: Spectrum>(
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
