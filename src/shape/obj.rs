//! Wavefront OBJ with MTL, through tobj.

use std::cell::RefCell;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use glam::{DVec3, Vec2, Vec3};

use super::parsed::{Parsed, folder};
use super::{MeshData, MeshMaterial, TextureSource};
use crate::file;

pub(super) fn read(path: &Path) -> Result<Parsed, String> {
    let file = File::open(path).map_err(|e| format!("cannot be read: {e}"))?;
    let options = tobj::LoadOptions { single_index: true, triangulate: true, ..Default::default() };
    let beside = RefCell::new(Vec::new());
    // Only a regular file: a pipe would be waited for.
    let load_mtl = |name: &Path| {
        let library = folder(path).join(name);
        let mtl = file::open(&library).map_err(|_| tobj::LoadError::OpenFileFailed)?;
        beside.borrow_mut().push(library);
        tobj::load_mtl_buf(&mut BufReader::new(mtl))
    };
    let (models, materials) = tobj::load_obj_buf(&mut BufReader::new(file), &options, load_mtl)
        .map_err(|e| format!("is no OBJ file that can be read: {e}"))?;
    // A missing or broken MTL leaves the mesh grey, as other readers do.
    let mut materials: Vec<_> =
        materials.unwrap_or_default().into_iter().map(|m| material(m, folder(path))).collect();
    let plain = materials.len() as u32;
    let mut data = MeshData::default();
    for model in &models {
        append(&mut data, &model.mesh, plain);
    }
    if data.slots.contains(&plain) {
        materials.push(MeshMaterial::default());
    }
    Ok(Parsed { data, materials, beside: beside.into_inner() })
}

/// Adds a model. Where one has normals or texture coordinates and another has none, zeros fill the
/// gap.
fn append(data: &mut MeshData, mesh: &tobj::Mesh, plain: u32) {
    let base = data.positions.len() as u32;
    let positions = mesh.positions.as_chunks::<3>().0;
    data.positions.extend(positions.iter().map(|p| DVec3::from(p.map(f64::from))));
    let end = data.positions.len();
    if !mesh.normals.is_empty() {
        data.normals.resize(base as usize, Vec3::ZERO);
        data.normals.extend(mesh.normals.as_chunks::<3>().0.iter().map(|n| Vec3::from(*n)));
    }
    if !mesh.texcoords.is_empty() {
        data.uvs.resize(base as usize, Vec2::ZERO);
        data.uvs.extend(mesh.texcoords.as_chunks::<2>().0.iter().map(|t| Vec2::from(*t)));
    }
    if !data.normals.is_empty() {
        data.normals.resize(end, Vec3::ZERO);
    }
    if !data.uvs.is_empty() {
        data.uvs.resize(end, Vec2::ZERO);
    }
    let triangles = mesh.indices.as_chunks::<3>().0;
    data.triangles.extend(triangles.iter().map(|t| t.map(|i| base + i)));
    let slot = mesh.material_id.map_or(plain, |id| id as u32);
    data.slots.resize(data.triangles.len(), slot);
}

fn material(m: tobj::Material, folder: &Path) -> MeshMaterial {
    // A map without Kd stands for itself.
    let fallback =
        if m.diffuse_texture.is_some() { [1.0; 3] } else { MeshMaterial::default().color };
    MeshMaterial {
        name: m.name,
        color: m.diffuse.map_or(fallback, |c| c.map(f64::from)),
        // Options may stand before the name, which comes last.
        texture: m.diffuse_texture.map(|t| {
            let name =
                if t.starts_with('-') { t.split_whitespace().last().unwrap_or("") } else { &t };
            TextureSource::Path(folder.join(name.replace('\\', "/")))
        }),
    }
}
