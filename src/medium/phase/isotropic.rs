//! The same in all directions.

use super::Deflection;
use crate::math::warp;

/// The isotropic phase function, 1 / (4 pi).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Isotropic;

impl Isotropic {
    pub(super) const fn eval(self) -> f64 {
        warp::uniform_sphere_pdf()
    }

    pub(super) fn sample(self, u: f64) -> Deflection {
        Deflection { one_minus_cos: 2.0 * (1.0 - u), one_plus_cos: 2.0 * u }
    }
}
