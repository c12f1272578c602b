//! Grids of VDB files, found, read and placed.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::DAffine3;

use super::{Context, at};
use crate::error::Result;
use crate::math::{Rgb, WorldPoint};
use crate::medium::Albedo;
use crate::scene::file::GridReference;
use crate::scene::reader::Place;
use crate::vdb::roles::GridRef;
use crate::vdb::{Grid, ReadAs, VdbFile, Voxel, Wanted};

/// VDB files, each opened once.
#[derive(Debug, Default)]
pub(in crate::scene) struct Grids {
    files: BTreeMap<PathBuf, VdbFile>,
    memory: Option<u64>,
}

impl Grids {
    /// None yet, of which each may take `memory` bytes while it is read.
    pub(super) fn within(memory: Option<u64>) -> Self {
        Self { memory, ..Self::default() }
    }

    /// The open file of `path`.
    pub(in crate::scene) fn open(&mut self, path: &Path) -> Result<&VdbFile> {
        if !self.files.contains_key(path) {
            let file = VdbFile::open(path)?.within(self.memory);
            self.files.insert(path.to_path_buf(), file);
        }
        Ok(&self.files[path])
    }
}

/// The density that `reference` names; bad values are taken as 0 and warned of.
pub(super) fn density(
    reference: &GridReference,
    level_set_as_fog: bool,
    placement: &DAffine3,
    context: &mut Context,
) -> Result<Grid<f32>> {
    let read_as = if level_set_as_fog { ReadAs::LevelSetAsFog } else { ReadAs::Density };
    scalar(reference, read_as, placement, context)
}

/// The values, none of them negative, that `reference` names.
pub(super) fn values(
    reference: &GridReference,
    placement: &DAffine3,
    context: &mut Context,
) -> Result<Grid<f32>> {
    scalar(reference, ReadAs::Density, placement, context)
}

/// The scalar or colour grid that `reference` names, as an albedo.
pub(super) fn albedo(
    reference: &GridReference,
    scale: Rgb,
    placement: &DAffine3,
    context: &mut Context,
) -> Result<Albedo> {
    let (file, grid) = find_vector(reference, context)?;
    if let GridRef::Single { index, .. } = grid
        && !file.grids()[index].is_vector()
    {
        let grid = scalar(reference, ReadAs::Density, placement, context)?;
        return Ok(Albedo::Scalar { grid, scale });
    }
    let label = grid.label().to_owned();
    let grid = at(&reference.at, file.read_color(&grid))?;
    context.warnings.extend(bad_values(&reference.file.path, &label, &grid, "clamped to [0, 1]"));
    Ok(Albedo::Color { grid: placed(grid, placement, &reference.at)?, scale })
}

fn scalar(
    reference: &GridReference,
    read_as: ReadAs,
    placement: &DAffine3,
    context: &mut Context,
) -> Result<Grid<f32>> {
    let sight = context.sight;
    let (file, index) = find(reference, context)?;
    let place = |p: WorldPoint| WorldPoint::from_xyz(placement.transform_point3(p.xyz));
    let is_wanted = |corners: &[WorldPoint; 8]| {
        sight.is_none_or(|sight| !sight.frustum.misses(&corners.map(place)))
    };
    let wanted = sight.map(|sight| Wanted { is_wanted: &is_wanted, leaves_out: sight.leaves_out });
    let grid = at(&reference.at, file.read_scalar_where(index, read_as, wanted))?;
    let label = file.grids()[index].label();
    context.warnings.extend(bad_values(&reference.file.path, &label, &grid, "taken as 0"));
    context.unseen += grid.unwanted();
    placed(grid, placement, &reference.at)
}

/// The file and the number of the scalar grid in it.
fn find<'c>(reference: &GridReference, context: &'c mut Context) -> Result<(&'c VdbFile, usize)> {
    context.sources.add(&reference.file.path);
    let file = at(&reference.file.at, context.grids.open(&reference.file.path))?;
    let index = match &reference.name {
        Some(name) => file.find(name, reference.index),
        None => file.default_density(),
    };
    let index = at(&reference.at, index)?;
    note(&mut context.warnings, file, &file.reference(index), reference);
    Ok((file, index))
}

/// The file and the scalar or vector grid in it.
fn find_vector<'c>(
    reference: &GridReference,
    context: &'c mut Context,
) -> Result<(&'c VdbFile, GridRef)> {
    let Some(name) = &reference.name else {
        let (file, index) = find(reference, context)?;
        return Ok((file, file.reference(index)));
    };
    context.sources.add(&reference.file.path);
    let file = at(&reference.file.at, context.grids.open(&reference.file.path))?;
    let grid = at(&reference.at, file.find_vector(name, reference.index))?;
    note(&mut context.warnings, file, &grid, reference);
    Ok((file, grid))
}

/// Notes that `grid` was taken where others could have been meant, once.
fn note(notes: &mut Vec<String>, file: &VdbFile, grid: &GridRef, reference: &GridReference) {
    let ambiguity = file.ambiguity(grid).filter(|_| reference.index.is_none());
    notes.extend(ambiguity.filter(|note| !notes.contains(note)));
}

fn placed<V: Voxel>(grid: Grid<V>, placement: &DAffine3, place: &Place) -> Result<Grid<V>> {
    if *placement == DAffine3::IDENTITY {
        return Ok(grid);
    }
    grid.placed(placement).ok_or_else(|| {
        place.error("the placement makes the grid's transform singular; give a scale nearer to 1")
    })
}

/// A warning where `grid` has values that it should not have.
pub(in crate::scene) fn bad_values<V: Voxel>(
    path: &Path,
    label: &str,
    grid: &Grid<V>,
    fate: &str,
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
        .then(|| format!("{}: grid \"{label}\": {list} voxels {fate}", path.display()))
}
