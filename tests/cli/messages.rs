//! The command line from outside: messages, exit codes, nothing half written, the files' content.

use std::path::{Path, PathBuf};

use assert_cmd::Command;
use fogbow::image::{Layers, read_layers};
use serde_json::Value;

use crate::skip;

const CAMERA: &str = "[camera]\nposition = [0, 1, 8]\ntarget = [0, 1, 0]\n";

/// The scenes that ship with all their files.
const SCENES: [&str; 7] = [
    "balls_a.toml",
    "balls_b.toml",
    "cloud.toml",
    "fire.toml",
    "lucy.toml",
    "road.toml",
    "smoke.toml",
];

fn fogbow() -> Command {
    Command::new(assert_cmd::cargo::cargo_bin!("fogbow"))
}

/// Files of the folder by name.
fn listing(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

/// Runs in `folder`; the exit code and stderr, after seeing that nothing was written.
fn fails(folder: &Path, args: &[&str]) -> (i32, String) {
    let before = listing(folder);
    let output = fogbow().current_dir(folder).args(args).output().unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(listing(folder), before, "{args:?} left something: {message}");
    assert!(output.stdout.is_empty(), "{args:?} printed a result");
    assert!(!message.contains("panicked"), "{message}");
    (output.status.code().unwrap(), message)
}

/// Runs `fogbow render` on bad input: exit code 1 and one line that says all of `says`.
fn refuses(folder: &Path, args: &[&str], says: &[&str]) {
    let (code, message) = fails(folder, &[&["render"], args].concat());
    assert_eq!(code, 1, "{args:?}: {message}");
    assert_eq!(message.lines().count(), 1, "{args:?}: {message}");
    assert!(message.starts_with("error: "), "{args:?}: {message}");
    assert!(says.iter().all(|words| message.contains(words)), "{args:?}: {message}");
}

/// A file that ships.
fn volume(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("volumes").join(name)
}

/// Runs in `folder`; stdout, after seeing that it succeeded and said nothing of a panic.
fn succeeds(folder: &Path, args: &[&str]) -> String {
    let output = fogbow().current_dir(folder).args(args).output().unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{args:?}: {message}");
    assert!(!message.contains("panicked"), "{message}");
    String::from_utf8(output.stdout).unwrap()
}

/// Renders a shipped scene small as `name`.exr; the bytes of the EXR and the PNG.
fn small(folder: &Path, scene: &str, name: &str, more: &[&str]) -> [Vec<u8>; 2] {
    let scene = volume(scene);
    let output = format!("{name}.exr");
    let args = ["render", scene.to_str().unwrap(), "-o", &output, "--size", "32x24"];
    let budget = ["--rays", "2", "--photons", "5000", "--quiet"];
    succeeds(folder, &[&args, &budget[..], more].concat());
    ["exr", "png"].map(|e| std::fs::read(folder.join(name).with_extension(e)).unwrap())
}

#[test]
fn every_command_has_help() {
    for args in [&["--help"][..], &["render", "--help"], &["--version"]] {
        let output = fogbow().args(args).output().unwrap();
        assert!(output.status.success() && !output.stdout.is_empty(), "{args:?}");
    }
}

#[test]
fn misuse_exits_with_2() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("s.toml"), CAMERA).unwrap();
    let rows: &[(&[&str], &str)] = &[
        (&[], "Usage"),
        (&["rendre"], "render"),
        (&["render", "s.toml"], "--output"),
        (&["render", "s.toml", "-o", "a.png"], ".exr"),
        (&["make", "statue", "-o", "a.vdb"], "statue is written as .ply; name a .ply file"),
        (&["make", "smoke", "-o", "a.ply"], "smoke is written as .vdb; name a .vdb file"),
        (&["make", "fire", "-o", "a"], "fire is written as .vdb"),
        (&["render", "s.toml", "-o", "a.exr", "--time", "soon"], "without a unit seconds"),
        (
            &["render", "s.toml", "-o", "a.exr", "--checkpoint", "0"],
            "without a unit seconds, or off",
        ),
        (&["render", "s.toml", "-o", "a.exr", "--memory", "much"], "without a unit bytes"),
        (&["study", "s.toml", "-o", "a", "--time", "1 parsec"], "without a unit seconds"),
        (&["help", "rendre"], "render"),
        (&["completions", "tcsh"], "bash"),
        (&["render", "s.toml", "-o", "a.exr", "--size", "0x10"], "960x540"),
        (&["render", "s.toml", "-o", "a.exr", "--size", "0x4"], "960x540"),
        (&["render", "s.toml", "-o", "a.exr", "--size", "10"], "960x540"),
        (&["render", "s.toml", "-o", "a"], "s in .exr"),
        (&["render", "s.toml", "-o", "a.exr", "--rays", "0"], "from 1 to"),
        (&["render", "s.toml", "-o", "a.exr", "--radius", "-1"], "--radius"),
        (&["render", "s.toml", "-o", "a.exr", "--radius", "nan"], "above 0"),
        (&["render", "s.toml", "-o", "a.exr", "--director", "z"], "fixed"),
        (&["render", "s.toml", "-o", "a.exr", "--weights", "1"], "0.5,0.5"),
        (&["render", "s.toml", "-o", "a.exr", "--directs", "light"], "rays, radius, step"),
        (&["render", "s.toml", "-o", "a.exr", "--coarsest-step", "0.5"], "from 1 to 256"),
        (&["render", "s.toml", "-o", "a.exr", "--threads", "0"], "1..="),
        (&["render", "s.toml", "-o", "a.exr", "--level-set", "fog"], "level_set"),
    ];
    for (args, says) in rows {
        let (code, message) = fails(folder.path(), args);
        assert!(code == 2 && message.contains(says), "{args:?}: {code} {message}");
    }
}

#[test]
fn bad_input_exits_with_1_and_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        std::fs::write(folder.path().join(name), text).unwrap();
    };
    write("text.vdb", "this is no VDB");
    write("empty.vdb", "");
    write("bad.obj", "f 1 2 3\n");
    write("good.toml", CAMERA);
    let scene = |name: &str, tables: &str| write(name, &format!("{CAMERA}{tables}\n"));
    scene("key.toml", "[film]\nsiz = [1, 1]");
    scene("negative.toml", "[[medium]]\nregion = \"everywhere\"\nalbedo = -0.5");
    scene("over.toml", "[[medium]]\nregion = \"everywhere\"\nalbedo = 1.5");
    scene("zero.toml", "[film]\nsize = [0, 0]");
    scene("mesh.toml", "[[surface]]\nshape = \"mesh\"\nfile = \"bad.obj\"");
    scene("vdb.toml", "[[medium]]\nfile = \"text.vdb\"");
    scene("gone.toml", "[[medium]]\nfile = \"gone.vdb\"");
    scene("folder.toml", "[[medium]]\nfile = \"folder.vdb\"");
    write("pointer.vdb", "version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 9\n");
    std::fs::create_dir(folder.path().join("folder.vdb")).unwrap();
    std::fs::create_dir(folder.path().join("folder.exr")).unwrap();
    let smoke = std::fs::read(volume("smoke.vdb")).unwrap();
    std::fs::write(folder.path().join("half.vdb"), &smoke[..smoke.len() / 2]).unwrap();
    std::fs::write(folder.path().join("smoke.vdb"), smoke).unwrap();
    scene("grid.toml", "[[medium]]\nfile = \"smoke.vdb\"\ngrid = \"heat\"");
    std::fs::write(folder.path().join("binary.toml"), [0xff, 0xfe, 0x00]).unwrap();
    let rows: &[(&[&str], &[&str])] = &[
        (&["gone.toml", "-o", "a.exr"], &["gone.toml:5:8: medium[0].file", "no such file"]),
        (&["missing.toml", "-o", "a.exr"], &["missing.toml", "cannot be read"]),
        (&["missing.vdb", "-o", "a.exr"], &["missing.vdb", "cannot be read"]),
        (&["binary.toml", "-o", "a.exr"], &["binary.toml", "UTF-8"]),
        (&["text.vdb", "-o", "a.exr"], &["text.vdb"]),
        (&["empty.vdb", "-o", "a.exr"], &["empty.vdb"]),
        (&["vdb.toml", "-o", "a.exr"], &["vdb.toml:5:8: medium[0].file", "text.vdb"]),
        (&["key.toml", "-o", "a.exr"], &["key.toml:5:1: film.siz", "did you mean `size`"]),
        (&["negative.toml", "-o", "a.exr"], &["medium[0].albedo", "`-0.5`", "0 to 1"]),
        (&["over.toml", "-o", "a.exr"], &["medium[0].albedo", "`1.5`", "create energy"]),
        (&["zero.toml", "-o", "a.exr"], &["film.size[0]", "`0`", "1 to 65536"]),
        (&["mesh.toml", "-o", "a.exr"], &["mesh.toml:6:8: surface[0].file", "bad.obj"]),
        (&["good.toml", "-o", "gone/a.exr"], &["gone/a.exr", "cannot be written"]),
        (&["good.toml", "-o", "text.vdb/a.exr"], &["text.vdb/a.exr", "cannot be written"]),
        (&["good.toml", "-o", "folder.exr"], &["folder.exr", "not a regular file"]),
        (&[".", "-o", "a.exr"], &["is a folder", "give a scene (.toml), a VDB or a USD file"]),
        (&["folder.vdb", "-o", "a.exr"], &["folder.vdb", "is a folder"]),
        (&["folder.toml", "-o", "a.exr"], &["medium[0].file", "folder.vdb"]),
        (&["pointer.vdb", "-o", "a.exr"], &["pointer.vdb", "git-lfs pointer", "git lfs pull"]),
        (&["half.vdb", "-o", "a.exr"], &["half.vdb", "\"density\"", "byte"]),
        (&["grid.toml", "-o", "a.exr"], &["no grid called \"heat\"", "\"density\" (float"]),
    ];
    for (args, says) in rows {
        refuses(folder.path(), args, says);
        let (_, message) = fails(folder.path(), &[&["render"], *args].concat());
        assert!(!message.contains(".fogbow-"), "a temporary name: {message}");
    }
}

/// A B44 block from which the exr crate computes a negative number: it panics where overflow is
/// checked, and fogbow still says one line, or renders.
#[test]
fn a_damaged_environment_is_one_line() {
    use exr::prelude::*;
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("sky.exr");
    let values = |name| AnyChannel::new(name, FlatSamples::F16(vec![f16::ONE; 64 * 32]));
    let channels = AnyChannels::sort(["R", "G", "B"].map(values).into_iter().collect());
    let encoding = Encoding {
        compression: Compression::B44,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let part = Layer::new((64, 32), LayerAttributes::default(), encoding, channels);
    exr::image::Image::from_layer(part).write().to_file(&file).unwrap();
    let mut bytes = std::fs::read(&file).unwrap();
    let end = bytes.len();
    bytes[end - 500..].fill(0);
    std::fs::write(&file, bytes).unwrap();
    let scene = format!("{CAMERA}[[light]]\ntype = \"environment\"\ntexture = \"sky.exr\"\n");
    std::fs::write(folder.path().join("s.toml"), scene).unwrap();
    let args = ["render", "s.toml", "-o", "a.exr", "--size", "4x4", "--rays", "1", "--quiet"];
    let output = fogbow().current_dir(folder.path()).args(args).output().unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(!message.contains("panicked"), "{message}");
    if cfg!(debug_assertions) {
        assert_eq!(output.status.code(), Some(1), "{message}");
        assert!(message.lines().count() == 1 && message.contains("sky.exr"), "{message}");
        assert!(message.contains("damaged"), "{message}");
    }
}

#[test]
fn an_earlier_picture_survives_a_failure() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.exr"), "earlier").unwrap();
    std::fs::write(folder.path().join("s.toml"), "[camera]").unwrap();
    let (code, _) = fails(folder.path(), &["render", "s.toml", "-o", "a.exr"]);
    assert_eq!(code, 1);
    assert_eq!(std::fs::read(folder.path().join("a.exr")).unwrap(), b"earlier");
}

#[test]
fn a_level_set_is_refused_and_converted_on_request() {
    let path =
        Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/volumes/levelset/sphere.vdb"));
    if !path.is_file() {
        skip::skip(path.display());
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let file = path.canonicalize().unwrap();
    let file = file.to_str().unwrap();
    let scene = |more: &str| format!("{CAMERA}[[medium]]\nfile = \"{file}\"\n{more}\n");
    std::fs::write(folder.path().join("refused.toml"), scene("grid = \"ls_sphere\"")).unwrap();
    let as_fog = scene("grid = \"ls_sphere\"\nlevel_set = \"fog\"");
    std::fs::write(folder.path().join("fog.toml"), as_fog).unwrap();
    let says = ["ls_sphere", "is a level set", "level_set = \"fog\""];
    refuses(folder.path(), &[file, "-o", "a.exr"], &says);
    refuses(folder.path(), &["refused.toml", "-o", "a.exr"], &says);

    let small = ["--size", "16x12", "--rays", "1", "--photons", "500"];
    succeeds(
        folder.path(),
        &[&["render", file, "-o", "a.exr", "--level-set", "fog"], &small[..]].concat(),
    );
    succeeds(folder.path(), &[&["render", "fog.toml", "-o", "b.exr"], &small[..]].concat());
    let layers = read_layers(&folder.path().join("a.exr")).unwrap();
    let alpha = layers.get("A").unwrap();
    assert!(alpha.iter().any(|a| *a > 0.5) && alpha.contains(&0.0), "a ball in the middle");
}

#[test]
fn threads_do_not_change_a_byte() {
    let folder = tempfile::tempdir().unwrap();
    let cases: [(&str, &[&str]); 6] = [
        ("smoke.toml", &[]),
        ("balls_b.toml", &[]),
        ("lucy.toml", &[]),
        ("fire.toml", &[]),
        ("road.toml", &[]),
        ("smoke.toml", &["--reference"]),
    ];
    for (scene, more) in cases {
        let [one, two] = ["1", "2"].map(|threads| {
            small(folder.path(), scene, threads, &[more, &["--threads", threads]].concat())
        });
        assert!(one[0] == two[0], "{scene} {more:?}: the EXR differs");
        assert!(one[1] == two[1], "{scene} {more:?}: the PNG differs");
        let other = small(folder.path(), scene, "3", &[more, &["--seed", "1"]].concat());
        assert!(one[0] != other[0], "{scene} {more:?}: the seed changes nothing");
    }
}

#[test]
fn pictures_hold_every_layer_and_what_they_were_made_with() {
    let folder = tempfile::tempdir().unwrap();
    for scene in SCENES {
        small(folder.path(), scene, "a", &["--seed", "7"]);
        let layers = read_layers(&folder.path().join("a.exr")).unwrap();
        assert_eq!((layers.width, layers.height), (32, 24));
        assert_layers(scene, &layers);
        let attribute = |name: &str| {
            layers.attributes.get(name).unwrap_or_else(|| panic!("{scene}: no {name}")).as_str()
        };
        assert_eq!(attribute("fogbow:version"), env!("CARGO_PKG_VERSION"));
        assert_eq!(attribute("fogbow:seed"), "7");
        assert_eq!(attribute("fogbow:rays"), "2");
        assert_eq!(attribute("fogbow:photons"), "5000");
        assert_eq!(attribute("fogbow:size"), "[32,24]");
        assert_eq!(attribute("fogbow:director"), "fixed");
        assert_eq!(attribute("fogbow:work:rays"), (32 * 24 * 2).to_string());
        assert_eq!(attribute("fogbow:work:dropped_samples"), "0");
        let hash = attribute("fogbow:scene");
        assert!(hash.len() >= 32 && hash.bytes().all(|b| b.is_ascii_hexdigit()), "{hash}");
        for name in ["radius", "step", "max_scatter", "method", "view", "exposure"] {
            attribute(&format!("fogbow:{name}"));
        }
        assert!(!layers.attributes.keys().any(|name| name.contains("second")), "timings");
    }
}

#[test]
fn lucy_herself_stands_in_for_the_statue_where_she_is_at_hand() {
    let mesh = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/meshes/lucy.obj");
    if !Path::new(mesh).is_file() {
        skip::skip(mesh);
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let depths = ["lucy_mesh.toml", "lucy.toml"].map(|scene| {
        small(folder.path(), scene, "a", &[]);
        let layers = read_layers(&folder.path().join("a.exr")).unwrap();
        layers.get("Z").unwrap()[12 * 32 + 16] // her middle, 6.6 m from the camera
    });
    assert!(depths.iter().all(|z| (6.0..7.0).contains(z)), "{depths:?}");
}

/// All layers that are promised are there, finite and in their range.
fn assert_layers(scene: &str, layers: &Layers) {
    let layer = |name: &str| {
        let values = layers.get(name).unwrap_or_else(|| panic!("{scene}: no layer {name}"));
        assert!(values.iter().all(|v| v.is_finite()), "{scene}: {name}");
        values
    };
    for name in ["R", "G", "B", "Z", "radius", "step", "variance"] {
        assert!(layer(name).iter().all(|v| *v >= 0.0), "{scene}: {name}");
    }
    for name in ["A", "transmittance", "saliency", "xs"] {
        assert!(layer(name).iter().all(|v| (0.0..=1.0).contains(v)), "{scene}: {name}");
    }
    assert!(layer("rays").iter().all(|v| *v == 2.0), "{scene}");
    assert!(layer("G").iter().any(|v| *v > 0.0), "{scene} is black");
}

#[test]
fn json_tells_settings_times_and_counters() {
    let folder = tempfile::tempdir().unwrap();
    let scene = volume("smoke.toml");
    let args = ["render", scene.to_str().unwrap(), "-o", "a.exr", "--size", "16x12", "--json"];
    let text = succeeds(folder.path(), &[&args[..], &["--rays", "1", "--photons", "500"]].concat());
    let report: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(report["settings"]["photons"], 500);
    assert_eq!(report["work"]["rays"], 16 * 12);
    assert_eq!(report["outputs"][1], "a.png");
    for stage in ["load", "write"] {
        assert!(report["seconds"][stage].as_f64().is_some_and(|s| s >= 0.0), "{report}");
    }
    assert_eq!(listing(folder.path()), ["a.exr", "a.png"]);
}

#[test]
fn info_tells_what_a_file_holds() {
    let folder = tempfile::tempdir().unwrap();
    let fire = volume("fire.vdb");
    let text = succeeds(folder.path(), &["info", fire.to_str().unwrap()]);
    for words in ["2 grid(s)", "\"density\": float, fog volume", "\"temperature\"", "voxel size"] {
        assert!(text.contains(words), "{words}: {text}");
    }
    let text = succeeds(folder.path(), &["info", fire.to_str().unwrap(), "--json"]);
    let report: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(report["density"], "density");
    assert_eq!(report["grids"][1]["name"], "temperature");
    assert!(report["grids"][0]["statistics"]["active"].as_u64().is_some_and(|n| n > 0));

    std::fs::write(folder.path().join("text.vdb"), "this is no VDB").unwrap();
    for name in ["text.vdb", "gone.vdb"] {
        let (code, message) = fails(folder.path(), &["info", name]);
        assert!(code == 1 && message.lines().count() == 1 && message.contains(name), "{message}");
    }
}

#[test]
fn make_gives_the_same_bytes_twice() {
    let folder = tempfile::tempdir().unwrap();
    for kind in ["smoke", "cloud", "fog", "fire"] {
        let [one, two, other] =
            [("one.vdb", "3"), ("two.vdb", "3"), ("other.vdb", "4")].map(|(name, seed)| {
                succeeds(
                    folder.path(),
                    &["make", kind, "-o", name, "--resolution", "24", "--seed", seed],
                );
                std::fs::read(folder.path().join(name)).unwrap()
            });
        assert!(one == two, "{kind} differs from itself");
        assert!(one != other, "{kind}: the seed changes nothing");
    }
    let (code, message) = fails(folder.path(), &["make", "smoke", "-o", "gone/a.vdb"]);
    assert!(code == 1 && message.lines().count() == 1, "{message}");
    let (code, message) = fails(folder.path(), &["make", "steam", "-o", "a.vdb"]);
    assert!(code == 2 && message.contains("smoke"), "{message}");
}
