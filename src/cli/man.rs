//! `fogbow man`: manual pages.

use std::io::Write as _;
use std::path::PathBuf;

use clap::CommandFactory;
use clap_mangen::Man;

use super::{Cli, console};
use crate::error::{Error, Result};
use crate::file;

/// Arguments of `fogbow man`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// The folder for the pages of the program and of every command, as fogbow.1 and fogbow-render.1;
    /// it is made where it is missing. Without one the program's page is printed.
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
}

/// Prints the program's page, or writes all.
///
/// # Errors
/// Where a page cannot be written.
pub(super) fn run(args: &Args) -> Result<()> {
    let mut program = Cli::command();
    program.build();
    let Some(folder) = &args.output else {
        let page = page(&Man::new(program))?;
        console::result(String::from_utf8_lossy(&page).trim_end());
        return Ok(());
    };
    std::fs::create_dir_all(folder)
        .map_err(|e| Error::file(folder, format!("cannot be made: {e}; give a folder")))?;
    let commands = program.get_subcommands().cloned();
    for command in std::iter::once(program.clone()).chain(commands) {
        let man = Man::new(command);
        let path = folder.join(man.get_filename());
        let page = page(&man)?;
        file::write(&path, |out| out.write_all(&page))?;
        console::result(&path.display().to_string());
    }
    Ok(())
}

fn page(man: &Man) -> Result<Vec<u8>> {
    let mut page = Vec::new();
    man.render(&mut page).map_err(|e| Error::Failed(format!("no page can be made: {e}")))?;
    Ok(page)
}
