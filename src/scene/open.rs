//! Opens a scene file, a VDB file alone, or a frame of a sequence.

use std::path::Path;

use super::load::{self, Grids, StaticScene, Text};
use super::{LoadOptions, Scene, Sequence, outline};
use crate::error::{Error, Result};

impl Scene {
    /// Loads a scene file or, by its content, a bare VDB.
    ///
    /// # Errors
    /// Where a file cannot be read or used, or a key is wrong.
    pub fn load(path: &Path, options: &LoadOptions) -> Result<Self> {
        if let Some(frame) = options.frame {
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
