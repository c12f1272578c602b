//! Memory that a render takes, from the sizes of its parts.
//!
//! Sizes of types are asked of the compiler. What only measurement can tell are two allowances, for
//! what the allocator retains and for working memory; `tests/plan.rs` compares the sum with the peak
//! that the system reports.

use std::sync::Arc;

use serde::Serialize;

use super::reconstructed_passes::reconstructed_pass_bytes;
use super::stage_settings::{exposed_window, film_contents, shown_window};
use crate::director::PixelBudget;
use crate::film::{
    Accumulator, DEEP_BYTES, FeatureMean, FilmContents, PixelComponents, RECONSTRUCTION_BYTES,
};
use crate::image::{Features, Film, Window};
use crate::medium::Medium;
use crate::photon::PhotonMemory;
use crate::scene::plan::Needs;
use crate::scene::{RenderSettings, Scene};

/// Bytes of a pixel of the film: its samples, and the layers that they become.
const FILM: u64 = (size_of::<Accumulator>() + Film::PIXEL_BYTES) as u64;

/// Bytes that features add to a pixel of the film: their sum, and the mean that it becomes.
const FEATURES: u64 = (size_of::<FeatureMean>() + size_of::<Features>()) as u64;

/// Bytes of a pixel of the film while it is reconstructed: its layers, its components, and those at all levels.
const RECONSTRUCTING: u64 =
    (Film::PIXEL_BYTES + size_of::<PixelComponents>() + RECONSTRUCTION_BYTES) as u64;

/// Bytes of a pixel while the film is written: its layers, their copy for the encoder, and the file.
const WRITING: u64 = (Film::PIXEL_BYTES + 2 * Film::LAYER_BYTES) as u64;

/// Bytes of a pixel of the director's maps: distance, snapshot, X, S and XS.
const MAPS: u64 = (size_of::<f64>() + size_of::<[f32; 3]>() + 3 * size_of::<f32>()) as u64;

/// Bytes of a pixel of the film that is directed: its budget, with S and XS in the film's size.
const BUDGET: u64 = (size_of::<PixelBudget>() + 2 * size_of::<f32>()) as u64;

/// Bytes of freed memory that the allocator retains at most. The default M_MMAP_THRESHOLD_MAX of
/// glibc on 64-bit systems: larger blocks are mapped, and returned at once.
const RETAINED: u64 = 32 << 20;

/// Bytes of small tables and file formats: an allowance.
const WORKING: u64 = 4 << 20;

/// Bytes of a thread, its stack and what its allocator holds: an allowance.
const THREAD: u64 = 1 << 20;

/// Memory of a render, in bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Memory {
    /// What stays in use once it is made: grids, trees, photon maps, the director's maps and the film.
    #[serde(flatten)]
    pub kept: MemoryParts,
    /// The film with its copies while it is written.
    pub writing: u64,
    /// The most that is in use at any time.
    pub peak: u64,
    /// What the peak consists of.
    pub at_peak: MemoryParts,
}

/// Parts of the memory in use at one time, in bytes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct MemoryParts {
    /// The program and its libraries.
    pub program: u64,
    /// Voxel grids with the tables by which their emission is sampled, and what is read into them.
    pub grids: u64,
    /// Surfaces with their trees, and what is read into them.
    pub surfaces: u64,
    /// Photon maps and caches, with what building them takes.
    pub photons: u64,
    /// The film, or its copies while it is written.
    pub film: u64,
    /// The director's maps.
    pub maps: u64,
}

impl MemoryParts {
    /// Sum of all parts.
    pub const fn sum(&self) -> u64 {
        self.program + self.grids + self.surfaces + self.photons + self.film + self.maps
    }
}

/// Estimates the memory that rendering `scene` under `settings` takes without its photons, in a program
/// that takes `program` bytes before it loads the scene.
pub fn memory_without_photons(scene: &Scene, settings: &RenderSettings, program: u64) -> Memory {
    let none = PhotonMemory { held: 0, building: 0, pieces: 0, pilot: 0 };
    memory_with(scene, settings, none, program)
}

/// As [`memory_without_photons`], with `photons`.
pub(super) fn memory_with(
    scene: &Scene,
    settings: &RenderSettings,
    photons: PhotonMemory,
    program: u64,
) -> Memory {
    let program = program + WORKING + rayon::current_num_threads() as u64 * THREAD;
    let all = Window::whole(scene.film.size);
    let pixels = exposed_window(scene, settings).pixels();
    let media = &scene.media;
    let sizes = media.grid_bytes();
    let grids = sizes.iter().map(|bytes| *bytes as u64).sum::<u64>() + grids_of_times(scene);
    let surfaces = surface_bytes(scene);
    let FilmContents { features, aovs, .. } = film_contents(scene, settings);
    let plane = size_of::<f32>() * aovs.layers().len();
    let passes = (aovs.len() * size_of::<f64>() + plane) as u64;
    let features = passes + if features { FEATURES } else { 0 };
    let components = if settings.in_halves() { size_of::<PixelComponents>() as u64 } else { 0 };
    // A stated error is found without reconstruction, one that rays are directed by with it.
    let reconstructing = if settings.reconstructs() || settings.measures_error() {
        RECONSTRUCTING + (plane + reconstructed_pass_bytes(&aovs)) as u64
    } else {
        0
    };
    // Components are copied from the tiles of the film while a stated error is found.
    let copied = if settings.error.is_some() { components } else { 0 };
    let film = pixels * reconstructing.max(FILM + features + components + copied);
    let maps = map_pixels(scene, settings) * MAPS + all.pixels() * BUDGET;
    let maps = if Needs::new(scene, settings).maps { maps } else { 0 };
    let deep = if scene.film.deep { DEEP_BYTES } else { 0 };
    let writing = shown_window(scene, settings).pixels() * (WRITING + (3 * plane + deep) as u64);
    // Grids are read one after another. Beside the last there are for a while its file and OpenVDB's
    // own copy; beside a mesh, the lists that it is read into.
    let read = sizes.last().map_or(0, |bytes| 2 * *bytes as u64);
    let reading = read + surfaces;
    let tables: u64 = media.iter().map(Medium::sampler_bytes).sum();
    let retained = |freed: u64| freed.min(RETAINED);
    // Photons use what loading and a pilot have freed again.
    let most = photons.building.max(photons.pilot);
    let freed = retained(reading.max(most.saturating_sub(photons.held)));
    // The samples of the film lie in tiles, too small to be returned.
    let samples = retained(freed + pixels * size_of::<Accumulator>() as u64) - freed;
    let built = photons.building + retained(photons.pieces);
    // A pilot comes right after loading, in pieces that fit into little of what that has freed.
    let built = built.max(retained(reading) + photons.pilot);
    let scene = MemoryParts { program, grids, surfaces, ..MemoryParts::default() };
    let aimed = MemoryParts { grids: grids + tables, ..scene };
    // Loading, building the photon maps, rays, writing.
    let stages = [
        MemoryParts { grids: grids + read, surfaces: 2 * surfaces, ..scene },
        MemoryParts { maps, photons: built, ..aimed },
        MemoryParts { maps, photons: photons.held + freed, film, ..aimed },
        MemoryParts { film: writing + samples, photons: freed, ..aimed },
    ];
    let at_peak = stages.into_iter().max_by_key(MemoryParts::sum).unwrap_or(scene);
    let kept = MemoryParts { photons: photons.held, film, maps, ..aimed };
    Memory { kept, writing, peak: at_peak.sum(), at_peak }
}

/// Bytes of the grids that scenes of other times do not share with `scene`.
fn grids_of_times(scene: &Scene) -> u64 {
    let of = |scene: &Scene| scene.media.iter().flat_map(Medium::grids).collect::<Vec<_>>();
    let mut known = of(scene);
    let mut bytes = 0;
    for voxels in scene.times.iter().flat_map(of) {
        if !known.contains(&voxels) {
            known.push(voxels);
            bytes += voxels.bytes as u64;
        }
    }
    bytes
}

/// Bytes of the surfaces of `scene` and of its other times.
fn surface_bytes(scene: &Scene) -> u64 {
    let mut all = vec![&scene.surfaces];
    for moment in &scene.times {
        if all.iter().all(|known| !Arc::ptr_eq(known, &moment.surfaces)) {
            all.push(&moment.surfaces);
        }
    }
    all.into_iter().map(|surfaces| surfaces.memory_bytes() as u64).sum()
}

/// Pixels of each of the director's maps.
pub(super) fn map_pixels(scene: &Scene, settings: &RenderSettings) -> u64 {
    settings.directing.map_size(scene.film.size).map(u64::from).iter().product()
}
