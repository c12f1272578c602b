//! OpenVDB grids: read, sampled, integrated along rays, written.
//!
//! A file is opened with [`VdbFile::open`], a grid chosen with [`VdbFile::default_density`] or
//! [`VdbFile::find`] and read with [`VdbFile::read_scalar`] or [`VdbFile::read_vector`]. A [`Grid`]
//! owns its voxels in bricks that carry their neighbours' faces, so that no trilinear cell ever
//! crosses from one brick into another.

mod advect;
mod blend;
mod brick;
mod build;
mod cells;
mod check;
mod combine;
mod cubic;
mod domain;
#[allow(unreachable_pub)] // what cxx generates
mod ffi;
mod file;
mod grid;
mod info;
mod regions;
pub mod roles;
mod sample;
mod source;
mod statistics;
mod tree;
mod velocity;
mod voxel;
mod walk;
mod write;

pub use advect::Drift;
pub use blend::{Advection, blended, emptied};
pub use cubic::Cubic;
pub(crate) use ffi::bridge::map_large_blocks;
pub use file::{ReadAs, VdbFile, Wanted};
pub use grid::{Grid, VoxelBox};
pub use info::GridInfo;
pub use statistics::{BadValues, Statistics};
pub use voxel::Voxel;
pub use walk::{BrickRef, BrickSegment, BrickWalk};
pub use write::{Block, GridToWrite, Tile, ValueType, write};
