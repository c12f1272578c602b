//! Files that hold a state of a render.
//!
//! 1. name and version, 12 bytes
//! 2. length of the head in bytes, u64; all numbers are little-endian
//! 3. head in JSON
//! 4. body, as long as the head tells
//! 5. BLAKE3 hash of all before it

use std::fs::File;
use std::io::{self, BufReader, Read, Write};
use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use crate::error::{Error, Result};
use crate::file;

/// Bytes of the hash.
pub(super) const HASH: u64 = blake3::OUT_LEN as u64;

/// Largest length of a head, in bytes: many times a real one's, so that a damaged file cannot ask for all
/// memory.
const MAX_HEAD: u64 = 1 << 20;

/// A kind of files, and how messages speak of it.
#[derive(Debug)]
pub(super) struct FileKind {
    /// Name and version.
    pub magic: [u8; 12],
    /// What a damaged or foreign file is not.
    pub is_none: &'static str,
    /// What to do with that.
    pub remedy: &'static str,
    /// What one with another key is.
    pub is_other: &'static str,
    /// What to do with that.
    pub other_remedy: &'static str,
}

impl FileKind {
    /// Writes `head` and then the body to `out`, and their hash.
    ///
    /// # Errors
    /// Where writing fails.
    pub fn write<W: Write>(
        &self,
        out: W,
        head: &impl Serialize,
        body: impl FnOnce(&mut Hashing<W>) -> io::Result<()>,
    ) -> io::Result<()> {
        let head = serde_json::to_vec(head)?;
        let mut out = Hashing::new(out);
        out.put(&self.magic)?;
        out.put(&(head.len() as u64).to_le_bytes())?;
        out.put(&head)?;
        body(&mut out)?;
        let hash = out.hash.finalize();
        out.inner.write_all(hash.as_bytes())
    }

    /// Opens the file `path` and reads its head, of which `body` tells the length of the body.
    ///
    /// # Errors
    /// Where it cannot be read, is none of these files or not as long as it says.
    pub fn open<Head: DeserializeOwned>(
        &self,
        path: &Path,
        body: impl FnOnce(&Head) -> Option<u64>,
    ) -> Result<Opened<Head>> {
        let file = file::open(path)?;
        let length = file.metadata().map_or(0, |data| data.len());
        let mut input = Hashing::new(BufReader::new(file));
        let magic: [u8; 12] = input.take().map_err(|e| self.cut(path, &e))?;
        if magic != self.magic {
            let what = "it is of another version of fogbow, or none of its files";
            return Err(self.damaged(path, what));
        }
        let size = u64::from_le_bytes(input.take().map_err(|e| self.cut(path, &e))?);
        if size > MAX_HEAD.min(length) {
            return Err(self.damaged(path, "its head is too large"));
        }
        let mut head = vec![0; size as usize];
        input.fill(&mut head).map_err(|e| self.cut(path, &e))?;
        let head: Head = serde_json::from_slice(&head)
            .map_err(|_| self.damaged(path, "its head cannot be understood"))?;
        let before = self.magic.len() as u64 + 8 + size;
        let whole = body(&head).and_then(|body| body.checked_add(before + HASH));
        if whole != Some(length) {
            return Err(self.damaged(path, "it is not as long as it says"));
        }
        Ok(Opened { input, head })
    }

    /// Reads the hash behind the body of the file `path`.
    ///
    /// # Errors
    /// Where it does not fit what was read before.
    pub fn check_hash(&self, path: &Path, input: &mut Hashing<BufReader<File>>) -> Result<()> {
        let hash = input.hash.finalize();
        let mut stored = [0; HASH as usize];
        input.inner.read_exact(&mut stored).map_err(|e| self.cut(path, &e))?;
        if hash != stored {
            return Err(self.damaged(path, "its hash does not fit its content"));
        }
        Ok(())
    }

    /// Refuses a file with the key `found`; the error names the entries in which it differs from the one that is
    /// `wanted`.
    ///
    /// # Errors
    /// Where there are such.
    pub fn check_key(
        &self,
        path: &Path,
        found: &Map<String, Value>,
        wanted: &Map<String, Value>,
    ) -> Result<()> {
        let none = Value::Null;
        let names = wanted.keys().chain(found.keys().filter(|name| !wanted.contains_key(*name)));
        let differs = |name: &&String| found.get(*name) != wanted.get(*name);
        let entry =
            |map: &Map<String, Value>, name: &str| map.get(name).unwrap_or(&none).to_string();
        let differences: Vec<String> = names
            .filter(differs)
            .map(|name| {
                format!("{name} is {} there and {} here", entry(found, name), entry(wanted, name))
            })
            .collect();
        if differences.is_empty() {
            return Ok(());
        }
        let Self { is_other, other_remedy, .. } = self;
        let differences = differences.join(", ");
        Err(Error::file(path, format!("{is_other}: {differences}; {other_remedy}")))
    }

    /// That `what` is wrong with the file `path`.
    pub fn damaged(&self, path: &Path, what: &str) -> Error {
        Error::file(path, format!("{}: {what}; {}", self.is_none, self.remedy))
    }

    /// That the file `path` could not be read on.
    pub fn cut(&self, path: &Path, e: &io::Error) -> Error {
        match e.kind() {
            io::ErrorKind::UnexpectedEof => self.damaged(path, "it ends too early"),
            io::ErrorKind::InvalidData => {
                self.damaged(path, "it holds something else than it says")
            }
            _ => Error::file(path, format!("cannot be read: {e}")),
        }
    }
}

/// A file whose head was read.
pub(super) struct Opened<Head> {
    pub input: Hashing<BufReader<File>>,
    pub head: Head,
}

/// A reader or writer that hashes the bytes that pass.
pub(super) struct Hashing<T> {
    inner: T,
    hash: blake3::Hasher,
}

impl<T> Hashing<T> {
    /// Of `inner`, none of whose bytes have passed.
    pub fn new(inner: T) -> Self {
        Self { inner, hash: blake3::Hasher::new() }
    }
}

impl<T: Write> Hashing<T> {
    /// Writes `bytes`.
    pub fn put(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.hash.update(bytes);
        self.inner.write_all(bytes)
    }
}

impl<T: Read> Hashing<T> {
    /// Reads as many bytes as there are in `bytes`.
    pub fn fill(&mut self, bytes: &mut [u8]) -> io::Result<()> {
        self.inner.read_exact(bytes)?;
        self.hash.update(bytes);
        Ok(())
    }

    /// Reads N bytes.
    pub fn take<const N: usize>(&mut self) -> io::Result<[u8; N]> {
        let mut bytes = [0; N];
        self.fill(&mut bytes)?;
        Ok(bytes)
    }

    /// Reads N words.
    pub fn words<const N: usize>(&mut self) -> io::Result<[u64; N]> {
        let mut words = [[0; 8]; N];
        self.fill(words.as_flattened_mut())?;
        Ok(words.map(u64::from_le_bytes))
    }
}
