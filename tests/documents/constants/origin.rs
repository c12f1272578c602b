//! What the doc comment of a constant says: meaning, unit and where the value comes from.

use std::fs;
use std::path::Path;

use crate::pages::PAGES;

/// Units that constants have.
const UNITS: [&str; 7] = ["none", "count", "m", "rad", "cd/m²", "pixels", "bytes"];

/// Where values come from, as the table says it.
pub(super) const KINDS: [(&str, &str); 5] = [
    ("Definition", "a format, an identity, an index or the size of something"),
    ("Limit", "a guard against work or memory without end, or against overflow"),
    ("Source", "a publication"),
    ("Derivation", "it follows from what is named"),
    ("Bench", "the measurement or test that shows what it costs and brings"),
];

const BENCH: &str = "cargo bench --bench results -- --only ";

/// What a doc comment says.
pub(super) struct Origin {
    pub meaning: String,
    pub unit: String,
    pub kind: &'static str,
    /// What of that kind.
    pub text: String,
}

/// A text without links to other items.
fn unlinked(text: &str) -> String {
    let mut pieces = text.split("[`");
    let mut made = pieces.next().unwrap_or_default().to_owned();
    for piece in pieces {
        let (name, rest) = piece.split_once("`]").unwrap_or((piece, ""));
        let target = rest.strip_prefix('(').and_then(|rest| rest.split_once(')'));
        made += &format!("`{name}`{}", target.map_or(rest, |(_, rest)| rest));
    }
    made
}

/// The first sentence of a text.
fn first_sentence(text: &str) -> &str {
    let ends = text.match_indices(". ").map(|(at, _)| at);
    let mut ends = ends.filter(|at| text[at + 2..].starts_with(|c: char| c.is_uppercase()));
    ends.next().map_or(text, |at| &text[..=at])
}

/// What `doc` says, or what it lacks.
pub(super) fn origin(doc: &str) -> Result<Origin, String> {
    let paragraphs: Vec<String> =
        doc.split("\n\n").map(|p| unlinked(&p.replace('\n', " "))).collect();
    let last = paragraphs.last().and_then(|p| p.strip_prefix("Unit: "));
    let last = last.ok_or("its comment does not end with `Unit: UNIT. KIND: what of it.`")?;
    let (unit, rest) = last.split_once(". ").ok_or("no origin follows the unit")?;
    if !UNITS.contains(&unit) {
        return Err(format!("`{unit}` is none of the units {UNITS:?}"));
    }
    let (kind, text) = rest.split_once(": ").unwrap_or((rest, ""));
    let Some((kind, _)) = KINDS.iter().find(|(known, _)| *known == kind) else {
        return Err(format!("`{kind}` is none of the origins {:?}", KINDS.map(|(kind, _)| kind)));
    };
    if text.is_empty() || !text.ends_with('.') {
        return Err(format!("`{kind}` wants a sentence"));
    }
    if *kind == "Bench" {
        check_measured(text)?;
    }
    let meaning = first_sentence(&paragraphs[0]).to_owned();
    if paragraphs.len() < 2 || meaning.is_empty() {
        return Err("its meaning is missing".to_owned());
    }
    Ok(Origin { meaning, unit: unit.to_owned(), kind, text: text.to_owned() })
}

/// Whether `text` names a measurement of the results, or a file with a test by its name.
fn check_measured(text: &str) -> Result<(), String> {
    let spans: Vec<&str> = text.split('`').skip(1).step_by(2).collect();
    if let Some(name) = spans.iter().find_map(|span| span.strip_prefix(BENCH)) {
        let known = PAGES.iter().any(|page| page.name == name);
        return if known { Ok(()) } else { Err(format!("there is no measurement `{name}`")) };
    }
    let [test, file] = spans[..] else {
        return Err(format!("`{text}` names neither `{BENCH}NAME` nor `test` of `file`"));
    };
    let there =
        fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(file)).unwrap_or_default();
    let found = there.contains(&format!("fn {test}("));
    if found { Ok(()) } else { Err(format!("{file} has no test {test}")) }
}

#[test]
fn comments_say_meaning_unit_and_origin() {
    let doc = "Sides of [`TILE`]s. They\nare few.\n\nUnit: pixels. Derivation: from [`this`](Self::this)\nand that.";
    let Origin { meaning, unit, kind, text } = origin(doc).unwrap();
    assert_eq!(
        [meaning, unit, kind.to_owned(), text],
        ["Sides of `TILE`s.", "pixels", "Derivation", "from `this` and that."]
    );
}

#[test]
fn an_origin_that_says_too_little_is_told() {
    let wrong = |last: &str| origin(&format!("Meaning.\n\n{last}")).err().unwrap_or_default();
    for (last, told) in [
        ("Unit: none. Source: Itti et al. 1998.", ""),
        ("Unit: m. Bench: `cargo bench --bench results -- --only verify`.", ""),
        (
            "Unit: m. Bench: `few_constants_are_chosen_by_measuring` of `tests/documents/constants/mod.rs`.",
            "",
        ),
        ("Source: Itti et al. 1998.", "its comment does not end"),
        ("Unit: furlongs. Source: Itti et al. 1998.", "`furlongs` is none of the units"),
        ("Unit: none. Taste: mine.", "`Taste` is none of the origins"),
        ("Unit: none. Limit:", "`Limit:` is none of the origins"),
        ("Unit: none. Limit: ", "`Limit` wants a sentence"),
        (
            "Unit: m. Bench: `cargo bench --bench results -- --only taste`.",
            "there is no measurement",
        ),
        ("Unit: m. Bench: `some_test` of `tests/documents/constants/mod.rs`.", "has no test"),
        ("Unit: m. Bench: by eye.", "names neither"),
    ] {
        assert!(
            wrong(last).contains(told) && wrong(last).is_empty() == told.is_empty(),
            "{last}: {}",
            wrong(last)
        );
    }
}
