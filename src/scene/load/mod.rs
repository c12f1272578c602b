//! From a file to a complete scene.

mod context;
mod files;
mod grids;
mod groups;
mod kind;
mod lights;
mod media;
mod motion;
mod retime;
mod shots;
mod surfaces;

use std::collections::BTreeMap;
use std::mem::take;
use std::path::Path;
use std::sync::Arc;

use super::bare::{self, BareScene};
use super::camera::Camera;
use super::file::{self, CameraSection, SceneFile, SurfaceSection};
use super::frame_motion::FrameMotion;
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
use crate::medium::Media;
use crate::sequence::FrameTime;
use crate::shape::MeshData;
use crate::surface::Surfaces;

use context::{Context, Culling};
pub(super) use files::Grids;
pub(super) use kind::{bare_sequence, is_vdb};
use motion::Moving;
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
            return ShotSource::of_usd(path, options)?
                .text(options.frame_of(""))
                .map(Self::from_shot);
        }
        Self::given(path, file::read(path)?, options)
    }

    /// That of the scene file `path`, which takes no options for bare VDB files.
    pub(super) fn given(path: &Path, text: String, options: &LoadOptions) -> Result<Self> {
        refuse_level_set(options)?;
        if let Some(shots) = ShotSource::of_text(path, &text, options)? {
            return shots.text(options.frame_of(&text)).map(Self::from_shot);
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

    /// Parses it at the time `frame`.
    pub(super) fn read(
        &self,
        path: &Path,
        options: &LoadOptions,
        frame: Option<FrameTime>,
    ) -> Result<SceneFile> {
        let document = Document::new(path, self.as_str(), &options.settings).at_frame(frame);
        match self {
            Self::File(_) => document.read(file::scene),
            Self::Bare(_) => document.for_bare_vdb().read(file::scene),
            Self::Shot(with) => {
                let Files { assets, next_assets, meshes, .. } = &with.made.files;
                let (path, start) = (with.path.as_path(), with.start);
                let shot = ShotText { path, start, assets, next_assets, meshes };
                document.with_shot(shot).read(file::scene)
            }
        }
    }
}

impl StaticScene {
    /// Camera, lights and surfaces of `file`, whose text is `text`, in the middle of the time that the shutter is open.
    pub(super) fn build(text: &Text, file: &SceneFile, options: &LoadOptions) -> Result<Self> {
        let (frames, size) = (file.motion.middle(), file.film.size);
        let mut context = Context { meshes: text.meshes(), ..Context::default() };
        let camera = camera_at(frames, file)?;
        let mut lights = Vec::new();
        let (mut surfaces, mut names) = (Vec::new(), Vec::new());
        for section in &file.lights {
            let (light, surface) = lights::build(section, lights.len() as u32, &mut context)?;
            lights.push(light);
            names.extend(surface.as_ref().map(|_| ObjectName::Chosen("light".into())));
            surfaces.extend(surface);
        }
        for section in &file.surfaces {
            let built = surfaces::build(section, frames, lights.len() as u32, &mut context)?;
            surfaces.push(built.surface);
            names.push(section.object.clone());
            lights.extend(built.light);
        }
        let is_hidden = |index: &usize| !file.lights[*index].visible;
        let hidden = (0..file.lights.len()).filter(is_hidden).collect();
        let is_moving = file.camera_or_surfaces_move();
        let moved = if is_moving { format!("{frames}\n") } else { String::new() };
        let tables = outline::static_tables(text.as_str());
        let hashed = format!("{camera:?} {size:?}\n{moved}{tables}{}", options.hashed_static());
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

    /// The same so many `frames` after the time of the scene `file`: what stands still is shared.
    fn moved(&self, frames: f64, text: &Text, file: &SceneFile) -> Result<Self> {
        let mut moved = Self { camera: camera_at(frames, file)?, ..self.clone() };
        if file.surfaces.iter().any(SurfaceSection::moves) {
            let mut context = Context { meshes: text.meshes(), ..Context::default() };
            let mut surfaces = self.surfaces.surfaces().to_vec();
            let mut lights = Lights::clone(&self.lights);
            // Those of lights come first.
            let first = surfaces.len() - file.surfaces.len();
            for (section, surface) in file.surfaces.iter().zip(&mut surfaces[first..]) {
                if section.moves() {
                    let own = surface.light().unwrap_or_default();
                    let built = surfaces::build(section, frames, own, &mut context)?;
                    *surface = built.surface;
                    if let Some(light) = built.light {
                        lights.lights[own as usize] = light;
                    }
                }
            }
            moved.surfaces = Arc::new(Surfaces::new(surfaces));
            moved.lights = Arc::new(lights);
        }
        Ok(moved)
    }

    /// The same, where the content of some files is known.
    #[must_use]
    pub(super) fn knowing(mut self, sources: &Sources) -> Self {
        self.sources.learn(sources);
        self
    }
}

/// The camera of `file` so many `frames` after the time of the scene.
fn camera_at(frames: f64, file: &SceneFile) -> Result<Camera> {
    let CameraSection { at, pose, projection, clip, next } = &file.camera;
    let moved = next.as_ref().filter(|_| frames != 0.0);
    let pose = moved.map_or(Some(*pose), |next| pose.toward(next, frames));
    let camera = pose.and_then(|pose| Camera::new(&pose, projection, file.film.size));
    let camera = camera.ok_or_else(|| at.error("its axes cannot be found; give another `up`"))?;
    Ok(camera.clipped(*clip))
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
    let mut still = static_scene;
    let (warnings, notes) = (take(&mut still.warnings), take(&mut still.notes));
    grids.begin(&file.media);
    let leaves_out = options.planning == Planning::Needed;
    let frustum = still.camera.frustum(file.film.size).filter(|_| {
        // What moves may come into sight.
        file.motion.is_of_frame() && media::only_camera_rays_need_voxels(file, &still.surfaces)
    });
    let culling = frustum.map(|frustum| Culling { frustum, leaves_out });
    let (meshes, sources) = (text.meshes(), take(&mut still.sources));
    let held = take(grids);
    let mut context = Context { grids: held, meshes, sources, warnings, notes, culling, unseen: 0 };
    let media = media_and_times(text, file, &still, &mut context);
    let (of_grids, notes_of_grids) =
        (take(&mut context.grids.warnings), take(&mut context.grids.notes));
    *grids = take(&mut context.grids);
    let (moved, times) = media?;
    let StaticScene { camera, surfaces, lights, names, hash: static_hash, .. } = still;
    if let Some(warning) = lights::endless_fog(file) {
        context.warnings.push(warning);
    }
    let (groups, of_media) = groups::build(file)?;
    let in_groups = |(media, motion): Moved| (media.in_groups(of_media.clone()), motion);
    let (media, motion) = in_groups(moved);
    context.warnings.extend(of_grids);
    context.warnings.extend(sanity::notes(&media, &camera));
    context.notes.extend(notes_of_grids);
    let between = motion::hashed(file);
    let light = outline::light_tables(text.as_str()) + &options.hashed_light() + &between;
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
    let mut scene = Scene {
        camera,
        media,
        objects,
        surfaces,
        lights,
        groups,
        film: file.film,
        render: RenderSettings { planning: options.planning, ..file.render },
        path: path.to_path_buf(),
        hash: context.sources.hash(&format!("{}{}{between}", text.as_str(), options.hashed()))?,
        light_hash: context.sources.hash(&light)?,
        static_hash,
        unseen: culling.map(|_| Unseen { voxels: context.unseen, left_out: leaves_out }),
        warnings,
        notes,
        made,
        motion,
        times: Vec::new(),
    };
    let at = |(still, moved)| at_time(&scene, still, in_groups(moved));
    scene.times = times.into_iter().map(at).collect();
    Ok((scene, context.sources))
}

/// `scene` with the camera, surfaces and lights of `still` and these media, and where they are one frame later.
fn at_time(
    scene: &Scene,
    still: StaticScene,
    (media, motion): (Media, Option<FrameMotion>),
) -> Scene {
    let StaticScene { camera, surfaces, lights, .. } = still;
    Scene {
        camera,
        media,
        surfaces,
        lights,
        objects: scene.objects.clone(),
        groups: scene.groups.clone(),
        path: scene.path.clone(),
        hash: scene.hash.clone(),
        static_hash: scene.static_hash.clone(),
        light_hash: scene.light_hash.clone(),
        warnings: Vec::new(),
        notes: Vec::new(),
        made: scene.made.clone(),
        motion,
        times: Vec::new(),
        ..*scene
    }
}

/// Media, and where all of the scene is one frame later where that is asked for.
type Moved = (Media, Option<FrameMotion>);

/// The media of `file` in the middle of the time that the shutter is open, where all is one frame later, and where anything moves
/// meanwhile, all of the scene at each of its times. `still` is the rest of it in the middle.
fn media_and_times(
    text: &Text,
    file: &SceneFile,
    still: &StaticScene,
    context: &mut Context,
) -> Result<(Moved, Vec<(StaticScene, Moved)>)> {
    let motion = &file.motion;
    let animations = motion::animations(file, context)?;
    let moved_at = |frames, still: &StaticScene, context: &mut Context| -> Result<Moved> {
        let media = motion::media(frames, file, &animations, &still.camera, context)?;
        if !file.film.passes.has(Aov::Motion) {
            return Ok((media, None));
        }
        let StaticScene { camera, surfaces, .. } = still.moved(frames + 1.0, text, file)?;
        let here = (&still.camera, &*still.surfaces);
        let motion = motion::frame_motion(frames, file, &animations, here, (camera, surfaces));
        Ok((media, Some(motion)))
    };
    let (media, vectors) = moved_at(motion.middle(), still, context)?;
    if motion.shutter == 0.0 {
        return Ok(((media, vectors), Vec::new()));
    }
    let surfaces = still.surfaces.surfaces().iter();
    let moving = Moving {
        file,
        cameras: [camera_at(motion.open, file)?, camera_at(motion.open + motion.shutter, file)?],
        animations: &animations,
        media: media.iter().map(|medium| medium.density.bounds()).collect(),
        surfaces: surfaces.map(|surface| surface.shape().bounds()).collect(),
    };
    let count = moving.count(context);
    let at = |frames| {
        let still = still.moved(frames, text, file)?;
        let moved = moved_at(frames, &still, context)?;
        Ok((still, moved))
    };
    let times: Result<Vec<_>> = motion.middles(count).map(at).collect();
    Ok(((media, vectors), times?))
}
