//! Values of a scene's text.

use std::path::Path;

use glam::DVec3;
use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};

use super::super::keys::Kind;
use super::super::outline::without_frame;
use super::super::settings::{MAX_PIXELS, MAX_SIDE};
use super::source::Source;
use super::{FileReference, MAX_MAGNITUDE, Place, Range, one_line};
use crate::error::{Error, Result};
use crate::math::Rgb;
use crate::sequence::Pattern;

/// A value of the text with the key it belongs to.
#[derive(Debug, Clone)]
pub(in crate::scene) struct Value<'t> {
    source: &'t Source<'t>,
    key: String,
    value: &'t Spanned<DeValue<'t>>,
}

impl<'t> Value<'t> {
    pub(super) const fn new(
        source: &'t Source<'t>,
        key: String,
        value: &'t Spanned<DeValue<'t>>,
    ) -> Self {
        Self { source, key, value }
    }

    /// The TOML value.
    pub(super) fn get(&self) -> &'t DeValue<'t> {
        self.value.get_ref()
    }

    /// The number that a key of `kind` takes.
    pub(super) fn number_of(&self, kind: &Kind) -> Result<f64> {
        match kind {
            Kind::Number(range) => self.number(*range),
            other => Err(self.wrong(&other.right())),
        }
    }

    /// The whole number that a key of `kind` takes.
    pub(super) fn whole_of(&self, kind: &Kind) -> Result<u64> {
        match kind {
            Kind::Whole(min, max) => self.integer(*min, *max),
            other => Err(self.wrong(&other.right())),
        }
    }

    /// The one or three numbers that a key of `kind` takes.
    pub(super) fn splat_of(&self, kind: &Kind) -> Result<DVec3> {
        match kind {
            Kind::Splat(range) => self.splat(*range),
            other => Err(self.wrong(&other.right())),
        }
    }

    /// The three numbers that a key of `kind` takes.
    pub(super) fn triple_of(&self, kind: &Kind) -> Result<DVec3> {
        match kind {
            Kind::Triple => self.triple(Range::ANY),
            Kind::Direction => self.direction(),
            other => Err(self.wrong(&other.right())),
        }
    }

    /// The two numbers that a key of `kind` takes.
    pub(in crate::scene) fn pair_of(&self, kind: &Kind) -> Result<[f64; 2]> {
        match kind {
            Kind::Pair(range) => self.pair(*range),
            other => Err(self.wrong(&other.right())),
        }
    }

    /// The number that a key of `kind` takes; `None` where it is a word instead.
    pub(in crate::scene) fn number_or_of(&self, kind: &Kind) -> Result<Option<f64>> {
        match kind {
            Kind::NumberOr(range, words) => self.number_or(*range, words),
            other => Err(self.wrong(&other.right())),
        }
    }

    /// The file that a key of `kind` takes.
    pub(super) fn file_of(&self, kind: &Kind) -> Result<FileReference> {
        self.file(&kind.right())
    }

    /// Width and height that a key of `kind` takes.
    pub(super) fn size_of(&self, kind: &Kind) -> Result<[u32; 2]> {
        match kind {
            Kind::Size => self.size(),
            other => Err(self.wrong(&other.right())),
        }
    }

    /// The truth value that a key of `kind` takes.
    pub(super) fn switch_of(&self, kind: &Kind) -> Result<bool> {
        match kind {
            Kind::Switch => self.switch(),
            other => Err(self.wrong(&other.right())),
        }
    }

    /// `true` or `false`.
    pub(super) fn switch(&self) -> Result<bool> {
        self.value.get_ref().as_bool().ok_or_else(|| self.wrong("true or false"))
    }

    /// Width and height of a film.
    pub(super) fn size(&self) -> Result<[u32; 2]> {
        let [width, height] = self.integer_pair(1, u64::from(MAX_SIDE))?;
        if width * height > MAX_PIXELS {
            return Err(self.wrong(&format!("at most {MAX_PIXELS} pixels together")));
        }
        Ok([width as u32, height as u32])
    }

    /// The number it is within `range`; `None` where it is one of `words`.
    pub(in crate::scene) fn number_or(&self, range: Range, words: &[&str]) -> Result<Option<f64>> {
        if self.is_string() {
            let list = words.iter().map(|w| format!("\"{w}\"")).collect::<Vec<_>>().join(" or ");
            let right = format!("{} or {list}", range.words());
            let given = self.string(&right)?;
            return if words.contains(&given) { Ok(None) } else { Err(self.wrong(&right)) };
        }
        self.number(range).map(Some)
    }

    /// The word of `words` that it is.
    pub(super) fn one_of(&self, words: &[&'static str]) -> Result<&'static str> {
        let words: Vec<_> = words.iter().map(|word| (*word, *word)).collect();
        self.word(&words)
    }

    /// Where the value stands.
    pub(in crate::scene) fn place(&self) -> Place {
        self.source.place(self.value.span().start, &*self.key)
    }

    /// An error about the value.
    pub(in crate::scene) fn error(&self, problem: impl std::fmt::Display) -> Error {
        self.place().error(problem)
    }

    /// The error that the value has another form than `right` describes.
    pub(in crate::scene) fn wrong(&self, right: &str) -> Error {
        self.error(format!("found {}; give {right}", self.found()))
    }

    /// Whether it is an inline or a full table.
    pub(in crate::scene) fn is_table(&self) -> bool {
        self.value.get_ref().is_table()
    }

    /// Whether it is a string.
    pub(in crate::scene) fn is_string(&self) -> bool {
        self.value.get_ref().is_str()
    }

    /// The table it is; `right` describes the form it should have.
    pub(super) fn table(&self, right: &str) -> Result<&'t DeTable<'t>> {
        self.value.get_ref().as_table().ok_or_else(|| self.wrong(right))
    }

    /// The text that contains it.
    pub(super) const fn source(&self) -> &'t Source<'t> {
        self.source
    }

    /// Its key.
    pub(super) fn key(&self) -> &str {
        &self.key
    }

    /// Where it begins in the text, in bytes.
    pub(super) fn offset(&self) -> usize {
        self.value.span().start
    }

    /// The number it is, within `range`.
    pub(in crate::scene) fn number(&self, range: Range) -> Result<f64> {
        let number = self.as_number().ok_or_else(|| self.wrong(range.words()))?;
        if !number.is_finite() || !range.holds(number) {
            return Err(self.wrong(range.words()));
        }
        if number.abs() > MAX_MAGNITUDE {
            return Err(self.wrong(&format!("a number no larger than {MAX_MAGNITUDE:e}")));
        }
        Ok(number)
    }

    /// The whole number it is, from `min` to `max`.
    pub(in crate::scene) fn integer(&self, min: u64, max: u64) -> Result<u64> {
        self.as_integer()
            .and_then(|i| u64::try_from(i).ok())
            .filter(|i| (min..=max).contains(i))
            .ok_or_else(|| self.wrong(&format!("a whole number from {min} to {max}")))
    }

    /// Three numbers within `range`.
    pub(in crate::scene) fn triple(&self, range: Range) -> Result<DVec3> {
        let right = "three numbers [x, y, z]";
        let array = self.value.get_ref().as_array().filter(|a| a.len() == 3);
        let array = array.ok_or_else(|| self.wrong(right))?;
        let numbers =
            self.items(array).map(|item| item.number(range)).collect::<Result<Vec<_>>>()?;
        Ok(DVec3::from_slice(&numbers))
    }

    /// Two numbers within `range`.
    pub(in crate::scene) fn pair(&self, range: Range) -> Result<[f64; 2]> {
        match self.value.get_ref().as_array().map(|array| self.items(array).collect::<Vec<_>>()) {
            Some(items) if items.len() == 2 => {
                Ok([items[0].number(range)?, items[1].number(range)?])
            }
            _ => Err(self.wrong("two numbers [a, b]")),
        }
    }

    /// Two whole numbers from `min` to `max`.
    pub(in crate::scene) fn integer_pair(&self, min: u64, max: u64) -> Result<[u64; 2]> {
        match self.value.get_ref().as_array().map(|array| self.items(array).collect::<Vec<_>>()) {
            Some(items) if items.len() == 2 => {
                Ok([items[0].integer(min, max)?, items[1].integer(min, max)?])
            }
            _ => Err(self.wrong("two whole numbers [width, height]")),
        }
    }

    /// The values of an array of at most `max`.
    pub(in crate::scene) fn list(&self, max: usize, right: &str) -> Result<Vec<Self>> {
        let array = self.value.get_ref().as_array().ok_or_else(|| self.wrong(right))?;
        if array.len() > max {
            return Err(self.error(format!("{} of them; at most {max} are allowed", array.len())));
        }
        Ok(self.items(array).collect())
    }

    /// A number for all three channels or axes, or three numbers, within `range`.
    pub(in crate::scene) fn splat(&self, range: Range) -> Result<DVec3> {
        match self.value.get_ref() {
            DeValue::Integer(_) | DeValue::Float(_) => self.number(range).map(DVec3::splat),
            DeValue::Array(array) if array.len() == 3 => self.triple(range),
            _ => Err(self.wrong(&format!("{} or three such numbers in brackets", range.words()))),
        }
    }

    /// A colour: a number (grey) or three numbers (linear Rec.709), within `range`.
    pub(in crate::scene) fn color(&self, range: Range) -> Result<Rgb> {
        self.splat(range)
    }

    /// A vector that is not zero.
    pub(in crate::scene) fn direction(&self) -> Result<DVec3> {
        let v = self.triple(Range::ANY)?;
        if v.length_squared() == 0.0 {
            return Err(self.wrong("a direction of a length above 0"));
        }
        Ok(v)
    }

    /// The string it is, not empty.
    pub(in crate::scene) fn string(&self, right: &str) -> Result<&'t str> {
        self.value.get_ref().as_str().filter(|s| !s.is_empty()).ok_or_else(|| self.wrong(right))
    }

    /// The value that `words` gives for it.
    pub(in crate::scene) fn word<T: Copy>(&self, words: &[(&str, T)]) -> Result<T> {
        let list = words.iter().map(|(w, _)| format!("\"{w}\"")).collect::<Vec<_>>().join(" or ");
        let given = self.string(&list)?;
        words.iter().find(|(w, _)| *w == given).map(|(_, t)| *t).ok_or_else(|| self.wrong(&list))
    }

    /// The file it names, relative to the scene file. It must be there, unless it belongs to a
    /// frame of a sequence.
    pub(in crate::scene) fn file(&self, right: &str) -> Result<FileReference> {
        let name = self.string(right)?;
        let of_shot = self.source.shot.and_then(|shot| shot.file(name));
        if let Some(path) = of_shot {
            // Meshes of a shot are in memory, and what else it names is told by its own path.
            let is_there = self.source.shot.is_some_and(|s| s.meshes.contains_key(name));
            if is_there || path.is_file() {
                let next = self.source.shot.and_then(|shot| shot.next_assets.get(name).cloned());
                return Ok(FileReference { path, at: self.place(), next });
            }
            return Err(self.error(format!("{}: no such file", path.display())));
        }
        let folder = self.source.path.parent().unwrap_or(Path::new(""));
        let path = folder.join(name);
        if !path.is_file() {
            if let Some(pattern) = Pattern::from_path(&path) {
                let time = self.source.frame;
                let time = time.ok_or_else(|| self.error(without_frame(name, &pattern)))?;
                let next = (!time.is_whole()).then(|| pattern.existing(time.frame() + 1));
                return Ok(FileReference {
                    path: pattern.existing(time.frame()),
                    at: self.place(),
                    next,
                });
            }
            let what = if path.exists() { "is not a file" } else { "no such file" };
            let right = format!("{right}, its path relative to the scene file");
            return Err(self.error(format!("{}: {what}; give {right}", path.display())));
        }
        Ok(FileReference { path, at: self.place(), next: None })
    }

    /// As [`file`](Self::file), that of the next frame where it is one of a sequence; `None` where that is not there.
    pub(in crate::scene) fn next_file(&self, right: &str) -> Result<Option<FileReference>> {
        let folder = self.source.path.parent().unwrap_or(Path::new(""));
        let path = folder.join(self.string(right)?);
        let pattern = Pattern::from_path(&path).filter(|_| !path.is_file());
        let next = self.source.frame.map(|time| time.frame() + 1);
        match pattern.zip(next) {
            Some((pattern, next)) => {
                let path = pattern.existing(next);
                Ok(path.is_file().then(|| FileReference { path, at: self.place(), next: None }))
            }
            None => self.file(right).map(Some),
        }
    }

    pub(super) fn items(&self, array: &'t DeArray<'t>) -> impl Iterator<Item = Value<'t>> {
        let (source, key) = (self.source, self.key.clone());
        let item = move |(i, value)| Value { source, key: format!("{key}[{i}]"), value };
        array.iter().enumerate().map(item)
    }

    fn as_number(&self) -> Option<f64> {
        match self.value.get_ref() {
            DeValue::Float(float) => float.as_str().parse().ok(),
            DeValue::Integer(_) => self.as_integer().map(|i| i as f64),
            _ => None,
        }
    }

    fn as_integer(&self) -> Option<i64> {
        let integer = self.value.get_ref().as_integer()?;
        i64::from_str_radix(integer.as_str(), integer.radix()).ok()
    }

    /// The value as written in the file, shortened.
    fn found(&self) -> String {
        let text = self.source.text.get(self.value.span()).unwrap_or_default();
        let line = one_line(text);
        if self.value.get_ref().is_table() && !text.starts_with('{') {
            return "a table".into();
        }
        match line.char_indices().nth(40) {
            Some((end, _)) => format!("`{}...`", &line[..end]),
            None => format!("`{line}`"),
        }
    }
}

/// Parses `text` as a TOML value and calls `read` with it.
pub(super) fn with_value<T>(text: &str, read: impl FnOnce(&Value<'_>) -> Result<T>) -> Result<T> {
    let source = Source::new(Path::new(""), text);
    let value =
        DeValue::parse(text).map_err(|e| source.place(0, "value").error(one_line(e.message())))?;
    read(&Value::new(&source, "value".into(), &value))
}
