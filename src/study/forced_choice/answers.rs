//! Answers of participants, as a CSV file.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::file;

/// Columns of a file of answers. The first five are needed, in any order.
pub const COLUMNS: [&str; 7] =
    ["participant", "scene", "condition", "gold", "chosen", "seconds", "time"];

/// Columns that a file must have.
const NEEDED: usize = 5;

/// The most bytes of a file of answers.
const MAX_BYTES: u64 = 64 << 20;

/// The most characters of a text in an answer.
const MAX_TEXT: usize = 200;

/// Participant, scene and condition of an answer.
pub type AnswerKey = (String, String, Condition);

/// How the pictures are shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Condition {
    /// One after the other, four seconds each with two seconds of grey between.
    Successive,
    /// The gold standard on top and both below it for eight seconds: which is the one on top?
    Reference,
}

/// Where, or when, a picture was shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Side {
    /// The first of two that follow each other.
    First,
    /// The second.
    Second,
    /// The left of two beside each other.
    Left,
    /// The right.
    Right,
}

/// One person's answer for one scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Answer {
    /// The participant's name or number.
    pub participant: String,
    /// The scene's name.
    pub scene: String,
    /// How it was shown.
    pub condition: Condition,
    /// Where the gold standard was.
    pub gold: Side,
    /// Which picture the participant took for the gold standard.
    pub chosen: Side,
    /// Seconds from the question to the answer.
    #[serde(default)]
    pub seconds: Option<f64>,
    /// Time of the answer by the browser's clock.
    #[serde(default)]
    pub time: String,
}

impl Condition {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Successive => "successive",
            Self::Reference => "reference",
        }
    }

    /// The two places that it has.
    fn sides(self) -> [Side; 2] {
        match self {
            Self::Successive => [Side::First, Side::Second],
            Self::Reference => [Side::Left, Side::Right],
        }
    }
}

impl Answer {
    /// Whether the gold standard was found.
    pub fn is_right(&self) -> bool {
        self.chosen == self.gold
    }

    /// Its key: a participant answers once for a scene in a condition.
    pub fn key(&self) -> AnswerKey {
        (self.participant.clone(), self.scene.clone(), self.condition)
    }

    /// Checks what its types do not ensure: texts, sides and seconds.
    ///
    /// # Errors
    /// Says what is wrong and what would be right.
    pub fn check(&self) -> Result<(), String> {
        for (name, text) in [("participant", &self.participant), ("scene", &self.scene)] {
            if text.trim().is_empty() {
                return Err(format!("{name} is empty; give a name"));
            }
        }
        for text in [&self.participant, &self.scene, &self.time] {
            if text.chars().count() > MAX_TEXT || text.chars().any(char::is_control) {
                return Err(format!("texts must be of at most {MAX_TEXT} printable characters"));
            }
        }
        let sides = self.condition.sides();
        if !sides.contains(&self.gold) || !sides.contains(&self.chosen) {
            let [a, b] = if self.condition == Condition::Successive {
                ["first", "second"]
            } else {
                ["left", "right"]
            };
            let name = self.condition.name();
            return Err(format!("in the condition {name} gold and chosen are {a} or {b}"));
        }
        if self.seconds.is_some_and(|s| !s.is_finite() || s < 0.0) {
            return Err("seconds must be a number of at least 0".into());
        }
        Ok(())
    }
}

/// The answers in all of `paths`, in their order.
///
/// # Errors
/// Where a file cannot be read, has no such columns or a line that is no answer, or somebody
/// answered twice for a scene in the same condition; the message names the line.
pub fn read_answers(paths: &[PathBuf]) -> Result<Vec<Answer>> {
    let mut answers = Vec::new();
    let mut places = HashMap::new();
    for path in paths {
        for (line, answer) in read_file(path)? {
            if let Some((other, first)) = places.insert(answer.key(), (path, line)) {
                let problem = format!(
                    "\"{}\" answered for \"{}\" already in line {first} of {}; keep one of them",
                    answer.participant,
                    answer.scene,
                    other.display()
                );
                return Err(at(path, line, &problem));
            }
            answers.push(answer);
        }
    }
    Ok(answers)
}

/// The answers of a file with their lines, from 1.
fn read_file(path: &Path) -> Result<Vec<(u64, Answer)>> {
    let bytes = file::read(path, MAX_BYTES)?;
    let bytes = bytes.strip_prefix("\u{feff}".as_bytes()).unwrap_or(&bytes);
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(bytes);
    let heads = reader.headers().map_err(|e| unreadable(path, &e))?.clone();
    if let Some(missing) = COLUMNS[..NEEDED].iter().find(|name| !heads.iter().any(|h| h == **name))
    {
        let problem = format!(
            "there is no column \"{missing}\"; the first line must be {}",
            COLUMNS[..NEEDED].join(",")
        );
        return Err(at(path, 1, &problem));
    }
    let mut answers = Vec::new();
    let mut record = csv::StringRecord::new();
    while reader.read_record(&mut record).map_err(|e| unreadable(path, &e))? {
        let line = record.position().map_or(0, csv::Position::line);
        let answer: Answer = record
            .deserialize(Some(&heads))
            .map_err(|e| at(path, line, &format!("is no answer: {}", cause(&e))))?;
        answer.check().map_err(|problem| at(path, line, &problem))?;
        answers.push((line, answer));
    }
    Ok(answers)
}

/// The problem of a line, without its number, which the message has already.
fn cause(error: &csv::Error) -> String {
    match error.kind() {
        csv::ErrorKind::Deserialize { err, .. } => err.kind().to_string(),
        _ => error.to_string(),
    }
}

fn unreadable(path: &Path, error: &csv::Error) -> Error {
    let line = error.position().map_or(1, csv::Position::line);
    let problem = match error.kind() {
        csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
            format!("has {len} fields, the first line has {expected_len}")
        }
        csv::ErrorKind::Utf8 { .. } => "is not UTF-8 text".into(),
        _ => error.to_string(),
    };
    at(path, line, &problem)
}

fn at(path: &Path, line: u64, problem: &str) -> Error {
    Error::file(path, format!("line {line}: {problem}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Vec<Answer>, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("answers.csv");
        std::fs::write(&path, text).unwrap();
        read_answers(&[path]).map_err(|e| e.to_string())
    }

    const HEAD: &str = "participant,scene,condition,gold,chosen\n";

    #[test]
    fn answers_are_read_with_more_columns_and_in_any_order() {
        let text = "chosen,note,gold,condition,scene,participant\n\
                    first,\"a, b\",first,successive,road,ann\nleft,,right,reference,road,bob\n";
        let answers = read(text).unwrap();
        assert!(answers[0].is_right() && !answers[1].is_right());
        assert_eq!((answers[1].condition, answers[1].seconds), (Condition::Reference, None));
        assert_eq!(read(HEAD).unwrap(), []);
    }

    #[test]
    fn problems_name_their_line() {
        let good = "ann,road,successive,first,second\n";
        for (text, says) in [
            (String::new(), "line 1: there is no column \"participant\""),
            ("a,b\n1,2\n".into(), "no column \"participant\""),
            (format!("{HEAD}{good}bob,road,successive,first\n"), "line 3: has 4 fields"),
            (
                format!("{HEAD}{good}bob,road,sideways,first,first\n"),
                "line 3: is no answer: unknown variant `sideways`",
            ),
            (format!("{HEAD}{good}bob,road,successive,first,left\n"), "line 3: in the condition"),
            (format!("{HEAD}{good},road,successive,first,first\n"), "line 3: participant is empty"),
            (
                format!("{HEAD}{good}{good}"),
                "line 3: \"ann\" answered for \"road\" already in line 2",
            ),
        ] {
            let message = read(&text).unwrap_err();
            assert!(message.contains(says) && !message.contains('\n'), "{message}");
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bytes.csv");
        std::fs::write(&path, [HEAD.as_bytes(), b"\xff\xfe,a,b,c,d\n"].concat()).unwrap();
        let message = read_answers(&[path]).unwrap_err().to_string();
        assert!(message.contains("line 2") && message.contains("UTF-8"), "{message}");
    }
}
