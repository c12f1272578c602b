//! Free flight by null-collision tracking with local majorants.
//!
//! Tentative collisions of one medium form a Poisson process along the ray whose rate is its
//! majorant, piecewise constant over bricks or finer (Woodcock et al. 1965; Novák et al. 2018,
//! section 4). Overlapping media are independent processes, so the first tentative collision of all
//! of them is the nearest of the firsts, and only the medium that had it needs a new one.

use glam::BVec3;
use smallvec::SmallVec;

use crate::math::{Index, Ray, Span, Spectrum, Stream, World};
use crate::vdb::{BrickSegment, BrickWalk, Grid};

use super::mapping::{AsItIs, Mapping};
use super::refine::{PATIENCE, Refined};
use super::transfer::Transfer;
use super::{Density, Medium};

/// A tentative collision.
#[derive(Debug, Clone, Copy)]
pub struct Collision {
    /// Distance along the ray, in metres.
    pub t: f64,
    /// Index of the medium.
    pub medium: usize,
    /// Density there, without unit.
    pub density: f64,
    /// Rate of the medium's tentative collisions there, 1/m: its majorant over the channels that
    /// carry anything.
    pub majorant: f64,
    /// The same for the whole brick or region, 1/m, whatever the ray: `majorant` is finer where
    /// this one is very loose.
    pub region_majorant: f64,
}

/// The tentative collisions of several media along one ray, front to back.
#[derive(Debug)]
pub struct Flights<'a> {
    media: &'a [Medium],
    ray: Ray<World>,
    end: f64,
    /// Channels whose extinction counts.
    channels: BVec3,
    /// Grid lookups of flights that were started anew.
    lookups: u64,
    flights: SmallVec<[(Flight<'a>, Option<Collision>); 1]>,
}

impl<'a> Flights<'a> {
    /// Starts along `ray` (unit direction) within `span`, for light that carries `power` (any
    /// unit): channels without power ask for no collisions.
    pub fn start<S: Spectrum>(
        media: &'a [Medium],
        ray: &Ray<World>,
        span: Span,
        power: S,
        rng: &mut Stream,
    ) -> Self {
        let channels = power.nonzero();
        let flights = SmallVec::new();
        let mut flights = Self { media, ray: *ray, end: span.end, channels, lookups: 0, flights };
        flights.start_at(span.start, rng);
        flights
    }

    fn start_at(&mut self, start: f64, rng: &mut Stream) {
        let span = Span::new(start, self.end);
        self.lookups = self.take_lookups();
        self.flights.clear();
        for (index, medium) in self.media.iter().enumerate() {
            let mut flight = Flight::new(index, medium, &self.ray, span, self.channels);
            let first = flight.next(rng);
            self.flights.push((flight, first));
        }
    }

    /// The next tentative collision, or nothing where the span ends first.
    pub fn next(&mut self, rng: &mut Stream) -> Option<Collision> {
        let reach = |next: &Option<Collision>| next.map_or(f64::INFINITY, |c| c.t);
        let (flight, next) =
            self.flights.iter_mut().min_by(|a, b| reach(&a.1).total_cmp(&reach(&b.1)))?;
        let collision = (*next)?;
        *next = flight.next(rng);
        Some(collision)
    }

    /// Grid lookups since this was last asked: one a region crossed.
    pub fn take_lookups(&mut self) -> u64 {
        let ahead = self.flights.iter_mut().map(|(flight, _)| flight.take_lookups());
        std::mem::take(&mut self.lookups) + ahead.sum::<u64>()
    }

    /// Tells that after the collision at `t` the light carries `power`: where a channel has died
    /// out, further collisions come at the rate of those that are left. Without that a medium that
    /// is a million times as thick for red would stop blue light a million times for nothing.
    pub fn carry_on<S: Spectrum>(&mut self, power: S, t: f64, rng: &mut Stream) {
        let channels = power.nonzero();
        if channels != self.channels {
            self.channels = channels;
            self.start_at(t, rng); // the process has no memory
        }
    }
}

/// The tentative collisions of one medium.
#[derive(Debug)]
struct Flight<'a> {
    medium: usize,
    /// Largest extinction coefficient per unit of density of the channels that count, 1/m.
    sigma_t: f64,
    path: Path<'a>,
}

#[derive(Debug)]
#[allow(clippy::large_enum_variant, reason = "it lives on the stack, one a medium")]
enum Path<'a> {
    Homogeneous { ahead: SmallVec<[Span; 1]>, at: usize },
    Voxel(Bricks<'a, AsItIs>),
    Ramped(Bricks<'a, &'a Transfer<f64>>),
}

/// The bricks ahead along a ray.
#[derive(Debug)]
struct Bricks<'a, M> {
    grid: &'a Grid<f32>,
    mapping: M,
    ray: Ray<Index>,
    walk: BrickWalk<'a>,
    brick: Option<BrickSegment>,
    /// Densities of the brick.
    range: [f64; 2],
    refined: Refined,
    /// What is left of the piece the flight is in, and its majorant as a density.
    piece: Option<(Span, f64)>,
    /// Tentative collisions in this brick before it was refined.
    collisions: u32,
    /// Bricks and constant blocks crossed.
    lookups: u64,
}

impl<'a> Flight<'a> {
    fn new(index: usize, of: &'a Medium, ray: &Ray<World>, span: Span, channels: BVec3) -> Self {
        let sigma_t = of.sigma_t_max(channels);
        let path = match &of.density {
            Density::Homogeneous(region) => {
                let mut ahead = SmallVec::new();
                region.spans(ray, span, |piece| ahead.push(piece));
                Path::Homogeneous { ahead, at: 0 }
            }
            Density::Voxel(grid) => Path::Voxel(Bricks::new(grid, AsItIs, ray, span)),
            Density::Ramped(ramped) => {
                Path::Ramped(Bricks::new(ramped.grid(), ramped.transfer(), ray, span))
            }
        };
        Self { medium: index, sigma_t, path }
    }

    fn take_lookups(&mut self) -> u64 {
        match &mut self.path {
            Path::Homogeneous { .. } => 0,
            Path::Voxel(bricks) => std::mem::take(&mut bricks.lookups),
            Path::Ramped(bricks) => std::mem::take(&mut bricks.lookups),
        }
    }

    /// The next tentative collision: spends an exponentially distributed optical thickness of
    /// majorant piece by piece.
    fn next(&mut self, rng: &mut Stream) -> Option<Collision> {
        let (medium, sigma_t) = (self.medium, self.sigma_t);
        let mut left = rng.exponential();
        match &mut self.path {
            Path::Homogeneous { ahead, at } => {
                while let Some(piece) = ahead.get_mut(*at) {
                    if let Some(t) = spend(&mut left, piece, sigma_t) {
                        let (majorant, region_majorant) = (sigma_t, sigma_t);
                        return Some(Collision {
                            t,
                            medium,
                            density: 1.0,
                            majorant,
                            region_majorant,
                        });
                    }
                    *at += 1;
                }
                None
            }
            Path::Voxel(bricks) => bricks.next(medium, sigma_t, left),
            Path::Ramped(bricks) => bricks.next(medium, sigma_t, left),
        }
    }
}

impl<'a, M: Mapping> Bricks<'a, M> {
    fn new(grid: &'a Grid<f32>, mapping: M, ray: &Ray<World>, span: Span) -> Self {
        let ray = grid.transform().ray_to_local(ray);
        let walk = grid.bricks(&ray, span);
        let refined = Refined::default();
        let (brick, piece) = (None, None);
        let (range, collisions, lookups) = ([0.0; 2], 0, 0);
        Self { grid, mapping, ray, walk, brick, range, refined, piece, collisions, lookups }
    }

    /// The next tentative collision, after the optical thickness `left` of majorant.
    fn next(&mut self, medium: usize, sigma_t: f64, mut left: f64) -> Option<Collision> {
        loop {
            if self.collisions == PATIENCE {
                self.refine(sigma_t);
            }
            if let Some((span, density)) = &mut self.piece
                && let Some(brick) = &self.brick
            {
                let majorant = sigma_t * *density;
                if let Some(t) = spend(&mut left, span, majorant) {
                    self.collisions += 1;
                    let value = self.grid.value_in(brick.brick, self.ray.at(t));
                    return Some(Collision {
                        t,
                        medium,
                        density: self.mapping.value(value).min(*density),
                        majorant,
                        region_majorant: sigma_t * self.range[1],
                    });
                }
            }
            if !self.advance() {
                return None;
            }
        }
    }

    /// Goes on to the next piece; whether there is one.
    fn advance(&mut self) -> bool {
        if let Some(brick) = &self.brick {
            self.piece = self.refined.next(brick, self.grid, self.mapping, &self.ray);
            if self.piece.is_some() {
                return true;
            }
        }
        self.brick = self.walk.next();
        self.lookups += u64::from(self.brick.is_some());
        self.collisions = 0;
        self.piece = self.brick.as_ref().map(|brick| {
            self.range = self.mapping.range([brick.min, brick.max].map(f64::from));
            (brick.span, self.range[1])
        });
        self.piece.is_some()
    }

    /// Refines what is left of the brick.
    fn refine(&mut self, sigma_t: f64) {
        self.collisions += 1; // once a brick
        if let (Some(brick), Some((rest, _))) = (&self.brick, self.piece)
            && self.refined.take_over(self.range, rest, sigma_t)
        {
            self.piece = self.refined.next(brick, self.grid, self.mapping, &self.ray);
        }
    }
}

/// Takes the optical thickness `left` out of `span` at rate `majorant`: the place where it is
/// spent, which becomes the start of the span, or nothing where the span ends first. The place
/// always moves, if only by rounding, so that no place can hold a flight for ever.
fn spend(left: &mut f64, span: &mut Span, majorant: f64) -> Option<f64> {
    let thickness = majorant * span.length();
    if *left < thickness {
        span.start = (span.start + *left / majorant).max(span.start.next_up());
        return (span.start < span.end).then_some(span.start);
    }
    *left -= if thickness.is_nan() { 0.0 } else { thickness };
    None
}
