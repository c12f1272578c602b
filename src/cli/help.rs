//! `fogbow help`: of the program, of a command, and every key of a scene file.

use clap::Parser;

use super::{Cli, console};
use crate::scene::{Key, TABLES, Without};

/// The topic that lists the keys of a scene file.
const SCENE: &str = "scene";

/// Columns of a line.
const WIDTH: usize = 80;

/// Arguments of `fogbow help`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// A command, or "scene": every key of a scene file, what it takes, its unit and its default.
    #[arg(value_name = "COMMAND|scene")]
    topic: Option<String>,
}

/// Prints the help that is asked for.
pub(super) fn run(args: &Args) {
    match args.topic.as_deref() {
        Some(SCENE) => console::result(&scene()),
        // clap prints the help of the command, or that there is no such command.
        topic => {
            Cli::parse_from(["fogbow"].into_iter().chain(topic).chain(["--help"]));
        }
    }
}

/// Every key of a scene file, table by table, in lines for a terminal.
fn scene() -> String {
    let mut lines = vec![
        "A scene file is TOML. These are its tables with their keys; the flag in brackets"
            .to_owned(),
        "overrides the key, and --set TABLE.KEY=VALUE, as --set medium.0.albedo=0.8, any."
            .to_owned(),
    ];
    let mut last = "";
    for (name, variant, table) in TABLES {
        if *name != last {
            lines.extend([String::new(), (*name).to_owned()]);
            last = name;
        }
        if !variant.is_empty() {
            lines.extend([String::new(), format!("  {}:", variant.replace('`', ""))]);
        }
        lines.extend(table.keys.iter().flat_map(|key| entry(key)));
    }
    lines.join("\n")
}

/// A key with its flag, its sentence, and what it takes.
fn entry(key: &Key) -> Vec<String> {
    let flag = key.flag.map_or(String::new(), |flag| format!(" (--{flag})"));
    let unit = if key.unit.is_empty() { String::new() } else { format!(", in {}", key.unit) };
    let without = match key.without {
        Without::Needed(_) => "must be there".to_owned(),
        Without::Default(value) => format!("without it {value}"),
        Without::Other(what) => format!("without it {what}"),
    };
    let mut lines = vec![format!("    {}{flag}", key.name)];
    lines.extend(wrapped(&format!("{} Takes {}{unit}; {without}.", key.doc, key.kind.right()), 8));
    lines
}

/// `text` in lines of at most [`WIDTH`] columns, where words allow, each after `indent` spaces.
fn wrapped(text: &str, indent: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= WIDTH => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(format!("{:indent$}{word}", "")),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_is_listed_within_the_width() {
        let text = scene();
        for (name, _, table) in TABLES {
            assert!(text.contains(name), "{name}");
            for key in table.keys {
                let is_listed = text.lines().any(|line| {
                    line.split_whitespace().next() == Some(key.name) && line.starts_with("    ")
                });
                assert!(is_listed, "{name} {}", key.name);
            }
        }
        let long = text.lines().find(|line| line.chars().count() > WIDTH + 10);
        assert_eq!(long, None);
    }

    #[test]
    fn words_are_kept_whole() {
        let lines = wrapped(&"four ".repeat(40), 8);
        assert!(lines.len() > 2 && lines.iter().all(|line| line.chars().count() <= WIDTH));
        assert!(lines.iter().all(|line| line.starts_with("        four")));
    }
}
