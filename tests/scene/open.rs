//! Scenes that stay open while options change.

use std::fs;

use fogbow::scene::{LoadOptions, OpenScene, Scene};
use fogbow::vdb::{Block, GridToWrite, write};
use glam::{DVec3, IVec3};

/// A scene of one grid with a bad voxel; camera rays alone need it where `albedo` is 0.
fn scene(albedo: f64) -> String {
    format!(
        "[camera]\nposition = [0.4, 0.4, 5]\ntarget = [0.4, 0.4, 0]\n[film]\nsize = [20, 10]\n\
         [[medium]]\nfile = \"smoke.vdb\"\nalbedo = {albedo}\nemission = {{ color = 1.0 }}\n\
         [[light]]\ntype = \"environment\"\nradiance = 0.2\n"
    )
}

#[test]
fn an_open_scene_is_the_one_that_is_loaded_anew_and_reads_nothing_twice() {
    for albedo in [0.9, 0.0] {
        let folder = tempfile::tempdir().unwrap();
        let [path, grid_path] = ["s.toml", "smoke.vdb"].map(|name| folder.path().join(name));
        let mut values = vec![1.0; 512];
        values[3] = -1.0;
        let blocks = vec![Block { origin: IVec3::ZERO, values, active: None }];
        let grid = GridToWrite::fog("density", 0.1, DVec3::ZERO);
        write(&grid_path, &[GridToWrite { blocks, ..grid }]).unwrap();
        fs::write(&path, scene(albedo)).unwrap();

        let all = [
            LoadOptions::default(),
            LoadOptions::default().rays(3),
            LoadOptions::default().with("medium.0.sigma_t", 2.0),
            LoadOptions::default().with("light.0.radiance", 2.0),
            LoadOptions::default(),
        ];
        let anew: Vec<_> = all.iter().map(|options| Scene::load(&path, options).unwrap()).collect();
        let mut open = OpenScene::of_file(&path);
        open.load(&all[0]).unwrap();
        fs::write(&path, "what lies here later").unwrap();
        fs::write(&grid_path, "has no effect").unwrap();
        for (options, anew) in all.iter().zip(&anew) {
            let kept = open.load(options).unwrap();
            assert_eq!(kept.warnings, anew.warnings, "{options:?}");
            assert!(kept.warnings.iter().any(|warning| warning.contains("1 negative")));
            assert_eq!((kept.unseen, &kept.notes), (anew.unseen, &anew.notes), "{options:?}");
            let hashes = |scene: &Scene| {
                [&scene.hash, &scene.light_hash, &scene.static_hash].map(String::clone)
            };
            assert_eq!(hashes(&kept), hashes(anew), "{options:?}");
            assert_eq!(kept.render, anew.render);
        }
    }
}
