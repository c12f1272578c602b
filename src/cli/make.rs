//! `fogbow make`: procedural volumes and the statue.

use std::path::PathBuf;

use clap::ValueEnum;

use crate::error::{Error, Result};
use crate::file::PendingFile;
use crate::make::{Kind, Settings, make, make_statue};
use crate::shape::write_ply;
use crate::vdb;

/// What to make and where to put it.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// What to make.
    #[arg(value_enum)]
    kind: KindName,

    /// The file to write: .vdb, or .ply of the statue.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,

    /// Chooses one of many alike.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,

    /// Voxels along the longest side, 1 to 4096; the statue's up to 1024.
    #[arg(long, value_name = "N", default_value_t = 128)]
    resolution: u32,

    /// Edge of a voxel in metres; by default smoke is 4 m high, fire and the statue 2 m, fog 80 m and
    /// a cloud 800 m wide.
    #[arg(long, value_name = "METRES", allow_negative_numbers = true)]
    voxel: Option<f64>,
}

/// What can be made, by its name on the command line.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum KindName {
    /// A turbulent plume; grid "density".
    Smoke,
    /// A cumulus with a flat base; grid "density".
    Cloud,
    /// Banks of fog on the ground; grid "density".
    Fog,
    /// A campfire with its smoke; grids "density" and "temperature" (times 1500 to 2000 K).
    Fire,
    /// A winged figure on a pedestal, facing +z; a mesh, written as PLY.
    Statue,
}

impl KindName {
    /// The ending of its files, without the dot: scenes go by it.
    const fn ending(self) -> &'static str {
        match self {
            Self::Smoke | Self::Cloud | Self::Fog | Self::Fire => "vdb",
            Self::Statue => "ply",
        }
    }
}

/// Makes the volume or the statue and writes it.
///
/// # Errors
/// Where a setting is out of range, the file has another ending than the kind's, or cannot be
/// written; the latter before any work.
pub(super) fn run(args: &Args) -> Result<()> {
    check_ending(args)?;
    drop(PendingFile::new(&args.output)?);
    let settings = Settings { seed: args.seed, resolution: args.resolution, voxel: args.voxel };
    let volume = |kind| vdb::write(&args.output, &make(kind, &settings)?);
    match args.kind {
        KindName::Smoke => volume(Kind::Smoke),
        KindName::Cloud => volume(Kind::Cloud),
        KindName::Fog => volume(Kind::Fog),
        KindName::Fire => volume(Kind::Fire),
        KindName::Statue => write_ply(&args.output, &make_statue(&settings)?),
    }
}

fn check_ending(args: &Args) -> Result<()> {
    let right = args.kind.ending();
    if args.output.extension().is_some_and(|ending| ending.eq_ignore_ascii_case(right)) {
        return Ok(());
    }
    let kind = args.kind.to_possible_value().map_or_else(String::new, |v| v.get_name().to_owned());
    Err(Error::Usage(format!(
        "-o {}: {kind} is written as .{right}; name a .{right} file",
        args.output.display()
    )))
}
