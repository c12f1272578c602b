//! `fogbow plan`.

use std::path::PathBuf;
use std::time::Duration;

use serde_json::{Value, json};

use super::console;
use super::limit;
use super::load;
use super::look::LookArgs;
use super::settings::{RunArgs, SettingArgs};
use crate::error::Result;
use crate::render::{self, Costs};
use crate::scene::plan::{Item, RenderPlan};
use crate::scene::{self, LoadOptions, Scene};

/// Photons that take longer are warned of.
const LONG: Duration = Duration::from_secs(600);

/// Arguments of `fogbow plan`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// A scene (.toml), or a VDB file, which gets a camera and lights.
    #[arg(value_name = "SCENE|FILE.vdb")]
    scene: PathBuf,
    /// The frame meant, where the scene names a sequence of files.
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    frame: Option<i64>,
    #[command(flatten)]
    settings: SettingArgs,
    #[command(flatten)]
    look: LookArgs,
    #[command(flatten)]
    run: RunArgs,
}

/// Prints what rendering the scene needs, and what it should cost.
pub(super) fn run(args: &Args) -> Result<()> {
    let program = limit::program();
    let options = LoadOptions { frame: args.frame, ..load::options(&args.settings, &args.look) };
    let (scene, pool, _) = load::scene(&args.scene, options, &args.run)?;
    let plan = RenderPlan::of(&scene, &scene.render);
    let costs = pool.install(|| render::costs(&scene, &scene.render, program))?;
    let slow = pool.install(|| slow(&scene))?;
    let advice: Vec<_> = scene::advice(&scene).into_iter().chain(slow).collect();
    console::warn(&advice);
    let warnings = [scene.warnings.as_slice(), &advice].concat();
    let text = if args.run.json {
        let items: Vec<_> = plan.items.iter().map(|item| with_work(item, &costs)).collect();
        let report = json!({
            "scene": scene.hash,
            "items": items,
            "needs": plan.needs,
            "offers": plan.offers,
            "work": costs.work,
            "memory": costs.memory,
            "warnings": warnings,
            "notes": scene.notes,
        });
        report.to_string()
    } else {
        readable(&scene, &plan, &costs)
    };
    console::result(&text);
    Ok(())
}

/// A sentence where photons take long.
fn slow(scene: &Scene) -> Result<Option<String>> {
    let photons = scene.render.photons;
    let time = render::photon_time(scene, &scene.render)?;
    Ok((time > LONG).then(|| {
        let fewer = photons as f64 * LONG.as_secs_f64() / time.as_secs_f64();
        format!(
            "{photons} photons take about {:.1} h on this machine; {:.0} would take ten minutes",
            time.as_secs_f64() / 3600.0,
            fewer
        )
    }))
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
fn readable(scene: &Scene, plan: &RenderPlan, costs: &Costs) -> String {
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
    lines.push(format!("work, about:{}", list(costs.work.counts(), &amount)));
    let memory = &costs.memory;
    let parts = [
        ("program", memory.program),
        ("grids", memory.grids),
        ("surfaces", memory.surfaces),
        ("photons", memory.photons),
        ("film", memory.film),
        ("maps", memory.maps),
    ];
    lines.push(format!(
        "memory, about:{}; {} at most",
        list(parts, &mebibytes),
        mebibytes(memory.peak)
    ));
    lines.extend(plan.offers.iter().map(|offer| format!("offered: {offer}")));
    lines.join("\n")
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
