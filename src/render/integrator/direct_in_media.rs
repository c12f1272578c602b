//! Direct light that media scatter once along a ray.
//!
//! It is evaluated at points sampled by opacity and, for lights [near the ray](EquiangularLights::near), at points
//! sampled equiangularly (Kulla and Fajardo 2012), half of them in proportion to opacity too. Near lights are then not
//! sampled by opacity alone, which would add variance. Equiangular points round a mesh are not weighed by opacity: where a
//! near light is one, all near lights are sampled both ways, combined by the balance heuristic (Veach 1997, section 9.2.2).

use crate::light::{LightRegion, Lights};
use crate::math::{Ray, Spectrum, World};
use crate::medium::{Place, Profile};
use crate::photon::PhotonDirection;
use crate::transport::direct_light::{Connection, MediumNee};
use crate::transport::{Decision, EquiangularLights, LightNumbers, OpacitySteps, PathContext};

use super::ray_estimators::DirectLightGroup;
use super::setup::Integrator;

/// Points along a ray, sampled by opacity, at which direct light is evaluated: a stratum
/// each. More of them cost shadow rays where more rays of a pixel do the same.
const OPACITY_SAMPLES: u32 = 2;

/// Points along a ray, sampled equiangularly, at which the light of near lights is evaluated: a stratum each. There are
/// more of them where near lights are not sampled by opacity.
const EQUIANGULAR_SAMPLES: u32 = 2;

/// Which direct light an estimate includes.
#[derive(Debug, Clone, Copy)]
pub(super) struct LightFilter<'a> {
    /// Where each light is included; missing entries are everywhere.
    pub regions: &'a [LightRegion],
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
        Self { regions: &[], media: None, punctual_weight: 1.0, others: false };

    /// What a group of media scatters, with this weight of punctual lights.
    pub fn group(group: &'a DirectLightGroup, punctual_weight: f64) -> Self {
        let DirectLightGroup { media, regions } = group;
        Self { regions, media: Some(media), punctual_weight, others: true }
    }

    fn region(&self, light: usize) -> LightRegion {
        self.regions.get(light).copied().unwrap_or(LightRegion::Everywhere)
    }
}

/// The points that direct light along one ray is evaluated at, and their densities.
struct RaySampling<'a, S> {
    ray: &'a Ray<World>,
    profile: &'a Profile<S>,
    filter: LightFilter<'a>,
    lights: &'a Lights,
    equiangular: EquiangularLights<'a>,
    /// Whether near lights are sampled equiangularly alone.
    near_equiangular_only: bool,
    opacity_samples: u32,
    equiangular_samples: u32,
}

impl<'a, S: Spectrum> RaySampling<'a, S> {
    fn new(
        lights: &'a Lights,
        ray: &'a Ray<World>,
        profile: &'a Profile<S>,
        filter: LightFilter<'a>,
    ) -> Self {
        let extent = profile.extent();
        let span = |light: usize| filter.region(light).clip(ray, extent);
        let mut equiangular = if filter.others {
            EquiangularLights::near(lights, ray, span)
        } else {
            EquiangularLights::punctual(lights, ray, extent)
        };
        let is_far = |light| !equiangular.contains(light) && !span(light).is_empty();
        let by_opacity =
            filter.others && ((0..lights.lights.len()).any(is_far) || !equiangular.have_parts());
        let opacity_samples = if by_opacity { OPACITY_SAMPLES } else { 0 };
        let mut equiangular_samples = EQUIANGULAR_SAMPLES;
        let near_equiangular_only =
            filter.others && !equiangular.is_empty() && equiangular.have_parts();
        if near_equiangular_only {
            equiangular = equiangular.weighed(&OpacitySteps::along(profile));
            // As many shadow rays as there would be with points by opacity, of which each asks for one light.
            equiangular_samples += OPACITY_SAMPLES.div_ceil(equiangular.pick(0.0).len() as u32);
        }
        Self {
            ray,
            profile,
            filter,
            lights,
            equiangular,
            near_equiangular_only,
            opacity_samples,
            equiangular_samples,
        }
    }

    /// Whether a light is sampled equiangularly alone.
    fn is_equiangular_only(&self, light: usize) -> bool {
        self.near_equiangular_only && self.equiangular.contains(light)
    }

    /// The [density](Self::density) of a connection at a point that is sampled by opacity; infinite for lights that are
    /// sampled equiangularly alone.
    fn density_by_opacity(&self, place: &Place<S>, connection: &Connection) -> f64 {
        if self.is_equiangular_only(connection.light) {
            f64::INFINITY
        } else {
            self.density(place, connection)
        }
    }

    /// The denominator of the balance heuristic for a connection at a point of the ray, over the density of
    /// that point by opacity, 1/sr; infinite for lights that are excluded.
    fn density(&self, place: &Place<S>, connection: &Connection) -> f64 {
        let Connection { light, origin, light_pdf, pdf } = connection;
        if !self.filter.region(*light).contains(self.ray.at(place.t)) {
            return f64::INFINITY;
        }
        let by_opacity = if self.is_equiangular_only(*light) {
            0.0
        } else {
            f64::from(self.opacity_samples) * pdf
        };
        let distance_pdf = self.equiangular.pdf(*light, origin, place.t);
        let equiangular =
            f64::from(self.equiangular_samples) * distance_pdf * light_pdf / place.pdf;
        let is_punctual = self.lights.lights[*light].position().is_some();
        let weight = if is_punctual { self.filter.punctual_weight } else { 1.0 };
        (by_opacity + equiangular) / weight
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
        let places = ctx.stratified.draws(Decision::OpacityPlaces, *opacity_samples);
        let lights = ctx.stratified.draws(Decision::OpacityLights, *opacity_samples);
        for index in 0..*opacity_samples {
            let [u, channel, ..] = places.numbers(index, &mut ctx.rng);
            let Some(place) = profile.sample([u, channel]) else { break };
            let p = ray.at(place.t);
            let scatterers = self.scatterers(p, sampling.filter.media);
            ctx.work.grid_lookups += self.media.albedo_lookups;
            if scatterers.is_empty() {
                continue;
            }
            ctx.work.gathers += 1;
            let nee = MediumNee::new(self.scene, p, -ray.direction, &scatterers);
            let density = |connection: &Connection| sampling.density_by_opacity(&place, connection);
            let u = lights.numbers(index, &mut ctx.rng);
            sum += place.weight * nee.direct(u, density, ctx);
        }
        sum
    }

    /// `sum` with the light of near lights at points sampled equiangularly round each.
    fn add_equiangular_samples(
        &self,
        mut sum: S,
        sampling: &RaySampling<'_, S>,
        ctx: &mut PathContext,
    ) -> S {
        let RaySampling { ray, profile, filter, lights, equiangular, .. } = sampling;
        if equiangular.is_empty() {
            return sum;
        }
        let count = sampling.equiangular_samples;
        let places = ctx.stratified.draws(Decision::EquiangularPlaces, count);
        for sample in 0..count {
            let [distance, x, y, among] = places.numbers(sample, &mut ctx.rng);
            let picked = equiangular.pick(among);
            let positions = LightNumbers::varied(among, [x, y]);
            for sampled in picked {
                let index = sampled.index;
                let u = positions.position(index);
                let Some((t, light)) = equiangular.sample(sampled, distance, u) else { continue };
                let Some(place) = profile.place_at(t) else { continue };
                let p = ray.at(t);
                let scatterers = self.scatterers(p, filter.media);
                ctx.work.grid_lookups += self.media.albedo_lookups;
                if scatterers.is_empty() {
                    continue;
                }
                ctx.work.gathers += 1;
                let nee = MediumNee::new(self.scene, p, -ray.direction, &scatterers);
                let choice = lights.pick_probability(p, index);
                let density = sampling.density(&place, &nee.connection(index, &light, choice));
                let light = place.weight * nee.in_scattered(&light, ctx) / density;
                sum += light.in_group(self.scene.groups.of_light(index));
            }
        }
        sum
    }
}
