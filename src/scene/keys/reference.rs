//! The scene reference, made from the tables of keys.

use std::fmt::Write as _;

use super::{Key, TABLES, Without};

/// What stands above the tables.
const HEAD: &str = "\
# Every key of a scene

A scene is a TOML file; [Writing a scene](scene.md) shows how one is built. `fogbow help scene` prints the same. A flag
in brackets overrides its key for one render, and `--set film.size=[640,360]` or `--set medium.0.albedo=0.8` any key. Lengths are in metres, y is up, and a path is relative to the scene file. A colour is a number (grey) or three
numbers, linear Rec.709.
";

/// Every key of a scene file, table by table, in Markdown.
pub fn reference() -> String {
    let mut out = String::from(HEAD);
    let mut last = "";
    for (name, variant, table) in TABLES {
        if *name != last {
            let _ = write!(out, "\n## `{name}`\n");
            last = name;
        }
        if !variant.is_empty() {
            let _ = write!(out, "\n{variant}:\n");
        }
        let _ = writeln!(out, "\n| key | takes | unit | without it | meaning |");
        let _ = writeln!(out, "| --- | --- | --- | --- | --- |");
        for key in table.keys {
            let _ = writeln!(out, "{}", row(key));
        }
    }
    out
}

fn row(key: &Key) -> String {
    let without = match key.without {
        Without::Needed(_) => "must be there".into(),
        Without::Default(value) => format!("`{value}`"),
        Without::Other(what) => escaped(what),
    };
    let flag = key.flag.map_or(String::new(), |flag| format!(" (`--{flag}`)"));
    format!(
        "| `{}`{flag} | {} | {} | {without} | {} |",
        key.name,
        escaped(&key.kind.right()),
        key.unit,
        escaped(key.doc)
    )
}

/// `text` as it stands in a cell of a table.
fn escaped(text: &str) -> String {
    text.replace('|', "\\|").replace('[', "\\[").replace(']', "\\]")
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::scene::keys::flagged;
    use crate::scene::reader::{Setting, checks};

    /// `RENEW_KEYS=1 cargo test --lib the_reference_is_that_of_the_keys` writes it anew.
    #[test]
    fn the_reference_is_that_of_the_keys() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/src/guide/keys.md");
        if std::env::var_os("RENEW_KEYS").is_some() {
            std::fs::write(path, reference()).unwrap();
        }
        let written = std::fs::read_to_string(path).unwrap();
        let command = "RENEW_KEYS=1 cargo test --lib the_reference_is_that_of_the_keys";
        assert!(written == reference(), "{path} is not that of the keys; renew it by `{command}`");
    }

    #[test]
    fn every_key_has_a_sentence_and_a_default_in_its_range() {
        for (name, _, table) in TABLES {
            let names: BTreeSet<_> = table.keys.iter().map(|key| key.name).collect();
            assert_eq!(names.len(), table.keys.len(), "{name}: a key stands twice");
            for key in table.keys {
                assert!(key.doc.ends_with('.') && key.doc.len() > 5, "{name} {}", key.name);
                if let Without::Default(value) = key.without {
                    assert!(checks(&key.kind, value), "{name} {} = {value}", key.name);
                }
            }
        }
    }

    #[test]
    fn flags_are_told_apart_and_take_what_their_keys_take() {
        let flags: Vec<_> = flagged().filter_map(|(_, key)| key.flag).collect();
        assert_eq!(flags.iter().collect::<BTreeSet<_>>().len(), flags.len());
        let key = |flag| flagged().find(|(_, key)| key.flag == Some(flag)).unwrap();
        let given = |flag, text| {
            let (table, key) = key(flag);
            Setting::from_flag(table, key, text).map(|setting| setting.parts().1.to_owned())
        };
        assert_eq!(given("size", "960x540").unwrap(), "[960, 540]");
        assert_eq!(given("weights", "1,.5").unwrap(), "[1.0, 0.5]");
        assert_eq!(given("radius", ".5").unwrap(), "0.5");
        assert_eq!(given("exposure", "auto").unwrap(), "\"auto\"");
        assert_eq!(given("exposure", "-1").unwrap(), "-1.0");
        assert_eq!(given("view-transform", "srgb").unwrap(), "\"srgb\"");
        for (flag, wrong) in [
            ("size", "9"),
            ("rays", "0"),
            ("rays", "2.5"),
            ("radius", "-1"),
            ("view-transform", "film"),
        ] {
            assert!(given(flag, wrong).unwrap_err().starts_with("give "), "{flag} {wrong}");
        }
    }
}
