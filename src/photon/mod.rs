//! Pass 1: photons are shot from the lights through surfaces and media and kept in maps, from
//! which pass 2 estimates the light that arrives anywhere.
//!
//! Light in media estimates fluence, not collision density, so thin regions and the edges of a
//! medium get their share and no energy is lost at a medium's boundary. Where cells can be thin
//! and the eye lies outside, flights leave their length on a lattice; elsewhere a photon is kept at
//! tentative collisions and weighs one over their rate.

mod beam;
mod build;
mod emitters;
mod estimate;
mod extents;
mod gather;
mod keep;
mod kernel;
mod lattice;
mod map;
mod memory;
mod path;
mod radius;
mod scout;
mod shoot;
mod shooting;
mod soft;
mod split;
mod stored;
mod surface;
mod target;
mod visible;
mod worth;
mod zones;

pub use beam::{BeamMap, Beside};
pub use estimate::PhotonMaps;
pub use gather::Depth;
pub use lattice::{DirectLattice, Filled, GatherLattice, Lattice, Round};
pub use map::PhotonMap;
pub use memory::{PhotonMemory, memory};
pub use path::MAX_EVENTS;
pub use shoot::shoot;
pub use shooting::Shooting;
pub use soft::Scattering;
pub use stored::{Heading, Octahedral, Photon, Placed, Unknown};
pub use surface::SurfaceMap;
