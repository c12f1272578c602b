//! The kernel of density estimates.

use std::f64::consts::PI;

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
