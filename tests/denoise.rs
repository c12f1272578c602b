//! `--denoise`: refused in one line without Open Image Denoise, and with it less noise, the noisy
//! picture kept, and the same bytes each time.

use std::path::Path;

use assert_cmd::Command;

fn render(folder: &Path, output: &str, more: &[&str]) -> Command {
    let mut command = Command::new(assert_cmd::cargo::cargo_bin!("fogbow"));
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("volumes/smoke.toml");
    command.current_dir(folder).arg("render").arg(scene).args(["-o", output, "--quiet"]);
    // An option is given but once.
    for usual in [["--size", "64x64"], ["--photons", "20000"], ["--rays", "2"]] {
        command.args(usual.iter().filter(|_| !more.contains(&usual[0])));
    }
    command.args(more);
    command
}

#[cfg(not(feature = "denoise"))]
#[test]
fn without_the_library_it_is_refused_before_anything_is_rendered() {
    let folder = tempfile::tempdir().unwrap();
    let refused = render(folder.path(), "out.exr", &["--denoise"]).assert().failure().code(2);
    let message = String::from_utf8_lossy(&refused.get_output().stderr).into_owned();
    assert_eq!(message.lines().count(), 1, "{message}");
    assert!(message.contains("--denoise") && message.contains("--features denoise"), "{message}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[cfg(feature = "denoise")]
mod with {
    use fogbow::image::{Layers, read_layers};

    use super::*;

    fn rendered(folder: &Path, output: &str, more: &[&str]) -> Layers {
        render(folder, output, more).assert().success();
        read_layers(&folder.join(output)).unwrap()
    }

    fn layer<'a>(layers: &'a Layers, name: &str) -> &'a [f32] {
        layers.channels.get(name).unwrap_or_else(|| panic!("no layer {name}"))
    }

    fn squared_distance(a: &[f32], b: &[f32]) -> f64 {
        a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>()
    }

    #[test]
    fn it_comes_nearer_to_the_truth_and_keeps_what_was_there() {
        let folder = tempfile::tempdir().unwrap();
        let traced = |output, more: &[&str]| {
            rendered(folder.path(), output, &[&["--reference"], more].concat())
        };
        let truth = traced("truth.exr", &["--rays", "512", "--seed", "9"]);
        let (noisy, clean) = (traced("noisy.exr", &[]), traced("clean.exr", &["--denoise"]));
        for channel in ["R", "G", "B"] {
            assert_eq!(layer(&clean, &format!("noisy.{channel}")), layer(&noisy, channel));
            let [before, after] = [&noisy, &clean]
                .map(|l| squared_distance(layer(l, channel), layer(&truth, channel)));
            assert!(after < 0.2 * before, "{channel}: {after} of {before}");
        }
        assert_eq!(clean.attributes["fogbow:denoised"], "true");
        assert!(!noisy.attributes.contains_key("fogbow:denoised"));
    }

    #[test]
    fn bytes_are_the_same_on_one_thread_and_on_two() {
        let folder = tempfile::tempdir().unwrap();
        let bytes = |output: &str, threads| {
            rendered(folder.path(), output, &["--denoise", "--threads", threads]);
            std::fs::read(folder.path().join(output)).unwrap()
        };
        assert!(bytes("one.exr", "1") == bytes("two.exr", "2"));
    }

    #[test]
    fn what_does_not_fit_the_memory_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let big = ["--denoise", "--size", "2048x2048", "--memory", "1500M"];
        let refused = render(folder.path(), "out.exr", &big).assert().failure().code(1);
        let message = String::from_utf8_lossy(&refused.get_output().stderr).into_owned();
        assert!(message.contains("for the film") && message.contains("--memory"), "{message}");
    }
}
