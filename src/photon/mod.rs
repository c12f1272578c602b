//! Pass 1: photons are shot from the lights through surfaces and media and kept in maps, from
//! which pass 2 estimates the light that arrives anywhere.
//!
//! Light in media estimates fluence, not collision density, so thin regions and the edges of a
//! medium get their share and no energy is lost at a medium's boundary. Where cells can be thin
//! and the eye lies outside, flights leave their length on a lattice; elsewhere a photon is kept at
//! tentative collisions and weighs one over their rate.

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
mod memory;
mod path;
mod pilot;
mod radius;
mod settings;
mod shoot;
mod split;
mod stored;
mod surface;

pub use beam::{BeamHit, BeamMap};
pub use map::PhotonMap;
pub use maps::PhotonMaps;
pub use memory::{PhotonMemory, memory};
pub use settings::PhotonSettings;
pub use shoot::shoot;
pub use stored::{NoDirection, Octahedral, Photon, PhotonAt, PhotonDirection};
pub use surface::SurfaceMap;
