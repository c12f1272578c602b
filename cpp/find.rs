//! Where OpenVDB and what its headers need are, and what to say where they are not: build.rs uses it,
//! and tests/documents/build_message.rs tests it.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Component, Path, PathBuf};

/// The header of OpenVDB that brings all others the bridge includes.
const OPENVDB: &str = "openvdb/openvdb.h";
/// Headers the bridge includes with any version of OpenVDB, each with the Debian package that brings
/// it.
const HEADERS: [(&str, &str); 2] = [(OPENVDB, "libopenvdb-dev"), ("tbb/version.h", "libtbb-dev")];

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
    for header in boost_headers(prefixes) {
        need_header(prefixes, &header, "libboost-dev")?;
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

/// Headers of Boost that OpenVDB's headers include, as those of versions up to 11 do.
fn boost_headers(prefixes: &[PathBuf]) -> BTreeSet<String> {
    let folders = prefixes.iter().map(|prefix| prefix.join("include"));
    let Some(folder) = folders.into_iter().find(|folder| folder.join(OPENVDB).is_file()) else {
        return BTreeSet::new();
    };
    let mut found = BTreeSet::new();
    let mut seen = BTreeSet::new();
    let mut waiting = vec![PathBuf::from(OPENVDB)];
    while let Some(header) = waiting.pop() {
        let Ok(text) = fs::read_to_string(folder.join(&header)) else { continue };
        if !seen.insert(header.clone()) {
            continue;
        }
        for name in text.lines().filter_map(included) {
            if name.starts_with("boost/") {
                found.insert(name.into());
            } else {
                waiting.push(resolved(&header, name));
            }
        }
    }
    found
}

/// The header that a line of C++ includes.
fn included(line: &str) -> Option<&str> {
    let name = line.trim_start().strip_prefix('#')?.trim_start().strip_prefix("include")?;
    let name = name.trim_start();
    name.strip_prefix('<')
        .and_then(|name| name.split_once('>'))
        .or_else(|| name.strip_prefix('"')?.split_once('"'))
        .map(|(name, _)| name)
}

/// Where the header `name` is that `header` includes: OpenVDB names its own from `openvdb/` on, or from
/// the folder that they are in.
fn resolved(header: &Path, name: &str) -> PathBuf {
    if name.starts_with("openvdb/") {
        return name.into();
    }
    let mut path = header.parent().map_or_else(PathBuf::new, Path::to_path_buf);
    for part in Path::new(name).components() {
        match part {
            Component::ParentDir => drop(path.pop()),
            part => path.push(part),
        }
    }
    path
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
    let is_there = prefixes.iter().any(|prefix| prefix.join("include").join(OPENVDB).is_file());
    let boost = if is_there && boost_headers(prefixes).is_empty() { "" } else { " libboost-dev" };
    format!(
        "\nfogbow needs OpenVDB: {problem} (looked in {}).\n\
         On Debian or Ubuntu:  sudo apt-get install libopenvdb-dev{boost}\n\
         Elsewhere, name OpenVDB's prefix (with include/ and lib/) in OPENVDB_DIR.\n",
        if places.is_empty() { "no folder".into() } else { places.join(", ") }
    )
}
