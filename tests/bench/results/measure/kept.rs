//! Rows of a run, part by part, so that it can be cut short and taken up.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use fogbow::study::Machine;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::pages::Result;
use crate::pages::record::Record;

/// What is measured so far.
pub struct Kept<R> {
    path: PathBuf,
    state: State<R>,
}

#[derive(Serialize, Deserialize)]
struct State<R> {
    version: String,
    command: String,
    date: String,
    parts: Vec<Part<R>>,
    /// Sentences.
    notes: Vec<String>,
}

#[derive(Serialize, Deserialize)]
struct Part<R> {
    name: String,
    rows: Vec<R>,
}

/// Where the parts of a measurement are kept.
pub fn partial(folder: &Path, name: &str) -> PathBuf {
    folder.join(format!("{name}.partial.json"))
}

/// Removes what is kept there, where anything is.
pub fn forget(partial: &Path) {
    let _ = fs::remove_file(partial);
    let _ = fs::remove_dir_all(partial.with_extension(""));
}

impl<R: Serialize + DeserializeOwned> Kept<R> {
    /// What is kept of the same command and version; nothing of any other.
    pub fn open(path: &Path, command: &str) -> Self {
        let version = env!("CARGO_PKG_VERSION");
        let kept = fs::read(path).ok().and_then(|json| serde_json::from_slice(&json).ok());
        let same = |state: &State<R>| state.version == version && state.command == command;
        let state = kept.filter(same).unwrap_or_else(|| State {
            version: version.into(),
            command: command.into(),
            date: today(),
            parts: Vec::new(),
            notes: Vec::new(),
        });
        Self { path: path.into(), state }
    }

    /// Measures a part unless it is kept, and keeps it.
    pub fn part(&mut self, name: &str, measure: impl FnOnce() -> Result<Vec<R>>) -> Result<()> {
        if self.state.parts.iter().any(|part| part.name == name) {
            println!("  {name}: kept");
            return Ok(());
        }
        println!("  {name}");
        let rows = measure()?;
        self.state.parts.push(Part { name: name.into(), rows });
        self.state.date = today();
        self.save()
    }

    /// Tells on the page what else holds for this run.
    pub fn note(&mut self, sentence: impl Into<String>) {
        let sentence = sentence.into();
        if !self.state.notes.contains(&sentence) {
            self.state.notes.push(sentence);
        }
    }

    /// A folder for what a part keeps itself.
    pub fn folder(&self, part: &str) -> PathBuf {
        self.path.with_extension("").join(part)
    }

    /// A folder beside, for what further runs use again.
    pub fn lasting(&self, name: &str) -> PathBuf {
        self.path.with_file_name(name)
    }

    /// All parts as a record.
    pub fn record(self, name: &str) -> Record<R> {
        let State { version, command, date, parts, notes } = self.state;
        Record {
            name: name.into(),
            version,
            machine: Machine::here().to_string(),
            date,
            command,
            note: notes.join(" "),
            rows: parts.into_iter().flat_map(|part| part.rows).collect(),
        }
    }

    /// Under another name first, so that no kill leaves half of it.
    fn save(&self) -> Result<()> {
        let beside = self.path.with_extension("new");
        fs::write(&beside, serde_json::to_vec(&self.state)?)?;
        Ok(fs::rename(&beside, &self.path)?)
    }
}

/// As year-month-day.
fn today() -> String {
    let now = humantime::format_rfc3339_seconds(SystemTime::now()).to_string();
    now.split('T').next().unwrap_or_default().to_owned()
}
