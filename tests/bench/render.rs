//! Photons, gathers and whole pictures a second, on one thread and on all.
//!
//! `cargo bench --bench render`

#![allow(clippy::print_stdout)]

use std::error::Error;
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use fogbow::math::{Ray, Rgb, Span, Stage, Stream, World, WorldPoint, warp};
use fogbow::photon::{BeamMap, Photon, PhotonMap, PhotonMaps, Placed, Shooting, shoot};
use fogbow::render::{Silent, render};
use fogbow::scene::plan::Needs;
use fogbow::scene::{LoadOptions, Overrides, Scene};
use glam::Vec3;
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

const ROUNDS: usize = 5;
const PHOTONS: u64 = 100_000;
const RAYS: u32 = 4;
const SIZE: u32 = 128;
/// Photons of the maps that are built on their own.
const STORED: u64 = 500_000;

fn main() -> Result<(), Box<dyn Error>> {
    let all = std::thread::available_parallelism()?.get();
    let pools = [pool(1)?, pool(all)?];
    let many = format!("{all} threads");
    let title = format!("median of {ROUNDS} rounds");
    println!("{title:32} {:>12} {many:>12} {:>9}", "1 thread", "speed-up");

    for name in ["smoke", "fire"] {
        let scene = load(name)?;
        let unit = ("photon paths/s", PHOTONS as f64);
        measure(&pools, &format!("{name}: shoot"), unit, || drop(maps(&scene)));
    }

    let placed = ball();
    let stored = ("photons/s", STORED as f64);
    let (origin, radius) = (WorldPoint::new(0.0, 0.0, 0.0), 0.02);
    let radii = vec![radius as f32; placed.len()];
    measure(&pools, "build a beam map", stored, || drop(BeamMap::new(origin, &placed, &radii)));
    measure(&pools, "build a surface map", stored, || drop(PhotonMap::new(origin, &placed)));

    for name in ["smoke", "fire"] {
        let scene = load(name)?;
        let (rays, maps) = (camera_rays(&scene), maps(&scene));
        let count: u64 = rays.par_iter().map(|ray| beside(&maps, ray)).sum();
        let each = count as f64 / rays.len() as f64;
        let label = format!("{name}: along a ray ({each:.0} found)");
        measure(&pools, &label, ("gathers/s", rays.len() as f64), || {
            black_box(rays.par_iter().map(|ray| beside(&maps, ray)).sum::<u64>());
        });
    }
    let map = PhotonMap::new(origin, &placed);
    let points = &placed[..50_000];
    let around = |p: &Placed| {
        let mut found = 0;
        map.within(WorldPoint::from_xyz(Vec3::from(p.place).as_dvec3()), radius, |_, _| found += 1);
        found
    };
    let each = points.iter().map(around).sum::<u64>() as f64 / points.len() as f64;
    let unit = ("gathers/s", points.len() as f64);
    measure(&pools, &format!("around a place ({each:.0} found)"), unit, || {
        black_box(points.par_iter().map(around).sum::<u64>());
    });

    for name in ["smoke", "fire", "cloud", "road"] {
        let scene = load(name)?;
        let rays = f64::from(RAYS) * scene.film.size.map(f64::from).iter().product::<f64>();
        measure(&pools, &format!("{name}: picture"), ("rays/s", rays), || {
            black_box(render(&scene, &scene.render, &Silent).expect("a shipped scene renders"));
        });
    }
    Ok(())
}

fn pool(threads: usize) -> Result<ThreadPool, rayon::ThreadPoolBuildError> {
    ThreadPoolBuilder::new().num_threads(threads).build()
}

/// Prints the median rate in each pool, the rounds of the pools taken in turn.
fn measure(
    pools: &[ThreadPool; 2],
    name: &str,
    (unit, count): (&str, f64),
    work: impl Fn() + Sync,
) {
    let mut seconds = [const { Vec::new() }; 2];
    for _ in 0..ROUNDS {
        for (pool, seconds) in pools.iter().zip(&mut seconds) {
            let start = Instant::now();
            pool.install(&work);
            seconds.push(start.elapsed().as_secs_f64());
        }
    }
    let [one, many] = seconds.map(|mut seconds| {
        seconds.sort_by(f64::total_cmp);
        count / seconds[ROUNDS / 2]
    });
    println!("{name:32} {one:12.0} {many:12.0} {:8.2}x  {unit}", many / one);
}

/// A shipped scene, small.
fn load(name: &str) -> fogbow::Result<Scene> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("volumes");
    let overrides = Overrides {
        size: Some([SIZE, SIZE]),
        rays: Some(RAYS),
        photons: Some(PHOTONS),
        ..Overrides::default()
    };
    let options = LoadOptions { overrides, ..LoadOptions::default() };
    Scene::load(&folder.join(format!("{name}.toml")), &options)
}

fn maps(scene: &Scene) -> PhotonMaps {
    let needs = Needs::of(scene, &scene.render);
    let shooting = Shooting {
        photons: PHOTONS,
        traced: None,
        pixels: 1.0,
        seed: 0,
        max_scatter: None,
        final_gather: scene.render.final_gather,
        denoise: scene.render.denoise,
        radius: None,
        levels: 0,
        needs,
    };
    shoot(scene, &shooting, &|_| {}).expect("a shipped scene can be shot").0
}

/// One ray through each pixel.
fn camera_rays(scene: &Scene) -> Vec<Ray<World>> {
    let at = |i: u32| f64::from(i) + 0.5;
    let pixels = (0..SIZE).flat_map(|y| (0..SIZE).map(move |x| (x, y)));
    pixels.map(|(x, y)| scene.camera.ray(at(x), at(y), [0.5; 2])).collect()
}

/// Gathers along a ray; returns how many photons it met.
fn beside(maps: &PhotonMaps, ray: &Ray<World>) -> u64 {
    let mut found = 0;
    maps.volume[0].along(ray, Span::AHEAD, 1.0, |_| found += 1);
    found
}

/// Photons spread evenly in a ball of 1 m.
fn ball() -> Vec<Placed> {
    (0..STORED)
        .map(|i| {
            let mut random = Stream::new(0, Stage::Test, i, 0);
            let place = warp::uniform_sphere(random.uniform2()) * random.uniform().cbrt();
            let direction = warp::uniform_sphere(random.uniform2());
            Placed { place: place.as_vec3().to_array(), photon: Photon::new(Rgb::ONE, direction) }
        })
        .collect()
}
