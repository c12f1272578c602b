//! Walking a ray through the tree, region by region.
//!
//! The place is kept as the integer cell the ray is in. Leaving a region sets the coordinate across
//! the face from the face itself; the others follow from the ray but are held inside the region and
//! never go back. So the walk cannot stall or turn round, whatever rounding does, and each step
//! advances at least one coordinate.

use glam::{BVec3, DVec3, IVec3};

use crate::math::{Index, IndexPoint, Ray, Span};

use super::brick::{in_brick, number};
use super::grid::Grid;
use super::tree::{Child, Cursor, Region, SIDE, Tree};
use super::voxel::Voxel;

/// A ray counted from the place where it enters the grid: s = t - t of entry. Distances are then
/// small however far away the ray began.
#[derive(Debug, Clone, Copy)]
pub(super) struct LocalRay {
    pub(super) entry: DVec3,
    pub(super) direction: DVec3,
    /// Reciprocal of the direction; 0 along an axis the ray does not move on.
    inverse: DVec3,
    /// Added to a crossing: infinity along an axis the ray does not move on.
    never: DVec3,
    /// 1 or -1 along each axis.
    pub(super) step: IVec3,
}

impl LocalRay {
    fn new(entry: DVec3, direction: DVec3) -> Self {
        let still = direction.abs().cmplt(DVec3::splat(1e-290));
        let direction = DVec3::select(still, DVec3::ZERO, direction);
        Self {
            entry,
            direction,
            inverse: DVec3::select(still, DVec3::ZERO, direction.recip()),
            never: DVec3::select(still, DVec3::INFINITY, DVec3::ZERO),
            step: IVec3::select(direction.cmplt(DVec3::ZERO), IVec3::NEG_ONE, IVec3::ONE),
        }
    }

    pub(super) fn at(&self, s: f64) -> DVec3 {
        self.entry + self.direction * s
    }

    /// Where the ray crosses the planes `face` of each axis, given relative to the entry.
    #[inline]
    pub(super) fn crossings(&self, face: DVec3) -> DVec3 {
        face * self.inverse + self.never
    }

    /// Of a block of cells, the face the ray leaves through, on each axis.
    #[inline]
    pub(super) fn far_faces(&self, min: IVec3, end: IVec3) -> IVec3 {
        IVec3::select(self.step.cmpgt(IVec3::ZERO), end, min)
    }
}

/// The smallest number and its axis, the first of equal ones; nothing branches on the axis, which
/// no processor can foresee.
#[inline]
pub(super) fn smallest(v: DVec3) -> (f64, BVec3) {
    let x = (v.x <= v.y) & (v.x <= v.z);
    let y = !x & (v.y <= v.z);
    let xy = if v.x < v.y { v.x } else { v.y };
    (if xy < v.z { xy } else { v.z }, BVec3::new(x, y, !(x | y)))
}

/// The cell that holds `p`, whose coordinates lie within ±2^31.
#[inline]
fn cell_of(p: DVec3) -> IVec3 {
    // Adding this rounds to a whole number and leaves it in the lowest bits, in two's complement.
    const WHOLE: f64 = 1.5 * (1u64 << 52) as f64;
    let floor = |x: f64| {
        let rounded = x + WHOLE;
        rounded.to_bits() as i32 - i32::from(rounded - WHOLE > x)
    };
    IVec3::new(floor(p.x), floor(p.y), floor(p.z))
}

/// A region with the piece of the ray inside, in s.
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece<V> {
    pub(super) region: Region<V>,
    /// The cell the ray enters through.
    pub(super) cell: IVec3,
    pub(super) start: f64,
    pub(super) end: f64,
}

/// The regions a ray crosses inside the grid's bounds, front to back and without gaps.
#[derive(Debug, Clone)]
pub(super) struct Walk<'a, V> {
    pub(super) ray: LocalRay,
    /// t of s = 0.
    pub(super) t0: f64,
    /// Where the bounds are left.
    end: f64,
    s: f64,
    cell: IVec3,
    /// Whether regions are ahead.
    goes_on: bool,
    cursor: Cursor<'a, V>,
}

impl<'a, V: Voxel> Walk<'a, V> {
    pub(super) fn new(grid: &'a Grid<V>, ray: &Ray<Index>, span: Span) -> Self {
        let finite = ray.origin.xyz.is_finite() && ray.direction.is_finite();
        let inside = if finite && !grid.bounds().is_empty() {
            grid.bounds().clip(ray).intersect(span)
        } else {
            Span::new(0.0, 0.0)
        };
        let hits = !inside.is_empty() && inside.start.is_finite() && inside.end.is_finite();
        let t0 = if hits { inside.start } else { 0.0 };
        let local = LocalRay::new(ray.at(t0).xyz, ray.direction);
        let cells = grid.medium_cells();
        Self {
            ray: local,
            t0,
            end: inside.end - t0,
            s: 0.0,
            cell: if hits {
                cell_of(local.entry).clamp(cells.min, cells.end - 1)
            } else {
                IVec3::ZERO
            },
            goes_on: hits,
            cursor: Cursor::new(grid.tree()),
        }
    }

    /// A ray parameter from an s.
    pub(super) fn t(&self, s: f64) -> f64 {
        self.t0 + s
    }

    /// The next piece; pieces of no length are left out. Always inlined: the walk then stays in
    /// registers.
    #[inline(always)]
    pub(super) fn next_piece(&mut self) -> Option<Piece<V>> {
        while self.goes_on {
            let piece = self.step();
            if piece.end > piece.start {
                return Some(piece);
            }
        }
        None
    }

    /// Crosses the region of the current cell.
    #[inline(always)]
    fn step(&mut self) -> Piece<V> {
        let (cell, start) = (self.cell, self.s);
        let region = self.cursor.region(cell);
        let faces = self.ray.far_faces(region.min, region.end());
        let crossings = self.ray.crossings(faces.as_dvec3() - self.ray.entry);
        let (end, axis) = smallest(crossings);
        if end < self.end {
            self.s = end.max(start);
            let there = cell_of(self.ray.at(self.s)).clamp(region.min, region.end() - 1);
            let forward = self.ray.step.cmpgt(IVec3::ZERO);
            let onward = IVec3::select(forward, there.max(cell), there.min(cell));
            let beyond = IVec3::select(forward, faces, faces - 1);
            self.cell = IVec3::select(axis, beyond, onward);
        } else {
            self.s = self.end;
            self.goes_on = false;
        }
        Piece { region, cell, start, end: self.s }
    }
}

/// Opposite corner of a brick, in its own coordinates.
const END: DVec3 = DVec3::splat((SIDE - 1) as f64);

/// A part of a grid in which sampling needs no search: a brick of 8³ cells, or a constant block.
#[derive(Debug, Clone, Copy)]
pub struct BrickRef {
    pub(super) region: Region<f32>,
}

/// A piece of a ray inside one brick or constant block.
#[derive(Debug, Clone, Copy)]
pub struct BrickSegment {
    /// The piece, in the ray's parameter.
    pub span: Span,
    /// No value in the region is smaller.
    pub min: f32,
    /// No value in the region is larger: a majorant of the trilinear value, reached at a voxel.
    pub max: f32,
    /// The region, for [`Grid::value_in`].
    pub brick: BrickRef,
}

/// The regions along a ray, front to back and without gaps; see [`Grid::bricks`].
#[derive(Debug, Clone)]
pub struct BrickWalk<'a> {
    tree: &'a Tree<f32>,
    walk: Walk<'a, f32>,
}

impl Iterator for BrickWalk<'_> {
    type Item = BrickSegment;

    #[inline]
    fn next(&mut self) -> Option<BrickSegment> {
        let piece = self.walk.next_piece()?;
        let [min, max] = self.tree.range_of(piece.region.content);
        Some(BrickSegment {
            span: Span::new(self.walk.t(piece.start), self.walk.t(piece.end)),
            min,
            max,
            brick: BrickRef { region: piece.region },
        })
    }
}

impl Grid<f32> {
    /// The regions that `ray` crosses within `span`: bricks of 8³ cells and constant blocks of any
    /// size, each with the bounds of its values. They follow one another without gaps through the
    /// grid's [`bounds`](Self::bounds).
    pub fn bricks(&self, ray: &Ray<Index>, span: Span) -> BrickWalk<'_> {
        BrickWalk { tree: self.tree(), walk: Walk::new(self, ray, span) }
    }

    /// Bounds of the trilinear value over the box between two places inside the region `brick`: but
    /// for rounding its exact range where the box spans two cells along each axis at most, and that
    /// of the samples round it elsewhere.
    pub fn range_in(&self, brick: BrickRef, a: IndexPoint, b: IndexPoint) -> [f64; 2] {
        let Child::Node(i) = brick.region.content else {
            return self.tree().range_of(brick.region.content).map(f64::from);
        };
        let samples = &self.tree().bricks[i as usize];
        let local = |p: DVec3| (p - brick.region.min.as_dvec3()).clamp(DVec3::ZERO, END);
        let (low, high) = (local(a.xyz.min(b.xyz)), local(a.xyz.max(b.xyz)));
        let (first, end) = (low.floor().as_ivec3(), high.ceil().as_ivec3());
        let mut range = [f64::INFINITY, f64::NEG_INFINITY];
        let mut include = |v: f64| range = [range[0].min(v), range[1].max(v)];
        if (end - first).max_element() <= 2 {
            // A trilinear function takes its extremes over a box at corners of it; faces between
            // cells cut the box into such boxes.
            let cut = (first + 1).as_dvec3().clamp(low, high);
            let along = |axis: usize| [low[axis], cut[axis], high[axis]];
            let (x, y, z) = (along(0), along(1), along(2));
            for i in 0..27 {
                let corner = DVec3::new(x[i / 9], y[i / 3 % 3], z[i % 3]);
                include(in_brick(samples, corner));
            }
        } else {
            for x in first.x..=end.x {
                for y in first.y..=end.y {
                    let row = number(IVec3::new(x, y, first.z));
                    let row = &samples[row..=row + (end.z - first.z) as usize];
                    row.iter().for_each(|v| include(f64::from(*v)));
                }
            }
        }
        range
    }

    /// The trilinear value at a place inside the region `brick`, without a search, and never
    /// outside the bounds of the region's [`BrickSegment`].
    #[inline]
    pub fn value_in(&self, brick: BrickRef, p: IndexPoint) -> f64 {
        match brick.region.content {
            Child::Constant(v) => f64::from(v),
            Child::Node(i) => {
                let local = p.xyz - brick.region.min.as_dvec3();
                let [min, max] = self.tree().ranges[i as usize].map(f64::from);
                let value = in_brick(&self.tree().bricks[i as usize], local);
                value.max(min).min(max)
            }
        }
    }
}
