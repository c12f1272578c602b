//! Packages (.usdz): layers, pictures and volumes in an archive that stores them as they are.

use std::fmt::Display;
use std::io::{self, Cursor, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use zip::read::ZipFile;
use zip::{CompressionMethod, ZipArchive};

/// Most files of a package: those of an archive without the extension for large ones.
const MAX_FILES: u64 = 65_535;

/// Directories of a package, of which one is its own and others are those of packages in it, above which
/// [`MAX_READ`] holds.
const MAX_DIRECTORIES: u64 = 100;

/// Most bytes that may be read to look at all directories of a package.
const MAX_READ: u64 = 1 << 34;

/// Bytes of a record that ends a directory, as far as they are looked at.
const RECORD: usize = 40;

/// Bytes of a package that are looked at together.
const BLOCK: u64 = 1 << 20;

/// Endings of layers in packages, by which the crate knows them.
const LAYERS: [&str; 3] = [".usd", ".usda", ".usdc"];

/// Whether `bytes` begin like a package.
pub(super) fn is_package(bytes: &[u8]) -> bool {
    bytes.starts_with(b"PK")
}

/// Unpacks the package `path` into `folder`. Returns its first layer.
pub(super) fn unpack(path: &Path, folder: &Path) -> Result<PathBuf, String> {
    let file = std::fs::File::open(path).map_err(|e| damaged(&e))?;
    let mut left = file.metadata().map_err(|e| damaged(&e))?.len();
    let mut first = None;
    each_entry(file, |mut entry| {
        if entry.is_dir() {
            return Ok(());
        }
        let name = entry.enclosed_name().ok_or_else(|| damaged(&"a name that leads out of it"))?;
        left = size_left(&entry, left).map_err(|e| damaged(&e))?;
        let target = folder.join(&name);
        target.parent().map_or(Ok(()), std::fs::create_dir_all).map_err(|e| damaged(&e))?;
        let mut out = std::fs::File::create(&target).map_err(|e| damaged(&e))?;
        let size = entry.size();
        io::copy(&mut (&mut entry).take(size), &mut out).map_err(|e| damaged(&e))?;
        first.get_or_insert(target);
        Ok(())
    })?;
    first.ok_or_else(|| damaged(&"it is empty"))
}

/// Calls `visit` with each layer of the package `bytes`.
///
/// # Errors
/// Where it cannot be read, or `visit` fails.
pub(super) fn each_layer(
    bytes: &[u8],
    mut visit: impl FnMut(Vec<u8>) -> Result<(), String>,
) -> Result<(), String> {
    let mut left = bytes.len() as u64;
    each_entry(Cursor::new(bytes), |entry| {
        left = size_left(&entry, left).map_err(|e| damaged(&e))?;
        if !LAYERS.iter().any(|ending| entry.name().ends_with(ending)) {
            return Ok(());
        }
        let (mut layer, size) = (Vec::new(), entry.size());
        entry.take(size).read_to_end(&mut layer).map_err(|e| damaged(&e))?;
        visit(layer)
    })
}

/// Calls `visit` with each file and folder of a package.
fn each_entry<R: Read + Seek>(
    mut package: R,
    mut visit: impl FnMut(ZipFile<'_, R>) -> Result<(), String>,
) -> Result<(), String> {
    check_directories(&mut package)?;
    let mut archive = ZipArchive::new(package).map_err(|e| damaged(&e))?;
    for index in 0..archive.len() {
        visit(archive.by_index(index).map_err(|e| damaged(&e))?)?;
    }
    Ok(())
}

/// Whether the file `path` is a package whose directory can be read.
pub(super) fn has_directory(path: &Path) -> bool {
    std::fs::File::open(path).is_ok_and(|mut file| check_directories(&mut file).is_ok())
}

/// Refuses a package of more files than are of use, or of so many directories that to read them takes long: the crate
/// asks for memory by the number of files that a directory tells, and reads one directory after the other until one fits.
fn check_directories<R: Read + Seek>(package: &mut R) -> Result<(), String> {
    let size = package.seek(SeekFrom::End(0)).map_err(|e| damaged(&e))?;
    package.rewind().map_err(|e| damaged(&e))?;
    let mut bytes = package.chain(io::repeat(0).take(RECORD as u64 - 1));
    let (mut block, mut directories) = (Vec::new(), 0_u64);
    loop {
        block.drain(..block.len().saturating_sub(RECORD - 1));
        let more = bytes.by_ref().take(BLOCK).read_to_end(&mut block).map_err(|e| damaged(&e))?;
        for record in block.windows(RECORD).filter(|record| record.starts_with(b"PK")) {
            let number = |at: usize, bytes: usize| {
                record[at..at + bytes].iter().rev().fold(0, |sum, byte| sum << 8 | u64::from(*byte))
            };
            let files = match &record[2..4] {
                [5, 6] => {
                    directories += 1;
                    number(10, 2)
                }
                [6, 6] => number(32, 8),
                _ => 0,
            };
            // The crate refuses more files than there is room for.
            if files > MAX_FILES && files < size {
                let problem = format!("it has {files} files; give one of at most {MAX_FILES}");
                return Err(damaged(&problem));
            }
        }
        if more == 0 {
            break;
        }
    }
    if directories > MAX_DIRECTORIES && directories.saturating_mul(size) > MAX_READ {
        return Err(damaged(&format!(
            "it has {directories} directories; give one with its own alone"
        )));
    }
    Ok(())
}

fn damaged(problem: &dyn Display) -> String {
    format!("is no USD package that can be read: {problem}")
}

/// What of the `left` bytes of a package remains for others behind `entry`.
fn size_left<R: Read>(entry: &ZipFile<'_, R>, left: u64) -> Result<u64, &'static str> {
    if entry.compression() != CompressionMethod::Stored {
        return Err("its files are compressed, and a package stores them as they are");
    }
    left.checked_sub(entry.size()).ok_or("its sizes cannot be")
}
