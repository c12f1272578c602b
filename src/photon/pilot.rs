//! The pilot: what the first paths tell of all.

use rayon::prelude::*;

use super::PhotonDirection;
use super::path::{Deposits, PhotonTracer};
use super::settings::STORED_PER_PATH;
use crate::math::{Spectrum, WeightedValues};
use crate::transport::FlightSegment;

/// Most paths of the pilot.
///
/// Unit: count. Limit: on the time before any photon is stored.
const MAX_PATHS: u64 = 2048;

/// Fewest paths of the pilot, if there are so many, and those that tell of a weight window that splits too often.
///
/// Unit: count. Derivation: what 128 independent paths estimate has a relative error of about 1 /
/// sqrt(128), a tenth.
const MIN_PATHS: u64 = 128;

/// Photon paths of the render for each path of a pilot: the pilot traces 1/16 of the paths, or more
/// where photons have to be thinned.
///
/// Unit: none. Limit: on the share of the pilot in the time of all paths.
pub(super) const PHOTONS_PER_PATH: u64 = 16;

/// Excess of the expected number of stored photons over the wanted one above which more paths are
/// traced, so that the share to store is known well.
///
/// Unit: none. Limit: on the pilot's time where at least half of the photons are stored and the share
/// matters little.
const MAX_EXCESS: f64 = 2.0;

/// Paths of the pilot's first round: few, since one may leave very many photons.
///
/// Unit: count. Limit: on photons in memory where each path leaves very many.
const FIRST_ROUND: u64 = 8;

/// Paths of each later round, as a share of those traced before.
///
/// Unit: none. Limit: on paths beyond those that tell enough.
const LATER_ROUND: f64 = 0.25;

/// Fewest volume photons to be stored, if there are so many: those of thick media lie mostly where
/// the camera does not see them, so that few paths must store many.
///
/// Unit: count. Bench: `any_extinction_ends_in_a_picture` of `tests/physics/extremes.rs`.
const MIN_STORED: f64 = 200_000.0;

/// Volume photons after which the pilot ends: a spike of density makes one path leave very many.
///
/// Unit: count. Limit: on memory.
const MAX_PILOT_PHOTONS: usize = 1_000_000;

/// Largest ratio of the events of paths with splitting to those without.
///
/// Unit: none. Limit: on the time of tracing.
const MAX_SPLITTING_COST: f64 = 2.0;

/// Most raises of the weight window in search of one whose splitting is cheap enough.
///
/// Unit: count. Limit: on the search.
const MAX_RAISES: u32 = 8;

/// Smallest factor of a raise.
///
/// Unit: none. Limit: on the search: 8 raises multiply the window by 25.
const MIN_RAISE: f64 = 1.5;

/// Estimates for all paths of a render.
#[derive(Debug)]
pub(super) struct PathPilot {
    /// Probability of storing a volume photon.
    pub store_probability: f64,
    /// Length in metres of all flights through media. A path counts at most the diagonal of the media:
    /// a longer one crosses the same places again, which lowers noise little.
    pub flight_length: f64,
    /// Median power of flights in media by length, summed over channels, in the unit of flights;
    /// `None` where there are none.
    median_power: Option<f64>,
    /// Collisions and surface intersections a path.
    events: f64,
}

impl PathPilot {
    /// Sets the weight window of `paths` to the median power of flights in media, raised where splitting
    /// would make paths too expensive, and traces the pilot of `count` paths with it (weight windows of
    /// Vorba and Křivánek 2016, "Adjoint-Driven Russian Roulette and Splitting in Light Transport
    /// Simulation").
    pub fn with_weight_window<S: Spectrum, H: PhotonDirection>(
        paths: &mut PhotonTracer<'_>,
        count: u64,
    ) -> Self {
        let whole = Self::trace::<S, H>(paths, count);
        let Some(power) = whole.median_power else { return whole };
        let mut window = power * paths.units.surface;
        let excess = |of: &Self| of.events / (MAX_SPLITTING_COST * whole.events).max(1.0);
        for _ in 0..MAX_RAISES {
            paths.window = Some(window);
            // Few paths tell of a window that splits far too often, by which many would take long.
            let mut split = Self::trace::<S, H>(paths, MIN_PATHS.min(count));
            if excess(&split) <= 1.0 {
                split = Self::trace::<S, H>(paths, count);
            }
            let excess = excess(&split);
            if excess <= 1.0 {
                return split;
            }
            window *= excess.max(MIN_RAISE);
        }
        paths.window = None;
        whole
    }

    /// Traces the first of `count` paths.
    fn trace<S: Spectrum, H: PhotonDirection>(paths: &PhotonTracer<'_>, count: u64) -> Self {
        let (mut traced, mut stored, mut segments, mut events) = (0, 0, Vec::new(), 0);
        let diagonal = paths.flight_bounds.map_or(0.0, |bounds| bounds.size().length());
        let mut length = 0.0;
        let most = MAX_PATHS.min(count);
        let few = (count / PHOTONS_PER_PATH).max(MIN_PATHS).min(most);
        let wanted = (STORED_PER_PATH * count as f64).max(MIN_STORED);
        let expected =
            |stored: usize, traced: u64| stored as f64 * count as f64 / traced.max(1) as f64;
        let goes_on =
            |stored, traced| traced < few || expected(stored, traced) > MAX_EXCESS * wanted;
        while traced < most && stored < MAX_PILOT_PHOTONS && goes_on(stored, traced) {
            let round = FIRST_ROUND.max((LATER_ROUND * traced as f64) as u64);
            let until = (traced + round).min(if traced < few { few } else { most });
            let trace = |path: u64| paths.trace::<S, H>(path..path + 1);
            let round: Vec<u64> = (traced..until).collect();
            let each: Vec<_> = round.into_par_iter().with_max_len(1).map(trace).collect();
            for Deposits { volume, tracks, work, .. } in each {
                stored += volume.len();
                events += work.collisions + work.intersections;
                length += tracks.iter().map(FlightSegment::length).sum::<f64>().min(diagonal);
                segments.extend(tracks);
            }
            traced = until;
        }
        let store_probability = (wanted / expected(stored, traced).max(1.0)).min(1.0);
        let share = traced as f64 / count.max(1) as f64;
        let flight_length = length / share.max(f64::MIN_POSITIVE);
        let events = events as f64 / traced.max(1) as f64;
        Self { store_probability, flight_length, median_power: median_power(&segments), events }
    }
}

/// The power, summed over channels, below which half of the length is flown; `None` where there are no
/// flights.
fn median_power<S: Spectrum>(segments: &[FlightSegment<S>]) -> Option<f64> {
    let power = |segment: &FlightSegment<S>| S::to_f64(segment.power()).element_sum();
    let by_length = segments.iter().map(|segment| (power(segment), segment.length()));
    WeightedValues::new(by_length).quantile(0.5).filter(|power| *power > 0.0)
}
