//! A scene file as plain TOML: what can be told without knowing its keys.

use std::path::Path;

use toml::{Table, Value};

use crate::sequence::Pattern;

/// Tables of what is seen where there are no media, beside the camera.
const STILL: [&str; 2] = ["surface", "light"];

/// Keys that name files.
const FILES: [&str; 3] = ["file", "texture", "mesh"];

/// What `text` says of surfaces and lights, however it is laid out. A text that is no TOML says
/// nothing.
pub(super) fn still_tables(text: &str) -> String {
    let mut table = parsed(text);
    table.retain(|key, _| STILL.contains(&key));
    table.to_string()
}

/// The sequences of files that a scene names.
#[derive(Debug, Default)]
pub(super) struct Named {
    /// By their patterns, each once.
    pub(super) patterns: Vec<Pattern>,
    /// Whether surfaces or lights name any.
    pub(super) by_stills: bool,
}

/// The sequences of files that `text`, the scene file `path`, names.
pub(super) fn sequences(path: &Path, text: &str) -> Named {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut named = Named::default();
    for (key, value) in &parsed(text) {
        visit(value, &mut |name| {
            let file = folder.join(name);
            let Some(pattern) = Pattern::of(&file).filter(|_| !file.is_file()) else { return };
            named.by_stills |= STILL.contains(&key.as_str());
            if !named.patterns.contains(&pattern) {
                named.patterns.push(pattern);
            }
        });
    }
    named
}

/// Tells `found` every file name in `value`.
fn visit(value: &Value, found: &mut impl FnMut(&str)) {
    match value {
        Value::Array(items) => items.iter().for_each(|item| visit(item, found)),
        Value::Table(table) => {
            for (key, value) in table {
                match value.as_str().filter(|_| FILES.contains(&key.as_str())) {
                    Some(name) => found(name),
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
