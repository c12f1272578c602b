//! Filling sparse blocks from a function of space.

use glam::{DVec3, IVec3};
use rayon::prelude::*;

use crate::vdb::Block;

/// Edge of a block in voxels: one leaf of OpenVDB.
const BLOCK: i32 = 8;

/// Voxels in a block.
const BLOCK_VOXELS: i32 = BLOCK * BLOCK * BLOCK;

/// What lies under this share of a grid's maximum counts as nothing.
const CUT: f64 = 1e-4;

/// The voxels that a volume may fill: indices from `min` up to, but not including, `max`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Domain {
    pub(super) min: IVec3,
    pub(super) max: IVec3,
    /// Voxels along the longest side; a unit of the fields' coordinates.
    pub(super) resolution: u32,
}

impl Domain {
    /// A box of `proportions` (the longest is 1) standing on y = 0, with the y axis through the
    /// middle of its floor.
    pub(super) fn standing(proportions: DVec3, resolution: u32) -> Self {
        let size = (proportions * f64::from(resolution)).round().max(DVec3::ONE).as_ivec3();
        let min = IVec3::new(-(size.x / 2), 0, -(size.z / 2));
        Self { min, max: min + size, resolution }
    }

    fn blocks(&self) -> Vec<IVec3> {
        let first = self.min.div_euclid(IVec3::splat(BLOCK));
        let last = (self.max - 1).div_euclid(IVec3::splat(BLOCK));
        let mut blocks = Vec::new();
        for x in first.x..=last.x {
            for y in first.y..=last.y {
                blocks.extend((first.z..=last.z).map(|z| IVec3::new(x, y, z) * BLOCK));
            }
        }
        blocks
    }
}

/// Evaluates `field` at every voxel of `domain` and keeps the blocks that are not empty, one list
/// for each of its `N` values, each scaled so that its maximum is 1.
///
/// `field` is called with coordinates in units of the longest side. Blocks come in the order of
/// their origins whatever the number of threads.
pub(super) fn fill<const N: usize>(
    domain: Domain,
    field: impl Fn(DVec3) -> [f64; N] + Sync,
) -> [Vec<Block>; N] {
    let filled: Vec<[Block; N]> =
        domain.blocks().into_par_iter().map(|origin| fill_block(domain, origin, &field)).collect();
    let mut grids = std::array::from_fn(|_| Vec::new());
    for blocks in filled {
        for (grid, block) in grids.iter_mut().zip(blocks) {
            grid.push(block);
        }
    }
    grids.map(normalised)
}

fn fill_block<const N: usize>(
    domain: Domain,
    origin: IVec3,
    field: &impl Fn(DVec3) -> [f64; N],
) -> [Block; N] {
    let mut values: [_; N] = std::array::from_fn(|_| vec![0.0f32; BLOCK_VOXELS as usize]);
    for offset in 0..BLOCK_VOXELS {
        let voxel = origin + IVec3::new(offset >> 6, offset >> 3 & 7, offset & 7);
        if voxel.cmplt(domain.min).any() || voxel.cmpge(domain.max).any() {
            continue;
        }
        let at = field(voxel.as_dvec3() / f64::from(domain.resolution));
        for (grid, value) in values.iter_mut().zip(at) {
            grid[offset as usize] = value as f32;
        }
    }
    values.map(|values| Block { origin, values, active: None })
}

fn normalised(mut blocks: Vec<Block>) -> Vec<Block> {
    let max = blocks.iter().flat_map(|b| b.values.iter()).fold(0.0f32, |max, &v| max.max(v));
    for value in blocks.iter_mut().flat_map(|b| b.values.iter_mut()) {
        let share = f64::from(*value) / f64::from(max);
        *value = if share >= CUT { share as f32 } else { 0.0 };
    }
    blocks.retain(|b| b.values.iter().any(|&v| v > 0.0));
    blocks
}
