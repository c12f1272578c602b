//! `fogbow make`: procedural volumes.

use std::path::PathBuf;

use crate::error::Result;
use crate::file::PendingFile;
use crate::make::{Kind, Settings, make};
use crate::vdb;

/// What to make and where to put it.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// What to make.
    #[arg(value_enum)]
    kind: KindName,

    /// The VDB file to write.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,

    /// Chooses one of many alike.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,

    /// Voxels along the longest side, 1 to 4096.
    #[arg(long, value_name = "N", default_value_t = 128)]
    resolution: u32,

    /// Edge of a voxel in metres; by default smoke is 4 m high, fire 2 m, fog 80 m and a cloud 800 m
    /// wide.
    #[arg(long, value_name = "METRES", allow_negative_numbers = true)]
    voxel: Option<f64>,
}

/// The kinds by their names on the command line.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum KindName {
    /// A turbulent plume; grid "density".
    Smoke,
    /// A cumulus with a flat base; grid "density".
    Cloud,
    /// Banks of fog on the ground; grid "density".
    Fog,
    /// A campfire with its smoke; grids "density" and "temperature" (times 1500 to 2000 K).
    Fire,
}

impl From<KindName> for Kind {
    fn from(name: KindName) -> Self {
        match name {
            KindName::Smoke => Self::Smoke,
            KindName::Cloud => Self::Cloud,
            KindName::Fog => Self::Fog,
            KindName::Fire => Self::Fire,
        }
    }
}

/// Makes the volume and writes it.
///
/// # Errors
/// Where a setting is out of range or the file cannot be written; the latter before any work.
pub(super) fn run(args: &Args) -> Result<()> {
    drop(PendingFile::new(&args.output)?);
    let settings = Settings { seed: args.seed, resolution: args.resolution, voxel: args.voxel };
    vdb::write(&args.output, &make(args.kind.into(), &settings)?)
}
