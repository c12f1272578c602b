//! Grids written and read back, and the public volumes.

#![allow(dead_code)] // each test uses a part

use std::path::{Path, PathBuf};

use fogbow::vdb::{GridToWrite, VdbFile, write};

use crate::skip;

/// A file or folder among the public volumes, where they are there.
pub(crate) fn shared(file: &str) -> Option<PathBuf> {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/volumes")).join(file);
    if !path.exists() {
        skip::skip(path.display());
        return None;
    }
    Some(path)
}

/// The grids as a file, which lives as long as the folder.
pub(crate) fn written(grids: &[GridToWrite]) -> (tempfile::TempDir, VdbFile) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("made.vdb");
    write(&path, grids).unwrap();
    let file = VdbFile::open(&path).unwrap();
    (folder, file)
}
