//! Scenes of USD files: a shot as Blender, Houdini or Maya export it.
//!
//! What is understood is written as the text of a scene file, and that is what is rendered: a shot and the scene
//! that `fogbow export` makes of it give the same picture. Meshes are kept in memory under the names that the
//! exported scene gives their files.

mod arcs;
mod binary_layer;
mod camera;
mod geometry;
mod layers;
mod light;
mod material;
mod mesh;
mod package;
mod primitive;
mod seen;
mod shading;
mod shot;
mod stage;
mod text_layer;
mod values;
mod volume;
mod walk;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use openusd::sdf;
use openusd::usd::Stage;
use tempfile::TempDir;

use super::bare::{self, Appearance};
use super::draft::Draft;
use crate::error::{Error, Result};
use camera::Camera;
use seen::Seen;
use shading::Shading;
use stage::Root;
use values::Reader;
use volume::Volume;
use walk::StageSpace;

pub use shot::Files;
pub use stage::USD_READER;

/// Whether `path` is the name of a USD file.
pub(super) fn is_usd(path: &Path) -> bool {
    let endings = ["usd", "usda", "usdc", "usdz"];
    path.extension().is_some_and(|e| endings.iter().any(|known| e.eq_ignore_ascii_case(known)))
}

/// The scene of one frame of a shot.
#[derive(Debug)]
pub struct ShotScene {
    /// The scene in parts, with a comment on each key.
    pub draft: Draft,
    /// The files that it names.
    pub files: Files,
    /// What was chosen, one line each.
    pub notes: Vec<String>,
    /// What is left out, one line each.
    pub warnings: Vec<String>,
    /// Keeps the files of a package.
    _folder: Option<Arc<TempDir>>,
}

/// A USD file.
#[derive(Debug)]
pub(in crate::scene) struct Shot {
    root: Root,
    /// The camera that was asked for, by its path or name.
    camera: Option<String>,
    timing: Timing,
    /// Its volumes at the first frame, where they were asked for.
    volumes: OnceLock<Vec<Volume>>,
    /// Looks of those without a material, by their paths, so that all frames have the same.
    appearances: Arc<Mutex<Appearances>>,
}

/// Looks of volumes by their paths; nothing where no file is there.
type Appearances = BTreeMap<String, Option<Appearance>>;

/// Frames of a shot.
#[derive(Debug, Clone, Copy)]
struct Timing {
    /// Its first and last time codes, where it says them.
    range: Option<[f64; 2]>,
    /// Time codes in a frame.
    codes: f64,
}

impl Timing {
    fn of(stage: &Stage) -> Self {
        let number = |name: &str| match stage.stage_metadata(name) {
            Ok(Some(sdf::Value::Double(number))) if number.is_finite() => Some(number),
            _ => None,
        };
        let rate = |name: &str| number(name).filter(|rate| *rate > 0.0);
        let codes = match (rate("timeCodesPerSecond"), rate("framesPerSecond")) {
            (Some(codes), Some(frames)) => codes / frames,
            _ => 1.0,
        };
        let range = number("startTimeCode").zip(number("endTimeCode"));
        let range = range.filter(|(first, last)| first <= last).map(|(first, last)| [first, last]);
        Self { range, codes }
    }

    /// The time code of a frame; without one the first.
    fn at(&self, frame: Option<i64>) -> f64 {
        match frame {
            Some(frame) => frame as f64 * self.codes,
            None => self.range.map_or(0.0, |[first, _]| first),
        }
    }

    /// The first and the last frame.
    fn frames(&self) -> Option<[i64; 2]> {
        let [first, last] = self.range?.map(|time| time / self.codes);
        let is_usual = first.abs().max(last.abs()) < 1e9 && last - first < MAX_FRAMES;
        is_usual.then_some([first.ceil() as i64, last.floor() as i64])
    }
}

/// Most frames of a shot that are listed.
const MAX_FRAMES: f64 = 1e6;

impl Shot {
    /// The shot of the USD file `path`, seen by `camera`: a path or a name, by default the first.
    ///
    /// # Errors
    /// Where it, or a file it asks for, cannot be read.
    pub(super) fn open(path: &Path, camera: Option<&str>) -> Result<Self> {
        let root = Root::open(path)?;
        let timing = root.read(|stage| Ok(Timing::of(stage)))?;
        let camera = camera.map(str::to_owned);
        let (volumes, appearances) = (OnceLock::new(), Arc::default());
        Ok(Self { root, camera, timing, volumes, appearances })
    }

    /// All frames that the shot says to have, and whose files are there.
    pub(super) fn frames(&self) -> Vec<i64> {
        let frames = self.timing.frames().into_iter().flat_map(|[first, last]| first..=last);
        frames.filter(|frame| self.volume_files(*frame).iter().all(|file| file.is_file())).collect()
    }

    /// The number of the first frame.
    pub(super) fn first_frame(&self) -> i64 {
        self.timing.frames().map_or(0, |[first, _]| first)
    }

    /// The VDB files of `frame`; none where the shot cannot be used, as its [`scene`](Self::scene) says.
    pub(super) fn volume_files(&self, frame: i64) -> Vec<PathBuf> {
        let time = self.timing.at(Some(frame));
        let volumes = self.volumes.get_or_init(|| self.read_volumes().unwrap_or_default());
        volumes.iter().flat_map(|volume| volume.files(time)).collect()
    }

    /// Its volumes at the first frame.
    fn read_volumes(&self) -> Result<Vec<Volume>> {
        let (path, time) = (self.root.path.clone(), self.timing.at(None));
        self.root.read(move |stage| {
            let reader = Reader { stage, file: &path, time };
            let space = StageSpace::of(stage);
            let (mut volumes, mut warnings) = (Vec::new(), Vec::new());
            walk::prims(&reader, space.to_world, &mut |placed| {
                if placed.kind == "Volume" {
                    volumes.extend(Volume::read(&reader, placed, &space, &mut warnings)?);
                }
                Ok(())
            })?;
            Ok(volumes)
        })
    }

    /// The scene of `frame`, or of the first.
    ///
    /// # Errors
    /// Where a prim cannot be used, or there is no camera.
    pub(super) fn scene(&self, frame: Option<i64>) -> Result<ShotScene> {
        let time = self.timing.at(frame);
        let view = View {
            path: self.root.path.clone(),
            folder: self.root.folder(),
            camera: self.camera.clone(),
            appearances: self.appearances.clone(),
        };
        let mut made = self.root.read(move |stage| view.understood(stage, time))?;
        if let (None, Some([first, last])) = (frame, self.timing.frames())
            && first != last
        {
            made.notes.push(format!(
                "{}: frame {first} of {first} to {last}; --frames or --frame gives others",
                self.root.path.display()
            ));
        }
        Ok(made)
    }
}

impl ShotScene {
    /// Lets camera and meshes move to where they are in `later`, the scene one frame later.
    pub(in crate::scene) fn move_toward(&mut self, later: &Self) {
        let (files, warnings) = (&mut self.files, &mut self.warnings);
        let mesh = |name: &str| {
            files.next_mesh(name, &later.files).unwrap_or_else(|()| {
                warnings.push(format!(
                    "the mesh {name} has other triangles one frame later, and stands still while the shutter is open"
                ));
                None
            })
        };
        self.draft.set_next(&later.draft, mesh);
    }

    /// Lets volumes become those of `later`, the scene one frame later.
    pub(in crate::scene) fn turn_into(&mut self, later: &Self) {
        for (here, there) in self.draft.volumes_beside(&later.draft) {
            if let Some(path) = later.files.assets.get(there).filter(|_| here != there) {
                self.files.next_assets.insert(here.to_owned(), path.clone());
            }
        }
    }
}

/// What a scene of a shot needs besides its stage.
struct View {
    path: PathBuf,
    /// Where a package was unpacked.
    folder: Option<Arc<TempDir>>,
    camera: Option<String>,
    appearances: Arc<Mutex<Appearances>>,
}

impl View {
    /// The scene of `stage` at the time code `time`.
    fn understood(&self, stage: &Stage, time: f64) -> Result<ShotScene> {
        let path = self.path.as_path();
        let reader = Reader { stage, file: path, time };
        let space = StageSpace::of(stage);
        let files = Files::of(path, self.folder.as_ref().map(|folder| folder.path()));
        let mut seen = Seen::nothing(stage, files, space);
        walk::prims(&reader, space.to_world, &mut |placed| seen.add(&reader, placed))?;
        let camera = self.choose(&seen.cameras)?;
        let mut draft = Draft::default();
        camera.write(&mut draft, resolution(&reader)?);
        let mut notes = Vec::new();
        for volume in &seen.volumes {
            let shading = match &volume.shading {
                Some(given) => Shading::Given(given.clone()),
                None => {
                    let known = self.appearance(volume)?;
                    let Some(chosen) = known else {
                        let file = volume.files(time).into_iter().next().unwrap_or_default();
                        let problem = format!("{}: {}: no such file", volume.path, file.display());
                        return Err(Error::file(path, problem));
                    };
                    notes.push(format!(
                        "{}: {}: no volume material, its look is chosen by its files: {}",
                        path.display(),
                        volume.path,
                        chosen.summary
                    ));
                    Shading::Chosen(chosen)
                }
            };
            volume.write(&reader, &shading, &mut draft, &mut seen.files)?;
        }
        seen.geometry.write(&mut draft, &mut seen.files);
        draft.append(seen.lights);
        if seen.cameras.len() > 1 {
            let others = seen.cameras.len() - 1;
            let (path, camera) = (path.display(), &camera.path);
            notes.push(format!("{path}: seen by {camera}; --camera takes one of {others} others"));
        }
        let mut warnings = seen.warnings;
        warnings.extend(camera.warnings.clone());
        warnings.append(&mut seen.looks.warnings);
        for (kind, (first, count)) in &seen.unknown {
            let path = path.display();
            warnings.push(format!("{path}: {first}: a {kind} is left out, {count} in all"));
        }
        if let Some(first) = seen.cages.first() {
            let (path, count) = (path.display(), seen.cages.len());
            warnings.push(format!(
                "{path}: {first}: subdivision surfaces are shown as their cages, {count} in all"
            ));
        }
        Ok(ShotScene { draft, files: seen.files, notes, warnings, _folder: self.folder.clone() })
    }

    /// The look of a volume without a material.
    fn appearance(&self, volume: &Volume) -> Result<Option<Appearance>> {
        let mut known = self.appearances.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = known.get(&volume.path) {
            return Ok(known.clone());
        }
        let found = appearance(&self.path, volume)?;
        known.insert(volume.path.clone(), found.clone());
        Ok(found)
    }

    fn choose<'c>(&self, cameras: &'c [Camera]) -> Result<&'c Camera> {
        let path = &self.path;
        let Some(asked) = &self.camera else {
            let problem = "has no camera; export one with it";
            return cameras.first().ok_or_else(|| Error::file(path, problem));
        };
        let is_it = |camera: &&Camera| {
            camera.path == *asked || camera.path.rsplit('/').next() == Some(asked)
        };
        cameras.iter().find(is_it).ok_or_else(|| {
            let names: Vec<_> = cameras.iter().map(|camera| camera.path.as_str()).collect();
            let known = if names.is_empty() { "none".into() } else { names.join(", ") };
            Error::Usage(format!(
                "--camera {asked}: no such camera in {}; it has {known}",
                path.display()
            ))
        })
    }
}

/// The look of a volume without a material, by the largest of its files, so that all frames have the same; nothing
/// where none of them is there.
fn appearance(path: &Path, volume: &Volume) -> Result<Option<Appearance>> {
    let field = &volume.fields[volume.density];
    let files = field.files.iter().map(|(_, file)| file.as_path());
    let Some(file) = shading::largest(files.filter(|file| file.is_file())) else { return Ok(None) };
    let found = bare::appearance(file, field.grid.as_deref(), volume.scale());
    found.map(Some).map_err(|e| Error::file(path, format!("{}: {e}", volume.path)))
}

/// The resolution of the shot's render settings.
fn resolution(reader: &Reader<'_>) -> Result<Option<[i64; 2]>> {
    let Ok(Some(settings)) = reader.stage.stage_metadata("renderSettingsPrimPath") else {
        return Ok(None);
    };
    let path = settings.as_str().and_then(|path| sdf::Path::new(path).ok());
    match path {
        Some(path) => reader.pair(&path, "resolution"),
        None => Ok(None),
    }
}
