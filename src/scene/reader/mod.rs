//! Reads values out of a TOML document that remembers where everything stands.
//!
//! Serde's derive loses the place of a value inside inline tables and cannot tell which form of a
//! value was meant; every message of a scene file names file, line, column and key, so the document
//! is read by its spans instead. Settings of the command line are put into the document first: they
//! are read, and refused, as if they stood in the file.

mod document;
mod range;
mod section;
mod setting;
mod source;
mod value;

use std::path::PathBuf;

use crate::error::Error;

pub(super) use document::Document;
pub use range::Range;
pub(super) use section::{Section, with_empty};
pub use setting::Setting;
#[cfg(test)]
pub(super) use setting::checks;
pub(super) use source::ShotText;
pub(super) use value::Value;

/// The largest magnitude of any number in a scene file: squares of it stay finite in f32.
pub const MAX_MAGNITUDE: f64 = 1e18;

/// Where a key stands.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// The key with its tables, such as `medium[0].albedo`.
    pub key: String,
    origin: Origin,
}

/// Where a key was given.
#[derive(Debug, Clone, PartialEq)]
enum Origin {
    /// A scene file; line and column count from 1, the column in characters.
    File { path: PathBuf, line: usize, column: usize },
    /// The text written for a bare VDB file.
    Bare { path: PathBuf },
    /// The text written for a prim of a USD file.
    Shot { path: PathBuf, prim: String },
    /// A setting of the command line, as the user gave it.
    Setting { given: String },
}

impl Place {
    /// An error about the key.
    pub fn error(&self, problem: impl std::fmt::Display) -> Error {
        let problem = one_line(&problem.to_string());
        match &self.origin {
            Origin::File { path, line, column } => Error::Key {
                path: path.clone(),
                line: *line,
                column: *column,
                key: self.key.clone(),
                problem,
            },
            Origin::Bare { path } => {
                let own = format!("{}: ", path.display());
                Error::file(path, problem.strip_prefix(&own).unwrap_or(&problem))
            }
            Origin::Shot { path, prim } => {
                Error::file(path, format!("{prim}: {}: {problem}", self.key))
            }
            Origin::Setting { given } => Error::Usage(format!("{given}: {problem}")),
        }
    }

    /// The same place, its key's name followed by `more`.
    pub(super) fn below(mut self, more: &str) -> Self {
        self.key.push_str(more);
        self
    }
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &self.origin {
            Origin::File { path, line, .. } => write!(f, "{}:{line}: {}", path.display(), self.key),
            Origin::Bare { path } => write!(f, "{}: {}", path.display(), self.key),
            Origin::Shot { path, prim } => write!(f, "{}: {prim}: {}", path.display(), self.key),
            Origin::Setting { given } => write!(f, "{given}"),
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
    /// That of the next frame, where the time is between two and the name has the number of a frame; it need not be there.
    pub next: Option<PathBuf>,
}

/// `text` without line ends and control characters: a message is one line.
pub(super) fn one_line(text: &str) -> String {
    let visible = |c: char| if c.is_control() { ' ' } else { c };
    text.chars().map(visible).collect::<String>().split_whitespace().collect::<Vec<_>>().join(" ")
}
