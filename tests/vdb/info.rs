//! `fogbow info`: every field of the report, and a damaged grid beside a sound one.

use assert_cmd::Command;
use fogbow::vdb::{Block, GridToWrite, write};
use glam::{DVec3, IVec3};
use serde_json::Value;

fn grid(name: &str) -> GridToWrite {
    let mut grid = GridToWrite::fog(name, 0.1, DVec3::ZERO);
    // Values without any pattern, which compression cannot shrink.
    let values = (0..512u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 8) as f32).collect();
    grid.blocks.push(Block { origin: IVec3::ZERO, values, active: None });
    grid
}

#[test]
fn the_grids_beside_a_damaged_one_are_listed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("two.vdb");
    write(&path, &[grid("density"), grid("soot")]).unwrap();
    let mut bytes = std::fs::read(&path).unwrap();
    let end = bytes.len();
    bytes[end - 1000..].fill(0xa5); // inside the voxels of the last grid
    std::fs::write(&path, bytes).unwrap();

    let info = |more: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_fogbow"));
        let output = command.arg("info").arg(&path).args(more).assert().success();
        String::from_utf8(output.get_output().stdout.clone()).unwrap()
    };
    let report: Value = serde_json::from_str(&info(&["--json"])).unwrap();
    let [sound, damaged] = &report["grids"].as_array().unwrap()[..] else { panic!("{report}") };
    assert_eq!(report["format_version"], 224);
    assert_eq!(report["density"], "density");
    for (pointer, value) in [
        ("/label", Value::from("density")),
        ("/value_type", "float".into()),
        ("/class", "fog volume".into()),
        ("/map", "UniformScaleMap".into()),
        ("/compression", "active mask + blosc".into()),
        ("/matrix/0", vec![0.1, 0.0, 0.0, 0.0].into()),
        ("/statistics/active", 511.into()),
        ("/statistics/leaves", 1.into()),
        ("/statistics/active_tiles", 0.into()),
        ("/statistics/tile_voxels", 0.into()),
        ("/statistics/bad/nan", 0.into()),
        ("/statistics/bounds/1", vec![7, 7, 7].into()),
        ("/problem", Value::Null),
        ("/verdict", "taken for density".into()),
    ] {
        assert_eq!(sound.pointer(pointer), Some(&value), "{pointer}: {sound}");
    }
    for key in ["/statistics/min", "/statistics/max", "/statistics/mean", "/memory_bytes"] {
        assert!(sound.pointer(key).is_some_and(Value::is_number), "{key}: {sound}");
    }
    assert!(sound["world_bounds"].is_array());

    assert_eq!(damaged["label"], "soot");
    let problem = damaged["problem"].as_str().unwrap();
    assert_eq!(damaged["verdict"], format!("refused: {problem}"));
    assert!(damaged["statistics"].is_null());
    assert!(report["summary"].as_str().is_some_and(|line| line.starts_with("smoke, ")), "{report}");
    let text = info(&[]);
    assert!(text.contains(problem) && text.contains("\"density\": float"), "{text}");
}

#[test]
fn the_first_line_says_what_a_bare_render_does() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.vdb");
    let scalar = |name: &str, value: fn(usize) -> f32| {
        let mut grid = GridToWrite::fog(name, 1.0 / 3.0, DVec3::ZERO);
        let values = (0..512).map(value).collect();
        grid.blocks.push(Block { origin: IVec3::ZERO, values, active: None });
        grid
    };
    let density = || scalar("density", |_| 1.0 / 3.0);
    let info = |grids: &[GridToWrite]| {
        write(&path, grids).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_fogbow"));
        let output = command.arg("info").arg(&path).assert().success();
        String::from_utf8(output.get_output().stdout.clone()).unwrap()
    };
    let size = "2.67 x 2.67 x 2.67 m";
    let text = info(&[density()]);
    assert_eq!(text.lines().next(), Some(&*format!("smoke, optical thickness 6, y up, {size}")));
    for words in
        ["values      0.3333 to 0.3333, mean 0.3333, 0 zeros", "[0.3333, 0.3333, 0.3333] m"]
    {
        assert!(text.contains(words), "{words}: {text}");
    }

    let parts = ["Cd.x", "Cd.y", "Cd.z"].map(|name| scalar(name, |_| 0.5));
    let mut grids = vec![density(), scalar("flames", |i| i as f32), scalar("phi_out", |_| 1.0)];
    grids.extend(parts);
    grids.push(scalar("flags", |_| 1.0));
    let text = info(&grids);
    let first =
        format!("fire, optical thickness 4, glows by `flames`, coloured by `Cd`, z up, {size}");
    assert_eq!(text.lines().next(), Some(&*first));
    let count = |words: &str| text.matches(words).count();
    for (words, wanted) in [
        ("taken for density", 1),
        ("taken for fire", 1),
        ("taken for colour", 3),
        ("not used by a bare render", 2),
    ] {
        assert_eq!(count(words), wanted, "{words}: {text}");
    }

    let text = info(&[scalar("pressure", |_| 1.0)]);
    assert!(text.starts_with("a bare render refuses it: "), "{text}");
    let text = info(&[scalar("density", |_| 0.0)]);
    assert!(
        text.starts_with("a bare render refuses it: ") && text.contains("no density above 0"),
        "{text}"
    );
}
