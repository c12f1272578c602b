//! Arrays become VDB files.

use std::path::PathBuf;

use glam::{DAffine3, DQuat, DVec3, IVec3};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use rayon::prelude::*;

use super::exception::Failure;
use super::scene::numbers;
use crate::vdb::{Block, GridToWrite, ValueType, write};

/// Edge of a block of voxels.
const EDGE: usize = 8;

/// A grid to write: name, voxels along x, y and z, values of each, and the bytes of 32-bit numbers with z the fastest.
type Given<'py> = (String, [usize; 3], usize, Bound<'py, PyBytes>);

/// Writes arrays as grids of one VDB file. The sample of voxel (0, 0, 0) lies at `origin`; voxel size and origin in
/// metres.
#[pyfunction]
pub(super) fn write_volume(
    py: Python<'_>,
    path: PathBuf,
    grids: Vec<Given<'_>>,
    voxel_size: [f64; 3],
    origin: [f64; 3],
) -> PyResult<()> {
    let scale = DVec3::from_array(voxel_size);
    let transform = DAffine3::from_scale_rotation_translation(
        scale,
        DQuat::IDENTITY,
        DVec3::from_array(origin),
    );
    let given: Vec<_> = grids
        .iter()
        .map(|(name, shape, values, bytes)| (name, *shape, *values, bytes.as_bytes()))
        .collect();
    let written = py.detach(|| {
        let mut grids = Vec::new();
        for (name, shape, values, bytes) in given {
            let numbers = numbers(bytes);
            if numbers.len() != shape.iter().product::<usize>() * values {
                return Ok(Err("an array has another number of values than its shape"));
            }
            let value_type = if values == 3 { ValueType::Vec3 } else { ValueType::Float };
            let blocks = blocks(shape, values, &numbers);
            let grid = GridToWrite::fog(name, 1.0, DVec3::ZERO);
            grids.push(GridToWrite { value_type, transform, blocks, ..grid });
        }
        write(&path, &grids).map(Ok)
    });
    written.map_err(|e| Failure(e).raised(py))?.map_err(PyValueError::new_err)
}

/// The blocks of an array that are not 0 all over.
fn blocks(shape: [usize; 3], values: usize, numbers: &[f32]) -> Vec<Block> {
    let [nx, ny, nz] = shape.map(|n| n.div_ceil(EDGE));
    let block = |number: usize| {
        let at = [number / (ny * nz), number / nz % ny, number % nz].map(|n| n * EDGE);
        let mut block = vec![0.0; EDGE * EDGE * EDGE * values];
        for x in at[0]..shape[0].min(at[0] + EDGE) {
            for y in at[1]..shape[1].min(at[1] + EDGE) {
                let count = EDGE.min(shape[2] - at[2]) * values;
                let from = ((x * shape[1] + y) * shape[2] + at[2]) * values;
                let to = ((x - at[0]) * EDGE + (y - at[1])) * EDGE * values;
                block[to..to + count].copy_from_slice(&numbers[from..from + count]);
            }
        }
        let origin = IVec3::from_array(at.map(|n| n as i32));
        block.iter().any(|v| *v != 0.0).then_some(Block { origin, values: block, active: None })
    };
    (0..nx * ny * nz).into_par_iter().filter_map(block).collect()
}
