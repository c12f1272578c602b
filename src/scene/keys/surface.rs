//! Keys of `[[surface]]`.

use super::Without::{Default, Needed, Other};
use super::{Key, Kind, Table};
use crate::scene::groups::GroupName;
use crate::scene::reader::Range;

const REFRACTION: Range =
    Range::new(|n| (1.0..=10.0).contains(&n), "an index of refraction from 1 to 10");

/// The least roughness: below it a surface is a mirror, and lamps would show as dots of noise.
///
/// Unit: none. Limit: on the density of sampled directions.
pub(in crate::scene) const LEAST_ROUGHNESS: f64 = 0.03;
const ROUGH: Range = Range::new(
    |n| (LEAST_ROUGHNESS..=1.0).contains(&n),
    "a roughness from 0.03 to 1; a mirror has 0",
);
const COAT: Range =
    Range::new(|n| (1.01..=10.0).contains(&n), "an index of refraction from 1.01 to 10");

pub(in crate::scene) const TRANSLATE: Key =
    Key::new("translate", Kind::Triple, "m", Default("[0.0, 0.0, 0.0]"), "Placement: moved last.");
pub(in crate::scene) const ROTATE: Key = Key::new(
    "rotate",
    Kind::Triple,
    "degrees",
    Default("[0.0, 0.0, 0.0]"),
    "Placement: turned about x, y and z in this order, after scaling.",
);
pub(in crate::scene) const SCALE: Key =
    Key::new("scale", Kind::Splat(Range::NOT_ZERO), "", Default("1.0"), "Placement: scaled first.");

pub(in crate::scene) const NAME: Key = Key::new(
    "name",
    Kind::Text("a name"),
    "",
    Other("that of its file or its shape"),
    "What the pass cryptomatte calls it; surfaces of the same name are one object.",
);
pub(in crate::scene) const SHAPE: Key = Key::new(
    "shape",
    Kind::Word(|| vec!["sphere", "quad", "box", "plane", "mesh"]),
    "",
    Needed("\"sphere\", \"quad\", \"box\", \"plane\" or \"mesh\""),
    "Kind of shape.",
);
pub(in crate::scene) const CENTER: Key =
    Key::new("center", Kind::Triple, "m", Default("[0.0, 0.0, 0.0]"), "Centre.");
pub(in crate::scene) const RADIUS: Key =
    Key::new("radius", Kind::Number(Range::POSITIVE), "m", Needed("a radius in metres"), "Radius.");
pub(in crate::scene) const U: Key = Key::new(
    "u",
    Kind::Direction,
    "m",
    Needed("half of one side, [x, y, z] in metres"),
    "Half of one side.",
);
pub(in crate::scene) const V: Key = Key::new(
    "v",
    Kind::Direction,
    "m",
    Needed("half of the other side, [x, y, z] in metres"),
    "Half of the other side.",
);
pub(in crate::scene) const BOX_MIN: Key = Key::new(
    "min",
    Kind::Triple,
    "m",
    Needed("the smallest corner, [x, y, z]"),
    "Smallest corner.",
);
pub(in crate::scene) const BOX_MAX: Key =
    Key::new("max", Kind::Triple, "m", Needed("the largest corner, [x, y, z]"), "Largest corner.");
pub(in crate::scene) const POINT: Key =
    Key::new("point", Kind::Triple, "m", Default("[0.0, 0.0, 0.0]"), "A point on the plane.");
pub(in crate::scene) const NORMAL: Key =
    Key::new("normal", Kind::Direction, "", Default("[0.0, 1.0, 0.0]"), "Normal of the plane.");
pub(in crate::scene) const MESH_FILE: Key = Key::new(
    "file",
    Kind::File("a mesh (.obj, .ply, .gltf, .glb)"),
    "",
    Needed("a mesh (.obj, .ply, .gltf, .glb)"),
    "The mesh.",
);
pub(in crate::scene) const MATERIAL: Key = Key::new(
    "material",
    Kind::Table("{ type = \"diffuse\", reflectance = 0.5 }"),
    "",
    Other("a mesh has its own; else diffuse, 0.5"),
    "What it does with light.",
);
pub(in crate::scene) const EMISSION: Key = Key::new(
    "emission",
    Kind::Splat(Range::NOT_NEGATIVE),
    "W/(m² sr)",
    Other("none"),
    "Radiance that a quad or a mesh gives off.",
);
pub(in crate::scene) const VISIBLE: Key = Key::new(
    "visible",
    Kind::Switch,
    "",
    Default("true"),
    "Whether rays from the camera see it; where they don't, light, shadows and mirrors still meet it.",
);
pub(in crate::scene) const GROUP: Key = Key::new(
    "group",
    Kind::Text(GroupName::RIGHT),
    "",
    Other("the group rest"),
    "The group that its light belongs to, for the pass groups; a scene has at most 8, with the group rest.",
);
pub(in crate::scene) const HOLDOUT: Key = Key::new(
    "holdout",
    Kind::Switch,
    "",
    Default("false"),
    "Whether the camera sees a hole in the picture there, with nothing behind it.",
);
pub(in crate::scene) const SHADOW_CATCHER: Key = Key::new(
    "shadow_catcher",
    Kind::Switch,
    "",
    Default("false"),
    "Whether the camera sees only shadows and indirect light on it; a diffuse surface without emission.",
);

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

pub(in crate::scene) const SPHERE: Table = Table {
    what: "a sphere",
    keys: &[
        &SHAPE,
        &NAME,
        &CENTER,
        &RADIUS,
        &MATERIAL,
        &EMISSION,
        &GROUP,
        &VISIBLE,
        &HOLDOUT,
        &SHADOW_CATCHER,
        &TRANSLATE,
        &ROTATE,
        &SCALE,
        &MOVES,
    ],
};
pub(in crate::scene) const QUAD: Table = Table {
    what: "a quad",
    keys: &[
        &SHAPE,
        &NAME,
        &CENTER,
        &U,
        &V,
        &MATERIAL,
        &EMISSION,
        &GROUP,
        &VISIBLE,
        &HOLDOUT,
        &SHADOW_CATCHER,
        &TRANSLATE,
        &ROTATE,
        &SCALE,
        &MOVES,
    ],
};
pub(in crate::scene) const BOX: Table = Table {
    what: "a box",
    keys: &[
        &SHAPE,
        &NAME,
        &BOX_MIN,
        &BOX_MAX,
        &MATERIAL,
        &EMISSION,
        &GROUP,
        &VISIBLE,
        &HOLDOUT,
        &SHADOW_CATCHER,
        &TRANSLATE,
        &ROTATE,
        &SCALE,
        &MOVES,
    ],
};
pub(in crate::scene) const PLANE: Table = Table {
    what: "a plane",
    keys: &[
        &SHAPE,
        &NAME,
        &POINT,
        &NORMAL,
        &MATERIAL,
        &EMISSION,
        &GROUP,
        &VISIBLE,
        &HOLDOUT,
        &SHADOW_CATCHER,
        &TRANSLATE,
        &ROTATE,
        &SCALE,
        &MOVES,
    ],
};
pub(in crate::scene) const MESH: Table = Table {
    what: "a mesh",
    keys: &[
        &SHAPE,
        &NAME,
        &MESH_FILE,
        &NEXT_FILE,
        &MATERIAL,
        &EMISSION,
        &GROUP,
        &VISIBLE,
        &HOLDOUT,
        &SHADOW_CATCHER,
        &TRANSLATE,
        &ROTATE,
        &SCALE,
        &MOVES,
    ],
};

pub(in crate::scene) const MATERIAL_TYPE: Key = Key::new(
    "type",
    Kind::Word(|| vec!["diffuse", "plastic", "metal", "mirror", "glass"]),
    "",
    Needed("\"diffuse\", \"plastic\", \"metal\", \"mirror\" or \"glass\""),
    "Kind of material.",
);
pub(in crate::scene) const REFLECTANCE: Key = Key::new(
    "reflectance",
    Kind::Table("a colour or { texture = \"picture.png\" }"),
    "",
    Default("0.5"),
    "Part of the light that is reflected, in [0, 1].",
);
pub(in crate::scene) const MIRROR_REFLECTANCE: Key = Key::new(
    "reflectance",
    Kind::Splat(Range::UNIT),
    "",
    Default("1.0"),
    "Part of the light that is reflected.",
);
pub(in crate::scene) const METAL_REFLECTANCE: Key = Key::new(
    "reflectance",
    Kind::Table("a colour or { texture = \"picture.png\" }"),
    "",
    Default("0.9"),
    "Part of the light that is reflected where it falls on straight, in [0, 1]; at a slant it is more.",
);
pub(in crate::scene) const ROUGHNESS: Key = Key::new(
    "roughness",
    Kind::Number(ROUGH),
    "",
    Default("0.5"),
    "Square root of the width of the slopes of facets (GGX), as Blender and UsdPreviewSurface have it.",
);
pub(in crate::scene) const COAT_IOR: Key =
    Key::new("ior", Kind::Number(COAT), "", Default("1.5"), "Index of refraction of the coat.");
pub(in crate::scene) const IOR: Key =
    Key::new("ior", Kind::Number(REFRACTION), "", Default("1.5"), "Index of refraction.");
pub(in crate::scene) const TINT: Key = Key::new(
    "tint",
    Kind::Splat(Range::UNIT),
    "",
    Default("1.0"),
    "Part of the refracted light that gets through each face.",
);
pub(in crate::scene) const TEXTURE_FILE: Key =
    Key::new("texture", Kind::File("a picture file"), "", Needed("a picture file"), "The picture.");
pub(in crate::scene) const DIFFUSE: Table =
    Table { what: "a diffuse material", keys: &[&MATERIAL_TYPE, &REFLECTANCE] };
pub(in crate::scene) const PLASTIC: Table =
    Table { what: "a plastic", keys: &[&MATERIAL_TYPE, &REFLECTANCE, &ROUGHNESS, &COAT_IOR] };
pub(in crate::scene) const METAL: Table =
    Table { what: "a metal", keys: &[&MATERIAL_TYPE, &METAL_REFLECTANCE, &ROUGHNESS] };
pub(in crate::scene) const MIRROR: Table =
    Table { what: "a mirror", keys: &[&MATERIAL_TYPE, &MIRROR_REFLECTANCE] };
pub(in crate::scene) const GLASS: Table =
    Table { what: "glass", keys: &[&MATERIAL_TYPE, &IOR, &TINT] };
pub(in crate::scene) const TEXTURE: Table = Table { what: "a texture", keys: &[&TEXTURE_FILE] };
