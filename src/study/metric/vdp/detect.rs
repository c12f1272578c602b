//! Masking and detection in one band (Daly 1993, "Masking function", "Psychometric function",
//! "Probability summation"). Contrasts are in units of their threshold.

/// Constants of the masking function, k1 = W^(1 - 1/(1 - Q)) and k2 = W^(1/(1 - Q)) with W = 6 and
/// Q = 0.7: at the slope Q the threshold rises as contrast^Q from the threshold on.
const K1: f64 = 0.015_286_700_226; // 6^(-7/3)
const K2: f64 = 392.498_048; // 6^(10/3)

/// Detection in one band.
pub(super) struct Detector {
    slope: f64,
}

impl Detector {
    /// A band whose masking grows by the slope s, 0.65 to 1.
    pub(super) fn new(slope: f64) -> Self {
        Self { slope }
    }

    /// What the band adds to the evidence of a difference, from the contrasts that the reference
    /// and the test have in it: (difference / threshold)^beta, the exponent of the psychometric
    /// function, with beta = 3.5. Both pictures mask (mutual masking): the lower threshold holds.
    pub(super) fn evidence(&self, reference: f64, test: f64) -> f64 {
        let mask = reference.abs().min(test.abs()); // elevation grows with contrast
        let difference = (test - reference).abs() / self.elevation(mask);
        difference.powi(3) * difference.sqrt()
    }

    /// Threshold elevation by a mask, T_e = (1 + (k1 (k2 m)^s)^b)^(1/b) with b = 4.
    fn elevation(&self, mask: f64) -> f64 {
        let rise = K1 * (K2 * mask).powf(self.slope);
        (1.0 + rise.powi(4)).sqrt().sqrt()
    }
}

/// The probability of detection from the evidence of all bands: 1 - prod(1 - P_band) with P_band =
/// 1 - 2^-evidence, which is 1/2 at the threshold. Below 1e-16 it is 0.
pub(super) fn probability(evidence: f64) -> f64 {
    1.0 - (-evidence).exp2()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_are_powers_of_w() {
        assert!((K1 / 6.0_f64.powf(-7.0 / 3.0) - 1.0).abs() < 1e-8);
        assert!((K2 / 6.0_f64.powf(10.0 / 3.0) - 1.0).abs() < 1e-8);
    }

    #[test]
    fn a_difference_at_threshold_is_seen_by_half() {
        let detector = Detector::new(1.0);
        assert_eq!(probability(detector.evidence(0.0, 1.0)), 0.5);
        assert_eq!(probability(detector.evidence(0.0, -1.0)), 0.5);
        assert_eq!(probability(detector.evidence(7.0, 7.0)), 0.0);
        assert!(probability(detector.evidence(0.0, 2.0)) > 0.99);
        assert!(probability(detector.evidence(0.0, 0.5)) < 0.07);
    }

    #[test]
    fn learnt_masks_raise_the_threshold_by_their_contrast_to_the_slope() {
        let elevation = Detector::new(0.7).elevation(100.0);
        assert!((elevation - 100.0_f64.powf(0.7)).abs() < 0.01, "{elevation}");
        assert_eq!(Detector::new(0.7).elevation(0.0), 1.0);
        assert!(Detector::new(1.0).elevation(5.0) > Detector::new(0.7).elevation(5.0));
    }

    #[test]
    fn masking_is_mutual() {
        let detector = Detector::new(0.8);
        assert_eq!(detector.evidence(3.0, 5.0), detector.evidence(5.0, 3.0));
        assert!(detector.evidence(0.0, 2.0) > detector.evidence(20.0, 22.0));
    }
}
