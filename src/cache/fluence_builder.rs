//! From flights of photons to a fluence grid.

use std::ops::Range;

use glam::{DVec3, IVec3};
use rayon::prelude::*;

use crate::math::{Aabb, Spectrum, World, WorldPoint};
use crate::medium::{BRICK, Phase, SparseCells, VOLUME};
use crate::scene::Camera;
use crate::transport::FlightSegment;

use super::bins::Bins;
use super::cell_walk::{Line, Steps};
use super::flight::Flight;
use super::fluence_grid::FluenceGrid;
use super::mip::Mip;
use super::moments::{FIRST, MOST};
use super::seen_share::SeenShares;

/// Largest number of values whose sums are held in 64 bits: where cells are few, more flights may
/// cross one than 32 bits can count.
///
/// Unit: count. Limit: on memory: 2 MiB a channel.
const MAX_EXACT_SUMS: usize = 1 << 18;

/// Flights for each one that goes to the cells of second moments: those are twice as wide, and four
/// times as many flights cross them.
///
/// Unit: count. Derivation: with a fourth of the flights, each cell is crossed by as many as a narrow one.
const THINNING: usize = 4;

/// A fluence grid to which flights are added.
pub struct FluenceBuilder<'a, S: Spectrum> {
    cells: SparseCells,
    /// 8³ cells a brick, z fastest, for each plane.
    pub(super) sums: Vec<S::F32>,
    /// Where values are few: their sums before the last flights were added.
    pub(super) totals: Vec<S>,
    /// The origin of flights, in cell coordinates.
    origin: DVec3,
    contents: CellContents<'a>,
    /// Second moments, on cells twice as wide.
    pub(super) second: Option<Box<Self>>,
}

/// What a cell holds of the light that flies through it.
#[derive(Clone, Copy)]
pub enum CellContents<'a> {
    /// What a phase function scatters toward the camera; near surfaces, of the light where those shares of cells are seen.
    TowardEye(&'a Phase, &'a Camera, Option<&'a SeenShares<'a>>),
    /// Fluence and flux: the moments of degrees 0 and 1.
    FirstMoments,
    /// Those and, on cells twice as wide, the second moments.
    Moments,
    /// The second moments alone.
    SecondMoments,
}

/// The bricks that one thread fills.
struct Layer<'a, S: Spectrum> {
    index: usize,
    /// Index of the first brick.
    first: usize,
    /// Values of a brick: its cells times the planes.
    volume: usize,
    sums: &'a mut [S::F32],
}

impl<'a, S: Spectrum> FluenceBuilder<'a, S> {
    /// An empty grid on `cells` for these contents. Flights are given relative to `origin`.
    pub fn new(cells: SparseCells, origin: WorldPoint, contents: CellContents<'a>) -> Self {
        let sums = vec![S::F32::default(); cells.bricks() * contents.planes() * VOLUME];
        let second = matches!(contents, CellContents::Moments)
            .then(|| Box::new(Self::new(cells.coarser(), origin, CellContents::SecondMoments)));
        let origin = cells.to_cells(origin);
        let totals = vec![S::ZERO; if sums.len() <= MAX_EXACT_SUMS { sums.len() } else { 0 }];
        Self { cells, sums, totals, origin, contents, second }
    }

    /// The box of all cells, in world space.
    pub fn bounds(&self) -> Aabb<World> {
        let size = (self.cells.size << BRICK).as_dvec3();
        Aabb::new(self.cells.corner, self.cells.to_world(size))
    }

    /// Adds flights. Each layer of bricks is filled by one thread, in the order of the flights, so
    /// that the sums are the same on any number of threads.
    pub fn add(&mut self, flights: &[&[FlightSegment<S>]]) {
        if let Some(second) = &mut self.second {
            let few: Vec<Vec<FlightSegment<S>>> =
                flights.par_iter().map(|segments| thinned(segments)).collect();
            second.add(&few.iter().map(Vec::as_slice).collect::<Vec<_>>());
        }
        let count = self.cells.layers.len() - 1;
        let sort = |segments: &&[FlightSegment<S>]| {
            Bins::new(segments.iter().map(|segment| self.layers_of(segment)), count)
        };
        let sorted: Vec<Bins> = flights.par_iter().with_max_len(1).map(sort).collect();
        let mut layers = Vec::with_capacity(count);
        let mut rest = &mut self.sums[..];
        let (cells, origin, contents) = (&self.cells, self.origin, self.contents);
        let volume = contents.planes() * VOLUME;
        for (index, bounds) in cells.layers.windows(2).enumerate() {
            let (sums, others) = rest.split_at_mut((bounds[1] - bounds[0]) as usize * volume);
            rest = others;
            if !sums.is_empty() {
                layers.push(Layer::<S> { index, first: bounds[0] as usize, volume, sums });
            }
        }
        layers.into_par_iter().with_max_len(1).for_each(|mut layer| {
            for (segments, sorted) in flights.iter().zip(&sorted) {
                for number in sorted.of(layer.index) {
                    layer.add(&segments[*number as usize], cells, origin, contents);
                }
            }
        });
        for (total, sum) in self.totals.iter_mut().zip(&mut self.sums) {
            *total += S::to_f64(std::mem::take(sum));
        }
    }

    /// The layers of bricks that a flight may cross.
    fn layers_of(&self, segment: &FlightSegment<S>) -> Range<usize> {
        let (axis, side) = (self.cells.layer_axis, f64::from(1 << BRICK));
        let layer = |p: DVec3| ((self.origin[axis] + p[axis] / self.cells.edge) / side).floor();
        let (start, end) = (layer(segment.start()), layer(segment.end()));
        let layers = self.cells.layers.len() - 1;
        let within = |layer: f64| (layer as usize).min(layers);
        within(start.min(end))..within(start.max(end) + 1.0)
    }

    /// The finished grid, with `coarser` levels of wider cells. Powers were given in units of
    /// `unit` W.
    pub fn finish(self, coarser: u32, unit: f64) -> FluenceGrid<S> {
        let Self { cells, mut sums, totals, contents, second, .. } = self;
        for (sum, total) in sums.iter_mut().zip(totals) {
            *sum = total.to_f32();
        }
        let second =
            second.map(|builder| Box::new(builder.finish(coarser, unit * THINNING as f64)));
        // Lengths were summed in cells.
        let scale = unit / cells.edge.powi(2);
        let planes = contents.planes();
        let shares = contents.seen().map(|seen| seen.shares().clone());
        let mut means = Mip::<S> { cells, planes, values: sums, shares };
        let mut levels = Vec::new();
        for _ in 0..coarser {
            let next = means.coarser();
            levels.push(means.level());
            means = next;
        }
        levels.push(means.level());
        FluenceGrid { levels, scale, second }
    }
}

/// One of each [`THINNING`] flights, another one in each group: paths of one length would otherwise
/// always give the same of their segments.
fn thinned<S: Spectrum>(segments: &[FlightSegment<S>]) -> Vec<FlightSegment<S>> {
    let group = |(index, group): (usize, &[FlightSegment<S>])| group.get(index % THINNING).copied();
    segments.chunks(THINNING).enumerate().filter_map(group).collect()
}

impl<S: Spectrum> Layer<'_, S> {
    /// Adds the part of a flight in this layer, brick by brick.
    fn add(
        &mut self,
        segment: &FlightSegment<S>,
        cells: &SparseCells,
        origin: DVec3,
        contents: CellContents<'_>,
    ) {
        let start = origin + segment.start() / cells.edge;
        let end = origin + segment.end() / cells.edge;
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
        let power = segment.power() * length as f32;
        let flight = Flight::<S> { line, direction: line.direction / length, power };
        for (brick, from, to) in Steps::new(&line, from, to, low, high, BRICK) {
            let Some(number) = cells.brick(brick) else { continue };
            let first = (number - self.first) * self.volume;
            let sums = &mut self.sums[first..first + self.volume];
            match contents {
                CellContents::TowardEye(phase, camera, shares) => {
                    let of = shares.and_then(|shares| shares.shares().of(number).zip(Some(shares)));
                    let seen = |cell: usize, u: f64| {
                        of.is_none_or(|(of, shares)| match of[cell] {
                            1.0 => true,
                            0.0 => false,
                            _ => shares.sees(cells.to_world(line.at(u))),
                        })
                    };
                    if phase.is_isotropic() {
                        flight.add_isotropic(sums, brick, [from, to], seen);
                    } else {
                        let value = |u: f64| {
                            let p = cells.to_world(line.at(u));
                            phase.eval(flight.direction.dot(camera.toward(p)))
                        };
                        flight.add_scattered(sums, brick, [from, to], seen, value);
                    }
                }
                CellContents::FirstMoments | CellContents::Moments => {
                    flight.add_moments(sums, brick, from, to, 0..FIRST);
                }
                CellContents::SecondMoments => {
                    flight.add_moments(sums, brick, from, to, FIRST..MOST);
                }
            }
        }
    }
}

impl<'a> CellContents<'a> {
    /// Shares of cells that are seen, where light elsewhere is left out.
    const fn seen(self) -> Option<&'a SeenShares<'a>> {
        match self {
            Self::TowardEye(_, _, seen) => seen,
            Self::FirstMoments | Self::Moments | Self::SecondMoments => None,
        }
    }

    /// Values a cell.
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
    use crate::medium::{Density, cell_index};
    use crate::scene::camera::{Pose, Projection};
    use crate::shape::{Cuboid, Region};
    use glam::DAffine3;
    use std::f64::consts::PI;

    /// Points along each flight by which brute force adds them up.
    const POINTS: u32 = 20_000;

    fn camera() -> Camera {
        let pose = Pose { position: DVec3::new(0.0, 0.5, 4.0), target: DVec3::ZERO, up: DVec3::Y };
        let projection =
            Projection::Perspective { fov: 40.0, aperture: 0.0, focus: None, shift: [0.0; 2] };
        Camera::new(&pose, &projection, [8, 8]).unwrap()
    }

    #[test]
    fn few_cells_sum_any_number_of_flights() {
        let region = Cuboid::new(DVec3::ZERO, DVec3::ONE, &DAffine3::IDENTITY).unwrap();
        let density = Density::Homogeneous(Region::Box(region));
        let origin = WorldPoint::new(0.0, 0.0, 0.0);
        let cells = SparseCells::covering(&density, 2.0, 1).unwrap();
        let camera = camera();
        let contents = CellContents::TowardEye(&Phase::ISOTROPIC, &camera, None);
        let mut builder = FluenceBuilder::<f64>::new(cells, origin, contents);
        let mut total_with = |power: f64| {
            let [from, to] = [0.25, 0.75].map(|x| WorldPoint::new(x, 0.5, 0.5));
            builder.add(&[&[FlightSegment::new(origin, from, to, power)]]);
            builder.totals.iter().sum::<f64>()
        };
        // In 32 bits 1 is lost in such a sum.
        let many = total_with(f64::from(1 << 26));
        let with_others = (0..64).map(|_| total_with(1.0)).last().unwrap();
        let share = (with_others - many) / many * f64::from(1 << 26);
        assert!((share - 64.0).abs() < 1e-3, "{share} of 64");
    }

    #[test]
    fn cells_hold_the_sums_of_brute_force() {
        let far = DVec3::new(3e6, -2e6, 1e6);
        let peaked = Phase::henyey_greenstein(0.9).unwrap();
        // The first moments are exact for a phase function that is linear in the cosine, of this slope.
        let (wo, g) = (DVec3::new(0.36, -0.48, 0.8), 0.3);
        let camera = camera();
        for (contents, shift) in [
            (CellContents::TowardEye(&Phase::ISOTROPIC, &camera, None), DVec3::ZERO),
            (CellContents::TowardEye(&peaked, &camera, None), DVec3::ZERO),
            (CellContents::TowardEye(&Phase::ISOTROPIC, &camera, None), far),
            (CellContents::FirstMoments, DVec3::ZERO),
            (CellContents::SecondMoments, DVec3::ZERO),
        ] {
            let (low, high) = (DVec3::new(-1.0, -0.7, -0.4), DVec3::new(1.0, 0.8, 0.5));
            let region = Cuboid::new(low + shift, high + shift, &DAffine3::IDENTITY).unwrap();
            let density = Density::Homogeneous(Region::Box(region));
            let cells = SparseCells::covering(&density, 0.17, contents.planes()).unwrap();
            let origin = WorldPoint::from_xyz(shift + DVec3::new(0.3, 0.2, 0.1));
            let mut rng = Stream::new(4, Stage::Test, 0, 0);
            let mut place = |scale: f64| {
                let at = DVec3::from([(); 3].map(|()| (2.0 * rng.uniform() - 1.0) * scale));
                WorldPoint::from_xyz(at + shift)
            };
            let mut segments: Vec<FlightSegment> = (0..200)
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
            segments.push(FlightSegment::new(
                origin,
                at(-9.0, 0.1, 0.1),
                at(9.0, 0.1, 0.1),
                Rgb::ONE,
            ));
            let corner = cells.to_world(DVec3::splat(3.0));
            segments.push(FlightSegment::new(origin, corner, corner + DVec3::Y, Rgb::ONE));
            segments.push(FlightSegment::new(
                origin,
                at(0.1, 0.2, 0.3),
                at(0.1, 0.2, 0.3),
                Rgb::ONE,
            ));

            let mut right = vec![DVec3::ZERO; cells.bricks() * VOLUME];
            for segment in &segments[..201] {
                let (start, end) = (segment.start(), segment.end());
                for index in 0..POINTS {
                    let u = (f64::from(index) + 0.5) / f64::from(POINTS);
                    let p = origin + start.lerp(end, u);
                    let cell = cells.to_cells(p).floor().as_ivec3();
                    let Some(brick) = cells.find_brick(cell >> BRICK) else { continue };
                    let direction = (end - start).normalize();
                    let share = match contents {
                        CellContents::TowardEye(phase, camera, _) => {
                            phase.eval(direction.dot(camera.toward(p)))
                        }
                        // The first of them is that of x².
                        CellContents::SecondMoments => {
                            (direction.x * direction.x - 1.0 / 3.0) / (4.0 * PI)
                        }
                        _ => (1.0 + 3.0 * g * direction.dot(wo)) / (4.0 * PI),
                    };
                    let power = segment.power().as_dvec3();
                    right[brick * VOLUME + cell_index(cell & ((1 << BRICK) - 1))] +=
                        power * share * segment.length() / f64::from(POINTS) / cells.edge.powi(3);
                }
            }
            let positions = cells.brick_positions();
            let mut builder = FluenceBuilder::new(cells, origin, contents);
            builder.add(&[&segments[..100], &segments[100..201]]);
            let bounds = builder.bounds();
            let (total, mut off) = (right.iter().map(|r| r.abs()).sum::<DVec3>(), DVec3::ZERO);
            let grid = builder.finish(0, 1.0);
            for (number, at) in positions.iter().enumerate() {
                for index in 0..VOLUME as i32 {
                    let within = IVec3::new(index >> 6, index >> 3 & 7, index & 7);
                    // A little inward, lest rounding read the cell before the first.
                    let center = ((*at << BRICK) + within).as_dvec3() + 0.5 + 1e-6;
                    let p = bounds.min + center * grid.cell_width();
                    let right = right[number * VOLUME + index as usize];
                    let value = match contents {
                        CellContents::FirstMoments => grid.scattered(p, 0, wo, [g, 0.0, 0.0]),
                        _ => grid.toward_camera(p, 0),
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
