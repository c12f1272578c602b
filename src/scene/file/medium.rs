//! `[[medium]]`.

use glam::{DAffine3, DVec3};

use super::motion::{self, MotionStep, VelocitySection};
use super::transfer::{self, TransferSection};
use super::{group, placement};
use crate::error::Result;
use crate::math::Rgb;
use crate::scene::groups::GroupName;
use crate::scene::keys::{Key, medium as keys, transfer as transfer_keys};
use crate::scene::objects::ObjectName;
use crate::scene::reader::{FileReference, Place, Range, Section, Value};

/// One `[[medium]]`.
#[derive(Debug, Clone, PartialEq)]
pub struct MediumSection {
    /// Where the table stands.
    pub at: Place,
    /// `name`, or `medium[i]`.
    pub name: String,
    /// What it is called in pictures.
    pub object: ObjectName,
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
    /// `group`: the group of its emission.
    pub group: Option<GroupName>,
    /// `translate`, `rotate`, `scale`.
    pub placement: DAffine3,
    /// `motion`.
    pub motion: Option<MotionStep>,
    /// `velocity`, `velocity_unit`, `velocity_scale`.
    pub velocity: VelocitySection,
}

impl MediumSection {
    /// That of the next frame, where the time is between two and any of its grids is numbered.
    ///
    /// # Errors
    /// Where a file of the next frame is not there.
    pub(super) fn next(&self) -> Result<Option<Self>> {
        let mut next = self.clone();
        let mut is_numbered = false;
        let density = match &mut next.density {
            DensitySection::Grid { grid, .. } => Some(grid),
            DensitySection::Region(_) => None,
        };
        let albedo = match &mut next.albedo {
            AlbedoSection::Grid { grid, .. } => Some(grid),
            AlbedoSection::Constant(_) => None,
        };
        let emission = match &mut next.emission {
            Some(
                EmissionSection::Grid { grid, .. } | EmissionSection::Temperature { grid, .. },
            ) => Some(grid),
            Some(EmissionSection::Density { .. }) | None => None,
        };
        for grid in [density, albedo, emission].into_iter().flatten() {
            let Some(path) = grid.file.next.take() else { continue };
            if !path.is_file() {
                return Err(grid.file.at.error(format!(
                    "{}: no such file; a time between two frames needs the files of both, give that of a frame",
                    path.display()
                )));
            }
            is_numbered = true;
            grid.file.path = path;
        }
        Ok(is_numbered.then_some(next))
    }
}

/// Where a medium is, and how dense.
#[derive(Debug, Clone, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "there is one a medium")]
pub enum DensitySection {
    /// As a grid says.
    Grid {
        /// The grid.
        grid: GridReference,
        /// Whether a level set is turned into a fog volume.
        level_set_as_fog: bool,
        /// `density`: what its values are taken for.
        transfer: Option<TransferSection>,
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
#[allow(clippy::large_enum_variant, reason = "there is one a medium")]
pub enum AlbedoSection {
    /// The same everywhere, in [0, 1].
    Constant(Rgb),
    /// A scalar or colour grid times `scale`.
    Grid {
        /// The grid.
        grid: GridReference,
        /// Factor, in (0, 1].
        scale: f64,
        /// What the values of a scalar grid stand for.
        transfer: Option<TransferSection>,
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
        /// Emission coefficient for a value of 1.
        color: Rgb,
        /// What the values of the grid stand for.
        transfer: Option<TransferSection>,
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
        /// What the values of the grid stand for before that.
        transfer: Option<TransferSection>,
    },
}

pub(super) fn read(section: &Section<'_>) -> Result<MediumSection> {
    section.only(&keys::MEDIUM)?;
    section.at_most_one(&[&keys::FILE, &keys::REGION_KEY])?;
    let at = section.place();
    let (name, density) = (section.maybe_text(&keys::NAME)?, density(section)?);
    let file = section.maybe_text(&keys::FILE)?;
    Ok(MediumSection {
        name: name.clone().unwrap_or_else(|| at.key.clone()),
        object: ObjectName::new(name, file.as_deref(), "medium"),
        at,
        density,
        sigma_t: section.splat(&keys::SIGMA_T)?,
        albedo: section.read(&keys::ALBEDO, |v| albedo(section, v))?,
        phase: section.read(&keys::PHASE_KEY, phase)?,
        emission: section.maybe(&keys::EMISSION, |v| emission(section, v))?,
        group: group(section)?,
        placement: placement(section)?,
        motion: motion::step(section)?,
        velocity: motion::velocity(section)?,
    })
}

fn density(section: &Section<'_>) -> Result<DensitySection> {
    if let Some(value) = section.get(&keys::REGION_KEY) {
        for key in [&keys::GRID, &keys::INDEX, &keys::LEVEL_SET, &keys::DENSITY] {
            if let Some(value) = section.get(key) {
                return Err(
                    value.error("belongs to `file`, but the medium has a `region`; leave one out")
                );
            }
        }
        return region(&value).map(DensitySection::Region);
    }
    let file = section.file(&keys::FILE)?;
    Ok(DensitySection::Grid {
        level_set_as_fog: section.get(&keys::LEVEL_SET).is_some()
            && section.word(&keys::LEVEL_SET, &[("fog", true)])?,
        grid: grid(file, section, &keys::GRID)?,
        transfer: match section.get(&keys::DENSITY) {
            Some(value) => {
                let section = Section::from_value(&value, &keys::DENSITY.kind.right())?;
                section.only(&transfer_keys::TRANSFER)?;
                transfer::read(&section, Range::NOT_NEGATIVE)?
            }
            None => None,
        },
    })
}

/// The grid named by `key` and `index` of `section`.
fn grid(file: FileReference, section: &Section<'_>, key: &Key) -> Result<GridReference> {
    Ok(GridReference {
        at: section.get(key).as_ref().map_or_else(|| file.at.clone(), Value::place),
        name: section.maybe_text(key)?,
        index: section.maybe_whole(&keys::INDEX)?.map(|i| i as usize),
        file,
    })
}

/// The same for a grid beside the density: its file is by default that of `medium`.
fn side_grid(medium: &Section<'_>, section: &Section<'_>, key: &Key) -> Result<GridReference> {
    let file = match section.maybe_file(&keys::SIDE_FILE)? {
        Some(own) => own,
        None => medium.maybe_file(&keys::FILE)?.ok_or_else(|| {
            section.missing(keys::SIDE_FILE.name, "a VDB file, since the medium has none")
        })?,
    };
    grid(file, section, key)
}

fn region(value: &Value<'_>) -> Result<RegionSection> {
    let right = keys::REGION_KEY.kind.right();
    if value.is_string() {
        return value.word(&[("everywhere", ())]).map(|()| RegionSection::Everywhere);
    }
    let section = Section::from_value(value, &right)?;
    section.only(&keys::REGION)?;
    section.at_most_one(keys::REGION.keys)?;
    if let Some(value) = section.get(&keys::BOX) {
        let section = Section::from_value(&value, &keys::BOX.kind.right())?;
        section.only(&keys::REGION_BOX)?;
        let (min, max) = super::surface::corners(&section)?;
        return Ok(RegionSection::Box { min, max });
    }
    if let Some(value) = section.get(&keys::SPHERE) {
        let section = Section::from_value(&value, &keys::SPHERE.kind.right())?;
        section.only(&keys::REGION_SPHERE)?;
        return Ok(RegionSection::Sphere {
            center: section.triple(&keys::CENTER)?,
            radius: section.number(&keys::BALL_RADIUS)?,
        });
    }
    let mesh = section.maybe_file(&keys::MESH)?;
    mesh.map(RegionSection::Mesh).ok_or_else(|| value.wrong(&right))
}

fn albedo(medium: &Section<'_>, value: &Value<'_>) -> Result<AlbedoSection> {
    if !value.is_table() {
        return value.color(keys::UNIT_ALBEDO).map(AlbedoSection::Constant);
    }
    let section = Section::from_value(value, &keys::ALBEDO.kind.right())?;
    section.only(&keys::ALBEDO_GRID)?;
    section.require(&keys::ALBEDO_GRID_NAME)?;
    Ok(AlbedoSection::Grid {
        grid: side_grid(medium, &section, &keys::ALBEDO_GRID_NAME)?,
        scale: section.number(&keys::ALBEDO_SCALE)?,
        transfer: transfer::read(&section, keys::UNIT_ALBEDO)?,
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

const PHASES: &[(&str, PhaseKind)] = &[
    ("isotropic", PhaseKind::Isotropic),
    ("rayleigh", PhaseKind::Rayleigh),
    ("henyey-greenstein", PhaseKind::HenyeyGreenstein),
    ("two-lobe", PhaseKind::TwoLobe),
    ("fog", PhaseKind::Fog),
];

fn phase(value: &Value<'_>) -> Result<PhaseSection> {
    if value.is_string() {
        return value
            .word(&[("isotropic", PhaseSection::Isotropic), ("rayleigh", PhaseSection::Rayleigh)]);
    }
    let section = Section::from_value(value, &keys::PHASE_KEY.kind.right())?;
    let kind = section.word(&keys::PHASE_TYPE, PHASES)?;
    section.only(match kind {
        PhaseKind::Isotropic | PhaseKind::Rayleigh => &keys::PHASE,
        PhaseKind::HenyeyGreenstein => &keys::HENYEY_GREENSTEIN,
        PhaseKind::TwoLobe => &keys::TWO_LOBE,
        PhaseKind::Fog => &keys::FOG,
    })?;
    Ok(match kind {
        PhaseKind::Isotropic => PhaseSection::Isotropic,
        PhaseKind::Rayleigh => PhaseSection::Rayleigh,
        PhaseKind::HenyeyGreenstein => {
            PhaseSection::HenyeyGreenstein { g: section.number(&keys::G)? }
        }
        PhaseKind::TwoLobe => PhaseSection::TwoLobe {
            g: section.pair(&keys::LOBES)?,
            weight: section.number(&keys::WEIGHT)?,
        },
        PhaseKind::Fog => PhaseSection::Fog { diameter: section.number(&keys::DIAMETER)? },
    })
}

fn emission(medium: &Section<'_>, value: &Value<'_>) -> Result<EmissionSection> {
    let section = Section::from_value(value, &keys::EMISSION.kind.right())?;
    section.at_most_one(&[&keys::EMISSION_GRID_NAME, &keys::TEMPERATURE])?;
    if section.get(&keys::TEMPERATURE).is_some() {
        section.only(&keys::EMISSION_TEMPERATURE)?;
        return Ok(EmissionSection::Temperature {
            grid: side_grid(medium, &section, &keys::TEMPERATURE)?,
            kelvin_scale: section.number(&keys::KELVIN_SCALE)?,
            kelvin_offset: section.number(&keys::KELVIN_OFFSET)?,
            scale: section.number(&keys::EMISSION_SCALE)?,
            transfer: transfer::read(&section, Range::NOT_NEGATIVE)?,
        });
    }
    let by_grid = section.get(&keys::EMISSION_GRID_NAME).is_some();
    section.only(if by_grid { &keys::EMISSION_GRID } else { &keys::EMISSION_DENSITY })?;
    if !by_grid && section.get(&keys::COLOR).is_none() {
        let right = "a colour in W/(m³ sr), or `grid` or `temperature`";
        return Err(section.missing(keys::COLOR.name, right));
    }
    let color = section.splat(&keys::COLOR)? * section.number(&keys::EMISSION_SCALE)?;
    if !by_grid {
        return Ok(EmissionSection::Density { color });
    }
    Ok(EmissionSection::Grid {
        grid: side_grid(medium, &section, &keys::EMISSION_GRID_NAME)?,
        color,
        transfer: transfer::read(&section, Range::NOT_NEGATIVE)?,
    })
}
