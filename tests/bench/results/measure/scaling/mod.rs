//! How the cost of a render grows with photons, pixels, rays, voxels and optical thickness.
//!
//! One thing is varied at a time from a base; the others stay. Times are processor seconds of one thread,
//! which other programs on the machine hardly touch, without loading and writing: medians of rounds in
//! which all settings take turns. Told is, for each sweep, the slope of the logarithm of the time over
//! that of what is varied, by least squares, of the whole render over the upper half of the sweep, and of
//! the stage that does the work over all of it.

mod axis;
mod subject;

use std::path::Path;

use fogbow::study::slope;
use rayon::{ThreadPool, ThreadPoolBuilder};

use super::Kept;
use super::child::{argument, fogbow};
use super::scenes::shipped;
use super::spent::median;
use super::stages::{STAGES, timed};
use crate::pages::Result;
use crate::pages::scaling::Row;

use axis::{AXES, Axis};
use subject::{SUBJECTS, Settings, Subject};

const ROUNDS: usize = 3;

/// Of a stage that takes less than this share of a sweep no slope is told.
const SMALL: f64 = 0.02;

/// Photons of the renders whose memory is told.
const MANY: u64 = 10_000_000;

/// What a setting took.
#[derive(Clone)]
struct Point {
    /// What is varied.
    x: f64,
    /// Whether light in the medium was kept on a lattice, and not with photons along the ray.
    lattice: bool,
    /// Seconds of each stage.
    stages: [f64; STAGES.len()],
    /// Seconds of the render.
    whole: f64,
}

/// A part a sweep of a scene, and one a scene for memory.
pub fn measure(kept: &mut Kept<Row>, quick: bool) -> Result<()> {
    let pool = ThreadPoolBuilder::new().num_threads(1).build()?;
    let folder = tempfile::tempdir()?;
    for subject in &SUBJECTS[..if quick { 1 } else { SUBJECTS.len() }] {
        for axis in AXES {
            kept.part(&format!("{} against {}", subject.name, axis.title()), || {
                let Some(sweep) = subject.sweep(axis, quick, folder.path())? else {
                    return Ok(Vec::new());
                };
                let rounds = if quick { 1 } else { ROUNDS };
                let points = points(subject, &sweep, rounds, &pool, folder.path())?;
                Ok(rows(axis, subject.name, &points))
            })?;
        }
    }
    for name in ["smoke", "cloud"] {
        kept.part(&format!("memory of {name}"), || {
            memory(name, if quick { 10_000 } else { MANY })
        })?;
    }
    Ok(())
}

/// Medians of rounds in which all settings of a sweep take turns.
fn points(
    subject: &Subject,
    sweep: &[(f64, Settings)],
    rounds: usize,
    pool: &ThreadPool,
    folder: &Path,
) -> Result<Vec<Point>> {
    let mut all: Vec<Vec<Point>> = sweep.iter().map(|_| Vec::new()).collect();
    for _ in 0..rounds {
        for ((x, settings), points) in sweep.iter().zip(&mut all) {
            points.push(point(subject, *x, settings, pool, folder)?);
        }
    }
    Ok(all.iter().map(|rounds| middle(rounds)).collect())
}

fn point(
    subject: &Subject,
    x: f64,
    settings: &Settings,
    pool: &ThreadPool,
    folder: &Path,
) -> Result<Point> {
    let scene = subject.scene(settings, folder)?;
    let took = timed(&scene, pool)?;
    Ok(Point {
        x,
        lattice: took.rendered.work.tracks > 0,
        stages: took.stages.map(|stage| stage.ran),
        whole: took.whole.ran,
    })
}

/// One point of medians.
fn middle(rounds: &[Point]) -> Point {
    let of = |value: &dyn Fn(&Point) -> f64| median(rounds.iter().map(value).collect());
    let stages = std::array::from_fn(|index| of(&|point| point.stages[index]));
    Point { stages, whole: of(&|point| point.whole), ..rounds[0].clone() }
}

fn rows(axis: Axis, scene: &str, points: &[Point]) -> Vec<Row> {
    let each = points.iter().map(|point| Row::Point {
        axis: axis.title().into(),
        scene: scene.into(),
        x: point.x,
        lattice: point.lattice,
        stages: point.stages,
        whole: point.whole,
    });
    let [Some(first), Some(last)] = [points.first(), points.last()] else { return Vec::new() };
    let of = |points: &[Point], value: &dyn Fn(&Point) -> f64| {
        let places: Vec<(f64, f64)> = points.iter().map(|p| (p.x, value(p))).collect();
        slope(&places)
    };
    let total = |value: &dyn Fn(&Point) -> f64| points.iter().map(value).sum::<f64>();
    let stage = axis.stage();
    let is_small = total(&|p| p.stages[stage]) < SMALL * total(&|p| p.whole);
    let slope = Row::Slope {
        axis: axis.title().into(),
        scene: scene.into(),
        ends: [first.x, last.x],
        whole: of(&points[points.len() / 2..], &|point| point.whole),
        stage: if is_small { None } else { of(points, &|point| point.stages[stage]) },
    };
    each.chain([slope]).collect()
}

/// The most memory that a render of many photons takes.
fn memory(name: &str, photons: u64) -> Result<Vec<Row>> {
    let folder = tempfile::tempdir()?;
    let (scene, output) = (shipped(name), folder.path().join("out.exr"));
    let (own, count) =
        (["render", argument(&scene)?, "-o", argument(&output)?], photons.to_string());
    let small = ["--size", "32x24", "--rays", "1", "--photons", &count, "--json", "--quiet"];
    let report = fogbow(&[&own[..], &small].concat())?;
    let bytes = report["peak_memory"].as_f64().ok_or("no peak is told")?;
    Ok(vec![Row::Memory { scene: name.into(), photons, megabytes: 1e-6 * bytes }])
}
