//! From flights to a lattice.

use glam::{DVec3, IVec3, Vec3, Vec4};
use rayon::prelude::*;

use crate::math::{Aabb, World, WorldPoint, warp};
use crate::medium::Phase;
use crate::scene::Camera;

use super::cells::{Brick, Lattice, SIDE};
use super::shape::{BRICK, Cells, VOLUME};
use super::track::Track;
use super::walk::{Line, Steps};

/// How much the phase function may change along a flight through a brick, as a share of its value,
/// for its course between the ends to count as straight.
const STRAIGHT: f64 = 0.1;

/// A lattice that still takes flights.
pub struct Builder<'a> {
    cells: Cells,
    /// Three channels and nothing, 8³ cells a brick, z fastest.
    sums: Vec<Vec4>,
    /// The maps' origin, in cells from the lattice's corner.
    origin: DVec3,
    spread: Spread<'a>,
}

/// How much of the light that flies through a place is scattered toward the eye.
#[derive(Clone, Copy)]
struct Spread<'a> {
    phase: &'a Phase,
    camera: &'a Camera,
}

/// The bricks that one thread fills.
struct Layer<'a> {
    index: usize,
    /// Number of the first.
    first: usize,
    sums: &'a mut [Vec4],
}

impl<'a> Builder<'a> {
    /// An empty lattice over `cells` for light scattered by `phase` toward `camera`. Flights are
    /// given relative to `origin`.
    pub fn new(cells: Cells, origin: WorldPoint, phase: &'a Phase, camera: &'a Camera) -> Self {
        let sums = vec![Vec4::ZERO; cells.bricks() * VOLUME];
        let origin = cells.local(origin);
        Self { cells, sums, origin, spread: Spread { phase, camera } }
    }

    /// The box that holds all cells.
    pub fn bounds(&self) -> Aabb<World> {
        let size = (self.cells.size << BRICK).as_dvec3();
        Aabb::new(self.cells.corner, self.cells.world(size))
    }

    /// Adds flights. Each layer of bricks is filled by one thread, in the order of the flights, so
    /// that the sums are the same on any number of threads.
    pub fn add(&mut self, tracks: &[&[Track]]) {
        let mut layers = Vec::with_capacity(self.cells.layers.len());
        let mut rest = &mut self.sums[..];
        for (index, bounds) in self.cells.layers.windows(2).enumerate() {
            let (sums, others) = rest.split_at_mut((bounds[1] - bounds[0]) as usize * VOLUME);
            rest = others;
            if !sums.is_empty() {
                layers.push(Layer { index, first: bounds[0] as usize, sums });
            }
        }
        let (cells, origin, spread) = (&self.cells, self.origin, self.spread);
        layers.into_par_iter().for_each(|mut layer| {
            for track in tracks.iter().copied().flatten() {
                layer.add(track, cells, origin, spread);
            }
        });
    }

    /// The finished lattice.
    pub fn finish(self) -> Lattice {
        let Self { cells, sums, .. } = self;
        let mut places = Vec::with_capacity(cells.bricks());
        cells.for_each_brick(|at| places.push(at));
        // Lengths were counted in cells.
        let per_volume = (cells.edge.powi(2).recip()) as f32;
        let value = |brick: usize, at: IVec3| {
            let sum = sums[brick * VOLUME + cell_index(at)] * per_volume;
            Vec3::from(sum.truncate()).to_array()
        };
        let brick = |at: &IVec3| -> Brick {
            let own = cells.brick(*at).expect("only bricks that are held are listed");
            std::array::from_fn(|index| {
                let (x, y, z) = (index / (SIDE * SIDE), index / SIDE % SIDE, index % SIDE);
                let within = IVec3::new(x as i32, y as i32, z as i32);
                match cells.brick_anywhere(*at + (within >> BRICK)) {
                    Some(brick) => value(brick, within & ((1 << BRICK) - 1)),
                    None => value(own, within.min(IVec3::splat((1 << BRICK) - 1))),
                }
            })
        };
        let bricks = places.par_iter().map(brick).collect();
        Lattice { cells, bricks }
    }
}

impl Layer<'_> {
    /// Adds what lies of a flight in this layer.
    fn add(&mut self, track: &Track, cells: &Cells, origin: DVec3, spread: Spread<'_>) {
        let start = origin + track.start() / cells.edge;
        let end = origin + track.end() / cells.edge;
        let line = Line::new(start, end - start);
        let axis = cells.layered;
        let (mut low, mut high) = (IVec3::ZERO, cells.size);
        (low[axis], high[axis]) = (self.index as i32, self.index as i32 + 1);
        let side = f64::from(1 << BRICK);
        let (from, to) = line.within(low.as_dvec3() * side, high.as_dvec3() * side);
        if to <= from {
            return;
        }
        let length = line.direction.length();
        if length == 0.0 {
            return;
        }
        let direction = line.direction / length;
        let [r, g, b] = track.power();
        let power = Vec4::new(r, g, b, 0.0) * length as f32;
        for (brick, from, to) in Steps::new(&line, from, to, low, high, BRICK) {
            let Some(number) = cells.brick(brick) else { continue };
            let first = (number - self.first) * VOLUME;
            let sums = &mut self.sums[first..first + VOLUME];
            let toward = |u: f64| spread.at(cells.world(line.at(u)), direction);
            let (low, high) = (brick << BRICK, (brick + 1) << BRICK);
            let steps = Steps::new(&line, from, to, low, high, 0);
            if spread.phase.is_isotropic() {
                let power = power * warp::uniform_sphere_pdf() as f32;
                for (cell, from, to) in steps {
                    sums[cell_index(cell - low)] += power * (to - from) as f32;
                }
                continue;
            }
            let (first, last) = (toward(from), toward(to));
            let slope = (last - first) / (to - from);
            let straight = (last - first).abs() <= STRAIGHT * first.min(last);
            for (cell, begin, end) in steps {
                let middle = 0.5 * (begin + end);
                let share = if straight { first + slope * (middle - from) } else { toward(middle) };
                sums[cell_index(cell - low)] += power * ((end - begin) * share) as f32;
            }
        }
    }
}

impl Spread<'_> {
    /// The share, 1/sr, of light that flies along the unit `direction` through `p`.
    fn at(self, p: WorldPoint, direction: DVec3) -> f64 {
        self.phase.eval(direction.dot(self.camera.toward(p)))
    }
}

/// Place among a brick's cells.
fn cell_index(within: IVec3) -> usize {
    ((within.x << (2 * BRICK)) + (within.y << BRICK) + within.z) as usize
}
