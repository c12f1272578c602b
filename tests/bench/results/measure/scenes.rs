//! Scenes that measurements take.

use std::path::{Path, PathBuf};

use fogbow::scene::{LoadOptions, Scene};

use crate::pages::Result;

/// Titles and names in `volumes/` of the four scenes after the paper's.
pub const PAPER: [(&str, &str); 4] =
    [("Balls A", "balls_a"), ("Balls B", "balls_b"), ("Lucy", "lucy"), ("Road", "road")];

/// Files beside the repository that are rendered bare, with their titles.
pub const BARE: [(&str, &str); 3] = [
    ("smoke_v222.vdb, bare", "smoke/smoke_v222.vdb"),
    ("singlecloud.vdb, bare", "cloud/singlecloud.vdb"),
    ("fluid_data_0010.vdb, bare", "gas_sequence/fluid_data_0010.vdb"),
];

/// A scene of `volumes/`.
pub fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("volumes/{name}.toml"))
}

/// A file of `../shared/volumes`, where it is there.
pub fn shared(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/volumes").join(name);
    path.is_file().then_some(path)
}

/// The film's size with `side` pixels along its longer side.
pub fn scaled(path: &Path, side: u32) -> Result<[u32; 2]> {
    let [width, height] = Scene::load(path, &LoadOptions::default())?.film.size;
    let longer = width.max(height);
    Ok([width, height].map(|own| (own * side / longer).max(1)))
}
