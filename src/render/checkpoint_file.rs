//! Checkpoints as files.

use std::fs::File;
use std::io::{self, BufReader, Read, Write};
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::checkpoint::{CacheState, CheckpointState};
use crate::cache::LazyCells;
use crate::error::{Error, Result};
use crate::file;
use crate::film::TiledFilm;
use crate::image::{Accumulator, FeatureMean};
use crate::math::Spectrum;
use crate::work::Work;

/// What a checkpoint begins with: name and version.
const MAGIC: [u8; 12] = *b"fogbow cp 3\n";

/// Bytes of the hash at its end.
const HASH: u64 = blake3::OUT_LEN as u64;

/// The largest head, in bytes.
const MAX_HEAD: u64 = 1 << 20;

/// What a checkpoint says of itself.
#[derive(Debug, Serialize, Deserialize)]
struct Head {
    /// What it is a checkpoint of.
    key: Map<String, Value>,
    work: Work,
    /// How many pixels follow.
    pixels: u64,
    /// Whether what their rays see follows as well.
    features: bool,
    /// Cells of each lattice, and how many are known.
    lattices: Vec<[u64; 2]>,
}

impl Head {
    /// Bytes that follow it, without the hash; nothing where there could not be so many.
    fn body(&self) -> Option<u64> {
        let words = Accumulator::WORDS + if self.features { FeatureMean::WORDS } else { 0 };
        let pixels = self.pixels.checked_mul(8 * words as u64)?;
        self.lattices.iter().try_fold(pixels, |sum, [cells, known]| {
            let bits = cells.div_ceil(64).checked_mul(8)?;
            sum.checked_add(bits)?.checked_add(known.checked_mul(12)?)
        })
    }
}

/// Writes the state of a render of `key` to `path`, whole or not at all.
pub(super) fn write<S: Spectrum>(
    path: &Path,
    key: &Map<String, Value>,
    work: &Work,
    plate: &TiledFilm,
    lattices: &[&LazyCells<S>],
) -> Result<()> {
    let counts = |lattice: &&LazyCells<S>| {
        let known = (0..lattice.count()).filter(|&cell| lattice.stored(cell).is_some()).count();
        [lattice.count() as u64, known as u64]
    };
    let head = Head {
        key: key.clone(),
        work: *work,
        pixels: plate.samples().count() as u64,
        features: plate.features().next().is_some(),
        lattices: lattices.iter().map(counts).collect(),
    };
    let head = serde_json::to_vec(&head)
        .map_err(|e| Error::file(path, format!("cannot be written: {e}")))?;
    let mut passing = path.as_os_str().to_owned();
    passing.push(".new");
    file::write_by_way_of(Path::new(&passing), path, |out| {
        let mut out = Hashing::new(out);
        out.put(&MAGIC)?;
        out.put(&(head.len() as u64).to_le_bytes())?;
        out.put(&head)?;
        for samples in plate.samples() {
            out.put(samples.to_bits().map(u64::to_le_bytes).as_flattened())?;
        }
        for features in plate.features() {
            out.put(features.to_bits().map(u64::to_le_bytes).as_flattened())?;
        }
        for lattice in lattices {
            let known = |cell: &usize| lattice.stored(*cell);
            for first in (0..lattice.count()).step_by(64) {
                let cells = first..lattice.count().min(first + 64);
                let bits = cells.rev().fold(0_u64, |bits, cell| {
                    bits << 1 | u64::from(lattice.stored(cell).is_some())
                });
                out.put(&bits.to_le_bytes())?;
            }
            for value in (0..lattice.count()).filter_map(|cell| known(&cell)) {
                out.put(value.map(u32::to_le_bytes).as_flattened())?;
            }
        }
        let hash = out.hash.finalize();
        out.inner.write_all(hash.as_bytes())
    })
}

/// What the checkpoint at `path` is of.
///
/// # Errors
/// Where it cannot be read or is damaged.
pub(super) fn key(path: &Path) -> Result<Map<String, Value>> {
    Opened::open(path).map(|opened| opened.head.key)
}

/// Reads the checkpoint at `path`.
///
/// # Errors
/// Where it cannot be read, is damaged, or not of `key`.
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

/// A file of which the head has been read.
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
            "is not a checkpoint that can be gone on from: {what}; delete it, or leave out \
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

/// Everything behind the head; nothing where counts do not fit.
fn body(input: &mut Hashing<BufReader<File>>, head: &Head) -> io::Result<Option<CheckpointState>> {
    let mut samples = Vec::with_capacity(head.pixels as usize);
    for _ in 0..head.pixels {
        samples.push(Accumulator::from_bits(&input.words()?));
    }
    let told = if head.features { head.pixels } else { 0 };
    let mut features = Vec::with_capacity(told as usize);
    for _ in 0..told {
        features.push(FeatureMean::from_bits(&input.words()?));
    }
    let mut lattices = Vec::with_capacity(head.lattices.len());
    for [cells, count] in &head.lattices {
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
        lattices.push(CacheState { cells: *cells as usize, known });
    }
    Ok(Some(CheckpointState { work: head.work, samples, features, lattices }))
}

/// Refuses a checkpoint of another picture, naming what differs.
fn check_key(path: &Path, found: &Map<String, Value>, asked: &Map<String, Value>) -> Result<()> {
    let none = Value::Null;
    let names = asked.keys().chain(found.keys().filter(|name| !asked.contains_key(*name)));
    let differs = |name: &&String| found.get(*name) != asked.get(*name);
    let of = |map: &Map<String, Value>, name: &str| map.get(name).unwrap_or(&none).to_string();
    let named: Vec<String> = names
        .filter(differs)
        .map(|name| format!("{name} is {} there and {} here", of(found, name), of(asked, name)))
        .collect();
    if named.is_empty() {
        return Ok(());
    }
    Err(Error::file(
        path,
        format!(
            "is the checkpoint of another render: {}; ask for the same, or delete it or leave out \
             --resume to start anew",
            named.join(", ")
        ),
    ))
}

/// Hashes what is written or read.
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
