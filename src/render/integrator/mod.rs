//! Estimators of the light along a camera ray.

mod cached;
mod camera_path;
mod final_gather;
mod forward_peak;
mod in_scattering;
mod joint_nee;
mod reference;

pub(super) use in_scattering::Marcher;
pub(super) use reference::PathTracer;
