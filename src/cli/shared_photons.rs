//! Photons that several pictures of one scene are rendered with: shot once, and read from a temporary file.

use std::collections::BTreeMap;
use std::path::PathBuf;

use tempfile::TempDir;

use super::render_args::Args;
use crate::error::{Error, Result};
use crate::render::{self, Control, Progress, SavedPhotons};
use crate::scene::Scene;
use crate::scene::plan::Needs;

/// Photons that several pictures share. A picture has the pixels that it has without them.
#[derive(Debug, Default)]
pub struct SharedPhotons {
    folder: Option<TempDir>,
    /// The pictures that are expected, by what their photons depend on.
    expected: BTreeMap<String, Shared>,
}

#[derive(Debug, Default)]
struct Shared {
    /// Pictures.
    count: usize,
    /// Where the photons are, once they are shot.
    file: Option<PathBuf>,
}

impl SharedPhotons {
    /// Counts the picture of `scene` that `args` ask for among those that are to come.
    pub(super) fn expect(&mut self, args: &Args, scene: &Scene) {
        if let Some(key) = key(args, scene) {
            self.expected.entry(key).or_default().count += 1;
        }
    }

    /// The photons for the picture of `scene` that `args` ask for, where another one is expected that has the same. They
    /// are shot for the first of those.
    ///
    /// # Errors
    /// Where there is no place for them, or they cannot be read.
    pub(super) fn of(
        &mut self,
        args: &Args,
        scene: &Scene,
        progress: &dyn Progress,
    ) -> Result<Option<SavedPhotons>> {
        let Some(key) = key(args, scene) else { return Ok(None) };
        let Some(shared) = self.expected.get_mut(&key).filter(|shared| shared.count > 1) else {
            return Ok(None);
        };
        if shared.file.is_none() {
            let folder = match self.folder.take() {
                Some(folder) => folder,
                None => tempfile::tempdir()
                    .map_err(|e| Error::Failed(format!("no temporary folder can be made: {e}")))?,
            };
            let name = blake3::hash(key.as_bytes()).to_hex();
            let file = self.folder.insert(folder).path().join(format!("{name}.fog"));
            if render::save_photons(scene, &file, false, Control::from(progress)).is_err() {
                // Each picture shoots its own, and tells what is wrong.
                shared.count = 0;
                return Ok(None);
            }
            shared.file = Some(file);
        }
        shared.file.as_deref().map(|file| SavedPhotons::open(file, scene)).transpose()
    }
}

/// What the photons of the picture depend on, with what their strategies do; `None` where it has photons of its own.
fn key(args: &Args, scene: &Scene) -> Option<String> {
    let render = &scene.render;
    let has_own = args.reference
        || args.limits.time.is_some()
        || args.limits.memory.is_some()
        || args.photons.photons_from.is_some()
        || render.error.is_some()
        || render.pass.is_some()
        || render.photons == 0
        || Needs::new(scene, render).parts
        || !scene.times.is_empty()
        || !Needs::new(scene, render).photons();
    (!has_own).then(|| format!("{} {}", render::photons_key(scene), render.rays))
}
