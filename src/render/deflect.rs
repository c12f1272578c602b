//! Rays that the peaks of phase functions deflect.
//!
//! Fog of droplets scatters half of its light by a few degrees. What photons bring by such a peak is
//! rare and bright: few fly so nearly at the eye. Seen from the eye the same light varies little, as
//! it comes from nearly straight ahead. So rays gather photons by the rest of the phase function and
//! are followed once more where the peak deflects them, as a path tracer would (Veach 1997, section
//! 8.2), to gather again: a final gather for one lobe.

use std::time::Instant;

use smallvec::SmallVec;

use crate::director::Budget;
use crate::math::{Ray, Spectrum, Stream, World};
use crate::medium::Profile;
use crate::photon::Heading;

use super::expose::State;
use super::march::Marcher;

/// Deflected rays of one camera ray that are followed at most.
const MAX_DEFLECTIONS: u32 = 10_000;

/// A ray to follow.
#[derive(Debug, Clone, Copy)]
pub(super) struct Way<S> {
    pub(super) ray: Ray<World>,
    /// What its light counts.
    pub(super) throughput: S,
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

impl<S: Spectrum, H: Heading> Marcher<'_, S, H> {
    /// The light along `onward` and all rays deflected from those, W/(m² sr).
    pub(super) fn follow_deflected(
        &self,
        mut onward: Onward<S>,
        budget: &Budget,
        state: &mut State<S>,
    ) -> S {
        if onward.is_empty() {
            return S::ZERO;
        }
        let (start, before) = (Instant::now(), state.gathering);
        // Each ray stands in as its first one did, and for itself from there.
        let shared = std::mem::replace(&mut state.shared, 1.0);
        let (mut light, mut followed) = (S::ZERO, 0);
        while let Some(way) = onward.pop() {
            let Some(way) = way.surviving(&mut state.draws.rng) else { continue };
            if followed == MAX_DEFLECTIONS {
                state.draws.work.capped_paths += 1;
                break;
            }
            followed += 1;
            light += self.follow(way, budget, &mut onward, state).light;
        }
        state.shared = shared;
        state.gathering = before + start.elapsed();
        light
    }

    /// The ray on which the light comes that a peak scatters along `ray`, from a place spread by
    /// opacity; nothing where another ray stands in for this one.
    pub(super) fn deflected(
        &self,
        ray: &Ray<World>,
        profile: &Profile<S>,
        state: &mut State<S>,
    ) -> Option<Way<S>> {
        if !self.peaked || state.shared == 0.0 {
            return None;
        }
        let rng = &mut state.draws.rng;
        let place = profile.sample(rng.uniform2())?;
        let p = ray.at(place.t);
        state.draws.work.grid_lookups += self.lookups;
        let peak = |(medium, share): (usize, S)| {
            let scattering = &self.maps.scatterings[medium];
            let share = share * (1.0 - scattering.share);
            scattering.peak.map(|phase| (phase, share, share.element_sum()))
        };
        let peaks: SmallVec<[_; 1]> = self.shares(p).into_iter().filter_map(peak).collect();
        let total: f64 = peaks.iter().map(|(_, _, weight)| weight).sum();
        let mut left = rng.uniform() * total;
        let (phase, share, weight) = peaks.into_iter().find(|(_, _, weight)| {
            left -= weight;
            left < 0.0
        })?;
        let (direction, _) = phase.sample(ray.direction, rng.uniform2());
        let throughput = place.weight * share * (state.shared * total / weight);
        Some(Way { ray: Ray::new(p, direction), throughput, from_eye: false })
    }
}
