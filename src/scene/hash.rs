//! What a scene was made of, as a number.

use std::path::{Path, PathBuf};

use blake3::Hash;

use crate::error::{Error, Result};

/// The files a scene is made of, in the order of their first use, each hashed once.
#[derive(Debug, Clone, Default)]
pub(super) struct Sources {
    files: Vec<(PathBuf, Option<Hash>)>,
}

impl Sources {
    /// Adds `path`, once.
    pub(super) fn add(&mut self, path: &Path) {
        if !self.files.iter().any(|(known, _)| known == path) {
            self.files.push((path.to_path_buf(), None));
        }
    }

    /// BLAKE3 of `text` and of the content of each file, wherever the files lie.
    pub(super) fn hash(&mut self, text: &str) -> Result<String> {
        let mut all = blake3::Hasher::new();
        all.update(blake3::hash(text.as_bytes()).as_bytes());
        for (path, known) in &mut self.files {
            let content = match *known {
                Some(content) => content,
                None => content(path)?,
            };
            *known = Some(content);
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
