//! Memory that photons take.

use super::shoot::MOST_PATHS;
use super::{BeamMap, Photon, PhotonAt, PhotonDirection, PhotonMaps};
use crate::cache::{FluenceGrid, LazyCells};
use crate::math::Spectrum;
use crate::transport::FlightSegment;
use crate::work::Work;

/// Bytes of photon maps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PhotonMemory {
    /// Once the maps are built.
    pub held: u64,
    /// The most while they are built.
    pub building: u64,
    /// What came in pieces and was put together meanwhile.
    pub pieces: u64,
}

/// About what the maps take for which `work` is expected. `look` are the maps of some of the paths,
/// with the lattices of all.
pub fn memory<S: Spectrum, H: PhotonDirection>(
    work: &Work,
    look: &PhotonMaps<S, H>,
) -> PhotonMemory {
    let (volume, surface) = (work.volume_photons, work.surface_photons);
    let (placed, sphere) = (size_of::<PhotonAt<S, H>>() as u64, BeamMap::<S, H>::SPHERE as u64);
    let (lying, photon) = (size_of::<PhotonAt<S>>() as u64, size_of::<Photon<S>>() as u64);
    let kept = look.lattices.iter().map(FluenceGrid::memory_bytes).sum::<usize>() as u64;
    let filled = look.filled().into_iter().map(LazyCells::memory_bytes).sum::<usize>() as u64;
    let lattices = kept + filled;
    let share = (MOST_PATHS as f64 / work.photon_paths.max(1) as f64).min(1.0);
    // A flight crosses a layer of bricks or two, where it is told by its number.
    let flight = (size_of::<FlightSegment<S>>() + 2 * size_of::<u32>()) as u64;
    let flights = (work.tracks as f64 * share) as u64 * flight;
    // A sphere is a photon with its place and radius, and the hierarchy has 80 bytes for each node
    // of about five.
    let held = volume * (sphere + 24) + surface * (photon + 16) + lattices;
    // Deposits in one piece, radii, boxes, the two hierarchies that become the last one, and spheres.
    let building =
        volume * (placed + 4 + 32 + 64 + 96 + 24 + sphere) + surface * (2 * lying + photon + 16);
    let pieces = volume * placed + surface * lying;
    PhotonMemory { held, building: lattices + building.max(flights + kept), pieces }
}
