//! `fogbow render`.

use std::time::{Duration, Instant};

use clap::builder::{PossibleValuesParser, TypedValueParser};
use serde_json::{Map, Value, json};

use super::console;
use super::load::{self, Volumes};
use super::memory;
use super::output::Output;
use super::progress::Console;
use super::settings::{PathArgs, RunArgs, SettingArgs};
use crate::error::Result;
use crate::image::{View, write_exr, write_png};
use crate::render::{self, Progress, Rendered, Silent};
use crate::scene::plan::RenderPlan;
use crate::scene::{self, Director, Planning, Scene};

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
    run: RunArgs,
}

/// Renders and writes the pictures.
pub(super) fn run(args: &Args) -> Result<()> {
    let output = Output::check(&args.paths.output)?;
    let volumes = Volumes { level_set_as_fog: args.level_set.is_some(), ..Volumes::default() };
    let (mut scene, pool, loading) =
        load::scene(&args.paths.scene, &args.settings, volumes, &args.run)?;
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
    let console = Console::new();
    let progress: &dyn Progress = if args.run.quiet { &Silent } else { &console };
    let rendered = pool.install(|| {
        if args.reference {
            Ok(render::render_reference(&scene, &scene.render, progress))
        } else {
            render::render(&scene, &scene.render, progress)
        }
    })?;

    let ended = rendered.warnings();
    console::warn(&ended);
    warnings.extend(ended);
    let start = Instant::now();
    let settings = settings(&scene, &rendered, args.reference);
    write(&output, &scene, &rendered, &settings)?;
    let writing = start.elapsed();
    if args.run.json {
        let seconds = seconds(loading, &rendered, writing);
        let report = json!({
            "settings": settings,
            "seconds": seconds,
            "work": rendered.work,
            "peak_memory": memory::peak(),
            "warnings": warnings,
            "notes": scene.notes,
            "outputs": [output.exr.display().to_string(), output.png.display().to_string()],
        });
        console::result(&report.to_string());
    } else {
        console::result(&output.exr.display().to_string());
        console::result(&output.png.display().to_string());
    }
    Ok(())
}

fn planning(name: String) -> Planning {
    if name == "everything" { Planning::Everything } else { Planning::Needed }
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

/// Writes the EXR, with settings and work counters in its header, and the PNG.
fn write(
    output: &Output,
    scene: &Scene,
    rendered: &Rendered,
    settings: &Map<String, Value>,
) -> Result<()> {
    let work = serde_json::to_value(rendered.work).unwrap_or_default();
    let text = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
    let setting = |(name, value)| (format!("fogbow:{name}"), text(value));
    let counter = |(name, value): (&String, &Value)| (format!("fogbow:work:{name}"), text(value));
    let named: Vec<(String, String)> = settings
        .iter()
        .map(setting)
        .chain(work.as_object().into_iter().flatten().map(counter))
        .collect();
    let attributes: Vec<(&str, String)> =
        named.iter().map(|(name, value)| (name.as_str(), value.clone())).collect();
    write_exr(&output.exr, &rendered.film, &attributes)?;
    let view = View { exposure: scene.film.exposure, transform: scene.film.view };
    write_png(&output.png, &rendered.film.image(), &view)
}
