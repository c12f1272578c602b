//! The bridge to OpenVDB, and the only place with unsafe code: what `cxx` generates.
//!
//! Every function that can throw in C++ returns a `Result`; nothing unwinds across. All numbers are
//! copied over once: a grid is read, turned into plain arrays and let go.

#![allow(unsafe_code, missing_docs, clippy::missing_safety_doc, clippy::needless_lifetimes)]

#[cxx::bridge(namespace = "fogbow")]
pub(super) mod bridge {
    /// What a file says about one grid before its voxels are read.
    #[derive(Debug, Clone)]
    struct GridHeader {
        name: String,
        /// OpenVDB's type name, such as `Tree_float_5_4_3`.
        tree_type: String,
        /// Whether the library knows the type.
        registered: bool,
        /// OpenVDB's class name, such as `fog volume`.
        grid_class: String,
        half: bool,
        /// OpenVDB's map name, such as `UniformScaleMap`.
        map: String,
        linear: bool,
        /// Row-vector matrix of OpenVDB, row by row; empty where the map is not linear.
        affine: Vec<f64>,
        /// OpenVDB's compression flags of the grid.
        compression: u32,
        /// From the metadata; -1 where it is not there.
        voxel_count: i64,
    }

    /// A constant block of voxels.
    #[derive(Debug, Clone, Copy)]
    struct Tile {
        /// Smallest voxel.
        origin: [i32; 3],
        /// Edge length is 2 to this power: 3, 7 or 12.
        log2_size: u32,
        /// The value; a scalar in the first place.
        value: [f32; 3],
        active: bool,
    }

    /// A grid to be written.
    #[derive(Debug, Clone, Default)]
    struct WriteGrid {
        name: String,
        /// `float`, `double`, `int32`, `int64`, `bool` or `vec3s`.
        value_type: String,
        /// OpenVDB's class name, such as `fog volume`.
        grid_class: String,
        half: bool,
        /// Whether to write a frustum map instead of `affine`, which only tests want.
        frustum: bool,
        /// Row-vector matrix of OpenVDB, row by row.
        affine: [f64; 16],
        background: [f32; 3],
        /// Three numbers a leaf.
        origins: Vec<i32>,
        /// 512 values a leaf (three numbers each for vectors), z fastest.
        values: Vec<f32>,
        /// Eight words a leaf.
        masks: Vec<u64>,
        tiles: Vec<Tile>,
    }

    unsafe extern "C++" {
        include!("fogbow/cpp/vdb.h");

        /// An open file: its header, and its grids' metadata.
        type File;
        /// One grid with its voxels.
        type Voxels;

        /// Has blocks of a megabyte and more mapped each for itself, where the C library can.
        fn map_large_blocks();

        fn library_version() -> String;
        fn newest_file_version() -> u32;

        fn open_file(path: &str) -> Result<UniquePtr<File>>;
        fn library_of_writer(self: &File) -> String;
        fn headers(self: &File) -> Result<Vec<GridHeader>>;
        /// Reads the voxels of grid `index`; `fog` turns a level set into a fog volume.
        fn read(self: &File, index: usize, fog: bool) -> Result<UniquePtr<Voxels>>;

        /// Numbers a value: 1 or 3.
        fn components(self: &Voxels) -> usize;
        fn background(self: &Voxels) -> [f32; 3];
        fn active_voxels(self: &Voxels) -> u64;
        /// Three numbers a leaf.
        fn origins(self: &Voxels) -> &[i32];
        /// 512 values a leaf, z fastest.
        fn values(self: &Voxels) -> &[f32];
        /// Active voxels, eight words a leaf.
        fn masks(self: &Voxels) -> &[u64];
        /// Tiles that are active or differ from the background.
        fn tiles(self: &Voxels) -> Vec<Tile>;
        /// OpenVDB's own `BoxSampler` at index-space points, three numbers each.
        fn box_sample(self: &Voxels, points: &[f64], out: &mut [f64]) -> Result<()>;

        fn write_file(path: &str, grids: &[WriteGrid]) -> Result<()>;
    }
}
