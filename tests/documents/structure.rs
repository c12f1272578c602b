//! The structure that CONTRIBUTING.md promises: floors, no two files that use each other, their sizes,
//! and the call paths of a pixel and of a photon.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// Lines of a file at most.
const LONGEST_FILE: usize = 400;

/// Lines of a function on a call path at most.
const LONGEST_FUNCTION: usize = 60;

/// Functions of a call path at most.
const LONGEST_PATH: usize = 12;

/// Rooms of the renderer, which have at most [`FEW`] files below [`SHORT`] lines.
const HEART: [&str; 6] = ["render", "film", "photon", "cache", "strategy", "transport"];

/// See [`HEART`].
const SHORT: usize = 60;

/// See [`HEART`].
const FEW: usize = 5;

/// Rooms from the lowest floor to the highest. A room uses those on floors below its own.
const FLOORS: [&[&str]; 11] = [
    &["error", "file", "loopback", "math", "sequence", "work"],
    &["vdb", "image", "shape"],
    &["medium", "surface", "light", "make"],
    &["scene"],
    &["transport"],
    &["strategy", "photon", "cache"],
    &["director", "film"],
    &["render"],
    &["study", "verify"],
    &["cli"],
    &["python", "main"],
];

/// Path of a module below the crate's root.
type Module = Vec<String>;

/// The source files of the crate.
struct Sources {
    /// The text of each module's file, without comments, strings and tests.
    texts: BTreeMap<Module, String>,
    /// Lines of each file.
    lines: BTreeMap<Module, usize>,
}

/// What a module uses, and what it shows of others.
#[derive(Default)]
struct Uses {
    used: Vec<Module>,
    /// The path behind each name that it re-exports.
    shown: BTreeMap<String, Module>,
}

impl Sources {
    fn read() -> Self {
        let mut sources = Self { texts: BTreeMap::new(), lines: BTreeMap::new() };
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
        sources.add(&root, &mut Vec::new());
        sources
    }

    fn add(&mut self, folder: &Path, module: &mut Module) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
            if path.is_dir() {
                module.push(name);
                self.add(&path, module);
                module.pop();
            } else if path.extension().is_some_and(|e| e == "rs") {
                let text = fs::read_to_string(&path).unwrap();
                let mut own = module.clone();
                if !["mod", "lib"].contains(&name.as_str()) {
                    own.push(name);
                }
                self.lines.insert(own.clone(), text.lines().count());
                self.texts.insert(own, code(&text));
            }
        }
    }

    /// The path `path`, as `module` says it, from the crate's root; nothing for other crates.
    fn absolute(&self, module: &Module, path: &[&str]) -> Option<Module> {
        let owned = |path: &[&str]| path.iter().map(|s| (*s).to_owned()).collect::<Module>();
        let mut base = module.clone();
        let mut rest = path;
        match *path.first()? {
            "crate" => return Some(owned(&path[1..])),
            "self" => rest = &path[1..],
            "super" => {
                while rest.first() == Some(&"super") {
                    base.pop();
                    rest = &rest[1..];
                }
            }
            first => {
                let mut below = module.clone();
                below.push(first.to_owned());
                self.texts.contains_key(&below).then_some(())?;
            }
        }
        base.extend(owned(rest));
        Some(base)
    }

    /// The module whose file defines what `path` names, re-exports followed.
    fn home(&self, uses: &BTreeMap<Module, Uses>, path: &Module) -> Module {
        let mut path = path.clone();
        for _ in 0..8 {
            let depth = (0..=path.len()).rev().find(|&n| self.texts.contains_key(&path[..n]));
            let module = path[..depth.unwrap_or(0)].to_vec();
            let shown = path.get(module.len()).and_then(|name| uses[&module].shown.get(name));
            match shown {
                Some(next) => path.clone_from(next),
                None => return module,
            }
        }
        path
    }

    /// For each module the others that its file uses.
    fn arrows(&self) -> BTreeMap<Module, BTreeSet<Module>> {
        let uses: BTreeMap<Module, Uses> =
            self.texts.iter().map(|(m, text)| (m.clone(), self.uses(m, text))).collect();
        let of = |(module, own): (&Module, &Uses)| {
            let homes = own.used.iter().map(|path| self.home(&uses, path));
            let others = homes.filter(|home| home != module && !home.is_empty()).collect();
            (module.clone(), others)
        };
        uses.iter().map(of).collect()
    }

    fn uses(&self, module: &Module, text: &str) -> Uses {
        let mut uses = Uses::default();
        let mut rest = text;
        let mut body = String::new();
        while let Some((before, statement, after)) = next_use(rest) {
            body.push_str(before);
            let is_shown = before.trim_end().ends_with("pub") || before.trim_end().ends_with(')');
            for path in leaves(statement) {
                let path: Vec<&str> = path.iter().map(String::as_str).collect();
                let Some(path) = self.absolute(module, &path) else { continue };
                match path.last() {
                    Some(name) if is_shown => drop(uses.shown.insert(name.clone(), path.clone())),
                    _ => uses.used.push(path),
                }
            }
            rest = after;
        }
        body.push_str(rest);
        let is_word = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
        for word in body.split(|c| !is_word(c)) {
            let path: Vec<&str> = word.split("::").filter(|s| !s.is_empty()).collect();
            if path.len() > 1 && ["crate", "super", "self"].contains(&path[0]) {
                uses.used.extend(self.absolute(module, &path));
            }
        }
        uses
    }
}

/// `text` up to its tests, without comments and strings.
pub(crate) fn code(text: &str) -> String {
    let end = text.find("#[cfg(test)]\nmod ").unwrap_or(text.len());
    let without_comments = text[..end].lines().map(|line| line.split("//").next().unwrap_or(""));
    let lines = without_comments.map(|line| line.split('"').step_by(2).collect::<String>());
    lines.collect::<Vec<_>>().join("\n")
}

/// The first `use` of `text`: what stands before it, its tree, what comes after.
fn next_use(text: &str) -> Option<(&str, &str, &str)> {
    let starts = text.match_indices("use ").map(|(start, _)| start);
    let is_statement = |start: &usize| {
        let line = text[..*start].rsplit('\n').next().unwrap_or("").trim();
        line.is_empty() || line.starts_with("pub")
    };
    let start = starts.clone().find(is_statement)?;
    let tree = start + "use ".len();
    let end = tree + text[tree..].find(';')?;
    Some((&text[..start], &text[tree..end], &text[end + 1..]))
}

/// The paths of a tree of `use`, names before `as`.
fn leaves(tree: &str) -> Vec<Vec<String>> {
    let (mut parts, mut depth, mut part) = (Vec::new(), 0, String::new());
    for c in tree.chars() {
        depth += i32::from(c == '{') - i32::from(c == '}');
        if c == ',' && depth == 0 {
            parts.push(std::mem::take(&mut part));
        } else {
            part.push(c);
        }
    }
    parts.push(part);
    let segments = |path: &str| -> Vec<String> {
        let path = path.split(" as ").next().unwrap_or("");
        let names = path.split("::").map(str::trim).filter(|s| !s.is_empty() && *s != "self");
        let names = names.map(str::to_owned).collect::<Vec<_>>();
        if path.trim_start().starts_with("self::") {
            [vec!["self".to_owned()], names].concat()
        } else {
            names
        }
    };
    let paths = |part: &String| -> Vec<Vec<String>> {
        let Some((head, below)) = part.split_once('{') else { return vec![segments(part)] };
        let below = &below[..below.rfind('}').unwrap_or(below.len())];
        leaves(below).into_iter().map(|path| [segments(head), path].concat()).collect()
    };
    parts.iter().filter(|part| !part.trim().is_empty()).flat_map(paths).collect()
}

/// Modules that can be reached from `start` along `arrows`.
fn reached<'a>(
    arrows: &'a BTreeMap<Module, BTreeSet<Module>>,
    start: &'a Module,
) -> BTreeSet<&'a Module> {
    let (mut seen, mut open) = (BTreeSet::new(), vec![start]);
    while let Some(module) = open.pop() {
        for next in &arrows[module] {
            if seen.insert(next) {
                open.push(next);
            }
        }
    }
    seen
}

#[test]
fn no_two_files_use_each_other() {
    let arrows = Sources::read().arrows();
    assert!(arrows.values().map(BTreeSet::len).sum::<usize>() > 500, "too few uses were found");
    let in_circles = arrows.keys().filter(|module| reached(&arrows, module).contains(*module));
    let told: Vec<String> = in_circles.map(|module| module.join("/")).collect();
    assert!(told.is_empty(), "files in circles: {told:?}");
}

#[test]
fn rooms_use_floors_below_their_own() {
    let floor = |room: &str| FLOORS.iter().position(|rooms| rooms.contains(&room));
    let mut wrong = BTreeSet::new();
    for (module, others) in Sources::read().arrows() {
        let Some(own) = module.first() else { continue };
        for room in others.iter().map(|other| &other[0]).filter(|room| *room != own) {
            let below = match (floor(own), floor(room)) {
                (Some(0), Some(room)) => room == 0,
                (Some(own), Some(room)) => room < own,
                _ => own == "guide" || room == "guide",
            };
            if !below {
                wrong.insert(format!("{} uses {room}", module.join("/")));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn files_are_neither_long_nor_many() {
    let lines = Sources::read().lines;
    let long: Vec<_> = lines.iter().filter(|(_, lines)| **lines > LONGEST_FILE).collect();
    assert!(long.is_empty(), "{long:?}");
    let in_heart = |module: &Module| module.first().is_some_and(|m| HEART.contains(&m.as_str()));
    let short = lines.iter().filter(|(module, lines)| in_heart(module) && **lines < SHORT);
    // A file that only lists what a room shows is its table of contents.
    let short = short.filter(|(module, _)| {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
        !root.join(module.join("/")).is_dir()
    });
    let short: Vec<_> = short.collect();
    assert!(short.len() <= FEW, "{short:?}");
}

/// The functions of each call path in CONTRIBUTING.md: file and name.
fn call_paths() -> Vec<Vec<(String, String)>> {
    let text = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("CONTRIBUTING.md"));
    let text = text.unwrap();
    let (mut paths, mut last) = (Vec::<Vec<_>>::new(), 0);
    for line in text.lines() {
        // "3. `render/integrator/camera_path.rs` `trace`: ..."
        let Some((number, rest)) = line.split_once(". `") else { continue };
        let Ok(number) = number.trim().parse::<usize>() else { continue };
        let mut quoted = rest.split('`');
        let (file, function) = (quoted.next().unwrap(), quoted.nth(1).unwrap_or_default());
        if number != last + 1 {
            assert_eq!(number, 1, "{line}");
        }
        if number == 1 {
            paths.push(Vec::new());
        }
        last = number;
        paths.last_mut().unwrap().push((file.to_owned(), function.to_owned()));
    }
    paths
}

#[test]
fn call_paths_are_short() {
    let paths = call_paths();
    assert_eq!(paths.len(), 2, "one of a pixel, one of a photon");
    for (file, function) in paths.iter().flatten() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("src").join(file);
        let text = fs::read_to_string(&path).unwrap_or_else(|e| panic!("{file}: {e}"));
        let lines: Vec<&str> = text.lines().collect();
        let name = [format!("fn {function}("), format!("fn {function}<")];
        let start = lines.iter().position(|line| name.iter().any(|name| line.contains(name)));
        let start = start.unwrap_or_else(|| panic!("{file} has no {function}"));
        let indent = lines[start].len() - lines[start].trim_start().len();
        let end = format!("{}}}", " ".repeat(indent));
        let length = lines[start..].iter().position(|line| *line == end).unwrap() + 1;
        assert!(length < LONGEST_FUNCTION, "{file}: {function} has {length} lines");
    }
    for path in paths {
        assert!((3..=LONGEST_PATH).contains(&path.len()), "{path:?}");
    }
}
