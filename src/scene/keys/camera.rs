//! Keys of `[camera]`.

use super::Without::{Default, Needed, Other};
use super::{Key, Kind, Table};
use crate::scene::reader::Range;

const ANGLE: Range = Range::new(|x| x > 0.0 && x < 180.0, "an angle above 0 and below 180 degrees");

pub(in crate::scene) const TYPE: Key = Key::new(
    "type",
    Kind::Word(|| vec!["perspective", "orthographic", "latlong"]),
    "",
    Default("\"perspective\""),
    "Kind of camera.",
);
pub(in crate::scene) const POSITION: Key = Key::new(
    "position",
    Kind::Triple,
    "m",
    Needed("where the camera stands, [x, y, z] in metres"),
    "Where the camera stands.",
);
pub(in crate::scene) const TARGET: Key = Key::new(
    "target",
    Kind::Triple,
    "m",
    Needed("what the camera looks at, [x, y, z] in metres"),
    "What the camera looks at.",
);
pub(in crate::scene) const UP: Key = Key::new(
    "up",
    Kind::Direction,
    "",
    Default("[0.0, 1.0, 0.0]"),
    "What is upward in the picture; not parallel to the view.",
);
pub(in crate::scene) const FOV: Key = Key::new(
    "fov",
    Kind::Number(ANGLE),
    "degrees",
    Default("40.0"),
    "Full angle of view along the width.",
);
pub(in crate::scene) const APERTURE: Key = Key::new(
    "aperture",
    Kind::Number(Range::NOT_NEGATIVE),
    "m",
    Default("0.0"),
    "Diameter of the lens; 0 is a pinhole.",
);
pub(in crate::scene) const FOCUS: Key = Key::new(
    "focus",
    Kind::Number(Range::POSITIVE),
    "m",
    Other("that of the target"),
    "Distance of the plane in focus, along the view.",
);
pub(in crate::scene) const HEIGHT: Key = Key::new(
    "height",
    Kind::Number(Range::POSITIVE),
    "m",
    Needed("the height of the view in metres"),
    "Height of the view.",
);

pub(in crate::scene) const SHIFT: Key = Key::new(
    "shift",
    Kind::Pair(Range::ANY),
    "widths of the picture",
    Default("[0.0, 0.0]"),
    "How far the film is shifted rightward and upward in its plane, as with a shift lens: the axis of the view leaves the \
     middle of the picture, and upright lines stay upright.",
);
pub(in crate::scene) const CLIP: Key = Key::new(
    "clip",
    Kind::Pair(Range::NOT_NEGATIVE),
    "m",
    Other("no end"),
    "Nearest and farthest distance along the view that the camera sees, of a latlong camera from where it stands. \
     Surfaces and media outside are not in the picture, but they light and shade what is, and mirrors show them.",
);

pub(in crate::scene) const NEXT: Key = Key::new(
    "next",
    Kind::Table("{ position, target, up }"),
    "",
    Other("it stands still"),
    "The camera one frame later, where `[motion]` opens a shutter.",
);

pub(in crate::scene) const PERSPECTIVE: Table = Table {
    what: "a perspective camera",
    keys: &[&TYPE, &POSITION, &TARGET, &UP, &FOV, &APERTURE, &FOCUS, &SHIFT, &CLIP, &NEXT],
};
pub(in crate::scene) const ORTHOGRAPHIC: Table = Table {
    what: "an orthographic camera",
    keys: &[&TYPE, &POSITION, &TARGET, &UP, &HEIGHT, &SHIFT, &CLIP, &NEXT],
};
pub(in crate::scene) const LATLONG: Table =
    Table { what: "a latlong camera", keys: &[&TYPE, &POSITION, &TARGET, &UP, &CLIP, &NEXT] };

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
