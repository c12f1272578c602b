//! Packages (.usdz): layers, pictures and volumes in an archive that stores them as they are.

use std::fmt::Display;
use std::io::{self, Cursor, Read, Seek};
use std::path::{Path, PathBuf};

use zip::read::ZipFile;
use zip::{CompressionMethod, ZipArchive};

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
    package: R,
    mut visit: impl FnMut(ZipFile<'_, R>) -> Result<(), String>,
) -> Result<(), String> {
    let mut archive = ZipArchive::new(package).map_err(|e| damaged(&e))?;
    for index in 0..archive.len() {
        visit(archive.by_index(index).map_err(|e| damaged(&e))?)?;
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
