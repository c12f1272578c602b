//! What leaving out saves, and what it costs that more could be left out.
//!
//! `cargo bench --bench plan`. Ratios of one run: each scene as planned and with everything on, in
//! turn, and the median of their ratios over the rounds.

#![allow(clippy::print_stdout)]

use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use fogbow::math::{Ray, Rgb, Span, World, WorldPoint};
use fogbow::medium::{Density, Media, Profile};
use fogbow::render::{Rendered, Silent, render};
use fogbow::scene::{LoadOptions, Planning, RenderSettings, Scene};
use fogbow::shape::Region;
use glam::DVec3;

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

fn main() {
    println!("median of {ROUNDS} rounds: time with everything on over time as planned");
    for (name, tables) in [
        ("no medium: a ball on the ground", &[LAMP, BALL, FLOOR][..]),
        ("a ball in homogeneous fog", &[LAMP, BALL, FOG]),
        ("homogeneous fog alone", &[LAMP, FOG]),
        ("a spot on a box of fog", &[SPOT, FOG]),
        ("smoke under a sun", &[SUN, SMOKE]),
        ("smoke that absorbs alone, under a sky", &[SKY, SOOT]),
    ] {
        println!("{name:40} {:6.2}", everything_over_needed(&scene(tables)));
    }
    let (share, nanoseconds) = generality(&scene(&[LAMP, BALL, FOG]));
    println!(
        "a ball in homogeneous fog: {:.2} % of its time ({nanoseconds:.1} ns a march) goes to what \
         other scenes need",
        100.0 * share
    );
}

/// The scene of these tables; files are those of `volumes/`.
fn scene(tables: &[&str]) -> Scene {
    let folder = tempfile::tempdir().expect("a folder");
    let smoke = Path::new(env!("CARGO_MANIFEST_DIR")).join("volumes/smoke.vdb");
    let text = CAMERA.to_owned() + &tables.concat();
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, text.replace("smoke.vdb", &smoke.display().to_string()))
        .expect("written");
    Scene::load(&path, &LoadOptions::default()).expect("a scene")
}

fn everything_over_needed(scene: &Scene) -> f64 {
    let ratios = (0..ROUNDS).map(|_| {
        let [needed, all] = [Planning::Needed, Planning::Everything].map(|p| timed(scene, p).0);
        all / needed
    });
    median(ratios.collect())
}

/// Seconds of a render, and the render.
fn timed(scene: &Scene, planning: Planning) -> (f64, Rendered) {
    let settings = RenderSettings { planning, ..scene.render };
    let start = Instant::now();
    let rendered = render(scene, &settings, &Silent).expect("a picture");
    (start.elapsed().as_secs_f64(), rendered)
}

/// Share of a render on one thread that its marches take longer than code that knows of nothing but
/// one homogeneous region, and by how many nanoseconds each.
fn generality(scene: &Scene) -> (f64, f64) {
    let [medium] = scene.media.iter().as_slice() else { panic!("one medium") };
    let Density::Homogeneous(region) = &medium.density else { panic!("a region") };
    let rays: Vec<Ray<World>> = (0..2000)
        .map(|i| {
            let at = f64::from(i) / 1000.0 - 1.0;
            Ray::new(WorldPoint::new(at, 0.8, 6.0), DVec3::new(0.0, 0.1 * at, -1.0).normalize())
        })
        .collect();
    let mut profile = Profile::default();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
    let rounds = (0..ROUNDS).map(|_| {
        let general = each(&rays, |ray| general(&mut profile, &scene.media, ray));
        let special = each(&rays, |ray| special(region, medium.sigma_t, ray));
        let (seconds, rendered) = pool.install(|| timed(scene, Planning::Needed));
        let extra = (general - special).max(0.0);
        (extra * rendered.work.marches as f64 / seconds, extra)
    });
    let (shares, extras): (Vec<f64>, Vec<f64>) = rounds.unzip();
    (median(shares), 1e9 * median(extras))
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

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    values[values.len() / 2]
}
