//! A snapshot that is reused while only media change: from frame to frame, or from a file.

use std::path::Path;

use super::Snapshot;
use crate::error::{Error, Result};
use crate::image::{FAR, read_layers, write_exr_layers};
use crate::scene::{RenderSettings, Scene};
use crate::work::Work;

/// The EXR attribute that holds the key.
///
/// Unit: none. Definition: of the file format.
const KEY_ATTRIBUTE: &str = "fogbow:sight";

/// A snapshot with a key of all that it depends on, so that it is not used for another scene.
#[derive(Debug, Clone, PartialEq)]
pub struct CachedSnapshot {
    /// First-hit distances and direct light.
    pub snapshot: Snapshot,
    /// Work for them; 0 where they were read from a file.
    pub work: Work,
    key: String,
}

impl CachedSnapshot {
    /// Keeps `snapshot` of `scene` under `settings`, which took `work`.
    pub fn new(snapshot: Snapshot, work: Work, scene: &Scene, settings: &RenderSettings) -> Self {
        Self { snapshot, work, key: key(scene, settings) }
    }

    /// Whether a snapshot of `scene` under `settings` would be equal: where camera, sizes of film and
    /// maps, surfaces with their materials, lights and seed are. Media may differ.
    pub fn matches(&self, scene: &Scene, settings: &RenderSettings) -> bool {
        self.key == key(scene, settings)
    }

    /// Writes an EXR with the distances as `Z` and the light as `R`, `G`, `B`.
    ///
    /// # Errors
    /// Where the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let Snapshot { depth, snapshot } = &self.snapshot;
        let [r, g, b] = snapshot.channels();
        let z: Vec<f32> = depth.iter().map(|z| z.min(FAR) as f32).collect();
        let layers = [("R", &r[..]), ("G", &g[..]), ("B", &b[..]), ("Z", &z[..])];
        let attributes = [(KEY_ATTRIBUTE, self.key.clone())];
        write_exr_layers(path, snapshot.width(), snapshot.height(), &layers, &attributes)
    }

    /// Reads a file of [`write`](Self::write).
    ///
    /// # Errors
    /// Where the file cannot be read, or does not [match](Self::matches).
    pub fn read(path: &Path, scene: &Scene, settings: &RenderSettings) -> Result<Self> {
        let layers = read_layers(path)?;
        let right = "give the z.exr that `fogbow maps` wrote for this scene";
        let found = layers.attributes.get(KEY_ATTRIBUTE).ok_or_else(|| {
            Error::file(path, format!("was not written by `fogbow maps`; {right}"))
        })?;
        let size = settings.directing.map_size(scene.film.size).map(|side| side as usize);
        if *found != key(scene, settings) || [layers.width, layers.height] != size {
            let problem = "was written for another camera, size, resolution or seed, or for other \
                           surfaces or lights";
            return Err(Error::file(path, format!("{problem}; {right}")));
        }
        let (Some(z), Some(snapshot)) = (layers.get("Z"), layers.image()) else {
            return Err(Error::file(path, format!("lacks a layer of Z, R, G, B; {right}")));
        };
        let far = |z: &f32| if f64::from(*z) >= FAR { f64::INFINITY } else { f64::from(*z) };
        let snapshot = Snapshot { depth: z.iter().map(far).collect(), snapshot };
        Ok(Self { snapshot, work: Work::default(), key: found.clone() })
    }
}

/// Hash of all that a snapshot depends on.
fn key(scene: &Scene, settings: &RenderSettings) -> String {
    let (size, seed) = (settings.directing.map_size(scene.film.size), settings.seed);
    let all = format!("{} {size:?} {seed}", scene.static_hash);
    blake3::hash(all.as_bytes()).to_hex().to_string()
}
