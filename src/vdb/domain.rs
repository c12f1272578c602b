//! Where a grid's medium is.

use glam::IVec3;

use crate::math::{Aabb, Index};

use super::regions::CellBox;
use super::tree::{Child, Region, SIDE, Tree};
use super::voxel::Voxel;

/// The box of cells in which a grid's values are a medium, with what is counted over it. Outside is
/// vacuum, whatever the tree holds there.
#[derive(Debug, Clone, Copy)]
pub(super) struct Domain {
    pub(super) cells: CellBox,
    pub(super) bounds: Aabb<Index>,
    /// Whether values other than 0 reach the faces of the box, so that it cuts them off.
    pub(super) is_cut: bool,
    /// Whether values of 0 count as well.
    pub(super) is_filled: bool,
    /// Smallest and largest value inside, 0 included.
    pub(super) range: [f32; 2],
    /// Volume of the regions that count, in voxels.
    pub(super) volume: f64,
}

/// Whether a value is 0, in all its components.
fn is_zero<V: Voxel>(value: V) -> bool {
    value.bits() == V::default().bits()
}

/// Index space [min - 1, max + 1] of the active voxels, which reach as far as their neighbours.
fn active_cells(active: Option<[[i32; 3]; 2]>) -> CellBox {
    active.map_or(CellBox::EMPTY, |[min, max]| CellBox {
        min: IVec3::from(min) - 1,
        end: IVec3::from(max) + 1,
    })
}

impl Domain {
    /// That of a grid whose values differ from the background in `extent` only, and whose smallest
    /// and largest active voxels are `active`: the box of these where anything but 0 lies beyond
    /// them, else the tighter box of what is not 0.
    pub(super) fn new<V: Voxel>(
        tree: &Tree<V>,
        extent: CellBox,
        active: Option<[[i32; 3]; 2]>,
    ) -> Self {
        let box_of_active = active_cells(active);
        if !is_zero(tree.background) {
            return Self::counted(tree, box_of_active, true, false);
        }
        let is_cut = has_values_beyond(tree, active);
        let cells = if is_cut { box_of_active.intersect(extent) } else { extent };
        Self::counted(tree, cells, is_cut, false)
    }

    /// The whole box of the active voxels `active`, values of 0 included.
    pub(super) fn filled<V: Voxel>(tree: &Tree<V>, active: Option<[[i32; 3]; 2]>) -> Self {
        Self::counted(tree, active_cells(active), true, true)
    }

    fn counted<V: Voxel>(tree: &Tree<V>, cells: CellBox, is_cut: bool, is_filled: bool) -> Self {
        let bounds = cells.bounds();
        let mut domain = Self { cells, bounds, is_cut, is_filled, range: [0.0; 2], volume: 0.0 };
        let (mut range, mut volume) = ([0f32; 2], 0.0);
        domain.for_each_region(tree, cells, &mut |region| {
            let [low, high] = tree.range_of(region.content);
            range = [range[0].min(low), range[1].max(high)];
            volume += region.cells().intersect(cells).volume();
        });
        (domain.range, domain.volume) = (range, volume);
        domain
    }

    /// Calls `f` for every region that counts and meets `cells`, in a fixed order.
    pub(super) fn for_each_region<V: Voxel>(
        &self,
        tree: &Tree<V>,
        cells: CellBox,
        f: &mut impl FnMut(Region<V>),
    ) {
        if cells.is_empty() {
            return;
        }
        let is_wanted = |value: V| self.is_filled || !is_zero(value);
        tree.for_each_region(cells, &is_wanted, f);
    }
}

/// Whether any voxel but the active ones' box is not 0, where the background is.
fn has_values_beyond<V: Voxel>(tree: &Tree<V>, active: Option<[[i32; 3]; 2]>) -> bool {
    let inside = |voxel: IVec3| {
        active.is_some_and(|[min, max]| {
            voxel.cmpge(IVec3::from(min)).all() && voxel.cmple(IVec3::from(max)).all()
        })
    };
    let mut found = false;
    tree.for_each_region(CellBox::ALL, &|value| !is_zero(value), &mut |region| {
        if found || (inside(region.min) && inside(region.end())) {
            return;
        }
        found = match region.content {
            Child::Constant(_) => true,
            Child::Node(i) => {
                let samples = tree.bricks[i as usize].iter().enumerate();
                samples.filter(|(_, value)| !is_zero(**value)).any(|(i, _)| {
                    let at = [i / (SIDE * SIDE), i / SIDE % SIDE, i % SIDE];
                    !inside(region.min + IVec3::from(at.map(|c| c as i32)))
                })
            }
        };
    });
    found
}
