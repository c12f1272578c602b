//! The pass `scattered` from outside: light of media by the order of its scattering.

use std::path::Path;

use fogbow::image::Layers;

use crate::parts::{layers, report};
use crate::run;
use crate::told_apart::{
    ALL, CHANNELS, Mean, Pass, STRATEGIES, check, check_merges, difference, folder, mean_of_eight,
    means, part, scene,
};

const ORDERS: [&str; 3] = ["emitted", "first", "more"];

const OF_MEDIA: Pass<'_> =
    Pass { names: ["scattered"; 2], parts: &ORDERS, whole: ["media.R", "media.G", "media.B"] };

/// Whether a part is black everywhere.
fn is_black(layers: &Layers, order: &str) -> bool {
    let is_black = |channel| part(layers, "scattered", order, channel).iter().all(|v| *v == 0.0);
    CHANNELS.into_iter().all(is_black)
}

/// The scene in `folder`, rendered with `passes` and as `more` says.
fn rendered(folder: &Path, passes: &str, more: &[&str]) -> Layers {
    report(folder, &[&["-o", "out.exr", "--passes", passes][..], more].concat());
    layers(folder, "out.exr")
}

#[test]
fn orders_add_up_to_the_light_of_media_and_change_none_of_the_picture() {
    let folder = folder(&scene(ALL));
    let folder = folder.path();
    let ways = STRATEGIES.map(|strategy| vec!["--strategy", strategy]);
    let others = [vec![], vec!["--reconstruct"], vec!["--threads", "1"]];
    for more in ways.into_iter().chain(others) {
        let all = check(folder, &OF_MEDIA, &["media"], &more);
        assert!(!ORDERS.iter().any(|order| is_black(&all, order)), "{more:?}");
        let says = &all.attributes["fogbow:light_passes"];
        assert!(says.starts_with("parts of "), "{says}");
    }
    report(folder, &["-o", "plain.exr", "--reference"]);
    let plain = layers(folder, "plain.exr");
    let all = rendered(folder, "scattered", &["--reference"]);
    assert!(plain.channels.iter().all(|(name, values)| all.get(name) == Some(values)));
}

/// A box of smoke before the camera, with `more`; light is scattered so many times.
fn smoke(times: u32, more: &str) -> String {
    format!(
        "
[camera]
position = [0, 0, 6]
target = [0, 0, 0]
[film]
size = [16, 12]
[render]
rays = 4
photons = 4000
max_scatter = {times}
[[medium]]
region = {{ box = {{ min = [-1.0, -1.0, -1.0], max = [1.0, 1.0, 1.0] }} }}
sigma_t = 2.0
albedo = [0.9, 0.8, 0.7]
phase = {{ type = \"henyey-greenstein\", g = 0.6 }}
{more}"
    )
}

const LAMP: &str = "
[[light]]
type = \"point\"
position = [0, 4, 0]
intensity = [9, 8, 7]
";

const SKY: &str = "
[[light]]
type = \"environment\"
radiance = 0.3
";

const FLAME: &str = "
[[medium]]
region = { sphere = { center = [0.0, -0.4, 0.0], radius = 0.4 } }
sigma_t = 0.5
albedo = 0.5
emission = { color = [6.0, 2.0, 0.5], scale = 1.0 }
";

/// A wall below the smoke that alone a spot light shines at.
const LIT_WALL: &str = "
[[surface]]
shape = \"quad\"
center = [0, -4, 0]
u = [3, 0, 0]
v = [0, 0, -3]
material = { type = \"diffuse\", reflectance = 0.8 }
[[light]]
type = \"spot\"
position = [1.5, -2, 0]
target = [0.6, -4, 0]
angle = 40
intensity = 50
";

#[test]
fn light_of_a_lamp_a_sky_or_a_flame_that_smoke_scatters_once_is_the_first_order() {
    for (light, glows) in [(LAMP, false), (SKY, false), (FLAME, true)] {
        let folder = folder(&smoke(1, light));
        for how in [&[][..], &["--strategy", "beams"], &["--reference"]] {
            let found = rendered(folder.path(), "scattered", how);
            assert!(is_black(&found, "more"), "{light} {how:?}");
            assert!(!is_black(&found, "first"), "{light} {how:?}");
            assert_eq!(is_black(&found, "emitted"), !glows, "{light} {how:?}");
            // The sky is seen beside.
            if light != SKY {
                let once = Pass { parts: &["emitted", "first"], whole: CHANNELS, ..OF_MEDIA };
                let off = difference(&found, &once);
                assert!(off < 1e-6, "{off} of {light}, {how:?}");
            }
        }
    }
}

#[test]
fn light_of_a_wall_or_a_mirror_is_more_than_the_first_order() {
    let mirror = LIT_WALL.replace("diffuse", "mirror");
    for times in [1, 9] {
        // No path from the camera finds a lamp without a surface in a mirror.
        for (wall, how) in [
            (LIT_WALL, &["--strategy", "beams"][..]),
            (LIT_WALL, &["--reference", "--rays", "64"]),
            (&mirror, &["--strategy", "beams"]),
        ] {
            let folder = folder(&smoke(times, wall));
            let found = rendered(folder.path(), "scattered", how);
            let says = format!("{wall} {times} {how:?}");
            assert!(is_black(&found, "first") && is_black(&found, "emitted"), "{says}");
            assert!(!is_black(&found, "more"), "{says}");
        }
    }
}

#[test]
fn crops_and_means_have_orders_as_pictures_have() {
    check_merges("media,scattered", &OF_MEDIA);
}

/// Means of the channels of each order over pictures of the scene `text`, made as `how` says.
fn means_of_orders(text: &str, how: &[&str]) -> [[Mean; 3]; 3] {
    let folder = folder(text);
    let of_seed = |seed: u32| {
        let seed = seed.to_string();
        let found = rendered(folder.path(), "scattered", &[how, &["--seed", &seed]].concat());
        ORDERS.map(|order| means(&found, |channel| format!("scattered.{order}.{channel}")))
    };
    let pictures: [_; 8] = std::array::from_fn(|seed| of_seed(1 + seed as u32));
    std::array::from_fn(|order| {
        std::array::from_fn(|channel| mean_of_eight(pictures.map(|means| means[order][channel])))
    })
}

/// Fog that scatters nearly ahead, before a wall that a lamp lights too: its peak deflects rays.
const PEAKED: &str = "
[camera]
position = [0, 1, 6]
target = [0, 1, 0]
[film]
size = [16, 12]
[render]
photons = 100000
[[medium]]
region = { box = { min = [-2.0, 0.0, -2.0], max = [2.0, 2.0, 2.0] } }
sigma_t = 0.8
albedo = [0.95, 0.9, 0.8]
phase = { type = \"henyey-greenstein\", g = 0.85 }
emission = { color = [0.1, 0.2, 0.3], scale = 0.2 }
[[surface]]
shape = \"plane\"
point = [0, 0, -3]
normal = [0, 0, 1]
material = { type = \"diffuse\", reflectance = 0.7 }
[[light]]
type = \"area\"
center = [0, 5, 0]
u = [1, 0, 0]
v = [0, 0, 1]
radiance = [20, 14, 9]
";

/// Orders of photon map, caches and gathers are those of the reference. Means of eight pictures each differ by less than six
/// standard errors as these tell them, and by what estimators with kernels and cells may be off: with Student's distribution of
/// 14 degrees of freedom a false alarm of 3e-5 a number, of 2e-3 in all at these fixed seeds.
#[test]
fn orders_are_those_of_the_reference() {
    let smoky = scene(ALL);
    let cases = [
        (smoky.as_str(), "traced", 0.0),
        (&smoky, "moments", BIAS),
        (&smoky, "shared-gathers", BIAS),
        (&smoky, "fluence-toward-eye", BIAS),
        (&smoky, "beams", BIAS),
        (PEAKED, "beams", BIAS),
    ];
    let right = [smoky.as_str(), PEAKED]
        .map(|text| (text, means_of_orders(text, &["--reference", "--rays", "64"])));
    for (text, strategy, bias) in cases {
        let found = means_of_orders(text, &["--strategy", strategy, "--rays", "16"]);
        let (_, right) = right.iter().find(|(of, _)| *of == text).unwrap();
        for (order, (found, right)) in ORDERS.iter().zip(found.iter().zip(right)) {
            for (found, right) in found.iter().zip(right) {
                let off = (found.0 - right.0).abs();
                let allowed = 6.0 * (found.1 + right.1).sqrt() + bias * right.0;
                assert!(off <= allowed, "{strategy} {order}: {} for {}", found.0, right.0);
            }
        }
    }
}

/// What kernels and cells may be off by, of light.
const BIAS: f64 = 0.03;

/// The first order is what is scattered in a picture of light that is scattered once, with nothing that reflects. Twelve
/// numbers of the false alarm above, 4e-4 in all.
#[test]
fn the_first_order_is_the_picture_of_light_scattered_once() {
    let light = LAMP.to_owned() + SKY + FLAME;
    let once = means_of_orders(&smoke(1, &light), &["--reference", "--rays", "64"]);
    for how in [&["--reference", "--rays", "64"][..], &["--strategy", "traced", "--rays", "16"]] {
        let all = means_of_orders(&smoke(99, &light).replace("max_scatter = 99", ""), how);
        for (all, once) in all.iter().zip(&once).take(2) {
            for (all, once) in all.iter().zip(once) {
                let error = (all.1 + once.1).sqrt();
                assert!((all.0 - once.0).abs() <= 6.0 * error, "{how:?}: {} for {}", all.0, once.0);
            }
        }
    }
}

#[test]
fn what_has_no_orders_ends_in_one_message() {
    let folder = folder(&smoke(9, LAMP));
    let refused = |more: &[&str], says: &[&str]| {
        let args = [&["render", "s.toml", "-o", "out.exr", "--quiet"], more].concat();
        let (code, _, err) = run(folder.path(), &args);
        assert!(code != 0 && err.lines().count() == 1, "{err}");
        assert!(says.iter().all(|words| err.contains(words)), "{says:?}: {err}");
    };
    refused(&["--passes", "groups,scattered"], &["passes groups and scattered", "leave one"]);
    report(folder.path(), &["--photons-to", "map.fog"]);
    let from_file = ["--photons-from", "map.fog", "--passes", "scattered"];
    refused(&from_file, &["map.fog: saved photons do not tell how often they were scattered"]);
}
