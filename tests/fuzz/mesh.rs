//! Any bytes as a mesh: OBJ or PLY by the first byte.

#![no_main]

use std::sync::LazyLock;

use glam::DAffine3;
use libfuzzer_sys::fuzz_target;
use tempfile::TempDir;

static FOLDER: LazyLock<TempDir> = LazyLock::new(|| tempfile::tempdir().expect("a folder"));

fuzz_target!(|data: &[u8]| {
    let Some((kind, data)) = data.split_first() else { return };
    let extension = ["obj", "ply"][usize::from(kind % 2)];
    let path = FOLDER.path().join("fuzzed").with_extension(extension);
    std::fs::write(&path, data).expect("written");
    if let Err(error) = fogbow::shape::load_mesh(&path, &DAffine3::IDENTITY) {
        assert!(!error.to_string().contains('\n'));
    }
});
