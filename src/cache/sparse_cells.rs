//! Which cells a lattice has.

use glam::{DVec3, IVec3};

use crate::math::{Aabb, World, WorldPoint};
use crate::medium::Density;

/// Log2 of the edge of a brick, in cells.
pub(super) const BRICK: i32 = 3;

/// Cells of a brick.
pub(super) const VOLUME: usize = 1 << (3 * BRICK);

/// Cells round a medium that belong to its lattice.
const MARGIN: f64 = 1.5;

/// Bricks, held or not, that a lattice may span.
const MOST_SLOTS: f64 = 5e7;

/// Numbers, one a channel, that cells as large as the medium may hold: 64 MiB a channel.
const MOST_NUMBERS: f64 = (1 << 24) as f64;

/// Of all that are held, as bricks reach beyond the medium: 256 MiB a channel.
const MOST_HELD: usize = 1 << 26;

/// Marks a brick that is not held.
const NONE: u32 = u32::MAX;

/// Place among a brick's cells, z fastest.
pub(super) fn cell_index(within: IVec3) -> usize {
    ((within.x << (2 * BRICK)) + (within.y << BRICK) + within.z) as usize
}

/// The cells of a lattice: bricks of 8³ round a medium.
#[derive(Debug, Clone)]
pub struct SparseCells {
    /// Corner of the first cell.
    pub(super) corner: WorldPoint,
    /// Edge of a cell, in metres.
    pub(super) edge: f64,
    /// Bricks along each axis.
    pub(super) size: IVec3,
    /// What a step along each axis adds to a slot.
    strides: IVec3,
    /// The axis along which slots, and so bricks, lie in layers.
    pub(super) layered: usize,
    /// The number of the brick in each slot.
    slots: Vec<u32>,
    /// Bricks before each layer, and all of them.
    pub(super) layers: Vec<u32>,
}

impl SparseCells {
    /// Cells of `edge` metres round all places where `density` is not 0, each for `planes` numbers;
    /// nothing where it is endless or there would be too many.
    pub fn around(density: &Density, edge: f64, planes: usize) -> Option<Self> {
        let bounds = density.bounds()?.grown(MARGIN * edge);
        let extent = (bounds.size() / (edge * f64::from(1 << BRICK))).ceil();
        let fits = extent.is_finite()
            && extent.min_element() >= 1.0
            && extent.element_product() <= MOST_SLOTS
            && density.volume()? * planes as f64 <= MOST_NUMBERS * edge.powi(3);
        if !fits {
            return None;
        }
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
        cells.number();
        (cells.bricks() * VOLUME * planes <= MOST_HELD).then_some(cells)
    }

    /// Bytes in memory.
    pub(super) fn memory_bytes(&self) -> usize {
        size_of_val(&self.slots[..]) + size_of_val(&self.layers[..])
    }

    /// None held, of this many bricks along each axis.
    fn empty(corner: WorldPoint, edge: f64, size: IVec3) -> Self {
        let layered = (0..3).max_by_key(|&axis| size[axis]).unwrap_or(0);
        let (a, b) = ((layered + 1) % 3, (layered + 2) % 3);
        let mut strides = IVec3::ZERO;
        (strides[b], strides[a], strides[layered]) = (1, size[b], size[a] * size[b]);
        let slots = vec![NONE; size.element_product() as usize];
        Self { corner, edge, size, strides, layered, slots, layers: vec![0] }
    }

    /// Cells twice as wide that hold all of these.
    pub(super) fn wider(&self) -> Self {
        let mut cells = Self::empty(self.corner, 2.0 * self.edge, (self.size + 1) / 2);
        for at in self.places() {
            let slot = cells.slot(at / 2);
            cells.slots[slot] = 0;
        }
        cells.number();
        cells
    }

    /// Marks the bricks that meet `region`.
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

    /// Numbers the marked bricks in the order of their slots.
    fn number(&mut self) {
        let layer = self.strides[self.layered] as usize;
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

    /// The number of the brick at this place in bricks, which lies inside [`size`](Self::size);
    /// nothing where it is not held.
    pub(super) fn brick(&self, at: IVec3) -> Option<usize> {
        let number = self.slots[self.slot(at)];
        (number != NONE).then_some(number as usize)
    }

    /// As [`brick`](Self::brick), for any place.
    pub(super) fn brick_anywhere(&self, at: IVec3) -> Option<usize> {
        let inside = at.cmpge(IVec3::ZERO).all() && at.cmplt(self.size).all();
        if inside { self.brick(at) } else { None }
    }

    /// How many bricks are held.
    pub fn bricks(&self) -> usize {
        self.layers.last().map_or(0, |&count| count as usize)
    }

    /// The place in bricks of each brick that is held, in the order of their numbers.
    pub(super) fn places(&self) -> Vec<IVec3> {
        let mut places = Vec::with_capacity(self.bricks());
        let (a, b) = ((self.layered + 1) % 3, (self.layered + 2) % 3);
        for along in 0..self.size[self.layered] {
            for down in 0..self.size[a] {
                for across in 0..self.size[b] {
                    let mut at = IVec3::ZERO;
                    (at[self.layered], at[a], at[b]) = (along, down, across);
                    if self.brick(at).is_some() {
                        places.push(at);
                    }
                }
            }
        }
        places
    }

    /// A place in units of cells from the corner.
    pub(super) fn local(&self, p: WorldPoint) -> DVec3 {
        (p - self.corner) / self.edge
    }

    /// The place of a point given in cells from the corner.
    pub(super) fn world(&self, local: DVec3) -> WorldPoint {
        self.corner + local * self.edge
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
        SparseCells::around(&Density::Homogeneous(Region::Box(plate)), edge, 1)
    }

    #[test]
    fn what_is_held_is_bounded_however_little_of_it_the_medium_fills() {
        // In both its own volume is that of few cells.
        assert!(round_plate(0.016).is_none());
        let cells = round_plate(0.1).unwrap();
        assert!(cells.bricks() * VOLUME <= MOST_HELD);
        assert!(cells.memory_bytes() >= cells.bricks() * size_of::<u32>());
    }
}
