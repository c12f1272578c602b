//! The kernel of density estimates.

use std::f64::consts::PI;

/// Radius of a kernel at most, in mean free paths of where its light is gathered.
///
/// Unit: none. Derivation: a disk of radius r that is slanted by 60° to a face blurs light along the normal by a
/// variance of r² / 8. Fluence that falls by e in a mean free path l is brightened by half of that over l²: by
/// 1/64 for l / 2.
const MAX_FREE_PATHS: f64 = 0.5;

/// Largest factor by which a kernel becomes narrower for that.
///
/// Unit: none. Limit: on noise: rays meet a sixteenth of the photons.
const MAX_NARROWING: f64 = 4.0;

/// The radius in metres that a photon's kernel has where its light is gathered in a medium of extinction coefficient
/// `sigma_t`, 1/m, if it has `radius` where free paths are long. Wider ones would blur fluence across the faces of a
/// thick medium. More photons have narrower radii, so that blur vanishes however short free paths are.
pub fn radius_within(radius: f64, sigma_t: f64) -> f64 {
    (MAX_FREE_PATHS / sigma_t).clamp(radius / MAX_NARROWING, radius)
}

/// Whether a kernel of this `radius` stays wider than that however narrow it may become.
pub fn is_too_wide(radius: f64, sigma_t: f64) -> bool {
    radius / MAX_NARROWING * sigma_t > MAX_FREE_PATHS
}

/// Epanechnikov's kernel on a disk, 1/m²: integrates to 1 over it (Silverman 1986, "Density
/// Estimation for Statistics and Data Analysis", section 4.2).
#[derive(Debug, Clone, Copy)]
pub struct DiskKernel {
    scale: f64,
    inverse_radius2: f64,
}

impl DiskKernel {
    /// The kernel on the disk of `radius` metres.
    pub fn new(radius: f64) -> Self {
        let radius2 = radius * radius;
        Self { scale: 2.0 / (PI * radius2), inverse_radius2: 1.0 / radius2 }
    }

    /// Its value at a squared distance.
    pub fn at(&self, distance2: f64) -> f64 {
        self.scale * (1.0 - distance2 * self.inverse_radius2).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kernels_are_as_narrow_as_free_paths_but_not_endlessly() {
        for (sigma_t, right) in [(0.0, 0.8), (0.5, 0.8), (1.0, 0.5), (2.0, 0.25), (1e9, 0.2)] {
            assert_eq!(radius_within(0.8, sigma_t), right, "{sigma_t}");
            assert_eq!(is_too_wide(0.8, sigma_t), sigma_t > 2.5, "{sigma_t}");
        }
    }

    #[test]
    fn integrates_to_one() {
        let (n, kernel) = (4000, DiskKernel::new(0.7));
        let dr = 0.7 / f64::from(n);
        let ring = |i| {
            let r = (f64::from(i) + 0.5) * dr;
            kernel.at(r * r) * 2.0 * PI * r * dr
        };
        let sum: f64 = (0..n).map(ring).sum();
        assert!((sum - 1.0).abs() < 1e-6, "{sum}");
    }
}
