//! Opens a scene file, a VDB file alone, a shot (USD), or a frame of a sequence.

use std::path::Path;

use super::load::{self, Grids, StaticScene, Text};
use super::usd::{self, Shot, ShotScene};
use super::{LoadOptions, Scene, Sequence, outline};
use crate::error::{Error, Result};

impl Scene {
    /// Loads a scene file, a USD file or, by its content, a bare VDB.
    ///
    /// # Errors
    /// Where a file cannot be read or used, or a key is wrong.
    pub fn load(path: &Path, options: &LoadOptions) -> Result<Self> {
        if let Some(frame) = options.frame
            && !usd::is_usd(path)
        {
            return Sequence::open(path, options)?.load(frame);
        }
        if let Some(pattern) = load::bare_sequence(path) {
            let name = path.display().to_string();
            return Err(Error::Usage(outline::without_frame(&name, &pattern)));
        }
        let mut grids = Grids::within(options.memory);
        let text = Text::open(path, options, &mut grids)?;
        let file = text.read(path, options, None)?;
        let static_scene = StaticScene::build(&text, &file, options)?;
        load::build(path, &text, &file, static_scene, grids, options)
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
    Shot::open(path, options.camera.as_deref())?.scene(options.frame)
}
