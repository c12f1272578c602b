//! `fogbow plan`.

use std::path::PathBuf;

use serde_json::{Value, json};

use super::console;
use super::film_args::FilmArgs;
use super::load;
use super::look::LookArgs;
use super::memory_limit;
use super::settings::{RunArgs, SettingArgs};
use crate::error::Result;
use crate::render::{self, Costs, StageSeconds};
use crate::scene::plan::{Item, RenderPlan};
use crate::scene::{self, Director, LoadOptions, OpenScene, Scene};
use crate::sequence::FrameTime;

/// Seconds: photons that take longer are warned of.
const LONG: f64 = 600.0;

/// Arguments of `fogbow plan`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Work, memory and seconds are estimates. Seconds are those of a clock, without loading \
    and writing: a few photons are shot and a few pixels are exposed on this machine and this scene, \
    and what they take is scaled to all of them; a director's maps are made, of fewer pixels where \
    the film is large, and rays count as those maps hand them out."
)]
pub(super) struct Args {
    /// A scene (.toml), or a VDB file, which gets a camera and lights.
    #[arg(value_name = "SCENE|FILE.vdb")]
    scene: PathBuf,
    /// The frame meant, where the scene names a sequence of files; 12.5 is a time
    /// between two.
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    frame: Option<FrameTime>,
    #[command(flatten)]
    settings: SettingArgs,
    #[command(flatten)]
    film: FilmArgs,
    #[command(flatten)]
    look: LookArgs,
    #[command(flatten)]
    run: RunArgs,
}

/// Prints what rendering the scene needs, and what it should cost.
pub(super) fn run(args: &Args) -> Result<()> {
    console::result(&report(args, &mut OpenScene::of_file(&args.scene))?);
    Ok(())
}

/// What `run` prints, of the scene `open`.
pub(super) fn report(args: &Args, open: &mut OpenScene) -> Result<String> {
    let program = memory_limit::program();
    let options = args.film.apply(load::options(&args.settings, &args.look));
    let options = LoadOptions { frame: args.frame, ..options };
    let (mut scene, pool, _) = load::scene(open, options, &args.run)?;
    let costs = pool.install(|| render::costs(&scene, &scene.render, program))?;
    (scene.render.rays, scene.render.photons) = (costs.rays, costs.photons);
    let plan = RenderPlan::new(&scene, &scene.render);
    let advice: Vec<_> = scene::advice(&scene).into_iter().chain(slow(&scene, &costs)).collect();
    console::warn(&advice);
    let warnings = [scene.warnings.as_slice(), &advice].concat();
    if args.run.json {
        let items: Vec<_> = plan.items.iter().map(|item| with_work(item, &costs)).collect();
        let report = json!({
            "scene": scene.hash,
            "rays": scene.render.rays,
            "photons": scene.render.photons,
            "items": items,
            "needs": plan.needs,
            "strategy": costs.strategy,
            "offers": plan.offers,
            "work": costs.work,
            "memory": costs.memory,
            "seconds": seconds(&scene, &costs, pool.current_num_threads()),
            "warnings": warnings,
            "notes": scene.notes,
        });
        Ok(report.to_string())
    } else {
        Ok(readable(&scene, &plan, &costs, pool.current_num_threads()))
    }
}

/// A sentence where photons take long.
fn slow(scene: &Scene, costs: &Costs) -> Option<String> {
    let (photons, seconds) = (scene.render.photons, costs.seconds.photons);
    (seconds > LONG).then(|| {
        format!(
            "{photons} photons take about {:.1} h on this machine; {:.0} would take ten minutes",
            seconds / 3600.0,
            photons as f64 * LONG / seconds
        )
    })
}

/// About how much of its work `item` takes.
fn work(item: &Item, costs: &Costs) -> u64 {
    costs.work.counts().find(|(name, _)| *name == item.counter).map_or(0, |(_, count)| count)
}

/// The item with about how much work it takes.
fn with_work(item: &Item, costs: &Costs) -> Value {
    let mut value = json!(item);
    value["work"] = json!(work(item, costs));
    value
}

/// A table of items, then work and memory.
fn readable(scene: &Scene, plan: &RenderPlan, costs: &Costs, threads: usize) -> String {
    let [width, height] = scene.film.size;
    let mut lines = vec![format!(
        "{}: {width} x {height} pixels, {} rays, {} photons",
        scene.path.display(),
        scene.render.rays,
        scene.render.photons
    )];
    for item in &plan.items {
        let verdict = if item.needed { "needed" } else { "left out" };
        let (stage, name, why) = (item.stage, item.name, &item.why);
        let work = match work(item, costs) {
            0 => String::new(),
            count => format!(": {} {}", amount(count), item.counter.replace('_', " ")),
        };
        lines.push(format!("{stage:9} {name:23} {verdict:9} {why}{work}"));
    }
    if plan.needs.media {
        let strategy = costs.strategy.lines();
        lines.extend(strategy.iter().map(|line| format!("strategy, {line}")));
    }
    lines.push(format!("work, about:{}", list(costs.work.counts(), &amount)));
    let StageSeconds { director, photons, march } = costs.seconds;
    let stages = [("pilot and director", director), ("photons", photons), ("rays", march)];
    let stages = stages.iter().filter(|(_, seconds)| *seconds > 0.0);
    let stages: Vec<_> =
        stages.map(|(name, seconds)| format!("{name} {}", digits(*seconds))).collect();
    lines.push(format!(
        "seconds, estimated from a short trial (--threads {threads}): {}; {}{} in all",
        stages.join(", "),
        if is_bound(scene) { "at most " } else { "" },
        digits(costs.seconds.total())
    ));
    let memory = &costs.memory;
    let parts = [
        ("program", memory.kept.program),
        ("grids", memory.kept.grids),
        ("surfaces", memory.kept.surfaces),
        ("photons", memory.kept.photons),
        ("film", memory.kept.film),
        ("maps", memory.kept.maps),
    ];
    lines.push(format!(
        "memory, about:{}; {} at most",
        list(parts, &mebibytes),
        mebibytes(memory.peak)
    ));
    lines.extend(plan.offers.iter().map(|offer| format!("offered: {offer}")));
    lines.join("\n")
}

/// Whether rays are told at most: the director gives them by a variance or an error that is not known yet.
fn is_bound(scene: &Scene) -> bool {
    scene.render.director == Director::Variance || scene.render.measures_error()
}

/// Seconds a stage, and what they hold for.
fn seconds(scene: &Scene, costs: &Costs, threads: usize) -> Value {
    let mut value = json!(costs.seconds);
    value["total"] = json!(costs.seconds.total());
    value["is_estimate"] = json!(true);
    value["is_upper_bound"] = json!(is_bound(scene));
    value["threads"] = json!(threads);
    value
}

/// Two digits of a number of seconds.
fn digits(seconds: f64) -> String {
    match seconds {
        s if s >= 9.95 => format!("{s:.0}"),
        s if s >= 0.995 => format!("{s:.1}"),
        s => format!("{s:.2}"),
    }
}

/// What is not 0, with commas between.
fn list<'n>(
    counts: impl IntoIterator<Item = (&'n str, u64)>,
    show: &dyn Fn(u64) -> String,
) -> String {
    let present = counts.into_iter().filter(|(_, count)| *count > 0);
    let words: Vec<String> = present
        .map(|(name, count)| format!(" {} {}", name.replace('_', " "), show(count)))
        .collect();
    if words.is_empty() { " none".into() } else { words.join(",") }
}

/// Two digits and a unit.
fn amount(count: u64) -> String {
    let steps = [(1e9, " G"), (1e6, " M"), (1e3, " k")];
    let step = steps.iter().find(|(size, _)| count as f64 >= *size);
    step.map_or_else(
        || count.to_string(),
        |(size, unit)| format!("{:.1}{unit}", count as f64 / size),
    )
}

fn mebibytes(bytes: u64) -> String {
    format!("{:.1} MiB", bytes as f64 / f64::from(1 << 20))
}
