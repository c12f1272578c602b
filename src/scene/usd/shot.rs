//! Files of a shot, as its scene names them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::shape::MeshData;

/// The files that the scene of a shot names, by those names.
#[derive(Debug, Clone, Default)]
pub struct Files {
    /// The folder of the shot, and that into which its package was unpacked.
    folders: Vec<PathBuf>,
    /// Where the package of the shot was unpacked.
    unpacked: Option<PathBuf>,
    /// Folder of the meshes, as the scene names it.
    meshes_in: String,
    /// VDB files and pictures: where they are.
    pub(in crate::scene) assets: BTreeMap<String, PathBuf>,
    /// Where those are that stand in their places one frame later, between two frames.
    pub(in crate::scene) next_assets: BTreeMap<String, PathBuf>,
    /// Meshes, which are in no files.
    pub(in crate::scene) meshes: BTreeMap<String, Arc<MeshData>>,
}

impl Files {
    /// Those of the shot `path`, none yet.
    pub(super) fn of(path: &Path, unpacked: Option<&Path>) -> Self {
        let folder = path.parent().unwrap_or(Path::new(""));
        let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let absolute = std::path::absolute(here).unwrap_or_else(|_| here.into());
        let canonical = here.canonicalize();
        let folders = unpacked.into_iter().map(Path::to_path_buf);
        let folders = folders.chain([absolute]).chain(canonical).collect();
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let unpacked = unpacked.map(Path::to_path_buf);
        Self { folders, unpacked, meshes_in: format!("{stem}_meshes"), ..Self::default() }
    }

    /// The name of the file `path`: relative to the shot where it lies below it.
    pub(super) fn asset(&mut self, path: PathBuf) -> String {
        let plain: PathBuf = path.components().collect();
        let below = self.folders.iter().find_map(|folder| plain.strip_prefix(folder).ok());
        let name = below.unwrap_or(&plain).to_string_lossy().into_owned();
        self.assets.insert(name.clone(), path);
        name
    }

    /// The name of a file for `mesh`, after `name`.
    pub(super) fn mesh(&mut self, name: &str, mesh: Arc<MeshData>) -> String {
        let plain = |c: char| if c.is_ascii_alphanumeric() || "-_".contains(c) { c } else { '_' };
        let stem: String = name.chars().map(plain).collect();
        let named = |number: usize| {
            let number = if number == 1 { String::new() } else { format!("_{number}") };
            format!("{}/{stem}{number}.ply", self.meshes_in)
        };
        let free = (1..).map(named).find(|name| !self.meshes.contains_key(name));
        let file = free.unwrap_or_default();
        self.meshes.insert(file.clone(), mesh);
        file
    }

    /// The name of the mesh that the mesh `name` is in `later`, one frame later; `None` where it is the same there, and an error
    /// where it has other triangles.
    pub(in crate::scene) fn next_mesh(
        &mut self,
        name: &str,
        later: &Self,
    ) -> Result<Option<String>, ()> {
        let Some(here) = self.meshes.get(name) else { return Ok(None) };
        let there = later.meshes.get(name).ok_or(())?;
        if there.positions == here.positions && there.normals == here.normals {
            return Ok(None);
        }
        let is_same = there.triangles == here.triangles
            && there.positions.len() == here.positions.len()
            && there.normals.len() == here.normals.len();
        let there = is_same.then(|| Arc::clone(there)).ok_or(())?;
        let next = format!("{}_next.ply", name.trim_end_matches(".ply"));
        self.meshes.insert(next.clone(), there);
        Ok(Some(next))
    }

    /// VDB files and pictures by their names in the scene: where they are.
    pub fn assets(&self) -> impl Iterator<Item = (&str, &Path)> {
        self.assets.iter().map(|(name, path)| (name.as_str(), path.as_path()))
    }

    /// Meshes by the names of their files in the scene.
    pub fn meshes(&self) -> impl Iterator<Item = (&str, &MeshData)> {
        self.meshes.iter().map(|(name, mesh)| (name.as_str(), mesh.as_ref()))
    }

    /// Whether `path` lies in the package of the shot, and not beside it.
    pub fn is_packed(&self, path: &Path) -> bool {
        self.unpacked.as_ref().is_some_and(|folder| path.starts_with(folder))
    }
}
