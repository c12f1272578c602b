//! Particles much smaller than the wavelength: air, thin smoke's finest part.

use std::f64::consts::PI;

use super::Deflection;

/// Rayleigh's phase function for unpolarised light, 3 (1 + cos²) / (16 pi).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rayleigh;

impl Rayleigh {
    pub(super) fn eval(self, cos_theta: f64) -> f64 {
        3.0 / (16.0 * PI) * (1.0 + cos_theta * cos_theta)
    }

    /// Solves cos³ + 3 cos = 8 u - 4, whose one real root is 2 sinh(asinh(4 u - 2) / 3).
    pub(super) fn sample(self, u: f64) -> Deflection {
        let cos_theta = 2.0 * ((4.0 * u - 2.0).asinh() / 3.0).sinh();
        Deflection::from_cos(cos_theta.clamp(-1.0, 1.0))
    }
}
