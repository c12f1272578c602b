//! Shapes and meshes.

#[path = "../common/skip.rs"]
mod skip;

mod files;
mod rays;
