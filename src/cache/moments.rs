//! Moments of radiance over directions, and the light that a phase function scatters of them.
//!
//! With M_l(w) the mean over all directions w' of radiance from w' times P_l(w . w'), light scattered
//! toward w is the sum over l of (2 l + 1) x_l M_l(w), where x_l are the phase function's Legendre
//! coefficients (Ishimaru 1978, "Wave Propagation and Scattering in Random Media", section 9-1). The
//! moments up to the second degree are held as components of tensors without trace.
//!
//! The moments beyond need a closure. This one takes radiance as a mixture: a share p of the fluence
//! as a Henyey-Greenstein lobe of mean cosine f along the flux, the rest isotropic, so that
//! M_l = M_0 p f^l P_l; the first two moments along the flux give p and f. It holds for isotropic
//! light, for a beam, and for a mixture of both. (Levermore 1984, "Relating Eddington Factors to Flux
//! Limiters", compares such closures for the second moment.) Where the second moment is less than that of a
//! single lobe, as near a surface where light comes from one side, the higher moments are scaled
//! down with it.

use glam::DVec3;

use crate::math::Spectrum;

/// Number of moments up to the first degree.
///
/// Unit: count. Definition: one of degree 0 and three of degree 1.
pub(super) const FIRST: usize = 4;

/// Number of moments up to the second degree.
///
/// Unit: count. Definition: those and five of degree 2.
pub(super) const MOST: usize = 9;

/// 2 l + 1 for the second degree.
///
/// Unit: none. Definition: the number of its moments.
const SECOND_DEGREE: f64 = 5.0;

/// Largest mean cosine of the closure's lobe: flux over fluence of a beam is 1, for which the lobe is
/// singular.
///
/// Unit: none. Limit: on the closure's lobe near its singularity.
const MAX_COSINE: f64 = 0.995;

/// The moments of light that flies along a unit vector: its fluence, its flux, and five components
/// of the second without trace: xx, yy, xy, xz, yz.
pub(super) fn of_flight(along: DVec3) -> [f64; MOST] {
    let DVec3 { x, y, z } = along;
    let third = 1.0 / 3.0;
    [1.0, x, y, z, x * x - third, y * y - third, x * y, x * z, y * z]
}

/// Weights of the components of the second degree in 2/3 M_2 along a unit vector.
fn second_along(along: DVec3) -> [f64; MOST - FIRST] {
    let DVec3 { x, y, z } = along;
    [x * x - z * z, y * y - z * z, 2.0 * x * y, 2.0 * x * z, 2.0 * y * z]
}

/// Light that a phase function scatters into one direction, from the moments of radiance.
pub(super) struct ScatteredMoments {
    /// Weight of each moment.
    weights: [f64; MOST],
    wo: DVec3,
    /// Mean cosine of the Henyey-Greenstein function that has the third Legendre coefficient.
    beyond: f64,
}

impl ScatteredMoments {
    /// Into the unit direction `wo`, by the phase function with these Legendre coefficients of
    /// degrees 1 to 3.
    pub fn new(wo: DVec3, legendre: [f64; 3]) -> Self {
        let first = (wo * (3.0 * legendre[0])).to_array();
        let second = second_along(wo).map(|part| 3.0 / 2.0 * SECOND_DEGREE * legendre[1] * part);
        let mut weights = [1.0; MOST];
        weights[1..FIRST].copy_from_slice(&first);
        weights[FIRST..].copy_from_slice(&second);
        Self { weights, wo, beyond: legendre[2].cbrt() }
    }

    /// Scattered light of these moments, as many as are held. Noise may make it negative; it is
    /// unbiased only if it is clamped after averaging, not before.
    pub fn of<S: Spectrum>(&self, moments: &[S]) -> S {
        let sum = |light: S, (moment, weight): (&S, &f64)| light + *moment * *weight;
        let light = moments.iter().zip(&self.weights).fold(S::ZERO, sum);
        let rest = if moments.len() == MOST { self.beyond_second(moments) } else { 0.0 };
        light + moments[0] * rest
    }

    /// The closure: light of the moments beyond the second degree, over the fluence.
    fn beyond_second<S: Spectrum>(&self, moments: &[S]) -> f64 {
        let of = |i: usize| moments[i].element_sum();
        let (fluence, flux) = (of(0), DVec3::new(of(1), of(2), of(3)));
        let length = flux.length();
        if !(length > 0.0 && fluence > 0.0) {
            return 0.0;
        }
        let along = flux / length;
        let first = (length / fluence).min(MAX_COSINE);
        let parts = second_along(along).into_iter().zip(FIRST..);
        let second = 3.0 / 2.0 * parts.map(|(part, i)| part * of(i)).sum::<f64>() / fluence;
        let spread = (second / first).clamp(first, MAX_COSINE);
        let fade = (second / (first * first)).clamp(0.0, 1.0);
        let (share, g) = (fade * first / spread, self.beyond * spread);
        let cosine = along.dot(self.wo);
        let lobe = (1.0 - g * g) / (1.0 + g * g - 2.0 * g * cosine).powf(3.0 / 2.0);
        let held =
            1.0 + 3.0 * g * cosine + 0.5 * SECOND_DEGREE * g * g * (3.0 * cosine * cosine - 1.0);
        share * (lobe - held)
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
            let found = ScatteredMoments::new(toward, legendre).of(&of_flight(along));
            let right = 4.0 * PI * phase.eval(along.dot(toward));
            prop_assert!((found - right).abs() < 0.05 * right + 0.1, "{found} for {right}");
        }

        #[test]
        fn a_lobe_in_even_light_is_scattered_exactly(
            along in direction(), toward in direction(), g in -0.9..0.9f64,
            f in 0.1..0.99f64, share in 0.01..1.0f64
        ) {
            let beam = of_flight(along);
            let of = |i| if i == 0 { 1.0 } else { share * f * if i < FIRST { 1.0 } else { f } };
            let moments: Vec<f64> = (0..MOST).map(|i| of(i) * beam[i]).collect();
            let found = ScatteredMoments::new(toward, [g, g * g, g * g * g]).of(&moments);
            let lobe = Phase::henyey_greenstein(g * f).unwrap();
            let right = 1.0 - share + share * 4.0 * PI * lobe.eval(along.dot(toward));
            prop_assert!((found - right).abs() < 1e-9 * (1.0 + right), "{found} for {right}");
        }

        #[test]
        fn of_light_from_one_side_nothing_is_told_beyond_its_moments(
            along in direction(), toward in direction(), g in -0.9..0.9f64
        ) {
            // Evenly from a hemisphere: the flux is half of the fluence, the second moment 0.
            let beam = of_flight(along);
            let moments = [1.0, 0.5 * beam[1], 0.5 * beam[2], 0.5 * beam[3], 0.0, 0.0, 0.0, 0.0, 0.0];
            let found = ScatteredMoments::new(toward, [g, g * g, g * g * g]).of(&moments);
            let right = 1.0 + 1.5 * g * along.dot(toward);
            prop_assert!((found - right).abs() < 1e-9, "{found} for {right}");
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
            let found = ScatteredMoments::new(toward, [g, g * g, 0.0]).of(&moments);
            let cosine = a.dot(toward);
            let right = 1.0 + share * 2.5 * g * g * (3.0 * cosine * cosine - 1.0);
            prop_assert!((found - right).abs() < 1e-9, "{found} for {right}");
        }

        #[test]
        fn four_moments_are_those_of_the_first_degree(
            along in direction(), toward in direction(), g in -0.9..0.9f64
        ) {
            let (_, legendre) = henyey_greenstein(g);
            let found = ScatteredMoments::new(toward, legendre).of(&of_flight(along)[..FIRST]);
            let right = 1.0 + 3.0 * g * along.dot(toward);
            prop_assert!((found - right).abs() < 1e-9, "{found} for {right}");
        }
    }
}
