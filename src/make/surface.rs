//! The surface of a solid, as triangles.

use fast_surface_nets::ndshape::{RuntimeShape, Shape};
use fast_surface_nets::{SurfaceNetsBuffer, surface_nets};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::sparse::Domain;
use crate::shape::MeshData;

/// Samples beyond each face of the domain, so that the surface closes inside.
const MARGIN: i32 = 2;

/// Where `distance` is 0 in `domain`, as a mesh in units of `unit` metres.
///
/// `distance` is called with coordinates in units of the longest side; it is negative inside.
/// The vertices come in the order of their voxels whatever the number of threads (naive surface
/// nets: Gibson 1998, "Constrained elastic surface nets").
pub(super) fn surface(
    domain: Domain,
    unit: f64,
    distance: impl Fn(DVec3) -> f64 + Sync,
) -> MeshData {
    let origin = domain.min - MARGIN;
    let size = (domain.max - domain.min + 2 * MARGIN).as_uvec3();
    let grid = RuntimeShape::<u32, 3>::new(size.to_array());
    let scale = 1.0 / f64::from(domain.resolution);
    let samples: Vec<f32> = (0..grid.size())
        .into_par_iter()
        .map(|i| {
            let voxel = origin.as_dvec3() + DVec3::from(grid.delinearize(i).map(f64::from));
            distance(voxel * scale) as f32
        })
        .collect();
    let mut nets = SurfaceNetsBuffer::default();
    surface_nets(&samples, &grid, [0; 3], (size - 1).to_array(), &mut nets);
    let place = |p: &[f32; 3]| (origin.as_dvec3() + DVec3::from(p.map(f64::from))) * (scale * unit);
    MeshData {
        positions: nets.positions.iter().map(place).collect(),
        normals: nets.normals.iter().map(|n| Vec3::from(*n).normalize_or_zero()).collect(),
        triangles: nets.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
        ..MeshData::default()
    }
}
