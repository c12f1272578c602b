//! Numbered files: the frames of a sequence.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// The most frames that can be asked for at once.
const MAX_FRAMES: usize = 1_000_000;

/// The largest frame number, and the smallest with its sign turned.
const MAX_NUMBER: i64 = 1_000_000_000;

/// Frame numbers in the order in which they were asked for, each once.
///
/// Parsed from parts with commas between, each a number (`5`), a range (`1-100`, `100-1`) or a
/// range with a step (`1-100x2`). Numbers may be negative: `-5--1`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Frames(Vec<i64>);

impl Frames {
    /// The numbers.
    pub fn numbers(&self) -> &[i64] {
        &self.0
    }
}

impl FromStr for Frames {
    type Err = String;

    /// # Errors
    /// What would be right, where it is something else.
    fn from_str(text: &str) -> Result<Self, String> {
        let (mut numbers, mut known) = (Vec::new(), BTreeSet::new());
        for part in text.split(',') {
            let range = range(part.trim()).ok_or_else(|| {
                format!("`{part}` is no frame; give 5, 1-100, 1-100x2 or 1,4,9-12")
            })?;
            for number in range {
                if known.insert(number) {
                    numbers.push(number);
                }
                if numbers.len() > MAX_FRAMES {
                    return Err(format!("give at most {MAX_FRAMES} frames"));
                }
            }
        }
        Ok(Self(numbers))
    }
}

/// The numbers of one part of a list of frames.
fn range(part: &str) -> Option<Box<dyn Iterator<Item = i64>>> {
    let (ends, step) = match part.split_once(['x', 'X']) {
        Some((ends, step)) => (ends, step.parse().ok().filter(|step| *step > 0)?),
        None => (part, 1_usize),
    };
    // The first character may be a sign, so that only a later one can stand between two numbers.
    let dash = ends.char_indices().skip(1).find(|(_, c)| *c == '-').map(|(at, _)| at);
    let number = |text: &str| {
        let digits = text.strip_prefix('-').unwrap_or(text);
        let plain = !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit());
        text.parse().ok().filter(|n: &i64| plain && n.abs() <= MAX_NUMBER)
    };
    let (first, last) = match dash {
        Some(at) => (number(&ends[..at])?, number(&ends[at + 1..])?),
        None => (number(ends)?, number(ends)?),
    };
    Some(if first <= last {
        Box::new((first..=last).step_by(step))
    } else {
        Box::new((last..=first).rev().step_by(step))
    })
}

/// A file name with a place for the frame's number: `smoke_####.vdb`, padded with zeros to as many
/// digits as there are `#`, or `smoke_%04d.vdb` and `smoke_%d.vdb` as in C's `printf`. Where several
/// such places stand in the name of the file, the last one counts; folders are taken as they are.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pattern {
    folder: PathBuf,
    before: String,
    width: usize,
    after: String,
}

impl Pattern {
    /// The pattern that `path` is, if it is one.
    pub fn from_path(path: &Path) -> Option<Self> {
        let name = path.file_name()?.to_str()?;
        let (start, end, width) = hashes(name).max(printf(name))?;
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        Some(Self { folder, before: name[..start].into(), width, after: name[end..].into() })
    }

    /// The file of `frame`. A sign counts as a digit, as in `printf`.
    pub fn at(&self, frame: i64) -> PathBuf {
        let Self { before, width, after, .. } = self;
        self.folder.join(format!("{before}{frame:0width$}{after}"))
    }

    /// The file of `frame` where it may be there already: as [`at`](Self::at), or with the sign of
    /// a negative number before as many digits as others have, where only that one is there.
    pub fn existing(&self, frame: i64) -> PathBuf {
        let usual = self.at(frame);
        if frame >= 0 || usual.is_file() {
            return usual;
        }
        let other = self.beside_sign(frame);
        if other.is_file() { other } else { usual }
    }

    /// The numbers of all files that are there, from the smallest.
    pub fn numbers(&self) -> Vec<i64> {
        let here = Path::new(".");
        let folder = if self.folder.as_os_str().is_empty() { here } else { &self.folder };
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let numbers: BTreeSet<i64> =
            entries.filter_map(|entry| self.number(entry.file_name().to_str()?)).collect();
        numbers.into_iter().filter(|n| self.existing(*n).is_file()).collect()
    }

    /// The number in the name of a file of the sequence.
    fn number(&self, name: &str) -> Option<i64> {
        let middle = name.strip_prefix(&self.before)?.strip_suffix(&self.after)?;
        let number: i64 = middle.parse().ok().filter(|n: &i64| n.abs() <= MAX_NUMBER)?;
        let path = self.folder.join(name);
        (path == self.at(number) || path == self.beside_sign(number)).then_some(number)
    }

    fn beside_sign(&self, frame: i64) -> PathBuf {
        let Self { before, width, after, .. } = self;
        let sign = if frame < 0 { "-" } else { "" };
        self.folder.join(format!("{before}{sign}{:0width$}{after}", frame.unsigned_abs()))
    }
}

/// The last run of `#` in `name`: where it begins and ends, and how many there are.
fn hashes(name: &str) -> Option<(usize, usize, usize)> {
    let end = name.rfind('#')? + 1;
    let start = name[..end].trim_end_matches('#').len();
    Some((start, end, end - start))
}

/// The last `%d` or `%04d` in `name`: where it begins and ends, and the width.
fn printf(name: &str) -> Option<(usize, usize, usize)> {
    name.rmatch_indices('%').find_map(|(start, _)| {
        let (digits, _) = name[start + 1..].split_once('d')?;
        let width = match digits {
            "" => 0,
            _ => digits.strip_prefix('0')?.parse().ok().filter(|width| *width <= 32)?,
        };
        Some((start, start + 1 + digits.len() + 1, width))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_of_frames() {
        let rows: [(&str, &[i64]); 9] = [
            ("5", &[5]),
            ("1-4", &[1, 2, 3, 4]),
            ("1-6x2", &[1, 3, 5]),
            ("1,4,9-12", &[1, 4, 9, 10, 11, 12]),
            ("4-1", &[4, 3, 2, 1]),
            ("-2-1", &[-2, -1, 0, 1]),
            ("-3--1", &[-3, -2, -1]),
            ("-7", &[-7]),
            ("2, 1-3, 2", &[2, 1, 3]),
        ];
        for (text, numbers) in rows {
            assert_eq!(text.parse::<Frames>().unwrap().numbers(), numbers, "{text}");
        }
        let wrong =
            ["", "a", "1-", "-", "1-4x0", "1-4x", "1,,2", "1-2-3", "+1", "1e3", "9999999999"];
        for text in wrong.into_iter().chain(["1-1000000000", "--1", "1.5"]) {
            assert!(text.parse::<Frames>().is_err(), "{text}");
        }
    }

    #[test]
    fn places_for_numbers() {
        let rows = [
            ("smoke_####.vdb", 7, "smoke_0007.vdb"),
            ("smoke_####.vdb", 12345, "smoke_12345.vdb"),
            ("smoke_####.vdb", -7, "smoke_-007.vdb"),
            ("smoke_#.vdb", 12, "smoke_12.vdb"),
            ("smoke_%04d.vdb", 7, "smoke_0007.vdb"),
            ("smoke_%d.vdb", 7, "smoke_7.vdb"),
            ("a/v##_####.vdb", 7, "a/v##_0007.vdb"),
            ("c#/100%d_%02d.vdb", 7, "c#/100%d_07.vdb"),
        ];
        for (name, frame, file) in rows {
            let pattern = Pattern::from_path(Path::new(name)).unwrap();
            assert_eq!(pattern.at(frame), Path::new(file), "{name}");
        }
        for name in ["smoke.vdb", "c#/smoke.vdb", "100%.vdb", "%4d.vdb", "%x.vdb", ""] {
            assert_eq!(Pattern::from_path(Path::new(name)), None, "{name}");
        }
    }

    #[test]
    fn numbers_of_the_files_that_are_there() {
        let folder = tempfile::tempdir().unwrap();
        let files = ["s_0010.vdb", "s_0009.vdb", "s_-001.vdb", "s_-0002.vdb", "s_00011.vdb"];
        for name in files.iter().chain(&["s_12345.vdb", "s_3.vdb", "s_+004.vdb", "t_0001.vdb"]) {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        let pattern = Pattern::from_path(&folder.path().join("s_####.vdb")).unwrap();
        assert_eq!(pattern.numbers(), [-2, -1, 9, 10, 12345]);
        assert_eq!(pattern.existing(-2), folder.path().join("s_-0002.vdb"));
        assert_eq!(pattern.existing(-1), folder.path().join("s_-001.vdb"));
        assert_eq!(pattern.existing(-3), folder.path().join("s_-003.vdb"));
    }
}
