//! `fogbow info`: what is in an OpenVDB file, and what fogbow would do with it.

mod text;

use std::io::{self, Write as _};
use std::path::PathBuf;

use serde::Serialize;

use crate::error::{Error, Result};
use crate::math::{Index, Transform};
use crate::scene;
use crate::vdb::roles::{Contents, Role};
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
    /// What a bare render does, in one line.
    summary: String,
    file: PathBuf,
    format_version: u32,
    library_version: String,
    reader_version: String,
    grids: Vec<GridReport>,
    /// The grid taken for density where none is named.
    density: Option<String>,
    /// Why no density is taken.
    problem: Option<String>,
    /// Notes on the file as a whole, one line each.
    notes: Vec<String>,
    /// The roles of the grids in a bare render; `None` where it refuses the file.
    contents: Option<Contents>,
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
    /// Why it cannot be read; `None` where it can.
    problem: Option<String>,
    /// What a bare render does with it, or why it refuses it.
    verdict: String,
}

/// Prints the report. A grid that cannot be read is listed with the reason.
///
/// # Errors
/// Where the file cannot be opened, or the report not be written.
pub fn run(args: &Args) -> Result<()> {
    match io::stdout().lock().write_all(told(args)?.as_bytes()) {
        Err(e) if e.kind() != io::ErrorKind::BrokenPipe => {
            Err(Error::file("standard output", format!("cannot be written: {e}")))
        }
        _ => Ok(()), // a reader that has seen enough is no error
    }
}

/// What `run` prints.
///
/// # Errors
/// Where the file cannot be opened.
pub fn told(args: &Args) -> Result<String> {
    let report = report(&VdbFile::open(&args.file)?);
    if args.json {
        let json = serde_json::to_string_pretty(&report);
        return json
            .map(|json| json + "\n")
            .map_err(|e| Error::file(&args.file, format!("cannot be told as JSON: {e}")));
    }
    Ok(text::readable(&report))
}

fn report(file: &VdbFile) -> Report {
    let contents = Contents::find(file);
    let chosen = file.default_density().ok();
    let grids: Vec<_> = (0..file.grids().len())
        .map(|i| grid_report(file, i, role(i, contents.as_ref().ok(), chosen)))
        .collect();
    let usable = chosen.map(|i| &grids[i]);
    let usable = usable.filter(|grid| grid.problem.is_none() && !grid.info.is_level_set());
    Report {
        summary: scene::summary(file.path())
            .unwrap_or_else(|problem| format!("a bare render refuses it: {problem}")),
        file: file.path().to_path_buf(),
        format_version: file.version(),
        library_version: file.library_version().to_string(),
        reader_version: VdbFile::reader_version(),
        density: usable.map(|grid| grid.label.clone()),
        problem: contents.as_ref().err().map(Error::to_string),
        notes: file.notes(),
        contents: contents.ok(),
        grids,
    }
}

/// The role of the grid number `index`: by the contents of the file or, where these are unknown, density
/// for the grid that was `chosen`.
fn role(index: usize, contents: Option<&Contents>, chosen: Option<usize>) -> Option<Role> {
    match contents {
        Some(contents) => contents.role(index),
        None => (chosen == Some(index)).then_some(Role::Density),
    }
}

fn grid_report(file: &VdbFile, index: usize, role: Option<Role>) -> GridReport {
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
        None => verdict(&report.info, role),
    };
    report
}

impl GridReport {
    /// Reads the grid and fills in what depends on its voxels.
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

fn verdict(info: &GridInfo, role: Option<Role>) -> String {
    let level_set = "refused as density: a level set; level_set = \"fog\" converts it";
    match (role, info.is_level_set()) {
        (Some(role), false) => format!("taken for {role}"),
        (Some(role), true) => format!("taken for {role}, but {level_set}"),
        (None, true) => level_set.into(),
        (None, false) => {
            format!("not used by a bare render; in a scene grid = \"{}\"", info.name)
        }
    }
}
