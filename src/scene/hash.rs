//! What a scene was made of, as a number.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use blake3::Hash;

use crate::error::{Error, Result};
use crate::shape::MeshData;

/// The files a scene is made of, in the order of their first use, each hashed once.
#[derive(Debug, Clone, Default)]
pub(super) struct Sources {
    files: Vec<PathBuf>,
    /// Hashes of their content and of that of files of other scenes.
    contents: BTreeMap<PathBuf, Hash>,
}

impl Sources {
    /// Takes over what is known of the content of files, where it is not known here.
    pub(super) fn learn(&mut self, other: &Self) {
        for (path, hash) in &other.contents {
            self.contents.entry(path.clone()).or_insert(*hash);
        }
    }

    /// Adds `path`, once.
    pub(super) fn add(&mut self, path: &Path) {
        if !self.files.iter().any(|known| known == path) {
            self.files.push(path.to_path_buf());
        }
    }

    /// Adds the content of `mesh`, which is in no file, once.
    pub(super) fn add_mesh(&mut self, name: &Path, mesh: &MeshData) {
        if self.files.iter().any(|known| known == name) {
            return;
        }
        let mut content = blake3::Hasher::new();
        let mut add = |bytes: &[u8]| {
            content.update(bytes);
        };
        // What parts are called changes no light.
        let MeshData { positions, triangles, normals, uvs, slots, parts: _ } = mesh;
        positions.iter().for_each(|p| p.to_array().iter().for_each(|x| add(&x.to_le_bytes())));
        normals.iter().for_each(|n| n.to_array().iter().for_each(|x| add(&x.to_le_bytes())));
        uvs.iter().for_each(|uv| uv.to_array().iter().for_each(|x| add(&x.to_le_bytes())));
        triangles.iter().flatten().chain(slots).for_each(|i| add(&i.to_le_bytes()));
        self.files.push(name.to_path_buf());
        self.contents.insert(name.to_path_buf(), content.finalize());
    }

    /// BLAKE3 of `text` and of the content of each file, wherever the files lie.
    pub(super) fn hash(&mut self, text: &str) -> Result<String> {
        let mut all = blake3::Hasher::new();
        all.update(blake3::hash(text.as_bytes()).as_bytes());
        for path in &self.files {
            let content = match self.contents.get(path) {
                Some(known) => *known,
                None => *self.contents.entry(path.clone()).or_insert(content(path)?),
            };
            all.update(content.as_bytes());
        }
        Ok(all.finalize().to_hex().to_string())
    }
}

fn content(path: &Path) -> Result<Hash> {
    let mut content = blake3::Hasher::new();
    std::fs::File::open(path)
        .and_then(|file| content.update_reader(file).map(drop))
        .map_err(|e| Error::file(path, format!("cannot be read: {e}")))?;
    Ok(content.finalize())
}
