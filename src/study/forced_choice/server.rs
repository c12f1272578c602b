//! A local server that shows the page and keeps the answers.

use std::collections::HashSet;
use std::fs::{File, OpenOptions};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use tiny_http::{Method, Request};

use super::answers::{Answer, AnswerKey, read_answers};
use super::page::{EXPERIMENT, PAGE};
use super::pair::Experiment;
use crate::error::{Error, Result};
use crate::file;
use crate::loopback::{Loopback, Reply, header, send};

/// The file of answers beside the page.
pub const ANSWERS: &str = "answers.csv";

/// The most bytes of an answer that is sent.
const MAX_ANSWER: u64 = 4096;

/// The most bytes of a page.
const MAX_PAGE: u64 = 1 << 30;

/// How long a request is waited for before the next try: any time does.
const PATIENCE: Duration = Duration::from_secs(3600);

/// Serves the page of a folder to this machine alone, and adds each answer to [`ANSWERS`].
pub struct Server {
    http: Loopback,
    page: Vec<u8>,
    scenes: Vec<String>,
    answers: PathBuf,
    log: File,
    /// Keys of the answers stored.
    stored: HashSet<AnswerKey>,
}

impl Server {
    /// Opens `port` of 127.0.0.1, any free one for 0, for what [`write_trial`](super::write_trial)
    /// wrote to `folder`.
    ///
    /// # Errors
    /// Where there is no trial in the folder, earlier answers in it are damaged or cannot be added
    /// to, or the port cannot be had.
    pub fn bind(folder: &Path, port: u16) -> Result<Self> {
        let beside = folder.join(EXPERIMENT);
        let unknown = |e| Error::file(&beside, format!("is no trial: {e}; make it anew"));
        let experiment: Experiment =
            serde_json::from_slice(&file::read(&beside, MAX_PAGE)?).map_err(unknown)?;
        let page = file::read(&folder.join(PAGE), MAX_PAGE)?;
        let answers = folder.join(ANSWERS);
        let (log, stored) = open_answers(&answers)?;
        let http = Loopback::bind(port)?;
        let scenes = experiment.scenes.into_iter().map(|scene| scene.name).collect();
        Ok(Self { http, page, scenes, answers, log, stored })
    }

    /// Where the page is.
    pub fn url(&self) -> String {
        self.http.url()
    }

    /// The file of answers.
    pub fn answers(&self) -> &Path {
        &self.answers
    }

    /// Serves until the process ends or an answer cannot be stored.
    ///
    /// # Errors
    /// Where an answer cannot be stored; the participant gets the message too.
    pub fn run(mut self) -> Result<()> {
        while let Ok(request) = self.http.receive(PATIENCE) {
            let Some(mut request) = request else { continue };
            let (reply, failed) = match self.reply(&mut request) {
                Ok(reply) => (reply, None),
                Err(error) => (Reply::text(500, error.to_string()), Some(error)),
            };
            send(request, reply);
            if let Some(error) = failed {
                return Err(error);
            }
        }
        Ok(())
    }

    fn reply(&mut self, request: &mut Request) -> Result<Reply> {
        match (request.method(), request.url()) {
            (Method::Get | Method::Head, "/") => Ok(Reply::page(self.page.clone())),
            (Method::Post, "/answers") => {
                self.store(request).map(|(status, text)| Reply::text(status, text))
            }
            (_, "/" | "/answers") => Ok(Reply::text(405, "GET / or POST /answers")),
            _ => Ok(Reply::text(404, "there is / and /answers")),
        }
    }

    /// Stores the answer in a request. Returns HTTP status and text.
    fn store(&mut self, request: &mut Request) -> Result<(u16, String)> {
        // A foreign page cannot send this type without asking first, and is not answered then.
        let is_json = header(request, "Content-Type").is_some_and(|t| t == "application/json");
        if !is_json {
            return Ok((415, "an answer is application/json".into()));
        }
        let mut bytes = Vec::new();
        let read = request.as_reader().take(MAX_ANSWER + 1).read_to_end(&mut bytes);
        if read.is_err() || bytes.len() as u64 > MAX_ANSWER {
            return Ok((413, format!("an answer has at most {MAX_ANSWER} bytes")));
        }
        let answer: Answer = match serde_json::from_slice(&bytes) {
            Ok(answer) => answer,
            Err(e) => return Ok((400, format!("is no answer: {e}"))),
        };
        if let Err(problem) = answer.check() {
            return Ok((400, problem));
        }
        if !self.scenes.contains(&answer.scene) {
            return Ok((400, format!("there is no scene \"{}\"", answer.scene)));
        }
        if self.stored.contains(&answer.key()) {
            return Ok((409, "this answer was given already".into()));
        }
        let row = row(&answer).map_err(|e| unwritable(&self.answers, &e))?;
        append(&mut self.log, &row).map_err(|e| unwritable(&self.answers, &e))?;
        self.stored.insert(answer.key());
        Ok((200, "stored".into()))
    }
}

impl std::fmt::Debug for Server {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Server").field("http", &self.http).finish_non_exhaustive()
    }
}

/// Opens a file of answers for appending; also the keys of the answers in it.
fn open_answers(path: &Path) -> Result<(File, HashSet<AnswerKey>)> {
    let there = path.metadata().is_ok_and(|about| about.len() > 0);
    let earlier = if there { read_answers(&[path.to_path_buf()])? } else { Vec::new() };
    let mut log = OpenOptions::new()
        .create(true)
        .append(true)
        .open(path)
        .map_err(|e| unwritable(path, &e))?;
    let bytes = if there { file::read(path, MAX_PAGE)? } else { Vec::new() };
    let start = if bytes.is_empty() {
        format!("{}\n", super::COLUMNS.join(","))
    } else if check_columns(&bytes) {
        // A spreadsheet may have left out the last line's end.
        if bytes.ends_with(b"\n") { String::new() } else { "\n".into() }
    } else {
        let problem = format!("has other columns than {}", super::COLUMNS.join(","));
        return Err(Error::file(path, format!("{problem}; move it away")));
    };
    append(&mut log, start.as_bytes()).map_err(|e| unwritable(path, &e))?;
    Ok((log, earlier.iter().map(Answer::key).collect()))
}

/// Whether the first line has the columns that rows are written with.
fn check_columns(bytes: &[u8]) -> bool {
    let first = bytes.split(|b| *b == b'\n').next().unwrap_or_default();
    first.trim_ascii() == super::COLUMNS.join(",").as_bytes()
}

/// One row with its line end.
fn row(answer: &Answer) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
    writer.serialize(answer)?;
    writer.into_inner().map_err(|e| e.into_error().into())
}

/// Adds bytes at once and waits until they are on disk.
fn append(log: &mut File, bytes: &[u8]) -> std::io::Result<()> {
    log.write_all(bytes)?;
    log.sync_data()
}

fn unwritable(path: &Path, problem: &dyn std::fmt::Display) -> Error {
    Error::file(path, format!("cannot be written: {problem}"))
}
