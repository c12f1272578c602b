//! How light is followed through a scene: what photons, camera rays, caches and the reference share.

mod context;
pub mod direct_light;
mod equiangular_lights;
mod flight_segment;
mod punctual_directions;

pub use context::{PathContext, SobolPoint};
pub use equiangular_lights::EquiangularLights;
pub use flight_segment::FlightSegment;
pub use punctual_directions::PunctualDirections;

/// Scatterings and reflections after which a path is ended and counted as capped.
pub const MAX_EVENTS: u32 = 100_000;
