//! The bridge to OpenVDB: unsafe code that `cxx` generates.
//!
//! Every function that can throw in C++ returns a `Result`; nothing unwinds across. All numbers are
//! copied over once: a grid is read, turned into plain arrays and let go.

#![allow(unsafe_code, missing_docs, clippy::missing_safety_doc, clippy::needless_lifetimes)]

#[cxx::bridge(namespace = "fogbow")]
pub(super) mod bridge {
    /// Where a grid stands in its file.
    #[derive(Debug, Clone)]
    struct GridPlace {
        /// OpenVDB's type name, such as `Tree_float_5_4_3`.
        tree_type: String,
        /// Offset of its flags of compression, behind which metadata, transform and tree follow.
        start: u64,
    }

    /// An entry of metadata as OpenVDB prints it.
    #[derive(Debug, Clone)]
    struct MetadataText {
        name: String,
        value: String,
    }

    /// What a file says about one grid before its voxels are read.
    #[derive(Debug, Clone)]
    struct GridHeader {
        /// Whether the library knows the type; nothing else is told where it does not.
        registered: bool,
        /// OpenVDB's class name, such as `fog volume`.
        grid_class: String,
        /// OpenVDB's map name, such as `UniformScaleMap`.
        map: String,
        linear: bool,
        /// Row-vector matrix of OpenVDB, row by row; empty where the map is not linear.
        affine: Vec<f64>,
        /// OpenVDB's compression flags of the grid.
        compression: u32,
        /// From the metadata; -1 where it is not there.
        voxel_count: i64,
        metadata: Vec<MetadataText>,
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

        /// An open file.
        type File;
        /// One grid with its voxels.
        type Voxels;

        /// Has blocks of a megabyte and more mapped each for itself, where the C library can.
        fn map_large_blocks();

        fn library_version() -> String;
        fn newest_file_version() -> u32;

        /// Opens a file that the library `library` (major, minor) wrote in the file format `format`;
        /// one newer than the library's own is read as that.
        fn open_file(path: &str, library: [u32; 2], format: u32) -> Result<UniquePtr<File>>;
        /// The metadata at an offset, entries of more than 256 bytes and unknown types left out.
        fn metadata(self: &File, at: u64) -> Result<Vec<MetadataText>>;
        fn header(self: &File, place: &GridPlace) -> Result<GridHeader>;
        /// Reads the voxels of a grid that has a tree of its own; `fog` turns a level set into a fog
        /// volume.
        fn read(self: &File, place: &GridPlace, fog: bool) -> Result<UniquePtr<Voxels>>;

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

// SAFETY: a `File` is a stream of its own; neither another thread nor OpenVDB refers to it.
unsafe impl Send for bridge::File {}
