//! The files of a study: each run is stored before the next begins.
//!
//! `study.json` is the header; [`RUNS`] has one run a line, added once its EXR is complete. Whenever a study
//! is killed, only the run under way is lost.

use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::candidate::Settings;
use super::job::{Costs, Job, Run};
use super::machine::Machine;
use super::plan::Plan;
use super::request::Request;
use super::results::SCHEMA;
use crate::error::{Error, Result};
use crate::file;
use crate::image::{Film, write_exr};
use crate::scene::Scene;

/// The file of runs, one JSON object a line.
pub const RUNS: &str = "trials.jsonl";

const STUDY: &str = "study.json";

/// The header of a study: what it compares, where, and how.
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
    /// `None` until it is chosen.
    pub(super) plan: Option<Plan>,
    /// Costs of single renders, for a study bounded by time.
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

    /// The first field in which the stored header of a study differs from `self`, as a sentence.
    fn differs_in(&self, stored: &Self) -> Option<String> {
        let difference = |name: &str, stored: &dyn std::fmt::Debug, asked: &dyn std::fmt::Debug| {
            let (stored, asked) = (format!("{stored:?}"), format!("{asked:?}"));
            (stored != asked).then(|| format!("its {name} is {stored}, now it is {asked}"))
        };
        difference("schema", &stored.schema, &self.schema)
            .or_else(|| difference("fogbow version", &stored.version, &self.version))
            .or_else(|| difference("scene hash", &stored.hash, &self.hash))
            .or_else(|| difference("size", &stored.size, &self.size))
            .or_else(|| difference("seed", &stored.seed, &self.seed))
            .or_else(|| difference("render settings", &stored.gold, &self.gold))
            .or_else(|| difference("machine", &stored.machine, &self.machine))
            .or_else(|| difference("request", &what_of(&stored.request), &what_of(&self.request)))
    }
}

/// The folder of a study.
#[derive(Debug)]
pub(super) struct Store {
    folder: PathBuf,
    pub(super) header: Header,
    runs: BTreeMap<Key, Run>,
    log: File,
}

/// Candidate, point, round, and whether the march step is the finest.
type Key = (String, usize, u32, bool);

fn key(run: Run) -> (Key, Run) {
    ((run.candidate.clone(), run.point, run.round, run.finest_step), run)
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
        let log_path = folder.join(RUNS);
        let (runs, sound) = if there { read_runs(&log_path)? } else { (Vec::new(), 0) };
        let log = OpenOptions::new()
            .create(true)
            .append(true)
            .open(&log_path)
            .map_err(|e| unwritable(&log_path, &e))?;
        // Drops what a killed study left of its last line.
        log.set_len(sound).map_err(|e| unwritable(&log_path, &e))?;
        let runs =
            runs.into_iter().filter(|t: &Run| folder.join(&t.exr).is_file()).map(key).collect();
        let store = Self { folder: folder.to_path_buf(), header, runs, log };
        store.write_header()?;
        Ok(store)
    }

    /// The run of `job`, where there is one.
    pub(super) fn find(&self, job: &Job) -> Option<&Run> {
        self.runs.get(&(job.candidate.to_owned(), job.point, job.round, job.finest_step))
    }

    /// Number of rounds with a run.
    pub(super) fn rounds(&self) -> u32 {
        self.runs.values().map(|run| run.round + 1).max().unwrap_or(0)
    }

    /// Number of runs.
    pub(super) fn len(&self) -> usize {
        self.runs.len()
    }

    /// Stores a run: first its picture, then its line.
    pub(super) fn add(&mut self, run: Run, film: &Film) -> Result<()> {
        let path = self.folder.join(RUNS);
        let settings = [
            ("fogbow:version", self.header.version.clone()),
            ("fogbow:scene", self.header.hash.clone()),
            ("fogbow:candidate", run.candidate.clone()),
            ("fogbow:point", run.point.to_string()),
            ("fogbow:seed", run.seed.to_string()),
        ];
        write_exr(&self.folder.join(&run.exr), film, &settings)?;
        let mut line = serde_json::to_vec(&run).map_err(|e| unwritable(&path, &e))?;
        line.push(b'\n');
        self.log
            .write_all(&line)
            .and_then(|()| self.log.sync_data())
            .map_err(|e| unwritable(&path, &e))?;
        self.runs.extend([key(run)]);
        Ok(())
    }

    /// Stores the plan, and the costs where they are known.
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

/// A request without its amount of work, which a resumed study may raise.
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

/// The runs of a log, and the length of its whole lines. Only the last can be torn.
fn read_runs(path: &Path) -> Result<(Vec<Run>, u64)> {
    if !path.exists() {
        return Ok((Vec::new(), 0));
    }
    let mut bytes = fs::read(path).map_err(|e| unreadable(path, &e))?;
    bytes.truncate(bytes.iter().rposition(|&b| b == b'\n').map_or(0, |end| end + 1));
    let lines = bytes.split(|&b| b == b'\n').enumerate().filter(|(_, line)| !line.is_empty());
    let parse = |(number, line): (usize, &[u8])| {
        serde_json::from_slice(line).map_err(|e| {
            Error::file(path, format!("line {} is no run: {e}; delete the line", number + 1))
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
