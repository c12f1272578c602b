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

/// Offset of the metadata of a file: behind the magic number, the versions of format and library, the
/// flag of offsets, and an identifier as text.
pub(super) const METADATA: u64 = 8 + 3 * 4 + 1 + 36;

/// Where the grids of a file are.
#[derive(Debug)]
pub(super) struct Layout {
    /// Major and minor version of the library that wrote it.
    pub(super) library: [u32; 2],
    /// End of the file's own header.
    head: u64,
    pub(super) grids: Vec<GridLayout>,
}

/// Where a grid is.
#[derive(Debug)]
pub(super) struct GridLayout {
    pub(super) unique_name: String,
    /// The grid whose tree it shares; empty where it has its own.
    pub(super) parent: String,
    /// OpenVDB's name of the type.
    pub(super) kind: String,
    /// Whether its type is marked for floats that are stored in 16 bits.
    pub(super) half: bool,
    /// End of its descriptor.
    pub(super) described: u64,
    /// Offset of its compression, behind which metadata and transform follow.
    pub(super) start: u64,
    /// Offset of the tree.
    pub(super) tree: u64,
    /// End of the grid.
    pub(super) end: u64,
    /// What it holds, where the walk reads it.
    pub(super) values: Option<Values>,
}

impl GridLayout {
    /// The name, without the number that OpenVDB puts behind those that repeat.
    pub(super) fn name(&self) -> &str {
        self.unique_name.split(SEPARATOR).next().unwrap_or_default()
    }
}

impl Layout {
    /// End of the last grid.
    pub(super) fn end(&self) -> u64 {
        self.grids.last().map_or(self.head, |grid| grid.end)
    }

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
pub(super) type GridProblem = (Option<String>, String);

/// Walks over everything but the trees; over those as well where a file has no offsets.
pub(super) fn read<R: Read + Seek>(file: &mut Bytes<R>) -> Result<Layout, GridProblem> {
    let of_file = |problem| (None, problem);
    let Head { library, offsets, count } = head(file).map_err(of_file)?;
    let head = file.at();
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
    Ok(Layout { library, head, grids })
}

/// What the header of a file tells.
struct Head {
    library: [u32; 2],
    /// Whether grids have offsets.
    offsets: bool,
    /// How many grids there are.
    count: i32,
}

fn head<R: Read + Seek>(file: &mut Bytes<R>) -> Checked<Head> {
    let what = "the header";
    file.skip(8 + 4, what)?; // magic number, version of the format
    let library = [file.u32(what)?, file.u32(what)?];
    let offsets = file.byte(what)? != 0;
    file.skip(36, what)?; // an identifier, as text
    metadata::read(file)?;
    let at = file.at();
    let count = file.i32("the number of grids")?;
    if !(0..=MOST_GRIDS).contains(&count) {
        return Err(damaged(at, format_args!("a number of {count} grids")));
    }
    Ok(Head { library, offsets, count })
}

fn grid<R: Read + Seek>(
    file: &mut Bytes<R>,
    unique_name: String,
    offsets: bool,
) -> Checked<GridLayout> {
    let full_type = file.text("the type of a grid")?;
    let (kind, half) =
        full_type.strip_suffix(HALF_SUFFIX).map_or((&full_type[..], false), |kind| (kind, true));
    let parent = file.text("the name of a grid")?;
    let places = ["start", "voxels", "end"];
    let mut read = |place| file.i64(&format!("the offset of its {place}"));
    let [start, _, end] = [read(places[0])?, read(places[1])?, read(places[2])?];
    let here = file.at();
    let told = if offsets {
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
    let start = file.at();
    let compression = file.u32("the compression")?;
    let halves = metadata::read(file)?;
    transform(file)?;
    let values = Values::new(kind, halves, compression);
    let tree = file.at();
    match (told, values) {
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
    Ok(GridLayout {
        unique_name,
        parent,
        kind: kind.into(),
        half,
        described: here,
        start,
        tree,
        end: file.at(),
        values,
    })
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
pub(super) fn plain(name: &str) -> String {
    let name = name.split(SEPARATOR).next().unwrap_or_default();
    name.chars().take(80).map(|c| if c.is_control() { ' ' } else { c }).collect()
}
