//! Fields on an oblique grid, for tests of media.

use fogbow::vdb::{Block, Grid, GridToWrite, ReadAs, Tile};
use glam::{DAffine3, DQuat, DVec3, IVec3};

use crate::common::written;

/// Width of a voxel, in metres.
pub(crate) const VOXEL: f64 = 0.125;

/// A grid of 24³ voxels round the world's origin, turned by `angle` about an oblique axis.
pub(crate) fn grid(angle: f64, value: impl Fn(DVec3) -> f64, tiles: Vec<Tile>) -> Grid<f32> {
    let turn = DQuat::from_axis_angle(DVec3::new(0.36, 0.48, 0.8), angle);
    let mut blocks = Vec::new();
    for corner in 0..27 {
        let origin = IVec3::new(corner % 3 - 1, corner / 3 % 3 - 1, corner / 9 - 1) * 8;
        let voxel = |i: i32| origin + IVec3::new(i >> 6, i >> 3 & 7, i & 7);
        let values = (0..512).map(|i| value(voxel(i).as_dvec3() * VOXEL) as f32).collect();
        blocks.push(Block { origin, values, active: None });
    }
    let to_write = GridToWrite {
        transform: DAffine3::from_scale_rotation_translation(
            DVec3::splat(VOXEL),
            turn,
            DVec3::new(0.01, -0.02, 0.03),
        ),
        blocks,
        tiles,
        ..GridToWrite::fog("density", VOXEL, DVec3::ZERO)
    };
    let (_folder, file) = written(&[to_write]);
    file.read_scalar(0, ReadAs::Density).unwrap()
}

/// Smoke with holes; 0 at the faces.
pub(crate) fn puffs(p: DVec3) -> f64 {
    let wave = (4.0 * p.x).sin() * (3.0 * p.y + 1.0).cos() * (5.0 * p.z + 0.5).sin();
    let fade = (0.8 - p.length()).clamp(0.0, 1.0);
    (wave + 0.4).max(0.0) * fade * 3.0
}
