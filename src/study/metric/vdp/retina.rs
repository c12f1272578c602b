//! The amplitude nonlinearity (Daly 1993, "Amplitude nonlinearity"): each receptor adapts to the
//! luminance of its own pixel.

/// Constants of the response for luminance in cd/m².
const C1: f64 = 12.6;
const B: f64 = 0.63;

/// Response to `luminance` in cd/m², 0 to 1: R / R_max = L / (L + (c1 L)^b).
pub(super) fn response(luminance: f64) -> f64 {
    1.0 / (1.0 + saturation(luminance))
}

/// dR / d ln L: what a small contrast on a field of `luminance` changes the response by.
pub(super) fn contrast_slope(luminance: f64) -> f64 {
    let u = saturation(luminance);
    (1.0 - B) * u / (1.0 + u).powi(2)
}

/// (c1 L)^b / L.
fn saturation(luminance: f64) -> f64 {
    C1.powf(B) * luminance.powf(B - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_response_is_dalys() {
        for l in [0.2, 5.0, 80.0, 1000.0] {
            assert!((response(l) - l / (l + (12.6 * l).powf(0.63))).abs() < 1e-15);
        }
    }

    #[test]
    fn the_slope_is_the_derivative() {
        for l in [0.2_f64, 5.0, 80.0, 1000.0] {
            let h = 1e-5_f64;
            let numeric = (response(l * h.exp()) - response(l * (-h).exp())) / (2.0 * h);
            assert!((contrast_slope(l) / numeric - 1.0).abs() < 1e-8);
        }
    }
}
