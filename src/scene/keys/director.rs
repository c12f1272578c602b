//! Keys of `[director]`.

use super::Without::{Default, Other};
use super::{Key, Kind, Table};
use crate::scene::directing::{Importance, MAX_COARSENING, Operator, RESOLUTIONS, names};
use crate::scene::reader::Range;
use crate::scene::settings::MAX_RAYS;

const COARSENING: Range =
    Range::new(|x| (1.0..=MAX_COARSENING).contains(&x), "a factor from 1 to 256");
const RATIO: Range = Range::new(|x| RESOLUTIONS.contains(&x), "a factor from 0.0625 (1/16) to 4");

pub(in crate::scene) const X: Key = Key::new(
    "x",
    Kind::Word(|| names(Importance::ALL)),
    "",
    Default("\"error\""),
    "What the X-map says: the error that the picture's first rays leave after reconstruction, how uncertain scattered light is, or the transmittance of Anson et al. 2006.",
)
.flag("x");
pub(in crate::scene) const WEIGHTS: Key = Key::new(
    "weights",
    Kind::Pair(Range::NOT_NEGATIVE),
    "",
    Other("[1, 0.5] with the operator \"tolerance\", else [0.5, 0.5]"),
    "Weights of X and S in the XS-map; with \"tolerance\" the power of X, and how much more error passes where S is 0.",
)
.flag("weights");
pub(in crate::scene) const OP: Key = Key::new(
    "op",
    Kind::Word(|| names(Operator::ALL)),
    "",
    Other("\"tolerance\" with the X \"error\", else \"+\""),
    "How X and S become one: the weighted sum, the product of powers, or X over the error that passes where S is low.",
)
.flag("op");
pub(in crate::scene) const DIRECTS: Key = Key::new(
    "directs",
    Kind::Text("some of rays, radius, step with commas between, or nothing"),
    "",
    Other("\"rays\" with the X \"error\", else \"rays,radius,step\""),
    "What the XS-map hands out.",
)
.flag("directs");
pub(in crate::scene) const FLOOR: Key = Key::new(
    "floor",
    Kind::Whole(1, MAX_RAYS as u64),
    "",
    Default("1"),
    "Rays of the least important pixel.",
)
.flag("floor");
pub(in crate::scene) const RADIUS: Key = Key::new(
    "radius",
    Kind::Number(COARSENING),
    "",
    Default("2.0"),
    "Gather radius of the least important pixel over that of the most important one.",
)
.flag("coarsest-radius");
pub(in crate::scene) const STEP: Key = Key::new(
    "step",
    Kind::Number(COARSENING),
    "voxels",
    Default("4.0"),
    "March step of the least important pixel.",
)
.flag("coarsest-step");
pub(in crate::scene) const TOLERANCE: Key = Key::new(
    "tolerance",
    Kind::Number(Range::POSITIVE),
    "",
    Default("0.05"),
    "Relative error of a pixel for which the director \"variance\" gives it rays.",
)
.flag("tolerance");
pub(in crate::scene) const RESOLUTION: Key = Key::new(
    "resolution",
    Kind::Number(RATIO),
    "",
    Default("1.0"),
    "Pixels of the maps over those of the film, along each side.",
)
.flag("resolution");

pub(in crate::scene) const DIRECTOR: Table = Table {
    what: "[director]",
    keys: &[&X, &WEIGHTS, &OP, &DIRECTS, &FLOOR, &RADIUS, &STEP, &TOLERANCE, &RESOLUTION],
};
