//! From a file to a complete scene.

mod context;
mod files;
mod grids;
mod groups;
mod lights;
mod media;
mod shots;
mod surfaces;

use std::collections::BTreeMap;
use std::io::Read;
use std::mem::take;
use std::path::Path;
use std::sync::Arc;

use super::bare::{self, BareScene};
use super::camera::Camera;
use super::file::{self, AlbedoSection, DensitySection, LightKind, RegionSection, SceneFile};
use super::hash::Sources;
use super::objects::{ObjectName, Objects};
use super::outline;
use super::reader::{Document, ShotText};
use super::sanity;
use super::settings::Planning;
use super::usd::{Files, is_usd};
use super::{Aov, LoadOptions, RenderSettings, Scene, Unseen};
use crate::error::{Error, Result};
use crate::light::Lights;
use crate::math::{Rgb, WorldPoint};
use crate::medium::{Media, Medium};
use crate::sequence::Pattern;
use crate::shape::MeshData;
use crate::surface::Surfaces;

use context::{Context, Culling};
pub(super) use files::Grids;
pub(super) use shots::{ShotSource, WithShot};

/// The parts of a scene that all frames of a sequence share: camera, surfaces and lights.
#[derive(Debug, Clone)]
pub(super) struct StaticScene {
    camera: Camera,
    surfaces: Arc<Surfaces>,
    lights: Arc<Lights>,
    /// The names of the surfaces.
    names: Vec<ObjectName>,
    sources: Sources,
    warnings: Vec<String>,
    notes: Vec<String>,
    hash: String,
}

/// Refuses the option that is for bare VDB files where the scene is none.
fn refuse_level_set(options: &LoadOptions) -> Result<()> {
    if options.level_set_as_fog {
        return Err(Error::Usage(
            "--level-set is for bare VDB files; in a scene write `level_set = \"fog\"`".into(),
        ));
    }
    Ok(())
}

/// The text of a scene: that of a file, or one written for a bare VDB file.
#[derive(Debug, Clone)]
pub(super) enum Text {
    /// Read from a scene file, or given in place of one.
    File(String),
    /// Written for a bare VDB file, or for a sequence of them.
    Bare(Arc<BareScene>),
    /// Written for a USD file, behind the text of the scene that adds to it.
    Shot(Arc<WithShot>),
}

impl Text {
    /// The text of the scene file `path`, or one for the VDB file `path`, whose density `grids` then holds.
    pub(super) fn open(path: &Path, options: &LoadOptions, grids: &mut Grids) -> Result<Self> {
        if is_vdb(path)? {
            return bare::make(path, None, options, grids).map(|made| Self::Bare(Arc::new(made)));
        }
        if is_usd(path) {
            refuse_level_set(options)?;
            return ShotSource::of_usd(path, options)?.text(options.frame).map(Self::from_shot);
        }
        Self::given(path, file::read(path)?, options)
    }

    /// That of the scene file `path`, which takes no options for bare VDB files.
    pub(super) fn given(path: &Path, text: String, options: &LoadOptions) -> Result<Self> {
        refuse_level_set(options)?;
        if let Some(shots) = ShotSource::of_text(path, &text, options)? {
            return shots.text(options.frame).map(Self::from_shot);
        }
        options.look.refuse_in_scene()?;
        Ok(Self::File(text))
    }

    /// That of a shot.
    pub(super) fn from_shot(shot: WithShot) -> Self {
        Self::Shot(Arc::new(shot))
    }

    pub(super) fn as_str(&self) -> &str {
        match self {
            Self::File(text) => text,
            Self::Bare(made) => &made.text,
            Self::Shot(with) => &with.text,
        }
    }

    /// Meshes in memory that it names.
    fn meshes(&self) -> BTreeMap<String, Arc<MeshData>> {
        match self {
            Self::Shot(with) => with.made.files.meshes.clone(),
            Self::File(_) | Self::Bare(_) => BTreeMap::new(),
        }
    }

    /// What was chosen where the user says nothing, one line each.
    fn notes(&self) -> Vec<String> {
        match self {
            Self::File(_) => Vec::new(),
            Self::Bare(made) => made.notes.clone(),
            Self::Shot(with) => with.made.notes.clone(),
        }
    }

    /// What of it is left out, one line each.
    fn warnings(&self) -> Vec<String> {
        match self {
            Self::File(_) | Self::Bare(_) => Vec::new(),
            Self::Shot(with) => with.made.warnings.clone(),
        }
    }

    /// Parses it, with the files of `frame`.
    pub(super) fn read(
        &self,
        path: &Path,
        options: &LoadOptions,
        frame: Option<i64>,
    ) -> Result<SceneFile> {
        let document = Document::new(path, self.as_str(), &options.settings).at_frame(frame);
        match self {
            Self::File(_) => document.read(file::scene),
            Self::Bare(_) => document.for_bare_vdb().read(file::scene),
            Self::Shot(with) => {
                let Files { assets, meshes, .. } = &with.made.files;
                let shot = ShotText { path: &with.path, start: with.start, assets, meshes };
                document.with_shot(shot).read(file::scene)
            }
        }
    }
}

impl StaticScene {
    /// Camera, lights and surfaces of `file`, whose text is `text`.
    pub(super) fn build(text: &Text, file: &SceneFile, options: &LoadOptions) -> Result<Self> {
        let mut context = Context { meshes: text.meshes(), ..Context::default() };
        let size = file.film.size;
        let camera = Camera::new(&file.camera.pose, &file.camera.projection, size)
            .ok_or_else(|| file.camera.at.error("its axes cannot be found; give another `up`"))?
            .clipped(file.camera.clip);
        let mut lights = Vec::new();
        let (mut surfaces, mut names) = (Vec::new(), Vec::new());
        for section in &file.lights {
            let (light, surface) = lights::build(section, lights.len() as u32, &mut context)?;
            lights.push(light);
            names.extend(surface.as_ref().map(|_| ObjectName::Chosen("light".into())));
            surfaces.extend(surface);
        }
        for section in &file.surfaces {
            let built = surfaces::build(section, lights.len() as u32, &mut context)?;
            surfaces.push(built.surface);
            names.push(section.object.clone());
            lights.extend(built.light);
        }
        let is_hidden = |index: &usize| !file.lights[*index].visible;
        let hidden = (0..file.lights.len()).filter(is_hidden).collect();
        let tables = outline::static_tables(text.as_str());
        let hashed = format!("{camera:?} {size:?}\n{tables}{}", options.hashed_static());
        Ok(Self {
            camera,
            surfaces: Arc::new(Surfaces::new(surfaces)),
            lights: Arc::new(Lights { lights, hidden }),
            names,
            hash: context.sources.hash(&hashed)?,
            sources: context.sources,
            warnings: context.warnings,
            notes: context.notes,
        })
    }

    /// The same, where the content of some files is known.
    #[must_use]
    pub(super) fn knowing(mut self, sources: &Sources) -> Self {
        self.sources.learn(sources);
        self
    }
}

/// The scene of `file`, whose text is `text`, with its media read; `grids` may hold some already, and keep all. Also its
/// files with hashes of their content.
pub(super) fn build(
    path: &Path,
    text: &Text,
    file: &SceneFile,
    static_scene: StaticScene,
    grids: &mut Grids,
    options: &LoadOptions,
) -> Result<(Scene, Sources)> {
    let StaticScene {
        camera,
        surfaces,
        lights,
        names,
        sources,
        warnings,
        notes,
        hash: static_hash,
    } = static_scene;
    grids.begin(&file.media);
    let leaves_out = options.planning == Planning::Needed;
    let frustum =
        camera.frustum(file.film.size).filter(|_| only_camera_rays_need_voxels(file, &surfaces));
    let culling = frustum.map(|frustum| Culling { frustum, leaves_out });
    let meshes = text.meshes();
    let held = take(grids);
    let mut context = Context { grids: held, meshes, sources, warnings, notes, culling, unseen: 0 };
    let media: Result<Vec<_>> = file
        .media
        .iter()
        .map(|section| {
            let medium = media::build(section, &mut context)?;
            let coordinate = largest_coordinate(&medium, &camera);
            Ok(medium.resolved(coordinate))
        })
        .collect();
    let (of_grids, notes_of_grids) =
        (take(&mut context.grids.warnings), take(&mut context.grids.notes));
    *grids = take(&mut context.grids);
    let media = media?;
    if let Some(warning) = endless_fog(file) {
        context.warnings.push(warning);
    }
    let (groups, of_media) = groups::build(file)?;
    let media = Media::new(media).in_groups(of_media);
    context.warnings.extend(of_grids);
    context.warnings.extend(sanity::notes(&media, &camera));
    context.notes.extend(notes_of_grids);
    let light = outline::light_tables(text.as_str()) + &options.hashed_light();
    let made = match text {
        Text::File(_) | Text::Shot(_) => None,
        Text::Bare(made) => Some(made.clone()),
    };
    let mut notes = text.notes();
    notes.append(&mut context.notes);
    let mut warnings = text.warnings();
    warnings.append(&mut context.warnings);
    let objects = if file.film.passes.has(Aov::Cryptomatte) {
        let of_surfaces = names.iter().zip(surfaces.surfaces());
        Objects::new(
            file.media.iter().map(|medium| &medium.object),
            of_surfaces.map(|(name, surface)| {
                (name, surface.shape().mesh().map_or(&[][..], |mesh| mesh.parts()))
            }),
        )
    } else {
        Objects::default()
    };
    let scene = Scene {
        camera,
        media,
        objects,
        surfaces,
        lights,
        groups,
        film: file.film,
        render: RenderSettings { planning: options.planning, ..file.render },
        path: path.to_path_buf(),
        hash: context.sources.hash(&format!("{}{}", text.as_str(), options.hashed()))?,
        light_hash: context.sources.hash(&light)?,
        static_hash,
        unseen: culling.map(|_| Unseen { voxels: context.unseen, left_out: leaves_out }),
        warnings,
        notes,
        made,
    };
    Ok((scene, context.sources))
}

/// The largest number by which places in `medium` are reckoned, in metres: a coordinate, or a distance from the camera.
fn largest_coordinate(medium: &Medium, camera: &Camera) -> f64 {
    let corners = medium.density.bounds().map(|bounds| bounds.corners());
    let of_corner = |corner: WorldPoint| {
        let distance = camera.place().map_or(0.0, |place| (corner - place).length());
        distance.max(corner.xyz.abs().max_element())
    };
    corners.into_iter().flatten().map(of_corner).fold(0.0, f64::max)
}

/// Whether camera rays alone need voxels of the media: these scatter no light, and none crosses them to a
/// surface.
fn only_camera_rays_need_voxels(file: &SceneFile, surfaces: &Surfaces) -> bool {
    surfaces.is_empty() && file.media.iter().all(|m| m.albedo == AlbedoSection::Constant(Rgb::ZERO))
}

/// The pattern of a sequence of bare VDB files that `path` is, if it is one.
pub(super) fn bare_sequence(path: &Path) -> Option<Pattern> {
    Pattern::from_path(path).filter(|_| ends_in_vdb(path) && !path.exists())
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
            Error::file(path, format!("{problem}; give a scene (.toml), a VDB or a USD file"))
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
