//! Files: what is read of them, what is refused and with which words, what is written.

use fogbow::vdb::{Block, GridToWrite, ReadAs, Tile, ValueType, VdbFile, write};
use glam::{DAffine3, DMat3, DQuat, DVec3, IVec3};

use crate::common::{shared, written};
use crate::corpus;

fn block(value: impl Fn(usize) -> f32) -> Block {
    Block { origin: IVec3::ZERO, values: (0..512).map(value).collect(), active: None }
}

fn fog(name: &str) -> GridToWrite {
    let mut grid = GridToWrite::fog(name, 0.25, DVec3::new(1.0, 2.0, 3.0));
    grid.blocks.push(block(|i| i as f32));
    grid
}

fn refusal(name: &str, bytes: &[u8]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    VdbFile::open(&path).unwrap_err().to_string()
}

#[test]
fn statistics_agree_with_the_reference() {
    let Some(list) = shared("reference.json") else { return };
    let list: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(&list).unwrap()).unwrap();
    for entry in list.as_array().unwrap() {
        let path = shared(entry["file"].as_str().unwrap()).unwrap();
        let file = VdbFile::open(&path).unwrap();
        assert_eq!(u64::from(file.version()), entry["format"].as_u64().unwrap());
        assert_eq!(file.library_version(), entry["library"].as_str().unwrap());
        let grids = entry["grids"].as_array().unwrap();
        assert_eq!(file.grids().len(), grids.len());
        for truth in grids {
            let name = truth["name"].as_str().unwrap();
            let index = file.find(name, None).unwrap();
            let info = &file.grids()[index];
            assert_eq!(info.class, truth["class"].as_str().unwrap());
            assert_eq!(info.map, truth["map"].as_str().unwrap());
            assert_eq!(u64::from(info.half), truth["half"].as_u64().unwrap());
            let statistics = if info.is_scalar() {
                *file.read_scalar(index, ReadAs::Raw).unwrap().statistics()
            } else {
                *file.read_vector(index).unwrap().statistics()
            };
            let same =
                |key: &str, ours: u64| assert_eq!(ours, truth[key].as_u64().unwrap(), "{key}");
            same("active", statistics.active);
            same("active_tiles", statistics.active_tiles);
            same("tile_voxels", statistics.tile_voxels);
            same("leaves", statistics.leaves);
            if statistics.active > 0 {
                same("zeros", statistics.zeros);
                same("neg", statistics.bad.negative);
                for (key, ours) in
                    [("min", statistics.min), ("max", statistics.max), ("mean", statistics.mean)]
                {
                    let theirs = truth[key].as_f64().unwrap();
                    let slack = 1e-6 * theirs.abs().max(1e-6);
                    assert!((ours - theirs).abs() <= slack, "{name} {key}: {ours} {theirs}");
                }
                let bounds = serde_json::to_value(statistics.bounds).unwrap();
                assert_eq!(bounds, truth["bbox"], "{name}");
            }
        }
    }
}

#[test]
fn foreign_and_damaged_files_are_refused() {
    assert!(refusal("a.vdb", b"hello").contains("starts with 68 65 6c 6c, and an OpenVDB file"));
    assert!(refusal("b.vdb", b"").contains("is empty"));
    assert!(refusal("c.vdb", b"version https://git-lfs.github.com/spec/v1\n").contains("git-lfs"));
    for magic in [b"NanoVDB0", b"NanoVDB1", b"NanoVDB2"] {
        let message = refusal("d.nvdb", &[&magic[..], b"........"].concat());
        let remedy = "nanovdb_convert in.nvdb out.vdb";
        assert!(message.contains(remedy) && message.contains("libnanovdb-tools"), "{message}");
    }
    let mut future = vec![0x20, 0x42, 0x44, 0x56, 0, 0, 0, 0];
    future.extend(999u32.to_le_bytes());
    assert!(refusal("e.vdb", &future).contains("file format 999"));
    let folder = tempfile::tempdir().unwrap();
    let message = VdbFile::open(folder.path()).unwrap_err().to_string();
    assert!(message.contains("is a folder"), "{message}");
    let message = VdbFile::open(&folder.path().join("none.vdb")).unwrap_err().to_string();
    assert!(message.contains("cannot be read: No such file"), "{message}");
}

/// A file of `bytes`, which lives as long as the folder.
fn opened(bytes: &[u8]) -> (tempfile::TempDir, VdbFile) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("made.vdb");
    std::fs::write(&path, bytes).unwrap();
    let file = VdbFile::open(&path).unwrap();
    (folder, file)
}

/// The non-zero voxels of a grid with their places.
fn voxels(file: &VdbFile, index: usize) -> Vec<(IVec3, f32)> {
    let mut voxels = Vec::new();
    let grid = file.read_scalar(index, ReadAs::Density).unwrap();
    grid.for_each_nonzero(|voxel| voxels.push((voxel.min, voxel.value)));
    voxels
}

#[test]
fn newer_formats_give_the_same_voxels_and_a_note() {
    let sound = corpus::tiny(|_| {});
    let (_folder, known) = opened(&corpus::format(&sound, 224));
    assert_eq!(known.notes(), [""; 0]);
    let truth = voxels(&known, 0);
    assert!(truth.len() > 500);
    let newest = VdbFile::reader_version();
    for (version, says) in
        [(225, "newer than OpenVDB"), (226, "newer than any"), (u32::MAX, "newer than any")]
    {
        let (_folder, file) = opened(&corpus::format(&sound, version));
        assert_eq!(file.version(), version);
        assert_eq!(voxels(&file, 0), truth, "{version}");
        if version > 225 || newest.starts_with("10.") {
            let [note] = &file.notes()[..] else { panic!("{:?}", file.notes()) };
            let head = format!("{}: file format {version}, ", file.path().display());
            assert!(note.starts_with(&head) && note.contains(says), "{note}");
        }
    }
}

#[test]
fn a_newer_format_that_is_built_otherwise_is_refused() {
    let sound = corpus::tiny(|_| {});
    let grown = [&sound[..], &[7; 20]].concat();
    let moved = {
        // The grid starts one byte later than its descriptor ends.
        let mut bytes = sound.clone();
        let kind = b"Tree_float_5_4_3";
        let offsets = bytes.windows(kind.len()).position(|w| w == kind).unwrap() + kind.len() + 4;
        for offset in bytes[offsets..offsets + 24].as_chunks_mut::<8>().0 {
            *offset = (i64::from_le_bytes(*offset) + 1).to_le_bytes();
        }
        bytes.insert(offsets + 24, 0);
        bytes
    };
    for (bytes, says) in [
        (&grown[..], "goes on for 20 bytes behind its last grid"),
        (&moved, "starts at byte"),
        (&sound[..sound.len() - 1], "should end at byte"),
    ] {
        let message = refusal("newer.vdb", &corpus::format(bytes, 226));
        assert!(message.contains("has the file format 226, and is not built as"), "{message}");
        assert!(message.contains(says), "{message}");
    }
    for bytes in [&grown[..], &moved] {
        let (_folder, file) = opened(&corpus::format(bytes, 225));
        assert!(voxels(&file, 0).len() > 500);
    }
}

#[test]
fn true_half_grids_are_read_or_refused_by_name() {
    for version in [225, 226] {
        let (_folder, file) = opened(&corpus::format(corpus::HALF_GRID, version));
        let [half, density] = ["half", "density"].map(|name| file.find(name, None).unwrap());
        let info = &file.grids()[half];
        assert_eq!((info.value_type.as_str(), info.half), ("half", false));
        let truth = voxels(&file, density);
        assert!(truth.len() > 600);
        if VdbFile::reader_version().starts_with("13.") {
            assert_eq!(voxels(&file, half), truth);
            continue;
        }
        let message = file.read_scalar(half, ReadAs::Density).unwrap_err().to_string();
        assert!(message.contains("is a grid of 16-bit floats (Tree_half_5_4_3)"), "{message}");
        assert!(message.contains("write it anew as a grid of floats"), "{message}");
    }
}

#[test]
fn blenders_newest_smoke_is_read() {
    let Some(path) = shared("blender52/smoke_0001.vdb") else { return };
    let file = VdbFile::open(&path).unwrap();
    assert_eq!((file.version(), file.library_version()), (225, "13.0"));
    let density = file.default_density().unwrap();
    let grid = file.read_scalar(density, ReadAs::Density).unwrap();
    assert_eq!(file.grids()[density].voxel_count, Some(grid.statistics().active));
    assert!(grid.max_value() > 0.0);
}

#[test]
fn metadata_comes_as_text() {
    let (_folder, file) = opened(&corpus::tiny(|_| {}));
    let of_grid = |name: &str| {
        let entry = file.grids()[0].metadata.iter().find(|(key, _)| key == name);
        entry.map(|(_, value)| value.as_str())
    };
    assert_eq!(of_grid("class"), Some("fog volume"));
    assert_eq!(of_grid("name"), Some("density"));
    assert!(of_grid("file_bbox_min").unwrap().starts_with("[-128, "));
    assert_eq!(of_grid("file_delayed_load"), None);
    assert_eq!(file.metadata(), []);
    let long = corpus::tiny(|grid| grid.name = "x".repeat(257));
    assert!(opened(&long).1.grids()[0].metadata.iter().all(|(key, _)| key != "name"));
    let written = opened(corpus::HALF_GRID).1;
    assert_eq!(written.metadata(), [("creator".into(), "OpenVDB 13.0.0".into())]);
}

#[test]
fn truncated_files_are_refused_at_every_length() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("whole.vdb");
    write(&path, &[fog("density"), fog("other")]).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    for length in (0..bytes.len()).step_by(37) {
        let message = refusal("cut.vdb", &bytes[..length]);
        let told = ["truncated", "is empty", "but the file has", "starts with"];
        assert!(told.iter().any(|t| message.contains(t)), "{length}: {message}");
    }
}

#[test]
fn grids_are_chosen_by_name_and_index() {
    let (_folder, file) = written(&[fog("a"), fog("density"), fog("density"), fog("")]);
    assert_eq!(file.default_density().unwrap(), 1);
    assert_eq!(file.find("density", Some(1)).unwrap(), 2);
    assert_eq!(file.grids()[2].label(), "density[1]");
    assert_eq!(file.find("", None).unwrap(), 3);
    let message = file.find("density", Some(2)).unwrap_err().to_string();
    assert!(
        message.contains("none with index 2") && message.contains("\"density[1]\""),
        "{message}"
    );
    let message = file.find("smoke", None).unwrap_err().to_string();
    assert!(message.contains("no grid called \"smoke\"") && message.contains("\"a\""), "{message}");
    let (_folder, file) = written(&[fog("a")]);
    assert_eq!(file.default_density().unwrap(), 0);
    let (_folder, file) = written(&[fog("a"), fog("b")]);
    assert!(file.default_density().unwrap_err().to_string().contains("several fog volumes"));
}

#[test]
fn level_sets_are_refused_or_converted() {
    let Some(path) = shared("levelset/sphere.vdb") else { return };
    let file = VdbFile::open(&path).unwrap();
    let message = file.read_scalar(0, ReadAs::Density).unwrap_err().to_string();
    assert!(message.contains("level_set = \"fog\""), "{message}");
    let fog = file.read_scalar(0, ReadAs::LevelSetAsFog).unwrap();
    assert_eq!((fog.min_value(), fog.max_value(), fog.background()), (0.0, 1.0, 0.0));
    assert!(fog.occupied_volume() > 500_000.0);
}

/// A ball of radius 6 voxels as a level set: distances within the narrow band of 3 voxels, active
/// where they are, in a file with offsets of its grids or without.
fn ball(offsets: bool) -> (tempfile::TempDir, VdbFile) {
    let mut grid =
        GridToWrite { class: "level set".into(), ..GridToWrite::fog("ball", 1.0, DVec3::ZERO) };
    grid.background = [3.0; 3];
    for corner in 0..8 {
        let origin = IVec3::new(corner / 4, corner / 2 % 2, corner % 2) * 8;
        let at = |i: i32| origin + IVec3::new(i / 64, i / 8 % 8, i % 8);
        let distance =
            |i: i32| (at(i).as_dvec3().distance(DVec3::splat(7.5)) - 6.0).clamp(-3.0, 3.0);
        let values: Vec<_> = (0..512).map(|i| distance(i) as f32).collect();
        let mut active = [0u64; 8];
        for (i, value) in values.iter().enumerate() {
            active[i / 64] |= u64::from(value.abs() < 3.0) << (i % 64);
        }
        grid.blocks.push(Block { origin, values, active: Some(active) });
    }
    let mut bytes = corpus::written(&[grid]);
    bytes[20] = u8::from(offsets); // the flag behind magic number and versions
    opened(&bytes)
}

#[test]
fn a_level_set_becomes_the_same_fog_however_often_it_is_read() {
    for offsets in [true, false] {
        let (_folder, file) = ball(offsets);
        let read = |read_as| {
            let grid = file.read_scalar(0, read_as).unwrap();
            serde_json::to_value(grid.statistics()).unwrap()
        };
        let (distances, fog) = (read(ReadAs::Raw), read(ReadAs::LevelSetAsFog));
        assert_eq!(fog["max"], 1.0, "full inside of the band, offsets: {offsets}");
        for _ in 0..2 {
            assert_eq!(read(ReadAs::LevelSetAsFog), fog, "offsets: {offsets}");
        }
        assert_eq!(read(ReadAs::Raw), distances, "offsets: {offsets}");
    }
}

#[test]
fn every_type_comes_back() {
    let types = [ValueType::Float, ValueType::Double, ValueType::Int32, ValueType::Int64];
    let grids: Vec<_> = types.iter().map(|&t| GridToWrite { value_type: t, ..fog("g") }).collect();
    let (_folder, file) = written(&grids);
    for i in 0..types.len() {
        let grid = file.read_scalar(i, ReadAs::Density).unwrap();
        let mut count = 0;
        grid.for_each_nonzero(|voxel| {
            let at = voxel.min;
            assert_eq!(voxel.value, (at.x * 64 + at.y * 8 + at.z) as f32);
            count += 1;
        });
        assert_eq!(count, 511);
    }
    let flags = GridToWrite { value_type: ValueType::Bool, half: false, ..fog("b") };
    let (_folder, file) = written(&[flags]);
    assert_eq!(file.read_scalar(0, ReadAs::Density).unwrap().max_value(), 1.0);
    let mut colour = GridToWrite { value_type: ValueType::Vec3, ..fog("c") };
    colour.blocks[0].values = (0..1536).map(|i| (i % 3) as f32).collect();
    let (_folder, file) = written(&[colour]);
    let grid = file.read_vector(0).unwrap();
    assert_eq!(grid.value(fogbow::math::IndexPoint::new(3.5, 3.0, 2.2)), [0.0, 1.0, 2.0]);
    let message = file.read_scalar(0, ReadAs::Density).unwrap_err().to_string();
    assert!(message.contains("holds three-vectors, but scalars are wanted"), "{message}");
}

#[test]
fn half_precision_and_transforms_come_back() {
    let mut grid = fog("density");
    grid.half = true;
    let turn = DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -0.7, 1.1);
    let mirrored = DMat3::from_quat(turn) * DMat3::from_diagonal(DVec3::new(-0.1, 0.2, 0.5));
    grid.transform = DAffine3 { matrix3: mirrored, translation: DVec3::new(5.0, -6.0, 7.0) };
    let expected = grid.transform;
    let (_folder, file) = written(&[grid]);
    assert!(file.grids()[0].half);
    let grid = file.read_scalar(0, ReadAs::Density).unwrap();
    assert!(grid.transform().affine().abs_diff_eq(expected, 1e-12));
    assert_eq!(grid.max_value(), 511.0);
}

/// The file with the type of its only grid told to be another: the name gets longer, so the three
/// offsets behind it grow.
fn retyped(path: &std::path::Path, name: &str) {
    let old = b"Tree_float_5_4_3";
    let mut bytes = std::fs::read(path).unwrap();
    let at = bytes.windows(old.len()).position(|w| w == old).unwrap();
    let after = at + old.len();
    let parent = u32::from_le_bytes(bytes[after..after + 4].try_into().unwrap()) as usize;
    let grown = (name.len() - old.len()) as i64;
    for i in 0..3 {
        let place = after + 4 + parent + 8 * i;
        let offset = i64::from_le_bytes(bytes[place..place + 8].try_into().unwrap());
        bytes[place..place + 8].copy_from_slice(&(offset + grown).to_le_bytes());
    }
    bytes[at - 4..at].copy_from_slice(&(name.len() as u32).to_le_bytes());
    bytes.splice(at..after, name.bytes());
    std::fs::write(path, bytes).unwrap();
}

#[test]
fn types_without_numbers_are_refused_by_name() {
    for (tree, words) in [
        ("Tree_ptdataidx32_5_4_3", "holds points; turn them into a fog volume"),
        ("Tree_unheard_of_5_4_3", "has the type Tree_unheard_of_5_4_3, which OpenVDB does not"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("points.vdb");
        write(&path, &[fog("density")]).unwrap();
        retyped(&path, tree);
        let file = VdbFile::open(&path).unwrap();
        let message = file.read_scalar(0, ReadAs::Density).unwrap_err().to_string();
        assert!(message.contains(words), "{message}");
    }
}

#[test]
fn bad_values_are_counted_and_taken_as_nothing() {
    let mut grid = fog("density");
    grid.blocks[0].values[1] = f32::NAN;
    grid.blocks[0].values[2] = f32::INFINITY;
    grid.blocks[0].values[3] = -2.0;
    let value = [-1.0, 0.0, 0.0];
    grid.tiles.push(Tile { origin: IVec3::new(8, 0, 0), edge: 8, value, active: true });
    let (_folder, file) = written(&[grid]);
    let grid = file.read_scalar(0, ReadAs::Density).unwrap();
    let bad = grid.bad_values();
    assert_eq!((bad.nan, bad.infinite, bad.negative), (1, 1, 513));
    assert_eq!((grid.min_value(), grid.max_value()), (0.0, 511.0));
}

#[test]
fn the_same_grids_give_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = ["a.vdb", "b.vdb"].map(|name| {
        write(&folder.path().join(name), &[fog("density"), fog("x")]).unwrap();
        std::fs::read(folder.path().join(name)).unwrap()
    });
    assert!(bytes[0] == bytes[1]);
    let unwritable = folder.path().join("none/there.vdb");
    assert!(write(&unwritable, &[fog("density")]).is_err());
}
