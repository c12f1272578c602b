//! Keys of `[motion]`.

use super::Without::{Default, Other};
use super::{Key, Kind, Table};
use crate::scene::reader::Range;

/// Times of a shutter, at most: each is a scene in memory.
///
/// Unit: count. Limit: on memory.
const MOST_TIMES: u64 = 64;

const OPEN: Range =
    Range::new(|s| (0.0..=10.0).contains(&s), "a number of frames from 0 to 10; 0 is no blur");

const FRAMES: Range =
    Range::new(|n| n.abs() <= 1e9, "a number of a frame from -1e9 to 1e9, such as 12 or 12.5");

pub(in crate::scene) const SHUTTER: Key = Key::new(
    "shutter",
    Kind::Number(OPEN),
    "frames",
    Default("0.0"),
    "How long the shutter is open: 0.5 is an angle of 180 degrees, and with 0 nothing is blurred.",
);
pub(in crate::scene) const SHUTTER_POSITION: Key = Key::new(
    "position",
    Kind::Word(|| vec!["center", "start", "end"]),
    "",
    Default("\"center\""),
    "Where the time of the frame is: in the middle of what the shutter sees, at its start or at its end.",
);
pub(in crate::scene) const FPS: Key = Key::new(
    "fps",
    Kind::Number(Range::POSITIVE),
    "1/s",
    Default("24.0"),
    "Frames a second, for velocities in metres a second.",
);
pub(in crate::scene) const TIMES: Key = Key::new(
    "times",
    Kind::Whole(1, MOST_TIMES),
    "",
    Other("one for each pixel that anything moves, from 2 to 32"),
    "Equal parts of the shutter, each of which sees the scene as it is in its middle.",
);

pub(in crate::scene) const FRAME: Key = Key::new(
    "frame",
    Kind::Number(FRAMES),
    "",
    Other("that of `--frames` or `--frame`"),
    "The frame whose number stands for `####` in names of files; 12.5 is the time between two, at which velocities carry the smoke of both. \
     `--frames` and `--frame` stand over it.",
);

pub(in crate::scene) const MOTION: Table =
    Table { what: "a shutter", keys: &[&SHUTTER, &SHUTTER_POSITION, &FPS, &TIMES, &FRAME] };
