//! Scenes that are shots (USD), or add to one.

use std::path::{Path, PathBuf};

use crate::error::{Error, Result};
use crate::scene::LoadOptions;
use crate::scene::file;
use crate::scene::reader::Document;
use crate::scene::usd::{Shot, ShotScene, is_usd};

/// The text of a scene that is, or adds to, a shot.
#[derive(Debug)]
pub(in crate::scene) struct WithShot {
    /// The USD file.
    pub(super) path: PathBuf,
    /// The scene's own text, then that of the shot.
    pub(super) text: String,
    /// Where the latter begins.
    pub(super) start: usize,
    /// The shot.
    pub(super) made: ShotScene,
}

/// A USD file with the scene file that adds to it, where there is one.
#[derive(Debug)]
pub(in crate::scene) struct ShotSource {
    shot: Shot,
    path: PathBuf,
    /// The text of the scene file.
    own: String,
}

impl ShotSource {
    /// The shot `path`, or the one that the scene file `path`, which is no VDB file, names; nothing where it
    /// names none.
    ///
    /// # Errors
    /// Where a file cannot be read or used.
    pub(in crate::scene) fn open(path: &Path, options: &LoadOptions) -> Result<Option<Self>> {
        let camera = options.camera.as_deref();
        if is_usd(path) {
            options.look.refuse_in_scene()?;
            let shot = Shot::open(path, camera)?;
            return Ok(Some(Self { shot, path: path.into(), own: String::new() }));
        }
        let named = Self::named(path)?;
        if named.is_none() && camera.is_some() {
            return Err(Error::Usage(
                "--camera is for shots (USD); a scene has its own [camera]".into(),
            ));
        }
        let Some((own, section)) = named else { return Ok(None) };
        options.look.refuse_in_scene()?;
        let file = section.file.path;
        let shot = Shot::open(&file, camera.or(section.camera.as_deref()));
        let shot = shot.map_err(|problem| section.file.at.error(problem))?;
        Ok(Some(Self { shot, path: file, own }))
    }

    /// The text of the scene file `path` and the shot that it names.
    fn named(path: &Path) -> Result<Option<(String, file::ShotSection)>> {
        let text = file::read(path)?;
        let section = Document::new(path, &text, &[]).read(file::shot);
        // What is wrong with a text that names no shot is told where it is read.
        let names_one = || text.parse::<toml::Table>().is_ok_and(|t| t.contains_key("usd"));
        match section {
            Ok(section) => Ok(section.map(|section| (text, section))),
            Err(problem) if names_one() => Err(problem),
            Err(_) => Ok(None),
        }
    }

    /// The shot.
    pub(in crate::scene) const fn shot(&self) -> &Shot {
        &self.shot
    }

    /// The scene's own text, without that of the shot.
    pub(in crate::scene) fn own(&self) -> &str {
        &self.own
    }

    /// The text of `frame`, or of the first.
    ///
    /// # Errors
    /// Where the shot cannot be used.
    pub(in crate::scene) fn text(&self, frame: Option<i64>) -> Result<WithShot> {
        let mut made = self.shot.scene(frame)?;
        let mut text = self.own.clone();
        if !self.own.is_empty() {
            made.draft.leave_out(&self.own.parse().unwrap_or_default());
            text.push('\n');
        }
        let start = text.len();
        text += &made.draft.text();
        Ok(WithShot { path: self.path.clone(), text, start, made })
    }
}
