//! Finds OpenVDB, builds the bridge to it, and makes the guide's pages for rustdoc.

#[path = "cpp/find.rs"]
mod find;
#[path = "src/guide/rustdoc.rs"]
mod guide;

use std::env;
use std::path::{Path, PathBuf};
use std::process::exit;

/// Where OpenVDB usually is.
const USUAL: [&str; 3] = ["/usr/local", "/usr", "/opt/homebrew"];

fn main() {
    for file in ["build.rs", "cpp", "src/guide", "src/vdb/ffi.rs"] {
        println!("cargo::rerun-if-changed={file}");
    }
    println!("cargo::rerun-if-env-changed=OPENVDB_DIR");

    let pages = PathBuf::from(env::var_os("OUT_DIR").expect("set by cargo")).join("guide");
    guide::write_pages(Path::new("src/guide"), &pages)
        .unwrap_or_else(|error| fail(&format!("src/guide: {error}")));

    let prefixes = find::prefixes(env::var_os("OPENVDB_DIR").map(PathBuf::from), &USUAL);
    let arch = env::var("CARGO_CFG_TARGET_ARCH").unwrap_or_default();
    let folder = find::find(&prefixes, &arch).unwrap_or_else(|message| fail(&message));
    let includes: Vec<PathBuf> = prefixes.iter().map(|p| p.join("include")).collect();

    let sources = ["cpp/allocator.cc", "cpp/vdb_read.cc", "cpp/vdb_voxels.cc", "cpp/vdb_write.cc"];
    compile("fogbow_vdb", "src/vdb/ffi.rs", &sources, 2, &includes);
    if env::var_os("CARGO_FEATURE_BENCH_PEERS").is_some() {
        compile_peers(&prefixes, &includes);
    }

    println!("cargo::rustc-link-search=native={}", folder.display());
    println!("cargo::rustc-link-lib=openvdb");
    println!("cargo::rustc-link-lib=tbb");
    if find::library(&prefixes, &arch, "Imath").is_some() {
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
    find::need_header(prefixes, header, "libnanovdb-dev").unwrap_or_else(|message| fail(&message));
    compile("fogbow_peers", "tests/bench/peers.rs", &["tests/bench/cpp/peers.cc"], 3, includes);
}

/// Ends the build with one message.
#[allow(clippy::print_stderr)] // where cargo looks for it
fn fail(message: &str) -> ! {
    eprintln!("{message}");
    exit(1);
}
