//! Keys of `[film]`.

use super::Without::{Default, Other};
use super::{Key, Kind, Table};
use crate::scene::reader::Range;

const STOPS: Range = Range::new(|x| x.abs() <= 100.0, "a number of stops from -100 to 100");

pub(in crate::scene) const SIZE: Key = Key::new(
    "size",
    Kind::Size,
    "pixels",
    Default("[960, 540]"),
    "Width and height of the picture, each from 1 to 65536, at most 2^28 pixels together.",
)
.flag("size");
pub(in crate::scene) const EXPOSURE: Key = Key::new(
    "exposure",
    Kind::NumberOr(STOPS, &["auto"]),
    "stops",
    Default("0.0"),
    "Exposure of the PNG; \"auto\" meters a first look at the scene.",
)
.flag("exposure");
pub(in crate::scene) const VIEW: Key = Key::new(
    "view",
    Kind::Word(|| vec!["agx", "srgb"]),
    "",
    Default("\"agx\""),
    "View transform of the PNG: AgX for looking at, or the sRGB curve alone for measuring.",
)
.flag("view-transform");

pub(in crate::scene) const PASSES: Key = Key::new(
    "passes",
    Kind::Text("names with commas between them, such as \"depth,albedo\""),
    "",
    Other("none"),
    "Layers that the EXR gets beside its own: some of depth, albedo, normal, position, motion, media, direct, indirect, emission, \
     specular, cryptomatte, groups and scattered. The five from media to specular add up to the picture, and so do groups: the \
     light of each group of emitters. What media emit, scatter first and scatter more adds up to media. Groups and scattered \
     exclude each other.",
)
.flag("passes");
pub(in crate::scene) const HALF: Key = Key::new(
    "half",
    Kind::Switch,
    "",
    Default("false"),
    "Whether the EXR stores colours as 16-bit floats, except where they are too bright or too dark for those; by `--half` \
     as well.",
);
pub(in crate::scene) const DEEP: Key = Key::new(
    "deep",
    Kind::Switch,
    "",
    Default("false"),
    "Whether a deep EXR is written beside the picture, with samples of its light and opacity by distance, and the pass \
     media, of which they are made; by `--deep` as well.",
);

pub(in crate::scene) const FILM: Table =
    Table { what: "[film]", keys: &[&SIZE, &EXPOSURE, &VIEW, &PASSES, &HALF, &DEEP] };
