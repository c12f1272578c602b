//! The variance of the mean of passes.
//!
//! Each pass knows how its rays scatter within a pixel, and nothing of the noise that they share: that of
//! photons and cells. What differs between passes holds both. The variance within passes is precise but too
//! small; that between them is right on average but rests on few passes. What the second has more than the
//! first is the noise of photons, which changes little from pixel to pixel: it is averaged over neighbours
//! and added to the first.

/// Pixels on each side of a pixel over which the noise of photons is averaged: 49 in all. From two passes a
/// pixel alone tells its variance with a relative standard deviation of the square root of 2, and 49 that are
/// independent with a seventh of that.
const POOL_RADIUS: usize = 3;

/// Luminance of the passes in each pixel: its weighted mean and the sum of squared deviations from it, by
/// the update of West 1979, "Updating Mean and Variance Estimates: An Improved Method".
#[derive(Debug)]
pub(super) struct Spread {
    means: Vec<f64>,
    squares: Vec<f64>,
}

impl Spread {
    /// That of no pass, of so many `pixels`.
    pub(super) fn new(pixels: usize) -> Self {
        Self { means: vec![0.0; pixels], squares: vec![0.0; pixels] }
    }

    /// Adds the `luminance` of a pass of `weight` in the pixel `index`; `total` is the weight of all passes up to it.
    pub(super) fn add(&mut self, index: usize, luminance: f64, weight: f64, total: f64) {
        let before = luminance - self.means[index];
        self.means[index] += before * (weight / total);
        self.squares[index] += weight * before * (luminance - self.means[index]);
    }

    /// The variance of the mean of `passes` of the weight `total`: that `within` passes, of which `width` make a row, and
    /// the excess over it of the variance between passes, as far as it is positive.
    pub(super) fn variances(
        self,
        within: Vec<f64>,
        width: usize,
        passes: usize,
        total: f64,
    ) -> Vec<f64> {
        if passes < 2 {
            return within;
        }
        let per_mean = 1.0 / ((passes - 1) as f64 * total);
        let between = self.squares.iter().map(|squares| squares * per_mean);
        let excess: Vec<f64> = between.zip(&within).map(|(all, within)| all - within).collect();
        let photons = pooled(&excess, width);
        within.iter().zip(photons).map(|(within, photons)| within + photons.max(0.0)).collect()
    }
}

/// The mean of `values` over a square of [`POOL_RADIUS`], cut where the picture ends; `width` make a row.
fn pooled(values: &[f64], width: usize) -> Vec<f64> {
    let height = values.len() / width;
    let near =
        |at: usize, end: usize| at.saturating_sub(POOL_RADIUS)..(at + POOL_RADIUS + 1).min(end);
    let mean = |sum: f64, count: usize| sum / count as f64;
    let mut across = vec![0.0; values.len()];
    for (row, means) in values.chunks_exact(width).zip(across.chunks_exact_mut(width)) {
        for (x, value) in means.iter_mut().enumerate() {
            let near = &row[near(x, width)];
            *value = mean(near.iter().sum(), near.len());
        }
    }
    let mut pooled = vec![0.0; values.len()];
    for (y, means) in pooled.chunks_exact_mut(width).enumerate() {
        let rows = near(y, height);
        for row in rows.clone() {
            let row = &across[row * width..(row + 1) * width];
            means.iter_mut().zip(row).for_each(|(sum, value)| *sum += value);
        }
        means.iter_mut().for_each(|sum| *sum = mean(*sum, rows.len()));
    }
    pooled
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Stage, Stream};

    /// Four passes whose rays and photons are both as noisy, photons in blocks of 4 x 4 pixels. The layer's mean
    /// has a standard deviation of 1.5 % of the variance of the mean, so that 6 % is exceeded once in 10 000 seeds.
    #[test]
    fn the_layer_is_the_variance_of_the_mean_on_average() {
        const SIDE: usize = 128;
        const PASSES: usize = 4;
        let noise = |key: u64| Stream::new(5, Stage::Test, key, 0).uniform();
        let mut spread = Spread::new(SIDE * SIDE);
        for pass in 0..PASSES {
            let key = |index: usize| (pass * 2 * SIDE * SIDE + index) as u64;
            for pixel in 0..SIDE * SIDE {
                let block = pixel / SIDE / 4 * SIDE + pixel % SIDE / 4;
                let luminance = noise(key(pixel)) + noise(key(SIDE * SIDE + block));
                spread.add(pixel, luminance, 1.0, (pass + 1) as f64);
            }
        }
        // A uniform number has the variance 1/12.
        let within = 1.0 / 12.0 / PASSES as f64;
        let found = spread.variances(vec![within; SIDE * SIDE], SIDE, PASSES, PASSES as f64);
        let mean = found.iter().sum::<f64>() / found.len() as f64;
        assert!((mean / (2.0 * within) - 1.0).abs() < 0.06, "{mean} for {}", 2.0 * within);
        assert!(found.iter().all(|variance| *variance >= within));
    }

    #[test]
    fn noise_that_passes_do_not_know_of_is_added() {
        // Two passes, 1 and 3 in all pixels: the mean's variance is (1 + 1) / (2 * 1) = 1.
        let mut spread = Spread::new(12);
        for pixel in 0..12 {
            spread.add(pixel, 1.0, 1.0, 1.0);
            spread.add(pixel, 3.0, 1.0, 2.0);
        }
        let found = spread.variances(vec![0.25; 12], 4, 2, 2.0);
        assert!(found.iter().all(|v| (v - 1.0).abs() < 1e-12), "{found:?}");
    }

    #[test]
    fn passes_that_agree_have_the_variance_within_them() {
        let mut spread = Spread::new(6);
        for pixel in 0..6 {
            spread.add(pixel, 5.0, 1.0, 1.0);
            spread.add(pixel, 5.0, 0.5, 1.5);
        }
        let within: Vec<f64> = (0..6).map(f64::from).collect();
        assert_eq!(spread.variances(within.clone(), 3, 2, 1.5), within);
    }

    #[test]
    fn weights_count_in_the_spread() {
        // Mean (1 * 1 + 3 * 5) / 4 = 4, squares 1 * 9 + 3 * 1 = 12, variance of the mean 12 / (1 * 4).
        let mut spread = Spread::new(1);
        spread.add(0, 1.0, 1.0, 1.0);
        spread.add(0, 5.0, 3.0, 4.0);
        let found = spread.variances(vec![0.0], 1, 2, 4.0);
        assert!((found[0] - 3.0).abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn a_square_is_averaged_as_far_as_the_picture_goes() {
        let mut values = vec![0.0; 10 * 9];
        values[4 * 10 + 5] = 49.0;
        let found = pooled(&values, 10);
        // Column, row and the pixels of the square about it.
        for (x, y, pixels) in [(5, 4, 49.0), (2, 7, 30.0), (8, 4, 35.0), (5, 1, 35.0)] {
            assert!((found[y * 10 + x] - 49.0 / pixels).abs() < 1e-12, "{x} {y}: {found:?}");
        }
        assert_eq!([found[4 * 10 + 9], found[4 * 10 + 1], found[0]], [0.0; 3]);
        assert!(pooled(&[7.0; 6], 3).iter().all(|v| (v - 7.0_f64).abs() < 1e-12));
    }
}
