//! Photons, gathers and whole pictures a second, on one thread and on all, and what the crates that
//! photons are kept in do by themselves on the same photons, in the way of their own benchmarks. Rates
//! of one thread are those of a core.

mod bench;
mod crates;

use fogbow::math::{Ray, Rgb, Span, Stage, Stream, World, WorldPoint, warp};
use fogbow::photon::{Photon, PhotonAt, PhotonMap, PhotonMaps, PhotonSettings};
use fogbow::render::{PassSettings, PhotonPass, Silent, render};
use fogbow::scene::plan::Needs;
use fogbow::scene::{FinalGather, LoadOptions, Scene, Strategy, StrategyRequest};
use fogbow::strategy::Assignment;
use fogbow::work::Work;
use rayon::prelude::*;

use super::Kept;
use super::scenes::shipped;
use crate::pages::Result;
use crate::pages::rates::Row;

use bench::{Bench, Job};

const PHOTONS: u64 = 100_000;
const RAYS: u32 = 4;
const SIZE: u32 = 128;
/// Photons of the maps that are built on their own.
const STORED: u64 = 500_000;
/// Radius, in metres, of theirs along rays, and of gathers around a place.
const RADIUS: f32 = 0.02;
const AROUND: f32 = 0.06;
const ORIGIN: WorldPoint = WorldPoint::new(0.0, 0.0, 0.0);

/// A part a piece of work.
pub fn measure(kept: &mut Kept<Row>, quick: bool) -> Result<()> {
    let bench = Bench::new(quick)?;
    for name in ["smoke", "fire", "cloud", "road"] {
        kept.part(&format!("{name}: shoot and build"), || shooting(&bench, name))?;
    }
    for name in ["cloud", "road"] {
        kept.part(&format!("{name}: along camera rays"), || gathering(&bench, name))?;
    }
    kept.part("beside crates", || {
        let placed = ball();
        crates::compare(&bench, &placed, &placed[..50_000], &across(20_000))
    })?;
    for name in ["smoke", "fire", "cloud", "road"] {
        kept.part(&format!("{name}: picture"), || pictures(&bench, name))?;
    }
    Ok(())
}

fn shooting(bench: &Bench, name: &str) -> Result<Vec<Row>> {
    let scene = load(name)?;
    let (_, work) = shot(&scene, Strategy::FluenceTowardEye);
    let counts = [
        ("paths/s", PHOTONS as f64),
        ("stored/s", (work.volume_photons + work.surface_photons) as f64),
        ("flights/s", work.tracks as f64),
    ];
    let counts: Vec<_> = counts.into_iter().filter(|(_, count)| *count > 0.0).collect();
    Ok(bench.group(&[Job::of(format!("{name}: shoot and build"), &counts, || {
        shot(&scene, Strategy::FluenceTowardEye)
    })]))
}

fn gathering(bench: &Bench, name: &str) -> Result<Vec<Row>> {
    let scene = load(name)?;
    let (rays, (maps, _)) = (camera_rays(&scene), shot(&scene, Strategy::Beams));
    let found = rays.par_iter().map(|ray| beside(&maps, ray)).sum::<u64>() as f64;
    let counts = [("gathers/s", rays.len() as f64), ("photons/s", found)];
    Ok(bench.group(&[Job::of(format!("{name}: along camera rays"), &counts, || {
        rays.par_iter().map(|ray| beside(&maps, ray)).sum::<u64>()
    })]))
}

fn pictures(bench: &Bench, name: &str) -> Result<Vec<Row>> {
    let scene = load(name)?;
    let rays = f64::from(RAYS) * scene.film.size.map(f64::from).iter().product::<f64>();
    Ok(bench.group(&[Job::new(format!("{name}: picture"), ("rays/s", rays), || {
        render(&scene, &scene.render, &Silent).map(|rendered| rendered.work)
    })]))
}

/// A shipped scene, small.
fn load(name: &str) -> fogbow::Result<Scene> {
    let options = LoadOptions::default().size([SIZE, SIZE]).rays(RAYS).photons(PHOTONS);
    Scene::load(&shipped(name), &options)
}

/// The maps of a scene's photons, where rays are followed here, and what making them took.
fn shot(scene: &Scene, strategy: Strategy) -> (PhotonMaps, Work) {
    let needs = Needs::new(scene, &scene.render);
    let photons = PhotonSettings {
        photons: PHOTONS,
        traced: None,
        seed: 0,
        max_scatter: None,
        radius: None,
        levels: 0,
        needs,
        any_camera: false,
    };
    let settings = PassSettings {
        photons,
        pass: None,
        strategy: StrategyRequest::Asked(strategy),
        measures_one: false,
        final_gather: FinalGather::Auto,
        rays: 4,
        film_pixels: 1.0,
        gather_share: 1.0,
    };
    let assignment = Assignment::uniform(strategy, scene.media.iter().len(), "it is measured");
    let (pass, work) = PhotonPass::new(scene, &settings, &assignment, &|_| {})
        .expect("a shipped scene can be shot");
    (pass.maps, work)
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

/// How many photons lie around one.
fn around(map: &PhotonMap, p: &PhotonAt) -> u64 {
    let mut found = 0;
    map.within(p.at(ORIGIN), f64::from(AROUND), |_, _| found += 1);
    found
}

/// Rays across a ball of 1 m, from outside.
fn across(count: u64) -> Vec<Ray<World>> {
    (0..count)
        .map(|i| {
            let mut random = Stream::new(0, Stage::Test, i, 1);
            let from = 2.0 * warp::uniform_sphere(random.uniform2());
            let to = warp::uniform_sphere(random.uniform2()) * random.uniform().cbrt();
            Ray::new(WorldPoint::from_xyz(from), (to - from).normalize())
        })
        .collect()
}

/// Photons spread evenly in a ball of 1 m.
fn ball() -> Vec<PhotonAt> {
    (0..STORED)
        .map(|i| {
            let mut random = Stream::new(0, Stage::Test, i, 0);
            let place = warp::uniform_sphere(random.uniform2()) * random.uniform().cbrt();
            let direction = warp::uniform_sphere(random.uniform2());
            PhotonAt { place: place.as_vec3().to_array(), photon: Photon::new(Rgb::ONE, direction) }
        })
        .collect()
}
