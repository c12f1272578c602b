//! `fogbow trial`.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use serde_json::json;

use super::console;
use super::load;
use super::look::LookArgs;
use super::progress::Console;
use super::settings::{RunArgs, SettingArgs};
use crate::error::{Error, Result};
use crate::render::{Clock, Progress};
use crate::scene::{LoadOptions, OpenScene};
use crate::sequence::FrameTime;
use crate::study::forced_choice::{
    PAGE, Pair, Server, Tally, check_scenes, read_answers, tally, write_trial,
};

/// Significance level of the chi-square test.
const SIGNIFICANCE: f64 = 0.05;

/// Fewest answers for the chi-square test: it needs five expected in each of its two cells.
const MIN_ANSWERS: u64 = 10;

/// Arguments of `fogbow trial`.
#[derive(Debug, clap::Args)]
#[command(
    override_usage = "fogbow trial <SCENE>... -o <DIR> [--serve [PORT]] [OPTIONS]\n       \
    fogbow trial -o <DIR> --serve [PORT]\n       fogbow trial --analyse <ANSWERS.csv>... [--json]",
    after_help = "Each person sees each scene once: the gold standard and the picture of --director \
    xs, or of another that is named, either one after the other (4 s, 2 s of grey, 4 s) or both for 8 s below the gold \
    standard. Opened as a file the page offers the answers for download; with --serve they go to \
    DIR/answers.csv. Columns of answers: participant, scene, condition (successive or reference), \
    gold and chosen (first or second, left or right), seconds, time; the last two may be missing."
)]
pub(super) struct Args {
    /// Scenes (.toml), or VDB files, which get a camera and lights.
    #[arg(value_name = "SCENE", conflicts_with = "analyse",
        required_unless_present_any = ["analyse", "serve"])]
    scenes: Vec<PathBuf>,
    /// The folder for trial.html and the answers.
    #[arg(
        short,
        long,
        value_name = "DIR",
        required_unless_present = "analyse",
        conflicts_with = "analyse"
    )]
    output: Option<PathBuf>,
    /// Serve the page to this machine and store answers; any free port where none is given.
    /// Without scenes the page that lies in the folder is served.
    #[arg(long, value_name = "PORT", num_args = 0..=1, default_missing_value = "0",
        conflicts_with = "analyse")]
    serve: Option<u16>,
    /// Count the answers in these files instead: chi-square and p by scene and condition.
    #[arg(long, value_name = "ANSWERS.csv", num_args = 1.., visible_alias = "analyze")]
    analyse: Vec<PathBuf>,
    /// The frame to show, where scenes name a sequence of files; 12.5 is a time between
    /// two.
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    frame: Option<FrameTime>,
    #[command(flatten)]
    settings: SettingArgs,
    #[command(flatten)]
    look: LookArgs,
    #[command(flatten)]
    run: RunArgs,
}

/// Makes the page, serves it, or counts answers. The program was called by `command`.
pub(super) fn run(args: &Args, command: &str) -> Result<()> {
    let Some(folder) = &args.output else { return analyse(&args.analyse, args.run.json) };
    if !args.scenes.is_empty() {
        make(args, command, folder)?;
    }
    args.serve.map_or(Ok(()), |port| serve(args, folder, port))
}

fn make(args: &Args, command: &str, folder: &Path) -> Result<()> {
    let console = Console::new(Clock::start(), args.run.quiet);
    let progress: &dyn Progress = &console;
    let mut loaded = Vec::new();
    // All are loaded before the first is rendered, so that a bad file is found at once.
    for path in &args.scenes {
        let options =
            LoadOptions { frame: args.frame, ..load::options(&args.settings, &args.look) };
        let open = &mut OpenScene::of_file(path);
        loaded.push(load::scene_to_show(open, options, &args.run)?);
    }
    check_scenes(loaded.iter().map(|(scene, ..)| scene))?;
    std::fs::create_dir_all(folder)
        .map_err(|e| Error::file(folder, format!("cannot be made: {e}; give a folder")))?;
    progress.stage("pictures", loaded.len() as u64);
    let mut pairs = Vec::new();
    for (scene, pool, _) in &loaded {
        pairs.push(pool.install(|| Pair::render(scene))?);
        progress.advance(1);
    }
    progress.finish();
    write_trial(&pairs, command, folder)?;
    let page = folder.join(PAGE);
    if args.run.json {
        let scenes: Vec<_> = pairs.iter().map(|pair| &pair.scene).collect();
        console::result(&json!({ "page": page, "scenes": scenes }).to_string());
    } else {
        console::result(&page.display().to_string());
    }
    Ok(())
}

fn serve(args: &Args, folder: &Path, port: u16) -> Result<()> {
    let server = Server::bind(folder, port)?;
    if args.run.json {
        let report = json!({ "url": server.url(), "answers": server.answers() });
        console::result(&report.to_string());
    } else {
        console::result(&server.url());
    }
    if !args.run.quiet {
        let answers = server.answers().display();
        console::message(&format!("answers go to {answers}; Ctrl-C ends"));
    }
    server.run()
}

fn analyse(paths: &[PathBuf], as_json: bool) -> Result<()> {
    let answers = read_answers(paths)?;
    if answers.is_empty() {
        return Err(Error::file(&paths[0], "has no answers; give files with at least one"));
    }
    let tallies = tally(&answers);
    if as_json {
        let report = json!({
            "files": paths,
            "answers": answers.len(),
            "test": "chi-square against half right and half wrong, one degree of freedom, \
                no correction for continuity",
            "tallies": tallies,
        });
        console::result(&report.to_string());
    } else {
        console::result(&table(&tallies));
    }
    Ok(())
}

fn table(tallies: &[Tally]) -> String {
    let longest = tallies.iter().map(|t| t.scene.chars().count()).max().unwrap_or(0).max(5);
    let mut out = format!(
        "{:<longest$}  {:<10}  {:>7}  {:>5}  {:>5}  {:>10}  {:>9}",
        "scene", "condition", "answers", "right", "wrong", "chi-square", "p"
    );
    for t in tallies {
        let Tally { scene, answers, right, wrong, chi_square, p, .. } = t;
        let condition = t.condition.name();
        let p = if *p < 1e-4 { format!("{p:.2e}") } else { format!("{p:.4}") };
        let _ = write!(
            out,
            "\n{scene:<longest$}  {condition:<10}  {answers:>7}  {right:>5}  {wrong:>5}  \
             {chi_square:>10.2}  {p:>9}  {}",
            conclusion(t)
        );
    }
    let _ = write!(
        out,
        "\n\nRight is who took the gold standard for it. Chi-square against half right and half \
         wrong, one degree of freedom, no correction for continuity."
    );
    if tallies.iter().any(|t| t.answers < MIN_ANSWERS) {
        let _ = write!(out, " Below {MIN_ANSWERS} answers it is rough.");
    }
    out
}

/// The conclusion from a tally.
fn conclusion(tally: &Tally) -> &'static str {
    match (tally.p < SIGNIFICANCE, tally.right > tally.wrong) {
        (false, _) => "may be guessing",
        (true, true) => "the difference is seen",
        (true, false) => "the directed picture is taken for the gold standard",
    }
}
