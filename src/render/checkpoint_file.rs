//! The file format of checkpoints.
//!
//! A [state file](super::state_file): its head is key, work, rounds, and how much follows. Its body:
//!
//! 1. samples of each pixel, then features and components where they are gathered, as the bits of their numbers
//! 2. XS and saliency of each pixel of the whole film, where a director has measured them
//! 3. for each cache a bit a cell, set where it is filled, in words of 64; then the filled cells' values

use std::fs::File;
use std::io::{self, BufReader, Write};
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::cache::LazyCells;
use crate::error::Result;
use crate::file;
use crate::film::{Accumulator, FeatureMean, FilmState, Importance, PixelComponents, TiledFilm};
use crate::math::Spectrum;
use crate::work::Work;

use super::rounds::Round;
use super::state_file::{FileKind, Hashing, Opened};

/// The filled cells of a cache.
#[derive(Debug, PartialEq)]
pub(super) struct CacheState {
    /// Cells of the cache, filled or not.
    pub cells: usize,
    /// Index and value of those that are filled.
    pub known: Vec<(u32, [u32; 3])>,
}

/// The state of an exposure between two rays.
#[derive(Debug, PartialEq)]
pub(super) struct CheckpointState {
    /// Work done so far.
    pub work: Work,
    /// Rounds that were begun, where the render has rounds.
    pub rounds: Vec<Round>,
    /// What pixels have gathered.
    pub film: FilmState,
    /// Filled cells, one entry for each cache.
    pub caches: Vec<CacheState>,
}

/// Checkpoints, with name and version of their format.
const CHECKPOINT: FileKind = FileKind {
    magic: *b"fogbow cp 7\n",
    is_none: "is not a checkpoint that can be resumed",
    remedy: "delete it, or leave out --resume, to start from the beginning",
    is_other: "is the checkpoint of another render",
    other_remedy: "ask for the same, or delete it or leave out --resume to start anew",
};

/// The head of a file.
#[derive(Debug, Serialize, Deserialize)]
struct Head {
    /// Identifies the picture.
    key: Map<String, Value>,
    work: Work,
    /// Rounds that were begun, where the render has rounds.
    rounds: Vec<Round>,
    /// Number of pixels.
    pixels: u64,
    /// Whether features follow the samples.
    features: bool,
    /// Whether components follow those.
    components: bool,
    /// Number of pixels whose importance follows those.
    importance: u64,
    /// For each cache, the number of its cells and of those that are filled.
    #[serde(rename = "lattices")]
    caches: Vec<[u64; 2]>,
}

impl Head {
    /// Bytes between head and hash; `None` where the number overflows.
    fn body(&self) -> Option<u64> {
        let features = if self.features { FeatureMean::WORDS } else { 0 };
        let components = if self.components { PixelComponents::WORDS } else { 0 };
        let words = Accumulator::WORDS + features + components;
        let pixels = self.pixels.checked_mul(8 * words as u64)?;
        let pixels = pixels.checked_add(self.importance.checked_mul(8)?)?;
        self.caches.iter().try_fold(pixels, |sum, [cells, known]| {
            let bits = cells.div_ceil(64).checked_mul(8)?;
            sum.checked_add(bits)?.checked_add(known.checked_mul(12)?)
        })
    }
}

/// Writes the state of a render with `key` to `path`, whole or not at all.
pub(super) fn write<S: Spectrum>(
    path: &Path,
    key: &Map<String, Value>,
    work: &Work,
    rounds: &[Round],
    film: &TiledFilm,
    caches: &[&LazyCells<S>],
) -> Result<()> {
    let counts = |cache: &&LazyCells<S>| {
        let known = (0..cache.count()).filter(|&cell| cache.stored(cell).is_some()).count();
        [cache.count() as u64, known as u64]
    };
    let head = Head {
        key: key.clone(),
        work: *work,
        rounds: rounds.to_vec(),
        pixels: film.samples().count() as u64,
        features: film.features().next().is_some(),
        components: film.components().next().is_some(),
        importance: film.importance.len() as u64,
        caches: caches.iter().map(counts).collect(),
    };
    let mut temporary = path.as_os_str().to_owned();
    temporary.push(".new");
    file::write_by_way_of(Path::new(&temporary), path, |out| {
        CHECKPOINT.write(out, &head, |out| write_body(out, film, caches))
    })
}

/// Writes what lies between head and hash.
fn write_body<S: Spectrum, W: Write>(
    out: &mut Hashing<W>,
    film: &TiledFilm,
    caches: &[&LazyCells<S>],
) -> io::Result<()> {
    for samples in film.samples() {
        out.put(samples.to_bits().map(u64::to_le_bytes).as_flattened())?;
    }
    for features in film.features() {
        out.put(features.to_bits().map(u64::to_le_bytes).as_flattened())?;
    }
    for components in film.components() {
        out.put(components.to_bits().map(u64::to_le_bytes).as_flattened())?;
    }
    for Importance { xs, saliency } in &film.importance {
        out.put([*xs, *saliency].map(f32::to_le_bytes).as_flattened())?;
    }
    for cache in caches {
        for first in (0..cache.count()).step_by(64) {
            let cells = first..cache.count().min(first + 64);
            let bits = cells
                .rev()
                .fold(0_u64, |bits, cell| bits << 1 | u64::from(cache.stored(cell).is_some()));
            out.put(&bits.to_le_bytes())?;
        }
        for value in (0..cache.count()).filter_map(|cell| cache.stored(cell)) {
            out.put(value.map(u32::to_le_bytes).as_flattened())?;
        }
    }
    Ok(())
}

/// Reads the key of the checkpoint `path`.
///
/// # Errors
/// Where it cannot be read or is damaged.
pub(super) fn key(path: &Path) -> Result<Map<String, Value>> {
    CHECKPOINT.open(path, Head::body).map(|opened| opened.head.key)
}

/// Reads the checkpoint `path`.
///
/// # Errors
/// Where it cannot be read, is damaged or has another key than `key`.
pub(super) fn read(path: &Path, key: &Map<String, Value>) -> Result<CheckpointState> {
    let Opened { mut input, head } = CHECKPOINT.open(path, Head::body)?;
    CHECKPOINT.check_key(path, &head.key, key)?;
    let body = body(&mut input, &head).map_err(|e| CHECKPOINT.cut(path, &e))?;
    CHECKPOINT.check_hash(path, &mut input)?;
    body.ok_or_else(|| CHECKPOINT.damaged(path, "it has not as many cells as it says"))
}

/// Reads what lies between head and hash; `None` where bits and number of filled cells disagree.
fn body(input: &mut Hashing<BufReader<File>>, head: &Head) -> io::Result<Option<CheckpointState>> {
    let mut samples = Vec::with_capacity(head.pixels as usize);
    for _ in 0..head.pixels {
        samples.push(Accumulator::from_bits(&input.words()?));
    }
    let count = if head.features { head.pixels } else { 0 };
    let mut features = Vec::with_capacity(count as usize);
    for _ in 0..count {
        features.push(FeatureMean::from_bits(&input.words()?));
    }
    let count = if head.components { head.pixels } else { 0 };
    let mut components = Vec::with_capacity(count as usize);
    for _ in 0..count {
        components.push(PixelComponents::from_bits(&input.words()?));
    }
    let mut importance = Vec::with_capacity(head.importance as usize);
    for _ in 0..head.importance {
        let [xs, saliency] = [input.take()?, input.take()?].map(f32::from_le_bytes);
        importance.push(Importance { xs, saliency });
    }
    let mut caches = Vec::with_capacity(head.caches.len());
    for [cells, count] in &head.caches {
        let mut indices = Vec::with_capacity(*count as usize);
        for first in (0..*cells).step_by(64) {
            let bits = u64::from_le_bytes(input.take()?);
            let set = (0..64).filter(|bit| bits >> bit & 1 == 1);
            indices.extend(set.map(|bit| (first + bit) as u32));
        }
        if indices.len() as u64 != *count {
            return Ok(None);
        }
        let mut known = Vec::with_capacity(indices.len());
        for index in indices {
            let mut value = [[0; 4]; 3];
            input.fill(value.as_flattened_mut())?;
            known.push((index, value.map(u32::from_le_bytes)));
        }
        caches.push(CacheState { cells: *cells as usize, known });
    }
    let film = FilmState { samples, features, components, importance };
    Ok(Some(CheckpointState { work: head.work, rounds: head.rounds.clone(), film, caches }))
}
