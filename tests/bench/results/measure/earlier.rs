//! This build beside that of an earlier commit: noise, processor seconds and memory at the same settings.
//!
//! Both render scenes that ship, those of files beside the repository and a lamp in fog as programs of their own, in turn,
//! with seeds that differ.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use fogbow::image::read_exr;

use super::child::{argument, printed};
use super::halves::{Halves, Pixels, mean, mean_of, trimmed_mean, wide};
use super::scene_text::LAMP_IN_FOG;
use super::spent::median;
use super::strategy::{Series, StrategyScene, ratio, scenes_of_files};
use super::{Kept, LeftOut};
use crate::pages::Result;
use crate::pages::earlier::{Row, Side};
use crate::pages::strategy::Figures;

/// The environment variable of the earlier commit, as git names it.
const COMMIT: &str = "FOGBOW_EARLIER";

/// Tells processor seconds and the peak of memory of a program.
const TIME: &str = "/usr/bin/time";

/// Added to the seeds of this build, so that noise of both is independent.
const SEEDS_APART: usize = 1000;

/// Extent of a run.
struct Extent {
    /// An even number.
    seeds: usize,
    /// Every how many-th scene is taken.
    stride: usize,
}

const WHOLE: Extent = Extent { seeds: 8, stride: 1 };
const QUICK: Extent = Extent { seeds: 2, stride: 16 };

/// A part a scene.
pub fn measure(kept: &mut Kept<Row>, quick: bool) -> Result<()> {
    let extent = if quick { QUICK } else { WHOLE };
    let Ok(commit) = std::env::var(COMMIT) else {
        return Err(LeftOut(format!("{COMMIT} names no commit to compare with")).into());
    };
    if !Path::new(TIME).exists() {
        return Err(LeftOut(format!("there is no {TIME}; apt-get install time")).into());
    }
    let commit = resolved(&commit)?;
    kept.note(format!("The earlier build is that of commit {} (`{COMMIT}`).", &commit[..10]));
    let folder = kept.lasting("earlier");
    let programs = [built(&commit, &folder)?, env!("CARGO_BIN_EXE_fogbow").into()];
    let (mut all, left_out) = scenes_of_files()?;
    left_out.into_iter().for_each(|sentence| kept.note(sentence));
    all.push(StrategyScene { name: "lamp in fog".into(), text: LAMP_IN_FOG.into() });
    for scene in all.iter().step_by(extent.stride) {
        kept.part(&scene.name, || Ok(vec![compare(scene, &extent, &programs, &folder)?]))?;
    }
    Ok(())
}

/// The whole name of a commit.
fn resolved(commit: &str) -> Result<String> {
    let mut command = Command::new("git");
    command.current_dir(env!("CARGO_MANIFEST_DIR"));
    command.args(["rev-parse", "--verify", "--quiet", &format!("{commit}^{{commit}}")]);
    let name =
        printed(&mut command).map_err(|_| format!("{COMMIT} is {commit}: no such commit"))?;
    Ok(String::from_utf8(name)?.trim().into())
}

/// The program of a commit, built in `folder` unless it was before.
fn built(commit: &str, folder: &Path) -> Result<PathBuf> {
    let source = folder.join(commit);
    let program = source.join("target/release/fogbow");
    if program.exists() {
        return Ok(program);
    }
    let _ = fs::remove_dir_all(&source);
    let git = |arguments: &[&OsStr]| printed(Command::new("git").args(arguments));
    let repository = OsStr::new(env!("CARGO_MANIFEST_DIR"));
    let clone = ["clone", "--quiet", "--no-checkout"].map(OsStr::new);
    git(&[&clone[..], &[repository, source.as_os_str()]].concat())?;
    let checkout = ["checkout", "--quiet", commit].map(OsStr::new);
    git(&[&[OsStr::new("-C"), source.as_os_str()], &checkout[..]].concat())?;
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut build = Command::new(cargo);
    build.current_dir(&source).args(["build", "--release", "--quiet", "--bin", "fogbow"]);
    printed(build.env("CARGO_TARGET_DIR", source.join("target")))?;
    Ok(program)
}

/// Pictures of one program, and what they took.
#[derive(Default)]
struct Pictures {
    pixels: Vec<Pixels>,
    seconds: Vec<f64>,
    /// Peaks of memory, in MiB.
    memory: Vec<f64>,
}

impl Pictures {
    /// Renders `scene` with this seed.
    fn add(&mut self, program: &Path, scene: &Path, seed: usize) -> Result<()> {
        let (picture, spent) = (scene.with_extension("exr"), scene.with_extension("spent"));
        let mut command = Command::new(TIME);
        command.args(["--quiet", "-f", "%U %S %M", "-o", argument(&spent)?, argument(program)?]);
        command.args(["render", argument(scene)?, "--quiet", "--seed", &seed.to_string()]);
        printed(command.args(["-o", argument(&picture)?]))?;
        let told = fs::read_to_string(&spent)?;
        let numbers: std::result::Result<Vec<f64>, _> =
            told.split_whitespace().map(str::parse).collect();
        let [user, system, kilobytes] = numbers?[..] else {
            return Err(format!("{TIME} tells {told}").into());
        };
        self.pixels.push(wide(&read_exr(&picture)?));
        self.seconds.push(user + system);
        self.memory.push(kilobytes / 1024.0);
        Ok(())
    }

    /// The means of the pictures of the first half of the seeds and of the others.
    fn means(&self) -> [Pixels; 2] {
        let (first, second) = self.pixels.split_at(self.pixels.len() / 2);
        [first, second].map(|pictures| mean_of(pictures.iter()))
    }

    /// The noise of each picture, by its distance from the mean of all, which has some of it.
    fn noise(&self, relative: &Halves) -> Vec<f64> {
        let (count, mean) = (self.pixels.len() as f64, mean_of(self.pixels.iter()));
        let noise =
            |picture| trimmed_mean(relative.squares(picture, &mean)) * count / (count - 1.0);
        self.pixels.iter().map(noise).collect()
    }

    /// The light of each picture.
    fn light(&self) -> Vec<f64> {
        self.pixels.iter().map(|pixels| pixels.iter().flatten().sum()).collect()
    }
}

fn compare(
    scene: &StrategyScene,
    extent: &Extent,
    programs: &[PathBuf; 2],
    folder: &Path,
) -> Result<Row> {
    let path = folder.join("scene.toml");
    fs::write(&path, &scene.text)?;
    let mut sides = [Pictures::default(), Pictures::default()];
    for seed in 0..extent.seeds {
        // Who goes first changes.
        for turn in 0..2 {
            let side = (seed + turn) % 2;
            sides[side].add(&programs[side], &path, seed + side * SEEDS_APART)?;
        }
    }
    let [then, now] = sides.each_ref().map(Pictures::means);
    let relative = Halves::new([0, 1].map(|half| mean_of([&then[half], &now[half]].into_iter())))?;
    let noise = sides.each_ref().map(|side| side.noise(&relative));
    let difference = trimmed_mean(relative.squared_difference(&now, &then));
    // Where the means differ, this build takes the blame.
    let errors = [noise[0].clone(), noise[1].iter().map(|noise| noise + difference).collect()];
    let light = sides.each_ref().map(Pictures::light);
    // Ratios of two series of figures; light takes the place of errors where that is compared.
    let over = |values: &[Vec<f64>; 2], figure: fn(Figures) -> f64| {
        let [then, now] =
            [0, 1].map(|side| Series { errors: &values[side], seconds: &sides[side].seconds });
        ratio(&now, &then, 0..extent.seeds, figure)
    };
    let [earlier, of_now] = [0, 1].map(|side| Side {
        noise: mean(&noise[side]),
        seconds: mean(&sides[side].seconds),
        memory: median(sides[side].memory.clone()),
    });
    Ok(Row {
        scene: scene.name.clone(),
        earlier,
        now: of_now,
        difference,
        seconds: over(&errors, |of| of.seconds),
        noise: over(&noise, |of| of.error),
        cost: over(&errors, |of| of.cost()),
        light: over(&light, |of| of.error),
    })
}
