//! What a path draws its random numbers from and counts its work in.

use std::time::Duration;

use crate::math::Stream;
use crate::scene::plan::Needs;
use crate::work::Work;

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

/// The named dimensions of a camera sample that are stratified over the samples of a pixel beyond
/// film and lens. Each serves one decision of the path, the first of its kind; later ones use
/// independent numbers, as stratification over a pixel helps little after the first bounce.
#[derive(Debug, Clone, Copy, Default)]
pub struct StratifiedSample {
    light: Option<SobolPoint>,
    scattering: Option<SobolPoint>,
}

impl StratifiedSample {
    /// The dimensions of `point` for lights and scattering.
    pub const fn new(point: SobolPoint) -> Self {
        Self { light: Some(point), scattering: Some(point) }
    }

    /// The numbers for a position on a light, at the first surface of the path that samples lights;
    /// `None` afterwards.
    pub fn next_light(&mut self) -> Option<[f64; 2]> {
        self.light.take().map(SobolPoint::light)
    }

    /// The numbers for distance, channel and direction of the first scattering in a medium; `None`
    /// afterwards.
    pub fn next_scattering(&mut self) -> Option<[f64; 4]> {
        self.scattering.take().map(SobolPoint::scattering)
    }
}

/// One point of an Owen-scrambled Sobol sequence (Burley 2020, "Practical Hash-based Owen
/// Scrambling"), whose named dimensions are computed on demand.
#[derive(Debug, Clone, Copy)]
pub struct SobolPoint {
    /// Index in the sequence, below 2^16.
    pub index: u32,
    /// Seed of the scrambling.
    pub scramble: u32,
}

impl SobolPoint {
    /// Two numbers for the film and two for the lens.
    pub fn film_and_lens(self) -> [f64; 4] {
        sobol_burley::sample_4d(self.index, 0, self.scramble).map(f64::from)
    }

    /// Two numbers for a position on a light.
    pub fn light(self) -> [f64; 2] {
        let number = |dimension| sobol_burley::sample(self.index, dimension, self.scramble);
        [4, 5].map(|dimension| f64::from(number(dimension)))
    }

    /// Four numbers for a scattering: two for distance and channel, two for the direction.
    pub fn scattering(self) -> [f64; 4] {
        sobol_burley::sample_4d(self.index, 2, self.scramble).map(f64::from)
    }
}
