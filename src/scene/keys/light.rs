//! Keys of `[[light]]`.

use super::Without::{Default, Needed, Other};
pub(in crate::scene) use super::surface::{GROUP, VISIBLE};
use super::surface::{U, V};
use super::{Key, Kind, Table};
use crate::scene::reader::Range;

const HALF_ANGLE: Range =
    Range::new(|a| a > 0.0 && a <= 180.0, "an angle above 0 and at most 180 degrees");
const DISK: Range =
    Range::new(|a| (0.0..180.0).contains(&a), "an angle from 0 to below 180 degrees");
/// What the elevation of a stop may be.
pub(in crate::scene) const ELEVATION: Range =
    Range::new(|e| (-90.0..=90.0).contains(&e), "an elevation from -90 to 90 degrees");
const POWER_OF_COSINE: Range =
    Range::new(|e| (0.0..=1e6).contains(&e), "a number from 0 to 1000000");

pub(in crate::scene) const TYPE: Key = Key::new(
    "type",
    Kind::Word(|| vec!["point", "spot", "sun", "area", "environment"]),
    "",
    Needed("\"point\", \"spot\", \"sun\", \"area\" or \"environment\""),
    "Kind of light.",
);
pub(in crate::scene) const POSITION: Key =
    Key::new("position", Kind::Triple, "m", Needed("[x, y, z] in metres"), "Where the light is.");
pub(in crate::scene) const INTENSITY: Key = Key::new(
    "intensity",
    Kind::Splat(Range::NOT_NEGATIVE),
    "W/sr",
    Needed("a colour in W/sr, or `power` in W"),
    "Intensity; of a spot along its axis.",
);
pub(in crate::scene) const POWER: Key = Key::new(
    "power",
    Kind::Splat(Range::NOT_NEGATIVE),
    "W",
    Other("`intensity` says how strong it is"),
    "All of the light.",
);
pub(in crate::scene) const TARGET: Key = Key::new(
    "target",
    Kind::Triple,
    "m",
    Needed("a point to shine at, or `direction`"),
    "A point to shine at.",
);
pub(in crate::scene) const DIRECTION: Key = Key::new(
    "direction",
    Kind::Direction,
    "",
    Other("`target` says where it shines"),
    "Where it shines.",
);
pub(in crate::scene) const ANGLE: Key = Key::new(
    "angle",
    Kind::Number(HALF_ANGLE),
    "degrees",
    Default("30.0"),
    "Half angle of the cone.",
);
pub(in crate::scene) const FALLOFF: Key = Key::new(
    "falloff",
    Kind::Number(Range::NOT_NEGATIVE),
    "degrees",
    Default("0.0"),
    "Outermost part of the half angle over which the light fades smoothly.",
);
pub(in crate::scene) const EXPONENT: Key = Key::new(
    "exponent",
    Kind::Number(POWER_OF_COSINE),
    "",
    Other("`falloff` says how it fades"),
    "Power of the cosine from the axis by which the light fades.",
);
pub(in crate::scene) const BEAM: Key = Key::new(
    "texture",
    Kind::File("a picture file"),
    "",
    Other("an even beam"),
    "A picture in the beam.",
);
pub(in crate::scene) const TRAVEL: Key = Key::new(
    "direction",
    Kind::Direction,
    "",
    Needed("the direction the light travels"),
    "Direction in which the light travels.",
);
pub(in crate::scene) const IRRADIANCE: Key = Key::new(
    "irradiance",
    Kind::Splat(Range::NOT_NEGATIVE),
    "W/m²",
    Needed("a colour in W/m²"),
    "Irradiance of a plane square to the light.",
);
pub(in crate::scene) const DIAMETER: Key = Key::new(
    "angle",
    Kind::Number(DISK),
    "degrees",
    Default("0.533"),
    "Angular diameter; that of the sun seen from the earth by default.",
);
pub(in crate::scene) const CENTER: Key =
    Key::new("center", Kind::Triple, "m", Needed("[x, y, z] in metres"), "Centre of the quad.");
pub(in crate::scene) const RADIANCE: Key = Key::new(
    "radiance",
    Kind::Splat(Range::NOT_NEGATIVE),
    "W/(m² sr)",
    Needed("a colour in W/(m² sr)"),
    "Radiance; the quad shines along u x v.",
);
pub(in crate::scene) const SKY_RADIANCE: Key = Key::new(
    "radiance",
    Kind::Splat(Range::NOT_NEGATIVE),
    "W/(m² sr)",
    Needed("a colour in W/(m² sr), `texture` or `gradient`"),
    "Radiance from all directions.",
);
pub(in crate::scene) const GRADIENT: Key = Key::new(
    "gradient",
    Kind::Table("at least two stops [elevation, colour], going upward"),
    "degrees, W/(m² sr)",
    Other("`radiance` or `texture`"),
    "Radiance by elevation above the horizon: stops, linear in the sine of the elevation between them.",
);
pub(in crate::scene) const SKY: Key = Key::new(
    "texture",
    Kind::File("a latitude-longitude EXR, HDR, TIFF, PNG or JPEG"),
    "",
    Other("an even sky"),
    "A latitude-longitude picture.",
);
pub(in crate::scene) const SKY_SCALE: Key = Key::new(
    "scale",
    Kind::Number(Range::NOT_NEGATIVE),
    "",
    Default("1.0"),
    "Factor on the radiance.",
);
pub(in crate::scene) const SKY_ROTATE: Key = Key::new(
    "rotate",
    Kind::Number(Range::ANY),
    "degrees",
    Default("0.0"),
    "Turn of the picture about the y axis.",
);
pub(in crate::scene) const UNSEEN: Key = Key::new(
    "visible",
    Kind::Switch,
    "",
    Default("true"),
    "Whether rays from the camera see it; a light without extent they never do.",
);

pub(in crate::scene) const POINT: Table =
    Table { what: "a point light", keys: &[&TYPE, &POSITION, &INTENSITY, &POWER, &GROUP, &UNSEEN] };
pub(in crate::scene) const SPOT: Table = Table {
    what: "a spot light",
    keys: &[
        &TYPE, &POSITION, &TARGET, &DIRECTION, &INTENSITY, &POWER, &ANGLE, &FALLOFF, &EXPONENT,
        &BEAM, &GROUP, &UNSEEN,
    ],
};
pub(in crate::scene) const SUN: Table =
    Table { what: "a sun", keys: &[&TYPE, &TRAVEL, &IRRADIANCE, &DIAMETER, &GROUP, &VISIBLE] };
pub(in crate::scene) const AREA: Table =
    Table { what: "an area light", keys: &[&TYPE, &CENTER, &U, &V, &RADIANCE, &GROUP, &VISIBLE] };
pub(in crate::scene) const ENVIRONMENT: Table = Table {
    what: "an environment",
    keys: &[&TYPE, &SKY_RADIANCE, &GRADIENT, &SKY, &SKY_SCALE, &SKY_ROTATE, &GROUP, &VISIBLE],
};
