//! Eight merged passes against the whole.

use std::path::Path;

use fogbow::render::{self, SavedPhotons};
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

/// At least three: the error of each is taken against two halves of the others.
const SEEDS: u64 = 4;

/// Stages of a render after loading and pilot.
const SHOT: [&str; 3] = ["photons", "photon map", "rays"];

/// The rows of both ways.
pub fn measure(name: &str, quick: bool, pool: &ThreadPool, folder: &Path) -> Result<Vec<Row>> {
    let (divisor, seeds) = if quick { (4, 3) } else { (1, SEEDS) };
    let path = shipped(name);
    let size = scaled(&path, SIDE / divisor)?;
    let options = LoadOptions::default().size(size).rays(RAYS / divisor);
    let scene = Scene::load(&path, &options.photons(PHOTONS / u64::from(divisor)))?;
    let mut picture = Picture { scene, pool };
    let photons = folder.join(format!("{name}.fog"));
    let mut all = Vec::new();
    for seed in 1..=seeds {
        picture.scene.render.seed = seed;
        println!("    seed {seed}");
        all.push(Seed::new(&picture, &photons)?);
    }
    let row = |photons: &str, way: fn(&Seed) -> &Rendered| -> Result<Row> {
        let ratios = |value: &dyn Fn(usize) -> Result<f64>| -> Result<Interval> {
            let values = (0..all.len()).map(value).collect::<Result<Vec<_>>>()?;
            let interval = Interval::from_values(&values);
            interval.ok_or_else(|| format!("{values:?} have no mean").into())
        };
        let error = |which: usize| {
            let all = &all;
            move |seed: usize| -> Result<f64> {
                let truth = truth(all, seed)?;
                let [own, whole] = [way(&all[seed]), &all[seed].whole]
                    .map(|rendered| truth.errors_of(&rendered.pixels)[which]);
                Ok(own / whole)
            }
        };
        let over = |value: fn(&Rendered, &[&str]) -> f64, stages: &'static [&'static str]| {
            let all = &all;
            move |seed: usize| -> Result<f64> {
                Ok(value(way(&all[seed]), stages) / value(&all[seed].whole, stages))
            }
        };
        // Reading photons is not what the passes share.
        let stages: &[&str] = if photons == "saved" { &SHOT[2..] } else { &SHOT };
        Ok(Row::Passes(Passes {
            scene: name.into(),
            photons: photons.into(),
            size,
            rays: RAYS / divisor,
            passes: PASSES,
            seeds,
            error: ratios(&error(0))?,
            error_of_all: ratios(&error(1))?,
            brightness: ratios(&over(|of, _| of.pixels.iter().flatten().sum(), &[]))?,
            steps: ratios(&over(|of, _| of.steps, &[]))?,
            seconds: ratios(&over(Rendered::seconds, stages))?,
        }))
    };
    Ok(vec![row("saved", |seed| &seed.saved)?, row("shot anew", |seed| &seed.shot)?])
}

/// Two halves of the wholes of all seeds but this one.
fn truth(all: &[Seed], without: usize) -> Result<Halves> {
    let others: Vec<&Pixels> = (all.iter().enumerate())
        .filter(|(index, _)| *index != without)
        .map(|(_, seed)| &seed.whole.pixels)
        .collect();
    let (a, b) = others.split_at(others.len() / 2);
    Halves::new([a, b].map(|half| mean_of(half.iter().copied())))
}

/// A picture, whole or merged of passes, and what it took.
struct Rendered {
    pixels: Pixels,
    /// Of marches.
    steps: f64,
    /// Processor seconds of each of [`SHOT`].
    stages: [f64; SHOT.len()],
}

impl Rendered {
    /// Of the whole, or the mean of passes.
    fn new(parts: &[Watched<render::Rendered>]) -> Self {
        let pictures: Vec<Pixels> = parts.iter().map(|p| wide(&p.done.film.image())).collect();
        Self {
            pixels: mean_of(pictures.iter()),
            steps: parts.iter().map(|part| part.done.work.march_steps as f64).sum(),
            stages: SHOT.map(|stage| parts.iter().map(|part| part.stage(stage).ran).sum()),
        }
    }

    /// Processor seconds of `stages`.
    fn seconds(&self, stages: &[&str]) -> f64 {
        let own = SHOT.iter().zip(self.stages).filter(|(stage, _)| stages.contains(stage));
        own.map(|(_, seconds)| seconds).sum()
    }
}

/// The whole of a seed, and both merged pictures.
struct Seed {
    whole: Rendered,
    saved: Rendered,
    shot: Rendered,
}

impl Seed {
    fn new(picture: &Picture<'_>, photons: &Path) -> Result<Self> {
        let taken = picture.save(photons)?;
        let saved = SavedPhotons::open(photons, &picture.scene)?;
        let whole = || picture.part(None, None, None);
        let [mut by_saved, mut by_shot, mut wholes] = [(); 3].map(|()| Vec::new());
        for number in 1..=PASSES {
            let pass = Some(PicturePass { count: PASSES, number });
            by_saved.push(picture.part(pass, None, Some(&saved))?);
            by_shot.push(picture.part(pass, None, None)?);
            // In the middle, so that a machine that slows down hits all.
            if number == PASSES / 2 {
                wholes.push(whole()?);
            }
        }
        let mut saved = Rendered::new(&by_saved);
        // The whole fills cells by its rays, the saved photons have them.
        saved.stages[SHOT.len() - 1] += taken.stage("cells").ran;
        saved.steps += taken.done.work.march_steps as f64;
        Ok(Self { whole: Rendered::new(&wholes), saved, shot: Rendered::new(&by_shot) })
    }
}
