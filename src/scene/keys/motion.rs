//! Keys of `[motion]`, and of what moves.

use super::Without::{Default, Other};
use super::camera::{POSITION, TARGET, UP};
use super::surface::{ROTATE, TRANSLATE};
use super::{Key, Kind, Table};
use crate::scene::reader::Range;

/// Times of a shutter, at most: each is a scene in memory.
///
/// Unit: count. Limit: on memory.
const MOST_TIMES: u64 = 64;

const OPEN: Range =
    Range::new(|s| (0.0..=10.0).contains(&s), "a number of frames from 0 to 10; 0 is no blur");

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

pub(in crate::scene) const MOTION: Table =
    Table { what: "a shutter", keys: &[&SHUTTER, &SHUTTER_POSITION, &FPS, &TIMES] };

pub(in crate::scene) const MOVES: Key = Key::new(
    "motion",
    Kind::Table("{ translate, rotate }"),
    "",
    Other("it stands still"),
    "How far it is moved and turned in a frame, where `[motion]` opens a shutter.",
);
pub(in crate::scene) const NEXT_FILE: Key = Key::new(
    "next_file",
    Kind::File("a mesh (.obj, .ply, .gltf, .glb)"),
    "",
    Other("its vertices stand still"),
    "The mesh one frame later, with the same triangles; vertices move straight to their places there. `####` is the number of the next frame.",
);

/// What `motion` holds: a placement a frame.
pub(in crate::scene) const MOVES_TABLE: Table = Table {
    what: "a motion",
    keys: &[
        &Key { unit: "m", doc: "How far it moves in a frame.", ..TRANSLATE },
        &Key {
            doc: "How far it turns in a frame about x, y and z in this order, through the place to which its placement moves the origin.",
            ..ROTATE
        },
    ],
};

/// What `next` of a camera holds.
pub(in crate::scene) const NEXT_POSE: Table = Table {
    what: "the camera one frame later",
    keys: &[
        &Key {
            without: Other("that of the camera"),
            doc: "Where the camera stands one frame later; it moves there in a straight line.",
            ..POSITION
        },
        &Key {
            without: Other("that of the camera"),
            doc: "What the camera looks at one frame later; it turns there evenly.",
            ..TARGET
        },
        &Key {
            without: Other("that of the camera"),
            doc: "What is upward in the picture one frame later.",
            ..UP
        },
    ],
};
