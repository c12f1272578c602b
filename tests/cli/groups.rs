//! The pass `groups` from outside: the light of each group of emitters.

use std::path::Path;

use fogbow::image::Layers;

use crate::parts::{layers, report};
use crate::told_apart::{
    ALL, CHANNELS, Pass, STRATEGIES, check, check_merges, folder, mean_of_eight, means, scene,
};
use crate::{is_there, printed, run};

/// The groups of [`scene`] in its order, the last of an emitter that names none.
const GROUPS: [&str; 5] = ["key", "fill", "sign", "fire", "rest"];

const OF_PICTURE: Pass<'_> =
    Pass { names: ["groups", "group"], parts: &GROUPS, whole: ["R", "G", "B"] };

#[test]
fn groups_add_up_to_the_picture_and_change_none_of_it() {
    let folder = folder(&scene(ALL));
    let folder = folder.path();
    let all = check(folder, &OF_PICTURE, &[], &[]);
    for group in GROUPS {
        let values = all.get(&format!("group.{group}.G")).unwrap();
        assert!(values.iter().any(|value| *value > 0.0), "{group} is black");
    }
    assert_eq!(all.attributes["fogbow:light_passes"], "parts of R, G and B");
    if is_there("oiiotool") {
        let mut args = vec![];
        for group in GROUPS {
            let channels = format!("group.{group}.R,group.{group}.G,group.{group}.B");
            args.extend(["told.exr".into(), "--ch".into(), channels]);
            args.extend(["--chnames".into(), "R,G,B".into()]);
        }
        args.extend(["--add"; 4].map(str::to_owned));
        args.extend(["-d", "float", "-o", "sum.exr"].map(str::to_owned));
        printed(folder, "oiiotool", &args.iter().map(String::as_str).collect::<Vec<_>>());
        let sum = layers(folder, "sum.exr");
        for name in CHANNELS {
            let pairs = sum.get(name).unwrap().iter().zip(all.get(name).unwrap());
            assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() <= 1e-5 * b.max(1.0)), "{name}");
        }
        let channels = "group.key.R,group.key.G,group.key.B";
        let dim = ["--ch", channels, "--chnames", "R,G,B", "--mulc", "0.5", "-o", "dimmed.exr"];
        printed(folder, "oiiotool", &[&["told.exr"][..], &dim].concat());
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
    for strategy in STRATEGIES {
        check(folder, &OF_PICTURE, &[], &["--strategy", strategy]);
    }
    check(folder, &OF_PICTURE, &["media"], &["--reconstruct"]);
    check(folder, &OF_PICTURE, &[], &["--reference"]);
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
    let plain = folder(text);
    let all = check(plain.path(), &Pass { parts: &["rest"], ..OF_PICTURE }, &[], &[]);
    assert!(all.get("group.rest.G") == all.get("G"));
    let named = folder(&text.replace("intensity = 9", "intensity = 9\ngroup = \"lamp\""));
    for strategy in ["auto", "beams", "fluence-toward-eye"] {
        let groups = Pass { parts: &["lamp", "rest"], ..OF_PICTURE };
        check(named.path(), &groups, &[], &["--strategy", strategy]);
    }
}

/// Each group takes the weights of the whole picture, so that its noise falls beside the mirror, which stays as it is. The flame
/// is left out: its edges, which the smoke around it hides from the filter, are smeared. The truth is a mean over 16 seeds.
#[test]
fn groups_are_reconstructed_as_the_picture_is() {
    let folder = folder(&scene(ALL));
    let folder = folder.path();
    let rendered = |seed: u32, more: &[&str]| {
        let seed = seed.to_string();
        let args = ["-o", "out.exr", "--passes", "groups", "--seed", &seed];
        report(folder, &[&args[..], more].concat());
        layers(folder, "out.exr")
    };
    let truth: Vec<Layers> = (101..=116).map(|seed| rendered(seed, &[])).collect();
    // Squared error of the layers of all three channels, of pictures with eight seeds.
    let error = |pictures: &[Layers], layer: &dyn Fn(&str) -> String| {
        let squares = CHANNELS.iter().map(|channel| {
            let name = layer(channel);
            let planes: Vec<&[f32]> = truth.iter().map(|of| of.get(&name).unwrap()).collect();
            let truth = |pixel: usize| {
                planes.iter().map(|plane| f64::from(plane[pixel])).sum::<f64>() / 16.0
            };
            let of_picture = |picture: &Layers| {
                let values = picture.get(&name).unwrap().iter().enumerate();
                let values = values.filter(|(pixel, _)| pixel % 24 < 16);
                values.map(|(pixel, value)| (f64::from(*value) - truth(pixel)).powi(2)).sum::<f64>()
            };
            pictures.iter().map(of_picture).sum::<f64>()
        });
        squares.sum::<f64>()
    };
    let [noisy, clean] = [&[][..], &["--reconstruct"]]
        .map(|more| (1..=8).map(|seed| rendered(seed, more)).collect::<Vec<Layers>>());
    for group in ["key", "fill", "sign", "rest"] {
        let layer = |channel: &str| format!("group.{group}.{channel}");
        let [before, after] = [&noisy, &clean].map(|pictures| error(pictures, &layer));
        assert!(after < 0.7 * before, "{group}: {after} after {before}");
    }
}

#[test]
fn crops_and_means_have_groups_as_pictures_have() {
    check_merges("groups", &OF_PICTURE);
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
                let [a, b] = [&alone, &parts]
                    .map(|pictures| mean_of_eight(pictures.map(|means| means[channel])));
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
