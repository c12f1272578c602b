//! The finished lattice.

use glam::{DVec3, IVec3};

use crate::math::{Rgb, Spectrum, WorldPoint};

use super::shape::{BRICK, Cells, trilinear};

/// Values along an edge of a brick: its own and its neighbours' first.
pub(super) const SIDE: usize = (1 << BRICK) + 1;

/// Values of a brick, z fastest.
pub(super) type Brick<S> = [<S as Spectrum>::Stored; SIDE * SIDE * SIDE];

/// Light in a medium on a lattice of cubic cells; see the module's documentation.
#[derive(Debug)]
pub struct Lattice<S: Spectrum = Rgb> {
    /// The finest, and others each with cells twice as wide.
    pub(super) levels: Vec<Level<S>>,
    /// W/(m² sr) that a value of 1 stands for.
    pub(super) scale: f64,
}

/// Light on cells of one width.
#[derive(Debug)]
pub(super) struct Level<S: Spectrum> {
    pub cells: Cells,
    pub bricks: Vec<Brick<S>>,
}

impl<S: Spectrum> Lattice<S> {
    /// Edge of the finest cells, in metres.
    pub fn edge(&self) -> f64 {
        self.levels.first().map_or(0.0, |level| level.cells.edge)
    }

    /// Bytes in memory.
    pub fn memory_bytes(&self) -> usize {
        self.levels.iter().map(|level| level.bricks.len() * size_of::<Brick<S>>()).sum()
    }

    /// The light scattered at `p` per unit of sigma_s, W/(m² sr): trilinear between the centres of
    /// cells 2^`level` times as wide as the finest, 0 where there are none.
    pub fn at(&self, p: WorldPoint, level: usize) -> S {
        let Some(Level { cells, bricks }) = self.levels.get(level).or(self.levels.last()) else {
            return S::ZERO;
        };
        let local = cells.local(p) - 0.5;
        let low = local.floor();
        let cell = low.as_ivec3();
        let Some(brick) = cells.brick_anywhere(cell >> BRICK) else { return S::ZERO };
        let within = cell & ((1 << BRICK) - 1);
        blend::<S>(&bricks[brick], within, local - low) * self.scale
    }
}

/// The trilinear value at the fraction `f` of the cell `within` a brick.
fn blend<S: Spectrum>(brick: &Brick<S>, within: IVec3, f: DVec3) -> S {
    let first = (within.x as usize * SIDE + within.y as usize) * SIDE + within.z as usize;
    let corner = |x: i32, y: i32, z: i32| {
        S::unpack(brick[first + (x as usize * SIDE + y as usize) * SIDE + z as usize])
    };
    S::long(trilinear(corner, f.as_vec3()))
}
