//! Trilinear values in a brick.

use glam::{DVec3, IVec3};

use super::tree::{Brick, SIDE};
use super::voxel::Voxel;

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
pub(super) const ROW: usize = SIDE * SIDE;

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
pub(super) fn locate(local: DVec3) -> (usize, DVec3) {
    let ((x, u), (y, v), (z, w)) = (split(local.x), split(local.y), split(local.z));
    (x * ROW + y * SIDE + z, DVec3::new(u, v, w))
}

/// The trilinear value at `local` in [0, 8]³ of a brick.
#[inline]
pub(super) fn in_brick<V: Voxel>(brick: &Brick<V>, local: DVec3) -> V::Sample {
    let (number, u) = locate(local);
    V::blend(corners(brick, number), u)
}
