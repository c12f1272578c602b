//! The text of a scene, and where something in it stands.

use std::ops::Range;
use std::path::Path;

use super::{Origin, Place};

/// The text of a scene, and what is needed to say where something in it stands.
#[derive(Debug)]
pub(super) struct Source<'a> {
    /// The file as the user named it.
    pub(super) path: &'a Path,
    /// The scene's text, followed by the values of all settings.
    pub(super) text: String,
    /// Bytes of the scene's own text.
    length: usize,
    /// Where the value of each setting stands in the text.
    settings: Vec<Placed<'a>>,
    /// The frame whose files are meant where a path has a place for its number.
    pub(super) frame: Option<i64>,
    /// Whether the text was made for a VDB file alone.
    pub(super) bare: bool,
}

/// The value of a setting in the text.
#[derive(Debug)]
pub(super) struct Placed<'a> {
    /// Path of its key, with dots.
    pub(super) key: &'a str,
    /// How the user gave it.
    said: &'a str,
    /// Its bytes.
    pub(super) range: Range<usize>,
}

impl<'a> Source<'a> {
    /// The scene `text` of the file `path`.
    pub(super) fn new(path: &'a Path, text: &str) -> Self {
        let (text, length) = (text.to_owned(), text.len());
        Self { path, text, length, settings: Vec::new(), frame: None, bare: false }
    }

    /// Puts the value of the setting of `key` after the text; the user gave it as `said`.
    pub(super) fn append(&mut self, key: &'a str, value: &str, said: &'a str) {
        self.text.push('\n');
        let start = self.text.len();
        self.text.push_str(value);
        self.settings.push(Placed { key, said, range: start..self.text.len() });
    }

    /// The scene's own text.
    pub(super) fn own(&self) -> &str {
        &self.text[..self.length]
    }

    /// The values of settings, in the order in which they were given.
    pub(super) fn settings(&self) -> &[Placed<'a>] {
        &self.settings
    }

    /// The place of byte `offset`.
    pub(super) fn place(&self, offset: usize, key: impl Into<String>) -> Place {
        let key = key.into();
        let holds = |setting: &&Placed<'_>| {
            let Range { start, end } = setting.range;
            offset > self.length && (start..=end).contains(&offset)
        };
        if let Some(setting) = self.settings.iter().find(holds) {
            return Place { key, origin: Origin::Setting { said: setting.said.to_owned() } };
        }
        let path = self.path.to_path_buf();
        if self.bare {
            return Place { key, origin: Origin::Bare { path } };
        }
        let before = self.text.get(..offset).unwrap_or(&self.text);
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        let (line, column) =
            (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1);
        Place { key, origin: Origin::File { path, line, column } }
    }
}
