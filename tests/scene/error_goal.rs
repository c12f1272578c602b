//! Renders that end at a stated error.

use fogbow::image::read_layers;
use tempfile::TempDir;

use crate::limits::{bytes, fails_with, render, report, succeeds};

const SMALL: [&str; 5] = ["--size", "64x64", "--quiet", "--checkpoint", "off"];

fn with<'a>(more: &[&'a str]) -> Vec<&'a str> {
    [&SMALL[..], more].concat()
}

/// The error is reached, more rays and photons are taken for a smaller one, and header, report and layers say how many.
#[test]
fn rays_and_photons_grow_until_the_error_is_small() {
    let folder = TempDir::new().unwrap();
    let mut before = (0, 0);
    for goal in ["0.3", "0.1"] {
        let found = report(render(
            folder.path(),
            "smoke.toml",
            &with(&["--error", goal, "--strategy", "fluence-toward-eye", "--json"]),
        ));
        let settings = &found["settings"];
        let reached = settings["error_reached"].as_f64().unwrap();
        assert!(reached > 0.0 && reached <= goal.parse::<f64>().unwrap(), "{settings}");
        assert!(settings["error_uncertainty"].as_f64().unwrap() < 0.5, "{settings}");
        assert_eq!(
            (&found["complete"], &found["warnings"]),
            (&true.into(), &serde_json::json!([]))
        );
        let count = |name: &str| settings[name].as_u64().unwrap();
        let taken = (count("rays"), count("photons"));
        assert!(taken > before, "{taken:?} after {before:?}");
        before = taken;
        let layers = read_layers(&folder.path().join("out.exr")).unwrap();
        assert_eq!(layers.attributes["fogbow:error"], goal);
        assert_eq!(
            layers.attributes["fogbow:error_reached"],
            settings["error_reached"].to_string()
        );
        assert!(layers.channels["rays"].iter().all(|rays| *rays as u64 == taken.0));
        assert_eq!(found["work"]["rays"], taken.0 * 64 * 64);
        assert_eq!(found["work"]["photon_paths"], taken.1);
    }
}

#[test]
fn threads_do_not_change_the_picture() {
    let folder = TempDir::new().unwrap();
    for goal in [&["--error", "0.2"][..], &["--error", "0.3", "--reconstruct"]] {
        let pictures = ["1", "3"].map(|threads| {
            let strategy = ["--strategy", "fluence-toward-eye", "--threads", threads];
            let more = with(&[goal, &strategy].concat());
            succeeds(render(folder.path(), "smoke.toml", &more));
            bytes(folder.path())
        });
        assert!(pictures[0] == pictures[1], "{goal:?}");
    }
}

#[test]
fn time_ends_the_rounds_with_a_picture_and_a_warning() {
    let folder = TempDir::new().unwrap();
    let more = with(&["--error", "0.0001", "--time", "3s", "--json"]);
    let found = report(render(folder.path(), "smoke.toml", &more));
    assert_eq!(found["complete"], false);
    let warnings = found["warnings"].to_string();
    // On a busy machine the first round is not finished.
    let reached = warnings.contains("the error after ") && warnings.contains(" times 0.0001");
    assert!(reached || warnings.contains("the error is not known"), "{warnings}");
    assert_eq!(reached, found["settings"].get("error_reached").is_some(), "{found}");
}

/// Without any light the error is not known, and that is said.
#[test]
fn darkness_is_not_taken_for_quiet() {
    let folder = TempDir::new().unwrap();
    let dark = ["--set", "light.0.radiance=0", "--set", "light.1.radiance=0"];
    let more = with(&[&["--error", "0.1", "--size", "4x4", "--json"][..], &dark].concat());
    let found = report(render(folder.path(), "smoke.toml", &more[2..]));
    let warnings = found["warnings"].to_string();
    assert!(warnings.contains("the error is not known"), "{warnings}");
}

#[test]
fn what_an_error_does_not_go_with_is_refused() {
    let folder = TempDir::new().unwrap();
    for (more, right) in [
        (&["--error", "0.1", "--crop", "0,0,8x8"][..], "--crop"),
        (&["--error", "0.1", "--reference"], "--reference"),
        (&["--error", "0.1", "--director", "xs"], "leave out `director = \"xs\"`"),
    ] {
        let message = fails_with(render(folder.path(), "smoke.toml", &with(more)), 2);
        assert!(message.contains(right), "{message}");
    }
    for wrong in ["0", "-1", "seen"] {
        let refused = render(folder.path(), "smoke.toml", &["--error", wrong]).output().unwrap();
        let message = String::from_utf8(refused.stderr).unwrap();
        assert!(refused.status.code() == Some(2) && message.contains("\"visible\""), "{message}");
    }
}
