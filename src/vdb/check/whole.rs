//! Whether the walk understands a file to its last byte, as one of an unknown format must be.

use std::io::{Read, Seek};

use super::bytes::Bytes;
use super::header::{GridLayout, GridProblem, Layout, plain};
use super::tree;

/// Checks that each byte belongs to the header, a grid's descriptor, or a grid, and that every tree
/// of a known type ends where its grid does. Trees of other types are taken for what their offsets
/// say.
pub(super) fn check<R: Read + Seek>(
    file: &mut Bytes<R>,
    layout: &Layout,
) -> Result<(), GridProblem> {
    for grid in &layout.grids {
        of_grid(file, grid).map_err(|problem| (Some(plain(&grid.unique_name)), problem))?;
    }
    match file.length() - layout.end() {
        0 => Ok(()),
        behind => Err((None, format!("goes on for {behind} bytes behind its last grid"))),
    }
}

fn of_grid<R: Read + Seek>(file: &mut Bytes<R>, grid: &GridLayout) -> Result<(), String> {
    if grid.start != grid.described {
        return Err(format!(
            "starts at byte {} and its descriptor ends at {}",
            grid.start, grid.described
        ));
    }
    let end = match grid.values {
        _ if !grid.parent.is_empty() => grid.tree,
        None => grid.end,
        Some(values) => {
            file.seek(grid.tree)?;
            tree::walk(file, values)?;
            file.at()
        }
    };
    if end != grid.end {
        return Err(format!("has voxels to byte {end} and should end at {}", grid.end));
    }
    Ok(())
}
