//! The bridge to OpenVDB's and NanoVDB's own samplers.

#![allow(unsafe_code, missing_docs)] // what cxx generates

#[cxx::bridge(namespace = "fogbow")]
pub mod bridge {
    /// Points in index space at origin + direction (first + k step), k = 0 .. count.
    #[derive(Debug, Clone, Copy)]
    struct Run {
        origin: [f64; 3],
        direction: [f64; 3],
        first: f64,
        count: u32,
    }

    unsafe extern "C++" {
        include!("fogbow/tests/bench/cpp/peers.h");

        /// One grid, held by both libraries.
        type Peers;

        fn open_peers(path: &str, grid: &str) -> Result<UniquePtr<Peers>>;
        /// The sum of `BoxSampler` with a kept accessor.
        fn openvdb(self: &Peers, runs: &[Run], step: f64) -> f64;
        /// The sum of `SampleFromVoxels<ReadAccessor, 1>`, which keeps the last cell's corners.
        fn nanovdb_f64(self: &Peers, runs: &[Run], step: f64) -> f64;
        /// The same with places in single precision.
        fn nanovdb_f32(self: &Peers, runs: &[Run], step: f64) -> f64;
    }
}
