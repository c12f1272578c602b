//! Rays that the peaks of phase functions deflect.
//!
//! Fog of droplets scatters half of its light by a few degrees. What photons bring by such a peak is
//! rare and bright: few fly so nearly at the eye. Seen from the eye the same light varies little, as
//! it comes from nearly straight ahead. So rays gather photons by the rest of the phase function and
//! are followed once more where the peak deflects them, as a path tracer would (Veach 1997, section
//! 8.2), to gather again: a final gather for one lobe. Where they lead past a lamp is bright; since
//! the peak does not know of lamps, rays are sent nearly at those as well, weighed by the balance
//! heuristic (Veach 1997, section 9.2.2).

use smallvec::SmallVec;

use crate::director::PixelBudget;
use crate::math::{Ray, Span, Spectrum, Stream, World, WorldPoint};
use crate::medium::{Phase, Profile};
use crate::photon::PhotonDirection;
use crate::transport::MAX_EVENTS;
use crate::transport::direct_light;

use super::in_scattering::{Asked, Marcher};
use crate::render::exposure::State;
use crate::transport::PunctualDirections;

/// A ray to follow.
#[derive(Debug, Clone, Copy)]
pub(super) struct Way<S> {
    pub(super) ray: Ray<World>,
    /// What its light counts.
    pub(super) throughput: S,
    /// What the light of lamps counts of that, where it is scattered once more along the ray.
    pub(super) lamps: f64,
    /// What light counts of it that varies little within a pixel: 0 where another ray stands in.
    pub(super) shared: f64,
    /// Whether it comes from the eye.
    pub(super) from_eye: bool,
}

/// Rays that are still to be followed.
pub(super) type Onward<S> = SmallVec<[Way<S>; 2]>;

impl<S: Spectrum> Way<S> {
    /// The same where the way to its start counts `throughput`.
    pub(super) fn times(self, throughput: S) -> Self {
        Self { throughput: self.throughput * throughput, ..self }
    }

    /// The way, if it survives a game of Russian roulette.
    fn surviving(self, rng: &mut Stream) -> Option<Self> {
        let survival = self.throughput.max_element().min(1.0);
        (rng.uniform() < survival).then(|| Self { throughput: self.throughput / survival, ..self })
    }
}

impl<S: Spectrum, H: PhotonDirection> Marcher<'_, S, H> {
    /// The light along `onward` and all rays deflected from those, W/(m² sr), and what of it stands
    /// in for that of other rays.
    pub(super) fn follow_deflected(
        &self,
        mut onward: Onward<S>,
        budget: &PixelBudget,
        state: &mut State<S>,
    ) -> (S, S) {
        let shared = state.shared;
        let (mut light, mut stands_in, mut followed) = (S::ZERO, S::ZERO, 0);
        while let Some(way) = onward.pop() {
            let Some(way) = way.surviving(&mut state.ctx.rng) else { continue };
            if followed == MAX_EVENTS {
                state.ctx.work.capped_rays += 1;
                break;
            }
            followed += 1;
            state.shared = way.shared;
            let found = self.follow(way, budget, &mut onward, state);
            light += found.light;
            stands_in += found.shared;
        }
        state.shared = shared;
        (light, stands_in)
    }

    /// The ray on which the light comes that a peak scatters along `ray`, from a place spread by
    /// opacity, and what of that light lamps send nearly straight to that place, W/(m² sr).
    pub(super) fn deflected(
        &self,
        ray: &Ray<World>,
        profile: &Profile<S>,
        budget: &PixelBudget,
        state: &mut State<S>,
    ) -> (Option<Way<S>>, S) {
        let nothing = (None, S::ZERO);
        if !self.peaked {
            return nothing;
        }
        let Some(place) = profile.sample(state.ctx.rng.uniform2()) else { return nothing };
        let p = ray.at(place.t);
        let Some((peak, share)) = self.peak_at(p, state) else { return nothing };
        let weight = place.weight * share;
        let toward = PunctualDirections::new(&self.scene.lights, p);
        let rng = &mut state.ctx.rng;
        let (direction, pdf) = peak.sample(ray.direction, rng.uniform2());
        let way = Way {
            ray: Ray::new(p, direction),
            throughput: weight,
            lamps: toward.left(direction, pdf),
            shared: state.shared,
            from_eye: false,
        };
        let Some((direction, pdf)) = toward.sample(rng.uniform(), rng.uniform2()) else {
            return (Some(way), S::ZERO);
        };
        let value = peak.eval(ray.direction.dot(direction));
        if value == 0.0 {
            return (Some(way), S::ZERO);
        }
        let light = self.light_of_lamps(&Ray::new(p, direction), budget, state);
        (Some(way), weight * light * (value / (pdf + value)))
    }

    /// A peak of the phase functions at `p`, chosen by what it scatters, and the share of the
    /// extinction there for which it stands.
    fn peak_at(&self, p: WorldPoint, state: &mut State<S>) -> Option<(Phase, S)> {
        state.ctx.work.grid_lookups += self.lookups;
        let peak = |(medium, share): (usize, S)| {
            let scattering = &self.choice.splits[medium];
            let share = share * (1.0 - scattering.share);
            scattering.peak.map(|phase| (phase, share, share.element_sum()))
        };
        let peaks: SmallVec<[_; 1]> = self.shares(p).into_iter().filter_map(peak).collect();
        let total: f64 = peaks.iter().map(|(_, _, weight)| weight).sum();
        let mut left = state.ctx.rng.uniform() * total;
        let (phase, share, weight) = peaks.into_iter().find(|(_, _, weight)| {
            left -= weight;
            left < 0.0
        })?;
        Some((phase, share * (total / weight)))
    }

    /// The light of lamps that the media before the first surface scatter along `ray`, which leads
    /// nearly at one, W/(m² sr).
    fn light_of_lamps(&self, ray: &Ray<World>, budget: &PixelBudget, state: &mut State<S>) -> S {
        let hit = direct_light::first_surface(self.scene, ray, &mut state.ctx);
        let span = Span::new(0.0, hit.map_or(f64::INFINITY, |hit| hit.t));
        let jitter = state.ctx.rng.uniform();
        let mut profile = std::mem::take(&mut state.profile);
        profile.trace(&self.scene.media, ray, span, budget.step, jitter);
        profile.count(&mut state.ctx.work);
        let light = self.direct(ray, &profile, Asked::LAMPS, state);
        state.profile = profile;
        light
    }
}
