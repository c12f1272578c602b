//! The text of a scene, and places in it.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::{Origin, Place};
use crate::sequence::FrameTime;
use crate::shape::MeshData;

/// The text of a scene, with what turns a byte offset into a [`Place`].
#[derive(Debug)]
pub(super) struct Source<'a> {
    /// The file as the user named it.
    pub(super) path: &'a Path,
    /// The scene's text, followed by the values of all settings.
    pub(super) text: String,
    /// Bytes of the scene's own text.
    length: usize,
    /// Where the value of each setting stands in the text.
    settings: Vec<SettingSpan<'a>>,
    /// The time whose frame's number is put into the paths of a sequence.
    pub(super) frame: Option<FrameTime>,
    /// Whether the text was written for a bare VDB file.
    pub(super) bare: bool,
    /// The part that was written for a USD file.
    pub(super) shot: Option<ShotText<'a>>,
}

/// The part of a scene's text that was written for a USD file. Its tables have titles that begin with a prim.
#[derive(Debug, Clone, Copy)]
pub(in crate::scene) struct ShotText<'a> {
    /// The USD file.
    pub(in crate::scene) path: &'a Path,
    /// Where it begins.
    pub(in crate::scene) start: usize,
    /// Where the files are that it names.
    pub(in crate::scene) assets: &'a BTreeMap<String, PathBuf>,
    /// Those that stand in their places one frame later, between two frames.
    pub(in crate::scene) next_assets: &'a BTreeMap<String, PathBuf>,
    /// The meshes in memory that it names.
    pub(in crate::scene) meshes: &'a BTreeMap<String, Arc<MeshData>>,
}

impl ShotText<'_> {
    /// Where the file `name` is, if the shot has it.
    pub(super) fn file(&self, name: &str) -> Option<PathBuf> {
        match self.assets.get(name) {
            Some(path) => Some(path.clone()),
            None => self.meshes.contains_key(name).then(|| name.into()),
        }
    }
}

/// The value of a setting in the text.
#[derive(Debug)]
pub(super) struct SettingSpan<'a> {
    /// Path of its key, with dots.
    pub(super) key: &'a str,
    /// How the user gave it.
    given: &'a str,
    /// Its bytes.
    pub(super) range: Range<usize>,
}

impl<'a> Source<'a> {
    /// The scene `text` of the file `path`.
    pub(super) fn new(path: &'a Path, text: &str) -> Self {
        let (text, length) = (text.to_owned(), text.len());
        Self { path, text, length, settings: Vec::new(), frame: None, bare: false, shot: None }
    }

    /// Appends the value of the setting of `key`, which the user gave as `given`.
    pub(super) fn append(&mut self, key: &'a str, value: &str, given: &'a str) {
        self.text.push('\n');
        let start = self.text.len();
        self.text.push_str(value);
        self.settings.push(SettingSpan { key, given, range: start..self.text.len() });
    }

    /// The scene's own text.
    pub(super) fn own(&self) -> &str {
        &self.text[..self.length]
    }

    /// The values of settings, in the order in which they were given.
    pub(super) fn settings(&self) -> &[SettingSpan<'a>] {
        &self.settings
    }

    /// The place of byte `offset`.
    pub(super) fn place(&self, offset: usize, key: impl Into<String>) -> Place {
        let key = key.into();
        let holds = |setting: &&SettingSpan<'_>| {
            let Range { start, end } = setting.range;
            offset > self.length && (start..=end).contains(&offset)
        };
        if let Some(setting) = self.settings.iter().find(holds) {
            return Place { key, origin: Origin::Setting { given: setting.given.to_owned() } };
        }
        let path = self.path.to_path_buf();
        if self.bare {
            return Place { key, origin: Origin::Bare { path } };
        }
        let before = self.text.get(..offset).unwrap_or(&self.text);
        if let Some(shot) = self.shot.filter(|shot| offset >= shot.start) {
            let title = before.lines().rev().find_map(|line| line.strip_prefix("# /"));
            let prim = title.and_then(|title| title.split_once(": "));
            let prim = prim.map_or(String::new(), |(prim, _)| format!("/{prim}"));
            return Place { key, origin: Origin::Shot { path: shot.path.into(), prim } };
        }
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        let (line, column) =
            (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1);
        Place { key, origin: Origin::File { path, line, column } }
    }
}
