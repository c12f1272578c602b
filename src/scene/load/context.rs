//! What loading gathers on its way.

use super::files::Grids;
use crate::error::Result;
use crate::scene::camera::Frustum;
use crate::scene::hash::Sources;
use crate::scene::reader::Place;

/// What loading gathers on its way.
#[derive(Debug, Default)]
pub(super) struct Context {
    /// VDB files, each opened once.
    pub(super) grids: Grids,
    /// Every file read.
    pub(super) sources: Sources,
    /// One line each.
    pub(super) warnings: Vec<String>,
    /// What is told beside warnings, one line each.
    pub(super) notes: Vec<String>,
    /// Where the camera looks, if nothing else asks for voxels.
    pub(super) sight: Option<Sight>,
    /// Active voxels elsewhere.
    pub(super) unseen: u64,
}

/// Where alone voxels are asked for.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sight {
    pub(super) frustum: Frustum,
    /// Whether other voxels are left out, and not only counted.
    pub(super) leaves_out: bool,
}

/// `result` with its problem told at `place`.
pub(super) fn at<T>(place: &Place, result: Result<T, impl std::fmt::Display>) -> Result<T> {
    result.map_err(|problem| place.error(problem))
}
