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
        let excess = |events: f64| events / (MAX_SPLITTING_COST * whole.events).max(1.0);
        for _ in 0..MAX_RAISES {
            paths.window = Some(window);
            // Few paths tell of a window that splits far too often, by which many would take long.
            let mut few = Traced::<S>::new();
            while few.paths < MIN_PATHS.min(count) && few.stored < MAX_PILOT_PHOTONS {
                few.trace_round::<H>(paths, MIN_PATHS.min(count));
            }
            let mut found = excess(few.events_a_path());
            if found <= 1.0 {
                let split = Self::trace::<S, H>(paths, count);
                found = excess(split.events);
                if found <= 1.0 {
                    return split;
                }
            }
            window *= found.max(MIN_RAISE);
        }
        paths.window = None;
        whole
    }

    /// Traces the first of `count` paths.
    fn trace<S: Spectrum, H: PhotonDirection>(paths: &PhotonTracer<'_>, count: u64) -> Self {
        let most = MAX_PATHS.min(count);
        let few = (count / PHOTONS_PER_PATH).max(MIN_PATHS).min(most);
        let wanted = (STORED_PER_PATH * count as f64).max(MIN_STORED);
        let mut traced = Traced::<S>::new();
        let expected = |of: &Traced<S>| of.stored as f64 * count as f64 / of.paths.max(1) as f64;
        let is_enough = |of: &Traced<S>| of.paths >= few && expected(of) <= MAX_EXCESS * wanted;
        while traced.paths < most && traced.stored < MAX_PILOT_PHOTONS && !is_enough(&traced) {
            traced.trace_round::<H>(paths, if traced.paths < few { few } else { most });
        }
        let share = traced.paths as f64 / count.max(1) as f64;
        Self {
            store_probability: (wanted / expected(&traced).max(1.0)).min(1.0),
            flight_length: traced.length / share.max(f64::MIN_POSITIVE),
            median_power: median_power(&traced.segments),
            events: traced.events_a_path(),
        }
    }
}

/// What the first paths leave.
#[derive(Debug)]
struct Traced<S: Spectrum> {
    paths: u64,
    /// Volume photons.
    stored: usize,
    /// Flights through media.
    segments: Vec<FlightSegment<S>>,
    /// Length of those in metres, of each path at most the diagonal of the media.
    length: f64,
    /// Collisions and surface intersections.
    events: u64,
}

impl<S: Spectrum> Traced<S> {
    const fn new() -> Self {
        Self { paths: 0, stored: 0, segments: Vec::new(), length: 0.0, events: 0 }
    }

    /// Traces some paths more, up to the one before `until`.
    fn trace_round<H: PhotonDirection>(&mut self, paths: &PhotonTracer<'_>, until: u64) {
        let diagonal = paths.flight_bounds.map_or(0.0, |bounds| bounds.size().length());
        let round = FIRST_ROUND.max((LATER_ROUND * self.paths as f64) as u64);
        let until = (self.paths + round).min(until);
        let trace = |path: u64| paths.trace::<S, H>(path..path + 1);
        let round: Vec<u64> = (self.paths..until).collect();
        let each: Vec<_> = round.into_par_iter().with_max_len(1).map(trace).collect();
        for Deposits { volume, tracks, work, .. } in each {
            self.stored += volume.len();
            self.events += work.collisions + work.intersections;
            self.length += tracks.iter().map(FlightSegment::length).sum::<f64>().min(diagonal);
            self.segments.extend(tracks);
        }
        self.paths = until;
    }

    fn events_a_path(&self) -> f64 {
        self.events as f64 / self.paths.max(1) as f64
    }
}

/// The power, summed over channels, below which half of the length is flown; `None` where there are no
/// flights.
fn median_power<S: Spectrum>(segments: &[FlightSegment<S>]) -> Option<f64> {
    let power = |segment: &FlightSegment<S>| S::to_f64(segment.power()).element_sum();
    let by_length = segments.iter().map(|segment| (power(segment), segment.length()));
    WeightedValues::new(by_length).quantile(0.5).filter(|power| *power > 0.0)
}
