//! Settings that override a scene file's.

use std::fmt::Display;

use toml::de::DeValue;

use super::super::keys::{Key, Kind};
use super::Range;
use super::value::{Value, with_value};
use crate::error::Result;

/// A key with a value that overrides the scene file's, as by `--set medium.0.albedo=0.8`.
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    /// The key with its tables, `.` between them; tables of an array by their number from 0.
    pub(super) path: String,
    /// The value in TOML.
    pub(super) value: String,
    /// The argument as the user gave it, for messages.
    pub(super) given: String,
}

impl Setting {
    /// `path`, such as `render.rays`, with a `value` in TOML.
    pub fn new(path: &str, value: impl Display) -> Self {
        let value = value.to_string();
        Self { path: path.into(), given: format!("{path} = {value}"), value }
    }

    /// `KEY=VALUE`, as `--set` takes it: a value that is no TOML is text.
    ///
    /// # Errors
    /// What would be right, where it has another form.
    pub fn parse(text: &str) -> Result<Self, String> {
        let right = "give KEY=VALUE, such as medium.0.albedo=0.8 or render.rays=64";
        let (path, value) = text.split_once('=').ok_or(right)?;
        let path = path.trim().replace('[', ".").replace(']', "");
        if path.is_empty() || path.split('.').any(str::is_empty) {
            return Err(right.into());
        }
        let value = value.trim();
        let value = if DeValue::parse(value).is_ok() { value.into() } else { quoted(value) };
        Ok(Self { path, value, given: format!("--set {text}") })
    }

    /// The value of a flag for `key` of the table `table`.
    ///
    /// # Errors
    /// What would be right, where it is no such value.
    pub(crate) fn from_flag(table: &str, key: &'static Key, text: &str) -> Result<Self, String> {
        let flag = key.flag.unwrap_or(key.name);
        let value =
            in_toml(&key.kind, text).ok_or_else(|| format!("give {}", flag_form(&key.kind)))?;
        let path = format!("{table}.{}", key.name);
        let setting = Self { path, value, given: format!("--{flag} {text}") };
        with_value(&setting.value, |value| check(value, &key.kind))
            .map_err(|_| format!("give {}", flag_form(&key.kind)))?;
        Ok(setting)
    }

    /// Whether it changes the scene itself, not only film, render or director.
    pub(in crate::scene) fn is_of_scene(&self) -> bool {
        !["film", "render", "director"].contains(&self.table())
    }

    /// The top table of its key.
    pub(in crate::scene) fn table(&self) -> &str {
        self.path.split('.').next().unwrap_or_default()
    }

    /// Key and value.
    pub(in crate::scene) fn parts(&self) -> (&str, &str) {
        (&self.path, &self.value)
    }
}

/// Text of a flag as a TOML value of `kind`.
fn in_toml(kind: &Kind, text: &str) -> Option<String> {
    let number = |text: &str| text.trim().parse().ok().filter(|x: &f64| x.is_finite());
    let float = |x: f64| format!("{x:?}");
    Some(match kind {
        Kind::Number(_) | Kind::Splat(_) => float(number(text)?),
        Kind::NumberOr(..) => number(text).map_or_else(|| quoted(text), float),
        Kind::Whole(..) => text.trim().parse::<u64>().ok()?.to_string(),
        Kind::Size => {
            let (width, height) = text.split_once(['x', 'X'])?;
            let side = |text: &str| text.trim().parse::<u64>().ok();
            format!("[{}, {}]", side(width)?, side(height)?)
        }
        Kind::Pair(_) => {
            let (a, b) = text.split_once(',')?;
            format!("[{}, {}]", float(number(a)?), float(number(b)?))
        }
        Kind::Triple | Kind::Direction => {
            let numbers: Option<Vec<_>> = text.split(',').map(|x| number(x).map(float)).collect();
            format!("[{}]", numbers?.join(", "))
        }
        Kind::Switch | Kind::Table(_) => text.into(),
        Kind::Word(_) | Kind::Text(_) | Kind::File(_) => quoted(text),
    })
}

/// The form that the flag of a key of `kind` takes.
fn flag_form(kind: &Kind) -> String {
    match kind {
        Kind::Size => {
            "width and height as 960x540, each from 1 to 65536, at most 268435456 pixels".into()
        }
        Kind::Pair(_) => format!("{} as 0.5,0.5", kind.right()),
        kind => kind.right(),
    }
}

/// Checks `value` against `kind` alone, without the keys beside it.
fn check(value: &Value<'_>, kind: &Kind) -> Result<()> {
    match kind {
        Kind::Number(range) => value.number(*range).map(drop),
        Kind::Whole(min, max) => value.integer(*min, *max).map(drop),
        Kind::Switch => value.switch().map(drop),
        Kind::Splat(range) => value.splat(*range).map(drop),
        Kind::Triple => value.triple(Range::ANY).map(drop),
        Kind::Direction => value.direction().map(drop),
        Kind::Pair(range) => value.pair(*range).map(drop),
        Kind::Size => value.size().map(drop),
        Kind::Word(words) => value.one_of(&words()).map(drop),
        Kind::NumberOr(range, words) => value.number_or(*range, words).map(drop),
        Kind::Text(_) | Kind::File(_) | Kind::Table(_) => Ok(()),
    }
}

/// Whether `text` is a TOML value that passes [`check`].
#[cfg(test)]
pub(in crate::scene) fn checks(kind: &Kind, text: &str) -> bool {
    with_value(text, |value| check(value, kind)).is_ok()
}

/// `text` as a TOML string.
pub(in crate::scene) fn quoted(text: &str) -> String {
    toml::Value::from(text).to_string()
}
