//! `fogbow merge` from outside: crops and passes of a small scene.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::OnceLock;

use fogbow::image::{Film, Layers, write_exr, write_exr_layers};
use serde_json::Value;
use tempfile::TempDir;

use crate::parts::{copied, layers, merges, refuses, report};
use crate::run;

/// A ball of smoke before a wall.
const SCENE: &str = "\
[camera]
position = [0, 1, 8]
target = [0, 1, 0]
[film]
size = [33, 23]
[render]
rays = 4
photons = 2000
[[medium]]
region = { box = { min = [-1.0, 0.0, -1.0], max = [1.0, 2.0, 1.0] } }
sigma_t = 1.5
albedo = 0.8
[[surface]]
shape = \"plane\"
point = [0, 0, -2]
normal = [0.3, 0, 1]
[[light]]
type = \"area\"
center = [2, 5, 2]
u = [1, 0, 0]
v = [0, 0, 1]
radiance = [20, 16, 12]
";

/// Crops of odd sizes that fill the frame.
const CROPS: [&str; 4] = ["0,0,13x23", "13,0,20x7", "13,7,1x16", "14,7,19x16"];

fn render(folder: &Path, name: &str, more: &[&str]) {
    report(folder, &[&["-o", name], more].concat());
}

/// A folder with the scene, its frame whole.exr and crop0.exr to crop3.exr of seed 0, and 1.exr, 2.exr and 3.exr of those
/// seeds. Tests write other names.
fn parts() -> &'static Path {
    static PARTS: OnceLock<TempDir> = OnceLock::new();
    let made = PARTS.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("s.toml"), SCENE).unwrap();
        render(folder.path(), "whole.exr", &[]);
        for (index, crop) in CROPS.iter().enumerate() {
            render(folder.path(), &format!("crop{index}.exr"), &["--crop", crop]);
        }
        for seed in ["1", "2", "3"] {
            render(folder.path(), &format!("{seed}.exr"), &["--seed", seed]);
        }
        folder
    });
    made.path()
}

/// A folder of one test with copies of all [`parts`].
fn folder() -> TempDir {
    copied(parts())
}

fn bytes(folder: &Path, name: &str) -> [Vec<u8>; 2] {
    ["exr", "png"].map(|e| std::fs::read(folder.join(name).with_extension(e)).unwrap())
}

/// Writes the picture `from` as `name`, with an attribute set.
fn altered(folder: &Path, from: &str, name: &str, attribute: &str, value: &str) {
    let mut from = layers(folder, from);
    from.attributes.insert(attribute.into(), value.into());
    let named: Vec<_> = from.channels.iter().map(|(n, v)| (n.as_str(), v.as_slice())).collect();
    let attributes: Vec<_> = from.attributes.iter().map(|(n, v)| (n.as_str(), v.clone())).collect();
    let path = folder.join(name);
    write_exr_layers(&path, from.width, from.height, &named, &attributes).unwrap();
}

/// The bits of all layers.
fn bits(layers: &Layers) -> BTreeMap<String, Vec<u32>> {
    let bits = |values: &Vec<f32>| values.iter().map(|v| v.to_bits()).collect();
    layers.channels.iter().map(|(name, values)| (name.clone(), bits(values))).collect()
}

#[test]
fn crops_merged_equal_the_whole_bit_for_bit() {
    let folder = folder();
    let folder = folder.path();
    let [a, b, c, d] = ["crop0.exr", "crop1.exr", "crop2.exr", "crop3.exr"];
    assert_eq!(merges(folder, &[a, b, c, d], "out.exr"), "out.exr\nout.png\n");
    let (merged, whole) = (layers(folder, "out.exr"), layers(folder, "whole.exr"));
    assert!(whole.channels.len() >= 12 && whole.get("R").unwrap().iter().any(|r| *r > 0.0));
    assert!(bits(&merged) == bits(&whole), "pixels differ");
    assert_eq!((merged.corner, merged.display), (whole.corner, whole.display));
    assert_eq!(bytes(folder, "out.exr")[1], bytes(folder, "whole.exr")[1], "the PNG differs");

    // The header is that of the whole but for the work, which is that of all crops, and the recipe.
    let settings = |layers: &Layers| -> Vec<(String, String)> {
        let own = |name: &str| !name.starts_with("fogbow:work:") && name != "fogbow:recipe";
        layers.attributes.clone().into_iter().filter(|(name, _)| own(name)).collect()
    };
    assert_eq!(settings(&merged), settings(&whole));
    let work = |layers: &Layers, name: &str| {
        layers.attributes[&format!("fogbow:work:{name}")].parse::<u64>().unwrap()
    };
    assert_eq!(work(&merged, "rays"), work(&whole, "rays"));
    let paths = work(&whole, "photon_paths");
    assert!(paths > 0);
    assert_eq!(work(&merged, "photon_paths"), 4 * paths);

    merges(folder, &[d, b, a, c], "other.exr");
    assert_eq!(bytes(folder, "out.exr"), bytes(folder, "other.exr"), "the order changes bytes");
}

#[test]
fn passes_are_averaged_in_any_order_to_the_same_bytes() {
    let folder = folder();
    let folder = folder.path();
    merges(folder, &["1.exr", "2.exr", "3.exr"], "out.exr");
    for order in [["3.exr", "2.exr", "1.exr"], ["2.exr", "3.exr", "1.exr"]] {
        merges(folder, &order, "other.exr");
        assert_eq!(bytes(folder, "out.exr"), bytes(folder, "other.exr"), "{order:?}");
    }
    let parts = ["1.exr", "2.exr", "3.exr"].map(|name| layers(folder, name));
    let merged = layers(folder, "out.exr");
    let of = |name: &str| parts.each_ref().map(|part| part.get(name).unwrap());
    for name in ["R", "G", "B", "A", "transmittance", "saliency", "xs", "radius", "step"] {
        for (index, found) in merged.get(name).unwrap().iter().enumerate() {
            let sum: f64 = of(name).iter().map(|part| f64::from(part[index])).sum();
            assert_eq!(*found, (sum / 3.0) as f32, "{name} at {index}");
        }
    }
    assert_ne!(of("R")[0], of("R")[1], "seeds change the picture");
    assert!(merged.get("rays").unwrap().iter().all(|rays| *rays == 12.0));
    let nearest = |index: usize| of("Z").iter().map(|z| z[index]).fold(f32::MAX, f32::min);
    assert!(merged.get("Z").unwrap().iter().enumerate().all(|(i, z)| *z == nearest(i)));
    let attributes = &merged.attributes;
    let passes: Value = serde_json::from_str(&attributes["fogbow:passes"]).unwrap();
    let seeds: Vec<_> = passes.as_array().unwrap().iter().map(|p| p["seed"].clone()).collect();
    assert_eq!(seeds, [1, 2, 3]);
    assert!(passes.as_array().unwrap().iter().all(|pass| pass["weight"] == 1.0 / 3.0));
    assert!(!attributes.contains_key("fogbow:seed") && !attributes.contains_key("fogbow:recipe"));
    assert_eq!(attributes["fogbow:photons"], "2000");
    assert_eq!(attributes["fogbow:work:rays"], (3 * 33 * 23 * 4).to_string());
    refuses(folder, &["other.exr", "whole.exr"], &["other.exr", "merged of passes already"]);
}

#[test]
fn passes_may_be_in_crops() {
    let folder = folder();
    let folder = folder.path();
    merges(folder, &["whole.exr", "1.exr"], "whole_passes.exr");
    let parts = ["crop3.exr", "1.exr", "crop0.exr", "crop2.exr", "crop1.exr"];
    merges(folder, &parts, "out.exr");
    let [whole, crops] = ["whole_passes.exr", "out.exr"].map(|name| layers(folder, name));
    assert!(whole.channels == crops.channels, "pixels differ");
    refuses(folder, &parts[..4], &["crop0.exr: ", "crop3.exr", "seed 0", "pixels 13,0,20x7;"]);
}

#[test]
fn passes_weigh_by_rays_and_photons() {
    let folder = folder();
    let folder = folder.path();
    render(folder, "more.exr", &["--seed", "4", "--rays", "8"]);
    let (code, out, _) = run(folder, &["merge", "more.exr", "1.exr", "-o", "out.exr", "--json"]);
    assert_eq!(code, 0);
    let report: Value = serde_json::from_str(&out).unwrap();
    assert_eq!((&report["size"], &report["parts"]), (&serde_json::json!([33, 23]), &2.into()));
    assert_eq!(report["outputs"], serde_json::json!(["out.exr", "out.png"]));
    let weights = [0, 1].map(|pass| report["passes"][pass]["weight"].as_f64().unwrap());
    assert!((weights[0] - 7.0 / 17.0).abs() < 1e-12 && (weights[1] - 10.0 / 17.0).abs() < 1e-12);
    let [one, more, merged] = ["1.exr", "more.exr", "out.exr"].map(|name| layers(folder, name));
    let [one, more, merged] = [&one, &more, &merged].map(|layers| layers.get("G").unwrap());
    for ((one, more), found) in one.iter().zip(more).zip(merged) {
        let mean = weights[0] * f64::from(*one) + weights[1] * f64::from(*more);
        assert!((mean - f64::from(*found)).abs() <= 1e-6 * mean.abs(), "{found} for {mean}");
    }
    let attributes = layers(folder, "out.exr").attributes;
    assert!(!attributes.contains_key("fogbow:rays"), "rays stand with each pass");
}

#[test]
fn gaps_and_overlaps_name_their_places_and_files() {
    let folder = folder();
    let folder = folder.path();
    let [a, b, c, d] = ["crop0.exr", "crop1.exr", "crop2.exr", "crop3.exr"];
    refuses(folder, &[a, b, d], &[a, b, d, "seed 0", "pixels 13,7,1x16; render --crop 13,7,1x16"]);
    refuses(folder, &[a], &["crop0.exr: leaves gaps: no part", "pixels 13,0,20x23"]);
    render(folder, "wide.exr", &["--crop", "13,0,20x9"]);
    refuses(folder, &[a, "wide.exr", c, d], &["wide.exr: overlaps crop2.exr", "pixels 13,7,1x2,"]);
    refuses(folder, &[a, "whole.exr"], &["crop0.exr", "whole.exr", "pixels 0,0,13x23"]);
    std::fs::copy(folder.join("1.exr"), folder.join("again.exr")).unwrap();
    let twice = ["1.exr: has the seed 1", "as has again.exr", "count twice"];
    refuses(folder, &["1.exr", "again.exr"], &twice);
    refuses(folder, &["2.exr", "1.exr", "2.exr"], &["seed 2", "count twice"]);
}

#[test]
fn parts_of_other_pictures_are_refused_by_name() {
    let folder = folder();
    let folder = folder.path();
    let cases: [(&[&str], &str); 6] = [
        (&["--set", "medium.0.albedo=0.7"], "fogbow:scene"),
        (&["--size", "32x23"], "fogbow:size is `[32,23]`, and `[33,23]` in 1.exr"),
        (&["--max-scatter", "3"], "fogbow:max_scatter"),
        (&["--radius", "0.2"], "fogbow:radius_asked is `0.2`, and not there in 1.exr"),
        (&["--reference"], "fogbow:method is `reference`, and `photon map` in 1.exr"),
        (&["--exposure", "1"], "fogbow:exposure is `1.0`"),
    ];
    for (more, says) in cases {
        render(folder, "other.exr", &[more, &["--seed", "9"]].concat());
        let says = ["other.exr: ", says, "the same scene, settings and version"];
        refuses(folder, &["1.exr", "other.exr"], &says);
    }
    // Crops of one pass have the same rays and photons.
    render(folder, "more.exr", &["--crop", CROPS[3], "--photons", "2001"]);
    let parts = ["crop0.exr", "crop1.exr", "crop2.exr", "more.exr"];
    refuses(folder, &parts, &["more.exr: fogbow:photons is `2001`, and `2000` in crop0.exr"]);
    altered(folder, "2.exr", "other.exr", "fogbow:version", "0.0.1");
    refuses(folder, &["1.exr", "other.exr"], &["other.exr: fogbow:version is `0.0.1`", "1.exr"]);
}

#[test]
fn unfinished_and_foreign_files_are_refused_by_name() {
    let folder = folder();
    let folder = folder.path();
    for (attribute, value, says) in [
        ("fogbow:complete", "false", "is unfinished"),
        ("fogbow:preview", "true", "is unfinished"),
        ("fogbow:crop", "0,0,3x3", "has the data window 0,0,33x23"),
        ("fogbow:size", "[1,", "has the data window 0,0,33x23"),
        ("fogbow:seed", "two", "fogbow:seed is `two`; it must be a whole number"),
        ("fogbow:work:rays", "-1", "fogbow:work:rays is `-1`"),
        ("fogbow:work:rays", &u64::MAX.to_string(), "too large"),
    ] {
        altered(folder, "2.exr", "other.exr", attribute, value);
        refuses(folder, &["3.exr", "1.exr", "other.exr"], &["exr: ", says]);
    }
    exr::prelude::write_rgb_file(folder.join("rgb.exr"), 33, 23, |_, _| {
        (0.5_f32, 0.5_f32, 0.5_f32)
    })
    .unwrap();
    refuses(folder, &["1.exr", "rgb.exr"], &["rgb.exr: has no fogbow:version"]);
    std::fs::write(folder.join("text.exr"), "a text").unwrap();
    refuses(folder, &["1.exr", "text.exr"], &["text.exr: is not an EXR file"]);
    refuses(folder, &["1.exr", "gone.exr"], &["gone.exr: cannot be read"]);
    refuses(folder, &["1.exr", "."], &[".: is a folder"]);
    let whole = std::fs::read(folder.join("2.exr")).unwrap();
    for end in [4, 100, 2000, whole.len() / 2, whole.len() - 1] {
        std::fs::write(folder.join("half.exr"), &whole[..end]).unwrap();
        refuses(folder, &["1.exr", "half.exr"], &["half.exr: "]);
    }
}

#[test]
fn the_output_is_none_of_the_parts() {
    let folder = folder();
    let folder = folder.path();
    let before = bytes(folder, "1.exr");
    for output in ["1.exr", "./1.exr"] {
        let (code, out, err) = run(folder, &["merge", "2.exr", "1.exr", "-o", output]);
        assert_eq!((code, out.as_str()), (2, ""), "{err}");
        assert!(err.contains("is the part 1.exr; name another file"), "{err}");
    }
    assert_eq!(bytes(folder, "1.exr"), before);
    for (args, says) in [
        (&["merge", "1.exr", "-o", "a.png"][..], "ends in .exr"),
        (&["merge", "-o", "a.exr"], "PART.exr"),
        (&["merge", "1.exr"], "--output"),
    ] {
        let (code, _, err) = run(folder, args);
        assert!(code == 2 && err.contains(says), "{args:?}: {code} {err}");
    }
}

/// Crops that are narrower than what the filter looks at, and that leave out pixels which it does not reach.
#[test]
fn reconstructed_crops_merged_equal_the_whole_bit_for_bit() {
    let folder = folder();
    let folder = folder.path();
    let crops = ["0,0,97x31", "97,0,1x31", "98,0,63x17", "98,17,63x14"];
    for directed in [&[][..], &["--director", "xs", "--x", "error", "--op", "tolerance"]] {
        let more = [&["--reconstruct", "--size", "161x31", "--rays", "3"], directed].concat();
        render(folder, "all.exr", &more);
        for (index, crop) in crops.iter().enumerate() {
            let threads = (1 + index % 3).to_string();
            let own = ["--crop", crop, "--threads", &threads];
            render(folder, &format!("part{index}.exr"), &[&more[..], &own].concat());
        }
        let parts = [0, 1, 2, 3].map(|index| format!("part{index}.exr"));
        merges(folder, &parts, "out.exr");
        let [merged, whole] = ["out.exr", "all.exr"].map(|name| layers(folder, name));
        assert!(whole.channels["noisy.R"] != whole.channels["R"]);
        assert!(bits(&merged) == bits(&whole), "pixels differ: {more:?}");
    }
}

#[test]
fn crops_that_were_denoised_are_merged_with_a_warning() {
    let folder = folder();
    let folder = folder.path();
    for (name, crop) in [("a", "0,0,16x23"), ("b", "16,0,17x23")] {
        render(folder, "crop.exr", &["--crop", crop]);
        // Black pixels, and the header of a crop for which a library for it was there.
        let part = layers(folder, "crop.exr");
        let film = Film::part([33, 23], crop.parse().unwrap());
        let denoised = ("fogbow:denoised", "true".to_owned());
        let attributes = part.attributes.iter().map(|(n, v)| (n.as_str(), v.clone()));
        let attributes: Vec<_> = attributes.chain([denoised]).collect();
        write_exr(&folder.join(format!("{name}.exr")), &film, &attributes).unwrap();
    }
    let (code, _, err) = run(folder, &["merge", "a.exr", "b.exr", "-o", "out.exr"]);
    assert!(code == 0 && err.contains("warning: the crops are denoised"), "{err}");
}

/// The variance that the layers of two halves of twelve passes tell, over half of their squared difference. It is 1
/// on average; what each pass knows of its own rays is far from it. Over all pixels, which share photons, the ratio
/// scatters by about a sixth.
#[test]
fn variance_is_that_of_rays_and_photons() {
    let folder = folder();
    let folder = folder.path();
    let names: Vec<String> = (10..22).map(|seed| format!("p{seed}.exr")).collect();
    for (seed, name) in (10..22).zip(&names) {
        render(folder, name, &["--seed", &seed.to_string(), "--photons", "400", "--rays", "8"]);
    }
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let [a, b] = [(&names[..6], "a.exr"), (&names[6..], "b.exr")].map(|(parts, name)| {
        merges(folder, parts, name);
        layers(folder, name)
    });
    let light = |layers: &Layers| -> Vec<f64> { layers.image().unwrap().luminances().collect() };
    let variance = |layers: &Layers| {
        layers.get("variance").unwrap().iter().map(|v| f64::from(*v)).sum::<f64>()
    };
    let differences = light(&a).into_iter().zip(light(&b)).map(|(a, b)| (a - b).powi(2));
    let truth = differences.sum::<f64>() / 2.0;
    let ratio = (variance(&a) + variance(&b)) / 2.0 / truth;
    assert!((0.5..1.6).contains(&ratio), "{ratio}");
}
