//! The strategy pilot: a few pixels by each assignment of strategies, with two independent halves of a few
//! photons.
//!
//! Assignments race (Maron and Moore 1994, "Hoeffding Races: Accelerating Model Selection Search"): all
//! are traced in a few pixels, those that are surely behind are given up, and the others are traced in as
//! many more, until one is left or more pixels would cost too much. `strategy/measured.rs` tells the
//! variance of a picture from those pixels, `strategy/trial.rs` compares.

mod contender;
mod entrant;
mod half;
mod pixels;

use std::sync::Arc;

use crate::cache::{Caches, DirectLightCache, FluenceGrid, GATHERS_PER_RAY};
use crate::math::Spectrum;
use crate::photon::{self, AimedPhotons, MapLayout, PathSample, PhotonDirection, PhotonMaps};
use crate::scene::{Scene, Strategy};
use crate::strategy::{self, Assignment, Evidence, Measured, Observed, Trial};

use super::pass_settings::PassSettings;
use contender::{Contender, Contenders};
use entrant::Entrant;
use half::Half;
use pixels::PilotPixels;

/// Photon paths of the render for each path of one half of the pilot: both halves together are a 32nd of all
/// photons, which fill the caches of all assignments.
const PHOTONS_PER_PATH: u64 = 64;

/// Fewest paths of a half: variances by 512 paths have a relative error of about 1 / sqrt(256), if each path
/// is seen. Of fewer photons none may be, and their variance would seem to be 0.
const MIN_PATHS: u64 = 512;

/// Levels of wider cells: the last is read by the rays whose own noise is measured.
const LEVELS: u32 = 2;

/// Bits of the indices of a half's paths. A Sobol sequence has fewer, so that each half has its own.
const SEQUENCE_BITS: u32 = 48;

/// Share of the cost of a picture by the best assignment so far that all rays of the pilot may cost, but for
/// the first round; and of the cheapest picture so far that those of one assignment may.
const MAX_SHARE: f64 = 1.0 / 16.0;

/// What the pilot works with.
pub(super) struct StrategyPilot<'a, 'b> {
    pub scene: &'a Scene,
    pub settings: &'b PassSettings,
    pub evidence: Evidence<'b>,
}

impl<'a> StrategyPilot<'a, '_> {
    /// Measures the assignments that differ, and returns the one with the least variance times cost;
    /// `None` where no light is seen. `direct` are the caches of direct light.
    pub fn measure<S: Spectrum, H: PhotonDirection>(
        &self,
        aimed: &mut AimedPhotons<'a>,
        direct: Vec<Option<DirectLightCache<S>>>,
    ) -> Option<Assignment> {
        let Self { scene, settings, evidence } = self;
        if aimed.count() == 0 {
            return None;
        }
        let paths = (aimed.count() / PHOTONS_PER_PATH).max(MIN_PATHS);
        let represents = aimed.count() as f64 / paths as f64;
        let pixels = PilotPixels::new(scene, settings);
        let contenders = Contenders { scene, settings, evidence, represents }.all();
        let (contenders, cells): (Vec<_>, Vec<_>) = contenders.into_iter().unzip();
        if let [only] = &contenders[..]
            && !only.has_moments()
            && !settings.measures_one
        {
            let (strategies, reason) = (only.strategies(), "no other is possible".into());
            return Some(Assignment { strategies, reason, ..Assignment::default() });
        }
        // Two halves of photons, others than those of the render, each of a Sobol sequence of its own.
        let seed = settings.photons.seed;
        let [a, b] = [1, 2].map(|sequence: u64| {
            let first = sequence << SEQUENCE_BITS;
            let part = PathSample { seed, paths: first..first + paths, represents, levels: LEVELS };
            Half::<S, H>::shoot(scene, aimed, &contenders, &cells, &part)
        });
        // All contenders enter, with the photons of both halves.
        let direct: Arc<[_]> = direct.into();
        let radii = [a.maps.volume_radius, a.radius_of_all];
        let enter = |(contender, grids): (Contender, [Vec<Option<FluenceGrid<S>>>; 2])| {
            let contender = contender.with_kernels(scene, settings, evidence, radii);
            let gathers = contender.shared.as_ref().map(|(_, cells)| cells.clone());
            let gathers = gathers.unwrap_or_default();
            let caches = grids.map(|fluence| {
                let final_gathers = settings.final_gathers(scene, gathers.clone(), &[]);
                Caches { direct: Arc::clone(&direct), fluence, final_gathers }
            });
            let photon_cost = contender.photon_cost(settings, &a.work, represents);
            Entrant::new(contender, caches, photon_cost)
        };
        let grids = a.fluence.into_iter().zip(b.fluence).map(|(a, b)| [a, b]);
        // What beams blur is no variance: they do not enter where it would be much.
        let blurs = a.maps.blur_faces(|p| scene.media.sigma_t_at(p).max_element());
        let others = contenders.iter().any(|contender| !contender.has_beams());
        let enters = |(contender, _): &(Contender, _)| !(blurs && others && contender.has_beams());
        let entering = contenders.into_iter().zip(grids).filter(enters);
        let mut entrants: Vec<Entrant<S>> = entering.map(enter).collect();
        let of_photons = photon::memory::<S, H>(&a.work, MapLayout::whole(), [0; 2], 0);
        let cells = direct.iter().flatten().filter_map(DirectLightCache::cells);
        let of_direct = cells.map(|cells| cells.memory_bytes() as u64);
        let pilot_bytes = of_photons.held
            + of_photons.building
            + of_direct.sum::<u64>()
            + entrants.iter().map(Entrant::memory_bytes).sum::<u64>();
        let measured = self.race(&mut entrants, [&a.maps, &b.maps], &pixels);
        let conditions = settings.conditions();
        let allowed =
            |measured: &&Measured| strategy::is_allowed(&measured.strategies, &conditions);
        let products = |a: &&Measured, b: &&Measured| a.product().total_cmp(&b.product());
        let best = measured.iter().filter(allowed).min_by(products)?;
        let reason = "in a pilot it has the least variance times cost".into();
        Some(Assignment { strategies: best.strategies.clone(), reason, measured, pilot_bytes })
    }

    /// Traces `entrants` in pixels until one is left that leads or more pixels would cost too much. Returns
    /// what was measured of each; nothing where no light is seen.
    fn race<S: Spectrum, H: PhotonDirection>(
        &self,
        entrants: &mut [Entrant<S>],
        maps: [&PhotonMaps<S, H>; 2],
        pixels: &PilotPixels<'_>,
    ) -> Vec<Measured> {
        let picture = pixels.picture;
        let mut count = pixels.first_count().min(pixels.max_count());
        loop {
            Self::trace(entrants, maps, pixels, count);
            // Compare.
            let seen = entrants.iter().filter(|entrant| entrant.is_seen());
            let observed: Vec<Observed<'_>> =
                seen.map(|entrant| entrant.observed(pixels)).collect();
            let samples: Vec<_> = observed.iter().map(|of| of.samples).collect();
            let mut weights = strategy::weights(&samples, &pixels.shares(count));
            if weights.iter().all(|weight| *weight == 0.0) {
                return Vec::new();
            }
            let mut trials = strategy::trials(&observed, &weights, picture);
            trials.extend(self.shared_gathers(entrants, &trials, &weights, pixels));
            strategy::leave_out_outliers(&mut weights, &trials);
            let found: Vec<Measured> =
                trials.iter().map(|trial| trial.measured(&weights)).collect();
            let order = |a: &usize, b: &usize| found[*a].product().total_cmp(&found[*b].product());
            let Some(leader) = (0..found.len()).min_by(order) else { return found };
            // Give up who is behind.
            let is_ahead = |trial: &&Trial| !trial.is_behind(&trials[leader], &weights);
            let ahead: Vec<Vec<Strategy>> =
                trials.iter().filter(is_ahead).map(Trial::unshared).collect();
            for entrant in entrants.iter_mut() {
                entrant.is_racing &= ahead.contains(&entrant.contender.strategies());
            }
            // Go on with as many pixels more, if they cost little enough.
            let racing: Vec<f64> =
                entrants.iter().filter(|e| e.is_racing).map(Entrant::spent).collect();
            let cost = entrants.iter().map(Entrant::spent).chain(racing.iter().copied());
            let next = (2 * count).min(pixels.max_count());
            if racing.len() < 2
                || next <= count
                || cost.sum::<f64>() > MAX_SHARE * found[leader].cost
            {
                return found;
            }
            count = next;
        }
    }

    /// Traces those of `entrants` that race in the first `count` pixels. What costs too much beside the
    /// cheapest picture is given up.
    fn trace<S: Spectrum, H: PhotonDirection>(
        entrants: &mut [Entrant<S>],
        maps: [&PhotonMaps<S, H>; 2],
        pixels: &PilotPixels<'_>,
        count: usize,
    ) {
        for index in 0..entrants.len() {
            let seen = entrants.iter().enumerate().filter(|(other, _)| *other != index);
            let seen = seen.map(|(_, entrant)| entrant).filter(|entrant| entrant.is_seen());
            let costs = seen.map(|entrant| entrant.observed(pixels).cost(pixels.picture));
            let most = MAX_SHARE * costs.fold(f64::INFINITY, f64::min);
            let entrant = &mut entrants[index];
            if entrant.is_racing {
                entrant.trace(pixels, maps, count, most);
                entrant.trace_shared(pixels, maps[0], count);
            }
        }
    }

    /// What shared gathers would bring, by what was measured of moments; `None` where they are not possible.
    fn shared_gathers<S: Spectrum>(
        &self,
        entrants: &[Entrant<S>],
        trials: &[Trial],
        weights: &[f64],
        pixels: &PilotPixels<'_>,
    ) -> Option<Trial> {
        let entrant = entrants.iter().find(|entrant| entrant.contender.shared.is_some())?;
        let strategies = entrant.contender.strategies();
        let moments = trials.iter().find(|trial| trial.strategies == strategies)?;
        let conditions = self.settings.conditions();
        let sharing = strategy::shared_footprint(self.scene, &conditions, &self.evidence)?;
        let others: Vec<&Trial> =
            trials.iter().filter(|trial| trial.strategies != strategies).collect();
        let cost = entrant.shared_cost(pixels)?;
        Some(moments.shared(&others, weights, [GATHERS_PER_RAY, sharing], cost))
    }
}
