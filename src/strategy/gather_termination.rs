//! When rays that are scattered are followed further before photons are asked.
//!
//! Where a phase function is peaked, light toward the eye hangs on which way photons fly, of which
//! few photons tell little. What it is after some more scatterings hangs on that less and less: with
//! each, every moment of what a path can bring falls by that of the phase function. So rays can be
//! scattered on, as a path tracer would, until the moments that lattices do not hold are small, and
//! there the photons' fluence, flux and, where scattering is peaked, second moments say the rest: a
//! final gather (Jensen 1996, "Global Illumination using Photon Maps") that is as deep as the phase
//! function asks for.

use crate::light::Light;
use crate::medium::Medium;
use crate::scene::{FinalGather, Scene};

use crate::photon::PhotonSettings;

/// What may be left in the end of the second moment for [`USUAL`] photons, where lattices hold the
/// first.
const LEFT: f64 = 0.15;

/// See [`LEFT`].
const USUAL: f64 = 1e5;

/// How these fall with the number of photons: as the edges of cells do.
const FALL: f64 = -0.2;

/// What may be left in the end of the third moment for [`USUAL`] photons, where lattices hold the
/// second.
const LEFT_OF_THIRD: f64 = 0.0525;

/// Second moment of phase functions from which on what gathers leave is less of an error than what
/// photons do.
const PEAKED: f64 = 0.2;

/// Second moment from which on it tells much of what a phase function does.
const TELLING: f64 = 0.5;

/// How far rays are followed before lattices of moments are asked.
#[derive(Debug, Clone)]
pub struct GatherTermination {
    /// Legendre coefficients of each medium's phase function.
    legendre: Vec<[f64; 3]>,
    /// What may be left of the first moment that lattices do not hold, by the degree that they do.
    enough: [f64; 2],
}

impl GatherTermination {
    /// What may be done in `scene`, the best first; the first is taken for which lattices can be made.
    /// Nothing is to ask photons at once: best where no phase function is peaked or mirrors throw
    /// light of lamps on media, and all there is where rays cannot be followed. Where noise is taken
    /// off, to follow rays is better than to gather photons along them.
    pub fn choices(scene: &Scene, shooting: &PhotonSettings) -> Vec<Option<Self>> {
        let Some(depth) = Self::possible(scene, shooting) else { return vec![None] };
        let is_peaked = depth.legendre.iter().any(|of| of[1].abs() > PEAKED);
        // Rays seldom meet in a mirror what sends much light there, and never a point.
        let mirrored =
            scene.surfaces.has_specular() && !scene.lights.lights.iter().all(Light::is_environment);
        match shooting.final_gather {
            FinalGather::Never => vec![None],
            FinalGather::Auto if mirrored || (!is_peaked && !shooting.denoise) => vec![None],
            FinalGather::Auto if !is_peaked => vec![None, Some(depth)],
            FinalGather::Auto | FinalGather::Always => vec![Some(depth), None],
        }
    }

    /// Nothing where orders of scattering are counted, or a lamp is in a medium, near which rays would
    /// seldom find very much.
    fn possible(scene: &Scene, shooting: &PhotonSettings) -> Option<Self> {
        let legendre = scene.media.iter().map(|m| m.phase.legendre()).collect();
        let lights = &scene.lights.lights;
        let holds_lamp = |medium: &Medium| {
            let bounds = medium.density.bounds();
            let holds = |lamp| bounds.is_none_or(|bounds| bounds.contains(lamp));
            lights.iter().filter_map(Light::position).any(holds)
        };
        let lamp_inside = scene.media.iter().any(holds_lamp);
        let photons = (shooting.photons.max(1) as f64 / USUAL).powf(FALL);
        let enough = [LEFT, LEFT_OF_THIRD].map(|left| left * photons);
        let follows = !lamp_inside && shooting.max_scatter.is_none();
        follows.then_some(Self { legendre, enough })
    }

    /// The Legendre coefficients of degrees 1 to 3 of a medium's phase function.
    pub fn legendre(&self, medium: usize) -> [f64; 3] {
        self.legendre[medium]
    }

    /// Degree of the moments that are kept of light in a medium: the second where that tells much.
    pub fn degree(&self, medium: usize) -> usize {
        if self.legendre[medium][1].abs() > TELLING { 2 } else { 1 }
    }

    /// What is left of the moment beyond those that lattices hold, 1 where nothing has been scattered
    /// yet, after a scattering in a medium; nothing where it is so little that moments may be asked
    /// instead. The first always goes on.
    pub fn after(&self, left: f64, medium: usize) -> Option<f64> {
        let first = left == 1.0;
        let degree = self.degree(medium);
        let left = left * self.legendre[medium][degree].abs();
        (first || left > self.enough[degree - 1]).then_some(left)
    }
}
