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
pub use sparse_cells::{BRICK, SparseCells, VOLUME, cell_at, cell_index};
pub use transfer::{GAMMA_TOLERANCE, Remap, Transfer};

use glam::BVec3;

use crate::math::{Rgb, WorldPoint, is_grey};
use crate::vdb::{Grid, Voxel};

/// Shortest free path over the distance between neighbouring numbers.
///
/// Unit: none. Derivation: places of scattering then round to the other side of a face in one of a thousand cases.
const FREE_PATH: f64 = 1024.0;

/// Free paths through which nothing is seen.
///
/// Unit: none. Derivation: white media pass light as one over their number.
const OPAQUE: f64 = 1e6;

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
    /// As `self`, with free paths that numbers as large as `coordinate`, in metres, resolve. It looks the same: only a
    /// homogeneous medium is changed, which gives off no light and stays opaque.
    #[must_use]
    pub fn resolved(mut self, coordinate: f64) -> Self {
        let is_plain = matches!(self.density, Density::Homogeneous(_)) && self.emission.is_none();
        if let Some(bounds) = self.density.bounds().filter(|_| is_plain && coordinate > 0.0) {
            let resolved = 1.0 / (FREE_PATH * f64::EPSILON * coordinate);
            let opaque = OPAQUE / bounds.size().min_element();
            self.sigma_t = self.sigma_t.min(Rgb::splat(resolved.max(opaque)));
        }
        self
    }

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

#[cfg(test)]
mod tests {
    use glam::{DAffine3, DVec3};

    use super::*;
    use crate::shape::{Cuboid, Region};

    /// A box as thick, with this extinction coefficient.
    fn plate(thickness: f64, sigma_t: Rgb) -> Medium {
        let half = DVec3::new(1.0, 1.0, 0.5 * thickness);
        Medium {
            density: Density::Homogeneous(Region::Box(
                Cuboid::new(-half, half, &DAffine3::IDENTITY).unwrap(),
            )),
            sigma_t,
            albedo: Albedo::Constant(Rgb::splat(0.5)),
            phase: Phase::ISOTROPIC,
            emission: None,
        }
    }

    #[test]
    fn free_paths_are_those_that_numbers_resolve_and_media_stay_opaque() {
        let coordinate = 8.0;
        for thickness in [2.0, 1e-6, 1e-12] {
            let sigma_t = plate(thickness, Rgb::new(1e18, 1e3, 0.0)).resolved(coordinate).sigma_t;
            let ulps = 1.0 / (sigma_t.x * coordinate * f64::EPSILON);
            let is_resolved = ulps > 0.999 * FREE_PATH;
            let opacity = sigma_t.x * thickness;
            assert!(is_resolved || opacity < 1.001 * OPAQUE, "{ulps} at {thickness}");
            assert!(opacity > 0.999 * OPAQUE.min(1e18 * thickness), "{opacity} at {thickness}");
            assert_eq!((sigma_t.y, sigma_t.z), (1e3, 0.0));
        }
    }
}
