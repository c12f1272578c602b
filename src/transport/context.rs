//! What a path draws its random numbers from and counts its work in.

use std::time::Duration;

use crate::math::Stream;
use crate::scene::plan::Needs;
use crate::work::Work;

use super::stratified::StratifiedSample;

/// The random numbers of one path, its work counters, and what the scene needs of it.
#[derive(Debug, Clone)]
pub struct PathContext {
    /// Independent random numbers.
    pub rng: Stream,
    /// Work done so far.
    pub work: Work,
    /// What the render plan needs: whether there are surfaces, media, emission and so on.
    pub needs: Needs,
    /// Stratified numbers of the camera sample that the path belongs to.
    pub stratified: StratifiedSample,
    /// What later rays profit from.
    pub amortized: Amortized,
}

impl PathContext {
    /// A context without stratified numbers and with no work done yet.
    pub fn new(rng: Stream, needs: Needs) -> Self {
        Self {
            rng,
            work: Work::default(),
            needs,
            stratified: StratifiedSample::default(),
            amortized: Amortized::default(),
        }
    }
}

/// What was done for more than one ray. The wall times weigh the progress display and say when to read
/// the clock; no pixel depends on them.
#[derive(Debug, Clone, Copy, Default)]
pub struct Amortized {
    /// Work of filling cells of caches.
    pub work: Work,
    /// Time of filling cells of caches.
    pub cells: Duration,
    /// Time of density estimates that one ray of a pixel makes for several.
    pub gathers: Duration,
}
