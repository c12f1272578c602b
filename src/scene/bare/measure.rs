//! Bounds and thickness of the density of a grid.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::math::{Aabb, IndexPoint, Ray, Span, World, WorldPoint};
use crate::vdb::Grid;

/// Share of the density that may lie beyond each face of the box.
const STRAY: f64 = 1e-3;
/// Rays along each side of a face that measure the thickness.
const PROBES: u32 = 48;
/// Share of the height within which a medium that stands on a ground is cut off level.
const SLAB: f64 = 0.02;

/// The world box that holds all density but a share of [`STRAY`] beyond each face, to whole blocks of
/// eight voxels, cut to the active voxels and half a voxel round them: voxels of 0 and stray ones
/// far away are left out.
pub(super) fn world_bounds(grid: &Grid<f32>) -> Option<Aabb<World>> {
    let [min, max] = grid.statistics().bounds?;
    let [low, high] = dense_box(grid)?;
    let min = DVec3::from(min.map(f64::from)).max(low) - 0.5;
    let max = DVec3::from(max.map(f64::from)).min(high) + 0.5;
    let corner = IndexPoint::from_xyz;
    let bounds = grid.transform().box_to_world(&Aabb::new(corner(min), corner(max)));
    (bounds.min.xyz.is_finite() && bounds.max.xyz.is_finite()).then_some(bounds)
}

/// The corners, in index space, of the blocks of eight voxels that hold all density but a share of
/// [`STRAY`] beyond each face; `None` where there is no density.
pub(super) fn dense_box(grid: &Grid<f32>) -> Option<[DVec3; 2]> {
    let mut marginals: [BTreeMap<i32, f64>; 3] = Default::default();
    let mut sum = 0.0;
    grid.for_each_nonzero(|block| {
        let size = block.max - block.min + 1;
        let mass = f64::from(block.value) * size.as_dvec3().element_product();
        sum += mass;
        for (axis, marginal) in marginals.iter_mut().enumerate() {
            let (first, last) = (block.min[axis] >> 3, block.max[axis] >> 3);
            let share = mass / f64::from(last - first + 1);
            (first..=last).for_each(|key| *marginal.entry(key).or_default() += share);
        }
    });
    if !(sum > 0.0 && sum.is_finite()) {
        return None;
    }
    let low = marginals.each_ref().map(|marginal| {
        let stray = stray_entries(marginal.values().copied(), STRAY * sum);
        f64::from(marginal.keys().nth(stray).map_or(0, |block| block << 3))
    });
    let high = marginals.each_ref().map(|marginal| {
        let stray = stray_entries(marginal.values().rev().copied(), STRAY * sum);
        f64::from(marginal.keys().rev().nth(stray).map_or(7, |block| (block << 3) + 7))
    });
    Some([DVec3::from(low), DVec3::from(high)])
}

/// The number of entries at the end of a `marginal` whose sum stays at `limit` or below.
pub(super) fn stray_entries(marginal: impl Iterator<Item = f64>, limit: f64) -> usize {
    let sums = marginal.scan(0.0, |sum, share| {
        *sum += share;
        Some(*sum)
    });
    sums.take_while(|sum| *sum <= limit).count()
}

/// Whether the medium stands on a ground: its lowest part lies at the height 0, or is cut off level, so
/// that the lowest [`SLAB`] of its height holds at least half of its even share of the density.
pub(super) fn stands(grid: &Grid<f32>, bounds: &Aabb<World>) -> bool {
    let size = bounds.size();
    let slab = SLAB * size.y;
    if bounds.min.xyz.y.abs() <= slab {
        return true;
    }
    let (mut low, mut all) = (0.0, 0.0);
    for i in 0..PROBES * PROBES {
        let share = |k: u32| (f64::from(k) + 0.5) / f64::from(PROBES);
        let (x, z) = (share(i % PROBES) * size.x, share(i / PROBES) * size.z);
        let ray = Ray::new(bounds.min + DVec3::new(x, 0.0, z), DVec3::Y);
        let local = grid.transform().ray_to_local(&ray);
        low += grid.integrate(&local, Span::new(0.0, slab));
        all += grid.integrate(&local, Span::new(0.0, size.y));
    }
    low > 0.5 * SLAB * all
}

/// The integral of density, in metres, along the axis where it is largest: mean over a raster of
/// rays, those that meet nothing left out.
pub(super) fn mean_thickness(grid: &Grid<f32>, bounds: &Aabb<World>) -> f64 {
    (0..3).map(|axis| mean_along(grid, bounds, axis)).fold(0.0, f64::max)
}

fn mean_along(grid: &Grid<f32>, bounds: &Aabb<World>, axis: usize) -> f64 {
    let size = bounds.size();
    let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
    let (mut sum, mut hits) = (0.0, 0u32);
    for i in 0..PROBES * PROBES {
        let share = |k: u32| (f64::from(k) + 0.5) / f64::from(PROBES);
        let mut origin = bounds.min.xyz;
        origin[u] += share(i % PROBES) * size[u];
        origin[v] += share(i / PROBES) * size[v];
        let ray = Ray::new(WorldPoint::from_xyz(origin), DVec3::AXES[axis]);
        let local = grid.transform().ray_to_local(&ray);
        let thickness = grid.integrate(&local, Span::new(0.0, size[axis]));
        if thickness > 0.0 {
            sum += thickness;
            hits += 1;
        }
    }
    if hits == 0 { 0.0 } else { sum / f64::from(hits) }
}
