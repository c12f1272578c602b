//! What an estimator draws from and counts with.

use std::time::Duration;

use crate::math::Stream;
use crate::scene::plan::Needs;
use crate::work::Work;

/// Random numbers to draw from, and a count of the work done with them.
#[derive(Debug, Clone)]
pub struct PathContext {
    /// Random numbers of one ray.
    pub rng: Stream,
    /// Work done so far.
    pub work: Work,
    /// What is needed.
    pub needs: Needs,
    /// For places on lights, for the first surface that asks.
    pub lights: Option<SobolPoint>,
    /// For where and how a medium first scatters the ray.
    pub scattering: Option<SobolPoint>,
    /// Time that went into what is found once and kept for all who ask later.
    pub once: Duration,
}

impl PathContext {
    /// From these random numbers, with no work done yet, for what `needs` say.
    pub fn new(rng: Stream, needs: Needs) -> Self {
        let (lights, scattering) = (None, None);
        Self { rng, work: Work::default(), needs, lights, scattering, once: Duration::ZERO }
    }
}

/// Numbers spread evenly over the rays of a pixel: one point of an Owen-scrambled Sobol sequence
/// (Burley 2020), whose dimensions are asked for as they are needed.
#[derive(Debug, Clone, Copy)]
pub struct SobolPoint {
    /// Which point, below 2^16.
    pub index: u32,
    /// Which scrambling.
    pub scramble: u32,
}

impl SobolPoint {
    /// Of the place on the film and on the lens.
    pub fn place(self) -> [f64; 4] {
        sobol_burley::sample_4d(self.index, 0, self.scramble).map(f64::from)
    }

    /// Of the place on a light.
    pub fn light(self) -> [f64; 2] {
        let number = |dimension| sobol_burley::sample(self.index, dimension, self.scramble);
        [4, 5].map(|dimension| f64::from(number(dimension)))
    }

    /// Of the place where a ray is scattered, the channel that chooses it, and the deflection.
    pub fn scattering(self) -> [f64; 4] {
        sobol_burley::sample_4d(self.index, 2, self.scramble).map(f64::from)
    }
}
