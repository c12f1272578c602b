//! Weights of passes in their mean, from the work that was asked for.
//!
//! The variance of a pixel is A / n + B / p for n rays a pixel and p photons, where A is the variance of
//! rays and B that of photons. Weights inversely proportional to variance make the noise of the mean least.
//! A and B are different in every pixel, and measured ones go with the pixel's own noise: a pass that missed a
//! rare bright path measures little variance, gets a large weight and darkens the mean. So A and B are not
//! measured: both are taken to leave as much noise in the mean of all N rays and P photons, A / N = B / P,
//! and the weight is 1 / (N / n + P / p). It is exact for passes whose rays and photons are in the same
//! ratio, where it is the share of the work. Of two passes with the same photons, one with twice the rays
//! weighs 10/7 of the other.
//!
//! n is the setting, rays of a pixel at most, and not the number of rays that were shot. A director gives a
//! pixel rays by what it measured in the same picture, so that a count of rays, of a pixel or of the picture, goes
//! with the picture's noise; with the same settings all passes have the same weight. All pixels of a
//! pass share its weight, since its photons light all of them.

/// Work that was asked for one pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PassWork {
    /// Rays of a pixel, at most.
    pub rays: u64,
    /// Photons; 0 where the picture has none, as the reference.
    pub photons: u64,
}

/// The weight of each pass, the largest 1. Photons count where all passes have some.
pub fn pass_weights(passes: &[PassWork]) -> Vec<f64> {
    let sum = |count: fn(&PassWork) -> u64| passes.iter().map(|pass| count(pass) as f64).sum();
    let (rays, photons): (f64, f64) = (sum(|pass| pass.rays), sum(|pass| pass.photons));
    let has_photons = passes.iter().all(|pass| pass.photons > 0);
    let weight = |pass: &PassWork| {
        let of_rays = rays / pass.rays.max(1) as f64;
        let of_photons = if has_photons { photons / pass.photons as f64 } else { 0.0 };
        1.0 / (of_rays + of_photons)
    };
    let weights: Vec<f64> = passes.iter().map(weight).collect();
    let largest = weights.iter().copied().fold(0.0, f64::max);
    weights.into_iter().map(|weight| weight / largest).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn weights(works: &[[u64; 2]]) -> Vec<f64> {
        let works: Vec<_> =
            works.iter().map(|&[rays, photons]| PassWork { rays, photons }).collect();
        pass_weights(&works)
    }

    #[test]
    fn equal_passes_weigh_the_same() {
        assert_eq!(weights(&[[7, 1003]; 3]), [1.0; 3]);
        assert_eq!(weights(&[[7, 0]; 3]), [1.0; 3]);
        assert_eq!(weights(&[[7, 5]]), [1.0]);
    }

    #[test]
    fn passes_weigh_by_their_share_of_rays_and_photons() {
        let is = |found: Vec<f64>, expected: [f64; 2]| {
            let near = found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12);
            assert!(near, "{found:?} for {expected:?}");
        };
        is(weights(&[[4, 1000], [8, 2000]]), [0.5, 1.0]);
        is(weights(&[[4, 1000], [8, 1000]]), [0.7, 1.0]);
        is(weights(&[[8, 1000], [8, 2000]]), [0.7, 1.0]);
        is(weights(&[[4, 2000], [8, 1000]]), [1.0, 1.0]);
        is(weights(&[[2, 0], [8, 0]]), [0.25, 1.0]);
    }
}
