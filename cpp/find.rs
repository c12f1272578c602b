//! Where OpenVDB and Boost are, and what to say where they are not: build.rs uses it, and
//! tests/build_message.rs tests it.

use std::path::{Path, PathBuf};

/// Headers the bridge includes, each with the Debian package that brings it.
const HEADERS: [(&str, &str); 3] = [
    ("openvdb/openvdb.h", "libopenvdb-dev"),
    ("boost/uuid/uuid.hpp", "libboost-dev"),
    ("tbb/version.h", "libtbb-dev"),
];

/// Where to look: `named` first, then `usual`; folders that are not there are left out.
pub(crate) fn prefixes(named: Option<PathBuf>, usual: &[&str]) -> Vec<PathBuf> {
    let usual = usual.iter().map(PathBuf::from);
    named.into_iter().chain(usual).filter(|p| p.is_dir()).collect()
}

/// The folder of OpenVDB's library under one of `prefixes`, for the architecture `arch`, once all
/// headers are found; otherwise the one message to end with.
pub(crate) fn find(prefixes: &[PathBuf], arch: &str) -> Result<PathBuf, String> {
    for (header, package) in HEADERS {
        need_header(prefixes, header, package)?;
    }
    library(prefixes, arch, "openvdb")
        .ok_or_else(|| message("the library libopenvdb of libopenvdb-dev is missing", prefixes))
}

/// That `header` is under one of `prefixes`; otherwise the message.
pub(crate) fn need_header(prefixes: &[PathBuf], header: &str, package: &str) -> Result<(), String> {
    if prefixes.iter().any(|prefix| prefix.join("include").join(header).is_file()) {
        return Ok(());
    }
    Err(message(&format!("the header {header} of {package} is missing"), prefixes))
}

/// The folder with the library `name`.
pub(crate) fn library(prefixes: &[PathBuf], arch: &str, name: &str) -> Option<PathBuf> {
    let is_there = |folder: &Path| {
        ["so", "dylib", "a"].iter().any(|end| folder.join(format!("lib{name}.{end}")).is_file())
    };
    prefixes
        .iter()
        .flat_map(|prefix| {
            // Debian's multiarch folder first.
            let folders = [format!("lib/{arch}-linux-gnu"), "lib".into(), "lib64".into()];
            folders.map(|folder| prefix.join(folder))
        })
        .find(|folder| is_there(folder))
}

fn message(problem: &str, prefixes: &[PathBuf]) -> String {
    let places: Vec<_> = prefixes.iter().map(|p| p.display().to_string()).collect();
    format!(
        "\nfogbow needs OpenVDB: {problem} (looked in {}).\n\
         On Debian or Ubuntu:  sudo apt-get install libopenvdb-dev libboost-dev\n\
         Elsewhere, name OpenVDB's prefix (with include/ and lib/) in OPENVDB_DIR.\n",
        if places.is_empty() { "no folder".into() } else { places.join(", ") }
    )
}
