//! Grids of VDB files, found, read and placed.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::DAffine3;

use super::media::colors;
use super::{Context, at};
use crate::error::Result;
use crate::math::{Rgb, WorldPoint};
use crate::medium::{Albedo, Ramped};
use crate::scene::file::{
    DensitySection, EmissionSection, GridReference, MediumSection, TransferSection,
};
use crate::scene::reader::Place;
use crate::vdb::roles::GridRef;
use crate::vdb::{Grid, ReadAs, VdbFile, Voxel, Wanted};

/// VDB files, each opened once, and their grids, each read once.
#[derive(Debug, Default)]
pub(in crate::scene) struct Grids {
    files: BTreeMap<PathBuf, VdbFile>,
    memory: Option<u64>,
    scalars: Vec<(Reading, Grid<f32>)>,
    vectors: Vec<ReadColors>,
    /// What was mended in them, one line each.
    pub(super) warnings: Vec<String>,
    /// What is told of the files, one line each.
    pub(super) notes: Vec<String>,
    /// Scalar grids that are named more than once.
    shared: Vec<GridName>,
}

/// A grid of colours that was read.
#[derive(Debug)]
struct ReadColors {
    path: PathBuf,
    grid: GridRef,
    colors: Grid<[f32; 3]>,
}

/// A grid as a scene names it: file, name and number among those of that name.
type GridName = (PathBuf, Option<String>, Option<usize>);

/// What was read: media for which it is the same share the voxels.
#[derive(Debug, PartialEq)]
struct Reading {
    path: PathBuf,
    index: usize,
    read_as: ReadAs,
    /// Where the grid was placed, if voxels out of sight there were left out or counted.
    seen_at: Option<DAffine3>,
}

impl Grids {
    /// None yet, of which each may take `memory` bytes while it is read.
    pub(in crate::scene) fn within(memory: Option<u64>) -> Self {
        Self { memory, ..Self::default() }
    }

    /// The same for a scene of these media.
    pub(super) fn for_media(self, media: &[MediumSection]) -> Self {
        let mut names: Vec<_> = media.iter().flat_map(scalar_grids).map(name_of).collect();
        names.sort_unstable();
        let twice = names.windows(2).filter(|pair| pair[0] == pair[1]);
        let shared = twice.map(|pair| pair[0].clone()).collect();
        Self { shared, ..self }
    }

    /// Whether several media name the grid, or one twice: it is then read whole, to be shared
    /// wherever they are placed.
    fn is_shared(&self, reference: &GridReference) -> bool {
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
        self.scalar_where(Reading { path: path.into(), index, read_as, seen_at: None }, None)
            .map(|(grid, _)| grid)
    }

    /// The grid that `reading` says, with the leaves that are `wanted`, and how many of its active voxels
    /// were found unwanted now.
    fn scalar_where(
        &mut self,
        reading: Reading,
        wanted: Option<Wanted<'_>>,
    ) -> Result<(Grid<f32>, u64)> {
        if let Some((_, grid)) = self.scalars.iter().find(|(known, _)| *known == reading) {
            return Ok((grid.clone(), 0));
        }
        let file = self.open(&reading.path)?;
        let grid = file.read_scalar_where(reading.index, reading.read_as, wanted)?;
        let label = file.grids()[reading.index].label();
        self.warnings.extend(bad_values(&reading.path, &label, &grid, "taken as 0"));
        self.scalars.push((reading, grid.clone()));
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
    transfer: Option<&TransferSection>,
    placement: &DAffine3,
    context: &mut Context,
) -> Result<Albedo> {
    let (file, grid) = find_vector(reference, context)?;
    if let GridRef::Single { index, .. } = grid
        && !file.grids()[index].is_vector()
    {
        let grid = scalar(reference, ReadAs::Density, placement, context)?;
        return Ok(match transfer {
            Some(transfer) => Albedo::Ramped(Ramped::new(grid, colors(transfer, scale)?)),
            None => Albedo::Scalar { grid, scale },
        });
    }
    if let Some(transfer) = transfer {
        return Err(transfer.at.error(
            "a ramp is for scalar grids, and this one holds colours; leave it out, or name a scalar",
        ));
    }
    let path = &reference.file.path;
    let known = context.grids.vectors.iter().find(|read| read.path == *path && read.grid == grid);
    let grid = if let Some(known) = known {
        known.colors.clone()
    } else {
        let file = at(&reference.file.at, context.grids.open(&reference.file.path))?;
        let read = at(&reference.at, file.read_color(&grid))?;
        context.warnings.extend(bad_values(path, grid.label(), &read, "clamped to [0, 1]"));
        context.grids.vectors.push(ReadColors { path: path.clone(), grid, colors: read.clone() });
        read
    };
    Ok(Albedo::Color { grid: placed(grid, placement, &reference.at)?, scale })
}

fn scalar(
    reference: &GridReference,
    read_as: ReadAs,
    placement: &DAffine3,
    context: &mut Context,
) -> Result<Grid<f32>> {
    let sight = context.sight.filter(|_| !context.grids.is_shared(reference));
    let index = find(reference, context)?.1;
    let place = |p: WorldPoint| WorldPoint::from_xyz(placement.transform_point3(p.xyz));
    let is_wanted = |corners: &[WorldPoint; 8]| {
        sight.is_none_or(|sight| !sight.frustum.misses(&corners.map(place)))
    };
    let wanted = sight.map(|sight| Wanted { is_wanted: &is_wanted, leaves_out: sight.leaves_out });
    let path = reference.file.path.clone();
    let reading = Reading { path, index, read_as, seen_at: sight.map(|_| *placement) };
    let read = context.grids.scalar_where(reading, wanted);
    let (grid, unwanted) = at(&reference.at, read)?;
    context.unseen += unwanted;
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
