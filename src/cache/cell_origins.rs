//! Where in the cells of a medium final gathers start, found once for all passes of a picture.

use std::sync::OnceLock;

use rayon::prelude::*;

use crate::math::{Spectrum, Stage, Stream};
use crate::medium::SparseCells;
use crate::scene::Scene;
use crate::scene::plan::Needs;
use crate::transport::{PathContext, PixelFootprint};
use crate::work::Work;

use super::camera_thickness::CameraThickness;
use super::gather_origin::{GatherCell, GatherOrigins, OriginWeights};
use super::lazy_cells::EmptyCell;

/// In place of a pass of rays: places of gathers are those of all.
///
/// Unit: none. Definition: the largest index, which no pass has.
const ALL_PASSES: u64 = u64::MAX;

/// Where final gathers start in the cells of a medium, and the optical thickness from there to the camera. Neither depends
/// on photons or on rays: all passes of a picture share them, and both halves of its photons.
#[derive(Debug)]
pub struct CellOrigins<S> {
    thickness: CameraThickness<S>,
    medium: usize,
    seed: u64,
    /// Those that were found before, and saved; others are found for each pass of rays.
    kept: OnceLock<KeptOrigins>,
}

/// Weights of the places of some cells.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct KeptOrigins {
    /// A bit a cell, set where there are weights, in words of 64, each with the number of bits set before it.
    known: Vec<(u64, u32)>,
    weights: Vec<OriginWeights>,
}

impl<S: Spectrum> CellOrigins<S> {
    /// None found yet in `cells` of the medium of this index. The `seed` decides which places there are.
    pub fn new(cells: SparseCells, medium: usize, seed: u64) -> Self {
        let thickness = CameraThickness::new(cells, medium);
        Self { thickness, medium, seed, kept: OnceLock::new() }
    }

    /// The optical thickness to the camera, on the same cells.
    pub const fn thickness(&self) -> &CameraThickness<S> {
        &self.thickness
    }

    /// Those of one cell.
    pub(super) fn of(
        &self,
        scene: &Scene,
        cell: &EmptyCell,
        footprint: &PixelFootprint,
        ctx: &mut PathContext,
    ) -> GatherOrigins {
        let mut stream = Stream::new(self.seed, Stage::GatherPoints, cell.key, ALL_PASSES);
        let (center, width) = (cell.center, self.thickness.cells().width());
        let at = GatherCell { center, width, scramble: stream.scramble() };
        let kept = self.kept.get().and_then(|kept| kept.of(cell.index));
        kept.map_or_else(
            || {
                let thickness = Some(&self.thickness);
                GatherOrigins::in_cell(scene, self.medium, at, footprint, thickness, ctx)
            },
            |weights| GatherOrigins::new(at, weights),
        )
    }

    /// Finds and keeps those of all cells whose thickness is known, and counts the work.
    pub fn keep_known(&self, scene: &Scene, footprint: &PixelFootprint, needs: Needs) -> Work {
        let cells = self.thickness.cells();
        let known: Vec<EmptyCell> = cells.known().collect();
        let find = |cell: &EmptyCell| {
            let stream = Stream::new(self.seed, Stage::March, cell.key, ALL_PASSES);
            let mut ctx = PathContext::new(stream, needs);
            let weights = self.of(scene, cell, footprint, &mut ctx).weights();
            let mut work = ctx.work;
            work += ctx.amortized.work;
            (weights, work)
        };
        let (weights, work): (Vec<_>, Vec<_>) = known.par_iter().map(find).unzip();
        let weights = known.iter().map(|cell| cell.index).zip(weights);
        self.keep(KeptOrigins::new(cells.count(), weights));
        work.into_iter().sum()
    }

    /// Keeps those that were found before for the same cells, unless some are kept already.
    pub fn keep(&self, origins: KeptOrigins) {
        let _ = self.kept.set(origins);
    }

    /// Those that are kept, if any.
    pub fn kept(&self) -> Option<&KeptOrigins> {
        self.kept.get()
    }
}

impl KeptOrigins {
    /// Those of so many cells, by index in ascending order.
    pub fn new(cells: usize, weights: impl Iterator<Item = (usize, OriginWeights)>) -> Self {
        let mut bits = vec![0_u64; cells.div_ceil(64)];
        let weights = weights.map(|(cell, weights)| {
            bits[cell / 64] |= 1 << (cell % 64);
            weights
        });
        let weights = weights.collect();
        let mut before = 0;
        let known = bits.into_iter().map(|bits| {
            let word = (bits, before);
            before += bits.count_ones();
            word
        });
        Self { known: known.collect(), weights }
    }

    /// Those of the cell of this index, if they are known.
    pub fn of(&self, cell: usize) -> Option<OriginWeights> {
        let (bits, before) = *self.known.get(cell / 64)?;
        let bit = 1 << (cell % 64);
        let index = before as usize + (bits & (bit - 1)).count_ones() as usize;
        (bits & bit != 0).then(|| self.weights[index])
    }

    /// Number of cells with weights.
    pub const fn count(&self) -> usize {
        self.weights.len()
    }

    /// Bytes in memory.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&self.known[..]) + size_of_val(&self.weights[..])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn kept_weights_are_found_by_cell(known in prop::collection::btree_set(0..500_usize, 0..99)) {
            let words = |cell: usize| [cell as u32, 7 * cell as u32, !(cell as u32)];
            let weights = |cell: usize| OriginWeights::from_words(words(cell));
            let kept = KeptOrigins::new(500, known.iter().map(|&cell| (cell, weights(cell))));
            prop_assert_eq!(kept.count(), known.len());
            for cell in 0..600 {
                prop_assert_eq!(kept.of(cell), known.contains(&cell).then(|| weights(cell)));
            }
            for cell in known {
                prop_assert_eq!(weights(cell).to_words(), words(cell));
            }
        }
    }
}
