//! Scenes whose files are numbered by frame.

use std::path::{Path, PathBuf};

use super::bare::{self, Look};
use super::document::{self, Named};
use super::load::{self, Stills};
use super::{LoadOptions, Scene, file};
use crate::error::{Error, Result};
use crate::medium::{Emission, Medium};
use crate::sequence::Pattern;
use crate::vdb::Grid;

/// A scene file that names sequences of files, or a sequence of bare VDB files. What does not
/// change from frame to frame is loaded once. A frame depends on its own number and the files that
/// are there, not on the frames that were loaded before it.
#[derive(Debug)]
pub struct Sequence {
    path: PathBuf,
    options: LoadOptions,
    source: Source,
}

#[derive(Debug)]
enum Source {
    /// The text of a scene file; surfaces and lights, where their files are not numbered.
    Scene { text: String, patterns: Vec<Pattern>, stills: Option<Stills> },
    /// VDB files, all seen and lit alike.
    Volumes { pattern: Pattern, look: Look },
}

impl Sequence {
    /// Opens a scene file that names sequences of files, or VDB files by a pattern of their names.
    /// Bare files are framed, lit and made as thick as suits the largest of all that are there.
    ///
    /// # Errors
    /// Where the file cannot be read or used, a key is wrong, or nothing in it is a sequence.
    pub fn open(path: &Path, options: &LoadOptions) -> Result<Self> {
        let source = match load::volumes(path) {
            Some(pattern) => {
                let look = largest(path, &pattern, options)?;
                Source::Volumes { pattern, look }
            }
            None => scene(path, options)?,
        };
        Ok(Self { path: path.to_path_buf(), options: *options, source })
    }

    /// The files of `frame`, whether or not they are there.
    pub fn files(&self, frame: i64) -> Vec<PathBuf> {
        self.patterns().iter().map(|pattern| pattern.existing(frame)).collect()
    }

    /// The first file of `frame` that is not there.
    pub fn missing(&self, frame: i64) -> Option<PathBuf> {
        self.files(frame).into_iter().find(|path| !path.is_file())
    }

    /// The frames all of whose files are there, from the lowest.
    pub fn numbers(&self) -> Vec<i64> {
        let first = self.patterns().first();
        let mut numbers = first.map(Pattern::numbers).unwrap_or_default();
        numbers.retain(|frame| self.missing(*frame).is_none());
        numbers
    }

    /// Loads `frame`.
    ///
    /// # Errors
    /// Where a file of it is missing or cannot be used. What all frames share was checked on
    /// opening, unless surfaces or lights have numbered files.
    pub fn load(&self, frame: i64) -> Result<Scene> {
        match &self.source {
            Source::Volumes { pattern, look } => {
                bare::load_like(&pattern.existing(frame), look, &self.options)
            }
            Source::Scene { text, stills, .. } => {
                let file = file::parse_at(&self.path, text, Some(frame))?;
                let stills = match stills {
                    Some(stills) => stills.clone(),
                    None => Stills::build(text, &file, &self.options)?,
                };
                load::build(&self.path, text, &file, stills, &self.options)
            }
        }
    }

    fn patterns(&self) -> &[Pattern] {
        match &self.source {
            Source::Scene { patterns, .. } => patterns,
            Source::Volumes { pattern, .. } => std::slice::from_ref(pattern),
        }
    }
}

impl Scene {
    /// Whether it has media of grids and there is nothing in any of them.
    pub fn is_clear(&self) -> bool {
        let mut media = self.media.iter().filter(|medium| medium.density.is_voxel()).peekable();
        media.peek().is_some() && media.all(is_clear)
    }
}

fn is_clear(medium: &Medium) -> bool {
    let glows = match &medium.emission {
        Some(Emission::Grid { grid, .. }) => grid.max_inside() > 0.0,
        Some(Emission::Ramped(ramped)) => ramped.peak() > 0.0,
        Some(Emission::Density(_) | Emission::Blackbody { .. }) | None => false,
    };
    let left_out = medium.density.grid().map_or(0, Grid::unwanted);
    medium.density.maximum() <= 0.0 && left_out == 0 && !glows
}

/// The scene file `path` with what its frames share.
fn scene(path: &Path, options: &LoadOptions) -> Result<Source> {
    let nothing_numbered = || {
        Error::Usage(format!(
            "{}: nothing in it is a sequence, all frames would be the same; put #### or %04d in \
             the name of a VDB file, or leave the frames out",
            path.display()
        ))
    };
    if load::is_vdb(path)? {
        return Err(nothing_numbered());
    }
    load::refuse_level_set(options)?;
    let text = file::read(path)?;
    let file = file::parse_at(path, &text, Some(0))?;
    let Named { patterns, by_stills } = document::sequences(path, &text);
    if patterns.is_empty() {
        return Err(nothing_numbered());
    }
    let stills = if by_stills { None } else { Some(Stills::build(&text, &file, options)?) };
    Ok(Source::Scene { text, patterns, stills })
}

/// How to look at a sequence of bare VDB files: as suits the largest that can be used.
fn largest(path: &Path, pattern: &Pattern, options: &LoadOptions) -> Result<Look> {
    let size = |file: &PathBuf| std::fs::metadata(file).map_or(0, |file| file.len());
    let mut files: Vec<_> = pattern.numbers().into_iter().map(|n| pattern.existing(n)).collect();
    files.sort_by_key(|file| std::cmp::Reverse(size(file)));
    let none = Error::file(path, "none of its files is there; give the path of a sequence");
    let mut first = None;
    for file in files {
        match Look::at(&file, options) {
            Ok(look) => return Ok(look),
            Err(problem) => first = first.or(Some(problem)),
        }
    }
    Err(first.unwrap_or(none))
}
