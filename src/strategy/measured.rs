//! What a pilot measured of each strategy, and which has the least error for its time.
//!
//! An assignment is a strategy for each medium. Its efficiency is that of Monte Carlo estimators, one over
//! squared error times cost (Veach 1997, section 2.2), with bias among the error. Photons are shot in
//! two halves A and B, and each ray is traced with the random numbers x and y by both. Products of
//! differences tell the parts of the error apart:
//!
//! - (Ax - Ay)(Bx - By)/2: variance of a ray, free of the photons' noise;
//! - (Ax - Bx)(Ay - By)/2: variance of the photons that all rays of a pixel share;
//! - (Ax - Bx)²/2 less that: variance of the photons that differs from ray to ray;
//! - (A' - A)(B' - B)/9, with kernels and cells twice as wide in A' and B': squared bias, as the bias of a
//!   kernel is then four times as large.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::scene::Strategy;

/// Rays along each side of the blocks over which biases are averaged before they are squared.
///
/// Unit: count. Derivation: 16 rays lower the noise of a bias by a factor of four, and still tell
/// shadow from light.
pub const BLOCK: usize = 4;

/// Epsilon of relative errors over the mean radiance: that of the metric that studies use.
///
/// Unit: none. Definition: that of the metric of studies.
const EPSILON: f64 = 0.5;

/// Nanoseconds of a second.
///
/// Unit: count. Definition: of the prefix.
const NANOSECONDS: f64 = 1e9;

/// Luminance that one ray brings by one assignment, W/(m² sr).
#[derive(Debug, Clone, Copy, Default)]
pub struct RaySamples {
    /// By each half of the photons, with two sets of random numbers.
    pub samples: [[f64; 2]; 2],
    /// By each half with kernels and cells twice as wide, with the first set.
    pub wide: [f64; 2],
}

/// How errors at the pilot's photons turn into those at all photons.
#[derive(Debug, Clone, Copy)]
pub struct PhotonScale {
    /// Factor on the photons' variance that the rays of a pixel share.
    pub shared: f64,
    /// Factor on the photons' variance that differs from ray to ray.
    pub of_ray: f64,
    /// Factor on the squared bias.
    pub bias: f64,
}

/// What one assignment brings and takes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// Strategy of each medium.
    pub strategies: Vec<Strategy>,
    /// Its relative squared errors.
    #[serde(flatten)]
    pub errors: Errors,
    /// Cost of a ray, in nanoseconds of a typical core.
    pub ray_cost: f64,
    /// Cost of all photons, in the same unit.
    pub photon_cost: f64,
    /// Pixels of the picture.
    pub pixels: f64,
    /// Rays of a pixel.
    pub rays: f64,
}

impl Measured {
    /// Relative squared error of a pixel.
    pub fn error(&self) -> f64 {
        let Errors { ray_variance, photon_variance, squared_bias } = self.errors;
        ray_variance / self.rays + photon_variance + squared_bias
    }

    /// Cost of the picture, in nanoseconds of a typical core.
    pub fn cost(&self) -> f64 {
        self.photon_cost + self.pixels * self.rays * self.ray_cost
    }

    /// Squared error times cost: one over the efficiency.
    pub fn product(&self) -> f64 {
        self.error() * self.cost()
    }
}

impl fmt::Display for Measured {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names = self.strategies.iter().map(|strategy| strategy.name());
        let names = names.collect::<Vec<_>>().join(", ");
        let (error, seconds) = (self.error().sqrt(), self.cost() / NANOSECONDS);
        write!(f, "{names}: relative error {error:.4} for about {seconds:.2} CPU s")
    }
}

/// Weights of the rays' squared errors: one over the squared radiance of their block plus that of an
/// epsilon, as in the relative error of studies. `assignments` are the samples of each, on a square grid of
/// rays, row by row.
pub fn weights(assignments: &[Vec<RaySamples>]) -> Vec<f64> {
    let rays = assignments.first().map_or(0, Vec::len);
    let mean_of = |ray: usize| {
        let all = assignments.iter().flat_map(|samples| samples[ray].samples).flatten();
        all.sum::<f64>() / (4 * assignments.len()) as f64
    };
    let means: Vec<f64> = (0..rays).map(mean_of).collect();
    let epsilon = EPSILON * means.iter().sum::<f64>() / rays.max(1) as f64;
    let blocks = blocks(&means);
    let weight = |ray: usize| {
        let squared = blocks[block_of(ray, rays)].powi(2) + epsilon.powi(2);
        if squared > 0.0 { 1.0 / squared } else { 0.0 }
    };
    (0..rays).map(weight).collect()
}

/// Relative squared errors of one assignment.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// Variance that averages out over the rays of a pixel, of one ray.
    pub ray_variance: f64,
    /// Variance of the photons that the rays of a pixel share.
    pub photon_variance: f64,
    /// Squared bias.
    pub squared_bias: f64,
}

/// Errors of one assignment with all photons, from rays whose squared errors have these weights.
pub fn errors(rays: &[RaySamples], weights: &[f64], scale: PhotonScale) -> Errors {
    let count = rays.len().max(1) as f64;
    let mean = |f: &dyn Fn(&RaySamples) -> f64| {
        rays.iter().zip(weights).map(|(ray, weight)| weight * f(ray)).sum::<f64>() / count
    };
    let of_ray = mean(&|RaySamples { samples: [a, b], .. }| 0.5 * (a[0] - a[1]) * (b[0] - b[1]));
    let shared = mean(&|RaySamples { samples: [a, b], .. }| 0.5 * (a[0] - b[0]) * (a[1] - b[1]));
    let photons = mean(&|RaySamples { samples: [a, b], .. }| {
        0.5 * (0.5 * (a[0] - b[0]).powi(2) + 0.5 * (a[1] - b[1]).powi(2))
    });
    let shared = shared.clamp(0.0, photons);
    let biases = [0, 1].map(|half| {
        let bias = |(ray, weight): (&RaySamples, &f64)| {
            weight.sqrt() * (ray.wide[half] - ray.samples[half][0]) / 3.0
        };
        blocks(&rays.iter().zip(weights).map(bias).collect::<Vec<_>>())
    });
    let [a, b] = &biases;
    let products: Vec<f64> = a.iter().zip(b).map(|(a, b)| a * b).collect();
    let squared_bias = significant(&products);
    Errors {
        ray_variance: of_ray.max(0.0) + (photons - shared) * scale.of_ray,
        photon_variance: shared * scale.shared,
        squared_bias: squared_bias * scale.bias,
    }
}

/// Mean less its standard error, at least 0: what is left of a mean that noise may have made.
fn significant(values: &[f64]) -> f64 {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
    (mean - (squares / (count * (count - 1.0))).sqrt()).max(0.0)
}

/// Means over blocks of a square grid.
fn blocks(values: &[f64]) -> Vec<f64> {
    let side = values.len().isqrt() / BLOCK;
    let mut means = vec![0.0; side * side];
    for (index, value) in values.iter().enumerate() {
        means[block_of(index, values.len())] += value / (BLOCK * BLOCK) as f64;
    }
    means
}

/// The block of one value of so many on a square grid.
fn block_of(index: usize, count: usize) -> usize {
    let side = count.isqrt();
    index / side / BLOCK * (side / BLOCK) + index % side / BLOCK
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Stage, Stream};

    /// Rays of radiance 2 with standard deviations of rays, of the photons of each half, and of what both
    /// together make, and with a bias, of which kernels twice as wide have four times as much.
    fn made(side: usize, [ray, photons, both, bias]: [f64; 4]) -> Vec<RaySamples> {
        let mut rng = Stream::new(5, Stage::Test, 0, 0);
        // A sum of twelve uniform numbers has a variance of 1.
        let mut normal = || (0..12).map(|_| rng.uniform()).sum::<f64>() - 6.0;
        let mut sample = || {
            let numbers = [ray * normal(), ray * normal()];
            let mut half = || {
                let noise = photons * normal();
                numbers.map(|number| 2.0 + bias + number + noise + both * normal())
            };
            let samples = [half(), half()];
            let wide = samples.map(|half| half[0] + 3.0 * bias + 0.5 * photons * normal());
            RaySamples { samples, wide }
        };
        (0..side * side).map(|_| sample()).collect()
    }

    /// Within 4.5 standard errors of products by 64² rays: a false alarm of 7e-6 at this fixed seed.
    #[test]
    fn errors_are_told_apart() {
        let side = 64;
        let error = 4.5 * (2.0 / (side * side) as f64).sqrt();
        for parts in
            [[0.5, 0.2, 0.1, 0.0], [0.1, 0.4, 0.0, 0.1], [0.0, 0.3, 0.2, 0.3], [0.2, 0.0, 0.0, 0.0]]
        {
            let [ray, photons, both, bias] = parts.map(|part: f64| part * part);
            let rays = made(side, parts);
            let even = vec![1.0; rays.len()];
            let scale = PhotonScale { shared: 0.5, of_ray: 0.25, bias: 0.25 };
            let found = errors(&rays, &even, scale);
            let near = |found: f64, right: f64, scale: f64| (found - right).abs() <= error * scale;
            let all = ray + photons + both;
            assert!(near(found.ray_variance, ray + 0.25 * both, all), "{found:?} for {parts:?}");
            assert!(
                near(found.photon_variance, 0.5 * photons, photons + both),
                "{found:?} for {parts:?}"
            );
            assert!(
                near(found.squared_bias, 0.25 * bias, 0.1 * (photons + bias)),
                "{found:?} for {parts:?}"
            );
        }
    }

    #[test]
    fn errors_are_relative_to_a_blocks_radiance() {
        let mut samples = made(8, [0.0; 4]);
        samples.iter_mut().step_by(8).for_each(|ray| *ray = RaySamples::default());
        // One ray in eight is dark, in the first column of blocks one in four: blocks of 1.5 and 2, whose
        // mean is 1.75.
        let found = weights(&[samples]);
        for (ray, radiance) in [(0, 1.5_f64), (7, 2.0)] {
            let right = 1.0 / (radiance.powi(2) + (0.5 * 1.75_f64).powi(2));
            assert!((found[ray] - right).abs() < 1e-12, "{} for {right}", found[ray]);
        }
        assert!(weights(&[vec![RaySamples::default(); 64]]).iter().all(|weight| *weight == 0.0));
    }

    #[test]
    fn blocks_tile_the_square() {
        let count = 144;
        let numbers: Vec<usize> = (0..count).map(|index| block_of(index, count)).collect();
        for block in 0..9 {
            assert_eq!(numbers.iter().filter(|number| **number == block).count(), 16);
        }
        assert_eq!([numbers[0], numbers[4], numbers[12 * 4], numbers[143]], [0, 1, 3, 8]);
    }
}
