//! Special functions and published values that cases are held against.

use std::f64::consts::PI;

/// The error function, by its series of positive terms (Abramowitz and Stegun 1964, 7.1.6).
pub(super) fn erf(x: f64) -> f64 {
    let (mut term, mut sum, mut n) = (x, x, 1.0);
    while term.abs() > 1e-17 * sum.abs() {
        term *= 2.0 * x * x / (2.0 * n + 1.0);
        sum += term;
        n += 1.0;
    }
    2.0 / PI.sqrt() * (-x * x).exp() * sum
}

/// Albedo and reflectance of an isotropically scattering half-space for normal incidence,
/// 1 - H(1) sqrt(1 - albedo) (Chandrasekhar 1960, "Radiative Transfer", section 33).
pub(super) const HALF_SPACES: [(f64, f64); 4] =
    [(0.5, 0.115_226), (0.9, 0.414_947), (0.99, 0.752_721), (0.999, 0.912_845)];

/// Distance and fluence round an isotropic point source of 1 W in an endless medium of sigma_t = 1,
/// albedo 0.9 (Case, de Hoffmann and Placzek 1953, the exact solution by transform).
pub(super) const POINT_FLUENCES: [(f64, f64); 3] =
    [(1.0, 0.143_284), (2.0, 0.037_126_4), (5.0, 0.002_915_13)];

/// Radiance scattered once toward the eye from an isotropic light of 1 W/sr in endless fog, at
/// `distance` metres and `angle` radians from the view (Sun, Ramamoorthi, Narasimhan and Nayar 2005,
/// equation 9), by quadrature in the angle at the light, in which the integrand is smooth.
pub(super) fn airlight(sigma_s: f64, sigma_t: f64, distance: f64, angle: f64) -> f64 {
    const STEPS: u32 = 20_000;
    let (height, foot) = (distance * angle.sin(), distance * angle.cos());
    let start = (-foot).atan2(height);
    let width = (0.5 * PI - start) / f64::from(STEPS);
    let integrand = |step: u32| {
        let opening = start + (f64::from(step) + 0.5) * width;
        let way = foot + height * opening.tan() + height / opening.cos();
        (-sigma_t * way).exp()
    };
    let sum: f64 = (0..STEPS).map(integrand).sum();
    sigma_s / (4.0 * PI) / height * sum * width
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn erf_is_that_of_the_tables() {
        for (x, expected) in
            [(0.0, 0.0), (0.5, 0.520_499_877_813_046_5), (-2.0, -0.995_322_265_018_952_7)]
        {
            assert!((erf(x) - expected).abs() < 1e-15, "{x}: {}", erf(x));
        }
        assert!((erf(5.5) - 1.0).abs() < 1e-13);
    }

    #[test]
    fn airlight_is_that_of_another_quadrature() {
        let found = airlight(0.1, 0.1, 10.0, 0.5);
        assert!((found / 8.82222e-4 - 1.0).abs() < 1e-5, "{found}");
    }
}
