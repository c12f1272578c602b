//! Pass 1: photons are shot from the lights through surfaces and media and kept in maps, from
//! which pass 2 estimates the light that arrives anywhere.
//!
//! Volume photons estimate fluence, not collision density: a photon is kept at tentative
//! collisions and weighs one over their rate, so thin regions and the edges of a medium get their
//! share and no energy is lost at a medium's boundary.

mod beam;
mod emitters;
mod estimate;
mod kernel;
mod lattice;
mod map;
mod memory;
mod path;
mod radius;
mod scout;
mod shoot;
mod soft;
mod stored;
mod surface;
mod visible;
mod zones;

pub use beam::{BeamMap, Beside};
pub use estimate::PhotonMaps;
pub use lattice::{DirectLattice, Lattice};
pub use map::PhotonMap;
pub use memory::{PhotonMemory, memory};
pub use path::MAX_EVENTS;
pub use shoot::{Shooting, shoot};
pub use stored::{Photon, Placed};
pub use surface::SurfaceMap;
