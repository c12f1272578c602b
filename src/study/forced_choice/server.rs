//! A local server that shows the page and keeps the answers.

use std::collections::HashSet;
use std::fs::{File, OpenOptions};
use std::io::{Read, Write};
use std::net::Ipv4Addr;
use std::path::{Path, PathBuf};

use tiny_http::{Header, Method, Request, Response};

use super::answers::{Answer, AnswerKey, read_answers};
use super::page::{EXPERIMENT, PAGE};
use super::pair::Experiment;
use crate::error::{Error, Result};
use crate::file;

/// The file of answers beside the page.
pub const ANSWERS: &str = "answers.csv";

/// The most bytes of an answer that is sent.
const MAX_ANSWER: u64 = 4096;

/// The most bytes of a page.
const MAX_PAGE: u64 = 1 << 30;

/// Serves the page of a folder to this machine alone, and adds each answer to [`ANSWERS`].
pub struct Server {
    http: tiny_http::Server,
    port: u16,
    page: Vec<u8>,
    scenes: Vec<String>,
    answers: PathBuf,
    log: File,
    /// Keys of the answers stored.
    stored: HashSet<AnswerKey>,
}

/// A response: HTTP status and text. Without text the page is sent.
type Reply = (u16, String);

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
        let taken = |e| Error::Usage(format!("port {port} cannot be had: {e}; give another"));
        let http = tiny_http::Server::http((Ipv4Addr::LOCALHOST, port)).map_err(taken)?;
        let port = http.server_addr().to_ip().map_or(port, |address| address.port());
        let scenes = experiment.scenes.into_iter().map(|scene| scene.name).collect();
        Ok(Self { http, port, page, scenes, answers, log, stored })
    }

    /// Where the page is.
    pub fn url(&self) -> String {
        format!("http://127.0.0.1:{}/", self.port)
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
        while let Ok(mut request) = self.http.recv() {
            let (reply, failed) = match self.reply(&mut request) {
                Ok(reply) => (reply, None),
                Err(error) => ((500, error.to_string()), Some(error)),
            };
            self.send(request, reply);
            if let Some(error) = failed {
                return Err(error);
            }
        }
        Ok(())
    }

    fn reply(&mut self, request: &mut Request) -> Result<Reply> {
        if !self.is_local(request) {
            return Ok((403, "only this machine is answered".into()));
        }
        match (request.method(), request.url()) {
            (Method::Get | Method::Head, "/") => Ok((200, String::new())),
            (Method::Post, "/answers") => self.store(request),
            (_, "/" | "/answers") => Ok((405, "GET / or POST /answers".into())),
            _ => Ok((404, "there is / and /answers".into())),
        }
    }

    /// Whether the request is for this server by its own name: a foreign page cannot reach it
    /// through a name of its own that leads here.
    fn is_local(&self, request: &Request) -> bool {
        let names = ["127.0.0.1", "localhost"].map(|name| format!("{name}:{}", self.port));
        header(request, "Host").is_some_and(|host| names.contains(&host))
    }

    /// Stores the answer in a request.
    fn store(&mut self, request: &mut Request) -> Result<Reply> {
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

    /// Sends a reply, or the page where its text is empty. A browser that has closed the connection is no
    /// failure.
    fn send(&self, request: Request, (status, text): Reply) {
        let is_page = text.is_empty();
        let kind = if is_page { "text/html; charset=utf-8" } else { "text/plain; charset=utf-8" };
        let body = if is_page { self.page.clone() } else { text.into_bytes() };
        let mut response = Response::from_data(body).with_status_code(status);
        for (name, value) in [
            ("Content-Type", kind),
            ("X-Content-Type-Options", "nosniff"),
            ("Cache-Control", "no-store"),
        ] {
            if let Ok(header) = Header::from_bytes(name, value) {
                response.add_header(header);
            }
        }
        let _ = request.respond(response);
    }
}

impl std::fmt::Debug for Server {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Server").field("url", &self.url()).finish_non_exhaustive()
    }
}

fn header(request: &Request, name: &'static str) -> Option<String> {
    let found = request.headers().iter().find(|header| header.field.equiv(name));
    found.map(|header| header.value.as_str().to_ascii_lowercase())
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
