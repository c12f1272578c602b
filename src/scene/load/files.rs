//! VDB files and their grids, each read once.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::DAffine3;

use crate::error::Result;
use crate::scene::camera::Frustum;
use crate::scene::file::{DensitySection, EmissionSection, GridReference, MediumSection};
use crate::vdb::roles::GridRef;
use crate::vdb::{Grid, ReadAs, VdbFile, Voxel, Wanted};

/// VDB files, each opened once, and their grids, each read once.
#[derive(Debug, Default)]
pub(in crate::scene) struct Grids {
    files: BTreeMap<PathBuf, VdbFile>,
    memory: Option<u64>,
    scalars: Vec<ReadScalars>,
    pub(super) vectors: Vec<ReadColors>,
    /// Warnings of bad values in them, one line each.
    pub(super) warnings: Vec<String>,
    /// Notes on the files, one line each.
    pub(super) notes: Vec<String>,
    /// Scalar grids that are named more than once.
    shared: Vec<GridName>,
}

/// A scalar grid with its key.
#[derive(Debug)]
struct ReadScalars {
    key: ScalarKey,
    grid: Grid<f32>,
    /// Whether the scene that is loaded uses it.
    is_used: bool,
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
    /// The grid's placement, the camera's frustum and whether voxels out of sight were left out, where these were
    /// counted.
    pub(super) culled: Option<(DAffine3, Frustum, bool)>,
}

impl Grids {
    /// No grids yet. Each may take `memory` bytes while it is read.
    pub(in crate::scene) fn within(memory: Option<u64>) -> Self {
        Self { memory, ..Self::default() }
    }

    /// Lets each grid that is not read yet take `memory` bytes meanwhile.
    pub(in crate::scene) fn limit(&mut self, memory: Option<u64>) {
        self.memory = memory;
    }

    /// Prepares for the media of one scene, and finds the grids that several of them name.
    pub(super) fn begin(&mut self, media: &[MediumSection]) {
        let mut names: Vec<_> = media.iter().flat_map(scalar_grids).map(name_of).collect();
        names.sort_unstable();
        let twice = names.windows(2).filter(|pair| pair[0] == pair[1]);
        self.shared = twice.map(|pair| pair[0].clone()).collect();
        self.scalars.iter_mut().for_each(|read| read.is_used = false);
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
            self.files.insert(path.to_path_buf(), file);
        }
        let file = &self.files[path];
        add_once(&mut self.notes, file.notes());
        Ok(file)
    }

    /// The scalar grid number `index` of `path`, all of it; bad values are taken as 0 and warned of.
    pub(in crate::scene) fn scalar(
        &mut self,
        path: &Path,
        index: usize,
        read_as: ReadAs,
    ) -> Result<Grid<f32>> {
        self.scalar_where(ScalarKey { path: path.into(), index, read_as, culled: None }, None)
            .map(|(grid, _)| grid)
    }

    /// The grid of `key` with the leaves that are `wanted`, and the number of its active voxels in others;
    /// 0 where the scene has that grid already.
    pub(super) fn scalar_where(
        &mut self,
        key: ScalarKey,
        wanted: Option<Wanted<'_>>,
    ) -> Result<(Grid<f32>, u64)> {
        self.open(&key.path)?;
        let file = &self.files[&key.path];
        let label = file.grids()[key.index].label();
        let known = match self.scalars.iter().position(|read| read.key == key) {
            Some(known) => known,
            None => {
                let grid = file.read_scalar_where(key.index, key.read_as, wanted)?;
                self.scalars.push(ReadScalars { key, grid, is_used: false });
                self.scalars.len() - 1
            }
        };
        let ReadScalars { key, grid, is_used } = &mut self.scalars[known];
        add_once(&mut self.warnings, bad_values(&key.path, &label, grid, "taken as 0"));
        let unwanted = if std::mem::replace(is_used, true) { 0 } else { grid.unwanted() };
        Ok((grid.clone(), unwanted))
    }
}

/// Adds those `lines` to `list` that it has not.
pub(super) fn add_once(list: &mut Vec<String>, lines: impl IntoIterator<Item = String>) {
    for line in lines {
        if !list.contains(&line) {
            list.push(line);
        }
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
