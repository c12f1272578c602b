//! Photons: shot from lights and emissive media through the scene, and stored in immutable maps.
//!
//! Photons in media estimate fluence, not collision density, so that thin regions and the edges of a
//! medium get their share and no energy is lost at a boundary: a photon is stored at tentative
//! collisions with a weight of one over their rate. Flights can be recorded as well, for caches that
//! are built from their lengths. This module knows no rays, pixels or caches.

mod beam;
mod build;
mod camera_importance;
mod deposit_regions;
mod emission_target;
mod emitter_importance;
mod emitters;
mod extents;
mod kernel;
mod map;
mod maps;
mod path;
mod pilot;
mod radius;
mod settings;
mod shoot;
mod split;
mod stored;
mod surface;
mod traced;

pub use beam::{BeamHit, BeamMap};
pub use build::{GatherBall, MapBuilder};
pub use camera_importance::CameraImportance;
pub use map::PhotonMap;
pub use maps::{PhotonMaps, Response};
pub use settings::{MapLayout, PhotonMemory, PhotonSettings, memory};
pub use shoot::{AimedPhotons, FlightSink, Recording};
pub use stored::{NoDirection, Octahedral, Photon, PhotonAt, PhotonDirection};
pub use surface::SurfaceMap;
pub use traced::{PathSample, ShotPart, TracedHead, TracedPhotons};
