//! Light transport: the one path engine of photons, camera rays, final gathers, caches and the
//! reference.
//!
//! A path flies through media by null-collision [`tracking`], steps through mirrors and glass by
//! [`specular`], samples lights by [`direct_light`], and keeps what it needs for all that in a
//! [`PathState`] and a [`PathContext`].

pub mod camera_view;
mod context;
pub mod direct_light;
mod equiangular_lights;
mod opacity_steps;
mod path_state;
mod punctual_directions;
pub mod specular;
mod stratified;
pub mod surface_light;
pub mod tracking;
mod viewpoint;

pub use context::{Amortized, PathContext};
pub use direct_light::LightNumbers;
pub use equiangular_lights::EquiangularLights;
pub use opacity_steps::OpacitySteps;
pub use path_state::{EnclosingSolids, PathState, Scattering, survives_roulette};
pub use punctual_directions::PunctualDirections;
pub use stratified::{Decision, Draws, SobolPoint, StratifiedSample};
pub use tracking::FlightSegment;
pub use viewpoint::{PixelFootprint, camera_position, is_camera_outside};

/// Scatterings and reflections after which a path is ended and counted as capped. Russian roulette
/// ends paths long before; the limit bounds the time of a pixel in media that hardly absorb.
///
/// Unit: count. Limit: on paths in media that do not absorb.
pub const MAX_EVENTS: u32 = 100_000;
