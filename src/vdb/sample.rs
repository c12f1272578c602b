//! Trilinear values: at a point, and at even steps along a ray.

use glam::DVec3;

use crate::math::{Index, IndexPoint, Ray, Span};

use super::brick::{ROW, corners, in_brick, locate};
use super::grid::Grid;
use super::tree::{Brick, Child, Cursor, SIDE};
use super::voxel::Voxel;
use super::walk::Walk;

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
