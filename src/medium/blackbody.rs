//! What a hot body glows with.

use glam::DMat3;

use crate::math::{Rgb, luminance};

/// First radiation constant for radiance, 2 h c², in W nm⁴ / (m² sr): the wavelength enters in
/// nanometres, the result counts per nanometre.
const C1: f64 = 2.0 * PLANCK * LIGHT_SPEED * LIGHT_SPEED * 1e36;
/// Second radiation constant, h c / k, in nm K.
const C2: f64 = PLANCK * LIGHT_SPEED / BOLTZMANN * 1e9;
const PLANCK: f64 = 6.626_070_15e-34;
const BOLTZMANN: f64 = 1.380_649e-23;
const LIGHT_SPEED: f64 = 299_792_458.0;

/// The visible range in nanometres and the step of the trapezoidal rule over it.
const WAVELENGTHS: std::ops::RangeInclusive<u32> = 360..=830;
const WAVELENGTH_STEP: f64 = 1.0;

/// Linear Rec.709 from XYZ (IEC 61966-2-1, white D65), by columns.
const REC709_FROM_XYZ: DMat3 = DMat3::from_cols_array(&[
    3.240_454_2,
    -0.969_266_0,
    0.055_643_4,
    -1.537_138_5,
    1.876_010_8,
    -0.204_025_9,
    -0.498_531_4,
    0.041_556_0,
    1.057_225_2,
]);

/// Above this temperature the spectrum in the visible range no longer changes its shape.
const HOTTEST: f64 = 1e9;

/// Radiance of a blackbody as linear Rec.709, in W/(m² sr).
///
/// X, Y and Z are the integrals over wavelength of Planck's spectral radiance times the CIE 1931
/// 2° colour matching functions (the fits of Wyman, Sloan and Shirley 2013, "Simple Analytic
/// Approximations to the CIE XYZ Color Matching Functions", section 2.2), without the 683 lm/W:
/// the luminance of the result before clamping is the integral of B ȳ. Colours outside Rec.709, as
/// all under about 1900 K are, have their negative channels set to 0. Nothing, negative
/// temperatures and NaN glow with 0; above 1e9 K the radiance is that of 1e9 K.
pub fn blackbody_radiance(kelvin: f64) -> Rgb {
    unclamped_radiance(kelvin).max(Rgb::ZERO)
}

/// Colour of a blackbody, of luminance 1; black where it gives hardly any light.
pub fn blackbody_color(kelvin: f64) -> Rgb {
    let radiance = blackbody_radiance(kelvin);
    let brightness = luminance(radiance);
    if brightness >= f64::MIN_POSITIVE { radiance / brightness } else { Rgb::ZERO }
}

fn unclamped_radiance(kelvin: f64) -> Rgb {
    if kelvin.is_nan() || kelvin <= 0.0 {
        return Rgb::ZERO;
    }
    let kelvin = kelvin.min(HOTTEST);
    let xyz: Rgb = WAVELENGTHS
        .map(|nanometres| {
            let w = f64::from(nanometres);
            matching_functions(w) * spectral_radiance(w, kelvin)
        })
        .sum();
    REC709_FROM_XYZ * xyz * WAVELENGTH_STEP
}

/// Planck's law, W/(m² sr nm), for a wavelength in nanometres.
fn spectral_radiance(wavelength: f64, kelvin: f64) -> f64 {
    C1 / (wavelength.powi(5) * (C2 / (wavelength * kelvin)).exp_m1())
}

/// The fits to the CIE 1931 2° functions x̄, ȳ, z̄ at a wavelength in nanometres.
fn matching_functions(wavelength: f64) -> Rgb {
    let lobe = |height: f64, peak: f64, below: f64, above: f64| {
        let t = (wavelength - peak) * if wavelength < peak { below } else { above };
        height * (-0.5 * t * t).exp()
    };
    Rgb::new(
        lobe(0.362, 442.0, 0.0624, 0.0374)
            + lobe(1.056, 599.8, 0.0264, 0.0323)
            + lobe(-0.065, 501.1, 0.0490, 0.0382),
        lobe(0.821, 568.8, 0.0213, 0.0247) + lobe(0.286, 530.9, 0.0613, 0.0322),
        lobe(1.217, 437.0, 0.0845, 0.0278) + lobe(0.681, 459.0, 0.0385, 0.0725),
    )
}

/// [`blackbody_radiance`] from a table, for use per sample: within 1e-3 of the brightest channel
/// from 300 to 1e9 K, above which radiance stays the same. What is colder glows below
/// 1e-18 W/(m² sr) and counts as dark.
#[derive(Debug, Clone)]
pub struct Blackbody {
    nodes: Vec<Node>,
}

/// Logarithm of the sum of magnitudes, which is nearly linear between nodes, and the colour.
#[derive(Debug, Clone, Copy)]
struct Node {
    log_scale: f64,
    color: Rgb,
}

impl Blackbody {
    const COLDEST: f64 = 300.0;
    const HOTTEST: f64 = HOTTEST;
    const INTERVALS: u32 = 4096;

    /// Computes the table.
    pub fn new() -> Self {
        let ratio = (Self::HOTTEST / Self::COLDEST).ln() / f64::from(Self::INTERVALS);
        let nodes = (0..=Self::INTERVALS)
            .map(|i| {
                let rgb = unclamped_radiance(Self::COLDEST * (ratio * f64::from(i)).exp());
                let scale = rgb.abs().element_sum();
                Node { log_scale: scale.ln(), color: rgb / scale }
            })
            .collect();
        Self { nodes }
    }

    /// Radiance at a temperature in kelvin, in W/(m² sr).
    pub fn radiance(&self, kelvin: f64) -> Rgb {
        let place = (kelvin / Self::COLDEST).ln() / (Self::HOTTEST / Self::COLDEST).ln()
            * f64::from(Self::INTERVALS);
        if place < 0.0 {
            return Rgb::ZERO;
        }
        if place.is_nan() || place >= f64::from(Self::INTERVALS) {
            return blackbody_radiance(kelvin);
        }
        let below = place as usize;
        let t = place - below as f64;
        let (a, b) = (self.nodes[below], self.nodes[below + 1]);
        let scale = (a.log_scale + (b.log_scale - a.log_scale) * t).exp();
        (a.color.lerp(b.color, t) * scale).max(Rgb::ZERO)
    }
}

impl Default for Blackbody {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::luminance;

    fn chromaticity(kelvin: f64) -> [f64; 2] {
        let xyz = REC709_FROM_XYZ.inverse() * unclamped_radiance(kelvin);
        [xyz.x / xyz.element_sum(), xyz.y / xyz.element_sum()]
    }

    #[test]
    fn colours_are_those_of_the_planckian_locus() {
        // CIE 15: illuminant A is the blackbody at 2855.5 K; the 6504 K point of the locus is
        // that of Wyszecki and Stiles 1982. The fits of the matching functions are good to 0.005.
        for (kelvin, [x, y]) in [(2855.5, [0.4476, 0.4074]), (6504.0, [0.3135, 0.3236])] {
            let [found_x, found_y] = chromaticity(kelvin);
            assert!((found_x - x).abs() < 0.005, "{kelvin} K: x {found_x} not {x}");
            assert!((found_y - y).abs() < 0.005, "{kelvin} K: y {found_y} not {y}");
        }
    }

    #[test]
    fn hottest_bodies_follow_rayleigh_and_jeans() {
        // Radiance grows as T where h c / (wavelength k T) is small.
        let ratio = luminance(unclamped_radiance(2e8)) / luminance(unclamped_radiance(1e8));
        assert!((ratio - 2.0).abs() < 1e-3, "{ratio}");
    }

    #[test]
    fn extremes_are_finite_and_never_negative() {
        for kelvin in [f64::NEG_INFINITY, -1.0, -0.0, 0.0, 1e-300, 1.0, 30.0, f64::NAN] {
            let rgb = blackbody_radiance(kelvin);
            assert!(rgb.is_finite() && rgb.max_element() < 1e-100, "{kelvin} K: {rgb}");
            assert_eq!(Blackbody::new().radiance(kelvin), Rgb::ZERO, "{kelvin} K");
        }
        let coldest = blackbody_radiance(300.0);
        assert!(coldest.max_element() < 1e-18, "all below may count as dark: {coldest}");
        for kelvin in [1000.0, 1e5, 1e30, f64::INFINITY] {
            let rgb = blackbody_radiance(kelvin);
            assert!(rgb.is_finite() && rgb.min_element() >= 0.0, "{kelvin} K: {rgb}");
        }
    }

    #[test]
    fn table_agrees_with_integration() {
        let table = Blackbody::new();
        for i in 0..2000 {
            let kelvin = 300.0 * (HOTTEST / 300.0).powf((f64::from(i) + 0.37) / 2000.0);
            let (exact, found) = (blackbody_radiance(kelvin), table.radiance(kelvin));
            let error = (found - exact).abs().max_element() / exact.max_element();
            assert!(error < 1e-3, "{kelvin} K: {found} not {exact}");
        }
    }
}
