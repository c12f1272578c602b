//! `fogbow render`.

use std::time::Instant;

use clap::builder::{PossibleValuesParser, TypedValueParser};

use super::console;
use super::holding::HoldArgs;
use super::interrupt::Interrupt;
use super::limit;
use super::load;
use super::output::Output;
use super::picture::Job;
use super::settings::{PathArgs, RunArgs, SettingArgs};
use crate::error::{Error, Result};
use crate::scene::plan::RenderPlan;
use crate::scene::{self, Planning};

/// Arguments of `fogbow render`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    paths: PathArgs,
    #[command(flatten)]
    settings: SettingArgs,
    /// Render without bias, by path tracing: slow, to measure against.
    #[arg(long)]
    reference: bool,
    /// For a VDB file that has only a level set: turn it into a fog volume.
    #[arg(long, value_name = "AS", value_parser = ["fog"])]
    level_set: Option<String>,
    /// What to do of what the scene does not need: nothing, or everything all the same.
    #[arg(long, value_name = "WHAT", default_value = "needed",
        value_parser = PossibleValuesParser::new(["needed", "everything"]).map(planning))]
    plan: Planning,
    #[command(flatten)]
    hold: HoldArgs,
    #[command(flatten)]
    run: RunArgs,
}

/// Renders and writes the pictures.
pub(super) fn run(args: &Args) -> Result<()> {
    let (start, program) = (Instant::now(), limit::program());
    let output = Output::check(&args.paths.output)?;
    let interrupt = Interrupt::listen()?;
    let level_set_as_fog = args.level_set.is_some();
    let (mut scene, pool, loading) = load::scene_within(
        args.hold.memory,
        &args.paths.scene,
        &args.settings,
        level_set_as_fog,
        &args.run,
    )?;
    scene.render.planning = args.plan;
    if !args.reference && !args.run.quiet {
        console::message(&RenderPlan::of(&scene, &scene.render).line());
    }

    let mut warnings = scene.warnings.clone();
    if !args.reference {
        let advice = scene::advice(&scene);
        console::warn(&advice);
        warnings.extend(advice);
    }
    let job = Job {
        output: &output,
        hold: &args.hold,
        interrupt: &interrupt,
        reference: args.reference,
        level_set_as_fog,
        quiet: args.run.quiet,
        start,
        loading,
        program,
    };
    let told = job.run(&mut scene, &pool, warnings)?;
    if args.run.json {
        console::result(&told.report.to_string());
    } else {
        console::result(&told.output.exr.display().to_string());
        console::result(&told.output.png.display().to_string());
    }
    match told.interrupted {
        Some(message) => Err(Error::Interrupted { message, code: interrupt.exit_code() }),
        None => Ok(()),
    }
}

fn planning(name: String) -> Planning {
    if name == "everything" { Planning::Everything } else { Planning::Needed }
}
