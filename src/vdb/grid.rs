//! A grid in memory.

use glam::{DAffine3, IVec3};

use crate::math::{Aabb, Index, IndexPoint, Point, Transform};

use super::build::build;
use super::source::Source;
use super::statistics::{BadValues, Statistics};
use super::tree::{Child, Cursor, Tree, place};
use super::voxel::Voxel;

/// A box of voxels with one value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VoxelBox {
    /// Smallest voxel.
    pub min: IVec3,
    /// Largest voxel, inside the box.
    pub max: IVec3,
    /// The value of each.
    pub value: f32,
}

/// The voxels of one grid, with the map from its index space to the world. Between the voxels, which
/// are samples at whole coordinates, values are trilinear.
#[derive(Debug)]
pub struct Grid<V> {
    tree: Tree<V>,
    transform: Transform<Index>,
    statistics: Statistics,
    /// Smallest cell and the one after the last that is not background.
    cells: (IVec3, IVec3),
    bounds: Aabb<Index>,
    range: [f32; 2],
    occupied: f64,
    unwanted: u64,
}

impl<V: Voxel> Grid<V> {
    /// Builds the grid; statistics are given because they are counted before repairs and before so
    /// many active voxels were unwanted.
    pub(super) fn new(
        source: &Source<V>,
        transform: Transform<Index>,
        statistics: Statistics,
        unwanted: u64,
    ) -> Self {
        let tree = build(source);
        let mut cells = (IVec3::MAX, IVec3::MIN);
        let mut range = tree.background.range();
        let mut occupied = 0.0;
        tree.for_each_region(&mut |region| {
            cells = (cells.0.min(region.min), cells.1.max(region.end()));
            let [low, high] = tree.range_of(region.content);
            range = [range[0].min(low), range[1].max(high)];
            occupied += f64::from(1u32 << region.log2_size).powi(3);
        });
        let bounds = if tree.roots.is_empty() {
            Aabb::EMPTY
        } else {
            Aabb::new(Point::from_xyz(cells.0.as_dvec3()), Point::from_xyz(cells.1.as_dvec3()))
        };
        Self { tree, transform, statistics, cells, bounds, range, occupied, unwanted }
    }

    pub(super) fn tree(&self) -> &Tree<V> {
        &self.tree
    }

    /// Smallest cell that is not background, and the one after the largest.
    pub(super) fn extent(&self) -> (IVec3, IVec3) {
        self.cells
    }

    /// The map from index space to the world as the file has it.
    pub fn transform(&self) -> &Transform<Index> {
        &self.transform
    }

    /// The grid moved by `placement` in the world; nothing where the map becomes singular.
    pub fn placed(self, placement: &DAffine3) -> Option<Self> {
        Some(Self { transform: self.transform.placed(placement)?, ..self })
    }

    /// The value outside [`bounds`](Self::bounds).
    pub fn background(&self) -> V {
        self.tree.background
    }

    /// A box, tight to whole bricks, outside which the trilinear value is the background.
    pub fn bounds(&self) -> &Aabb<Index> {
        &self.bounds
    }

    /// The largest value anywhere (of a vector, the largest component), background included.
    pub fn max_value(&self) -> f32 {
        self.range[1]
    }

    /// The smallest value anywhere, background included.
    pub fn min_value(&self) -> f32 {
        self.range[0]
    }

    /// Bytes the voxels take in memory.
    pub fn memory_bytes(&self) -> usize {
        self.tree.bytes()
    }

    /// Active voxels in the file, those in tiles among them.
    pub fn active_voxels(&self) -> u64 {
        self.statistics.active
    }

    /// Active voxels of the file in leaves that were not wanted, and are background here where those
    /// were left out.
    pub const fn unwanted(&self) -> u64 {
        self.unwanted
    }

    /// What was counted while reading, before bad values were taken as 0.
    pub fn statistics(&self) -> &Statistics {
        &self.statistics
    }

    /// Bad values that were found; a grid read as density has them no more.
    pub fn bad_values(&self) -> BadValues {
        self.statistics.bad
    }

    /// Calls `f` with each brick and constant block that is not background: with a box of cells
    /// outside of all of which the grid is background.
    pub fn for_each_occupied(&self, mut f: impl FnMut(Aabb<Index>)) {
        self.tree.for_each_region(&mut |region| {
            let corner = |cell: IVec3| Point::from_xyz(cell.as_dvec3());
            f(Aabb::new(corner(region.min), corner(region.end())));
        });
    }

    /// Volume of the bricks and constant blocks that are not background, in voxels.
    pub fn occupied_volume(&self) -> f64 {
        self.occupied
    }
}

impl Grid<f32> {
    /// The largest value of the region round `p` in which [`bricks`](Self::bricks) sees it.
    pub fn majorant(&self, p: IndexPoint) -> f32 {
        if !self.bounds.contains(p) {
            return self.tree.background;
        }
        let cell = p.xyz.floor().as_ivec3().clamp(self.cells.0, self.cells.1 - 1);
        self.tree.range_of(Cursor::new(&self.tree).region(cell).content)[1]
    }

    /// Calls `f` for every voxel that is neither 0 nor, within constant blocks, the background: in a
    /// fixed order, a constant block as one box, other voxels as boxes of one.
    pub fn for_each_nonzero(&self, mut f: impl FnMut(VoxelBox)) {
        self.tree.for_each_region(&mut |region| match region.content {
            Child::Constant(0.0) => {}
            Child::Constant(value) => {
                f(VoxelBox { min: region.min, max: region.end() - 1, value });
            }
            Child::Node(i) => {
                let brick = &self.tree.bricks[i as usize];
                for slot in 0..512 {
                    let at = place(slot, 3);
                    let value = brick[(at.x * 81 + at.y * 9 + at.z) as usize];
                    if value != 0.0 {
                        f(VoxelBox { min: region.min + at, max: region.min + at, value });
                    }
                }
            }
        });
    }
}
