//! The first look, kept for another medium: from frame to frame, or in a file.

use std::path::Path;

use super::Snapshot;
use crate::error::{Error, Result};
use crate::image::{FAR, read_layers, write_exr_layers};
use crate::scene::{RenderSettings, Scene};
use crate::work::Work;

/// The attribute that says what was looked at.
const SUBJECT: &str = "fogbow:sight";

/// A look with what it was a look at, so that it is taken for no other.
#[derive(Debug, Clone, PartialEq)]
pub struct CachedSnapshot {
    /// Distances and snapshot.
    pub sight: Snapshot,
    /// What looking took; nothing where it was read from a file.
    pub work: Work,
    subject: String,
}

impl CachedSnapshot {
    /// `sight`, that of `scene` under `settings`, which took `work`.
    pub fn new(sight: Snapshot, work: Work, scene: &Scene, settings: &RenderSettings) -> Self {
        Self { sight, work, subject: subject(scene, settings) }
    }

    /// Whether a look at `scene` under `settings` would see the same: camera, size of film and
    /// maps, surfaces with their materials, lights and seed are, media need not be.
    pub fn suits(&self, scene: &Scene, settings: &RenderSettings) -> bool {
        self.subject == subject(scene, settings)
    }

    /// Writes distances as `Z` and the snapshot as `R`, `G`, `B`.
    ///
    /// # Errors
    /// Where the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let Snapshot { depth, snapshot } = &self.sight;
        let [r, g, b] = snapshot.channels();
        let z: Vec<f32> = depth.iter().map(|z| z.min(FAR) as f32).collect();
        let layers = [("R", &r[..]), ("G", &g[..]), ("B", &b[..]), ("Z", &z[..])];
        let attributes = [(SUBJECT, self.subject.clone())];
        write_exr_layers(path, snapshot.width(), snapshot.height(), &layers, &attributes)
    }

    /// Reads what [`write`](Self::write) wrote.
    ///
    /// # Errors
    /// Where the file cannot be read, or does not [suit](Self::suits).
    pub fn read(path: &Path, scene: &Scene, settings: &RenderSettings) -> Result<Self> {
        let layers = read_layers(path)?;
        let right = "give the z.exr that `fogbow maps` wrote for this scene";
        let found = layers.attributes.get(SUBJECT).ok_or_else(|| {
            Error::file(path, format!("was not written by `fogbow maps`; {right}"))
        })?;
        let size = settings.directing.map_size(scene.film.size).map(|side| side as usize);
        if *found != subject(scene, settings) || [layers.width, layers.height] != size {
            let problem = "was written for another camera, size, resolution or seed, or for other \
                           surfaces or lights";
            return Err(Error::file(path, format!("{problem}; {right}")));
        }
        let (Some(z), Some(snapshot)) = (layers.get("Z"), layers.image()) else {
            return Err(Error::file(path, format!("lacks a layer of Z, R, G, B; {right}")));
        };
        let far = |z: &f32| if f64::from(*z) >= FAR { f64::INFINITY } else { f64::from(*z) };
        let sight = Snapshot { depth: z.iter().map(far).collect(), snapshot };
        Ok(Self { sight, work: Work::default(), subject: found.clone() })
    }
}

/// All that a look depends on, as a hash.
fn subject(scene: &Scene, settings: &RenderSettings) -> String {
    let (size, seed) = (settings.directing.map_size(scene.film.size), settings.seed);
    let all = format!("{} {size:?} {seed}", scene.still);
    blake3::hash(all.as_bytes()).to_hex().to_string()
}
