//! What the director is asked, from the command line.

use clap::builder::{PossibleValuesParser, TypedValueParser};

use crate::scene::{
    Directed, DirectingOverrides, Director, Importance, MAX_COARSENING, MAX_RAYS, Operator,
    RESOLUTIONS,
};

/// Settings of the director; each stands over the scene file's.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Director")]
pub(super) struct DirectingArgs {
    /// Who decides what a pixel may spend.
    #[arg(long, value_parser = words(Director::ALL))]
    pub(super) director: Option<Director>,
    /// What the X-map says.
    #[arg(long, value_parser = words(Importance::ALL))]
    x: Option<Importance>,
    /// Weights of X and S in the XS-map.
    #[arg(long, value_name = "X,S", value_parser = weights)]
    weights: Option<[f64; 2]>,
    /// How X and S become one.
    #[arg(long, value_parser = words(Operator::ALL))]
    op: Option<Operator>,
    /// What the XS-map hands out: some of rays,radius,step, or nothing.
    #[arg(long, value_name = "WHAT", value_parser = Directed::parse)]
    directs: Option<Directed>,
    /// Rays of the least important pixel.
    #[arg(long, value_name = "N",
        value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_RAYS)))]
    floor: Option<u32>,
    /// Gather radius of the least important pixel over that of the most important one.
    #[arg(long, value_name = "FACTOR", value_parser = coarsening)]
    coarsest_radius: Option<f64>,
    /// March step of the least important pixel, in voxels.
    #[arg(long, value_name = "VOXELS", value_parser = coarsening)]
    coarsest_step: Option<f64>,
    /// Relative error at which `--director variance` ends a pixel.
    #[arg(long, value_name = "ERROR", value_parser = tolerance)]
    tolerance: Option<f64>,
    /// Pixels of the maps over those of the film, along each side, such as 0.25 or 2.
    #[arg(long, value_name = "FACTOR", value_parser = resolution)]
    resolution: Option<f64>,
}

impl DirectingArgs {
    /// What stands over the scene file.
    pub(super) fn overrides(&self) -> DirectingOverrides {
        DirectingOverrides {
            x: self.x,
            weights: self.weights,
            operator: self.op,
            directed: self.directs,
            floor: self.floor,
            coarsest_radius: self.coarsest_radius,
            coarsest_step: self.coarsest_step,
            tolerance: self.tolerance,
            resolution: self.resolution,
        }
    }
}

/// A parser of the words of `all`.
pub(super) fn words<T: Copy + Send + Sync + 'static>(
    all: &'static [(&'static str, T)],
) -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(all.iter().map(|(word, _)| *word)).try_map(move |given| {
        let known = all.iter().find(|(word, _)| *word == given);
        known.map(|(_, value)| *value).ok_or("unknown")
    })
}

fn weights(text: &str) -> Result<[f64; 2], String> {
    let weight = |s: &str| s.trim().parse().ok().filter(|w: &f64| (0.0..=1e6).contains(w));
    let parsed = text.split_once(',').and_then(|(x, s)| Some([weight(x)?, weight(s)?]));
    parsed.ok_or_else(|| "give two numbers of at least 0 as 0.5,0.5".into())
}

fn coarsening(text: &str) -> Result<f64, String> {
    let parsed = text.parse().ok().filter(|f: &f64| (1.0..=MAX_COARSENING).contains(f));
    parsed.ok_or_else(|| format!("give a factor from 1 to {MAX_COARSENING}"))
}

fn tolerance(text: &str) -> Result<f64, String> {
    let parsed = text.parse().ok().filter(|e: &f64| *e > 0.0 && e.is_finite());
    parsed.ok_or_else(|| "give a number above 0, such as 0.05".into())
}

fn resolution(text: &str) -> Result<f64, String> {
    let parsed = text.parse().ok().filter(|f: &f64| RESOLUTIONS.contains(f));
    parsed.ok_or_else(|| "give a factor from 0.0625 to 4".into())
}
