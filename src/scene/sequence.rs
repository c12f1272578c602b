//! Scenes whose files are numbered by frame.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::bare::{self, BareScene};
use super::load::{self, Grids, ShotSource, StaticScene, Text};
use super::outline::{self, Named};
use super::{LoadOptions, Scene};
use crate::error::{Error, Result};
use crate::medium::{Emission, Medium};
use crate::sequence::{FrameTime, Pattern};
use crate::vdb::Grid;

/// A scene file that names sequences of files, a sequence of bare VDB files, or a shot (USD). What does not
/// change from frame to frame is loaded once. A frame depends on its own number and the files that
/// are there, not on the frames that were loaded before it.
#[derive(Debug)]
pub struct Sequence {
    path: PathBuf,
    options: LoadOptions,
    text: Text,
    /// The shot whose frames they are; the text is then that of its first frame.
    shot: Option<ShotSource>,
    patterns: Vec<Pattern>,
    /// Those among them of grids, of which a time between two frames needs both.
    of_grids: Vec<Pattern>,
    /// Camera, surfaces and lights, where their files are not numbered.
    static_scene: Option<StaticScene>,
    /// The frame whose picture is metered for all of them.
    metered: Option<i64>,
}

impl Sequence {
    /// Opens a scene file that names sequences of files, or VDB files by a pattern of their names.
    /// Bare files are framed, lit and made as thick as suits the largest of all that are there.
    ///
    /// # Errors
    /// Where the file cannot be read or used, a key is wrong, or nothing in it is a sequence.
    pub fn open(path: &Path, options: &LoadOptions) -> Result<Self> {
        let options = options.clone();
        let is_bare = load::bare_sequence(path).is_some() || load::is_vdb(path)?;
        if let Some(shot) =
            (!is_bare).then(|| ShotSource::open(path, &options)).transpose()?.flatten()
        {
            return Self::of_shot(path, options, shot);
        }
        let (text, metered) = match load::bare_sequence(path) {
            Some(pattern) => {
                let (made, frame) = largest(path, &pattern, &options)?;
                (Text::Bare(Arc::new(made)), Some(frame))
            }
            None if load::is_vdb(path)? => return Err(nothing_numbered(path)),
            None => (Text::open(path, &options, &mut Grids::default())?, None),
        };
        let file = text.read(path, &options, Some(0.into()))?;
        let Named { patterns, of_grids, by_static_scene } = outline::sequences(path, text.as_str());
        if patterns.is_empty() {
            return Err(nothing_numbered(path));
        }
        let static_scene =
            if by_static_scene { None } else { Some(StaticScene::build(&text, &file, &options)?) };
        let path = path.to_path_buf();
        let mut sequence =
            Self { path, options, text, shot: None, patterns, of_grids, static_scene, metered };
        sequence.metered = metered.or_else(|| sequence.numbers().first().copied());
        Ok(sequence)
    }

    /// The frames of `shot`, which is, or is named by, the file `path`.
    fn of_shot(path: &Path, options: LoadOptions, shot: ShotSource) -> Result<Self> {
        let Named { patterns, of_grids, .. } = outline::sequences(path, shot.own());
        let first = shot.shot().frames().first().copied();
        let text = Text::from_shot(shot.text(first.map(FrameTime::from))?);
        let (shot, path) = (Some(shot), path.to_path_buf());
        let (static_scene, metered) = (None, None);
        let mut sequence =
            Self { path, options, text, shot, patterns, of_grids, static_scene, metered };
        sequence.metered = sequence.numbers().first().copied();
        Ok(sequence)
    }

    /// The frame by which the exposure of all is chosen where none is given: of bare files the
    /// largest, else the first that is there.
    pub fn metered_frame(&self) -> Option<i64> {
        self.metered
    }

    /// The files of the frame at `time`, and between two frames the grids of the next one, whether or not they are there.
    pub fn files(&self, time: FrameTime) -> Vec<PathBuf> {
        let volumes = |frame| self.shot.iter().flat_map(move |of| of.shot().volume_files(frame));
        let named = |patterns: &[Pattern], frame| {
            patterns.iter().map(|pattern| pattern.existing(frame)).collect::<Vec<_>>()
        };
        let frame = time.frame();
        let mut files = named(&self.patterns, frame);
        files.extend(volumes(frame));
        if !time.is_whole() {
            files.extend(named(&self.of_grids, frame + 1));
            files.extend(volumes(frame + 1));
        }
        files
    }

    /// The first file for `time` that is not there.
    pub fn missing(&self, time: FrameTime) -> Option<PathBuf> {
        self.files(time).into_iter().find(|path| !path.is_file())
    }

    /// The frames all of whose files are there, from the lowest.
    pub fn numbers(&self) -> Vec<i64> {
        let first = self.patterns.first();
        let of_shot = || self.shot.as_ref().map(|source| source.shot().frames());
        let mut numbers = first.map(Pattern::numbers).or_else(of_shot).unwrap_or_default();
        numbers.retain(|frame| self.missing((*frame).into()).is_none());
        numbers
    }

    /// Loads what is there at `time`.
    ///
    /// # Errors
    /// Where a file of it is missing or cannot be used. What all frames share was checked on
    /// opening, unless surfaces or lights have numbered files.
    pub fn load(&self, time: FrameTime) -> Result<Scene> {
        let mut grids = Grids::within(self.options.memory);
        let of_shot = self.shot.as_ref().map(|source| source.text(Some(time))).transpose()?;
        let of_shot = of_shot.map(Text::from_shot);
        let text = of_shot.as_ref().unwrap_or(&self.text);
        let mut file = text.read(&self.path, &self.options, Some(time))?;
        if matches!(text, Text::Bare(_)) {
            bare::leave_out_missing(&mut file, &mut grids)?;
        }
        let is_shared = time.is_whole() || !file.camera_or_surfaces_move();
        let static_scene = match self.static_scene.as_ref().filter(|_| is_shared) {
            Some(known) => known.clone(),
            None => StaticScene::build(text, &file, &self.options)?,
        };
        load::build(&self.path, text, &file, static_scene, &mut grids, &self.options)
            .map(|(scene, _)| scene)
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

fn nothing_numbered(path: &Path) -> Error {
    Error::Usage(format!(
        "{}: nothing in it is a sequence, all frames would be the same; put #### or %04d in the \
         name of a VDB file, or leave the frames out",
        path.display()
    ))
}

/// The scene for a sequence of bare VDB files, as suits the largest that can be used, and the number of
/// that.
fn largest(path: &Path, pattern: &Pattern, options: &LoadOptions) -> Result<(BareScene, i64)> {
    let size = |file: &Path| std::fs::metadata(file).map_or(0, |file| file.len());
    let numbers = pattern.numbers().into_iter();
    let mut files: Vec<_> = numbers.map(|n| (n, pattern.existing(n))).collect();
    files.sort_by_key(|(_, file)| std::cmp::Reverse(size(file)));
    let none = Error::file(path, "none of its files is there; give the path of a sequence");
    let mut first = None;
    for (number, file) in files {
        let mut grids = Grids::within(options.memory);
        match bare::make(&file, Some(path), options, &mut grids) {
            Ok(made) => return Ok((made, number)),
            Err(problem) => first = first.or(Some(problem)),
        }
    }
    Err(first.unwrap_or(none))
}
