//! Scenes that are shots (USD), or add to one.

use std::path::{Path, PathBuf};

use crate::error::{Error, Result};
use crate::scene::LoadOptions;
use crate::scene::file;
use crate::scene::reader::{Document, Setting};
use crate::scene::usd::{Shot, ShotScene, is_usd};
use crate::sequence::FrameTime;

/// The table that opens a shutter.
const MOTION: &str = "motion";

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
    /// Whether a shutter is open, during which it moves.
    moves: bool,
}

impl ShotSource {
    /// The shot `path`, or the one that the scene file `path`, which is no VDB file, names; nothing where it
    /// names none.
    ///
    /// # Errors
    /// Where a file cannot be read or used.
    pub(in crate::scene) fn open(path: &Path, options: &LoadOptions) -> Result<Option<Self>> {
        if is_usd(path) {
            return Self::of_usd(path, options).map(Some);
        }
        Self::of_text(path, &file::read(path)?, options)
    }

    /// The shot of the USD file `path`.
    ///
    /// # Errors
    /// Where it cannot be read or used.
    pub(super) fn of_usd(path: &Path, options: &LoadOptions) -> Result<Self> {
        options.look.refuse_in_scene()?;
        let shot = Shot::open(path, options.camera.as_deref())?;
        Ok(Self { shot, path: path.into(), own: String::new(), moves: opens_shutter("", options) })
    }

    /// The shot that the `text` of the scene file `path` names; nothing where it names none.
    ///
    /// # Errors
    /// Where the shot cannot be read or used.
    pub(super) fn of_text(path: &Path, text: &str, options: &LoadOptions) -> Result<Option<Self>> {
        let camera = options.camera.as_deref();
        let Some(section) = Self::named(path, text)? else {
            if camera.is_some() {
                return Err(Error::Usage(
                    "--camera is for shots (USD); a scene has its own [camera]".into(),
                ));
            }
            return Ok(None);
        };
        options.look.refuse_in_scene()?;
        let file = section.file.path;
        let shot = Shot::open(&file, camera.or(section.camera.as_deref()));
        let shot = shot.map_err(|problem| section.file.at.error(problem))?;
        let moves = opens_shutter(text, options);
        Ok(Some(Self { shot, path: file, own: text.into(), moves }))
    }

    /// What the `text` of the scene file `path` says of a shot.
    fn named(path: &Path, text: &str) -> Result<Option<file::ShotSection>> {
        let section = Document::new(path, text, &[]).read(file::shot);
        // What is wrong with a text that names no shot is told where it is read.
        let names_one = || text.parse::<toml::Table>().is_ok_and(|t| t.contains_key("usd"));
        section.or_else(|problem| if names_one() { Err(problem) } else { Ok(None) })
    }

    /// The shot.
    pub(in crate::scene) const fn shot(&self) -> &Shot {
        &self.shot
    }

    /// The scene's own text, without that of the shot.
    pub(in crate::scene) fn own(&self) -> &str {
        &self.own
    }

    /// The text at the time `frame`, or at the first frame.
    ///
    /// # Errors
    /// Where the shot cannot be used.
    pub(in crate::scene) fn text(&self, frame: Option<FrameTime>) -> Result<WithShot> {
        let is_between = frame.is_some_and(|time| !time.is_whole());
        let frame = frame.map(FrameTime::frame);
        let mut made = self.shot.scene(frame)?;
        if self.moves || is_between {
            let next = frame.unwrap_or_else(|| self.shot.first_frame()) + 1;
            let later = self.shot.scene(Some(next))?;
            made.move_toward(&later);
            if is_between {
                made.turn_into(&later);
            }
        }
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

/// Whether the `text` of a scene or `options` have the table `[motion]`.
fn opens_shutter(text: &str, options: &LoadOptions) -> bool {
    let is_motion = |setting: &Setting| setting.table() == MOTION;
    options.settings.iter().any(is_motion)
        || text.parse::<toml::Table>().is_ok_and(|table| table.contains_key(MOTION))
}
