//! From flights to a lattice.

use std::ops::Range;

use glam::{DVec3, IVec3};
use rayon::prelude::*;

use crate::math::{Aabb, Spectrum, World, WorldPoint, warp};
use crate::medium::Phase;
use crate::scene::Camera;

use super::bins::Bins;
use super::cell_walk::{Line, Steps};
use super::fluence_grid::FluenceGrid;
use super::mip::Mip;
use super::moments::{FIRST, MOST, of_flight};
use crate::medium::{BRICK, SparseCells, VOLUME, cell_index};
use crate::transport::FlightSegment;

/// How much the phase function may change along a flight through a brick, as a share of its value,
/// for its course between the ends to count as straight.
const STRAIGHT: f64 = 0.1;

/// Numbers of a lattice up to which 64 bits hold its sums: where cells are so few, more flights may cross
/// one than 32 bits can count.
const FEW: usize = 1 << 18;

/// Cells twice as wide are crossed by four times as many flights: one in so many will do.
const THINNED: usize = 4;

/// A lattice that still takes flights.
pub struct FluenceBuilder<'a, S: Spectrum> {
    cells: SparseCells,
    /// 8³ cells a brick, z fastest, for each plane.
    sums: Vec<S::F32>,
    /// Where those are few, what they were before the last flights were added.
    totals: Vec<S>,
    /// The maps' origin, in cells from the lattice's corner.
    origin: DVec3,
    holds: CellContents<'a>,
    /// Moments of a higher degree, on cells twice as wide.
    wide: Option<Box<Self>>,
}

/// What a lattice holds of the light that flies through its cells.
#[derive(Clone, Copy)]
pub enum CellContents<'a> {
    /// What a phase function scatters toward the eye.
    TowardEye(&'a Phase, &'a Camera),
    /// Its fluence and its flux: what of it is scattered anywhere, where it comes from nearly all
    /// sides.
    FirstMoments,
    /// Those and, on cells twice as wide, its second moments.
    Moments,
    /// Its second moments alone.
    SecondMoments,
}

/// The bricks that one thread fills.
struct Layer<'a, S: Spectrum> {
    index: usize,
    /// Number of the first.
    first: usize,
    /// Cells of a brick, for all planes.
    volume: usize,
    sums: &'a mut [S::F32],
}

impl<'a, S: Spectrum> FluenceBuilder<'a, S> {
    /// An empty lattice over `cells` that is to hold this of light. Flights are given relative to
    /// `origin`.
    pub fn new(cells: SparseCells, origin: WorldPoint, holds: CellContents<'a>) -> Self {
        let sums = vec![S::F32::default(); cells.bricks() * holds.planes() * VOLUME];
        let wide = matches!(holds, CellContents::Moments)
            .then(|| Box::new(Self::new(cells.coarser(), origin, CellContents::SecondMoments)));
        let origin = cells.to_cells(origin);
        let totals = vec![S::ZERO; if sums.len() <= FEW { sums.len() } else { 0 }];
        Self { cells, sums, totals, origin, holds, wide }
    }

    /// The box that holds all cells.
    pub fn bounds(&self) -> Aabb<World> {
        let size = (self.cells.size << BRICK).as_dvec3();
        Aabb::new(self.cells.corner, self.cells.to_world(size))
    }

    /// Adds flights. Each layer of bricks is filled by one thread, in the order of the flights, so
    /// that the sums are the same on any number of threads.
    pub fn add(&mut self, tracks: &[&[FlightSegment<S>]]) {
        if let Some(wide) = &mut self.wide {
            let few: Vec<Vec<FlightSegment<S>>> =
                tracks.par_iter().map(|tracks| thinned(tracks)).collect();
            wide.add(&few.iter().map(Vec::as_slice).collect::<Vec<_>>());
        }
        let count = self.cells.layers.len() - 1;
        let sort =
            |tracks: &&[FlightSegment<S>]| Bins::new(tracks.iter().map(|t| self.crossed(t)), count);
        let sorted: Vec<Bins> = tracks.par_iter().with_max_len(1).map(sort).collect();
        let mut layers = Vec::with_capacity(count);
        let mut rest = &mut self.sums[..];
        let (cells, origin, holds) = (&self.cells, self.origin, self.holds);
        let volume = holds.planes() * VOLUME;
        for (index, bounds) in cells.layers.windows(2).enumerate() {
            let (sums, others) = rest.split_at_mut((bounds[1] - bounds[0]) as usize * volume);
            rest = others;
            if !sums.is_empty() {
                layers.push(Layer::<S> { index, first: bounds[0] as usize, volume, sums });
            }
        }
        layers.into_par_iter().with_max_len(1).for_each(|mut layer| {
            for (tracks, sorted) in tracks.iter().zip(&sorted) {
                for number in sorted.of(layer.index) {
                    layer.add(&tracks[*number as usize], cells, origin, holds);
                }
            }
        });
        for (total, sum) in self.totals.iter_mut().zip(&mut self.sums) {
            *total += S::to_f64(std::mem::take(sum));
        }
    }

    /// The layers of bricks that a flight may cross.
    fn crossed(&self, track: &FlightSegment<S>) -> Range<usize> {
        let (axis, side) = (self.cells.layer_axis, f64::from(1 << BRICK));
        let place = |p: DVec3| ((self.origin[axis] + p[axis] / self.cells.edge) / side).floor();
        let (start, end) = (place(track.start()), place(track.end()));
        let layers = self.cells.layers.len() - 1;
        let within = |place: f64| (place as usize).min(layers);
        within(start.min(end))..within(start.max(end) + 1.0)
    }

    /// The finished lattice, with this many levels of wider cells. Powers were given in units of
    /// `unit` W.
    pub fn finish(self, wider: u32, unit: f64) -> FluenceGrid<S> {
        let Self { cells, mut sums, totals, holds, wide, .. } = self;
        for (sum, total) in sums.iter_mut().zip(totals) {
            *sum = total.to_f32();
        }
        let wide = wide.map(|builder| Box::new(builder.finish(wider, unit * THINNED as f64)));
        // Lengths were counted in cells.
        let scale = unit / cells.edge.powi(2);
        let planes = holds.planes();
        let mut means = Mip::<S> { cells, planes, values: sums };
        let mut levels = Vec::new();
        for _ in 0..wider {
            let next = means.wider();
            levels.push(means.level());
            means = next;
        }
        levels.push(means.level());
        FluenceGrid { levels, scale, wide }
    }
}

/// One of each [`THINNED`] flights, another each time, lest flights of paths that are all of one length
/// be always the same of these.
fn thinned<S: Spectrum>(tracks: &[FlightSegment<S>]) -> Vec<FlightSegment<S>> {
    let group = |(index, group): (usize, &[FlightSegment<S>])| group.get(index % THINNED).copied();
    tracks.chunks(THINNED).enumerate().filter_map(group).collect()
}

impl<S: Spectrum> Layer<'_, S> {
    /// Adds what lies of a flight in this layer.
    fn add(
        &mut self,
        track: &FlightSegment<S>,
        cells: &SparseCells,
        origin: DVec3,
        holds: CellContents<'_>,
    ) {
        let start = origin + track.start() / cells.edge;
        let end = origin + track.end() / cells.edge;
        let line = Line::new(start, end - start);
        let axis = cells.layer_axis;
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
        let power = track.power() * length as f32;
        for (brick, from, to) in Steps::new(&line, from, to, low, high, BRICK) {
            let Some(number) = cells.brick(brick) else { continue };
            let first = (number - self.first) * self.volume;
            let sums = &mut self.sums[first..first + self.volume];
            let (low, high) = (brick << BRICK, (brick + 1) << BRICK);
            let steps = Steps::new(&line, from, to, low, high, 0);
            let even = power * warp::uniform_sphere_pdf() as f32;
            let (phase, camera) = match holds {
                CellContents::TowardEye(phase, _) if phase.is_isotropic() => {
                    for (cell, from, to) in steps {
                        sums[cell_index(cell - low)] += even * (to - from) as f32;
                    }
                    continue;
                }
                CellContents::FirstMoments
                | CellContents::Moments
                | CellContents::SecondMoments => {
                    let of_flight = of_flight(direction).map(|m| m as f32);
                    let second = matches!(holds, CellContents::SecondMoments);
                    let moments = if second { &of_flight[FIRST..] } else { &of_flight[..FIRST] };
                    for (cell, from, to) in steps {
                        let (cell, power) = (cell_index(cell - low), even * (to - from) as f32);
                        for (plane, moment) in moments.iter().enumerate() {
                            sums[plane * VOLUME + cell] += power * *moment;
                        }
                    }
                    continue;
                }
                CellContents::TowardEye(phase, camera) => (phase, camera),
            };
            let toward = |u: f64| {
                let p = cells.to_world(line.at(u));
                phase.eval(direction.dot(camera.toward(p)))
            };
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

impl CellContents<'_> {
    /// How many numbers a cell has.
    pub const fn planes(self) -> usize {
        match self {
            Self::TowardEye(..) => 1,
            Self::FirstMoments | Self::Moments => FIRST,
            Self::SecondMoments => MOST - FIRST,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Rgb, Stage, Stream};
    use crate::medium::Density;
    use crate::scene::camera::{Pose, Projection};
    use crate::shape::{Cuboid, Region};
    use glam::DAffine3;
    use std::f64::consts::PI;

    /// Points along each flight by which brute force adds them up.
    const POINTS: u32 = 20_000;

    fn camera() -> Camera {
        let pose = Pose { position: DVec3::new(0.0, 0.5, 4.0), target: DVec3::ZERO, up: DVec3::Y };
        let projection = Projection::Perspective { fov: 40.0, aperture: 0.0, focus: None };
        Camera::new(&pose, &projection, [8, 8]).unwrap()
    }

    #[test]
    fn few_cells_count_any_number_of_flights() {
        let region = Cuboid::new(DVec3::ZERO, DVec3::ONE, &DAffine3::IDENTITY).unwrap();
        let density = Density::Homogeneous(Region::Box(region));
        let origin = WorldPoint::new(0.0, 0.0, 0.0);
        let cells = SparseCells::covering(&density, 2.0, 1).unwrap();
        let camera = camera();
        let holds = CellContents::TowardEye(&Phase::ISOTROPIC, &camera);
        let mut builder = FluenceBuilder::<f64>::new(cells, origin, holds);
        let mut total_with = |power: f64| {
            let [from, to] = [0.25, 0.75].map(|x| WorldPoint::new(x, 0.5, 0.5));
            builder.add(&[&[FlightSegment::new(origin, from, to, power)]]);
            builder.totals.iter().sum::<f64>()
        };
        // In 32 bits one is nothing beside so many.
        let many = total_with(f64::from(1 << 26));
        let with_others = (0..64).map(|_| total_with(1.0)).last().unwrap();
        let share = (with_others - many) / many * f64::from(1 << 26);
        assert!((share - 64.0).abs() < 1e-3, "{share} of 64");
    }

    #[test]
    fn cells_hold_what_brute_force_adds_up() {
        let far = DVec3::new(3e6, -2e6, 1e6);
        let peaked = Phase::henyey_greenstein(0.9).unwrap();
        // Moments tell what goes to any side by a function of which they are all there is.
        let (toward, straight) = (DVec3::new(0.36, -0.48, 0.8), 0.3);
        let camera = camera();
        for (holds, shift) in [
            (CellContents::TowardEye(&Phase::ISOTROPIC, &camera), DVec3::ZERO),
            (CellContents::TowardEye(&peaked, &camera), DVec3::ZERO),
            (CellContents::TowardEye(&Phase::ISOTROPIC, &camera), far),
            (CellContents::FirstMoments, DVec3::ZERO),
            (CellContents::SecondMoments, DVec3::ZERO),
        ] {
            let (low, high) = (DVec3::new(-1.0, -0.7, -0.4), DVec3::new(1.0, 0.8, 0.5));
            let region = Cuboid::new(low + shift, high + shift, &DAffine3::IDENTITY).unwrap();
            let density = Density::Homogeneous(Region::Box(region));
            let cells = SparseCells::covering(&density, 0.17, holds.planes()).unwrap();
            let origin = WorldPoint::from_xyz(shift + DVec3::new(0.3, 0.2, 0.1));
            let mut rng = Stream::new(4, Stage::Test, 0, 0);
            let mut place = |scale: f64| {
                let at = DVec3::from([(); 3].map(|()| (2.0 * rng.uniform() - 1.0) * scale));
                WorldPoint::from_xyz(at + shift)
            };
            let mut tracks: Vec<FlightSegment> = (0..200)
                .map(|i| {
                    FlightSegment::new(
                        origin,
                        place(1.0),
                        place(3.0),
                        Rgb::new(1.0, f64::from(i), 0.5),
                    )
                })
                .collect();
            // Along an axis, along a face, and of no length.
            let at = |x, y, z| WorldPoint::from_xyz(DVec3::new(x, y, z) + shift);
            tracks.push(FlightSegment::new(
                origin,
                at(-9.0, 0.1, 0.1),
                at(9.0, 0.1, 0.1),
                Rgb::ONE,
            ));
            let corner = cells.to_world(DVec3::splat(3.0));
            tracks.push(FlightSegment::new(origin, corner, corner + DVec3::Y, Rgb::ONE));
            tracks.push(FlightSegment::new(origin, at(0.1, 0.2, 0.3), at(0.1, 0.2, 0.3), Rgb::ONE));

            let mut right = vec![DVec3::ZERO; cells.bricks() * VOLUME];
            for track in &tracks[..201] {
                let (start, end) = (track.start(), track.end());
                for index in 0..POINTS {
                    let u = (f64::from(index) + 0.5) / f64::from(POINTS);
                    let p = origin + start.lerp(end, u);
                    let cell = cells.to_cells(p).floor().as_ivec3();
                    let Some(brick) = cells.find_brick(cell >> BRICK) else { continue };
                    let direction = (end - start).normalize();
                    let share = match holds {
                        CellContents::TowardEye(phase, camera) => {
                            phase.eval(direction.dot(camera.toward(p)))
                        }
                        // Its first is that of x².
                        CellContents::SecondMoments => {
                            (direction.x * direction.x - 1.0 / 3.0) / (4.0 * PI)
                        }
                        _ => (1.0 + 3.0 * straight * direction.dot(toward)) / (4.0 * PI),
                    };
                    let power = track.power().as_dvec3();
                    right[brick * VOLUME + cell_index(cell & ((1 << BRICK) - 1))] +=
                        power * share * track.length() / f64::from(POINTS) / cells.edge.powi(3);
                }
            }
            let places = cells.brick_positions();
            let mut builder = FluenceBuilder::new(cells, origin, holds);
            builder.add(&[&tracks[..100], &tracks[100..201]]);
            let bounds = builder.bounds();
            let (total, mut off) = (right.iter().map(|r| r.abs()).sum::<DVec3>(), DVec3::ZERO);
            let lattice = builder.finish(0, 1.0);
            for (number, at) in places.iter().enumerate() {
                for index in 0..VOLUME as i32 {
                    let within = IVec3::new(index >> 6, index >> 3 & 7, index & 7);
                    // A little inward, so that rounding asks no cell beyond the first.
                    let center = ((*at << BRICK) + within).as_dvec3() + 0.5 + 1e-6;
                    let p = bounds.min + center * lattice.cell_width();
                    let right = right[number * VOLUME + index as usize];
                    let value = match holds {
                        CellContents::FirstMoments => {
                            lattice.toward(p, 0, toward, [straight, 0.0, 0.0])
                        }
                        _ => lattice.at(p, 0),
                    };
                    off += (value - right).abs();
                }
            }
            // Brute force puts a point of each flight into the wrong cell at each border, and 32
            // bits do.
            assert!((off / total).max_element() < 2e-3, "{} at {shift}", off / total);
        }
    }
}
