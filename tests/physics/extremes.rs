//! Scenes at the ends of every range: a sound picture, or one clear message.

use fogbow::render::{Rendered, Silent, render};
use fogbow::scene::{LoadOptions, Scene, advice};
use fogbow::vdb::{Block, GridToWrite, write};
use glam::{DVec3, IVec3};

/// A scene in a furnace of radiance 1: keys of its film, of `[render]` and of `[[medium]]`.
struct Extreme {
    render: &'static str,
    medium: &'static str,
    light: &'static str,
}

const PLAIN: Extreme = Extreme {
    render: "photons = 500",
    medium: "file = \"puff.vdb\"\nsigma_t = 1.0\nalbedo = 0.9",
    light: "type = \"environment\"\nradiance = 1.0",
};

/// A puff of 16³ voxels with one spike; voxels that are no density among it.
fn puff() -> GridToWrite {
    let mut grid = GridToWrite::fog("density", 0.25, DVec3::ZERO);
    for corner in 0..8 {
        let origin = IVec3::new(corner & 1, corner >> 1 & 1, corner >> 2) * 8 - 8;
        let value = |i: i32| {
            let v = origin + IVec3::new(i >> 6, i >> 3 & 7, i & 7);
            match v.to_array() {
                [1, 1, 1] => 1e6,
                [2, -3, 0] => f32::NAN,
                [-2, 3, 1] => f32::INFINITY,
                [0, -4, 2] => -1.0,
                _ => (1.0 - v.as_vec3().length() / 7.0).max(0.0),
            }
        };
        grid.blocks.push(Block { origin, values: (0..512).map(value).collect(), active: None });
    }
    grid
}

fn load(extreme: &Extreme) -> Scene {
    let Extreme { render, medium, light } = extreme;
    let folder = tempfile::tempdir().unwrap();
    write(&folder.path().join("puff.vdb"), &[puff()]).unwrap();
    let path = folder.path().join("scene.toml");
    let text = format!(
        "[camera]\nposition = [0.1, 0.2, 6.0]\ntarget = [0.0, 0.0, 0.0]\nfov = 30.0\n\
         [film]\nsize = [4, 4]\n[render]\nrays = 2\n{render}\n\
         [[medium]]\n{medium}\n[[light]]\n{light}\n"
    );
    std::fs::write(&path, text).unwrap();
    Scene::load(&path, &LoadOptions::default()).unwrap()
}

fn rendered(extreme: &Extreme) -> Rendered {
    let scene = load(extreme);
    render(&scene, &scene.render, &Silent).unwrap()
}

/// Sound: finite, none dropped, of bounded work. Returns the mean of green.
fn sound(extreme: &Extreme) -> f64 {
    let rendered = rendered(extreme);
    let values = || rendered.film.layers().flat_map(|(_, layer)| layer.iter());
    assert!(values().all(|v| v.is_finite()), "{}", extreme.medium);
    assert_eq!(rendered.film.repaired() + rendered.work.dropped_samples, 0, "{}", extreme.medium);
    assert!(rendered.work.collisions < 20_000_000, "{} collisions", rendered.work.collisions);
    let green = rendered.film.layer("G").unwrap();
    green.iter().map(|v| f64::from(*v)).sum::<f64>() / green.len() as f64
}

#[test]
fn any_extinction_ends_in_a_picture() {
    for medium in [
        "file = \"puff.vdb\"\nsigma_t = 1e-18",
        "file = \"puff.vdb\"\nsigma_t = 1e-6",
        "file = \"puff.vdb\"\nsigma_t = 1e6",
        "file = \"puff.vdb\"\nsigma_t = 1e12",
        "file = \"puff.vdb\"\nsigma_t = 1e18",
        "file = \"puff.vdb\"\nsigma_t = 1.0\nscale = 1e-15",
        "file = \"puff.vdb\"\nsigma_t = 1.0\ntranslate = [1e7, 0, 0]",
    ] {
        let mean = sound(&Extreme { medium, ..PLAIN });
        assert!((0.3..1.5).contains(&mean), "{medium}: {mean}");
    }
}

#[test]
fn one_thick_channel_does_not_stop_the_others() {
    for sigma_t in ["[1e9, 1.0, 1e-9]", "[1e12, 1.0, 0.0]", "[1e18, 1e-18, 1e-18]"] {
        let medium = format!(
            "region = {{ sphere = {{ center = [0, 0, 0], radius = 1 }} }}\nsigma_t = {sigma_t}\n\
             albedo = 0.5"
        );
        let mean = sound(&Extreme { medium: medium.leak(), ..PLAIN });
        assert!((0.3..1.5).contains(&mean), "{sigma_t}: {mean}");
    }
}

#[test]
fn light_and_photons_of_any_size_end_in_a_picture() {
    for (radiance, photons) in [(1e18, 500), (1e-18, 500), (1.0, 0), (1.0, 1), (1.0, 33)] {
        let light = format!("type = \"environment\"\nradiance = {radiance:?}").leak();
        let render = format!("photons = {photons}").leak();
        let mean = sound(&Extreme { light, render, ..PLAIN }) / radiance;
        assert!((0.3..1.5).contains(&mean), "{radiance}, {photons} photons: {mean}");
    }
}

#[test]
fn photons_on_one_another_are_no_burden() {
    let medium = "region = { box = { min = [-1, -1, -1], max = [1, 1, 1] } }\n\
                  sigma_t = [1e12, 1.0, 0.0]\nalbedo = 1.0";
    sound(&Extreme {
        medium,
        light: "type = \"point\"\nposition = [0, 3, 0]\nintensity = 1",
        ..PLAIN
    });
}

#[test]
fn radius_and_step_of_any_size_are_advised_on() {
    for (render, told) in [
        ("photons = 500\nradius = 1e-9", Some("radius 1.000e-9 m is small")),
        ("photons = 500\nradius = 1e9", Some("radius 1.000e9 m is")),
        ("photons = 500\nstep = 1e9", Some("step 1.000e9 m is")),
        ("photons = 500\nstep = 1e-9", None),
        ("photons = 0", Some("no photons")),
        ("photons = 500", None),
    ] {
        let extreme = Extreme { render, ..PLAIN };
        let said = advice(&load(&extreme));
        assert_eq!(said.len(), usize::from(told.is_some()), "{render}: {said:?}");
        if let Some(told) = told {
            assert!(said[0].starts_with(told), "{said:?}");
        }
        let mean = sound(&extreme);
        assert!((0.3..1.5).contains(&mean), "{render}: {mean}");
    }
}

#[test]
fn voxels_that_are_no_density_are_told_of() {
    let warnings = load(&PLAIN).warnings;
    assert!(
        warnings[0].contains("1 NaN, 1 infinite, 1 negative voxels taken as 0"),
        "{warnings:?}"
    );
}
