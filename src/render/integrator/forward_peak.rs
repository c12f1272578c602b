//! Camera rays that the forward peaks of phase functions deflect.
//!
//! Droplets of fog scatter half of their light by a few degrees. Of the photons that such a peak would
//! send to the camera few are there, and bright; seen from the camera the same light varies little, as
//! it comes from nearly straight ahead. So photons are gathered with the rest of the phase function
//! alone, and the camera ray is deflected by the peak and traced once more (Veach 1997, section 8.2): a
//! final gather for one lobe. The peak does not know of punctual lights, so rays are sampled near
//! those as well ([`PunctualDirections`]), with the balance heuristic (Veach 1997, section 9.2.2).

use crate::director::PixelBudget;
use crate::math::{Ray, Span, Spectrum, World, WorldPoint};
use crate::medium::{Phase, Profile};
use crate::photon::PhotonDirection;
use crate::transport::{Decision, EnclosingSolids, PathContext, PunctualDirections, direct_light};

use super::direct_in_media::LightFilter;
use super::pending::PendingRay;
use super::setup::{Integrator, choose};

/// Light of the forward peak at one point of a ray.
pub(super) struct PeakResult<S> {
    /// The deflected ray on which more of it comes; `None` where nothing has a peak.
    pub deflected: Option<PendingRay<S>>,
    /// The light of punctual lights from nearly straight ahead, W/(m² sr), of the order before the peak scatters it.
    pub radiance: S,
}

impl<S: Spectrum, H: PhotonDirection> Integrator<'_, S, H> {
    /// Samples a point of `ray` by opacity, deflects the ray there by a forward peak, and adds what
    /// punctual lights send to it nearly along the ray. `memory` is for the march toward those.
    pub(super) fn sample_forward_peak(
        &self,
        ray: &Ray<World>,
        profile: &Profile<S>,
        budget: &PixelBudget,
        ctx: &mut PathContext,
        memory: &mut Profile<S>,
    ) -> PeakResult<S> {
        let nothing = PeakResult { deflected: None, radiance: S::ZERO };
        if !self.media.has_forward_peak {
            return nothing;
        }
        let draws = ctx.stratified.draws(Decision::ForwardPeak, 1);
        let [u, channel, x, y] = draws.numbers(0, &mut ctx.rng);
        let Some(place) = profile.sample([u, channel]) else { return nothing };
        let p = ray.at(place.t);
        let Some((peak, albedo)) = self.choose_peak(p, ctx) else { return nothing };
        let weight = place.weight * albedo;
        let punctual = PunctualDirections::new(&self.scene.lights, p);
        let (direction, pdf) = peak.sample(ray.direction, [x, y]);
        let deflected = Some(PendingRay {
            ray: Ray::new(p, direction),
            end: f64::INFINITY,
            throughput: self.scene.groups.scattered(weight),
            punctual_weight: punctual.mis_weight(direction, pdf),
            from_camera: false,
            deflected: true,
            // Direct light was sampled where it was deflected.
            sees_emitters: false,
            rough: None,
            solids: EnclosingSolids::NONE,
            splits: 0,
        });
        let sample = punctual.sample(ctx.rng.uniform(), ctx.rng.uniform2());
        let Some((direction, pdf)) = sample else {
            return PeakResult { deflected, radiance: S::ZERO };
        };
        let value = peak.eval(ray.direction.dot(direction));
        if value == 0.0 {
            return PeakResult { deflected, radiance: S::ZERO };
        }
        let light = self.punctual_light(&Ray::new(p, direction), budget, ctx, memory);
        PeakResult { deflected, radiance: weight * light * (value / (pdf + value)) }
    }

    /// A forward peak of the phase functions at `p`, chosen in proportion to what it scatters, and its
    /// part of the albedo over the probability of that.
    fn choose_peak(&self, p: WorldPoint, ctx: &mut PathContext) -> Option<(Phase, S)> {
        ctx.work.grid_lookups += self.media.albedo_lookups;
        let peak = |(medium, albedo): (usize, S)| {
            let split = &self.choice.splits[medium];
            split.peak.map(|phase| (phase, albedo * (1.0 - split.share)))
        };
        choose(self.albedos(p).into_iter().filter_map(peak).collect(), ctx.rng.uniform())
    }

    /// Light of punctual lights that the media before the first surface scatter along `ray`, which
    /// leads nearly at one, W/(m² sr).
    fn punctual_light(
        &self,
        ray: &Ray<World>,
        budget: &PixelBudget,
        ctx: &mut PathContext,
        profile: &mut Profile<S>,
    ) -> S {
        let hit = direct_light::first_surface(self.scene, ray, ctx);
        let span = Span::new(0.0, hit.map_or(f64::INFINITY, |hit| hit.t));
        let jitter = ctx.rng.uniform();
        profile.trace(&self.scene.media, ray, span, budget.step, jitter);
        profile.count(&mut ctx.work);
        self.scene.groups.scattered(self.direct_along(ray, profile, LightFilter::PUNCTUAL, ctx))
    }
}
