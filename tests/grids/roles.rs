//! Which grid of a file is taken for what: by name, by content, as three scalar grids.

use std::path::Path;

use fogbow::math::{IndexPoint, WorldPoint};
use fogbow::scene::{LoadOptions, Scene};
use fogbow::vdb::roles::{Axis, Contents, FireKind, GridRef, Role, Unit};
use fogbow::vdb::{Block, GridToWrite, ReadAs, ValueType, VdbFile, write};
use glam::{DVec3, IVec3};

use crate::common::{shared, written};

/// Voxels of an 8³ block by their place in it.
fn block(value: impl Fn(f32, f32, f32) -> f32) -> Vec<f32> {
    let at = |i: usize| [i >> 6, i >> 3 & 7, i & 7].map(|c| c as f32);
    (0..512).map(at).map(|[x, y, z]| value(x, y, z)).collect()
}

/// One block of scalars.
fn scalar(name: &str, value: impl Fn(f32, f32, f32) -> f32) -> GridToWrite {
    let mut grid = GridToWrite::fog(name, 0.5, DVec3::ZERO);
    grid.blocks.push(Block { origin: IVec3::ZERO, values: block(value), active: None });
    grid
}

/// Smoke that thins out along y.
fn smoke(name: &str) -> GridToWrite {
    scalar(name, |_, y, _| 1.0 - y / 8.0)
}

/// One block of vectors.
fn vector(name: &str, value: [f32; 3]) -> GridToWrite {
    let mut grid = GridToWrite { value_type: ValueType::Vec3, ..smoke(name) };
    grid.blocks[0].values = std::iter::repeat_n(value, 512).flatten().collect();
    grid
}

fn empty(name: &str) -> GridToWrite {
    GridToWrite::fog(name, 0.5, DVec3::ZERO)
}

fn contents(grids: &[GridToWrite]) -> Contents {
    let (_folder, file) = written(grids);
    Contents::find(&file).unwrap()
}

/// The label and kind of what glows beside smoke.
fn glows(grids: &[GridToWrite]) -> Option<(String, FireKind)> {
    let all: Vec<_> = [smoke("density")].into_iter().chain(grids.iter().cloned()).collect();
    contents(&all).fire.map(|fire| (fire.grid.label().to_owned(), fire.kind))
}

#[test]
fn densities_are_preferred_in_the_order_of_the_table() {
    let order = ["density", "dens", "soot", "smoke", "voxel_fog_density", "total_density", "fog"];
    for first in 0..order.len() {
        let grids: Vec<_> = order[first..].iter().rev().map(|name| smoke(name)).collect();
        let (_folder, file) = written(&grids);
        let found = file.default_density().unwrap();
        assert_eq!(file.grids()[found].name, order[first]);
    }
}

#[test]
fn densities_have_any_case_and_suffixes_and_are_never_helpers() {
    for name in ["Density", "DENSITY_0", "density1", "Soot.hires"] {
        let others = ["shadow", "density_inflow", "pressure", "temperature", "sdf", "a"];
        let mut grids: Vec<_> = others.iter().map(|other| smoke(other)).collect();
        grids.push(smoke(name));
        assert_eq!(contents(&grids).density.label(), name);
    }
    // Nothing by name: the only fog volume without a role, then the only one.
    assert_eq!(contents(&[smoke("pressure"), smoke("heat"), smoke("a")]).density.label(), "a");
    assert_eq!(contents(&[smoke("pressure"), smoke("heat")]).density.label(), "heat");
    for grids in [&[smoke("pressure")][..], &[smoke("a"), smoke("b")], &[]] {
        let (_folder, file) = written(grids);
        let message = Contents::find(&file).unwrap_err().to_string();
        assert!(message.contains("it holds") && message.lines().count() == 1, "{message}");
    }
}

#[test]
fn a_level_set_called_density_is_refused_by_name_and_passed_over_for_fog() {
    let level_set = GridToWrite { class: "level set".into(), ..smoke("density") };
    let (_folder, file) = written(std::slice::from_ref(&level_set));
    let message = Contents::find(&file).unwrap_err().to_string();
    assert!(message.contains("is a level set"), "{message}");
    assert_eq!(contents(&[level_set, smoke("soot")]).density.label(), "soot");
}

#[test]
fn plain_smoke_of_blender_does_not_glow() {
    // Blender 5.2 writes a constant temperature, and empty flames, into plain smoke.
    let ball = |name: &str, value: f32| {
        scalar(name, move |x, y, z| {
            let r = DVec3::new(x.into(), y.into(), z.into()).distance(DVec3::splat(3.5));
            if r < 3.0 { value } else { 0.0 }
        })
    };
    let made = contents(&[ball("density", 1.0), empty("flame"), ball("temperature", 800.0)]);
    assert_eq!(made.fire, None);
    let told = |words: &str| made.notes.iter().any(|note| note.contains(words));
    assert!(told("\"flame\" does not glow: it is empty"), "{:?}", made.notes);
    assert!(told("\"temperature\" does not glow: it is constant"), "{:?}", made.notes);
}

#[test]
fn caches_of_mantaflow_are_smoke_with_colour_and_z_up() {
    for frame in 7..=10 {
        let Some(path) = shared(&format!("gas_sequence/fluid_data_{frame:04}.vdb")) else { return };
        let contents = Contents::find(&VdbFile::open(&path).unwrap()).unwrap();
        assert_eq!(contents.density.label(), "density");
        assert_eq!(contents.fire, None, "{frame}");
        assert!(
            matches!(contents.color, Some(GridRef::Triple { ref label, .. }) if label == "color")
        );
        assert_eq!(contents.velocity.as_ref().map(GridRef::label), Some("velocity"));
        assert_eq!(contents.up.map(|(axis, _)| axis), Some(Axis::Z));
        let told = |words: &str| contents.notes.iter().any(|note| note.contains(words));
        assert!(told("\"emission\" does not glow") && told("follows the density"), "{contents:?}");
    }
}

#[test]
fn shared_volumes_are_plain_smoke() {
    for name in ["smoke/smoke_v222.vdb", "cloud/singlecloud.vdb"] {
        let Some(path) = shared(name) else { return };
        let contents = Contents::find(&VdbFile::open(&path).unwrap()).unwrap();
        assert_eq!(contents.density.label(), "density");
        assert_eq!((contents.fire, contents.color, contents.up), (None, None, None));
    }
}

#[test]
fn shipped_fire_glows_by_its_temperature() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("volumes/fire.vdb");
    let fire = Contents::find(&VdbFile::open(&path).unwrap()).unwrap().fire.unwrap();
    assert_eq!(fire.grid.label(), "temperature");
    assert_eq!(fire.kind, FireKind::Temperature(Unit::Normalised));
}

#[test]
fn flames_come_before_temperatures_and_fuel_last() {
    let hot = || scalar("temperature", |x, _, _| 300.0 + 200.0 * x);
    let flames = |name: &str| scalar(name, |x, _, z| x * z / 49.0);
    let intensity = |name: &str| Some((name.to_owned(), FireKind::Intensity));
    for name in ["flame", "Flames", "heat", "burn", "fire", "emission", "voxel_flame"] {
        assert_eq!(glows(&[hot(), flames(name)]), intensity(name));
    }
    assert_eq!(glows(&[flames("heat"), flames("flames")]), intensity("flames"));
    assert_eq!(glows(&[flames("fuel")]), intensity("fuel"));
    let kelvin = Some(("temperature".to_owned(), FireKind::Temperature(Unit::Kelvin)));
    assert_eq!(glows(&[flames("fuel"), hot()]), kelvin);
    assert_eq!(glows(&[flames("fuel"), empty("flame")]), None, "nothing burns");
    assert_eq!(glows(&[empty("flame"), hot()]), kelvin);
    let normalised = || scalar("temperature", |x, _, _| x / 7.0);
    assert_eq!(glows(&[empty("flame"), normalised()]), None, "no flame, so it is but warm");
    let constant = |name: &str| scalar(name, |_, _, _| 0.5);
    assert_eq!(glows(&[constant("flame"), hot()]), kelvin);
    assert_eq!(glows(&[constant("flame")]), None);
    assert_eq!(glows(&[flames("fuel_inflow"), flames("react"), flames("shadow")]), None);
    // A flame of one value in a part of the smoke is no constant.
    let core = scalar("flame", |x, _, _| if x < 3.0 { 1.0 } else { 0.0 });
    assert_eq!(glows(&[core]), intensity("flame"));
}

#[test]
fn only_caches_of_mantaflow_have_emission_for_sources() {
    let emission = || scalar("emission", |x, _, _| x);
    assert!(glows(&[emission()]).is_some());
    for mark in ["flags", "phi_obstacle", "fuel_inflow"] {
        assert_eq!(glows(&[emission(), smoke(mark)]), None, "{mark}");
    }
}

#[test]
fn temperatures_glow_where_their_values_say_so() {
    let temperature = |value: fn(f32) -> f32| {
        glows(&[scalar("temperature", move |x, _, _| value(x))]).map(|(_, kind)| kind)
    };
    let glow = |unit| Some(FireKind::Temperature(unit));
    assert_eq!(temperature(|x| 290.0 + 150.0 * x), glow(Unit::Kelvin));
    assert_eq!(temperature(|x| 1500.0 + 20.0 * x), glow(Unit::Kelvin), "a narrow range of Kelvin");
    assert_eq!(temperature(|x| -20.0 + 60.0 * x), None, "Celsius, at most 400");
    assert_eq!(temperature(|x| -100.0 + 140.0 * x), glow(Unit::Celsius));
    assert_eq!(temperature(|x| 250.0 + 10.0 * x), None, "a cloud's Kelvin");
    assert_eq!(temperature(|x| -40.0 + 8.0 * x), None, "a cloud's Celsius");
    assert_eq!(temperature(|x| x / 7.0), glow(Unit::Normalised));
    assert_eq!(temperature(|x| x * x / 10.0 - 0.01), glow(Unit::Normalised), "it rings");
    assert_eq!(temperature(|x| 0.9 + 0.01 * x), None, "it hardly varies");
    assert_eq!(temperature(|_| 1200.0), None, "it is constant");
    assert_eq!(temperature(|_| 0.0), None, "it is empty");
}

#[test]
fn a_temperature_that_follows_the_density_is_no_fire() {
    for noise in [0.0, 0.05] {
        let copy = scalar("temperature", move |x, y, z| {
            let wave = (x * 7.0 + y * 3.0 + z * 5.0).sin();
            0.8 * (1.0 - y / 8.0) + noise * wave
        });
        assert_eq!(glows(&[copy]), None, "{noise}");
    }
    let own = scalar("temperature", |x, y, _| (1.0 - y / 8.0) * (1.0 - x / 8.0));
    assert!(glows(&[own]).is_some());
}

#[test]
fn grids_that_lie_elsewhere_are_compared_in_the_world() {
    // The temperature has half the voxel size and another origin, but follows the density.
    let profile = |world: f32| 0.1 + (world - 1.75).powi(2) / 3.5;
    let density = scalar("density", |_, y, _| profile(0.5 * y));
    let mut temperature = GridToWrite::fog("temperature", 0.25, DVec3::splat(-0.5));
    for i in 0..27 {
        let origin = 8 * IVec3::new(i / 9, i / 3 % 3, i % 3);
        let values = block(|_, y, _| 2.0 * profile(0.25 * (y + origin.y as f32) - 0.5));
        temperature.blocks.push(Block { origin, values, active: None });
    }
    assert_eq!(contents(&[density, temperature]).fire, None);
}

#[test]
fn three_scalar_grids_are_a_vector() {
    for ends in [
        [".x", ".y", ".z"],
        ["x", "y", "z"],
        ["_x", "_y", "_z"],
        [".X", ".Y", ".Z"],
        ["X", "Y", "Z"],
        [".r", ".g", ".b"],
        ["_r", "_g", "_b"],
        ["_R", "_G", "_B"],
        ["R", "G", "B"],
    ] {
        let mut grids = vec![smoke("density")];
        // In no order in the file.
        for i in [2, 0, 1] {
            grids.push(scalar(&format!("Cd{}", ends[i]), move |_, _, _| 0.25 * (i + 1) as f32));
        }
        let (_folder, file) = written(&grids);
        let contents = Contents::find(&file).unwrap();
        let color = contents.color.clone().unwrap();
        assert_eq!((color.label(), color.indices()), ("Cd", &[2, 3, 1][..]), "{ends:?}");
        assert_eq!(file.find_vector("Cd", None).unwrap(), color);
        let grid = file.read_vector_of(&color).unwrap();
        assert_eq!(grid.value(IndexPoint::new(3.0, 4.0, 5.0)), [0.25, 0.5, 0.75]);
        assert_eq!(contents.role(1), Some(Role::Color));
        assert!(file.find_vector("C", None).is_err());
    }
    let two = contents(&[smoke("density"), smoke("Cd.x"), smoke("Cd.y")]);
    assert_eq!(two.color, None);
}

#[test]
fn a_vector_of_that_name_wins_over_three_scalars() {
    let parts = ["color_r", "color_g", "color_b"].map(smoke);
    let mut grids = vec![smoke("density")];
    grids.extend(parts);
    grids.push(vector("color", [0.5, 0.25, 0.125]));
    let contents = contents(&grids);
    assert_eq!(contents.color, Some(GridRef::Single { index: 4, label: "color".into() }));
    let told = contents.notes.iter().any(|n| n.contains("\"color\" is taken, and not the three"));
    assert!(told, "{:?}", contents.notes);
}

#[test]
fn three_scalars_need_one_transform() {
    let mut moved = smoke("vel.y");
    moved.transform.translation.x += 0.25;
    let (_folder, file) = written(&[smoke("vel.x"), moved, smoke("vel.z")]);
    let grid = file.find_vector("vel", None).unwrap();
    let message = file.read_vector_of(&grid).unwrap_err().to_string();
    for words in ["grid \"vel\"", "\"vel.x\", \"vel.y\", \"vel.z\"", "different transforms"] {
        assert!(message.contains(words), "{words}: {message}");
    }
}

#[test]
fn colours_of_mantaflow_are_divided_by_the_density() {
    // No density in a corner and outside: values between must not be darker for that.
    let density = |x: f32, y: f32, z: f32| if x + y + z < 4.0 { 0.0 } else { 0.1 * (y + 1.0) };
    let colors = [0.75, 0.5, 0.25];
    let part =
        |i: usize, name: &str| scalar(name, move |x, y, z| colors[i] as f32 * density(x, y, z));
    let mut grids = vec![scalar("density", density)];
    grids.extend(["color_r", "color_g", "color_b"].iter().enumerate().map(|(i, n)| part(i, n)));
    for (mark, divided) in [("flags", true), ("a", false)] {
        let all: Vec<_> = grids.iter().cloned().chain([smoke(mark)]).collect();
        let (_folder, file) = written(&all);
        let color = Contents::find(&file).unwrap().color.unwrap();
        let grid = file.read_color(&color).unwrap();
        let parts = [1, 2, 3].map(|i| file.read_scalar(i, ReadAs::Raw).unwrap());
        for i in 0..500 {
            let at = |n: i32| f64::from(i * n % 97) / 97.0 * 9.0 - 1.0;
            let p = IndexPoint::new(at(1), at(7), at(31));
            let expected =
                if divided { colors } else { parts.each_ref().map(|part| part.value(p)) };
            for (got, wanted) in grid.value(p).into_iter().zip(expected) {
                assert!((got - wanted).abs() < 1e-6, "{mark}, {p:?}: {got}, {wanted}");
            }
        }
    }
}

#[test]
fn black_colours_are_not_used() {
    let black = vector("Cd", [0.0; 3]);
    let contents = contents(&[smoke("density"), black]);
    assert_eq!(contents.color, None);
    assert!(contents.notes.iter().any(|note| note.contains("black")), "{:?}", contents.notes);
}

#[test]
fn several_grids_of_one_name_are_noted() {
    let contents = contents(&[smoke("density"), smoke("density")]);
    assert_eq!(contents.density, GridRef::Single { index: 0, label: "density[0]".into() });
    let note = &contents.notes[0];
    assert!(note.contains("2 grids are called \"density\"; \"density[0]\" is taken"), "{note}");
}

#[test]
fn near_misses_get_a_hint() {
    let (_folder, file) = written(&[smoke("density"), smoke("Cd.x"), smoke("Cd.y"), smoke("Cd.z")]);
    for (given, meant) in [("densty", "density"), ("Density", "density"), ("dnesity", "density")] {
        let message = file.find(given, None).unwrap_err().to_string();
        assert!(message.contains(&format!("did you mean \"{meant}\"?")), "{message}");
    }
    let message = file.find_vector("cd", None).unwrap_err().to_string();
    assert!(message.contains("did you mean \"Cd\"?"), "{message}");
    let message = file.find("Cd", None).unwrap_err().to_string();
    assert!(message.contains("only its three components"), "{message}");
    let message = file.find("wibble", None).unwrap_err().to_string();
    assert!(!message.contains("did you mean"), "{message}");
}

#[test]
fn smoke_that_rises_tells_which_way_is_up() {
    let up = |v: [f32; 3]| contents(&[smoke("density"), vector("vel", v)]).up.map(|(axis, _)| axis);
    assert_eq!(up([0.1, 2.0, 0.3]), Some(Axis::Y));
    assert_eq!(up([0.1, 0.3, 2.0]), Some(Axis::Z));
    assert_eq!(up([0.1, 0.3, -2.0]), None);
    assert_eq!(up([2.0, 0.3, 0.1]), None);
    assert_eq!(up([0.0; 3]), None);
    let parts = [("v.x", 0.0), ("v.y", 0.1), ("v.z", 1.0)];
    let parts = parts.map(|(name, value)| scalar(name, move |_, _, _| value));
    let all: Vec<_> = [smoke("density")].into_iter().chain(parts).collect();
    assert_eq!(contents(&all).up.map(|(axis, _)| axis), Some(Axis::Z));
}

#[test]
fn grids_without_a_role_are_not_read() {
    let folder = tempfile::tempdir().unwrap();
    for (name, is_read) in [("pressure", false), ("shadow", false), ("heat", true)] {
        let path = folder.path().join(format!("{name}.vdb"));
        // Values without any pattern, which compression cannot shrink.
        let noise = |i: u32| (i.wrapping_mul(2_654_435_761) >> 8) as f32;
        let values = |name| {
            let mut grid = smoke(name);
            grid.blocks[0].values = (0..512).map(noise).collect();
            grid
        };
        write(&path, &[values("density"), values(name)]).unwrap();
        let mut bytes = std::fs::read(&path).unwrap();
        let end = bytes.len();
        bytes[end - 1000..].fill(0xa5); // inside the voxels of the last grid
        std::fs::write(&path, bytes).unwrap();
        match Contents::find(&VdbFile::open(&path).unwrap()) {
            Ok(_) => assert!(!is_read, "{name}"),
            Err(e) => assert!(is_read && e.to_string().contains("\"heat\""), "{e}"),
        }
    }
}

#[test]
fn scenes_find_three_scalars_and_note_namesakes() {
    let folder = tempfile::tempdir().unwrap();
    let mut grids = vec![smoke("density"), smoke("density")];
    for (name, value) in [("color_r", 0.75), ("color_g", 0.5), ("color_b", 0.25)] {
        grids.push(scalar(name, move |_, _, _| value));
    }
    write(&folder.path().join("a.vdb"), &grids).unwrap();
    let load = |albedo: &str| {
        let text = format!(
            "[camera]\nposition = [0, 1, 8]\ntarget = [0, 1, 0]\n[[light]]\ntype = \"point\"\n\
             position = [0, 9, 0]\nintensity = 1\n[[medium]]\nfile = \"a.vdb\"\n\
             grid = \"density\"\nalbedo = {{ grid = \"{albedo}\" }}\n"
        );
        let path = folder.path().join("a.toml");
        std::fs::write(&path, text).unwrap();
        Scene::load(&path, &LoadOptions::default())
    };
    let scene = load("color").unwrap();
    let at = WorldPoint::from_xyz(DVec3::splat(1.5));
    assert_eq!(scene.media.get(0).albedo.at(at), DVec3::new(0.75, 0.5, 0.25));
    let notes = scene.warnings.iter().filter(|w| w.contains("2 grids are called \"density\""));
    assert_eq!(notes.count(), 1, "{:?}", scene.warnings);
    let message = load("colour").unwrap_err().to_string();
    let place = "a.toml:11:19: medium[0].albedo.grid";
    assert!(message.contains("did you mean \"color\"?") && message.contains(place), "{message}");
}

#[test]
fn three_scalars_equal_the_vector_they_make() {
    let Some(path) = shared("gas_sequence/fluid_data_0010.vdb") else { return };
    let file = VdbFile::open(&path).unwrap();
    let color = file.find_vector("color", None).unwrap();
    let vector = file.read_vector_of(&color).unwrap();
    let indices = color.indices().to_vec();
    let parts = indices.iter().map(|&i| file.read_scalar(i, ReadAs::Raw).unwrap());
    let parts: Vec<_> = parts.collect();
    let samples = (0..20_000).map(|i| {
        let at = |n: u32, size: f64| f64::from((i * n) % 997) / 997.0 * size;
        IndexPoint::new(at(1, 60.0) + 40.0, at(31, 75.0) + 50.0, at(57, 30.0) + 5.0)
    });
    for p in samples {
        let got = vector.value(p);
        for (part, got) in parts.iter().zip(got) {
            assert!((part.value(p) - got).abs() < 1e-9, "{p:?}");
        }
    }
}
