//! What the first paths tell of all.

use rayon::prelude::*;

use super::PhotonDirection;
use super::path::{Deposits, PhotonTracer};
use crate::math::Spectrum;
use crate::transport::FlightSegment;

/// Paths that are asked at most.
const PATHS: u64 = 2048;

/// Paths that are asked at least, if there are so many.
const FEWEST: u64 = 128;

/// Of so many paths one is asked, unless photons have to be thinned.
pub(super) const ONE_IN: u64 = 16;

/// How many times too many photons may be left before that is done with care.
const MANY: f64 = 2.0;

/// Paths that are asked at once at first: few, since one may leave very many photons.
const AT_ONCE: u64 = 8;

/// Share of the paths asked so far that are asked at once later.
const MORE: f64 = 0.25;

/// Volume photons, about, kept of one path.
const KEPT: f64 = 4.0;

/// Volume photons, about, that are kept at least, if there are so many: those of thick media lie
/// mostly where nobody sees them, so that of few paths many must be kept.
const SPARED: f64 = 200_000.0;

/// Volume photons after which enough is known of how many a path leaves: as at a spike of density.
const ENOUGH: usize = 1_000_000;

/// How many times as many events splitting may make of the same paths.
const DEARER: f64 = 2.0;

/// How often the window for splitting is raised at most.
const RAISES: u32 = 8;

/// What is known of all paths before they are shot.
#[derive(Debug)]
pub(super) struct PathPilot {
    /// Share of the volume photons to keep, so that a path leaves few.
    pub keep: f64,
    /// Length in metres of all flights through media, of each path at most once across them: what a
    /// path leaves beyond lies beside what it left before.
    pub flown: f64,
    /// Power, summed over channels, of flights in media, in the unit of tracks: half of their length
    /// is flown with less. Nothing where there are none.
    usual_power: Option<f64>,
    /// Collisions and surfaces met, a path.
    events: f64,
}

impl PathPilot {
    /// Gives `paths` a window round the usual power in media, raised where splitting heavier photons
    /// would make them too dear, and tells what `count` paths then leave.
    pub fn windowed<S: Spectrum, H: PhotonDirection>(
        paths: &mut PhotonTracer<'_>,
        count: u64,
    ) -> Self {
        let whole = Self::by::<S, H>(paths, count);
        let Some(power) = whole.usual_power else { return whole };
        let mut window = power * paths.units.surface;
        for _ in 0..RAISES {
            paths.window = Some(window);
            let split = Self::by::<S, H>(paths, count);
            let dearer = split.events / (DEARER * whole.events).max(1.0);
            if dearer <= 1.0 {
                return split;
            }
            window *= dearer.max(1.5);
        }
        paths.window = None;
        whole
    }

    /// Asks the first of `count` paths.
    fn by<S: Spectrum, H: PhotonDirection>(paths: &PhotonTracer<'_>, count: u64) -> Self {
        let (mut traced, mut left, mut tracks, mut events) = (0, 0, Vec::new(), 0);
        let across = paths.tracked.map_or(0.0, |bounds| bounds.size().length());
        let mut flown = 0.0;
        let most = PATHS.min(count);
        let few = (count / ONE_IN).max(FEWEST).min(most);
        let sought = (KEPT * count as f64).max(SPARED);
        let expected = |left: usize, traced: u64| left as f64 * count as f64 / traced.max(1) as f64;
        let wanting = |left, traced| traced < few || expected(left, traced) > MANY * sought;
        while traced < most && left < ENOUGH && wanting(left, traced) {
            let more = AT_ONCE.max((MORE * traced as f64) as u64);
            let until = (traced + more).min(if traced < few { few } else { most });
            let trace = |path: u64| paths.trace::<S, H>(path..path + 1);
            let asked: Vec<u64> = (traced..until).collect();
            let each: Vec<_> = asked.into_par_iter().with_max_len(1).map(trace).collect();
            for Deposits { volume, tracks: left_behind, work, .. } in each {
                left += volume.len();
                events += work.collisions + work.intersections;
                flown += left_behind.iter().map(FlightSegment::length).sum::<f64>().min(across);
                tracks.extend(left_behind);
            }
            traced = until;
        }
        let keep = (sought / expected(left, traced).max(1.0)).min(1.0);
        let share = traced as f64 / count.max(1) as f64;
        let flown = flown / share.max(f64::MIN_POSITIVE);
        let events = events as f64 / traced.max(1) as f64;
        Self { keep, flown, usual_power: usual_power(&mut tracks), events }
    }
}

fn usual_power<S: Spectrum>(tracks: &mut [FlightSegment<S>]) -> Option<f64> {
    let power = |track: &FlightSegment<S>| S::to_f64(track.power()).element_sum();
    tracks.sort_by(|a, b| power(a).total_cmp(&power(b)));
    let total: f64 = tracks.iter().map(FlightSegment::length).sum();
    let mut flown = 0.0;
    let middle = tracks.iter().find(|track| {
        flown += track.length();
        flown >= 0.5 * total
    });
    middle.map(power).filter(|power| *power > 0.0)
}
