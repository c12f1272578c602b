//! The two pictures of a scene.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::super::candidate::Settings;
use super::super::job::{rendered, stages};
use super::super::machine::Machine;
use crate::error::Result;
use crate::image::{Picture, View};
use crate::scene::{Director, RenderSettings, Scene};

/// The version of the schema of `trial.json`.
pub(super) const SCHEMA: u32 = 1;

/// An experiment and how it was made: the schema of `trial.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Experiment {
    /// Its version.
    pub schema: u32,
    /// fogbow's version.
    pub version: String,
    /// The command line that made it.
    pub command: String,
    /// The machine that rendered it.
    pub machine: Machine,
    /// The scenes.
    pub scenes: Vec<ShownScene>,
}

/// A scene of an experiment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ShownScene {
    /// Its name in answers: that of its file without the ending.
    pub name: String,
    /// The scene file.
    pub file: PathBuf,
    /// Hash of the scene and of all files it names.
    pub hash: String,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// The seed of both pictures.
    pub seed: u64,
    /// Exposure in stops and view transform.
    pub view: View,
    /// Settings of the gold standard.
    pub gold: Settings,
    /// Settings of the directed picture.
    pub directed: Settings,
    /// Seconds that the gold standard took, without loading.
    pub gold_seconds: f64,
    /// Seconds that the directed picture took.
    pub directed_seconds: f64,
}

/// A scene with its two pictures as they are shown.
#[derive(Clone, Debug)]
pub struct Pair {
    /// What they are of.
    pub scene: ShownScene,
    /// The gold standard.
    pub gold: Picture,
    /// The directed picture.
    pub directed: Picture,
}

impl Pair {
    /// Renders both: what `fogbow render` makes with `--director fixed`, and with `--director xs`
    /// or the director that the scene's settings name, to the byte.
    ///
    /// # Errors
    /// Where an emitter cannot be sampled.
    pub fn render(scene: &Scene) -> Result<Self> {
        let with = |director| RenderSettings { director, ..scene.render };
        let director = match scene.render.director {
            Director::Fixed => Director::Xs,
            other => other,
        };
        let (gold, directed) = (with(Director::Fixed), with(director));
        let view = scene.film.shown();
        let shown = |settings: &RenderSettings| {
            let rendered = rendered(scene, settings, false)?;
            let seconds: f64 = stages(&rendered).iter().map(|(_, seconds)| seconds).sum();
            Ok::<_, crate::Error>((Picture::developed(&rendered.film.image(), &view), seconds))
        };
        let (gold_picture, gold_seconds) = shown(&gold)?;
        let (directed_picture, directed_seconds) = shown(&directed)?;
        let scene = ShownScene {
            name: name(scene),
            file: scene.path.clone(),
            hash: scene.hash.clone(),
            size: scene.film.size,
            seed: scene.render.seed,
            view,
            gold: Settings::from(&gold),
            directed: Settings::from(&directed),
            gold_seconds,
            directed_seconds,
        };
        Ok(Self { scene, gold: gold_picture, directed: directed_picture })
    }
}

/// The name of a scene's file without its ending and without control characters.
pub(super) fn name(scene: &Scene) -> String {
    let stem = scene.path.file_stem().unwrap_or(scene.path.as_os_str());
    stem.to_string_lossy().chars().filter(|c| !c.is_control()).take(100).collect()
}
