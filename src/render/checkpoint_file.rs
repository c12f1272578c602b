//! The file format of checkpoints.
//!
//! A [state file](super::state_file): its head is key, work, rounds, and how much follows. Its body:
//!
//! 1. samples of each pixel, then features, components and sums of passes where they are gathered, as the bits of their numbers
//! 2. XS and saliency of each pixel of the whole film, where a director has measured them
//! 3. the [cells](super::cell_file) of each cache

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

use super::cell_file::{self, CellsHead};
use super::rounds::Round;
use super::state_file::{FileKind, Hashing, Opened};

/// The filled cells of a cache.
#[derive(Debug, PartialEq)]
pub(super) struct CacheState {
    /// What they are.
    pub head: CellsHead,
    /// Indices of those that are filled.
    pub known: Vec<usize>,
    /// Their bits, cell by cell.
    pub bits: Vec<u32>,
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
    magic: *b"fogbow cp 9\n",
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
    /// Numbers of each pixel for passes, which follow those.
    aovs: u64,
    /// Number of pixels whose importance follows those.
    importance: u64,
    /// The cells of each cache.
    caches: Vec<CellsHead>,
}

impl Head {
    /// Bytes between head and hash; `None` where the number overflows.
    fn body(&self) -> Option<u64> {
        let features = if self.features { FeatureMean::WORDS } else { 0 };
        let components = if self.components { PixelComponents::WORDS } else { 0 };
        let words = ((Accumulator::WORDS + features + components) as u64).checked_add(self.aovs)?;
        let pixels = self.pixels.checked_mul(words.checked_mul(8)?)?;
        let pixels = pixels.checked_add(self.importance.checked_mul(8)?)?;
        self.caches.iter().try_fold(pixels, |sum, cells| sum.checked_add(cells.bytes()?))
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
    let head = Head {
        key: key.clone(),
        work: *work,
        rounds: rounds.to_vec(),
        pixels: film.samples().count() as u64,
        features: film.features().next().is_some(),
        components: film.components().next().is_some(),
        aovs: film.aovs.len() as u64,
        importance: film.importance.len() as u64,
        caches: caches.iter().map(|cache| CellsHead::new(cache)).collect(),
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
    for sum in film.aov_sums() {
        out.put(&sum.to_le_bytes())?;
    }
    for Importance { xs, saliency } in &film.importance {
        out.put([*xs, *saliency].map(f32::to_le_bytes).as_flattened())?;
    }
    caches.iter().try_for_each(|cache| cell_file::write(out, cache))
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
    Ok(body)
}

/// Reads what lies between head and hash.
fn body(input: &mut Hashing<BufReader<File>>, head: &Head) -> io::Result<CheckpointState> {
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
    // The head was checked against the length of the file.
    let count = head.pixels * head.aovs;
    let mut aovs = Vec::with_capacity(count as usize);
    for _ in 0..count {
        aovs.push(f64::from_le_bytes(input.take()?));
    }
    let mut importance = Vec::with_capacity(head.importance as usize);
    for _ in 0..head.importance {
        let [xs, saliency] = [input.take()?, input.take()?].map(f32::from_le_bytes);
        importance.push(Importance { xs, saliency });
    }
    let mut caches = Vec::with_capacity(head.caches.len());
    for head in &head.caches {
        let (mut known, mut bits) = (Vec::new(), Vec::new());
        head.read(input, |cell, of_cell| {
            known.push(cell);
            bits.extend_from_slice(of_cell);
        })?;
        caches.push(CacheState { head: *head, known, bits });
    }
    let film = FilmState { samples, features, components, aovs, importance };
    Ok(CheckpointState { work: head.work, rounds: head.rounds.clone(), film, caches })
}
