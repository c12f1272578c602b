//! Reads values out of a TOML document that remembers where everything stands.
//!
//! Serde's derive loses the place of a value inside inline tables and cannot tell which form of a
//! value was meant; every message of a scene file names file, line, column and key, so the document
//! is read by its spans instead.

use std::path::{Path, PathBuf};

use glam::DVec3;
use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};

use super::document;
use crate::error::{Error, Result, nearest};
use crate::math::Rgb;
use crate::sequence::Pattern;

/// The largest magnitude of any number in a scene file: squares of it stay finite in f32.
pub const MAX_MAGNITUDE: f64 = 1e18;

/// The text of a scene file, for the places in messages.
#[derive(Debug)]
pub(super) struct Source<'t> {
    /// The file as the user named it.
    pub(super) path: &'t Path,
    /// What is in it.
    pub(super) text: &'t str,
    /// The frame whose files are meant where a path has a place for its number.
    pub(super) frame: Option<i64>,
}

/// Where a key stands in a scene file.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// The scene file.
    pub path: PathBuf,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// The key with its tables, such as `medium[0].albedo`.
    pub key: String,
}

impl Place {
    /// An error about the key.
    pub fn error(&self, problem: impl std::fmt::Display) -> Error {
        Error::Key {
            path: self.path.clone(),
            line: self.line,
            column: self.column,
            key: self.key.clone(),
            problem: one_line(&problem.to_string()),
        }
    }
}

/// A file named by a key, its path already relative to the scene file's folder.
#[derive(Debug, Clone, PartialEq)]
pub struct FileReference {
    /// The file.
    pub path: PathBuf,
    /// The key that names it.
    pub at: Place,
}

/// A condition on a number, with the words that say what would be right.
#[derive(Debug, Clone, Copy)]
pub(super) struct Range {
    holds: fn(f64) -> bool,
    words: &'static str,
}

impl Range {
    pub(super) const ANY: Self = Self { holds: |_| true, words: "a finite number" };
    pub(super) const POSITIVE: Self = Self { holds: |x| x > 0.0, words: "a number above 0" };
    pub(super) const NOT_NEGATIVE: Self =
        Self { holds: |x| x >= 0.0, words: "a number of at least 0" };
    pub(super) const NOT_ZERO: Self = Self { holds: |x| x != 0.0, words: "a number other than 0" };
    pub(super) const UNIT: Self =
        Self { holds: |x| (0.0..=1.0).contains(&x), words: "a number from 0 to 1" };

    pub(super) const fn new(holds: fn(f64) -> bool, words: &'static str) -> Self {
        Self { holds, words }
    }

    /// What would be right.
    pub(super) const fn words(&self) -> &'static str {
        self.words
    }
}

impl Source<'_> {
    /// The place of byte `offset`.
    pub(super) fn place(&self, offset: usize, key: impl Into<String>) -> Place {
        let before = self.text.get(..offset).unwrap_or(self.text);
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        Place {
            path: self.path.to_path_buf(),
            line: before.matches('\n').count() + 1,
            column: before[line_start..].chars().count() + 1,
            key: key.into(),
        }
    }
}

/// A table of the document.
#[derive(Debug, Clone)]
pub(super) struct Section<'t> {
    source: &'t Source<'t>,
    key: String,
    table: &'t DeTable<'t>,
    offset: usize,
}

impl<'t> Section<'t> {
    /// The document's top table.
    pub(super) fn root(source: &'t Source<'t>, document: &'t Spanned<DeTable<'t>>) -> Self {
        Self { source, key: String::new(), table: document.get_ref(), offset: 0 }
    }

    /// Where the table begins.
    pub(super) fn place(&self) -> Place {
        let key = if self.key.is_empty() { "scene" } else { &self.key };
        self.source.place(self.offset, key)
    }

    /// Refuses keys that are not among `known`; `what` says what they would be keys of.
    pub(super) fn only(&self, what: &str, known: &[&str]) -> Result<()> {
        let unknown = self
            .table
            .keys()
            .filter(|key| !known.contains(&key.get_ref().as_ref()))
            .min_by_key(|key| key.span().start);
        let Some(key) = unknown else { return Ok(()) };
        let name = key.get_ref().as_ref();
        let hint = nearest(name, known).map_or(String::new(), |k| format!(" did you mean `{k}`?"));
        Err(self
            .source
            .place(key.span().start, self.path_of(name))
            .error(format!("unknown key of {what};{hint} known here: {}", known.join(", "))))
    }

    /// The value of `key`, if it is there.
    pub(super) fn get(&self, key: &str) -> Option<Value<'t>> {
        let (_, value) = self.table.iter().find(|(k, _)| k.get_ref().as_ref() == key)?;
        Some(Value { source: self.source, key: self.path_of(key), value })
    }

    /// The value of `key`, which must be there; `right` says what it should hold.
    pub(super) fn require(&self, key: &str, right: &str) -> Result<Value<'t>> {
        self.get(key).ok_or_else(|| {
            let mut place = self.place();
            place.key = self.path_of(key);
            place.error(format!("missing; give {right}"))
        })
    }

    /// Refuses more than one of `keys`.
    pub(super) fn at_most_one(&self, keys: &[&str]) -> Result<()> {
        let mut given = keys.iter().filter_map(|k| self.get(k).map(|value| (k, value)));
        match (given.next(), given.next()) {
            (Some((first, _)), Some((second, value))) => Err(value
                .error(format!("`{first}` and `{second}` exclude each other; give one of them"))),
            _ => Ok(()),
        }
    }

    /// What `read` makes of `key`, or `default` where it is not there.
    pub(super) fn or<T>(
        &self,
        key: &str,
        default: T,
        read: impl FnOnce(Value<'t>) -> Result<T>,
    ) -> Result<T> {
        self.get(key).map_or(Ok(default), read)
    }

    /// What `read` makes of `key`, if it is there.
    pub(super) fn maybe<T>(
        &self,
        key: &str,
        read: impl FnOnce(Value<'t>) -> Result<T>,
    ) -> Result<Option<T>> {
        self.get(key).map(read).transpose()
    }

    /// The tables of the array `key` (`[[key]]`), none where it is not there.
    pub(super) fn tables(&self, key: &str, max: usize) -> Result<Vec<Self>> {
        let Some(value) = self.get(key) else { return Ok(Vec::new()) };
        let right = format!("tables, each begun by `[[{key}]]`");
        let DeValue::Array(items) = value.value.get_ref() else { return Err(value.wrong(&right)) };
        if items.len() > max {
            return Err(value.error(format!("{} of them; at most {max} are allowed", items.len())));
        }
        value.items(items).map(|item| item.table(&right)).collect()
    }

    fn path_of(&self, key: &str) -> String {
        if self.key.is_empty() { key.to_owned() } else { format!("{}.{key}", self.key) }
    }
}

/// A value of the document with the key it belongs to.
#[derive(Debug, Clone)]
pub(super) struct Value<'t> {
    source: &'t Source<'t>,
    key: String,
    value: &'t Spanned<DeValue<'t>>,
}

impl<'t> Value<'t> {
    /// Where the value stands.
    pub(super) fn place(&self) -> Place {
        self.source.place(self.value.span().start, &*self.key)
    }

    /// An error about the value.
    pub(super) fn error(&self, problem: impl std::fmt::Display) -> Error {
        self.place().error(problem)
    }

    /// The error that the value is not what it should be.
    pub(super) fn wrong(&self, right: &str) -> Error {
        self.error(format!("found {}; give {right}", self.found()))
    }

    /// Whether it is an inline or a full table.
    pub(super) fn is_table(&self) -> bool {
        self.value.get_ref().is_table()
    }

    /// Whether it is a string.
    pub(super) fn is_string(&self) -> bool {
        self.value.get_ref().is_str()
    }

    /// The table it is.
    pub(super) fn table(&self, right: &str) -> Result<Section<'t>> {
        let table = self.value.get_ref().as_table().ok_or_else(|| self.wrong(right))?;
        let offset = self.value.span().start;
        Ok(Section { source: self.source, key: self.key.clone(), table, offset })
    }

    /// The number it is, within `range`.
    pub(super) fn number(&self, range: Range) -> Result<f64> {
        let number = self.as_number().ok_or_else(|| self.wrong(range.words))?;
        if !number.is_finite() || !(range.holds)(number) {
            return Err(self.wrong(range.words));
        }
        if number.abs() > MAX_MAGNITUDE {
            return Err(self.wrong(&format!("a number no larger than {MAX_MAGNITUDE:e}")));
        }
        Ok(number)
    }

    /// The whole number it is, from `min` to `max`.
    pub(super) fn integer(&self, min: u64, max: u64) -> Result<u64> {
        self.as_integer()
            .and_then(|i| u64::try_from(i).ok())
            .filter(|i| (min..=max).contains(i))
            .ok_or_else(|| self.wrong(&format!("a whole number from {min} to {max}")))
    }

    /// Three numbers within `range`.
    pub(super) fn triple(&self, range: Range) -> Result<DVec3> {
        let right = "three numbers [x, y, z]";
        let array = self.value.get_ref().as_array().filter(|a| a.len() == 3);
        let array = array.ok_or_else(|| self.wrong(right))?;
        let numbers =
            self.items(array).map(|item| item.number(range)).collect::<Result<Vec<_>>>()?;
        Ok(DVec3::from_slice(&numbers))
    }

    /// Two numbers within `range`.
    pub(super) fn pair(&self, range: Range) -> Result<[f64; 2]> {
        match self.value.get_ref().as_array().map(|array| self.items(array).collect::<Vec<_>>()) {
            Some(items) if items.len() == 2 => {
                Ok([items[0].number(range)?, items[1].number(range)?])
            }
            _ => Err(self.wrong("two numbers [a, b]")),
        }
    }

    /// Two whole numbers from `min` to `max`.
    pub(super) fn integer_pair(&self, min: u64, max: u64) -> Result<[u64; 2]> {
        match self.value.get_ref().as_array().map(|array| self.items(array).collect::<Vec<_>>()) {
            Some(items) if items.len() == 2 => {
                Ok([items[0].integer(min, max)?, items[1].integer(min, max)?])
            }
            _ => Err(self.wrong("two whole numbers [width, height]")),
        }
    }

    /// The values of an array of at most `max`.
    pub(super) fn list(&self, max: usize, right: &str) -> Result<Vec<Self>> {
        let array = self.value.get_ref().as_array().ok_or_else(|| self.wrong(right))?;
        if array.len() > max {
            return Err(self.error(format!("{} of them; at most {max} are allowed", array.len())));
        }
        Ok(self.items(array).collect())
    }

    /// A number for all three channels or axes, or three numbers, within `range`.
    pub(super) fn splat(&self, range: Range) -> Result<DVec3> {
        match self.value.get_ref() {
            DeValue::Integer(_) | DeValue::Float(_) => self.number(range).map(DVec3::splat),
            DeValue::Array(array) if array.len() == 3 => self.triple(range),
            _ => Err(self.wrong(&format!("{} or three such numbers in brackets", range.words))),
        }
    }

    /// A colour: a number (grey) or three numbers (linear Rec.709), within `range`.
    pub(super) fn color(&self, range: Range) -> Result<Rgb> {
        self.splat(range)
    }

    /// A vector that is not zero.
    pub(super) fn direction(&self) -> Result<DVec3> {
        let v = self.triple(Range::ANY)?;
        if v.length_squared() == 0.0 {
            return Err(self.wrong("a direction of a length above 0"));
        }
        Ok(v)
    }

    /// The string it is, not empty.
    pub(super) fn string(&self, right: &str) -> Result<&'t str> {
        self.value.get_ref().as_str().filter(|s| !s.is_empty()).ok_or_else(|| self.wrong(right))
    }

    /// What belongs to the word it is.
    pub(super) fn word<T: Copy>(&self, words: &[(&str, T)]) -> Result<T> {
        let list = words.iter().map(|(w, _)| format!("\"{w}\"")).collect::<Vec<_>>().join(" or ");
        let given = self.string(&list)?;
        words.iter().find(|(w, _)| *w == given).map(|(_, t)| *t).ok_or_else(|| self.wrong(&list))
    }

    /// The file it names, relative to the scene file. It must be there, unless it belongs to a
    /// frame of a sequence.
    pub(super) fn file(&self, right: &str) -> Result<FileReference> {
        let name = self.string(right)?;
        let folder = self.source.path.parent().unwrap_or(Path::new(""));
        let path = folder.join(name);
        if !path.is_file() {
            if let Some(pattern) = Pattern::of(&path) {
                let path = self.source.frame.map(|frame| pattern.existing(frame));
                let path =
                    path.ok_or_else(|| self.error(document::without_frame(name, &pattern)))?;
                return Ok(FileReference { path, at: self.place() });
            }
            let what = if path.exists() { "is not a file" } else { "no such file" };
            let right = format!("{right}, its path relative to the scene file");
            return Err(self.error(format!("{}: {what}; give {right}", path.display())));
        }
        Ok(FileReference { path, at: self.place() })
    }

    fn items(&self, array: &'t DeArray<'t>) -> impl Iterator<Item = Value<'t>> {
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

    /// The value as it stands in the file, shortened.
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

/// `text` without line ends and control characters: a message is one line.
pub(super) fn one_line(text: &str) -> String {
    let visible = |c: char| if c.is_control() { ' ' } else { c };
    text.chars().map(visible).collect::<String>().split_whitespace().collect::<Vec<_>>().join(" ")
}
