//! The medium of a bare render.

use std::path::{Path, PathBuf};

use glam::{DAffine3, DMat3, DVec3};
use toml::Value;

use super::super::LoadOptions;
use super::super::load::Grids;
use super::glow::Glow;
use super::look::{Look, UpAxis};
use super::measure::{dense_box, mean_thickness, stands, world_bounds};
use crate::error::{Error, Result};
use crate::math::{Aabb, World};
use crate::vdb::roles::Contents;
use crate::vdb::{Grid, ReadAs, VdbFile};

/// Least length of the longest side, in metres, of smoke that is taken for a cloud.
const MIN_CLOUD_SIDE: f64 = 200.0;

/// The kind of a medium, by the content of its file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Smoke,
    Fire,
    Cloud,
}

/// The medium of a bare render.
#[derive(Debug)]
pub(super) struct Subject {
    path: PathBuf,
    pub(super) density: Grid<f32>,
    pub(super) label: String,
    pub(super) name: String,
    pub(super) occurrence: usize,
    pub(super) level_set: bool,
    pub(super) kind: Kind,
    pub(super) look: Look,
    pub(super) up: UpAxis,
    /// The box of the active voxels and half a voxel more, y up.
    pub(super) bounds: Aabb<World>,
    pub(super) thickness: f64,
    /// 1/m for density 1.
    pub(super) sigma_t: f64,
    pub(super) albedo: f64,
    pub(super) g: f64,
    pub(super) glow: Option<Glow>,
    pub(super) color: Option<String>,
    /// Whether its lowest part is cut off level, or lies at the height 0.
    pub(super) stands: bool,
    notes: Vec<String>,
}

impl Subject {
    /// The medium of the file `path`.
    ///
    /// # Errors
    /// Where it cannot be read, or there is nothing to see in it.
    pub(super) fn read(path: &Path, options: &LoadOptions, grids: &mut Grids) -> Result<Self> {
        let look_options = &options.look;
        let file = grids.open(path)?;
        let index = match &look_options.grid {
            Some(name) => file.find(name, None)?,
            None => density_index(file, options.level_set_as_fog)?,
        };
        let read_as =
            if options.level_set_as_fog { ReadAs::LevelSetAsFog } else { ReadAs::Density };
        let grid = grids.scalar(path, index, read_as)?;
        let file = grids.open(path)?;
        let info = &file.grids()[index];
        let (label, name, level_set) = (info.label(), info.name.clone(), info.is_level_set());
        let occurrence = info.occurrence;
        let empty = || {
            Error::grid(
                path,
                &label,
                "has no density above 0 to render; give another file, or name another grid by --grid",
            )
        };
        if dense_box(&grid).is_none() {
            return Err(empty());
        }
        let contents = Contents::with_density(file, index, &grid)?;
        let mut notes = contents.notes.clone();
        if let Some(background) = grid.background_inside() {
            notes.push(format!(
                "{}: grid \"{label}\": background {background} fills the box of its active voxels",
                path.display()
            ));
        }
        let (up, reason) = match (look_options.up, contents.up) {
            (Some(up), _) => (up, None),
            (None, Some((axis, reason))) => (UpAxis::from_axis(axis), Some(reason)),
            (None, None) => (UpAxis::Y, None),
        };
        if let Some(reason) = reason.filter(|_| up != UpAxis::Y) {
            notes.push(format!("{}: {} is up: {reason}", path.display(), up.name()));
        }
        let singular =
            || Error::grid(path, &label, "its transform is singular once it is turned upright");
        let density = match up {
            UpAxis::Y => grid,
            other => grid.placed(&upright(other)).ok_or_else(singular)?,
        };
        let bounds = world_bounds(&density).ok_or_else(empty)?;
        let length = mean_thickness(&density, &bounds);
        if !(length > 0.0 && length.is_finite()) {
            return Err(empty());
        }
        let glow = match &contents.fire {
            Some(fire) => {
                let burning = grids.scalar(path, fire.grid.indices()[0], ReadAs::Density)?;
                Glow::from_fire(fire, &burning, &mut notes)
            }
            None => None,
        };
        let kind = match (
            &glow,
            bounds.size().max_element() >= MIN_CLOUD_SIDE || is_named_cloud(path, &name),
        ) {
            (Some(_), _) => Kind::Fire,
            (None, true) => Kind::Cloud,
            (None, false) => Kind::Smoke,
        };
        let look = look_options.look.unwrap_or(match kind {
            Kind::Smoke => Look::Studio,
            Kind::Fire => Look::Dusk,
            Kind::Cloud => Look::Sky,
        });
        let (thickness, albedo, g) = match (look, kind) {
            (Look::None, _) => (6.0, 0.95, 0.0),
            (_, Kind::Smoke) => (6.0, 0.75, 0.2),
            (_, Kind::Fire) => (4.0, 0.6, 0.2),
            (_, Kind::Cloud) => (24.0, 0.98, 0.5),
        };
        let thickness = thickness * look_options.density.unwrap_or(1.0);
        Ok(Self {
            path: path.to_path_buf(),
            label,
            name,
            occurrence,
            level_set,
            kind,
            look,
            up,
            bounds,
            thickness,
            sigma_t: thickness / length,
            albedo: look_options.albedo.unwrap_or(if contents.color.is_some() {
                1.0
            } else {
                albedo
            }),
            g: look_options.g.unwrap_or(g),
            glow,
            color: contents.color.map(|grid| grid.label().to_owned()),
            notes,
            stands: stands(&density, &bounds),
            density,
        })
    }

    /// The turn that makes the file's upward axis y: degrees about x, y and z.
    pub(super) fn rotation(&self) -> DVec3 {
        match self.up {
            UpAxis::X => DVec3::new(0.0, 0.0, 90.0),
            UpAxis::Y => DVec3::ZERO,
            UpAxis::Z => DVec3::new(-90.0, 0.0, 0.0),
        }
    }

    /// The value of the key `albedo`.
    pub(super) fn albedo_value(&self) -> Value {
        match &self.color {
            Some(grid) if self.albedo > 0.0 => {
                let mut table = toml::Table::new();
                table.insert("grid".into(), grid.as_str().into());
                table.insert("scale".into(), self.albedo.into());
                Value::Table(table)
            }
            _ => self.albedo.into(),
        }
    }

    /// The value of the key `emission`; `None` without emission.
    pub(super) fn emission_value(&self) -> Option<Value> {
        self.glow.as_ref().map(Glow::value)
    }

    /// The choices, one line each.
    pub(super) fn notes(&self) -> Vec<String> {
        let path = self.path.display();
        let summary = format!("{path}: grid \"{}\": {}", self.label, self.summary());
        std::iter::once(summary).chain(self.notes.iter().cloned()).collect()
    }

    /// What a render shows, in one line.
    pub(super) fn summary(&self) -> String {
        let kind = match self.kind {
            Kind::Smoke => "smoke",
            Kind::Fire => "fire",
            Kind::Cloud => "cloud",
        };
        let glow = self.glow.as_ref();
        let glows = glow.map_or(String::new(), |g| format!(", glows by `{}`{}", g.grid, g.unit));
        let colored = self.color.as_ref().map_or(String::new(), |c| format!(", coloured by `{c}`"));
        let [x, y, z] = self.bounds.size().to_array().map(short);
        format!(
            "{kind}, optical thickness {}{glows}{colored}, {} up, {x} x {y} x {z} m",
            short(self.thickness),
            self.up.name()
        )
    }
}

/// `x` with three significant digits.
fn short(x: f64) -> String {
    let x: f64 = format!("{x:.2e}").parse().unwrap_or(x);
    if (1e-3..1e6).contains(&x) { format!("{x}") } else { format!("{x:e}") }
}

/// The turn that makes `up` the y axis.
fn upright(up: UpAxis) -> DAffine3 {
    DAffine3::from_mat3(match up {
        UpAxis::X => DMat3::from_cols(DVec3::Y, DVec3::NEG_X, DVec3::Z),
        UpAxis::Y => DMat3::IDENTITY,
        UpAxis::Z => DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y),
    })
}

/// Whether the names of file or grid speak of a cloud.
fn is_named_cloud(path: &Path, grid: &str) -> bool {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().to_lowercase();
    let grid = grid.to_lowercase();
    ["cloud", "cumul", "strat", "cirrus"]
        .iter()
        .any(|word| stem.contains(word) || grid.contains(word))
}

/// The default density, or with `as_fog` the only level set where there is no density.
fn density_index(file: &VdbFile, as_fog: bool) -> Result<usize> {
    let problem = match file.default_density() {
        Ok(index) => return Ok(index),
        Err(problem) => problem,
    };
    let grids = file.grids().iter().enumerate();
    let level_sets: Vec<_> =
        grids.filter(|(_, g)| g.is_level_set() && g.is_scalar()).map(|(i, _)| i).collect();
    match level_sets[..] {
        [only] if as_fog => Ok(only),
        [only] => Err(Error::grid(
            file.path(),
            file.grids()[only].label(),
            "is a level set, the distance to a surface and no density; --level-set fog, in a scene \
             level_set = \"fog\", turns it into a fog volume",
        )),
        _ => Err(problem),
    }
}
