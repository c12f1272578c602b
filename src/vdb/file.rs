//! Opening files and reading grids.

use std::path::{Path, PathBuf};

use bytesize::ByteSize;
use glam::{DAffine3, DVec3};

use crate::error::{Error, Result};
use crate::math::{Aabb, Index, Transform, WorldPoint};

use super::check::Checked;
use super::ffi::bridge;
use super::grid::Grid;
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

/// What a file says about a grid before its voxels are read.
#[derive(Debug, Clone, serde::Serialize)]
pub struct GridInfo {
    /// The name, which need not be unique and may be empty.
    pub name: String,
    /// Which of the grids of this name it is, from 0.
    pub occurrence: usize,
    /// Type of the values, such as `float`, `vec3s` or `ptdataidx32`.
    pub value_type: String,
    /// OpenVDB's class: `fog volume`, `level set`, `staggered` or `unknown`.
    pub class: String,
    /// Whether the values are stored in 16 bits.
    pub half: bool,
    /// OpenVDB's name of the map, such as `UniformScaleMap`.
    pub map: String,
    /// Compression in the file, such as `blosc + active mask`.
    pub compression: String,
    /// Active voxels, where the file tells.
    pub voxel_count: Option<u64>,
    /// The map as rows of a column-vector matrix; nothing where it is not linear.
    pub matrix: Option<[[f64; 4]; 3]>,
    #[serde(skip)]
    tree_type: String,
    #[serde(skip)]
    registered: bool,
    #[serde(skip)]
    unique: bool,
}

impl GridInfo {
    /// The name as a user gives it: with the occurrence where several grids share the name.
    pub fn label(&self) -> String {
        if self.unique { self.name.clone() } else { format!("{}[{}]", self.name, self.occurrence) }
    }

    /// Whether the values are single numbers that can be read.
    pub fn is_scalar(&self) -> bool {
        self.has_type(&["float", "double", "int32", "int64", "bool"])
    }

    /// Whether the values are three-vectors that can be read.
    pub fn is_vector(&self) -> bool {
        self.has_type(&["vec3s", "vec3d", "vec3i"])
    }

    /// Whether it is a level set.
    pub fn is_level_set(&self) -> bool {
        self.class == "level set"
    }

    fn has_type(&self, types: &[&str]) -> bool {
        self.registered && types.contains(&self.value_type.as_str())
    }

    /// Why its voxels cannot be read at all; nothing where they can.
    pub fn unreadable(&self) -> Option<String> {
        if !self.registered {
            return Some(format!(
                "has the type {}, which OpenVDB does not know; write it anew with another",
                self.tree_type
            ));
        }
        if self.value_type.starts_with("ptdataidx") {
            return Some("holds points; turn them into a fog volume first".into());
        }
        if !self.is_scalar() && !self.is_vector() {
            return Some(format!(
                "has the type {}; scalar grids (float, double, int32, int64, bool) and vec3 grids \
                 can be read",
                self.value_type
            ));
        }
        if self.matrix.is_none() {
            return Some(format!(
                "has a frustum transform ({}); resample it to a linear transform",
                self.map
            ));
        }
        None
    }

    fn affine(&self) -> Option<DAffine3> {
        let [x, y, z] = self.matrix?;
        let column = |i: usize| DVec3::new(x[i], y[i], z[i]);
        Some(DAffine3::from_cols(column(0), column(1), column(2), column(3)))
    }
}

/// An open OpenVDB file: the metadata of all its grids, and the voxels of those asked for.
pub struct VdbFile {
    path: PathBuf,
    file: cxx::UniquePtr<bridge::File>,
    checked: Checked,
    writer: String,
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
    /// headers, or of a format that the library does not know.
    pub fn open(path: &Path) -> Result<Self> {
        let checked = Checked::open(path)?;
        let Some(name) = path.to_str() else {
            return Err(Error::file(path, "the name is not UTF-8, which OpenVDB needs"));
        };
        let file = bridge::open_file(name).map_err(|e| Error::file(path, reading(&e)))?;
        let headers = file.headers().map_err(|e| Error::file(path, reading(&e)))?;
        let grids = describe(&headers);
        let writer = file.library_of_writer();
        Ok(Self { path: path.to_path_buf(), file, checked, writer, grids, memory: None })
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
        let statistics = Statistics::of(&source);
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
        let leaves = self.checked.tree(index).map_err(|e| self.grid_error(info, e))?;
        let needed = leaves * if info.is_vector() { 3 * LEAF } else { LEAF };
        if let Some(memory) = self.memory.filter(|memory| needed > *memory) {
            let [needed, memory] = [needed, memory].map(|bytes| ByteSize(bytes).to_string());
            return Err(self.grid_error(
                info,
                format!(
                    "takes about {needed} of memory to read, and {memory} may be taken; give a \
                     coarser or cropped grid, or more memory"
                ),
            ));
        }
        self.file.read(index, fog).map_err(|e| self.grid_error(info, reading(&e)))
    }

    fn info(&self, index: usize) -> Result<&GridInfo> {
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

fn describe(headers: &[bridge::GridHeader]) -> Vec<GridInfo> {
    let same =
        |some: &[bridge::GridHeader], name: &str| some.iter().filter(|h| h.name == name).count();
    headers
        .iter()
        .enumerate()
        .map(|(i, header)| GridInfo {
            name: header.name.clone(),
            occurrence: same(&headers[..i], &header.name),
            unique: same(headers, &header.name) == 1,
            value_type: value_type(&header.tree_type).to_string(),
            class: header.grid_class.clone(),
            half: header.half,
            map: header.map.clone(),
            compression: compression(header.compression),
            voxel_count: u64::try_from(header.voxel_count).ok(),
            matrix: header.linear.then(|| {
                // OpenVDB multiplies row vectors from the left, so its rows are our columns.
                std::array::from_fn(|r| std::array::from_fn(|c| header.affine[4 * c + r]))
            }),
            tree_type: header.tree_type.clone(),
            registered: header.registered,
        })
        .collect()
}

/// `Tree_float_5_4_3` holds `float`; other configurations keep their full name.
fn value_type(tree_type: &str) -> &str {
    let inner = tree_type.strip_prefix("Tree_").and_then(|t| t.strip_suffix("_5_4_3"));
    inner.unwrap_or(tree_type)
}

/// OpenVDB's compression flags in words.
fn compression(flags: u32) -> String {
    let names = [(1, "zip"), (2, "active mask"), (4, "blosc")];
    let set: Vec<_> = names.iter().filter(|(bit, _)| flags & bit != 0).map(|&(_, n)| n).collect();
    if set.is_empty() { "none".into() } else { set.join(" + ") }
}
