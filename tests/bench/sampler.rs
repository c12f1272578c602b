//! Trilinear samples a second along random rays: fogbow beside OpenVDB and NanoVDB, in one process
//! and on one thread.
//!
//! `cargo bench --bench sampler --features bench-peers` prints an object a line, which
//! `cargo bench --bench results -- --only sampler` makes a page of.

#![allow(clippy::print_stdout)]

mod peers;

use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant;

use fogbow::math::{Index, IndexPoint, Ray, Span, Stage, Stream, warp};
use fogbow::vdb::{Grid, ReadAs, VdbFile};

use peers::bridge::{Run, open_peers};

const RAYS: u64 = 4000;
const ROUNDS: usize = 15;
/// In voxels.
const STEP: f64 = 0.5;

fn main() -> Result<(), Box<dyn Error>> {
    let path = volume();
    let file = VdbFile::open(&path)?;
    let index = file.default_density()?;
    let grid = file.read_scalar(index, ReadAs::Density)?;
    let peers = open_peers(&path.display().to_string(), &file.grids()[index].name)?;

    let rays = rays(&grid);
    let steps: Vec<Run> = rays.iter().map(|(ray, span)| whole(ray, *span)).collect();
    let inside: Vec<Run> = rays.iter().flat_map(|(ray, span)| sampled(&grid, ray, *span)).collect();
    let (all, seen) = (count(&steps), count(&inside));
    let mut cells = 0;
    for (ray, span) in &rays {
        let _ = grid.cells(ray, *span, |_, _, _| {
            cells += 1;
            std::ops::ControlFlow::Continue(())
        });
    }
    let fogbow = || rays.iter().map(|(ray, span)| fogbow_sum(&grid, ray, *span)).sum();
    let integrate = || rays.iter().map(|(ray, span)| grid.integrate(ray, *span) / STEP).sum();
    // The rivals get the very points that fogbow evaluates, and need not find the empty blocks. On
    // whole rays, as a march would use them, they have to evaluate every step.
    let mut rows = [
        Row::new("fogbow samples", seen, fogbow),
        Row::new("OpenVDB BoxSampler", seen, || peers.openvdb(&inside, STEP)),
        Row::new("NanoVDB, places f64", seen, || peers.nanovdb_f64(&inside, STEP)),
        Row::new("NanoVDB, places f32", seen, || peers.nanovdb_f32(&inside, STEP)),
        Row::new("NanoVDB f64, whole rays", all, || peers.nanovdb_f64(&steps, STEP)),
        Row::new("fogbow exact, cells", cells, integrate),
    ];
    let rounds = if std::env::var_os("FOGBOW_QUICK").is_some() { 1 } else { ROUNDS };
    for _ in 0..rounds {
        rows.iter_mut().for_each(Row::time);
    }
    let fogbow = rows[0].median();
    let expected = rows[0].sum;
    for row in &rows {
        let (seconds, n) = (row.median(), row.count as f64);
        let told = serde_json::json!({
            "sampler": row.name,
            "times": seconds / fogbow,
            "nanoseconds": 1e9 * seconds / n,
        });
        println!("{told}");
        let off = (row.sum / expected - 1.0).abs();
        // The exact integral is not the sum of the steps, only near it.
        let allowed = if row.name.ends_with("cells") { 1e-2 } else { 1e-5 };
        assert!(off < allowed, "{} sums up to {}, not {expected}", row.name, row.sum);
    }
    Ok(())
}

/// What is timed.
struct Row<'a> {
    name: &'static str,
    count: u64,
    work: Box<dyn Fn() -> f64 + 'a>,
    seconds: Vec<f64>,
    sum: f64,
}

impl<'a> Row<'a> {
    fn new(name: &'static str, count: u64, work: impl Fn() -> f64 + 'a) -> Self {
        Self { name, count, work: Box::new(work), seconds: Vec::new(), sum: 0.0 }
    }

    fn time(&mut self) {
        let start = Instant::now();
        self.sum = std::hint::black_box((self.work)());
        self.seconds.push(start.elapsed().as_secs_f64());
    }

    fn median(&self) -> f64 {
        let mut seconds = self.seconds.clone();
        seconds.sort_by(f64::total_cmp);
        seconds[seconds.len() / 2]
    }
}

/// The public smoke where it is there, else the one that comes along.
fn volume() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let public = here.join("../shared/volumes/smoke/smoke_v222.vdb");
    if public.is_file() { public } else { here.join("volumes/smoke.vdb") }
}

/// Rays of unit speed through uniform points of the bounds in uniform directions, and where they
/// are inside.
fn rays(grid: &Grid<f32>) -> Vec<(Ray<Index>, Span)> {
    let (min, size) = (grid.bounds().min.xyz, grid.bounds().size());
    (0..RAYS)
        .map(|i| {
            let mut random = Stream::new(0, Stage::Test, i, 0);
            let u = std::array::from_fn(|_| random.uniform());
            let through = min + size * glam::DVec3::from_array(u);
            let direction = warp::uniform_sphere(random.uniform2());
            let ray = Ray::new(IndexPoint::from_xyz(through), direction);
            let span = grid.bounds().clip(&ray);
            (ray, span)
        })
        .collect()
}

fn fogbow_sum(grid: &Grid<f32>, ray: &Ray<Index>, span: Span) -> f64 {
    let mut sum = 0.0;
    grid.samples(ray, span, span.start + 0.5 * STEP, STEP, |_, value| sum += value);
    sum
}

fn run(ray: &Ray<Index>, first: f64, count: u32) -> Run {
    let (origin, direction) = (ray.origin.xyz.to_array(), ray.direction.to_array());
    Run { origin, direction, first, count }
}

/// All steps of a ray.
fn whole(ray: &Ray<Index>, span: Span) -> Run {
    run(ray, span.start + 0.5 * STEP, (span.length() / STEP).round() as u32)
}

/// The steps that fogbow evaluates: those outside blocks of zeros.
fn sampled(grid: &Grid<f32>, ray: &Ray<Index>, span: Span) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    grid.samples(ray, span, span.start + 0.5 * STEP, STEP, |t, _| match runs.last_mut() {
        Some(last) if t < last.first + (f64::from(last.count) + 0.5) * STEP => last.count += 1,
        _ => runs.push(run(ray, t, 1)),
    });
    runs
}

fn count(runs: &[Run]) -> u64 {
    runs.iter().map(|run| u64::from(run.count)).sum()
}
