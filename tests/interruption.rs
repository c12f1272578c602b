//! Renders that are stopped, killed, cut short and cropped, as a user runs them: what they leave, and
//! that going on gives the bytes of a render that nothing disturbed.

#![allow(clippy::print_stderr)] // how often a render was killed

use std::collections::BTreeSet;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use fogbow::image::{Layers, read_layers};
use fogbow::math::{Stage, Stream};
use rustix::process::{Pid, Signal, kill_process};
use tempfile::TempDir;

fn volume(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("volumes").join(name)
}

/// `fogbow render` of a shipped scene in `folder`, with `more` arguments.
fn with(folder: &Path, scene: &str, output: &str, size: &str, more: &[&str]) -> Command {
    let mut command = Command::new(assert_cmd::cargo::cargo_bin!("fogbow"));
    command.current_dir(folder).arg("render").arg(volume(scene));
    command.args(["-o", output, "--size", size]).args(more);
    command
}

/// The same with few photons.
fn render(folder: &Path, scene: &str, output: &str, size: &str, more: &[&str]) -> Command {
    with(folder, scene, output, size, &[&["--photons", "5000"], more].concat())
}

fn run(mut command: Command) -> Output {
    command.output().unwrap()
}

/// Runs to a good end; stderr.
fn succeeds(command: Command) -> String {
    let output = run(command);
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{message}");
    message
}

/// Runs to a bad end with `code`; the one line on stderr that says so.
fn fails(command: Command, code: i32) -> String {
    let output = run(command);
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(code), "{message}");
    assert!(!message.contains("panicked"), "{message}");
    message
}

fn start(mut command: Command) -> Child {
    command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
}

fn bytes(folder: &Path, name: &str) -> [Vec<u8>; 2] {
    ["exr", "png"].map(|e| std::fs::read(folder.join(name).with_extension(e)).unwrap())
}

fn signal(child: &Child, signal: Signal) {
    kill_process(Pid::from_child(child), signal).unwrap();
}

/// Waits until `there` says so, while `child` runs.
fn wait_for(child: &mut Child, there: impl Fn() -> bool) {
    while !there() {
        assert!(child.try_wait().unwrap().is_none(), "the render ended early");
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn is_incomplete(layers: &Layers) -> bool {
    layers.attributes.get("fogbow:complete").is_some_and(|complete| complete == "false")
}

/// The share of its rays, in per cent, that a stopped render tells of in its last line.
fn share_of_rays(last: &str) -> f64 {
    let share = last.split_once(" has ").and_then(|(_, rest)| rest.split_once(" % of its rays"));
    share.unwrap_or_else(|| panic!("no share of rays: {last}")).0.parse().unwrap()
}

/// Every pass.
const PASSES: &str =
    "depth,albedo,normal,position,media,direct,indirect,emission,specular,cryptomatte,groups";

/// More rays than can be shot while a test runs: hours of work.
const ENDLESS: [&str; 4] = ["--rays", "1000000", "--checkpoint", "50ms"];

#[test]
fn the_first_signal_leaves_a_picture_and_what_is_needed_to_go_on() {
    let folder = TempDir::new().unwrap();
    let checkpoint = folder.path().join("out.exr.checkpoint");
    for (scene, code, kind) in [("smoke.toml", 130, Signal::INT), ("cloud.toml", 143, Signal::TERM)]
    {
        let mut child = start(render(folder.path(), scene, "out.exr", "64x48", &ENDLESS));
        wait_for(&mut child, || checkpoint.exists());
        signal(&child, kind);
        let output = child.wait_with_output().unwrap();
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(code), "{message}");
        let last = message.lines().last().unwrap();
        assert!(last.starts_with("error: interrupted: out.exr has "), "{message}");
        assert!(last.contains("--resume"), "{message}");
        // It stopped soon, counted in rays: hardly any of them were shot.
        assert!(share_of_rays(last) < 1.0, "{message}");
        let layers = read_layers(&folder.path().join("out.exr")).unwrap();
        assert!(is_incomplete(&layers));
        assert!(layers.get("R").unwrap().iter().any(|r| *r > 0.0));
        assert!(folder.path().join("out.png").exists());
        std::fs::remove_file(&checkpoint).unwrap();
    }
}

#[test]
fn an_interrupted_render_leaves_a_finished_picture_as_it_was() {
    let folder = TempDir::new().unwrap();
    let few = ["--rays", "2", "--quiet"];
    succeeds(render(folder.path(), "smoke.toml", "out.exr", "32x24", &few));
    let before = bytes(folder.path(), "out.exr");
    for _ in 0..2 {
        let mut child = start(render(folder.path(), "smoke.toml", "out.exr", "32x24", &ENDLESS));
        let checkpoint = folder.path().join("out.exr.checkpoint");
        wait_for(&mut child, || checkpoint.exists());
        signal(&child, Signal::INT);
        assert_eq!(child.wait().unwrap().code(), Some(130));
        assert_eq!(bytes(folder.path(), "out.exr"), before);
        assert!(is_incomplete(&read_layers(&folder.path().join("out.partial.exr")).unwrap()));
        std::fs::remove_file(checkpoint).unwrap();
    }
    succeeds(render(folder.path(), "smoke.toml", "out.exr", "32x24", &few));
    assert!(!folder.path().join("out.partial.exr").exists());
    assert!(!folder.path().join("out.partial.png").exists());
}

/// Minutes of photons, which nothing else comes before.
const PHOTONS: [&str; 4] = ["--photons", "50000000", "--memory", "1T"];

/// Interrupts a render of smoke while its photons are shot, which it stops at; its last line.
fn early(folder: &Path, size: &str, more: &[&str]) -> String {
    let mut child = start(with(
        folder,
        "smoke.toml",
        "out.exr",
        size,
        &[&PHOTONS[..], &["--verbose"], more].concat(),
    ));
    let mut messages = BufReader::new(child.stderr.take().unwrap()).lines();
    assert!(messages.any(|line| line.unwrap().starts_with("plan: ")));
    std::thread::sleep(Duration::from_millis(500));
    signal(&child, Signal::INT);
    assert_eq!(child.wait().unwrap().code(), Some(130));
    // A stage that is done says how long it took.
    let after: Vec<String> = messages.map(Result::unwrap).collect();
    let is_done = |line: &String| line.starts_with("photons: ") && !line.contains('%');
    assert!(!after.iter().any(is_done), "all photons were shot first: {after:?}");
    after.last().unwrap().clone()
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<_> = names.collect();
    names.sort();
    names
}

#[test]
fn before_the_first_ray_a_signal_leaves_a_first_look() {
    let folder = TempDir::new().unwrap();
    let message = early(folder.path(), "320x240", &[]);
    let look = "error: interrupted before the first ray: out.exr is a preview without photons";
    assert_eq!(message, look);
    assert_eq!(names(folder.path()), ["out.exr", "out.png"]);
    let layers = read_layers(&folder.path().join("out.exr")).unwrap();
    assert!(is_incomplete(&layers));
    assert_eq!(layers.attributes["fogbow:preview"], "true");
    // What got no ray shows what its neighbours do.
    let [rays, r, g, b] = ["rays", "R", "G", "B"].map(|name| layers.get(name).unwrap());
    let color = |pixel: usize| [r, g, b].map(|channel| channel[pixel].to_bits());
    let (bare, shot): (Vec<_>, Vec<_>) = (0..r.len()).partition(|pixel| rays[*pixel] == 0.0);
    let shot: BTreeSet<_> = shot.into_iter().map(color).collect();
    assert!(shot.len() > 10 && bare.into_iter().all(|pixel| shot.contains(&color(pixel))));

    // A second one takes its place, and both leave other pictures alone.
    early(folder.path(), "32x24", &[]);
    assert_eq!(names(folder.path()), ["out.exr", "out.png"]);
    let few = ["--rays", "2", "--quiet"];
    succeeds(render(folder.path(), "smoke.toml", "out.exr", "32x24", &few));
    let finished = bytes(folder.path(), "out.exr");
    let message = early(folder.path(), "32x24", &[]);
    assert!(message.contains("out.partial.exr is a preview"), "{message}");
    assert_eq!(bytes(folder.path(), "out.exr"), finished);
}

/// Where a checkpoint holds more than a preview would show, it is what stays.
#[test]
fn before_the_first_ray_a_signal_leaves_a_checkpoint_that_is_gone_on_from() {
    let folder = TempDir::new().unwrap();
    let checkpoint = folder.path().join("out.exr.checkpoint");
    let state = || (std::fs::read(&checkpoint).unwrap(), bytes(folder.path(), "out.exr"));
    let more = [&ENDLESS[..], &["--photons", "1000000"]].concat();
    let mut child = start(with(folder.path(), "smoke.toml", "out.exr", "32x24", &more));
    wait_for(&mut child, || checkpoint.exists());
    signal(&child, Signal::INT);
    child.wait().unwrap();
    let before = state();

    let more = [&more[..], &["--resume"]].concat();
    let mut child = start(with(folder.path(), "smoke.toml", "out.exr", "32x24", &more));
    let mut messages = BufReader::new(child.stderr.take().unwrap()).lines();
    assert!(messages.any(|line| line.unwrap().starts_with("note: resumes after")));
    std::thread::sleep(Duration::from_millis(100));
    signal(&child, Signal::INT);
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let message = messages.last().unwrap().unwrap();
    let kept =
        "error: interrupted before the first ray: out.exr.checkpoint holds the state as before";
    assert_eq!(message, kept);
    assert!(before == state());
}

/// Whatever the machine does beside it, a render that is given a time and paused for longer ends no
/// sooner than both together; were the pause counted, its time would be over with the pause.
#[test]
fn a_pause_is_no_part_of_the_time() {
    const GIVEN: Duration = Duration::from_secs(3);
    const PAUSE: Duration = Duration::from_secs(4);
    let folder = TempDir::new().unwrap();
    let more = [&ENDLESS[..], &["--time", "3s"]].concat();
    let begin = Instant::now();
    let mut child = start(render(folder.path(), "smoke.toml", "out.exr", "48x32", &more));
    wait_for(&mut child, || folder.path().join("out.exr.checkpoint").exists());
    signal(&child, Signal::STOP);
    std::thread::sleep(PAUSE);
    signal(&child, Signal::CONT);
    let output = child.wait_with_output().unwrap();
    let (took, message) = (begin.elapsed(), String::from_utf8(output.stderr).unwrap());
    assert!(output.status.success(), "{message}");
    assert!(message.contains("warning: the time is over"), "{message}");
    // A render ends a little early, to write its files in time, and a clock that is looked at ten
    // times a second takes up to one of its periods for work.
    assert!(took >= GIVEN + PAUSE - Duration::from_millis(500), "{took:?}");
}

/// Renders `arguments` undisturbed and, `rounds` times, killed at random moments and gone on with on
/// other numbers of threads until it is done.
fn kills(rounds: u64, scene: &str, size: &str, arguments: &[&str]) {
    let folder = TempDir::new().unwrap();
    let begin = Instant::now();
    succeeds(render(folder.path(), scene, "whole.exr", size, &[arguments, &["--quiet"]].concat()));
    let whole = begin.elapsed().as_secs_f64();
    let expected = bytes(folder.path(), "whole.exr");
    let mut killed = 0;
    for round in 0..rounds {
        let mut moments = Stream::new(round, Stage::March, 0, 0);
        for attempt in 0.. {
            let threads = (1 + (round + attempt) % 3).to_string();
            let more = ["--quiet", "--resume", "--checkpoint", "20ms", "--threads", &threads];
            let arguments = [arguments, &more].concat();
            let mut child = start(render(folder.path(), scene, "out.exr", size, &arguments));
            // Later and later, so that it is done in the end.
            let moment = whole * (0.2 + 1.2 * moments.uniform() + 0.1 * attempt as f64);
            std::thread::sleep(Duration::from_secs_f64(moment));
            if let Some(status) = child.try_wait().unwrap() {
                assert!(status.success(), "round {round}, attempt {attempt}: {status}");
                break;
            }
            child.kill().unwrap();
            child.wait().unwrap();
            killed += 1;
        }
        assert_eq!(bytes(folder.path(), "out.exr"), expected, "round {round}");
        let left = std::fs::read_dir(folder.path()).unwrap();
        let left: Vec<_> = left.map(|entry| entry.unwrap().file_name()).collect();
        assert!(left.iter().all(|name| !name.to_string_lossy().contains("checkpoint")), "{left:?}");
        for name in ["out.exr", "out.png"] {
            std::fs::remove_file(folder.path().join(name)).unwrap();
        }
    }
    eprintln!("{scene}: {rounds} rounds, killed {killed} times, all bytes the same");
}

#[test]
fn killed_and_gone_on_with_it_has_the_same_bytes() {
    kills(2, "smoke.toml", "64x48", &["--rays", "24"]);
    let by_scattering = ["--director", "xs", "--x", "scattering"];
    let more = [&["--rays", "12", "--passes", PASSES][..], &by_scattering].concat();
    kills(1, "cloud.toml", "48x32", &more);
    kills(1, "balls_a.toml", "48x32", &["--rays", "12", "--director", "variance"]);
    kills(2, "balls_b.toml", "48x48", &["--rays", "12", "--director", "xs"]);
    kills(1, "smoke.toml", "48x32", &["--rays", "24", "--reference"]);
    kills(2, "smoke.toml", "48x32", &["--error", "0.05", "--reconstruct"]);
}

#[test]
#[ignore = "50 rounds: cargo test --test interruption fifty -- --ignored --nocapture"]
fn fifty_rounds_of_killing() {
    kills(50, "smoke.toml", "96x64", &["--rays", "40"]);
}

/// Whether the last chunk of a PNG is there.
fn is_whole_png(path: &Path) -> bool {
    std::fs::read(path).unwrap().ends_with(b"IEND\xae\x42\x60\x82")
}

/// Previews are whole whenever they are read, and the finished picture has the bytes of one without them.
#[test]
fn previews_are_whole_and_change_no_byte() {
    let folder = TempDir::new().unwrap();
    for more in [&["--rays", "100"][..], &["--error", "0.06"]] {
        succeeds(render(folder.path(), "smoke.toml", "whole.exr", "64x48", more));
        let more = [more, &["--preview", "20ms", "--quiet"]].concat();
        let mut child = start(render(folder.path(), "smoke.toml", "out.exr", "64x48", &more));
        let (mut looks, mut without_photons) = (BTreeSet::new(), 0);
        while child.try_wait().unwrap().is_none() {
            std::thread::sleep(Duration::from_millis(5));
            let picture = folder.path().join("out.exr");
            if !picture.exists() {
                continue;
            }
            let layers = read_layers(&picture).unwrap();
            assert!(is_whole_png(&picture.with_extension("png")));
            if is_incomplete(&layers) {
                let rays: f32 = layers.channels["rays"].iter().sum();
                looks.insert(rays as u64);
                without_photons += usize::from(layers.attributes.contains_key("fogbow:preview"));
            }
        }
        assert!(child.wait().unwrap().success());
        assert!(looks.len() > 2 && without_photons > 0, "{looks:?}, {without_photons}");
        assert_eq!(bytes(folder.path(), "out.exr"), bytes(folder.path(), "whole.exr"));
        for name in ["out.exr", "out.png"] {
            std::fs::remove_file(folder.path().join(name)).unwrap();
        }
    }
}

#[test]
fn a_preview_is_there_when_it_is_asked_for() {
    let folder = TempDir::new().unwrap();
    let [checkpoint, picture] =
        ["out.exr.checkpoint", "out.exr"].map(|name| folder.path().join(name));
    let mut child = start(render(folder.path(), "smoke.toml", "out.exr", "32x24", &ENDLESS));
    wait_for(&mut child, || checkpoint.exists());
    assert!(!picture.exists());
    signal(&child, Signal::USR1);
    wait_for(&mut child, || picture.exists());
    assert!(is_incomplete(&read_layers(&picture).unwrap()));
    signal(&child, Signal::INT);
    child.wait().unwrap();
}

/// A checkpoint of a render of smoke that was stopped, in `folder`.
fn stopped(folder: &Path) -> PathBuf {
    let checkpoint = folder.join("out.exr.checkpoint");
    let mut child = start(render(folder, "smoke.toml", "out.exr", "32x24", &ENDLESS));
    wait_for(&mut child, || checkpoint.exists());
    signal(&child, Signal::INT);
    child.wait().unwrap();
    checkpoint
}

#[test]
fn a_checkpoint_of_something_else_or_a_damaged_one_is_refused() {
    let folder = TempDir::new().unwrap();
    let checkpoint = stopped(folder.path());
    let resumed = |scene: &str, size: &str, more: &[&str]| {
        let more = [&ENDLESS[..], &["--resume", "--quiet"], more].concat();
        fails(render(folder.path(), scene, "out.exr", size, &more), 1)
    };
    let before = std::fs::read(&checkpoint).unwrap();
    for (message, words) in [
        (resumed("smoke.toml", "32x25", &[]), "size is [32,24] there and [32,25] here"),
        (resumed("smoke.toml", "32x24", &["--seed", "9"]), "seed is 0 there and 9 here"),
        (resumed("smoke.toml", "32x24", &["--reference"]), "method is \"photon map\" there"),
        (resumed("smoke.toml", "32x24", &["--crop", "0,0,9x9"]), "crop is null there"),
        (resumed("cloud.toml", "32x24", &[]), "scene is \""),
    ] {
        assert!(message.starts_with("error: out.exr.checkpoint: "), "{message}");
        assert_eq!(message.lines().count(), 1, "{message}");
        assert!(message.contains(words) && message.contains("--resume"), "{message}");
    }
    assert_eq!(std::fs::read(&checkpoint).unwrap(), before);

    let mut any = Stream::new(3, Stage::March, 0, 0);
    let mut at = |length: usize| (any.uniform() * length as f64) as usize;
    for round in 0..24 {
        let mut damaged = before.clone();
        if round % 2 == 0 {
            damaged.truncate(at(before.len()));
        } else {
            let place = if round < 12 { at(1500) } else { at(before.len()) };
            damaged[place] ^= 1 << at(8);
        }
        std::fs::write(&checkpoint, &damaged).unwrap();
        let message = resumed("smoke.toml", "32x24", &[]);
        assert!(message.starts_with("error: out.exr.checkpoint: "), "{message}");
        assert_eq!(message.lines().count(), 1, "{message}");
    }
}

#[test]
fn the_time_is_kept_and_the_rest_can_follow() {
    let folder = TempDir::new().unwrap();
    for more in [&[][..], &["--reference"]] {
        let more = [&["--rays", "1000000", "--time", "2s"], more].concat();
        let message = succeeds(render(folder.path(), "smoke.toml", "out.exr", "48x32", &more));
        assert!(message.contains("warning: the time is over: the picture has "), "{message}");
        let layers = read_layers(&folder.path().join("out.exr")).unwrap();
        assert!(is_incomplete(&layers));
        assert!(layers.get("rays").unwrap().iter().any(|rays| *rays >= 1.0));
        let rays = |layers: &Layers| layers.attributes["fogbow:work:rays"].parse::<u64>().unwrap();
        let again = [&more[..], &["--resume"]].concat();
        succeeds(render(folder.path(), "smoke.toml", "out.exr", "48x32", &again));
        assert!(rays(&read_layers(&folder.path().join("out.exr")).unwrap()) > rays(&layers));
        std::fs::remove_file(folder.path().join("out.exr.checkpoint")).unwrap();
    }
}

#[test]
fn enough_time_changes_no_byte() {
    let folder = TempDir::new().unwrap();
    let few = ["--rays", "2", "--quiet"];
    succeeds(render(folder.path(), "smoke.toml", "a.exr", "32x24", &few));
    let long = [&few[..], &["--time", "1h", "--memory", "16G", "--resume"]].concat();
    succeeds(render(folder.path(), "smoke.toml", "b.exr", "32x24", &long));
    assert_eq!(bytes(folder.path(), "a.exr"), bytes(folder.path(), "b.exr"));
}

#[test]
fn crops_are_cut_out_of_the_whole_picture() {
    let folder = TempDir::new().unwrap();
    for (scene, more) in [
        ("balls_a.toml", &["--director", "xs", "--passes", PASSES][..]),
        ("smoke.toml", &[]),
        ("cloud.toml", &[]),
        ("smoke.toml", &["--reference"]),
    ] {
        let more = [&["--rays", "3", "--quiet"], more].concat();
        succeeds(render(folder.path(), scene, "whole.exr", "50x40", &more));
        let whole = read_layers(&folder.path().join("whole.exr")).unwrap();
        let mut seen = 0;
        for crop in ["0,0,21x17", "21,0,29x17", "0,17,21x23", "21,17,29x23"] {
            let more = [&more[..], &["--crop", crop]].concat();
            succeeds(render(folder.path(), scene, "part.exr", "50x40", &more));
            let part = read_layers(&folder.path().join("part.exr")).unwrap();
            assert_eq!(part.display, [50, 40]);
            let [left, top] = part.corner.map(|c| usize::try_from(c).unwrap());
            assert!(crop.starts_with(&format!("{left},{top},{}x{}", part.width, part.height)));
            for (name, values) in &part.channels {
                for (row, line) in values.chunks_exact(part.width).enumerate() {
                    let first = (top + row) * whole.width + left;
                    let expected = &whole.get(name).unwrap()[first..first + part.width];
                    let bits = |line: &[f32]| line.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
                    assert_eq!(bits(line), bits(expected), "{scene}: {name}, row {row} of {crop}");
                }
            }
            seen += part.width * part.height;
        }
        assert_eq!(seen, whole.width * whole.height);
    }
    let beyond = ["--crop", "40,0,11x10"];
    let message = fails(render(folder.path(), "smoke.toml", "part.exr", "50x40", &beyond), 2);
    assert!(message.contains("beyond the film of 50x40"), "{message}");
}

#[test]
fn a_checkpoint_that_cannot_be_written_does_not_end_the_render() {
    let folder = TempDir::new().unwrap();
    // A folder in its place.
    std::fs::create_dir(folder.path().join("out.exr.checkpoint")).unwrap();
    let message = succeeds(render(
        folder.path(),
        "smoke.toml",
        "out.exr",
        "64x48",
        &["--rays", "64", "--checkpoint", "1ms"],
    ));
    assert!(message.contains("warning: no checkpoint is kept: "), "{message}");
    assert!(!is_incomplete(&read_layers(&folder.path().join("out.exr")).unwrap()));
}
