//! `fogbow completions`: what a shell needs to complete commands and flags.

use clap::CommandFactory;
use clap_complete::{Shell, generate};

use super::{Cli, console};

/// Arguments of `fogbow completions`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "bash: fogbow completions bash > ~/.local/share/bash-completion/completions/fogbow\n\
    zsh: fogbow completions zsh > DIR/_fogbow, where DIR is in $fpath\n\
    fish: fogbow completions fish > ~/.config/fish/completions/fogbow.fish"
)]
pub(super) struct Args {
    /// The shell.
    #[arg(value_enum)]
    shell: Shell,
}

/// Prints the completions.
pub(super) fn run(args: &Args) {
    let mut script = Vec::new();
    generate(args.shell, &mut Cli::command(), "fogbow", &mut script);
    console::result(String::from_utf8_lossy(&script).trim_end());
}
