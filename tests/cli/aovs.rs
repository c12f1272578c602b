//! `--passes` and `--half`, and headers, from outside.

use std::fs;

use fogbow::image::{FAR, Layers, read_header};

use crate::parts::{layers, merges, report, smoke};
use crate::{is_there, printed, run};

const ALL: &str = "depth,albedo,normal,position,media,direct,indirect,emission,specular";

const LIGHT: [&str; 5] = ["media", "direct", "indirect", "emission", "specular"];

/// A folder with a scene: smoke beside a mirror over a floor, before a sky, and a lamp that is seen.
fn scene() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let more = "
[[surface]]
shape = \"sphere\"
center = [2.2, 1, 0]
radius = 0.8
material = { type = \"mirror\", reflectance = 0.9 }
[[light]]
type = \"area\"
center = [-2, 2, -1]
u = [0.5, 0, 0]
v = [0, 0.5, 0]
radiance = 4
[[light]]
type = \"environment\"
radiance = [0.1, 0.2, 0.4]
";
    fs::write(folder.path().join("s.toml"), smoke(4, 5000, "[0.9, 0.8, 0.7]") + more).unwrap();
    folder
}

/// The largest difference of the sum of all light passes from `beauty`, relative to its largest value.
fn difference(layers: &Layers, beauty: [&str; 3]) -> f32 {
    let mut worst: f32 = 0.0;
    let mut brightest: f32 = 0.0;
    for (channel, name) in ["R", "G", "B"].into_iter().zip(beauty) {
        let parts = LIGHT.map(|pass| layers.get(&format!("{pass}.{channel}")).unwrap());
        for (index, value) in layers.get(name).unwrap().iter().enumerate() {
            let sum: f32 = parts.iter().map(|part| part[index]).sum();
            worst = worst.max((sum - value).abs());
            brightest = brightest.max(*value);
        }
    }
    worst / brightest
}

#[test]
fn light_passes_add_up_to_the_picture_and_change_none_of_it() {
    let folder = scene();
    let folder = folder.path();
    report(folder, &["-o", "plain.exr"]);
    report(folder, &["-o", "all.exr", "--passes", ALL]);
    let [plain, all] = ["plain.exr", "all.exr"].map(|name| layers(folder, name));
    assert_eq!(all.channels.len(), plain.channels.len() + 27);
    for (name, values) in &plain.channels {
        assert!(all.get(name) == Some(values), "{name} is another with passes");
    }
    assert!(difference(&all, ["R", "G", "B"]) < 1e-6);
    for pass in LIGHT {
        let values = all.get(&format!("{pass}.G")).unwrap();
        assert!(values.iter().any(|value| *value > 0.0), "{pass} is black");
        assert!(values.contains(&0.0), "{pass} is everywhere");
    }
    assert_eq!(all.attributes["fogbow:light_passes"], "parts of R, G and B");
    assert!(!plain.attributes.keys().any(|name| name.contains("passes")));

    // Some of them are the same as among all.
    report(folder, &["-o", "some.exr", "--passes", "indirect, depth", "--threads", "1"]);
    let some = layers(folder, "some.exr");
    assert_eq!(some.channels.len(), plain.channels.len() + 6);
    assert!(some.channels.iter().all(|(name, values)| all.get(name) == Some(values)));

    // They are reconstructed as the picture is, which stays what it was.
    report(folder, &["-o", "bare.exr", "--reconstruct"]);
    report(folder, &["-o", "clean.exr", "--passes", ALL, "--reconstruct"]);
    let [bare, clean] = ["bare.exr", "clean.exr"].map(|name| layers(folder, name));
    assert!(bare.channels.iter().all(|(name, values)| clean.get(name) == Some(values)));
    assert!(clean.get("R") != clean.get("noisy.R"));
    assert!(difference(&clean, ["R", "G", "B"]) < 1e-6);
    assert_eq!(clean.attributes["fogbow:light_passes"], "parts of R, G and B");
    report(folder, &["-o", "some.exr", "--passes", "indirect, depth", "--reconstruct"]);
    let some = layers(folder, "some.exr");
    assert!(some.channels.iter().all(|(name, values)| clean.get(name) == Some(values)));

    if is_there("oiiotool") {
        let mut args = vec![];
        for pass in LIGHT {
            args.extend(["all.exr".into(), "--ch".into(), format!("{pass}.R,{pass}.G,{pass}.B")]);
            args.extend(["--chnames".into(), "R,G,B".into()]);
        }
        args.extend(["--add"; 4].map(str::to_owned));
        args.extend(["-d", "float", "-o", "sum.exr"].map(str::to_owned));
        printed(folder, "oiiotool", &args.iter().map(String::as_str).collect::<Vec<_>>());
        let sum = layers(folder, "sum.exr");
        for name in ["R", "G", "B"] {
            let pairs = sum.get(name).unwrap().iter().zip(all.get(name).unwrap());
            assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() <= 1e-5 * b.max(1.0)), "{name}");
        }
    }
}

/// A box of even smoke seen along its axis by parallel rays: where opacity lies is known in closed form.
#[test]
fn depths_of_an_even_medium_are_those_of_its_exponential() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let text = |sigma_t: f64, more: &str| {
        format!(
            "
[camera]
type = \"orthographic\"
position = [0, 0, 8]
target = [0, 0, 0]
height = 1.0
[film]
size = [4, 4]
[render]
rays = 4
photons = 100
[[medium]]
region = {{ box = {{ min = [-1.0, -1.0, -1.0], max = [1.0, 1.0, 1.0] }} }}
sigma_t = {sigma_t}
albedo = 0.9
[[light]]
type = \"environment\"
radiance = 1
{more}"
        )
    };
    let wall = "
[[surface]]
shape = \"quad\"
center = [0, 0, -2]
u = [4, 0, 0]
v = [0, 4, 0]
material = { type = \"diffuse\", reflectance = 0.25 }
";
    for (sigma_t, more) in [(0.1, ""), (3.0, ""), (0.1, wall), (0.6, wall)] {
        fs::write(folder.join("s.toml"), text(sigma_t, more)).unwrap();
        let passes = ["--passes", "depth,position,albedo,normal"];
        let through = (-2.0 * sigma_t).exp();
        let opacity: f64 = if more.is_empty() { 1.0 - through } else { 1.0 };
        let reach = |share: f64| {
            let beyond = 1.0 - share * opacity;
            if beyond > through { 7.0 - beyond.ln() / sigma_t } else { 10.0 }
        };
        // The mean of t over the exponential, cut off, and what the wall adds.
        let of_media = 7.0 * (1.0 - through) + (1.0 - through * (1.0 + 2.0 * sigma_t)) / sigma_t;
        let behind = if more.is_empty() { 0.0 } else { 10.0 * through };
        let mean = (of_media + behind) / opacity;
        let half = if through < 0.5 { 7.0 + 0.5_f64.ln().abs() / sigma_t } else { f64::INFINITY };
        let z = if more.is_empty() { half.min(FAR) } else { half.min(10.0) };
        let seen = if more.is_empty() { 0.0 } else { through };
        for method in [&[][..], &["--reference"]] {
            report(folder, &[&["-o", "out.exr"], &passes[..], method].concat());
            let found = layers(folder, "out.exr");
            for (name, expected) in [
                ("depth.first", reach(0.01)),
                ("depth.mean", mean),
                ("depth.last", reach(0.99)),
                ("position.Z", 8.0 - mean),
                ("albedo.G", 0.9 * (1.0 - through) + 0.25 * seen),
                ("normal.Z", seen),
                ("Z", z),
            ] {
                for value in found.get(name).unwrap() {
                    let error = (f64::from(*value) - expected).abs();
                    let told = format!("{name} of {sigma_t} is {value}, not {expected} {method:?}");
                    assert!(error <= 1e-5 * expected.abs(), "{told}");
                }
            }
            assert!(found.get("position.X").unwrap().iter().all(|x| x.abs() < 0.5));
        }
    }
}

#[test]
fn what_a_render_cannot_give_is_refused_by_name() {
    let folder = scene();
    let folder = folder.path();
    let refused = |more: &[&str]| {
        let (code, out, err) = run(folder, &[&["render", "s.toml", "-o", "a.exr"], more].concat());
        assert!(code != 0 && out.is_empty() && !folder.join("a.exr").exists(), "{more:?}");
        err
    };
    let told = refused(&["--passes", "depth,beauty"]);
    assert!(
        told.contains("--passes depth,beauty") && told.contains("no pass \"beauty\""),
        "{told}"
    );
    let told = refused(&["--set", "film.passes=7"]);
    assert!(told.contains("film.passes"), "{told}");
    let told = refused(&["--reference", "--passes", ALL]);
    assert!(told.contains("leave media, direct, indirect, emission, specular out"), "{told}");
}

#[test]
fn passes_go_through_crops_and_merges() {
    let folder = scene();
    let folder = folder.path();
    let passes = ["--passes", ALL];
    report(folder, &[&["-o", "whole.exr"], &passes[..]].concat());
    let crops = ["0,0,24x9", "0,9,10x11", "10,9,14x11"];
    for (index, crop) in crops.into_iter().enumerate() {
        let name = format!("crop{index}.exr");
        report(folder, &[&["-o", &name, "--crop", crop], &passes[..]].concat());
    }
    merges(folder, &["crop0.exr", "crop1.exr", "crop2.exr"], "merged.exr");
    let [whole, merged] = ["whole.exr", "merged.exr"].map(|name| layers(folder, name));
    assert!(whole.channels == merged.channels);
    // A part has all of its layers in the file, for other programs.
    let stored = |name: &str| {
        let bytes = fs::read(folder.join(name)).unwrap();
        bytes.windows(16).any(|bytes| bytes == b"fogbow:constant.")
    };
    assert_eq!(["whole.exr", "merged.exr", "crop0.exr"].map(stored), [true, true, false]);

    for seed in ["1", "2"] {
        let name = format!("seed{seed}.exr");
        report(folder, &[&["-o", &name, "--seed", seed], &passes[..]].concat());
    }
    merges(folder, &["seed1.exr", "seed2.exr"], "mean.exr");
    let [mean, one, two] = ["mean.exr", "seed1.exr", "seed2.exr"].map(|name| layers(folder, name));
    assert!(difference(&mean, ["R", "G", "B"]) < 1e-6);
    for (index, value) in mean.get("depth.mean").unwrap().iter().enumerate() {
        let [a, b] = [&one, &two].map(|part| {
            let at = |name| f64::from(part.get(name).unwrap()[index]);
            (at("A"), at("depth.mean"))
        });
        let expected = (a.0 * a.1 + b.0 * b.1) / (a.0 + b.0);
        let expected = if a.0 + b.0 > 0.0 { expected } else { FAR };
        assert!((f64::from(*value) / expected - 1.0).abs() < 1e-6, "{value} for {expected}");
    }
}

#[test]
fn colours_are_halved_where_that_holds_them() {
    let folder = scene();
    let folder = folder.path();
    let half = ["--half", "--passes", "depth,media,emission,normal"];
    report(folder, &[&["-o", "half.exr"], &half[..]].concat());
    report(folder, &["-o", "full.exr", half[1], half[2]]);
    let kinds = |name: &str| read_header(&folder.join(name)).unwrap().half;
    let colors = |passes: &[&str]| -> Vec<String> {
        let of = |pass: &&str| ["B", "G", "R"].map(|channel| format!("{pass}.{channel}"));
        passes.iter().flat_map(of).collect()
    };
    let own = ["A", "B", "G", "R"].map(str::to_owned);
    assert_eq!(kinds("half.exr"), [&own[..], &colors(&["emission", "media"])].concat());
    assert!(kinds("full.exr").is_empty());
    let [halved, full] = ["half.exr", "full.exr"].map(|name| layers(folder, name));
    for (name, values) in &full.channels {
        for (a, b) in halved.get(name).unwrap().iter().zip(values) {
            let digits = if kinds("half.exr").contains(name) { 2_f32.powi(-11) } else { 0.0 };
            assert!((a - b).abs() <= digits * b.abs() + 2_f32.powi(-25), "{name}: {a} for {b}");
        }
    }
    // A lamp too bright for half floats keeps its value, where it is seen.
    let lamp = [&["-o", "bright.exr", "--set", "light.1.radiance=90000"], &half[..]].concat();
    report(folder, &lamp);
    assert_eq!(kinds("bright.exr"), colors(&["media"]));
    let brightest = |name: &str| {
        layers(folder, "bright.exr").get(name).unwrap().iter().copied().fold(0.0, f32::max)
    };
    assert!(brightest("R") > 65_504.0 && brightest("emission.R") > 65_504.0);

    for seed in ["1", "2"] {
        let name = format!("{seed}.exr");
        report(folder, &[&["-o", &name, "--seed", seed], &half[..]].concat());
    }
    merges(folder, &["1.exr", "2.exr"], "mean.exr");
    assert_eq!(kinds("mean.exr"), kinds("half.exr"));
}

#[test]
fn other_programs_read_the_header() {
    if !is_there("oiiotool") {
        return;
    }
    let folder = scene();
    let folder = folder.path();
    report(folder, &["-o", "a.exr", "--passes", "depth"]);
    let told = printed(folder, "oiiotool", &["--info", "-v", "a.exr"]);
    for line in [
        "fogbow:rays: 4",
        "fogbow:size: 24, 20",
        "fogbow:constant.rays: 4",
        "fogbow:alpha: \"R, G and B are premultiplied (associated) by A\"",
        "chromaticities: 0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329",
    ] {
        assert!(told.lines().any(|found| found.trim() == line), "{line} is not in {told}");
    }
    assert!(told.contains("worldtocamera") || told.contains("worldToCamera"), "{told}");
    let header = read_header(&folder.join("a.exr")).unwrap();
    let matrix: Vec<f64> = serde_json::from_str(&header.attributes["worldToCamera"]).unwrap();
    // Row vectors: the translation is the last row, and the view runs along -z.
    assert_eq!(matrix[12..], [0.0, -1.0, -8.0, 1.0]);
}
