//! Light that media scatter and emit along one ray of the camera path.

use crate::math::{Span, Spectrum, WorldPoint};
use crate::medium::Profile;
use crate::photon::PhotonDirection;
use crate::render::pixel_sampling::{CameraRay, Profiles};
use crate::surface::SurfaceHit;
use crate::transport::{Decision, PathContext, PathState};

use super::direct_in_media::LightFilter;
use super::final_gather::GatherPath;
use super::pending::PendingRay;
use super::ray_estimators::RayEstimators;
use super::setup::{Estimate, Integrator, choose};

/// What media do to a ray.
pub(super) struct MediumResult<S> {
    /// Their light, W/(m² sr).
    pub light: Estimate<S>,
    /// Their transmittance.
    pub transmittance: S,
    /// A deflected ray on which more of their light comes.
    pub deflected: Option<PendingRay<S>>,
}

impl<S: Spectrum, H: PhotonDirection> Integrator<'_, S, H> {
    /// Marches through the media before `hit`: their emission, in-scattered light, and transmittance.
    pub(super) fn through_media(
        &self,
        segment: &PendingRay<S>,
        hit: Option<&SurfaceHit<'_>>,
        camera_ray: &CameraRay<'_>,
        ctx: &mut PathContext,
        profiles: &mut Profiles<S>,
    ) -> MediumResult<S> {
        let (ray, budget) = (&segment.ray, camera_ray.budget);
        let Profiles { path: profile, toward_light } = profiles;
        let end = hit.map_or(segment.end, |h| h.t);
        let jitter = ctx.rng.uniform();
        profile.trace(&self.scene.media, ray, Span::new(0.0, end), budget.step, jitter);
        profile.count(&mut ctx.work);
        let emitted = if self.needs.emission { profile.emitted() } else { S::ZERO };
        let mut light = Estimate { radiance: emitted, indirect: S::ZERO };
        let mut deflected = None;
        if self.needs.scattering {
            let scattered = self.in_scattering(segment, hit, profile, camera_ray, ctx);
            let peak = self.sample_forward_peak(ray, profile, budget, ctx, toward_light);
            for found in [scattered.radiance, peak.radiance] {
                light.radiance += self.scene.groups.scattered(found);
            }
            light.indirect = scattered.indirect;
            deflected = peak.deflected;
        }
        MediumResult { light, transmittance: profile.transmittance(), deflected }
    }

    /// Light that media scatter along a ray to its origin, W/(m² sr), by the estimators of each medium's
    /// strategy. Where light is told apart by order, it has that which it had before they scattered it so.
    fn in_scattering(
        &self,
        segment: &PendingRay<S>,
        hit: Option<&SurfaceHit<'_>>,
        profile: &Profile<S>,
        camera_ray: &CameraRay<'_>,
        ctx: &mut PathContext,
    ) -> Estimate<S> {
        let ray = &segment.ray;
        let by = if segment.from_camera { &self.from_camera } else { &self.elsewhere };
        let mut light = Estimate::ZERO;
        for group in &by.direct {
            let filter = LightFilter::group(group, segment.punctual_weight);
            light.radiance += self.direct_along(ray, profile, filter, ctx);
        }
        if by.any(|medium| by.gathers(medium)) {
            let gathered = self.gather_along(segment, by, profile, camera_ray, ctx);
            light.radiance += gathered.radiance;
            light.indirect += gathered.indirect;
        }
        if by.any(|medium| by.reads_caches(medium)) {
            light.radiance += self.cached_in_scattering(ray, by, profile, camera_ray, ctx);
        }
        if by.beams_end() > 0.0 && camera_ray.indirect_weight > 0.0 {
            let photons = self.volume_photons_along(segment, by, hit, profile, camera_ray, ctx);
            light.radiance += photons;
            light.indirect += photons;
        }
        light
    }

    /// The light of one final gather that starts at a point of the ray, sampled by opacity: all
    /// in-scattered light but direct light that gathers do not find.
    fn gather_along(
        &self,
        segment: &PendingRay<S>,
        by: &RayEstimators,
        profile: &Profile<S>,
        camera_ray: &CameraRay<'_>,
        ctx: &mut PathContext,
    ) -> Estimate<S> {
        let draws = ctx.stratified.draws(Decision::FinalGather, 1);
        let [a, b, c, d] = draws.numbers(0, &mut ctx.rng);
        let Some(place) = profile.sample([a, b]) else { return Estimate::ZERO };
        let p = segment.ray.at(place.t);
        let Some((medium, albedo)) = self.choose_medium(p, by, ctx) else { return Estimate::ZERO };
        ctx.work.gathers += 1;
        let level = self.maps.level(camera_ray.budget.radius);
        let path = PathState::new(segment.ray);
        let gather = GatherPath::new(path, level, camera_ray.indirect_weight);
        let found = self.trace_gather(gather, p, medium, [c, d], ctx);
        let weight = place.weight * albedo;
        Estimate { radiance: weight * found.radiance, indirect: weight * found.indirect }
    }

    /// A medium at `p` whose light rays gather, chosen in proportion to what it scatters, and its part of
    /// the albedo over the probability of that.
    fn choose_medium(
        &self,
        p: WorldPoint,
        by: &RayEstimators,
        ctx: &mut PathContext,
    ) -> Option<(usize, S)> {
        ctx.work.grid_lookups += self.media.albedo_lookups;
        let mut albedos = self.albedos(p);
        albedos.retain(|(medium, _)| by.gathers(*medium));
        if let [only] = albedos[..] {
            return Some(only);
        }
        choose(albedos, ctx.rng.uniform())
    }
}
