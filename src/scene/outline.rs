//! A scene file as plain TOML: what can be told without knowing its keys.

use std::path::Path;

use toml::{Table, Value};

use crate::sequence::Pattern;

/// Tables of what is seen where there are no media, beside the camera.
pub(super) const STATIC: [&str; 2] = ["surface", "light"];

/// Tables of what no light depends on.
const OF_PICTURE: [&str; 4] = ["camera", "film", "render", "director"];

/// Keys that name files.
const FILES: [&str; 4] = ["file", "next_file", "texture", "mesh"];

/// What `text` says of surfaces and lights, however it is laid out. A text that is no TOML says
/// nothing.
pub(super) fn static_tables(text: &str) -> String {
    let mut table = parsed(text);
    table.retain(|key, _| STATIC.contains(&key));
    table.to_string()
}

/// What `text` says of all that light depends on, however it is laid out: media, surfaces and lights.
pub(super) fn light_tables(text: &str) -> String {
    let mut table = parsed(text);
    table.retain(|key, _| is_of_light(key));
    table.to_string()
}

/// Whether light depends on settings of the top table `table`.
pub(super) fn is_of_light(table: &str) -> bool {
    !OF_PICTURE.contains(&table)
}

/// The number that `text` gives as `frame` of `[motion]`.
pub(super) fn frame(text: &str) -> Option<f64> {
    let key = "frame";
    // Most texts need not be parsed for it.
    let table = text.contains(key).then(|| parsed(text))?;
    let value = table.get("motion")?.get(key)?;
    value.as_float().or_else(|| value.as_integer().map(|number| number as f64))
}

/// The sequences of files that a scene names.
#[derive(Debug, Default)]
pub(super) struct Named {
    /// By their patterns, each once.
    pub(super) patterns: Vec<Pattern>,
    /// Those among them of grids, of which a time between two frames needs both.
    pub(super) of_grids: Vec<Pattern>,
    /// Whether surfaces or lights name any.
    pub(super) by_static_scene: bool,
}

/// The sequences of files that `text`, the scene file `path`, names.
pub(super) fn sequences(path: &Path, text: &str) -> Named {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut named = Named::default();
    for (key, value) in &parsed(text) {
        visit(value, &mut |name, of| {
            let file = folder.join(name);
            let Some(pattern) = Pattern::from_path(&file).filter(|_| !file.is_file()) else {
                return;
            };
            named.by_static_scene |= STATIC.contains(&key.as_str());
            if key == "medium" && of == "file" && !named.of_grids.contains(&pattern) {
                named.of_grids.push(pattern.clone());
            }
            if !named.patterns.contains(&pattern) {
                named.patterns.push(pattern);
            }
        });
    }
    named
}

/// What is wrong where `name` stands for many files and no frame is given.
pub(super) fn without_frame(name: &str, pattern: &Pattern) -> String {
    let numbers = pattern.numbers();
    let (example, there) = match (numbers.first(), numbers.last()) {
        (Some(first), Some(last)) => {
            let count = numbers.len();
            (
                format!("{first}-{last}"),
                format!("; {count} of its files are there, {first} to {last}"),
            )
        }
        _ => ("1-100".into(), "; none of its files is there".into()),
    };
    format!(
        "{name} is a sequence of files; say which with `fogbow render --frames {example}`, for \
         other commands with `--frame N`{there}"
    )
}

/// Tells `found` every file name in `value` with its key.
fn visit(value: &Value, found: &mut impl FnMut(&str, &str)) {
    match value {
        Value::Array(items) => items.iter().for_each(|item| visit(item, found)),
        Value::Table(table) => {
            for (key, value) in table {
                match value.as_str().filter(|_| FILES.contains(&key.as_str())) {
                    Some(name) => found(name, key),
                    None => visit(value, found),
                }
            }
        }
        _ => {}
    }
}

fn parsed(text: &str) -> Table {
    text.parse().unwrap_or_default()
}
