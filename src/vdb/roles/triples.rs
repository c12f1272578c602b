//! Vector grids, whole or as three scalar grids.

use crate::error::{Error, Result};
use crate::vdb::{Grid, GridInfo, VdbFile};

use super::up::is_mantaflow;

/// Endings of the names of three grids that are the components of one vector.
const ENDINGS: [[&str; 3]; 12] = [
    [".x", ".y", ".z"],
    [".X", ".Y", ".Z"],
    ["_x", "_y", "_z"],
    ["_X", "_Y", "_Z"],
    ["x", "y", "z"],
    ["X", "Y", "Z"],
    [".r", ".g", ".b"],
    [".R", ".G", ".B"],
    ["_r", "_g", "_b"],
    ["_R", "_G", "_B"],
    ["r", "g", "b"],
    ["R", "G", "B"],
];

/// A grid of a file, or three scalar grids of it that are the components of one vector grid.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub enum GridRef {
    /// One grid.
    Single {
        /// Its number in [`VdbFile::grids`].
        index: usize,
        /// Its name, with the occurrence where several share it.
        label: String,
    },
    /// Three scalar grids.
    Triple {
        /// Their numbers in [`VdbFile::grids`], in the order x, y, z or r, g, b.
        indices: [usize; 3],
        /// What their names have in common: `vel` of `vel.x`, `vel.y` and `vel.z`.
        label: String,
    },
}

impl GridRef {
    /// The name by which a user knows it.
    pub fn label(&self) -> &str {
        match self {
            Self::Single { label, .. } | Self::Triple { label, .. } => label,
        }
    }

    /// The numbers of its grids in [`VdbFile::grids`].
    pub fn indices(&self) -> &[usize] {
        match self {
            Self::Single { index, .. } => std::slice::from_ref(index),
            Self::Triple { indices, .. } => indices,
        }
    }
}

impl VdbFile {
    /// The grid of that number, which is there.
    pub(crate) fn reference(&self, index: usize) -> GridRef {
        GridRef::Single { index, label: self.grids()[index].label() }
    }

    /// Reads a vector grid as it is; three scalar grids become one.
    ///
    /// # Errors
    /// Where a grid cannot be read, does not hold what it should, or three have not one transform.
    pub fn read_vector_of(&self, grid: &GridRef) -> Result<Grid<[f32; 3]>> {
        match grid {
            GridRef::Single { index, .. } => self.read_vector(*index),
            GridRef::Triple { indices, label } => {
                self.one_transform(indices, label)?;
                self.read_combined(indices)
            }
        }
    }

    /// Reads a vector grid as the colour of smoke. The colours of Mantaflow's caches are multiplied by
    /// the density; Cycles divides them by it again, and so does this.
    ///
    /// # Errors
    /// As [`read_vector_of`](Self::read_vector_of).
    pub fn read_color(&self, grid: &GridRef) -> Result<Grid<[f32; 3]>> {
        let names = self.grids().iter().map(|grid| grid.name.as_str());
        let density = self.grids().iter().position(|g| {
            let first = &self.grids()[grid.indices()[0]];
            g.name == "density" && is_component(g) && same_transform(g, first)
        });
        match (grid, density) {
            (GridRef::Triple { indices, label }, Some(density)) if is_mantaflow(names) => {
                self.one_transform(indices, label)?;
                self.read_unpremultiplied(indices, density)
            }
            _ => self.read_vector_of(grid),
        }
    }

    fn one_transform(&self, indices: &[usize; 3], label: &str) -> Result<()> {
        let [first, others @ ..] = indices.map(|i| &self.grids()[i]);
        if others.into_iter().all(|other| same_transform(first, other)) {
            return Ok(());
        }
        let names = indices.map(|i| format!("\"{}\"", self.grids()[i].label()));
        Err(Error::grid(
            self.path(),
            label,
            format!(
                "its components {} have different transforms; resample them to one",
                names.join(", ")
            ),
        ))
    }
}

/// Whether no voxel within 1000 of the origin is moved by more than a thousandth of its size.
fn same_transform(a: &GridInfo, b: &GridInfo) -> bool {
    let (Some(a), Some(b)) = (a.matrix, b.matrix) else { return false };
    (0..3).all(|row| {
        let size = a[row][..3].iter().fold(0.0, |size: f64, x| size.max(x.abs()));
        let differs = |column: usize| (a[row][column] - b[row][column]).abs();
        (0..3).all(|column| differs(column) <= 1e-6 * size) && differs(3) <= 1e-3 * size
    })
}

/// The three scalar grids that are components of the vector `stem`, if they are there.
pub(super) fn triple(grids: &[GridInfo], stem: &str) -> Option<GridRef> {
    if stem.is_empty() {
        return None;
    }
    let find = |ending: &str| {
        grids.iter().position(|grid| {
            is_component(grid) && grid.name.strip_prefix(stem).is_some_and(|end| end == ending)
        })
    };
    let indices = ENDINGS.iter().find_map(|[x, y, z]| Some([find(x)?, find(y)?, find(z)?]))?;
    Some(GridRef::Triple { indices, label: stem.to_owned() })
}

/// All vectors of which three components are there, in the order of the file.
pub(super) fn triples(grids: &[GridInfo]) -> Vec<GridRef> {
    let mut found: Vec<GridRef> = Vec::new();
    for grid in grids.iter().filter(|grid| is_component(grid)) {
        let stems = ENDINGS.iter().filter_map(|[x, ..]| grid.name.strip_suffix(x));
        for stem in stems {
            let known = found.iter().any(|known| known.label() == stem);
            if let Some(new) = triple(grids, stem).filter(|_| !known) {
                found.push(new);
            }
        }
    }
    found
}

fn is_component(grid: &GridInfo) -> bool {
    grid.is_scalar() && !grid.is_level_set()
}
