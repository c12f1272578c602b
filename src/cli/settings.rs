//! Raw arguments to settings.

use std::path::PathBuf;

use clap::builder::PossibleValuesParser;
use clap::builder::TypedValueParser;

use super::directing::{DirectingArgs, words};
use crate::image::ViewTransform;
use crate::scene::{
    FinalGather, MAX_MAGNITUDE, MAX_PHOTONS, MAX_PIXELS, MAX_RAYS, MAX_SCATTER, MAX_SIDE, Overrides,
};

/// Settings that every rendering command takes; each stands over the scene file's.
#[derive(Debug, clap::Args)]
pub(super) struct SettingArgs {
    /// Width and height of the picture in pixels.
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<[u32; 2]>,
    /// Camera rays a pixel.
    #[arg(long, value_name = "N",
        value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_RAYS)))]
    rays: Option<u32>,
    /// Photons that the map is to hold.
    #[arg(long, value_name = "N",
        value_parser = clap::value_parser!(u64).range(0..=MAX_PHOTONS))]
    photons: Option<u64>,
    /// Gather radius in metres.
    #[arg(long, value_name = "M", allow_negative_numbers = true, value_parser = length)]
    radius: Option<f64>,
    /// March step in metres.
    #[arg(long, value_name = "M", allow_negative_numbers = true, value_parser = length)]
    step: Option<f64>,
    #[command(flatten)]
    directing: DirectingArgs,
    /// Seed of every random stream.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Highest order of volume scattering; 1 is single scattering.
    #[arg(long, value_name = "N",
        value_parser = clap::value_parser!(u32).range(0..=i64::from(MAX_SCATTER)))]
    max_scatter: Option<u32>,
    /// Where rays that media scatter are followed further before photons are asked.
    #[arg(long, value_name = "WHERE", value_parser = words(FinalGather::ALL))]
    final_gather: Option<FinalGather>,
    /// Exposure of the PNG in stops.
    #[arg(long, value_name = "STOPS", allow_negative_numbers = true, value_parser = exposure)]
    exposure: Option<f64>,
    /// View transform of the PNG.
    #[arg(long, value_parser = PossibleValuesParser::new(["agx", "srgb"]).map(view))]
    view: Option<ViewTransform>,
}

impl SettingArgs {
    /// What stands over the scene file.
    pub(super) fn overrides(&self) -> Overrides {
        Overrides {
            size: self.size,
            exposure: self.exposure,
            view: self.view,
            rays: self.rays,
            photons: self.photons,
            radius: self.radius,
            step: self.step,
            director: self.directing.director,
            directing: self.directing.overrides(),
            seed: self.seed,
            max_scatter: self.max_scatter,
            final_gather: self.final_gather,
            denoise: None,
        }
    }
}

/// How a command runs and talks.
#[derive(Debug, clap::Args)]
pub(super) struct RunArgs {
    /// Threads to work with; the picture does not depend on it. By default one a core.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(super) threads: Option<u16>,
    /// Print settings, seconds a stage, counters and paths as one JSON object.
    #[arg(long)]
    pub(super) json: bool,
    /// Print no progress and no notes.
    #[arg(long)]
    pub(super) quiet: bool,
}

/// What is rendered and where it goes.
#[derive(Debug, clap::Args)]
pub(super) struct PathArgs {
    /// A scene (.toml), or a VDB file, which gets a camera and lights; with --frames also a pattern
    /// such as smoke_####.vdb.
    #[arg(value_name = "SCENE|FILE.vdb")]
    pub(super) scene: PathBuf,
    /// The EXR to write; a PNG is written beside it. With --frames their numbers go where #### or %04d
    /// stands, else before the ending.
    #[arg(short, long, value_name = "OUT.exr")]
    pub(super) output: PathBuf,
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let side = |s: &str| s.parse().ok().filter(|n| (1..=MAX_SIDE).contains(n));
    let parsed = text.split_once(['x', 'X']).and_then(|(w, h)| Some([side(w)?, side(h)?]));
    parsed.filter(|[w, h]| u64::from(*w) * u64::from(*h) <= MAX_PIXELS).ok_or_else(|| {
        format!(
            "give width and height as 960x540, each from 1 to {MAX_SIDE}, at most {MAX_PIXELS} \
                 pixels"
        )
    })
}

fn length(text: &str) -> Result<f64, String> {
    let parsed = text.parse().ok().filter(|m: &f64| *m > 0.0 && *m <= MAX_MAGNITUDE);
    parsed.ok_or_else(|| "give a length above 0 in metres".into())
}

fn exposure(text: &str) -> Result<f64, String> {
    let parsed = text.parse().ok().filter(|stops: &f64| stops.abs() <= 100.0);
    parsed.ok_or_else(|| "give a number of stops from -100 to 100".into())
}

fn view(name: String) -> ViewTransform {
    if name == "srgb" { ViewTransform::Srgb } else { ViewTransform::Agx }
}
