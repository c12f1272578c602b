//! What a pilot measured of each assignment of strategies.
//!
//! The efficiency of an assignment is that of Monte Carlo estimators, one over variance times cost (Veach
//! 1997, section 2.2). Bias is left out: kernels and cells are as wide as makes it smaller than the noise.
//! Photons are shot in two halves A and B, and each pixel of the pilot is traced with the random numbers x
//! and y by both. Products of differences of its luminances tell the parts of the variance apart:
//!
//! - (Ax - Ay)(Bx - By)/2: variance of the rays of a pixel, free of the photons' noise;
//! - (Ax - Bx)(Ay - By)/2: variance of the photons, as all rays of a pixel share it.
//!
//! The covariance of A and B over the rays of a pixel is the variance that the pixel would have if its rays
//! were independent, and the variance of A less that what photons add to it. It is known much better than
//! the products of one pixel, but too large: the rays of a pixel are stratified. How much so is told by the first
//! product for the means of few rays each, of which a pixel has many pairs.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::math::quantile;
use crate::scene::Strategy;

/// Epsilon of relative errors over the mean radiance: that of the metric that studies use.
///
/// Unit: none. Definition: that of the metric of studies.
const EPSILON: f64 = 0.5;

/// Rays of a block, of which stratification is measured.
///
/// Unit: count. Derivation: as few as a Sobol sequence stratifies in two dimensions, so that the pilot's rays make as
/// many blocks as they can.
pub const BLOCK: usize = 4;

/// Nanoseconds of a second.
///
/// Unit: count. Definition: of the prefix.
const NANOSECONDS: f64 = 1e9;

/// Luminance of a ray, W/(m² sr).
#[derive(Debug, Clone, Copy, Default)]
pub struct RayLuminance {
    /// What the ray estimates for itself.
    pub own: f64,
    /// What it gathers for all rays of its pixel, without the weight for that; `None` where others gather for it.
    pub gathered: Option<f64>,
}

/// The rays of a pixel by each half of the photons, with two sets of random numbers.
pub type PixelRays<'a> = [[&'a [RayLuminance]; 2]; 2];

/// What one pixel of the pilot shows by one assignment.
#[derive(Debug, Clone, Copy, Default)]
pub struct PixelSamples {
    /// Mean luminance of smooth rays by each half of the photons, with two sets of random numbers.
    means: [[f64; 2]; 2],
    /// Variance of the photons that all rays share.
    shared: f64,
    /// Variance of the mean of the picture's rays, if they were independent.
    independent: f64,
    /// Variance of the mean of a block of rays as they are, and if they were independent.
    of_block: [f64; 2],
    /// What the noise of the pilot's photons adds to that.
    of_rays: f64,
}

/// How the pilot's variances turn into those of the picture.
#[derive(Debug, Clone, Copy)]
pub struct VarianceScale {
    /// Factor on the photons' variance that the rays of a pixel share.
    pub shared: f64,
    /// Factor on the photons' variance that differs with the rays.
    pub of_rays: f64,
}

/// Variances: of the luminance of one pixel, or relative ones of a picture.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Variance {
    /// Variance of a pixel's rays.
    pub ray_variance: f64,
    /// What it would be if photons had no noise.
    pub smooth_ray_variance: f64,
    /// Variance of the photons, as far as the rays of a pixel share it.
    pub photon_variance: f64,
}

impl Variance {
    /// Their sum.
    pub fn total(&self) -> f64 {
        self.ray_variance + self.photon_variance
    }
}

impl PixelSamples {
    /// Those of a pixel in a picture with so many rays and gathers a pixel. In the `smooth` rays photons have
    /// little noise, as cells are wider; in the `sharp` ones they have that of the picture's cells.
    pub fn new(smooth: PixelRays<'_>, sharp: PixelRays<'_>, picture: &PictureSize) -> Self {
        let means = |rays: PixelRays<'_>| rays.map(|half| half.map(pixel_mean));
        let over_sets = |f: &dyn Fn(usize) -> f64| 0.5 * (f(0) + f(1));
        // Of the mean of the picture's rays, by the covariance of two runs of the same rays.
        let of_mean = |a: &[RayLuminance], b: &[RayLuminance]| {
            covariance(a, b, own) / picture.rays + covariance(a, b, gathered) / picture.gathers
        };
        let [a, b] = smooth;
        let independent = over_sets(&|set| of_mean(a[set], b[set]));
        let [a, b] = sharp;
        let noisy = over_sets(&|set| 0.5 * (of_mean(a[set], a[set]) + of_mean(b[set], b[set])));
        let [a, b] = means(sharp);
        let shared = 0.5 * (a[0] - b[0]) * (a[1] - b[1]);
        let of_block = [stratified_block(smooth), independent_block(smooth)];
        Self { means: means(smooth), shared, independent, of_block, of_rays: noisy - independent }
    }

    /// Mean of its four luminances.
    fn luminance(&self) -> f64 {
        self.means.iter().flatten().sum::<f64>() / 4.0
    }

    /// Variance of the mean of a block of rays, stratified as they are. May be negative.
    pub const fn stratified_block(&self) -> f64 {
        self.of_block[0]
    }

    /// Variance of the mean of a block of rays, if they were independent. May be negative.
    pub const fn independent_block(&self) -> f64 {
        self.of_block[1]
    }

    /// A pixel of which only the variances of blocks are known, for tests.
    #[cfg(test)]
    pub fn of_blocks(stratified: f64, independent: f64) -> Self {
        Self { of_block: [stratified, independent], ..Self::default() }
    }

    /// Variance of this pixel in the picture; any part may be negative. Stratification leaves the share `left` of the
    /// variance of independent rays.
    pub fn variance(&self, left: f64, scale: &VarianceScale) -> Variance {
        let smooth = left * self.independent;
        Variance {
            ray_variance: smooth + scale.of_rays * self.of_rays,
            smooth_ray_variance: smooth,
            photon_variance: scale.shared * self.shared,
        }
    }
}

/// Variance of the mean of a block of rays, over all pairs of blocks of both sets of random numbers.
fn stratified_block(rays: PixelRays<'_>) -> f64 {
    let [a, b] = rays.map(|half| half.map(|set| blocks(set).map(pixel_mean).collect::<Vec<f64>>()));
    let pairs = (0..a[0].len()).flat_map(|x| (0..a[1].len()).map(move |y| (x, y)));
    let product = |(x, y): (usize, usize)| 0.5 * (a[0][x] - a[1][y]) * (b[0][x] - b[1][y]);
    let count = a[0].len() * a[1].len();
    pairs.map(product).sum::<f64>() / count.max(1) as f64
}

/// Variance of the mean of a block of rays, if they were independent.
fn independent_block(rays: PixelRays<'_>) -> f64 {
    let [a, b] = rays;
    let of_set = |set: usize| {
        let Some(block) = blocks(a[set]).next() else { return 0.0 };
        let gathers = block.iter().filter(|ray| ray.gathered.is_some()).count();
        covariance(a[set], b[set], own) / block.len() as f64
            + covariance(a[set], b[set], gathered) / gathers.max(1) as f64
    };
    0.5 * (of_set(0) + of_set(1))
}

/// The blocks of the rays of a pixel; all rays where they are fewer.
fn blocks(rays: &[RayLuminance]) -> impl Iterator<Item = &[RayLuminance]> {
    rays.chunks_exact(BLOCK.min(rays.len()).max(1))
}

const fn own(ray: &RayLuminance) -> Option<f64> {
    Some(ray.own)
}

const fn gathered(ray: &RayLuminance) -> Option<f64> {
    ray.gathered
}

/// Mean luminance of the rays of a pixel.
fn pixel_mean(rays: &[RayLuminance]) -> f64 {
    mean(rays, own) + mean(rays, gathered)
}

/// Mean of a part of those rays that have it.
fn mean(rays: &[RayLuminance], part: impl Fn(&RayLuminance) -> Option<f64>) -> f64 {
    let (sum, count) =
        rays.iter().filter_map(part).fold((0.0, 0.0), |(sum, count), x| (sum + x, count + 1.0));
    sum / f64::max(count, 1.0)
}

/// Covariance of a part in two runs of the same rays; 0 of fewer than two.
fn covariance(
    a: &[RayLuminance],
    b: &[RayLuminance],
    part: impl Fn(&RayLuminance) -> Option<f64> + Copy,
) -> f64 {
    let means = [a, b].map(|rays| mean(rays, part));
    let pairs = a.iter().zip(b).filter_map(|(a, b)| Some((part(a)?, part(b)?)));
    let (sum, count) = pairs.fold((0.0, 0.0), |(sum, count), (a, b)| {
        (sum + (a - means[0]) * (b - means[1]), count + 1.0)
    });
    if count > 1.0 { sum / (count - 1.0) } else { 0.0 }
}

/// Weights of the pixels' squared errors: one over the squared radiance plus that of an epsilon, as in the
/// relative error of studies. `assignments` are the samples by each, of all pixels or of the first. A
/// pixel's radiance is the median of what they show: one that sparks does not make its own error small.
///
/// Each pixel stands for its part of the picture by `shares`, of mean 1.
pub fn weights(assignments: &[&[PixelSamples]], shares: &[f64]) -> Vec<f64> {
    let radiance = |pixel: usize| {
        let all = assignments.iter().filter_map(|samples| samples.get(pixel));
        quantile(all.map(PixelSamples::luminance).collect(), 0.5).unwrap_or(0.0)
    };
    let radiances: Vec<f64> = (0..shares.len()).map(radiance).collect();
    let shared = radiances.iter().zip(shares).map(|(radiance, share)| radiance * share);
    let epsilon = EPSILON * shared.sum::<f64>() / shares.len().max(1) as f64;
    let weight = |(radiance, share): (f64, &f64)| {
        let squared = radiance.powi(2) + epsilon.powi(2);
        if squared > 0.0 { share / squared } else { 0.0 }
    };
    radiances.into_iter().zip(shares).map(weight).collect()
}

/// The picture that is to be rendered.
#[derive(Debug, Clone, Copy)]
pub struct PictureSize {
    /// Its pixels.
    pub pixels: f64,
    /// Rays of a pixel.
    pub rays: f64,
    /// Those of them that gather.
    pub gathers: f64,
}

/// What one assignment brings and takes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// Strategy of each medium.
    pub strategies: Vec<Strategy>,
    /// Relative variance of a pixel.
    #[serde(flatten)]
    pub variance: Variance,
    /// Cost of the picture, in nanoseconds of a typical core.
    pub cost: f64,
    /// Cost of its photons, in the same unit.
    pub photon_cost: f64,
    /// Power of the number of rays by which their variance falls: 1 where rays are noise, more as they are stratified.
    #[serde(default = "edge_power")]
    pub ray_power: f64,
}

/// Power of the number of rays by which variance falls where an edge crosses the pixel, for rays of which nothing was measured.
///
/// Unit: none. Source: Mitchell 1996, "Consequences of Stratified Sampling in Graphics".
pub const EDGE_POWER: f64 = 1.5;

const fn edge_power() -> f64 {
    EDGE_POWER
}

impl Measured {
    /// Variance times cost: one over the efficiency.
    pub fn product(&self) -> f64 {
        self.variance.total() * self.cost
    }
}

impl fmt::Display for Measured {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names = self.strategies.iter().map(|strategy| strategy.name());
        let names = names.collect::<Vec<_>>().join(", ");
        let (error, seconds) = (self.variance.total().sqrt(), self.cost / NANOSECONDS);
        write!(f, "{names}: relative error {error:.4} for about {seconds:.2} CPU s")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Stage, Stream};

    const RAYS: usize = 8;
    const PICTURE: PictureSize = PictureSize { pixels: 1.0, rays: 16.0, gathers: 4.0 };

    /// Pixels of luminance 2 with standard deviations of each ray, of the photons of each half, and of what
    /// both together make of each ray. Every second ray gathers half of its light.
    fn made(count: usize, [rays, photons, both]: [f64; 3]) -> Vec<PixelSamples> {
        let mut rng = Stream::new(5, Stage::Test, 0, 0);
        // A sum of twelve uniform numbers has a variance of 1.
        let mut normal = || (0..12).map(|_| rng.uniform()).sum::<f64>() - 6.0;
        let mut pixel = || {
            let numbers = [(); 2].map(|()| [(); RAYS].map(|()| rays * normal()));
            let mut half = || {
                let noise = photons * normal();
                numbers.map(|set| {
                    let ray = |(index, number): (usize, f64)| {
                        let light = 1.0 + 0.5 * (noise + number + both * normal());
                        let gathered = (index % 2 == 0).then_some(light);
                        RayLuminance { own: light, gathered }
                    };
                    set.into_iter().enumerate().map(ray).collect::<Vec<_>>()
                })
            };
            let halves = [half(), half()];
            let rays = halves.each_ref().map(|half| half.each_ref().map(|set| &set[..]));
            PixelSamples::new(rays, rays, &PICTURE)
        };
        (0..count).map(|_| pixel()).collect()
    }

    /// Within 4.5 standard errors of products by 4096 pixels: a false alarm of 7e-6 at this fixed seed.
    #[test]
    fn variances_are_told_apart() {
        let count = 4096;
        let error = 4.5 * (2.0 / count as f64).sqrt();
        let scale = VarianceScale { shared: 0.5, of_rays: 0.25 };
        for parts in
            [[0.3, 0.0, 0.0], [0.5, 0.2, 0.1], [0.1, 0.4, 0.0], [0.0, 0.3, 0.2], [0.2, 0.0, 0.0]]
        {
            let [rays, photons, both] = parts.map(|part: f64| part * part);
            let pixels = made(count, parts);
            let each: Vec<Variance> =
                pixels.iter().map(|pixel| pixel.variance(0.5, &scale)).collect();
            let mean =
                |part: fn(&Variance) -> f64| each.iter().map(part).sum::<f64>() / count as f64;
            let near = |found: f64, right: f64, scale: f64| (found - right).abs() <= error * scale;
            // A quarter of the variance is that of each of 16 rays, another that of each of 4 gathers.
            let independent = 0.25 / 16.0 + 0.25 / 4.0;
            let right = independent * (0.5 * rays + 0.25 * both);
            let found = mean(|variance| variance.ray_variance);
            assert!(near(found, right, rays + photons + both), "rays {found} not {right}");
            let found = mean(|variance| variance.photon_variance);
            assert!(
                near(found, 0.5 * photons, rays + photons + both),
                "photons {found}: {parts:?}"
            );
            let mean_of = |part: fn(&PixelSamples) -> f64| {
                pixels.iter().map(part).sum::<f64>() / count as f64
            };
            let found = mean_of(PixelSamples::independent_block);
            let right = (0.25 / 4.0 + 0.25 / 2.0) * rays;
            assert!(near(found, right, rays + photons + both), "block {found}: {parts:?}");
            let found = mean_of(PixelSamples::stratified_block);
            // In a block 4 rays and 2 gathers, which have the same numbers.
            let right = (0.25 / 4.0 + 0.25 / 2.0 + 2.0 * 0.25 / 4.0) * rays;
            assert!(near(found, right, rays + photons + both), "stratified {found}: {parts:?}");
        }
    }

    #[test]
    fn variances_are_relative_to_what_most_assignments_show() {
        let of = |radiances: &[f64]| -> Vec<PixelSamples> {
            let pixel =
                |whole: &f64| PixelSamples { means: [[*whole; 2]; 2], ..Default::default() };
            radiances.iter().map(pixel).collect()
        };
        // The last one was given up after two pixels.
        let (a, b, c) = (of(&[1.0, 2.0, 3.0]), of(&[1.0, 2.0, 3.0]), of(&[40.0, 2.0]));
        let found = weights(&[&a, &b, &c], &[1.0; 3]);
        for (weight, radiance) in found.iter().zip([1.0_f64, 2.0, 3.0]) {
            let right = 1.0 / (radiance.powi(2) + 1.0);
            assert!((weight - right).abs() < 1e-12, "{weight} for {right}");
        }
        assert_eq!(weights(&[&of(&[0.0; 4])], &[1.0; 4]), [0.0; 4]);
    }
}
