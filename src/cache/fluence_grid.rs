//! The finished lattice.

use glam::{DVec3, IVec3};

use crate::math::{Rgb, Spectrum, WorldPoint};

use super::moments::{FIRST, MOST, Scattered};
use crate::medium::{BRICK, SparseCells};

/// Values along an edge of a brick: its own and its neighbours' first.
pub(super) const SIDE: usize = (1 << BRICK) + 1;

/// Cells whose values a brick holds, z fastest.
pub(super) const HELD: usize = SIDE * SIDE * SIDE;

/// Light in a medium on a lattice of cubic cells; see the module's documentation.
#[derive(Debug)]
pub struct FluenceGrid<S: Spectrum = Rgb> {
    /// The finest, and others each with cells twice as wide.
    pub(super) levels: Vec<Level<S>>,
    /// W/(m² sr) that a value of 1 stands for.
    pub(super) scale: f64,
    /// Where moments of the second degree are held as well: those, on cells twice as wide.
    pub(super) wide: Option<Box<Self>>,
}

/// Light on cells of one width.
#[derive(Debug)]
pub(super) struct Level<S: Spectrum> {
    pub cells: SparseCells,
    /// How many numbers a cell has: one, or moments.
    pub planes: usize,
    /// Those of each cell that a brick holds, brick by brick.
    pub values: Vec<S::Stored>,
}

impl<S: Spectrum> FluenceGrid<S> {
    /// Width of the finest cells, in metres.
    pub fn cell_width(&self) -> f64 {
        self.levels.first().map_or(0.0, |level| level.cells.edge)
    }

    /// Bytes in memory.
    pub fn memory_bytes(&self) -> usize {
        let of = |level: &Level<S>| size_of_val(&level.values[..]) + level.cells.memory_bytes();
        let own: usize = self.levels.iter().map(of).sum();
        own + self.wide.as_ref().map_or(0, |wide| wide.memory_bytes())
    }

    /// The light scattered toward the eye at `p` per unit of sigma_s, W/(m² sr): trilinear between
    /// the centres of cells 2^`level` times as wide as the finest, 0 where there are none.
    pub fn at(&self, p: WorldPoint, level: usize) -> S {
        let [light] = self.blended(p, level);
        light
    }

    /// The light scattered at `p` into the unit direction `toward`, per unit of sigma_s,
    /// W/(m² sr), where the lattice holds moments: as far as those tell of light, and of the phase
    /// function its Legendre coefficients of degrees 1 to 3.
    pub fn toward(&self, p: WorldPoint, level: usize, toward: DVec3, legendre: [f64; 3]) -> S {
        let scattered = Scattered::new(toward, legendre);
        let first: [S; FIRST] = self.blended(p, level);
        let Some(wide) = &self.wide else { return scattered.of(&first) };
        let mut moments = [S::ZERO; MOST];
        moments[..FIRST].copy_from_slice(&first);
        moments[FIRST..].copy_from_slice(&wide.blended::<{ MOST - FIRST }>(p, level));
        scattered.of(&moments)
    }

    /// The first numbers of cells at `p`, trilinear between their centres.
    #[inline]
    fn blended<const N: usize>(&self, p: WorldPoint, level: usize) -> [S; N] {
        let none = [S::ZERO; N];
        let Some(level) = self.levels.get(level).or(self.levels.last()) else { return none };
        let cells = &level.cells;
        let local = cells.to_cells(p) - 0.5;
        let low = local.floor();
        let cell = low.as_ivec3();
        let Some(brick) = cells.find_brick(cell >> BRICK) else { return none };
        let within = cell & ((1 << BRICK) - 1);
        level.blend(brick, within, local - low).map(|short| S::to_f64(short) * self.scale)
    }
}

impl<S: Spectrum> Level<S> {
    /// The trilinear values at the fraction `f` of the way from the centre of the cell `within` a
    /// brick to the next along each axis.
    #[inline]
    fn blend<const N: usize>(&self, brick: usize, within: IVec3, f: DVec3) -> [S::F32; N] {
        let first = (within.x as usize * SIDE + within.y as usize) * SIDE + within.z as usize;
        let first = brick * HELD + first;
        let f = f.as_vec3();
        let mut sums = [S::F32::default(); N];
        for (x, of_x) in [(0, 1.0 - f.x), (1, f.x)] {
            for (y, of_y) in [(0, 1.0 - f.y), (1, f.y)] {
                // Two along z lie side by side.
                let row = (first + (x * SIDE + y) * SIDE) * self.planes;
                let row = &self.values[row..row + 2 * self.planes];
                let (near, far) = row.split_at(self.planes);
                for (sum, (near, far)) in sums.iter_mut().zip(near.iter().zip(far)) {
                    let along = S::unpack(*near) * (1.0 - f.z) + S::unpack(*far) * f.z;
                    *sum += along * (of_x * of_y);
                }
            }
        }
        sums
    }
}
