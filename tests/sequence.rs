//! Sequences from outside: names, frames that are not there, order, what is kept, kill and resume.

#![allow(clippy::print_stdout, clippy::print_stderr)] // measurements tell what they found

#[path = "common/skip.rs"]
mod skip;

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use fogbow::image::{read_exr, read_layers};
use fogbow::math::{Stage, Stream};
use fogbow::render::{Earlier, Silent, render_next, shot_strategies};
use fogbow::scene::{Director, LoadOptions, RenderSettings, Scene, Sequence};
use fogbow::vdb;
use glam::DVec3;
use serde_json::Value;

/// Smoke over the ground, its file numbered.
const SCENE: &str = r#"
    [camera]
    position = [0, 1.5, 6]
    target = [0, 1, 0]
    [film]
    size = [24, 16]
    [render]
    rays = 4
    photons = 3000
    director = "xs"
    [director]
    x = "scattering"
    [[medium]]
    file = "smoke_####.vdb"
    sigma_t = 8.0
    [[surface]]
    shape = "plane"
    point = [0, 0, 0]
    normal = [0, 1, 0]
    material = { type = "diffuse", reflectance = 0.5 }
    [[light]]
    type = "area"
    center = [-3.2, 5.6, 2.4]
    u = [-0.24, 0.0, -0.32]
    v = [0.23, 0.28, -0.17]
    radiance = 300.0
"#;

/// A folder with [`SCENE`] and the frames 7 to 10 of its smoke.
struct Studio {
    folder: tempfile::TempDir,
}

impl Studio {
    fn new() -> Self {
        let studio = Self { folder: tempfile::tempdir().unwrap() };
        studio.write("scene.toml", SCENE);
        for frame in 7..=10 {
            let (name, seed) = (format!("smoke_{frame:04}.vdb"), frame.to_string());
            studio.does(&["make", "smoke", "-o", &name, "--resolution", "16", "--seed", &seed]);
        }
        studio
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), content).unwrap();
    }

    fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    fn has(&self, name: &str) -> bool {
        self.path(name).exists()
    }

    fn command(&self, args: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_fogbow"));
        command.current_dir(self.folder.path()).args(args);
        command
    }

    fn runs(&self, args: &[&str]) -> Output {
        let output = self.command(args).output().unwrap();
        assert!(!message(&output).contains("panicked"), "{args:?}: {}", message(&output));
        output
    }

    fn does(&self, args: &[&str]) -> Output {
        let output = self.runs(args);
        assert!(output.status.success(), "{args:?}: {}", message(&output));
        output
    }

    /// Runs what must fail in one line.
    fn refuses(&self, args: &[&str], code: i32, says: &[&str]) {
        let output = self.runs(args);
        let message = message(&output);
        assert_eq!(output.status.code(), Some(code), "{args:?}: {message}");
        assert_eq!(message.lines().count(), 1, "{args:?}: {message}");
        assert!(says.iter().all(|words| message.contains(words)), "{args:?}: {message}");
    }

    /// What is told of each frame that is rendered to `to`.
    fn frames(&self, frames: &str, to: &str, more: &[&str]) -> Vec<Value> {
        let args = ["render", "scene.toml", "-o", to, "--frames", frames, "--json", "--quiet"];
        let output = self.does(&[&args, more].concat());
        let text = String::from_utf8(output.stdout).unwrap();
        text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
    }

    /// The bytes of the pictures of 7 to 10 at `to`, which has one `#`.
    fn pictures(&self, to: &str) -> Vec<Vec<u8>> {
        let names = (7..=10).flat_map(|frame| {
            ["exr", "png"].map(|ending| to.replace('#', &format!("{frame}.{ending}")))
        });
        names.map(|name| self.bytes(&name)).collect()
    }
}

fn message(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn states(reports: &[Value]) -> Vec<&str> {
    reports.iter().map(|report| report["state"].as_str().unwrap()).collect()
}

fn intersections(report: &Value) -> u64 {
    report["director"]["work"]["intersections"].as_u64().unwrap()
}

#[test]
fn a_frame_is_the_same_alone_and_in_any_order() {
    let studio = Studio::new();
    let reports = studio.frames("7-10", "a_####.exr", &["--threads", "2"]);
    assert_eq!(reports.len(), 4);
    for (report, frame) in reports.iter().zip(7..) {
        assert_eq!(report["frame"], frame);
        let exr = format!("a_{frame:04}.exr");
        assert!(report["outputs"][0] == exr && studio.has(&exr), "{report}");
        assert!(report["seconds"]["march"].is_number(), "{report}");
    }
    studio.frames("10,9-7", "b_%04d.exr", &["--threads", "1"]);
    studio.frames("9", "c.exr", &[]);
    for ending in ["exr", "png"] {
        for frame in 7..=10 {
            let [a, b] = ["a", "b"].map(|n| studio.bytes(&format!("{n}_{frame:04}.{ending}")));
            assert!(a == b, "frame {frame}: the {ending} depends on the order");
        }
        let alone = studio.bytes(&format!("c.0009.{ending}"));
        assert!(alone == studio.bytes(&format!("a_0009.{ending}")), "{ending} of frame 9");
    }
    assert!(studio.bytes("a_0007.exr") != studio.bytes("a_0008.exr"));
}

#[test]
fn what_does_not_move_is_looked_at_once() {
    let studio = Studio::new();
    let reports = studio.frames("7-9", "a.exr", &[]);
    let first = intersections(&reports[0]);
    assert!(first >= 24 * 16);
    for report in &reports[1..] {
        assert_eq!(intersections(report), 0, "{report}");
        assert_eq!(report["director"]["spared"]["intersections"], first);
    }
    // A light whose beam changes from frame to frame is looked at each time.
    let spot = "[[light]]\ntype = \"spot\"\nposition = [0, 5, 0]\ntarget = [0, 0, 0]\nangle = 30\n\
                intensity = 9.0\ntexture = \"beam_#.png\"\n";
    studio.write("scene.toml", format!("{SCENE}{spot}"));
    for (frame, grey) in [(7, 10), (8, 200)] {
        let beam = image::GrayImage::from_pixel(4, 4, image::Luma([grey]));
        beam.save(studio.path(&format!("beam_{frame}.png"))).unwrap();
    }
    let reports = studio.frames("7,8", "b.exr", &[]);
    assert!(reports.iter().all(|report| intersections(report) >= 24 * 16));
}

/// What z.exr depends on is all that was seen, not how many there are of it.
#[test]
fn a_stale_first_look_is_refused() {
    let studio = Studio::new();
    let maps = ["maps", "scene.toml", "-o", "maps", "--quiet", "--frame"];
    studio.does(&[&maps[..], &["7"]].concat());
    let with = |more: &[&'static str]| [&maps[..], more, &["--z", "maps/z.exr"]].concat();
    studio.does(&with(&["8"]));
    studio.write("scene.toml", SCENE.replace("sigma_t = 8.0", "sigma_t = 2.0\n    albedo = 0.5"));
    studio.does(&with(&["8"]));
    let changes = [
        ("radiance = 300.0", "radiance = 301.0"),
        ("reflectance = 0.5", "reflectance = 0.6"),
        ("target = [0, 1, 0]", "target = [0, 1.1, 0]"),
    ];
    for (from, to) in changes {
        studio.write("scene.toml", SCENE.replace(from, to));
        studio.refuses(&with(&["8"]), 1, &["z.exr", "other surfaces or lights"]);
    }
    studio.write("scene.toml", SCENE);
    studio.refuses(&with(&["8", "--resolution", "0.5"]), 1, &["z.exr", "resolution"]);
}

#[test]
fn a_pattern_wants_frames() {
    let studio = Studio::new();
    let says = ["is a sequence of files", "--frames 7-10", "4 of its files are there, 7 to 10"];
    let in_scene = ["scene.toml:14:12: medium[0].file", "smoke_####.vdb"];
    studio.refuses(&["render", "scene.toml", "-o", "a.exr"], 1, &[&says[..], &in_scene].concat());
    studio.refuses(&["render", "smoke_####.vdb", "-o", "a.exr"], 2, &says);
    studio.refuses(&["plan", "smoke_%04d.vdb"], 2, &["--frame N"]);
    studio.does(&["plan", "scene.toml", "--frame", "8", "--quiet"]);
    studio.does(&["trial", "scene.toml", "-o", "trial", "--frame", "8", "--quiet"]);
    studio.refuses(&["trial", "scene.toml", "-o", "trial", "--frame", "99"], 1, &["_0099.vdb"]);
    studio.refuses(
        &["render", "smoke_0007.vdb", "-o", "a.exr", "--frames", "1-3"],
        2,
        &["all frames would be the same"],
    );
    for wrong in ["", "1-", "a", "1-3x0", "1-9999999"] {
        let output = studio.runs(&["render", "scene.toml", "-o", "a.exr", "--frames", wrong]);
        assert_eq!(output.status.code(), Some(2), "{wrong}");
    }
    let key = SCENE.replace("sigma_t", "sigmat");
    studio.write("scene.toml", key);
    let args = ["render", "scene.toml", "-o", "a.exr", "--frames", "7", "--missing", "skip"];
    studio.refuses(&args, 1, &["did you mean `sigma_t`"]);
}

#[test]
fn frames_that_cannot_be_used() {
    let studio = Studio::new();
    let smoke = studio.bytes("smoke_0009.vdb");
    studio.write("smoke_0009.vdb", &smoke[..smoke.len() / 2]);
    studio.write("smoke_0011.vdb", "");
    std::fs::remove_file(studio.path("smoke_0008.vdb")).unwrap();

    // What is missing is found before anything is rendered, what is broken when it is read.
    let render = ["render", "scene.toml", "-o", "a.exr", "--quiet", "--frames"];
    let says = ["frame 8", "smoke_0008.vdb: no such file", "--missing hold"];
    studio.refuses(&[&render[..], &["7-10"]].concat(), 1, &says);
    assert!(!studio.has("a.0007.exr"));
    studio.refuses(&[&render[..], &["7,9,10"]].concat(), 1, &["frame 9", "smoke_0009.vdb"]);
    assert!(studio.has("a.0007.exr") && !studio.has("a.0010.exr"));

    let skipped = studio.frames("7-11", "b.exr", &["--missing", "skip"]);
    assert_eq!(states(&skipped), ["rendered", "skipped", "skipped", "rendered", "skipped"]);
    assert!(studio.has("b.0010.exr") && !studio.has("b.0009.exr"));
    let held = studio.frames("7-11", "c.exr", &["--missing", "hold"]);
    assert_eq!(states(&held), ["rendered", "held", "held", "rendered", "held"]);
    assert!(held[2]["held"] == 7 && held[4]["held"] == 10, "{held:?}");
    for (one, other) in [("b.0010", "c.0011"), ("a.0007", "c.0008"), ("a.0007", "c.0009")] {
        let [one, other] = [one, other].map(|name| studio.bytes(&format!("{name}.exr")));
        assert!(one == other);
    }
    // What is held does not depend on which frames are asked for.
    studio.frames("9", "d.exr", &["--missing", "hold"]);
    assert!(studio.bytes("d.0009.exr") == studio.bytes("c.0009.exr"));
    let says = ["frame 6", "no frame before it can be held"];
    studio.refuses(&[&render[..], &["6-7", "--missing", "hold"]].concat(), 1, &says);
}

#[test]
fn every_frame_says_what_was_done() {
    let studio = Studio::new();
    std::fs::remove_file(studio.path("smoke_0008.vdb")).unwrap();
    let args = ["render", "scene.toml", "-o", "a.exr", "--frames", "7-10", "--missing", "hold"];
    let message = message(&studio.does(&args));
    for words in [
        "1 of 4 frames have no file: 8",
        "frame 8: smoke_0008.vdb: no such file",
        "frame 7 is rendered again",
        "frame 9: 3 of 4, ETA",
        "frame 10: 4 of 4",
    ] {
        assert!(message.contains(words), "{words}: {message}");
    }
}

/// Frames without any voxel are told apart from sound ones.
#[test]
fn an_empty_frame_is_no_frame_unless_asked_for() {
    let studio = Studio::new();
    let path = studio.path("smoke_0008.vdb");
    vdb::write(&path, &[vdb::GridToWrite::fog("density", 0.5, DVec3::ZERO)]).unwrap();
    let render = ["render", "scene.toml", "-o", "a.exr", "--quiet", "--frames", "8"];
    studio.refuses(&render, 1, &["frame 8", "smoke_0008.vdb: is empty", "--empty"]);
    let clear = studio.frames("8", "b.exr", &["--empty"]);
    assert_eq!(states(&clear), ["rendered"]);
    let held = studio.frames("8", "c.exr", &["--missing", "hold"]);
    assert_eq!(held[0]["held"], 7);
}

#[test]
fn negative_numbers_and_bare_files() {
    let studio = Studio::new();
    for (from, to) in [(7, "-002"), (8, "-001"), (9, "0000")] {
        let from = studio.path(&format!("smoke_{from:04}.vdb"));
        std::fs::copy(from, studio.path(&format!("v_{to}.vdb"))).unwrap();
    }
    let args = ["--size", "16x12", "--rays", "2", "--photons", "2000", "--quiet"];
    let bare = |frames, to| {
        let render = ["render", "v_%04d.vdb", "-o", to, "--frames", frames];
        studio.does(&[&render, &args[..]].concat())
    };
    bare("-2-0", "a_####.exr");
    bare("-1", "b.exr");
    assert!(studio.bytes("a_-001.exr") == studio.bytes("b.-001.exr"));
    // Seen and lit alike: the depth of the empty world and all settings are the same.
    let notes =
        |name: &str| read_layers(&studio.path(name)).unwrap().attributes["fogbow:step"].clone();
    assert_eq!(notes("a_-002.exr"), notes("a_0000.exr"));
}

#[test]
fn finished_frames_are_left_out() {
    let studio = Studio::new();
    studio.frames("7-10", "a_#.exr", &[]);
    let whole = studio.pictures("a_#");
    let again = || studio.frames("7-10", "a_#.exr", &["--resume"]);
    assert_eq!(states(&again()), ["finished"; 4]);

    let picture = studio.bytes("a_8.exr");
    studio.write("a_8.exr", &picture[..picture.len() - 100]);
    std::fs::remove_file(studio.path("a_9.png")).unwrap();
    assert_eq!(states(&again()), ["finished", "rendered", "rendered", "finished"]);
    assert!(studio.pictures("a_#") == whole);

    // Another volume, other settings, another seed: other pictures.
    studio.write("smoke_0010.vdb", studio.bytes("smoke_0007.vdb"));
    assert_eq!(states(&again()), ["finished", "finished", "finished", "rendered"]);
    for more in [["--seed", "1"], ["--rays", "3"], ["--radius", "0.1"], ["--floor", "2"]] {
        let reports = studio.frames("8", "a_#.exr", &[&["--resume"], &more[..]].concat());
        assert_eq!(states(&reports), ["rendered"], "{more:?}");
    }
}

/// Kills a sequence at a moment of its choice in each of `rounds`, twice in every third, goes on and
/// compares, each time on another number of threads. The moments are drawn with a fixed seed from the time that a whole run
/// takes.
fn kills(rounds: u64, more: &[&str]) {
    let studio = Studio::new();
    let args = [&["render", "scene.toml", "--frames", "7-10", "--quiet"], more, &["-o"]].concat();
    let begin = Instant::now();
    studio.does(&[&args[..], &["whole_#.exr"]].concat());
    let time = begin.elapsed().as_secs_f64();
    let whole = studio.pictures("whole_#");
    let mut left_something = 0;
    for round in 0..rounds {
        let mut moments = Stream::new(8, Stage::Test, round, 0);
        for frame in 7..=10 {
            for ending in ["exr", "png", "exr.checkpoint"] {
                let _ = std::fs::remove_file(studio.path(&format!("a_{frame}.{ending}")));
            }
        }
        for _ in 0..1 + u64::from(round % 3 == 2) {
            let threads = ((1.0 + 3.0 * moments.uniform()) as u32).to_string();
            let own = ["a_#.exr", "--resume", "--checkpoint", "20ms", "--threads", &threads];
            let mut command = studio.command(&[&args[..], &own].concat());
            let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
            std::thread::sleep(Duration::from_secs_f64(moments.uniform() * time));
            child.kill().unwrap(); // SIGKILL
            child.wait().unwrap();
        }
        left_something += u64::from(studio.has("a_7.exr"));
        studio.does(&[&args[..], &["a_#.exr", "--resume"]].concat());
        assert!(studio.pictures("a_#") == whole, "round {round}");
    }
    eprintln!(
        "{more:?}: {rounds} rounds, {left_something} of them with finished frames: all equal"
    );
}

#[test]
fn a_killed_sequence_goes_on() {
    kills(3, &[]);
    kills(2, &RECONSTRUCTED);
}

/// Rays by the error that is left after reconstruction.
const RECONSTRUCTED: [&str; 4] = ["--x", "error", "--op", "tolerance"];

#[test]
#[ignore = "minutes: cargo test --test sequence -- --ignored --nocapture fifty"]
fn fifty_kills_and_resumes() {
    kills(50, &[]);
    kills(50, &RECONSTRUCTED);
}

#[test]
fn maps_of_another_resolution() {
    let studio = Studio::new();
    let one = studio.frames("7", "a.exr", &[]);
    studio.frames("7", "b.exr", &["--resolution", "1"]);
    assert!(studio.bytes("a.0007.exr") == studio.bytes("b.0007.exr"));
    assert_eq!(one[0]["work"]["map_pixels"], 24 * 16);
    for (resolution, size) in [("0.25", [6, 4]), ("0.5", [12, 8]), ("2", [48, 32])] {
        let reports = studio.frames("7", "c.exr", &["--resolution", resolution]);
        assert_eq!(reports[0]["work"]["map_pixels"], size[0] * size[1], "{resolution}");
        let film = read_layers(&studio.path("c.0007.exr")).unwrap();
        assert_eq!([film.width, film.height], [24, 16]);
        let [rays, xs] = ["rays", "xs"].map(|name| film.get(name).unwrap());
        for (rays, xs) in rays.iter().zip(xs) {
            assert_eq!(*rays, (4.0 * xs).round().clamp(1.0, 4.0), "the budget is a pixel's");
        }
        let maps = ["maps", "scene.toml", "-o", "maps", "--frame", "7", "--quiet"];
        studio.does(&[&maps[..], &["--resolution", resolution]].concat());
        for name in ["x", "z", "xs", "saliency"] {
            let map = read_layers(&studio.path(&format!("maps/{name}.exr"))).unwrap();
            assert_eq!([map.width, map.height], size, "{name} at {resolution}");
        }
    }
    let wrong = ["render", "scene.toml", "-o", "a.exr", "--frames", "7", "--resolution", "9"];
    assert_eq!(studio.runs(&wrong).status.code(), Some(2));
    studio.write(
        "scene.toml",
        SCENE.replace("x = \"scattering\"", "x = \"scattering\"\nresolution = 0"),
    );
    studio.refuses(&wrong[..6], 1, &["director.resolution", "0.0625"]);
}

/// With FMA and AVX2 hidden from it the C library takes other forms of exp, ln and sin, which may
/// differ in the last bit. Pictures stay the same but for rounding.
#[test]
fn other_vector_units_make_the_same_picture() {
    let studio = Studio::new();
    studio.frames("7", "a.exr", &[]);
    let args = ["render", "scene.toml", "-o", "b.exr", "--frames", "7", "--quiet"];
    let plain = "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX512F";
    let output = studio.command(&args).env("GLIBC_TUNABLES", plain).output().unwrap();
    assert!(output.status.success(), "{}", message(&output));
    let [a, b] = ["a", "b"].map(|n| read_exr(&studio.path(&format!("{n}.0007.exr"))).unwrap());
    let differences = a.pixels().as_flattened().iter().zip(b.pixels().as_flattened());
    let worst = differences.map(|(a, b)| (a - b).abs() / a.abs().max(1e-3)).fold(0.0, f32::max);
    eprintln!("largest relative difference: {worst:e}");
    assert!(worst < 1e-3, "{worst}");
}

/// A way of rendering whose flicker is measured.
struct Way {
    name: &'static str,
    settings: fn(RenderSettings) -> RenderSettings,
    /// Whether frames have the strategies of the shot, as those of `fogbow render --frames`, and none of their own.
    of_shot: bool,
}

/// Strategies are measured for each frame, and for the shot; then with stages that follow what they measure in a frame.
const WAYS: [Way; 4] = [
    Way { name: "fixed, strategies a frame", settings: |own| own, of_shot: false },
    Way { name: "fixed", settings: |own| own, of_shot: true },
    Way {
        name: "reconstructed",
        settings: |own| RenderSettings { reconstruct: true, ..own },
        of_shot: true,
    },
    Way {
        name: "directed by error",
        settings: |own| RenderSettings { director: Director::Xs, ..own },
        of_shot: true,
    },
];

/// The flicker of a sequence, an object a line for `cargo bench --bench results -- --only flicker`: the
/// mean over pixels of |L[t-1] - 2 L[t] + L[t+1]|, which linear change leaves at 0, over the mean
/// luminance; less that of pictures with little noise, which is what the smoke itself does.
#[test]
#[ignore = "a measurement"]
fn flicker_of_seeds() {
    let pattern = Path::new(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../shared/volumes/gas_sequence/fluid_data_####.vdb"
    ));
    if !pattern.parent().unwrap().is_dir() {
        skip::skip(pattern.display());
        return;
    }
    let options = LoadOptions::default().size([64, 48]);
    let sequence = Sequence::open(pattern, &options).unwrap();
    let scenes: Vec<_> = (7..=10).map(|frame: i64| sequence.load(frame.into()).unwrap()).collect();
    let flicker = |way: &Way, rays: u32, photons: u64, seed: &dyn Fn(u64) -> u64| {
        let settings = |scene: &Scene, seed| {
            (way.settings)(RenderSettings { rays, photons, seed, ..scene.render })
        };
        let shot = way.of_shot.then(|| {
            let scene = scenes.last().unwrap();
            shot_strategies(scene, &settings(scene, seed(0))).unwrap()
        });
        let lights: Vec<Vec<f64>> = (0..)
            .zip(&scenes)
            .map(|(t, scene)| {
                let earlier = Earlier { strategies: shot.as_ref(), ..Earlier::default() };
                let settings = settings(scene, seed(t));
                let film = render_next(scene, &settings, earlier, &Silent).unwrap().film;
                film.image().luminances().collect()
            })
            .collect();
        let bend = |a: &[f64], b: &[f64], c: &[f64]| -> f64 {
            a.iter().zip(b).zip(c).map(|((a, b), c)| (a - 2.0 * b + c).abs()).sum()
        };
        let bends: f64 = lights.windows(3).map(|w| bend(&w[0], &w[1], &w[2])).sum();
        let middle: f64 = lights[1..lights.len() - 1].iter().flatten().sum();
        bends / middle
    };
    let quick = std::env::var_os("FOGBOW_QUICK").is_some();
    let (many, seeds) = if quick { (400_000, 1) } else { (2_000_000, 4) };
    let smoke = flicker(&WAYS[0], 64, many, &|_| 0);
    for way in &WAYS {
        for photons in [20_000, 200_000] {
            let mean = |vary: u64| {
                let of = |seed: u64| flicker(way, 16, photons, &|t| 100 * seed + vary * t) - smoke;
                (1..=seeds).map(of).sum::<f64>() / seeds as f64
            };
            let (same, other) = (mean(0), mean(1));
            let told = serde_json::json!({
                "way": way.name,
                "photons": photons,
                "one_seed": same,
                "seed_a_frame": other,
                "smoke": smoke,
            });
            println!("{told}");
            assert!(same < other);
        }
    }
}
