//! The rule by which strategies are taken where nothing is asked for or measured.

use crate::medium::Medium;
use crate::scene::{FinalGather, Scene, Strategy};
use crate::transport::is_camera_outside;

use super::kind::Conditions;
use super::possible;

/// Largest ratios of the noise-optimal to the thin width of cells that hold light scattered toward the
/// camera, where moments and where beams are the alternative: noise of finer cells costs less than gathers
/// of photons along every ray.
///
/// Unit: none. Bench: `cargo bench --bench results -- --only strategy`.
const MAX_REFINEMENT: [f64; 2] = [1.4, 2.0];

/// Second Legendre coefficient of a phase function above which final gathers have less error than
/// photons alone.
///
/// Unit: none. Bench: `cargo bench --bench results -- --only strategy`.
const PEAKED: f64 = 0.2;

/// Strategies for a medium of this index, the best first.
pub(super) fn preferred(scene: &Scene, conditions: &Conditions, medium: usize) -> Vec<Strategy> {
    use Strategy::{Beams, FluenceTowardEye, Moments, SharedGathers};
    let Conditions { final_gather, denoise, .. } = *conditions;
    let gathers = match (possible::gathers(scene, conditions), denoise) {
        (false, _) => &[][..],
        // A denoiser removes noise that is independent from ray to ray, not noise that rays share.
        (true, true) => &[Moments],
        (true, false) => &[SharedGathers, Moments],
    };
    let peaked = is_peaked(scene.media.get(medium));
    match final_gather {
        FinalGather::Never => vec![FluenceTowardEye, Beams],
        FinalGather::Auto if possible::misses_caustics(scene) => vec![FluenceTowardEye, Beams],
        FinalGather::Auto if !peaked && !denoise => vec![FluenceTowardEye, Beams],
        FinalGather::Auto if !peaked => [&[FluenceTowardEye], gathers, &[Beams]].concat(),
        FinalGather::Auto | FinalGather::Always => [gathers, &[FluenceTowardEye, Beams]].concat(),
    }
}

/// Largest ratio of the noise-optimal to the thin width of cells that hold light scattered toward the
/// camera, beside these strategies.
pub(super) fn max_refinement(preferred: &[Strategy]) -> f64 {
    MAX_REFINEMENT[usize::from(!preferred.contains(&Strategy::Moments))]
}

/// Why a medium has this strategy by the rule.
pub(super) fn reason(
    scene: &Scene,
    conditions: &Conditions,
    medium: &Medium,
    strategy: Strategy,
) -> &'static str {
    match strategy {
        Strategy::Beams if !is_camera_outside(scene, medium) => {
            "the camera is in this medium or near it, where cells of a cache would show"
        }
        Strategy::Beams | Strategy::Traced => {
            "cells that are optically thin would be crossed by too few photons, or be too many"
        }
        Strategy::FluenceTowardEye => "cells that are optically thin are crossed by enough photons",
        _ if conditions.final_gather == FinalGather::Always => "final gathers are asked for",
        _ if is_peaked(medium) => {
            "its phase function is peaked: few photons fly so that much is scattered toward the camera"
        }
        Strategy::Moments | Strategy::SharedGathers => {
            "optically thin cells would be crossed by too few photons, and the denoiser removes the \
             noise of gathers"
        }
    }
}

/// Whether the phase function of `medium` is peaked.
fn is_peaked(medium: &Medium) -> bool {
    medium.phase.legendre()[1].abs() > PEAKED
}
