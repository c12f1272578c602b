//! Random streams keyed by what they are for, never by thread.

use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// What a random stream is drawn for. Streams of different stages are independent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u64)]
pub enum Stage {
    /// Photon paths; the index is the path.
    Photons = 1,
    /// Camera rays of the march; the index is the pixel.
    March = 2,
    /// Camera rays of the unbiased reference; the index is the pixel.
    Reference = 3,
    /// The director; the index is the pixel.
    Director = 4,
    /// Procedural content.
    Content = 5,
    /// The pilot of strategies; the index is the ray.
    Strategy = 7,
    /// Visibility rays; the index is the pixel.
    Visibility = 8,
    /// Points of final gathers on cells; the index is the cell.
    GatherPoints = 9,
    /// Rays of deep pixels; the index is the pixel.
    Deep = 10,
    /// Tests and benchmarks.
    Test = 6,
}

/// A stream of uniform numbers, given by (seed, stage, index, sample) alone.
#[derive(Debug, Clone)]
pub struct Stream(Xoshiro256PlusPlus);

impl Stream {
    /// The stream for `sample` of pixel or photon `index` in `stage`.
    pub fn new(seed: u64, stage: Stage, index: u64, sample: u64) -> Self {
        let key = [stage as u64, index, sample]
            .into_iter()
            .fold(mix(seed), |key, word| mix(key ^ mix(word.wrapping_add(0x9e37_79b9_7f4a_7c15))));
        Self(Xoshiro256PlusPlus::seed_from_u64(key))
    }

    /// Uniform in [0, 1) with 53 bits.
    pub fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * f64::EPSILON * 0.5
    }

    /// Two uniform numbers.
    pub fn uniform2(&mut self) -> [f64; 2] {
        [self.uniform(), self.uniform()]
    }

    /// A number that scrambles a low-discrepancy sequence.
    pub fn scramble(&mut self) -> u32 {
        (self.uniform() * f64::from(u32::MAX)) as u32
    }

    /// Uniform in the open interval (0, 1): a logarithm of it is finite.
    pub fn open(&mut self) -> f64 {
        ((self.0.next_u64() >> 12) as f64 + 0.5) * f64::EPSILON
    }

    /// Exponentially distributed with mean 1, never 0 and never infinite.
    pub fn exponential(&mut self) -> f64 {
        -self.open().ln()
    }
}

/// The finaliser of SplitMix64 (Steele et al. 2014), a bijection with full avalanche.
const fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}
