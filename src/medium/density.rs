//! Where a medium is, and how dense.

use std::ops::ControlFlow;

use crate::math::{Aabb, Index, Ray, Span, World, WorldPoint};
use crate::shape::Region;
use crate::vdb::Grid;
use crate::work::Work;

use super::piece::Ramp;
use super::ramped::Ramped;

/// The density field of a medium, without unit.
#[derive(Debug)]
#[allow(clippy::large_enum_variant, reason = "there is one a medium")]
pub enum Density {
    /// 1 inside the region, 0 outside.
    Homogeneous(Region),
    /// A voxel grid, trilinear between samples, 0 outside its [`bounds`](Grid::bounds).
    Voxel(Grid<f32>),
    /// What the values of a voxel grid stand for, 0 outside its bounds.
    Ramped(Ramped<f64>),
}

impl Density {
    /// The density at `p`.
    pub fn value(&self, p: WorldPoint) -> f64 {
        match self {
            Self::Homogeneous(region) => f64::from(u8::from(region.contains(p))),
            Self::Voxel(grid) => {
                let p = grid.transform().point_to_local(p);
                if grid.bounds().contains(p) { grid.value(p) } else { 0.0 }
            }
            Self::Ramped(ramped) => ramped.inside(p),
        }
    }

    /// The grid, where there is one.
    pub const fn grid(&self) -> Option<&Grid<f32>> {
        match self {
            Self::Homogeneous(_) => None,
            Self::Voxel(grid) => Some(grid),
            Self::Ramped(ramped) => Some(ramped.grid()),
        }
    }

    /// An upper bound of the density in the neighbourhood of `p` that free flight uses there: the
    /// largest sample of the brick for a grid.
    pub fn majorant(&self, p: WorldPoint) -> f64 {
        match self {
            Self::Homogeneous(_) => self.value(p),
            Self::Voxel(grid) => {
                let range = grid.range_at(grid.transform().point_to_local(p));
                range.map_or(0.0, |[_, max]| f64::from(max))
            }
            Self::Ramped(ramped) => ramped.peak_at(ramped.grid().transform().point_to_local(p)),
        }
    }

    /// The integral of the density over `span` of `ray` (unit direction), in metres: exact, by a
    /// closed form or cell by cell. `work` counts the steps.
    pub fn integrate(&self, ray: &Ray<World>, span: Span, work: &mut Work) -> f64 {
        let (mut sum, mut steps) = (0.0, 0);
        match self {
            Self::Homogeneous(region) => region.spans(ray, span, |piece| {
                sum += piece.length();
                steps += 1;
            }),
            Self::Voxel(grid) => {
                let _ = grid.cells(&grid.transform().ray_to_local(ray), span, |_, integral, _| {
                    sum += integral;
                    steps += 1;
                    ControlFlow::Continue(())
                });
                work.grid_lookups += steps;
            }
            Self::Ramped(ramped) => {
                let ray = ramped.grid().transform().ray_to_local(ray);
                let _ = ramped.cells(&ray, span, |_, integral, _| {
                    sum += integral;
                    steps += 1;
                    ControlFlow::Continue(())
                });
                work.grid_lookups += steps;
            }
        }
        work.march_steps += steps;
        sum
    }

    /// Whether it is a voxel grid.
    pub const fn is_voxel(&self) -> bool {
        matches!(self, Self::Voxel(_) | Self::Ramped(_))
    }

    /// Hands out consecutive pieces of `ray` (unit direction) front to back, each with its density.
    /// Where density is 0 there need be no piece.
    ///
    /// Homogeneous media give one piece a region crossing. Grids give one piece a crossed cell,
    /// integrated exactly, where `step` is at most a voxel; otherwise one piece of `step` metres
    /// each, by one sample at the fraction `jitter` of it. A little less than `step` divides the
    /// part of `span` inside the grid evenly, so that the mean over `jitter` is the exact integral.
    /// A cell without transfer function gives several where it is thick by the extinction coefficient
    /// `sigma_t` per unit of density, 1/m: within each a straight line tells where light scatters.
    pub(super) fn pieces(
        &self,
        ray: &Ray<World>,
        span: Span,
        [step, jitter]: [f64; 2],
        sigma_t: f64,
        mut f: impl FnMut(Span, Ramp),
    ) {
        match self {
            Self::Homogeneous(region) => {
                region.spans(ray, span, |piece| f(piece, Ramp::flat(1.0)));
            }
            Self::Voxel(grid) => {
                let local = grid.transform().ray_to_local(ray);
                if step <= grid.transform().unit_lengths().max_element() {
                    let _ = grid.lines(&local, span, sigma_t, |piece, integral, rise| {
                        f(piece, Ramp::new(integral / piece.length(), rise));
                        ControlFlow::Continue(())
                    });
                } else if let Some((span, step)) = even_steps(grid, &local, span, step) {
                    let lead = jitter * step;
                    grid.samples(&local, span, span.start + lead, step, |t, value| {
                        let piece = Span::new(t - lead, t - lead + step).intersect(span);
                        f(piece, Ramp::flat(value));
                    });
                }
            }
            Self::Ramped(ramped) => {
                let grid = ramped.grid();
                let local = grid.transform().ray_to_local(ray);
                if step <= grid.transform().unit_lengths().max_element() {
                    let _ = ramped.cells(&local, span, |piece, integral, rise| {
                        if integral > 0.0 {
                            f(piece, Ramp::new(integral / piece.length(), rise));
                        }
                        ControlFlow::Continue(())
                    });
                } else if let Some((span, step)) = even_steps(grid, &local, span, step) {
                    let lead = jitter * step;
                    ramped.samples(&local, span, span.start + lead, step, |t, value| {
                        let piece = Span::new(t - lead, t - lead + step).intersect(span);
                        f(piece, Ramp::flat(value));
                    });
                }
            }
        }
    }

    /// The box that holds all of it; nothing where it is endless.
    pub fn bounds(&self) -> Option<Aabb<World>> {
        match self {
            Self::Homogeneous(region) => region.bounds(),
            Self::Voxel(grid) => Some(grid.transform().box_to_world(grid.bounds())),
            Self::Ramped(ramped) => {
                let grid = ramped.grid();
                Some(grid.transform().box_to_world(grid.bounds()))
            }
        }
    }

    /// The largest density anywhere.
    pub fn maximum(&self) -> f64 {
        match self {
            Self::Homogeneous(_) => 1.0,
            Self::Voxel(grid) => f64::from(grid.max_inside()),
            Self::Ramped(ramped) => ramped.peak(),
        }
    }

    /// The volume where it is not 0, in m³, to the brick; nothing where it is endless.
    pub fn volume(&self) -> Option<f64> {
        match self {
            Self::Homogeneous(region) => region.volume(),
            Self::Voxel(grid) => Some(grid.occupied_volume() * grid.transform().volume_scale()),
            Self::Ramped(ramped) => {
                Some(ramped.occupied_volume() * ramped.grid().transform().volume_scale())
            }
        }
    }

    /// The finest detail, in metres: the shortest voxel edge, or nothing where there is no grid.
    pub fn detail(&self) -> Option<f64> {
        self.grid().map(|grid| grid.transform().unit_lengths().min_element())
    }
}

/// The part of `span` inside the grid, so that no step is wider than what holds anything, and a step
/// of at most `step` that divides it evenly; nothing where the ray misses it.
fn even_steps(grid: &Grid<f32>, ray: &Ray<Index>, span: Span, step: f64) -> Option<(Span, f64)> {
    let span = grid.bounds().clip(ray).intersect(span);
    let steps = (span.length() / step).ceil().max(1.0);
    (!span.is_empty()).then(|| (span, span.length() / steps))
}
