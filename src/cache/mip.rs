//! Coarser levels of a fluence grid.

use glam::IVec3;
use rayon::prelude::*;

use crate::math::Spectrum;

use super::fluence_grid::{Level, SIDE, STORED};
use super::seen_share::Shares;
use crate::medium::{BRICK, SparseCells, VOLUME, cell_at, cell_index};

/// Cells of a brick along an edge.
///
/// Unit: count. Definition: two to the power of the logarithm.
const EDGE: i32 = 1 << BRICK;

/// Means of light in cells, 8³ a brick for each of [`planes`](Self::planes).
pub(super) struct Mip<S: Spectrum> {
    pub cells: SparseCells,
    /// Values a cell. A brick stores the first value of all its cells, then the second.
    pub planes: usize,
    pub values: Vec<S::F32>,
    /// Shares of cells that are seen, where values are of those alone.
    pub shares: Option<Shares>,
}

impl<S: Spectrum> Mip<S> {
    fn value(&self, brick: usize, plane: usize, within: IVec3) -> S::F32 {
        self.values[(brick * self.planes + plane) * VOLUME + cell_index(within)]
    }

    /// The same light on cells twice as wide: means of eight cells.
    pub fn coarser(&self) -> Self {
        let cells = self.cells.coarser();
        let planes = self.planes;
        let mut values = vec![S::F32::default(); cells.bricks() * planes * VOLUME];
        let fill = |(at, values): (IVec3, &mut [S::F32])| {
            for index in 0..VOLUME {
                let first = ((at << BRICK) + cell_at(index)) * 2;
                // All eight lie in one brick, whose edge is even.
                let Some(brick) = self.cells.find_brick(first >> BRICK) else { continue };
                for plane in 0..planes {
                    let corner = |i: i32| {
                        let by = IVec3::new(i & 1, i >> 1 & 1, i >> 2);
                        self.value(brick, plane, (first & (EDGE - 1)) + by)
                    };
                    values[plane * VOLUME + index] =
                        (0..8).map(corner).sum::<S::F32>() * (0.5 * 0.5 * 0.5);
                }
            }
        };
        let bricks = values.par_chunks_mut(VOLUME * planes);
        cells.brick_positions().into_par_iter().zip(bricks).for_each(fill);
        let shares = self.shares.as_ref().map(|shares| shares.coarser(&self.cells, &cells));
        Self { cells, planes, values, shares }
    }

    /// The level of a grid, whose bricks store the first values of their neighbours as well.
    pub fn level(mut self) -> Level<S> {
        if let Some(shares) = self.shares.take() {
            shares.complete::<S>(&self.cells, &mut self.values);
        }
        let Self { cells, planes, .. } = &self;
        let mut values = vec![S::Stored::default(); cells.bricks() * STORED * planes];
        let fill = |(at, values): (IVec3, &mut [S::Stored])| {
            let own = cells.brick(at).expect("only stored bricks are listed");
            for (index, values) in values.chunks_mut(*planes).enumerate() {
                let (x, y, z) = (index / (SIDE * SIDE), index / SIDE % SIDE, index % SIDE);
                let within = IVec3::new(x as i32, y as i32, z as i32);
                let (brick, within) = match cells.find_brick(at + (within >> BRICK)) {
                    Some(brick) => (brick, within & (EDGE - 1)),
                    None => (own, within.min(IVec3::splat(EDGE - 1))),
                };
                for (plane, value) in values.iter_mut().enumerate() {
                    *value = S::pack(self.value(brick, plane, within));
                }
            }
        };
        let bricks = values.par_chunks_mut(STORED * planes);
        cells.brick_positions().into_par_iter().zip(bricks).for_each(fill);
        Level { cells: self.cells, planes: self.planes, values }
    }
}
