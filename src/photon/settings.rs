//! Settings of a photon pass, its batches, and the memory that it takes.

use crate::math::Spectrum;
use crate::scene::plan::Needs;
use crate::transport::FlightSegment;
use crate::work::Work;

use super::{BeamMap, Photon, PhotonAt, PhotonDirection};

/// Volume photons that a path should store, in the mean: as many along a deposit region's diagonal, and of
/// more a share.
///
/// Unit: count. Bench: `cargo bench --bench results -- --only equal-time`.
pub(super) const STORED_PER_PATH: f64 = 4.0;

/// Paths that are traced as one task.
///
/// Unit: count. Derivation: some milliseconds of work, a thousand times what handing out a task takes.
pub(super) const CHUNK: u64 = 512;

/// Tasks whose flights are recorded together.
///
/// Unit: count. Limit: on memory, by [`MAX_PATHS_IN_MEMORY`].
pub(super) const BATCH: usize = 32;

/// Paths whose flights are in memory at once: those of one batch while they are recorded, those of
/// the next while it is traced.
///
/// Unit: count. Derivation: two batches of [`BATCH`] tasks of [`CHUNK`] paths.
const MAX_PATHS_IN_MEMORY: u64 = 2 * BATCH as u64 * CHUNK;

/// How photons are shot.
#[derive(Debug, Clone, Copy)]
pub struct PhotonSettings {
    /// Number of photon paths.
    pub photons: u64,
    /// Number of paths that a pilot traces out of those; `None` traces all.
    pub traced: Option<u64>,
    /// Seed of the random streams.
    pub seed: u64,
    /// Highest order of volume scattering in the picture; `None` means all.
    pub max_scatter: Option<u32>,
    /// Gather radius in metres, where one is given.
    pub radius: Option<f64>,
    /// Levels of thinned volume photons beside the full one, for gathers up to 2^levels times as
    /// wide.
    pub levels: u32,
    /// Which photons are needed.
    pub needs: Needs,
    /// Whether they serve any camera: they are not aimed at what that of the scene sees.
    pub any_camera: bool,
}

/// Bytes of photon maps and caches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PhotonMemory {
    /// Once the maps are built.
    pub held: u64,
    /// The most while they are built.
    pub building: u64,
    /// Of that, what is grown in pieces and then copied together.
    pub pieces: u64,
    /// Of a pilot that chose strategies, freed before the maps are built.
    pub pilot: u64,
}

/// The maps that photons are in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapLayout {
    /// How many there are, which are built one after another.
    pub maps: u64,
    /// Share of the photons in media that they keep.
    pub kept: f64,
}

impl MapLayout {
    /// One map of all photons.
    pub const fn whole() -> Self {
        Self { maps: 1, kept: 1.0 }
    }
}

/// About what photons take for which `work` is expected, in maps of this layout, beside caches that take `complete` bytes from the
/// start of tracing and `lazy` bytes of cells that rays fill, after a `pilot` of so many bytes.
pub fn memory<S: Spectrum, H: PhotonDirection>(
    work: &Work,
    MapLayout { maps, kept }: MapLayout,
    [complete, lazy]: [u64; 2],
    pilot: u64,
) -> PhotonMemory {
    let (volume, surface) = (work.volume_photons, work.surface_photons);
    let kept = (volume as f64 * kept) as u64;
    let (stored, sphere) = (size_of::<PhotonAt<S, H>>() as u64, BeamMap::<S, H>::SPHERE as u64);
    let (stored_on_surface, photon) =
        (size_of::<PhotonAt<S>>() as u64, size_of::<Photon<S>>() as u64);
    let caches = complete + lazy;
    let in_memory = MAX_PATHS_IN_MEMORY as f64 / work.photon_paths.max(1) as f64;
    let recorded = in_memory.min(1.0 / maps as f64);
    // A flight crosses one layer of bricks or two, each of which lists its index.
    let flight = (size_of::<FlightSegment<S>>() + 2 * size_of::<u32>()) as u64;
    let flights = (work.tracks as f64 * recorded) as u64 * flight;
    // A hierarchy has nodes of 80 bytes and one index of 4 bytes a photon: 24 bytes at about four
    // photons a node. A kd-tree has position and index a photon.
    let held = kept * (sphere + 24) + surface * (photon + 16);
    // Deposits in one piece with their radii; boxes, the two hierarchies that become the last one, and spheres of those that
    // are kept.
    let building = volume * (stored + 4)
        + kept * (32 + 64 + 96 + 24 + sphere)
        + surface * (2 * stored_on_surface + photon + 16);
    let pieces = volume * stored + surface * stored_on_surface;
    // The last map is built beside all others.
    let [built, building, pieces] = [held - held / maps, building / maps, pieces / maps];
    let building = caches + built + building.max(flights + complete);
    PhotonMemory { held: held + caches, building, pieces, pilot }
}
