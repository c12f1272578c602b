//! Mean of the features that the rays of a pixel see.

use crate::image::Features;

/// Mean of the features of one pixel's rays.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FeatureMean {
    count: u32,
    mean: Features,
}

impl FeatureMean {
    /// Number of 64-bit words of [`to_bits`](Self::to_bits).
    ///
    /// Unit: count. Definition: of the format of checkpoints.
    pub const WORDS: usize = 4;

    /// Adds the features of a ray; those with a NaN or an infinity are ignored.
    pub fn add(&mut self, seen: &Features) {
        if !seen.is_finite() {
            return;
        }
        self.count += 1;
        let weight = 1.0 / f64::from(self.count);
        let step = |mean: &mut f32, seen: f32| {
            let before = f64::from(*mean);
            *mean = (before + (f64::from(seen) - before) * weight) as f32;
        };
        for (mean, seen) in self.mean.albedo.iter_mut().zip(seen.albedo) {
            step(mean, seen);
        }
        for (mean, seen) in self.mean.normal.iter_mut().zip(seen.normal) {
            step(mean, seen);
        }
    }

    /// The mean; 0 without a ray.
    pub const fn mean(&self) -> Features {
        self.mean
    }

    /// The state as the bits of its numbers, for checkpoints.
    pub fn to_bits(&self) -> [u64; Self::WORDS] {
        let Features { albedo: [r, g, b], normal: [x, y, z] } = self.mean;
        let pair = |low: u32, high: u32| u64::from(low) | u64::from(high) << 32;
        let floats = |low: f32, high: f32| pair(low.to_bits(), high.to_bits());
        [pair(self.count, 0), floats(r, g), floats(b, x), floats(y, z)]
    }

    /// Restores the state from [`to_bits`](Self::to_bits).
    pub fn from_bits(bits: &[u64; Self::WORDS]) -> Self {
        let [low, high] = [
            |word: u64| f32::from_bits(word as u32),
            |word: u64| f32::from_bits((word >> 32) as u32),
        ];
        let [count, first, second, third] = *bits;
        let albedo = [low(first), high(first), low(second)];
        let normal = [high(second), low(third), high(third)];
        Self { count: count as u32, mean: Features { albedo, normal } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_mean_is_that_of_all_and_survives_storing(
            rays in prop::collection::vec((prop::array::uniform3(0.0_f32..1.0), prop::array::uniform3(-1.0_f32..1.0)), 1..40),
        ) {
            let mut mean = FeatureMean::default();
            for &(albedo, normal) in &rays {
                mean.add(&Features { albedo, normal });
                mean.add(&Features { albedo, normal: [f32::NAN, 0.0, 0.0] });
                mean = FeatureMean::from_bits(&mean.to_bits());
            }
            let Features { albedo, normal } = mean.mean();
            for c in 0..3 {
                let mut expected = [0.0; 2];
                for ray in &rays {
                    expected[0] += f64::from(ray.0[c]) / rays.len() as f64;
                    expected[1] += f64::from(ray.1[c]) / rays.len() as f64;
                }
                prop_assert!((f64::from(albedo[c]) - expected[0]).abs() < 1e-5);
                prop_assert!((f64::from(normal[c]) - expected[1]).abs() < 1e-5);
            }
        }
    }
}
