//! The table of named constants, which the doc comments of the sources make.
//!
//! The last paragraph of such a comment is `Unit: UNIT. KIND: what of it.`

mod item;
mod number;
mod origin;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use crate::structure::code;

use item::{Item, items, with_implementations};
use number::floats;
use origin::{KINDS, Origin, origin};

/// Rooms whose constants are told of.
const ROOMS: [&str; 6] = ["transport", "strategy", "photon", "cache", "film", "director"];

/// Constants that measurements may have chosen, at most.
const MAX_MEASURED: usize = 25;

/// Numbers of formulas. Any other is a constant with a name.
const OF_FORMULAS: [f64; 7] = [0.0, 0.5, 1.0, 2.0, 3.0, 4.0, 6.0];

const COMMAND: &str = "RENEW_CONSTANTS=1 cargo test --test documents the_table_of_constants";

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The sources of a room with their paths in it, in order.
fn files(room: &str) -> Vec<(String, String)> {
    fn add(folder: &Path, files: &mut BTreeSet<PathBuf>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                add(&path, files);
            } else if path.extension().is_some_and(|e| e == "rs") {
                files.insert(path);
            }
        }
    }
    let room = root().join("src").join(room);
    let mut files = BTreeSet::new();
    add(&room, &mut files);
    let text = |path: &PathBuf| {
        let name = path.strip_prefix(&room).unwrap().to_str().unwrap().to_owned();
        (name, fs::read_to_string(path).unwrap())
    };
    files.iter().map(text).collect()
}

/// The constants of all rooms by room and file, or what is wrong with them.
fn constants() -> Result<Vec<(&'static str, String, Item, Origin)>, String> {
    let (mut constants, mut wrong) = (Vec::new(), Vec::new());
    for room in ROOMS {
        for (file, text) in files(room) {
            for item in with_implementations(items(&text)) {
                match origin(&item.doc) {
                    Ok(origin) => constants.push((room, file.clone(), item, origin)),
                    Err(what) => wrong.push(format!("{room}/{file}: {}: {what}", item.name)),
                }
            }
        }
    }
    if wrong.is_empty() { Ok(constants) } else { Err(wrong.join("\n")) }
}

/// The page of them.
fn page(constants: &[(&'static str, String, Item, Origin)]) -> String {
    let cell = |text: &str| text.replace('|', "\\|");
    let mut page = format!(
        "# Named constants\n\nFor those who work on fogbow: the constants of its rooms {}. \
         `tests/documents/constants/` makes this page of their doc comments.\n\n| origin | means | constants |\n\
         | --- | --- | --- |\n",
        ROOMS.map(|room| format!("`{room}`")).join(", "),
    );
    for (kind, means) in KINDS {
        let count = constants.iter().filter(|(.., origin)| origin.kind == kind).count();
        let most =
            if kind == "Bench" { format!(" of {MAX_MEASURED} at most") } else { String::new() };
        page += &format!("| {} | {means} | {count}{most} |\n", kind.to_lowercase());
    }
    for room in ROOMS {
        page += &format!(
            "\n## `{room}`\n| file | name | value | unit | meaning | origin |\n\
             | --- | --- | --- | --- | --- | --- |\n"
        );
        for (_, file, item, origin) in constants.iter().filter(|(of, ..)| *of == room) {
            let (name, value) = (&item.name, cell(item.value.as_deref().unwrap_or_default()));
            let (meaning, text) = (cell(&origin.meaning), cell(&origin.text));
            let (unit, kind) = (&origin.unit, origin.kind.to_lowercase());
            page += &format!(
                "| `{file}` | `{name}` | `{value}` | {unit} | {meaning} | {kind}: {text} |\n"
            );
        }
    }
    page
}

/// `RENEW_CONSTANTS=1 cargo test --test documents the_table_of_constants` writes it anew.
#[test]
fn the_table_of_constants_is_that_of_the_sources() {
    let constants = constants().unwrap_or_else(|wrong| panic!("{wrong}"));
    assert!(constants.len() > 50, "too few were found");
    let made = page(&constants);
    let path = root().join("src/guide/constants.md");
    if std::env::var_os("RENEW_CONSTANTS").is_some() {
        fs::write(&path, &made).unwrap();
    }
    let there = fs::read_to_string(&path).unwrap_or_default();
    assert!(there == made, "{} is stale: run {COMMAND}", path.display());
}

#[test]
fn few_constants_are_chosen_by_measuring() {
    let constants = constants().unwrap_or_else(|wrong| panic!("{wrong}"));
    let measured = constants.iter().filter(|(.., origin)| origin.kind == "Bench");
    let names: Vec<&str> = measured.map(|(_, _, item, _)| item.name.as_str()).collect();
    assert!(names.len() <= MAX_MEASURED, "{}: {names:?}", names.len());
}

#[test]
fn no_number_but_those_of_formulas_is_without_a_name() {
    let mut bare = Vec::new();
    for room in ROOMS {
        for (file, text) in files(room) {
            let named: Vec<_> = items(&text).into_iter().map(|item| item.lines).collect();
            for (index, line) in code(&text).lines().enumerate() {
                let is_bare = |number: &f64| !OF_FORMULAS.contains(number);
                if !named.iter().any(|lines| lines.contains(&index))
                    && floats(line).iter().any(is_bare)
                {
                    bare.push(format!("{room}/{file}:{}: {}", index + 1, line.trim()));
                }
            }
        }
    }
    assert!(bare.is_empty(), "give them names:\n{}", bare.join("\n"));
}
