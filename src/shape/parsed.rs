//! What the readers of mesh formats hand over.

use std::path::{Path, PathBuf};

use super::MeshData;

/// What a mesh file says of a material.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshMaterial {
    /// Its name in the file; empty where it has none.
    pub name: String,
    /// Diffuse reflectance or base colour, linear Rec.709. It multiplies the texture.
    pub color: [f64; 3],
    /// Its texture, sRGB.
    pub texture: Option<TextureSource>,
}

/// Where a texture is.
#[derive(Debug, Clone, PartialEq)]
pub enum TextureSource {
    /// In a file, not opened yet.
    Path(PathBuf),
    /// Inside the mesh file: an encoded PNG or JPEG.
    Bytes(Vec<u8>),
}

impl Default for MeshMaterial {
    /// A grey of reflectance 0.8.
    fn default() -> Self {
        Self { name: String::new(), color: [0.8; 3], texture: None }
    }
}

/// What a reader of one format hands over.
pub(super) struct Parsed {
    pub(super) data: MeshData,
    pub(super) materials: Vec<MeshMaterial>,
    pub(super) beside: Vec<PathBuf>,
}

/// The folder that relative paths in the file at `path` start from.
pub(super) fn folder(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new(""))
}

/// Splits a convex polygon into a fan of triangles.
pub(super) fn fan(polygon: &[u32]) -> impl Iterator<Item = [u32; 3]> + '_ {
    polygon.windows(2).skip(1).map(|pair| [polygon[0], pair[0], pair[1]])
}
