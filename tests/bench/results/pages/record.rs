//! What a measurement leaves.

use std::fmt::Write as _;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::Result;

/// Raw figures, and all that it takes to find them again.
#[derive(Debug, Serialize, Deserialize)]
pub struct Record<R> {
    /// The measurement, as in [`PAGES`](super::PAGES).
    pub name: String,
    /// fogbow's version.
    pub version: String,
    /// Processor, processors, threads and system.
    pub machine: String,
    /// The day of the last row, as year-month-day.
    pub date: String,
    /// What measured it.
    pub command: String,
    /// What else holds for these rows, such as what was left out; empty where nothing does.
    pub note: String,
    /// The figures.
    pub rows: Vec<R>,
}

/// What does not depend on what was measured.
pub type About = Record<serde::de::IgnoredAny>;

/// The head of a record.
pub fn about(json: &str) -> Result<About> {
    Ok(serde_json::from_str(json)?)
}

/// The rows of a record.
pub fn rows<R: DeserializeOwned>(json: &str) -> Result<Vec<R>> {
    Ok(serde_json::from_str::<Record<R>>(json)?.rows)
}

/// The page of a record: its title, what `tables` makes of the rows, and where they come from.
pub fn page<R: DeserializeOwned>(
    json: &str,
    title: &str,
    tables: fn(&[R]) -> String,
) -> Result<String> {
    let record: Record<R> = serde_json::from_str(json)?;
    let mut out = format!("# {title}\n{}\n{}", tables(&record.rows), source(&about(json)?));
    if !record.note.is_empty() {
        writeln!(out, "\n{}", record.note)?;
    }
    Ok(out)
}

/// Version, date, machine and command in one line.
pub fn source(about: &About) -> String {
    let About { version, date, machine, command, .. } = about;
    format!("fogbow {version}, {date}, {machine}: {command}\n")
}
