//! Light that is kept on lattices.

use crate::cache::SamplePass;
use crate::math::{Ray, Spectrum, World, WorldPoint};
use crate::medium::Profile;
use crate::photon::PhotonDirection;
use crate::strategy::GatherTermination;
use crate::transport::{PathContext, SobolPoint};

use super::final_gather::Walk;
use super::in_scattering::{Marcher, stratum};
use crate::render::exposure::State;

impl<S: Spectrum, H: PhotonDirection> Marcher<'_, S, H> {
    /// Light kept on lattices that is scattered along `ray`, at places spread by opacity.
    pub(super) fn kept_along(
        &self,
        ray: &Ray<World>,
        profile: &Profile<S>,
        radius: f64,
        state: &mut State<S>,
    ) -> S {
        let level = self.maps.level(radius);
        let places = self.choice.places_at(level);
        let mut sum = S::ZERO;
        for index in 0..places {
            let u = stratum(index, places, state);
            let Some(place) = profile.sample([u, state.ctx.rng.uniform()]) else { break };
            let p = ray.at(place.t);
            state.ctx.work.gathers += 1;
            state.ctx.work.grid_lookups += self.lookups;
            for (medium, share) in self.shares(p) {
                sum += place.weight * share * self.kept_at(medium, p, level, state);
            }
        }
        sum / f64::from(places)
    }

    /// Light kept on the lattices of a medium at `p`.
    fn kept_at(&self, medium: usize, p: WorldPoint, level: usize, state: &mut State<S>) -> S {
        let Self { scene, caches, choice, .. } = self;
        let direct = caches.direct.get(medium);
        let direct = direct.map_or(S::ZERO, |d| d.sample(scene, p, &mut state.ctx));
        let Some(gather) = &choice.termination else {
            return direct
                + caches.fluence.get(medium).map_or(S::ZERO, |grid| grid.toward_camera(p, level));
        };
        let Some(gathered) = caches.final_gathers.get(medium) else { return direct };
        let round = state.round;
        direct
            + gathered.sample(scene, p, round, &mut state.ctx, |place, count, ctx| {
                self.gathers(gather, medium, place, count, round, ctx)
            })
    }

    /// The mean of what so many final gathers find that start at `p`, where a medium scatters toward
    /// the camera.
    fn gathers(
        &self,
        gather: &GatherTermination,
        medium: usize,
        p: WorldPoint,
        count: u32,
        round: SamplePass,
        ctx: &mut PathContext,
    ) -> S {
        let toward = Ray::new(p, -self.scene.camera.toward(p));
        let scramble = ctx.rng.scramble();
        let mut state = State::new(ctx.clone(), round);
        let mut sum = S::ZERO;
        for index in 0..count {
            let [_, _, c, d] = SobolPoint { index, scramble }.scattering();
            sum += self.walked(gather, Walk::along(toward), p, medium, [c, d], &mut state);
        }
        *ctx = state.ctx;
        (sum / f64::from(count)).not_negative()
    }
}
