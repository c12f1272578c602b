//! Exact integrals along rays.
//!
//! Inside one cell the trilinear value along a straight line is a cubic polynomial, which two-point
//! Gauss-Legendre quadrature integrates exactly.

use std::cell::Cell;
use std::ops::ControlFlow;

use glam::{DVec3, IVec3};
use smallvec::{SmallVec, smallvec};

use crate::math::{Index, Ray, Span};

use super::brick::{corners, number};
use super::cubic::Cubic;
use super::grid::Grid;
use super::tree::{Brick, Child};
use super::voxel::Voxel;
use super::walk::{LocalRay, Piece, Walk, smallest};

/// Half the distance between the two nodes on [-1, 1]: 1/sqrt(3).
const NODE: f64 = 0.577_350_269_189_625_8;

/// By how much the optical thickness along a straight line may differ from the exact one: light that
/// scatters there is as much too bright or too dark.
const MAX_BOW: f64 = 1.0 / 32.0;

/// Optical thickness of a cell up to which no line differs more: of all values that are nowhere below 0
/// that of u³ differs most, by a quarter of the whole.
const THIN: f64 = 4.0 * MAX_BOW;

/// Optical thickness behind which nothing is seen.
const OPAQUE: f64 = 16.0;

/// Halvings of a cell, at most: down to rounding.
const MAX_HALVINGS: usize = 48;

impl Grid<f32> {
    /// The integral of the trilinear value over t, along `ray` within `span`, exact but for
    /// rounding. In units of t: times the length of the world direction it is an optical thickness
    /// per unit of extinction.
    pub fn integrate(&self, ray: &Ray<Index>, span: Span) -> f64 {
        let mut sum = 0.0;
        let _ = self.cells(ray, span, |_, integral, _| {
            sum += integral;
            ControlFlow::Continue(())
        });
        sum
    }

    /// Hands out the pieces of `ray` within `span`, front to back: one a crossed cell, one a constant
    /// block. Blocks of zeros are left out. `f` gets the integral of the value over the piece, and by
    /// how much the value rises from its mean to the end of the piece: along the straight line
    /// through the nodes of the quadrature, which may pass below 0. It ends the walk with
    /// [`ControlFlow::Break`], which is then returned.
    #[inline]
    pub fn cells(
        &self,
        ray: &Ray<Index>,
        span: Span,
        f: impl FnMut(Span, f64, f64) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        self.lines(ray, span, 0.0, f)
    }

    /// As [`cells`](Self::cells), where an integral of 1 is an optical thickness of `unit`: cells are
    /// halved until their straight lines tell where light scatters.
    #[inline]
    pub fn lines(
        &self,
        ray: &Ray<Index>,
        span: Span,
        unit: f64,
        mut f: impl FnMut(Span, f64, f64) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let thickness = Cell::new(0.0);
        let mut walk = Walk::new(self, ray, span);
        while let Some(piece) = walk.next_piece() {
            let t0 = walk.t0;
            let mut give = |start: f64, end: f64, sum: f64, rise: f64| {
                thickness.set(thickness.get() + unit * sum);
                f(Span::new(t0 + start, t0 + end), sum, rise)
            };
            match piece.region.content {
                Child::Constant(0.0) => {}
                Child::Constant(v) => {
                    give(piece.start, piece.end, f64::from(v) * (piece.end - piece.start), 0.0)?;
                }
                Child::Node(i) => {
                    let brick = &self.tree().bricks[i as usize];
                    let [min, max] = self.tree().ranges[i as usize].map(f64::from);
                    // Rounding at a face must not leave the bounds that majorants rely on.
                    let entry = walk.ray.entry - piece.region.min.as_dvec3();
                    let direction = walk.ray.direction;
                    let mut give_within = |start: f64, end: f64, sum: f64, rise: f64| {
                        let length = end - start;
                        let (least, most) = (min * length, max * length);
                        let sum = if sum > least { sum } else { least };
                        give(start, end, if sum < most { sum } else { most }, rise)
                    };
                    brick_cells(&walk.ray, entry, &piece, &mut |cell, start, end| {
                        let (sum, rise) = cell_integral(brick, cell, entry, direction, start, end);
                        let is_hidden = || thickness.get() > OPAQUE;
                        if unit * sum <= THIN || is_hidden() {
                            return give_within(start, end, sum, rise);
                        }
                        let corners = corners(brick, number(cell & 7));
                        let local = entry - cell.as_dvec3();
                        let along = |part| cubic(corners, local, direction, part).0;
                        let is_straight = |bow: f64| unit * bow <= MAX_BOW || is_hidden();
                        halve(along, [start, end], is_straight, &mut give_within)
                    })?;
                }
            }
        }
        ControlFlow::Continue(())
    }

    /// Hands out the pieces of `ray` within `span`, front to back: one a crossed cell, one a constant
    /// block, those of 0 too, each with the value along it and bounds of that. `f` ends the walk
    /// with [`ControlFlow::Break`], which is then returned.
    pub fn cubics(
        &self,
        ray: &Ray<Index>,
        span: Span,
        mut f: impl FnMut(Span, &Cubic, [f64; 2]) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let mut walk = Walk::new(self, ray, span);
        while let Some(piece) = walk.next_piece() {
            let span = |start: f64, end: f64| Span::new(walk.t0 + start, walk.t0 + end);
            match piece.region.content {
                Child::Constant(v) => {
                    let v = f64::from(v);
                    f(span(piece.start, piece.end), &Cubic::flat(v), [v, v])?;
                }
                Child::Node(i) => {
                    let brick = &self.tree().bricks[i as usize];
                    let entry = walk.ray.entry - piece.region.min.as_dvec3();
                    let direction = walk.ray.direction;
                    brick_cells(&walk.ray, entry, &piece, &mut |cell, start, end| {
                        let corners = corners(brick, number(cell & 7));
                        let local = entry - cell.as_dvec3();
                        let (cubic, range) = cubic(corners, local, direction, [start, end]);
                        f(span(start, end), &cubic, range)
                    })?;
                }
            }
        }
        ControlFlow::Continue(())
    }
}

/// Halves what lies between two s until all parts are straight by their bow. `along` tells the value
/// between two s, and `give` gets each part, its integral and the rise to its end.
fn halve(
    along: impl Fn([f64; 2]) -> Cubic,
    [mut start, end]: [f64; 2],
    is_straight: impl Fn(f64) -> bool,
    give: &mut impl FnMut(f64, f64, f64, f64) -> ControlFlow<()>,
) -> ControlFlow<()> {
    let mut ends: SmallVec<[f64; 16]> = smallvec![end];
    while let Some(&end) = ends.last() {
        let (length, cubic) = (end - start, along([start, end]));
        let [mean, rise] = cubic.line();
        // A line that passes below 0 is made less steep.
        let bow = cubic.bow() + 0.25 * (rise.abs() - mean).max(0.0);
        if ends.len() <= MAX_HALVINGS && !is_straight(length * bow) {
            ends.push(0.5 * (start + end));
            continue;
        }
        give(start, end, length * mean, rise)?;
        start = end;
        ends.pop();
    }
    ControlFlow::Continue(())
}

/// The value over one cell of these corners between two s, and bounds of it; `local` is where in the
/// cell s is 0.
fn cubic(
    corners: [f32; 8],
    local: DVec3,
    direction: DVec3,
    [start, end]: [f64; 2],
) -> (Cubic, [f64; 2]) {
    let low = corners.into_iter().fold(f32::INFINITY, f32::min);
    let high = corners.into_iter().fold(f32::NEG_INFINITY, f32::max);
    let range = [low, high].map(f64::from);
    let value = |share: f64| {
        let p = local + direction * (start + (end - start) * share);
        f32::blend(corners, p).max(range[0]).min(range[1])
    };
    (Cubic::through([0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0].map(value)), range)
}

/// The cells of one brick (Amanatides and Woo 1987), each crossing found from the ray's entry rather
/// than by adding up; `entry` is where that is in the brick. `give` gets the cell and where the ray
/// enters and leaves it.
#[inline]
fn brick_cells(
    ray: &LocalRay,
    entry: DVec3,
    piece: &Piece<f32>,
    give: &mut impl FnMut(IVec3, f64, f64) -> ControlFlow<()>,
) -> ControlFlow<()> {
    let first = piece.cell - piece.region.min;
    let crossings = inner_crossings(ray, entry, first);
    let mut passed = IVec3::ZERO; // faces of each axis
    let mut start = piece.start;
    loop {
        let at = passed & 7; // in range already: this tells the compiler
        let (nearest, axis) = smallest(DVec3::new(
            crossings[0][at.x as usize],
            crossings[1][at.y as usize],
            crossings[2][at.z as usize],
        ));
        let leaves = nearest >= piece.end;
        let end = if leaves { piece.end } else { nearest };
        if end > start {
            give(first + passed * ray.step, start, end)?;
            start = end;
        }
        if leaves {
            return ControlFlow::Continue(());
        }
        passed += IVec3::from(axis);
    }
}

/// Where a ray that enters a brick through the cell `first` crosses the faces between its cells, for
/// each axis in turn; infinity after the last.
#[inline]
fn inner_crossings(ray: &LocalRay, entry: DVec3, first: IVec3) -> [[f64; 8]; 3] {
    let face = ray.far_faces(first, first + 1).as_dvec3() - entry;
    let inner = ray.far_faces(first, 7 - first);
    let step = ray.step.as_dvec3();
    let mut crossings = [[f64::INFINITY; 8]; 3];
    for k in 0..7 {
        let at = ray.crossings(face + step * f64::from(k));
        for axis in 0..3 {
            crossings[axis][k as usize] = if k < inner[axis] { at[axis] } else { f64::INFINITY };
        }
    }
    crossings
}

/// The integral over one cell between two s, and the rise to the second.
#[inline]
fn cell_integral(
    brick: &Brick<f32>,
    cell: IVec3,
    entry: DVec3,
    direction: DVec3,
    start: f64,
    end: f64,
) -> (f64, f64) {
    let corners = corners(brick, number(cell & 7)); // in range already: this tells the compiler
    let (middle, half) = ((start + end) * 0.5, (end - start) * 0.5);
    let origin = entry - cell.as_dvec3() + direction * middle;
    let offset = direction * (half * NODE);
    let (first, last) =
        (f32::blend(corners, origin - offset), f32::blend(corners, origin + offset));
    (half * (first + last), (last - first) * (0.5 / NODE))
}
