//! Keys of `[[medium]]`.

use super::Without::{Default, Needed, Other};
pub(in crate::scene) use super::surface::GROUP;
use super::surface::{BOX_MAX, BOX_MIN, MOVES, ROTATE, SCALE, TRANSLATE};
use super::transfer::{CLAMP, FROM, GAMMA, RAMP};
use super::{Key, Kind, Table};
use crate::scene::reader::Range;

const MEAN_COSINE: Range = Range::new(|g| g > -1.0 && g < 1.0, "a number above -1 and below 1");
const DROPLET: Range =
    Range::new(|d| d > 0.0 && d <= 50.0, "a diameter above 0 and at most 50 micrometres");
const TO_ONE: Range = Range::new(|s| s > 0.0 && s <= 1.0, "a number above 0 and at most 1");
/// What an albedo may be.
pub(in crate::scene) const UNIT_ALBEDO: Range = Range::new(
    |a| (0.0..=1.0).contains(&a),
    "an albedo from 0 to 1 (below 0 is no part of the light, over 1 would create energy)",
);
/// Largest occurrence of a grid's name.
pub(in crate::scene) const MAX_INDEX: u64 = 65_535;

pub(in crate::scene) const NAME: Key = Key::new(
    "name",
    Kind::Text("a name"),
    "",
    Other("medium[i]"),
    "What messages and the pass cryptomatte call it; without one that calls it by its file.",
);
pub(in crate::scene) const FILE: Key = Key::new(
    "file",
    Kind::File("a VDB file"),
    "",
    Needed("a VDB file, or `region` for a homogeneous medium"),
    "The VDB file with the density.",
);
pub(in crate::scene) const GRID: Key = Key::new(
    "grid",
    Kind::Text("a grid's name"),
    "",
    Other("the file's density: by name, else the only fog volume"),
    "The grid with the density.",
);
pub(in crate::scene) const INDEX: Key = Key::new(
    "index",
    Kind::Whole(0, MAX_INDEX),
    "",
    Other("the first"),
    "Which of several grids of that name, from 0.",
);
pub(in crate::scene) const LEVEL_SET: Key = Key::new(
    "level_set",
    Kind::Word(|| vec!["fog"]),
    "",
    Other("level sets are refused"),
    "Turns a level set into a fog volume.",
);
pub(in crate::scene) const DENSITY: Key = Key::new(
    "density",
    Kind::Table("{ from, clamp, gamma, ramp }"),
    "",
    Other("the values of the grid"),
    "What the values of the grid are taken for as a density, after interpolation.",
);
pub(in crate::scene) const REGION_KEY: Key = Key::new(
    "region",
    Kind::Table(
        "\"everywhere\", { box = { min, max } }, { sphere = { center, radius } } or { mesh = \"closed.obj\" }",
    ),
    "",
    Other("the medium is that of `file`"),
    "Where a homogeneous medium of density 1 is.",
);
pub(in crate::scene) const SIGMA_T: Key = Key::new(
    "sigma_t",
    Kind::Splat(Range::NOT_NEGATIVE),
    "1/m",
    Default("1.0"),
    "Extinction coefficient for density 1.",
);
pub(in crate::scene) const ALBEDO: Key = Key::new(
    "albedo",
    Kind::Table("a colour or { grid = \"name\" }"),
    "",
    Default("0.9"),
    "Share of the extinction that scatters: a colour, or a grid of the file.",
);
pub(in crate::scene) const PHASE_KEY: Key = Key::new(
    "phase",
    Kind::Table("\"isotropic\", \"rayleigh\" or { type = \"henyey-greenstein\", g = 0.5 }"),
    "",
    Default("\"isotropic\""),
    "Phase function.",
);
pub(in crate::scene) const EMISSION: Key = Key::new(
    "emission",
    Kind::Table("{ grid, color, scale }, { temperature, kelvin_scale, ... } or { color, scale }"),
    "",
    Other("none"),
    "Light that the medium gives off.",
);

pub(in crate::scene) const VELOCITY: Key = Key::new(
    "velocity",
    Kind::Table("the name of a vector grid, [\"x\", \"y\", \"z\"] of three grids, or \"none\""),
    "",
    Other("the file's velocity: by name"),
    "The grid of velocities that moves all grids of the medium, where `[motion]` opens a shutter.",
);
pub(in crate::scene) const VELOCITY_UNIT: Key = Key::new(
    "velocity_unit",
    Kind::Word(|| vec!["m/s", "m/frame", "voxels/frame"]),
    "",
    Default("\"m/s\""),
    "What the velocities are given in; they are turned and scaled with the medium.",
);
pub(in crate::scene) const VELOCITY_SCALE: Key = Key::new(
    "velocity_scale",
    Kind::Number(Range::ANY),
    "",
    Default("1.0"),
    "Factor on the velocities.",
);

pub(in crate::scene) const MEDIUM: Table = Table {
    what: "a medium",
    keys: &[
        &NAME,
        &FILE,
        &REGION_KEY,
        &SIGMA_T,
        &ALBEDO,
        &PHASE_KEY,
        &EMISSION,
        &GROUP,
        &GRID,
        &INDEX,
        &LEVEL_SET,
        &DENSITY,
        &TRANSLATE,
        &ROTATE,
        &SCALE,
        &VELOCITY,
        &VELOCITY_UNIT,
        &VELOCITY_SCALE,
        &MOVES,
    ],
};

pub(in crate::scene) const BOX: Key = Key::new(
    "box",
    Kind::Table("{ min = [x, y, z], max = [x, y, z] }"),
    "",
    Other("another region"),
    "A box along the axes.",
);
pub(in crate::scene) const SPHERE: Key = Key::new(
    "sphere",
    Kind::Table("{ center = [x, y, z], radius = r }"),
    "",
    Other("another region"),
    "A ball.",
);
pub(in crate::scene) const MESH: Key = Key::new(
    "mesh",
    Kind::File("a closed mesh (.obj, .ply, .gltf, .glb)"),
    "",
    Other("another region"),
    "The inside of a closed mesh.",
);
pub(in crate::scene) const CENTER: Key =
    Key::new("center", Kind::Triple, "m", Default("[0.0, 0.0, 0.0]"), "Centre of the ball.");
pub(in crate::scene) const BALL_RADIUS: Key = Key::new(
    "radius",
    Kind::Number(Range::POSITIVE),
    "m",
    Needed("a radius in metres"),
    "Radius of the ball.",
);
pub(in crate::scene) const REGION: Table =
    Table { what: "a region", keys: &[&BOX, &SPHERE, &MESH] };
pub(in crate::scene) const REGION_BOX: Table = Table { what: "a box", keys: &[&BOX_MIN, &BOX_MAX] };
pub(in crate::scene) const REGION_SPHERE: Table =
    Table { what: "a sphere", keys: &[&CENTER, &BALL_RADIUS] };

pub(in crate::scene) const SIDE_FILE: Key = Key::new(
    "file",
    Kind::File("a VDB file"),
    "",
    Other("the medium's"),
    "The VDB file with the grid.",
);
pub(in crate::scene) const ALBEDO_GRID_NAME: Key = Key::new(
    "grid",
    Kind::Text("a grid's name"),
    "",
    Needed("the name of a grid"),
    "A grid of scalars or colours, clamped to [0, 1].",
);
pub(in crate::scene) const ALBEDO_SCALE: Key =
    Key::new("scale", Kind::Number(TO_ONE), "", Default("1.0"), "Factor on the grid.");
pub(in crate::scene) const ALBEDO_GRID: Table = Table {
    what: "an albedo grid",
    keys: &[&ALBEDO_GRID_NAME, &SIDE_FILE, &INDEX, &ALBEDO_SCALE, &FROM, &CLAMP, &GAMMA, &RAMP],
};

pub(in crate::scene) const PHASE_TYPE: Key = Key::new(
    "type",
    Kind::Word(|| vec!["isotropic", "rayleigh", "henyey-greenstein", "two-lobe", "fog"]),
    "",
    Needed("the kind of phase function"),
    "Kind of phase function.",
);
pub(in crate::scene) const G: Key = Key::new(
    "g",
    Kind::Number(MEAN_COSINE),
    "",
    Needed("a number above -1 and below 1"),
    "Mean cosine of the angle of scattering.",
);
pub(in crate::scene) const LOBES: Key = Key::new(
    "g",
    Kind::Pair(MEAN_COSINE),
    "",
    Needed("two mean cosines"),
    "Mean cosines of the two lobes.",
);
pub(in crate::scene) const WEIGHT: Key = Key::new(
    "weight",
    Kind::Number(Range::UNIT),
    "",
    Needed("the weight of the first lobe"),
    "Weight of the first lobe.",
);
pub(in crate::scene) const DIAMETER: Key = Key::new(
    "diameter",
    Kind::Number(DROPLET),
    "um",
    Needed("a diameter above 0 and at most 50 micrometres"),
    "Diameter of the droplets, in the fit to Mie scattering of Jendersie and d'Eon 2023.",
);
pub(in crate::scene) const PHASE: Table =
    Table { what: "this phase function", keys: &[&PHASE_TYPE] };
pub(in crate::scene) const HENYEY_GREENSTEIN: Table =
    Table { what: "this phase function", keys: &[&PHASE_TYPE, &G] };
pub(in crate::scene) const TWO_LOBE: Table =
    Table { what: "this phase function", keys: &[&PHASE_TYPE, &LOBES, &WEIGHT] };
pub(in crate::scene) const FOG: Table =
    Table { what: "this phase function", keys: &[&PHASE_TYPE, &DIAMETER] };

pub(in crate::scene) const EMISSION_GRID_NAME: Key = Key::new(
    "grid",
    Kind::Text("a grid's name"),
    "",
    Other("emission follows the density"),
    "The grid that the emission follows.",
);
pub(in crate::scene) const TEMPERATURE: Key = Key::new(
    "temperature",
    Kind::Text("a grid's name"),
    "",
    Other("nothing glows as a blackbody"),
    "The grid of temperatures of a blackbody.",
);
pub(in crate::scene) const COLOR: Key = Key::new(
    "color",
    Kind::Splat(Range::NOT_NEGATIVE),
    "W/(m³ sr)",
    Default("1.0"),
    "Emission coefficient for a value of 1.",
);
pub(in crate::scene) const KELVIN_SCALE: Key = Key::new(
    "kelvin_scale",
    Kind::Number(Range::POSITIVE),
    "K",
    Default("1.0"),
    "Kelvin for one unit of the grid.",
);
pub(in crate::scene) const KELVIN_OFFSET: Key = Key::new(
    "kelvin_offset",
    Kind::Number(Range::ANY),
    "K",
    Default("0.0"),
    "Kelvin where the grid is 0.",
);
pub(in crate::scene) const EMISSION_SCALE: Key = Key::new(
    "scale",
    Kind::Number(Range::NOT_NEGATIVE),
    "",
    Default("1.0"),
    "Factor on the emission.",
);
pub(in crate::scene) const EMISSION_DENSITY: Table =
    Table { what: "emission", keys: &[&EMISSION_GRID_NAME, &TEMPERATURE, &COLOR, &EMISSION_SCALE] };
pub(in crate::scene) const EMISSION_GRID: Table = Table {
    what: "emission",
    keys: &[
        &EMISSION_GRID_NAME,
        &SIDE_FILE,
        &INDEX,
        &COLOR,
        &EMISSION_SCALE,
        &FROM,
        &CLAMP,
        &GAMMA,
        &RAMP,
    ],
};
pub(in crate::scene) const EMISSION_TEMPERATURE: Table = Table {
    what: "emission by temperature",
    keys: &[
        &TEMPERATURE,
        &SIDE_FILE,
        &INDEX,
        &KELVIN_SCALE,
        &KELVIN_OFFSET,
        &EMISSION_SCALE,
        &FROM,
        &CLAMP,
        &GAMMA,
        &RAMP,
    ],
};
