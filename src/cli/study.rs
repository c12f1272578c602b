//! `fogbow study`.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use serde_json::json;

use super::console;
use super::load;
use super::look::LookArgs;
use super::progress::Console;
use super::settings::{RunArgs, SettingArgs};
use crate::error::Result;
use crate::render::{Clock, Progress};
use crate::scene::{LoadOptions, MAX_RAYS, OpenScene};
use crate::sequence::FrameTime;
use crate::study::{
    CANDIDATES, Effect, Estimate, MOST_SEEDS, Metric, Request, Study, write_report,
};

/// Arguments of `fogbow study`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "The gold standard is the scene's picture with the ceiling of rays in every \
    pixel. Every run is on disk at once: after a kill, the same command with --resume goes on. \
    With all candidates the report tells what each part of the director brings at equal time; the \
    candidate photons shows how errors fall with photons, beside theory."
)]
pub(super) struct Args {
    /// A scene (.toml), or a VDB file, which gets a camera and lights.
    #[arg(value_name = "SCENE|FILE.vdb")]
    scene: PathBuf,
    /// The folder for report.html, results.json, results.csv and the pictures.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Go on with the study that lies in the folder.
    #[arg(long)]
    resume: bool,
    /// Time to spend, such as 90s, 10m or 2h: on gold, the directed candidate and uniform sampling
    /// with at least three seeds, then on other candidates and more seeds. With --resume, on more of
    /// them.
    #[arg(long, value_name = "TIME", value_parser = time)]
    time: Option<f64>,
    /// Measure against an unbiased picture of this many rays a pixel as well.
    #[arg(long, value_name = "RAYS",
        value_parser = clap::value_parser!(u32).range(2..=i64::from(MAX_RAYS)))]
    reference: Option<u32>,
    /// Some of the candidates, with commas between; all by default.
    #[arg(long, value_name = "NAMES", value_delimiter = ',',
        value_parser = candidates())]
    candidates: Vec<String>,
    /// Ceilings of rays, with commas between; the scene's and its halves by default.
    #[arg(long, value_name = "RAYS", value_delimiter = ',',
        value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_RAYS)))]
    budgets: Vec<u32>,
    /// Seeds of every candidate at every budget: 5 by default, and with --time as many as fit.
    #[arg(long, value_name = "N",
        value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_SEEDS)))]
    seeds: Option<u32>,
    /// The error that answers are about.
    #[arg(long, default_value = Metric::default().name(), value_parser = metric())]
    metric: Metric,
    /// Errors to tell the time to, with commas between.
    #[arg(long, value_name = "ERRORS", value_delimiter = ',')]
    errors: Vec<f64>,
    /// The frame to study, where the scene names a sequence of files; 12.5 is a time
    /// between two.
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    frame: Option<FrameTime>,
    #[command(flatten)]
    settings: SettingArgs,
    #[command(flatten)]
    look: LookArgs,
    #[command(flatten)]
    run: RunArgs,
}

/// Runs the study, writes its report, and prints what it found. The program was called by `command`.
pub(super) fn run(args: &Args, command: &str) -> Result<()> {
    let progress = Console::new(Clock::start(), args.run.quiet);
    let told = report(args, &mut OpenScene::of_file(&args.scene), command, &progress)?;
    console::result(&told);
    Ok(())
}

/// What `run` prints, of a study of the scene `open`.
pub(super) fn report(
    args: &Args,
    open: &mut OpenScene,
    command: &str,
    progress: &dyn Progress,
) -> Result<String> {
    let seeds = if args.time.is_some() { MOST_SEEDS } else { Request::default().seeds };
    let request = Request {
        candidates: args.candidates.clone(),
        budgets: args.budgets.clone(),
        seeds: args.seeds.unwrap_or(seeds),
        reference: args.reference,
        seconds: args.time,
        metric: args.metric,
        errors: args.errors.clone(),
    };
    request.check()?;
    let options = LoadOptions { frame: args.frame, ..load::options(&args.settings, &args.look) };
    let (scene, pool, _) = load::scene_to_show(open, options, &args.run)?;
    let results = pool.install(|| {
        let study = Study::new(&scene, &args.output, &request, args.resume)?;
        let results = study.run(command, progress)?;
        write_report(&results, &args.output)?;
        Ok(results)
    })?;
    let report = args.output.join("report.html");
    if args.run.json {
        let summary = json!({
            "verdict": results.verdict,
            "headline": results.headline,
            "plan": results.plan,
            "ablation": results.ablation,
            "convergence": results.convergence,
            "report": report,
            "results": args.output.join("results.json"),
        });
        return Ok(summary.to_string());
    }
    let mut lines = results.verdict;
    if !results.ablation.is_empty() {
        lines.push(table(&results.ablation));
    }
    lines.push(report.display().to_string());
    Ok(lines.join("\n"))
}

/// What each part of the director brings.
fn table(effects: &[Effect]) -> String {
    let mut out = format!(
        "\n{:<28}  {:<18}  {:<18}  outcome, gain in error at equal time",
        "part", "with", "without"
    );
    for effect in effects {
        let Effect { part, with, without, error_gain, .. } = effect;
        let gain = match error_gain {
            Estimate::Found(gain) => match gain.range {
                Some([low, high]) => format!("{:.3} ({low:.3} to {high:.3})", gain.estimate),
                None => format!("{:.3}", gain.estimate),
            },
            Estimate::None(why) => why.clone(),
        };
        let outcome = effect.outcome();
        let _ = write!(out, "\n{part:<28}  {with:<18}  {without:<18}  {outcome}: {gain}");
    }
    out.push('\n');
    out
}

fn candidates() -> PossibleValuesParser {
    let candidates = CANDIDATES.map(|(name, about)| PossibleValue::new(name).help(about));
    PossibleValuesParser::new(candidates)
}

fn metric() -> impl TypedValueParser<Value = Metric> {
    PossibleValuesParser::new(Metric::ALL.iter().map(|row| row.0)).try_map(|given| {
        let known = Metric::ALL.iter().find(|row| row.0 == given);
        known.map(|row| row.1).ok_or("unknown")
    })
}

/// Seconds of a time, as every command takes it.
fn time(text: &str) -> Result<f64, String> {
    super::units::time(text).map(|time| time.as_secs_f64())
}
