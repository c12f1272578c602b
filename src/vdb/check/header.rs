//! The file's header, and for each grid its descriptor, metadata and transform.

use std::collections::HashSet;
use std::io::{Read, Seek};

use super::bytes::{Bytes, Checked, damaged};
use super::metadata;
use super::tree::{self, Values};

/// Most grids of a file.
const MOST_GRIDS: i32 = 100_000;
/// What OpenVDB appends to the name of a type whose floats are stored in 16 bits.
const HALF_SUFFIX: &str = "_HalfFloat";
/// What OpenVDB puts between a grid's name and its number where names repeat.
const SEPARATOR: char = '\x1e';

/// Where the trees of a file are.
#[derive(Debug)]
pub(super) struct Layout {
    grids: Vec<GridLayout>,
}

/// Where a grid's tree is.
#[derive(Debug)]
pub(super) struct GridLayout {
    unique_name: String,
    /// The grid whose tree it shares; empty where it has its own.
    parent: String,
    kind: String,
    /// Offset of the tree.
    pub(super) tree: u64,
    /// End of the grid, where the file tells.
    pub(super) end: Option<u64>,
    /// What it holds, where fogbow reads it.
    pub(super) values: Option<Values>,
}

impl Layout {
    /// The grid that has the tree of grid `index`.
    pub(super) fn owner(&self, index: usize) -> Checked<&GridLayout> {
        let grid = &self.grids[index];
        if grid.parent.is_empty() {
            return Ok(grid);
        }
        let own = |g: &&GridLayout| g.parent.is_empty() && g.unique_name == grid.parent;
        let parent = self.grids.iter().find(own).ok_or_else(|| {
            format!("shares the tree of a grid that is missing: {:?}", plain(&grid.parent))
        })?;
        if parent.kind != grid.kind {
            return Err(format!("shares the tree of {:?}, of another type", plain(&grid.parent)));
        }
        Ok(parent)
    }
}

/// A problem, with the grid that it is about where it is about one.
type GridProblem = (Option<String>, String);

/// Walks over everything but the trees; over those as well where a file has no offsets.
pub(super) fn read<R: Read + Seek>(file: &mut Bytes<R>) -> Result<Layout, GridProblem> {
    let of_file = |problem| (None, problem);
    let (offsets, count) = head(file).map_err(of_file)?;
    let mut grids = Vec::new();
    let mut names = HashSet::new();
    for _ in 0..count {
        let unique_name = file.text("the name of a grid").map_err(of_file)?;
        let grid = grid(file, unique_name.clone(), offsets)
            .map_err(|problem| (Some(plain(&unique_name)), problem))?;
        if !names.insert(unique_name.clone()) {
            let problem = "stands in the file twice under one internal name: it is damaged";
            return Err((Some(plain(&unique_name)), problem.into()));
        }
        grids.push(grid);
    }
    Ok(Layout { grids })
}

/// Whether the file has offsets, and how many grids.
fn head<R: Read + Seek>(file: &mut Bytes<R>) -> Checked<(bool, i32)> {
    let what = "the header";
    file.skip(8 + 3 * 4, what)?; // magic number, versions of format and library
    let offsets = file.byte(what)? != 0;
    file.skip(36, what)?; // an identifier, as text
    metadata::read(file)?;
    let at = file.at();
    let count = file.i32("the number of grids")?;
    if !(0..=MOST_GRIDS).contains(&count) {
        return Err(damaged(at, format_args!("a number of {count} grids")));
    }
    Ok((offsets, count))
}

fn grid<R: Read + Seek>(
    file: &mut Bytes<R>,
    unique_name: String,
    offsets: bool,
) -> Checked<GridLayout> {
    let full_type = file.text("the type of a grid")?;
    let kind = full_type.strip_suffix(HALF_SUFFIX).unwrap_or(&full_type);
    let parent = file.text("the name of a grid")?;
    let places = ["start", "voxels", "end"];
    let mut read = |place| file.i64(&format!("the offset of its {place}"));
    let [start, _, end] = [read(places[0])?, read(places[1])?, read(places[2])?];
    let here = file.at();
    let behind = if offsets {
        let right = u64::try_from(start).ok().zip(u64::try_from(end).ok());
        let right = right.filter(|(start, end)| here <= *start && start <= end);
        let Some((start, end)) = right else {
            return Err(damaged(here, format_args!("a grid from byte {start} to {end}")));
        };
        if end > file.length() {
            return Err(format!(
                "should end at byte {end}, but the file has {}: it is incomplete; copy or download \
                 it again",
                file.length()
            ));
        }
        file.seek(start)?;
        Some(end)
    } else {
        None
    };
    let compression = file.u32("the compression")?;
    let half = metadata::read(file)?;
    transform(file)?;
    let values = Values::new(kind, half, compression);
    let tree = file.at();
    match (behind, values) {
        (Some(end), _) if tree > end => {
            return Err(damaged(end, "a transform that reaches behind the grid's end"));
        }
        (Some(end), _) => file.seek(end)?,
        (None, _) if !parent.is_empty() => {}
        (None, Some(values)) => tree::walk(file, values).map(drop)?,
        (None, None) => {
            return Err(format!(
                "has the type {kind:?}, which cannot be skipped in a file without offsets; write the \
                 file anew with OpenVDB's io::File"
            ));
        }
    }
    Ok(GridLayout { unique_name, parent, kind: kind.into(), tree, end: behind, values })
}

/// Walks over a transform.
fn transform<R: Read + Seek>(file: &mut Bytes<R>) -> Checked<()> {
    let what = "the transform";
    let (at, map) = (file.at(), file.text(what)?);
    let size = match map.as_str() {
        "NonlinearFrustumMap" => {
            file.skip(6 * 8 + 2 * 8, what)?;
            let second = file.text(what)?;
            linear(&second).ok_or_else(|| damaged(at, format_args!("{second:?} in a frustum")))?
        }
        map => linear(map)
            .ok_or_else(|| damaged(at, format_args!("an unknown transform {:?}", plain(map))))?,
    };
    file.skip(size, what)
}

/// Bytes of a linear map.
fn linear(map: &str) -> Option<u64> {
    Some(match map {
        "ScaleMap" | "UniformScaleMap" => 5 * 24,
        "TranslationMap" => 24,
        "ScaleTranslateMap" | "UniformScaleTranslateMap" => 6 * 24,
        "AffineMap" | "UnitaryMap" => 16 * 8,
        _ => return None,
    })
}

/// A name for messages: without its number, its length bounded.
fn plain(name: &str) -> String {
    let name = name.split(SEPARATOR).next().unwrap_or_default();
    name.chars().take(80).map(|c| if c.is_control() { ' ' } else { c }).collect()
}
