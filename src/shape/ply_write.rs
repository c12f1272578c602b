//! Binary PLY, through ply-rs-bw.

use std::path::Path;

use glam::{DVec3, Vec2, Vec3};
use ply_rs_bw::ply::{
    Addable, DefaultElement, ElementDef, Encoding, Ply, Property, PropertyDef, PropertyType,
    ScalarType,
};
use ply_rs_bw::writer::Writer;

use super::MeshData;
use crate::error::Result;
use crate::file;

/// What a comment that names a part of the mesh begins with, before its first face and its name.
pub(super) const PART: &str = "fogbow part ";

/// Writes the positions, the normals and texture coordinates where there are any, and the triangles of `mesh`
/// as a binary PLY file, in 32 bits each. Its parts are told by comments.
///
/// # Errors
/// Where the file cannot be written; an earlier one is intact then.
pub fn write_ply(path: &Path, mesh: &MeshData) -> Result<()> {
    let float = PropertyType::Scalar(ScalarType::Float);
    let normals: &[&str] = if mesh.normals.is_empty() { &[] } else { &NORMAL };
    let uvs: &[&str] = if mesh.uvs.is_empty() { &[] } else { &UV };
    let names = &[&POSITION, normals, uvs].concat();
    let mut vertex = ElementDef::new("vertex".into());
    for name in names {
        vertex.properties.add(PropertyDef::new((*name).into(), float.clone()));
    }
    let mut face = ElementDef::new("face".into());
    let list = PropertyType::List(ScalarType::UChar, ScalarType::Int);
    face.properties.add(PropertyDef::new(CORNERS.into(), list));
    let mut ply = Ply::<DefaultElement>::new();
    ply.header.encoding = Encoding::BinaryLittleEndian;
    ply.header.comments =
        mesh.parts.iter().map(|(first, name)| format!("{PART}{first} {name}")).collect();
    ply.header.elements.add(vertex);
    ply.header.elements.add(face);
    ply.payload.insert("vertex".into(), vertices(mesh, names));
    ply.payload.insert("face".into(), mesh.triangles.iter().map(triangle).collect());
    file::write(path, |out| {
        Writer::new().write_ply(out, &mut ply).map(drop).map_err(std::io::Error::other)
    })
}

const POSITION: [&str; 3] = ["x", "y", "z"];
const NORMAL: [&str; 3] = ["nx", "ny", "nz"];
const UV: [&str; 2] = ["s", "t"];
const CORNERS: &str = "vertex_indices";

fn vertices(mesh: &MeshData, names: &[&str]) -> Vec<DefaultElement> {
    let vertex = |(index, position): (usize, &DVec3)| {
        let normal = mesh.normals.get(index).into_iter().flat_map(Vec3::to_array);
        let uv = mesh.uvs.get(index).into_iter().flat_map(Vec2::to_array);
        let values = position.as_vec3().to_array().into_iter().chain(normal).chain(uv);
        names.iter().zip(values).map(|(n, v)| ((*n).into(), Property::Float(v))).collect()
    };
    mesh.positions.iter().enumerate().map(vertex).collect()
}

fn triangle(corners: &[u32; 3]) -> DefaultElement {
    let corners = corners.map(|i| i as i32).to_vec();
    DefaultElement::from([(CORNERS.into(), Property::ListInt(corners))])
}
