//! A study on disk: every trial is there before the next begins.
//!
//! `study.json` says what the study is of; [`TRIALS`] has one trial a line, added once its EXR is
//! whole. Whatever moment a study is killed at, all but the trial under way is kept.

use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::candidate::Settings;
use super::job::{Costs, Job};
use super::machine::Machine;
use super::plan::Plan;
use super::request::Request;
use super::results::SCHEMA;
use super::trial::Trial;
use crate::error::{Error, Result};
use crate::file;
use crate::image::{Film, write_exr};
use crate::scene::Scene;

/// The file of trials, one JSON object a line.
pub const TRIALS: &str = "trials.jsonl";

const STUDY: &str = "study.json";

/// What a study is of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Header {
    pub(super) schema: u32,
    pub(super) version: String,
    pub(super) scene: PathBuf,
    pub(super) hash: String,
    pub(super) size: [u32; 2],
    pub(super) seed: u64,
    pub(super) gold: Settings,
    pub(super) machine: Machine,
    pub(super) request: Request,
    /// Nothing until it is chosen.
    pub(super) plan: Option<Plan>,
    /// What renders take, where that was asked for.
    pub(super) costs: Option<Costs>,
}

impl Header {
    pub(super) fn new(scene: &Scene, request: &Request) -> Self {
        Self {
            schema: SCHEMA,
            version: env!("CARGO_PKG_VERSION").into(),
            scene: scene.path.clone(),
            hash: scene.hash.clone(),
            size: scene.film.size,
            seed: scene.render.seed,
            gold: Settings::from(&scene.render),
            machine: Machine::here(),
            request: request.clone(),
            plan: None,
            costs: None,
        }
    }

    /// The first thing in which a study on disk is another one than `self`.
    fn differs_in(&self, stored: &Self) -> Option<String> {
        let told = |name: &str, stored: &dyn std::fmt::Debug, asked: &dyn std::fmt::Debug| {
            let (stored, asked) = (format!("{stored:?}"), format!("{asked:?}"));
            (stored != asked).then(|| format!("its {name} is {stored}, now it is {asked}"))
        };
        told("schema", &stored.schema, &self.schema)
            .or_else(|| told("fogbow version", &stored.version, &self.version))
            .or_else(|| told("scene hash", &stored.hash, &self.hash))
            .or_else(|| told("size", &stored.size, &self.size))
            .or_else(|| told("seed", &stored.seed, &self.seed))
            .or_else(|| told("render settings", &stored.gold, &self.gold))
            .or_else(|| told("machine", &stored.machine, &self.machine))
            .or_else(|| told("request", &what_of(&stored.request), &what_of(&self.request)))
    }
}

/// The folder of a study.
#[derive(Debug)]
pub(super) struct Store {
    folder: PathBuf,
    pub(super) header: Header,
    trials: BTreeMap<Key, Trial>,
    log: File,
}

/// Candidate, point, round, and whether the march step is the finest.
type Key = (String, usize, u32, bool);

fn key(trial: Trial) -> (Key, Trial) {
    ((trial.candidate.clone(), trial.point, trial.round, trial.finest_step), trial)
}

impl Store {
    /// Begins a study in `folder`, or with `resume` goes on with the one that lies there.
    ///
    /// # Errors
    /// Where the folder cannot be used, holds a study that was not to be resumed, or one of
    /// something else.
    pub(super) fn open(folder: &Path, header: Header, resume: bool) -> Result<Self> {
        let path = folder.join(STUDY);
        let there = path.exists();
        if there && !resume {
            return Err(Error::file(
                folder,
                "holds a study already; go on with it by --resume, or name another folder",
            ));
        }
        let header = if there { stored(&path, &header)? } else { header };
        fs::create_dir_all(folder.join("exr")).map_err(|e| unwritable(folder, &e))?;
        let log_path = folder.join(TRIALS);
        let (trials, sound) = if there { read_trials(&log_path)? } else { (Vec::new(), 0) };
        let log = OpenOptions::new()
            .create(true)
            .append(true)
            .open(&log_path)
            .map_err(|e| unwritable(&log_path, &e))?;
        // What a killed study left of its last line.
        log.set_len(sound).map_err(|e| unwritable(&log_path, &e))?;
        let trials =
            trials.into_iter().filter(|t: &Trial| folder.join(&t.exr).is_file()).map(key).collect();
        let store = Self { folder: folder.to_path_buf(), header, trials, log };
        store.write_header()?;
        Ok(store)
    }

    /// The trial that `job` asks for, where it is done.
    pub(super) fn find(&self, job: &Job) -> Option<&Trial> {
        self.trials.get(&(job.candidate.to_owned(), job.point, job.round, job.finest_step))
    }

    /// How many rounds are begun.
    pub(super) fn rounds(&self) -> u32 {
        self.trials.values().map(|trial| trial.round + 1).max().unwrap_or(0)
    }

    /// How many trials are done.
    pub(super) fn len(&self) -> usize {
        self.trials.len()
    }

    /// Writes the picture, then the line of a finished trial.
    pub(super) fn add(&mut self, trial: Trial, film: &Film) -> Result<()> {
        let path = self.folder.join(TRIALS);
        let settings = [
            ("fogbow:version", self.header.version.clone()),
            ("fogbow:scene", self.header.hash.clone()),
            ("fogbow:candidate", trial.candidate.clone()),
            ("fogbow:point", trial.point.to_string()),
            ("fogbow:seed", trial.seed.to_string()),
        ];
        write_exr(&self.folder.join(&trial.exr), film, &settings)?;
        let mut line = serde_json::to_vec(&trial).map_err(|e| unwritable(&path, &e))?;
        line.push(b'\n');
        self.log
            .write_all(&line)
            .and_then(|()| self.log.sync_data())
            .map_err(|e| unwritable(&path, &e))?;
        self.trials.extend([key(trial)]);
        Ok(())
    }

    /// Settles what is going to be rendered, and what that takes where it is known.
    pub(super) fn settle(&mut self, plan: Plan, costs: Option<Costs>) -> Result<()> {
        self.header.plan = Some(plan);
        self.header.costs = costs;
        self.write_header()
    }

    fn write_header(&self) -> Result<()> {
        let path = self.folder.join(STUDY);
        let text = serde_json::to_vec_pretty(&self.header).map_err(|e| unwritable(&path, &e))?;
        file::write(&path, |out| out.write_all(&text))
    }

    pub(super) fn folder(&self) -> &Path {
        &self.folder
    }
}

/// A request but for how much is rendered, of which there may be more.
fn what_of(request: &Request) -> Request {
    Request { seeds: 0, seconds: None, ..request.clone() }
}

/// The header on disk, if it is of the study that `asked` is of.
fn stored(path: &Path, asked: &Header) -> Result<Header> {
    let text = fs::read_to_string(path).map_err(|e| unreadable(path, &e))?;
    let stored: Header = serde_json::from_str(&text).map_err(|e| unreadable(path, &e))?;
    match asked.differs_in(&stored) {
        None => Ok(Header { request: asked.request.clone(), ..stored }),
        Some(difference) => Err(Error::file(
            path,
            format!("is of another study: {difference}; ask for the same, or name another folder"),
        )),
    }
}

/// The trials of a log, and the length of its whole lines. Only the last can be torn.
fn read_trials(path: &Path) -> Result<(Vec<Trial>, u64)> {
    if !path.exists() {
        return Ok((Vec::new(), 0));
    }
    let mut bytes = fs::read(path).map_err(|e| unreadable(path, &e))?;
    bytes.truncate(bytes.iter().rposition(|&b| b == b'\n').map_or(0, |end| end + 1));
    let lines = bytes.split(|&b| b == b'\n').enumerate().filter(|(_, line)| !line.is_empty());
    let parse = |(number, line): (usize, &[u8])| {
        serde_json::from_slice(line).map_err(|e| {
            Error::file(path, format!("line {} is no trial: {e}; delete the line", number + 1))
        })
    };
    Ok((lines.map(parse).collect::<Result<_>>()?, bytes.len() as u64))
}

fn unwritable(path: &Path, problem: &dyn std::fmt::Display) -> Error {
    Error::file(path, format!("cannot be written: {problem}"))
}

fn unreadable(path: &Path, problem: &dyn std::fmt::Display) -> Error {
    Error::file(path, format!("cannot be read: {problem}; name another folder"))
}
