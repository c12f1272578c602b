//! Sparse cubic cells that cover a medium.

use glam::{DVec3, IVec3};

use crate::math::{Aabb, World, WorldPoint};

use super::Density;

/// Log2 of the edge of a brick, in cells.
pub const BRICK: i32 = 3;

/// Cells of a brick.
pub const VOLUME: usize = 1 << (3 * BRICK);

/// Width, in cells, of the border round a medium that is covered as well: trilinear interpolation at
/// its edge reads the next cell.
const MARGIN: f64 = 1.5;

/// Largest number of bricks, stored or not, in the bounding box: 200 MB of brick indices.
const MAX_SLOTS: f64 = 5e7;

/// Largest number of values in the medium's own volume: 64 MiB a channel.
const MAX_MEDIUM_VALUES: f64 = (1 << 24) as f64;

/// Largest number of values in all stored bricks, which reach beyond the medium: 256 MiB a channel.
const MAX_VALUES: usize = 1 << 26;

/// Index of a brick that is not stored.
const NONE: u32 = u32::MAX;

/// Index of a cell within its brick, z fastest.
pub fn cell_index(within: IVec3) -> usize {
    ((within.x << (2 * BRICK)) + (within.y << BRICK) + within.z) as usize
}

/// The cell of this index within its brick: the inverse of [`cell_index`].
pub fn cell_at(index: usize) -> IVec3 {
    let index = index as i32;
    IVec3::new(index >> (2 * BRICK), index >> BRICK, index) & ((1 << BRICK) - 1)
}

/// A sparse grid of cubic cells, in bricks of 8³, that covers all places where a medium's density is
/// not 0. It stores no values: an array beside it has [`VOLUME`] of them a brick.
#[derive(Debug, Clone)]
pub struct SparseCells {
    /// Lowest corner of the first cell, in world space.
    pub corner: WorldPoint,
    /// Edge of a cell, in metres.
    pub edge: f64,
    /// Bricks along each axis.
    pub size: IVec3,
    /// Offset in `slots` of the next brick along each axis.
    strides: IVec3,
    /// The slowest axis of the brick order: bricks lie in layers along it.
    pub layer_axis: usize,
    /// Index of the brick at each position, or [`NONE`].
    slots: Vec<u32>,
    /// Number of stored bricks before each layer, and in all.
    pub layers: Vec<u32>,
}

impl SparseCells {
    /// Cells of `edge` metres round all places where `density` is not 0, each for `planes` values;
    /// `None` where the medium is unbounded or memory limits would be exceeded.
    pub fn covering(density: &Density, edge: f64, planes: usize) -> Option<Self> {
        let bounds = density.bounds().filter(|_| Self::fits(density, edge, planes))?;
        let extent = Self::bricks_of(&bounds, edge);
        let bounds = bounds.grown(MARGIN * edge);
        let mut cells = Self::empty(bounds.min, edge, extent.as_ivec3());
        match density {
            Density::Homogeneous(_) => cells.mark(&bounds),
            Density::Voxel(grid) => grid.for_each_occupied(|region| {
                cells.mark(&grid.transform().box_to_world(&region).grown(MARGIN * edge));
            }),
            Density::Ramped(ramped) => ramped.for_each_occupied(|region| {
                let region = ramped.grid().transform().box_to_world(&region);
                cells.mark(&region.grown(MARGIN * edge));
            }),
        }
        cells.index_bricks();
        (cells.bricks() * VOLUME * planes <= MAX_VALUES).then_some(cells)
    }

    /// Whether cells of `edge` metres, each for `planes` values, are few enough for the box and the volume of
    /// a medium. Sparse ones may still be too many.
    pub fn fits(density: &Density, edge: f64, planes: usize) -> bool {
        let extent = density.bounds().map(|bounds| Self::bricks_of(&bounds, edge));
        extent.zip(density.volume()).is_some_and(|(extent, volume)| {
            extent.is_finite()
                && extent.min_element() >= 1.0
                && extent.element_product() <= MAX_SLOTS
                && volume * planes as f64 <= MAX_MEDIUM_VALUES * edge.powi(3)
        })
    }

    /// Bricks along each axis that cover `bounds` and its border.
    fn bricks_of(bounds: &Aabb<World>, edge: f64) -> DVec3 {
        (bounds.grown(MARGIN * edge).size() / (edge * f64::from(1 << BRICK))).ceil()
    }

    /// Bytes in memory.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&self.slots[..]) + size_of_val(&self.layers[..])
    }

    /// No brick stored, of `size` along each axis.
    fn empty(corner: WorldPoint, edge: f64, size: IVec3) -> Self {
        let layer_axis = (0..3).max_by_key(|&axis| size[axis]).unwrap_or(0);
        let (a, b) = ((layer_axis + 1) % 3, (layer_axis + 2) % 3);
        let mut strides = IVec3::ZERO;
        (strides[b], strides[a], strides[layer_axis]) = (1, size[b], size[a] * size[b]);
        let slots = vec![NONE; size.element_product() as usize];
        Self { corner, edge, size, strides, layer_axis, slots, layers: vec![0] }
    }

    /// Cells twice as wide that cover all of these.
    pub fn coarser(&self) -> Self {
        let mut cells = Self::empty(self.corner, 2.0 * self.edge, (self.size + 1) / 2);
        for at in self.brick_positions() {
            let slot = cells.slot(at / 2);
            cells.slots[slot] = 0;
        }
        cells.index_bricks();
        cells
    }

    /// Marks the bricks that overlap `region` as stored.
    fn mark(&mut self, region: &Aabb<World>) {
        let brick = |p: WorldPoint| {
            let at = ((p - self.corner) / self.edge).floor().as_ivec3() >> BRICK;
            at.clamp(IVec3::ZERO, self.size - 1)
        };
        let (low, high) = (brick(region.min), brick(region.max));
        for x in low.x..=high.x {
            for y in low.y..=high.y {
                for z in low.z..=high.z {
                    let slot = self.slot(IVec3::new(x, y, z));
                    self.slots[slot] = 0;
                }
            }
        }
    }

    /// Gives the marked bricks ascending indices.
    fn index_bricks(&mut self) {
        let layer = self.strides[self.layer_axis] as usize;
        let mut count = 0;
        for slots in self.slots.chunks_mut(layer) {
            for slot in slots.iter_mut().filter(|slot| **slot != NONE) {
                *slot = count;
                count += 1;
            }
            self.layers.push(count);
        }
    }

    fn slot(&self, brick: IVec3) -> usize {
        let at = brick * self.strides;
        (at.x + at.y + at.z) as usize
    }

    /// Index of the brick at the brick coordinates `at`, which lie inside [`size`](Self::size);
    /// `None` where it is not stored.
    pub fn brick(&self, at: IVec3) -> Option<usize> {
        let number = self.slots[self.slot(at)];
        (number != NONE).then_some(number as usize)
    }

    /// As [`brick`](Self::brick), for any coordinates.
    pub fn find_brick(&self, at: IVec3) -> Option<usize> {
        let inside = at.cmpge(IVec3::ZERO).all() && at.cmplt(self.size).all();
        if inside { self.brick(at) } else { None }
    }

    /// Number of stored bricks.
    pub fn bricks(&self) -> usize {
        self.layers.last().map_or(0, |&count| count as usize)
    }

    /// Brick coordinates of each stored brick, in the order of their indices.
    pub fn brick_positions(&self) -> Vec<IVec3> {
        let mut positions = Vec::with_capacity(self.bricks());
        let (a, b) = ((self.layer_axis + 1) % 3, (self.layer_axis + 2) % 3);
        for along in 0..self.size[self.layer_axis] {
            for down in 0..self.size[a] {
                for across in 0..self.size[b] {
                    let mut at = IVec3::ZERO;
                    (at[self.layer_axis], at[a], at[b]) = (along, down, across);
                    if self.brick(at).is_some() {
                        positions.push(at);
                    }
                }
            }
        }
        positions
    }

    /// Cell coordinates of a world-space point: cells from the lowest corner.
    pub fn to_cells(&self, p: WorldPoint) -> DVec3 {
        (p - self.corner) / self.edge
    }

    /// World-space point of cell coordinates.
    pub fn to_world(&self, cells: DVec3) -> WorldPoint {
        self.corner + cells * self.edge
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::{Cuboid, Region};
    use glam::DAffine3;
    use std::f64::consts::FRAC_PI_4;

    /// Cells round a plate of 20 m that is 2 cm thick, aslant.
    fn round_plate(edge: f64) -> Option<SparseCells> {
        let corner = DVec3::new(10.0, 0.01, 10.0);
        let aslant = DAffine3::from_rotation_x(FRAC_PI_4);
        let plate = Cuboid::new(-corner, corner, &aslant).unwrap();
        SparseCells::covering(&Density::Homogeneous(Region::Box(plate)), edge, 1)
    }

    #[test]
    fn memory_is_bounded_however_little_of_it_the_medium_fills() {
        // In both its own volume is that of few cells.
        assert!(round_plate(0.016).is_none());
        let cells = round_plate(0.1).unwrap();
        assert!(cells.bricks() * VOLUME <= MAX_VALUES);
        assert!(cells.memory_bytes() >= cells.bricks() * size_of::<u32>());
    }
}
