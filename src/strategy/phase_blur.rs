//! Phase functions that photons can bear.
//!
//! A photon weighs the phase function at its own direction. Where that function is very peaked, as
//! in fog of droplets, few photons that happen to fly at the eye carry nearly all of the light and
//! show as bright spots. Where rays gather photons, they bear the smoother part of a function that
//! has two, or what is left of a lobe that its tip is cut from, and rays follow what peak or tip
//! scatters. Elsewhere photons' light is scattered by a
//! function that is blurred a little, the less the more photons there are: what a gather radius is
//! in space. Light that is found by sampling lights directly, and the photons' own flights, keep the
//! function as it is.

use crate::medium::{Medium, Phase};
use crate::scene::Scene;

/// How concentrated a phase function may be for [`USUAL`] photons: Henyey-Greenstein functions up
/// to g = .93 are.
const MOST: f64 = 100.0;

/// See [`MOST`].
const USUAL: f64 = 1e6;

/// How concentrated it may be for any number of photons.
const LEAST: f64 = 5.0;

/// How concentrated a lobe is that rays follow: Henyey-Greenstein lobes above g = .78 are.
const PEAKED: f64 = 10.0;

/// How concentrated the body of such a lobe is, below its tip, that photons bear.
const SMOOTH: f64 = 5.0;

/// Halvings by which the blur is found.
const HALVINGS: u32 = 40;

/// The phase function of each medium of `scene`, blurred for this number of photons. With a blur of
/// solid angle w the variance is as 1 / (w photons) and the squared bias as w²: w falls with the
/// third root of the number, and the concentration goes as 1 / w².
pub fn phases(scene: &Scene, photons: u64) -> Vec<Phase> {
    let most = (MOST * (photons as f64 / USUAL).powf(2.0 / 3.0)).max(LEAST);
    scene.media.iter().map(|medium| bearable(&medium.phase, most)).collect()
}

/// How a medium scatters the light of photons that rays gather.
#[derive(Debug, Clone, Copy)]
pub struct PhaseSplit {
    /// By this function.
    pub phase: Phase,
    /// The share of the light that it scatters.
    pub share: f64,
    /// By this the rest: a peak, whose light rays find that it deflects.
    pub peak: Option<Phase>,
}

impl PhaseSplit {
    /// All by one function.
    const fn by(phase: Phase) -> Self {
        Self { phase, share: 1.0, peak: None }
    }
}

/// How each medium of `scene` scatters photons: by its function in `blurred`, or in two parts where
/// rays may follow peaks (`follows`) and there is one. A lobe by itself is cut in two only in media
/// that the eye is inside of (`is_round_eye`): what comes out of others has spread.
pub fn scatterings(
    scene: &Scene,
    blurred: &[Phase],
    follows: bool,
    is_round_eye: impl Fn(&Medium) -> bool,
) -> Vec<PhaseSplit> {
    let split = |(medium, blurred): (&Medium, &Phase)| {
        let smooth = is_round_eye(medium).then_some(SMOOTH);
        let split = medium.phase.split(PEAKED, smooth).filter(|_| follows);
        split.map_or(PhaseSplit::by(*blurred), |split| PhaseSplit {
            phase: split.rest,
            share: 1.0 - split.share,
            peak: Some(split.peak),
        })
    };
    scene.media.iter().zip(blurred).map(split).collect()
}

fn bearable(phase: &Phase, most: f64) -> Phase {
    if phase.concentration() <= most {
        return *phase;
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..HALVINGS {
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
        assert_eq!(bearable(&smooth, MOST), smooth);
        assert_eq!(bearable(&Phase::RAYLEIGH, LEAST), Phase::RAYLEIGH);
        let fog = Phase::fog(20.0).unwrap();
        let blurred = bearable(&fog, MOST);
        assert!((blurred.concentration() / MOST - 1.0).abs() < 1e-3);
        assert!(blurred.mean_cosine() > 0.95 * fog.mean_cosine());
    }
}
