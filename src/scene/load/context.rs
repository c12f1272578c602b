//! State of loading a scene.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::files::Grids;
use crate::error::Result;
use crate::scene::camera::Frustum;
use crate::scene::hash::Sources;
use crate::scene::reader::Place;
use crate::shape::MeshData;

/// State of loading a scene: files that are open, warnings, notes.
#[derive(Debug, Default)]
pub(super) struct Context {
    /// VDB files, each opened once.
    pub(super) grids: Grids,
    /// Meshes in memory, by the names under which the scene has them.
    pub(super) meshes: BTreeMap<String, Arc<MeshData>>,
    /// The files read, for the hash.
    pub(super) sources: Sources,
    /// Warnings, one line each.
    pub(super) warnings: Vec<String>,
    /// Notes, one line each.
    pub(super) notes: Vec<String>,
    /// Culling of voxels out of the camera's sight, where only camera rays need voxels.
    pub(super) culling: Option<Culling>,
    /// Active voxels out of sight.
    pub(super) unseen: u64,
}

/// Culling of leaves of voxels by the camera's frustum.
#[derive(Debug, Clone, Copy)]
pub(super) struct Culling {
    /// The frustum of camera rays.
    pub(super) frustum: Frustum,
    /// Whether voxels outside are left out rather than only counted.
    pub(super) leaves_out: bool,
}

/// `result`, its error made one about the key at `place`.
pub(super) fn at<T>(place: &Place, result: Result<T, impl std::fmt::Display>) -> Result<T> {
    result.map_err(|problem| place.error(problem))
}
