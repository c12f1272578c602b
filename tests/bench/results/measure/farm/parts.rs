//! Parts of a picture, rendered by photons that they shoot or read.

use std::path::Path;

use fogbow::image::Window;
use fogbow::render::{Control, save_photons};
use fogbow::render::{Earlier, PhotonsReport, Progress, Rendered, SavedPhotons, render_next};
use fogbow::scene::{PicturePass, RenderSettings, Scene};
use rayon::ThreadPool;

use crate::measure::stages::{Watched, watched};
use crate::pages::Result;

/// A scene with what renders it.
pub struct Picture<'a> {
    pub scene: Scene,
    pub pool: &'a ThreadPool,
}

impl Picture<'_> {
    /// Shoots the photons and saves them in `path`.
    pub fn save(&self, path: &Path) -> Result<Watched<PhotonsReport>> {
        let work = |watch: &dyn Progress| {
            self.pool.install(|| save_photons(&self.scene, path, false, Control::from(watch)))
        };
        Ok(watched(work)?)
    }

    /// Renders a pass, or the whole, and of it a crop, or all: by `saved` photons, or its own.
    pub fn part(
        &self,
        pass: Option<PicturePass>,
        crop: Option<Window>,
        saved: Option<&SavedPhotons>,
    ) -> Result<Watched<Rendered>> {
        let settings = RenderSettings {
            pass,
            crop,
            saved_photons: saved.map(SavedPhotons::name),
            ..self.scene.render
        };
        let work = |watch: &dyn Progress| {
            let earlier = Earlier { photons: saved, ..Earlier::default() };
            self.pool.install(|| render_next(&self.scene, &settings, earlier, watch))
        };
        Ok(watched(work)?)
    }
}
