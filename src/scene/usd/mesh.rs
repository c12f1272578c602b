//! Meshes of a shot (UsdGeomMesh).

use std::collections::HashMap;

use glam::{Vec2, Vec3};
use openusd::sdf;

use super::values::Reader;
use crate::error::Result;
use crate::shape::MeshData;

/// Attributes that may hold normals.
const NORMALS: [&str; 2] = ["primvars:normals", "normals"];

/// Attributes that may hold texture coordinates, by the usual names.
const UVS: [&str; 4] = ["primvars:st", "primvars:UVMap", "primvars:uv", "primvars:map1"];

/// The faces of a mesh that have the same material.
pub(super) struct Part {
    /// The prim that says which material that is: a subset, or nothing for the mesh itself.
    pub(super) subset: Option<sdf::Path>,
    pub(super) mesh: MeshData,
}

/// The mesh at `path`, by its subsets for materials, and whether it is the cage of a subdivision surface.
///
/// # Errors
/// Where its lists do not fit each other.
pub(super) fn parts(reader: &Reader<'_>, path: &sdf::Path) -> Result<(Vec<Part>, bool)> {
    let mesh = Source::read(reader, path)?;
    let subdivides =
        !matches!(reader.word(path, "subdivisionScheme")?.as_deref(), Some("none" | "bilinear"));
    let mut part_of_face = vec![0_usize; mesh.counts.len()];
    let mut subsets = vec![None];
    let children = reader.stage.prim(path.clone()).child_names();
    for name in reader.of(path, children)? {
        let child = reader.of(path, path.append_path(name.as_str()))?;
        let is_material = || -> Result<bool> {
            Ok(reader.type_of(&child)? == "GeomSubset"
                && reader.word(&child, "familyName")?.as_deref() == Some("materialBind"))
        };
        if !is_material()? {
            continue;
        }
        for face in reader.integers(&child, "indices")? {
            let known = usize::try_from(face).ok().and_then(|face| part_of_face.get_mut(face));
            let Some(part) = known else {
                let faces = mesh.counts.len();
                return Err(reader.wrong(&child, format!("has face {face} of a mesh of {faces}")));
            };
            *part = subsets.len();
        }
        subsets.push(Some(child));
    }
    let parts = subsets.into_iter().enumerate().map(|(index, subset)| Part {
        subset,
        mesh: mesh.triangulated(|face| part_of_face[face] == index),
    });
    Ok((parts.filter(|part| !part.mesh.triangles.is_empty()).collect(), subdivides))
}

/// What a mesh says.
struct Source {
    points: Vec<glam::DVec3>,
    /// Corners of each face.
    counts: Vec<usize>,
    /// Points of all corners.
    corners: Vec<u32>,
    normals: Spread<Vec3>,
    uvs: Spread<Vec2>,
    is_left_handed: bool,
    /// Faces that are holes.
    holes: Vec<bool>,
}

/// Values over a mesh.
enum Spread<T> {
    None,
    /// One a point.
    Points(Vec<T>),
    /// One a corner of a face.
    Corners(Vec<T>),
    /// One a face.
    Faces(Vec<T>),
}

impl<T: Copy> Spread<T> {
    /// The value at a corner.
    fn at(&self, face: usize, corner: usize, point: usize) -> Option<T> {
        match self {
            Self::None => None,
            Self::Points(list) => list.get(point).copied(),
            Self::Corners(list) => list.get(corner).copied(),
            Self::Faces(list) => list.get(face).copied(),
        }
    }

    const fn is_some(&self) -> bool {
        !matches!(self, Self::None)
    }
}

impl Source {
    fn read(reader: &Reader<'_>, path: &sdf::Path) -> Result<Self> {
        let points = reader.triples(path, "points")?;
        if let Some(index) = points.iter().position(|p| !p.is_finite()) {
            return Err(reader.wrong(path, format!("points[{index}] is not finite")));
        }
        let counts = reader.integers(path, "faceVertexCounts")?;
        let counts: Vec<_> = counts.iter().map(|n| usize::try_from(*n).unwrap_or(0)).collect();
        let indices = reader.integers(path, "faceVertexIndices")?;
        let needed: usize = counts.iter().sum();
        if needed != indices.len() {
            let found = indices.len();
            let problem =
                format!("its faceVertexCounts need {needed} faceVertexIndices, it has {found}");
            return Err(reader.wrong(path, problem));
        }
        let corner = |index: &i64| {
            let known = u32::try_from(*index).ok().filter(|i| (*i as usize) < points.len());
            known.ok_or_else(|| {
                reader.wrong(path, format!("a face has the point {index} of {}", points.len()))
            })
        };
        let corners = indices.iter().map(corner).collect::<Result<Vec<_>>>()?;
        let mut holes = vec![false; counts.len()];
        for hole in reader.integers(path, "holeIndices")? {
            if let Some(face) = usize::try_from(hole).ok().and_then(|hole| holes.get_mut(hole)) {
                *face = true;
            }
        }
        let sizes = Sizes { points: points.len(), corners: corners.len(), faces: counts.len() };
        let normals = sizes.first(reader, path, &NORMALS, |name| {
            Ok(reader.triples(path, name)?.iter().map(|v| v.as_vec3()).collect())
        })?;
        let uvs = sizes.first(reader, path, &UVS, |name| reader.pairs(path, name))?;
        let is_left_handed = reader.word(path, "orientation")?.as_deref() == Some("leftHanded");
        Ok(Self { points, counts, corners, normals, uvs, is_left_handed, holes })
    }

    /// The faces for which `is_in` holds, as fans of triangles.
    fn triangulated(&self, is_in: impl Fn(usize) -> bool) -> MeshData {
        let mut mesh = MeshData::default();
        let mut known: HashMap<(u32, [u32; 5]), u32> = HashMap::new();
        let mut first = 0;
        for (face, count) in self.counts.iter().enumerate() {
            let corners = first..first + count;
            first += count;
            if !is_in(face) || self.holes[face] || *count < 3 {
                continue;
            }
            let mut vertices = Vec::with_capacity(*count);
            for corner in corners {
                let point = self.corners[corner];
                let normal = self.normals.at(face, corner, point as usize).unwrap_or(Vec3::ZERO);
                let uv = self.uvs.at(face, corner, point as usize).unwrap_or(Vec2::ZERO);
                let bits = [normal.x, normal.y, normal.z, uv.x, uv.y].map(f32::to_bits);
                vertices.push(*known.entry((point, bits)).or_insert_with(|| {
                    mesh.positions.push(self.points[point as usize]);
                    if self.normals.is_some() {
                        mesh.normals.push(normal);
                    }
                    if self.uvs.is_some() {
                        mesh.uvs.push(uv);
                    }
                    mesh.positions.len() as u32 - 1
                }));
            }
            if self.is_left_handed {
                vertices.reverse();
            }
            let fan = vertices.windows(2).skip(1).map(|pair| [vertices[0], pair[0], pair[1]]);
            mesh.triangles.extend(fan);
        }
        mesh
    }
}

/// How many values of each kind a mesh has.
struct Sizes {
    points: usize,
    corners: usize,
    faces: usize,
}

impl Sizes {
    /// `list` as `interpolation` spreads it; nothing where it is too short.
    fn spread<T>(&self, interpolation: Option<&str>, list: Vec<T>) -> Spread<T> {
        let found = list.len();
        let (needed, spread) = match interpolation {
            Some("faceVarying") => (self.corners, Spread::Corners(list)),
            Some("uniform") => (self.faces, Spread::Faces(list)),
            Some("constant") => return Spread::None,
            _ => (self.points, Spread::Points(list)),
        };
        if found == 0 || found < needed { Spread::None } else { spread }
    }

    /// The first of the attributes `names` that has any values, as `read` gives them.
    fn first<T: Copy>(
        &self,
        reader: &Reader<'_>,
        path: &sdf::Path,
        names: &[&str],
        read: impl Fn(&str) -> Result<Vec<T>>,
    ) -> Result<Spread<T>> {
        for name in names {
            let list = read(name)?;
            if !list.is_empty() {
                let list = indexed(list, &reader.integers(path, &format!("{name}:indices"))?);
                let interpolation = reader.interpolation(path, name)?;
                return Ok(self.spread(interpolation.as_deref(), list));
            }
        }
        Ok(Spread::None)
    }
}

/// `list` as `indices` order it.
fn indexed<T: Copy>(list: Vec<T>, indices: &[i64]) -> Vec<T> {
    if indices.is_empty() {
        return list;
    }
    let get = |index: &i64| usize::try_from(*index).ok().and_then(|i| list.get(i).copied());
    indices.iter().map_while(get).collect()
}
