//! Packages of shots (.usdz) that are larger than they may be.

use crate::usd::refusal;

/// Directories of archives as large ones have them: of more files than a package may have, of more than there is room
/// for, and so many of them that to look at all would take hours.
#[test]
fn directories_of_packages_are_bounded() {
    let folder = tempfile::tempdir().unwrap();
    let package = folder.path().join("many.usdz");
    let mut archive = openusd::usdz::ArchiveWriter::create(&package).unwrap();
    for index in 0..65_536 {
        archive.add_layer(&format!("{index}.usda"), b"").unwrap();
    }
    archive.finish().unwrap();
    let message = refusal(&package);
    assert!(message.contains("it has 65536 files"), "{message}");
    let bytes = std::fs::read(&package).unwrap();
    let end = bytes.windows(4).rposition(|four| four == b"PK\x06\x06").unwrap();
    for files in [100_000, 1 << 40, u64::MAX] {
        let mut told = bytes.clone();
        for at in [24, 32] {
            told[end + at..end + at + 8].copy_from_slice(&files.to_le_bytes());
        }
        std::fs::write(&package, told).unwrap();
        refusal(&package);
    }
    // A reference into it, and one to it.
    let path = folder.path().join("shot.usda");
    for target in ["many.usdz", "many.usdz[1.usda]"] {
        std::fs::write(&path, format!("#usda 1.0\ndef \"a\" (references = @./{target}@) {{}}\n"))
            .unwrap();
        refusal(&path);
    }
    let mut directory = [0; 22];
    directory[..4].copy_from_slice(b"PK\x05\x06");
    directory[10..12].copy_from_slice(&[1, 0]);
    std::fs::write(&package, [b"PK".to_vec(), directory.repeat(100_000)].concat()).unwrap();
    let message = refusal(&package);
    assert!(message.contains("it has 100000 directories"), "{message}");
}
