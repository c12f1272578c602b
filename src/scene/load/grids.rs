//! Finds, reads and places the grids that a scene names.

use glam::DAffine3;

use super::context::{Context, at};
use super::files::{ReadColors, ScalarKey, add_once, bad_values};
use crate::error::Result;
use crate::math::{Rgb, WorldPoint};
use crate::medium::{Albedo, Ramped, Transfer};
use crate::scene::file::{GridReference, TransferSection, VelocityName};
use crate::scene::reader::Place;
use crate::vdb::roles::GridRef;
use crate::vdb::{BadValues, Grid, ReadAs, VdbFile, Voxel, Wanted};

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
    let label = grid.label().to_owned();
    let grid = if let Some(known) = known {
        known.colors.clone()
    } else {
        let file = at(&reference.file.at, context.grids.open(&reference.file.path))?;
        let read = at(&reference.at, file.read_color(&grid))?;
        context.grids.vectors.push(ReadColors { path: path.clone(), grid, colors: read.clone() });
        read
    };
    add_once(&mut context.warnings, bad_values(path, &label, &grid, "clamped to [0, 1]"));
    Ok(Albedo::Color { grid: placed(grid, placement, &reference.at)?, scale })
}

fn scalar(
    reference: &GridReference,
    read_as: ReadAs,
    placement: &DAffine3,
    context: &mut Context,
) -> Result<Grid<f32>> {
    let culling = context.culling.filter(|_| !context.grids.is_shared(reference));
    let index = find(reference, context)?.1;
    let place = |p: WorldPoint| WorldPoint::from_xyz(placement.transform_point3(p.xyz));
    let is_wanted = |corners: &[WorldPoint; 8]| {
        culling.is_none_or(|culling| !culling.frustum.misses(&corners.map(place)))
    };
    let wanted = culling.map(|c| Wanted { is_wanted: &is_wanted, leaves_out: c.leaves_out });
    let path = reference.file.path.clone();
    let culled = culling.map(|culling| (*placement, culling.frustum, culling.leaves_out));
    let key = ScalarKey { path, index, read_as, culled };
    let read = context.grids.scalar_where(key, wanted);
    let (grid, unwanted) = at(&reference.at, read)?;
    context.unseen += unwanted;
    placed(grid, placement, &reference.at)
}

/// The velocities called `name` in the file of `density`; `None` where there are none. Bad values are taken as 0 and warned of.
pub(super) fn velocity(
    density: &GridReference,
    name: &VelocityName,
    context: &mut Context,
) -> Result<Option<Grid<[f32; 3]>>> {
    let file = at(&density.file.at, context.grids.open(&density.file.path))?;
    let (place, found) = match name {
        VelocityName::Still => return Ok(None),
        VelocityName::Usual => (&density.at, file.default_velocity()),
        VelocityName::Vector(place, name) => {
            (place, Some(at(place, file.find_vector(name, density.index))?))
        }
        VelocityName::Components(place, names) => {
            let find = |name: &String| at(place, file.find(name, None));
            let [x, y, z] = names.each_ref().map(find);
            let indices = [x?, y?, z?];
            (place, Some(GridRef::Triple { indices, label: names.join(", ") }))
        }
    };
    let Some(found) = found else { return Ok(None) };
    let read = at(place, file.read_vector_of(&found))?;
    let BadValues { nan, infinite, .. } = read.bad_values();
    if nan + infinite > 0 {
        add_once(
            &mut context.warnings,
            [format!(
                "{}: grid \"{}\": {} velocities that are not finite taken as 0",
                density.file.path.display(),
                found.label(),
                nan + infinite
            )],
        );
    }
    Ok(Some(read))
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

/// Adds a note, once, that `grid` was taken where the name fits several.
fn note(notes: &mut Vec<String>, file: &VdbFile, grid: &GridRef, reference: &GridReference) {
    add_once(notes, file.ambiguity(grid).filter(|_| reference.index.is_none()));
}

pub(super) fn placed<V: Voxel>(
    grid: Grid<V>,
    placement: &DAffine3,
    place: &Place,
) -> Result<Grid<V>> {
    if *placement == DAffine3::IDENTITY {
        return Ok(grid);
    }
    grid.placed(placement).ok_or_else(|| {
        place.error("the placement makes the grid's transform singular; give a scale nearer to 1")
    })
}

/// The transfer function to colours that `section` is, times `factor`.
pub(super) fn colors(section: &TransferSection, factor: Rgb) -> Result<Transfer<Rgb>> {
    at(&section.at, Transfer::new(section.remap, &section.times(factor)))
}
