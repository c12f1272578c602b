//! Media of one file share its voxels.

use std::path::Path;

use fogbow::medium::{Albedo, Density, Emission};
use fogbow::scene::{LoadOptions, Planning, Scene};
use fogbow::vdb::{Block, GridToWrite, ValueType, write};
use glam::{DVec3, IVec3};

/// A puff of 16³ voxels of density, temperature and colour.
fn write_puff(path: &Path) {
    let grid = |name: &str, components: usize| {
        let mut grid = GridToWrite::fog(name, 0.1, DVec3::ZERO);
        for corner in 0..8 {
            let origin = IVec3::new(corner & 1, corner >> 1 & 1, corner >> 2) * 8 - 8;
            let values = (0..512 * components).map(|i| 0.1 + (i % 7) as f32 * 0.1).collect();
            grid.blocks.push(Block { origin, values, active: None });
        }
        grid
    };
    let color = GridToWrite { value_type: ValueType::Vec3, ..grid("Cd", 3) };
    write(path, &[grid("density", 1), grid("temperature", 1), color]).unwrap();
}

const CAMERA: &str = "camera = { position = [0, 0, 9], target = [0, 0, 0], fov = 8.0 }\n\
                      film = { size = [8, 8] }\n";
const SKY: &str = "[[light]]\ntype = 'environment'\nradiance = 1.0\n";

fn load(media: &[String]) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    write_puff(&folder.path().join("puff.vdb"));
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, CAMERA.to_owned() + &media.concat() + SKY).unwrap();
    let options = LoadOptions { planning: Planning::Needed, ..LoadOptions::default() };
    Scene::load(&path, &options).unwrap()
}

fn puff(at: u32, keys: &str) -> String {
    format!("[[medium]]\nfile = 'puff.vdb'\nsigma_t = 1.0\ntranslate = [{at}, 0, 0]\n{keys}\n")
}

#[test]
fn twenty_media_of_one_file_are_one_grid_in_memory() {
    let keys = "albedo = { grid = 'Cd' }\nemission = { temperature = 'temperature' }";
    let media: Vec<String> = (0..20).map(|at| puff(at, keys)).collect();
    let (one, twenty) = (load(&media[..1]), load(&media));
    assert_eq!(one.media.grid_bytes().len(), 3);
    assert_eq!(twenty.media.grid_bytes(), one.media.grid_bytes());
    for (at, medium) in (0..).zip(twenty.media.iter()) {
        let Density::Voxel(grid) = &medium.density else { panic!("a grid") };
        let place = grid.transform().affine().translation;
        assert!((place - DVec3::new(f64::from(at), 0.0, 0.0)).length() < 1e-12, "{place}");
        assert!(matches!(medium.albedo, Albedo::Color { .. }));
        assert!(matches!(medium.emission, Some(Emission::Blackbody { .. })));
    }
}

/// Where only the camera asks for voxels those out of its sight are left out, which differ from
/// place to place: a grid with several places is read whole.
#[test]
fn what_is_out_of_sight_of_one_is_there_for_another() {
    let alone = load(&[puff(1, "albedo = 0.0")]);
    assert!(alone.unseen.unwrap().voxels > 0, "{:?}", alone.unseen);
    let both = load(&[puff(1, "albedo = 0.0"), puff(0, "albedo = 0.0")]);
    assert_eq!(both.media.grid_bytes().len(), 1);
    assert_eq!(both.unseen.unwrap().voxels, 0);
    let Density::Voxel(whole) = &both.media.get(1).density else { panic!("a grid") };
    assert_eq!(whole.unwanted(), 0);
    // A grid that is read as a density and as a temperature is one grid as well.
    let hot = load(&[puff(0, "albedo = 0.5\nemission = { temperature = 'density' }")]);
    assert_eq!(hot.media.grid_bytes().len(), 1);
}
