//! Shapes that USD has and scenes have as meshes.

use std::collections::HashMap;
use std::f64::consts::TAU;

use glam::{DVec3, Vec3};

use crate::shape::MeshData;

/// How often the triangles of a ball are split into four: its outline is then off by less than a hundredth.
const SPLITS: u32 = 3;
/// Corners of a disk.
const CORNERS: u32 = 64;

/// A ball about the origin with the surface of one of radius 1.
pub(super) fn sphere() -> MeshData {
    let (mut positions, mut triangles) = octahedron();
    for _ in 0..SPLITS {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32, positions: &mut Vec<DVec3>| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                positions.push((positions[a as usize] + positions[b as usize]).normalize());
                positions.len() as u32 - 1
            })
        };
        let mut split = Vec::with_capacity(4 * triangles.len());
        for [a, b, c] in triangles {
            let ab = middle(a, b, &mut positions);
            let bc = middle(b, c, &mut positions);
            let ca = middle(c, a, &mut positions);
            split.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        triangles = split;
    }
    let area: f64 = triangles.iter().map(|t| area(&positions, t)).sum();
    let scale = (2.0 * TAU / area).sqrt();
    let normals: Vec<Vec3> = positions.iter().map(|p| p.as_vec3()).collect();
    positions.iter_mut().for_each(|p| *p *= scale);
    MeshData { positions, triangles, normals, ..MeshData::default() }
}

/// A disk about the origin that looks along -z, with the surface of one of radius 1.
pub(super) fn disk() -> MeshData {
    let step = TAU / f64::from(CORNERS);
    let radius = (step / step.sin()).sqrt();
    let corner = |k: u32| DVec3::new(radius, 0.0, 0.0).rotate_z(f64::from(k) * step);
    let positions: Vec<DVec3> =
        std::iter::once(DVec3::ZERO).chain((0..CORNERS).map(corner)).collect();
    let triangles = (0..CORNERS).map(|k| [0, 1 + (k + 1) % CORNERS, 1 + k]).collect();
    MeshData { positions, triangles, ..MeshData::default() }
}

/// A cube about the origin with sides of length 1.
pub(super) fn cube() -> MeshData {
    let corner = |k: u32| DVec3::from([0, 1, 2].map(|axis| f64::from(k >> axis & 1) - 0.5));
    let faces =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = faces.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    MeshData { positions: (0..8).map(corner).collect(), triangles, ..MeshData::default() }
}

fn octahedron() -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let positions =
        [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z].to_vec();
    let triangles = vec![
        [0, 2, 4],
        [2, 1, 4],
        [1, 3, 4],
        [3, 0, 4],
        [2, 0, 5],
        [1, 2, 5],
        [3, 1, 5],
        [0, 3, 5],
    ];
    (positions, triangles)
}

fn area(positions: &[DVec3], triangle: &[u32; 3]) -> f64 {
    let [a, b, c] = triangle.map(|i| positions[i as usize]);
    0.5 * (b - a).cross(c - a).length()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The integral of the normal over the surface, which is 0 where it is closed, and the volume.
    fn totals(mesh: &MeshData) -> (DVec3, f64, f64) {
        let (mut normal, mut volume, mut surface) = (DVec3::ZERO, 0.0, 0.0);
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
            normal += 0.5 * (b - a).cross(c - a);
            volume += a.dot(b.cross(c)) / 6.0;
            surface += area(&mesh.positions, triangle);
        }
        (normal, volume, surface)
    }

    #[test]
    fn closed_shapes_look_outward_and_have_the_right_surface() {
        let (normal, volume, surface) = totals(&sphere());
        assert!(
            normal.length() < 1e-12 && (volume / (2.0 * TAU / 3.0) - 1.0).abs() < 0.02,
            "{volume}"
        );
        assert!((surface / (2.0 * TAU) - 1.0).abs() < 1e-12);
        let (normal, volume, surface) = totals(&cube());
        assert!(normal.length() < 1e-12 && (volume - 1.0).abs() < 1e-12 && surface == 6.0);
        let (normal, _, _) = totals(&disk());
        assert!((normal + DVec3::Z * 0.5 * TAU).length() < 1e-12, "{normal}");
    }
}
