//! One lobe, forward or backward.

use std::f64::consts::PI;

use super::Deflection;

/// The phase function of Henyey and Greenstein 1941, "Diffuse Radiation in the Galaxy", eq. 2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HenyeyGreenstein {
    g: f64,
}

impl HenyeyGreenstein {
    /// The function with mean cosine `g`.
    ///
    /// # Errors
    /// Says what would be right where `g` is not inside (-1, 1).
    pub fn new(g: f64) -> Result<Self, String> {
        if g.abs() < 1.0 {
            Ok(Self { g })
        } else {
            Err(format!("mean cosine g is {g}: must lie inside (-1, 1), ends excluded"))
        }
    }

    /// The mean cosine g.
    pub const fn mean_cosine(self) -> f64 {
        self.g
    }

    pub(super) const fn convolved(self, keep: f64) -> Self {
        Self { g: self.g * keep }
    }

    pub(super) fn eval(self, cos_theta: f64) -> f64 {
        let s = lobe_distance_squared(self.g, cos_theta);
        (1.0 - self.g) * (1.0 + self.g) / (4.0 * PI * s * s.sqrt())
    }

    /// The inverse of the cumulative distribution, written with m = u (1 + g) / (1 - g + 2 g u),
    /// for which 1 - cos = 2 (1 - m) (1 - g m): no difference of nearly equal numbers for any g,
    /// 0 and nearly 1 included.
    pub(super) fn sample(self, u: f64) -> Deflection {
        let denominator = 1.0 - self.g + 2.0 * self.g * u;
        let m = u * (1.0 + self.g) / denominator;
        let one_minus_m = (1.0 - u) * (1.0 - self.g) / denominator;
        deflection(self.g, m, one_minus_m)
    }
}

/// 1 + g² - 2 g cos, as the square of a distance that does not cancel near |g| = 1.
pub(super) fn lobe_distance_squared(g: f64, cos_theta: f64) -> f64 {
    let nearest = 1.0 - g.abs();
    nearest * nearest + 2.0 * g.abs() * (1.0 - cos_theta.copysign(cos_theta * g))
}

/// The deflection at m in [0, 1] of the parametrisation cos = 2 m (1 + g - g m) - 1, in which
/// sqrt(1 + g² - 2 g cos) = 1 + g - 2 g m.
pub(super) fn deflection(g: f64, m: f64, one_minus_m: f64) -> Deflection {
    Deflection {
        one_minus_cos: 2.0 * one_minus_m * (one_minus_m + m * (1.0 - g)),
        one_plus_cos: 2.0 * m * (1.0 + g * one_minus_m),
    }
}
