//! Meshes from files.

use std::path::{Path, PathBuf};

use glam::DAffine3;

use super::parsed::{MeshMaterial, Parsed};
use super::{Mesh, gltf, obj, ply};
use crate::error::{Error, Result};

/// The name of the thread that reads mesh files. A damaged file can make a crate panic; that ends this
/// thread and is reported as an error, so that its message on stderr may be left out.
pub const MESH_READER: &str = "mesh reader";

/// A mesh from a file with its materials.
#[derive(Debug, Clone)]
pub struct LoadedMesh {
    /// The mesh, placed.
    pub mesh: Mesh,
    /// Its materials by slot; there is one for every slot that the mesh names.
    pub materials: Vec<MeshMaterial>,
    /// Files beside it that were read: material libraries, buffers; not the textures.
    pub beside: Vec<PathBuf>,
}

/// Reads an OBJ (with MTL), PLY, glTF or GLB file, by its extension, and places it in the world.
/// Units of the file are taken as metres.
///
/// # Errors
/// Where the file is missing, of no such format, broken, without triangles, or with indices or
/// coordinates that cannot be; the message names the file and the problem.
pub fn load_mesh(path: &Path, placement: &DAffine3) -> Result<LoadedMesh> {
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    let read: fn(&Path) -> Result<Parsed, String> = match extension.as_str() {
        "obj" => obj::read,
        "ply" => ply::read,
        "gltf" | "glb" => gltf::read,
        _ => {
            let problem = "is no mesh that fogbow reads; it must end in .obj, .ply, .gltf or .glb";
            return Err(Error::file(path, problem));
        }
    };
    if !path.is_file() {
        let problem = if path.exists() { "is not a regular file" } else { "does not exist" };
        return Err(Error::file(path, problem));
    }
    let parsed = apart(|| read(path)).map_err(|problem| Error::file(path, problem))?;
    let mesh = Mesh::new(parsed.data, placement).map_err(|problem| Error::file(path, problem))?;
    let mut materials = parsed.materials;
    materials.resize_with(materials.len().max(mesh.slot_count()), MeshMaterial::default);
    Ok(LoadedMesh { mesh, materials, beside: parsed.beside })
}

/// Runs `read` on a thread of its own: where a crate panics over a damaged file, that ends there.
fn apart(read: impl FnOnce() -> Result<Parsed, String> + Send) -> Result<Parsed, String> {
    std::thread::scope(|scope| {
        let reader = std::thread::Builder::new()
            .name(MESH_READER.into())
            .spawn_scoped(scope, read)
            .map_err(|e| format!("cannot be read: {e}"))?;
        reader.join().unwrap_or_else(|_| Err("is damaged: its numbers cannot be".into()))
    })
}
