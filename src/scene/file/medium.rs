//! `[[medium]]`.

use glam::{DAffine3, DVec3};

use super::{PLACEMENT, placement};
use crate::error::Result;
use crate::math::Rgb;
use crate::scene::reader::{FileReference, Place, Range, Section, Value};

/// One `[[medium]]`.
#[derive(Debug, Clone, PartialEq)]
pub struct MediumSection {
    /// Where the table stands.
    pub at: Place,
    /// `name`, or `medium[i]`.
    pub name: String,
    /// `file` or `region`.
    pub density: DensitySection,
    /// `sigma_t`: extinction coefficient for density 1, in 1/m.
    pub sigma_t: Rgb,
    /// `albedo`.
    pub albedo: AlbedoSection,
    /// `phase`.
    pub phase: PhaseSection,
    /// `emission`.
    pub emission: Option<EmissionSection>,
    /// `translate`, `rotate`, `scale`.
    pub placement: DAffine3,
}

/// Where a medium is, and how dense.
#[derive(Debug, Clone, PartialEq)]
pub enum DensitySection {
    /// As a grid says.
    Grid {
        /// The grid.
        grid: GridReference,
        /// Whether a level set is turned into a fog volume.
        level_set_as_fog: bool,
    },
    /// Density 1 in a region.
    Region(RegionSection),
}

/// A grid of a VDB file.
#[derive(Debug, Clone, PartialEq)]
pub struct GridReference {
    /// The VDB file.
    pub file: FileReference,
    /// The key that names the grid, or the file where none does.
    pub at: Place,
    /// Its name; without one the file's default.
    pub name: Option<String>,
    /// Which of several grids of that name, from 0.
    pub index: Option<usize>,
}

/// A region of space, before placement.
#[derive(Debug, Clone, PartialEq)]
pub enum RegionSection {
    /// All of it.
    Everywhere,
    /// A box along the axes, in metres.
    Box {
        /// Smallest coordinates.
        min: DVec3,
        /// Largest coordinates.
        max: DVec3,
    },
    /// A ball, in metres.
    Sphere {
        /// Its centre.
        center: DVec3,
        /// Its radius.
        radius: f64,
    },
    /// The inside of a closed mesh.
    Mesh(FileReference),
}

/// What part of the extinction is scattering.
#[derive(Debug, Clone, PartialEq)]
pub enum AlbedoSection {
    /// The same everywhere, in [0, 1].
    Constant(Rgb),
    /// A scalar or colour grid times `scale`.
    Grid {
        /// The grid.
        grid: GridReference,
        /// Factor, in (0, 1].
        scale: f64,
    },
}

/// A phase function.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PhaseSection {
    /// 1/(4 pi).
    Isotropic,
    /// Rayleigh's.
    Rayleigh,
    /// Henyey and Greenstein's.
    HenyeyGreenstein {
        /// Mean cosine, in (-1, 1).
        g: f64,
    },
    /// Two Henyey-Greenstein lobes.
    TwoLobe {
        /// Mean cosines of the lobes, in (-1, 1).
        g: [f64; 2],
        /// Weight of the first, in [0, 1].
        weight: f64,
    },
    /// The fit to fog of Jendersie and d'Eon 2023.
    Fog {
        /// Droplet diameter in micrometres, in (0, 50].
        diameter: f64,
    },
}

/// What light a medium gives off.
#[derive(Debug, Clone, PartialEq)]
pub enum EmissionSection {
    /// `color` x density, W/(m³ sr), the factor `scale` already in it.
    Density {
        /// Emission coefficient for density 1.
        color: Rgb,
    },
    /// `color` x grid, W/(m³ sr), the factor `scale` already in it.
    Grid {
        /// The grid.
        grid: GridReference,
        /// Emission coefficient for grid value 1.
        color: Rgb,
    },
    /// A blackbody of `kelvin_offset + kelvin_scale` x grid kelvin, times `scale`.
    Temperature {
        /// The grid.
        grid: GridReference,
        /// Kelvin for one unit of the grid.
        kelvin_scale: f64,
        /// Kelvin where the grid is 0.
        kelvin_offset: f64,
        /// Factor on the blackbody's radiance.
        scale: f64,
    },
}

const G: Range = Range::new(|g| g > -1.0 && g < 1.0, "a number above -1 and below 1");
const DIAMETER: Range =
    Range::new(|d| d > 0.0 && d <= 50.0, "a diameter above 0 and at most 50 micrometres");
const SCALE_TO_ONE: Range = Range::new(|s| s > 0.0 && s <= 1.0, "a number above 0 and at most 1");
const ALBEDO: Range = Range::new(
    |a| (0.0..=1.0).contains(&a),
    "an albedo from 0 to 1 (below 0 is no part of the light, over 1 would create energy)",
);
const MAX_INDEX: u64 = 65_535;

pub(super) fn read(section: &Section<'_>) -> Result<MediumSection> {
    let common = ["name", "file", "region", "sigma_t", "albedo", "phase", "emission"];
    let of_file = ["grid", "index", "level_set"];
    section.only("a medium", &[&common[..], &of_file, &PLACEMENT].concat())?;
    section.at_most_one(&["file", "region"])?;
    let at = section.place();
    let name = section.maybe("name", |v| v.string("a name").map(str::to_owned))?;
    Ok(MediumSection {
        name: name.unwrap_or_else(|| at.key.clone()),
        at,
        density: density(section)?,
        sigma_t: section.or("sigma_t", Rgb::ONE, |v| v.color(Range::NOT_NEGATIVE))?,
        albedo: section
            .or("albedo", AlbedoSection::Constant(Rgb::splat(0.9)), |v| albedo(section, &v))?,
        phase: section.or("phase", PhaseSection::Isotropic, |v| phase(&v))?,
        emission: section.maybe("emission", |v| emission(section, &v))?,
        placement: placement(section)?,
    })
}

fn density(section: &Section<'_>) -> Result<DensitySection> {
    if let Some(value) = section.get("region") {
        for key in ["grid", "index", "level_set"] {
            if let Some(value) = section.get(key) {
                return Err(
                    value.error("belongs to `file`, but the medium has a `region`; leave one out")
                );
            }
        }
        return region(&value).map(DensitySection::Region);
    }
    let file = section.require("file", "a VDB file, or `region` for a homogeneous medium")?;
    let level_set = section.maybe("level_set", |v| v.word(&[("fog", ())]))?;
    Ok(DensitySection::Grid {
        grid: grid(file.file("a VDB file")?, section, "grid")?,
        level_set_as_fog: level_set.is_some(),
    })
}

/// The grid named by `key` and `index` of `section`.
fn grid(file: FileReference, section: &Section<'_>, key: &str) -> Result<GridReference> {
    let name = section.get(key);
    Ok(GridReference {
        at: name.as_ref().map_or_else(|| file.at.clone(), Value::place),
        name: name.map(|v| v.string("a grid's name").map(str::to_owned)).transpose()?,
        index: section.maybe("index", |v| v.integer(0, MAX_INDEX))?.map(|i| i as usize),
        file,
    })
}

/// The same for a grid beside the density: its file is by default that of `medium`.
fn side_grid(medium: &Section<'_>, section: &Section<'_>, key: &str) -> Result<GridReference> {
    let right = "a VDB file, since the medium has none";
    let file = match (section.get("file"), medium.get("file")) {
        (Some(own), _) => own.file("a VDB file")?,
        (None, Some(of_medium)) => of_medium.file("a VDB file")?,
        (None, None) => section.require("file", right)?.file(right)?,
    };
    grid(file, section, key)
}

fn region(value: &Value<'_>) -> Result<RegionSection> {
    let right = "\"everywhere\", { box = { min, max } }, { sphere = { center, radius } } or { mesh = \"closed.obj\" }";
    if value.is_string() {
        return value.word(&[("everywhere", ())]).map(|()| RegionSection::Everywhere);
    }
    let section = value.table(right)?;
    let kinds = ["box", "sphere", "mesh"];
    section.only("a region", &kinds)?;
    section.at_most_one(&kinds)?;
    if let Some(value) = section.get("box") {
        let section = value.table("{ min = [x, y, z], max = [x, y, z] }")?;
        let (min, max) = corners(&section)?;
        return Ok(RegionSection::Box { min, max });
    }
    if let Some(value) = section.get("sphere") {
        let section = value.table("{ center = [x, y, z], radius = r }")?;
        section.only("a sphere", &["center", "radius"])?;
        let center = section.or("center", DVec3::ZERO, |v| v.triple(Range::ANY))?;
        let radius = section.require("radius", "a radius in metres")?;
        return Ok(RegionSection::Sphere { center, radius: radius.number(Range::POSITIVE)? });
    }
    match section.get("mesh") {
        Some(mesh) => mesh.file("a closed mesh (.obj, .ply, .gltf, .glb)").map(RegionSection::Mesh),
        None => Err(value.wrong(right)),
    }
}

/// `min` and `max` of a box, each side longer than 0, in a section of their own.
fn corners(section: &Section<'_>) -> Result<(DVec3, DVec3)> {
    section.only("a box", &["min", "max"])?;
    super::surface::corners(section)
}

fn albedo(medium: &Section<'_>, value: &Value<'_>) -> Result<AlbedoSection> {
    if !value.is_table() {
        return value.color(ALBEDO).map(AlbedoSection::Constant);
    }
    let section = value.table("a colour or { grid = \"name\" }")?;
    section.only("an albedo grid", &["grid", "file", "index", "scale"])?;
    section.require("grid", "the name of a grid")?;
    Ok(AlbedoSection::Grid {
        grid: side_grid(medium, &section, "grid")?,
        scale: section.or("scale", 1.0, |v| v.number(SCALE_TO_ONE))?,
    })
}

#[derive(Clone, Copy)]
enum PhaseKind {
    Isotropic,
    Rayleigh,
    HenyeyGreenstein,
    TwoLobe,
    Fog,
}

fn phase(value: &Value<'_>) -> Result<PhaseSection> {
    if value.is_string() {
        return value
            .word(&[("isotropic", PhaseSection::Isotropic), ("rayleigh", PhaseSection::Rayleigh)]);
    }
    let section =
        value.table("\"isotropic\", \"rayleigh\" or { type = \"henyey-greenstein\", g = 0.5 }")?;
    let kind = section.require("type", "the kind of phase function")?.word(&[
        ("isotropic", PhaseKind::Isotropic),
        ("rayleigh", PhaseKind::Rayleigh),
        ("henyey-greenstein", PhaseKind::HenyeyGreenstein),
        ("two-lobe", PhaseKind::TwoLobe),
        ("fog", PhaseKind::Fog),
    ])?;
    let own: &[&str] = match kind {
        PhaseKind::Isotropic | PhaseKind::Rayleigh => &["type"],
        PhaseKind::HenyeyGreenstein => &["type", "g"],
        PhaseKind::TwoLobe => &["type", "g", "weight"],
        PhaseKind::Fog => &["type", "diameter"],
    };
    section.only("this phase function", own)?;
    Ok(match kind {
        PhaseKind::Isotropic => PhaseSection::Isotropic,
        PhaseKind::Rayleigh => PhaseSection::Rayleigh,
        PhaseKind::HenyeyGreenstein => {
            PhaseSection::HenyeyGreenstein { g: section.require("g", G.words())?.number(G)? }
        }
        PhaseKind::TwoLobe => PhaseSection::TwoLobe {
            g: section.require("g", "two mean cosines")?.pair(G)?,
            weight: section
                .require("weight", "the weight of the first lobe")?
                .number(Range::UNIT)?,
        },
        PhaseKind::Fog => PhaseSection::Fog {
            diameter: section.require("diameter", DIAMETER.words())?.number(DIAMETER)?,
        },
    })
}

fn emission(medium: &Section<'_>, value: &Value<'_>) -> Result<EmissionSection> {
    let section = value
        .table("{ grid, color, scale }, { temperature, kelvin_scale, ... } or { color, scale }")?;
    section.at_most_one(&["grid", "temperature"])?;
    let scale = |default| section.or("scale", default, |v| v.number(Range::NOT_NEGATIVE));
    if section.get("temperature").is_some() {
        section.only(
            "emission by temperature",
            &["temperature", "file", "index", "kelvin_scale", "kelvin_offset", "scale"],
        )?;
        return Ok(EmissionSection::Temperature {
            grid: side_grid(medium, &section, "temperature")?,
            kelvin_scale: section.or("kelvin_scale", 1.0, |v| v.number(Range::POSITIVE))?,
            kelvin_offset: section.or("kelvin_offset", 0.0, |v| v.number(Range::ANY))?,
            scale: scale(1.0)?,
        });
    }
    let by_grid = section.get("grid").is_some();
    let known: &[&str] = if by_grid {
        &["grid", "file", "index", "color", "scale"]
    } else {
        &["grid", "temperature", "color", "scale"]
    };
    section.only("emission", known)?;
    if !by_grid {
        section.require("color", "a colour in W/(m³ sr), or `grid` or `temperature`")?;
    }
    let color = section.or("color", Rgb::ONE, |v| v.color(Range::NOT_NEGATIVE))? * scale(1.0)?;
    if !by_grid {
        return Ok(EmissionSection::Density { color });
    }
    Ok(EmissionSection::Grid { grid: side_grid(medium, &section, "grid")?, color })
}
