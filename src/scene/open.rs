//! Opens a scene file, a VDB file alone, a shot (USD), or a frame of a sequence.

use std::path::{Path, PathBuf};

use super::hash::Sources;
use super::load::{self, Grids, StaticScene, Text};
use super::usd::{self, Shot, ShotScene};
use super::{LoadOptions, Scene, Sequence, outline};
use crate::error::{Error, Result};
use crate::sequence::FrameTime;

impl Scene {
    /// Loads a scene file, a USD file or, by its content, a bare VDB.
    ///
    /// # Errors
    /// Where a file cannot be read or used, or a key is wrong.
    pub fn load(path: &Path, options: &LoadOptions) -> Result<Self> {
        OpenScene::of_file(path).load(options)
    }
}

/// A scene to load with one set of options after another. Each file is read once, and what lies in it later has no
/// effect.
#[derive(Debug, Default)]
pub struct OpenScene {
    path: PathBuf,
    /// That of the scene file, once it is read; `None` for a VDB file.
    text: Option<String>,
    grids: Grids,
    /// Files that were read, with hashes of their content.
    sources: Sources,
    /// Camera, surfaces and lights, with the text and options that they follow from.
    static_scene: Option<(String, StaticScene)>,
}

impl OpenScene {
    /// That of a scene file or, by its content, of a bare VDB file. Nothing is read yet.
    pub fn of_file(path: &Path) -> Self {
        Self { path: path.to_path_buf(), ..Self::default() }
    }

    /// That of a `text` in TOML. Messages call it `name`, and paths are relative to the folder of that.
    pub fn of_text(name: &Path, text: String) -> Self {
        Self { text: Some(text), ..Self::of_file(name) }
    }

    /// The scene under `options`. A frame of a sequence is read anew.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn load(&mut self, options: &LoadOptions) -> Result<Scene> {
        let is_sequence = !usd::is_usd(&self.path);
        let pattern = load::bare_sequence(&self.path);
        let frame = if pattern.is_some() { options.frame_of("") } else { options.frame };
        if let Some(frame) = frame.filter(|_| is_sequence) {
            return Sequence::open(&self.path, options)?.load(frame);
        }
        if let Some(pattern) = pattern {
            let name = self.path.display().to_string();
            return Err(Error::Usage(outline::without_frame(&name, &pattern)));
        }
        self.grids.limit(options.memory);
        let text = match &self.text {
            Some(text) => Text::given(&self.path, text.clone(), options)?,
            None => Text::open(&self.path, options, &mut self.grids)?,
        };
        if let Text::File(text) = &text {
            self.text.get_or_insert_with(|| text.clone());
        }
        let file = text.read(&self.path, options, options.frame_of(text.as_str()))?;
        let key = format!("{}\n{:?}\n{}", text.as_str(), file.film.size, options.hashed());
        let known = self.static_scene.take().filter(|(known, _)| *known == key);
        let static_scene = match known {
            Some((_, known)) => known,
            None => StaticScene::build(&text, &file, options)?,
        };
        // Meshes of a shot may differ under the same names.
        if !matches!(text, Text::Shot(_)) {
            self.static_scene = Some((key, static_scene.clone()));
        }
        let static_scene = static_scene.knowing(&self.sources);
        let (scene, sources) =
            load::build(&self.path, &text, &file, static_scene, &mut self.grids, options)?;
        self.sources = sources;
        Ok(scene)
    }
}

/// The scene of the frame of a USD file that `options` name.
///
/// # Errors
/// Where the file or one that it asks for cannot be read or used.
pub fn read_shot(path: &Path, options: &LoadOptions) -> Result<ShotScene> {
    if !usd::is_usd(path) {
        let problem = "is no shot; give a USD file (.usd, .usda, .usdc, .usdz)";
        return Err(Error::file(path, problem));
    }
    Shot::open(path, options.camera.as_deref())?.scene(options.frame.map(FrameTime::frame))
}
