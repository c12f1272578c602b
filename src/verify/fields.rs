//! Density fields made in memory, for cases.

use glam::{DVec3, IVec3};

use super::Parts;
use crate::error::Result;
use crate::math::{Ray, Rgb, WorldPoint};
use crate::medium::{Albedo, Density, Emission, Media, Medium, Phase};
use crate::vdb::{Block, GridToWrite};

/// A grid of blocks from the block `min` to the one before `end` with `value` at each voxel.
pub fn blocks(
    name: &str,
    voxel: f64,
    min: IVec3,
    end: IVec3,
    value: impl Fn(IVec3) -> f64,
) -> GridToWrite {
    let mut grid = GridToWrite::fog(name, voxel, DVec3::ZERO);
    for x in min.x..end.x {
        for y in min.y..end.y {
            for z in min.z..end.z {
                grid.blocks.push(block(IVec3::new(x, y, z) * 8, &value));
            }
        }
    }
    grid
}

/// The block at `origin` with `value` at each voxel.
pub fn block(origin: IVec3, value: impl Fn(IVec3) -> f64) -> Block {
    let voxel = |i: i32| origin + IVec3::new(i >> 6, i >> 3 & 7, i & 7);
    let values = (0..512).map(|i| value(voxel(i)) as f32).collect();
    Block { origin, values, active: None }
}

/// A bar along x of 16 x 16 voxels by `length` (a multiple of 8) from voxel 0, whose density
/// depends on x alone; a ray well inside it sees that density.
pub fn bar(length: i32, value: impl Fn(i32) -> f64) -> GridToWrite {
    blocks("density", 1.0, IVec3::new(0, -1, -1), IVec3::new(length / 8, 1, 1), |v| value(v.x))
}

/// The ray along x through the inside of a [`bar`].
pub fn along_bar() -> Ray<crate::math::World> {
    Ray::new(WorldPoint::new(0.0, 0.3, -0.4), DVec3::X)
}

/// One grey medium with this grid as density; it emits `glow` times the density.
pub fn medium(parts: &Parts, grid: &GridToWrite, sigma_t: f64, glow: f64) -> Result<Media> {
    Ok(Media::new(vec![Medium {
        density: Density::Voxel((parts.export)(grid)?),
        sigma_t: Rgb::splat(sigma_t),
        albedo: Albedo::Constant(Rgb::ZERO),
        phase: Phase::ISOTROPIC,
        emission: (glow > 0.0).then_some(Emission::Density(Rgb::splat(glow))),
    }]))
}
