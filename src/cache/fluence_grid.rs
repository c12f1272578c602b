//! The finished fluence grid.

use glam::{DVec3, IVec3};

use crate::math::{Rgb, Spectrum, WorldPoint};

use super::moments::{FIRST, MOST, ScatteredMoments};
use crate::medium::{BRICK, SparseCells};

/// Values along an edge of a brick: its own and the first of its neighbours, so that interpolation
/// reads one brick.
///
/// Unit: count. Definition: the cells of a brick along an edge, and one.
pub(super) const SIDE: usize = (1 << BRICK) + 1;

/// Cells whose values a brick stores, z fastest.
///
/// Unit: count. Definition: the cube of the values along an edge.
pub(super) const STORED: usize = SIDE * SIDE * SIDE;

/// Light in a medium on a sparse grid of cubic cells, from the lengths of photons' flights; see the
/// module's documentation.
#[derive(Debug)]
pub struct FluenceGrid<S: Spectrum = Rgb> {
    /// The finest level, and others each with cells twice as wide.
    pub(super) levels: Vec<Level<S>>,
    /// W/(m² sr) for which a value of 1 stands.
    pub(super) scale: f64,
    /// Second moments, where those are held, on cells twice as wide.
    pub(super) second: Option<Box<Self>>,
}

/// Values on cells of one width.
#[derive(Debug)]
pub(super) struct Level<S: Spectrum> {
    pub cells: SparseCells,
    /// Values a cell: one, or moments.
    pub planes: usize,
    /// Values of the cells that each brick stores, brick by brick.
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
        own + self.second.as_ref().map_or(0, |second| second.memory_bytes())
    }

    /// Light scattered toward the camera at `p` per unit of sigma_s, W/(m² sr): trilinear between
    /// the centres of cells 2^`level` times as wide as the finest, 0 where there are none.
    pub fn toward_camera(&self, p: WorldPoint, level: usize) -> S {
        let [light] = self.interpolated(p, level);
        light
    }

    /// Light scattered at `p` into the unit direction `wo` per unit of sigma_s, W/(m² sr), where the
    /// grid holds moments: as far as those resolve the radiance, by the Legendre coefficients of
    /// degrees 1 to 3 of the phase function. Noise may make it negative.
    pub fn scattered(&self, p: WorldPoint, level: usize, wo: DVec3, legendre: [f64; 3]) -> S {
        let scattered = ScatteredMoments::new(wo, legendre);
        let first: [S; FIRST] = self.interpolated(p, level);
        let Some(second) = &self.second else { return scattered.of(&first) };
        let mut moments = [S::ZERO; MOST];
        moments[..FIRST].copy_from_slice(&first);
        moments[FIRST..].copy_from_slice(&second.interpolated::<{ MOST - FIRST }>(p, level));
        scattered.of(&moments)
    }

    /// The first N values of cells, trilinear at `p` between their centres.
    #[inline]
    fn interpolated<const N: usize>(&self, p: WorldPoint, level: usize) -> [S; N] {
        let none = [S::ZERO; N];
        let Some(level) = self.levels.get(level).or(self.levels.last()) else { return none };
        let cells = &level.cells;
        let local = cells.to_cells(p) - 0.5;
        let low = local.floor();
        let cell = low.as_ivec3();
        let Some(brick) = cells.find_brick(cell >> BRICK) else { return none };
        let within = cell & ((1 << BRICK) - 1);
        level.trilinear(brick, within, local - low).map(|value| S::to_f64(value) * self.scale)
    }
}

impl<S: Spectrum> Level<S> {
    /// Trilinear interpolation at the fraction `f` of the way from the centre of the cell `within` a
    /// brick to the next along each axis.
    #[inline]
    fn trilinear<const N: usize>(&self, brick: usize, within: IVec3, f: DVec3) -> [S::F32; N] {
        let first = (within.x as usize * SIDE + within.y as usize) * SIDE + within.z as usize;
        let first = brick * STORED + first;
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
