//! Trilinear values: at a point, and at even steps along a ray.

use glam::{DVec3, IVec3};

use crate::math::{Index, IndexPoint, Ray, Span};

use super::grid::Grid;
use super::tree::{Brick, Child, Cursor, SIDE};
use super::voxel::Voxel;
use super::walk::Walk;

/// Added to a number in [0, 8], this leaves it in the sum's lowest bits as a fixed-point number with
/// [`FRACTION`] bits after the point: truncation without a conversion, which would have to saturate.
const FIXED: f64 = 1.5 * (1u64 << (52 - FRACTION)) as f64;
const FRACTION: u32 = 40;
/// The whole part of a fixed-point number in the last cell.
const LAST: u64 = (FIXED.to_bits() >> FRACTION) + 7;

/// One coordinate of a place in a brick: the cell, and where in the cell, in [0, 1], to 2^-40.
#[inline]
fn split(coordinate: f64) -> (usize, f64) {
    let low = if coordinate > 0.0 { coordinate } else { 0.0 }; // and where it is not a number
    let fixed = if low < 8.0 { low } else { 8.0 } + FIXED;
    let whole = (fixed.to_bits() >> FRACTION).min(LAST);
    (whole as usize & 7, fixed - f64::from_bits(whole << FRACTION))
}

/// Distance between neighbours along x in a brick; along y it is [`SIDE`], along z 1.
const ROW: usize = SIDE * SIDE;

/// The eight corners of the cell whose smallest corner is voxel `i`, numbered 4 x + 2 y + z.
#[inline]
pub(super) fn corners<V: Voxel>(voxels: &[V], i: usize) -> [V; 8] {
    let c = &voxels[i..=i + ROW + SIDE + 1];
    [c[0], c[1], c[SIDE], c[SIDE + 1], c[ROW], c[ROW + 1], c[ROW + SIDE], c[ROW + SIDE + 1]]
}

/// Number of a cell's smallest corner in its brick.
#[inline]
pub(super) fn number(cell: IVec3) -> usize {
    cell.x as usize * ROW + cell.y as usize * SIDE + cell.z as usize
}

/// The cell that holds `local`, a place in [0, 8]³ of a brick, by its [`number`], and where in it.
#[inline]
fn locate(local: DVec3) -> (usize, DVec3) {
    let ((x, u), (y, v), (z, w)) = (split(local.x), split(local.y), split(local.z));
    (x * ROW + y * SIDE + z, DVec3::new(u, v, w))
}

/// The trilinear value at `local` in [0, 8]³ of a brick.
#[inline]
pub(super) fn in_brick<V: Voxel>(brick: &Brick<V>, local: DVec3) -> V::Sample {
    let (number, u) = locate(local);
    V::blend(corners(brick, number), u)
}

/// Samples a batch holds.
const BATCH: usize = 32;

/// Samples that are located one after another and read together, even out of several bricks: memory
/// is then asked for many of them at once, where each alone would have to wait for it.
struct Batch<'a> {
    voxels: &'a [f32],
    len: usize,
    t: [f64; BATCH],
    corner: [usize; BATCH],
    u: [DVec3; BATCH],
}

impl<'a> Batch<'a> {
    fn new(bricks: &'a [Brick<f32>]) -> Self {
        let voxels = bricks.as_flattened();
        Self { voxels, len: 0, t: [0.0; BATCH], corner: [0; BATCH], u: [DVec3::ZERO; BATCH] }
    }

    /// Adds the sample at `t`, at `local` of the brick that begins with voxel `first`.
    #[inline]
    fn push(&mut self, t: f64, first: usize, local: DVec3, f: &mut impl FnMut(f64, f64)) {
        if self.len == BATCH {
            self.flush(f);
        }
        let (number, u) = locate(local);
        let at = self.len % BATCH;
        (self.t[at], self.corner[at], self.u[at]) = (t, first + number, u);
        self.len += 1;
    }

    /// Hands out what is there.
    #[inline]
    fn flush(&mut self, f: &mut impl FnMut(f64, f64)) {
        let samples = self.t.iter().zip(&self.corner).zip(&self.u).take(self.len);
        for ((&t, &corner), &u) in samples {
            f(t, f32::blend(corners(self.voxels, corner), u));
        }
        self.len = 0;
    }
}

impl<V: Voxel> Grid<V> {
    /// The trilinear value at `p`, inside the medium's bounds or not: what OpenVDB's `BoxSampler`
    /// gives there.
    pub fn value(&self, p: IndexPoint) -> V::Sample {
        if !self.stored().contains(p) {
            return self.background().sample(); // and where p is not a number
        }
        let cells = self.extent();
        let cell = p.xyz.floor().as_ivec3().clamp(cells.min, cells.end - 1);
        let region = Cursor::new(self.tree()).region(cell);
        match region.content {
            Child::Constant(v) => v.sample(),
            Child::Node(i) => {
                in_brick(&self.tree().bricks[i as usize], p.xyz - region.min.as_dvec3())
            }
        }
    }
}

impl Grid<f32> {
    /// Trilinear values at t = `first` + k `dt`, k = 0, 1, ..., as far as they lie in `span`, inside
    /// the [`bounds`](Self::bounds) and not in an empty region: `f` gets t and the value. Regions of
    /// zeros are passed in one step. Nothing happens unless `dt` is positive.
    #[inline]
    pub fn samples(
        &self,
        ray: &Ray<Index>,
        span: Span,
        first: f64,
        dt: f64,
        f: impl FnMut(f64, f64),
    ) {
        self.samples_where(ray, span, first, dt, |value| value.to_bits() != 0, f);
    }

    /// As [`samples`](Self::samples), where constant regions of which `counts` is false of their
    /// value are passed in one step.
    #[inline]
    pub fn samples_where(
        &self,
        ray: &Ray<Index>,
        span: Span,
        first: f64,
        dt: f64,
        counts: impl Fn(f32) -> bool,
        mut f: impl FnMut(f64, f64),
    ) {
        if !(dt > 0.0 && dt.is_finite() && first.is_finite()) {
            return;
        }
        let mut walk = Walk::new(self, ray, span);
        let mut batch = Batch::new(&self.tree().bricks);
        let first = first - walk.t0;
        let mut k = 0.0;
        while let Some(piece) = walk.next_piece() {
            if let Child::Constant(value) = piece.region.content
                && !counts(value)
            {
                continue;
            }
            if first + k * dt < piece.start {
                k = ((piece.start - first) / dt).ceil().max(k);
            }
            match piece.region.content {
                Child::Constant(v) => {
                    batch.flush(&mut f);
                    while first + k * dt < piece.end {
                        f(walk.t(first + k * dt), f64::from(v));
                        k += 1.0;
                    }
                }
                Child::Node(i) => {
                    let voxel = i as usize * (ROW * SIDE);
                    let entry = walk.ray.entry - piece.region.min.as_dvec3();
                    while first + k * dt < piece.end {
                        let s = first + k * dt;
                        let local = entry + walk.ray.direction * s;
                        batch.push(walk.t(s), voxel, local, &mut f);
                        k += 1.0;
                    }
                }
            }
        }
        batch.flush(&mut f);
    }
}
