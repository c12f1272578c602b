//! Memory that photons take.

use super::{Photon, Placed};

/// Bytes of photon maps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PhotonMemory {
    /// Once the maps are built.
    pub held: u64,
    /// The most while they are built.
    pub building: u64,
}

/// About what maps of so many photons take.
pub fn memory(volume: u64, surface: u64) -> PhotonMemory {
    let (placed, photon) = (size_of::<Placed>() as u64, size_of::<Photon>() as u64);
    // A sphere is a photon with its place and radius, and the hierarchy has 80 bytes for each node
    // of about five.
    let held = volume * (placed + 4 + 24) + surface * (photon + 16);
    // Deposits in one piece, radii, boxes, the two hierarchies that become the last one, and spheres.
    let building =
        volume * (placed + 4 + 32 + 64 + 96 + 24 + 32) + surface * (2 * placed + photon + 16);
    PhotonMemory { held, building }
}
