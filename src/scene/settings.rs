//! Settings of film and render, as the stages take them. Names, ranges and defaults are in the tables of
//! [`keys`](super::keys).

use std::fmt;
use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::aov::Aovs;
use super::directing::{Directing, Director, Importance, name_of};
use super::picture_pass::PicturePass;
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
    /// Passes that are stored beside the layers of every picture.
    pub passes: Aovs,
    /// Whether colours are stored as half floats.
    pub half: bool,
    /// Whether a deep picture is written beside it.
    pub deep: bool,
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
    /// Whether a medium of this strategy has a grid of moments, at which final gathers end.
    pub const fn holds_moments(self) -> bool {
        matches!(self, Self::Moments | Self::SharedGathers)
    }

    /// Whether final gathers are made in a medium of this strategy, by rays or for cells. They do not count orders of
    /// scattering.
    pub const fn makes_gathers(self) -> bool {
        self.holds_moments() || matches!(self, Self::Traced)
    }

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
    /// The pass of the picture that is rendered; `None` for all of it.
    pub pass: Option<PicturePass>,
    /// Name of the saved photons that are read in place of shooting any.
    pub saved_photons: Option<PhotonsName>,
}

/// The name of saved photons: the first bytes of the hash of their file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PhotonsName(pub [u8; 8]);

impl fmt::Display for PhotonsName {
    /// In hexadecimal.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:016x}", u64::from_be_bytes(self.0))
    }
}

impl RenderSettings {
    /// The photon paths that are traced, by their indices: those of the pass, or all.
    pub fn paths(&self) -> Range<u64> {
        self.pass.map_or(0..self.photons, |pass| pass.share(self.photons, self.rays))
    }

    /// How many photon paths are traced.
    pub fn path_count(&self) -> u64 {
        let Range { start, end } = self.paths();
        end - start
    }

    /// Why the picture cannot be rendered in `pass` and others of as many, and what would be right.
    ///
    /// # Errors
    /// With that.
    pub fn check_pass(&self, pass: PicturePass) -> Result<(), String> {
        let Self { rays, photons, director, .. } = *self;
        let crops = "leave it out, or render crops of the frame by --crop";
        if pass.count > rays {
            return Err(format!(
                "a pixel has {rays} rays, and each pass needs one of its own; give at most {rays} passes or more --rays"
            ));
        }
        if (1..u64::from(rays)).contains(&photons) {
            return Err(format!(
                "the picture has {photons} photons, fewer than rays a pixel; give at least {rays} --photons"
            ));
        }
        if self.denoise || self.reconstruct {
            return Err(format!(
                "noise is taken off a whole picture, and off one pass it would leave a blur that no other pass \
                 mends; {crops}"
            ));
        }
        if self.measures_error() || director == Director::Variance {
            let name = director.name();
            let other = if self.measures_error() { ", or direct by --x scattering" } else { "" };
            return Err(format!(
                "the director {name} measures noise by photons that one pass has not; {crops}{other}"
            ));
        }
        Ok(())
    }

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_that_need_all_of_their_photons_at_once_have_no_passes() {
        let pass = PicturePass { count: 8, number: 3 };
        let whole = RenderSettings { rays: 8, photons: 1000, ..RenderSettings::default() };
        assert_eq!(whole.check_pass(pass), Ok(()));
        let by_scattering = Directing { x: Importance::Scattering, ..whole.directing };
        let unmeasured =
            RenderSettings { director: Director::Xs, directing: by_scattering, ..whole };
        for free in [
            RenderSettings { photons: 0, ..whole },
            RenderSettings { director: Director::XsPaper, ..whole },
            unmeasured,
        ] {
            assert_eq!(free.check_pass(pass), Ok(()));
        }
        for (settings, says) in [
            (RenderSettings { rays: 7, ..whole }, "give at most 7 passes or more --rays"),
            (RenderSettings { photons: 7, ..whole }, "give at least 8 --photons"),
            (RenderSettings { denoise: true, ..whole }, "noise is taken off"),
            (RenderSettings { reconstruct: true, ..whole }, "noise is taken off"),
            (RenderSettings { director: Director::Xs, ..whole }, "direct by --x scattering"),
            (RenderSettings { director: Director::Variance, ..whole }, "the director variance"),
        ] {
            let problem = settings.check_pass(pass).unwrap_err();
            assert!(problem.contains(says), "{problem}");
        }
    }
}
