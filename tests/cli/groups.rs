//! The pass `groups` from outside: the light of each group of emitters.

use std::fs;
use std::path::Path;

use fogbow::image::Layers;

use crate::parts::{layers, merges, report};
use crate::{is_there, printed, run};

/// The groups of [`scene`] in its order, the last of an emitter that names none.
const GROUPS: [&str; 5] = ["key", "fill", "sign", "fire", "rest"];

pub const ALL: [bool; 5] = [true; 5];

/// Smoke over a floor beside a mirror, with two coloured lamps, a quad and a flame that glow, and a sky: those of them that
/// are `lit`, a group each.
pub fn scene(lit: [bool; 5]) -> String {
    let [key, fill, sign, fire, rest] = lit.map(f64::from);
    format!(
        r#"
[camera]
position = [0, 1, 8]
target = [0, 1, 0]
[film]
size = [24, 20]
[render]
rays = 4
photons = 5000
seed = 5
[[medium]]
region = {{ box = {{ min = [-1.0, 0.0, -1.0], max = [1.0, 2.0, 1.0] }} }}
sigma_t = 2.0
albedo = [0.9, 0.8, 0.7]
phase = {{ type = "henyey-greenstein", g = 0.5 }}
[[medium]]
region = {{ sphere = {{ center = [0.0, 0.7, 0.2], radius = 0.4 }} }}
sigma_t = 1.0
albedo = 0.3
emission = {{ color = [6.0, 2.0, 0.5], scale = {fire} }}
group = "fire"
[[surface]]
shape = "plane"
material = {{ type = "diffuse", reflectance = 0.7 }}
[[surface]]
shape = "sphere"
center = [2.2, 1, 0]
radius = 0.8
material = {{ type = "mirror", reflectance = 0.9 }}
[[surface]]
shape = "quad"
center = [-1.8, 1.2, -0.5]
u = [0.4, 0, 0.2]
v = [0, 0.4, 0]
emission = [{}, {}, {}]
group = "sign"
[[light]]
type = "area"
center = [2, 5, 2]
u = [1, 0, 0]
v = [0, 0, 1]
radiance = [{}, {}, {}]
group = "key"
[[light]]
type = "point"
position = [-2, 3, 2]
intensity = [{}, {}, {}]
group = "fill"
[[light]]
type = "environment"
radiance = [{}, {}, {}]
"#,
        2.0 * sign,
        5.0 * sign,
        9.0 * sign,
        20.0 * key,
        14.0 * key,
        9.0 * key,
        2.0 * fill,
        6.0 * fill,
        3.0 * fill,
        0.1 * rest,
        0.2 * rest,
        0.4 * rest,
    )
}

/// A folder with the scene `text`.
pub fn folder(text: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("s.toml"), text).unwrap();
    folder
}

/// The largest difference of the sum of all `groups` from `beauty`, relative to its largest value.
fn difference(layers: &Layers, groups: &[&str], beauty: [&str; 3]) -> f32 {
    let mut worst: f32 = 0.0;
    let mut brightest: f32 = 0.0;
    for (channel, name) in ["R", "G", "B"].into_iter().zip(beauty) {
        let part = |group| layers.get(&format!("group.{group}.{channel}")).unwrap();
        for (index, value) in layers.get(name).unwrap().iter().enumerate() {
            let sum: f32 = groups.iter().map(|group| part(group)[index]).sum();
            worst = worst.max((sum - value).abs());
            brightest = brightest.max(*value);
        }
    }
    assert!(brightest > 0.0);
    worst / brightest
}

/// That the scene in `folder` looks the same with and without groups, which add up to `beauty`. Returns the layers.
fn check(folder: &Path, groups: &[&str], beauty: [&str; 3], more: &[&str]) -> Layers {
    report(folder, &[&["-o", "plain.exr"][..], more].concat());
    report(folder, &[&["-o", "groups.exr", "--passes", "groups"][..], more].concat());
    let [plain, all] = ["plain.exr", "groups.exr"].map(|name| layers(folder, name));
    assert_eq!(all.channels.len(), plain.channels.len() + 3 * groups.len(), "{more:?}");
    for (name, values) in &plain.channels {
        assert!(all.get(name) == Some(values), "{name} is another with groups, {more:?}");
    }
    let off = difference(&all, groups, beauty);
    assert!(off < 1e-6, "{off} with {more:?}");
    all
}

#[test]
fn groups_add_up_to_the_picture_and_change_none_of_it() {
    let folder = folder(&scene(ALL));
    let folder = folder.path();
    let beauty = ["R", "G", "B"];
    let all = check(folder, &GROUPS, beauty, &[]);
    for group in GROUPS {
        let values = all.get(&format!("group.{group}.G")).unwrap();
        assert!(values.iter().any(|value| *value > 0.0), "{group} is black");
    }
    assert_eq!(all.attributes["fogbow:light_passes"], "parts of R, G and B");
    if is_there("oiiotool") {
        let mut args = vec![];
        for group in GROUPS {
            let channels = format!("group.{group}.R,group.{group}.G,group.{group}.B");
            args.extend(["groups.exr".into(), "--ch".into(), channels]);
            args.extend(["--chnames".into(), "R,G,B".into()]);
        }
        args.extend(["--add"; 4].map(str::to_owned));
        args.extend(["-d", "float", "-o", "sum.exr"].map(str::to_owned));
        printed(folder, "oiiotool", &args.iter().map(String::as_str).collect::<Vec<_>>());
        let sum = layers(folder, "sum.exr");
        for name in beauty {
            let pairs = sum.get(name).unwrap().iter().zip(all.get(name).unwrap());
            assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() <= 1e-5 * b.max(1.0)), "{name}");
        }
        let channels = "group.key.R,group.key.G,group.key.B";
        let dim = ["--ch", channels, "--chnames", "R,G,B", "--mulc", "0.5", "-o", "dimmed.exr"];
        printed(folder, "oiiotool", &[&["groups.exr"][..], &dim].concat());
        let dimmed = layers(folder, "dimmed.exr");
        let key = all.get("group.key.G").unwrap().iter().map(|value| 0.5 * value);
        assert!(key.eq(dimmed.get("G").unwrap().iter().copied()));
    }
    // On one thread, and beside other passes.
    let others = ["-o", "others.exr", "--passes", "media,groups,depth", "--threads", "1"];
    report(folder, &others);
    let others = layers(folder, "others.exr");
    assert!(all.channels.iter().all(|(name, values)| others.get(name) == Some(values)));
    // By each strategy, and in halves.
    for strategy in ["beams", "fluence-toward-eye", "moments", "shared-gathers", "traced"] {
        check(folder, &GROUPS, beauty, &["--strategy", strategy]);
    }
    check(folder, &GROUPS, ["noisy.R", "noisy.G", "noisy.B"], &["--reconstruct"]);
    check(folder, &GROUPS, beauty, &["--reference"]);
}

#[test]
fn a_grey_scene_and_one_group_are_no_exception() {
    let text = "
[camera]
position = [0, 0, 8]
target = [0, 0, 0]
[film]
size = [16, 12]
[render]
rays = 4
photons = 2000
[[medium]]
region = { box = { min = [-1.0, -1.0, -1.0], max = [1.0, 1.0, 1.0] } }
sigma_t = 3.0
albedo = 0.9
[[light]]
type = \"point\"
position = [0, 3, 0]
intensity = 9
[[light]]
type = \"sun\"
direction = [1, -1, 0]
irradiance = 2
";
    let beauty = ["R", "G", "B"];
    let plain = folder(text);
    let all = check(plain.path(), &["rest"], beauty, &[]);
    assert!(all.get("group.rest.G") == all.get("G"));
    let named = folder(&text.replace("intensity = 9", "intensity = 9\ngroup = \"lamp\""));
    for strategy in ["auto", "beams", "fluence-toward-eye"] {
        check(named.path(), &["lamp", "rest"], beauty, &["--strategy", strategy]);
    }
}

#[test]
fn crops_and_means_have_groups_as_pictures_have() {
    let folder = folder(&scene(ALL));
    let folder = folder.path();
    let passes = ["--passes", "groups", "--strategy", "beams"];
    report(folder, &[&["-o", "whole.exr"][..], &passes].concat());
    for (name, crop) in [("a.exr", "0,0,24x9"), ("b.exr", "0,9,24x11")] {
        report(folder, &[&["-o", name, "--crop", crop][..], &passes].concat());
    }
    merges(folder, &["a.exr", "b.exr"], "merged.exr");
    let [whole, merged] = ["whole.exr", "merged.exr"].map(|name| layers(folder, name));
    assert!(whole.channels.iter().all(|(name, values)| merged.get(name) == Some(values)));
    report(folder, &[&["-o", "c.exr", "--seed", "6"][..], &passes[..]].concat());
    merges(folder, &["whole.exr", "c.exr"], "mean.exr");
    assert!(difference(&layers(folder, "mean.exr"), &GROUPS, ["R", "G", "B"]) < 1e-6);
}

/// The mean over the picture of three channels, by `name`.
pub fn means(layers: &Layers, name: impl Fn(&str) -> String) -> [f64; 3] {
    ["R", "G", "B"].map(|channel| {
        let values = layers.get(&name(channel)).unwrap();
        values.iter().map(|value| f64::from(*value)).sum::<f64>() / values.len() as f64
    })
}

/// A group is the picture with all other lights off. The means of eight pictures each differ by less than six standard errors
/// as these tell them: with Student's distribution of 14 degrees of freedom a false alarm of 3e-5 a number, of 1e-3 in all at
/// these fixed seeds.
#[test]
fn a_group_is_the_picture_with_all_other_lights_off() {
    let seeds = ["1", "2", "3", "4", "5", "6", "7", "8"];
    let whole = folder(&scene(ALL));
    for how in [["--strategy", "traced"].as_slice(), &["--reference"]] {
        let of_seed = |folder: &Path, seed: &str, more: &[&str]| {
            let rays = ["--rays", "16", "--seed", seed, "-o", "out.exr"];
            report(folder, &[&rays[..], how, more].concat());
            layers(folder, "out.exr")
        };
        let groups = seeds.map(|seed| of_seed(whole.path(), seed, &["--passes", "groups"]));
        for (index, group) in GROUPS.into_iter().enumerate() {
            let alone = folder(&scene(std::array::from_fn(|other| other == index)));
            let alone = seeds.map(|seed| of_seed(alone.path(), seed, &[]));
            let alone = alone.map(|layers| means(&layers, str::to_owned));
            let parts = groups
                .each_ref()
                .map(|layers| means(layers, |channel| format!("group.{group}.{channel}")));
            for channel in 0..3 {
                let [a, b] = [&alone, &parts].map(|pictures| {
                    let values = pictures.map(|means| means[channel]);
                    let mean = values.iter().sum::<f64>() / 8.0;
                    let spread = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
                    (mean, spread / (7.0 * 8.0))
                });
                let (off, error) = (a.0 - b.0, (a.1 + b.1).sqrt());
                assert!(off.abs() < 6.0 * error, "{group}: {} for {}, {how:?}", b.0, a.0);
            }
        }
    }
}

#[test]
fn what_is_no_group_ends_in_one_message() {
    let refused = |text: &str, more: &[&str], says: &[&str]| {
        let folder = folder(text);
        let args = [&["render", "s.toml", "-o", "out.exr", "--quiet"], more].concat();
        let (code, _, err) = run(folder.path(), &args);
        assert_eq!((code, err.lines().count()), (1, 1), "{err}");
        assert!(says.iter().all(|words| err.contains(words)), "{says:?}: {err}");
    };
    let text = scene(ALL);
    for wrong in ["\"\"", "\"a b\"", "\"a.b\"", "7", "\"a-name-of-more-than-23-letters\""] {
        let text = text.replace("\"key\"", wrong);
        refused(&text, &[], &["light[0]", "group", "at most 23 letters"]);
    }
    let lamps = |count: usize| {
        let lamp = |index| {
            format!(
                "[[light]]\ntype = \"point\"\nposition = [0, 9, 0]\nintensity = 1\ngroup = \"g{index}\"\n"
            )
        };
        scene(ALL) + &(0..count).map(lamp).collect::<String>()
    };
    refused(&lamps(4), &[], &["medium[1]", "more than the 8"]);
    let folder = folder(&lamps(3));
    report(folder.path(), &["-o", "out.exr", "--passes", "groups", "--rays", "1"]);
    report(folder.path(), &["--photons-to", "map.fog"]);
    let args = ["render", "s.toml", "-o", "out.exr", "--quiet", "--photons-from", "map.fog"];
    let (_, _, err) = run(folder.path(), &[&args[..], &["--passes", "groups"]].concat());
    assert_eq!(err.lines().count(), 1, "{err}");
    assert!(err.contains("map.fog: saved photons do not tell from which light"), "{err}");
}
