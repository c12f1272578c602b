//! Times between two frames of a sequence.

use std::path::Path;

use fogbow::math::{Rgb, WorldPoint};
use fogbow::medium::{Emission, Medium};
use fogbow::render::{Silent, render};
use fogbow::scene::{LoadOptions, Scene, Sequence};
use fogbow::sequence::FrameTime;
use fogbow::vdb::{Block, GridToWrite, ValueType, write};
use glam::{DQuat, DVec3, IVec3};

/// Edge of a voxel in metres.
const VOXEL: f64 = 0.1;

/// What trilinear lookups miss of the [`ball`], at most: an eighth of the squared edge times the second derivatives along three
/// axes, 4 over the squared radius each, twice where voxels are made anew.
const INTERPOLATION: f64 = 2.0 * 3.0 * VOXEL * VOXEL / 8.0 * 4.0 / SQUARED_RADIUS;

/// That of the ball in square metres.
const SQUARED_RADIUS: f64 = 0.49;

/// Places of lookups, in and around the smoke.
fn places() -> impl Iterator<Item = DVec3> {
    let at = |i: i32| f64::from(i) * 0.23 - 1.6;
    (0..15 * 15 * 15).map(move |i| DVec3::new(at(i / 225), at(i / 15 % 15), at(i % 15)))
}

/// A smooth ball of radius 0.7 m beside the origin.
fn ball(p: DVec3) -> f64 {
    let r = (p - DVec3::new(0.5, 0.0, 0.0)).length_squared() / SQUARED_RADIUS;
    (1.0 - r).max(0.0).powi(2)
}

/// A grid of what `value` gives of places within 1.6 m of the origin, in metres.
fn grid<const N: usize>(name: &str, value: impl Fn(DVec3) -> [f64; N]) -> GridToWrite {
    grid_on((VOXEL, DVec3::ZERO), name, value)
}

/// The same with voxels of another size, the first of which is at `first`.
fn grid_on<const N: usize>(
    (voxel, first): (f64, DVec3),
    name: &str,
    value: impl Fn(DVec3) -> [f64; N],
) -> GridToWrite {
    let mut grid = GridToWrite::fog(name, voxel, first);
    if N == 3 {
        (grid.value_type, grid.class) = (ValueType::Vec3, "unknown".into());
    }
    let half = (2.0 * VOXEL / voxel).ceil() as i32;
    let side = 2 * half;
    for i in 0..side.pow(3) {
        let origin = (IVec3::new(i / side / side, i / side % side, i % side) - half) * 8;
        let at = |slot: i32| origin + IVec3::new(slot >> 6, slot >> 3 & 7, slot & 7);
        let values = (0..512).flat_map(|slot| value(at(slot).as_dvec3() * voxel + first));
        let values: Vec<f32> = values.map(|v| v as f32).collect();
        if values.iter().any(|v| *v != 0.0) {
            grid.blocks.push(Block { origin, values, active: None });
        }
    }
    grid
}

/// Frames 12 and 13 of smoke, and a scene of it.
struct Frames(tempfile::TempDir);

impl Frames {
    /// Smoke that is `ball` at a place that `back` gives for the time after frame 12, in this `wind`.
    fn new(back: impl Fn(DVec3, f64) -> DVec3, wind: Option<&dyn Fn(DVec3) -> DVec3>) -> Self {
        let folder = tempfile::tempdir().unwrap();
        for (name, time) in [("smoke_0012.vdb", 0.0), ("smoke_0013.vdb", 1.0)] {
            let mut grids = vec![grid("density", |p| [ball(back(p, time))])];
            grids.extend(wind.map(|wind| grid("vel", |p| wind(p).to_array())));
            write(&folder.path().join(name), &grids).unwrap();
        }
        Self(folder)
    }

    fn folder(&self) -> &Path {
        self.0.path()
    }

    /// The scene with these keys of motion and of the medium.
    fn load(&self, motion: &str, medium: &str) -> fogbow::error::Result<Scene> {
        let path = self.folder().join("scene.toml");
        let file = if medium.contains("file") { "" } else { "file = 'smoke_####.vdb'" };
        let text = format!(
            "[camera]\nposition = [0, 0, 6]\ntarget = [0, 0, 0]\nnext = {{ position = [1, 0, 6], target = [1, 0, 0] }}\n\
             [film]\nsize = [8, 8]\n[render]\nrays = 4\nphotons = 500\n\
             [motion]\nfps = 1\n{motion}\n[[medium]]\n{file}\n{medium}\n\
             [[light]]\ntype = 'environment'\nradiance = 1.0\n"
        );
        std::fs::write(&path, text).unwrap();
        Scene::load(&path, &LoadOptions::default())
    }

    fn at(&self, motion: &str, medium: &str) -> Scene {
        self.load(motion, medium).unwrap()
    }
}

fn density(medium: &Medium, p: DVec3) -> f64 {
    medium.sigma_t_at(WorldPoint::from_xyz(p)).x
}

/// The largest difference of `medium` from what `expected` gives.
fn off(medium: &Medium, expected: impl Fn(DVec3) -> f64) -> f64 {
    places().map(|p| (density(medium, p) - expected(p)).abs()).fold(0.0, f64::max)
}

/// Metres a frame: no whole number of voxels.
const WIND: DVec3 = DVec3::new(-0.43, 0.27, 0.13);

fn in_wind() -> Frames {
    Frames::new(|p, time| p - WIND * time, Some(&|_| WIND))
}

/// Smoke in an even wind is halfway in the middle, and no double image; that of one lattice keeps its values.
#[test]
fn an_even_wind_carries_the_smoke_of_both_frames() {
    let frames = in_wind();
    for f in [0.25, 0.5, 0.9] {
        let scene = frames.at(&format!("frame = {}", 12.0 + f), "");
        assert_eq!(scene.notes.len(), 0, "{:?}", scene.notes);
        let off = off(scene.media.get(0), |p| ball(p - WIND * f));
        assert!(off < INTERPOLATION, "{f}: {off}");
    }
    // By whole voxels nothing is interpolated: each is that of both files.
    let wind = DVec3::new(0.4, -0.2, 0.2);
    let frames = Frames::new(|p, time| p - wind * time, Some(&|_| wind));
    let scene = frames.at("frame = 12.5", "");
    for i in 0..512 {
        let p = (IVec3::new(i / 64, i / 8 % 8, i % 8) - 4).as_dvec3() * VOXEL + wind * 0.5;
        let off = (density(scene.media.get(0), p) - ball(p - wind * 0.5)).abs();
        assert!(off < 1e-5, "{p}: {off}");
    }
}

/// Frames may have voxels of other sizes in other places, within reason.
#[test]
fn the_next_frame_may_have_another_lattice() {
    let frames = in_wind();
    let next = |voxel: f64| {
        let lattice = (voxel, DVec3::new(0.013, 0.04, -0.02));
        let grids = [
            grid_on(lattice, "density", |p| [ball(p - WIND)]),
            grid_on(lattice, "vel", |_| WIND.to_array()),
        ];
        write(&frames.folder().join("smoke_0013.vdb"), &grids).unwrap();
    };
    for voxel in [0.07, 0.12] {
        next(voxel);
        let off = off(frames.at("frame = 12.5", "").media.get(0), |p| ball(p - WIND * 0.5));
        assert!(off < 1.44 * INTERPOLATION, "{voxel}: {off}");
    }
    let huge = [grid_on((100.0, DVec3::ZERO), "density", |_| [1.0])];
    write(&frames.folder().join("smoke_0013.vdb"), &huge).unwrap();
    let problem = frames.load("frame = 12.5", "").unwrap_err().to_string();
    assert!(problem.contains("give frames whose voxels have about one size"), "{problem}");
}

/// In a vortex it turns on its way; the midpoint rule misses the arc by less than a hundredth of it.
#[test]
fn a_vortex_turns_the_smoke_of_both_frames() {
    let spin = 0.6;
    let back = |p: DVec3, time: f64| DQuat::from_rotation_z(-spin * time) * p;
    let frames = Frames::new(back, Some(&|p| DVec3::Z.cross(p) * spin));
    let scene = frames.at("frame = 12.4", "");
    let missed = off(scene.media.get(0), |p| ball(back(p, 0.4)));
    assert!(missed < INTERPOLATION + 0.03, "{missed}");
    let plain = frames.at("frame = 12.4", "velocity = 'none'");
    assert!(off(plain.media.get(0), |p| ball(back(p, 0.4))) > 0.05);
}

/// Without velocities each frame is there by its share, and a note says so; a medium that moves as a whole needs none.
#[test]
fn without_velocities_it_is_the_mean_of_both() {
    let frames = Frames::new(|p, time| p - WIND * time, None);
    let scene = frames.at("frame = 12.25", "");
    assert!(scene.notes[0].contains("has no velocities"), "{:?}", scene.notes);
    let whole = |number: i32| frames.at(&format!("frame = {number}"), "");
    let [first, second] = [whole(12), whole(13)];
    let mean = |p| 0.75 * density(first.media.get(0), p) + 0.25 * density(second.media.get(0), p);
    let off = |scene: &Scene, expected: &dyn Fn(DVec3) -> f64| off(scene.media.get(0), expected);
    assert!(off(&scene, &mean) < 1e-5, "{}", off(&scene, &mean));
    let motion = format!("motion = {{ translate = {:?} }}", WIND.to_array());
    let scene = frames.at("frame = 12.25", &motion);
    assert_eq!(scene.notes.len(), 0, "{:?}", scene.notes);
    let moved = |p| ball(p - WIND * 0.25);
    assert!(off(&scene, &moved) < INTERPOLATION, "{}", off(&scene, &moved));
}

/// A whole number is the picture of that file alone, bit for bit.
#[test]
fn whole_numbers_are_frames() {
    let frames = in_wind();
    let picture = |motion: &str, medium: &str| {
        let scene = frames.at(motion, medium);
        let film = render(&scene, &scene.render, &Silent).unwrap().film;
        film.layer("G").unwrap().iter().map(|v| v.to_bits()).collect::<Vec<_>>()
    };
    let alone = "file = 'smoke_0012.vdb'";
    for shutter in ["", "\nshutter = 0.5\ntimes = 2"] {
        let frame = picture(&format!("frame = 12{shutter}"), "");
        assert_eq!(frame, picture(shutter, alone));
        assert_ne!(frame, picture(&format!("frame = 12.5{shutter}"), ""));
    }
    // The last frame has none after it.
    assert_eq!(picture("frame = 13.0", ""), picture("", "file = 'smoke_0013.vdb'"));
}

/// Each part of a shutter is at its own time, before the frames and between them; the camera goes on by the same time.
#[test]
fn a_shutter_is_open_around_the_time() {
    let frames = in_wind();
    let scene = frames.at("frame = 12.25\nshutter = 1.0\ntimes = 4", "");
    for (time, f) in scene.times.iter().zip([-0.125, 0.125, 0.375, 0.625]) {
        let off = off(time.media.get(0), |p| ball(p - WIND * f));
        assert!(off < INTERPOLATION, "{f}: {off}");
        let place = time.camera.place().unwrap();
        assert!((place.xyz - DVec3::new(f, 0.0, 6.0)).length() < 1e-9, "{f}: {place:?}");
    }
    assert_eq!(scene.times.len(), 4);
    let sharp = frames.at("frame = 12.75", "").camera.place().unwrap();
    assert!((sharp.xyz.x - 0.75).abs() < 1e-9);
}

/// A file for all frames stays where it is.
#[test]
fn what_has_one_file_stays() {
    let frames = in_wind();
    let scene = frames.at("frame = 12.5", "file = 'smoke_0012.vdb'");
    assert!(off(scene.media.get(0), ball) < INTERPOLATION);
}

/// Smoke that one frame has alone has its own colour and temperature there, and the share of its density.
#[test]
fn colour_and_temperature_are_those_of_the_smoke() {
    let folder = tempfile::tempdir().unwrap();
    for (number, x) in [(12, -1.0), (13, 1.0)] {
        let there = |p: DVec3| f64::from((p - DVec3::X * x).abs().max_element() < 0.55);
        let grids = [
            grid("density", |p| [there(p)]),
            grid("Cd", |p| [0.9, 0.6, 0.3].map(|c| c * there(p))),
            grid("temperature", |p| [1500.0 * there(p)]),
        ];
        write(&folder.path().join(format!("smoke_{number:04}.vdb")), &grids).unwrap();
    }
    let frames = Frames(folder);
    let keys = "albedo = { grid = 'Cd' }\nemission = { temperature = 'temperature' }";
    let scene = frames.at("frame = 12.25", keys);
    let medium = scene.media.get(0);
    for (x, share) in [(-1.0, 0.75), (1.0, 0.25)] {
        let p = DVec3::X * x;
        assert!((density(medium, p) - share).abs() < 1e-6);
        let albedo = medium.albedo.at(WorldPoint::from_xyz(p));
        assert!((albedo - Rgb::new(0.9, 0.6, 0.3)).length() < 1e-6, "{albedo}");
        let Some(Emission::Blackbody { grid, .. }) = &medium.emission else { panic!() };
        let kelvin = grid.value(grid.transform().point_to_local(WorldPoint::from_xyz(p)));
        assert!((kelvin - 1500.0).abs() < 1e-3, "{kelvin}");
    }
}

/// The hash of a scene has its time and both files.
#[test]
fn hashes_have_time_and_files() {
    let frames = in_wind();
    let path = frames.folder().join("scene.toml");
    let without = frames.load("", "").unwrap_err().to_string();
    assert!(without.contains("is a sequence of files; say which"), "{without}");
    let at = |number: f64| {
        let options = LoadOptions { frame: FrameTime::nearest(number), ..LoadOptions::default() };
        let scene = Scene::load(&path, &options).unwrap();
        [scene.hash, scene.light_hash]
    };
    let middle = at(12.5);
    assert_eq!(middle, at(12.5));
    for other in [at(12.25), at(12.0), at(13.0)] {
        assert!(other.iter().zip(&middle).all(|(a, b)| a != b));
    }
    let frame = at(12.0);
    std::fs::copy(frames.folder().join("smoke_0012.vdb"), frames.folder().join("smoke_0013.vdb"))
        .unwrap();
    assert!(at(12.5).iter().zip(&middle).all(|(a, b)| a != b));
    assert_eq!(at(12.0), frame);
}

/// Where the next frame is not there, or lacks a grid, one line says so.
#[test]
fn what_the_next_frame_lacks_is_told() {
    let frames = in_wind();
    let problem = |motion: &str, medium: &str| frames.load(motion, medium).unwrap_err().to_string();
    let missing = problem("frame = 13.5", "");
    assert!(
        missing.contains("smoke_0014.vdb: no such file; a time between two frames needs"),
        "{missing}"
    );
    let wrong = problem("frame = 'twelve'", "");
    assert!(wrong.contains("frame") && wrong.contains("a number of a frame"), "{wrong}");
    write(&frames.folder().join("smoke_0013.vdb"), &[grid("smoke", |p| [ball(p)])]).unwrap();
    let lacks = problem("frame = 12.5", "grid = 'density'");
    assert!(lacks.contains("smoke_0013.vdb") && lacks.contains("density"), "{lacks}");
    let path = frames.folder().join("smoke_####.vdb");
    let sequence = Sequence::open(&path, &LoadOptions::default()).unwrap();
    let missing = sequence.missing(FrameTime::nearest(13.5).unwrap());
    assert_eq!(missing, Some(frames.folder().join("smoke_0014.vdb")));
    assert_eq!(sequence.missing(13.into()), None);
}

/// A shot has its volumes of both frames and its camera between them.
#[test]
fn shots_are_between_their_frames() {
    let frames = in_wind();
    let text = "#usda 1.0
(
    startTimeCode = 12
    endTimeCode = 13
    metersPerUnit = 1
    upAxis = \"Y\"
)
def Camera \"camera\" {
    double3 xformOp:translate.timeSamples = { 12: (0, 0, 6), 13: (1, 0, 6) }
    uniform token[] xformOpOrder = [\"xformOp:translate\"]
}
def Volume \"smoke\" {
    rel field:density = </smoke/density>
    def OpenVDBAsset \"density\" {
        asset filePath.timeSamples = { 12: @./smoke_0012.vdb@, 13: @./smoke_0013.vdb@ }
        token fieldName = \"density\"
    }
}
";
    let shot = frames.folder().join("shot.usda");
    std::fs::write(&shot, text).unwrap();
    let with = frames.folder().join("with.toml");
    std::fs::write(&with, "usd = 'shot.usda'\n[motion]\nframe = 12.5\nfps = 1\n").unwrap();
    let options = LoadOptions::default().with("motion.fps", 1);
    let flag = LoadOptions { frame: FrameTime::nearest(12.5), ..options.clone() };
    for (path, options) in [(&shot, &flag), (&with, &flag), (&with, &options)] {
        let scene = Scene::load(path, options).unwrap();
        let medium = scene.media.get(0);
        let scale = medium.sigma_t.x;
        let off = off(medium, |p| scale * ball(p - WIND * 0.5)) / scale;
        assert!(off < INTERPOLATION, "{path:?}: {off}");
        let place = scene.camera.place().unwrap();
        assert!((place.xyz.x - 0.5).abs() < 1e-9, "{path:?}: {place:?}");
    }
    let sequence = Sequence::open(&shot, &options).unwrap();
    let files = sequence.files(FrameTime::nearest(12.5).unwrap());
    assert_eq!(files.len(), 2, "{files:?}");
}
