//! Whether a file is an OpenVDB file at all, and of a format that can be read.

use crate::vdb::ffi::bridge;

/// The first eight bytes of every OpenVDB file.
const MAGIC: [u8; 8] = [0x20, 0x42, 0x44, 0x56, 0, 0, 0, 0];
/// The oldest format whose structure is known here: that of 2013.
const OLDEST: u32 = 222;
/// The newest format whose structure is known here, which OpenVDB 13 writes: 224 with grids of the
/// type `half`.
const NEWEST: u32 = 225;

/// The format's version, from the first bytes of a file.
pub(super) fn version(head: &[u8]) -> Result<u32, String> {
    if !head.starts_with(&MAGIC) {
        return Err(foreign(head));
    }
    let Some(version) = head[MAGIC.len()..].first_chunk() else {
        return Err(
            "ends after its first bytes: it is incomplete; copy or download it again".into()
        );
    };
    let version = u32::from_le_bytes(*version);
    if version < OLDEST {
        return Err(format!(
            "has the file format {version}, from before 2013; {OLDEST} and newer are read: write it \
             anew with a newer OpenVDB"
        ));
    }
    Ok(version)
}

/// Whether nothing is known of a version but that its files may be built as those of earlier ones.
pub(super) fn is_unknown(version: u32) -> bool {
    version > NEWEST
}

/// The problem that a file of an unknown version is not built as known ones are, for which the walk
/// found a `problem`, in a grid or in the file itself.
pub(super) fn differs(version: u32, grid: Option<&str>, problem: &str) -> String {
    let what = grid.map_or("it".into(), |grid| format!("grid {grid:?}"));
    let (cause, _) = problem.split_once("; ").unwrap_or((problem, ""));
    format!(
        "has the file format {version}, and is not built as files of {OLDEST} to {NEWEST} are: {what} \
         {cause}; write it anew with OpenVDB 13 or older"
    )
}

/// What a user should know of a version that is read although the library that is linked does not
/// write it yet.
pub(super) fn note(version: u32) -> Option<String> {
    let newest = bridge::newest_file_version();
    if is_unknown(version) {
        Some(format!(
            "file format {version}, newer than any that is known ({NEWEST}); its structure is that of \
             {NEWEST} to the last byte, and it is read as such"
        ))
    } else if version > newest {
        let library = bridge::library_version();
        Some(format!(
            "file format {version}, newer than OpenVDB {library} writes ({newest}); its structure is \
             checked, and it is read as {newest}"
        ))
    } else {
        None
    }
}

/// What a file is that does not begin as OpenVDB files do.
fn foreign(head: &[u8]) -> String {
    let known: [(&[u8], &str); 6] = [
        (
            b"version https://",
            "is a git-lfs pointer, and not the file itself; fetch it with git lfs pull",
        ),
        // A digit follows: 0 in files and grids of versions before 32.6, then 1 in grids without a
        // file's header and 2 in files (NANOVDB_MAGIC_NUMB, _GRID and _FILE of nanovdb/NanoVDB.h).
        (
            b"NanoVDB",
            "is a NanoVDB file; convert it with \"nanovdb_convert in.nvdb out.vdb\", which comes with \
             OpenVDB (Debian's libnanovdb-tools)",
        ),
        (&[0x1f, 0x8b], "is compressed with gzip; unpack it first"),
        (b"PK\x03\x04", "is a ZIP archive; unpack it first"),
        (b"<!DOCTYPE", "is a web page, and not the file itself; download it again"),
        (b"<html", "is a web page, and not the file itself; download it again"),
    ];
    if head.is_empty() {
        return "is empty, and no OpenVDB file; copy or download it again".into();
    }
    let found = known.iter().find(|(start, _)| head.starts_with(start));
    if let Some((_, problem)) = found {
        return (*problem).into();
    }
    let hex = |bytes: &[u8]| bytes.iter().map(|b| format!("{b:02x}")).collect::<Vec<_>>().join(" ");
    format!(
        "starts with {}, and an OpenVDB file starts with {}; name an OpenVDB file",
        hex(&head[..head.len().min(4)]),
        hex(&MAGIC[..4])
    )
}
