//! Files that are no VDB, sound files without a density, and trees that cannot be.

use fogbow::vdb::{Block, GridToWrite, ValueType};
use glam::{DVec3, IVec3};

use super::craft::{retyped, text_at, tree_at};
use super::{Case, HALF_GRID, format, tiny, with, written};

pub(super) fn cases() -> Vec<Case> {
    let case = |(name, bytes): (&str, Vec<u8>)| Case { name: name.into(), bytes };
    foreign().into_iter().chain(contents()).chain(lies()).map(case).collect()
}

fn foreign() -> Vec<(&'static str, Vec<u8>)> {
    let sound = tiny(|_| {});
    let lfs = "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 370262\n";
    vec![
        ("sound", sound.clone()),
        ("empty", Vec::new()),
        ("git-lfs pointer", lfs.into()),
        ("page of an error", b"<!DOCTYPE html><html>404</html>".to_vec()),
        ("gzip", vec![0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 0, 3]),
        ("zip", b"PK\x03\x04\x14\0\0\0\0\0".to_vec()),
        ("nanovdb", b"NanoVDB0\x20\0\0\0\x06\0\0\0\x01\0\0\0".to_vec()),
        ("nanovdb 2", b"NanoVDB2\x20\0\0\0\x06\0\0\0\x01\0\0\0".to_vec()),
        ("magic only", sound[..8].to_vec()),
        ("nanovdb grid", b"NanoVDB1\x20\0\0\0\x06\0\0\0\x01\0\0\0".to_vec()),
        ("newest known", format(&sound, 225)),
        ("newer", format(&sound, 226)),
        ("newer with more behind it", format(&[&sound[..], &[7; 999]].concat(), 226)),
        ("newer, cut", format(&sound[..sound.len() - 1], 226)),
        ("far newer", format(&sound, u32::MAX)),
        ("older", with(&sound, 8, &221u32.to_le_bytes())),
        ("oldest", with(&sound, 8, &1u32.to_le_bytes())),
        ("ancient header", with(&sound, 8, &[218, 0, 0, 0])),
        ("without offsets", with(&sound, 20, &[0])),
        ("more behind it", [&sound[..], &[7; 999]].concat()),
        ("twice", [&sound[..], &sound[..]].concat()),
    ]
}

fn contents() -> Vec<(&'static str, Vec<u8>)> {
    let block = |value: f32| Block { origin: IVec3::ZERO, values: vec![value; 512], active: None };
    let fog = |name: &str, value: f32| {
        let mut grid = GridToWrite::fog(name, 0.5, DVec3::ZERO);
        grid.blocks.push(block(value));
        grid
    };
    let mut inactive = fog("density", 1.0);
    inactive.blocks[0].active = Some([0; 8]);
    let mut zero = fog("density", 0.0);
    zero.blocks[0].active = Some([u64::MAX; 8]);
    let mut level_set = fog("surface", 1.0);
    level_set.class = "level set".into();
    let mut far = fog("density", 1.0);
    far.blocks[0].origin = IVec3::splat(2_147_483_640);
    // The most memory a byte of a file can ask for: leaves of nothing.
    let mut hollow = fog("density", 1.0);
    hollow.blocks.extend((0..8000).map(|i| Block {
        origin: IVec3::new(i / 400, i / 20 % 20, i % 20 + 1) * 8,
        values: vec![0.0; 512],
        active: Some([0; 8]),
    }));
    let many: Vec<_> = (0..300).map(|i| fog(&format!("grid {i}"), 1.0)).collect();
    vec![
        ("no grids", written(&[])),
        ("no voxels", written(&[GridToWrite::fog("density", 0.5, DVec3::ZERO)])),
        ("no active voxels", written(&[inactive])),
        ("all zero", written(&[zero])),
        ("NaN", written(&[fog("density", f32::NAN)])),
        ("infinite", written(&[fog("density", f32::INFINITY)])),
        ("negative", written(&[fog("density", -1.0)])),
        ("largest", written(&[fog("density", f32::MAX)])),
        ("smallest", written(&[fog("density", 1e-45)])),
        ("NaN around", tiny(|g| g.background = [f32::NAN; 3])),
        ("infinite around", tiny(|g| g.background = [f32::INFINITY; 3])),
        ("vectors only", tiny(|g| g.value_type = ValueType::Vec3)),
        ("level set only", written(&[level_set])),
        ("same name twice", written(&[fog("density", 1.0), fog("density", 2.0)])),
        ("no name", written(&[fog("", 1.0)])),
        ("two fogs", written(&[fog("soot", 1.0), fog("dust", 1.0)])),
        ("three hundred grids", written(&many)),
        ("hollow", written(&[hollow])),
        ("far away", written(&[far])),
    ]
}

fn lies() -> Vec<(&'static str, Vec<u8>)> {
    let sound = tiny(|_| {});
    let (name, class) = (text_at(&sound, "density"), text_at(&sound, "class"));
    let halves = tiny(|g| g.half = true);
    let half = text_at(&halves, "is_saved_as_half_float") + 4 + 22 + 4 + 4; // its size
    let delayed = text_at(&sound, "__delayedload");
    let map = text_at(&sound, "UniformScaleTranslateMap");
    let tree = tree_at(&sound);
    let scaled = |scale: f64| with(&sound, map + 52, &[scale.to_le_bytes(); 3].concat());
    let huge = u32::MAX.to_le_bytes();
    let child = tree + 16; // its buffers, background, tiles and children come before
    let float = "Tree_float_5_4_3";
    vec![
        ("name as long as memory", with(&sound, name, &huge)),
        ("metadata without end", with(&sound, class - 4, &huge)),
        ("metadata name without end", with(&sound, class, &huge)),
        ("metadata value without end", with(&sound, class + 19, &huge)),
        ("half float of another size", with(&halves, half, &8u32.to_le_bytes())),
        ("half float of 7", with(&halves, half + 4, &[7])),
        ("floats as halves", with(&halves, half + 4, &[0])),
        ("delayed load of 4 billion leaves", with(&sound, delayed + 21, &huge)),
        ("delayed load mask without end", with(&sound, delayed + 25, &huge)),
        ("transform name without end", with(&sound, map, &huge)),
        ("unknown transform", with(&sound, map + 4, b"Z")),
        ("NaN transform", with(&sound, map + 28, &[0xff; 144])),
        ("flat voxels", scaled(0.0)),
        ("NaN voxels", scaled(f64::NAN)),
        ("infinite voxels", scaled(f64::INFINITY)),
        ("tiny voxels", scaled(1e-300)),
        ("huge voxels", scaled(1e300)),
        ("large voxels", scaled(1e12)),
        ("two buffers", with(&sound, tree, &2i32.to_le_bytes())),
        ("4 billion tiles", with(&sound, tree + 8, &huge)),
        ("4 billion children", with(&sound, tree + 12, &huge)),
        ("no children", with(&sound, tree + 12, &[0; 4])),
        ("child off the lattice", with(&sound, child, &7i32.to_le_bytes())),
        ("child at the edge", with(&sound, child, &(i32::MAX - 4095).to_le_bytes())),
        ("all children", with(&sound, child + 12, &[0xff; 4096])),
        ("all values active", with(&sound, child + 12 + 4096, &[0xff; 4096])),
        ("points", retyped(&sound, float, "Tree_ptdataidx32_5_4_3")),
        ("point indices", retyped(&sound, float, "Tree_ptidx32_5_4_3")),
        ("mask", retyped(&sound, float, "Tree_mask_5_4_3")),
        ("text", retyped(&sound, float, "Tree_string_5_4_3")),
        ("half grid", HALF_GRID.into()),
        ("half grid, newer", format(HALF_GRID, 226)),
        ("half grid in name only", retyped(&sound, float, "Tree_half_5_4_3")),
        ("unknown type", retyped(&sound, float, "Tree_float_6_5_4")),
        ("double in name only", retyped(&sound, float, "Tree_double_5_4_3")),
        ("vector in name only", retyped(&sound, float, "Tree_vec3d_5_4_3")),
        ("bool in name only", retyped(&sound, float, "Tree_bool_5_4_3")),
        ("type of 4000 letters", retyped(&sound, float, &"x".repeat(4000))),
        ("type with line ends", retyped(&sound, float, "a\nb\tc\u{1b}[31m")),
    ]
}
