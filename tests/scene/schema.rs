//! Scenes drawn at random from the schema: sound ones are read, and where one key is broken the
//! message names file, line, column and key, what was found there and what would be right.

use std::path::Path;

use fogbow::Error;
use fogbow::scene::file::parse;
use proptest::prelude::*;
use proptest::sample::Index;

/// What a key takes.
#[derive(Debug, Clone, Copy)]
enum Kind {
    Number,
    Whole,
    Text,
    /// Three numbers.
    Triple,
    /// A number or three.
    Color,
    Pair,
    Table,
}

/// A key of a table.
#[derive(Clone, Copy)]
struct Key {
    name: &'static str,
    kind: Kind,
    needed: bool,
    good: &'static str,
    /// Values of the right type that are out of range.
    bad: &'static [&'static str],
}

const fn key(
    name: &'static str,
    kind: Kind,
    needed: bool,
    good: &'static str,
    bad: &'static [&'static str],
) -> Key {
    Key { name, kind, needed, good, bad }
}

use Kind::{Color, Number, Pair, Table, Text, Triple, Whole};

const PLACE: [Key; 3] = [
    key("translate", Triple, false, "[1, 2, 3]", &["[1, nan, 3]"]),
    key("rotate", Triple, false, "[0, 90, 0]", &["[0, inf, 0]"]),
    key("scale", Color, false, "[1, 2, 1]", &["0", "[1, 0, 1]"]),
];

const CAMERA: &[Key] = &[
    key("position", Triple, true, "[0, 1, 8]", &["[0, nan, 8]"]),
    key("target", Triple, true, "[0, 1, 0]", &["[0, 1, 8]"]),
    key("up", Triple, false, "[0, 1, 0]", &["[0, 0, 0]", "[0, 0, 2]"]),
    key("fov", Number, false, "30.0", &["0", "180", "-5"]),
    key("aperture", Number, false, "0.1", &["-0.1"]),
    key("focus", Number, false, "3", &["0"]),
    key("shift", Pair, false, "[0.1, -0.2]", &["[inf, 0]"]),
    key("clip", Pair, false, "[0.1, 100]", &["[-1, 2]", "[2, 2]"]),
    key(
        "next",
        Table,
        false,
        "{ target = [0.5, 1, 0] }",
        &["{ target = [0, 1, 8] }", "{ up = [0, 0, 0] }", "{ fov = 1 }"],
    ),
];
const MOTION: &[Key] = &[
    key("shutter", Number, false, "0.5", &["-1", "11"]),
    key("position", Text, false, "\"start\"", &["\"middle\""]),
    key("fps", Number, false, "25", &["0"]),
    key("times", Whole, false, "8", &["0", "65"]),
];
const ORTHOGRAPHIC: &[Key] = &[
    key("type", Text, true, "\"orthographic\"", &["\"fisheye\""]),
    key("position", Triple, true, "[0, 1, 8]", &["[0, nan, 8]"]),
    key("target", Triple, true, "[0, 1, 0]", &["[0, 1, 8]"]),
    key("height", Number, true, "4", &["0", "-1"]),
    key("shift", Pair, false, "[0.1, -0.2]", &["[inf, 0]"]),
    key("clip", Pair, false, "[0.1, 100]", &["[-1, 2]", "[2, 2]"]),
];
const FILM: &[Key] = &[
    key("size", Pair, false, "[64, 32]", &["[0, 1]", "[1000000000, 1000000000]", "[65536, 65536]"]),
    key("exposure", Number, false, "1.5", &["101"]),
    key("view", Text, false, "\"srgb\"", &["\"film\""]),
];
const RENDER: &[Key] = &[
    key("rays", Whole, false, "4", &["0", "1_000_000_000_000", "1e12"]),
    key("photons", Whole, false, "1_000", &["1_000_000_000_000_000_000", "1e18"]),
    key("radius", Number, false, "0.1", &["0"]),
    key("step", Number, false, "0.1", &["-1"]),
    key("director", Text, false, "\"xs\"", &["\"best\""]),
    key("seed", Whole, false, "7", &["0.5"]),
    key("max_scatter", Whole, false, "1", &["1_000_001"]),
];
const DIRECTOR: &[Key] = &[
    key("x", Text, false, "\"transmittance\"", &["\"fog\""]),
    key("weights", Pair, false, "[1, 0]", &["[1, -1]"]),
    key("op", Text, false, "\"*\"", &["\"/\""]),
    key("directs", Text, false, "\"rays,step\"", &["\"light\""]),
    key("floor", Whole, false, "2", &["0"]),
    key("radius", Number, false, "2", &["0.5", "257"]),
    key("step", Number, false, "4", &["0.5"]),
    key("tolerance", Number, false, "0.1", &["0"]),
    key("resolution", Number, false, "0.5", &["0", "0.06", "4.1"]),
];
const SMOKE: &[Key] = &[
    key("file", Text, true, "\"smoke.vdb\"", &["\"gone.vdb\"", "\"..\"", "\"/dev/zero\""]),
    key("grid", Text, false, "\"density\"", &[]),
    key("index", Whole, false, "1", &["65536"]),
    key("level_set", Text, false, "\"fog\"", &["\"sdf\""]),
    key("sigma_t", Color, false, "[1, 2, 3]", &["-1", "[1, -1, 1]"]),
    key("albedo", Color, false, "0.9", &["-0.1", "1.1", "[0.5, 2, 0.5]"]),
    key("phase", Table, false, "\"rayleigh\"", &["{ type = \"fog\", diameter = 0 }"]),
    key("emission", Table, false, "{ grid = \"a\" }", &["{ grid = \"a\", scale = -1 }"]),
    PLACE[0],
    PLACE[1],
    PLACE[2],
    key("velocity", Table, false, "[\"u\", \"v\", \"w\"]", &["[\"u\", \"v\"]"]),
    key("velocity_unit", Text, false, "\"m/frame\"", &["\"km/h\""]),
    key("velocity_scale", Number, false, "-2", &[]),
];
const FOG: &[Key] = &[
    key(
        "region",
        Table,
        true,
        "{ sphere = { radius = 1 } }",
        &[
            "\"all\"",
            "{ sphere = { radius = 0 } }",
            "{ box = { min = [0, 0, 0], max = [1, 1, 0] } }",
        ],
    ),
    key("name", Text, false, "\"fog\"", &[]),
    key("albedo", Color, false, "[0.1, 0.2, 0.3]", &["2"]),
    key(
        "phase",
        Table,
        false,
        "{ type = \"henyey-greenstein\", g = 0.5 }",
        &["\"mie\"", "{ type = \"henyey-greenstein\", g = -1 }"],
    ),
    key("emission", Table, false, "{ color = 1 }", &["{ color = -1 }", "{ scale = 2 }"]),
];
const SPHERE: &[Key] = &[
    key("shape", Text, true, "\"sphere\"", &["\"ball\""]),
    key("center", Triple, false, "[0, 1, 0]", &["[0, 1, 1e300]"]),
    key("radius", Number, true, "0.5", &["0", "-1"]),
    key("material", Table, false, "{ type = \"glass\" }", &["{ type = \"glass\", ior = 0.9 }"]),
    PLACE[0],
    key("motion", Table, false, "{ translate = [1, 0, 0] }", &["{ rotate = 90 }", "{ x = 1 }"]),
];
const QUAD: &[Key] = &[
    key("shape", Text, true, "\"quad\"", &["\"square\""]),
    key("u", Triple, true, "[1, 0, 0]", &["[0, 0, 0]"]),
    key("v", Triple, true, "[0, 1, 0]", &["[0, 0, 0]", "[2, 0, 0]"]),
    key("emission", Color, false, "[1, 2, 3]", &["-1"]),
];
const MESH: &[Key] = &[
    key("shape", Text, true, "\"mesh\"", &["\"obj\""]),
    key("file", Text, true, "\"mesh.obj\"", &["\"gone.obj\"", "\"loop.obj\""]),
];
const POINT: &[Key] = &[
    key("type", Text, true, "\"point\"", &["\"lamp\""]),
    key("position", Triple, true, "[0, 3, 0]", &["[0, 3, inf]"]),
    key("power", Color, true, "10", &["-10"]),
];
const SPOT: &[Key] = &[
    key("type", Text, true, "\"spot\"", &["\"cone\""]),
    key("position", Triple, true, "[0, 3, 0]", &["[nan, 3, 0]"]),
    key("target", Triple, true, "[0, 0, 0]", &["[0, 3, 0]"]),
    key("intensity", Color, true, "10", &["[1, 2, -3]"]),
    key("angle", Number, false, "20", &["0", "181"]),
    key("falloff", Number, false, "5", &["31", "-1"]),
];
const SUN: &[Key] = &[
    key("type", Text, true, "\"sun\"", &["\"moon\""]),
    key("direction", Triple, true, "[0, -1, 0]", &["[0, 0, 0]"]),
    key("irradiance", Color, true, "3", &["-3"]),
    key("angle", Number, false, "0.5", &["180"]),
];
const SKY: &[Key] = &[
    key("type", Text, true, "\"environment\"", &["\"sky\""]),
    key("radiance", Color, true, "[0.1, 0.2, 0.3]", &["-1"]),
    key("scale", Number, false, "2", &["-2"]),
    key("rotate", Number, false, "-90", &["nan"]),
];

/// Tables of a scene: its head, its key in messages, its keys.
type TableOf = (&'static str, &'static str, &'static [Key]);

/// One of each row is in a scene, in this order; of a row of one it may be left out.
const TABLES: &[&[TableOf]] = &[
    &[("[camera]", "camera", CAMERA), ("[camera]", "camera", ORTHOGRAPHIC)],
    &[("[film]", "film", FILM)],
    &[("[motion]", "motion", MOTION)],
    &[("[render]", "render", RENDER)],
    &[("[director]", "director", DIRECTOR)],
    &[("[[medium]]", "medium[0]", SMOKE), ("[[medium]]", "medium[0]", FOG)],
    &[
        ("[[surface]]", "surface[0]", SPHERE),
        ("[[surface]]", "surface[0]", QUAD),
        ("[[surface]]", "surface[0]", MESH),
    ],
    &[
        ("[[light]]", "light[0]", POINT),
        ("[[light]]", "light[0]", SPOT),
        ("[[light]]", "light[0]", SUN),
        ("[[light]]", "light[0]", SKY),
    ],
];

/// How a key is broken.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Break {
    Type,
    Range,
    Missing,
    Twice,
    Misspelt,
}

impl Key {
    /// Values of another type than the key takes, or that no key takes.
    fn wrong_types(&self) -> Vec<&'static str> {
        let any = ["true", "1979-05-27", "[[1]]", "[]"];
        let number = ["nan", "-inf", "1e300"];
        let own: &[&str] = match self.kind {
            Number => &["\"1\"", "[1]", "{ a = 1 }"],
            Whole => &["1.5", "-1", "99999999999999999999", "\"1\"", "{ a = 1 }"],
            Text => &["1", "\"\"", "['a']", "{ a = 1 }"],
            Triple => &["1", "[1, 2]", "[1, 2, 3, 4]", "[1, 2, \"3\"]", "{ a = 1 }"],
            Color => &["\"red\"", "[1, 2]", "[1, 2, true]"],
            Pair => &["1", "[1]", "[1, 2, 3]", "[1, \"2\"]"],
            Table => &["1", "[1, 2]"],
        };
        let numeric = matches!(self.kind, Number | Whole | Color);
        any.into_iter()
            .chain(own.iter().copied())
            .chain(number.into_iter().filter(|_| numeric))
            .collect()
    }
}

/// A scene of lines, with where each key stands.
struct Draft {
    lines: Vec<String>,
    /// Line (from 0), table and key.
    keys: Vec<(usize, TableOf, Key)>,
    /// Line of each table's head.
    heads: Vec<(usize, TableOf)>,
}

/// Draws a scene with the choices in `picks`.
fn draft(picks: &mut impl Iterator<Item = Index>) -> Draft {
    let mut draft = Draft { lines: Vec::new(), keys: Vec::new(), heads: Vec::new() };
    let mut pick = |n: usize| picks.next().expect("enough").index(n);
    for (row, choices) in TABLES.iter().enumerate() {
        if row > 0 && pick(3) == 0 {
            continue;
        }
        let table = choices[pick(choices.len())];
        draft.lines.extend(["", "# ünïcode before it"].into_iter().take(pick(3)).map(String::from));
        draft.heads.push((draft.lines.len(), table));
        draft.lines.push(table.0.into());
        for key in
            table.2.iter().filter(|key| key.needed || pick(2) == 0).copied().collect::<Vec<_>>()
        {
            let indent = " ".repeat(pick(4));
            draft.keys.push((draft.lines.len(), table, key));
            draft.lines.push(format!("{indent}{} = {} # µm", key.name, key.good));
        }
    }
    draft
}

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for name in ["smoke.vdb", "mesh.obj"] {
        std::fs::write(folder.path().join(name), "").unwrap();
    }
    std::os::unix::fs::symlink("loop.obj", folder.path().join("loop.obj")).unwrap();
    folder
}

/// Line, column, key and problem of the error that `text` gives.
fn error(folder: &Path, text: &str) -> (usize, usize, String, String) {
    let path = folder.join("scene.toml");
    match parse(&path, text) {
        Err(Error::Key { path: told, line, column, key, problem }) => {
            assert_eq!(told, path);
            (line, column, key, problem)
        }
        Err(other) => panic!("another error: {other}\n{text}"),
        Ok(_) => panic!("accepted:\n{text}"),
    }
}

/// Breaks one key of `draft` and looks at the message.
fn check(folder: &Path, mut draft: Draft, way: Break, pick: impl Fn(usize) -> usize) {
    let (at, table, key) = draft.keys[pick(draft.keys.len())];
    let full = format!("{}.{}", table.1, key.name);
    let indent = draft.lines[at].len() - draft.lines[at].trim_start().len();
    let values = match way {
        Break::Type => key.wrong_types(),
        Break::Range => key.bad.to_vec(),
        _ => vec![key.good],
    };
    let has_default = !key.needed || full == "camera.type";
    if values.is_empty() || way == Break::Missing && has_default {
        return;
    }
    let value = values[pick(values.len())];
    let head = draft.heads.iter().find(|(_, t)| t.1 == table.1).expect("its table").0;
    match way {
        Break::Type | Break::Range => {
            draft.lines[at] = format!("{}{} = {value} # µm", " ".repeat(indent), key.name);
        }
        Break::Missing => draft.lines[at].clear(),
        Break::Twice => draft.lines.insert(at + 1, format!("{} = {value}", key.name)),
        Break::Misspelt => {
            draft.lines[at] = format!("{}{}q = {value}", " ".repeat(indent), key.name);
        }
    }
    let text = draft.lines.join("\n");
    let (line, column, told, problem) = error(folder, &text);
    let context =
        || format!("{way:?} {full} = {value}: {line}:{column}: {told}: {problem}\n{text}");
    assert!(!problem.is_empty() && !problem.contains('\n'), "{}", context());
    match way {
        Break::Type | Break::Range => {
            assert_eq!(line, at + 1, "{}", context());
            let start = indent + key.name.len() + 4;
            assert!((start..start + value.len()).contains(&column), "{}", context());
            let deeper = |c: char| c == '.' || c == '[';
            let rest = told.strip_prefix(&full);
            assert!(rest.is_some_and(|r| r.is_empty() || r.starts_with(deeper)), "{}", context());
            let found = problem.contains("found `") || problem.contains("missing");
            let named = problem.contains("unknown key") || problem.contains("no such file");
            assert!(found || named || problem.contains("is not a file"), "{}", context());
            assert!(problem.contains("give ") || problem.contains("known here"), "{}", context());
        }
        Break::Missing => {
            assert_eq!(line, head + 1, "{}", context());
            assert!(told == full || problem.contains(key.name), "{}", context()); // or another key
            assert!(problem.contains("missing") && problem.contains("give "), "{}", context());
        }
        Break::Twice => {
            assert_eq!(line, at + 2, "{}", context());
            assert!(problem.contains("duplicate key"), "{}", context());
        }
        // Without its kind a table has no list of keys.
        Break::Misspelt if key.needed && problem.contains("missing") => {
            assert_eq!((line, &told), (head + 1, &full), "{}", context());
        }
        Break::Misspelt => {
            assert_eq!((line, column), (at + 1, indent + 1), "{}", context());
            assert_eq!(told, format!("{full}q"), "{}", context());
            assert!(problem.contains("unknown key"), "{}", context());
        }
    }
}

fn picks() -> impl Strategy<Value = Vec<Index>> {
    prop::collection::vec(any::<Index>(), 150)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn sound_scenes_are_read(picks in picks()) {
        let folder = folder();
        let text = draft(&mut picks.into_iter()).lines.join("\n");
        let read = parse(&folder.path().join("scene.toml"), &text);
        prop_assert!(read.is_ok(), "{}\n{text}", read.unwrap_err());
    }

    #[test]
    fn one_broken_key_is_told_with_its_place(picks in picks(), key in any::<Index>(),
        way in prop::sample::select(vec![Break::Type, Break::Type, Break::Range, Break::Missing,
            Break::Twice, Break::Misspelt])) {
        let folder = folder();
        check(folder.path(), draft(&mut picks.into_iter()), way, |n| key.index(n));
    }
}

/// Every key of the schema with every value that it must not have.
#[test]
fn every_wrong_value_of_every_key_is_told() {
    let folder = folder();
    for choices in TABLES {
        for (head, name, keys) in *choices {
            for key in *keys {
                for value in key.wrong_types().iter().chain(key.bad) {
                    let camera = "[camera]\nposition = [0, 1, 8]\ntarget = [0, 1, 0]\n";
                    let camera = if *name == "camera" { "" } else { camera };
                    let lines = keys.iter().filter(|k| k.needed || k.name == key.name).map(|k| {
                        let value = if k.name == key.name { value } else { k.good };
                        format!("{} = {value}\n", k.name)
                    });
                    let text = format!("{camera}{head}\n{}", lines.collect::<String>());
                    let (line, _, told, problem) = error(folder.path(), &text);
                    let right = text.lines().nth(line - 1).unwrap().starts_with(key.name)
                        && told.starts_with(&format!("{name}.{}", key.name));
                    assert!(right, "{line}: {told}: {problem}\n{text}");
                }
            }
        }
    }
}
