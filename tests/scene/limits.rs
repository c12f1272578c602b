//! Renders, and files that are made, where memory or disk do not last.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use fogbow::image::read_layers;
use serde_json::Value;
use tempfile::TempDir;

fn volume(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("volumes").join(name)
}

/// `fogbow` in `folder`.
fn fogbow(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(assert_cmd::cargo::cargo_bin!("fogbow"));
    command.current_dir(folder).args(arguments);
    command
}

/// `fogbow render` of a shipped scene to out.exr in `folder`, with `more` arguments.
pub fn render(folder: &Path, scene: &str, more: &[&str]) -> Command {
    let scene = volume(scene);
    let mut command = fogbow(folder, &["render", scene.to_str().unwrap(), "-o", "out.exr"]);
    command.args(more);
    command
}

/// Runs to a bad end with code 1; the one line on stderr that says so.
fn fails(command: Command) -> String {
    fails_with(command, 1)
}

/// Runs to a bad end with `code`; the one line on stderr that says so.
pub fn fails_with(mut command: Command, code: i32) -> String {
    let output = command.output().unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(code), "{message}");
    assert!(message.starts_with("error: ") && message.lines().count() == 1, "{message}");
    message
}

/// Runs to a good end.
pub fn succeeds(mut command: Command) -> Output {
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    output
}

/// What a command that succeeds prints as JSON.
pub fn report(command: Command) -> Value {
    serde_json::from_slice(&succeeds(command).stdout).unwrap()
}

pub fn bytes(folder: &Path) -> [Vec<u8>; 2] {
    ["out.exr", "out.png"].map(|name| std::fs::read(folder.join(name)).unwrap())
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<_> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn what_does_not_fit_the_memory_is_thinned_or_refused_with_figures() {
    let folder = TempDir::new().unwrap();
    let cloud = |size: &str, photons: &str, memory: &str| {
        let budget = ["--rays", "1", "--quiet", "--json", "--size", size, "--photons", photons];
        let more = ["--memory", memory, "--strategy", "beams"];
        render(folder.path(), "cloud.toml", &[&budget[..], &more].concat())
    };
    let message = fails(cloud("32x24", "5000", "20M"));
    assert!(message.contains("--memory allows 19.1 MiB (20.0 MB)"), "{message}");
    let message = fails(cloud("65536x4096", "5000", "4G"));
    assert!(message.contains(" + film ") && message.contains("--size"), "{message}");
    assert!(message.contains("--memory allows 3.7 GiB (4.0 GB)"), "{message}");
    assert_eq!(names(folder.path()), Vec::<String>::new());

    let output = succeeds(cloud("32x24", "2000000", "200M"));
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(message.contains("photons instead of 2000000"), "{message}");
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["settings"]["photons_asked"], 2_000_000);
    assert!(report["settings"]["photons"].as_u64().unwrap() < 2_000_000);
    if let Some(peak) = report["peak_memory"].as_u64() {
        assert!(peak <= 200_000_000, "{peak} bytes were taken");
    }
    let attributes = read_layers(&folder.path().join("out.exr")).unwrap().attributes;
    assert_eq!(attributes["fogbow:photons_asked"], "2000000");
}

/// Whatever fits the memory by the plan is rendered, and takes no more than it may.
#[test]
fn what_fits_the_memory_is_not_refused() {
    for (size, reconstruct) in [("128x96", "false"), ("640x480", "true")] {
        fits(size, &format!("render.reconstruct={reconstruct}"));
    }
}

fn fits(size: &str, setting: &str) {
    let folder = TempDir::new().unwrap();
    let budget = ["--size", size, "--rays", "1", "--photons", "100000", "--set", setting];
    let budget = [&budget[..], &["--json", "--quiet"]].concat();
    let scene = volume("smoke.toml");
    let planned =
        report(fogbow(folder.path(), &[&["plan", scene.to_str().unwrap()], &budget[..]].concat()));
    let peak = planned["memory"]["peak"].as_u64().unwrap();
    let parts = planned["memory"]["at_peak"].as_object().unwrap().values();
    assert_eq!(parts.map(|part| part.as_u64().unwrap()).sum::<u64>(), peak);

    let within = |memory: u64| {
        let memory = memory.to_string();
        render(folder.path(), "smoke.toml", &[&budget[..], &["--memory", &memory]].concat())
    };
    let rendered = report(within(peak + peak / 8));
    assert_eq!(rendered["settings"]["photons"], 100_000, "nothing had to be thinned");
    if let Some(taken) = rendered["peak_memory"].as_u64() {
        assert!(taken <= peak + peak / 8, "{taken} bytes were taken, {peak} planned: {setting}");
    }
    let message = fails(within(peak / 3));
    assert!(message.contains("(program ") && message.contains(" + film "), "{message}");
}

/// The command where no file may grow beyond so many KiB, which a shell can forbid; a full disk fails
/// alike.
fn limited(folder: &Path, kibibytes: u64, command: &Command) -> Command {
    let mut limited = Command::new("bash");
    let shell = format!("trap '' XFSZ; ulimit -f {kibibytes}; exec \"$0\" \"$@\"");
    limited.current_dir(folder).args(["-c", &shell]);
    limited.arg(command.get_program()).args(command.get_args());
    limited
}

/// A small picture.
const FEW: [&str; 7] = ["--size", "64x48", "--photons", "5000", "--rays", "1", "--quiet"];

#[test]
fn a_full_disk_ends_in_one_line_and_earlier_pictures_stay() {
    let folder = TempDir::new().unwrap();
    let command = render(folder.path(), "smoke.toml", &FEW);
    let small = limited(folder.path(), 8, &command);
    succeeds(command);
    let before = bytes(folder.path());
    let message = fails(small);
    assert!(message.starts_with("error: out.exr: cannot be written: "), "{message}");
    assert_eq!(bytes(folder.path()), before);
    assert_eq!(names(folder.path()), ["out.exr", "out.png"]);
}

/// The PNG would fit, the EXR does not: neither is there.
#[test]
fn a_full_disk_leaves_no_half_of_a_picture() {
    let folder = TempDir::new().unwrap();
    let command = render(folder.path(), "smoke.toml", &FEW);
    succeeds(limited(folder.path(), 1 << 20, &command));
    let [exr, png] = bytes(folder.path()).map(|bytes| bytes.len() as u64);
    let kibibytes = png.div_ceil(1 << 10) + 1;
    assert!(exr > kibibytes << 10, "{exr} and {png} bytes");
    for name in names(folder.path()) {
        std::fs::remove_file(folder.path().join(name)).unwrap();
    }
    let message = fails(limited(folder.path(), kibibytes, &command));
    assert!(message.starts_with("error: out.exr: cannot be written: "), "{message}");
    assert_eq!(names(folder.path()), Vec::<String>::new());
}

#[test]
fn a_full_disk_leaves_no_half_of_a_volume() {
    let folder = TempDir::new().unwrap();
    for (kind, file) in [("smoke", "a.vdb"), ("statue", "a.ply")] {
        let command = fogbow(folder.path(), &["make", kind, "-o", file, "--resolution", "48"]);
        let message = fails(limited(folder.path(), 4, &command));
        assert!(message.starts_with(&format!("error: {file}: cannot be written: ")), "{message}");
        assert!(!message.contains(".fogbow-"), "a temporary name: {message}");
        assert_eq!(names(folder.path()), Vec::<String>::new());
    }
}
