//! Constants as the text of a source has them.

use std::ops::Range;

/// A constant as the sources have it.
#[derive(Debug, PartialEq)]
pub(super) struct Item {
    pub name: String,
    /// The text of its doc comment.
    pub doc: String,
    /// As it is written, of a declaration in a trait those of its implementations.
    pub value: Option<String>,
    /// Indices of its lines in the file.
    pub lines: Range<usize>,
}

/// What stands before the tests of a file.
fn before_tests(text: &str) -> &str {
    &text[..text.find("#[cfg(test)]\nmod ").unwrap_or(text.len())]
}

/// The first place in `text` outside of brackets and strings at which `wanted` stands.
fn outside(text: &str, wanted: char) -> Option<usize> {
    let (mut depth, mut is_string) = (0, false);
    for (at, c) in text.char_indices() {
        match c {
            '"' => is_string = !is_string,
            _ if is_string => (),
            _ if c == wanted && depth == 0 => return Some(at),
            '(' | '[' | '{' => depth += 1,
            ')' | ']' | '}' => depth -= 1,
            _ => (),
        }
    }
    None
}

/// The name of the constant that starts in `line`.
fn declared(line: &str) -> Option<&str> {
    let line = line.trim_start();
    let line = match line.strip_prefix("pub") {
        Some(rest) if rest.starts_with('(') => rest.split_once(") ")?.1,
        Some(rest) => rest.trim_start(),
        None => line,
    };
    let (name, _) = line.strip_prefix("const ")?.split_once(':')?;
    let is_name = name.chars().all(|c| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_');
    (is_name && name != "_").then_some(name)
}

/// A line of code without the comment at its end.
fn without_comment(line: &str) -> &str {
    if line.contains('"') { line } else { line.split("//").next().unwrap_or_default().trim_end() }
}

/// The constants of a file, without those of its tests.
pub(super) fn items(text: &str) -> Vec<Item> {
    let lines: Vec<&str> = before_tests(text).lines().collect();
    let (mut items, mut doc) = (Vec::<Item>::new(), Vec::new());
    for (start, line) in lines.iter().enumerate() {
        if let Some(said) = line.trim_start().strip_prefix("///") {
            doc.push(said.trim());
        } else if let Some(name) = declared(line) {
            let rest: Vec<&str> = lines[start..].iter().map(|line| without_comment(line)).collect();
            let rest = rest.join("\n");
            let statement = &rest[..outside(&rest, ';').expect("a constant ends")];
            let value = outside(statement, '=').map(|at| &statement[at + 1..]);
            let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
            items.push(Item {
                name: name.to_owned(),
                doc: doc.join("\n"),
                value: value.map(words),
                lines: start..start + statement.lines().count(),
            });
            doc.clear();
        } else if !line.trim_start().starts_with("#[") {
            doc.clear();
        }
    }
    items
}

/// A declaration of a trait stands for those of its implementations, which say no more than a value.
pub(super) fn with_implementations(mut items: Vec<Item>) -> Vec<Item> {
    let is_declared = |item: &Item| item.value.is_none();
    let names: Vec<String> =
        items.iter().filter(|i| is_declared(i)).map(|i| i.name.clone()).collect();
    for name in names {
        let implements = |item: &Item| item.name == name && item.doc.is_empty();
        let values: Vec<String> =
            items.iter().filter(|i| implements(i)).filter_map(|i| i.value.clone()).collect();
        items.retain(|item| !implements(item));
        for item in items.iter_mut().filter(|item| item.name == name && item.value.is_none()) {
            item.value = Some(values.join(" or "));
        }
    }
    items
}

#[test]
fn constants_are_found_with_what_they_say() {
    let text = "
/// Sides of tiles.
/// They are few.
#[allow(dead_code)]
pub(super) const SIDES: [u32; 2] = [
    8, // not = ;
    4,
];
const NAME: &str = \"a; b\";
const fn f() {}
trait Kind {
    /// Whether so.
    const SO: bool;
}
impl Kind for A {
    const SO: bool = true;
}
impl Kind for B {
    const SO: bool = false;
}
#[cfg(test)]
mod tests {
    const HIDDEN: u32 = 1;
}
";
    let found = with_implementations(items(text));
    let values: Vec<_> = found.iter().map(|i| (i.name.as_str(), i.value.as_deref())).collect();
    let sides = ("SIDES", Some("[ 8, 4, ]"));
    assert_eq!(values, [sides, ("NAME", Some("\"a; b\"")), ("SO", Some("true or false"))]);
    assert_eq!([found[0].doc.as_str(), &found[1].doc], ["Sides of tiles.\nThey are few.", ""]);
    assert_eq!(found[0].lines, 4..8);
}
