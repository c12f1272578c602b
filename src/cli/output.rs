//! Where pictures go, checked before any work is done.

use std::path::{Path, PathBuf};

use crate::error::{Error, Result};
use crate::file::PendingFile;
use crate::image::png_path_beside;

/// The files of one picture.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Output {
    /// All layers.
    pub(super) exr: PathBuf,
    /// The view beside it.
    pub(super) png: PathBuf,
}

impl Output {
    /// The files for `-o path`, both writable.
    ///
    /// # Errors
    /// Where the path does not end in `.exr`, or a file cannot be made there.
    pub(super) fn check(path: &Path) -> Result<Self> {
        let ends_right = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr"));
        if !ends_right {
            return Err(Error::Usage(format!(
                "-o {}: give a path that ends in .exr; the PNG is written beside it",
                path.display()
            )));
        }
        let output = Self { exr: path.to_path_buf(), png: png_path_beside(path) };
        for target in [&output.exr, &output.png] {
            drop(PendingFile::new(target)?);
        }
        Ok(output)
    }

    /// The names of the files.
    pub(super) fn names(&self) -> [String; 2] {
        [&self.exr, &self.png].map(|path| path.display().to_string())
    }
}
