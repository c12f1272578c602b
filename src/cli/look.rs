//! How a VDB file without a scene is shown, from the command line.

use clap::builder::{PossibleValuesParser, TypedValueParser};

use crate::scene::{Ground, Look, LookOptions, UpAxis};

/// What stands over the choices for a VDB file alone.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "VDB files without a scene")]
pub(super) struct LookArgs {
    /// Lights and surroundings; by content where it is not given.
    #[arg(long, value_parser = words(Look::ALL))]
    look: Option<Look>,
    /// Whether the medium stands on a ground.
    #[arg(long, value_parser = words(Ground::ALL), default_value = "auto")]
    ground: Ground,
    /// The axis of the file that points up.
    #[arg(long, value_name = "AXIS", value_parser = words(UpAxis::ALL))]
    up: Option<UpAxis>,
    /// Turns the camera about the medium, counterclockwise seen from above.
    #[arg(long, value_name = "DEG", allow_negative_numbers = true, default_value_t = 0.0,
        value_parser = number(|x| x.abs() <= 3600.0, "an angle of at most 3600 degrees"))]
    orbit: f64,
    /// Angle of the camera above the horizon.
    #[arg(long, value_name = "DEG", allow_negative_numbers = true,
        value_parser = number(|x| x.abs() < 89.0, "an angle above -89 and below 89 degrees"))]
    elevation: Option<f64>,
    /// Focal length on a sensor 36 mm wide.
    #[arg(long, value_name = "MM",
        value_parser = number(|x| (1.0..=10_000.0).contains(&x), "a length from 1 to 10000 mm"))]
    focal: Option<f64>,
    /// The grid to take for density.
    #[arg(long, value_name = "NAME")]
    grid: Option<String>,
    /// Factor on the chosen extinction.
    #[arg(long, value_name = "FACTOR",
        value_parser = number(|x| x > 0.0 && x <= 1e6, "a factor above 0 and at most 1000000"))]
    density: Option<f64>,
    /// Albedo; of a coloured medium the factor on its colours.
    #[arg(long, value_name = "X",
        value_parser = number(|x| (0.0..=1.0).contains(&x), "a number from 0 to 1"))]
    albedo: Option<f64>,
    /// Mean cosine of the angle of scattering.
    #[arg(long, value_name = "X", allow_negative_numbers = true,
        value_parser = number(|x| x > -1.0 && x < 1.0, "a number above -1 and below 1"))]
    g: Option<f64>,
    /// The camera of a shot (USD), by its path or its name; by default the first.
    #[arg(long, value_name = "PRIM", help_heading = "Shots (USD)")]
    camera: Option<String>,
    /// Turns the level set of a file without density into a fog volume.
    #[arg(long, value_name = "AS", value_parser = ["fog"])]
    level_set: Option<String>,
}

impl LookArgs {
    /// What was asked for.
    pub(super) fn options(&self) -> LookOptions {
        LookOptions {
            look: self.look,
            ground: self.ground,
            up: self.up,
            orbit: self.orbit,
            elevation: self.elevation,
            focal: self.focal,
            grid: self.grid.clone(),
            density: self.density,
            albedo: self.albedo,
            g: self.g,
        }
    }

    /// The camera of a shot.
    pub(super) fn camera(&self) -> Option<String> {
        self.camera.clone()
    }

    /// Whether a level set is taken as fog.
    pub(super) const fn level_set_as_fog(&self) -> bool {
        self.level_set.is_some()
    }
}

/// A parser of the words of `all`.
fn words<T: Copy + Send + Sync + 'static>(
    all: &'static [(&'static str, T)],
) -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(all.iter().map(|(word, _)| *word)).try_map(move |given| {
        let known = all.iter().find(|(word, _)| *word == given);
        known.map(|(_, value)| *value).ok_or("unknown")
    })
}

/// A parser of numbers for which `holds` is true, `right` in words.
fn number(
    holds: fn(f64) -> bool,
    right: &'static str,
) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    move |text| text.parse().ok().filter(|x| holds(*x)).ok_or_else(|| format!("give {right}"))
}
