//! A scene for a bare VDB file, or for a sequence of them: the camera frames what is visible, the content
//! decides on lights, and the medium gets a visible optical thickness, at any scale of the world.
//!
//! What is chosen is written as the text of a scene file, and that is what is rendered: a bare render
//! and the scene that `--write-scene` leaves give the same picture.

mod framing;
mod glow;
mod lighting;
mod look;
mod measure;
mod subject;

use std::path::Path;

use toml::Value;

use super::LoadOptions;
use super::draft::{Draft, rounded};
use super::file::{self, AlbedoSection, EmissionSection, GridReference, SceneFile};
use super::load::Grids;
use super::reader::Document;
use crate::error::Result;
use crate::math::Rgb;

pub use look::{Ground, Look, LookOptions, UpAxis};

use subject::Subject;

/// The scene of a bare VDB file.
#[derive(Debug)]
pub struct BareScene {
    /// The scene as TOML.
    pub(super) text: String,
    /// The same in parts, with a comment on each key.
    pub draft: Draft,
    /// What was chosen, one line each.
    pub notes: Vec<String>,
    /// What a render shows, in one line.
    pub summary: String,
}

/// What a bare render of the VDB file `path` shows, in one line.
///
/// # Errors
/// Where it refuses the file.
pub fn summary(path: &Path) -> Result<String> {
    let subject = Subject::read(path, &LoadOptions::default(), &mut Grids::default())?;
    Ok(subject.summary())
}

/// What a medium without a material looks like, by what is in its file.
#[derive(Debug, Clone)]
pub(super) struct Appearance {
    /// Extinction for density 1, 1/m.
    pub(super) sigma_t: f64,
    /// The value of the key `albedo`.
    pub(super) albedo: Value,
    /// Mean cosine of the phase function.
    pub(super) g: f64,
    /// The value of the key `emission`.
    pub(super) emission: Option<Value>,
    /// The same in one line.
    pub(super) summary: String,
}

/// The look of the medium of the VDB file `path`, whose density is `grid` where that is given; each metre of the
/// file is `scale` metres in the scene.
///
/// # Errors
/// As a bare render of the file.
pub(super) fn appearance(path: &Path, grid: Option<&str>, scale: f64) -> Result<Appearance> {
    let look = LookOptions {
        grid: grid.map(str::to_owned),
        up: Some(UpAxis::Y),
        ..LookOptions::default()
    };
    let options = LoadOptions { look, ..LoadOptions::default() };
    let subject = Subject::read(path, &options, &mut Grids::default())?;
    let mut emission = subject.emission_value();
    // Ramps give emission a metre; blackbodies absorb as much of their light, whatever their size.
    if let Some(Value::Table(table)) = &mut emission
        && table.contains_key("ramp")
        && let Some(Value::Float(strength)) = table.get_mut("scale")
    {
        *strength /= scale;
    }
    Ok(Appearance {
        sigma_t: rounded(subject.sigma_t / scale),
        albedo: subject.albedo_value(),
        g: subject.g,
        emission,
        summary: subject.summary(),
    })
}

/// Leaves out emission and colour of the media of a bare scene where a frame's file lacks their grids:
/// simulations begin to write them with the first flame.
///
/// # Errors
/// Where a file cannot be opened.
pub(super) fn leave_out_missing(scene: &mut SceneFile, grids: &mut Grids) -> Result<()> {
    for medium in scene.media.iter_mut().chain(scene.next_media.iter_mut().flatten()) {
        if let Some(EmissionSection::Grid { grid, .. } | EmissionSection::Temperature { grid, .. }) =
            &medium.emission
            && !is_there(grid, grids)?
        {
            medium.emission = None;
        }
        if let AlbedoSection::Grid { grid, scale, .. } = &medium.albedo
            && !is_there(grid, grids)?
        {
            medium.albedo = AlbedoSection::Constant(Rgb::splat(*scale));
        }
    }
    Ok(())
}

/// Whether the file of `grid` has it, alone or as three components.
fn is_there(grid: &GridReference, grids: &mut Grids) -> Result<bool> {
    let file = grids.open(&grid.file.path)?;
    let name = grid.name.as_deref();
    Ok(name.is_none_or(|name| file.find_vector(name, grid.index).is_ok()))
}

/// The scene for the VDB file `path`, whose density `grids` then holds. For a sequence it names the
/// files by their `pattern`.
///
/// # Errors
/// Where the file cannot be read, or there is nothing to see in it.
pub(super) fn make(
    path: &Path,
    pattern: Option<&Path>,
    options: &LoadOptions,
    grids: &mut Grids,
) -> Result<BareScene> {
    let named = pattern.unwrap_or(path);
    let of_film = options.settings.iter().filter(|setting| setting.table() == "film");
    let of_film: Vec<_> = of_film.cloned().collect();
    let film = Document::new(named, "", &of_film).read(file::film)?;
    let subject = Subject::read(path, options, grids)?;
    let frame = framing::frame(&subject, &options.look, film.size);
    let draft = lighting::draft(&subject, &frame, &options.look, film.size, named);
    let text = draft.text();
    let notes = subject.notes();
    Ok(BareScene { text, notes, summary: subject.summary(), draft })
}
