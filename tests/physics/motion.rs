//! Motion blur against means of many sharp pictures.

use std::path::Path;

use fogbow::image::Film;
use fogbow::render::{Silent, render, render_reference};
use fogbow::scene::{RenderSettings, Scene};
use fogbow::vdb::{Block, GridToWrite, ValueType, write};
use glam::{DVec3, IVec3};

use crate::pictures::{Mean, ROUNDING, scene};

/// Width of a film in pixels, and of a block of it that is compared.
const WIDTH: usize = 16;
const BLOCK: usize = 4;

/// What the mean of a block may be off in standard errors of 16 values: by chance once in 40000, and once in 2000 of any of
/// the 16 blocks of a picture.
const ERRORS: f64 = 6.0;

/// Edge of a voxel in metres; of files beside Cycles, whose voxels should not be seen.
const VOXEL: f64 = 0.125;
const FINE: f64 = 0.05;

/// Three channels of what is at places in metres.
type Field = fn(DVec3) -> [f32; 3];

/// A grid of what `field` has within 2 m of the origin along each axis.
fn grid(name: &str, voxel: f64, is_vector: bool, field: Field) -> GridToWrite {
    let mut grid = GridToWrite::fog(name, voxel, DVec3::ZERO);
    if is_vector {
        (grid.value_type, grid.class) = (ValueType::Vec3, "unknown".into());
    }
    let half = (2.0 / voxel / 8.0).round() as i32;
    let blocks = -half..half;
    for x in blocks.clone() {
        for (y, z) in blocks.clone().flat_map(|y| blocks.clone().map(move |z| (y, z))) {
            let origin = IVec3::new(x, y, z) * 8;
            let at = |slot: i32| origin + IVec3::new(slot >> 6, slot >> 3 & 7, slot & 7);
            let values = (0..512).map(|slot| field(at(slot).as_dvec3() * voxel));
            let count = if is_vector { 3 } else { 1 };
            let values: Vec<f32> = values.flat_map(|v| v.into_iter().take(count)).collect();
            if values.iter().any(|v| *v != 0.0) {
                grid.blocks.push(Block { origin, values, active: None });
            }
        }
    }
    grid
}

/// A ball of smoke around a place beside the origin, and a smaller one above it.
fn smoke(p: DVec3) -> [f32; 3] {
    let ball = |center: DVec3, radius: f64| {
        (1.0 - (p - center).length_squared() / (radius * radius)).max(0.0)
    };
    [
        (ball(DVec3::new(0.5, 0.0, 0.0), 0.6) + ball(DVec3::new(-0.5, 0.4, 0.0), 0.5)) as f32,
        0.0,
        0.0,
    ]
}

/// Metres a second.
const WIND: DVec3 = DVec3::new(0.9, 0.5, 0.0);

/// Radians a second about the z axis.
const SPIN: f64 = 0.8;

fn files(folder: &Path, voxel: f64) {
    let wind: Field = |_| WIND.as_vec3().to_array();
    let spin: Field = |p| (DVec3::Z.cross(p) * SPIN).as_vec3().to_array();
    for (name, field) in [("wind", wind), ("spin", spin)] {
        let grids = [grid("density", voxel, false, smoke), grid("vel", voxel, true, field)];
        write(&folder.join(format!("{name}.vdb")), &grids).unwrap();
    }
}

/// A camera, smoke of `file`, and a lamp that is nearer to some of its places than to others.
fn lamp_lit(file: &str, camera: &str, smoke: &str) -> String {
    format!(
        r#"
        [camera]
        position = [0.0, 0.0, 6.0]
        target = [0.0, 0.0, 0.0]
        fov = 32.0
        {camera}
        [film]
        size = [{WIDTH}, {WIDTH}]
        [[light]]
        type = "point"
        position = [1.4, 1.4, 0.0]
        power = 100.0
        [[medium]]
        file = "{file}.vdb"
        sigma_t = 3.0
        albedo = 0.8
        {smoke}
        "#
    )
}

/// `text` with a shutter that is open for a frame of a second around that of the scene.
fn blurred(text: &str, times: u32) -> String {
    format!("{text}\n[motion]\nshutter = 1.0\nfps = 1\ntimes = {times}\n")
}

/// Mean radiance of each block.
fn blocks(film: &Film) -> Vec<f64> {
    let layer = film.layer("G").unwrap();
    let of = |left: usize, top: usize| {
        let pixels = (0..BLOCK * BLOCK).map(|i| (top + i / BLOCK) * WIDTH + left + i % BLOCK);
        pixels.map(|pixel| f64::from(layer[pixel])).sum::<f64>() / (BLOCK * BLOCK) as f64
    };
    let at = |i: usize| of(i % (WIDTH / BLOCK) * BLOCK, i / (WIDTH / BLOCK) * BLOCK);
    (0..(WIDTH / BLOCK).pow(2)).map(at).collect()
}

/// How a picture is made of a scene with a seed.
type Method = fn(&Scene, u64) -> Film;

const REFERENCE: Method =
    |scene, seed| render_reference(scene, &RenderSettings { seed, ..scene.render }, &Silent).film;
const PHOTONS: Method =
    |scene, seed| render(scene, &RenderSettings { seed, ..scene.render }, &Silent).unwrap().film;

/// The means of blocks of 16 films.
fn means(film: impl Fn(u64) -> Film) -> Vec<Mean> {
    let films: Vec<_> = (0..16).map(|seed| blocks(&film(seed))).collect();
    let block = |i: usize| Mean::of(&films.iter().map(|film| film[i]).collect::<Vec<_>>());
    (0..films[0].len()).map(block).collect()
}

/// Pictures of `moving`, blurred over `times`, are the means of those of what `still` is at each, but for noise and a part
/// `bias` of the brightest block; and of what blur changes, summed over all blocks, a share of at most `missing` is not there. A
/// sharp picture, of which all is missing, would not agree.
fn agree(
    folder: &Path,
    method: Method,
    (rays, photons, times): (u32, u64, u32),
    moving: &str,
    still: impl Fn(f64) -> String,
    [bias, missing]: [f64; 2],
) {
    let moving = scene(folder, &blurred(moving, times), rays * 8, photons);
    assert_eq!(moving.times.len(), times as usize);
    let ours = means(|seed| method(&moving, seed));
    let middle = |k: u32| (f64::from(k) + 0.5) / f64::from(times) - 0.5;
    let scenes: Vec<_> =
        (0..times).map(|k| scene(folder, &still(middle(k)), rays, photons)).collect();
    // Each of 16 means has all times, and seeds of its own.
    let theirs = (0..16_u64).map(|set| {
        let films = scenes.iter().enumerate();
        let films = films.map(|(k, scene)| blocks(&method(scene, 1000 + set * 64 + k as u64)));
        let sum = films.reduce(|a, b| a.iter().zip(b).map(|(a, b)| a + b).collect());
        sum.unwrap().into_iter().map(|v| v / f64::from(times)).collect::<Vec<f64>>()
    });
    let theirs: Vec<_> = theirs.collect();
    let sharp = scene(folder, &still(0.0), rays * 8, photons);
    let sharp = means(|seed| method(&sharp, 100 + seed));
    let brightest = ours.iter().map(|mean| mean.value).fold(0.0, f64::max);
    // Sums of products with what blur changes: of that itself, of what is missing, and the variance of this.
    let [mut blur, mut lost, mut variance] = [0.0; 3];
    for (i, (ours, sharp)) in ours.into_iter().zip(sharp).enumerate() {
        let theirs = Mean::of(&theirs.iter().map(|set| set[i]).collect::<Vec<_>>());
        let squares = ours.error.powi(2) + theirs.error.powi(2);
        let off = ours.value - theirs.value;
        let bound = ERRORS * squares.sqrt() + bias * brightest + ROUNDING;
        assert!(off.abs() <= bound, "block {i}: {ours:?} not {theirs:?}: {off} above {bound}");
        let change = sharp.value - theirs.value;
        // The noise of the mean is in both factors.
        blur += change.powi(2) - sharp.error.powi(2) - theirs.error.powi(2);
        lost += off * change - theirs.error.powi(2);
        variance += squares * change.powi(2);
    }
    let (share, noise) = (lost / blur, ERRORS * variance.sqrt() / blur);
    assert!(noise > 0.0 && missing + noise < 0.8, "too much noise: {noise}");
    assert!(share.abs() < missing + noise, "{share} of the blur is missing, above {noise}");
}

/// Writes the files of tests/check/motion.sh.
#[test]
#[ignore = "tests/check/motion.sh runs it"]
fn the_files_beside_cycles() {
    files(Path::new(&std::env::var("FOGBOW_FOLDER").unwrap()), FINE);
}

/// A wind moves smoke past a lamp: 64 pictures of it at other places.
#[test]
fn wind_blurs_as_moved_smoke_does() {
    let folder = tempfile::tempdir().unwrap();
    files(folder.path(), VOXEL);
    let still = |t: f64| {
        let [x, y, z] = (WIND * t).to_array();
        lamp_lit("wind", "", &format!("translate = [{x}, {y}, {z}]"))
    };
    let moving = lamp_lit("wind", "", "");
    agree(folder.path(), REFERENCE, (2, 1000, 64), &moving, still, [0.0; 2]);
    agree(folder.path(), PHOTONS, (2, 4000, 4), &moving, still, [0.02, 0.25]);
}

/// A vortex turns smoke: 64 pictures of it turned. Voxels that are made anew are a little smoother.
#[test]
fn a_vortex_blurs_as_turned_smoke_does() {
    let folder = tempfile::tempdir().unwrap();
    files(folder.path(), VOXEL);
    let still = |t: f64| {
        let turned = format!("rotate = [0.0, 0.0, {}]", (1.5 * SPIN * t).to_degrees());
        lamp_lit("spin", "", &turned)
    };
    let moving = lamp_lit("spin", "", "velocity_scale = 1.5");
    agree(folder.path(), REFERENCE, (4, 1000, 64), &moving, still, [0.02, 0.25]);
}

#[test]
fn cameras_blur_as_moved_ones_do() {
    let folder = tempfile::tempdir().unwrap();
    files(folder.path(), VOXEL);
    let next = "next = { position = [0.8, 0.0, 6.0], target = [0.8, 0.0, 0.0] }";
    let moving = lamp_lit("wind", next, "velocity = 'none'");
    let still = |t: f64| {
        let x = 0.8 * t;
        lamp_lit("wind", "", "")
            .replace("position = [0.0, 0.0, 6.0]", &format!("position = [{x}, 0.0, 6.0]"))
            .replace("target = [0.0, 0.0, 0.0]", &format!("target = [{x}, 0.0, 0.0]"))
    };
    agree(folder.path(), REFERENCE, (2, 1000, 64), &moving, still, [0.0; 2]);
    // A camera that turns by 8 degrees.
    let angle = 8.0_f64.to_radians();
    let target = |t: f64| {
        let turned = angle * t;
        [6.0 * turned.sin(), 0.0, 6.0 - 6.0 * turned.cos()]
    };
    let next = format!("next = {{ target = {:?} }}", target(1.0));
    let moving = lamp_lit("wind", &next, "velocity = 'none'");
    let still = |t: f64| {
        lamp_lit("wind", "", "")
            .replace("target = [0.0, 0.0, 0.0]", &format!("target = {:?}", target(t)))
    };
    agree(folder.path(), PHOTONS, (2, 4000, 4), &moving, still, [0.02, 0.25]);
}

/// A box that moves and turns casts its shadow into fog: as a placed box, and as a mesh of which two frames are known.
#[test]
fn surfaces_blur_as_moved_ones_do() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    files(folder, VOXEL);
    std::fs::write(
        folder.join("a.obj"),
        "v -0.5 -0.5 -0.3\nv 0.5 -0.5 -0.3\nv 0.5 0.5 -0.3\nv -0.5 0.5 -0.3\nf 1 2 3\nf 1 3 4\n",
    )
    .unwrap();
    std::fs::write(
        folder.join("b.obj"),
        "v 1.1 -0.5 -0.3\nv 2.1 -0.5 -0.3\nv 2.1 0.5 -0.3\nv 1.1 0.5 -0.3\nf 1 2 3\nf 1 3 4\n",
    )
    .unwrap();
    let with = |surface: &str| {
        lamp_lit("wind", "", "velocity = 'none'") + &format!("[[surface]]\n{surface}\n")
    };
    let cube = "shape = 'box'\nmin = [-0.4, -0.4, -0.2]\nmax = [0.4, 0.4, 0.2]\n";
    let moving = with(&format!(
        "{cube}motion = {{ translate = [0.9, 0.0, 0.4], rotate = [0.0, 0.0, 90.0] }}\n"
    ));
    let still = |t: f64| {
        let (x, z, angle) = (0.9 * t, 0.4 * t, 90.0 * t);
        with(&format!("{cube}translate = [{x}, 0.0, {z}]\nrotate = [0.0, 0.0, {angle}]\n"))
    };
    agree(folder, REFERENCE, (4, 1000, 16), &moving, still, [0.0; 2]);
    agree(folder, PHOTONS, (2, 4000, 4), &moving, still, [0.02, 0.25]);
    let moving = with("shape = 'mesh'\nfile = 'a.obj'\nnext_file = 'b.obj'\n");
    let still = |t: f64| {
        with(&format!("shape = 'mesh'\nfile = 'a.obj'\ntranslate = [{}, 0.0, 0.0]\n", 1.6 * t))
    };
    agree(folder, REFERENCE, (4, 1000, 16), &moving, still, [0.0; 2]);
}

/// The bytes of all layers of a film.
fn bytes(film: &Film) -> Vec<u32> {
    ["R", "G", "B", "A", "Z"]
        .iter()
        .flat_map(|name| film.layer(name).unwrap().iter().map(|v| v.to_bits()).collect::<Vec<_>>())
        .collect()
}

/// Pictures are the same on any number of threads, in halves and as passes too.
#[test]
fn threads_change_nothing() {
    let folder = tempfile::tempdir().unwrap();
    files(folder.path(), VOXEL);
    let text = blurred(&lamp_lit("spin", "", ""), 4);
    let on = |threads: usize, more: &str| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let text = format!("{text}\n[render]\n{more}\n");
        pool.install(|| {
            let scene = scene(folder.path(), &text, 8, 2000);
            bytes(&render(&scene, &scene.render, &Silent).unwrap().film)
        })
    };
    for more in ["", "reconstruct = true"] {
        assert_eq!(on(1, more), on(3, more), "{more}");
    }
}

/// A shutter that is closed, or before which nothing moves, changes no bit.
#[test]
fn without_motion_nothing_changes() {
    let folder = tempfile::tempdir().unwrap();
    files(folder.path(), VOXEL);
    let picture = |text: &str, warnings: usize| {
        let scene = scene(folder.path(), text, 8, 2000);
        assert_eq!(scene.warnings.len(), warnings, "{:?}", scene.warnings);
        assert!(scene.times.is_empty());
        bytes(&render(&scene, &scene.render, &Silent).unwrap().film)
    };
    let sharp = picture(&lamp_lit("wind", "", ""), 0);
    let closed = lamp_lit("wind", "", "") + "[motion]\nshutter = 0.0\nfps = 25\n";
    assert_eq!(picture(&closed, 0), sharp);
    let still = lamp_lit("wind", "", "velocity = 'none'") + "[motion]\nshutter = 0.5\n";
    assert_eq!(picture(&still, 1), sharp);
}
