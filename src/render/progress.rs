//! Progress reports of a render, and the times of its stages.

use std::time::{Duration, Instant};

use super::rendered::ReachedError;

/// Receives the progress of a render, from any thread.
pub trait Progress: Sync {
    /// A stage of `total` units of work begins; 0 where the number is unknown.
    fn stage(&self, name: &str, total: u64);
    /// `units` more of the stage's work are done.
    fn advance(&self, units: u64);
    /// `time` of the stage went into work that is done once, as filling a cache: an estimate of the
    /// time that is left should leave it out.
    fn once(&self, _time: Duration) {}
    /// The stage's units are redefined: `done` are done out of `total`.
    fn weigh(&self, _done: u64, _total: u64) {}
    /// The stage is over.
    fn finish(&self);
    /// A round of a render to a stated error is over, and the picture has this one.
    fn reached(&self, _error: &ReachedError) {}
    /// Something failed that does not end the render; `problem` is one sentence.
    fn warn(&self, _problem: &str) {}
}

/// Ignores all reports.
///
/// ```
/// use fogbow::render::{Progress, Silent};
/// Silent.stage("photons", 1000);
/// Silent.finish();
/// ```
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Progress for Silent {
    fn stage(&self, _: &str, _: u64) {}
    fn advance(&self, _: u64) {}
    fn finish(&self) {}
}

/// Wall-clock times of the stages that ran. A stage that was left out is not listed.
///
/// ```
/// use fogbow::render::Stages;
/// use std::time::Instant;
/// let mut stages = Stages::default();
/// stages.done("photons", Instant::now());
/// assert_eq!(stages.timings[0].0, "photons");
/// ```
#[derive(Debug, Clone, Default)]
pub struct Stages {
    /// Name and time of each stage, in the order in which they first ran.
    pub timings: Vec<(&'static str, Duration)>,
}

impl Stages {
    /// Records the stage `name`, or more of it, which began at `start` and ends here.
    pub fn done(&mut self, name: &'static str, start: Instant) {
        let time = start.elapsed();
        match self.timings.iter_mut().find(|(known, _)| *known == name) {
            Some((_, whole)) => *whole += time,
            None => self.timings.push((name, time)),
        }
    }

    /// Time of the stage `name`, in seconds: 0 where it did not run.
    pub fn seconds_of(&self, name: &str) -> f64 {
        let of = self.timings.iter().find(|(known, _)| *known == name);
        of.map_or(0.0, |(_, time)| time.as_secs_f64())
    }

    /// Time of all stages, in seconds.
    pub fn seconds(&self) -> f64 {
        self.timings.iter().map(|(_, time)| time.as_secs_f64()).sum()
    }
}
