//! Grids between two frames of a sequence.
//!
//! Between two frames each grid is the mean of those of both, by their shares, each carried there by the velocities of its own
//! frame: that of the frame before onward, that of the frame after back.

use glam::{DAffine3, DVec3, IVec3};

use crate::math::{Aabb, Index, Transform, WorldPoint};

use super::advect::{Drift, MOST_LEAVES, UNSEEN, leaves_near, with_voxels};
use super::grid::Grid;
use super::source::leaf_reach;
use super::tree::{BRICK, REACH};
use super::voxel::Voxel;

/// Rounding of places, in voxels.
///
/// Unit: voxels. Definition: far above that of double precision, far below what is seen.
const ROUNDING: f64 = 1e-6;

/// How the grids of a frame come to another time.
#[derive(Debug, Clone, Copy)]
pub struct Advection<'a> {
    /// The velocities that carry them; `None` where they stand still.
    pub drift: Option<&'a Drift>,
    /// For how many frames, back where it is negative.
    pub frames: f64,
}

impl Advection<'_> {
    /// How far all of it is carried alike, in metres.
    fn shift(&self) -> DVec3 {
        self.drift.map_or(DVec3::ZERO, |drift| drift.shift(self.frames))
    }

    /// How far any voxel of `grid` is carried beside that, in voxels; 0 where that is not seen.
    fn reach<V: Voxel>(&self, grid: &Grid<V>) -> f64 {
        let reach = self.drift.map_or(0.0, |drift| drift.reach(grid, self.frames));
        if reach > UNSEEN { reach } else { 0.0 }
    }

    /// Where what is carried to `p` comes from; all of it is carried alike where it `is_even`.
    fn before(&self, p: WorldPoint, is_even: bool) -> WorldPoint {
        let p = p - self.shift();
        let uneven = self.drift.filter(|_| !is_even);
        uneven.map_or(p, |drift| drift.before(p, self.frames))
    }

    /// The transform of `grid` where it is carried to.
    fn placed<V: Voxel>(&self, grid: &Grid<V>) -> Result<Transform<Index>, String> {
        let placed = grid.transform().placed(&DAffine3::from_translation(self.shift()));
        placed.ok_or_else(|| "is carried beyond all numbers".into())
    }
}

/// The mean of two `grids`, each where its advection brings it: the second has the `share` of it, weighed by the `densities` of
/// both where these are given. It has the voxels of the first.
///
/// # Errors
/// The problem, where it would take too many voxels.
pub fn blended<V: Voxel>(
    grids: [&Grid<V>; 2],
    advections: &[Advection<'_>; 2],
    share: f64,
    densities: Option<[&Grid<f32>; 2]>,
) -> Result<Grid<V>, String> {
    let [first, second] = grids;
    let [onward, back] = advections;
    let transform = onward.placed(first)?;
    let reaches = [onward.reach(first), back.reach(second)];
    let mut keys = leaves_near(first, reaches[0])?;
    let others = leaves_near(second, reaches[1])?;
    add_leaves(&mut keys, &others, &back.placed(second)?, &transform)?;
    let mean = |[a, b]: [V; 2], share: f64| {
        V::from_sample(V::blend([a, a, a, a, b, b, b, b], DVec3::X * share))
    };
    let share_at = |[p, q]: [WorldPoint; 2]| {
        let Some([a, b]) = densities else { return share };
        let [a, b] = [(1.0 - share) * value_at(a, p), share * value_at(b, q)];
        if a >= 0.0 && b >= 0.0 && a + b > 0.0 { b / (a + b) } else { share }
    };
    let value = |p: WorldPoint| {
        let [p, q] = [onward.before(p, reaches[0] == 0.0), back.before(p, reaches[1] == 0.0)];
        mean([value_at(first, p), value_at(second, q)].map(V::from_sample), share_at([p, q]))
    };
    let background = mean(grids.map(Grid::background), share);
    Ok(with_voxels(&keys, &transform, background, value))
}

/// A grid of zeros, placed as `grid` is.
pub fn emptied<V: Voxel>(grid: &Grid<V>) -> Grid<V> {
    with_voxels(&[], grid.transform(), V::default(), |_| V::default())
}

/// The value of `grid` at `p`.
fn value_at<V: Voxel>(grid: &Grid<V>, p: WorldPoint) -> V::Sample {
    grid.value(grid.transform().point_to_local(p))
}

/// Adds to `keys`, leaves of the lattice `to`, those that have voxels between those of the leaves `others` of the lattice `from`.
fn add_leaves(
    keys: &mut Vec<[i32; 3]>,
    others: &[[i32; 3]],
    from: &Transform<Index>,
    to: &Transform<Index>,
) -> Result<(), String> {
    let farthest = f64::from(1 << (REACH - 1));
    for other in others {
        let corners = leaf_reach(IVec3::from(*other)).corners();
        let there = corners.map(|corner| to.point_to_local(from.point_to_world(corner)));
        let Aabb { min, max } = Aabb::around(there);
        let (low, high) = (min.xyz, max.xyz);
        let is_usual = low.cmpge(DVec3::splat(-farthest)) & high.cmple(DVec3::splat(farthest));
        if !is_usual.all() {
            return Err("is carried too far from the voxels of the frame before".into());
        }
        let [low, high] = [(low + ROUNDING).ceil(), (high - ROUNDING).floor()];
        let [low, high] = [low, high].map(|voxel| voxel.as_ivec3() >> BRICK);
        let count = (high - low + 1).as_dvec3().element_product();
        if keys.len() as f64 + count > 2.0 * MOST_LEAVES as f64 {
            keys.sort_unstable();
            keys.dedup();
        }
        if keys.len() as f64 + count > 2.0 * MOST_LEAVES as f64 {
            return Err(too_many());
        }
        for x in low.x..=high.x {
            for y in low.y..=high.y {
                keys.extend((low.z..=high.z).map(|z| (IVec3::new(x, y, z) << BRICK).to_array()));
            }
        }
    }
    keys.sort_unstable();
    keys.dedup();
    if keys.len() > MOST_LEAVES { Err(too_many()) } else { Ok(()) }
}

fn too_many() -> String {
    format!(
        "would take more than {MOST_LEAVES} leaves of voxels between two frames; give frames whose voxels have about one size"
    )
}
