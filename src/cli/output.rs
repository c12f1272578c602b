//! The files of a picture: checked before any work is done, and written whole or not at all.

use std::io::Write;
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};
use crate::file::{self, PendingFile};
use crate::image::{Film, Picture, View, exr_bytes, png_bytes, png_path_beside};
use crate::render::Rendered;

/// The files of one picture.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Output {
    /// All layers.
    pub(super) exr: PathBuf,
    /// The view beside it.
    pub(super) png: PathBuf,
    /// The deep picture beside it, where one is written.
    pub(super) deep: Option<PathBuf>,
}

impl Output {
    /// The EXR `exr` and the PNG beside it.
    pub(super) fn at(exr: PathBuf) -> Self {
        let png = png_path_beside(&exr);
        Self { exr, png, deep: None }
    }

    /// With the deep picture beside them, where `deep` is set.
    #[must_use]
    pub(super) fn with_deep(self, deep: bool) -> Self {
        let beside = deep.then(|| self.exr.with_extension("deep.exr"));
        Self { deep: beside, ..self }
    }

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
        let output = Self::at(path.to_path_buf());
        for target in [&output.exr, &output.png] {
            drop(PendingFile::new(target)?);
        }
        Ok(output)
    }

    /// Writes the EXR with `attributes`, its colours as `half` floats where that is set, and the PNG by `view`, and then
    /// gives both their names, the EXR last: once that is there, the picture is.
    ///
    /// # Errors
    /// Where either cannot be written; then neither is.
    pub(super) fn write(
        &self,
        view: &View,
        rendered: &Rendered,
        half: bool,
        attributes: &[(String, String)],
    ) -> Result<()> {
        let (png, exr) = rayon::join(
            || shown(&self.png, &rendered.film, view),
            || layers(&self.exr, &rendered.film, half, attributes),
        );
        self.write_bytes(&exr?, Some(&png?))
    }

    /// Writes the content of both files, or of the EXR alone, and then gives them their names, the EXR last.
    ///
    /// # Errors
    /// As [`write`](Self::write).
    pub(super) fn write_bytes(&self, exr: &[u8], png: Option<&[u8]>) -> Result<()> {
        let exr = file::pending(&self.exr, |out| out.write_all(exr))?;
        let png = png.map(|png| file::pending(&self.png, |out| out.write_all(png))).transpose()?;
        png.map_or(Ok(()), PendingFile::finish)?;
        exr.finish()
    }

    /// The names of the files.
    pub(super) fn names(&self) -> Vec<String> {
        let all = [&self.exr, &self.png].into_iter().chain(&self.deep);
        all.map(|path| path.display().to_string()).collect()
    }
}

/// The content of the PNG `path` of `film` in this `view`.
///
/// # Errors
/// Where it cannot be encoded.
pub(super) fn shown(path: &Path, film: &Film, view: &View) -> Result<Vec<u8>> {
    png_bytes(path, &Picture::developed(&film.image(), view))
}

/// The content of the EXR `path` of `film`, with colours as `half` floats where that is set.
///
/// # Errors
/// Where a value is not finite.
pub(super) fn layers(
    path: &Path,
    film: &Film,
    half: bool,
    attributes: &[(String, String)],
) -> Result<Vec<u8>> {
    let attributes: Vec<(&str, String)> =
        attributes.iter().map(|(name, value)| (name.as_str(), value.clone())).collect();
    exr_bytes(path, film, half, &attributes)
}
