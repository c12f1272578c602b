//! `fogbow render`.

use std::time::Duration;

use clap::builder::{PossibleValuesParser, TypedValueParser};

use super::console;
use super::frames::FrameArgs;
use super::header::Method;
use super::holding::HoldArgs;
use super::interrupt::Interrupt;
use super::limit;
use super::load::{self, Volumes};
use super::output::Output;
use super::picture::{Job, Told};
use super::sequence;
use super::settings::{PathArgs, RunArgs, SettingArgs};
use crate::error::Result;
use crate::image::can_denoise;
use crate::render::Clock;
use crate::scene::plan::RenderPlan;
use crate::scene::{self, Overrides, Planning, Scene};

/// Arguments of `fogbow render`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    pub(super) paths: PathArgs,
    #[command(flatten)]
    pub(super) settings: SettingArgs,
    /// Render without bias, by path tracing: slow, to measure against.
    #[arg(long)]
    pub(super) reference: bool,
    /// Take noise off the picture in the end by Open Image Denoise; what was there stays in the layers
    /// noisy.R, noisy.G and noisy.B. Wants a fogbow built with --features denoise.
    #[arg(long)]
    pub(super) denoise: bool,
    /// For a VDB file that has only a level set: turn it into a fog volume.
    #[arg(long, value_name = "AS", value_parser = ["fog"])]
    pub(super) level_set: Option<String>,
    /// What to do of what the scene does not need: nothing, or everything all the same.
    #[arg(long, value_name = "WHAT", default_value = "needed",
        value_parser = PossibleValuesParser::new(["needed", "everything"]).map(planning))]
    pub(super) plan: Planning,
    #[command(flatten)]
    pub(super) hold: HoldArgs,
    #[command(flatten)]
    pub(super) frames: FrameArgs,
    #[command(flatten)]
    pub(super) run: RunArgs,
}

impl Args {
    /// Settings that stand over those of the scene file.
    pub(super) fn overrides(&self) -> Overrides {
        Overrides { denoise: Some(self.denoise), ..self.settings.overrides() }
    }

    /// How pictures are made.
    pub(super) const fn method(&self) -> Method {
        let level_set_as_fog = self.level_set.is_some();
        Method { reference: self.reference, level_set_as_fog }
    }
}

/// Renders and writes the pictures.
pub(super) fn run(args: &Args) -> Result<()> {
    if args.denoise {
        can_denoise()?;
    }
    if let Some(frames) = &args.frames.frames {
        return sequence::run(args, frames);
    }
    let (clock, program) = (Clock::start(), limit::program());
    let output = Output::check(&args.paths.output)?;
    let interrupt = Interrupt::listen()?;
    let (level_set_as_fog, memory, planning) =
        (args.method().level_set_as_fog, args.hold.memory, args.plan);
    let volumes = Volumes { level_set_as_fog, frame: None, memory, planning };
    let (mut scene, pool, loading) =
        load::scene(&args.paths.scene, args.overrides(), volumes, &args.run)?;
    let plan = plan(args, &scene);
    plan.iter().for_each(|line| console::message(line));
    let advice = advice(args, &scene);
    console::warn(&advice);
    let warnings = [scene.warnings.clone(), advice].concat();
    let job = Job {
        output: &output,
        hold: &args.hold,
        interrupt: &interrupt,
        method: args.method(),
        quiet: args.run.quiet,
        clock: &clock,
        start: Duration::ZERO,
        loading,
        program,
    };
    let told = job.run(&mut scene, &pool, warnings, None)?;
    tell(args, &told);
    told.end(&interrupt)
}

/// One line on what rendering `scene` needs, where it is to be said.
pub(super) fn plan(args: &Args, scene: &Scene) -> Option<String> {
    let said = !args.reference && !args.run.quiet;
    said.then(|| RenderPlan::of(scene, &scene.render).line())
}

/// What may be wrong with the settings for `scene`.
pub(super) fn advice(args: &Args, scene: &Scene) -> Vec<String> {
    if args.reference { Vec::new() } else { scene::advice(scene) }
}

/// Prints what is told of a picture.
pub(super) fn tell(args: &Args, told: &Told) {
    if args.run.json {
        console::result(&told.report.to_string());
    } else {
        told.output.names().iter().for_each(|name| console::result(name));
    }
}

fn planning(name: String) -> Planning {
    if name == "everything" { Planning::Everything } else { Planning::Needed }
}
