//! What leaving out saves, what it costs that more could be left out, and how near the foretold
//! memory is.
//!
//! Ratios of one run: each scene as planned and with everything on, in turn, and the median of their
//! ratios over the rounds.

use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::time::Instant;

use fogbow::math::{Ray, Rgb, Span, World, WorldPoint};
use fogbow::medium::{Density, Media, Profile};
use fogbow::render::{Silent, render};
use fogbow::scene::{LoadOptions, Planning, RenderSettings, Scene};
use fogbow::shape::Region;
use glam::DVec3;

use super::Kept;
use super::child::{argument, fogbow};
use super::scenes::{shared, shipped};
use super::spent::median;
use crate::pages::Result;
use crate::pages::plan::Row;

const ROUNDS: usize = 7;

const CAMERA: &str = "[camera]\nposition = [0.0, 0.9, 6.0]\ntarget = [0.0, 0.8, 0.0]\nfov = 32.0\n\
                      [film]\nsize = [160, 120]\n[render]\nrays = 8\nphotons = 100000\n";
const LAMP: &str = "[[light]]\ntype = \"point\"\nposition = [2.0, 3.0, 1.0]\nintensity = 20.0\n";
const SPOT: &str = "[[light]]\ntype = \"spot\"\nposition = [4.0, 0.8, 0.0]\ntarget = [0.0, 0.8, 0.0]\n\
                    intensity = 30.0\nangle = 40.0\n";
const SUN: &str =
    "[[light]]\ntype = \"sun\"\ndirection = [-1.0, -1.0, -0.5]\nirradiance = 3.0\nangle = 0.0\n";
const SKY: &str = "[[light]]\ntype = \"environment\"\nradiance = 0.5\n";
const BALL: &str = "[[surface]]\nshape = \"sphere\"\ncenter = [0.0, 0.6, 0.0]\nradius = 0.4\n\
                    material = { type = \"diffuse\", reflectance = 0.6 }\n";
const FLOOR: &str = "[[surface]]\nshape = \"plane\"\npoint = [0.0, 0.0, 0.0]\n\
                     normal = [0.0, 1.0, 0.0]\n\
                     material = { type = \"diffuse\", reflectance = 0.5 }\n";
const FOG: &str = "[[medium]]\nregion = { box = { min = [-1.5, 0.0, -1.5], max = [1.5, 1.6, 1.5] } }\n\
                   sigma_t = 0.8\nalbedo = 0.9\n";
const SMOKE: &str = "[[medium]]\nfile = \"smoke.vdb\"\nsigma_t = 8.0\nalbedo = 0.9\n";
const SOOT: &str = "[[medium]]\nfile = \"smoke.vdb\"\nsigma_t = 8.0\nalbedo = 0.0\n";

/// A part a scene.
pub fn measure(kept: &mut Kept<Row>, quick: bool) -> Result<()> {
    let rounds = if quick { 1 } else { ROUNDS };
    for (name, tables) in [
        ("a ball on the ground, no medium", &[LAMP, BALL, FLOOR][..]),
        ("a ball in homogeneous fog", &[LAMP, BALL, FOG]),
        ("homogeneous fog alone", &[LAMP, FOG]),
        ("a spot on a box of fog", &[SPOT, FOG]),
        ("smoke under a sun", &[SUN, SMOKE]),
        ("smoke that only absorbs, under a sky", &[SKY, SOOT]),
    ] {
        kept.part(name, || {
            let times = everything_over_needed(&scene(tables)?, rounds)?;
            Ok(vec![Row::Everything { scene: name.into(), times }])
        })?;
    }
    let fog = "a ball in homogeneous fog";
    kept.part("generality", || Ok(vec![generality(fog, &scene(&[LAMP, BALL, FOG])?, rounds)?]))?;
    for (name, photons) in [("smoke", "2000000"), ("cloud", "500000"), ("road", "400000")] {
        kept.part(&format!("memory of {name}"), || memory(name, shipped(name), photons, quick))?;
    }
    match shared("cloud/singlecloud.vdb") {
        Some(path) => kept.part("memory of singlecloud.vdb", || {
            memory("singlecloud.vdb", path, "1000000", quick)
        })?,
        None => kept.note("singlecloud.vdb was not there."),
    }
    Ok(())
}

/// The peak that `fogbow plan` foretells against the one that `fogbow render` tells.
fn memory(name: &str, scene: PathBuf, photons: &str, quick: bool) -> Result<Vec<Row>> {
    let folder = tempfile::tempdir()?;
    let output = folder.path().join("out.exr");
    let photons = if quick { "20000" } else { photons };
    let settings = ["--size", "128x128", "--rays", "4", "--photons", photons, "--json"];
    let plan = fogbow(&[&["plan", argument(&scene)?], &settings[..]].concat())?;
    let own = ["render", argument(&scene)?, "-o", argument(&output)?, "--quiet"];
    let report = fogbow(&[&own, &settings[..]].concat())?;
    let bytes = [&plan["memory"]["peak"], &report["peak_memory"]].map(serde_json::Value::as_f64);
    let [Some(foretold), Some(taken)] = bytes else { return Err("no peak is told".into()) };
    let off = 100.0 * (foretold / taken - 1.0);
    Ok(vec![Row::Memory {
        scene: format!("{name}, {photons} photons"),
        off_percent: [off, off],
        taken_mib: Some(taken / f64::from(1 << 20)),
    }])
}

/// The scene of these tables; files are those of `volumes/`.
fn scene(tables: &[&str]) -> Result<Scene> {
    let folder = tempfile::tempdir()?;
    let smoke = Path::new(env!("CARGO_MANIFEST_DIR")).join("volumes/smoke.vdb");
    let text = CAMERA.to_owned() + &tables.concat();
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, text.replace("smoke.vdb", &smoke.display().to_string()))?;
    Ok(Scene::load(&path, &LoadOptions::default())?)
}

fn everything_over_needed(scene: &Scene, rounds: usize) -> Result<f64> {
    let mut ratios = Vec::new();
    for _ in 0..rounds {
        let needed = timed(scene, Planning::Needed)?;
        ratios.push(timed(scene, Planning::Everything)? / needed);
    }
    Ok(median(ratios))
}

/// Seconds of a render.
fn timed(scene: &Scene, planning: Planning) -> Result<f64> {
    let settings = RenderSettings { planning, ..scene.render };
    let start = Instant::now();
    render(scene, &settings, &Silent)?;
    Ok(start.elapsed().as_secs_f64())
}

/// How much longer than code that knows of nothing but one homogeneous region the marches of a render
/// on one thread take.
fn generality(name: &str, scene: &Scene, rounds: usize) -> Result<Row> {
    let [medium] = scene.media.iter().as_slice() else { return Err("not one medium".into()) };
    let Density::Homogeneous(region) = &medium.density else { return Err("no region".into()) };
    let rays: Vec<Ray<World>> = (0..2000)
        .map(|i| {
            let at = f64::from(i) / 1000.0 - 1.0;
            Ray::new(WorldPoint::new(at, 0.8, 6.0), DVec3::new(0.0, 0.1 * at, -1.0).normalize())
        })
        .collect();
    let mut profile = Profile::default();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let (mut shares, mut extras) = (Vec::new(), Vec::new());
    for _ in 0..rounds {
        let general = each(&rays, |ray| general(&mut profile, &scene.media, ray));
        let special = each(&rays, |ray| special(region, medium.sigma_t, ray));
        let start = Instant::now();
        let rendered = pool.install(|| render(scene, &scene.render, &Silent))?;
        let seconds = start.elapsed().as_secs_f64();
        let extra = (general - special).max(0.0);
        shares.push(extra * rendered.work.marches as f64 / seconds);
        extras.push(extra);
    }
    Ok(Row::Generality {
        scene: name.into(),
        percent: 100.0 * median(shares),
        nanoseconds: 1e9 * median(extras),
    })
}

fn general(profile: &mut Profile, media: &Media, ray: &Ray<World>) -> Rgb {
    profile.trace(media, ray, Span::AHEAD, 0.0, 0.5);
    profile.transmittance()
}

fn special(region: &Region, sigma_t: Rgb, ray: &Ray<World>) -> Rgb {
    let mut length = 0.0;
    region.spans(ray, Span::AHEAD, |piece| length += piece.length());
    (-sigma_t * length).exp()
}

/// Seconds for one of `rays`.
fn each(rays: &[Ray<World>], mut f: impl FnMut(&Ray<World>) -> Rgb) -> f64 {
    const REPEATS: usize = 50;
    let start = Instant::now();
    for ray in std::iter::repeat_n(rays, REPEATS).flatten() {
        black_box(f(black_box(ray)));
    }
    start.elapsed().as_secs_f64() / (rays.len() * REPEATS) as f64
}
