//! Free flight by null-collision tracking with local majorants.
//!
//! Tentative collisions of one medium form a Poisson process along the ray whose rate is its
//! majorant, piecewise constant over bricks (Woodcock et al. 1965; Novák et al. 2018, section 4).
//! Overlapping media are independent processes, so the first tentative collision of all of them is
//! the nearest of the firsts, and only the medium that had it needs a new one.

use smallvec::SmallVec;

use crate::math::{Index, Ray, Span, Stream, World};
use crate::vdb::{BrickSegment, BrickWalk, Grid};

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
    /// Majorant of the medium there, 1/m, over all channels.
    pub majorant: f64,
}

/// The tentative collisions of several media along one ray, front to back.
#[derive(Debug)]
pub struct Flights<'a> {
    flights: SmallVec<[(Flight<'a>, Option<Collision>); 1]>,
}

impl<'a> Flights<'a> {
    /// Starts along `ray` (unit direction) within `span`.
    pub fn start(
        media: impl IntoIterator<Item = &'a Medium>,
        ray: &Ray<World>,
        span: Span,
        rng: &mut Stream,
    ) -> Self {
        let start = |(index, medium)| {
            let mut flight = Flight::new(index, medium, ray, span);
            let first = flight.next(rng);
            (flight, first)
        };
        Self { flights: media.into_iter().enumerate().map(start).collect() }
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
        self.flights.iter_mut().map(|(flight, _)| std::mem::take(&mut flight.lookups)).sum()
    }
}

/// The tentative collisions of one medium.
#[derive(Debug)]
struct Flight<'a> {
    medium: usize,
    /// Largest extinction coefficient per unit of density, 1/m.
    sigma_t: f64,
    path: Path<'a>,
    lookups: u64,
}

#[derive(Debug)]
#[allow(clippy::large_enum_variant, reason = "it lives on the stack, one a medium")]
enum Path<'a> {
    Homogeneous { ahead: SmallVec<[Span; 1]>, at: usize },
    Voxel { grid: &'a Grid<f32>, ray: Ray<Index>, walk: BrickWalk<'a>, brick: Option<BrickSegment> },
}

impl<'a> Flight<'a> {
    fn new(medium: usize, of: &'a Medium, ray: &Ray<World>, span: Span) -> Self {
        let path = match &of.density {
            Density::Homogeneous(region) => {
                let mut ahead = SmallVec::new();
                region.spans(ray, span, |piece| ahead.push(piece));
                Path::Homogeneous { ahead, at: 0 }
            }
            Density::Voxel(grid) => {
                let ray = grid.transform().ray_to_local(ray);
                let mut walk = grid.bricks(&ray, span);
                let brick = walk.next();
                Path::Voxel { grid, ray, walk, brick }
            }
        };
        Self { medium, sigma_t: of.sigma_t_max(), path, lookups: 0 }
    }

    /// The next tentative collision: spends an exponentially distributed optical thickness of
    /// majorant piece by piece.
    fn next(&mut self, rng: &mut Stream) -> Option<Collision> {
        let (medium, sigma_t) = (self.medium, self.sigma_t);
        let mut left = rng.exponential();
        match &mut self.path {
            Path::Homogeneous { ahead, at } => {
                while let Some(piece) = ahead.get_mut(*at) {
                    match spend(&mut left, piece, sigma_t) {
                        Some(t) => {
                            return Some(Collision { t, medium, density: 1.0, majorant: sigma_t });
                        }
                        None => *at += 1,
                    }
                }
            }
            Path::Voxel { grid, ray, walk, brick } => {
                while let Some(segment) = brick {
                    self.lookups += 1;
                    let majorant = sigma_t * f64::from(segment.max);
                    match spend(&mut left, &mut segment.span, majorant) {
                        Some(t) => {
                            let density = grid.value_in(segment.brick, ray.at(t));
                            return Some(Collision { t, medium, density, majorant });
                        }
                        None => *brick = walk.next(),
                    }
                }
            }
        }
        None
    }
}

/// Takes the optical thickness `left` out of `span` at rate `majorant`: the place where it is
/// spent, which becomes the start of the span, or nothing where the span ends first.
fn spend(left: &mut f64, span: &mut Span, majorant: f64) -> Option<f64> {
    let thickness = majorant * span.length();
    if *left < thickness {
        span.start += *left / majorant;
        return (span.start < span.end).then_some(span.start);
    }
    *left -= if thickness.is_nan() { 0.0 } else { thickness };
    None
}
