//! A scene's text with the settings that stand over it.

use std::ops::Range;
use std::path::Path;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::section::Section;
use super::setting::Setting;
use super::value::Value;
use super::{Origin, Place, one_line};
use crate::error::Result;

/// The text of a scene, and what is needed to say where something in it stands.
#[derive(Debug)]
pub(in crate::scene) struct Document<'a> {
    /// The file as the user named it.
    pub(super) path: &'a Path,
    /// The scene's text, followed by the values of all settings.
    pub(super) text: String,
    /// Bytes of the scene's own text.
    length: usize,
    /// Where the value of each setting stands in the text.
    settings: Vec<(&'a Setting, Range<usize>)>,
    /// The frame whose files are meant where a path has a place for its number.
    pub(super) frame: Option<i64>,
    /// Whether the text was made for a VDB file alone.
    bare: bool,
}

impl<'a> Document<'a> {
    /// The scene `text` of the file `path`, with `settings` over it.
    pub(in crate::scene) fn new(path: &'a Path, text: &str, settings: &'a [Setting]) -> Self {
        let mut all = text.to_owned();
        let mut placed = Vec::new();
        for setting in settings {
            all.push('\n');
            let start = all.len();
            all.push_str(&setting.value);
            placed.push((setting, start..all.len()));
        }
        Self { path, text: all, length: text.len(), settings: placed, frame: None, bare: false }
    }

    /// The same, for the files of a frame.
    pub(in crate::scene) fn at_frame(self, frame: Option<i64>) -> Self {
        Self { frame, ..self }
    }

    /// The same, as a scene that was made for the VDB file it is named after.
    pub(in crate::scene) fn made_for_vdb(self) -> Self {
        Self { bare: true, ..self }
    }

    /// Parses the text, puts the settings in, and has `read` read the top table.
    ///
    /// # Errors
    /// Where text or a setting is no TOML, a setting's table is not there, or `read` fails.
    pub(in crate::scene) fn read<T>(
        &self,
        read: impl FnOnce(&Section<'_>) -> Result<T>,
    ) -> Result<T> {
        let own = &self.text[..self.length];
        let mut root = DeTable::parse(own).map_err(|e| {
            let offset = e.span().map_or(0, |span| span.start);
            self.place(offset, "TOML").error(one_line(e.message()))
        })?;
        for (setting, range) in &self.settings {
            let text = &self.text[range.clone()];
            let place = self.place(range.start, setting.path.clone());
            let value = DeValue::parse(text).map_err(|e| place.error(one_line(e.message())))?;
            let value = moved(value, range.start);
            put(root.get_mut(), &setting.path, value).map_err(|problem| place.error(problem))?;
        }
        read(&Section::root(self, &root))
    }

    /// The place of byte `offset`.
    pub(super) fn place(&self, offset: usize, key: impl Into<String>) -> Place {
        let key = key.into();
        if let Some((setting, _)) = self
            .settings
            .iter()
            .find(|(_, range)| offset > self.length && range.start <= offset && offset <= range.end)
        {
            return Place { key, origin: Origin::Setting { said: setting.said.clone() } };
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

/// `value` with everything in it `by` bytes further on.
fn moved(value: Spanned<DeValue<'_>>, by: usize) -> Spanned<DeValue<'_>> {
    let span = value.span().start + by..value.span().end + by;
    let inner = match value.into_inner() {
        DeValue::Array(items) => {
            DeValue::Array(items.into_iter().map(|item| moved(item, by)).collect())
        }
        DeValue::Table(table) => DeValue::Table(
            table
                .into_iter()
                .map(|(key, value)| {
                    let span = key.span().start + by..key.span().end + by;
                    (Spanned::new(span, key.into_inner()), moved(value, by))
                })
                .collect(),
        ),
        other => other,
    };
    Spanned::new(span, inner)
}

/// Puts `value` in the place of `path` below `table`, whose tables are made where they are missing.
fn put<'t>(table: &mut DeTable<'t>, path: &str, value: Spanned<DeValue<'t>>) -> Result<(), String> {
    let span = value.span();
    let Some((first, rest)) = path.split_once('.') else {
        match table.iter_mut().find(|(key, _)| key.get_ref() == path) {
            Some((_, old)) => *old = value,
            None => drop(table.insert(Spanned::new(span, path.to_owned().into()), value)),
        }
        return Ok(());
    };
    if !table.keys().any(|key| key.get_ref() == first) {
        if rest.split('.').next().is_some_and(|word| word.parse::<usize>().is_ok()) {
            return Err(format!("the scene has no [[{first}]]"));
        }
        let empty = Spanned::new(span.clone(), DeValue::Table(DeTable::new()));
        table.insert(Spanned::new(span, first.to_owned().into()), empty);
    }
    let below = table.iter_mut().find(|(key, _)| key.get_ref() == first).map(|(_, value)| value);
    match below.map(Spanned::get_mut) {
        Some(DeValue::Table(below)) => put(below, rest, value),
        Some(DeValue::Array(items)) => {
            let (number, rest) = rest.split_once('.').unwrap_or((rest, ""));
            let count = items.len();
            let right = || format!("the scene has {count} of {first}, counted from 0");
            let index: usize = number.parse().map_err(|_| right())?;
            let item = items.get_mut(index).ok_or_else(right)?;
            match item.get_mut() {
                _ if rest.is_empty() => *item = value,
                DeValue::Table(below) => return put(below, rest, value),
                _ => return Err(format!("{first}.{number} is no table")),
            }
            Ok(())
        }
        _ => Err(format!("{first} is no table; give it as a whole")),
    }
}

/// Has `read` read a table without any key: what it makes of that are the defaults.
pub(in crate::scene) fn with_empty<T>(read: impl FnOnce(&Section<'_>) -> Result<T>) -> Result<T> {
    Document::new(Path::new(""), "", &[]).read(read)
}

/// Has `read` read the value that `text` is in TOML.
pub(super) fn with_value<T>(text: &str, read: impl FnOnce(&Value<'_>) -> Result<T>) -> Result<T> {
    let document = Document::new(Path::new(""), text, &[]);
    let value = DeValue::parse(text)
        .map_err(|e| document.place(0, "value").error(one_line(e.message())))?;
    read(&Value::new(&document, "value".into(), &value))
}
