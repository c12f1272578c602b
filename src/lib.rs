//! fogbow renders smoke, fog and fire stored as OpenVDB grids with a two-pass volume photon map.
//!
//! Data flows one way: a scene file becomes a [`scene::Scene`], photons are shot into it, rays are
//! marched through it, and a film is written out.

pub mod error;
pub mod file;
pub mod math;

pub use error::{Error, Result};
