//! Majorants along a ray where that of a brick is far too loose.
//!
//! One voxel of a million in thin smoke makes the brick's majorant bring millions of tentative
//! collisions to a ray that passes it. Once a crossing has had its fill of null collisions, the rest
//! of it is bisected until each piece brings few, or its density hardly varies, so that one in two
//! is real. The rate depends on the past of the flight alone, so that estimates stay unbiased.

use glam::DVec3;

use crate::math::{Index, Point, Ray, Span};
use crate::vdb::{BrickSegment, Grid};

use super::mapping::Mapping;

/// Tentative collisions of a crossing after which the rest is refined.
pub(super) const PATIENCE: u32 = 16;

/// Tentative collisions, in the mean, that the rest may bring beside real ones.
const MANY: f64 = 64.0;

/// How much the density may vary within a piece that brings more.
const VARIATION: f64 = 2.0;

/// Relative rounding of places and of values at them.
const ROUNDING: f64 = 1e-13;

/// What is ahead of a flight within one brick.
#[derive(Debug, Default)]
pub(super) struct Refined {
    /// Pieces with bounds of the density, the nearest last.
    ahead: Vec<(Span, [f64; 2])>,
    /// Least majorant, as a density: a lower one would save next to nothing.
    floor: f64,
}

impl Refined {
    /// Takes over the `rest` of a brick with the densities `range` where its majorant would bring
    /// many collisions more; `sigma_t` (1/m) is the largest extinction coefficient for density 1.
    pub fn take_over(&mut self, range: [f64; 2], rest: Span, sigma_t: f64) -> bool {
        self.floor = MANY / (sigma_t * rest.length());
        let worth = range[1] > self.floor && range[1] > VARIATION * range[0];
        if worth {
            self.ahead.push((rest, range));
        }
        worth
    }

    /// The next piece of `segment` and its majorant as a density, which `mapping` makes of the
    /// values of `grid`.
    pub fn next(
        &mut self,
        segment: &BrickSegment,
        grid: &Grid<f32>,
        mapping: impl Mapping,
        ray: &Ray<Index>,
    ) -> Option<(Span, f64)> {
        let (mut span, mut range) = self.ahead.pop()?;
        loop {
            let [min, max] = range;
            let middle = 0.5 * (span.start + span.end);
            let (a, b) = (ray.at(span.start).xyz, ray.at(span.end).xyz);
            let margin = ROUNDING * (a.abs().max(b.abs()).max(DVec3::ONE));
            let resolved = (b - a).abs().cmpgt(margin).any();
            if max <= self.floor || max <= VARIATION * min || !resolved {
                return Some((span, max.max(self.floor)));
            }
            let bounds = |span: Span| {
                let (a, b) = (ray.at(span.start).xyz, ray.at(span.end).xyz);
                let (low, high) = (a.min(b) - margin, a.max(b) + margin);
                let (low, high) = (Point::from_xyz(low), Point::from_xyz(high));
                let [low, high] = mapping.range(grid.range_in(segment.brick, low, high));
                // Samples round a box hold for parts of it as well.
                [low.max(min), high.min(max)]
            };
            let (near, far) = (Span::new(span.start, middle), Span::new(middle, span.end));
            self.ahead.push((far, bounds(far)));
            (span, range) = (near, bounds(near));
        }
    }
}
