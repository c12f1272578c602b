//! How light is followed through a scene: what photons, camera rays, caches and the reference share.

mod context;
pub mod direct_light;
mod equiangular_lights;
mod flight_segment;
mod punctual_directions;
mod viewpoint;

pub use context::{PathContext, SobolPoint};
pub use equiangular_lights::EquiangularLights;
pub use flight_segment::FlightSegment;
pub use punctual_directions::PunctualDirections;
pub use viewpoint::{PixelFootprint, camera_position, is_camera_outside};

/// Scatterings and reflections after which a path is ended and counted as capped.
pub const MAX_EVENTS: u32 = 100_000;
