//! Grids under a transfer function.

use std::ops::ControlFlow;

use crate::math::{Aabb, Index, IndexPoint, Ray, Rgb, Span, Spectrum, WorldPoint};
use crate::vdb::{Cubic, Grid};

use super::transfer::Transfer;

/// Distance of either node of Gauss-Legendre quadrature from the middle of a piece, in half pieces.
const NODE: f64 = 0.577_350_269_189_625_8;

/// A grid whose interpolated values stand for others.
#[derive(Debug, Clone)]
pub struct Ramped<V> {
    grid: Grid<f32>,
    transfer: Transfer<V>,
    /// Largest channel inside the bounds.
    peak: f64,
    /// Volume of the regions that may be above 0, in voxels.
    volume: f64,
}

impl<V: Spectrum> Ramped<V> {
    /// `grid` under `transfer`. Where a value of 0 stands for more than that it fills the box of
    /// the active voxels.
    pub fn new(grid: Grid<f32>, transfer: Transfer<V>) -> Self {
        let grid = if transfer.at(0.0) == V::ZERO { grid } else { grid.filled() };
        let (mut peak, mut volume) = (0.0f64, 0.0);
        grid.for_each_range(|cells, range| {
            let here = transfer.peak(range.map(f64::from));
            peak = peak.max(here);
            volume += if here > 0.0 { cells.size().element_product() } else { 0.0 };
        });
        Self { grid, transfer, peak, volume }
    }

    /// The grid.
    pub const fn grid(&self) -> &Grid<f32> {
        &self.grid
    }

    /// What its values stand for.
    pub const fn transfer(&self) -> &Transfer<V> {
        &self.transfer
    }

    /// The largest channel anywhere inside the bounds.
    pub const fn peak(&self) -> f64 {
        self.peak
    }

    /// Volume of the regions that may be above 0, in voxels.
    pub const fn occupied_volume(&self) -> f64 {
        self.volume
    }

    /// The value at `p`, inside the grid's bounds or not.
    pub fn at(&self, p: WorldPoint) -> V {
        self.transfer.at(self.grid.value(self.grid.transform().point_to_local(p)))
    }

    /// The value at `p` of a medium, which is vacuum outside the grid's bounds.
    pub fn inside(&self, p: WorldPoint) -> V {
        let p = self.grid.transform().point_to_local(p);
        if self.grid.bounds().contains(p) { self.transfer.at(self.grid.value(p)) } else { V::ZERO }
    }

    /// The largest channel in the region round `p` of index space; 0 outside the bounds.
    pub fn peak_at(&self, p: IndexPoint) -> f64 {
        self.grid.range_at(p).map_or(0.0, |range| self.transfer.peak(range.map(f64::from)))
    }

    /// Calls `f` with each brick and constant block that may be above 0, cut to the bounds.
    pub fn for_each_occupied(&self, mut f: impl FnMut(Aabb<Index>)) {
        self.grid.for_each_range(|cells, range| {
            if self.transfer.peak(range.map(f64::from)) > 0.0 {
                f(cells);
            }
        });
    }

    /// Hands out the pieces of `ray` within `span`, front to back, as [`Grid::cells`] does: with the
    /// integral of the value over each, exact but for rounding, and its rise. A piece ends where
    /// the grid's value crosses a knot of the transfer function: between those the value is a cubic.
    pub fn cells(
        &self,
        ray: &Ray<Index>,
        span: Span,
        mut f: impl FnMut(Span, V, V) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        self.grid.cubics(ray, span, |whole, cubic, range| {
            let length = whole.length();
            let place = |u: f64| if u < 1.0 { whole.start + u * length } else { whole.end };
            self.along(cubic, range, |start, end, first, last| {
                let span = Span::new(place(start), place(end));
                f(span, (first + last) * (0.5 * span.length()), (last - first) * (0.5 / NODE))
            })
        })
    }

    /// Calls `f` for the parts of `cubic`, whose values lie in `range`, between knots: with their
    /// ends and the values at both nodes of the quadrature.
    fn along(
        &self,
        cubic: &Cubic,
        range: [f64; 2],
        mut f: impl FnMut(f64, f64, V, V) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let mut give = |start: f64, end: f64, line: super::transfer::Line<V>| {
            let [a, b] = cubic.at_nodes(start, end).map(|v| line.value(v).not_negative());
            f(start, end, a, b)
        };
        if let Some(line) = self.transfer.only_line(range) {
            return give(0.0, 1.0, line);
        }
        for part in cubic.monotone_parts().windows(2) {
            let values = [cubic.at(part[0]), cubic.at(part[1])];
            let crossing = |value, from, to| cubic.crossing(value, from, to);
            self.transfer.for_each_line((part[0], part[1]), values, crossing, &mut give)?;
        }
        ControlFlow::Continue(())
    }

    /// Values at even steps as [`Grid::samples`] hands them out: regions of the value 0 are passed.
    pub fn samples(
        &self,
        ray: &Ray<Index>,
        span: Span,
        first: f64,
        dt: f64,
        mut f: impl FnMut(f64, V),
    ) {
        let counts = |value: f32| self.transfer.at(f64::from(value)) != V::ZERO;
        self.grid.samples_where(ray, span, first, dt, counts, |t, v| f(t, self.transfer.at(v)));
    }
}

impl Ramped<Rgb> {
    /// Whether all that values can stand for is grey.
    pub fn is_grey(&self) -> bool {
        self.transfer.is_grey()
    }
}
