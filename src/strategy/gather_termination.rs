//! When final gathers end.
//!
//! With a peaked phase function few photons tell how much light is scattered toward the camera. After n
//! more scatterings that depends less on the photons' directions: each multiplies the l-th Legendre
//! moment of what a path brings by the phase function's own. So a final gather (Jensen 1996, "Global
//! Illumination using Photon Maps") is scattered on, as in path tracing, until the moments that cells
//! do not hold are small; there fluence, flux and, for peaked functions, the second moments of photons
//! tell the rest.

use crate::scene::Scene;

/// Largest Legendre moments left unresolved when a gather ends, for [`REFERENCE_PHOTONS`] photons: the
/// second where cells hold moments of the first degree, the third where they hold the second.
///
/// Unit: none. Bench: `cargo bench --bench results -- --only strategy`.
const MAX_MOMENTS: [f64; 2] = [0.15, 0.0525];

/// Photons for which [`MAX_MOMENTS`] hold.
///
/// Unit: count. Definition: the number for which the tolerances are stated.
const REFERENCE_PHOTONS: f64 = 1e5;

/// Exponent of both over the number of photons: that of the width of cells.
///
/// Unit: none. Derivation: that of the width of cells, so that the bias of both falls alike.
const PHOTONS_EXPONENT: f64 = -0.2;

/// Second Legendre coefficient above which cells hold moments of the second degree.
///
/// Unit: none. Bench: `cargo bench --bench results -- --only strategy`.
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
    /// No medium, and no gather that ends.
    ///
    /// Unit: none. Definition: what a picture without photons has.
    pub const NEVER: Self = Self { legendre: Vec::new(), tolerance: [0.0; 2] };

    /// In the media of `scene`, for this number of photon paths.
    pub(super) fn new(scene: &Scene, photons: u64) -> Self {
        let legendre = scene.media.iter().map(|m| m.phase.legendre()).collect();
        let photons = (photons.max(1) as f64 / REFERENCE_PHOTONS).powf(PHOTONS_EXPONENT);
        let tolerance = MAX_MOMENTS.map(|moment| moment * photons);
        Self { legendre, tolerance }
    }

    /// Legendre coefficients of degrees 1 to 3 of a medium's phase function.
    pub fn legendre(&self, medium: usize) -> [f64; 3] {
        self.legendre[medium]
    }

    /// Highest degree of the moments that cells of a medium hold: 1 or 2.
    pub fn degree(&self, medium: usize) -> usize {
        if self.legendre[medium][1].abs() > HOLDS_SECOND_DEGREE { 2 } else { 1 }
    }

    /// Values of a cell that holds those moments.
    pub fn values(&self, medium: usize) -> usize {
        (self.degree(medium) + 1).pow(2)
    }

    /// The moment left unresolved after a scattering in a medium, where `unresolved` was before, 1 at
    /// the start.
    pub fn after(&self, unresolved: f64, medium: usize) -> f64 {
        unresolved * self.legendre[medium][self.degree(medium)].abs()
    }

    /// Whether a gather ends at the moments that a medium's cells hold, where scattering there leaves
    /// `unresolved` of the next one: never at its first scattering.
    pub fn ends(&self, unresolved: f64, medium: usize) -> bool {
        unresolved <= self.tolerance[self.degree(medium) - 1]
    }
}
