//! Any bytes as an OpenVDB file: opened, and every grid read.

#![no_main]

use std::sync::LazyLock;

use fogbow::vdb::{ReadAs, VdbFile};
use libfuzzer_sys::fuzz_target;
use tempfile::TempDir;

static FOLDER: LazyLock<TempDir> = LazyLock::new(|| tempfile::tempdir().expect("a folder"));

fuzz_target!(|data: &[u8]| {
    let path = FOLDER.path().join("fuzzed.vdb");
    std::fs::write(&path, data).expect("written");
    let Ok(file) = VdbFile::open(&path) else { return };
    for index in 0..file.grids().len() {
        if file.grids()[index].is_vector() {
            drop(file.read_vector(index));
        } else {
            drop(file.read_scalar(index, ReadAs::LevelSetAsFog));
        }
    }
});
