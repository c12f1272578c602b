//! The scene of a cell.

use crate::error::Result;
use crate::scene::Scene;
use crate::vdb::GridToWrite;
use crate::verify::scenes;

/// A scene, as the parts of its file that cells change.
#[derive(Debug, Clone)]
pub(super) struct Setup {
    /// Keys of `[camera]`.
    pub camera: String,
    /// Width and height of the picture.
    pub size: [u32; 2],
    /// Camera rays a pixel.
    pub rays: u32,
    /// Photon paths.
    pub photons: u64,
    /// Further keys of `[render]`.
    pub render: String,
    /// Keys of `[[medium]]`, which may name `grids.vdb`.
    pub medium: String,
    /// Keys of `[[light]]`.
    pub light: String,
    /// What `grids.vdb` holds.
    pub grids: Vec<GridToWrite>,
}

/// An environment of radiance 1.
pub(super) const SKY: &str = "type = \"environment\"\nradiance = 1.0";

impl Setup {
    /// The scene, loaded from a file.
    pub fn scene(&self) -> Result<Scene> {
        let Self { camera, size, rays, photons, render, medium, light, grids } = self;
        let text = format!(
            "[camera]\n{camera}\n[film]\nsize = {size:?}\n\
             [render]\nrays = {rays}\nphotons = {photons}\n{render}\n\
             [[medium]]\n{medium}\n[[light]]\n{light}\n"
        );
        scenes::scene(&text, grids)
    }
}

impl Default for Setup {
    fn default() -> Self {
        Self {
            camera: String::new(),
            size: [4, 4],
            rays: 4,
            photons: 500,
            render: String::new(),
            medium: String::new(),
            light: SKY.into(),
            grids: Vec::new(),
        }
    }
}
