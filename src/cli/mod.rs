//! The command line: arguments to settings, settings to calls, exit codes.
//!
//! Results go to stdout, progress and messages to stderr. The exit code is 0, 1 (it failed) or 2
//! (misuse).

pub mod calls;
mod completions;
mod console;
mod error;
mod export;
mod film_args;
mod first_look;
mod fit;
mod frames;
mod header;
mod help;
mod info;
mod interrupt;
mod limit_args;
mod live;
mod load;
mod look;
mod make;
mod man;
mod maps;
mod memory;
mod memory_limit;
mod merge;
mod output;
mod pace;
mod partial;
mod photon_args;
mod picture;
mod picture_in_memory;
mod plan;
mod preview;
mod progress;
mod render;
mod render_args;
mod report;
mod save_photons;
mod sequence;
mod settings;
mod shared_photons;
mod study;
mod trial;
mod units;
mod verify;

use std::ffi::OsString;

use clap::error::ErrorKind;
use clap::{Parser, Subcommand};

use crate::error::Error;
use crate::image::PICTURE_DECODER;
use crate::scene::USD_READER;
use crate::shape::MESH_READER;

pub use maps::MapValues;
pub use picture_in_memory::PictureInMemory;
pub use shared_photons::SharedPhotons;

/// Volumetric photon-mapping renderer for OpenVDB smoke, fog and fire.
#[derive(Debug, Parser)]
#[command(
    name = "fogbow",
    version,
    about,
    max_term_width = 100,
    disable_help_subcommand = true,
    after_help = "fogbow help scene lists every key of a scene file. Times without a unit are in seconds, \
    sizes in bytes."
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
#[allow(clippy::large_enum_variant, reason = "there is one a process")]
enum Command {
    /// Render a scene, a shot (USD), or a VDB file alone, to an EXR with layers and a PNG beside it.
    Render(render_args::Args),
    /// Make the director's maps: where in the picture it pays to be accurate.
    Maps(maps::Args),
    /// Tell how far a picture is from its reference, by every metric.
    Error(error::Args),
    /// Tell what each way of rendering a scene costs in error and saves in time.
    Study(study::Args),
    /// Show people gold standard and directed picture, and count who can tell them apart.
    Trial(trial::Args),
    /// Tell what rendering a scene needs, what it leaves out, and what it should cost.
    Plan(plan::Args),
    /// Tell what is in a VDB file and what fogbow would do with it.
    Info(info::Args),
    /// Write what is understood of a shot (USD) as a scene with comments.
    Export(export::Args),
    /// Merge crops and passes that were rendered apart into one picture.
    Merge(merge::Args),
    /// Make procedural smoke, a cloud, fog or fire as a VDB file, or a statue as a mesh.
    Make(make::Args),
    /// Hold fogbow's figures against closed forms, published values and extremes.
    Verify(verify::Args),
    /// Print what a shell needs to complete commands and flags.
    Completions(completions::Args),
    /// Print the manual page, or write those of all commands.
    Man(man::Args),
    /// Print this, the help of a command, or with "scene" every key of a scene file.
    Help(help::Args),
}

/// Runs the program with its `arguments`, the first of which is its name, and returns its exit code.
pub fn main(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    hush_decoder();
    memory::give_freed_blocks_back();
    let arguments: Vec<_> = arguments.into_iter().collect();
    let command = command(&arguments);
    let cli = match Cli::try_parse_from(&arguments) {
        Ok(cli) => cli,
        Err(error) => match live::misplaced_word(&arguments) {
            Some(problem) if error.kind() == ErrorKind::UnknownArgument => {
                let usage = Error::Usage(problem);
                console::message(&format!("error: {usage}"));
                return usage.exit_code();
            }
            _ => error.exit(),
        },
    };
    let result = match &cli.command {
        Command::Render(args) => render::run(args),
        Command::Maps(args) => maps::run(args),
        Command::Error(args) => error::run(args),
        Command::Study(args) => study::run(args, &command),
        Command::Trial(args) => trial::run(args, &command),
        Command::Plan(args) => plan::run(args),
        Command::Info(args) => info::run(args),
        Command::Export(args) => export::run(args),
        Command::Merge(args) => merge::run(args),
        Command::Make(args) => make::run(args),
        Command::Verify(args) => verify::run(args),
        Command::Completions(args) => {
            completions::run(args);
            Ok(())
        }
        Command::Man(args) => man::run(args),
        Command::Help(args) => {
            help::run(args);
            Ok(())
        }
    };
    match result {
        Ok(()) => 0,
        Err(error) => {
            console::message(&format!("error: {error}"));
            error.exit_code()
        }
    }
}

/// The command as it was given by its `arguments`.
fn command(arguments: &[OsString]) -> String {
    let words =
        arguments.iter().skip(1).map(|word| word.to_string_lossy().into_owned()).map(|word| {
            if word.contains(char::is_whitespace) { format!("'{word}'") } else { word }
        });
    std::iter::once("fogbow".to_owned()).chain(words).collect::<Vec<_>>().join(" ")
}

/// Keeps panics over a damaged picture or mesh off stderr, where they come back as one error.
fn hush_decoder() {
    let print = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        if !matches!(
            std::thread::current().name(),
            Some(PICTURE_DECODER | MESH_READER | USD_READER)
        ) {
            print(info);
        }
    }));
}
