//! A scene's text with the settings that override it.

use std::path::Path;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::one_line;
use super::section::Section;
use super::setting::Setting;
use super::source::{ShotText, Source};
use crate::error::Result;
use crate::sequence::FrameTime;

/// The text of a scene with the settings that override it.
#[derive(Debug)]
pub(in crate::scene) struct Document<'a> {
    source: Source<'a>,
}

impl<'a> Document<'a> {
    /// The scene `text` of the file `path`, overridden by `settings`.
    pub(in crate::scene) fn new(path: &'a Path, text: &str, settings: &'a [Setting]) -> Self {
        let mut source = Source::new(path, text);
        for Setting { path, value, given } in settings {
            source.append(path, value, given);
        }
        Self { source }
    }

    /// The same at a time, with the files of its frame.
    pub(in crate::scene) fn at_frame(mut self, frame: Option<FrameTime>) -> Self {
        self.source.frame = frame;
        self
    }

    /// The same, as the text written for a bare VDB file, whose messages name that file.
    pub(in crate::scene) fn for_bare_vdb(mut self) -> Self {
        self.source.bare = true;
        self
    }

    /// The same, part of which was written for a USD file.
    pub(in crate::scene) fn with_shot(mut self, shot: ShotText<'a>) -> Self {
        self.source.shot = Some(shot);
        self
    }

    /// Parses the text, applies the settings, and calls `read` with the top table.
    ///
    /// # Errors
    /// Where text or a setting is no TOML, a setting's table is not there, or `read` fails.
    pub(in crate::scene) fn read<T>(
        &self,
        read: impl FnOnce(&Section<'_>) -> Result<T>,
    ) -> Result<T> {
        let source = &self.source;
        let mut root = DeTable::parse(source.own()).map_err(|e| {
            let offset = e.span().map_or(0, |span| span.start);
            source.place(offset, "TOML").error(one_line(e.message()))
        })?;
        for setting in source.settings() {
            let text = &source.text[setting.range.clone()];
            let place = source.place(setting.range.start, setting.key);
            let value = DeValue::parse(text).map_err(|e| place.error(one_line(e.message())))?;
            let value = shifted(value, setting.range.start);
            put(root.get_mut(), setting.key, value).map_err(|problem| place.error(problem))?;
        }
        read(&Section::root(source, &root))
    }
}

/// `value` with all its spans shifted by `by` bytes.
fn shifted(value: Spanned<DeValue<'_>>, by: usize) -> Spanned<DeValue<'_>> {
    let span = value.span().start + by..value.span().end + by;
    let inner = match value.into_inner() {
        DeValue::Array(items) => {
            DeValue::Array(items.into_iter().map(|item| shifted(item, by)).collect())
        }
        DeValue::Table(table) => DeValue::Table(
            table
                .into_iter()
                .map(|(key, value)| {
                    let span = key.span().start + by..key.span().end + by;
                    (Spanned::new(span, key.into_inner()), shifted(value, by))
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
