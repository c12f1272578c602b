//! How a render tells how far it is, and what it took.

use std::time::{Duration, Instant};

/// Is told of stages and of work done in them, from any thread.
pub trait Progress: Sync {
    /// A stage of `total` units of work begins.
    fn stage(&self, name: &str, total: u64);
    /// `units` more of the stage's work are done.
    fn advance(&self, units: u64);
    /// So much of the stage's time went into what is done once, and says nothing of the rest.
    fn once(&self, _: Duration) {}
    /// The stage's units are counted anew: so many are done out of `total`.
    fn weigh(&self, _done: u64, _total: u64) {}
    /// The stage is over.
    fn finish(&self);
    /// Something went wrong that does not end the render: one sentence.
    fn warn(&self, _: &str) {}
}

/// Tells nobody.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Progress for Silent {
    fn stage(&self, _: &str, _: u64) {}
    fn advance(&self, _: u64) {}
    fn finish(&self) {}
}

/// The stages of a run with the time that each took.
#[derive(Debug, Clone, Default)]
pub struct Stages {
    /// In the order in which they ran.
    pub timings: Vec<(&'static str, Duration)>,
}

impl Stages {
    /// The stage that began at `start` is over.
    pub fn done(&mut self, name: &'static str, start: Instant) {
        self.timings.push((name, start.elapsed()));
    }
}
