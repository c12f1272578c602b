//! Film and render settings, their defaults, and what the command line puts over them.

use super::directing::{Directing, DirectingOverrides, Director, name_of};
use crate::image::{ViewTransform, Window};

/// Largest width and height of a film, in pixels.
pub const MAX_SIDE: u32 = 65_536;
/// Largest number of pixels of a film.
pub const MAX_PIXELS: u64 = 1 << 28;
/// Largest number of camera rays a pixel.
pub const MAX_RAYS: u32 = 1 << 20;
/// Largest number of photon paths that can be asked for.
pub const MAX_PHOTONS: u64 = 200_000_000;
/// Largest order of volume scattering that can be asked for; leave it out for no limit.
pub const MAX_SCATTER: u32 = 1_000_000;

/// What the picture looks like.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilmSettings {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Exposure of the PNG in stops.
    pub exposure: f64,
    /// View transform of the PNG.
    pub view: ViewTransform,
}

impl Default for FilmSettings {
    fn default() -> Self {
        Self { size: [960, 540], exposure: 0.0, view: ViewTransform::Agx }
    }
}

/// Where rays that media scatter are followed further before photons are asked: then what there is of
/// noise is grain, where photons alone leave blotches.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FinalGather {
    /// Where a phase function is peaked; where noise is taken off the picture, already where it is
    /// less so.
    #[default]
    Auto,
    /// Nowhere.
    Never,
    /// In all media that have an end and lie before the camera.
    Always,
}

impl FinalGather {
    /// Each by its name.
    pub const ALL: &[(&str, Self)] =
        &[("auto", Self::Auto), ("never", Self::Never), ("always", Self::Always)];

    /// Its name in scene files and on the command line.
    pub fn name(self) -> &'static str {
        name_of(Self::ALL, self)
    }
}

/// Whether a render leaves out what the scene does not need.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Planning {
    /// It does.
    #[default]
    Needed,
    /// It does all work that there is, to show that leaving it out changes nothing.
    Everything,
}

/// How the picture is computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RenderSettings {
    /// Camera rays a pixel.
    pub rays: u32,
    /// Photons the map is asked to hold.
    pub photons: u64,
    /// Gather radius in metres; by default from the photon count and the voxel size.
    pub radius: Option<f64>,
    /// March step in metres; by default from the voxel size.
    pub step: Option<f64>,
    /// Who decides what a pixel may spend.
    pub director: Director,
    /// How it is asked to.
    pub directing: Directing,
    /// Seed of every random stream.
    pub seed: u64,
    /// Highest order of volume scattering, 1 being single scattering; no limit by default.
    pub max_scatter: Option<u32>,
    /// Where scattered rays are followed.
    pub final_gather: FinalGather,
    /// Whether noise is to be taken off the picture when it is done.
    pub denoise: bool,
    /// Whether what the scene does not need is left out.
    pub planning: Planning,
    /// The part of the film that is rendered; all of it where none is given.
    pub crop: Option<Window>,
}

impl Default for RenderSettings {
    fn default() -> Self {
        Self {
            rays: 16,
            photons: 1_000_000,
            radius: None,
            step: None,
            director: Director::Fixed,
            directing: Directing::default(),
            seed: 0,
            max_scatter: None,
            final_gather: FinalGather::Auto,
            denoise: false,
            planning: Planning::Needed,
            crop: None,
        }
    }
}

/// Settings that stand over those of the scene file; the values are in the ranges of the fields
/// they replace.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Overrides {
    /// See [`FilmSettings::size`].
    pub size: Option<[u32; 2]>,
    /// See [`FilmSettings::exposure`].
    pub exposure: Option<f64>,
    /// See [`FilmSettings::view`].
    pub view: Option<ViewTransform>,
    /// See [`RenderSettings::rays`].
    pub rays: Option<u32>,
    /// See [`RenderSettings::photons`].
    pub photons: Option<u64>,
    /// See [`RenderSettings::radius`].
    pub radius: Option<f64>,
    /// See [`RenderSettings::step`].
    pub step: Option<f64>,
    /// See [`RenderSettings::director`].
    pub director: Option<Director>,
    /// See [`RenderSettings::directing`].
    pub directing: DirectingOverrides,
    /// See [`RenderSettings::seed`].
    pub seed: Option<u64>,
    /// See [`RenderSettings::max_scatter`].
    pub max_scatter: Option<u32>,
    /// See [`RenderSettings::final_gather`].
    pub final_gather: Option<FinalGather>,
    /// See [`RenderSettings::denoise`].
    pub denoise: Option<bool>,
}

impl FilmSettings {
    /// These settings with `over` put over them.
    pub fn overridden(self, over: &Overrides) -> Self {
        Self {
            size: over.size.unwrap_or(self.size),
            exposure: over.exposure.unwrap_or(self.exposure),
            view: over.view.unwrap_or(self.view),
        }
    }
}

impl RenderSettings {
    /// These settings with `over` put over them.
    pub fn overridden(self, over: &Overrides) -> Self {
        Self {
            rays: over.rays.unwrap_or(self.rays),
            photons: over.photons.unwrap_or(self.photons),
            radius: over.radius.or(self.radius),
            step: over.step.or(self.step),
            director: over.director.unwrap_or(self.director),
            directing: self.directing.overridden(&over.directing),
            seed: over.seed.unwrap_or(self.seed),
            max_scatter: over.max_scatter.or(self.max_scatter),
            final_gather: over.final_gather.unwrap_or(self.final_gather),
            denoise: over.denoise.unwrap_or(self.denoise),
            planning: self.planning,
            crop: self.crop,
        }
    }
}
