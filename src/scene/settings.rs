//! Settings of film and render, as the stages take them. Names, ranges and defaults are in the tables of
//! [`keys`](super::keys).

use std::fmt;

use serde::{Deserialize, Serialize};

use super::directing::{Directing, Director, Importance, name_of};
use crate::image::{View, ViewTransform, Window};

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

/// Size and look of the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilmSettings {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Exposure of the PNG in stops; `None` where it is metered.
    pub exposure: Option<f64>,
    /// View transform of the PNG.
    pub view: ViewTransform,
}

impl FilmSettings {
    /// The view of the PNG, with an exposure of 0 where none was given or metered.
    pub fn shown(&self) -> View {
        View { exposure: self.exposure.unwrap_or(0.0), transform: self.view }
    }
}

/// Estimator of the light that a medium scatters after it was scattered, reflected or emitted before.
/// Light that is scattered once comes from sampling lights, or from a cache of that.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Strategy {
    /// The beam radiance estimate: photons are gathered along each ray (Jarosz, Zwicker and Jensen
    /// 2008).
    #[default]
    Beams,
    /// Flights of photons leave the light that they scatter toward the camera on a sparse grid, which
    /// rays read by trilinear interpolation.
    FluenceTowardEye,
    /// Flights leave moments of radiance on a sparse grid. Each ray makes a final gather (Jensen 1996)
    /// that is scattered on until those moments tell the rest.
    Moments,
    /// As [`Moments`](Self::Moments), with final gathers that start in cells and are shared by all
    /// rays that read those (Keller, Dahm and Binder 2014, "Path Space Filtering").
    SharedGathers,
    /// Each ray is scattered on until it leaves the media or is absorbed: path tracing, without photons
    /// in this medium.
    Traced,
}

impl Strategy {
    /// Its name in scene files, on the command line and in reports.
    pub fn name(self) -> &'static str {
        StrategyRequest::Asked(self).name()
    }
}

/// Who decides which estimator lights a medium.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum StrategyRequest {
    /// A pilot, which measures noise and cost of each.
    #[default]
    Auto,
    /// The user, for all media that can have it.
    Asked(Strategy),
}

impl StrategyRequest {
    /// Each by its name.
    pub const ALL: &[(&str, Self)] = &[
        ("auto", Self::Auto),
        ("beams", Self::Asked(Strategy::Beams)),
        ("fluence-toward-eye", Self::Asked(Strategy::FluenceTowardEye)),
        ("moments", Self::Asked(Strategy::Moments)),
        ("shared-gathers", Self::Asked(Strategy::SharedGathers)),
        ("traced", Self::Asked(Strategy::Traced)),
    ];

    /// Its name in scene files, on the command line and in reports.
    pub fn name(self) -> &'static str {
        name_of(Self::ALL, self)
    }
}

/// Whether final gathers may be chosen: a coarser word for some [strategies](Strategy).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FinalGather {
    /// Any strategy is chosen.
    #[default]
    Auto,
    /// One without final gathers.
    Never,
    /// One with final gathers, where cells can hold the moments that they end at.
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

/// The error at which a render ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ErrorGoal {
    /// So much of the radiance, in the worst hundredth of the picture's blocks.
    Relative(f64),
    /// The least difference that is visible, in those: hardly a pixel is further off.
    Visible,
}

impl ErrorGoal {
    /// The word for [`Visible`](Self::Visible) in scene files and on the command line.
    pub const VISIBLE: &str = "visible";

    /// The error that is allowed, relative or in least visible differences.
    pub const fn value(self) -> f64 {
        match self {
            Self::Relative(error) => error,
            Self::Visible => 1.0,
        }
    }
}

impl fmt::Display for ErrorGoal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Relative(error) => error.fmt(f),
            Self::Visible => f.write_str(Self::VISIBLE),
        }
    }
}

/// Whether a render leaves out work that the scene does not need.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Planning {
    /// It leaves it out.
    #[default]
    Needed,
    /// It does all work, so that tests can show that leaving it out changes nothing.
    Everything,
}

/// Settings of a render.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RenderSettings {
    /// Camera rays a pixel.
    pub rays: u32,
    /// Photon paths.
    pub photons: u64,
    /// Gather radius in metres; by default from the photon count and the voxel size.
    pub radius: Option<f64>,
    /// March step in metres; by default from the voxel size.
    pub step: Option<f64>,
    /// What decides on the budget of a pixel.
    pub director: Director,
    /// Settings of the director.
    pub directing: Directing,
    /// Seed of every random stream.
    pub seed: u64,
    /// Highest order of volume scattering, 1 being single scattering; no limit by default.
    pub max_scatter: Option<u32>,
    /// Who decides which estimator lights a medium.
    pub strategy: StrategyRequest,
    /// Whether final gathers may be chosen.
    pub final_gather: FinalGather,
    /// Whether the finished picture is denoised.
    pub denoise: bool,
    /// Whether the finished picture is reconstructed from its components.
    pub reconstruct: bool,
    /// Whether work that the scene does not need is left out.
    pub planning: Planning,
    /// The error at which it ends, with as many rays and photons as that takes; by default it has those of the settings.
    pub error: Option<ErrorGoal>,
    /// The part of the film that is rendered; `None` for all of it.
    pub crop: Option<Window>,
}

impl RenderSettings {
    /// The director's settings as its kind takes them.
    pub fn effective_directing(&self) -> Directing {
        self.directing.of(self.director)
    }

    /// Whether the director measures the error of the picture's first rays.
    pub fn measures_error(&self) -> bool {
        let Directing { x, weights, .. } = self.effective_directing();
        let has_x = matches!(self.director, Director::X | Director::Xs);
        has_x && x == Importance::Error && weights[0] > 0.0
    }

    /// Whether rays and photons are in two independent halves.
    pub fn in_halves(&self) -> bool {
        self.reconstruct || self.measures_error() || self.error.is_some()
    }

    /// Whether the finished picture is reconstructed: where it is asked for, and where rays are given by the error that
    /// is left after it, unless the picture is denoised.
    pub fn reconstructs(&self) -> bool {
        self.reconstruct || (self.measures_error() && !self.denoise)
    }
}
