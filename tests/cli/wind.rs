//! A cube of smoke in a wind, for tests of motion.

use std::path::Path;

use fogbow::vdb::{Block, GridToWrite, ValueType, write};
use glam::{DVec3, IVec3};

/// Writes 8³ voxels of .2 m of even smoke, the first of them at `corner`, with `velocity` in the grid `vel` and further grids of one
/// value each.
pub fn write_cube(path: &Path, corner: DVec3, velocity: [f32; 3], more: &[(&str, f32)]) {
    let grid = |name: &str, value_type, values: Vec<f32>| {
        let block = Block { origin: IVec3::ZERO, values, active: None };
        let fog = GridToWrite::fog(name, 0.2, corner);
        let class = if name == "density" { "fog volume" } else { "unknown" }.into();
        GridToWrite { value_type, class, blocks: vec![block], ..fog }
    };
    let scalar = |(name, value): (&str, f32)| grid(name, ValueType::Float, vec![value; 512]);
    let mut grids =
        vec![scalar(("density", 1.0)), grid("vel", ValueType::Vec3, velocity.repeat(512))];
    grids.extend(more.iter().copied().map(scalar));
    write(path, &grids).unwrap();
}
