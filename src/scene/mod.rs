//! The scene: camera, media, surfaces, lights, film and render settings, complete and valid.
//!
//! [`Scene::load`] takes a scene file ([`mod@file`] describes it) or a bare VDB, to which it gives a
//! camera and lights. After it nothing reads a file any more.

mod advice;
mod aov;
mod bare;
pub mod camera;
mod directing;
mod draft;
pub mod file;
mod frame_motion;
mod groups;
mod hash;
mod keys;
mod load;
mod objects;
mod open;
mod options;
mod outline;
mod picture_pass;
pub mod plan;
mod reader;
mod sanity;
mod sequence;
mod settings;
mod usd;

use std::path::PathBuf;
use std::sync::Arc;

use crate::image::Window;
use crate::light::Lights;
use crate::medium::Media;
use crate::surface::Surfaces;

pub use advice::advice;
pub use aov::{Aov, Aovs};
pub use bare::{BareScene, Ground, Look, LookOptions, UpAxis, summary};
pub use camera::Camera;
pub use directing::{
    Directed, Directing, Director, Importance, MAX_COARSENING, Operator, RESOLUTIONS,
};
pub use draft::Draft;
pub use frame_motion::FrameMotion;
pub use groups::{GroupName, GroupNames, Groups};
pub use keys::{Key, Kind, TABLES, Table, Without, flagged, reference};
pub use objects::{ObjectName, Objects};
pub use open::{OpenScene, read_shot};
pub use options::LoadOptions;
pub use picture_pass::PicturePass;
pub use reader::{FileReference, MAX_MAGNITUDE, Place, Setting};
pub use sequence::Sequence;
pub use settings::{
    ErrorGoal, FilmSettings, FinalGather, MAX_PHOTONS, MAX_PIXELS, MAX_RAYS, MAX_SCATTER, MAX_SIDE,
    PhotonsName, Planning, RenderSettings, Strategy, StrategyRequest,
};
pub use usd::{Files, ShotScene, USD_READER};

/// All that a picture depends on.
#[derive(Debug)]
pub struct Scene {
    /// Where it is seen from.
    pub camera: Camera,
    /// Participating media.
    pub media: Media,
    /// Surfaces, those of area lights among them.
    pub surfaces: Arc<Surfaces>,
    /// Lights, those of the file first, then emissive surfaces.
    pub lights: Arc<Lights>,
    /// Names of media and surfaces, where the picture tells of objects.
    pub objects: Objects,
    /// Groups of lights, and of media that glow.
    pub groups: Groups,
    /// Size and looks of the picture.
    pub film: FilmSettings,
    /// How it is computed.
    pub render: RenderSettings,
    /// The file it came from.
    pub path: PathBuf,
    /// Hash of the scene's text and of the content of every file it names, in hexadecimal.
    pub hash: String,
    /// Hash, in hexadecimal, of what is seen without media: camera, film size, surfaces and lights
    /// with the content of their files.
    pub static_hash: String,
    /// Hash, in hexadecimal, of what light in the scene depends on: media, surfaces and lights with the content of
    /// their files, and not the camera.
    pub light_hash: String,
    /// Voxels out of the camera's sight, where nothing else asks for voxels.
    pub unseen: Option<Unseen>,
    /// What was mended or is likely not meant, one line each.
    pub warnings: Vec<String>,
    /// What was chosen where the file says nothing, one line each.
    pub notes: Vec<String>,
    /// The scene that was made, where a VDB file was given alone.
    pub made: Option<Arc<BareScene>>,
    /// Where all of it is one frame later, where motion vectors are asked for.
    pub motion: Option<FrameMotion>,
    /// The same in the middles of equal parts of the time that the shutter is open, in their order; none where nothing moves.
    /// The scene itself is that in the middle of all.
    pub times: Vec<Self>,
}

impl Scene {
    /// The part of the film that is rendered.
    pub fn window(&self) -> Window {
        self.render.crop.unwrap_or(Window::whole(self.film.size))
    }

    /// The scene at each of the times that its camera sees: itself where nothing moves.
    pub fn moments(&self) -> &[Self] {
        if self.times.is_empty() { std::slice::from_ref(self) } else { &self.times }
    }

    /// That of a file with this text.
    #[cfg(test)]
    pub(crate) fn of_text(text: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.toml");
        std::fs::write(&path, text).unwrap();
        Self::load(&path, &LoadOptions::default()).unwrap()
    }
}

/// Voxels out of the camera's sight.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Unseen {
    /// Active ones in leaves of the files that lie wholly out of sight.
    pub voxels: u64,
    /// Whether they were left out.
    pub left_out: bool,
}

impl Unseen {
    /// How many are held.
    pub const fn held(&self) -> u64 {
        if self.left_out { 0 } else { self.voxels }
    }
}
