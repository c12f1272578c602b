//! `fogbow render --pass` and the merge of passes, from outside.

use std::path::Path;
use std::sync::OnceLock;

use fogbow::image::Layers;
use serde_json::Value;
use tempfile::TempDir;

use crate::parts::{copied, layers, light, merges, refuses, report, smoke};
use crate::run;

/// Passes of the picture.
const PASSES: u32 = 4;

/// Renders with `more` arguments; the report.
fn render(folder: &Path, name: &str, more: &[&str]) -> Value {
    report(folder, &[&["-o", name], more].concat())
}

/// Renders all passes of a picture with `more` arguments, as 1.exr and so on after `prefix`; their names.
fn passes(folder: &Path, prefix: &str, count: u32, more: &[&str]) -> Vec<String> {
    let pass = |number: u32| {
        let name = format!("{prefix}{number}.exr");
        render(folder, &name, &[more, &["--pass", &format!("{number}/{count}")]].concat());
        name
    };
    (1..=count).map(pass).collect()
}

/// A folder with the scene, its frame whole.exr, and p1.exr to p4.exr of its passes. Tests write other names.
fn rendered() -> &'static Path {
    static MADE: OnceLock<TempDir> = OnceLock::new();
    let made = MADE.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("s.toml"), smoke(8, 20_000, "0.95")).unwrap();
        render(folder.path(), "whole.exr", &[]);
        passes(folder.path(), "p", PASSES, &[]);
        folder
    });
    made.path()
}

/// A folder of one test with copies of all that is [`rendered`].
fn folder() -> TempDir {
    copied(rendered())
}

/// The merge of `parts`.
fn merged(folder: &Path, parts: &[impl AsRef<str>], output: &str) -> Layers {
    merges(folder, parts, output);
    layers(folder, output)
}

fn work(layers: &Layers, name: &str) -> u64 {
    layers.attributes[&format!("fogbow:work:{name}")].parse().unwrap()
}

#[test]
fn passes_shoot_the_rays_and_photons_of_the_whole_once() {
    let folder = folder();
    let folder = folder.path();
    let names = ["p3.exr", "p1.exr", "p4.exr", "p2.exr"];
    let (whole, mean) = (layers(folder, "whole.exr"), merged(folder, &names, "m.exr"));
    for name in ["rays", "photon_paths", "photons_emitted", "volume_photons", "surface_photons"] {
        assert_eq!(work(&mean, name), work(&whole, name), "{name}");
    }
    assert!(work(&whole, "photon_paths") == 20_000 && work(&whole, "surface_photons") > 0);
    assert_eq!(mean.get("rays"), whole.get("rays"));
    for (mean, whole) in mean.get("A").unwrap().iter().zip(whole.get("A").unwrap()) {
        assert!((mean - whole).abs() < 1e-6, "alpha is {mean}, and {whole} of the same rays");
    }
    // The header is that of the whole, with a list of passes.
    for name in ["seed", "rays", "photons", "strategies", "step", "scene"] {
        let name = format!("fogbow:{name}");
        assert_eq!(mean.attributes.get(&name), whole.attributes.get(&name), "{name}");
    }
    assert!(!mean.attributes.contains_key("fogbow:pass"));
    let listed: Value = serde_json::from_str(&mean.attributes["fogbow:passes"]).unwrap();
    for (index, pass) in listed.as_array().unwrap().iter().enumerate() {
        let name = format!("{}/{PASSES}", index + 1);
        assert_eq!((&pass["pass"], &pass["weight"]), (&name.into(), &0.25.into()));
        assert_eq!((&pass["rays"], &pass["photons"]), (&2.into(), &5000.into()));
    }
    // The same photons, each with a kernel as wide as the whole gives it: what is left are the edges of
    // kernels, which lie elsewhere by what a quarter of the photons tells of their density.
    let ratio = light(&mean) / light(&whole);
    assert!((ratio - 1.0).abs() < 0.01, "{ratio}");
}

#[test]
fn passes_are_estimated_as_the_whole_is() {
    let folder = folder();
    let folder = folder.path();
    let strategy = |name: &str, more: &[&str]| render(folder, name, more)["strategy"].clone();
    let whole = strategy("a.exr", &[]);
    for pass in ["1/8", "8/8"] {
        assert_eq!(strategy("a.exr", &["--pass", pass]), whole, "{pass}");
    }
    let grid = ["--strategy", "fluence-toward-eye"];
    let [all, one] = [&[][..], &["--pass", "2/8"]].map(|more| {
        strategy("a.exr", &[&grid[..], more].concat())["media"][0]["cell_width"].clone()
    });
    assert!(all.is_number() && all == one, "{all} and {one}");
    // One pass of one is the picture.
    render(folder, "one.exr", &["--pass", "1/1"]);
    let bytes = |name: &str| std::fs::read(folder.join(name)).unwrap();
    assert!(bytes("one.exr") == bytes("whole.exr"), "1/1 is not the whole");
}

/// The same rays read the same photons, so that only what a pass fills or gathers by itself differs.
#[test]
fn passes_by_saved_photons_have_the_noise_of_the_whole() {
    let folder = folder();
    let folder = folder.path();
    // As many rays as each pass gathers photons once for.
    let rays = ["--rays", "16"];
    render(folder, "all.exr", &rays);
    render(folder, "seed6.exr", &[&rays[..], &["--seed", "6"]].concat());
    render_photons(folder);
    let from = ["--photons-from", "map.fog"];
    let names = passes(folder, "s", PASSES, &[&rays[..], &from].concat());
    let (whole, mean) = (layers(folder, "all.exr"), merged(folder, &names, "m.exr"));
    assert_eq!((work(&mean, "photon_paths"), work(&mean, "rays")), (0, work(&whole, "rays")));
    assert_eq!(mean.attributes.get("fogbow:radius"), whole.attributes.get("fogbow:radius"));
    assert_eq!(mean.get("rays"), whole.get("rays"));
    // Pictures of other photons are further off.
    let off = |other: &Layers| {
        let [whole, other] = [&whole, other].map(|layers| layers.image().unwrap());
        let squares = whole.luminances().zip(other.luminances()).map(|(a, b)| (a - b).powi(2));
        squares.sum::<f64>()
    };
    let names = passes(folder, "t", PASSES, &rays);
    let shot = merged(folder, &names, "shot.exr");
    let (read, shot, other) = (off(&mean), off(&shot), off(&layers(folder, "seed6.exr")));
    assert!(2.0 * read < shot && 4.0 * read < other, "{read}, {shot} and {other}");
    // All passes read them, or all shoot.
    let says = ["fogbow:photons_saved is", "not there"];
    refuses(folder, &["s1.exr", "t2.exr", "s3.exr", "s4.exr"], &says);
    // A pass may be in crops, which read them too.
    for (name, crop) in [("left.exr", "0,0,9x20"), ("right.exr", "9,0,15x20")] {
        let part = ["--pass", "2/4", "--crop", crop];
        render(folder, name, &[&rays[..], &from, &part].concat());
    }
    let crops = ["left.exr", "s1.exr", "right.exr", "s3.exr", "s4.exr"];
    assert!(merged(folder, &crops, "c.exr").channels == mean.channels, "pixels differ");
}

/// Saves the photons of the scene in map.fog.
fn render_photons(folder: &Path) {
    report(folder, &["--photons-to", "map.fog"]);
}

/// Rays of the reference share nothing, so that the mean of passes is the whole but for rounding, whether or not the
/// number of rays is a multiple of theirs.
#[test]
fn passes_of_the_reference_are_the_whole() {
    let folder = folder();
    let folder = folder.path();
    for count in [2, 3, 8] {
        let names = passes(folder, "r", count, &["--reference"]);
        render(folder, "whole.exr", &["--reference"]);
        let (whole, mean) = (layers(folder, "whole.exr"), merged(folder, &names, "m.exr"));
        for name in ["R", "G", "B", "A", "transmittance", "rays", "Z"] {
            let [whole, mean] = [&whole, &mean].map(|layers| layers.get(name).unwrap());
            for (a, b) in whole.iter().zip(mean) {
                assert!((a - b).abs() <= 2e-6 * a.abs(), "{name}: {a} and {b} in {count} passes");
            }
        }
    }
}

#[test]
fn passes_may_be_in_crops() {
    let folder = folder();
    let folder = folder.path();
    let whole = merged(folder, &["p1.exr", "p2.exr", "p3.exr", "p4.exr"], "m.exr");
    for (name, crop) in [("left.exr", "0,0,9x20"), ("right.exr", "9,0,15x20")] {
        render(folder, name, &["--pass", "2/4", "--crop", crop]);
    }
    let parts = ["right.exr", "p4.exr", "p1.exr", "left.exr", "p3.exr"];
    let crops = merged(folder, &parts, "c.exr");
    assert!(whole.channels == crops.channels, "pixels differ");
    let says =
        ["right.exr: leaves gaps", "seed 5 and pass 2/4", "render --pass 2/4 --crop 0,0,9x20"];
    refuses(folder, &["right.exr", "p4.exr", "p1.exr", "p3.exr"], &says);
}

#[test]
fn passes_that_are_missing_twice_there_or_of_other_pictures_are_told() {
    let folder = folder();
    let folder = folder.path();
    let [a, b, c, d] = ["p1.exr", "p2.exr", "p3.exr", "p4.exr"];
    refuses(
        folder,
        &[a, d],
        &["p1.exr: is pass 1/4 of seed 5", "no part is 2/4 or 3/4; render --pass 2/4"],
    );
    refuses(folder, &[b], &["p2.exr", "no part is 1/4 or 3/4 or 4/4; render --pass 1/4"]);
    std::fs::copy(folder.join(c), folder.join("again.exr")).unwrap();
    let twice = ["p3.exr: has the seed 5 and pass 3/4", "as has again.exr", "count twice"];
    refuses(folder, &[a, b, c, d, "again.exr"], &twice);
    refuses(folder, &[a, b, c, d, "whole.exr"], &["the whole of seed 5", "they share rays"]);
    render(folder, "of_eight.exr", &["--pass", "1/8"]);
    refuses(folder, &[a, b, c, d, "of_eight.exr"], &["pass 1/8 of seed 5", "they share rays"]);
    render(folder, "more.exr", &["--pass", "2/4", "--rays", "16"]);
    refuses(folder, &[a, "more.exr", c, d], &["more.exr: fogbow:rays is `16`, and `8` in p1.exr"]);
    render(folder, "goal.exr", &["--seed", "7", "--error", "0.5"]);
    refuses(folder, &["whole.exr", "goal.exr"], &["goal.exr: was rendered to the error 0.5"]);
    // Frames of other seeds may be whole or in passes.
    render(folder, "seed6.exr", &["--seed", "6"]);
    let both = merged(folder, &[a, b, c, d, "seed6.exr"], "both.exr");
    let passes: Value = serde_json::from_str(&both.attributes["fogbow:passes"]).unwrap();
    let weights: Vec<f64> =
        passes.as_array().unwrap().iter().map(|pass| pass["weight"].as_f64().unwrap()).collect();
    assert_eq!(weights, [0.125, 0.125, 0.125, 0.125, 0.5]);
    assert!(both.get("rays").unwrap().iter().all(|rays| *rays == 16.0));
}

#[test]
fn directed_pictures_have_their_rays_in_passes() {
    let folder = folder();
    let folder = folder.path();
    let directed = ["--director", "xs-paper"];
    render(folder, "d.exr", &directed);
    let names = passes(folder, "d", 2, &directed);
    let (whole, mean) = (layers(folder, "d.exr"), merged(folder, &names, "m.exr"));
    assert_eq!(mean.get("xs"), whole.get("xs"), "passes are directed differently");
    let [whole, mean] = [&whole, &mean].map(|layers| layers.get("rays").unwrap());
    assert!(whole.iter().any(|rays| *rays < 8.0), "nothing is directed");
    for (whole, mean) in whole.iter().zip(mean) {
        // A pixel of a single ray has one in each pass.
        assert_eq!(*mean, if *whole == 0.0 { 0.0 } else { whole.max(2.0) });
    }
}

#[test]
fn what_cannot_be_rendered_in_passes_is_told() {
    let folder = folder();
    let folder = folder.path();
    for (args, says) in [
        (&["--pass", "9/9"][..], "--pass 9/9: a pixel has 8 rays"),
        (&["--pass", "1/2", "--photons", "5"], "--pass 1/2: the picture has 5 photons"),
        (&["--pass", "1/2", "--reconstruct"], "--pass 1/2: noise is taken off a whole picture"),
        (
            &["--pass", "1/2", "--director", "xs", "--x", "error"],
            "--pass 1/2: the director xs measures noise",
        ),
        (
            &["--pass", "1/2", "--error", "0.1"],
            "--pass and an error as the goal exclude each other",
        ),
        (&["--pass", "3/2"], "give K/N, such as 3/8"),
        (&["--pass", "1/2", "--time", "5s"], "cannot be used with"),
    ] {
        let args = [&["render", "s.toml", "-o", "no.exr", "--quiet"], args].concat();
        let (code, _, err) = run(folder, &args);
        assert!(code == 2 && err.contains(says), "{args:?}: {code} {err}");
    }
    assert!(!folder.join("no.exr").exists());
}
