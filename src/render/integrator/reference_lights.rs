//! The path tracer of the [reference](super::reference), and the light that it samples.

use glam::DVec3;

use crate::light::LightSample;
use crate::math::{Ray, Rgb, Span, Spectrum, World, WorldPoint};
use crate::scene::Scene;
use crate::surface::SurfaceHit;
use crate::transport::{
    EquiangularLights, LightNumbers, PathContext, PathState, PunctualDirections, direct_light,
};

/// [`concentration`](crate::medium::Phase::concentration) of a phase function above which
/// rays are sampled near punctual lights, without unit: lobes of fog. Broader ones hit the surroundings of
/// lights by themselves.
const PEAKED: f64 = 50.0;

/// Traces camera paths through a scene.
#[derive(Debug)]
pub struct PathTracer<'a> {
    pub scene: &'a Scene,
    pub max_scatter: u32,
    /// Whether rays are sampled near punctual lights.
    pub samples_near_lights: bool,
}

/// A path in progress.
pub(super) struct ReferencePath<S> {
    pub state: PathState<S>,
    /// Order of volume scattering so far.
    pub order: u32,
    /// MIS weight of punctual lights where their light is scattered next along the ray, against rays
    /// sampled near them.
    pub punctual_weight: f64,
    /// What it sees; see [`Sight`].
    pub sight: Sight,
    /// Direct light of the shadow catcher that it meets first, with and without shadow, W/(m² sr).
    pub caught: Option<[Rgb; 2]>,
    /// Radiance that it had found where it came through all media before the first surface, W/(m² sr).
    pub before_surface: Option<S>,
}

/// What the ray of a path sees.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sight {
    /// What the camera does.
    Camera,
    /// All.
    All,
    /// All but lights, whose direct light was sampled where it starts.
    NoLights,
}

impl<'a> PathTracer<'a> {
    /// Traces `scene` with volume scattering up to the order `max_scatter`.
    pub fn new(scene: &'a Scene, max_scatter: Option<u32>) -> Self {
        let has_punctual = scene.lights.lights.iter().any(|light| light.position().is_some());
        let is_peaked = scene.media.iter().any(|m| m.phase.concentration() > PEAKED);
        let samples_near_lights = has_punctual && is_peaked;
        Self { scene, max_scatter: max_scatter.unwrap_or(u32::MAX), samples_near_lights }
    }
}

impl PathTracer<'_> {
    /// An estimate of the transmittance of media along `ray` before the distance `end`, in metres, by ratio tracking.
    pub(super) fn transmittance<S: Spectrum>(
        &self,
        ray: &Ray<World>,
        end: f64,
        ctx: &mut PathContext,
    ) -> S {
        let span = Span::new(0.0, end);
        self.scene.media.ratio_tracking(ray, span, &mut ctx.rng, &mut ctx.work)
    }

    /// Equiangular distributions of punctual lights over the part of `ray` before `end` that is in
    /// media.
    pub(super) fn punctual_lights(&self, ray: &Ray<World>, end: f64) -> EquiangularLights<'_> {
        let media = &self.scene.media;
        let all = Span::new(0.0, end);
        let span = if media.is_endless() { all } else { media.bounds().clip(ray).intersect(all) };
        EquiangularLights::punctual(&self.scene.lights, ray, span)
    }

    /// Density of collisions at the distance `t` along `ray`, 1/m, mean over channels: what collision
    /// sampling of the light of `punctual` has in the balance heuristic. Without those it is 0.
    pub(super) fn collision_density<S: Spectrum>(
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
    pub(super) fn directions_near_lights(&self, at: WorldPoint) -> Option<PunctualDirections> {
        self.samples_near_lights.then(|| PunctualDirections::new(&self.scene.lights, at))
    }

    /// Adds light of punctual lights that is scattered once along a ray sampled near one of them, and
    /// again where the path is; `scatter` gives phase function or BSDF times cosine for a direction,
    /// and the density with which that would have been sampled.
    pub(super) fn add_near_lights<S: Spectrum>(
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
    pub(super) fn add_equiangular<S: Spectrum>(
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
        let media = &self.scene.media;
        let mut sum = S::ZERO;
        for sampled in punctual.pick(ctx.rng.uniform()) {
            let index = sampled.index;
            let (t_number, u) = (ctx.rng.uniform(), ctx.rng.uniform2());
            let Some((t, light)) = punctual.sample(sampled, t_number, u) else { continue };
            let p = ray.at(t);
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
            let pdf = punctual.pdf(index, &light.origin(p), t) + other_pdf(index, p, t, ctx);
            let light = S::from_rgb(light.radiance) * through * scattering / pdf;
            let light = light.in_group(self.scene.groups.of_light(index));
            sum += self.scene.groups.scattered(light);
        }
        sum
    }

    /// Direct light at `at` from sampled lights, with ratio-tracked transmittance; `scatter` gives, for
    /// a light's index, the probability of choosing it and its sample, phase function or BSDF times
    /// cosine with other weights, and the density with which scattering would have sampled the
    /// direction.
    pub(super) fn next_event<S: Spectrum>(
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

    /// Direct light at `hit`, where `reflects` gives BSDF times cosine, W/(m² sr), and what that would be were nothing
    /// between it and the lights: both by the same samples of lights alone.
    pub(super) fn with_and_without_shadow<S: Spectrum>(
        &self,
        hit: &SurfaceHit<'_>,
        reflects: impl Fn(DVec3) -> S,
        ctx: &mut PathContext,
    ) -> [S; 2] {
        let mut open = ctx.rng.clone();
        let at_lights = LightNumbers::varied(open.uniform(), open.uniform2());
        let whole = |_, light: &LightSample, choice: f64, _: &mut PathContext| {
            S::from_rgb(light.radiance) * reflects(light.direction) / (choice * light.pdf)
        };
        let unshadowed = direct_light::sample_lights(self.scene, hit.point, at_lights, ctx, whole);
        let at_light = |_, _, light: &LightSample| (reflects(light.direction), 0.0);
        [self.next_event(hit.point, |d| hit.leave(d), at_light, ctx), unshadowed]
    }
}
