//! Participating media: coefficients, phase functions, optical depth and free flight.
//!
//! A [`Medium`] is a density (homogeneous in a region, or a voxel grid) times an extinction per
//! unit of density, with an albedo, a phase function and perhaps an emission. Media overlap freely:
//! [`Media`] adds their coefficients.

mod albedo;
pub mod blackbody;
mod density;
mod emission;
mod emission_sampler;
mod flight;
mod mapping;
mod media;
pub mod phase;
mod piece;
mod profile;
mod ramped;
mod refine;
mod sparse_cells;
mod transfer;

pub use albedo::Albedo;
pub use density::Density;
pub use emission::Emission;
pub use emission_sampler::{EmissionSampler, EmissionStart};
pub use flight::{Collision, Flights};
pub use media::{Media, Mixture};
pub use phase::Phase;
pub use piece::Piece;
pub use profile::{Place, Profile};
pub use ramped::Ramped;
pub use sparse_cells::{BRICK, SparseCells, VOLUME, cell_index};
pub use transfer::{GAMMA_TOLERANCE, Remap, Transfer};

use glam::BVec3;

use crate::math::{Rgb, WorldPoint, is_grey};
use crate::vdb::{Grid, Voxel};

/// Voxels in memory, which several grids may share.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SharedVoxels {
    /// The same for grids that share them.
    pub identity: usize,
    /// Bytes they take.
    pub bytes: usize,
}

impl SharedVoxels {
    /// The voxels of `grid`.
    fn from_grid<V: Voxel>(grid: &Grid<V>) -> Self {
        Self { identity: grid.identity(), bytes: grid.memory_bytes() }
    }
}

/// One participating medium.
#[derive(Debug)]
pub struct Medium {
    /// Where it is and how dense, without unit.
    pub density: Density,
    /// Extinction coefficient per unit of density, 1/m per channel.
    pub sigma_t: Rgb,
    /// Share of the extinction that scatters.
    pub albedo: Albedo,
    /// How scattered light is spread over directions.
    pub phase: Phase,
    /// Light that it gives off by itself.
    pub emission: Option<Emission>,
}

impl Medium {
    /// Extinction coefficient at `p`, 1/m.
    pub fn sigma_t_at(&self, p: WorldPoint) -> Rgb {
        self.sigma_t * self.density.value(p)
    }

    /// Whether it treats all channels alike.
    pub fn is_grey(&self) -> bool {
        is_grey(self.sigma_t)
            && self.albedo.is_grey()
            && self.emission.as_ref().is_none_or(Emission::is_grey)
    }

    /// The voxels of each of its grids: density, albedo and emission. Media may share them.
    pub fn grids(&self) -> impl Iterator<Item = SharedVoxels> {
        let density = self.density.grid().map(SharedVoxels::from_grid);
        let albedo = match &self.albedo {
            Albedo::Constant(_) => None,
            Albedo::Color { grid, .. } => Some(SharedVoxels::from_grid(grid)),
            Albedo::Scalar { grid, .. } => Some(SharedVoxels::from_grid(grid)),
            Albedo::Ramped(ramped) => Some(SharedVoxels::from_grid(ramped.grid())),
        };
        let emission = match &self.emission {
            None | Some(Emission::Density(_)) => None,
            Some(Emission::Grid { grid, .. } | Emission::Blackbody { grid, .. }) => {
                Some(SharedVoxels::from_grid(grid))
            }
            Some(Emission::Ramped(ramped)) => Some(SharedVoxels::from_grid(ramped.grid())),
        };
        [density, albedo, emission].into_iter().flatten()
    }

    /// The largest extinction coefficient of these channels per unit of density, 1/m.
    pub fn sigma_t_max(&self, channels: BVec3) -> f64 {
        Rgb::select(channels, self.sigma_t, Rgb::ZERO).max_element()
    }
}
