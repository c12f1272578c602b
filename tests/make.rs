//! Procedural volumes: determinism, ranges, sparsity, errors, the way through a file.

use std::path::{Path, PathBuf};

use fogbow::Error;
use fogbow::make::{Kind, MAX_RESOLUTION, Settings, make};
use fogbow::math::Point;
use fogbow::vdb::{self, Grid, GridToWrite, ReadAs, VdbFile};

const KINDS: [Kind; 4] = [Kind::Smoke, Kind::Cloud, Kind::Fog, Kind::Fire];

fn settings(resolution: u32) -> Settings {
    Settings { seed: 3, resolution, voxel: None }
}

fn values(grid: &GridToWrite) -> impl Iterator<Item = f32> {
    grid.blocks.iter().flat_map(|b| b.values.iter().copied())
}

/// The grid of that name.
fn read(file: &VdbFile, name: &str) -> Grid<f32> {
    let index = file.grids().iter().position(|grid| grid.name == name).unwrap();
    file.read_scalar(index, ReadAs::Density).unwrap()
}

/// The voxel's value.
fn value(grid: &Grid<f32>, voxel: glam::IVec3) -> f64 {
    grid.value(Point::from_xyz(voxel.as_dvec3()))
}

/// The file's bytes, made on `threads` threads.
fn bytes(kind: Kind, settings: &Settings, threads: usize) -> Vec<u8> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("made.vdb");
    pool.install(|| vdb::write(&path, &make(kind, settings).unwrap())).unwrap();
    std::fs::read(path).unwrap()
}

#[test]
fn same_arguments_give_the_same_bytes_on_any_number_of_threads() {
    for kind in KINDS {
        let one = bytes(kind, &settings(40), 1);
        assert_eq!(one, bytes(kind, &settings(40), 2), "{kind:?}");
        assert_ne!(one, bytes(kind, &Settings { seed: 4, ..settings(40) }, 1), "{kind:?}");
    }
}

#[test]
fn values_are_finite_and_their_maximum_is_1() {
    for kind in KINDS {
        for grid in make(kind, &settings(48)).unwrap() {
            assert!(values(&grid).all(|v| (0.0..=1.0).contains(&v)), "{kind:?} {}", grid.name);
            assert_eq!(values(&grid).fold(0.0, f32::max), 1.0, "{kind:?} {}", grid.name);
        }
    }
}

#[test]
fn no_block_is_empty_and_most_of_the_box_is() {
    for (kind, most) in [
        (Kind::Smoke, 0.35),
        (Kind::Cloud, 0.5),
        (Kind::Fog, 0.95), // a layer that fills its flat box
        (Kind::Fire, 0.4),
    ] {
        let grids = make(kind, &settings(64)).unwrap();
        for grid in &grids {
            assert!(grid.blocks.iter().all(|b| b.values.iter().any(|&v| v > 0.0)));
            assert!(values(grid).all(|v| v == 0.0 || v >= 1e-4), "{kind:?} {}", grid.name);
        }
        let filled = values(&grids[0]).filter(|&v| v > 0.0).count() as f64;
        let voxels = kind.proportions().element_product() * 64.0f64.powi(3);
        assert!(filled < most * voxels, "{kind:?}: {} of the box", filled / voxels);
        assert!(filled > 0.02 * voxels, "{kind:?}: {} of the box", filled / voxels);
    }
}

#[test]
fn resolution_bounds_the_longest_side_and_nearly_fills_it() {
    for kind in KINDS {
        for resolution in [33, 64] {
            let grid = &make(kind, &settings(resolution)).unwrap()[0];
            let (mut min, mut max) = (glam::IVec3::MAX, glam::IVec3::MIN);
            for block in &grid.blocks {
                for (i, _) in block.values.iter().enumerate().filter(|(_, v)| **v > 0.0) {
                    let i = i as i32;
                    let voxel = block.origin + glam::IVec3::new(i >> 6, i >> 3 & 7, i & 7);
                    (min, max) = (min.min(voxel), max.max(voxel));
                }
            }
            let longest = (max - min).max_element() as u32 + 1;
            let bounds = resolution * 7 / 10..=resolution;
            assert!(bounds.contains(&longest), "{kind:?}: {longest} of {resolution}");
            assert!(min.y >= 0, "{kind:?} reaches below the ground");
        }
    }
}

#[test]
fn one_voxel_is_no_failure() {
    for kind in KINDS {
        for grid in make(kind, &settings(1)).unwrap() {
            assert!(values(&grid).all(f32::is_finite), "{kind:?}");
        }
    }
}

#[test]
fn a_file_holds_what_was_made() {
    let folder = tempfile::tempdir().unwrap();
    for kind in KINDS {
        let path = folder.path().join(format!("{kind:?}.vdb"));
        let grids = make(kind, &Settings { voxel: Some(0.25), ..settings(32) }).unwrap();
        vdb::write(&path, &grids).unwrap();
        let file = VdbFile::open(&path).unwrap();
        assert_eq!(grids.len(), if kind == Kind::Fire { 2 } else { 1 });
        for made in &grids {
            let read = read(&file, &made.name);
            for block in &made.blocks {
                for i in [0, 77, 292, 511] {
                    let place = glam::IVec3::new(i >> 6, i >> 3 & 7, i & 7) + block.origin;
                    let at = value(&read, place);
                    let want = f64::from(block.values[i as usize]);
                    // Half floats carry 11 bits, and steps of 2^-24 near 0.
                    assert!((at - want).abs() <= want / 2048.0 + 6e-8, "{at} for {want}");
                }
            }
        }
    }
}

#[test]
fn bad_settings_are_told() {
    let message = |settings| make(Kind::Smoke, &settings).unwrap_err();
    for (bad, words) in [
        (settings(0), "--resolution 0: give 1 to 4096 voxels"),
        (settings(MAX_RESOLUTION + 1), "--resolution 4097: give 1 to 4096 voxels"),
        (Settings { voxel: Some(0.0), ..settings(8) }, "--voxel 0: give a positive edge"),
        (Settings { voxel: Some(-1.0), ..settings(8) }, "--voxel -1: give a positive edge"),
        (Settings { voxel: Some(f64::NAN), ..settings(8) }, "--voxel NaN: give a positive edge"),
        (Settings { voxel: Some(f64::INFINITY), ..settings(8) }, "--voxel inf: give a positive"),
    ] {
        let error = message(bad);
        assert!(matches!(error, Error::Usage(_)));
        assert!(error.to_string().starts_with(words), "{error}");
    }
}

fn shipped(extension: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("volumes");
    let mut files: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == extension))
        .collect();
    files.sort();
    files
}

#[test]
fn shipped_volumes_are_small_and_as_their_commands_make_them() {
    let made = [
        ("cloud", Kind::Cloud, 128),
        ("fire", Kind::Fire, 128),
        ("fog", Kind::Fog, 96),
        ("smoke", Kind::Smoke, 128),
    ];
    let files = shipped("vdb");
    assert_eq!(files.len(), made.len());
    for (path, (stem, kind, resolution)) in files.iter().zip(made) {
        assert_eq!(path.file_stem().unwrap(), stem);
        assert!(path.metadata().unwrap().len() < 1_500_000, "{}", path.display());
        // Compared as values: the compression and the maths library may differ elsewhere.
        let grids = make(kind, &Settings { seed: 1, resolution, voxel: None }).unwrap();
        let file = VdbFile::open(path).unwrap();
        for grid in &grids {
            let read = read(&file, &grid.name);
            let block = &grid.blocks[grid.blocks.len() / 2];
            for i in (0..512).step_by(37) {
                let place = glam::IVec3::new(i >> 6, i >> 3 & 7, i & 7) + block.origin;
                let difference = (value(&read, place) - f64::from(block.values[i as usize])).abs();
                assert!(difference < 1e-3, "{}: {}", path.display(), grid.name);
            }
        }
    }
}

#[test]
fn shipped_scenes_are_toml() {
    let scenes = shipped("toml");
    assert!(!scenes.is_empty());
    for path in scenes {
        let text = std::fs::read_to_string(&path).unwrap();
        let scene: toml::Table = text.parse().unwrap();
        for table in ["camera", "film", "render", "medium", "light"] {
            assert!(scene.contains_key(table), "{}: no {table}", path.display());
        }
    }
}
