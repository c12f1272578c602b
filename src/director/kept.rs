//! The first look, kept in a file for another medium.

use std::path::Path;

use super::Sight;
use crate::error::{Error, Result};
use crate::image::{FAR, read_layers, write_exr_layers};
use crate::scene::Scene;

/// The attribute that says what was looked at.
const SUBJECT: &str = "fogbow:sight";

impl Sight {
    /// Writes distances as `Z` and the snapshot as `R`, `G`, `B`.
    ///
    /// # Errors
    /// Where the file cannot be written.
    pub fn write(&self, path: &Path, scene: &Scene) -> Result<()> {
        let [r, g, b] = self.snapshot.channels();
        let z: Vec<f32> = self.depth.iter().map(|z| z.min(FAR) as f32).collect();
        let layers = [("R", &r[..]), ("G", &g[..]), ("B", &b[..]), ("Z", &z[..])];
        let (width, height) = (self.snapshot.width(), self.snapshot.height());
        write_exr_layers(path, width, height, &layers, &[(SUBJECT, subject(scene))])
    }

    /// Reads what [`write`](Self::write) wrote.
    ///
    /// # Errors
    /// Where the file cannot be read, or was written for another size, camera, number or extent of
    /// surfaces, or number of lights.
    pub fn read(path: &Path, scene: &Scene) -> Result<Self> {
        let layers = read_layers(path)?;
        let right = "give the z.exr that `fogbow maps` wrote for this scene";
        let found = layers.attributes.get(SUBJECT).ok_or_else(|| {
            Error::file(path, format!("was not written by `fogbow maps`; {right}"))
        })?;
        let size = [layers.width, layers.height];
        if *found != subject(scene) || size != scene.film.size.map(|side| side as usize) {
            let problem = "was written for another size, camera, set of surfaces or lights";
            return Err(Error::file(path, format!("{problem}; {right}")));
        }
        let (Some(z), Some(snapshot)) = (layers.get("Z"), layers.image()) else {
            return Err(Error::file(path, format!("lacks a layer of Z, R, G, B; {right}")));
        };
        let far = |z: &f32| if f64::from(*z) >= FAR { f64::INFINITY } else { f64::from(*z) };
        Ok(Self { depth: z.iter().map(far).collect(), snapshot })
    }
}

/// What a look depends on, as far as can be told cheaply.
fn subject(scene: &Scene) -> String {
    let (surfaces, lights) = (scene.surfaces.surfaces().len(), scene.lights.lights.len());
    let all = format!("{:?} {surfaces} {:?} {lights}", scene.camera, scene.surfaces.bounds());
    blake3::hash(all.as_bytes()).to_hex().to_string()
}
