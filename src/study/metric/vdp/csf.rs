//! The contrast sensitivity function (Daly 1993, "Contrast sensitivity function").

use super::super::Display;

/// Sensitivity at the peak.
const PEAK: f64 = 250.0;
/// Frequency scale, epsilon.
const SCALE: f64 = 0.9;
/// Sensitivity across the diagonals against that along the axes, ob.
const OBLIQUE: f64 = 0.78;

/// A picture on a display, as the eye has it before it.
pub(super) struct Viewing {
    pixels_per_degree: f64,
    /// Adaptation level, cd/m².
    luminance: f64,
    /// Size of the picture in square degrees, i².
    area: f64,
    /// Change of resolution by accommodation, r_a.
    accommodation: f64,
}

impl Viewing {
    /// A picture of `width` x `height` pixels with the eye adapted to `luminance` in cd/m².
    pub(super) fn new(display: &Display, luminance: f64, width: usize, height: usize) -> Self {
        let pixels_per_degree = display.pixels_per_degree();
        Self {
            pixels_per_degree,
            luminance,
            area: (width * height) as f64 / pixels_per_degree.powi(2),
            accommodation: 0.856 * display.distance.powf(0.14),
        }
    }

    /// Sensitivity, the reciprocal of the contrast at threshold, to a frequency in cycles a pixel:
    /// P min(S1(rho / (r_a r_theta)), S1(rho)), looked at straight (eccentricity 0).
    pub(super) fn sensitivity(&self, fx: f64, fy: f64) -> f64 {
        let rho = fx.hypot(fy) * self.pixels_per_degree;
        if rho == 0.0 {
            return 0.0;
        }
        // cos 4 theta by the double angle, twice.
        let cos_2 = (fx * fx - fy * fy) / (fx * fx + fy * fy);
        let cos_4 = 2.0 * cos_2 * cos_2 - 1.0;
        let orientation = 0.5 * ((1.0 - OBLIQUE) * cos_4 + 1.0 + OBLIQUE);
        let turned = rho / (self.accommodation * orientation);
        PEAK * self.s1(rho).min(self.s1(turned))
    }

    /// S1(rho, l, i²), normalised to about 1 at its peak; rho in cycles a degree.
    fn s1(&self, rho: f64) -> f64 {
        let a = 0.801 * (1.0 + 0.7 / self.luminance).powf(-0.2);
        let b = 0.3 * (1.0 + 100.0 / self.luminance).powf(0.15);
        let size = ((3.23 * (rho * rho * self.area).powf(-0.3)).powi(5) + 1.0).powf(-0.2);
        let decay = (-b * SCALE * rho).exp();
        size * a * SCALE * rho * decay * (1.0 + 0.06 / decay).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn viewing(luminance: f64) -> Viewing {
        Viewing::new(&Display::default(), luminance, 512, 512)
    }

    /// Sensitivity to a grating of `rho` cycles a degree, along x or on the diagonal.
    fn at(viewing: &Viewing, rho: f64, diagonal: bool) -> f64 {
        let f = rho / viewing.pixels_per_degree;
        let half = f / 2.0_f64.sqrt();
        if diagonal { viewing.sensitivity(half, half) } else { viewing.sensitivity(f, 0.0) }
    }

    #[test]
    fn it_is_a_band_pass_that_peaks_at_a_few_cycles_a_degree() {
        let v = viewing(80.0);
        let peak = (1..400)
            .map(|i| f64::from(i) * 0.1)
            .max_by(|&a, &b| at(&v, a, false).total_cmp(&at(&v, b, false)));
        assert!((2.0..6.0).contains(&peak.unwrap()), "{peak:?}");
        assert!((100.0..300.0).contains(&at(&v, peak.unwrap(), false)));
        assert_eq!(at(&v, 0.0, false), 0.0);
        assert!(at(&v, 60.0, false) < 1.0, "nothing is seen at 60 cycles a degree");
    }

    #[test]
    fn a_value_by_hand() {
        // l = 100, rho = 4, i² = 165.87: A = 0.801 (1.007)^-0.2 = 0.79988, B = 0.3 2^0.15 =
        // 0.33287, first factor 0.99997, decay exp(-1.19833) = 0.30170, root sqrt(1.19887) =
        // 1.09493. S1(4) = 0.79987 x 3.6 x 0.30170 x 1.09493 = 0.95121; r_a = 0.79692 takes 4 to
        // 5.0193, where S1 = 0.90396.
        let v = viewing(100.0);
        assert!((v.s1(4.0) - 0.9512).abs() < 1e-3, "{}", v.s1(4.0));
        assert!((at(&v, 4.0, false) / 250.0 - 0.9040).abs() < 2e-3);
    }

    #[test]
    fn dim_fields_and_diagonals_are_seen_worse() {
        assert!(at(&viewing(1.0), 4.0, false) < at(&viewing(80.0), 4.0, false));
        assert!(at(&viewing(80.0), 16.0, true) < 0.8 * at(&viewing(80.0), 16.0, false));
    }
}
