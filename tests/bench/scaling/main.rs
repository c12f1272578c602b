//! How the cost of a render grows with photons, pixels, rays, voxels and optical thickness.
//!
//!     cargo bench --bench scaling               # half an hour; draws volumes/scaling.svg
//!     cargo bench --bench scaling -- --quick    # that it works; draws target/scaling/quick.svg
//!     cargo bench --bench scaling -- --draw     # the last measurement once more
//!
//! One thing is varied at a time from a base that is printed; the others stay. Times are processor
//! seconds of one thread, which other programs on the machine hardly touch, without loading and
//! writing: medians of rounds in which all settings take turns. Printed is, for each sweep, the slope
//! of the logarithm of the time over that of what is varied, by least squares, over all of the sweep
//! and its upper half, of the whole render and of each stage, and what slope is to be expected.

#![allow(clippy::print_stdout)]

mod axis;
mod draw;
#[path = "../spent.rs"]
mod spent;
#[path = "../stages.rs"]
mod stages;
mod subject;

use std::error::Error;
use std::path::{Path, PathBuf};

use fogbow::study::slope;
use rayon::ThreadPoolBuilder;
use serde::{Deserialize, Serialize};

use axis::{AXES, Axis};
use spent::median;
use stages::{STAGES, timed};
use subject::{BASE, SUBJECTS, Settings, Subject};

const ROUNDS: usize = 3;

/// Of a stage that takes less than this share of a sweep no slope is told.
const SMALL: f64 = 0.02;

/// What a setting took.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Point {
    axis: Axis,
    scene: String,
    /// What is varied.
    x: f64,
    /// Whether light in the medium was kept on a lattice, and not with photons along the ray.
    lattice: bool,
    /// Seconds of each stage.
    stages: [f64; STAGES.len()],
    /// Seconds of the render.
    whole: f64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let asked = |word: &str| std::env::args().any(|argument| argument == word);
    let (quick, root) = (asked("--quick"), Path::new(env!("CARGO_MANIFEST_DIR")));
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or(root.join("target"), PathBuf::from);
    let folder = target.join("scaling");
    std::fs::create_dir_all(&folder)?;
    let kept = folder.join(if quick { "quick.csv" } else { "measured.csv" });
    if !asked("--draw") {
        measure(quick, &kept)?;
    }
    let points = read(&kept)?;
    table(&points);
    let svg = if quick { folder.join("quick.svg") } else { root.join("volumes/scaling.svg") };
    std::fs::write(&svg, draw::draw(&points)?)?;
    println!("\n{}", svg.display());
    Ok(())
}

/// Every sweep of every scene, the rounds over all of them; after each the medians go to `kept`.
fn measure(quick: bool, kept: &Path) -> Result<(), Box<dyn Error>> {
    let pool = ThreadPoolBuilder::new().num_threads(1).build()?;
    let folder = tempfile::tempdir()?;
    let mut all: Vec<(&Subject, Settings, Vec<Point>)> = Vec::new();
    for subject in &SUBJECTS {
        for axis in AXES {
            let Some(sweep) = subject.sweep(axis, quick, folder.path())? else { continue };
            for (x, settings) in sweep {
                let scene = subject.name.to_owned();
                let (stages, whole) = (Default::default(), 0.0);
                let point = Point { axis, scene, x, lattice: false, stages, whole };
                all.push((subject, settings, vec![point]));
            }
        }
    }
    let rounds = if quick { 1 } else { ROUNDS };
    for round in 1..=rounds {
        for (subject, settings, points) in &mut all {
            let scene = subject.scene(settings, folder.path())?;
            let took = timed(&scene, &pool);
            let (lattice, whole) = (took.rendered.work.tracks > 0, took.whole.ran);
            let stages = took.stages.map(|stage| stage.ran);
            points.push(Point { lattice, stages, whole, ..points[0].clone() });
        }
        let medians: Vec<Point> = all.iter().map(|(_, _, points)| middle(&points[1..])).collect();
        write(kept, &medians)?;
        println!("round {round} of {rounds} is done");
    }
    Ok(())
}

/// One point of medians.
fn middle(rounds: &[Point]) -> Point {
    let of = |value: &dyn Fn(&Point) -> f64| median(rounds.iter().map(value).collect());
    let stages = std::array::from_fn(|index| of(&|point| point.stages[index]));
    Point { stages, whole: of(&|point| point.whole), ..rounds[0].clone() }
}

fn write(path: &Path, points: &[Point]) -> Result<(), Box<dyn Error>> {
    let mut out = csv::WriterBuilder::new().has_headers(false).from_path(path)?;
    points.iter().try_for_each(|point| out.serialize(point))?;
    Ok(out.flush()?)
}

fn read(path: &Path) -> Result<Vec<Point>, csv::Error> {
    csv::ReaderBuilder::new().has_headers(false).from_path(path)?.deserialize().collect()
}

/// The points of one sweep.
fn sweep<'a>(points: &'a [Point], axis: Axis, scene: &str) -> Vec<&'a Point> {
    points.iter().filter(|point| point.axis == axis && point.scene == scene).collect()
}

fn table(points: &[Point]) {
    println!("\nBase: {BASE}. Processor seconds of one thread.\n");
    let stages = STAGES.join(" | ");
    println!("| against | scene | from, to | seconds | slope | upper half | {stages} |");
    println!("|{}", " --- |".repeat(6 + STAGES.len()));
    for axis in AXES {
        for subject in &SUBJECTS {
            let sweep = sweep(points, axis, subject.name);
            let (Some(first), Some(last)) = (sweep.first(), sweep.last()) else { continue };
            let of = |points: &[&Point], value: &dyn Fn(&Point) -> f64| {
                let places: Vec<(f64, f64)> = points.iter().map(|p| (p.x, value(p))).collect();
                slope(&places).map_or_else(|| "–".into(), |slope| format!("{slope:.2}"))
            };
            let whole = |point: &Point| point.whole;
            let total: f64 = sweep.iter().map(|point| point.whole).sum();
            let stage = |index: usize| {
                let own: f64 = sweep.iter().map(|point| point.stages[index]).sum();
                let is_small = own < SMALL * total;
                if is_small { "–".into() } else { of(&sweep, &|point| point.stages[index]) }
            };
            let stages: Vec<String> = (0..STAGES.len()).map(stage).collect();
            println!(
                "| {} | {} | {:.3e}, {:.3e} | {:.2}, {:.2} | {} | {} | {} |",
                axis.title(),
                subject.name,
                first.x,
                last.x,
                first.whole,
                last.whole,
                of(&sweep, &whole),
                of(&sweep[sweep.len() / 2..], &whole),
                stages.join(" | ")
            );
        }
    }
    println!("\nTo be expected:");
    for axis in AXES {
        println!("- {}: {}", axis.title(), axis.expected());
    }
}
