//! Prims that inherit from themselves, which composition by the crate follows until its stack ends.

use std::io::Cursor;

use openusd::sdf::{AbstractData, Path, Value};
use openusd::{usda, usdc};

/// Fields by which prims inherit, as both formats name them.
const FIELDS: [&str; 2] = ["inheritPaths", "specializes"];

/// Checks the text layer `text`.
///
/// # Errors
/// Where a prim inherits from itself, from one above or from one below itself.
pub(super) fn check_text(text: &str) -> Result<(), String> {
    let has_arcs = ["inherits", "specializes"].iter().any(|word| text.contains(word));
    // What cannot be parsed is for the crate to tell.
    match has_arcs.then(|| usda::parse(text)) {
        Some(Ok(data)) => check(&data),
        _ => Ok(()),
    }
}

/// As [`check_text`], a binary layer of this table of `tokens`.
pub(super) fn check_binary(bytes: &[u8], tokens: &[u8]) -> Result<(), String> {
    let is_arc = |token: &[u8]| FIELDS.iter().any(|field| field.as_bytes() == token);
    let has_arcs = tokens.split(|byte| *byte == 0).any(is_arc);
    match has_arcs.then(|| usdc::CrateData::open(Cursor::new(bytes), true)) {
        Some(Ok(data)) => check(&data),
        _ => Ok(()),
    }
}

fn check(data: &dyn AbstractData) -> Result<(), String> {
    for prim in data.spec_paths() {
        for field in FIELDS {
            let Ok(Some(value)) = data.try_field(&prim, field) else { continue };
            let Value::PathListOp(targets) = value.as_ref() else { continue };
            let own = prim.strip_all_variant_selections();
            let is_own = |target: &&Path| {
                let target = target.strip_all_variant_selections();
                own.has_prefix(&target) || target.has_prefix(&own)
            };
            if let Some(target) = targets.iter().find(is_own) {
                return Err(format!(
                    "{prim} inherits from {target}, which is itself, or above or below it"
                ));
            }
        }
    }
    Ok(())
}
