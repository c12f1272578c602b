//! `--photons-to` and `--photons-from`: photons that are shot once for many pictures.

use std::path::PathBuf;

use crate::error::{Error, Result};
use crate::render::SavedPhotons;
use crate::scene::Scene;

/// Photons that are saved, or were.
#[derive(Debug, clap::Args)]
pub(super) struct PhotonArgs {
    /// Shoot the photons, save them in this file, and render no picture. --photons-from reads them for all crops
    /// and equal passes of it.
    #[arg(long, value_name = "MAP.fog", conflicts_with_all = [
        "output", "photons_from", "reference", "frames", "pass", "crop", "resume", "time", "memory", "preview",
        "view", "tev",
    ])]
    pub(super) photons_to: Option<PathBuf>,
    /// Read saved photons in place of shooting any.
    #[arg(long, value_name = "MAP.fog", conflicts_with = "reference")]
    pub(super) photons_from: Option<PathBuf>,
    /// With --photons-to: save photons that serve any camera, aimed at the whole scene in place of what this camera
    /// sees.
    #[arg(long)]
    pub(super) any_camera: bool,
}

impl PhotonArgs {
    /// The photons that `scene` is rendered with, where they were saved.
    ///
    /// # Errors
    /// Where they cannot be read, are those of another picture, an error is the goal, or they are to be for any camera.
    pub(super) fn open(&self, scene: &mut Scene) -> Result<Option<SavedPhotons>> {
        self.check_goal(scene)?;
        if self.any_camera {
            let problem =
                "--any-camera says for whom --photons-to saves photons; give both, or neither";
            return Err(Error::Usage(problem.into()));
        }
        let path = self.photons_from.as_ref();
        let saved = path.map(|path| SavedPhotons::open(path, scene)).transpose()?;
        scene.render.saved_photons = saved.as_ref().map(SavedPhotons::name);
        Ok(saved)
    }

    /// Refuses photons that are saved, or were, where an error is the goal of `scene` or it is blurred by motion.
    ///
    /// # Errors
    /// With what to give instead.
    pub(super) fn check_goal(&self, scene: &Scene) -> Result<()> {
        let flags = [("--photons-to", &self.photons_to), ("--photons-from", &self.photons_from)];
        let asked = flags.iter().find(|(_, path)| path.is_some());
        if let Some((flag, _)) = asked.filter(|_| !scene.times.is_empty()) {
            return Err(Error::Usage(format!(
                "{flag} and motion blur exclude each other, since each time of the shutter has photons of its own: leave it \
                 out, or give motion.shutter = 0"
            )));
        }
        match asked.filter(|_| scene.render.error.is_some()) {
            Some((flag, _)) => Err(Error::Usage(format!(
                "{flag} and an error as the goal exclude each other, since each round shoots photons of its own: \
                 give rays and photons instead of the error"
            ))),
            None => Ok(()),
        }
    }
}
