//! Eight merged passes against the whole.

use std::path::Path;

use fogbow::render::{Rendered, SavedPhotons};
use fogbow::scene::{LoadOptions, PicturePass, Scene};
use fogbow::study::Interval;
use rayon::ThreadPool;

use super::parts::Picture;
use crate::measure::halves::{Halves, Pixels, mean_of, wide};
use crate::measure::scenes::{scaled, shipped};
use crate::measure::stages::Watched;
use crate::pages::Result;
use crate::pages::farm::{Passes, Row};

/// Pixels of the longer side.
const SIDE: u32 = 256;

/// Passes, with eight rays each.
const PASSES: u32 = 8;
const RAYS: u32 = 8 * PASSES;

const PHOTONS: u64 = 200_000;

const SEEDS: u64 = 6;

/// What a picture of the truth has more of, rays and photons.
const TRUTH: u32 = 4;

/// Stages of a render after the pilot.
const SHOT: [&str; 3] = ["photons", "photon map", "rays"];

/// Those of a render by saved photons that reading leaves.
const READ: [&str; 1] = ["rays"];

/// The rows of both ways.
pub fn measure(name: &str, quick: bool, pool: &ThreadPool, folder: &Path) -> Result<Vec<Row>> {
    let (divisor, seeds) = if quick { (4, 2) } else { (1, SEEDS) };
    let path = shipped(name);
    let size = scaled(&path, SIDE / divisor)?;
    let load = |seed: u64, more: u32| -> Result<Picture<'_>> {
        let options = LoadOptions::default().size(size).rays(RAYS / divisor * more);
        let photons = PHOTONS / u64::from(divisor) * u64::from(more);
        let mut scene = Scene::load(&path, &options.photons(photons))?;
        scene.render.seed = seed;
        Ok(Picture { scene, pool })
    };
    let truth = |seed: u64| -> Result<Pixels> {
        let rendered = load(seed, TRUTH)?.part(None, None, None)?;
        Ok(wide(&rendered.done.film.image()))
    };
    let truth = Halves::new([truth(1_000_001)?, truth(1_000_002)?])?;
    let mut ways = [Ratios::default(), Ratios::default()];
    for seed in 1..=seeds {
        let picture = load(seed, 1)?;
        let photons = folder.join(format!("{name}.fog"));
        picture.save(&photons)?;
        let saved = SavedPhotons::open(&photons, &picture.scene)?;
        for (ratios, saved, stages) in
            ways.iter_mut().zip([Some(&saved), None]).zip([&READ[..], &SHOT]).map(flat)
        {
            // Half of the passes come before the whole, so that a machine that slows down hits both.
            let pass = |number: u32| {
                picture.part(Some(PicturePass { count: PASSES, number }), None, saved)
            };
            let mut passes = (1..=PASSES / 2).map(pass).collect::<Result<Vec<_>>>()?;
            let whole = picture.part(None, None, saved)?;
            for number in PASSES / 2 + 1..=PASSES {
                passes.push(pass(number)?);
            }
            ratios.add(&passes, &whole, stages, &truth);
        }
    }
    let [saved, shot] = ways;
    let row = |ratios: Ratios, photons: &str| -> Result<Row> {
        Ok(Row::Passes(Passes {
            scene: name.into(),
            photons: photons.into(),
            size,
            rays: RAYS / divisor,
            passes: PASSES,
            seeds,
            error: interval(&ratios.error)?,
            error_of_all: interval(&ratios.error_of_all)?,
            brightness: interval(&ratios.brightness)?,
            steps: interval(&ratios.steps)?,
            seconds: interval(&ratios.seconds)?,
        }))
    };
    Ok(vec![row(saved, "saved")?, row(shot, "shot anew")?])
}

fn flat<A, B, C>(((a, b), c): ((A, B), C)) -> (A, B, C) {
    (a, b, c)
}

fn interval(values: &[f64]) -> Result<Interval> {
    Interval::from_values(values).ok_or_else(|| format!("{values:?} have no mean").into())
}

/// Of merged passes over the whole, a value a seed.
#[derive(Default)]
struct Ratios {
    error: Vec<f64>,
    error_of_all: Vec<f64>,
    brightness: Vec<f64>,
    steps: Vec<f64>,
    seconds: Vec<f64>,
}

impl Ratios {
    fn add(
        &mut self,
        passes: &[Watched<Rendered>],
        whole: &Watched<Rendered>,
        stages: &[&str],
        truth: &Halves,
    ) {
        let pictures: Vec<Pixels> = passes.iter().map(|p| wide(&p.done.film.image())).collect();
        let merged = mean_of(pictures.iter());
        let picture = wide(&whole.done.film.image());
        let [of_merged, of_whole] = [&merged, &picture].map(|picture| truth.errors_of(picture));
        let sum = |picture: &Pixels| picture.iter().flatten().sum::<f64>();
        let steps = |part: &Watched<Rendered>| part.done.work.march_steps as f64;
        let seconds = |part: &Watched<Rendered>| -> f64 {
            stages.iter().map(|stage| part.stage(stage).ran).sum()
        };
        self.error.push(of_merged[0] / of_whole[0]);
        self.error_of_all.push(of_merged[1] / of_whole[1]);
        self.brightness.push(sum(&merged) / sum(&picture));
        self.steps.push(passes.iter().map(steps).sum::<f64>() / steps(whole));
        self.seconds.push(passes.iter().map(seconds).sum::<f64>() / seconds(whole));
    }
}
