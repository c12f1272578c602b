//! Opening files and reading grids.

use std::path::{Path, PathBuf};

use bytesize::ByteSize;
use glam::DVec3;

use crate::error::{Error, Result};
use crate::math::{Aabb, Index, Transform, WorldPoint};

use super::check::Checked;
use super::ffi::bridge;
use super::grid::Grid;
use super::info::{GridInfo, describe, texts};
use super::source::Source;
use super::statistics::Statistics;
use super::voxel::Voxel;

/// Bytes that a leaf of single numbers takes while it is read: as OpenVDB has it, as it comes over the
/// bridge, and with its neighbours' first values.
const LEAF: u64 = 4 * (512 + 512 + 729) + 1024;

/// Which parts of a grid are wanted.
#[derive(Clone, Copy)]
pub struct Wanted<'w> {
    /// Asked of the corners, in the world of the file, of the boxes into which leaves of voxels
    /// reach.
    pub is_wanted: &'w dyn Fn(&[WorldPoint; 8]) -> bool,
    /// Whether other parts are left out, and not only counted.
    pub leaves_out: bool,
}

/// How to take the numbers of a scalar grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReadAs {
    /// As they are, level sets too.
    Raw,
    /// As a density: NaN, infinite and negative values are counted and taken as 0; a level set is
    /// refused.
    Density,
    /// As [`Density`](Self::Density), but a level set becomes a fog volume by OpenVDB's
    /// `sdfToFogVolume`: 1 inside, falling to 0 over the narrow band.
    LevelSetAsFog,
}

/// An open OpenVDB file: the metadata of all its grids, and the voxels of those asked for.
pub struct VdbFile {
    path: PathBuf,
    file: cxx::UniquePtr<bridge::File>,
    checked: Checked,
    writer: String,
    metadata: Vec<(String, String)>,
    grids: Vec<GridInfo>,
    /// Bytes that reading a grid may take.
    memory: Option<u64>,
}

impl std::fmt::Debug for VdbFile {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("VdbFile").field("path", &self.path).field("grids", &self.grids).finish()
    }
}

impl VdbFile {
    /// Opens a file and reads the metadata of all grids, but no voxels.
    ///
    /// # Errors
    /// Where there is no such file, it is a folder, not an OpenVDB file, truncated, damaged in its
    /// headers, or of an unknown format and not built as files of known ones are.
    pub fn open(path: &Path) -> Result<Self> {
        let checked = Checked::open(path)?;
        let Some(name) = path.to_str() else {
            return Err(Error::file(path, "the name is not UTF-8, which OpenVDB needs"));
        };
        let of_file = |e: cxx::Exception| Error::file(path, reading(&e));
        let [major, minor] = checked.library();
        let file = bridge::open_file(name, [major, minor], checked.version()).map_err(of_file)?;
        let metadata = texts(file.metadata(Checked::METADATA).map_err(of_file)?);
        let grids = describe(&file, &checked).map_err(of_file)?;
        Ok(Self {
            path: path.to_path_buf(),
            file,
            writer: format!("{major}.{minor}"),
            metadata,
            checked,
            grids,
            memory: None,
        })
    }

    /// The same file, of which no grid is read that takes more than `memory` bytes on its way.
    #[must_use]
    pub fn within(self, memory: Option<u64>) -> Self {
        Self { memory, ..self }
    }

    /// The file as it was named.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// All grids, in the order of the file.
    pub fn grids(&self) -> &[GridInfo] {
        &self.grids
    }

    /// Version of the file format, such as 224.
    pub fn version(&self) -> u32 {
        self.checked.version()
    }

    /// What a user should know of the file before it is used, each in one line that names it: that its
    /// format is newer than the library's own.
    pub fn notes(&self) -> Vec<String> {
        let note = |note: String| format!("{}: {note}", self.path.display());
        self.checked.note().map(note).into_iter().collect()
    }

    /// Metadata of the file by name, as OpenVDB prints values; entries longer than 256 bytes and types
    /// that it does not know are left out.
    pub fn metadata(&self) -> &[(String, String)] {
        &self.metadata
    }

    /// Version of the library that wrote the file, such as `8.0`.
    pub fn library_version(&self) -> &str {
        &self.writer
    }

    /// Version of the library that reads it, such as `10.0.1`.
    pub fn reader_version() -> String {
        bridge::library_version()
    }

    /// Reads the scalar grid number `index` of [`grids`](Self::grids).
    ///
    /// # Errors
    /// Where it holds no scalars, has a frustum transform, is a level set while
    /// [`ReadAs::Density`] is asked for, or the file is damaged.
    pub fn read_scalar(&self, index: usize, read_as: ReadAs) -> Result<Grid<f32>> {
        self.read_scalar_where(index, read_as, None)
    }

    /// As [`read_scalar`](Self::read_scalar), knowing which leaves of voxels are `wanted`.
    ///
    /// # Errors
    /// As [`read_scalar`](Self::read_scalar).
    pub fn read_scalar_where(
        &self,
        index: usize,
        read_as: ReadAs,
        wanted: Option<Wanted<'_>>,
    ) -> Result<Grid<f32>> {
        let info = self.info(index)?;
        let level_set = info.is_level_set();
        if level_set && read_as == ReadAs::Density {
            return Err(self.grid_error(
                info,
                "is a level set, the distance to a surface and no density; \
                 level_set = \"fog\" turns it into a fog volume",
            ));
        }
        let fog = level_set && read_as == ReadAs::LevelSetAsFog;
        self.read(index, fog, read_as != ReadAs::Raw, wanted)
    }

    /// Reads the grid of three-vectors number `index` of [`grids`](Self::grids), as it is.
    ///
    /// # Errors
    /// Where it holds no three-vectors, has a frustum transform, or the file is damaged.
    pub fn read_vector(&self, index: usize) -> Result<Grid<[f32; 3]>> {
        self.read(index, false, false, None)
    }

    fn read<V: Voxel>(
        &self,
        index: usize,
        fog: bool,
        density: bool,
        wanted: Option<Wanted<'_>>,
    ) -> Result<Grid<V>> {
        let info = self.info(index)?;
        if let Some(problem) = info.unreadable() {
            return Err(self.grid_error(info, problem));
        }
        let transform = info.affine().and_then(Transform::<Index>::new).ok_or_else(|| {
            self.grid_error(info, "its transform is singular; it must map voxels to a volume")
        })?;
        let voxels = self.voxels(index, fog)?;
        let mut source = Source::new(&voxels).map_err(|e| self.grid_error(info, e))?;
        drop(voxels);
        let statistics = Statistics::from_source(&source);
        if density {
            source.make_density();
        }
        let unwanted = wanted.map_or(0, |Wanted { is_wanted, leaves_out }| {
            let world = |cells: &Aabb<Index>| cells.corners().map(|p| transform.point_to_world(p));
            source.keep(&|cells| is_wanted(&world(cells)), leaves_out)
        });
        Ok(Grid::new(&source, transform, statistics, unwanted))
    }

    /// What OpenVDB's own `BoxSampler` gives at points of a grid's index space, as the yardstick of
    /// [`Grid::value`]: one number a point for scalars, three for vectors.
    ///
    /// # Errors
    /// Where the grid cannot be read.
    pub fn box_sample(&self, index: usize, points: &[DVec3]) -> Result<Vec<f64>> {
        let voxels = self.voxels(index, false)?;
        let points: Vec<f64> = points.iter().flat_map(DVec3::to_array).collect();
        let mut out = vec![0.0; points.len() / 3 * voxels.components()];
        let done = voxels.box_sample(&points, &mut out);
        done.map_err(|e| self.grid_error(&self.grids[index], e))?;
        Ok(out)
    }

    pub(super) fn voxels(&self, index: usize, fog: bool) -> Result<cxx::UniquePtr<bridge::Voxels>> {
        let info = self.info(index)?;
        let leaves = self.leaves(index)?;
        self.check_memory(info, leaves * if info.is_vector() { 3 * LEAF } else { LEAF })?;
        let place = self.checked.owner(index).map_err(|e| self.grid_error(info, e))?;
        self.file.read(&place, fog).map_err(|e| self.grid_error(info, reading(&e)))
    }

    /// Leaves of a grid whose bytes are sound.
    fn leaves(&self, index: usize) -> Result<u64> {
        self.checked.tree(index).map_err(|e| self.grid_error(&self.grids[index], e))
    }

    /// Refuses to read three scalar grids as one vector grid where that takes too much memory.
    pub(super) fn check_combined(&self, indices: &[usize; 3]) -> Result<()> {
        let mut leaves = 0;
        for &index in indices {
            leaves += self.leaves(index)?;
        }
        // At worst no two of them have a leaf in common.
        self.check_memory(self.info(indices[0])?, leaves * 3 * LEAF)
    }

    /// Refuses grid `info` where reading it takes `needed` bytes and those are too many.
    fn check_memory(&self, info: &GridInfo, needed: u64) -> Result<()> {
        let Some(memory) = self.memory.filter(|memory| needed > *memory) else { return Ok(()) };
        let [needed, memory] = [needed, memory].map(|bytes| ByteSize(bytes).to_string());
        Err(self.grid_error(
            info,
            format!(
                "takes about {needed} of memory to read, and {memory} may be taken; give a \
                 coarser or cropped grid, or more memory"
            ),
        ))
    }

    pub(super) fn info(&self, index: usize) -> Result<&GridInfo> {
        let count = self.grids.len();
        self.grids.get(index).ok_or_else(|| {
            Error::file(&self.path, format!("has no grid number {index}; it has {count} grids"))
        })
    }

    /// An error about one of the grids.
    pub(super) fn grid_error(&self, info: &GridInfo, problem: impl std::fmt::Display) -> Error {
        Error::grid(&self.path, info.label(), problem)
    }
}

/// What went wrong in the library, in the user's terms.
fn reading(e: &cxx::Exception) -> String {
    match e.what() {
        what if what.contains("iostream") => {
            "ends too early: it is truncated or damaged; copy or download it again".into()
        }
        what if what.contains("bad_alloc") || what.contains("length_error") => {
            "asks for more memory than there is: it is damaged, or too large".into()
        }
        what => format!("is damaged: OpenVDB says \"{what}\"; copy or download it again"),
    }
}
