//! Numbered files: the frames of a sequence.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// The most frames that can be asked for at once.
const MAX_FRAMES: usize = 1_000_000;

/// The largest frame number, and the smallest with its sign turned.
const MAX_NUMBER: i64 = 1_000_000_000;

/// Parts of a frame in which times are counted.
const PARTS: i64 = 1_000_000;

/// Decimals of the number of a frame, at most.
const DECIMALS: usize = 6;

/// A time in frames, to a millionth: that of a frame, or one between two.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FrameTime {
    parts: i64,
}

impl FrameTime {
    /// The time nearest to `number`; `None` beyond all numbers of frames.
    pub fn nearest(number: f64) -> Option<Self> {
        let is_usual = number.abs() <= MAX_NUMBER as f64;
        is_usual.then(|| Self { parts: (number * PARTS as f64).round() as i64 })
    }

    /// The last frame that is not after it.
    pub const fn frame(self) -> i64 {
        self.parts.div_euclid(PARTS)
    }

    /// How long after that frame it is, in frames: from 0 to less than 1.
    pub fn fraction(self) -> f64 {
        self.parts.rem_euclid(PARTS) as f64 / PARTS as f64
    }

    /// Whether it is that of a frame.
    pub const fn is_whole(self) -> bool {
        self.parts % PARTS == 0
    }

    /// Whether it and `next` are those of two frames, one after the other.
    pub fn is_followed_by(self, next: Self) -> bool {
        self.is_whole() && next.parts - self.parts == PARTS
    }

    /// As a number.
    pub fn number(self) -> f64 {
        self.parts as f64 / PARTS as f64
    }

    /// In text, with at least `width` characters before the decimals. A sign counts as one, as in `printf`.
    fn padded(self, width: usize) -> String {
        let sign = if self.parts < 0 { "-" } else { "" };
        let [whole, rest] = [self.parts.abs() / PARTS, self.parts.abs() % PARTS];
        let digits = width.saturating_sub(sign.len());
        let decimals = format!(".{rest:0DECIMALS$}");
        let decimals = decimals.trim_end_matches('0').trim_end_matches('.');
        format!("{sign}{whole:0digits$}{decimals}")
    }
}

impl From<i64> for FrameTime {
    fn from(frame: i64) -> Self {
        Self { parts: frame.clamp(-MAX_NUMBER, MAX_NUMBER) * PARTS }
    }
}

impl std::fmt::Display for FrameTime {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.padded(0))
    }
}

impl FromStr for FrameTime {
    type Err = String;

    /// # Errors
    /// What would be right, where it is something else.
    fn from_str(text: &str) -> Result<Self, String> {
        let parsed = parsed(text).filter(|time| time.parts.abs() <= MAX_NUMBER * PARTS);
        parsed.ok_or_else(|| {
            format!("`{text}` is no frame; give 12, or 12.5 for a time between two frames")
        })
    }
}

/// The number that `text` is, of digits with at most so many decimals.
fn parsed(text: &str) -> Option<FrameTime> {
    let digits = text.strip_prefix('-').unwrap_or(text);
    let (whole, decimals) = digits.split_once('.').unwrap_or((digits, "0"));
    let plain = |part: &str| !part.is_empty() && part.bytes().all(|b| b.is_ascii_digit());
    if !plain(whole) || !plain(decimals) || decimals.len() > DECIMALS {
        return None;
    }
    let whole: i64 = whole.parse().ok().filter(|n| *n <= MAX_NUMBER)?;
    let rest: i64 = format!("{decimals:0<DECIMALS$}").parse().ok()?;
    let parts = whole * PARTS + rest;
    Some(FrameTime { parts: if text.starts_with('-') { -parts } else { parts } })
}

/// Times in frames in the order in which they were asked for, each once.
///
/// Parsed from parts with commas between, each a number (`5`), a range (`1-100`, `100-1`) or a
/// range with a step (`1-100x2`). Numbers may be negative (`-5--1`) and have decimals (`12-13x0.25`).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Frames(Vec<FrameTime>);

impl Frames {
    /// The times.
    pub fn times(&self) -> &[FrameTime] {
        &self.0
    }
}

impl FromStr for Frames {
    type Err = String;

    /// # Errors
    /// What would be right, where it is something else.
    fn from_str(text: &str) -> Result<Self, String> {
        let (mut times, mut known) = (Vec::new(), BTreeSet::new());
        for part in text.split(',') {
            let range = range(part.trim()).ok_or_else(|| {
                format!("`{part}` is no frame; give 5, 1-100, 1-100x2, 12-13x0.25 or 1,4,9-12")
            })?;
            for time in range {
                if known.insert(time) {
                    times.push(time);
                }
                if times.len() > MAX_FRAMES {
                    return Err(format!("give at most {MAX_FRAMES} frames"));
                }
            }
        }
        Ok(Self(times))
    }
}

/// The times of one part of a list of frames.
fn range(part: &str) -> Option<impl Iterator<Item = FrameTime>> {
    let (ends, step) = match part.split_once(['x', 'X']) {
        Some((ends, step)) => (ends, parsed(step).filter(|step| step.parts > 0)?.parts),
        None => (part, PARTS),
    };
    // The first character may be a sign, so that only a later one can stand between two numbers.
    let dash = ends.char_indices().skip(1).find(|(_, c)| *c == '-').map(|(at, _)| at);
    let time = |text: &str| text.parse().ok().map(|time: FrameTime| time.parts);
    let (first, last) = match dash {
        Some(at) => (time(&ends[..at])?, time(&ends[at + 1..])?),
        None => (time(ends)?, time(ends)?),
    };
    let signed = if first <= last { step } else { -step };
    Some((0..=(last - first).abs() / step).map(move |k| FrameTime { parts: first + k * signed }))
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

    /// The file of `time`, whose decimals follow behind as many digits as that of a frame has. A sign counts as a digit,
    /// as in `printf`.
    pub fn at(&self, time: FrameTime) -> PathBuf {
        let Self { before, width, after, .. } = self;
        self.folder.join(format!("{before}{}{after}", time.padded(*width)))
    }

    /// The file of `frame` where it may be there already: as [`at`](Self::at), or with the sign of
    /// a negative number before as many digits as others have, where only that one is there.
    pub fn existing(&self, frame: i64) -> PathBuf {
        let usual = self.at(frame.into());
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
        (path == self.at(number.into()) || path == self.beside_sign(number)).then_some(number)
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
            let frames: Vec<_> = numbers.iter().map(|number| FrameTime::from(*number)).collect();
            assert_eq!(text.parse::<Frames>().unwrap().times(), frames, "{text}");
        }
        let rows: [(&str, &[f64]); 5] = [
            ("1.5", &[1.5]),
            ("12-13x0.25", &[12.0, 12.25, 12.5, 12.75, 13.0]),
            ("1-0x0.4", &[1.0, 0.6, 0.2]),
            ("-0.5-0.5x.5", &[]),
            ("-0.5-0.75x0.5", &[-0.5, 0.0, 0.5]),
        ];
        for (text, numbers) in rows {
            let times: Vec<_> = numbers.iter().filter_map(|n| FrameTime::nearest(*n)).collect();
            let parsed = text.parse::<Frames>();
            assert_eq!(
                parsed.map_or(Vec::new(), |frames| frames.times().to_vec()),
                times,
                "{text}"
            );
        }
        let wrong =
            ["", "a", "1-", "-", "1-4x0", "1-4x", "1,,2", "1-2-3", "+1", "1e3", "9999999999"];
        for text in wrong.into_iter().chain(["1-1000000000", "--1", "1.", ".5", "1.0000001"]) {
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
            assert_eq!(pattern.at(FrameTime::from(frame)), Path::new(file), "{name}");
        }
        let pattern = Pattern::from_path(Path::new("a_####.exr")).unwrap();
        for (time, file) in
            [(12.25, "a_0012.25.exr"), (-0.5, "a_-000.5.exr"), (-1.75, "a_-001.75.exr")]
        {
            let time = FrameTime::nearest(time).unwrap();
            assert_eq!(pattern.at(time), Path::new(file));
            assert_eq!(time.to_string().parse(), Ok(time));
            assert_eq!(time.frame() as f64 + time.fraction(), time.number());
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
