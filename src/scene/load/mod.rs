//! From a file to a complete scene.

mod grids;
mod lights;
mod media;
mod surfaces;

use std::io::Read;
use std::path::Path;
use std::sync::Arc;

use super::bare::{self, LookOptions, Made};
use super::camera::{Camera, Frustum};
use super::file::{self, AlbedoSection, DensitySection, LightKind, RegionSection, SceneFile};
use super::hash::Sources;
use super::outline;
use super::reader::{Document, Place, Setting};
use super::sanity;
use super::settings::Planning;
use super::{RenderSettings, Scene, Sequence, Unseen};
use crate::error::{Error, Result};
use crate::light::Lights;
use crate::math::Rgb;
use crate::medium::Media;
use crate::sequence::Pattern;
use crate::surface::Surfaces;

pub(super) use grids::Grids;

/// What stands over a scene file, or beside a VDB file alone.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LoadOptions {
    /// Settings that stand over those of the file, later ones over earlier ones.
    pub settings: Vec<Setting>,
    /// How a VDB file alone is shown.
    pub look: LookOptions,
    /// For a VDB file alone: turn a level set into a fog volume where there is no fog volume.
    pub level_set_as_fog: bool,
    /// Which frame of a sequence is meant.
    pub frame: Option<i64>,
    /// Bytes that reading a grid may take; no limit where none is given.
    pub memory: Option<u64>,
    /// Whether what the scene does not need is left out.
    pub planning: Planning,
}

impl LoadOptions {
    /// The same with the key `path`, such as `render.rays`, set to a `value` in TOML.
    #[must_use]
    pub fn with(mut self, path: &str, value: impl std::fmt::Display) -> Self {
        self.settings.push(Setting::new(path, value));
        self
    }

    /// The same with a film of `size`, width and height in pixels.
    #[must_use]
    pub fn size(self, size: [u32; 2]) -> Self {
        self.with("film.size", format!("{size:?}"))
    }

    /// The same with this many camera rays a pixel.
    #[must_use]
    pub fn rays(self, rays: u32) -> Self {
        self.with("render.rays", rays)
    }

    /// The same with this many photon paths.
    #[must_use]
    pub fn photons(self, photons: u64) -> Self {
        self.with("render.photons", photons)
    }

    /// What a scene with these settings depends on beside its text and files.
    fn hashed(&self) -> String {
        let of_scene = self.settings.iter().filter(|setting| setting.is_of_scene());
        of_scene.map(|setting| format!("{:?}\n", setting.parts())).collect()
    }

    /// Those of them that change what is seen of surfaces and lights.
    fn hashed_still(&self) -> String {
        let still = |setting: &&Setting| outline::STILL.contains(&setting.table());
        let settings = self.settings.iter().filter(still);
        settings.map(|setting| format!("{:?}\n", setting.parts())).collect()
    }
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
    /// What is told beside warnings, one line each.
    pub(super) notes: Vec<String>,
    /// Where the camera looks, if nothing else asks for voxels.
    sight: Option<Sight>,
    /// Active voxels elsewhere.
    unseen: u64,
}

/// Where alone voxels are asked for.
#[derive(Debug, Clone, Copy)]
struct Sight {
    frustum: Frustum,
    /// Whether other voxels are left out, and not only counted.
    leaves_out: bool,
}

/// What of a scene stays as it is where only its volumes change.
#[derive(Debug, Clone)]
pub(super) struct StaticScene {
    camera: Camera,
    surfaces: Arc<Surfaces>,
    lights: Arc<Lights>,
    sources: Sources,
    warnings: Vec<String>,
    notes: Vec<String>,
    hash: String,
}

impl Scene {
    /// Loads a scene file or, by its content, a bare VDB.
    ///
    /// # Errors
    /// Where a file cannot be read or used, or a key is wrong.
    pub fn load(path: &Path, options: &LoadOptions) -> Result<Self> {
        if let Some(frame) = options.frame {
            return Sequence::open(path, options)?.load(frame);
        }
        if let Some(pattern) = volumes(path) {
            let name = path.display().to_string();
            return Err(Error::Usage(outline::without_frame(&name, &pattern)));
        }
        let mut grids = Grids::within(options.memory);
        let text = Text::open(path, options, &mut grids)?;
        let file = text.read(path, options, None)?;
        let static_scene = StaticScene::build(&text, &file, options)?;
        build(path, &text, &file, static_scene, grids, options)
    }
}

/// The text of a scene: that of a file, or one that is made for a VDB file alone.
#[derive(Debug, Clone)]
pub(super) enum Text {
    /// That of a scene file.
    File(String),
    /// Made for a VDB file, or for a sequence of them.
    Made(Arc<Made>),
}

impl Text {
    /// That of the scene file `path`, or of the VDB file `path`, whose density `grids` then holds.
    pub(super) fn open(path: &Path, options: &LoadOptions, grids: &mut Grids) -> Result<Self> {
        if is_vdb(path)? {
            return bare::make(path, None, options, grids).map(|made| Self::Made(Arc::new(made)));
        }
        if options.level_set_as_fog {
            return Err(Error::Usage(
                "--level-set is for bare VDB files; in a scene write `level_set = \"fog\"`".into(),
            ));
        }
        options.look.refuse_in_scene()?;
        file::read(path).map(Self::File)
    }

    pub(super) fn as_str(&self) -> &str {
        match self {
            Self::File(text) => text,
            Self::Made(made) => &made.text,
        }
    }

    /// What it says, with the files of `frame`.
    pub(super) fn read(
        &self,
        path: &Path,
        options: &LoadOptions,
        frame: Option<i64>,
    ) -> Result<SceneFile> {
        let document = Document::new(path, self.as_str(), &options.settings).at_frame(frame);
        match self {
            Self::File(_) => document.read(file::scene),
            Self::Made(_) => document.made_for_vdb().read(file::scene),
        }
    }
}

impl StaticScene {
    /// Camera, lights and surfaces of `file`, whose text is `text`.
    pub(super) fn build(text: &Text, file: &SceneFile, options: &LoadOptions) -> Result<Self> {
        let mut context = Context::default();
        let size = file.film.size;
        let camera = Camera::new(&file.camera.pose, &file.camera.projection, size)
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
        let tables = outline::still_tables(text.as_str());
        let seen = format!("{camera:?} {size:?}\n{tables}{}", options.hashed_still());
        Ok(Self {
            camera,
            surfaces: Arc::new(Surfaces::new(surfaces)),
            lights: Arc::new(Lights { lights }),
            hash: context.sources.hash(&seen)?,
            sources: context.sources,
            warnings: context.warnings,
            notes: context.notes,
        })
    }
}

/// The scene of `file`, whose text is `text`, with its media read; `grids` may hold some already.
pub(super) fn build(
    path: &Path,
    text: &Text,
    file: &SceneFile,
    static_scene: StaticScene,
    grids: Grids,
    options: &LoadOptions,
) -> Result<Scene> {
    let StaticScene { camera, surfaces, lights, sources, warnings, notes, hash: still } =
        static_scene;
    let grids = grids.for_media(&file.media);
    let leaves_out = options.planning == Planning::Needed;
    let frustum = camera.frustum(file.film.size).filter(|_| is_only_seen(file, &surfaces));
    let sight = frustum.map(|frustum| Sight { frustum, leaves_out });
    let mut context = Context { grids, sources, warnings, notes, sight, unseen: 0 };
    let media = file
        .media
        .iter()
        .map(|section| media::build(section, &mut context))
        .collect::<Result<Vec<_>>>()?;
    if let Some(warning) = endless_fog(file) {
        context.warnings.push(warning);
    }
    let media = Media::new(media);
    context.warnings.append(&mut context.grids.warnings);
    context.warnings.extend(sanity::notes(&media, &camera));
    context.notes.append(&mut context.grids.notes);
    let made = match text {
        Text::File(_) => None,
        Text::Made(made) => Some(made.clone()),
    };
    Ok(Scene {
        camera,
        media,
        surfaces,
        lights,
        film: file.film,
        render: RenderSettings { planning: options.planning, ..file.render },
        path: path.to_path_buf(),
        hash: context.sources.hash(&format!("{}{}", text.as_str(), options.hashed()))?,
        still,
        unseen: sight.map(|_| Unseen { voxels: context.unseen, left_out: leaves_out }),
        warnings: context.warnings,
        notes: made.iter().flat_map(|made| made.notes.clone()).chain(context.notes).collect(),
        made,
    })
}

/// Whether nothing but camera rays asks for voxels of the media: no light is scattered by them, and
/// none crosses them to a surface.
fn is_only_seen(file: &SceneFile, surfaces: &Surfaces) -> bool {
    surfaces.is_empty() && file.media.iter().all(|m| m.albedo == AlbedoSection::Constant(Rgb::ZERO))
}

/// The sequence of bare VDB files that `path` stands for, if it does.
pub(super) fn volumes(path: &Path) -> Option<Pattern> {
    Pattern::of(path).filter(|_| ends_in_vdb(path) && !path.exists())
}

fn ends_in_vdb(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("vdb"))
}

/// Whether the file begins like a VDB.
pub(super) fn is_vdb(path: &Path) -> Result<bool> {
    let mut magic = [0; 4];
    let mut file = scene_file(path, crate::file::open(path))?;
    Ok(ends_in_vdb(path) || file.read_exact(&mut magic).is_ok_and(|()| &magic == b" BDV"))
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
    let light = file.lights.iter().find(|l| is_infinite(&l.kind))?;
    Some(format!(
        "{} comes from infinitely far and cannot cross {}, which has no end; give the medium a \
         region with an end",
        light.at, fog.name
    ))
}

/// Whether light of this kind comes from infinitely far.
fn is_infinite(kind: &LightKind) -> bool {
    use LightKind::{Environment, Gradient, Sun};
    matches!(kind, Sun { .. } | Environment { .. } | Gradient { .. })
}

/// `result` with its problem told at `place`.
fn at<T>(place: &Place, result: Result<T, impl std::fmt::Display>) -> Result<T> {
    result.map_err(|problem| place.error(problem))
}
