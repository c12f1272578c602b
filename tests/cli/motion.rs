//! Motion blur from outside.

use std::fs;
use std::path::Path;

use glam::DVec3;

use crate::parts::{layers, merges, report};
use crate::run;
use crate::wind::write_cube;

/// A cube of smoke in a wind of 2 m/s, with the velocities by component too.
fn moving(path: &Path) {
    let components = [("u", 2.0), ("v_up", 1e-9), ("w", 1e-9)];
    write_cube(path, DVec3::splat(-0.8), [2.0, 0.0, 0.0], &components);
}

const SCENE: &str = "\
[camera]
position = [0, 0, 6]
target = [0, 0, 0]
[film]
size = [24, 16]
[render]
rays = 8
photons = 2000
[motion]
shutter = 0.5
fps = 2
[[medium]]
file = \"moving.vdb\"
sigma_t = 3.0
[[light]]
type = \"environment\"
radiance = [1.0, 1.2, 1.5]
";

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    moving(&folder.path().join("moving.vdb"));
    fs::write(folder.path().join("s.toml"), SCENE).unwrap();
    folder
}

/// A note says at how many times, and `fogbow render` blurs scenes and VDB files alone.
#[test]
fn scenes_and_bare_files_blur() {
    let folder = folder();
    let notes = |args: &[&str]| {
        let (code, _, err) = run(folder.path(), args);
        assert_eq!(code, 0, "{err}");
        err
    };
    let err = notes(&["render", "s.toml", "-o", "out.exr"]);
    assert!(err.contains("motion: the scene at 4 times of a shutter of 0.5 frames"), "{err}");
    let more = ["--size", "16x16", "--rays", "4", "--photons", "1000"];
    let bare = ["render", "moving.vdb", "-o", "bare.exr", "--set", "motion.shutter=0.5"];
    let err = notes(&[&bare[..], &more].concat());
    assert!(err.contains("motion: the scene at"), "{err}");
    // Half a second of 2 m/s at 2 frames a second: half a metre, of the 4.4 m that 24 pixels show.
    let alpha = |name: &str| layers(folder.path(), name).get("A").unwrap().to_vec();
    report(folder.path(), &["-o", "sharp.exr", "--set", "motion.shutter=0"]);
    let (blurred, sharp) = (alpha("out.exr"), alpha("sharp.exr"));
    let covered = |alpha: &[f32]| alpha.iter().filter(|a| **a > 0.01).count();
    assert!(covered(&blurred) > covered(&sharp), "{} {}", covered(&blurred), covered(&sharp));
}

/// Velocities are told in any unit, by one grid or three.
#[test]
fn units_and_components_are_the_same() {
    let folder = folder();
    let picture = |key: &str| {
        let text = SCENE.replace("sigma_t = 3.0", &format!("sigma_t = 3.0\n{key}"));
        fs::write(folder.path().join("s.toml"), text).unwrap();
        report(folder.path(), &["-o", "out.exr"]);
        layers(folder.path(), "out.exr").get("G").unwrap().to_vec()
    };
    let seconds = picture("");
    for key in [
        "velocity = \"vel\"\nvelocity_unit = \"m/frame\"\nvelocity_scale = 0.5",
        "velocity_unit = \"voxels/frame\"\nvelocity_scale = 2.5",
        "velocity = [\"u\", \"v_up\", \"w\"]",
    ] {
        let other = picture(key);
        let off = seconds.iter().zip(&other).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(off < 1e-3, "{key}: {off}");
    }
    assert_ne!(picture("velocity = \"none\"\nmotion = { translate = [0, 0.1, 0] }"), seconds);
}

/// Crops are those of the whole; passes by number have all rays and photons, and their mean is near the whole.
#[test]
fn crops_and_passes_merge() {
    let folder = folder();
    let folder = folder.path();
    report(folder, &["-o", "whole.exr"]);
    let crops = ["0,0,10x16", "10,0,14x16"];
    for (i, crop) in crops.iter().enumerate() {
        report(folder, &["-o", &format!("crop{i}.exr"), "--crop", crop]);
        report(folder, &["-o", &format!("pass{i}.exr"), "--pass", &format!("{}/2", i + 1)]);
    }
    merges(folder, &["crop0.exr", "crop1.exr"], "crops.exr");
    merges(folder, &["pass0.exr", "pass1.exr"], "passes.exr");
    let green = |name: &str| layers(folder, name).get("G").unwrap().to_vec();
    assert_eq!(green("crops.exr"), green("whole.exr"));
    let mean = |name: &str| green(name).iter().sum::<f32>() / 384.0;
    let (passes, whole) = (mean("passes.exr"), mean("whole.exr"));
    assert!((passes / whole - 1.0).abs() < 0.02, "{passes} {whole}");
}

/// Reconstruction, a stated error, the reference and directors run with motion.
#[test]
fn methods_go_with_motion() {
    let folder = folder();
    let green = |args: &[&str]| {
        report(folder.path(), &[&["-o", "out.exr"], args].concat());
        let layers = layers(folder.path(), "out.exr");
        layers.get("G").unwrap().iter().sum::<f32>() / 384.0
    };
    let plain = green(&[]);
    for args in [
        &["--reference"][..],
        &["--reconstruct"],
        &["--director", "xs"],
        &["--director", "variance"],
        &["--director", "x", "--x", "error"],
        &["--director", "xs", "--x", "scattering"],
        &["--passes", "depth,position,albedo,media"],
    ] {
        let other = green(args);
        assert!((other / plain - 1.0).abs() < 0.05, "{args:?}: {other} {plain}");
    }
}

#[test]
fn what_does_not_go_with_motion_is_refused() {
    let folder = folder();
    let refused = |args: &[&str], says: &str| {
        let (code, _, err) = run(folder.path(), &[&["render", "s.toml", "--quiet"], args].concat());
        assert!(code != 0 && err.lines().count() == 1 && err.contains(says), "{args:?}: {err}");
    };
    refused(&["-o", "o.exr", "--deep"], "a deep picture and motion blur exclude each other");
    refused(&["--photons-to", "p.fog"], "--photons-to and motion blur exclude each other");
    let set = |setting: &str, says: &str| refused(&["-o", "o.exr", "--set", setting], says);
    set("motion.shutter=-1", "a number of frames from 0 to 10");
    set("motion.shutters=1", "did you mean `shutter`?");
    set("motion.times=65", "a whole number from 1 to 64");
    set("medium.0.velocity=wind", "has no grid called \"wind\"");
    set("medium.0.velocity=density", "holds scalars, but three-vectors are wanted here");
    set("medium.0.velocity=['u', 'w']", "of three grids");
    set("camera.next={ target = [0, 0, 6] }", "a pose whose target is not its position");
}

/// A mesh whose next frame is another is refused; of a sequence the next frame is found by its number.
#[test]
fn meshes_move_to_their_next_frames() {
    let folder = folder();
    let folder = folder.path();
    let square = |x: i32| {
        format!("v {x} -1 0\nv {} -1 0\nv {} 1 0\nv {x} 1 0\nf 1 2 3\nf 1 3 4\n", x + 1, x + 1)
    };
    fs::write(folder.join("q_1.obj"), square(0)).unwrap();
    fs::write(folder.join("q_2.obj"), square(1)).unwrap();
    fs::write(folder.join("other.obj"), "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n").unwrap();
    let surface = "[[surface]]\nshape = \"mesh\"\n";
    let write =
        |keys: &str| fs::write(folder.join("s.toml"), format!("{SCENE}{surface}{keys}")).unwrap();
    write("file = \"q_1.obj\"\nnext_file = \"other.obj\"\n");
    let (code, _, err) = run(folder, &["render", "s.toml", "-o", "o.exr", "--quiet"]);
    assert_eq!((code, err.lines().count()), (1, 1), "{err}");
    assert!(err.contains("next_file") && err.contains("1 triangles"), "{err}");
    write("file = \"q_#.obj\"\nnext_file = \"q_#.obj\"\n");
    let (code, out, err) =
        run(folder, &["render", "s.toml", "--frames", "1-2", "-o", "f_#.exr", "--quiet"]);
    assert_eq!((code, err.as_str()), (0, ""), "{out}");
    write("file = \"q_1.obj\"\nnext_file = \"q_2.obj\"\n");
    report(folder, &["-o", "one.exr"]);
    let green = |name: &str| layers(folder, name).get("G").unwrap().to_vec();
    assert_eq!(green("f_1.exr"), green("one.exr"));
}

/// Vectors are those of what is seen, sharp or blurred: of smoke in wind, of a ball that falls, and of a camera that follows.
#[test]
fn motion_vectors_are_those_of_what_is_seen() {
    let folder = folder();
    let folder = folder.path();
    let ball = "[[surface]]\nshape = \"sphere\"\ncenter = [1.6, 0.8, 0]\nradius = 0.4\nmotion = { translate = [0, -0.3, 0] }\n";
    let follows = "target = [0, 0, 0]\nnext = { position = [0.5, 0, 6], target = [0.5, 0, 0] }";
    // Pixels that a metre takes in a metre's distance.
    let scale = 24.0 / (2.0 * 20.0_f64.to_radians().tan());
    for (camera, pan) in [("target = [0, 0, 0]", 0.0), (follows, 0.5)] {
        for shutter in ["0.0", "0.5"] {
            let text = SCENE
                .replace("target = [0, 0, 0]", camera)
                .replace("shutter = 0.5", &format!("shutter = {shutter}"));
            fs::write(folder.join("s.toml"), format!("{text}{ball}")).unwrap();
            report(folder, &["-o", "out.exr", "--passes", "motion,position,depth", "--rays", "32"]);
            let all = layers(folder, "out.exr");
            let at = |name: &str, x: usize, y: usize| match all.get(name) {
                Some(layer) => f64::from(layer[y * 24 + x]),
                // A layer of one value everywhere stands in the header.
                None => 0.0,
            };
            // Smoke in the middle goes a metre to the right.
            let depth = 6.0 - at("position.Z", 12, 8);
            let [x, y] = ["motion.X", "motion.Y"].map(|name| at(name, 12, 8));
            let expected = (1.0 - pan) * scale / depth;
            assert!((x / expected - 1.0).abs() < 0.02, "{shutter} {pan}: {x} for {expected}");
            assert!(y.abs() < 0.02, "{y}");
            // The ball falls.
            let depth = 6.0 - at("position.Z", 19, 4);
            let [x, y] = ["motion.X", "motion.Y"].map(|name| at(name, 19, 4));
            let [right, up] = [-pan, -0.3].map(|metres| metres * scale / depth);
            assert!((x - right).abs() < 0.1 && (y - up).abs() < 0.1, "{x} {y}: {right} {up}");
            // The sky stands still.
            assert_eq!([at("motion.X", 0, 15), at("motion.Y", 0, 15)], [0.0; 2]);
        }
    }
}
