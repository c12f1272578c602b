//! The director: what its maps say, and that what they hand out does no harm.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use assert_cmd::Command;
use fogbow::director::{Snapshot, x_map};
use fogbow::image::{Film, Window, read_exr, read_layers};
use fogbow::math::{Ray, Rgb, Span, World, luminance};
use fogbow::medium::{Density, Medium};
use fogbow::render::{Progress, Silent, render};
use fogbow::scene::plan::Needs;
use fogbow::scene::{
    Directed, Directing, Director, Importance, LoadOptions, Operator, RenderSettings, Scene,
    Strategy, StrategyRequest,
};

use fogbow::study::metric::{default_epsilon, relative_map};

use crate::skip;

fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("volumes").join(name)
}

fn load(path: &Path, size: [u32; 2], rays: u32, photons: u64) -> Scene {
    Scene::load(path, &LoadOptions::default().size(size).rays(rays).photons(photons)).unwrap()
}

fn written(folder: &Path, text: &str) -> Scene {
    let path = folder.join("scene.toml");
    std::fs::write(&path, text).unwrap();
    Scene::load(&path, &LoadOptions::default()).unwrap()
}

fn layer(film: &Film, name: &str) -> Vec<f64> {
    film.layer(name).unwrap().iter().map(|v| f64::from(*v)).collect()
}

/// A wall that fills the view, with no medium in front of it: X is 1 everywhere.
const WALL: &str = r#"
    [camera]
    position = [0, 0, 3]
    target = [0, 0, 0]
    [film]
    size = [40, 24]
    [render]
    rays = 5
    [[surface]]
    shape = "plane"
    point = [0, 0, 0]
    normal = [0, 0, 1]
    [[light]]
    type = "point"
    position = [1, 1, 2]
    intensity = 3.0
"#;

#[test]
fn full_importance_gives_the_fixed_picture() {
    let folder = tempfile::tempdir().unwrap();
    let scene = written(folder.path(), WALL);
    let fixed = render(&scene, &scene.render, &Silent).unwrap().film;
    let directing = Directing { x: Importance::Transmittance, ..Directing::default() };
    let settings = RenderSettings { director: Director::X, directing, ..scene.render };
    assert_eq!(render(&scene, &settings, &Silent).unwrap().film, fixed);
}

#[test]
fn full_weights_give_the_fixed_picture_of_smoke() {
    let scene = load(&shipped("smoke.toml"), [24, 24], 6, 20_000);
    let fixed = render(&scene, &scene.render, &Silent).unwrap().film;
    // Weights this large make every X but 0 count as 1.
    let directing = Directing {
        x: Importance::Transmittance,
        weights: [1e6, 0.0],
        operator: Operator::Sum,
        ..Directing::default()
    };
    let settings = RenderSettings { director: Director::Xs, directing, ..scene.render };
    assert_eq!(render(&scene, &settings, &Silent).unwrap().film, fixed);
}

#[test]
fn no_importance_gives_the_floor() {
    let folder = tempfile::tempdir().unwrap();
    let nothing = WALL.replace("target = [0, 0, 0]", "target = [0, 0, 9]");
    let scene = written(folder.path(), &nothing);
    let directing = Directing { floor: 2, ..by_scattering(&scene).directing };
    for director in [Director::X, Director::S, Director::Xs] {
        let settings = RenderSettings { director, directing, ..scene.render };
        let film = render(&scene, &settings, &Silent).unwrap().film;
        assert!(layer(&film, "rays").iter().all(|rays| *rays == 2.0), "{director:?}");
        assert!(layer(&film, "xs").iter().all(|xs| *xs == 0.0), "{director:?}");
    }
}

#[test]
fn what_is_handed_out_is_recorded() {
    // So many photons that error is that of rays.
    let most = 128;
    let scene = load(&shipped("smoke.toml"), [48, 48], most, 200_000);
    let most = f64::from(most);
    let directing = Directing { directed: Directed::ALL, ..scene.render.directing };
    let by_error = RenderSettings { director: Director::Xs, directing, ..scene.render };
    // Error is measured by four rays.
    for (settings, floor) in [(by_error, 4.0), (by_scattering(&scene), 1.0)] {
        let film = render(&scene, &settings, &Silent).unwrap().film;
        let [rays, radius, step, xs] = ["rays", "radius", "step", "xs"].map(|n| layer(&film, n));
        assert!(rays.iter().all(|n| (floor..=most).contains(n)));
        for i in 0..xs.len() {
            assert_eq!(rays[i], (most * xs[i]).round().clamp(floor, most), "pixel {i}");
        }
        let spread = |v: &[f64]| {
            v.iter().copied().fold(0.0, f64::max) / v.iter().copied().fold(f64::INFINITY, f64::min)
        };
        assert!(spread(&radius) > 1.5 && spread(&step) > 1.5 && spread(&rays) > 2.0);
    }
}

/// Voxel grids: those that ship, and the public ones where they are.
fn assets() -> Vec<PathBuf> {
    let scenes = ["smoke", "cloud", "fire", "balls_a", "balls_b"];
    let scenes = scenes.map(|name| shipped(&format!("{name}.toml")));
    let public = [
        "smoke/smoke_v222.vdb",
        "smoke/smoke_v223_blosc.vdb",
        "cloud/singlecloud.vdb",
        "gas_sequence/fluid_data_0007.vdb",
        "gas_sequence/fluid_data_0010.vdb",
        "levelset/sphere.vdb",
    ];
    let public = public.map(|name| shipped("../../shared/volumes").join(name));
    let is_there = |path: &PathBuf| {
        let there = path.exists();
        if !there {
            skip::skip(path.display());
        }
        there
    };
    scenes.into_iter().chain(public).filter(is_there).collect()
}

/// Transmittance through grids by an independent sum over very small steps.
#[test]
fn x_is_the_exact_transmittance() {
    const SIDE: u32 = 12;
    for path in assets() {
        let level_set_as_fog = path.ends_with("sphere.vdb");
        let options = LoadOptions { level_set_as_fog, ..LoadOptions::default().size([SIDE; 2]) };
        let scene = Scene::load(&path, &options).unwrap();
        let (sight, _) = Snapshot::look(&scene, scene.film.size, 0, Needs::EVERYTHING);
        let (x, _) = x_map(&scene, &sight, Needs::EVERYTHING);
        let mut crossed = 0;
        for (index, found) in x.iter().enumerate() {
            let [column, row] =
                [index % SIDE as usize, index / SIDE as usize].map(|i| i as f64 + 0.5);
            let ray = scene.camera.ray(column, row, [0.5; 2]);
            let depth: Rgb =
                scene.media.iter().map(|medium| through(medium, &ray, sight.depth[index])).sum();
            crossed += usize::from(depth.max_element() > 0.0);
            let seen = sight.depth[index].is_finite()
                || scene.lights.environment_radiance(ray.direction).max_element() > 0.0;
            let expected = if seen { luminance((-depth).exp()) } else { 0.0 };
            let off = (f64::from(*found) - expected).abs();
            assert!(off < 1e-4, "{}, pixel {index}: {found} for {expected}", path.display());
        }
        assert!(crossed > 10, "{}: {crossed} rays meet it", path.display());
    }
}

/// Optical depth of a grid along `ray` up to `end`.
fn through(medium: &Medium, ray: &Ray<World>, end: f64) -> Rgb {
    const STEPS: u32 = 40_000;
    let Density::Voxel(_) = &medium.density else { panic!("not a grid") };
    let span = medium.density.bounds().unwrap().clip(ray).intersect(Span::new(0.0, end));
    let dt = span.length() / f64::from(STEPS);
    let at = |i: u32| ray.at(span.start + (f64::from(i) + 0.5) * dt);
    let sum: f64 =
        if dt > 0.0 { (0..STEPS).map(|i| medium.density.value(at(i))).sum() } else { 0.0 };
    medium.sigma_t * (sum * dt)
}

/// Rays handed out by importance or variance: over 64 seeds no tile differs from the fixed render's. Nine tiles
/// each and a bound of 4 standard errors make a false alarm of 1.2e-3 for the whole test, at fixed seeds.
#[test]
fn handing_out_rays_does_not_bias() {
    const SEEDS: u64 = 64;
    const TILE: usize = 16;
    let mut scene = load(&shipped("smoke.toml"), [48, 48], 8, 4_000);
    // No pilot for each of so many pictures.
    scene.render.strategy = StrategyRequest::Asked(Strategy::FluenceTowardEye);
    let tiles = |settings: &RenderSettings| {
        let film = render(&scene, settings, &Silent).unwrap().film;
        let light = layer(&film, "G");
        let mean = |tile: usize| {
            let (left, top) = (tile % 3 * TILE, tile / 3 * TILE);
            let rows = (top..top + TILE).flat_map(|y| &light[y * 48 + left..][..TILE]);
            rows.sum::<f64>() / (TILE * TILE) as f64
        };
        std::array::from_fn::<f64, 9, _>(mean)
    };
    let directing = by_scattering(&scene).directing;
    let directing = Directing { directed: Directed::RAYS, tolerance: 0.3, ..directing };
    let fixed: Vec<[f64; 9]> =
        (0..SEEDS).map(|seed| tiles(&RenderSettings { seed, ..scene.render })).collect();
    for director in [Director::Xs, Director::Variance] {
        let mut differences = [[0.0; SEEDS as usize]; 9];
        for seed in 0..SEEDS {
            let directed = tiles(&RenderSettings { seed, director, directing, ..scene.render });
            for tile in 0..9 {
                differences[tile][seed as usize] = directed[tile] - fixed[seed as usize][tile];
            }
        }
        for (tile, differences) in differences.iter().enumerate() {
            let n = SEEDS as f64;
            let mean = differences.iter().sum::<f64>() / n;
            let variance = differences.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (n - 1.0);
            let error = (variance / n).sqrt();
            assert!(mean.abs() <= 4.0 * error, "{director:?}, tile {tile}: {mean} ± {error}");
        }
    }
}

#[test]
fn the_same_on_any_number_of_threads() {
    let scene = load(&shipped("smoke.toml"), [40, 40], 8, 20_000);
    let directed = |director| RenderSettings { director, ..scene.render };
    let variance = directed(Director::Variance);
    for settings in [directed(Director::Xs), by_scattering(&scene), variance, by_error(&scene)] {
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| render(&scene, &settings, &Silent).unwrap().film)
        };
        assert_eq!(on(1), on(2), "{settings:?}");
    }
}

/// Settings that direct by how uncertain scattered light is, and by saliency.
fn by_scattering(scene: &Scene) -> RenderSettings {
    let directing = Directing::default().by(Importance::Scattering);
    RenderSettings { director: Director::Xs, directing, ..scene.render }
}

/// Settings that direct rays by measured error, whatever is salient.
fn by_error(scene: &Scene) -> RenderSettings {
    let directing = Directing {
        x: Importance::Error,
        operator: Operator::Tolerance,
        weights: [1.0, 0.0],
        directed: Directed::RAYS,
        ..Directing::default()
    };
    RenderSettings { director: Director::Xs, directing, ..scene.render }
}

/// Rays that measured error hands out have less error than as many spread evenly, both reconstructed, against eight times
/// as many. Seeds are fixed.
#[test]
fn rays_by_measured_error_beat_even_ones() {
    let scene = load(&shipped("balls_b.toml"), [64, 64], 32, 50_000);
    // No pilot of strategies for each of so many pictures.
    let strategy = StrategyRequest::Asked(Strategy::FluenceTowardEye);
    let [mut directed, mut even] = [0.0; 2];
    for seed in 0..2 {
        let of = |settings: RenderSettings| {
            render(&scene, &RenderSettings { strategy, ..settings }, &Silent).unwrap().film
        };
        let own = of(RenderSettings { seed, ..by_error(&scene) });
        let rays = layer(&own, "rays");
        let mean = rays.iter().sum::<f64>() / rays.len() as f64;
        assert!(mean < 16.0 && rays.contains(&32.0) && rays.contains(&4.0), "{mean} rays");
        let truth = of(RenderSettings { rays: 256, seed: seed + 100, ..scene.render });
        let rays = mean.ceil() as u32;
        let uniform = of(RenderSettings { rays, reconstruct: true, seed, ..scene.render });
        directed += error(&own, &truth);
        even += error(&uniform, &truth);
    }
    assert!(directed < 0.9 * even, "{directed} to {even}");
}

/// Mean of the relative squared errors of pixels without the largest hundredth.
fn error(film: &Film, truth: &Film) -> f64 {
    let [film, truth] = [film, truth].map(Film::image);
    let epsilon = default_epsilon(&truth).unwrap();
    relative_map(&truth, &film, epsilon).trimmed_mean(0.01)
}

/// The importance of a pixel is that of the whole frame, in any crop of it.
#[test]
fn crops_have_the_importance_of_the_whole() {
    let scene = load(&shipped("smoke.toml"), [40, 40], 16, 20_000);
    let settings = by_error(&scene);
    let whole = render(&scene, &settings, &Silent).unwrap().film;
    let window = Window { left: 9, top: 13, width: 20, height: 11 };
    let crop = RenderSettings { crop: Some(window), ..settings };
    let part = render(&scene, &crop, &Silent).unwrap().film;
    for name in ["xs", "rays", "saliency"] {
        let (all, part) = (layer(&whole, name), layer(&part, name));
        for (index, found) in part.iter().enumerate() {
            let (x, y) = (9 + index % 20, 13 + index / 20);
            assert_eq!(*found, all[y * 40 + x], "{name} at {x}, {y}");
        }
    }
}

/// Saliency lets error pass where nobody looks: it takes rays from pixels, and adds none.
#[test]
fn tolerance_spares_rays_where_nothing_is_salient() {
    let scene = load(&shipped("smoke.toml"), [48, 48], 16, 20_000);
    let plain = by_error(&scene);
    let directing = Directing { weights: [1.0, 1.0], ..plain.directing };
    let tolerant = RenderSettings { directing, ..plain };
    let [plain, tolerant] = [plain, tolerant].map(|s| render(&scene, &s, &Silent).unwrap().film);
    let [x, xs, s] = [(&plain, "xs"), (&tolerant, "xs"), (&tolerant, "saliency")]
        .map(|(film, name)| layer(film, name));
    for pixel in 0..x.len() {
        let right = x[pixel] / (2.0 - s[pixel]);
        assert!((xs[pixel] - right).abs() < 1e-5, "{} for {right}", xs[pixel]);
    }
}

#[test]
fn the_papers_director_is_made_of_its_parts() {
    let scene = load(&shipped("smoke.toml"), [32, 32], 8, 20_000);
    let paper = RenderSettings { director: Director::XsPaper, ..scene.render };
    let directing = Directing {
        x: Importance::Transmittance,
        weights: [0.5, 0.5],
        operator: Operator::Sum,
        directed: Directed::RAYS,
        ..Directing::default()
    };
    let parts = RenderSettings { director: Director::Xs, directing, ..scene.render };
    let [paper, parts] = [paper, parts].map(|s| render(&scene, &s, &Silent).unwrap().film);
    assert_eq!(paper, parts);
    assert!(layer(&paper, "rays").iter().any(|rays| *rays < 8.0));
}

#[test]
fn variance_spares_rays_but_not_in_the_dark() {
    let folder = tempfile::tempdir().unwrap();
    let scene = written(folder.path(), &WALL.replace("rays = 5", "rays = 64"));
    let directing = Directing { floor: 4, tolerance: 0.5, ..Directing::default() };
    let settings = RenderSettings { director: Director::Variance, directing, ..scene.render };
    let film = render(&scene, &settings, &Silent).unwrap().film;
    assert!(layer(&film, "rays").iter().all(|rays| *rays == 4.0));
    let dark = scene_without_light(folder.path());
    let film = render(&dark, &settings, &Silent).unwrap().film;
    assert!(layer(&film, "rays").iter().all(|rays| *rays == 64.0));
}

/// Units of the last stage, all and done.
#[derive(Default)]
struct Counted([AtomicU64; 2]);

impl Progress for Counted {
    fn stage(&self, _: &str, total: u64) {
        let Self([all, done]) = self;
        all.store(total, Ordering::Relaxed);
        done.store(0, Ordering::Relaxed);
    }

    fn advance(&self, units: u64) {
        self.0[1].fetch_add(units, Ordering::Relaxed);
    }

    fn finish(&self) {}
}

#[test]
fn rays_that_variance_spares_are_not_counted() {
    let folder = tempfile::tempdir().unwrap();
    let scene = written(folder.path(), &WALL.replace("rays = 5", "rays = 40"));
    let directing = Directing { floor: 12, tolerance: 0.5, ..Directing::default() };
    let settings = RenderSettings { director: Director::Variance, directing, ..scene.render };
    let counted = Counted::default();
    let film = render(&scene, &settings, &counted).unwrap().film;
    assert!(layer(&film, "rays").iter().all(|rays| *rays == 12.0));
    let [all, done] = counted.0.map(AtomicU64::into_inner);
    assert!(all > 0 && all == done, "{done} of {all}");
}

fn scene_without_light(folder: &Path) -> Scene {
    let (before, _) = WALL.split_once("[[light]]").unwrap();
    written(folder, before)
}

#[test]
fn a_kept_z_buffer_saves_every_intersection() {
    let folder = tempfile::tempdir().unwrap();
    let maps = |to: &str, more: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_fogbow"))
            .arg("maps")
            .arg(shipped("smoke.toml"))
            .args(["--size", "32x32", "--photons", "20000", "--json", "--quiet", "-o"])
            .arg(folder.path().join(to))
            .args(more)
            .assert();
        output.get_output().clone()
    };
    let report = |output: &std::process::Output| -> serde_json::Value {
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let first = maps("first", &[]);
    assert!(first.status.success());
    let z = folder.path().join("first/z.exr");
    let second = maps("second", &["--z", z.to_str().unwrap()]);
    assert!(second.status.success());
    let of = |output| report(output)["work"]["intersections"].as_u64().unwrap();
    assert!(of(&first) >= 32 * 32);
    assert_eq!(of(&second), 0);
    for name in ["x", "saliency", "xs"] {
        let read = |to: &str| read_layers(&folder.path().join(to).join(format!("{name}.exr")));
        let (one, other) = (read("first").unwrap(), read("second").unwrap());
        assert_eq!(one.channels, other.channels, "{name}");
    }
    let light = read_exr(&folder.path().join("first/false_medium.exr")).unwrap();
    assert_eq!((light.width(), light.height()), (32, 32));
    let picture = folder.path().join("first/x.exr");
    let wrong = maps("third", &["--z", picture.to_str().unwrap()]);
    assert_eq!(wrong.status.code(), Some(1));
    let message = String::from_utf8(wrong.stderr).unwrap();
    assert!(message.contains("x.exr") && message.contains("z.exr"), "{message}");
}
