//! Whether a file is an OpenVDB file at all, and of a format that can be read.

use crate::vdb::ffi::bridge;

/// The first eight bytes of every OpenVDB file.
const MAGIC: [u8; 8] = [0x20, 0x42, 0x44, 0x56, 0, 0, 0, 0];
/// The oldest format whose structure is known here: that of 2013.
const OLDEST: u32 = 222;

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
    let newest = bridge::newest_file_version();
    let reads = format!("OpenVDB {} reads {OLDEST} to {newest}", bridge::library_version());
    if version > newest {
        return Err(format!(
            "has the file format {version}; {reads}: write it anew with an older OpenVDB"
        ));
    }
    if version < OLDEST {
        return Err(format!(
            "has the file format {version}, from before 2013; {reads}: write it anew with a newer one"
        ));
    }
    Ok(version)
}

/// What a file is that does not begin as OpenVDB files do.
fn foreign(head: &[u8]) -> String {
    let known: [(&[u8], &str); 6] = [
        (
            b"version https://",
            "is a git-lfs pointer, and not the file itself; fetch it with git lfs pull",
        ),
        (b"NanoVDB", "is a NanoVDB file; convert it to OpenVDB with nanovdb_convert"),
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
