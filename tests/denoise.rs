//! `--denoise` and `--reconstruct`: less noise, the noisy picture kept and the same bytes each time. Without Open
//! Image Denoise one line that says what was looked for.

#[path = "common/skip.rs"]
mod skip;

use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use fogbow::image::{Denoiser, Layers, read_layers};
use tempfile::TempDir;

/// The library's name.
const LIBRARY: &str = "libOpenImageDenoise.so.2";

/// Long enough for anything here on a busy machine.
const PATIENCE: Duration = Duration::from_secs(120);

fn folder() -> TempDir {
    tempfile::tempdir().unwrap()
}

/// The library, or nothing, and the test is skipped.
fn library() -> Option<Denoiser> {
    let found = Denoiser::find();
    if found.is_err() {
        skip::skip("Open Image Denoise");
    }
    found.ok()
}

/// The ways to less noise that are there.
fn ways() -> Vec<&'static str> {
    let denoise = library().map(|_| "--denoise");
    denoise.into_iter().chain(["--reconstruct"]).collect()
}

fn scene(folder: &Path, scene: &str, output: &str, more: &[&str]) -> Command {
    let mut command = Command::new(assert_cmd::cargo::cargo_bin!("fogbow"));
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("volumes").join(scene);
    command.current_dir(folder).arg("render").arg(scene).args(["-o", output]);
    // An option is given but once.
    for usual in [["--size", "64x64"], ["--photons", "20000"], ["--rays", "2"]] {
        command.args(usual.iter().filter(|_| !more.contains(&usual[0])));
    }
    command.args(more);
    command
}

/// `fogbow render --denoise` with nothing in the environment by which the library could be found.
fn alone(folder: &Path) -> Command {
    let mut command = scene(folder, "smoke.toml", "out.exr", &["--quiet", "--denoise"]);
    command.env_clear().env("HOME", folder).env("PATH", folder);
    command
}

/// Whether `command` renders, for the loader has the library; the test is skipped then.
fn loader_has_it(command: &mut Command) -> bool {
    let renders = command.output().unwrap().status.success();
    if renders {
        skip::skip("loader without the library on its path");
    }
    renders
}

/// What a render that fails says, in one line.
fn refusal(mut command: Command) -> String {
    let output = command.output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(message.lines().count(), 1, "{message}");
    message
}

/// Puts a file that is no library where `pip install pyoidn` puts it below `prefix`.
fn damaged_package(prefix: &Path) -> PathBuf {
    let packages = prefix.join("lib/python3.11/site-packages/pyoidn/oidn/lib");
    std::fs::create_dir_all(&packages).unwrap();
    let file = packages.join(LIBRARY);
    std::fs::write(&file, "no library").unwrap();
    file
}

fn ran(mut command: Command) -> Output {
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    output
}

fn rendered(folder: &Path, name: &str, output: &str, more: &[&str]) -> Layers {
    ran(scene(folder, name, output, &[more, &["--quiet"]].concat()));
    read_layers(&folder.join(output)).unwrap()
}

fn layer<'a>(layers: &'a Layers, name: &str) -> &'a [f32] {
    layers.channels.get(name).unwrap_or_else(|| panic!("no layer {name}"))
}

/// Sum of the squared differences of what a screen can show: lamps seen in mirrors would outweigh all
/// else.
fn squared_distance(a: &Layers, b: &Layers) -> f64 {
    let channel = |channel| layer(a, channel).iter().zip(layer(b, channel));
    let pixels = ["R", "G", "B"].into_iter().flat_map(channel);
    pixels.map(|(a, b)| f64::from(a.min(1.0) - b.min(1.0)).powi(2)).sum()
}

#[test]
fn without_the_library_it_says_what_was_looked_for_before_anything_is_rendered() {
    let folder = folder();
    if loader_has_it(&mut alone(folder.path())) {
        return;
    }
    let message = refusal(alone(folder.path()));
    for part in [LIBRARY, "pip install pyoidn", "FOGBOW_OIDN", "VIRTUAL_ENV", "python3"] {
        assert!(message.contains(part), "{message}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn what_fogbow_oidn_names_must_be_it() {
    let folder = folder();
    let [empty, text] = ["empty", "text.so.2"].map(|name| folder.path().join(name));
    std::fs::create_dir(&empty).unwrap();
    std::fs::write(&text, "no library").unwrap();
    // Another library, which the loader takes and which has none of the functions.
    let other = std::fs::read_to_string("/proc/self/maps").unwrap();
    let other = other.lines().filter_map(|line| line.find('/').map(|at| &line[at..]));
    let other = other.filter(|file| file.contains("libm.so")).map(PathBuf::from).next();
    let cases = [
        (folder.path().join("nothing"), "cannot be found"),
        (empty, "is a folder without libOpenImageDenoise.so.2"),
        (text, "FOGBOW_OIDN"),
    ];
    let other = other.map(|file| (file, "has no function oidnNewDevice"));
    for (given, problem) in cases.into_iter().chain(other) {
        let mut command = alone(folder.path());
        command.env("FOGBOW_OIDN", &given);
        let message = refusal(command);
        assert!(message.contains(problem), "{message}");
        assert!(message.contains(&given.display().to_string()), "{message}");
    }
}

/// A library with the functions that are called, of another version than any that there is.
const LATER: &str = "
    static int device;
    void *oidnNewDevice(int type) { return &device; }
    void oidnCommitDevice(void *d) {}
    int oidnGetDeviceInt(void *d, const char *name) { return 30102; }
    int oidnGetDeviceError(void *d, const char **message) { return 0; }
    void oidnReleaseDevice(void *d) {}
    void *oidnNewFilter(void *d, const char *type) { return 0; }
    void oidnSetSharedFilterImage() {}
    void oidnSetFilterBool() {}
    void oidnCommitFilter(void *f) {}
    void oidnExecuteFilter(void *f) {}
    void oidnReleaseFilter(void *f) {}
";

#[test]
fn another_major_version_is_refused() {
    let folder = folder();
    let [code, library] = ["later.c", "later.so"].map(|name| folder.path().join(name));
    std::fs::write(&code, LATER).unwrap();
    let compiled =
        Command::new("cc").args(["-shared", "-fPIC", "-o"]).arg(&library).arg(&code).status();
    if !compiled.is_ok_and(|status| status.success()) {
        skip::skip("C compiler");
        return;
    }
    let mut command = alone(folder.path());
    command.env("FOGBOW_OIDN", &library);
    let message = refusal(command);
    assert!(message.contains("is version 3.1.2") && message.contains("not 2.x"), "{message}");
}

#[test]
fn a_damaged_library_in_an_environment_is_told_of() {
    let folder = folder();
    let file = damaged_package(&folder.path().join("venv"));
    let mut command = alone(folder.path());
    command.env("VIRTUAL_ENV", folder.path().join("venv"));
    if loader_has_it(&mut command) {
        return;
    }
    let (message, file) = (refusal(command), file.display().to_string());
    assert!(message.contains("not usable") && message.contains(&file), "{message}");
}

#[test]
fn an_environment_behind_a_damaged_one_is_used_and_told_of() {
    let Some(library) = library() else { return };
    let folder = folder();
    damaged_package(&folder.path().join("venv"));
    let working = damaged_package(&folder.path().join("conda"));
    let lib = working.parent().unwrap();
    for file in std::fs::read_dir(library.path().parent().unwrap()).unwrap() {
        let file = file.unwrap().path();
        let link = lib.join(file.file_name().unwrap());
        let _ = std::fs::remove_file(&link);
        std::os::unix::fs::symlink(file, link).unwrap();
    }
    let mut command = scene(folder.path(), "smoke.toml", "out.exr", &["--denoise", "--json"]);
    command.env_clear().env("HOME", folder.path());
    command.env("VIRTUAL_ENV", folder.path().join("venv"));
    command.env("CONDA_PREFIX", folder.path().join("conda"));
    let output = ran(command);
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let told = &report["denoiser"];
    assert_eq!(told["version"], library.version());
    let path = told["path"].as_str().unwrap();
    assert!(library.path().starts_with("/usr") || Path::new(path) == working, "{path}");
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains(&format!("{library}")) && said.contains(path), "{said}");
}

#[test]
fn it_comes_nearer_to_the_truth_and_keeps_what_was_there() {
    let Some(library) = library() else { return };
    let folder = folder();
    for (name, most) in [("smoke.toml", 0.2), ("balls_a.toml", 0.4)] {
        let traced = |output, more: &[&str]| {
            rendered(folder.path(), name, output, &[&["--reference"], more].concat())
        };
        let truth = traced("truth.exr", &["--rays", "256", "--seed", "9"]);
        let (noisy, clean) = (traced("noisy.exr", &[]), traced("clean.exr", &["--denoise"]));
        for channel in ["R", "G", "B"] {
            assert_eq!(layer(&clean, &format!("noisy.{channel}")), layer(&noisy, channel));
        }
        let [before, after] = [&noisy, &clean].map(|l| squared_distance(l, &truth));
        assert!(after < most * before, "{name}: {after} of {before}");
        assert_eq!(clean.attributes["fogbow:denoised"], "true");
        assert_eq!(clean.attributes["fogbow:denoiser"], library.to_string());
        assert!(!noisy.attributes.contains_key("fogbow:denoised"));
    }
}

/// At 4 rays a pixel much of the noise goes, without a library. In so small a picture of Lucy most is that of edges,
/// which stays.
#[test]
fn reconstruction_comes_nearer_to_the_truth_and_keeps_what_was_there() {
    let folder = folder();
    for (name, most) in [("smoke.toml", 0.6), ("lucy.toml", 0.8)] {
        let rendered = |output, more: &[&str]| rendered(folder.path(), name, output, more);
        let truth = ["--rays", "64", "--photons", "400000", "--seed", "9"];
        let truth = rendered("truth.exr", &truth);
        let clean = rendered("clean.exr", &["--rays", "4", "--reconstruct"]);
        let mut noisy = clean.clone();
        for channel in ["R", "G", "B"] {
            let kept = layer(&clean, &format!("noisy.{channel}")).to_vec();
            noisy.channels.insert(channel.into(), kept);
        }
        let [before, after] = [&noisy, &clean].map(|l| squared_distance(l, &truth));
        assert!(after < most * before, "{name}: {after} of {before}");
        assert_eq!(clean.attributes["fogbow:reconstructed"], "true");
        assert!(!clean.attributes.contains_key("fogbow:denoised"));
        assert!(!truth.attributes.contains_key("fogbow:reconstructed"));
    }
}

/// Two balls and a box over ground, under an even sky: noise is that of edges, and of shade.
const EDGES: &str = r#"
    [camera]
    position = [0.0, 2.0, 6.0]
    target = [0.0, 0.8, 0.0]
    fov = 32.0
    [film]
    size = [64, 64]
    [[surface]]
    shape = "plane"
    point = [0.0, 0.0, 0.0]
    normal = [0.0, 1.0, 0.0]
    material = { type = "diffuse", reflectance = 0.2 }
    [[surface]]
    shape = "sphere"
    center = [-0.7, 0.9, 0.0]
    radius = 0.8
    material = { type = "diffuse", reflectance = 0.9 }
    [[surface]]
    shape = "sphere"
    center = [0.8, 0.6, 0.9]
    radius = 0.5
    material = { type = "diffuse", reflectance = [0.7, 0.1, 0.1] }
    [[surface]]
    shape = "box"
    min = [0.3, 0.0, -1.6]
    max = [1.2, 1.9, -0.9]
    material = { type = "diffuse", reflectance = 0.6 }
    [[light]]
    type = "environment"
    radiance = 1.0
"#;

/// Few rays cover a pixel at an edge by halves or quarters; visibility rays by sixteenths and more.
#[test]
fn edges_are_smooth_though_rays_are_few() {
    let folder = folder();
    let file = folder.path().join("edges.toml");
    std::fs::write(&file, EDGES).unwrap();
    let name = file.to_str().unwrap();
    let rendered = |output, more: &[&str]| rendered(folder.path(), name, output, more);
    let truth = rendered("truth.exr", &["--rays", "256", "--seed", "9"]);
    let clean = rendered("clean.exr", &["--rays", "2", "--reconstruct"]);
    // Pixels that differ much from the next, across or down.
    let of = layer(&truth, "G");
    let differs = |a: usize, b: usize| of.get(b).is_some_and(|other| (of[a] - other).abs() > 0.15);
    let is_edge = |at: &usize| (at % 64 < 63 && differs(*at, at + 1)) || differs(*at, at + 64);
    let edges: Vec<usize> = (0..of.len()).filter(is_edge).collect();
    assert!(edges.len() > 150, "{}", edges.len());
    let error = |name: &str| {
        let found = layer(&clean, name);
        edges.iter().map(|&at| f64::from(found[at] - of[at]).powi(2)).sum::<f64>()
    };
    let [before, after] = ["noisy.G", "G"].map(error);
    assert!(after < 0.15 * before, "{after} of {before}");
}

#[test]
fn one_way_at_a_time() {
    let folder = folder();
    let both = ["--reconstruct", "--denoise"];
    let output = scene(folder.path(), "smoke.toml", "out.exr", &both).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    let both = ["--set", "render.denoise=true", "--set", "render.reconstruct=true", "--quiet"];
    let output = scene(folder.path(), "smoke.toml", "out.exr", &both).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(message.contains("`denoise` and `reconstruct` exclude each other"), "{message}");
}

#[test]
fn bytes_are_the_same_on_one_thread_and_on_two() {
    let folder = folder();
    for way in ways() {
        for director in ["fixed", "xs"] {
            let bytes = |output: &str, threads| {
                let more = [way, "--director", director, "--threads", threads];
                rendered(folder.path(), "balls_a.toml", output, &more);
                std::fs::read(folder.path().join(output)).unwrap()
            };
            assert!(bytes("one.exr", "1") == bytes("two.exr", "2"), "{way} {director}");
        }
    }
}

#[test]
fn a_render_that_was_killed_goes_on_to_the_same_bytes() {
    ways().into_iter().for_each(killed_and_resumed);
}

fn killed_and_resumed(way: &str) {
    let folder = folder();
    let more = [way, "--rays", "64", "--checkpoint", "1ms", "--quiet"];
    let whole = |output: &str, more: &[&str]| {
        ran(scene(folder.path(), "balls_a.toml", output, more));
        std::fs::read(folder.path().join(output)).unwrap()
    };
    let undisturbed = whole("undisturbed.exr", &more);
    let mut command = scene(folder.path(), "balls_a.toml", "killed.exr", &more);
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let (start, state) = (Instant::now(), folder.path().join("killed.exr.checkpoint"));
    while !state.exists() && child.try_wait().unwrap().is_none() {
        assert!(start.elapsed() < PATIENCE, "no checkpoint");
        std::thread::sleep(Duration::from_millis(2));
    }
    child.kill().unwrap();
    let status = child.wait().unwrap();
    assert!(status.signal().is_some() && state.exists(), "it was too fast to be killed: {status}");
    let resumed = whole("killed.exr", &[&more[..], &["--resume"]].concat());
    assert!(resumed == undisturbed);
}

#[test]
fn a_part_of_a_picture_is_denoised_alone() {
    let folder = folder();
    for way in ways() {
        let part =
            rendered(folder.path(), "smoke.toml", "part.exr", &[way, "--crop", "16,8,24x32"]);
        assert!(layer(&part, "R").iter().zip(layer(&part, "noisy.R")).any(|(a, b)| a != b));
    }
}

#[test]
fn what_does_not_fit_the_memory_is_refused() {
    if library().is_none() {
        return;
    }
    let folder = folder();
    let big = ["--denoise", "--quiet", "--size", "2048x2048", "--memory", "1500M"];
    let message = refusal(scene(folder.path(), "smoke.toml", "out.exr", &big));
    assert!(message.contains("film ") && message.contains("--memory allows"), "{message}");
}
