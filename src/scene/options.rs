//! What stands over a scene file, or beside a VDB file alone.

use super::bare::LookOptions;
use super::outline;
use super::reader::Setting;
use super::settings::Planning;
use crate::sequence::FrameTime;

/// What stands over a scene file, or beside a VDB file alone.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LoadOptions {
    /// Settings that stand over those of the file, later ones over earlier ones.
    pub settings: Vec<Setting>,
    /// How a VDB file alone is shown.
    pub look: LookOptions,
    /// For a VDB file alone: turn a level set into a fog volume where there is no fog volume.
    pub level_set_as_fog: bool,
    /// Which frame of a sequence is meant, or which time between two; over `frame` of `[motion]`.
    pub frame: Option<FrameTime>,
    /// For a shot (USD): the camera, by its path or name.
    pub camera: Option<String>,
    /// Bytes that reading a grid may take; no limit where none is given.
    pub memory: Option<u64>,
    /// Whether what the scene does not need is left out.
    pub planning: Planning,
}

impl LoadOptions {
    /// The same with the key `path`, such as `render.rays`, set to a `value` in TOML.
    #[must_use]
    pub fn with(mut self, path: &str, value: impl std::fmt::Display) -> Self {
        self.settings.push(Setting::new(path, value));
        self
    }

    /// The same with a film of `size`, width and height in pixels.
    #[must_use]
    pub fn size(self, size: [u32; 2]) -> Self {
        self.with("film.size", format!("{size:?}"))
    }

    /// The same with this many camera rays a pixel.
    #[must_use]
    pub fn rays(self, rays: u32) -> Self {
        self.with("render.rays", rays)
    }

    /// The same with this many photon paths.
    #[must_use]
    pub fn photons(self, photons: u64) -> Self {
        self.with("render.photons", photons)
    }

    /// The time of a scene of this `text`: that of the command line, of a setting, or of its `[motion]`.
    pub(super) fn frame_of(&self, text: &str) -> Option<FrameTime> {
        let of_setting = || {
            self.settings.iter().rev().map(Setting::parts).find(|(path, _)| *path == "motion.frame")
        };
        let number = || match of_setting() {
            Some((_, value)) => value.parse().ok(),
            None => outline::frame(text),
        };
        self.frame.or_else(|| number().and_then(FrameTime::nearest))
    }

    /// What a scene with these settings depends on beside its text and files.
    pub(super) fn hashed(&self) -> String {
        let of_scene = self.settings.iter().filter(|setting| setting.is_of_scene());
        of_scene.map(|setting| format!("{:?}\n", setting.parts())).collect()
    }

    /// Those of them that change light in the scene, whoever looks.
    pub(super) fn hashed_light(&self) -> String {
        let settings = self.settings.iter().filter(|s| outline::is_of_light(s.table()));
        settings.map(|setting| format!("{:?}\n", setting.parts())).collect()
    }

    /// Those of them that change what is seen of surfaces and lights.
    pub(super) fn hashed_static(&self) -> String {
        let is_static = |setting: &&Setting| outline::STATIC.contains(&setting.table());
        let settings = self.settings.iter().filter(is_static);
        settings.map(|setting| format!("{:?}\n", setting.parts())).collect()
    }
}
