//! Tables of a scene's text.

use std::path::Path;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::super::directing::names;
use super::super::keys::{Key, Kind, Table, Without};
use super::source::Source;
use super::value::{Value, with_value};
use super::{FileReference, Place};
use crate::error::{Result, nearest};
use crate::math::Rgb;
use crate::sequence::FrameTime;

use glam::DVec3;

/// A table of the text.
#[derive(Debug, Clone)]
pub(in crate::scene) struct Section<'t> {
    source: &'t Source<'t>,
    key: String,
    table: &'t DeTable<'t>,
    offset: usize,
}

impl<'t> Section<'t> {
    /// The top table.
    pub(super) fn root(source: &'t Source<'t>, root: &'t Spanned<DeTable<'t>>) -> Self {
        Self { source, key: String::new(), table: root.get_ref(), offset: 0 }
    }

    /// The table that `value` is; `right` describes the form it should have.
    pub(in crate::scene) fn from_value(value: &Value<'t>, right: &str) -> Result<Self> {
        let table = value.table(right)?;
        let (source, key, offset) = (value.source(), value.key().to_owned(), value.offset());
        Ok(Self { source, key, table, offset })
    }

    /// The time for which the text is read, where it is one of frames.
    pub(in crate::scene) const fn frame(&self) -> Option<FrameTime> {
        self.source.frame
    }

    /// Where the table begins.
    pub(in crate::scene) fn place(&self) -> Place {
        let key = if self.key.is_empty() { "scene" } else { &self.key };
        self.source.place(self.offset, key)
    }

    /// Refuses keys that are not of `table`.
    pub(in crate::scene) fn only(&self, table: &Table) -> Result<()> {
        let known: Vec<&str> = table.keys.iter().map(|key| key.name).collect();
        self.only_named(table.what, &known)
    }

    /// Refuses keys that are not among `known`; `what` names the table.
    pub(in crate::scene) fn only_named(&self, what: &str, known: &[&str]) -> Result<()> {
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
    pub(in crate::scene) fn get(&self, key: &Key) -> Option<Value<'t>> {
        self.named(key.name)
    }

    /// The value of the key of this name, if it is there.
    pub(in crate::scene) fn named(&self, name: &str) -> Option<Value<'t>> {
        let (_, value) = self.table.iter().find(|(k, _)| k.get_ref().as_ref() == name)?;
        Some(Value::new(self.source, self.path_of(name), value))
    }

    /// The table of this name, if it is there; `right` describes the form it should have.
    pub(in crate::scene) fn table(&self, name: &str, right: &str) -> Result<Option<Self>> {
        self.named(name).map(|value| Self::from_value(&value, right)).transpose()
    }

    /// The error that `key` is missing.
    pub(in crate::scene) fn missing(&self, name: &str, right: &str) -> crate::error::Error {
        let mut place = self.place();
        place.key = self.path_of(name);
        place.error(format!("missing; give {right}"))
    }

    /// The value of `key`, which must be there.
    pub(in crate::scene) fn require(&self, key: &Key) -> Result<Value<'t>> {
        self.get(key).ok_or_else(|| match key.without {
            Without::Needed(right) => self.missing(key.name, right),
            Without::Default(_) | Without::Other(_) => self.missing(key.name, &key.kind.right()),
        })
    }

    /// Refuses more than one of `keys`.
    pub(in crate::scene) fn at_most_one(&self, keys: &[&Key]) -> Result<()> {
        let mut given = keys.iter().filter_map(|k| self.get(k).map(|value| (k.name, value)));
        match (given.next(), given.next()) {
            (Some((first, _)), Some((second, value))) => Err(value
                .error(format!("`{first}` and `{second}` exclude each other; give one of them"))),
            _ => Ok(()),
        }
    }

    /// The result of `read` for the value of `key`, or for its default where it is missing.
    ///
    /// # Errors
    /// Where `read` fails, or the key is missing and has no default.
    pub(in crate::scene) fn read<T>(
        &self,
        key: &Key,
        read: impl FnOnce(&Value<'_>) -> Result<T>,
    ) -> Result<T> {
        match (self.get(key), key.without) {
            (None, Without::Default(text)) => with_value(text, read),
            (None, _) => self.require(key).and_then(|value| read(&value)),
            (Some(value), _) => read(&value),
        }
    }

    /// The result of `read` for the value of `key`, if it is there.
    pub(in crate::scene) fn maybe<T>(
        &self,
        key: &Key,
        read: impl FnOnce(&Value<'_>) -> Result<T>,
    ) -> Result<Option<T>> {
        self.get(key).map(|value| read(&value)).transpose()
    }

    /// The number of `key`.
    pub(in crate::scene) fn number(&self, key: &Key) -> Result<f64> {
        self.read(key, |v| v.number_of(&key.kind))
    }

    /// The number of `key`, if it is there.
    pub(in crate::scene) fn maybe_number(&self, key: &Key) -> Result<Option<f64>> {
        self.maybe(key, |v| v.number_of(&key.kind))
    }

    /// The whole number of `key`.
    pub(in crate::scene) fn whole(&self, key: &Key) -> Result<u64> {
        self.read(key, |v| v.whole_of(&key.kind))
    }

    /// The whole number of `key`, if it is there.
    pub(in crate::scene) fn maybe_whole(&self, key: &Key) -> Result<Option<u64>> {
        self.maybe(key, |v| v.whole_of(&key.kind))
    }

    /// The colour, or the factors along the axes, of `key`.
    pub(in crate::scene) fn splat(&self, key: &Key) -> Result<Rgb> {
        self.read(key, |v| v.splat_of(&key.kind))
    }

    /// The point or direction of `key`.
    pub(in crate::scene) fn triple(&self, key: &Key) -> Result<DVec3> {
        self.read(key, |v| v.triple_of(&key.kind))
    }

    /// The two numbers of `key`.
    pub(in crate::scene) fn pair(&self, key: &Key) -> Result<[f64; 2]> {
        self.read(key, |v| v.pair_of(&key.kind))
    }

    /// The two numbers of `key`, if it is there.
    pub(in crate::scene) fn maybe_pair(&self, key: &Key) -> Result<Option<[f64; 2]>> {
        self.maybe(key, |v| v.pair_of(&key.kind))
    }

    /// Width and height of `key`.
    pub(in crate::scene) fn size(&self, key: &Key) -> Result<[u32; 2]> {
        self.read(key, |v| v.size_of(&key.kind))
    }

    /// Whether `key` is true.
    pub(in crate::scene) fn switch(&self, key: &Key) -> Result<bool> {
        self.read(key, |v| v.switch_of(&key.kind))
    }

    /// The value that `words` gives for the word of `key`.
    pub(in crate::scene) fn word<T: Copy>(
        &self,
        key: &Key,
        words: &[(&'static str, T)],
    ) -> Result<T> {
        debug_assert!(matches!(key.kind, Kind::Word(known) if known() == names(words)), "{key:?}");
        self.read(key, |v| v.word(words))
    }

    /// The value that `words` gives for the word of `key`, if it is there.
    pub(in crate::scene) fn maybe_word<T: Copy>(
        &self,
        key: &Key,
        words: &[(&'static str, T)],
    ) -> Result<Option<T>> {
        debug_assert!(matches!(key.kind, Kind::Word(known) if known() == names(words)), "{key:?}");
        self.maybe(key, |v| v.word(words))
    }

    /// The file of `key`.
    pub(in crate::scene) fn file(&self, key: &Key) -> Result<FileReference> {
        self.require(key)?.file_of(&key.kind)
    }

    /// The file of `key`, if it is there.
    pub(in crate::scene) fn maybe_file(&self, key: &Key) -> Result<Option<FileReference>> {
        self.maybe(key, |v| v.file_of(&key.kind))
    }

    /// The text of `key`, if it is there.
    pub(in crate::scene) fn maybe_text(&self, key: &Key) -> Result<Option<String>> {
        self.maybe(key, |v| v.string(&key.kind.right()).map(str::to_owned))
    }

    /// The tables of the array `name` (`[[name]]`), none where it is not there.
    pub(in crate::scene) fn tables(&self, name: &str, max: usize) -> Result<Vec<Self>> {
        let Some(value) = self.named(name) else { return Ok(Vec::new()) };
        let right = format!("tables, each begun by `[[{name}]]`");
        let DeValue::Array(items) = value.get() else { return Err(value.wrong(&right)) };
        if items.len() > max {
            return Err(value.error(format!("{} of them; at most {max} are allowed", items.len())));
        }
        value.items(items).map(|item| Self::from_value(&item, &right)).collect()
    }

    fn path_of(&self, key: &str) -> String {
        if self.key.is_empty() { key.to_owned() } else { format!("{}.{key}", self.key) }
    }
}

/// Calls `read` with an empty table, which gives the defaults.
pub(in crate::scene) fn with_empty<T>(read: impl FnOnce(&Section<'_>) -> Result<T>) -> Result<T> {
    let (source, table) = (Source::new(Path::new(""), ""), DeTable::new());
    read(&Section { source: &source, key: String::new(), table: &table, offset: 0 })
}
