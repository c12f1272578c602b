//! How much faster two threads are than one, stage by stage, and what of a render is serial.
//!
//!     cargo bench --bench threads                    # a quarter of an hour
//!     cargo bench --bench threads -- cloud road      # these scenes of volumes/
//!     cargo bench --bench threads -- --quick         # that it works
//!
//! One thread and two take turns; printed are medians over the rounds of the seconds, of the pairs'
//! ratios, and of how many of the two threads were busy: those that ran or only waited for a
//! processor that another program had. "Unhindered" is how much faster two threads would be without
//! other programs: as threads were busy, less what they ran longer together than one. A share s of
//! a stage that is serial leaves 2 / (1 + s) threads busy (Amdahl 1967, "Validity of the single
//! processor approach to achieving large scale computing capabilities"), whatever else the machine
//! does. The last column is that part in the whole render, without loading and writing; above 5 % it
//! is told once more below the table. How much the machine itself does at once is told by two renders
//! on a thread each, side by side: less than 2 times where processors share what they work with.

#![allow(clippy::print_stdout)]

mod spent;
mod stages;

use std::fmt;
use std::path::{Path, PathBuf};

use fogbow::image::{Film, write_exr, write_png};
use fogbow::scene::{LoadOptions, Scene};
use rayon::{ThreadPool, ThreadPoolBuilder};

use spent::{Spent, median};
use stages::{STAGES, Timed, timed};

/// Scenes of `volumes/` with the rays of a pixel: renders of 5 to 20 s.
const SCENES: [(&str, u32); 4] = [("smoke", 16), ("cloud", 2), ("road", 2), ("fire", 16)];

/// Pixels of the scene's own film, along each side, that one stands for.
const COARSER: u32 = 2;

/// Photons at most.
const PHOTONS: u64 = 400_000;

const ROUNDS: usize = 5;

/// Of a render this share may be serial in one stage.
const SERIAL: f64 = 0.05;

/// What the two renders side by side have less of, so that they take less of the time.
const SIDE_BY_SIDE: u32 = 4;

const LOAD: usize = STAGES.len();
const WRITE: usize = LOAD + 1;
const WHOLE: usize = WRITE + 1;
const ROWS: [&str; WHOLE + 1] =
    [STAGES[0], STAGES[1], STAGES[2], "loading", "writing", "the render"];

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let quick = words.iter().any(|word| word == "--quick");
    let named: Vec<&String> = words.iter().filter(|word| !word.starts_with('-')).collect();
    let folder = tempfile::tempdir().expect("a folder");
    let pools = [pool(1), pool(2)];
    for (name, rays) in SCENES {
        if named.is_empty() || named.iter().any(|word| *word == name) {
            compare(name, rays, quick, &pools, folder.path());
        }
    }
}

fn pool(threads: usize) -> ThreadPool {
    ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool")
}

/// A scene's table.
fn compare(name: &str, rays: u32, quick: bool, pools: &[ThreadPool; 2], folder: &Path) {
    let (rounds, part) = if quick { (1, 4) } else { (ROUNDS, 1) };
    let subject = Subject::new(name, rays, part);
    let small = Subject::new(name, rays, part * SIDE_BY_SIDE);
    let mut pairs = Vec::new();
    let mut beside = Vec::new();
    for round in 0..rounds {
        let turn = |threads: usize| subject.turn(&pools[threads - 1], folder);
        // Who goes first changes.
        pairs.push(if round % 2 == 0 {
            let one = turn(1);
            [one, turn(2)]
        } else {
            let two = turn(2);
            [turn(1), two]
        });
        beside.push(small.side_by_side());
    }
    println!("\n{name}: {subject}, {rounds} rounds");
    println!(
        "| stage | 1 thread, s | 2 threads, s | faster | range | unhindered | busy | serial | of the render |"
    );
    println!("|{}", " --- |".repeat(9));
    let middle = |value: &dyn Fn(&[Took; 2]) -> f64| median(pairs.iter().map(value).collect());
    let mut short = Vec::new();
    for (row, title) in ROWS.iter().enumerate() {
        let seconds = [0, 1].map(|threads| middle(&|pair| pair[threads][row].elapsed));
        if seconds[0] < 1e-3 {
            continue;
        }
        let ratio = |pair: &[Took; 2]| pair[0][row].elapsed / pair[1][row].elapsed;
        let ratios = || pairs.iter().map(ratio);
        let busy = |pair: &[Took; 2]| pair[1][row].busy().min(2.0);
        let unhindered = middle(&|pair| pair[0][row].unhindered() / pair[1][row].unhindered());
        let busy = middle(&busy);
        let serial = 2.0 / busy - 1.0;
        let of_whole = serial * middle(&|pair| pair[0][row].ran / pair[0][WHOLE].ran);
        println!(
            "| {title} | {:.3} | {:.3} | {:.2} | {:.2} to {:.2} | {unhindered:.2} | {busy:.2} | {:.1} % | {:.1} % |",
            seconds[0],
            seconds[1],
            median(ratios().collect()),
            ratios().fold(f64::INFINITY, f64::min),
            ratios().fold(0.0, f64::max),
            100.0 * serial,
            100.0 * of_whole
        );
        if of_whole > SERIAL {
            short.push(*title);
        }
    }
    println!("two renders side by side do {:.2} times what one does", median(beside));
    match &short[..] {
        [] => println!("no stage has a serial part above 5 % of the render"),
        _ => println!("serial parts above 5 % of the render: {}", short.join(", ")),
    }
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
    fn new(name: &str, rays: u32, part: u32) -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("volumes/{name}.toml"));
        let own = Scene::load(&path, &LoadOptions::default()).expect("a shipped scene");
        let size = own.film.size.map(|side| side / (COARSER * part));
        Self { path, size, rays, photons: own.render.photons.min(PHOTONS) / u64::from(part) }
    }

    fn load(&self) -> Scene {
        let options = LoadOptions::default().size(self.size).rays(self.rays).photons(self.photons);
        Scene::load(&self.path, &options).expect("a shipped scene")
    }

    /// Loads, renders and writes, all in `pool`.
    fn turn(&self, pool: &ThreadPool, folder: &Path) -> Took {
        let (scene, load) = Spent::on(|| pool.install(|| self.load()));
        let Timed { rendered, stages, whole } = timed(&scene, pool);
        let path = folder.join("out.exr");
        let (_, write) = Spent::on(|| pool.install(|| write(&path, &scene, &rendered.film)));
        let [photons, map, rays] = stages;
        [photons, map, rays, load, write, whole]
    }

    /// How much two threads do at once with a render each, in units of one alone.
    fn side_by_side(&self) -> f64 {
        let (scene, pools) = (self.load(), [pool(1), pool(1)]);
        let alone = timed(&scene, &pools[0]).whole.ran;
        let (_, together) = Spent::on(|| {
            std::thread::scope(|threads| {
                for pool in &pools {
                    threads.spawn(|| timed(&scene, pool));
                }
            });
        });
        2.0 * 2.0 * alone / together.ran
    }
}

impl fmt::Display for Subject {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { size: [width, height], rays, photons, .. } = self;
        write!(f, "{photons} photons, {width} x {height} pixels, {rays} rays a pixel")
    }
}

/// Writes as the command does, but for what stands in the header.
fn write(path: &Path, scene: &Scene, film: &Film) {
    let view = scene.film.shown();
    let (png, exr) = rayon::join(
        || write_png(&path.with_extension("png"), &film.image(), &view),
        || write_exr(path, film, &[]),
    );
    png.and(exr).expect("written");
}
