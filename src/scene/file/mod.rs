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
//! [camera]                     # needed
//! type = "perspective"         # or "orthographic", "latlong"
//! position = [0.0, 1.5, 8.0]   # m; needed
//! target = [0.0, 1.0, 0.0]     # m; needed
//! up = [0, 1, 0]               # default
//! fov = 28.0                   # perspective: full angle across the width, in (0, 180); default 40
//! aperture = 0.0               # perspective: lens diameter, m; default 0, a pinhole
//! focus = 7.5                  # perspective: distance in focus, m; default the target's
//! # height = 4.0               # orthographic: height of the view, m; needed there
//!
//! [film]
//! size = [960, 540]            # pixels, each 1 to 65536, 2^28 together; default
//! exposure = 0.0               # of the PNG, stops; default
//! view = "agx"                 # view transform of the PNG: "agx" (default) or "srgb"
//!
//! [render]                     # all overridden by the command line
//! rays = 16                    # camera rays a pixel; default
//! photons = 1_000_000          # paths; default
//! radius = 0.05                # gather radius, m; default from photons and voxel size
//! step = 0.05                  # march step, m; default from the voxel size
//! director = "fixed"           # default; "x", "s", "xs": by its maps; "variance"
//! seed = 0                     # default
//! max_scatter = 8              # highest order of volume scattering; default no limit
//! final_gather = "auto"        # default; "never", "always": rays that media scatter go further
//!
//! [director]                   # how the maps are made and what they hand out; defaults
//! x = "scattering"             # or "transmittance", as in Anson et al. 2006
//! weights = [0.5, 0.5]         # of X and S in "xs"
//! op = "+"                     # or "*": X^w_x S^w_s
//! directs = "rays,radius,step" # some of these, or "nothing"
//! floor = 1                    # rays of the least important pixel
//! radius = 2.0                 # its gather radius over the most important one's
//! step = 4.0                   # its march step, voxels
//! tolerance = 0.05             # relative error at which "variance" ends a pixel
//! resolution = 1.0             # pixels of the maps over those of the film, along each side; to 4
//!
//! [[medium]]                   # any number; where they overlap, coefficients add
//! name = "smoke"               # in messages; default medium[i]
//! file = "smoke.vdb"           # either file, with
//! grid = "density"             #   its grid: default density, else the only fog volume
//! index = 0                    #   which of several grids of that name
//! level_set = "fog"            #   turns a level set into a fog volume
//! # region = "everywhere"      # or region: density 1 everywhere or inside
//! # region = { box = { min = [-1, 0, -1], max = [1, 2, 1] } }
//! # region = { sphere = { center = [0, 1, 0], radius = 1.0 } }
//! # region = { mesh = "closed.obj" }
//! sigma_t = 1.0                # colour, 1/m for density 1; default 1
//! albedo = 0.9                 # colour in [0, 1]; default 0.9; or per voxel:
//! # albedo = { grid = "Cd", file = "smoke.vdb", index = 0, scale = 1.0 }
//! phase = "isotropic"          # default; or "rayleigh", or
//! # phase = { type = "henyey-greenstein", g = 0.5 }              # g in (-1, 1)
//! # phase = { type = "two-lobe", g = [0.8, -0.2], weight = 0.7 } # weight of the first
//! # phase = { type = "fog", diameter = 20.0 }                    # of the droplets, um, to 50
//! emission = { color = 1.0, scale = 1.0 } # W/(m³ sr) for density 1; or times a grid:
//! # emission = { grid = "flame", color = [1, 0.5, 0.1], scale = 1.0 }
//! # emission = { temperature = "temperature", kelvin_scale = 1.0, kelvin_offset = 0.0, scale = 1.0 }
//! translate = [0, 0, 0]        # m; placement: scaled, rotated about x, y, z, translated
//! rotate = [0, 0, 0]           # degrees
//! scale = 1.0                  # number or three, none 0
//!
//! [[surface]]
//! shape = "sphere"             # with center, radius;
//! center = [0, 1, 0]           # "quad" with center (default 0), u, v: half sides;
//! radius = 0.5                 # "box" with min, max; "plane" with point, normal;
//! material = { type = "diffuse", reflectance = 0.5 } # "mesh" with file (.obj, .ply, .gltf, .glb)
//! # material = { type = "diffuse", reflectance = { texture = "wood.png" } }
//! # material = { type = "mirror", reflectance = 0.95 }
//! # material = { type = "glass", ior = 1.5, tint = 1.0 }
//! # emission = [10, 8, 6]      # radiance, W/(m² sr): quads and meshes become lights
//! # translate, rotate, scale as for a medium
//!
//! [[light]]
//! type = "point"               # position, intensity (W/sr) or power (W)
//! position = [0, 3, 0]         # "spot": also target or direction, angle (half, degrees), and
//! intensity = 10.0             #   falloff (degrees, inside the cone) or exponent; texture
//!                              # "sun": direction (of travel), irradiance (W/m²), angle (diameter)
//!                              # "area": center, u, v (half sides), radiance; shines along u x v
//!                              # "environment": radiance, texture (EXR, HDR, TIFF, PNG, JPEG) or
//!                              #   gradient; scale, rotate (of a texture, about y)
//! # gradient = [[-90, 0.02], [0, [0.3, 0.32, 0.35]], [90, 0.05]]  # elevation (degrees), radiance
//! ```

mod camera;
mod director;
mod light;
mod medium;
mod surface;

use std::path::Path;

use glam::{DAffine3, DMat3, DQuat, DVec3, EulerRot};
use toml::de::DeTable;

use super::directing::Director;
use super::reader::{FileReference, Range, Section, Source, Value, one_line};
use super::settings::{
    FilmSettings, FinalGather, MAX_PHOTONS, MAX_PIXELS, MAX_RAYS, MAX_SCATTER, MAX_SIDE,
    RenderSettings,
};
use crate::error::{Error, Result};
use crate::image::ViewTransform;
use crate::math::Rgb;

pub use camera::CameraSection;
pub use light::{Aim, LightKind, LightSection, SpotShape, Strength};
pub use medium::{
    AlbedoSection, DensitySection, EmissionSection, GridReference, MediumSection, PhaseSection,
    RegionSection,
};
pub use surface::{MaterialSection, ShapeSection, SurfaceSection};

/// Largest number of media, surfaces and lights a file may list, each.
pub const MAX_TABLES: usize = 4096;
/// Largest scene file, in bytes.
const MAX_BYTES: u64 = 16 << 20;

/// A scene file, read and checked; the files it names exist but are not read yet.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneFile {
    /// `[camera]`.
    pub camera: CameraSection,
    /// `[film]`.
    pub film: FilmSettings,
    /// `[render]`.
    pub render: RenderSettings,
    /// `[[medium]]`.
    pub media: Vec<MediumSection>,
    /// `[[surface]]`.
    pub surfaces: Vec<SurfaceSection>,
    /// `[[light]]`.
    pub lights: Vec<LightSection>,
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
    parse_at(path, text, None)
}

/// As [`parse`], with the files of `frame` where a name has a place for its number; whether those
/// are there is not looked at.
///
/// # Errors
/// As [`parse`].
pub fn parse_at(path: &Path, text: &str, frame: Option<i64>) -> Result<SceneFile> {
    let source = Source { path, text, frame };
    let document = DeTable::parse(text).map_err(|e| {
        let offset = e.span().map_or(0, |span| span.start);
        source.place(offset, "TOML").error(one_line(e.message()))
    })?;
    let root = Section::root(&source, &document);
    root.only("a scene", &["camera", "film", "render", "director", "medium", "surface", "light"])?;
    let film = film(&root)?;
    let camera = root.require("camera", "a table [camera] with position and target")?;
    Ok(SceneFile {
        camera: camera::read(&camera.table("a table [camera]")?)?,
        film,
        render: RenderSettings { directing: director::read(&root)?, ..render(&root)? },
        media: each(&root, "medium", medium::read)?,
        surfaces: each(&root, "surface", surface::read)?,
        lights: each(&root, "light", light::read)?,
    })
}

fn each<'t, T>(
    root: &Section<'t>,
    key: &str,
    read: impl Fn(&Section<'t>) -> Result<T>,
) -> Result<Vec<T>> {
    root.tables(key, MAX_TABLES)?.iter().map(read).collect()
}

fn film(root: &Section<'_>) -> Result<FilmSettings> {
    let default = FilmSettings::default();
    let Some(value) = root.get("film") else { return Ok(default) };
    let section = value.table("a table [film]")?;
    section.only("[film]", &["size", "exposure", "view"])?;
    Ok(FilmSettings {
        size: section.or("size", default.size, size)?,
        exposure: section.or("exposure", default.exposure, |v| v.number(EXPOSURE))?,
        view: section.or("view", default.view, |v| {
            v.word(&[("srgb", ViewTransform::Srgb), ("agx", ViewTransform::Agx)])
        })?,
    })
}

const EXPOSURE: Range = Range::new(|x| x.abs() <= 100.0, "a number of stops from -100 to 100");

fn size(value: Value<'_>) -> Result<[u32; 2]> {
    let [width, height] = value.integer_pair(1, u64::from(MAX_SIDE))?;
    if width * height > MAX_PIXELS {
        return Err(value.wrong(&format!("at most {MAX_PIXELS} pixels together")));
    }
    Ok([width as u32, height as u32])
}

fn render(root: &Section<'_>) -> Result<RenderSettings> {
    let default = RenderSettings::default();
    let Some(value) = root.get("render") else { return Ok(default) };
    let section = value.table("a table [render]")?;
    section.only(
        "[render]",
        &["rays", "photons", "radius", "step", "director", "seed", "max_scatter", "final_gather"],
    )?;
    let whole =
        |key, default, max| section.or(key, default, |v| v.integer(u64::from(key == "rays"), max));
    Ok(RenderSettings {
        rays: whole("rays", u64::from(default.rays), u64::from(MAX_RAYS))? as u32,
        photons: whole("photons", default.photons, MAX_PHOTONS)?,
        radius: section.maybe("radius", |v| v.number(Range::POSITIVE))?,
        step: section.maybe("step", |v| v.number(Range::POSITIVE))?,
        director: section.or("director", default.director, |v| v.word(Director::ALL))?,
        directing: default.directing,
        seed: whole("seed", default.seed, i64::MAX as u64)?,
        max_scatter: section
            .maybe("max_scatter", |v| v.integer(0, u64::from(MAX_SCATTER)))?
            .map(|orders| orders as u32),
        final_gather: section
            .or("final_gather", default.final_gather, |v| v.word(FinalGather::ALL))?,
        denoise: default.denoise,
        planning: default.planning,
        crop: default.crop,
    })
}

/// The keys of a placement.
const PLACEMENT: [&str; 3] = ["translate", "rotate", "scale"];

/// The placement that `translate`, `rotate` and `scale` describe: scaled, then rotated about x,
/// y and z in this order, then translated.
fn placement(section: &Section<'_>) -> Result<DAffine3> {
    let translate = section.or("translate", DVec3::ZERO, |v| v.triple(Range::ANY))?;
    let rotate = section.or("rotate", DVec3::ZERO, |v| v.triple(Range::ANY))?;
    let scale = section.or("scale", DVec3::ONE, |v| v.splat(Range::NOT_ZERO))?;
    let [x, y, z] = rotate.to_array().map(|degrees| (degrees % 360.0).to_radians());
    let turn = DMat3::from_quat(DQuat::from_euler(EulerRot::ZYX, z, y, x));
    let placement = DAffine3::from_mat3_translation(turn * DMat3::from_diagonal(scale), translate);
    if !placement.inverse().is_finite() {
        return Err(section.place().error(
            "its placement cannot be inverted: scale is too near 0; give factors nearer to 1",
        ));
    }
    Ok(placement)
}

/// The colour or `{ texture = "file" }` that `value` is.
fn color_or_texture(value: &Value<'_>, range: Range) -> Result<ColorSection> {
    if !value.is_table() {
        return value.color(range).map(ColorSection::Constant);
    }
    let section = value.table("a colour or { texture = \"picture.png\" }")?;
    section.only("a texture", &["texture"])?;
    let picture = section.require("texture", "a picture file")?;
    picture.file("a picture file").map(ColorSection::Texture)
}
