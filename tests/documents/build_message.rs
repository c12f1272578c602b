//! What build.rs says where OpenVDB or Boost is missing.

use std::fs;
use std::path::{Path, PathBuf};

use crate::find::{find, library, need_header, prefixes};

/// All files that are looked for, in a prefix.
const FILES: [&str; 5] = [
    "include/openvdb/openvdb.h",
    "include/openvdb/io/Archive.h",
    "include/boost/uuid/uuid.hpp",
    "include/tbb/version.h",
    "lib/x86_64-linux-gnu/libopenvdb.so",
];

/// What stands in them: OpenVDB's reach Boost over another of its own.
fn text(file: &str) -> &'static str {
    match file {
        "include/openvdb/openvdb.h" => "#include \"io/Archive.h\"\n#include <string>\n",
        "include/openvdb/io/Archive.h" => {
            "# include  <boost/uuid/uuid.hpp> // id\n#include <openvdb/openvdb.h>\n"
        }
        _ => "",
    }
}

fn put(prefix: &Path, files: &[&str]) {
    for name in files {
        let file = prefix.join(name);
        fs::create_dir_all(file.parent().unwrap()).unwrap();
        fs::write(file, text(name)).unwrap();
    }
}

/// What is said where `missing` is not there and everything else is.
fn message_without(missing: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let files: Vec<_> = FILES.into_iter().filter(|f| *f != missing).collect();
    put(folder.path(), &files);
    let message = find(&[folder.path().to_path_buf()], "x86_64").unwrap_err();
    assert!(message.contains(&folder.path().display().to_string()), "{message}");
    message
}

#[test]
fn each_missing_part_is_named_with_the_packages_to_install() {
    let parts = [
        (FILES[0], "openvdb/openvdb.h of libopenvdb-dev"),
        (FILES[2], "boost/uuid/uuid.hpp of libboost-dev"),
        (FILES[3], "tbb/version.h of libtbb-dev"),
        (FILES[4], "libopenvdb of libopenvdb-dev"),
    ];
    for (file, says) in parts {
        let message = message_without(file);
        assert!(message.contains(says), "{message}");
        assert!(message.contains("apt-get install libopenvdb-dev libboost-dev"), "{message}");
        assert!(message.contains("OPENVDB_DIR"), "{message}");
        assert_eq!(message.matches("fogbow needs OpenVDB").count(), 1, "{message}");
    }
}

#[test]
fn boost_is_asked_for_only_where_openvdbs_headers_include_it() {
    let folder = tempfile::tempdir().unwrap();
    let prefix = [folder.path().to_path_buf()];
    put(folder.path(), &[FILES[0], FILES[1], FILES[3], FILES[4]]);
    assert!(find(&prefix, "x86_64").unwrap_err().contains("boost/uuid/uuid.hpp of libboost-dev"));
    fs::write(folder.path().join(FILES[1]), "// #include <boost/any.hpp>\n").unwrap();
    assert_eq!(find(&prefix, "x86_64").unwrap(), folder.path().join("lib/x86_64-linux-gnu"));
    fs::remove_file(folder.path().join(FILES[4])).unwrap();
    let message = find(&prefix, "x86_64").unwrap_err();
    assert!(message.contains("install libopenvdb-dev\n"), "{message}");
}

#[test]
fn nothing_at_all_gives_one_message_as_well() {
    let message = find(&[], "x86_64").unwrap_err();
    assert!(message.contains("libopenvdb-dev") && message.contains("no folder"), "{message}");
}

#[test]
fn the_named_prefix_comes_before_the_usual_ones() {
    let (named, usual) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    put(named.path(), &FILES);
    put(usual.path(), &FILES);
    let usual = usual.path().to_str().unwrap();
    let both = prefixes(Some(named.path().to_path_buf()), &["/nowhere at all", usual]);
    assert_eq!(both, [named.path(), Path::new(usual)]);
    assert_eq!(find(&both, "x86_64").unwrap(), named.path().join("lib/x86_64-linux-gnu"));
}

#[test]
fn parts_may_lie_under_several_prefixes_and_in_any_library_folder() {
    let (one, two) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    put(one.path(), &FILES[..3]);
    put(two.path(), &[FILES[3], "lib64/libopenvdb.a"]);
    let both: Vec<PathBuf> = [&one, &two].map(|f| f.path().to_path_buf()).into();
    assert_eq!(find(&both, "riscv64").unwrap(), two.path().join("lib64"));
    assert_eq!(library(&both, "riscv64", "Imath"), None);
    assert!(need_header(&both, "nanovdb/NanoVDB.h", "libnanovdb-dev").is_err());
}
