//! Files that are opened only where they can be read, and appear whole or not at all.

mod blocks;

use std::fs::{File, Permissions};
use std::io::{BufWriter, Read, Write};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

pub use blocks::{Fill, Put, read_blocks, write_blocks};

use crate::error::{Error, Result};

/// Opens a regular file for reading. A pipe is not waited for.
///
/// # Errors
/// Where there is no such file, it is not readable, a folder, a pipe or a device.
pub fn open(path: &Path) -> Result<File> {
    let unreadable = |e| Error::file(path, format!("cannot be read: {e}"));
    let kind = std::fs::metadata(path).map_err(unreadable)?.file_type();
    if kind.is_dir() {
        return Err(Error::file(path, "is a folder; name a file"));
    }
    if !kind.is_file() {
        return Err(Error::file(path, "is a pipe or a device; save it to a file and name that"));
    }
    File::open(path).map_err(unreadable)
}

/// Reads a regular file of at most `most` bytes.
///
/// # Errors
/// As [`open`], and where it is larger or cannot be read to its end.
pub fn read(path: &Path, most: u64) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let read = open(path)?.take(most + 1).read_to_end(&mut bytes);
    read.map_err(|e| Error::file(path, format!("cannot be read: {e}")))?;
    if bytes.len() as u64 > most {
        return Err(Error::file(
            path,
            format!("is larger than {most} bytes, the most it may have"),
        ));
    }
    Ok(bytes)
}

/// A file under a temporary name beside its target. [`finish`](Self::finish) renames it to the
/// target; dropped before, it vanishes and an earlier target stays as it was.
#[derive(Debug)]
pub struct PendingFile {
    temporary: NamedTempFile,
    target: PathBuf,
}

impl PendingFile {
    /// Opens a temporary file in the folder of `target`.
    ///
    /// # Errors
    /// Where the folder is missing or not writable, or `target` is there and no regular file.
    pub fn new(target: &Path) -> Result<Self> {
        if target.exists() && !target.is_file() {
            return Err(Error::file(target, "is not a regular file; name a file to write"));
        }
        let folder = match target.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        let temporary = tempfile::Builder::new()
            .prefix(".fogbow-")
            .permissions(Permissions::from_mode(0o666)) // the umask applies, as to any new file
            .tempfile_in(folder)
            .map_err(|e| Error::file(target, format!("cannot be written: {}", cause(&e))))?;
        Ok(Self { temporary, target: target.to_path_buf() })
    }

    /// The temporary path, for writers that want a path.
    pub fn path(&self) -> &Path {
        self.temporary.path()
    }

    /// The open file.
    pub fn file(&mut self) -> &mut File {
        self.temporary.as_file_mut()
    }

    /// Gives the file its name, replacing what was there.
    ///
    /// # Errors
    /// Where the rename fails; the earlier file is intact then.
    pub fn finish(self) -> Result<()> {
        let target = self.target;
        self.temporary
            .persist(&target)
            .map(drop)
            .map_err(|e| Error::file(&target, format!("cannot be written: {}", cause(&e.error))))
    }
}

/// Writes `target` with `write`, whole or not at all.
///
/// # Errors
/// Where the folder, the writing or the rename fails; the earlier file is intact then.
pub fn write(
    target: &Path,
    write: impl FnOnce(&mut BufWriter<&mut File>) -> std::io::Result<()>,
) -> Result<()> {
    pending(target, write)?.finish()
}

/// Writes what is to be `target` with `write`, under a temporary name: files that belong together
/// are all written before the first gets its name.
///
/// # Errors
/// Where the folder or the writing fails.
pub fn pending(
    target: &Path,
    write: impl FnOnce(&mut BufWriter<&mut File>) -> std::io::Result<()>,
) -> Result<PendingFile> {
    let mut pending = PendingFile::new(target)?;
    let mut out = BufWriter::new(pending.file());
    write(&mut out)
        .and_then(|()| out.flush())
        .map_err(|e| Error::file(target, format!("cannot be written: {e}")))?;
    drop(out);
    Ok(pending)
}

/// What went wrong, without the temporary name that `tempfile` adds to it.
fn cause(error: &std::io::Error) -> String {
    let text = error.to_string();
    text.split_once(" at path ").map_or(text.as_str(), |(cause, _)| cause).to_owned()
}

/// Writes `target` with `write`, whole or not at all, by way of the file `passing` in the same
/// folder: what a program that was killed has left there is written over. The bytes are on the disk
/// when it returns.
///
/// # Errors
/// As [`write()`]; nothing is left at `passing` then.
pub fn write_by_way_of(
    passing: &Path,
    target: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> std::io::Result<()>,
) -> Result<()> {
    let written = File::create(passing).and_then(|file| {
        let mut out = BufWriter::new(file);
        write(&mut out)?;
        out.flush()?;
        out.get_ref().sync_data()?;
        std::fs::rename(passing, target)
    });
    written.map_err(|e| {
        let _ = std::fs::remove_file(passing);
        Error::file(target, format!("cannot be written: {e}"))
    })
}
