//! Figures that are marked in a Markdown text.
//!
//! A quoted figure stands between marks: `<!-- figure director.lucy.gain -->2.3<!-- / -->`. What is no
//! measurement, such as a setting, may be marked as `<!-- given -->5 %<!-- / -->`.

use std::collections::BTreeMap;

const OPEN: &str = "<!-- figure ";
const GIVEN: &str = "<!-- given -->";
const CLOSE: &str = "<!-- / -->";

/// What stands in the prose for what was taken out of it, lest its neighbours seem to be one.
const LEFT_OUT: &str = "·";

/// A text with its marked figures, and the rest of its prose.
pub struct MarkedText {
    /// Keys with what stands in the text.
    marked: Vec<(String, String)>,
    /// The text without marked figures, code and comments.
    prose: String,
}

impl MarkedText {
    /// Takes a Markdown text apart.
    ///
    /// # Errors
    /// Where a mark is not closed; names it.
    pub fn new(text: &str) -> Result<Self, String> {
        let mut marked = Vec::new();
        let mut prose = String::new();
        let mut rest = text;
        while let Some(at) = rest.find("<!-- ") {
            prose += &rest[..at];
            let mark = &rest[at..];
            let end = mark.find("-->").ok_or_else(|| format!("not closed: {}", line(mark)))? + 3;
            if !mark.starts_with(OPEN) && !mark.starts_with(GIVEN) {
                rest = &mark[end..];
                continue;
            }
            let close = mark.find(CLOSE).ok_or_else(|| format!("not closed: {}", line(mark)))?;
            if let Some(key) = mark[..end].strip_prefix(OPEN) {
                let key = key.trim_end_matches("-->").trim();
                marked.push((key.to_owned(), mark[end..close].to_owned()));
            }
            prose += LEFT_OUT;
            rest = &mark[close + CLOSE.len()..];
        }
        prose += rest;
        Ok(Self { marked, prose: without_code(&prose) })
    }

    /// What is wrong with the marked figures beside those `measured`.
    pub fn differing(&self, measured: &BTreeMap<String, String>) -> Vec<String> {
        let wrong = |(key, there): &(String, String)| match measured.get(key) {
            Some(figure) if figure == there => None,
            Some(figure) => Some(format!("{key} is {figure} and not {there}")),
            None => Some(format!("{key} was not measured")),
        };
        self.marked.iter().filter_map(wrong).collect()
    }

    /// Pieces of the prose that hold a figure of speed or error which is not marked: a number before
    /// "times", "%" or "CPU s", over the ends of lines too.
    pub fn unmarked(&self) -> Vec<String> {
        let words: Vec<&str> = self.prose.split_whitespace().collect();
        let tells = |&i: &usize| tells_a_measurement(&words[i..]);
        let around = |i: usize| words[i.saturating_sub(4)..(i + 5).min(words.len())].join(" ");
        (0..words.len()).filter(tells).map(around).collect()
    }
}

fn line(text: &str) -> &str {
    text.lines().next().unwrap_or_default()
}

/// The text without fenced blocks and code in lines.
fn without_code(text: &str) -> String {
    let mut out = String::new();
    let mut is_fenced = false;
    for line in text.lines() {
        if line.trim_start().starts_with("```") {
            is_fenced = !is_fenced;
        } else if !is_fenced && !line.starts_with("    ") {
            out += &line.split('`').step_by(2).collect::<Vec<_>>().join(LEFT_OUT);
        }
        out.push('\n');
    }
    out
}

/// Whether the first of `words` is such a number.
fn tells_a_measurement(words: &[&str]) -> bool {
    let bare = |i: usize| {
        let word = words.get(i).copied().unwrap_or_default();
        word.trim_matches(|c: char| !c.is_alphanumeric() && c != '%')
    };
    let is_number = |word: &str| {
        word.starts_with(|c: char| c.is_ascii_digit())
            && word.chars().all(|c| c.is_ascii_digit() || ".,".contains(c))
    };
    match bare(0).split_once('%') {
        Some((number, _)) => is_number(number),
        None if is_number(bare(0)) => {
            bare(1) == "times" || bare(1).starts_with('%') || bare(1) == "CPU" && bare(2) == "s"
        }
        None => false,
    }
}
