//! The finished lattice.

use glam::{DVec3, IVec3};

use crate::math::{Rgb, Spectrum, WorldPoint};

use super::moments::{self, Scattered};
use super::shape::{BRICK, Cells};

/// Values along an edge of a brick: its own and its neighbours' first.
pub(super) const SIDE: usize = (1 << BRICK) + 1;

/// Values of a brick, z fastest.
pub(super) type Brick<S> = [<S as Spectrum>::Stored; SIDE * SIDE * SIDE];

/// Light in a medium on a lattice of cubic cells; see the module's documentation.
#[derive(Debug)]
pub struct Lattice<S: Spectrum = Rgb> {
    /// The finest, and others each with cells twice as wide.
    pub(super) levels: Vec<Level<S>>,
    /// How many numbers a cell has: one, or moments.
    pub(super) planes: usize,
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

    /// The light scattered toward the eye at `p` per unit of sigma_s, W/(m² sr): trilinear between
    /// the centres of cells 2^`level` times as wide as the finest, 0 where there are none.
    pub fn at(&self, p: WorldPoint, level: usize) -> S {
        let mut light = S::ZERO;
        self.each_plane(p, level, 1, |_, value| light = value);
        light
    }

    /// The light scattered at `p` into the unit direction `toward`, per unit of sigma_s,
    /// W/(m² sr), where the lattice holds moments: as far as those tell of light, and of the phase
    /// function its Legendre coefficients of degrees 1 to 3.
    pub fn toward(&self, p: WorldPoint, level: usize, toward: DVec3, legendre: [f64; 3]) -> S {
        let mut moments = [S::ZERO; moments::MOST];
        self.each_plane(p, level, self.planes, |plane, value| moments[plane] = value);
        Scattered::new(toward, legendre).of(&moments[..self.planes])
    }

    /// Calls `f` with each of the first `planes` and its value at `p`.
    #[inline]
    fn each_plane(&self, p: WorldPoint, level: usize, planes: usize, mut f: impl FnMut(usize, S)) {
        let Some(Level { cells, bricks }) = self.levels.get(level).or(self.levels.last()) else {
            return;
        };
        let local = cells.local(p) - 0.5;
        let low = local.floor();
        let cell = low.as_ivec3();
        let Some(brick) = cells.brick_anywhere(cell >> BRICK) else { return };
        let within = cell & ((1 << BRICK) - 1);
        for plane in 0..planes {
            let of_plane = &bricks[brick * self.planes + plane];
            f(plane, blend::<S>(of_plane, within, local - low) * self.scale);
        }
    }
}

/// The trilinear value at the fraction `f` of the way from the centre of the cell `within` a brick to
/// the next along each axis.
fn blend<S: Spectrum>(brick: &Brick<S>, within: IVec3, f: DVec3) -> S {
    let first = (within.x as usize * SIDE + within.y as usize) * SIDE + within.z as usize;
    let f = f.as_vec3();
    let corner = |x, y, z| S::unpack(brick[first + (x * SIDE + y) * SIDE + z]);
    let lerp = |from: S::Short, to: S::Short, f: f32| from * (1.0 - f) + to * f;
    let along = |x, y| lerp(corner(x, y, 0), corner(x, y, 1), f.z);
    let side = |x| lerp(along(x, 0), along(x, 1), f.y);
    S::long(lerp(side(0), side(1), f.x))
}
