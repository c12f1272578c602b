//! Raw arguments to settings.

use std::path::PathBuf;

use clap::error::ErrorKind;
use clap::{Arg, ArgAction, ArgMatches, Command};

use crate::scene::{Key, Kind, Setting, flagged};

/// Settings that every rendering command takes; each stands over the scene file's. The flags are those
/// of the table of keys.
#[derive(Debug, Default)]
pub(super) struct SettingArgs {
    /// In the order in which they are put over the scene.
    pub(super) settings: Vec<Setting>,
}

/// The name of `--set`.
const SET: &str = "set";

impl clap::Args for SettingArgs {
    fn augment_args(command: Command) -> Command {
        let set = Arg::new(SET)
            .long(SET)
            .value_name("KEY=VALUE")
            .action(ArgAction::Append)
            .value_parser(Setting::parse)
            .help("Any key of the scene, such as medium.0.albedo=0.8; may be given several times");
        flagged().fold(command, |command, (table, key)| command.arg(flag(table, key))).arg(set)
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl clap::FromArgMatches for SettingArgs {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut args = Self::default();
        args.update_from_arg_matches(matches)?;
        Ok(args)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        let wrong = |e| clap::Error::raw(ErrorKind::InvalidValue, format!("{e}\n"));
        let given = matches.try_get_many::<Setting>(SET).map_err(wrong)?;
        self.settings.extend(given.into_iter().flatten().cloned());
        for (_, key) in flagged() {
            let name = key.flag.unwrap_or(key.name);
            let given = matches.try_get_one::<Setting>(name).map_err(wrong)?;
            self.settings.extend(given.cloned());
        }
        Ok(())
    }
}

/// The flag of `key`, which stands in `table`.
fn flag(table: &'static str, key: &'static Key) -> Arg {
    let name = key.flag.unwrap_or(key.name);
    let unit = if key.unit.is_empty() { String::new() } else { format!(", in {}", key.unit) };
    let words = match key.kind {
        Kind::Word(words) => format!(": {}", words().join(", ")),
        _ => String::new(),
    };
    let sentence = format!("{}{words}{unit}", key.doc.trim_end_matches('.'));
    let arg = Arg::new(name)
        .long(name)
        .value_name(value_name(&key.kind))
        .allow_negative_numbers(true)
        .value_parser(move |text: &str| Setting::from_flag(table, key, text))
        .help(sentence);
    if table == "director" { arg.help_heading("Director") } else { arg }
}

/// What the help calls the value of a flag.
fn value_name(kind: &Kind) -> &'static str {
    match kind {
        Kind::Size => "WxH",
        Kind::Pair(_) => "A,B",
        Kind::Number(_) | Kind::NumberOr(..) | Kind::Splat(_) => "X",
        Kind::Whole(..) => "N",
        Kind::Text(_) => "LIST",
        _ => "WORD",
    }
}

/// How a command runs and talks.
#[derive(Debug, clap::Args)]
pub(super) struct RunArgs {
    /// Threads to work with; the picture does not depend on it. By default one a core.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(super) threads: Option<u16>,
    /// Print settings, seconds a stage, counters and paths as one JSON object.
    #[arg(long)]
    pub(super) json: bool,
    /// Print no progress and no notes.
    #[arg(long)]
    pub(super) quiet: bool,
}

/// What is rendered and where it goes.
#[derive(Debug, clap::Args)]
pub(super) struct PathArgs {
    /// A scene (.toml), a shot (.usd, .usda, .usdc, .usdz), or a VDB file, which gets a camera and lights;
    /// with --frames also a pattern such as smoke_####.vdb.
    #[arg(value_name = "SCENE|SHOT.usd|FILE.vdb")]
    pub(super) scene: PathBuf,
    /// The EXR to write; a PNG is written beside it. With --frames their numbers go where #### or %04d
    /// stands, else before the ending.
    #[arg(short, long, value_name = "OUT.exr", required_unless_present = "photons_to")]
    pub(super) output: Option<PathBuf>,
}
