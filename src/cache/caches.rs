//! The caches of one render.

use std::sync::Arc;

use crate::math::Spectrum;

use super::cell_origins::{CellOrigins, KeptOrigins};
use super::direct_light::DirectLightCache;
use super::final_gather::FinalGatherCache;
use super::fluence_grid::FluenceGrid;
use super::lazy_cells::LazyCells;

/// Light in media that is cached during one render: for each medium, in the scene's order, what its
/// strategy asks for. The session owns them and lends them to the integrator.
#[derive(Debug)]
pub struct Caches<S: Spectrum> {
    /// Light straight from lights, scattered toward the camera. Filled by rays, and the same whatever the
    /// strategy.
    pub direct: Arc<[Option<DirectLightCache<S>>]>,
    /// Photons' light: scattered toward the camera, or its moments. Where phase functions are isotropic it holds for all directions.
    /// Complete before the first ray.
    pub fluence: Vec<Option<FluenceGrid<S>>>,
    /// What final gathers find. Filled by rays.
    pub final_gathers: Vec<Option<FinalGatherCache<S>>>,
}

impl<S: Spectrum> Default for Caches<S> {
    fn default() -> Self {
        Self { direct: Arc::new([]), fluence: Vec::new(), final_gathers: Vec::new() }
    }
}

impl<S: Spectrum> Caches<S> {
    /// All cells that rays fill, in a fixed order: a checkpoint stores them.
    pub fn lazy(&self) -> Vec<&LazyCells<S>> {
        let direct = self.direct.iter().flatten().filter_map(DirectLightCache::cells);
        let gathers = self.final_gathers.iter().flatten();
        let thickness = gathers.filter_map(|of| Some(of.origins()?.thickness().cells()));
        direct.chain(thickness).chain(self.own_lazy()).collect()
    }

    /// Those of [`lazy`](Self::lazy) that each half of the photons has for itself.
    pub fn own_lazy(&self) -> impl Iterator<Item = &LazyCells<S>> {
        self.final_gathers.iter().flatten().map(FinalGatherCache::cells)
    }

    /// Bytes of the fluence grids, and of cells that rays fill.
    pub fn memory_bytes(&self) -> [u64; 2] {
        let fluence = self.fluence.iter().flatten().map(FluenceGrid::memory_bytes).sum::<usize>();
        let lazy = self.lazy().into_iter().map(LazyCells::memory_bytes).sum::<usize>();
        let origins = self.final_gathers.iter().flatten().filter_map(FinalGatherCache::origins);
        let kept = origins.filter_map(CellOrigins::kept).map(KeptOrigins::memory_bytes);
        let lazy = lazy + kept.sum::<usize>();
        [fluence, lazy].map(|bytes| bytes as u64)
    }
}
