//! VDB files without a scene: what the picture shows, and the scene that is written for it.

use std::path::{Path, PathBuf};

use assert_cmd::Command;
use fogbow::image::{Layers, read_layers};
use fogbow::medium::Emission;
use fogbow::scene::{LoadOptions, Look, LookOptions, Scene, Sequence, UpAxis, summary};
use fogbow::sequence::FrameTime;
use fogbow::vdb::{Block, GridToWrite, ValueType, write};
use glam::{DVec3, IVec3};

fn fogbow() -> Command {
    Command::new(assert_cmd::cargo::cargo_bin!("fogbow"))
}

/// A grid of the voxels within `min` and `max` whose `value` is not nothing.
fn grid(name: &str, min: IVec3, max: IVec3, value: impl Fn(IVec3) -> Option<f32>) -> GridToWrite {
    let mut grid = GridToWrite::fog(name, 0.1, DVec3::ZERO);
    let (first, last): (IVec3, IVec3) = (min >> 3, max >> 3);
    for x in first.x..=last.x {
        for y in first.y..=last.y {
            for z in first.z..=last.z {
                let origin = IVec3::new(x, y, z) * 8;
                let at = |i: i32| value(origin + IVec3::new(i >> 6, i >> 3 & 7, i & 7));
                let mut active = [0u64; 8];
                for i in (0..512).filter(|&i| at(i).is_some()) {
                    active[i as usize / 64] |= 1 << (i % 64);
                }
                if active != [0; 8] {
                    let values = (0..512).map(|i| at(i).unwrap_or(0.0)).collect();
                    grid.blocks.push(Block { origin, values, active: Some(active) });
                }
            }
        }
    }
    grid
}

/// A ball of density 1 and of ten voxels' radius, `stretched` along each axis.
fn ball(center: IVec3, stretched: DVec3) -> GridToWrite {
    let reach = (stretched * 12.0).ceil().as_ivec3();
    grid("density", center - reach, center + reach, |v| {
        let r = ((v - center).as_dvec3() / stretched).length();
        (r < 10.0).then_some(1.0)
    })
}

fn file(folder: &Path, name: &str, grids: &[GridToWrite]) -> PathBuf {
    let path = folder.join(name);
    write(&path, grids).unwrap();
    path
}

/// Renders `path` small with so many rays and photons and reads the layers.
fn rendered(path: &Path, [rays, photons]: [&str; 2], more: &[&str]) -> Layers {
    let out = path.with_extension("exr");
    let fast = ["--rays", rays, "--photons", photons, "--quiet", "-o"];
    fogbow().arg("render").arg(path).args(fast).arg(&out).args(more).assert().success();
    read_layers(&out).unwrap()
}

/// Width and height over those of the picture of what media hide more than half of.
fn extent(layers: &Layers) -> [f64; 2] {
    let transmittance = &layers.channels["transmittance"];
    let hidden = |i: &usize| transmittance[*i] < 0.5;
    let (mut min, mut max) = ([usize::MAX; 2], [0; 2]);
    for i in (0..transmittance.len()).filter(hidden) {
        let at = [i % layers.width, i / layers.width];
        min = [0, 1].map(|k| min[k].min(at[k]));
        max = [0, 1].map(|k| max[k].max(at[k] + 1));
    }
    let size = [layers.width, layers.height];
    [0, 1].map(|k| (max[k] - min[k]) as f64 / size[k] as f64)
}

/// Balls, rods and plates in pictures of any shape, amid voxels of 0 and with stray voxels far away:
/// what is seen fills 0.8 of one side and no more of the other, to a pixel and the soft edge.
#[test]
fn what_is_visible_fills_the_picture() {
    let folder = tempfile::tempdir().unwrap();
    let plain = |stretched| vec![ball(IVec3::new(40, 7, -90), stretched)];
    let mut zeros = ball(IVec3::splat(20), DVec3::ONE);
    let box_of_zeros = grid("density", IVec3::splat(0), IVec3::splat(127), |v| {
        Some(if (v - 20).as_dvec3().length() < 10.0 { 1.0 } else { 0.0 })
    });
    zeros.blocks = box_of_zeros.blocks;
    let mut stray = ball(IVec3::ZERO, DVec3::ONE);
    let far = IVec3::new(4000, 800, 0);
    stray.blocks.extend(grid("density", far, far, |v| (v == far).then_some(1.0)).blocks);
    let cases = [
        ("ball", plain(DVec3::ONE)),
        ("rod", plain(DVec3::new(0.3, 2.0, 0.3))),
        ("plate", plain(DVec3::new(2.0, 0.3, 1.0))),
        ("zeros", vec![zeros]),
        ("stray", vec![stray]),
    ];
    for (name, grids) in cases {
        let path = file(folder.path(), &format!("{name}.vdb"), &grids);
        for (size, pixels) in
            [("128x72", [128.0, 72.0]), ("60x120", [60.0, 120.0]), ("96x96", [96.0; 2])]
        {
            let more = ["--size", size, "--density", "20", "--ground", "off", "--exposure", "0"];
            let extent = extent(&rendered(&path, ["1", "0"], &more));
            let filled = extent[0].max(extent[1]);
            let side = usize::from(extent[1] > extent[0]);
            let slack = 0.03 + 2.0 / pixels[side];
            assert!((filled - 0.8).abs() < slack, "{name} {size}: {extent:?}");
        }
    }
}

/// The scene that a bare render leaves, rendered, gives its picture: with flags, turned upright, of a
/// level set and of fire too.
#[test]
fn the_written_scene_renders_to_the_same_picture() {
    let folder = tempfile::tempdir().unwrap();
    let smoke = file(folder.path(), "a b.vdb", &[ball(IVec3::ZERO, DVec3::ONE)]);
    let hot = |v: IVec3| (v.length_squared() < 80).then(|| 0.2 + v.x.rem_euclid(5) as f32 / 5.0);
    let flames = grid("flames", IVec3::splat(-9), IVec3::splat(9), hot);
    let fire = file(folder.path(), "fire.vdb", &[ball(IVec3::ZERO, DVec3::ONE), flames]);
    let cases: [(&Path, &[&str]); 4] = [
        (&smoke, &[]),
        (
            &smoke,
            &[
                "--up",
                "z",
                "--look",
                "sky",
                "--ground",
                "on",
                "--set",
                "medium.0.albedo=[0.9,0.5,0.2]",
            ],
        ),
        (&fire, &["--seed", "7", "--director", "xs", "--set", "medium.0.emission.scale=3"]),
        (&smoke, &["--look", "none", "--exposure", "1", "--g", "0.6", "--orbit", "40"]),
    ];
    for (i, (path, flags)) in cases.into_iter().enumerate() {
        let name = |ending: &str| folder.path().join(format!("{i}.{ending}"));
        let small = ["--size", "40x30", "--rays", "2", "--photons", "3000", "--quiet"];
        let mut command = fogbow();
        command.arg("render").arg(path).args(small).args(flags);
        command.arg("-o").arg(name("exr")).arg("--write-scene").arg(name("toml"));
        command.assert().success();
        let mut again = fogbow();
        again.arg("render").arg(name("toml")).arg("--quiet").arg("-o").arg(name("again.exr"));
        again.assert().success();
        let read = |ending| read_layers(&name(ending)).unwrap().channels;
        assert_eq!(read("exr"), read("again.exr"), "{flags:?}");
        let png = |ending| std::fs::read(name(ending)).unwrap();
        assert_eq!(png("png"), png("again.png"), "{flags:?}");
        let text = std::fs::read_to_string(name("toml")).unwrap();
        let keys = text.lines().filter(|line| line.contains(" = "));
        assert!(
            keys.clone().count() > 10 && keys.clone().all(|line| line.contains("  # ")),
            "{text}"
        );
    }
}

/// Where lights, ground and medium stand for measurements: exactly one key and an even sky.
#[test]
fn the_look_for_measurements_is_one_key_and_an_even_sky() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(folder.path(), "smoke.vdb", &[ball(IVec3::ZERO, DVec3::ONE)]);
    let look = LookOptions { look: Some(Look::None), ..LookOptions::default() };
    let options = LoadOptions { look, ..LoadOptions::default() };
    let scene = Scene::load(&path, &options).unwrap();
    let text = scene.made.unwrap().draft.text();
    for line in [
        "irradiance = 5.0",
        "angle = 2.0",
        "radiance = [0.06, 0.08, 0.11]",
        "albedo = 0.95",
        "exposure = 0.0",
    ] {
        assert!(text.contains(line), "{line} is missing in\n{text}");
    }
    assert!(!text.contains("[[surface]]") && !text.contains("phase"), "{text}");
    assert_eq!(text.matches("[[light]]").count(), 2);
}

#[test]
fn a_line_says_what_a_bare_render_does() {
    let folder = tempfile::tempdir().unwrap();
    let ball = || ball(IVec3::ZERO, DVec3::ONE);
    let hot = |v: IVec3| (v.length_squared() < 80).then(|| 0.2 + v.x.rem_euclid(5) as f32 / 5.0);
    let around = |name: &str, value: &dyn Fn(IVec3) -> Option<f32>| {
        grid(name, IVec3::splat(-9), IVec3::splat(9), value)
    };
    let colors = ["Cd.x", "Cd.y", "Cd.z"].map(|name| around(name, &|v| hot(v).map(|x| 0.7 * x)));
    let says = |grids: &[GridToWrite]| summary(&file(folder.path(), "made.vdb", grids)).unwrap();
    assert_eq!(says(&[ball()]), "smoke, optical thickness 6, y up, 1.9 x 1.9 x 1.9 m");
    let fire = says(&[ball(), around("flames", &hot)]);
    assert_eq!(fire, "fire, optical thickness 4, glows by `flames`, y up, 1.9 x 1.9 x 1.9 m");
    let kelvin = says(&[ball(), around("temperature", &|v| hot(v).map(|x| 1500.0 * x))]);
    assert!(kelvin.contains("glows by `temperature` in kelvin"), "{kelvin}");
    let colored = says(&[&[ball()], &colors[..]].concat());
    assert!(colored.contains("coloured by `Cd`"), "{colored}");
    let mut up = around("vel", &|_| None);
    up.value_type = ValueType::Vec3;
    let values = (0..512).flat_map(|_| [0.1, -0.1, 2.0]).collect();
    up.blocks = vec![Block { origin: IVec3::ZERO, values, active: None }];
    let upright = says(&[ball(), up]);
    assert!(upright.contains(", z up, "), "{upright}");
}

/// A medium of Blender's, with z up, is seen as the same one with y up.
#[test]
fn z_up_is_turned_upright() {
    let folder = tempfile::tempdir().unwrap();
    let lean = |v: DVec3| (v - DVec3::new(2.0, 3.0, 0.0)).length() < 6.0 || v.length() < 4.0;
    let made = |name: &str, upright: &dyn Fn(DVec3) -> DVec3| {
        let grid = grid("density", IVec3::splat(-12), IVec3::splat(12), |v| {
            lean(upright(v.as_dvec3())).then_some(1.0)
        });
        file(folder.path(), name, &[grid])
    };
    let few = ["4", "0"];
    let y_up = rendered(&made("y.vdb", &|v| v), few, &["--size", "32x32", "--look", "none"]);
    let turned = made("z.vdb", &|v| DVec3::new(v.x, v.z, -v.y));
    let z_up = rendered(&turned, few, &["--size", "32x32", "--look", "none", "--up", "z"]);
    let name = "transmittance";
    for (a, b) in y_up.channels[name].iter().zip(&z_up.channels[name]) {
        assert!((a - b).abs() < 1e-3, "{a} and {b}");
    }
    let look = LookOptions { up: Some(UpAxis::X), ..LookOptions::default() };
    let options = LoadOptions { look, ..LoadOptions::default() };
    let scene = Scene::load(&turned, &options).unwrap();
    assert!(scene.made.unwrap().draft.text().contains("rotate = [0.0, 0.0, 90.0]"));
}

/// All frames of a sequence have the exposure of one of them, whichever are rendered.
#[test]
fn a_sequence_has_one_exposure() {
    let folder = tempfile::tempdir().unwrap();
    for frame in 1..=3 {
        let size = DVec3::splat(0.4 * f64::from(frame));
        file(folder.path(), &format!("puff_{frame:04}.vdb"), &[ball(IVec3::ZERO, size)]);
    }
    let exposures = |frames: &str, to: &str| {
        let small = ["--size", "32x32", "--rays", "1", "--photons", "2000", "--quiet", "--json"];
        let mut command = fogbow();
        command.current_dir(folder.path()).args(["render", "puff_####.vdb", "--frames", frames]);
        let output = command.args(["-o", to]).args(small).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let lines = String::from_utf8(output.stdout).unwrap();
        let reports = lines.lines().map(|line| serde_json::from_str(line).unwrap());
        reports
            .map(|json: serde_json::Value| json["settings"]["exposure"].clone())
            .collect::<Vec<_>>()
    };
    let all = exposures("1-3", "a_####.exr");
    assert_eq!(all.len(), 3);
    assert!(all.iter().all(|exposure| exposure.is_f64() && *exposure == all[0]), "{all:?}");
    assert_eq!(exposures("2", "b_####.exr"), [all[0].clone()]);
}

/// Frames from before the fire has caught have no grid of flames: they are rendered without.
#[test]
fn frames_may_lack_what_glows() {
    let folder = tempfile::tempdir().unwrap();
    let hot = |v: IVec3| (v.length_squared() < 80).then(|| 0.2 + v.x.rem_euclid(5) as f32 / 5.0);
    let flames = || grid("flames", IVec3::splat(-9), IVec3::splat(9), hot);
    file(folder.path(), "fire_1.vdb", &[ball(IVec3::ZERO, DVec3::ONE)]);
    file(folder.path(), "fire_2.vdb", &[ball(IVec3::ZERO, DVec3::ONE), flames()]);
    let sequence =
        Sequence::open(&folder.path().join("fire_#.vdb"), &LoadOptions::default()).unwrap();
    // Between two frames they catch fire by degrees.
    let hottest = |time: f64| {
        let scene = sequence.load(FrameTime::nearest(time).unwrap()).unwrap();
        match &scene.media.get(0).emission {
            Some(Emission::Ramped(ramped)) => ramped.grid().max_value(),
            None => 0.0,
            other => panic!("{other:?}"),
        }
    };
    let [none, some, all] = [1.0, 1.5, 2.0].map(hottest);
    assert!(none == 0.0 && (some / all - 0.5).abs() < 1e-6, "{none} {some} {all}");
}

/// What cannot be meant is told, and what can is not.
#[test]
fn what_cannot_be_meant_is_noted() {
    let folder = tempfile::tempdir().unwrap();
    let tepid = grid("temperature", IVec3::splat(-9), IVec3::splat(9), |v| Some(20.0 + v.x as f32));
    file(folder.path(), "puff.vdb", &[ball(IVec3::ZERO, DVec3::ONE), tepid]);
    let warned = |camera: &str, medium: &str| {
        let text = format!(
            "[camera]\nposition = {camera}\ntarget = [0, 0, 0]\n[[medium]]\nfile = \"puff.vdb\"\n{medium}\n"
        );
        let path = folder.path().join("scene.toml");
        std::fs::write(&path, text).unwrap();
        Scene::load(&path, &LoadOptions::default()).unwrap().warnings.join("\n")
    };
    assert_eq!(warned("[0, 0, 9]", "sigma_t = 3.0"), "");
    let cold = warned("[0, 0, 9]", "emission = { temperature = \"temperature\" }");
    assert!(cold.contains("medium[0].emission") && cold.contains("does not glow"), "{cold}");
    let hot = "emission = { temperature = \"temperature\", kelvin_scale = 50.0 }";
    assert_eq!(warned("[0, 0, 9]", hot), "");
    let thick = warned("[0, 0, 9]", "sigma_t = 1e5");
    assert!(thick.contains("medium[0].sigma_t") && thick.contains("mean free paths"), "{thick}");
    let inside = warned("[0, 0, 0.3]", "sigma_t = 500.0");
    assert!(inside.contains("camera.position") && inside.contains("solid"), "{inside}");
}
