//! Direct light that media scatter once along a ray.
//!
//! It is evaluated at points sampled by opacity and, for punctual lights, at points sampled
//! equiangularly (Kulla and Fajardo 2012), combined by the balance heuristic (Veach 1997, section
//! 9.2.2).

use crate::light::Lights;
use crate::math::{Ray, Spectrum, World};
use crate::medium::{Place, Profile};
use crate::photon::PhotonDirection;
use crate::transport::{EquiangularLights, PathContext, direct_light};

use super::ray_estimators::DirectLightGroup;
use super::setup::{Integrator, stratum};

/// Points along a ray, sampled by opacity, at which direct light is evaluated: a stratum
/// each. More of them cost shadow rays where more rays of a pixel do the same.
const OPACITY_SAMPLES: u32 = 4;

/// Points along a ray, sampled equiangularly, at which the light of punctual lights is evaluated, and
/// points sampled by opacity where all lights are punctual: a stratum
/// each.
const EQUIANGULAR_SAMPLES: u32 = 2;

/// Which direct light an estimate includes.
#[derive(Debug, Clone, Copy)]
pub(super) struct LightFilter<'a> {
    /// Mask of lights handled elsewhere; missing entries are false.
    pub excluded: &'a [bool],
    /// Mask of the media that scatter the light; `None` is all.
    pub media: Option<&'a [bool]>,
    /// Weight of the light of punctual lights.
    pub punctual_weight: f64,
    /// Whether other lights are included, and points are sampled by opacity.
    pub others: bool,
}

impl<'a> LightFilter<'a> {
    /// Punctual lights alone, sampled equiangularly.
    pub const PUNCTUAL: Self =
        Self { excluded: &[], media: None, punctual_weight: 1.0, others: false };

    /// What a group of media scatters, with this weight of punctual lights.
    pub fn group(group: &'a DirectLightGroup, punctual_weight: f64) -> Self {
        let DirectLightGroup { media, excluded } = group;
        Self { excluded, media: Some(media), punctual_weight, others: true }
    }

    fn excludes(&self, light: usize) -> bool {
        self.excluded.get(light).is_some_and(|&excluded| excluded)
    }
}

/// The points that direct light along one ray is evaluated at, and their densities.
struct RaySampling<'a, S> {
    ray: &'a Ray<World>,
    profile: &'a Profile<S>,
    filter: LightFilter<'a>,
    lights: &'a Lights,
    equiangular: EquiangularLights,
    opacity_samples: u32,
}

impl<'a, S: Spectrum> RaySampling<'a, S> {
    fn new(
        lights: &'a Lights,
        ray: &'a Ray<World>,
        profile: &'a Profile<S>,
        filter: LightFilter<'a>,
    ) -> Self {
        let equiangular = EquiangularLights::new(lights, ray, profile.extent());
        let opacity_samples = match (filter.others, equiangular.are_all()) {
            (false, _) => 0,
            (true, true) => EQUIANGULAR_SAMPLES,
            (true, false) => OPACITY_SAMPLES,
        };
        Self { ray, profile, filter, lights, equiangular, opacity_samples }
    }

    /// Effective number of samples that share the light `light` at a point sampled by opacity: the
    /// denominator of the balance heuristic over that density, infinite for lights that are excluded.
    /// `choice` is the probability of choosing the light there.
    fn effective_samples(&self, place: &Place<S>, light: usize, choice: f64) -> f64 {
        if self.filter.excludes(light) {
            return f64::INFINITY;
        }
        let equiangular = f64::from(EQUIANGULAR_SAMPLES) * self.equiangular.pdf(light, place.t);
        let is_punctual = self.lights.lights[light].position().is_some();
        let weight = if is_punctual { self.filter.punctual_weight } else { 1.0 };
        (f64::from(self.opacity_samples) + equiangular / (choice * place.pdf)) / weight
    }
}

impl<S: Spectrum, H: PhotonDirection> Integrator<'_, S, H> {
    /// Direct light of the lights in `filter` that media scatter once along `ray` to its origin,
    /// W/(m² sr).
    pub(super) fn direct_along(
        &self,
        ray: &Ray<World>,
        profile: &Profile<S>,
        filter: LightFilter<'_>,
        ctx: &mut PathContext,
    ) -> S {
        let sampling = RaySampling::new(&self.scene.lights, ray, profile, filter);
        let sum = self.add_opacity_samples(S::ZERO, &sampling, ctx);
        self.add_equiangular_samples(sum, &sampling, ctx)
    }

    /// `sum` with the light at points sampled by opacity, from lights chosen at each.
    fn add_opacity_samples(
        &self,
        mut sum: S,
        sampling: &RaySampling<'_, S>,
        ctx: &mut PathContext,
    ) -> S {
        let RaySampling { ray, profile, opacity_samples, .. } = sampling;
        for index in 0..*opacity_samples {
            let u = stratum(index, *opacity_samples, &mut ctx.rng);
            let Some(place) = profile.sample([u, ctx.rng.uniform()]) else { break };
            let p = ray.at(place.t);
            let scatterers = self.scatterers(p, sampling.filter.media);
            ctx.work.grid_lookups += self.media.albedo_lookups;
            if scatterers.is_empty() {
                continue;
            }
            ctx.work.gathers += 1;
            let count = |light, choice| sampling.effective_samples(&place, light, choice);
            let wo = -ray.direction;
            let light = direct_light::direct_in_medium(self.scene, p, wo, &scatterers, count, ctx);
            sum += place.weight * light;
        }
        sum
    }

    /// `sum` with the light of punctual lights at points sampled equiangularly round each.
    fn add_equiangular_samples(
        &self,
        mut sum: S,
        sampling: &RaySampling<'_, S>,
        ctx: &mut PathContext,
    ) -> S {
        let RaySampling { ray, profile, filter, lights, equiangular, .. } = sampling;
        for sample in 0..EQUIANGULAR_SAMPLES {
            let picked = equiangular.pick(ctx.rng.uniform());
            for (index, distances) in picked.iter().filter(|(index, _)| !filter.excludes(*index)) {
                let t = distances.sample(stratum(sample, EQUIANGULAR_SAMPLES, &mut ctx.rng));
                let Some(place) = profile.place_at(t) else { continue };
                let p = ray.at(t);
                let choice = lights.pick_probability(p, *index);
                let scatterers = self.scatterers(p, filter.media);
                ctx.work.grid_lookups += self.media.albedo_lookups;
                let light = lights.lights[*index].sample(p, ctx.rng.uniform2());
                let Some(light) = light.filter(|_| choice > 0.0 && !scatterers.is_empty()) else {
                    continue;
                };
                ctx.work.gathers += 1;
                let wo = -ray.direction;
                let light = direct_light::in_scattered(self.scene, p, wo, &scatterers, &light, ctx);
                let count = choice * sampling.effective_samples(&place, *index, choice);
                sum += place.weight * light / count;
            }
        }
        sum
    }
}
