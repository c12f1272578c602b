//! fogbow renders smoke, fog and fire stored as OpenVDB grids with a two-pass volume photon map.
//!
//! Data flows one way: a scene file becomes a [`scene::Scene`], photons are shot into it, rays are
//! marched through it, and a film is written out. The [`guide`] is for those who use the program.

pub mod cache;
pub mod cli;
pub mod director;
pub mod error;
pub mod file;
pub mod film;
pub mod guide;
pub mod image;
pub mod light;
mod loopback;
pub mod make;
pub mod math;
pub mod medium;
pub mod photon;
#[cfg(feature = "python")]
mod python;
pub mod render;
pub mod scene;
pub mod sequence;
pub mod shape;
pub mod strategy;
pub mod study;
pub mod surface;
pub mod transport;
pub mod vdb;
pub mod verify;
pub mod work;

pub use error::{Error, Result};
