//! Keys of transfer functions: what the values of a grid stand for, after interpolation.

use super::Without::{Default, Other};
use super::{Key, Kind, Table};
use crate::scene::reader::Range;

const GAMMAS: Range = Range::new(|g| (0.05..=20.0).contains(&g), "a number from 0.05 to 20");

pub(in crate::scene) const FROM: Key = Key::new(
    "from",
    Kind::Pair(Range::ANY),
    "",
    Default("[0.0, 1.0]"),
    "The values of the grid that are at 0 and at 1 of the ramp.",
);
pub(in crate::scene) const CLAMP: Key = Key::new(
    "clamp",
    Kind::Switch,
    "",
    Default("false"),
    "Whether values beyond those two are taken for them.",
);
pub(in crate::scene) const GAMMA: Key = Key::new(
    "gamma",
    Kind::Number(GAMMAS),
    "",
    Default("1.0"),
    "Exponent of the place on the ramp.",
);
pub(in crate::scene) const RAMP: Key = Key::new(
    "ramp",
    Kind::Table("stops [place, value] in ascending order"),
    "",
    Other("the value is its place"),
    "Piecewise-linear ramp, constant before the first and after the last stop; two stops at one place \
     make a jump. A value is a number, or a colour where colours are meant; for a temperature, kelvin \
     before kelvin_scale and kelvin_offset.",
);

pub(in crate::scene) const TRANSFER: Table =
    Table { what: "a transfer function", keys: &[&FROM, &CLAMP, &GAMMA, &RAMP] };
