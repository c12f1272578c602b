//! How much faster two threads are than one, stage by stage, and what of a render is serial.
//!
//! One thread and two take turns; told are medians over the rounds of the seconds, of the pairs' ratios,
//! and of how many of the two threads were busy: those that ran or only waited for a processor that
//! another program had. "Unhindered" is how much faster two threads would be without other programs: as
//! threads were busy, less what they ran longer together than one. A share s of a stage that is serial
//! leaves 2 / (1 + s) threads busy (Amdahl 1967, "Validity of the single processor approach to achieving
//! large scale computing capabilities"), whatever else the machine does.

use std::path::{Path, PathBuf};

use fogbow::image::{Film, write_exr, write_png};
use fogbow::scene::{LoadOptions, Scene};
use rayon::{ThreadPool, ThreadPoolBuilder};

use super::Kept;
use super::scenes::shipped;
use super::spent::{Spent, median};
use super::stages::{STAGES, Timed, timed};
use crate::pages::Result;
use crate::pages::threads::Row;

/// Scenes of `volumes/` with the rays of a pixel: renders of 5 to 20 s.
const SCENES: [(&str, u32); 4] = [("smoke", 16), ("cloud", 2), ("road", 2), ("fire", 16)];

/// Pixels of the scene's own film, along each side, that one stands for.
const COARSER: u32 = 2;

/// Photons at most.
const PHOTONS: u64 = 400_000;

const ROUNDS: usize = 5;

/// What the two renders side by side have less of, so that they take less of the time.
const SIDE_BY_SIDE: u32 = 4;

const LOAD: usize = STAGES.len();
const WRITE: usize = LOAD + 1;
const WHOLE: usize = WRITE + 1;
const ROWS: [&str; WHOLE + 1] =
    [STAGES[0], STAGES[1], STAGES[2], "loading", "writing", "the render"];

/// A part a scene.
pub fn measure(kept: &mut Kept<Row>, quick: bool) -> Result<()> {
    let folder = tempfile::tempdir()?;
    let pools = [pool(1)?, pool(2)?];
    for (name, rays) in SCENES {
        kept.part(name, || compare(name, rays, quick, &pools, folder.path()))?;
    }
    Ok(())
}

fn pool(threads: usize) -> Result<ThreadPool> {
    Ok(ThreadPoolBuilder::new().num_threads(threads).build()?)
}

/// A scene's rows: its stages, and two renders side by side.
fn compare(
    name: &str,
    rays: u32,
    quick: bool,
    pools: &[ThreadPool; 2],
    folder: &Path,
) -> Result<Vec<Row>> {
    let (rounds, part) = if quick { (1, 4) } else { (ROUNDS, 1) };
    let subject = Subject::new(name, rays, part)?;
    let small = Subject::new(name, rays, part * SIDE_BY_SIDE)?;
    let (mut pairs, mut beside) = (Vec::new(), Vec::new());
    for round in 0..rounds {
        let turn = |threads: usize| subject.turn(&pools[threads - 1], folder);
        // Who goes first changes.
        pairs.push(if round % 2 == 0 {
            let one = turn(1)?;
            [one, turn(2)?]
        } else {
            let two = turn(2)?;
            [turn(1)?, two]
        });
        beside.push(small.side_by_side()?);
    }
    let stages = ROWS.iter().enumerate().filter_map(|(row, title)| stage(name, row, title, &pairs));
    let side_by_side = Row {
        scene: name.into(),
        stage: "two renders side by side".into(),
        seconds: None,
        faster: Some(median(beside.clone())),
        range: Some(ends(&beside)),
        unhindered: None,
        busy: None,
        serial_percent: None,
    };
    Ok(stages.chain([side_by_side]).collect())
}

/// What one thread and two took for a stage; nothing where it hardly took any time.
fn stage(name: &str, row: usize, title: &str, pairs: &[[Took; 2]]) -> Option<Row> {
    let middle = |value: &dyn Fn(&[Took; 2]) -> f64| median(pairs.iter().map(value).collect());
    let seconds = [0, 1].map(|threads| middle(&|pair| pair[threads][row].elapsed));
    if seconds[0] < 1e-3 {
        return None;
    }
    let ratios: Vec<f64> =
        pairs.iter().map(|pair| pair[0][row].elapsed / pair[1][row].elapsed).collect();
    let busy = middle(&|pair| pair[1][row].busy().min(2.0));
    let serial = 2.0 / busy - 1.0;
    let share = middle(&|pair| pair[0][row].ran / pair[0][WHOLE].ran);
    Some(Row {
        scene: name.into(),
        stage: title.into(),
        seconds: Some(seconds),
        faster: Some(median(ratios.clone())),
        range: Some(ends(&ratios)),
        unhindered: Some(middle(&|pair| pair[0][row].unhindered() / pair[1][row].unhindered())),
        busy: Some(busy),
        serial_percent: Some(100.0 * serial * share),
    })
}

/// The least and the largest.
fn ends(values: &[f64]) -> [f64; 2] {
    let fold = |with: fn(f64, f64) -> f64, from| values.iter().copied().fold(from, with);
    [fold(f64::min, f64::INFINITY), fold(f64::max, 0.0)]
}

/// What each row took in one run.
type Took = [Spent; ROWS.len()];

/// A scene and how it is rendered.
struct Subject {
    path: PathBuf,
    size: [u32; 2],
    rays: u32,
    photons: u64,
}

impl Subject {
    /// One of `volumes/`, with one in `part` of its photons and pixels along each side.
    fn new(name: &str, rays: u32, part: u32) -> Result<Self> {
        let path = shipped(name);
        let own = Scene::load(&path, &LoadOptions::default())?;
        let size = own.film.size.map(|side| side / (COARSER * part));
        Ok(Self { path, size, rays, photons: own.render.photons.min(PHOTONS) / u64::from(part) })
    }

    fn load(&self) -> fogbow::Result<Scene> {
        let options = LoadOptions::default().size(self.size).rays(self.rays).photons(self.photons);
        Scene::load(&self.path, &options)
    }

    /// Loads, renders and writes, all in `pool`.
    fn turn(&self, pool: &ThreadPool, folder: &Path) -> Result<Took> {
        let (scene, load) = Spent::on(|| pool.install(|| self.load()));
        let scene = scene?;
        let Timed { rendered, stages, whole } = timed(&scene, pool)?;
        let path = folder.join("out.exr");
        let (written, write) = Spent::on(|| pool.install(|| write(&path, &scene, &rendered.film)));
        written?;
        let [photons, map, rays] = stages;
        Ok([photons, map, rays, load, write, whole])
    }

    /// How much two threads do at once with a render each, in units of one alone.
    fn side_by_side(&self) -> Result<f64> {
        let (scene, pools) = (self.load()?, [pool(1)?, pool(1)?]);
        let alone = timed(&scene, &pools[0])?.whole.ran;
        let (ended, together) = Spent::on(|| {
            std::thread::scope(|threads| {
                let both = pools.each_ref().map(|pool| threads.spawn(|| timed(&scene, pool)));
                both.map(|thread| thread.join().is_ok_and(|timed| timed.is_ok()))
            })
        });
        if ended.contains(&false) {
            return Err("a render side by side with another failed".into());
        }
        Ok(2.0 * 2.0 * alone / together.ran)
    }
}

/// Writes as the command does, but for what stands in the header.
fn write(path: &Path, scene: &Scene, film: &Film) -> fogbow::Result<()> {
    let view = scene.film.shown();
    let (png, exr) = rayon::join(
        || write_png(&path.with_extension("png"), &film.image(), &view),
        || write_exr(path, film, &[]),
    );
    png.and(exr)
}
