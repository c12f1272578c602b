//! Scenes: files, settings, bare volumes, shots, the plan of a render and its limits.

#[path = "../common/skip.rs"]
mod skip;

mod bare;
mod error_goal;
mod file;
mod limits;
mod open;
mod plan;
mod retime;
mod schema;
mod settings;
mod usd;
mod usd_cameras;
mod usd_materials;
mod usd_packages;
