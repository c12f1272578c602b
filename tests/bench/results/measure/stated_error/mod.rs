//! Stated against true errors, and what was foretold of the renders.
//!
//! Each scene is rendered to its goal with some seeds, and twice to a smaller error, which is the truth of noise: traced
//! references have more noise in the worst blocks after a minute. Light that all renders miss, and the bias of kernels and
//! cells, show in the brightness beside two traced references.

mod scenes;
mod worst;

use std::path::Path;

use fogbow::render::{self, Silent, StatedError, render, render_reference};
use fogbow::scene::{ErrorGoal, RenderSettings, Scene};
use fogbow::study::Interval;
use rayon::{ThreadPool, ThreadPoolBuilder};
use serde_json::Value;

use super::Kept;
use super::child::{argument, fogbow};
use super::halves::{Halves, Pixels, mean, mean_of, wide};
use super::spent::Spent;
use crate::pages::Result;
use crate::pages::stated_error::{Foretold, Row};
use scenes::{GoalScene, scenes};
use worst::{Truths, coarse};

/// Error of each picture of the truth over that of the pictures.
const TRUTH_SHARE: f64 = 0.5;

/// Seeds of the truth and of references: far from those of pictures.
const TRUTH_SEEDS: [u64; 2] = [1001, 1002];

/// Part of the truth's light below which a picture is counted as black.
const BLACK: f64 = 0.5;

/// Extent of a run.
struct Extent {
    seeds: u64,
    /// Every how many-th scene is taken.
    stride: usize,
    /// What the sides of pictures are divided by.
    part: u32,
    /// What goals are multiplied by.
    goal: f64,
    /// Rays a pixel of each reference.
    reference_rays: u32,
}

const WHOLE: Extent = Extent { seeds: 8, stride: 1, part: 1, goal: 1.0, reference_rays: 32 };
const QUICK: Extent = Extent { seeds: 3, stride: 5, part: 3, goal: 2.0, reference_rays: 4 };

/// A part a scene.
pub fn measure(kept: &mut Kept<Row>, quick: bool) -> Result<()> {
    let extent = if quick { QUICK } else { WHOLE };
    let pool = ThreadPoolBuilder::new().num_threads(1).build()?;
    let folder = kept.lasting("stated-error");
    for scene in scenes(&folder)?.iter().step_by(extent.stride) {
        kept.part(&scene.title, || Ok(vec![compare(scene, &extent, &pool, &folder)?]))?;
    }
    Ok(())
}

/// A picture that was rendered to an error.
struct Picture {
    pixels: Pixels,
    stated: Option<StatedError>,
    rays: f64,
    photons: f64,
    /// Processor seconds.
    seconds: f64,
}

impl Picture {
    fn new(scene: &Scene, goal: f64, seed: u64, pool: &ThreadPool) -> Result<Self> {
        let error = Some(ErrorGoal::Relative(goal));
        let settings = RenderSettings { error, seed, ..scene.render };
        let (rendered, spent) = Spent::on(|| pool.install(|| render(scene, &settings, &Silent)));
        let rendered = rendered?;
        let reached = rendered.error.ok_or("the error is not told")?;
        Ok(Self {
            pixels: wide(&rendered.film.image()),
            stated: reached.stated,
            rays: reached.rays.into(),
            photons: reached.photons as f64,
            seconds: spent.ran,
        })
    }
}

fn compare(scene: &GoalScene, extent: &Extent, pool: &ThreadPool, folder: &Path) -> Result<Row> {
    let size = scene.size(extent.part)?;
    let (goal, width) = (scene.goal * extent.goal, size[0] as usize);
    let loaded = scene.load(size)?;
    let of_seed = |goal: f64| {
        let loaded = &loaded;
        move |seed: u64| Picture::new(loaded, goal, seed, pool)
    };
    let pictures = (1..=extent.seeds).map(of_seed(goal)).collect::<Result<Vec<_>>>()?;
    let foretold = (1..).zip(&pictures).map(|(seed, picture)| {
        let foretold = pool.install(|| foretold_seconds(&loaded, goal, seed))?;
        Ok(foretold / picture.seconds)
    });
    let foretold = foretold.collect::<Result<Vec<f64>>>()?;
    let [a, b] = TRUTH_SEEDS.map(of_seed(TRUTH_SHARE * goal));
    let [a, b] = [a?.pixels, b?.pixels];
    let truths = Truths::new([&a, &b], width);

    // Squares of what was stated, and of what is true.
    let stated: Vec<f64> = pictures.iter().map(Picture::square).collect();
    let found: Vec<f64> = (0..pictures.len())
        .map(|own| {
            let others = pictures.iter().enumerate().filter(|(index, _)| *index != own);
            let others = mean_of(others.map(|(_, picture)| &picture.pixels));
            truths.worst_square(&pictures[own].pixels, &others)
        })
        .collect();
    let of_all = |value: fn(&Picture) -> f64| mean(&pictures.iter().map(value).collect::<Vec<_>>());
    let truth_light = light(&mean_of([&a, &b].into_iter()));
    let is_black = |picture: &&Picture| {
        picture.stated.is_none() || light(&picture.pixels) < BLACK * truth_light
    };
    let references = references(&loaded, extent.reference_rays, pool);
    let beside = Beside::new(&pictures, &references, width)?;
    Ok(Row {
        scene: scene.title.clone(),
        size,
        goal,
        seeds: extent.seeds,
        black: pictures.iter().filter(is_black).count(),
        stated: mean(&stated).sqrt(),
        uncertainty: of_all(|picture| picture.stated.map_or(0.0, |stated| stated.uncertainty)),
        found: jackknife(found.len(), |kept| 0.5 * mean_where(&found, kept).ln()),
        ratio: jackknife(found.len(), |kept| {
            0.5 * (mean_where(&stated, kept) / mean_where(&found, kept)).ln()
        }),
        brighter_percent: beside.brighter,
        bias_percent: beside.bias,
        rays: of_all(|picture| picture.rays),
        photons: of_all(|picture| picture.photons),
        seconds: of_all(|picture| picture.seconds),
        foretold: Foretold {
            seconds: Interval::from_values(&foretold),
            memory: foretold_memory(scene, goal, size, folder)?,
        },
    })
}

impl Picture {
    /// Square of the error that is stated, 0 where none is.
    fn square(&self) -> f64 {
        self.stated.map_or(0.0, |stated| stated.value.powi(2))
    }
}

/// Pictures beside the references.
struct Beside {
    /// How much brighter they are, in %, and its standard error.
    brighter: [f64; 2],
    /// Root of the mean squared bias of their blocks, in % of the radiance.
    bias: f64,
}

impl Beside {
    fn new(pictures: &[Picture], references: &[Pixels; 2], width: usize) -> Result<Self> {
        let halves = Halves::new(references.each_ref().map(|half| coarse(half, width)))?;
        let own: Vec<Pixels> = pictures.iter().map(|own| coarse(&own.pixels, width)).collect();
        let each: Vec<f64> = own
            .iter()
            .map(|picture| halves.brighter_percent(std::slice::from_ref(picture)))
            .collect();
        let brighter = mean(&each);
        let count = each.len() as f64;
        let squares: Vec<f64> = each.iter().map(|value| (value - brighter).powi(2)).collect();
        let of_pictures = mean(&squares) / (count - 1.0);
        // Both halves tell the noise of their mean.
        let [a, b] = halves.pictures().each_ref().map(light);
        let of_references = (100.0 * (a - b) / (a + b)).powi(2);
        let bias = mean(&halves.squared_bias(own.iter()));
        Ok(Self {
            brighter: [brighter, (of_pictures + of_references).sqrt()],
            bias: 100.0 * bias.max(0.0).sqrt(),
        })
    }
}

/// Sum of all pixels.
fn light(picture: &Pixels) -> f64 {
    picture.iter().flatten().sum()
}

/// Two traced pictures.
fn references(scene: &Scene, rays: u32, pool: &ThreadPool) -> [Pixels; 2] {
    TRUTH_SEEDS.map(|seed| {
        let settings = RenderSettings { rays, seed, ..scene.render };
        let rendered = pool.install(|| render_reference(scene, &settings, &Silent));
        wide(&rendered.film.image())
    })
}

/// Processor seconds that `fogbow plan` would foretell of a render to the error `goal` with this seed.
fn foretold_seconds(scene: &Scene, goal: f64, seed: u64) -> fogbow::Result<f64> {
    let error = Some(ErrorGoal::Relative(goal));
    let settings = RenderSettings { error, seed, ..scene.render };
    let (costs, spent) = Spent::on(|| render::costs(scene, &settings, 0));
    // The plan is of a clock, which stands still for no other program.
    Ok(costs?.seconds.total() * spent.ran / spent.elapsed)
}

/// The peak of memory that `fogbow plan` foretells over that which `fogbow render` tells.
fn foretold_memory(scene: &GoalScene, goal: f64, size: [u32; 2], folder: &Path) -> Result<f64> {
    let [width, height] = size;
    let (goal, size) = (goal.to_string(), format!("{width}x{height}"));
    let output = folder.join("memory.exr");
    let settings = ["--size", &size, "--error", &goal, "--threads", "1", "--json"];
    let plan = fogbow(&[&["plan", argument(&scene.path)?], &settings[..]].concat())?;
    let own = ["render", argument(&scene.path)?, "-o", argument(&output)?, "--quiet"];
    let report = fogbow(&[&own, &settings[..]].concat())?;
    let bytes = [&plan["memory"]["peak"], &report["peak_memory"]].map(Value::as_f64);
    let [Some(foretold), Some(taken)] = bytes else { return Err("no peak is told".into()) };
    Ok(foretold / taken)
}

/// The mean of the `values` whose index is to be kept.
fn mean_where(values: &[f64], kept: &dyn Fn(usize) -> bool) -> f64 {
    let kept = values.iter().enumerate().filter(|(index, _)| kept(*index));
    mean(&kept.map(|(_, value)| *value).collect::<Vec<_>>())
}

/// The interval of what `logarithm` tells of the kept ones of `count` values, by the jackknife (Miller 1974, "The Jackknife—A
/// Review"); nothing where it has no such logarithm.
fn jackknife(count: usize, logarithm: impl Fn(&dyn Fn(usize) -> bool) -> f64) -> Option<Interval> {
    let whole = logarithm(&|_| true);
    let pseudo = |left_out: usize| {
        let without = logarithm(&|index| index != left_out);
        (count as f64 * whole - (count as f64 - 1.0) * without).exp()
    };
    Interval::from_values(&(0..count).map(pseudo).collect::<Vec<_>>())
}
