//! `fogbow render`.

use std::time::{Duration, Instant};

use clap::builder::{PossibleValuesParser, TypedValueParser};
use rayon::ThreadPool;
use serde_json::{Map, Value, json};

use super::console;
use super::frames::FrameArgs;
use super::load::{self, Volumes};
use super::memory;
use super::output::Output;
use super::progress::Console;
use super::sequence;
use super::settings::{PathArgs, RunArgs, SettingArgs};
use crate::director::KeptSight;
use crate::error::Result;
use crate::image::{View, write_exr, write_png};
use crate::render::{self, Progress, Rendered, Silent};
use crate::scene::plan::RenderPlan;
use crate::scene::{self, Director, Planning, Scene};

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
    /// For a VDB file that has only a level set: turn it into a fog volume.
    #[arg(long, value_name = "AS", value_parser = ["fog"])]
    pub(super) level_set: Option<String>,
    /// What to do of what the scene does not need: nothing, or everything all the same.
    #[arg(long, value_name = "WHAT", default_value = "needed",
        value_parser = PossibleValuesParser::new(["needed", "everything"]).map(planning))]
    pub(super) plan: Planning,
    #[command(flatten)]
    pub(super) frames: FrameArgs,
    /// Leave out frames that an earlier run finished.
    #[arg(long, requires = "frames")]
    pub(super) resume: bool,
    #[command(flatten)]
    pub(super) run: RunArgs,
}

/// The EXR's attribute that says what the picture was made of.
pub(super) const RECIPE: &str = "fogbow:recipe";

/// Renders and writes the pictures.
pub(super) fn run(args: &Args) -> Result<()> {
    if let Some(frames) = &args.frames.frames {
        return sequence::run(args, frames);
    }
    let output = Output::check(&args.paths.output)?;
    let volumes = Volumes { level_set_as_fog: args.level_set.is_some(), ..Volumes::default() };
    let (mut scene, pool, loading) =
        load::scene(&args.paths.scene, &args.settings, volumes, &args.run)?;
    scene.render.planning = args.plan;
    let job = Job { args, output: &output, pool: &pool, loading };
    let (report, _) = picture(&job, &scene, None)?;
    if args.run.json {
        console::result(&report.to_string());
    } else {
        output.names().iter().for_each(|name| console::result(name));
    }
    Ok(())
}

/// One picture to make.
pub(super) struct Job<'a> {
    pub(super) args: &'a Args,
    /// Where it goes.
    pub(super) output: &'a Output,
    /// Who works on it.
    pub(super) pool: &'a ThreadPool,
    /// What reading the scene took.
    pub(super) loading: Duration,
}

/// Renders `scene` and writes the picture; what is told of it, and the director's first look, which
/// may be that of an earlier picture, `kept`.
pub(super) fn picture(
    job: &Job<'_>,
    scene: &Scene,
    kept: Option<KeptSight>,
) -> Result<(Value, Option<KeptSight>)> {
    let Job { args, output, pool, loading } = *job;
    if !args.reference && !args.run.quiet {
        console::message(&RenderPlan::of(scene, &scene.render).line());
    }
    let mut warnings = scene.warnings.clone();
    if !args.reference {
        let advice = scene::advice(scene);
        console::warn(&advice);
        warnings.extend(advice);
    }
    let console = Console::new();
    let progress: &dyn Progress = if args.run.quiet { &Silent } else { &console };
    let mut rendered = pool.install(|| {
        if args.reference {
            Ok(render::render_reference(scene, &scene.render, progress))
        } else {
            render::render_next(scene, &scene.render, kept, progress)
        }
    })?;

    let ended = rendered.warnings();
    console::warn(&ended);
    warnings.extend(ended);
    let start = Instant::now();
    let settings = settings(scene, &rendered, args.reference);
    write(output, scene, &rendered, &settings, &recipe(scene, args))?;
    let writing = start.elapsed();
    let seconds = seconds(loading, &rendered, writing);
    let mut report = json!({
        "settings": settings,
        "seconds": seconds,
        "work": rendered.work,
        "peak_memory": memory::peak(),
        "warnings": warnings,
        "notes": scene.notes,
        "outputs": output.names(),
    });
    if let Some(directed) = rendered.director {
        report["director"] = json!(directed);
    }
    Ok((report, rendered.sight.take()))
}

fn planning(name: String) -> Planning {
    if name == "everything" { Planning::Everything } else { Planning::Needed }
}

/// A hash of all that a picture's bytes depend on.
pub(super) fn recipe(scene: &Scene, args: &Args) -> String {
    let version = env!("CARGO_PKG_VERSION");
    let (film, render) = (&scene.film, &scene.render);
    let all = format!("{version} {} {} {film:?} {render:?}", scene.hash, args.reference);
    blake3::hash(all.as_bytes()).to_hex().to_string()
}

/// What the picture was made with; the same input gives the same settings.
fn settings(scene: &Scene, rendered: &Rendered, reference: bool) -> Map<String, Value> {
    let (film, render) = (&scene.film, &scene.render);
    let settings = json!({
        "version": env!("CARGO_PKG_VERSION"),
        "scene": scene.hash,
        "method": if reference { "reference" } else { "photon map" },
        "size": film.size,
        "exposure": film.exposure,
        "view": film.view.to_string(),
        "rays": render.rays,
        "photons": render.photons,
        "radius": rendered.radius.or(render.radius),
        "step": render.step,
        "director": render.director.name(),
        "seed": render.seed,
        "max_scatter": render.max_scatter,
    });
    let mut settings = if let Value::Object(settings) = settings { settings } else { Map::new() };
    if render.director != Director::Fixed && !reference {
        let asked = &render.directing;
        settings.insert(
            "directing".into(),
            json!({
                "x": asked.x.name(),
                "weights": asked.weights,
                "op": asked.operator.name(),
                "directs": asked.directed.to_string(),
                "floor": asked.floor,
                "coarsest_radius": asked.coarsest_radius,
                "coarsest_step": asked.coarsest_step,
                "tolerance": asked.tolerance,
                "resolution": asked.resolution,
            }),
        );
    }
    settings
}

fn seconds(loading: Duration, rendered: &Rendered, writing: Duration) -> Map<String, Value> {
    let stages = rendered.timings.iter().map(|(name, time)| (*name, *time));
    [("load", loading)]
        .into_iter()
        .chain(stages)
        .chain([("write", writing)])
        .map(|(name, time)| (name.to_owned(), json!(time.as_secs_f64())))
        .collect()
}

/// Writes the PNG, then the EXR with settings and work counters in its header: once that is there,
/// the picture is finished.
fn write(
    output: &Output,
    scene: &Scene,
    rendered: &Rendered,
    settings: &Map<String, Value>,
    recipe: &str,
) -> Result<()> {
    let work = serde_json::to_value(rendered.work).unwrap_or_default();
    let text = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
    let setting = |(name, value)| (format!("fogbow:{name}"), text(value));
    let counter = |(name, value): (&String, &Value)| (format!("fogbow:work:{name}"), text(value));
    let named: Vec<(String, String)> = settings
        .iter()
        .map(setting)
        .chain(work.as_object().into_iter().flatten().map(counter))
        .chain([(RECIPE.into(), recipe.into())])
        .collect();
    let attributes: Vec<(&str, String)> =
        named.iter().map(|(name, value)| (name.as_str(), value.clone())).collect();
    let view = View { exposure: scene.film.exposure, transform: scene.film.view };
    write_png(&output.png, &rendered.film.image(), &view)?;
    write_exr(&output.exr, &rendered.film, &attributes)
}
