//! Pictures for a compositor, laid over each other by oiiotool.

use std::path::Path;

use crate::parts::{layers, merges, report, smoke};
use crate::{is_there, printed};

const SKY: &str = "[[light]]\ntype = \"environment\"\nradiance = [0.5, 0.7, 1.0]\n";

/// Renders s.toml of this text as `name`.
fn render(folder: &Path, text: &str, name: &str, more: &[&str]) {
    std::fs::write(folder.join("s.toml"), text).unwrap();
    report(folder, &[&["-o", name], more].concat());
}

#[test]
fn oiiotool_lays_pictures_over_plates() {
    if !is_there("oiiotool") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    // Grey smoke before a sky, without the floor.
    let all = smoke(4, 2000, "0.8");
    let [before, after] = ["[[surface]]", "[[light]]"].map(|key| all.find(key).unwrap());
    let media = [&all[..before], &all[after..]].concat();
    render(folder, &format!("{media}{SKY}"), "full.exr", &[]);
    render(folder, &format!("{media}{SKY}visible = false\n"), "front.exr", &[]);
    let camera = &all[..all.find("[[medium]]").unwrap()];
    render(folder, &format!("{camera}{SKY}"), "plate.exr", &[]);
    // Channels of half a picture alone are laid over each other, so that all have the same.
    let channels = ["--ch", "R,G,B,A"];
    let over =
        [&["front.exr"], &channels[..], &["plate.exr"], &channels, &["--over", "-o", "over.exr"]];
    printed(folder, "oiiotool", &over.concat());
    let (laid, full) = (layers(folder, "over.exr"), layers(folder, "full.exr"));
    for name in ["R", "G", "B"] {
        let pixels = laid.get(name).unwrap().iter().zip(full.get(name).unwrap());
        for (laid, full) in pixels {
            assert!((laid - full).abs() < 1e-4, "{name}: {laid} for {full}");
        }
    }
}

/// Crops of a shadow catcher are those of the whole, and passes have the mean of their coverage.
#[test]
fn shadow_catchers_merge() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let text = smoke(8, 2000, "0.8")
        .replace("shape = \"plane\"", "shape = \"plane\"\nshadow_catcher = true");
    render(folder, &text, "whole.exr", &[]);
    for (name, crop) in [("a.exr", "0,0,24x9"), ("b.exr", "0,9,24x11")] {
        render(folder, &text, name, &["--crop", crop]);
    }
    merges(folder, &["a.exr", "b.exr"], "crops.exr");
    for (name, pass) in [("1.exr", "1/2"), ("2.exr", "2/2")] {
        render(folder, &text, name, &["--pass", pass]);
    }
    merges(folder, &["1.exr", "2.exr"], "passes.exr");
    let [whole, crops, passes, one, two] =
        ["whole.exr", "crops.exr", "passes.exr", "1.exr", "2.exr"]
            .map(|name| layers(folder, name).get("A").unwrap().to_vec());
    assert_eq!(whole, crops);
    assert!(whole.iter().any(|a| *a > 0.3) && whole.iter().any(|a| *a < 0.05));
    for (mean, (one, two)) in passes.iter().zip(one.iter().zip(&two)) {
        assert!((mean - 0.5 * (one + two)).abs() < 1e-6, "{mean} of {one} and {two}");
    }
}
