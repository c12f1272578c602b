//! The text of a scene, with a sentence on every key.

use std::fmt::Write as _;

use toml::Value;

use super::keys::camera as camera_keys;
use super::keys::medium::FILE;
use super::keys::surface::NEXT_FILE;
use super::keys::{Key, TABLES};
use super::reader::Setting;

/// The scene of a bare render, table by table.
#[derive(Debug, Clone, Default)]
pub struct Draft {
    tables: Vec<Table>,
}

#[derive(Debug, Clone)]
struct Table {
    name: &'static str,
    /// Whether it is one of several of its name.
    listed: bool,
    /// The comment above it.
    title: String,
    entries: Vec<Entry>,
}

#[derive(Debug, Clone)]
struct Entry {
    name: String,
    value: Value,
    comment: String,
}

impl Draft {
    /// Begins the table `[name]`.
    pub(super) fn table(&mut self, name: &'static str, title: &str) -> &mut Self {
        self.begin(name, false, title)
    }

    /// Begins one of the tables `[[name]]`.
    pub(super) fn listed(&mut self, name: &'static str, title: &str) -> &mut Self {
        self.begin(name, true, title)
    }

    fn begin(&mut self, name: &'static str, listed: bool, title: &str) -> &mut Self {
        self.tables.push(Table { name, listed, title: title.into(), entries: Vec::new() });
        self
    }

    /// Gives the last table a key.
    pub(super) fn key(&mut self, key: &Key, value: impl Into<Value>) -> &mut Self {
        if let Some(table) = self.tables.last_mut() {
            table.set(key.name, value.into(), &comment(key));
        }
        self
    }

    /// Leaves out what `scene` has itself: single tables of the same name, and media whose name it gives one.
    pub(super) fn leave_out(&mut self, scene: &toml::Table) {
        let media = scene.get("medium").and_then(Value::as_array).into_iter().flatten();
        let named: Vec<_> = media.filter_map(|medium| medium.get("name")).collect();
        self.tables.retain(|table| {
            let is_replaced = |entry: &Entry| entry.name == "name" && named.contains(&&entry.value);
            let replaces_single = !table.listed && scene.contains_key(table.name);
            let replaces_medium =
                || table.name == "medium" && table.entries.iter().any(is_replaced);
            !(replaces_single || replaces_medium())
        });
    }

    /// Adds the tables of `other`.
    pub(super) fn append(&mut self, other: Self) {
        self.tables.extend(other.tables);
    }

    /// Gives the camera its pose in `later`, the scene one frame later, where that is another, and each surface the file that
    /// `mesh` names for its own.
    pub(super) fn set_next(&mut self, later: &Self, mut mesh: impl FnMut(&str) -> Option<String>) {
        let camera = |draft: &Self| draft.tables.iter().position(|table| table.name == "camera");
        if let Some((here, there)) = camera(self).zip(camera(later)) {
            let there = &later.tables[there];
            let here = &mut self.tables[here];
            let of_pose = [&camera_keys::POSITION, &camera_keys::TARGET, &camera_keys::UP];
            let pose = |table: &Table| {
                let value = |key: &&Key| Some((key.name.to_owned(), table.get(key.name)?.clone()));
                of_pose.iter().filter_map(value).collect::<toml::Table>()
            };
            let next = pose(there);
            if next != pose(here) {
                here.set(camera_keys::NEXT.name, next.into(), &comment(&camera_keys::NEXT));
            }
        }
        for table in self.tables.iter_mut().filter(|table| table.name == "surface") {
            let file = table.get("file").and_then(Value::as_str);
            if let Some(next) = file.and_then(&mut mesh) {
                table.set(NEXT_FILE.name, next.into(), &comment(&NEXT_FILE));
            }
        }
    }

    /// The files of media with those that they have in `later`, the scene one frame later.
    pub(super) fn volumes_beside<'a>(&'a self, later: &'a Self) -> Vec<(&'a str, &'a str)> {
        fn add<'a>(name: &str, beside: [&'a Value; 2], pairs: &mut Vec<(&'a str, &'a str)>) {
            match beside {
                [Value::String(here), Value::String(there)] if name == FILE.name => {
                    pairs.push((here, there));
                }
                [Value::Table(here), Value::Table(there)] => {
                    for (name, here) in here {
                        if let Some(there) = there.get(name) {
                            add(name, [here, there], pairs);
                        }
                    }
                }
                _ => {}
            }
        }
        let media = |draft: &'a Self| draft.tables.iter().filter(|table| table.name == "medium");
        let mut pairs = Vec::new();
        for here in media(self) {
            let Some(there) = media(later).find(|there| there.title == here.title) else {
                continue;
            };
            for Entry { name, value, .. } in &here.entries {
                if let Some(there) = there.get(name) {
                    add(name, [value, there], &mut pairs);
                }
            }
        }
        pairs
    }

    /// Sets the file of the first medium, as the scene names it.
    pub fn set_file(&mut self, file: &str) {
        let medium = self.tables.iter_mut().find(|table| table.name == "medium");
        if let Some(entry) = medium.and_then(|m| m.entries.iter_mut().find(|e| e.name == "file")) {
            entry.value = file.into();
        }
    }

    /// Names files as `names` say, by the names that they have.
    pub fn rename(&mut self, names: &std::collections::BTreeMap<String, String>) {
        fn visit(value: &mut Value, names: &std::collections::BTreeMap<String, String>) {
            match value {
                Value::String(text) => {
                    if let Some(name) = names.get(text) {
                        text.clone_from(name);
                    }
                }
                Value::Table(table) => table.iter_mut().for_each(|(_, value)| visit(value, names)),
                _ => {}
            }
        }
        for entry in self.tables.iter_mut().flat_map(|table| &mut table.entries) {
            visit(&mut entry.value, names);
        }
    }

    /// The draft with `settings` applied, except those of tables that it does not have.
    #[must_use]
    pub fn with(mut self, settings: &[Setting]) -> Self {
        for setting in settings {
            let (path, value) = setting.parts();
            let Ok(value) = format!("v = {value}").parse::<toml::Table>() else { continue };
            if let Some(value) = value.get("v") {
                self.put(path, value.clone());
            }
        }
        self
    }

    fn put(&mut self, path: &str, value: Value) {
        let mut words = path.split('.');
        let name = words.next().unwrap_or_default();
        if !self.tables.iter().any(|table| table.name == name)
            && let Some(name) =
                ["motion", "film", "render", "director"].into_iter().find(|n| *n == name)
        {
            self.begin(name, false, "");
        }
        let mut named = self.tables.iter_mut().filter(|table| table.name == name);
        let Some(mut table) = named.next() else { return };
        if table.listed {
            let index = words.next().and_then(|word| word.parse::<usize>().ok());
            match index {
                Some(0) => {}
                Some(index) => match named.nth(index - 1) {
                    Some(other) => table = other,
                    None => return,
                },
                None => return,
            }
        }
        let Some(key) = words.next() else { return };
        let rest: Vec<&str> = words.collect();
        let comment = known(table.name, key).map(self::comment).unwrap_or_default();
        if rest.is_empty() {
            table.set(key, value, &comment);
            return;
        }
        let index = match table.entries.iter().position(|entry| entry.name == key) {
            Some(index) => index,
            None => {
                table.set(key, Value::Table(toml::Table::new()), &comment);
                table.entries.len() - 1
            }
        };
        let mut at = &mut table.entries[index].value;
        for word in &rest[..rest.len() - 1] {
            let Value::Table(below) = at else { return };
            at = below.entry(*word).or_insert_with(|| Value::Table(toml::Table::new()));
        }
        if let Value::Table(below) = at {
            below.insert(rest[rest.len() - 1].into(), value);
        }
    }

    /// The scene as TOML, each key with a comment that says what it means.
    pub fn text(&self) -> String {
        let mut out = String::new();
        for table in &self.tables {
            let header = if table.listed {
                format!("[[{}]]", table.name)
            } else {
                format!("[{}]", table.name)
            };
            if !out.is_empty() {
                out.push('\n');
            }
            if !table.title.is_empty() {
                let _ = writeln!(out, "# {}", table.title);
            }
            let _ = writeln!(out, "{header}");
            let lines: Vec<String> =
                table.entries.iter().map(|e| format!("{} = {}", e.name, e.value)).collect();
            let width = lines.iter().map(|line| line.chars().count()).filter(|n| *n <= 60).max();
            let width = width.unwrap_or(0);
            for (line, entry) in lines.iter().zip(&table.entries) {
                let _ = writeln!(out, "{line:width$}  # {}", entry.comment);
            }
        }
        out
    }
}

impl Table {
    fn get(&self, name: &str) -> Option<&Value> {
        self.entries.iter().find(|entry| entry.name == name).map(|entry| &entry.value)
    }

    fn set(&mut self, name: &str, value: Value, comment: &str) {
        match self.entries.iter_mut().find(|entry| entry.name == name) {
            Some(entry) => entry.value = value,
            None => self.entries.push(Entry { name: name.into(), value, comment: comment.into() }),
        }
    }
}

/// The comment of a key: its sentence and unit.
fn comment(key: &Key) -> String {
    let doc = key.doc.trim_end_matches('.');
    if key.unit.is_empty() { doc.into() } else { format!("{doc}, {}", key.unit) }
}

/// The key of this name that tables called `table` have.
fn known(table: &str, key: &str) -> Option<&'static Key> {
    let of_table = TABLES.iter().filter(|(name, ..)| name.trim_matches(['[', ']']) == table);
    of_table.flat_map(|(.., table)| table.keys).copied().find(|known| known.name == key)
}

/// `x` with five significant digits, enough for a value that was chosen.
pub(super) fn rounded(x: f64) -> f64 {
    significant(x, 4)
}

fn significant(x: f64, digits: usize) -> f64 {
    format!("{x:.digits$e}").parse().unwrap_or(x)
}

/// A point with ten significant digits, exact enough for a small object far from the origin.
pub(super) fn point(p: glam::DVec3) -> Value {
    Value::Array(p.to_array().map(|x| Value::Float(significant(x, 9))).to_vec())
}

/// A direction or a colour, each number [`rounded`].
pub(super) fn triple(v: glam::DVec3) -> Value {
    Value::Array(v.to_array().map(|x| Value::Float(rounded(x))).to_vec())
}

/// A point, a direction or a colour, as exactly as numbers are.
pub(super) fn exact(v: glam::DVec3) -> Value {
    // Adding 0 turns -0 into 0.
    Value::Array(v.to_array().map(|x| Value::Float(x + 0.0)).to_vec())
}
