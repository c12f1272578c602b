//! `fogbow info`: what is in an OpenVDB file, and what fogbow would do with it.

use std::fmt::Write as _;
use std::io::{self, Write as _};
use std::path::PathBuf;

use serde::Serialize;

use crate::error::{Error, Result};
use crate::math::{Index, Transform};
use crate::vdb::{Grid, GridInfo, ReadAs, Statistics, VdbFile, Voxel};

/// Tells what is in an OpenVDB file, and what fogbow would do with it.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The OpenVDB file.
    pub file: PathBuf,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Serialize)]
struct Report {
    file: PathBuf,
    format_version: u32,
    library_version: String,
    reader_version: String,
    grids: Vec<GridReport>,
    /// The grid taken for density where none is named.
    density: Option<String>,
    /// Why there is none.
    problem: Option<String>,
}

#[derive(Debug, Serialize)]
struct GridReport {
    label: String,
    #[serde(flatten)]
    info: GridInfo,
    voxel_size: Option<[f64; 3]>,
    /// Whether the transform turns or skews the axes.
    rotated: bool,
    /// Whether the transform swaps left and right.
    mirrored: bool,
    background: Option<Vec<f32>>,
    statistics: Option<Statistics>,
    /// Outer corners of the active voxels' samples in the world, in metres.
    world_bounds: Option<[[f64; 3]; 2]>,
    memory_bytes: Option<usize>,
    /// Why it cannot be read; nothing where it can.
    problem: Option<String>,
    /// What fogbow does with it.
    verdict: String,
}

/// Prints the report. A grid that cannot be read is listed with the reason.
///
/// # Errors
/// Where the file cannot be opened, or the report not be written.
pub fn run(args: &Args) -> Result<()> {
    let file = VdbFile::open(&args.file)?;
    let report = report(&file);
    let text = if args.json {
        let json = serde_json::to_string_pretty(&report);
        json.map_err(|e| Error::file(&args.file, format!("cannot be told as JSON: {e}")))? + "\n"
    } else {
        readable(&report)
    };
    match io::stdout().lock().write_all(text.as_bytes()) {
        Err(e) if e.kind() != io::ErrorKind::BrokenPipe => {
            Err(Error::file("standard output", format!("cannot be written: {e}")))
        }
        _ => Ok(()), // a reader that has seen enough is no error
    }
}

fn report(file: &VdbFile) -> Report {
    let choice = file.default_density();
    let chosen = choice.as_ref().ok().copied();
    let grids: Vec<_> =
        (0..file.grids().len()).map(|i| grid_report(file, i, chosen == Some(i))).collect();
    let unusable = chosen.and_then(|i| {
        let problem = grids[i].problem.as_ref()?;
        Some(Error::grid(file.path(), &grids[i].label, problem).to_string())
    });
    Report {
        file: file.path().to_path_buf(),
        format_version: file.version(),
        library_version: file.library_version().to_string(),
        reader_version: VdbFile::reader_version(),
        density: chosen.filter(|_| unusable.is_none()).map(|i| grids[i].label.clone()),
        problem: choice.err().map(|e| e.to_string()).or(unusable),
        grids,
    }
}

fn grid_report(file: &VdbFile, index: usize, chosen: bool) -> GridReport {
    let info = file.grids()[index].clone();
    let mut report = GridReport {
        label: info.label(),
        voxel_size: None,
        rotated: false,
        mirrored: false,
        background: None,
        statistics: None,
        world_bounds: None,
        memory_bytes: None,
        problem: None,
        verdict: String::new(),
        info,
    };
    report.problem = report.read(file, index).err().map(|e| match e {
        Error::Grid { problem, .. } => problem, // the grid's name stands above it already
        other => other.to_string(),
    });
    report.verdict = match &report.problem {
        Some(problem) => format!("refused: {problem}"),
        None => verdict(&report.info, chosen),
    };
    report
}

impl GridReport {
    /// Reads the grid and fills in what only its voxels tell.
    fn read(&mut self, file: &VdbFile, index: usize) -> Result<()> {
        if self.info.is_vector() {
            let grid = file.read_vector(index)?;
            self.background = Some(grid.background().to_vec());
            self.measure(&grid);
        } else {
            let grid = file.read_scalar(index, ReadAs::Raw)?;
            self.background = Some(vec![grid.background()]);
            self.measure(&grid);
        }
        Ok(())
    }

    fn measure<V: Voxel>(&mut self, grid: &Grid<V>) {
        let statistics = *grid.statistics();
        let matrix = grid.transform().affine().matrix3;
        self.voxel_size = Some(grid.transform().unit_lengths().to_array());
        self.mirrored = matrix.determinant() < 0.0;
        let axes = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
        self.rotated = axes.iter().enumerate().any(|(i, axis)| {
            let aligned = axis[i].abs();
            (axis.length() - aligned) > 1e-9 * axis.length()
        });
        self.world_bounds = statistics.bounds.map(|b| world_bounds(grid.transform(), b));
        self.memory_bytes = Some(grid.memory_bytes());
        self.statistics = Some(statistics);
    }
}

fn world_bounds(transform: &Transform<Index>, bounds: [[i32; 3]; 2]) -> [[f64; 3]; 2] {
    let [min, max] =
        bounds.map(|[x, y, z]| crate::math::IndexPoint::new(x.into(), y.into(), z.into()));
    let world = transform.box_to_world(&crate::math::Aabb::new(min, max));
    [world.min.xyz.to_array(), world.max.xyz.to_array()]
}

fn verdict(info: &GridInfo, chosen: bool) -> String {
    let level_set = "refused as density: a level set; level_set = \"fog\" converts it";
    match (chosen, info.is_level_set(), info.is_vector()) {
        (true, true, _) => format!("the density where none is named, but {level_set}"),
        (true, ..) => "the density where none is named".into(),
        (_, true, _) => level_set.into(),
        (_, _, true) => "usable as colour".into(),
        _ => format!("usable by name: grid = \"{}\"", info.name),
    }
}

fn readable(report: &Report) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(
        out,
        "{}: OpenVDB format {}, written by OpenVDB {}, read by OpenVDB {}; {} grid(s)",
        report.file.display(),
        report.format_version,
        report.library_version,
        report.reader_version,
        report.grids.len()
    );
    for grid in &report.grids {
        let _ = describe(&mut out, grid);
    }
    let _ = match (&report.density, &report.problem) {
        (Some(name), _) => writeln!(out, "\ndensity where none is named: \"{name}\""),
        (None, Some(problem)) => writeln!(out, "\nno density where none is named: {problem}"),
        _ => Ok(()),
    };
    out
}

fn describe(out: &mut String, grid: &GridReport) -> std::fmt::Result {
    let info = &grid.info;
    let half = if info.half { ", stored in 16 bits" } else { "" };
    writeln!(out, "\n\"{}\": {}, {}{half}", grid.label, info.value_type, info.class)?;
    let mut line = |key: &str, text: String| writeln!(out, "  {key:<12}{text}");
    line("compression", info.compression.clone())?;
    if let Some(s) = &grid.statistics {
        line(
            "voxels",
            format!(
                "{} active ({} leaves; {} active tiles with {} voxels)",
                s.active, s.leaves, s.active_tiles, s.tile_voxels
            ),
        )?;
        line("values", format!("{} to {}, mean {}, {} zeros", s.min, s.max, s.mean, s.zeros))?;
        if s.bad.total() > 0 && !info.is_level_set() {
            let bad = s.bad;
            line(
                "bad values",
                format!(
                    "{} NaN, {} infinite, {} negative; as density they are taken as 0",
                    bad.nan, bad.infinite, bad.negative
                ),
            )?;
        }
        let bounds = s.bounds.map(|[a, b]| format!("{a:?} to {b:?}"));
        line("index box", bounds.unwrap_or_else(|| "empty".into()))?;
    }
    if let Some([a, b]) = grid.world_bounds {
        line("world box", format!("{a:.6?} to {b:.6?} m"))?;
    }
    let turned = if grid.rotated { ", rotated or skewed" } else { "" };
    let mirrored = if grid.mirrored { ", mirrored" } else { "" };
    let size = grid.voxel_size.map_or(String::new(), |s| format!(", voxel size {s:.6?} m"));
    line("transform", format!("{}{size}{turned}{mirrored}", info.map))?;
    if let Some(background) = &grid.background {
        line("background", format!("{background:?}"))?;
    }
    if let Some(bytes) = grid.memory_bytes {
        line("memory", format!("{:.1} MiB", bytes as f64 / f64::from(1 << 20)))?;
    }
    line("fogbow", grid.verdict.clone())
}
