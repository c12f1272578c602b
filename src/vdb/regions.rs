//! Boxes of cells, and the regions of a tree one after another.

use glam::IVec3;

use crate::math::{Aabb, Index, Point};

use super::tree::{BRICK, Child, LOWER, REACH, Region, Tree, UPPER, place};
use super::voxel::Voxel;

/// A box of cells; empty where an `end` is not above its `min`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct CellBox {
    /// Smallest cell.
    pub(super) min: IVec3,
    /// The cell after the last along each axis.
    pub(super) end: IVec3,
}

impl CellBox {
    /// No cells.
    pub(super) const EMPTY: Self = Self { min: IVec3::MAX, end: IVec3::MIN };

    /// All cells a grid may have.
    pub(super) const ALL: Self =
        Self { min: IVec3::splat(-(1 << REACH)), end: IVec3::splat(1 << REACH) };

    pub(super) fn is_empty(&self) -> bool {
        self.min.cmpge(self.end).any()
    }

    /// The cells of both.
    pub(super) fn intersect(self, other: Self) -> Self {
        Self { min: self.min.max(other.min), end: self.end.min(other.end) }
    }

    /// The smallest box that holds both.
    pub(super) fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), end: self.end.max(other.end) }
    }

    /// The box as a part of index space.
    pub(super) fn bounds(&self) -> Aabb<Index> {
        let corner = |cell: IVec3| Point::from_xyz(cell.as_dvec3());
        if self.is_empty() { Aabb::EMPTY } else { Aabb::new(corner(self.min), corner(self.end)) }
    }

    /// Cells in the box.
    pub(super) fn volume(&self) -> f64 {
        if self.is_empty() { 0.0 } else { (self.end - self.min).as_dvec3().element_product() }
    }
}

impl<V> Region<V> {
    /// Its cells.
    pub(super) fn cells(&self) -> CellBox {
        CellBox { min: self.min, end: self.end() }
    }
}

impl<V: Voxel> Tree<V> {
    /// Calls `f` for every region that meets `cells` and whose content `is_wanted`, in a fixed order;
    /// bricks are always wanted. Where the background is wanted, regions that the tree does not hold
    /// come last, as large cubes.
    pub(super) fn for_each_region(
        &self,
        cells: CellBox,
        is_wanted: &impl Fn(V) -> bool,
        f: &mut impl FnMut(Region<V>),
    ) {
        for &(key, root) in &self.roots {
            let region = Region { min: IVec3::from(key) << UPPER, log2_size: UPPER, content: root };
            self.visit(region, cells, is_wanted, f);
        }
        if is_wanted(self.background) {
            for corner in 0..8 {
                self.visit_gaps(place(corner, 1) - 1, REACH - UPPER, cells, f);
            }
        }
    }

    fn visit(
        &self,
        region: Region<V>,
        cells: CellBox,
        is_wanted: &impl Fn(V) -> bool,
        f: &mut impl FnMut(Region<V>),
    ) {
        let Region { min, log2_size, content } = region;
        if region.cells().intersect(cells).is_empty() {
            return;
        }
        let (children, side) = match content {
            Child::Node(i) if log2_size == UPPER => (&self.upper[i as usize][..], UPPER - LOWER),
            Child::Node(i) if log2_size == LOWER => (&self.lower[i as usize][..], LOWER - BRICK),
            Child::Node(_) => return f(region),
            Child::Constant(value) => {
                if is_wanted(value) {
                    f(region);
                }
                return;
            }
        };
        let log2_size = log2_size - side;
        for (slot, &content) in children.iter().enumerate() {
            let min = min + (place(slot, side) << log2_size);
            self.visit(Region { min, log2_size, content }, cells, is_wanted, f);
        }
    }

    /// The regions round the roots, in the block `key` of edge 2^([`UPPER`] + `level`).
    fn visit_gaps(&self, key: IVec3, level: u32, cells: CellBox, f: &mut impl FnMut(Region<V>)) {
        let log2_size = UPPER + level;
        let content = Child::Constant(self.background);
        let region = Region { min: key << log2_size, log2_size, content };
        if region.cells().intersect(cells).is_empty() {
            return;
        }
        if self.occupied[level as usize].binary_search(&key.to_array()).is_err() {
            return f(region);
        }
        if level > 0 {
            for corner in 0..8 {
                self.visit_gaps(2 * key + place(corner, 1), level - 1, cells, f);
            }
        }
    }
}
