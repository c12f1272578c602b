//! Phase functions of photons, blurred for their number: path-space regularization (Kaplanyan and
//! Dachsbacher 2013, "Path Space Regularization for Holistic and Robust Light Transport").
//!
//! A photon that is gathered is weighed by the phase function at its one direction. Where that function
//! is very peaked, as in fog of droplets, few photons carry nearly all of the light and show as bright
//! spots. Two ways avoid this. Rays that gather photons use the smoother part of a function of two
//! lobes, or a lobe without its tip; rays deflected by the peak or tip find the rest. Elsewhere the
//! function is blurred, the less the more photons there are: what a gather radius is in space. Light
//! that is sampled directly and the photons' own flights keep the exact function.

use crate::medium::{Medium, Phase};
use crate::scene::Scene;

/// Largest [`concentration`](Phase::concentration) of a phase function for [`REFERENCE_PHOTONS`]
/// photons: that of Henyey-Greenstein with g = 0.93.
///
/// Unit: none. Bench: `cargo bench --bench results -- --only strategy`.
const MAX_CONCENTRATION: f64 = 100.0;

/// Photons for which [`MAX_CONCENTRATION`] holds.
///
/// Unit: count. Definition: the number for which the largest concentration is stated.
const REFERENCE_PHOTONS: f64 = 1e6;

/// Concentration up to which a phase function is not blurred, however few photons there are.
///
/// Unit: none. Bench: `cargo bench --bench results -- --only strategy`.
const MIN_CONCENTRATION: f64 = 5.0;

/// Concentration above which a lobe is followed by rays: that of Henyey-Greenstein with g = 0.78.
///
/// Unit: none. Derivation: twice that of the body, so that a tip is worth a ray of its own.
const PEAK_CONCENTRATION: f64 = 10.0;

/// Concentration of the body that is left to photons when the tip of such a lobe is cut off.
///
/// Unit: none. Derivation: what is never blurred needs no ray to follow it.
const BODY_CONCENTRATION: f64 = 5.0;

/// Halvings of the interval in which the blur is searched: to the last bits of an f64.
///
/// Unit: count. Derivation: each halves an interval of 1, and 2^-40 is below what a phase function
/// shows.
const BISECTIONS: u32 = 40;

/// The phase function of each medium of `scene`, blurred for this number of photons. With a blur of
/// solid angle w variance is as 1 / (w photons) and squared bias as w²: w is as photons^(-1/3), and
/// the concentration as 1 / w².
pub fn phases(scene: &Scene, photons: u64) -> Vec<Phase> {
    let growth = (photons as f64 / REFERENCE_PHOTONS).powf(2.0 / 3.0);
    let most = (MAX_CONCENTRATION * growth).max(MIN_CONCENTRATION);
    scene.media.iter().map(|medium| blurred(&medium.phase, most)).collect()
}

/// A phase function in two parts: one for photons that rays gather, one for rays to follow.
#[derive(Debug, Clone, Copy)]
pub struct PhaseSplit {
    /// Scatters the light of gathered photons.
    pub phase: Phase,
    /// Share of the scattered light that is left to it.
    pub share: f64,
    /// Scatters the rest: a peak, whose light is found by rays that it deflects.
    pub peak: Option<Phase>,
}

impl PhaseSplit {
    /// One part, `phase`.
    const fn whole(phase: Phase) -> Self {
        Self { phase, share: 1.0, peak: None }
    }
}

/// The split of each medium of `scene`: the whole function in `blurred`, or two parts where rays
/// follow peaks (`follows`) and there is one. The tip of a single lobe is cut off only in media that
/// the camera is in or near (`is_near`): light that leaves others has spread.
pub fn scatterings(
    scene: &Scene,
    blurred: &[Phase],
    follows: bool,
    is_near: impl Fn(&Medium) -> bool,
) -> Vec<PhaseSplit> {
    let split = |(medium, blurred): (&Medium, &Phase)| {
        let body = is_near(medium).then_some(BODY_CONCENTRATION);
        let split = medium.phase.split(PEAK_CONCENTRATION, body).filter(|_| follows);
        split.map_or(PhaseSplit::whole(*blurred), |split| PhaseSplit {
            phase: split.rest,
            share: 1.0 - split.share,
            peak: Some(split.peak),
        })
    };
    scene.media.iter().zip(blurred).map(split).collect()
}

/// Whether rays that gather photons follow a peak of `phase`, where they can.
pub fn is_peaked(phase: &Phase) -> bool {
    phase.split(PEAK_CONCENTRATION, Some(BODY_CONCENTRATION)).is_some()
}

/// `phase` convolved with the narrowest Henyey-Greenstein kernel that brings its concentration down to
/// `most`.
fn blurred(phase: &Phase, most: f64) -> Phase {
    if phase.concentration() <= most {
        return *phase;
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        if phase.convolved(middle).concentration() <= most { low = middle } else { high = middle }
    }
    phase.convolved(low)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_peaked_functions_are_blurred() {
        let smooth = Phase::henyey_greenstein(0.9).unwrap();
        assert_eq!(blurred(&smooth, MAX_CONCENTRATION), smooth);
        assert_eq!(blurred(&Phase::RAYLEIGH, MIN_CONCENTRATION), Phase::RAYLEIGH);
        let fog = Phase::fog(20.0).unwrap();
        let result = blurred(&fog, MAX_CONCENTRATION);
        assert!((result.concentration() / MAX_CONCENTRATION - 1.0).abs() < 1e-3);
        assert!(result.mean_cosine() > 0.95 * fog.mean_cosine());
    }
}
