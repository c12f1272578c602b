//! What is asked of a shot.

use crate::scene;
use crate::scene::plan::Needs;

/// How photons are shot.
#[derive(Debug, Clone, Copy)]
pub struct PhotonSettings {
    /// Paths sent out.
    pub photons: u64,
    /// Paths of them that are traced, for a look at what all would leave; nothing means all.
    pub traced: Option<u64>,
    /// Seed of the random streams.
    pub seed: u64,
    /// Highest order of volume scattering that the picture holds; nothing means all.
    pub max_scatter: Option<u32>,
    /// Where rays are followed before photons are asked.
    pub final_gather: scene::FinalGather,
    /// Whether noise is taken off the picture in the end.
    pub denoise: bool,
    /// Gather radius in metres, where it is given.
    pub radius: Option<f64>,
    /// Levels of thinned volume photons beside the full one, for gathers up to 2^levels times as
    /// wide.
    pub levels: u32,
    /// Rays of each pixel of the picture, at most.
    pub rays: u32,
    /// Pixels of the film, along each side, that one of the picture stands for: cells for direct
    /// light and for final gathers are as much wider.
    pub pixels: f64,
    /// Which photons are needed.
    pub needs: Needs,
}
