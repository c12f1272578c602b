//! Moments of radiance over directions, and what a phase function makes of them.
//!
//! With M_l(w) the mean over all directions w' of radiance from w' times P_l(w . w'), light scattered
//! toward w is the sum over l of (2 l + 1) x_l M_l(w), where x_l are the phase function's Legendre
//! coefficients (Ishimaru 1978, "Wave Propagation and Scattering in Random Media", section 9-1). The
//! moments up to the second degree are held as components of tensors. What is beyond them is
//! estimated as if light had the course of a Henyey-Greenstein lobe along its flux, for which
//! M_l = M_0 f^l P_l with f the length of the flux over the fluence: right for a beam as for light
//! from all sides.

use glam::DVec3;

use crate::math::Spectrum;

/// Moments up to the first degree.
pub(super) const FIRST: usize = 4;

/// Moments up to the second degree.
pub(super) const MOST: usize = 9;

/// Flux over fluence up to which light counts as spread over directions at all.
const SPREAD: f64 = 0.995;

/// The moments of light that flies along a unit vector: its fluence, its flux, and five components
/// of the second without trace: xx, yy, xy, xz, yz.
pub(super) fn of_flight(along: DVec3) -> [f64; MOST] {
    let DVec3 { x, y, z } = along;
    let third = 1.0 / 3.0;
    [1.0, x, y, z, x * x - third, y * y - third, x * y, x * z, y * z]
}

/// Light scattered into one direction by a phase function, by its moments.
pub(super) struct Scattered {
    /// What each moment counts.
    weights: [f64; MOST],
    toward: DVec3,
    /// Mean cosine of the Henyey-Greenstein function that has the third Legendre coefficient.
    beyond: f64,
}

impl Scattered {
    /// Into the unit direction `toward`, by the phase function with these Legendre coefficients of
    /// degrees 1 to 3.
    pub fn new(toward: DVec3, legendre: [f64; 3]) -> Self {
        let DVec3 { x, y, z } = toward;
        let first = (toward * (3.0 * legendre[0])).to_array();
        let second = [x * x - z * z, y * y - z * z, 2.0 * x * y, 2.0 * x * z, 2.0 * y * z];
        let mut weights = [1.0; MOST];
        weights[1..FIRST].copy_from_slice(&first);
        weights[FIRST..].copy_from_slice(&second.map(|m| 7.5 * legendre[1] * m));
        Self { weights, toward, beyond: legendre[2].cbrt() }
    }

    /// Of these moments, as many as are held. Noise may leave it below 0: only where it is brought to
    /// 0 after it is averaged it keeps its mean.
    pub fn of<S: Spectrum>(&self, moments: &[S]) -> S {
        let sum = |light: S, (moment, weight): (&S, &f64)| light + *moment * *weight;
        let light = moments.iter().zip(&self.weights).fold(S::ZERO, sum);
        let rest = if moments.len() == MOST { self.rest(moments) } else { 0.0 };
        light + moments[0] * rest
    }

    /// What is beyond the second degree, over the fluence.
    fn rest<S: Spectrum>(&self, moments: &[S]) -> f64 {
        let [fluence, x, y, z] = [0, 1, 2, 3].map(|i| moments[i].element_sum());
        let flux = DVec3::new(x, y, z);
        let length = flux.length();
        if !(length > 0.0 && fluence > 0.0) {
            return 0.0;
        }
        let cosine = flux.dot(self.toward) / length;
        let g = self.beyond * (length / fluence).min(SPREAD);
        let lobe = (1.0 - g * g) / (1.0 + g * g - 2.0 * g * cosine).powf(1.5);
        lobe - 1.0 - 3.0 * g * cosine - 2.5 * g * g * (3.0 * cosine * cosine - 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::medium::Phase;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    fn direction() -> impl Strategy<Value = DVec3> {
        (-1.0..1.0f64, 0.0..6.3f64).prop_map(|(z, angle)| {
            let across = (1.0 - z * z).sqrt();
            DVec3::new(across * angle.cos(), across * angle.sin(), z)
        })
    }

    fn henyey_greenstein(g: f64) -> (Phase, [f64; 3]) {
        (Phase::henyey_greenstein(g).unwrap(), [g, g * g, g * g * g])
    }

    proptest! {
        #[test]
        fn a_beam_is_scattered_as_the_phase_function_says(
            along in direction(), toward in direction(), g in -0.8..0.8f64
        ) {
            let (phase, legendre) = henyey_greenstein(g);
            let found = Scattered::new(toward, legendre).of(&of_flight(along));
            let right = 4.0 * PI * phase.eval(along.dot(toward));
            prop_assert!((found - right).abs() < 0.05 * right + 0.1, "{found} for {right}");
        }

        #[test]
        fn light_of_the_second_degree_is_scattered_exactly(
            a in direction(), toward in direction(), g in -0.9..0.9f64, share in 0.0..1.0f64
        ) {
            // A beam there and back has no flux, and every even moment of a single one.
            let there: [f64; MOST] = of_flight(a);
            let back: [f64; MOST] = of_flight(-a);
            let even = 1.0 - share;
            let moments: Vec<f64> = (0..MOST)
                .map(|i| share * 0.5 * (there[i] + back[i]) + if i == 0 { even } else { 0.0 })
                .collect();
            let found = Scattered::new(toward, [g, g * g, 0.0]).of(&moments);
            let cosine = a.dot(toward);
            let right = 1.0 + share * 2.5 * g * g * (3.0 * cosine * cosine - 1.0);
            prop_assert!((found - right).abs() < 1e-9, "{found} for {right}");
        }

        #[test]
        fn four_moments_are_those_of_the_first_degree(
            along in direction(), toward in direction(), g in -0.9..0.9f64
        ) {
            let (_, legendre) = henyey_greenstein(g);
            let found = Scattered::new(toward, legendre).of(&of_flight(along)[..FIRST]);
            let right = 1.0 + 3.0 * g * along.dot(toward);
            prop_assert!((found - right).abs() < 1e-9, "{found} for {right}");
        }
    }
}
