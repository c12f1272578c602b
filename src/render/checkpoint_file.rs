//! The file format of checkpoints.
//!
//! 1. name and version, 12 bytes
//! 2. length of the head in bytes, u64; all numbers are little-endian
//! 3. head in JSON: key, work, rounds, and how much follows
//! 4. samples of each pixel, then features and components where they are gathered, as the bits of their numbers
//! 5. XS and saliency of each pixel of the whole film, where a director has measured them
//! 6. for each cache a bit a cell, set where it is filled, in words of 64; then the filled cells' values
//! 7. BLAKE3 hash of all before it

use std::fs::File;
use std::io::{self, BufReader, Read, Write};
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::cache::LazyCells;
use crate::error::{Error, Result};
use crate::file;
use crate::film::{Accumulator, FeatureMean, FilmState, Importance, PixelComponents, TiledFilm};
use crate::math::Spectrum;
use crate::work::Work;

use super::rounds::Round;

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

/// Name and version of the format.
const MAGIC: [u8; 12] = *b"fogbow cp 7\n";

/// Bytes of the hash.
const HASH: u64 = blake3::OUT_LEN as u64;

/// Largest length of a head, in bytes: many times a real one's, so that a damaged file cannot ask for all
/// memory.
const MAX_HEAD: u64 = 1 << 20;

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
    let head = serde_json::to_vec(&head)
        .map_err(|e| Error::file(path, format!("cannot be written: {e}")))?;
    let mut temporary = path.as_os_str().to_owned();
    temporary.push(".new");
    file::write_by_way_of(Path::new(&temporary), path, |out| {
        let mut out = Hashing::new(out);
        out.put(&MAGIC)?;
        out.put(&(head.len() as u64).to_le_bytes())?;
        out.put(&head)?;
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
            let known = |cell: &usize| cache.stored(*cell);
            for first in (0..cache.count()).step_by(64) {
                let cells = first..cache.count().min(first + 64);
                let bits = cells
                    .rev()
                    .fold(0_u64, |bits, cell| bits << 1 | u64::from(cache.stored(cell).is_some()));
                out.put(&bits.to_le_bytes())?;
            }
            for value in (0..cache.count()).filter_map(|cell| known(&cell)) {
                out.put(value.map(u32::to_le_bytes).as_flattened())?;
            }
        }
        let hash = out.hash.finalize();
        out.inner.write_all(hash.as_bytes())
    })
}

/// Reads the key of the checkpoint `path`.
///
/// # Errors
/// Where it cannot be read or is damaged.
pub(super) fn key(path: &Path) -> Result<Map<String, Value>> {
    Opened::open(path).map(|opened| opened.head.key)
}

/// Reads the checkpoint `path`.
///
/// # Errors
/// Where it cannot be read, is damaged or has another key than `key`.
pub(super) fn read(path: &Path, key: &Map<String, Value>) -> Result<CheckpointState> {
    let Opened { mut input, head } = Opened::open(path)?;
    check_key(path, &head.key, key)?;
    let body = body(&mut input, &head).map_err(|e| cut(path, &e))?;
    let hash = input.hash.finalize();
    let mut stored = [0; HASH as usize];
    input.inner.read_exact(&mut stored).map_err(|e| cut(path, &e))?;
    if hash != stored {
        return Err(damaged(path, "its hash does not fit its content"));
    }
    body.ok_or_else(|| damaged(path, "it has not as many cells as it says"))
}

/// A file whose head was read.
struct Opened {
    input: Hashing<BufReader<File>>,
    head: Head,
}

impl Opened {
    fn open(path: &Path) -> Result<Self> {
        let file = file::open(path)?;
        let length = file.metadata().map_or(0, |data| data.len());
        let mut input = Hashing::new(BufReader::new(file));
        let magic: [u8; MAGIC.len()] = input.take().map_err(|e| cut(path, &e))?;
        if magic != MAGIC {
            return Err(damaged(path, "it is of another version of fogbow, or none of its files"));
        }
        let size = u64::from_le_bytes(input.take().map_err(|e| cut(path, &e))?);
        if size > MAX_HEAD.min(length) {
            return Err(damaged(path, "its head is too large"));
        }
        let mut head = vec![0; size as usize];
        input.fill(&mut head).map_err(|e| cut(path, &e))?;
        let head: Head = serde_json::from_slice(&head)
            .map_err(|_| damaged(path, "its head cannot be understood"))?;
        let before = MAGIC.len() as u64 + 8 + size;
        let whole = head.body().and_then(|body| body.checked_add(before + HASH));
        if whole != Some(length) {
            return Err(damaged(path, "it is not as long as it says"));
        }
        Ok(Self { input, head })
    }
}

fn damaged(path: &Path, what: &str) -> Error {
    Error::file(
        path,
        format!(
            "is not a checkpoint that can be resumed: {what}; delete it, or leave out \
             --resume, to start from the beginning"
        ),
    )
}

fn cut(path: &Path, e: &io::Error) -> Error {
    match e.kind() {
        io::ErrorKind::UnexpectedEof => damaged(path, "it ends too early"),
        _ => Error::file(path, format!("cannot be read: {e}")),
    }
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

/// Refuses a checkpoint of another picture; the error names the entries of the key that differ.
fn check_key(path: &Path, found: &Map<String, Value>, wanted: &Map<String, Value>) -> Result<()> {
    let none = Value::Null;
    let names = wanted.keys().chain(found.keys().filter(|name| !wanted.contains_key(*name)));
    let differs = |name: &&String| found.get(*name) != wanted.get(*name);
    let entry = |map: &Map<String, Value>, name: &str| map.get(name).unwrap_or(&none).to_string();
    let differences: Vec<String> = names
        .filter(differs)
        .map(|name| {
            format!("{name} is {} there and {} here", entry(found, name), entry(wanted, name))
        })
        .collect();
    if differences.is_empty() {
        return Ok(());
    }
    Err(Error::file(
        path,
        format!(
            "is the checkpoint of another render: {}; ask for the same, or delete it or leave out \
             --resume to start anew",
            differences.join(", ")
        ),
    ))
}

/// A reader or writer that hashes the bytes that pass.
struct Hashing<T> {
    inner: T,
    hash: blake3::Hasher,
}

impl<T> Hashing<T> {
    fn new(inner: T) -> Self {
        Self { inner, hash: blake3::Hasher::new() }
    }
}

impl<T: Write> Hashing<T> {
    fn put(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.hash.update(bytes);
        self.inner.write_all(bytes)
    }
}

impl<T: Read> Hashing<T> {
    fn fill(&mut self, bytes: &mut [u8]) -> io::Result<()> {
        self.inner.read_exact(bytes)?;
        self.hash.update(bytes);
        Ok(())
    }

    fn take<const N: usize>(&mut self) -> io::Result<[u8; N]> {
        let mut bytes = [0; N];
        self.fill(&mut bytes)?;
        Ok(bytes)
    }

    fn words<const N: usize>(&mut self) -> io::Result<[u64; N]> {
        let mut words = [[0; 8]; N];
        self.fill(words.as_flattened_mut())?;
        Ok(words.map(u64::from_le_bytes))
    }
}
