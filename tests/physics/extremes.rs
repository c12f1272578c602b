//! Scenes at the ends of every range: a sound picture that agrees with the reference, or one clear
//! message.
//!
//! Seeds are fixed. Means over [`SEEDS`](crate::pictures::SEEDS) seeds of either renderer may be 4.5
//! standard errors apart, which are estimated from those seeds: by Student's distribution with 15 degrees
//! of freedom a false alarm of 4e-4 a comparison of one channel, about 60 of which are made here. Where
//! the photon map is biased the bound says by how much.

use fogbow::render::{Silent, render, render_reference};
use fogbow::scene::{LoadOptions, RenderSettings, Scene, advice};
use fogbow::vdb::{Block, GridToWrite, write};
use glam::{DVec3, IVec3};

use crate::pictures::{ERRORS, Mean, ROUNDING, agree, means};

/// Rays a pixel of the reference.
const REFERENCE_RAYS: u32 = 16;

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
    let rays = if render.contains("rays") { "" } else { "rays = 2\n" };
    let text = format!(
        "[camera]\nposition = [0.1, 0.2, 6.0]\ntarget = [0.0, 0.0, 0.0]\nfov = 30.0\n\
         [film]\nsize = [4, 4]\n[render]\n{rays}{render}\n\
         [[medium]]\n{medium}\n[[light]]\n{light}\n"
    );
    std::fs::write(&path, text).unwrap();
    Scene::load(&path, &LoadOptions::default()).unwrap()
}

/// Means of the photon map, of which every picture is sound: finite, none dropped, of bounded work.
fn sound(extreme: &Extreme) -> [Mean; 3] {
    let scene = load(extreme);
    let medium = extreme.medium;
    means(|seed| {
        let settings = RenderSettings { seed, ..scene.render };
        let rendered = render(&scene, &settings, &Silent).unwrap();
        for (name, layer) in rendered.film.layers() {
            assert!(layer.iter().all(|v| v.is_finite()), "{medium}: {name}");
        }
        assert_eq!(rendered.film.repaired() + rendered.work.dropped_samples, 0, "{medium}");
        assert!(rendered.work.collisions < 20_000_000, "{} collisions", rendered.work.collisions);
        rendered.film
    })
}

/// Means of the reference, with light that is scattered as often as the scene or `max_scatter` says.
fn reference(extreme: &Extreme, max_scatter: Option<u32>) -> [Mean; 3] {
    let scene = load(extreme);
    means(|seed| {
        let settings = RenderSettings { seed, rays: REFERENCE_RAYS, max_scatter, ..scene.render };
        render_reference(&scene, &settings, &Silent).film
    })
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
        let extreme = Extreme { medium, ..PLAIN };
        agree(sound(&extreme), reference(&extreme, None), 0.0, medium);
    }
}

#[test]
fn one_thick_channel_does_not_stop_the_others() {
    for sigma_t in ["[1e9, 1.0, 1e-9]", "[1e12, 1.0, 0.0]", "[1e18, 1e-18, 1e-18]"] {
        let medium = format!(
            "region = {{ sphere = {{ center = [0, 0, 0], radius = 1 }} }}\nsigma_t = {sigma_t}\n\
             albedo = 0.5"
        );
        let render = "photons = 500\nrays = 8";
        let extreme = Extreme { medium: medium.leak(), render, ..PLAIN };
        let ours = sound(&extreme);
        agree(ours, reference(&extreme, None), 0.0, sigma_t);
        // Nothing that can be seen of is in the way of blue.
        assert!((ours[2].value - 1.0).abs() < ROUNDING, "{sigma_t}: {:?}", ours[2]);
    }
}

/// Light of any size gives the picture of light of size 1, and any number of photons the same in the
/// mean. None leave light that is scattered once.
#[test]
fn light_and_photons_of_any_size_end_in_a_picture() {
    let right = reference(&PLAIN, None);
    for (radiance, photons) in [(1e18, 500), (1e-18, 500), (1.0, 0), (1.0, 1), (1.0, 33)] {
        let light = format!("type = \"environment\"\nradiance = {radiance:?}").leak();
        let render = format!("photons = {photons}").leak();
        let of_one =
            |mean: Mean| Mean { value: mean.value / radiance, error: mean.error / radiance };
        let ours = sound(&Extreme { light, render, ..PLAIN }).map(of_one);
        let right = if photons == 0 { reference(&PLAIN, Some(1)) } else { right };
        agree(ours, right, 0.0, &format!("{radiance}, {photons} photons"));
    }
}

#[test]
fn photons_on_one_another_are_no_burden() {
    let medium = "region = { box = { min = [-1, -1, -1], max = [1, 1, 1] } }\n\
                  sigma_t = [1e12, 1.0, 0.0]\nalbedo = 1.0";
    let [red, green, blue] = sound(&Extreme {
        medium,
        light: "type = \"point\"\nposition = [0, 3, 0]\nintensity = 1",
        render: "photons = 500\nrays = 8",
    });
    // The lamp is behind the plane of the face that is seen: nothing of red, which goes no way into the
    // box, comes to the eye, and nothing scatters blue. Green is lit with less than 1/4 W/m².
    assert!(red.value == 0.0 && blue.value == 0.0, "{red:?} {blue:?}");
    assert!(green.value > ERRORS * green.error && green.value < 0.25, "{green:?}");
}

/// A radius within which there is no photon leaves light that is scattered once, where photons are
/// gathered; one as wide as the world spreads the rest too thin, but makes it no less than nothing and no
/// more than there is. A step beyond the medium samples it at one place, which is 2.4 % bright here.
#[test]
fn radius_and_step_of_any_size_are_advised_on() {
    let [once, all] = [Some(1), None].map(|max_scatter| reference(&PLAIN, max_scatter));
    for (render, told, least, most, bias) in [
        (
            "photons = 500\nradius = 1e-9\nstrategy = 'beams'",
            Some("radius 1.000e-9 m is small"),
            once,
            once,
            0.0,
        ),
        ("photons = 500\nradius = 1e9", Some("radius 1.000e9 m is"), once, all, 0.0),
        ("photons = 500\nstep = 1e9", Some("step 1.000e9 m is"), all, all, 0.024),
        ("photons = 500\nstep = 1e-9", None, all, all, 0.0),
        ("photons = 0", Some("no photons"), once, once, 0.0),
        ("photons = 500", None, all, all, 0.0),
    ] {
        let extreme = Extreme { render, ..PLAIN };
        let said = advice(&load(&extreme));
        assert_eq!(said.len(), usize::from(told.is_some()), "{render}: {said:?}");
        if let Some(told) = told {
            assert!(said[0].starts_with(told), "{said:?}");
        }
        let ours = sound(&extreme);
        let between = |((ours, least), most): ((Mean, Mean), Mean)| {
            let value = ours.value.clamp(least.value, most.value);
            Mean { value, error: least.error.max(most.error) }
        };
        let mut nearest = ours.into_iter().zip(least).zip(most).map(between);
        agree(ours, std::array::from_fn(|_| nearest.next().unwrap()), bias, render);
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
