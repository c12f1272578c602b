//! The scene file: TOML 1.0, every key checked.
//!
//! World space is in metres with y up. A colour is a number (grey) or three numbers, linear
//! Rec.709. A path is relative to the scene file. Angles are in degrees. No number may be infinite,
//! not a number, or larger than 1e18 in magnitude. Unknown keys are errors.
//!
//! A file may be one of a sequence: `####` in its name, `%04d` or `%d` stand for the number of the
//! frame that is rendered (see [`Pattern`](crate::sequence::Pattern)).
//!
//! ```toml
//! [camera]
//! position = [0.0, 1.5, 8.0]
//! target = [0.0, 1.0, 0.0]
//!
//! [[medium]]                   # any number; where they overlap, coefficients add
//! file = "smoke.vdb"
//! sigma_t = 8.0
//! albedo = { grid = "Cd" }     # a vector grid, or three of its components: Cd.x, Cd.y, Cd.z
//! density = { from = [0.1, 0.6], ramp = [[0.0, 0.0], [0.2, 1.0], [1.0, 1.0]] }
//! emission = { grid = "flames", ramp = [[0.0, 0.0], [0.5, [2.0, 0.5, 0.1]], [1.0, [9.0, 5.0, 2.0]]] }
//!
//! [[light]]
//! type = "environment"
//! gradient = [[-90, 0.02], [0, [0.3, 0.32, 0.35]], [90, 0.05]]
//! ```
//!
//! The [guide](crate::guide::keys) lists every key.

mod camera;
mod director;
mod light;
mod medium;
mod motion;
mod render;
mod surface;
mod transfer;

use std::path::Path;

use glam::{DAffine3, DMat3, DQuat, DVec3, EulerRot};

use super::directing::Directing;
use super::groups::GroupName;
use super::keys::{shot as shot_keys, surface as keys};
use super::reader::{Document, FileReference, Range, Section, Value, with_empty};
use super::settings::{FilmSettings, RenderSettings};
use crate::error::{Error, Result};
use crate::math::Rgb;

pub use camera::CameraSection;
pub use light::{Aim, LightKind, LightSection, SpotShape, Strength};
pub use medium::{
    AlbedoSection, DensitySection, EmissionSection, GridReference, MediumSection, PhaseSection,
    RegionSection,
};
pub use motion::{MotionSection, MotionStep, VelocityName, VelocitySection, VelocityUnit};
pub use surface::{MaterialSection, ShapeSection, SurfaceSection};
pub use transfer::TransferSection;

/// Largest number of media, surfaces and lights a file may list, each.
pub const MAX_TABLES: usize = 4096;
/// Largest scene file, in bytes.
const MAX_BYTES: u64 = 16 << 20;

/// A scene file, read and checked; the files it names exist but are not read yet.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneFile {
    /// `[camera]`.
    pub camera: CameraSection,
    /// `[motion]`.
    pub motion: MotionSection,
    /// `[film]`.
    pub film: FilmSettings,
    /// `[render]`.
    pub render: RenderSettings,
    /// `[[medium]]`.
    pub media: Vec<MediumSection>,
    /// Those of the next frame, where the time is between two and their files differ.
    pub next_media: Vec<Option<MediumSection>>,
    /// `[[surface]]`.
    pub surfaces: Vec<SurfaceSection>,
    /// `[[light]]`.
    pub lights: Vec<LightSection>,
}

impl SceneFile {
    /// Whether camera or surfaces move.
    pub fn camera_or_surfaces_move(&self) -> bool {
        self.camera.next.is_some() || self.surfaces.iter().any(SurfaceSection::moves)
    }
}

/// A colour, or a picture to take it from.
#[derive(Debug, Clone, PartialEq)]
pub enum ColorSection {
    /// The same everywhere.
    Constant(Rgb),
    /// From a picture file.
    Texture(FileReference),
}

/// The text of the scene file `path`.
///
/// # Errors
/// Where it cannot be read, is no UTF-8 or larger than 16 MiB.
pub fn read(path: &Path) -> Result<String> {
    let bytes = crate::file::read(path, MAX_BYTES)?;
    String::from_utf8(bytes).map_err(|_| {
        Error::file(path, "is neither UTF-8 text nor a VDB; give a scene (.toml) or a VDB file")
    })
}

/// Reads the `text` of the scene file `path`.
///
/// # Errors
/// Where it is no TOML, or a key is unknown, missing, of the wrong type or out of range, or a file
/// it names is not there.
pub fn parse(path: &Path, text: &str) -> Result<SceneFile> {
    Document::new(path, text, &[]).read(scene)
}

/// Reads a scene's top table.
pub(super) fn scene(root: &Section<'_>) -> Result<SceneFile> {
    let tables = ["camera", "motion", "film", "render", "director", "medium", "surface", "light"];
    let keys = shot_keys::SHOT.keys.iter().map(|key| key.name);
    root.only_named("a scene", &tables.into_iter().chain(keys).collect::<Vec<_>>())?;
    let film = film(root)?;
    let camera = root
        .table("camera", "a table [camera]")?
        .ok_or_else(|| root.missing("camera", "a table [camera] with position and target"))?;
    let (camera, motion) = (camera::read(&camera)?, motion::read(root)?);
    let render = render(root)?;
    let media = each(root, "medium", medium::read)?;
    Ok(SceneFile {
        camera,
        motion,
        film,
        render,
        next_media: media.iter().map(MediumSection::next).collect::<Result<_>>()?,
        media,
        surfaces: each(root, "surface", surface::read)?,
        lights: each(root, "light", light::read)?,
    })
}

/// The shot that a scene adds to, and the camera that it takes.
#[derive(Debug, Clone, PartialEq)]
pub struct ShotSection {
    /// The USD file.
    pub file: FileReference,
    /// The path or name of the camera.
    pub camera: Option<String>,
}

/// Reads `usd` and `usd_camera` of a scene's top table.
pub(super) fn shot(root: &Section<'_>) -> Result<Option<ShotSection>> {
    let camera = root.maybe_text(&shot_keys::USD_CAMERA)?;
    let file = root.maybe_file(&shot_keys::USD)?;
    Ok(file.map(|file| ShotSection { file, camera }))
}

/// Reads the table `[film]` of a scene's top table.
pub(super) fn film(root: &Section<'_>) -> Result<FilmSettings> {
    match root.table("film", "a table [film]")? {
        Some(section) => render::film(&section),
        None => with_empty(render::film),
    }
}

fn render(root: &Section<'_>) -> Result<RenderSettings> {
    let directing = match root.table("director", "a table [director]")? {
        Some(section) => director::read(&section)?,
        None => with_empty(director::read)?,
    };
    match root.table("render", "a table [render]")? {
        Some(section) => render::render(&section, directing),
        None => with_empty(|section| render::render(section, directing)),
    }
}

fn each<'t, T>(
    root: &Section<'t>,
    key: &str,
    read: impl Fn(&Section<'t>) -> Result<T>,
) -> Result<Vec<T>> {
    root.tables(key, MAX_TABLES)?.iter().map(read).collect()
}

/// What the tables of keys say where a scene says nothing.
const DEFAULTS: &str = "the defaults of the keys are in their ranges";

impl Default for FilmSettings {
    fn default() -> Self {
        with_empty(render::film).expect(DEFAULTS)
    }
}

impl Default for Directing {
    fn default() -> Self {
        with_empty(director::read).expect(DEFAULTS)
    }
}

impl Default for RenderSettings {
    fn default() -> Self {
        with_empty(|section| render::render(section, Directing::default())).expect(DEFAULTS)
    }
}

/// The placement that `translate`, `rotate` and `scale` describe: scaled, then rotated about x,
/// y and z in this order, then translated.
fn placement(section: &Section<'_>) -> Result<DAffine3> {
    let translate = section.triple(&keys::TRANSLATE)?;
    let rotate = section.triple(&keys::ROTATE)?;
    let scale = section.splat(&keys::SCALE)?;
    let matrix = turn(rotate) * DMat3::from_diagonal(scale);
    let placement = DAffine3::from_mat3_translation(matrix, translate);
    if !placement.inverse().is_finite() {
        return Err(section.place().error(
            "its placement cannot be inverted: scale is too near 0; give factors nearer to 1",
        ));
    }
    Ok(placement)
}

/// The name that `group` gives.
fn group(section: &Section<'_>) -> Result<Option<GroupName>> {
    section.maybe(&keys::GROUP, |v| {
        let name = v.string(GroupName::RIGHT)?;
        GroupName::new(name).ok_or_else(|| v.wrong(GroupName::RIGHT))
    })
}

/// The turn about x, y and z in this order, in degrees.
fn turn(rotate: DVec3) -> DMat3 {
    let [x, y, z] = rotate.to_array().map(|degrees| (degrees % 360.0).to_radians());
    DMat3::from_quat(DQuat::from_euler(EulerRot::ZYX, z, y, x))
}

/// The colour within `range` or `{ texture = "file" }` that `value` is.
fn color_or_texture(value: &Value<'_>, range: Range) -> Result<ColorSection> {
    if !value.is_table() {
        return value.color(range).map(ColorSection::Constant);
    }
    let section = Section::from_value(value, "a colour or { texture = \"picture.png\" }")?;
    section.only(&keys::TEXTURE)?;
    section.file(&keys::TEXTURE_FILE).map(ColorSection::Texture)
}
