//! Opens USD stages.

use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};

use openusd::usd::Stage;
use tempfile::TempDir;

use super::layers::Layers;
use super::package;
use crate::error::{Error, Result};
use crate::scene::reader::one_line;

/// The name of the thread that reads USD files. A damaged file can make the crate panic; that ends this
/// thread and is reported as an error, so that its message on stderr may be left out.
pub const USD_READER: &str = "USD reader";

/// Stack of that thread, in bytes: composition calls itself for each arc and level.
const STACK: usize = 256 << 20;

/// Most characters of a message of the crate.
const MAX_MESSAGE: usize = 400;

/// What is read of a stage, or why it cannot be opened.
type Task = Box<dyn FnOnce(Result<&Stage, &str>) + Send>;

/// A USD file; a package is unpacked into a folder that lasts as long as this. The stage is opened once, where it
/// is first read.
#[derive(Debug)]
pub(super) struct Root {
    /// The file as the user named it.
    pub(super) path: PathBuf,
    /// The layer to open.
    layer: PathBuf,
    /// Where a package was unpacked.
    folder: Option<Arc<TempDir>>,
    /// To the thread that holds the stage.
    tasks: Mutex<Option<Sender<Task>>>,
}

impl Root {
    /// The file `path`.
    ///
    /// # Errors
    /// Where it cannot be read, or is a package that cannot be unpacked.
    pub(super) fn open(path: &Path) -> Result<Self> {
        let mut file = crate::file::open(path)?;
        let mut magic = [0; 2];
        let is_package = file.read_exact(&mut magic).is_ok() && package::is_package(&magic);
        let tasks = Mutex::new(None);
        if !is_package {
            return Ok(Self { path: path.into(), layer: path.into(), folder: None, tasks });
        }
        let wrong = |problem: String| Error::file(path, one_line(&problem));
        let folder = TempDir::with_prefix("fogbow-usdz-")
            .map_err(|e| wrong(format!("cannot be unpacked: {e}")))?;
        let layer = package::unpack(path, folder.path()).map_err(wrong)?;
        Ok(Self { path: path.into(), layer, folder: Some(Arc::new(folder)), tasks })
    }

    /// The folder into which it was unpacked, where it is a package.
    pub(super) fn folder(&self) -> Option<Arc<TempDir>> {
        self.folder.clone()
    }

    /// What `read` finds on the stage.
    ///
    /// # Errors
    /// Where the file or one that it asks for cannot be read, or `read` fails.
    pub(super) fn read<T: Send + 'static>(
        &self,
        read: impl FnOnce(&Stage) -> Result<T> + Send + 'static,
    ) -> Result<T> {
        let (path, folder) = (self.path.clone(), self.folder.clone());
        let wrong = move |problem: &str| {
            // Paths in a package, as messages of the crate have them.
            let unpacked = folder.as_ref().map(|folder| format!("{}/", folder.path().display()));
            let problem = unpacked.map_or(problem.into(), |folder| problem.replace(&folder, ""));
            Error::file(&path, shortened(&problem))
        };
        let (answer, found) = channel();
        let say = wrong.clone();
        let task: Task = Box::new(move |stage| {
            let found = stage.map_err(&say).and_then(|stage| {
                let found = read(stage);
                // Files that prims refer to are opened where the prims are asked for.
                match stage.composition_errors().first() {
                    Some(problem) => Err(say(&problem.to_string())),
                    None => found,
                }
            });
            // Where it fails, nobody waits for the answer.
            let _ = answer.send(found);
        });
        let tasks = self.tasks().map_err(|problem| wrong(&problem))?;
        let damaged = || wrong("is damaged: its numbers cannot be");
        tasks.send(task).map_err(|_| damaged())?;
        found.recv().unwrap_or_else(|_| Err(damaged()))
    }

    /// The way to the thread that holds the stage.
    fn tasks(&self) -> Result<Sender<Task>, String> {
        let mut tasks = self.tasks.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(tasks) = &*tasks {
            return Ok(tasks.clone());
        }
        let (sender, receiver) = channel();
        let layer = self.layer.clone();
        std::thread::Builder::new()
            .name(USD_READER.into())
            .stack_size(STACK)
            .spawn(move || serve(&layer, &receiver))
            .map_err(|e| format!("cannot be read: {e}"))?;
        Ok(tasks.insert(sender).clone())
    }
}

/// Opens the stage of `layer` and does `tasks` with it, until there can be no more.
fn serve(layer: &Path, tasks: &Receiver<Task>) {
    let name = layer.to_str().ok_or_else(|| "has no name in UTF-8".to_owned());
    let stage = name.and_then(|name| {
        Stage::builder().resolver(Layers::default()).open(name).map_err(|e| format!("{e:#}"))
    });
    for task in tasks {
        task(stage.as_ref().map_err(String::as_str));
    }
}

/// `message` in one line, cut where it is long.
fn shortened(message: &str) -> String {
    let line = one_line(message);
    match line.char_indices().nth(MAX_MESSAGE) {
        Some((end, _)) => format!("{}...", &line[..end]),
        None => line,
    }
}
