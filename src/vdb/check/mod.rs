//! Checks of a file before OpenVDB reads it.
//!
//! OpenVDB believes its files. It takes memory for any length that stands in one before it looks
//! whether the bytes are there, it reads uncompressed chunks of any length into buffers of a fixed
//! one, and it lets Blosc read as far as a chunk's own header says. So the whole structure is walked
//! here first (headers, metadata, trees, the sizes of all chunks), with every number held against the
//! bytes that are there. Chunks are skipped, not decompressed: the walk costs little beside the
//! reading. Behind it no size is left that OpenVDB, zlib or Blosc could follow out of a buffer, and
//! memory is bounded by the number of nodes that really stand in the file.
//!
//! There is no child process to read in: it would have to hand over or read again every voxel, and
//! behind these checks no file of tests/corpus or mutation has brought OpenVDB down. Before
//! them an uncompressed chunk with a wrong size corrupted the heap.

mod bytes;
mod format;
mod header;
mod metadata;
mod tree;
mod whole;

use std::fs::File;
use std::io::Read;
use std::path::Path;

use bytes::Bytes;
use header::{GridLayout, Layout};

use crate::error::{Error, Result};
use crate::file;

use super::ffi::bridge::GridPlace;

/// A file whose headers are sound; its trees are checked one by one.
#[derive(Debug)]
pub(super) struct Checked {
    file: File,
    version: u32,
    layout: Layout,
}

impl Checked {
    /// Offset of the file's own metadata.
    pub(super) const METADATA: u64 = header::METADATA;

    /// Checks what a file is, its headers and the metadata of all grids; in a file without offsets,
    /// where grids stand one behind the other, their trees as well, and in one of an unknown format
    /// everything to its last byte.
    ///
    /// # Errors
    /// Where it is no regular file, not of a format that is read, or a size or an offset in it cannot
    /// be.
    pub(super) fn open(path: &Path) -> Result<Self> {
        let of_file = |problem| Error::file(path, problem);
        let file = file::open(path)?;
        let mut head = Vec::new();
        let read = (&file).take(16).read_to_end(&mut head);
        read.map_err(|e| of_file(format!("cannot be read: {e}")))?;
        let version = format::version(&head).map_err(of_file)?;
        let mut bytes = Bytes::new(&file).map_err(of_file)?;
        let layout = header::read(&mut bytes).and_then(|layout| {
            if format::is_unknown(version) {
                whole::check(&mut bytes, &layout)?;
            }
            Ok(layout)
        });
        let layout = layout.map_err(|(grid, problem)| match grid {
            _ if format::is_unknown(version) => {
                of_file(format::differs(version, grid.as_deref(), &problem))
            }
            Some(grid) => Error::grid(path, grid, problem),
            None => of_file(problem),
        })?;
        Ok(Self { file, version, layout })
    }

    /// Version of the file format.
    pub(super) fn version(&self) -> u32 {
        self.version
    }

    /// What a user should know of the format.
    pub(super) fn note(&self) -> Option<String> {
        format::note(self.version)
    }

    /// Major and minor version of the library that wrote the file.
    pub(super) fn library(&self) -> [u32; 2] {
        self.layout.library
    }

    /// The grids, in the order of the file: name, whether floats are stored in 16 bits, and place.
    pub(super) fn grids(&self) -> impl Iterator<Item = (&str, bool, GridPlace)> {
        self.layout.grids.iter().map(|grid| (grid.name(), grid.half, place(grid)))
    }

    /// Where the grid is that has the tree of grid `index`.
    ///
    /// # Errors
    /// The problem, where it is missing.
    pub(super) fn owner(&self, index: usize) -> Result<GridPlace, String> {
        self.layout.owner(index).map(place)
    }

    /// Checks the tree of grid `index`; how many leaves it has, as far as they are its own.
    ///
    /// # Errors
    /// The problem, where a node, a chunk or a size in it cannot be.
    pub(super) fn tree(&self, index: usize) -> Result<u64, String> {
        let grid = self.layout.owner(index)?;
        let Some(values) = grid.values else { return Ok(0) };
        let mut bytes = Bytes::new(&self.file)?;
        bytes.seek(grid.tree)?;
        let leaves = tree::walk(&mut bytes, values)?;
        if bytes.at() > grid.end {
            return Err(bytes::damaged(
                grid.end,
                format_args!("its voxels, which go on to byte {} behind its end,", bytes.at()),
            ));
        }
        Ok(leaves)
    }
}

fn place(grid: &GridLayout) -> GridPlace {
    GridPlace { tree_type: grid.kind.clone(), start: grid.start }
}

#[cfg(test)]
mod tests {
    use std::time::Instant;

    use super::*;
    use crate::vdb::{ReadAs, VdbFile};

    #[test]
    #[ignore = "a measurement: cargo test --release --lib the_walk_costs -- --ignored --nocapture"]
    #[allow(clippy::print_stdout)]
    fn the_walk_costs_little_beside_the_reading() {
        let least = |run: &dyn Fn()| {
            let time = |_| {
                let start = Instant::now();
                run();
                start.elapsed().as_secs_f64()
            };
            (0..15).map(time).fold(f64::INFINITY, f64::min)
        };
        for name in ["smoke/smoke_v222.vdb", "smoke/smoke_v223_blosc.vdb", "cloud/singlecloud.vdb"]
        {
            let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/volumes");
            let path = Path::new(folder).join(name);
            let Ok(file) = VdbFile::open(&path) else { continue };
            let density = file.default_density().expect("a density");
            let walk = least(&|| {
                let checked = Checked::open(&path).expect("sound");
                checked.tree(density).expect("sound");
            });
            let load = least(&|| {
                let file = VdbFile::open(&path).expect("sound");
                drop(file.read_scalar(density, ReadAs::Density).expect("sound"));
            });
            println!("{name}: {:.1} ms of {:.1} ms", 1e3 * walk, 1e3 * load);
            assert!(walk < 0.1 * load, "{name}: {walk} s of {load} s");
        }
    }
}
