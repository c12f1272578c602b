//! The finished lattice.

use glam::{DVec3, IVec3};

use crate::math::{Rgb, WorldPoint};

use super::shape::{BRICK, Cells};

/// Values along an edge of a brick: its own and its neighbours' first.
pub(super) const SIDE: usize = (1 << BRICK) + 1;

/// Values of a brick, z fastest.
pub(super) type Brick = [[f32; 3]; SIDE * SIDE * SIDE];

/// Light in a medium on a lattice of cubic cells; see the module's documentation.
#[derive(Debug)]
pub struct Lattice {
    pub(super) cells: Cells,
    pub(super) bricks: Vec<Brick>,
}

impl Lattice {
    /// Edge of a cell, in metres.
    pub const fn edge(&self) -> f64 {
        self.cells.edge
    }

    /// Bytes in memory.
    pub const fn memory_bytes(&self) -> usize {
        self.bricks.len() * size_of::<Brick>()
    }

    /// The light scattered at `p` per unit of sigma_s, W/(m² sr): trilinear between the centres of
    /// the cells, 0 where there are none.
    pub fn at(&self, p: WorldPoint) -> Rgb {
        let local = self.cells.local(p) - 0.5;
        let low = local.floor();
        let cell = low.as_ivec3();
        let Some(brick) = self.cells.brick_anywhere(cell >> BRICK) else { return Rgb::ZERO };
        let within = cell & ((1 << BRICK) - 1);
        blend(&self.bricks[brick], within, local - low)
    }
}

/// The trilinear value at the fraction `f` of the cell `within` a brick.
fn blend(brick: &Brick, within: IVec3, f: DVec3) -> Rgb {
    let f = f.as_vec3();
    let first = (within.x as usize * SIDE + within.y as usize) * SIDE + within.z as usize;
    let corner =
        |x: usize, y: usize, z: usize| glam::Vec3A::from(brick[first + (x * SIDE + y) * SIDE + z]);
    let along = |x, y| corner(x, y, 0).lerp(corner(x, y, 1), f.z);
    let side = |x| along(x, 0).lerp(along(x, 1), f.y);
    side(0).lerp(side(1), f.x).as_dvec3()
}
