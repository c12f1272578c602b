//! From a file to a complete scene.

mod grids;
mod lights;
mod media;
mod surfaces;

use std::io::Read;
use std::path::Path;

use super::camera::Camera;
use super::file::{self, DensitySection, LightKind, RegionSection, SceneFile};
use super::hash::Sources;
use super::reader::Place;
use super::{Overrides, Scene, bare};
use crate::error::{Error, Result};
use crate::medium::Media;
use crate::surface::Surfaces;

use grids::Grids;
pub(super) use grids::bad_values;

/// What stands over a scene file, or beside a bare VDB.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LoadOptions {
    /// Settings that replace those of the file.
    pub overrides: Overrides,
    /// For a bare VDB: turn a level set into a fog volume where there is no fog volume.
    pub level_set_as_fog: bool,
    /// Bytes that reading a grid may take; no limit where none is given.
    pub memory: Option<u64>,
}

/// What loading gathers on its way.
#[derive(Debug, Default)]
pub(super) struct Context {
    /// VDB files, each opened once.
    pub(super) grids: Grids,
    /// Every file read.
    pub(super) sources: Sources,
    /// One line each.
    pub(super) warnings: Vec<String>,
}

impl Scene {
    /// Loads a scene file or, by its content, a bare VDB.
    ///
    /// # Errors
    /// Where a file cannot be read or used, or a key is wrong.
    pub fn load(path: &Path, options: &LoadOptions) -> Result<Self> {
        if is_vdb(path)? {
            return bare::load(path, options);
        }
        if options.level_set_as_fog {
            return Err(Error::Usage(
                "--level-set is for bare VDB files; in a scene write `level_set = \"fog\"`".into(),
            ));
        }
        let text = file::read(path)?;
        let file = file::parse(path, &text)?;
        Self::build(path, &text, &file, options)
    }

    fn build(path: &Path, text: &str, file: &SceneFile, options: &LoadOptions) -> Result<Self> {
        let mut context = Context { grids: Grids::within(options.memory), ..Context::default() };
        let film = file.film.overridden(&options.overrides);
        let camera = Camera::new(&file.camera.pose, &file.camera.projection, film.size)
            .ok_or_else(|| file.camera.at.error("its axes cannot be found; give another `up`"))?;
        let mut lights = Vec::new();
        let mut surfaces = Vec::new();
        for section in &file.lights {
            let (light, surface) = lights::build(section, lights.len() as u32, &mut context)?;
            lights.push(light);
            surfaces.extend(surface);
        }
        for section in &file.surfaces {
            let built = surfaces::build(section, lights.len() as u32, &mut context)?;
            surfaces.push(built.surface);
            lights.extend(built.light);
        }
        let media = file
            .media
            .iter()
            .map(|section| media::build(section, &mut context))
            .collect::<Result<Vec<_>>>()?;
        if let Some(warning) = endless_fog(file) {
            context.warnings.push(warning);
        }
        Ok(Self {
            camera,
            media: Media::new(media),
            surfaces: Surfaces::new(surfaces),
            lights: crate::light::Lights { lights },
            film,
            render: file.render.overridden(&options.overrides),
            path: path.to_path_buf(),
            hash: context.sources.hash(text)?,
            warnings: context.warnings,
            notes: Vec::new(),
        })
    }
}

/// Whether the file begins like a VDB.
fn is_vdb(path: &Path) -> Result<bool> {
    let mut magic = [0; 4];
    let mut file = scene_file(path, crate::file::open(path))?;
    let extension = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("vdb"));
    Ok(extension || file.read_exact(&mut magic).is_ok_and(|()| &magic == b" BDV"))
}

/// `opened`, its error also saying what would be right.
fn scene_file<T>(path: &Path, opened: Result<T>) -> Result<T> {
    opened.map_err(|e| match e {
        Error::File { problem, .. } => {
            Error::file(path, format!("{problem}; give a scene (.toml) or a VDB file"))
        }
        other => other,
    })
}

/// A warning where light from infinitely far is to cross endless fog: none arrives.
fn endless_fog(file: &SceneFile) -> Option<String> {
    let fog = file.media.iter().find(|m| {
        m.density == DensitySection::Region(RegionSection::Everywhere)
            && m.sigma_t.max_element() > 0.0
    })?;
    let light = file
        .lights
        .iter()
        .find(|l| matches!(l.kind, LightKind::Sun { .. } | LightKind::Environment { .. }))?;
    Some(format!(
        "{}:{}: {} comes from infinitely far and cannot cross {}, which has no end; give the medium \
         a region with an end",
        light.at.path.display(),
        light.at.line,
        light.at.key,
        fog.name
    ))
}

/// `result` with its problem told at `place`.
fn at<T>(place: &Place, result: Result<T, impl std::fmt::Display>) -> Result<T> {
    result.map_err(|problem| place.error(problem))
}
