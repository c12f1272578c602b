//! Measures what fogbow's pages quote, and writes the pages.
//!
//!     cargo bench --bench results                                 # all, hours
//!     cargo bench --bench results -- --only director --only plan  # some
//!     cargo bench --bench results -- --quick                      # that it works: minutes
//!     cargo bench --bench results -- --render                     # no measuring, only pages
//!     cargo bench --bench results -- --scenes FOLDER              # those of `strategy`, as files
//!
//! Records and pages go to `tests/bench/results`, those of `--quick` to `target/results/quick`. What
//! is finished of a run that was cut short is kept in `target/results`, by version and command, and is
//! not measured again; with `--fresh` it is.

#![allow(clippy::print_stdout, clippy::print_stderr)] // progress, and what went wrong

mod measure;
mod pages;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use measure::{LeftOut, Measurement, forget, measurements, partial, write_scenes};
use pages::{PAGES, Places, Result};

/// What is asked on the command line.
#[derive(Default)]
struct Arguments {
    /// Names of measurements; all where there are none.
    only: Vec<String>,
    quick: bool,
    render: bool,
    fresh: bool,
    /// Where the scenes of `strategy` are written, and nothing else is done.
    scenes: Option<PathBuf>,
}

impl Arguments {
    fn parse(words: impl Iterator<Item = String>) -> Result<Self> {
        let mut arguments = Self::default();
        let mut words = words.filter(|word| word != "--bench"); // cargo's own
        while let Some(word) = words.next() {
            match word.as_str() {
                "--quick" => arguments.quick = true,
                "--render" => arguments.render = true,
                "--fresh" => arguments.fresh = true,
                "--scenes" => {
                    let folder = words.next().ok_or("--scenes wants a folder")?;
                    arguments.scenes = Some(folder.into());
                }
                "--only" => {
                    let name = words.next().ok_or("--only wants the name of a measurement")?;
                    if PAGES.iter().all(|page| page.name != name) {
                        let names = PAGES.map(|page| page.name).join(", ");
                        return Err(format!("--only {name} is unknown; there are {names}").into());
                    }
                    arguments.only.push(name);
                }
                _ => {
                    let known = "--only NAME, --quick, --render, --fresh and --scenes FOLDER";
                    return Err(format!("{word} is unknown; there are {known}").into());
                }
            }
        }
        Ok(arguments)
    }

    fn is_asked(&self, name: &str) -> bool {
        self.only.is_empty() || self.only.iter().any(|only| only == name)
    }
}

fn main() -> ExitCode {
    let arguments = match Arguments::parse(std::env::args().skip(1)) {
        Ok(arguments) => arguments,
        Err(error) => {
            eprintln!("error: {error}");
            return ExitCode::from(2);
        }
    };
    match run(&arguments) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Whether all that was asked for was measured or left out for want of something.
fn run(arguments: &Arguments) -> Result<bool> {
    if let Some(folder) = &arguments.scenes {
        write_scenes(folder)?;
        return Ok(true);
    }
    let target = std::env::var_os("CARGO_TARGET_DIR")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("target"), PathBuf::from)
        .join("results");
    let work = if arguments.quick { target.join("quick") } else { target };
    let places = if arguments.quick {
        Places { records: work.clone(), volumes: work.clone() }
    } else {
        Places::checked_in()
    };
    fs::create_dir_all(&work)?;
    let mut failed = false;
    if !arguments.render {
        let asked = measurements().into_iter().filter(|m| arguments.is_asked(m.name));
        let asked: Vec<Measurement> = asked.collect();
        for measurement in &asked {
            println!("{}", measurement.name);
            let kept = partial(&work, measurement.name);
            if arguments.fresh {
                forget(&kept);
            }
            let record = places.records.join(format!("{}.json", measurement.name));
            match (measurement.measure)(&kept, &record, arguments.quick) {
                Ok(()) => println!("  {}", record.display()),
                Err(error) if error.is::<LeftOut>() => {
                    println!("left out: {}: {error}", measurement.name);
                }
                Err(error) => {
                    eprintln!("error: {}: {error}", measurement.name);
                    failed = true;
                }
            }
        }
        if !failed {
            // The run is whole: the next one measures anew.
            for measurement in &asked {
                forget(&partial(&work, measurement.name));
            }
        }
    }
    for (path, text) in places.rendered()? {
        fs::write(&path, text).map_err(|e| format!("{}: {e}", path.display()))?;
        println!("{}", path.display());
    }
    Ok(!failed)
}
