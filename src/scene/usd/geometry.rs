//! Surfaces of a shot, gathered by their looks.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DAffine3, Vec2, Vec3};
use toml::Value;

use super::shot::Files;
use crate::math::Rgb;
use crate::scene::draft::{Draft, exact};
use crate::scene::keys::surface as keys;
use crate::shape::MeshData;

/// How a surface looks.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Look {
    /// The material's name.
    pub(super) name: String,
    /// The value of the key `material`.
    pub(super) material: Value,
    /// Radiance in W/(m² sr).
    pub(super) emission: Rgb,
}

impl Look {
    /// A diffuse surface.
    pub(super) fn diffuse(name: &str, reflectance: impl Into<Value>, emission: Rgb) -> Self {
        let mut material = toml::Table::new();
        material.insert("type".into(), "diffuse".into());
        material.insert("reflectance".into(), reflectance.into());
        Self { name: name.into(), material: Value::Table(material), emission }
    }
}

/// Surfaces of one look, as one mesh in the world.
#[derive(Debug)]
struct Group {
    look: Look,
    /// The first prim of it, and how many there are.
    prim: String,
    count: usize,
    mesh: MeshData,
    /// The prims by their first triangles.
    parts: Vec<(u32, String)>,
}

/// Surfaces gathered by their looks, in the order of their first prims.
#[derive(Debug, Default)]
pub(super) struct Geometry {
    groups: Vec<Group>,
    known: HashMap<String, usize>,
}

impl Geometry {
    /// Adds `mesh` of the prim `prim`, placed by `to_world`.
    pub(super) fn add(&mut self, prim: &str, look: &Look, to_world: &DAffine3, mut mesh: MeshData) {
        if mesh.triangles.is_empty() {
            return;
        }
        place(&mut mesh, to_world);
        let key = format!("{} {} {:?}", look.name, look.material, look.emission);
        let groups = &mut self.groups;
        let index = *self.known.entry(key).or_insert_with(|| {
            let (look, mesh) = (look.clone(), MeshData::default());
            groups.push(Group { look, prim: prim.into(), count: 0, mesh, parts: Vec::new() });
            groups.len() - 1
        });
        let group = &mut groups[index];
        group.count += 1;
        group.parts.push((group.mesh.triangles.len() as u32, prim.into()));
        join(&mut group.mesh, mesh);
    }

    /// Adds a lamp of this shape and `radiance`, which is black otherwise.
    pub(super) fn add_lamp(
        &mut self,
        prim: &str,
        to_world: &DAffine3,
        mesh: MeshData,
        radiance: Rgb,
    ) {
        let name = prim.rsplit('/').next().unwrap_or(prim);
        self.add(prim, &Look::diffuse(name, 0.0, radiance), to_world, mesh);
    }

    /// Writes a surface for each look, its mesh among `files`.
    pub(super) fn write(self, draft: &mut Draft, files: &mut Files) {
        for Group { look, prim, count, mut mesh, parts } in self.groups {
            let more = if count > 1 { format!(" and {} more", count - 1) } else { String::new() };
            mesh.parts = parts.into();
            let file = files.mesh(&look.name, Arc::new(mesh));
            draft
                .listed("surface", &format!("{prim}: {}{more}", look.name))
                .key(&keys::SHAPE, "mesh")
                .key(&keys::MESH_FILE, file.as_str())
                .key(&keys::MATERIAL, look.material);
            if look.emission != Rgb::ZERO {
                draft.key(&keys::EMISSION, exact(look.emission));
            }
        }
    }
}

/// Moves `mesh` to the world; corners are rounded as a PLY file has them.
fn place(mesh: &mut MeshData, to_world: &DAffine3) {
    let rounded = |p: &mut glam::DVec3| *p = to_world.transform_point3(*p).as_vec3().as_dvec3();
    mesh.positions.iter_mut().for_each(rounded);
    let of_normals = to_world.matrix3.inverse().transpose();
    for normal in &mut mesh.normals {
        *normal = (of_normals * normal.as_dvec3()).normalize_or_zero().as_vec3();
    }
    if to_world.matrix3.determinant() < 0.0 {
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
}

/// Adds `more` to `mesh`. What only one of them has is 0 for the other: no normal, a corner of the texture.
fn join(mesh: &mut MeshData, more: MeshData) {
    let (before, added) = (mesh.positions.len(), more.positions.len());
    if !mesh.normals.is_empty() || !more.normals.is_empty() {
        mesh.normals.resize(before, Vec3::ZERO);
        mesh.normals.extend(more.normals);
        mesh.normals.resize(before + added, Vec3::ZERO);
    }
    if !mesh.uvs.is_empty() || !more.uvs.is_empty() {
        mesh.uvs.resize(before, Vec2::ZERO);
        mesh.uvs.extend(more.uvs);
        mesh.uvs.resize(before + added, Vec2::ZERO);
    }
    mesh.positions.extend(more.positions);
    let shifted = more.triangles.iter().map(|t| t.map(|i| i + before as u32));
    mesh.triangles.extend(shifted);
}
