//! Every key of a scene file: name, type, unit, default, range and a sentence, each once.
//!
//! What is read from files, said in messages, taken by flags and by `--set`, and written by
//! `--write-scene` is made from these tables.

pub(super) mod camera;
pub(super) mod director;
pub(super) mod film;
pub(super) mod light;
pub(super) mod medium;
pub(super) mod motion;
mod reference;
pub(super) mod render;
pub(super) mod shot;
pub(super) mod surface;
pub(super) mod transfer;

use super::reader::Range;

pub use reference::reference;

/// A key of a table.
#[derive(Debug, Clone, Copy)]
pub struct Key {
    /// Its name.
    pub name: &'static str,
    /// What it takes.
    pub kind: Kind,
    /// Unit of its numbers; empty where they have none.
    pub unit: &'static str,
    /// What holds where it is not there.
    pub without: Without,
    /// What it means: a sentence.
    pub doc: &'static str,
    /// The flag that stands over it, without dashes.
    pub flag: Option<&'static str>,
}

/// What holds where a key is not there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Without {
    /// It must be there: what to give.
    Needed(&'static str),
    /// The same as with this value, in TOML.
    Default(&'static str),
    /// Something else: what.
    Other(&'static str),
}

/// What a key takes.
#[derive(Debug, Clone, Copy)]
pub enum Kind {
    /// A number.
    Number(Range),
    /// A whole number from the first to the second.
    Whole(u64, u64),
    /// `true` or `false`.
    Switch,
    /// A number for all channels or axes, or three numbers.
    Splat(Range),
    /// Three numbers.
    Triple,
    /// Three numbers that are not all 0.
    Direction,
    /// Two numbers.
    Pair(Range),
    /// Width and height in pixels.
    Size,
    /// One of some words.
    Word(fn() -> Vec<&'static str>),
    /// A number, or one of some words.
    NumberOr(Range, &'static [&'static str]),
    /// Text: what it names.
    Text(&'static str),
    /// A file's name, its path relative to the scene file: what kind of file.
    File(&'static str),
    /// A table, or a short form of it: how it looks.
    Table(&'static str),
}

/// The keys that may stand together in one table.
#[derive(Debug, Clone, Copy)]
pub struct Table {
    /// What the table describes, such as `a perspective camera`.
    pub what: &'static str,
    /// The keys.
    pub keys: &'static [&'static Key],
}

impl Key {
    const fn new(
        name: &'static str,
        kind: Kind,
        unit: &'static str,
        without: Without,
        doc: &'static str,
    ) -> Self {
        Self { name, kind, unit, without, doc, flag: None }
    }

    /// The same key with a flag.
    const fn flag(self, flag: &'static str) -> Self {
        Self { flag: Some(flag), ..self }
    }
}

impl Kind {
    /// What would be right, for messages and documentation.
    pub fn right(&self) -> String {
        let quoted = |words: &[&str]| {
            words.iter().map(|w| format!("\"{w}\"")).collect::<Vec<_>>().join(" or ")
        };
        match self {
            Self::Number(range) => range.words().into(),
            Self::Whole(min, max) => format!("a whole number from {min} to {max}"),
            Self::Switch => "true or false".into(),
            Self::Splat(range) => format!("{}, or three of them", range.words()),
            Self::Triple => "three numbers".into(),
            Self::Direction => "three numbers, not all 0".into(),
            Self::Pair(range) => format!("two numbers, each {}", range.words()),
            Self::Size => "two whole numbers [width, height]".into(),
            Self::Word(words) => quoted(&words()),
            Self::NumberOr(range, words) => format!("{} or {}", range.words(), quoted(words)),
            Self::Text(what) | Self::File(what) | Self::Table(what) => (*what).into(),
        }
    }
}

/// The tables of a scene file: the name under which each stands, which of the tables of that name it is,
/// where there are several, and its keys.
pub const TABLES: &[(&str, &str, &Table)] = &[
    ("scene", "At the top of the file", &shot::SHOT),
    ("[camera]", "`type = \"perspective\"`", &camera::PERSPECTIVE),
    ("[camera]", "`type = \"orthographic\"`", &camera::ORTHOGRAPHIC),
    ("[camera]", "`type = \"latlong\"`", &camera::LATLONG),
    ("[camera] next", "", &camera::NEXT_POSE),
    ("[film]", "", &film::FILM),
    ("[render]", "", &render::RENDER),
    ("[director]", "", &director::DIRECTOR),
    ("[motion]", "", &motion::MOTION),
    ("[[medium]]", "", &medium::MEDIUM),
    ("[[medium]] density", "", &transfer::TRANSFER),
    ("[[medium]] region", "One of", &medium::REGION),
    ("[[medium]] region", "`box = { .. }`", &medium::REGION_BOX),
    ("[[medium]] region", "`sphere = { .. }`", &medium::REGION_SPHERE),
    ("[[medium]] albedo", "", &medium::ALBEDO_GRID),
    ("[[medium]] phase", "`type = \"isotropic\"` or `\"rayleigh\"`", &medium::PHASE),
    ("[[medium]] phase", "`type = \"henyey-greenstein\"`", &medium::HENYEY_GREENSTEIN),
    ("[[medium]] phase", "`type = \"two-lobe\"`", &medium::TWO_LOBE),
    ("[[medium]] phase", "`type = \"fog\"`", &medium::FOG),
    ("[[medium]] emission", "In proportion to the density", &medium::EMISSION_DENSITY),
    ("[[medium]] emission", "By a grid", &medium::EMISSION_GRID),
    ("[[medium]] emission", "By a grid of temperatures", &medium::EMISSION_TEMPERATURE),
    ("[[surface]]", "`shape = \"sphere\"`", &surface::SPHERE),
    ("[[surface]]", "`shape = \"quad\"`", &surface::QUAD),
    ("[[surface]]", "`shape = \"box\"`", &surface::BOX),
    ("[[surface]]", "`shape = \"plane\"`", &surface::PLANE),
    ("[[surface]]", "`shape = \"mesh\"`", &surface::MESH),
    ("[[surface]] motion", "", &surface::MOVES_TABLE),
    ("[[surface]] material", "`type = \"diffuse\"`", &surface::DIFFUSE),
    ("[[surface]] material", "`type = \"plastic\"`", &surface::PLASTIC),
    ("[[surface]] material", "`type = \"metal\"`", &surface::METAL),
    ("[[surface]] material", "`type = \"mirror\"`", &surface::MIRROR),
    ("[[surface]] material", "`type = \"glass\"`", &surface::GLASS),
    ("[[surface]] texture", "", &surface::TEXTURE),
    ("[[light]]", "`type = \"point\"`", &light::POINT),
    ("[[light]]", "`type = \"spot\"`", &light::SPOT),
    ("[[light]]", "`type = \"sun\"`", &light::SUN),
    ("[[light]]", "`type = \"area\"`", &light::AREA),
    ("[[light]]", "`type = \"environment\"`", &light::ENVIRONMENT),
];

/// The keys that a flag stands over, with the name of their table.
pub fn flagged() -> impl Iterator<Item = (&'static str, &'static Key)> {
    let tables =
        [("film", &film::FILM), ("render", &render::RENDER), ("director", &director::DIRECTOR)];
    let keys =
        |(name, table): (&'static str, &'static Table)| table.keys.iter().map(move |k| (name, *k));
    tables.into_iter().flat_map(keys).filter(|(_, key)| key.flag.is_some())
}
