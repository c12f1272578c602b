//! When final gathers end.
//!
//! With a peaked phase function few photons tell how much light is scattered toward the camera. After n
//! more scatterings that depends less on the photons' directions: each multiplies the l-th Legendre
//! moment of what a path brings by the phase function's own. So a final gather (Jensen 1996, "Global
//! Illumination using Photon Maps") is scattered on, as in path tracing, until the moments that cells
//! do not hold are small; there fluence, flux and, for peaked functions, the second moments of photons
//! tell the rest.

use crate::light::Light;
use crate::medium::Medium;
use crate::scene::{FinalGather, Scene};

use super::kind::Conditions;

/// Largest second Legendre moment left unresolved when a gather ends, for [`REFERENCE_PHOTONS`]
/// photons, where cells hold moments of the first degree.
const MAX_SECOND_MOMENT: f64 = 0.15;

/// As [`MAX_SECOND_MOMENT`], for the third moment where cells hold the second degree.
const MAX_THIRD_MOMENT: f64 = 0.0525;

/// Photons for which [`MAX_SECOND_MOMENT`] and [`MAX_THIRD_MOMENT`] hold.
const REFERENCE_PHOTONS: f64 = 1e5;

/// Exponent of both over the number of photons: that of the width of cells.
const PHOTONS_EXPONENT: f64 = -0.2;

/// Second Legendre coefficient of a phase function above which final gathers have less error than
/// photons alone.
const PEAKED: f64 = 0.2;

/// Second Legendre coefficient above which cells hold moments of the second degree.
const HOLDS_SECOND_DEGREE: f64 = 0.5;

/// When final gathers end: how much of the moments that cells do not hold is left.
#[derive(Debug, Clone)]
pub struct GatherTermination {
    /// Legendre coefficients of degrees 1 to 3 of each medium's phase function.
    legendre: Vec<[f64; 3]>,
    /// Largest moment of the next degree left unresolved, by the degree that cells hold less 1.
    tolerance: [f64; 2],
}

impl GatherTermination {
    /// What can be done in `scene`, the best first; the first whose cells exist is taken. `None` is
    /// no final gather: best where no phase function is peaked or a mirror throws light of lamps on
    /// media, and the only way where gathers cannot be made. Where the picture is denoised, a gather
    /// is better than beams.
    pub(super) fn choices(scene: &Scene, conditions: &Conditions) -> Vec<Option<Self>> {
        let Some(termination) = Self::possible(scene, conditions) else { return vec![None] };
        let is_peaked = Self::is_peaked(scene);
        // Gathers seldom meet in a mirror what sends much light there, and never a point.
        let mirrored =
            scene.surfaces.has_specular() && !scene.lights.lights.iter().all(Light::is_environment);
        match conditions.final_gather {
            FinalGather::Never => vec![None],
            FinalGather::Auto if mirrored || (!is_peaked && !conditions.denoise) => vec![None],
            FinalGather::Auto if !is_peaked => vec![None, Some(termination)],
            FinalGather::Auto | FinalGather::Always => vec![Some(termination), None],
        }
    }

    /// Whether any phase function of `scene` is peaked.
    pub(super) fn is_peaked(scene: &Scene) -> bool {
        scene.media.iter().any(|medium| medium.phase.legendre()[1].abs() > PEAKED)
    }

    /// `None` where orders of scattering are counted, or a lamp is in a medium: gathers seldom come
    /// near it, where light is strong.
    fn possible(scene: &Scene, conditions: &Conditions) -> Option<Self> {
        let legendre = scene.media.iter().map(|m| m.phase.legendre()).collect();
        let lights = &scene.lights.lights;
        let holds_lamp = |medium: &Medium| {
            let bounds = medium.density.bounds();
            let holds = |lamp| bounds.is_none_or(|bounds| bounds.contains(lamp));
            lights.iter().filter_map(Light::position).any(holds)
        };
        let lamp_inside = scene.media.iter().any(holds_lamp);
        let photons = (conditions.photons.max(1) as f64 / REFERENCE_PHOTONS).powf(PHOTONS_EXPONENT);
        let tolerance = [MAX_SECOND_MOMENT, MAX_THIRD_MOMENT].map(|moment| moment * photons);
        let possible = !lamp_inside && conditions.max_scatter.is_none();
        possible.then_some(Self { legendre, tolerance })
    }

    /// Legendre coefficients of degrees 1 to 3 of a medium's phase function.
    pub fn legendre(&self, medium: usize) -> [f64; 3] {
        self.legendre[medium]
    }

    /// Highest degree of the moments that cells of a medium hold: 1 or 2.
    pub fn degree(&self, medium: usize) -> usize {
        if self.legendre[medium][1].abs() > HOLDS_SECOND_DEGREE { 2 } else { 1 }
    }

    /// The moment left unresolved after a scattering in a medium, where `left` was before, 1 at the
    /// start; `None` where it is within the tolerance and the gather ends. The first scattering never
    /// ends it.
    pub fn next(&self, left: f64, medium: usize) -> Option<f64> {
        let first = left == 1.0;
        let degree = self.degree(medium);
        let left = left * self.legendre[medium][degree].abs();
        (first || left > self.tolerance[degree - 1]).then_some(left)
    }
}
