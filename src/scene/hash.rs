//! What a scene was made of, as a number.

use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

/// The files a scene is made of, in the order of their first use.
#[derive(Debug, Default)]
pub(super) struct Sources {
    files: Vec<PathBuf>,
}

impl Sources {
    /// Adds `path`, once.
    pub(super) fn add(&mut self, path: &Path) {
        if !self.files.iter().any(|known| known == path) {
            self.files.push(path.to_path_buf());
        }
    }

    /// BLAKE3 of `text` and of the content of each file, wherever the files lie.
    pub(super) fn hash(&self, text: &str) -> Result<String> {
        let mut all = blake3::Hasher::new();
        all.update(blake3::hash(text.as_bytes()).as_bytes());
        for path in &self.files {
            let mut content = blake3::Hasher::new();
            std::fs::File::open(path)
                .and_then(|file| content.update_reader(file).map(drop))
                .map_err(|e| Error::file(path, format!("cannot be read: {e}")))?;
            all.update(content.finalize().as_bytes());
        }
        Ok(all.finalize().to_hex().to_string())
    }
}
