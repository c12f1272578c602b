//! The trials of a pilot: assignments of strategies, compared pixel by pixel.

use super::kind::{shared, unshared};
use super::measured::{BLOCK, Measured, PictureSize, PixelSamples, Variance, VarianceScale};
use crate::math::nth_smallest;
use crate::scene::Strategy;

/// Standard errors by which an assignment must be behind another to be given up.
///
/// Unit: none. Derivation: at three, one in 700 of those that are not behind is given up where errors are
/// normal; those of pixels are skewed.
const BEHIND: f64 = 3.0;

/// Pixels of which the one with the largest variance by all assignments is left out.
///
/// Unit: count. Derivation: the metric of studies leaves such pixels out too. One in a thousand would be
/// none of a pilot's, and variance that all assignments have does not tell which is better.
const PIXELS_PER_OUTLIER: usize = 32;

/// What a pilot saw of one assignment so far.
pub struct Observed<'a> {
    /// Strategy of each medium.
    pub strategies: Vec<Strategy>,
    /// Pixels, the first ones where it was given up.
    pub samples: &'a [PixelSamples],
    /// From variances of the pilot to those of the picture.
    pub scale: VarianceScale,
    /// Cost of a ray, in nanoseconds of a typical core.
    pub ray_cost: f64,
    /// Cost of all photons, in the same unit.
    pub photon_cost: f64,
}

impl Observed<'_> {
    /// Cost of the picture.
    pub fn cost(&self, picture: PictureSize) -> f64 {
        self.photon_cost + picture.pixels * picture.rays * self.ray_cost
    }
}

/// The trials of all that were observed, for pixels of these `weights`.
///
/// Each assignment has a stratification of its own, which its blocks of rays tell. As far as they may tell it by chance,
/// rays count as independent.
pub fn trials(observed: &[Observed<'_>], weights: &[f64], picture: PictureSize) -> Vec<Trial> {
    let trial = |of: &Observed<'_>| {
        let share = stratified_share(of.samples, weights);
        let left = stratified_variance(share, picture.rays);
        Trial {
            strategies: of.strategies.clone(),
            variances: of.samples.iter().map(|own| own.variance(left, &of.scale)).collect(),
            cost: of.cost(picture),
            photon_cost: of.photon_cost,
            ray_power: ray_power(share),
        }
    };
    observed.iter().map(trial).collect()
}

/// Variance of so many stratified rays over that of independent ones, where blocks have this `share` of theirs.
///
/// What is smooth over a pixel has a variance as rays^-3 by scrambled nets (Owen 1997, "Scrambled Net Variance for
/// Integrals of Smooth Functions"), noise one as 1 / rays: the share of blocks tells how much there is of each.
fn stratified_variance(share: f64, rays: f64) -> f64 {
    let smooth = |rays: f64| rays.powi(-2);
    let of_block = smooth(BLOCK as f64);
    let noise = ((share - of_block) / (1.0 - of_block)).clamp(0.0, 1.0);
    noise + (1.0 - noise) * smooth(rays)
}

/// Power of the number of rays by which the variance falls of which a block has this `share` of that of independent ones: the
/// share is 1 where rays are noise, whose power is 1, and 1/16 where they are smooth, whose power is 3.
fn ray_power(share: f64) -> f64 {
    let smooth = (BLOCK as f64).powi(-2);
    1.0 - share.clamp(smooth, 1.0).ln() / (BLOCK as f64).ln()
}

/// Variance of blocks of stratified rays over that of independent ones: the ratio of their means over pixels, at most 1,
/// and drawn to that by its standard error (shrinkage by James and Stein 1961, "Estimation with Quadratic Loss").
fn stratified_share(samples: &[PixelSamples], weights: &[f64]) -> f64 {
    let sum = |part: &dyn Fn(&PixelSamples) -> f64| {
        let pixels = samples.iter().zip(weights);
        pixels.map(|(pixel, weight)| weight * part(pixel)).sum::<f64>()
    };
    let independent = sum(&PixelSamples::independent_block);
    let ratio = sum(&PixelSamples::stratified_block) / independent;
    let squares = samples.iter().zip(weights).map(|(pixel, weight)| {
        (weight * (pixel.stratified_block() - ratio * pixel.independent_block())).powi(2)
    });
    let squared_error = squares.sum::<f64>() / independent.powi(2);
    let less = 1.0 - ratio;
    let sure = (1.0 - squared_error / less.powi(2)).max(0.0);
    // Without any variance it is not a number.
    if sure > 0.0 { 1.0 - sure * less.max(0.0) } else { 1.0 }
}

/// What a pilot found of one assignment so far.
#[derive(Debug, Clone)]
pub struct Trial {
    /// Strategy of each medium.
    pub strategies: Vec<Strategy>,
    /// Variance of each pixel in the picture, of the first ones where the trial was given up.
    pub variances: Vec<Variance>,
    /// Cost of the picture, in nanoseconds of a typical core.
    pub cost: f64,
    /// Cost of its photons, in the same unit.
    pub photon_cost: f64,
    /// As in [`Measured::ray_power`].
    pub ray_power: f64,
}

impl Trial {
    /// Relative variance and cost of the picture, from pixels of these weights.
    pub fn measured(&self, weights: &[f64]) -> Measured {
        let mean = |part| weighted_mean(&self.variances, weights, part).mean.max(0.0);
        let variance = Variance {
            ray_variance: mean(|variance: &Variance| variance.ray_variance),
            smooth_ray_variance: mean(|variance| variance.smooth_ray_variance),
            photon_variance: mean(|variance| variance.photon_variance),
        };
        let Self { strategies, cost, photon_cost, ray_power, .. } = self;
        Measured {
            strategies: strategies.clone(),
            variance,
            cost: *cost,
            photon_cost: *photon_cost,
            ray_power: *ray_power,
        }
    }

    /// Whether its variance times cost is surely larger than that of `leader`: by pairs of pixels that both
    /// were traced in.
    pub fn is_behind(&self, leader: &Self, weights: &[f64]) -> bool {
        let pairs = self.variances.iter().zip(&leader.variances);
        let differences: Vec<f64> = pairs
            .map(|(own, other)| own.total() * self.cost - other.total() * leader.cost)
            .collect();
        let difference = weighted_mean(&differences, weights, |difference| *difference);
        difference.mean > BEHIND * difference.standard_error
    }

    /// Its strategies, or those that it was made of by [`shared`](Self::shared).
    pub fn unshared(&self) -> Vec<Strategy> {
        self.strategies.iter().map(|strategy| unshared(*strategy)).collect()
    }

    /// Whether it has final gathers in any medium.
    fn makes_gathers(&self) -> bool {
        self.strategies.iter().any(|strategy| strategy.makes_gathers())
    }

    /// What gathers that `sharing` rays share would bring, by what was measured of gathers that none shares. As
    /// much variance stays as the least noisy of `others` without gathers has in the same pixels: that of all
    /// other light. The rest, all where there are no such others, is divided by the number of `gathers` that a
    /// ray stands for times `sharing`. The picture takes this `cost`.
    pub fn shared(
        &self,
        others: &[&Self],
        weights: &[f64],
        [gathers, sharing]: [f64; 2],
        cost: f64,
    ) -> Self {
        let noise = |trial: &Self, pixels: usize| {
            let pixels = &trial.variances[..pixels];
            weighted_mean(pixels, weights, |variance| variance.smooth_ray_variance).mean.max(0.0)
        };
        let part_by = |other: &Self| {
            let pixels = other.variances.len().min(self.variances.len());
            noise(other, pixels) / noise(self, pixels)
        };
        let without = others.iter().filter(|other| !other.makes_gathers());
        let least = without.map(|other| part_by(other)).reduce(f64::min);
        let part = least.map_or(0.0, |part| part.min(1.0));
        let left = part + (1.0 - part) / (gathers * sharing);
        let of_pixel = |own: &Variance| Variance {
            ray_variance: left * own.ray_variance,
            smooth_ray_variance: left * own.smooth_ray_variance,
            ..*own
        };
        Self {
            strategies: self.strategies.iter().map(|strategy| shared(*strategy)).collect(),
            variances: self.variances.iter().map(of_pixel).collect(),
            cost,
            photon_cost: self.photon_cost,
            ray_power: self.ray_power,
        }
    }
}

/// Sets the weights of pixels to 0 that have the largest variances by all trials.
pub fn leave_out_outliers(weights: &mut [f64], trials: &[Trial]) {
    let least = |pixel: usize| {
        let all = trials.iter().filter_map(|trial| trial.variances.get(pixel));
        all.map(Variance::total).fold(f64::INFINITY, f64::min)
    };
    let pixels = weights.iter().enumerate();
    let variances: Vec<f64> = pixels.map(|(pixel, weight)| weight * least(pixel)).collect();
    let kept = weights.len() - weights.len() / PIXELS_PER_OUTLIER;
    let Some(largest) = kept.checked_sub(1).and_then(|rank| nth_smallest(variances.clone(), rank))
    else {
        return;
    };
    for (weight, variance) in weights.iter_mut().zip(variances) {
        if variance > largest {
            *weight = 0.0;
        }
    }
}

/// A mean with its standard error.
struct Mean {
    mean: f64,
    standard_error: f64,
}

/// That of a part of each pixel, weighted.
fn weighted_mean<T>(pixels: &[T], weights: &[f64], part: fn(&T) -> f64) -> Mean {
    let values: Vec<f64> = pixels.iter().zip(weights).map(|(p, w)| w * part(p)).collect();
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count.max(1.0);
    let squares = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
    Mean { mean, standard_error: (squares / (count * (count - 1.0)).max(1.0)).sqrt() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trial(strategy: Strategy, variances: &[f64], cost: f64) -> Trial {
        let of_pixel = |variance: &f64| Variance {
            ray_variance: *variance,
            smooth_ray_variance: *variance,
            photon_variance: 0.0,
        };
        let variances = variances.iter().map(of_pixel).collect();
        Trial { strategies: vec![strategy], variances, cost, photon_cost: 0.0, ray_power: 1.0 }
    }

    #[test]
    fn powers_of_rays_are_those_of_noise_edges_and_smooth_light() {
        // A share below that of smooth light, or below nothing, is one by chance.
        let known = [(1.0, 1.0), (0.5, 1.5), (1.0 / 16.0, 3.0), (0.01, 3.0), (-0.1, 3.0)];
        for (share, power) in known {
            assert!((ray_power(share) - power).abs() < 1e-12, "{} of {share}", ray_power(share));
        }
    }

    /// The share of stratified blocks is the ratio of their means where pixels agree on it, and 1 where they do not.
    #[test]
    fn chance_is_not_taken_for_stratification() {
        let pixels = |products: &[f64]| -> Vec<PixelSamples> {
            products.iter().map(|product| PixelSamples::of_blocks(*product, 2.0)).collect()
        };
        let share =
            |products: &[f64]| stratified_share(&pixels(products), &vec![1.0; products.len()]);
        assert_eq!(share(&[1.0; 64]), 0.5);
        assert!((share(&[0.8, 1.2].repeat(32)) - 0.5).abs() < 0.01);
        // Most products are small and few are large, as those of noise are.
        let mut skewed = vec![0.2; 64];
        (skewed[7], skewed[40]) = (30.0, 40.0);
        assert_eq!(share(&skewed), 1.0);
        assert_eq!(share(&[3.0; 64]), 1.0);
        assert_eq!(share(&[]), 1.0);
    }

    /// Noise falls as one over the rays, smooth light as one over their cube.
    #[test]
    fn blocks_tell_noise_from_smooth_light() {
        assert_eq!(stratified_variance(1.0, 16.0), 1.0);
        assert_eq!(stratified_variance(1.0 / 16.0, 16.0), 1.0 / 256.0);
        assert_eq!(stratified_variance(0.0, 16.0), 1.0 / 256.0);
        assert_eq!(stratified_variance(0.3, BLOCK as f64), 0.3);
        assert_eq!(stratified_variance(0.3, 1.0), 1.0);
        let half = stratified_variance(0.5 + 0.5 / 16.0, 64.0);
        assert!((half - (0.5 + 0.5 / 4096.0)).abs() < 1e-12, "{half}");
    }

    #[test]
    fn a_trial_is_given_up_where_pixels_agree() {
        let weights = [1.0; 4];
        let leader = trial(Strategy::Beams, &[1.0, 9.0, 2.0, 4.0], 2.0);
        let twice = trial(Strategy::Traced, &[1.0, 9.0, 2.0, 4.0], 4.0);
        assert!(!twice.is_behind(&leader, &weights), "four pixels of very unlike variances");
        let even = trial(Strategy::Traced, &[3.0, 11.0, 4.0, 6.0], 2.0);
        assert!(even.is_behind(&leader, &weights));
        assert!(!leader.is_behind(&even, &weights));
        assert!(!leader.is_behind(&leader, &weights));
    }

    #[test]
    fn variances_of_a_picture_are_weighted() {
        let measured = trial(Strategy::Beams, &[1.0, 3.0], 7.0).measured(&[0.5, 1.5]);
        assert_eq!((measured.variance.ray_variance, measured.product()), (2.5, 17.5));
    }

    #[test]
    fn a_pixel_that_is_bad_by_all_is_left_out() {
        let mut noisy = vec![1.0; PIXELS_PER_OUTLIER];
        (noisy[3], noisy[7]) = (50.0, 90.0);
        let mut other = noisy.clone();
        other[7] = 2.0;
        let trials = [trial(Strategy::Beams, &noisy, 1.0), trial(Strategy::Traced, &other, 1.0)];
        let mut weights = vec![1.0; PIXELS_PER_OUTLIER];
        leave_out_outliers(&mut weights, &trials);
        // That by one alone stays.
        assert_eq!((weights[3], weights[7]), (0.0, 1.0));
        assert_eq!(weights.iter().sum::<f64>(), (PIXELS_PER_OUTLIER - 1) as f64);
    }

    #[test]
    fn shared_gathers_lower_only_what_gathers_bring() {
        let moments = trial(Strategy::Moments, &[9.0, 1.0], 5.0);
        let common = trial(Strategy::Beams, &[1.0, 1.0], 1.0);
        let (gathers, weights) = ([8.0, 2.0], [1.0; 2]);
        let noisy = trial(Strategy::Traced, &[70.0, 80.0], 1.0);
        let shared = moments.shared(&[&noisy, &common], &weights, gathers, 33.0);
        assert_eq!(shared.strategies, [Strategy::SharedGathers]);
        let variances: Vec<f64> =
            shared.variances.iter().map(|variance| variance.ray_variance).collect();
        // A fifth of the mean is common, and a sixteenth of the rest is left.
        assert_eq!((variances, shared.cost), (vec![2.25, 0.25], 33.0));
        assert_eq!(shared.unshared(), moments.strategies);
        let shared = moments.shared(&[&noisy], &weights, gathers, 33.0);
        assert_eq!(shared.variances[0].ray_variance, 9.0 / 16.0);
        // All is common: noise may make it seem to be more. Who was given up tells of its pixels.
        let given_up = trial(Strategy::Beams, &[9.5], 1.0);
        let shared = moments.shared(&[&noisy, &given_up], &weights, gathers, 33.0);
        assert_eq!(shared.variances[0].ray_variance, 9.0);
    }
}
