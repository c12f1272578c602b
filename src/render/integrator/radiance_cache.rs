//! In-scattered light from caches: fluence grids, direct light and final gathers kept per cell.

use crate::cache::{GatherOrigins, GatherPoints, ReadingRays};
use crate::math::{Ray, Spectrum, World, WorldPoint};
use crate::medium::Profile;
use crate::photon::PhotonDirection;
use crate::render::pixel_sampling::CameraRay;
use crate::strategy::Strategy;
use crate::transport::{Decision, PathContext, PathState, SobolPoint};

use super::final_gather::GatherPath;
use super::ray_estimators::RayEstimators;
use super::setup::Integrator;

/// Where caches are read, and how.
#[derive(Debug, Clone, Copy)]
struct CacheLookup<'a> {
    p: WorldPoint,
    /// Number in [0, 1) that draws one of the cells around.
    u: f64,
    /// Level of fluence grids.
    level: usize,
    rays: ReadingRays<'a>,
}

impl<S: Spectrum, H: PhotonDirection> Integrator<'_, S, H> {
    /// Cached light that media scatter along `ray` to its origin, W/(m² sr), looked up at points
    /// sampled by opacity.
    pub(super) fn cached_in_scattering(
        &self,
        ray: &Ray<World>,
        by: &RayEstimators,
        profile: &Profile<S>,
        camera_ray: &CameraRay<'_>,
        ctx: &mut PathContext,
    ) -> S {
        let CameraRay { budget, pass, directed, .. } = *camera_ray;
        let rays = ReadingRays { pass, directed };
        let level = self.maps.level(budget.radius);
        let count = budget.places;
        let mut sum = S::ZERO;
        let draws = ctx.stratified.draws(Decision::CachedPlaces, count);
        for index in 0..count {
            let [u, channel, cell, _] = draws.numbers(index, &mut ctx.rng);
            let Some(place) = profile.sample([u, channel]) else { break };
            let p = ray.at(place.t);
            let lookup = CacheLookup { p, u: cell, level, rays };
            ctx.work.gathers += 1;
            ctx.work.grid_lookups += self.media.albedo_lookups;
            for (medium, albedo) in self.albedos(p) {
                if by.reads_caches(medium) {
                    let strategy = by.strategy_at(medium, place.t);
                    let light = self.cached_at(strategy, medium, lookup, ctx);
                    sum += place.weight * albedo * light;
                }
            }
        }
        sum / f64::from(count)
    }

    /// Cached light that a medium scatters toward the camera, per unit of sigma_s: direct
    /// light, and either fluence or final gathers.
    fn cached_at(
        &self,
        strategy: Strategy,
        medium: usize,
        lookup: CacheLookup<'_>,
        ctx: &mut PathContext,
    ) -> S {
        let CacheLookup { p, level, .. } = lookup;
        let direct = self.caches.direct.get(medium).and_then(Option::as_ref);
        let direct = direct.map_or(S::ZERO, |cache| cache.at(self.scene, p, ctx));
        let indirect = match strategy {
            Strategy::FluenceTowardEye => {
                let grid = self.caches.fluence[medium].as_ref();
                grid.map_or(S::ZERO, |grid| grid.toward_camera(p, level))
            }
            Strategy::SharedGathers => self.cached_gather(medium, lookup, ctx),
            Strategy::Beams | Strategy::Moments | Strategy::Traced => S::ZERO,
        };
        direct + indirect
    }

    /// The final gathers of a cell round the place; an empty cell makes its own.
    fn cached_gather(&self, medium: usize, lookup: CacheLookup<'_>, ctx: &mut PathContext) -> S {
        let CacheLookup { p, u, rays, .. } = lookup;
        let Some(cache) = &self.caches.final_gathers[medium] else { return S::ZERO };
        cache.sample(self.scene, p, u, rays, ctx, |origins, points, ctx| {
            self.mean_of_gathers(medium, origins, &points, ctx)
        })
    }

    /// The mean of final gathers, one for each of the `points`, of light that a medium scatters toward the camera at these
    /// `origins`.
    fn mean_of_gathers(
        &self,
        medium: usize,
        origins: &GatherOrigins,
        points: &GatherPoints,
        ctx: &mut PathContext,
    ) -> S {
        let GatherPoints { indices, scramble } = points.clone();
        let mut sum = S::ZERO;
        for index in indices.clone() {
            let [a, _, c, d] = SobolPoint { index, scramble }.scattering();
            let p = origins.place(a);
            let from_camera = Ray::new(p, -self.scene.camera.toward(p));
            let gather = GatherPath::new(PathState::new(from_camera), 0, 1.0);
            sum += self.trace_gather(gather, p, medium, [c, d], ctx).radiance;
        }
        sum / indices.len() as f64
    }
}
