//! The one error type.
//!
//! Every message names the file, the key or the grid, what was found there and what would be right.

use std::fmt::Display;
use std::path::{Path, PathBuf};

use crate::sequence::FrameTime;

/// Short for a result with fogbow's [`enum@Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// What can go wrong, told so that a user can mend it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file cannot be read, written or understood.
    #[error("{}: {problem}", .path.display())]
    File {
        /// The file as the user named it.
        path: PathBuf,
        /// What was found and what would be right.
        problem: String,
    },
    /// A grid inside a VDB file cannot be used.
    #[error("{}: grid \"{grid}\": {problem}", .path.display())]
    Grid {
        /// The VDB file.
        path: PathBuf,
        /// The grid's name, with its index where the name is not unique.
        grid: String,
        /// What was found and what would be right.
        problem: String,
    },
    /// A key of a scene file is unknown, missing, of the wrong type or out of range.
    #[error("{}{}: {key}: {problem}", .path.display(), place(*line, *column))]
    Key {
        /// The scene file.
        path: PathBuf,
        /// Line of the key, from 1; 0 where it is not known.
        line: usize,
        /// Column of the key, from 1; 0 where it is not known.
        column: usize,
        /// The key with its tables, such as `media[0].albedo`.
        key: String,
        /// What was found and what would be right.
        problem: String,
    },
    /// A frame of a sequence cannot be rendered.
    #[error("frame {frame}: {problem}")]
    Frame {
        /// Its time.
        frame: FrameTime,
        /// What was found and what would be right.
        problem: String,
    },
    /// The program was called in a way that makes no sense.
    #[error("{0}")]
    Usage(String),
    /// The machine, its memory or its system, does not let it be done.
    #[error("{0}")]
    Failed(String),
    /// The user or the system ended it; what is kept and how to go on.
    #[error("{message}")]
    Interrupted {
        /// What is kept and how to go on.
        message: String,
        /// The exit code that tells of the signal.
        code: u8,
    },
    /// Something that must hold does not; what and how often.
    #[error("{0}")]
    Verify(String),
}

impl Error {
    /// An [`Error::File`] for `path`.
    pub fn file(path: impl AsRef<Path>, problem: impl Display) -> Self {
        Self::File { path: path.as_ref().to_path_buf(), problem: visible(problem) }
    }

    /// An [`Error::Grid`] for `grid` in `path`.
    pub fn grid(path: impl AsRef<Path>, grid: impl Display, problem: impl Display) -> Self {
        Self::Grid {
            path: path.as_ref().to_path_buf(),
            grid: visible(grid),
            problem: visible(problem),
        }
    }

    /// The exit code that belongs to the error: 2 for misuse, 1 for a failure, that of the signal
    /// for an interruption.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Usage(_) => 2,
            Self::Interrupted { code, .. } => *code,
            _ => 1,
        }
    }
}

/// Text without control characters, which names in a file may have: a message is one line.
fn visible(text: impl Display) -> String {
    text.to_string().chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

fn place(line: usize, column: usize) -> String {
    if line == 0 { String::new() } else { format!(":{line}:{column}") }
}

/// The word of `known` that `name` was most likely meant to be: at most two letters, or a third of
/// them, are wrong, but not all (Damerau and Levenshtein's distance); case does not matter.
pub(crate) fn nearest<'k>(name: &str, known: &[&'k str]) -> Option<&'k str> {
    let name = name.to_lowercase();
    known
        .iter()
        .map(|k| (strsim::damerau_levenshtein(&name, &k.to_lowercase()), *k))
        .filter(|(distance, k)| *distance <= 2.max(k.len() / 3) && *distance < k.chars().count())
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, k)| k)
}
