//! A grid in memory.

use std::sync::Arc;

use glam::{DAffine3, IVec3};

use crate::math::{Aabb, Index, IndexPoint, Transform};

use super::build::build;
use super::domain::Domain;
use super::regions::CellBox;
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
/// are samples at whole coordinates, values are trilinear. Clones share the voxels.
///
/// A grid of a medium's coefficient is that medium inside [`bounds`](Self::bounds), where every
/// trilinear value counts, and vacuum outside. Any other grid has its values everywhere:
/// [`value`](Self::value).
#[derive(Debug, Clone)]
pub struct Grid<V> {
    tree: Arc<Tree<V>>,
    transform: Transform<Index>,
    statistics: Statistics,
    /// Cells outside which all is background.
    extent: CellBox,
    /// The same in index space.
    stored: Aabb<Index>,
    range: [f32; 2],
    domain: Domain,
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
        let mut extent = CellBox::EMPTY;
        let mut range = tree.background.range();
        let differs = |value: V| value.bits() != tree.background.bits();
        tree.for_each_region(CellBox::ALL, &differs, &mut |region| {
            extent = extent.union(region.cells());
            let [low, high] = tree.range_of(region.content);
            range = [range[0].min(low), range[1].max(high)];
        });
        let domain = Domain::new(&tree, extent, statistics.bounds);
        let stored = extent.bounds();
        let tree = Arc::new(tree);
        Self { tree, transform, statistics, extent, stored, range, domain, unwanted }
    }

    pub(super) fn tree(&self) -> &Tree<V> {
        &self.tree
    }

    /// Cells outside which all is background.
    pub(super) const fn extent(&self) -> &CellBox {
        &self.extent
    }

    /// The same in index space.
    pub(super) const fn stored(&self) -> &Aabb<Index> {
        &self.stored
    }

    /// Cells of the medium.
    pub(super) const fn medium_cells(&self) -> &CellBox {
        &self.domain.cells
    }

    /// Whether grids share their voxels: the same for clones, wherever they are
    /// [`placed`](Self::placed), another for any other grid in memory.
    pub fn identity(&self) -> usize {
        Arc::as_ptr(&self.tree).addr()
    }

    /// The same voxels as a medium that fills the whole box of the active ones: where values of 0
    /// are not vacuum, as under a ramp that gives them another value.
    #[must_use]
    pub fn filled(self) -> Self {
        Self { domain: Domain::filled(&self.tree, self.statistics.bounds), ..self }
    }

    /// The map from index space to the world as the file has it.
    pub fn transform(&self) -> &Transform<Index> {
        &self.transform
    }

    /// The grid moved by `placement` in the world; nothing where the map becomes singular.
    pub fn placed(self, placement: &DAffine3) -> Option<Self> {
        Some(Self { transform: self.transform.placed(placement)?, ..self })
    }

    /// The value where the file has none.
    pub fn background(&self) -> V {
        self.tree.background
    }

    /// The background where it is not 0, and so is a part of the medium in the box of the active
    /// voxels; nothing where it is 0 or no voxel is active.
    pub fn background_inside(&self) -> Option<V> {
        let is_zero = self.tree.background.bits() == V::default().bits();
        (!is_zero && self.statistics.bounds.is_some()).then_some(self.tree.background)
    }

    /// The box outside which the grid is vacuum as a medium: [min - 1, max + 1] of the active
    /// voxels where values other than 0 lie beyond them, which are cut off at its faces; else the
    /// box, tight to whole bricks, of what is not 0.
    pub const fn bounds(&self) -> &Aabb<Index> {
        &self.domain.bounds
    }

    /// Whether values other than 0 are cut off at the faces of [`bounds`](Self::bounds).
    pub const fn is_cut(&self) -> bool {
        self.domain.is_cut
    }

    /// Whether the medium has the voxel, inside its bounds or on their faces.
    pub fn has_voxel(&self, voxel: IVec3) -> bool {
        let CellBox { min, end } = self.domain.cells;
        voxel.cmpge(min).all() && voxel.cmple(end).all()
    }

    /// The largest value anywhere (of a vector, the largest component), background included.
    pub fn max_value(&self) -> f32 {
        self.range[1]
    }

    /// The smallest value anywhere, background included.
    pub fn min_value(&self) -> f32 {
        self.range[0]
    }

    /// The largest value of the medium inside [`bounds`](Self::bounds), at least 0.
    pub const fn max_inside(&self) -> f32 {
        self.domain.range[1]
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

    /// Calls `f` with each brick and constant block of the medium that is not 0, cut to its
    /// bounds: with boxes of cells outside of all of which the medium is 0.
    pub fn for_each_occupied(&self, mut f: impl FnMut(Aabb<Index>)) {
        let cells = self.domain.cells;
        self.domain.for_each_region(&self.tree, cells, &mut |region| {
            f(region.cells().intersect(cells).bounds());
        });
    }

    /// Volume of the bricks and constant blocks of the medium that are not 0, in voxels.
    pub const fn occupied_volume(&self) -> f64 {
        self.domain.volume
    }
}

impl Grid<f32> {
    /// The smallest and largest value of the region round `p` in which [`bricks`](Self::bricks)
    /// sees it; nothing outside [`bounds`](Self::bounds).
    pub fn range_at(&self, p: IndexPoint) -> Option<[f32; 2]> {
        if !self.bounds().contains(p) {
            return None;
        }
        let CellBox { min, end } = self.domain.cells;
        let cell = p.xyz.floor().as_ivec3().clamp(min, end - 1);
        Some(self.tree.range_of(Cursor::new(&self.tree).region(cell).content))
    }

    /// As [`for_each_occupied`](Self::for_each_occupied), with the smallest and largest value of
    /// each region.
    pub fn for_each_range(&self, mut f: impl FnMut(Aabb<Index>, [f32; 2])) {
        let cells = self.domain.cells;
        self.domain.for_each_region(&self.tree, cells, &mut |region| {
            let range = self.tree.range_of(region.content);
            f(region.cells().intersect(cells).bounds(), range);
        });
    }

    /// Calls `f` for every voxel of the medium that is not 0, those on the faces of its bounds
    /// among them: in a fixed order, a constant block as one box, other voxels as boxes of one.
    pub fn for_each_nonzero(&self, mut f: impl FnMut(VoxelBox)) {
        let CellBox { min, end } = self.domain.cells;
        let voxels = CellBox { min, end: end.saturating_add(IVec3::ONE) };
        self.domain.for_each_region(&self.tree, voxels, &mut |region| match region.content {
            Child::Constant(0.0) => {}
            Child::Constant(value) => {
                let CellBox { min, end } = region.cells().intersect(voxels);
                f(VoxelBox { min, max: end - 1, value });
            }
            Child::Node(i) => {
                let brick = &self.tree.bricks[i as usize];
                for slot in 0..512 {
                    let at = place(slot, 3);
                    let value = brick[(at.x * 81 + at.y * 9 + at.z) as usize];
                    if value != 0.0 && self.has_voxel(region.min + at) {
                        f(VoxelBox { min: region.min + at, max: region.min + at, value });
                    }
                }
            }
        });
    }
}
