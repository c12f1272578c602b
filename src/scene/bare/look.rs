//! Options of a bare render.

use crate::error::{Error, Result};
use crate::vdb::roles::Axis;

/// Lights and surroundings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Look {
    /// A key from the side and above, a rim from behind, a cool fill and a graded backdrop.
    Studio,
    /// Dark surroundings, for what glows.
    Dusk,
    /// Sun and sky, for clouds.
    Sky,
    /// One key light from the front and an even, faint sky: for measurements.
    None,
}

impl Look {
    /// Each by its name.
    pub const ALL: &[(&str, Self)] =
        &[("studio", Self::Studio), ("dusk", Self::Dusk), ("sky", Self::Sky), ("none", Self::None)];
}

/// Whether there is a ground.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Ground {
    /// Where the medium stands on one.
    #[default]
    Auto,
    /// Under the medium.
    On,
    /// Nowhere.
    Off,
}

impl Ground {
    /// Each by its name.
    pub const ALL: &[(&str, Self)] = &[("auto", Self::Auto), ("on", Self::On), ("off", Self::Off)];
}

/// Which axis of the file points up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UpAxis {
    /// x.
    X,
    /// y, as Houdini and most others have it.
    Y,
    /// z, as Blender has it.
    Z,
}

impl UpAxis {
    /// Each by its name.
    pub const ALL: &[(&str, Self)] = &[("x", Self::X), ("y", Self::Y), ("z", Self::Z)];

    /// The upward axis that was found in a file.
    pub(super) const fn from_axis(axis: Axis) -> Self {
        match axis {
            Axis::X => Self::X,
            Axis::Y => Self::Y,
            Axis::Z => Self::Z,
        }
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        super::super::directing::name_of(Self::ALL, self)
    }
}

/// How a bare VDB file is shown; its content decides on what is not given.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LookOptions {
    /// Lights and surroundings.
    pub look: Option<Look>,
    /// Whether there is a ground.
    pub ground: Ground,
    /// Which axis of the file points up.
    pub up: Option<UpAxis>,
    /// Turn of the camera about the upward axis, in degrees, counterclockwise seen from above.
    pub orbit: f64,
    /// Angle of the camera above the horizon, in degrees, in (-90, 90).
    pub elevation: Option<f64>,
    /// Focal length in millimetres, on a sensor 36 mm wide.
    pub focal: Option<f64>,
    /// The grid to take for density.
    pub grid: Option<String>,
    /// Factor on the extinction.
    pub density: Option<f64>,
    /// Single-scattering albedo, in [0, 1].
    pub albedo: Option<f64>,
    /// Mean cosine of the phase function, in (-1, 1).
    pub g: Option<f64>,
}

impl LookOptions {
    /// Refuses these options for a scene file, whose keys set all of them.
    pub(in crate::scene) fn refuse_in_scene(&self) -> Result<()> {
        if *self == Self::default() {
            return Ok(());
        }
        Err(Error::Usage(
            "--look, --ground, --up, --orbit, --elevation, --focal, --grid, --density, --albedo and --g \
             are for VDB files without a scene; in a scene give its keys, or --set \
             medium.0.albedo=0.8"
                .into(),
        ))
    }
}
