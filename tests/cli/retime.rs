//! Times between two frames of a sequence, from outside.

use std::fs;
use std::path::Path;

use glam::DVec3;
use serde_json::Value;

use crate::parts::layers;
use crate::run;
use crate::wind::write_cube;

/// Frames 1 and 2 of a cube of smoke in a wind of a metre a frame.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for number in [1, 2] {
        let path = folder.path().join(format!("smoke_{number:04}.vdb"));
        let corner = DVec3::new(f64::from(number) - 2.3, -0.8, -0.8);
        write_cube(&path, corner, [24.0, 0.0, 0.0], &[]);
    }
    fs::write(folder.path().join("s.toml"), SCENE).unwrap();
    folder
}

const SCENE: &str = "\
[camera]
position = [0, 0, 6]
target = [0, 0, 0]
[film]
size = [24, 16]
[render]
rays = 8
photons = 1000
[[medium]]
file = \"smoke_####.vdb\"
sigma_t = 3.0
[[light]]
type = \"environment\"
radiance = 1.0
";

/// Renders the scene, and returns what each line of JSON says.
fn rendered(folder: &Path, args: &[&str]) -> Vec<Value> {
    let (code, out, err) =
        run(folder, &[&["render", "s.toml", "--json", "--quiet"], args].concat());
    assert_eq!((code, err.as_str()), (0, ""), "{args:?}");
    out.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// Mean column of the smoke, from -1 to 1 across the picture.
fn middle(folder: &Path, name: &str) -> f64 {
    let layers = layers(folder, name);
    let alpha = layers.get("A").unwrap();
    let (mut sum, mut weight) = (0.0, 0.0);
    for (pixel, a) in alpha.iter().enumerate() {
        let (x, a) = ((pixel % 24) as f64, f64::from(*a));
        (sum, weight) = (sum + (x - 11.5) / 12.0 * a, weight + a);
    }
    sum / weight
}

/// Decimals stand in names and in JSON; smoke between two frames is between their places, and whole numbers are what they are alone.
#[test]
fn sequences_have_times_between_frames() {
    let folder = folder();
    let folder = folder.path();
    let all = rendered(folder, &["--frames", "1-2x0.25", "-o", "out_####.exr"]);
    let numbers: Vec<_> = all.iter().map(|report| report["frame"].to_string()).collect();
    assert_eq!(numbers, ["1", "1.25", "1.5", "1.75", "2"]);
    let names = ["0001", "0001.25", "0001.5", "0001.75", "0002"];
    let places = names.map(|name| middle(folder, &format!("out_{name}.exr")));
    let step = (places[4] - places[0]) / 4.0;
    assert!(step > 0.05, "{places:?}");
    for (k, place) in places.iter().enumerate() {
        let even = places[0] + step * k as f64;
        assert!((place - even).abs() < 0.2 * step, "{places:?}");
    }
    let bytes = |name: &str| fs::read(folder.join(name)).unwrap();
    rendered(folder, &["--frames", "1", "-o", "alone.exr"]);
    assert_eq!(bytes("alone.0001.exr"), bytes("out_0001.exr"));
    rendered(folder, &["--frames", "1.5", "-o", "alone.exr"]);
    assert_eq!(bytes("alone.0001.5.exr"), bytes("out_0001.5.exr"));
    // What is finished is left out.
    let again = rendered(folder, &["--frames", "1,1.5", "-o", "out_####.exr", "--resume"]);
    assert!(again.iter().all(|report| report["state"] == "finished"), "{again:?}");
}

/// One picture has its time by a key, and `fogbow plan` by a flag.
#[test]
fn one_picture_is_between_two_frames() {
    let folder = folder();
    let folder = folder.path();
    rendered(folder, &["--set", "motion.frame=1.5", "-o", "set.exr"]);
    fs::write(folder.join("s.toml"), format!("{SCENE}[motion]\nframe = 1.5\n")).unwrap();
    rendered(folder, &["-o", "key.exr"]);
    rendered(folder, &["--frames", "1.5", "-o", "out_#.exr"]);
    let green = |name: &str| layers(folder, name).get("G").unwrap().to_vec();
    assert_eq!(green("key.exr"), green("set.exr"));
    assert_eq!(green("key.exr"), green("out_1.5.exr"));
    // The command line stands over it.
    rendered(folder, &["--frames", "2", "-o", "out_#.exr"]);
    assert_ne!(green("key.exr"), green("out_2.exr"));
    for args in
        [&["plan", "s.toml", "--frame", "1.5"][..], &["plan", "smoke_####.vdb", "--frame=1.75"]]
    {
        let (code, _, err) = run(folder, args);
        assert_eq!(code, 0, "{args:?}: {err}");
    }
    let bare = ["render", "smoke_####.vdb", "--set", "motion.frame=1.5", "-o", "bare.exr"];
    let few = ["--size=8x8", "--rays=1", "--photons=1000", "--quiet"];
    let (code, _, err) = run(folder, &[&bare[..], &few].concat());
    assert_eq!((code, err.as_str()), (0, ""));
}

/// Behind the last frame there is nothing to blend with: that is a missing file.
#[test]
fn behind_the_last_frame_a_file_is_missing() {
    let folder = folder();
    let folder = folder.path();
    let frames = ["--frames", "1.5-2.5", "-o", "out_#.exr"];
    let run = |args: &[&str]| {
        run(folder, &[&["render", "s.toml", "--quiet", "--json"], &frames[..], args].concat())
    };
    let (code, _, err) = run(&[]);
    assert_eq!((code, err.lines().count()), (1, 1), "{err}");
    assert!(err.contains("frame 2.5: smoke_0003.vdb: no such file"), "{err}");
    let states = |args: &[&str]| {
        let (code, out, err) = run(args);
        assert_eq!(code, 0, "{err}");
        let reports = out.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
        reports.map(|report| format!("{} {}", report["state"], report["held"])).collect::<Vec<_>>()
    };
    assert_eq!(states(&["--missing", "hold"]), ["\"rendered\" null", "\"held\" 2"]);
    assert_eq!(states(&["--missing", "skip"]), ["\"rendered\" null", "\"skipped\" null"]);
    let (code, _, err) =
        crate::run(folder, &["render", "s.toml", "--frames", "1.5x", "-o", "o.exr"]);
    assert!(code == 2 && err.contains("12-13x0.25"), "{err}");
}
