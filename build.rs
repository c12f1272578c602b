//! Finds OpenVDB and builds the bridge to it.

use std::env;
use std::path::{Path, PathBuf};
use std::process::exit;

/// Headers the bridge includes, each with the Debian package that brings it.
const HEADERS: [(&str, &str); 3] = [
    ("openvdb/openvdb.h", "libopenvdb-dev"),
    ("boost/uuid/uuid.hpp", "libboost-dev"),
    ("tbb/version.h", "libtbb-dev"),
];

fn main() {
    for file in ["build.rs", "cpp", "src/vdb/ffi.rs"] {
        println!("cargo::rerun-if-changed={file}");
    }
    println!("cargo::rerun-if-env-changed=OPENVDB_DIR");

    let prefixes = prefixes();
    let includes: Vec<PathBuf> = prefixes.iter().map(|p| p.join("include")).collect();
    for (header, package) in HEADERS {
        if !includes.iter().any(|folder| folder.join(header).is_file()) {
            fail(&format!("the header {header} of {package} is missing"), &prefixes);
        }
    }
    let Some(folder) = library_folders_of(&prefixes).find(|f| has_library(f, "openvdb")) else {
        fail("the library libopenvdb of libopenvdb-dev is missing", &prefixes);
    };

    let sources = ["cpp/vdb_read.cc", "cpp/vdb_voxels.cc", "cpp/vdb_write.cc"];
    compile("fogbow_vdb", "src/vdb/ffi.rs", &sources, 2, &includes);
    if env::var_os("CARGO_FEATURE_BENCH_PEERS").is_some() {
        compile_peers(&prefixes, &includes);
    }

    println!("cargo::rustc-link-search=native={}", folder.display());
    println!("cargo::rustc-link-lib=openvdb");
    println!("cargo::rustc-link-lib=tbb");
    if library_folders_of(&prefixes).any(|f| has_library(&f, "Imath")) {
        println!("cargo::rustc-link-lib=Imath"); // half floats, where OpenVDB was built with it
    }
}

/// Compiles a bridge and the C++ behind it. The optimisation is not left to the profile, since
/// OpenVDB's templates crawl without any.
fn compile(name: &str, bridge: &str, sources: &[&str], optimisation: u32, includes: &[PathBuf]) {
    let mut build = cxx_build::bridge(bridge);
    build.files(sources).std("c++17").opt_level(optimisation);
    build.debug(false); // OpenVDB's templates make huge debug symbols
    for folder in includes.iter().filter(|f| f.as_path() != Path::new("/usr/include")) {
        build.flag(format!("-isystem{}", folder.display())); // system: their warnings are theirs
    }
    build.compile(name);
}

/// Builds what the sampler benchmark compares with, optimised as a user would.
fn compile_peers(prefixes: &[PathBuf], includes: &[PathBuf]) {
    for file in ["tests/bench/cpp", "tests/bench/peers.rs"] {
        println!("cargo::rerun-if-changed={file}");
    }
    let header = "nanovdb/util/OpenToNanoVDB.h";
    if !includes.iter().any(|folder| folder.join(header).is_file()) {
        fail(&format!("the header {header} of libnanovdb-dev is missing"), prefixes);
    }
    compile("fogbow_peers", "tests/bench/peers.rs", &["tests/bench/cpp/peers.cc"], 3, includes);
}

/// Where to look: `OPENVDB_DIR` first, then the usual places.
fn prefixes() -> Vec<PathBuf> {
    let named = env::var_os("OPENVDB_DIR").map(PathBuf::from);
    let usual = ["/usr/local", "/usr", "/opt/homebrew"].map(PathBuf::from);
    named.into_iter().chain(usual).filter(|p| p.is_dir()).collect()
}

fn library_folders_of(prefixes: &[PathBuf]) -> impl Iterator<Item = PathBuf> {
    prefixes.iter().flat_map(|p| library_folders(p))
}

/// The library folders of a prefix, Debian's multiarch one among them.
fn library_folders(prefix: &Path) -> Vec<PathBuf> {
    let arch = env::var("CARGO_CFG_TARGET_ARCH").unwrap_or_default();
    [format!("lib/{arch}-linux-gnu"), "lib".to_string(), "lib64".to_string()]
        .iter()
        .map(|folder| prefix.join(folder))
        .collect()
}

fn has_library(folder: &Path, name: &str) -> bool {
    ["so", "dylib", "a"].iter().any(|end| folder.join(format!("lib{name}.{end}")).is_file())
}

/// Ends the build with one message.
#[allow(clippy::print_stderr)] // where cargo looks for it
fn fail(problem: &str, prefixes: &[PathBuf]) -> ! {
    let places: Vec<_> = prefixes.iter().map(|p| p.display().to_string()).collect();
    eprintln!(
        "\nfogbow needs OpenVDB: {problem} (looked in {}).\n\
         On Debian or Ubuntu:  sudo apt-get install libopenvdb-dev libboost-dev\n\
         Elsewhere, name OpenVDB's prefix (with include/ and lib/) in OPENVDB_DIR.\n",
        places.join(", ")
    );
    exit(1);
}
