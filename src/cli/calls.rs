//! Commands as functions, for programs that hold scenes and pictures in memory. Arguments are words of the command line,
//! such as `--rays=8`; nothing is written that is not asked for, and reports are JSON.

use std::path::{Path, PathBuf};

use clap::{CommandFactory, Parser};

use super::maps::MapValues;
use super::picture_in_memory::{PictureInMemory, PictureRequest};
use super::shared_photons::SharedPhotons;
use super::{Cli, Command, error, hush_decoder, info, maps, memory, plan, render_args, study};
use crate::error::{Error, Result};
use crate::image::{Image, read_exr};
use crate::render::{Progress, Stop};
use crate::scene::OpenScene;

/// Flags that say where a picture goes, how it is shown meanwhile and what is printed: in memory it does neither.
const OF_THE_PROGRAM: [&str; 20] = [
    "any-camera",
    "checkpoint",
    "empty",
    "frames",
    "help",
    "json",
    "missing",
    "photons-to",
    "plan",
    "preview",
    "quiet",
    "resume",
    "tev",
    "verbose",
    "view",
    "write-scene",
    "z",
    "output",
    "set",
    "version",
];

/// Flags of studies that are left out of [`OF_THE_PROGRAM`]: a study is a folder.
const OF_A_STUDY: &str = "resume";

/// The name of a picture that has no file, in messages.
const IN_MEMORY: &str = "picture in memory";

/// A flag of a command.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Flag {
    /// Its name without dashes before it.
    pub name: String,
    /// Whether it has a value.
    pub has_value: bool,
    /// What it means, in a sentence.
    pub help: String,
}

/// Prepares the process, as the program does when it starts.
pub fn prepare() {
    hush_decoder();
    memory::give_freed_blocks_back();
}

/// The flags that [`render`], [`plan()`], [`maps()`], [`study()`] and [`compare`] take, by the command's name.
pub fn flags(command: &str) -> Vec<Flag> {
    let program = Cli::command();
    let found = program.find_subcommand(command);
    let is_for_programs =
        |name: &str| !OF_THE_PROGRAM.contains(&name) || (command == "study" && name == OF_A_STUDY);
    let flag = |arg: &clap::Arg| {
        let name = arg.get_long().filter(|name| is_for_programs(name))?.to_owned();
        let has_value = arg.get_action().takes_values();
        let help = arg.get_help().map(ToString::to_string).unwrap_or_default();
        Some(Flag { name, has_value, help })
    };
    found.into_iter().flat_map(clap::Command::get_arguments).filter_map(flag).collect()
}

/// Parses the arguments of `command`, which are `words` behind the `positional` ones.
fn parse(command: &str, positional: &[&str], words: &[String]) -> Result<Command> {
    let words = words.iter().map(String::as_str);
    let arguments = ["fogbow", command].into_iter().chain(positional.iter().copied()).chain(words);
    let wrong = |e: clap::Error| {
        let text = e.render().to_string();
        let lines: Vec<_> =
            text.lines().take_while(|line| !line.is_empty()).map(str::trim).collect();
        let text = lines.join(" ");
        Error::Usage(text.strip_prefix("error: ").unwrap_or(&text).to_owned())
    };
    Ok(Cli::try_parse_from(arguments).map_err(wrong)?.command)
}

fn other(command: &str) -> Error {
    Error::Usage(format!("{command} is another command"))
}

/// The arguments of a picture that is rendered in memory.
fn picture(words: &[String]) -> Result<render_args::Args> {
    match parse("render", &["scene", "--quiet", "--output=memory.exr"], words)? {
        Command::Render(args) => Ok(args),
        _ => Err(other("render")),
    }
}

/// Renders the scene `open`, of a sequence the `frame`, as `fogbow render` does. `progress` may end it by a panic.
///
/// # Errors
/// As the command.
pub fn render(
    open: &mut OpenScene,
    frame: Option<f64>,
    words: &[String],
    shared: &mut SharedPhotons,
    progress: &dyn Progress,
    stop: &Stop,
) -> Result<PictureInMemory> {
    let args = picture(words)?;
    PictureRequest { args: &args, frame, progress, stop }.render(open, shared)
}

/// Loads the scene `open` under the settings `words`, so that renders find its grids read.
///
/// # Errors
/// As `fogbow render`.
pub fn load(open: &mut OpenScene, frame: Option<f64>, words: &[String]) -> Result<()> {
    let args = picture(words)?;
    PictureRequest::load(&args, frame, open).map(drop)
}

/// Finds which of the pictures with these `settings` of the scene `open` have the same photons.
///
/// # Errors
/// As `fogbow render`.
pub fn share_photons(
    open: &mut OpenScene,
    settings: &[(Option<f64>, Vec<String>)],
) -> Result<SharedPhotons> {
    let mut shared = SharedPhotons::default();
    for (frame, words) in settings {
        let args = picture(words)?;
        let (scene, ..) = PictureRequest::load(&args, *frame, open)?;
        shared.expect(&args, &scene);
    }
    Ok(shared)
}

/// What `fogbow plan` tells of the scene `open`, as JSON.
///
/// # Errors
/// As the command.
pub fn plan(open: &mut OpenScene, words: &[String]) -> Result<String> {
    match parse("plan", &["scene", "--quiet", "--json"], words)? {
        Command::Plan(args) => plan::report(&args, open),
        _ => Err(other("plan")),
    }
}

/// The maps that `fogbow maps` writes of the scene `open`.
///
/// # Errors
/// As the command.
pub fn maps(open: &mut OpenScene, words: &[String]) -> Result<Vec<MapValues>> {
    match parse("maps", &["scene", "--quiet", "--output=."], words)? {
        Command::Maps(args) => maps::values(&args, open),
        _ => Err(other("maps")),
    }
}

/// Studies the scene `open` as `fogbow study` does, with the report in `folder`. Returns what that tells, as JSON.
/// `progress` may end it by a panic.
///
/// # Errors
/// As the command.
pub fn study(
    open: &mut OpenScene,
    folder: &Path,
    words: &[String],
    progress: &dyn Progress,
) -> Result<String> {
    let folder = format!("--output={}", folder.display());
    match parse("study", &["scene", "--quiet", "--json", &folder], words)? {
        Command::Study(args) => {
            study::report(&args, open, &format!("fogbow study {}", words.join(" ")), progress)
        }
        _ => Err(other("study")),
    }
}

/// What `fogbow info` tells of the VDB file `path`, as JSON.
///
/// # Errors
/// As the command.
pub fn info(path: &Path) -> Result<String> {
    info::told(&info::Args { file: path.to_path_buf(), json: true })
}

/// A picture to compare.
#[derive(Debug)]
pub enum Compared {
    /// That of an EXR file.
    File(PathBuf),
    /// One in memory.
    Image(Image),
}

impl Compared {
    fn name(&self) -> &str {
        match self {
            Self::File(path) => path.to_str().unwrap_or(IN_MEMORY),
            Self::Image(_) => IN_MEMORY,
        }
    }

    fn read(&self) -> Result<Image> {
        match self {
            Self::File(path) => read_exr(path),
            Self::Image(image) => Ok(image.clone()),
        }
    }
}

/// What `fogbow error` tells of two pictures, as JSON.
///
/// # Errors
/// As the command.
pub fn compare(reference: &Compared, test: &Compared, words: &[String]) -> Result<String> {
    match parse("error", &[reference.name(), test.name(), "--json"], words)? {
        Command::Error(args) => error::told(&args, &reference.read()?, &test.read()?),
        _ => Err(other("error")),
    }
}
