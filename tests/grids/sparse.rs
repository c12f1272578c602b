//! What emptiness costs: two puffs 1e5 voxels from each other beside the same two close together.

use std::path::Path;

use fogbow::image::Image;
use fogbow::render::{Rendered, Silent, render};
use fogbow::scene::{LoadOptions, Scene};
use fogbow::vdb::{Block, GridToWrite, write};
use glam::{DVec3, IVec3};

/// Radius of a puff, in voxels.
const RADIUS: f64 = 20.0;

/// How many times the work two puffs close together take those far apart may take.
const DEARER: f64 = 1.2;

/// Two puffs, the second `apart` voxels along x from the first.
fn puffs(apart: i32) -> GridToWrite {
    let mut grid = GridToWrite::fog("density", 0.05, DVec3::ZERO);
    for middle in [IVec3::ZERO, IVec3::new(apart, 3, 2)] {
        let value = |v: IVec3| {
            let p = (v - middle).as_dvec3();
            let cells = (p * 0.4).map(f64::sin).element_product();
            if p.length() < RADIUS { (1.0 + 0.9 * cells) as f32 } else { 0.0 }
        };
        for corner in 0..512 {
            let corner = IVec3::new(corner >> 6, corner >> 3 & 7, corner & 7) - 4;
            let origin = 8 * (middle.div_euclid(IVec3::splat(8)) + corner);
            let within = |i: i32| origin + IVec3::new(i >> 6, i >> 3 & 7, i & 7);
            let values: Vec<f32> = (0..512).map(|i| value(within(i))).collect();
            if values.iter().any(|value| *value != 0.0) {
                grid.blocks.push(Block { origin, values, active: None });
            }
        }
    }
    grid
}

/// Both puffs, one behind the other, under an even sky: each ray that meets one has to cross what
/// lies between them.
fn rendered(folder: &Path, apart: i32) -> Rendered {
    write(&folder.join("puffs.vdb"), &[puffs(apart)]).unwrap();
    let path = folder.join("scene.toml");
    let text = "[camera]
        type = 'orthographic'
        position = [-10, 0, 0]
        target = [0, 0, 0]
        height = 3
        [film]
        size = [48, 48]
        [[light]]
        type = 'environment'
        radiance = [1, 1, 1]
        [[medium]]
        file = 'puffs.vdb'
        sigma_t = 1.0
        albedo = 0.9
        [render]
        photons = 100000
        rays = 8";
    std::fs::write(&path, text).unwrap();
    let scene = Scene::load(&path, &LoadOptions::default()).unwrap();
    render(&scene, &scene.render, &Silent).unwrap()
}

#[test]
fn emptiness_takes_hardly_any_work() {
    let folder = tempfile::tempdir().unwrap();
    let [near, far] = [48, 100_000].map(|apart| rendered(folder.path(), apart));
    for (name, near, far) in [
        ("march steps", near.work.march_steps, far.work.march_steps),
        ("grid lookups", near.work.grid_lookups, far.work.grid_lookups),
        ("collisions", near.work.collisions, far.work.collisions),
        ("gathers", near.work.gathers, far.work.gathers),
    ] {
        assert!(
            far as f64 <= DEARER * near as f64,
            "{far} {name} far apart, {near} close together"
        );
    }
    // Photons find both puffs wherever they are; without them over a quarter of the light would be
    // missing.
    let light = |image: &Image| image.channels()[1].iter().map(|v| f64::from(*v)).sum::<f64>();
    let [near, far] = [near, far].map(|rendered| light(&rendered.film.image()));
    assert!((far / near - 1.0).abs() < 0.01, "{far} far apart, {near} close together");
}
