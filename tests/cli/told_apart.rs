//! What tests of light that a picture tells apart share: a scene with a light of each kind, and how the parts of a pass are
//! compared with the picture.

use std::fs;
use std::path::Path;

use fogbow::image::Layers;

use crate::parts::{layers, merges, report};

/// How light of media can be estimated.
pub const STRATEGIES: [&str; 5] =
    ["beams", "fluence-toward-eye", "moments", "shared-gathers", "traced"];

pub const CHANNELS: [&str; 3] = ["R", "G", "B"];

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

/// A pass that tells light apart.
pub struct Pass<'a> {
    /// What it is called, and what its layers begin with.
    pub names: [&'a str; 2],
    pub parts: &'a [&'a str],
    /// The layers that the parts add up to.
    pub whole: [&'a str; 3],
}

/// The layer of a `part` of the pass whose layers begin with `pass`.
pub fn part<'l>(layers: &'l Layers, pass: &str, part: &str, channel: &str) -> &'l [f32] {
    layers.get(&format!("{pass}.{part}.{channel}")).unwrap()
}

/// The largest difference of the sum of all parts from the whole, relative to its largest value.
pub fn difference(layers: &Layers, pass: &Pass<'_>) -> f32 {
    let (mut worst, mut brightest) = (0.0_f32, 0.0_f32);
    for (channel, name) in CHANNELS.into_iter().zip(pass.whole) {
        for (index, value) in layers.get(name).unwrap().iter().enumerate() {
            let value_of = |own: &&str| part(layers, pass.names[1], own, channel)[index];
            let sum: f32 = pass.parts.iter().map(value_of).sum();
            worst = worst.max((sum - value).abs());
            brightest = brightest.max(*value);
        }
    }
    assert!(brightest > 0.0);
    worst / brightest
}

/// That the scene in `folder`, with these `others` among its passes, looks the same with and without `pass`, whose parts add up to
/// its whole. Returns the layers, which are in `told.exr`.
pub fn check(folder: &Path, pass: &Pass<'_>, others: &[&str], more: &[&str]) -> Layers {
    let rendered = |name: &str, passes: &[&str]| {
        let list = passes.join(",");
        let flag = if passes.is_empty() { &[][..] } else { &["--passes", &list] };
        report(folder, &[&["-o", name], flag, more].concat());
        layers(folder, name)
    };
    let plain = rendered("plain.exr", others);
    let all = rendered("told.exr", &[others, &pass.names[..1]].concat());
    assert_eq!(all.channels.len(), plain.channels.len() + 3 * pass.parts.len(), "{more:?}");
    for (name, values) in &plain.channels {
        let says = pass.names[0];
        assert!(all.get(name) == Some(values), "{name} is another with {says}, {more:?}");
    }
    let off = difference(&all, pass);
    assert!(off < 1e-6, "{off} with {more:?}");
    all
}

/// That the picture in `folder`, rendered with these `flags`, is that of its two crops. It is in `whole.exr`.
fn check_crops(folder: &Path, flags: &[&str]) {
    let rendered = |name: &str, more: &[&str]| {
        report(folder, &[&["-o", name], flags, more].concat());
    };
    rendered("whole.exr", &[]);
    for (name, crop) in [("a.exr", "0,0,24x9"), ("b.exr", "0,9,24x11")] {
        rendered(name, &["--crop", crop]);
    }
    merges(folder, &["a.exr", "b.exr"], "merged.exr");
    let [whole, merged] = ["whole.exr", "merged.exr"].map(|name| layers(folder, name));
    assert!(whole.channels.iter().all(|(name, values)| merged.get(name) == Some(values)));
}

/// That crops and means of the picture of `scene(ALL)` with these `passes` have the layers that pictures have, and the parts of
/// `pass` add up in both; so do crops of the reconstructed one.
pub fn check_merges(passes: &str, pass: &Pass<'_>) {
    let folder = folder(&scene(ALL));
    let folder = folder.path();
    let flags = ["--passes", passes, "--strategy", "beams"];
    check_crops(folder, &[&flags[..], &["--reconstruct"]].concat());
    assert!(difference(&layers(folder, "merged.exr"), pass) < 1e-6);
    check_crops(folder, &flags);
    report(folder, &[&["-o", "c.exr", "--seed", "6"][..], &flags].concat());
    merges(folder, &["whole.exr", "c.exr"], "mean.exr");
    assert!(difference(&layers(folder, "mean.exr"), pass) < 1e-6);
}

/// Mean over pictures with different seeds, and its squared standard error.
pub type Mean = (f64, f64);

/// The mean over the picture of three channels, by `name`.
pub fn means(layers: &Layers, name: impl Fn(&str) -> String) -> [f64; 3] {
    CHANNELS.map(|channel| {
        let values = layers.get(&name(channel)).unwrap();
        values.iter().map(|value| f64::from(*value)).sum::<f64>() / values.len() as f64
    })
}

/// The mean over eight pictures of which these are the values.
pub fn mean_of_eight(values: [f64; 8]) -> Mean {
    let mean = values.iter().sum::<f64>() / 8.0;
    let spread = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
    (mean, spread / (7.0 * 8.0))
}
