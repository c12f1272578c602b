//! VDB files and their grids, each read once.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::DAffine3;

use crate::error::Result;
use crate::scene::file::{DensitySection, EmissionSection, GridReference, MediumSection};
use crate::vdb::roles::GridRef;
use crate::vdb::{Grid, ReadAs, VdbFile, Voxel, Wanted};

/// VDB files, each opened once, and their grids, each read once.
#[derive(Debug, Default)]
pub(in crate::scene) struct Grids {
    files: BTreeMap<PathBuf, VdbFile>,
    memory: Option<u64>,
    scalars: Vec<(ScalarKey, Grid<f32>)>,
    pub(super) vectors: Vec<ReadColors>,
    /// Warnings of bad values in them, one line each.
    pub(super) warnings: Vec<String>,
    /// Notes on the files, one line each.
    pub(super) notes: Vec<String>,
    /// Scalar grids that are named more than once.
    shared: Vec<GridName>,
}

/// A grid of colours with its key.
#[derive(Debug)]
pub(super) struct ReadColors {
    pub(super) path: PathBuf,
    pub(super) grid: GridRef,
    pub(super) colors: Grid<[f32; 3]>,
}

/// A grid as a scene names it: file, name and number among those of that name.
type GridName = (PathBuf, Option<String>, Option<usize>);

/// Key of a scalar grid that was read: media with the same key share the voxels.
#[derive(Debug, PartialEq)]
pub(super) struct ScalarKey {
    pub(super) path: PathBuf,
    pub(super) index: usize,
    pub(super) read_as: ReadAs,
    /// The grid's placement, where voxels out of sight were left out or counted.
    pub(super) culled_at: Option<DAffine3>,
}

impl Grids {
    /// No grids yet. Each may take `memory` bytes while it is read.
    pub(in crate::scene) fn within(memory: Option<u64>) -> Self {
        Self { memory, ..Self::default() }
    }

    /// Finds the grids that several of these media name.
    pub(super) fn for_media(self, media: &[MediumSection]) -> Self {
        let mut names: Vec<_> = media.iter().flat_map(scalar_grids).map(name_of).collect();
        names.sort_unstable();
        let twice = names.windows(2).filter(|pair| pair[0] == pair[1]);
        let shared = twice.map(|pair| pair[0].clone()).collect();
        Self { shared, ..self }
    }

    /// Whether several media name the grid, or one twice: it is then read whole, to be shared
    /// wherever they are placed.
    pub(super) fn is_shared(&self, reference: &GridReference) -> bool {
        self.shared.contains(&name_of(reference))
    }

    /// The open file of `path`.
    pub(in crate::scene) fn open(&mut self, path: &Path) -> Result<&VdbFile> {
        if !self.files.contains_key(path) {
            let file = VdbFile::open(path)?.within(self.memory);
            self.notes.extend(file.notes());
            self.files.insert(path.to_path_buf(), file);
        }
        Ok(&self.files[path])
    }

    /// The scalar grid number `index` of `path`, all of it; bad values are taken as 0 and warned of.
    pub(in crate::scene) fn scalar(
        &mut self,
        path: &Path,
        index: usize,
        read_as: ReadAs,
    ) -> Result<Grid<f32>> {
        self.scalar_where(ScalarKey { path: path.into(), index, read_as, culled_at: None }, None)
            .map(|(grid, _)| grid)
    }

    /// The grid of `key` with the leaves that are `wanted`, and the number of its active voxels in others;
    /// 0 where the grid was read before.
    pub(super) fn scalar_where(
        &mut self,
        key: ScalarKey,
        wanted: Option<Wanted<'_>>,
    ) -> Result<(Grid<f32>, u64)> {
        if let Some((_, grid)) = self.scalars.iter().find(|(known, _)| *known == key) {
            return Ok((grid.clone(), 0));
        }
        let file = self.open(&key.path)?;
        let grid = file.read_scalar_where(key.index, key.read_as, wanted)?;
        let label = file.grids()[key.index].label();
        self.warnings.extend(bad_values(&key.path, &label, &grid, "taken as 0"));
        self.scalars.push((key, grid.clone()));
        let unwanted = grid.unwanted();
        Ok((grid, unwanted))
    }
}

/// The scalar grids that `section` names.
fn scalar_grids(section: &MediumSection) -> impl Iterator<Item = &GridReference> {
    let density = match &section.density {
        DensitySection::Grid { grid, .. } => Some(grid),
        DensitySection::Region(_) => None,
    };
    let emission = match &section.emission {
        Some(EmissionSection::Grid { grid, .. } | EmissionSection::Temperature { grid, .. }) => {
            Some(grid)
        }
        Some(EmissionSection::Density { .. }) | None => None,
    };
    [density, emission].into_iter().flatten()
}

fn name_of(reference: &GridReference) -> GridName {
    (reference.file.path.clone(), reference.name.clone(), reference.index)
}

/// A warning where `grid` has NaN, infinite or negative values, which get the `treatment`.
pub(in crate::scene) fn bad_values<V: Voxel>(
    path: &Path,
    label: &str,
    grid: &Grid<V>,
    treatment: &str,
) -> Option<String> {
    let bad = grid.bad_values();
    let counts = [(bad.nan, "NaN"), (bad.infinite, "infinite"), (bad.negative, "negative")];
    let found: Vec<_> = counts
        .iter()
        .filter(|(count, _)| *count > 0)
        .map(|(count, kind)| format!("{count} {kind}"))
        .collect();
    let list = found.join(", ");
    (!found.is_empty())
        .then(|| format!("{}: grid \"{label}\": {list} voxels {treatment}", path.display()))
}
