//! Grids whose background is not 0: a medium inside [min - 1, max + 1] of the active voxels, vacuum
//! outside, whichever way it is asked.
//!
//! Seeds are fixed. Each comparison of a mean allows 4.5 standard errors: one false alarm in 150,000.

use std::f64::consts::PI;

use fogbow::math::{IndexPoint, Ray, Rgb, Span, Stage, Stream, World, WorldPoint, luminance};
use fogbow::medium::{Albedo, Density, Emission, EmissionSampler, Media, Medium, Phase, Profile};
use fogbow::render::{Rendered, Silent, render, render_reference};
use fogbow::scene::{LoadOptions, Scene};
use fogbow::vdb::{Block, Grid, GridToWrite, ReadAs, Tile, VdbFile, write};
use fogbow::work::Work;
use glam::{DAffine3, DQuat, DVec3, IVec3};

use crate::common::written;

const SIGMAS: f64 = 4.5;
const VOXEL: f64 = 0.1;

/// Smallest and largest active voxel along each axis.
const ACTIVE: [i32; 2] = [-3, 17];

/// Edge of the medium, in metres.
const EDGE: f64 = 22.0 * VOXEL;

/// 21³ active voxels of `value(voxel)` amid a background; what is inactive beside them has the
/// value `beside`.
fn amid(background: f32, beside: f32, value: impl Fn(IVec3) -> f32) -> GridToWrite {
    let mut grid = GridToWrite::fog("density", VOXEL, DVec3::ZERO);
    grid.background = [background, 0.0, 0.0];
    let turn = DQuat::from_axis_angle(DVec3::new(0.36, 0.48, 0.8), 0.7);
    let translation = DVec3::new(0.3, -0.2, 0.1);
    grid.transform =
        DAffine3::from_scale_rotation_translation(DVec3::splat(VOXEL), turn, translation);
    for corner in 0..64 {
        let origin = (IVec3::new(corner >> 4, corner >> 2 & 3, corner & 3) - 1) * 8;
        let voxel = |i: i32| origin + IVec3::new(i >> 6, i >> 3 & 7, i & 7);
        let is_active = |v: IVec3| {
            v.cmpge(IVec3::splat(ACTIVE[0])).all() && v.cmple(IVec3::splat(ACTIVE[1])).all()
        };
        let at = |v: IVec3| if is_active(v) { value(v) } else { beside };
        let mut active = [0u64; 8];
        for i in (0..512).filter(|&i| is_active(voxel(i))) {
            active[i as usize / 64] |= 1 << (i % 64);
        }
        let values = (0..512).map(|i| at(voxel(i))).collect();
        grid.blocks.push(Block { origin, values, active: Some(active) });
    }
    grid
}

/// The same value everywhere.
fn even(value: f32) -> GridToWrite {
    amid(value, value, |_| value)
}

fn read(grid: &GridToWrite) -> Grid<f32> {
    let (_folder, file) = written(std::slice::from_ref(grid));
    file.read_scalar(0, ReadAs::Density).unwrap()
}

fn medium(grid: Grid<f32>, sigma_t: f64, emission: Option<Emission>) -> Medium {
    Medium {
        density: Density::Voxel(grid),
        sigma_t: Rgb::splat(sigma_t),
        albedo: Albedo::Constant(Rgb::splat(0.5)),
        phase: Phase::ISOTROPIC,
        emission,
    }
}

/// Rays from outside and from inside, in index space, with the length in metres that they have
/// inside the medium, worked out by slabs.
fn rays(grid: &Grid<f32>) -> Vec<(Ray<World>, Span, f64)> {
    let far = Span::AHEAD;
    [
        ([-30.0, 4.0, 5.0], [1.0, 0.02, -0.05], far),
        ([7.0, 40.0, 6.0], [0.0, -1.0, 0.0], far),
        ([7.0, 8.0, 6.0], [0.3, 0.5, -0.4], far),
        ([-3.5, -3.7, -3.9], [-1.0, 0.4, 0.2], far),
        ([-20.0, -19.0, -21.0], [1.0, 1.0, 1.0], Span::new(2.0, 4.0)),
        ([-20.0, -19.0, 60.0], [1.0, 1.0, 1.0], far),
    ]
    .map(|(origin, direction, span): ([f64; 3], [f64; 3], Span)| {
        let transform = grid.transform();
        let origin = transform.point_to_world(IndexPoint::from_xyz(DVec3::from(origin)));
        let direction = transform.vector_to_world(DVec3::from(direction).normalize()).normalize();
        let ray = Ray::new(origin, direction);
        let local = transform.ray_to_local(&ray);
        let (mut start, mut end) = (span.start, span.end);
        for axis in 0..3 {
            let [low, high] = [f64::from(ACTIVE[0]) - 1.0, f64::from(ACTIVE[1]) + 1.0];
            let at = |face: f64| (face - local.origin.xyz[axis]) / local.direction[axis];
            let (a, b) = (at(low), at(high));
            (start, end) = (start.max(a.min(b)), end.min(a.max(b)));
        }
        (ray, span, (end - start).max(0.0))
    })
    .into()
}

#[test]
fn light_is_weakened_over_the_box_of_active_voxels() {
    const N: u32 = 20_000;
    for (background, sigma_t) in [(1.0f32, 0.8), (0.001, 700.0)] {
        let grid = read(&even(background));
        assert_eq!(grid.background_inside(), Some(background));
        assert!(grid.is_cut());
        let media = Media::new(vec![medium(grid.clone(), sigma_t, None)]);
        let density = &media.get(0).density;
        for (index, (ray, span, length)) in (0..).zip(rays(&grid)) {
            let tau = sigma_t * f64::from(background) * length;
            let exact = media.optical_thickness(&ray, span).x;
            assert!((exact - tau).abs() < 1e-9 * (1.0 + tau), "ray {index}: {exact} for {tau}");
            for step in [0.5 * VOXEL, 7.0 * VOXEL, 100.0] {
                for jitter in [0.0, 0.3, 0.99] {
                    let mut profile: Profile = Profile::default();
                    profile.trace(&media, &ray, span, step, jitter);
                    let found = profile.optical_thickness().x;
                    let near = (found - tau).abs() < 1e-9 * (1.0 + tau);
                    assert!(near, "ray {index}, step {step}: {found} for {tau}");
                }
            }
            let mut rng = Stream::new(3, Stage::Test, index, 0);
            let free = (0..N).filter(|_| {
                let mut flights = media.flights(&ray, span, Rgb::ONE, &mut rng);
                while let Some(c) = flights.next(&mut rng) {
                    let p = ray.at(c.t);
                    assert!(density.majorant(p) * sigma_t <= c.region_majorant * (1.0 + 1e-12));
                    if rng.uniform() * c.majorant < sigma_t * c.density {
                        return false;
                    }
                }
                true
            });
            let (found, expected) = (free.count() as f64 / f64::from(N), (-tau).exp());
            let error = (expected * (1.0 - expected) / f64::from(N)).sqrt();
            assert!((found - expected).abs() <= SIGMAS * error, "ray {index}: {found}, {expected}");
            let mut work = Work::default();
            let ratio = |rng: &mut Stream, work: &mut Work| -> f64 {
                media.ratio_tracking(&ray, span, rng, work)
            };
            let sum: f64 = (0..N).map(|_| ratio(&mut rng, &mut work)).sum();
            let off = sum / f64::from(N) - expected;
            assert!(off.abs() <= SIGMAS * error + 1e-9, "ray {index}: {off} of {expected}");
        }
    }
}

/// Bounds, volume and all that is told of a medium follow the box.
#[test]
fn the_medium_is_that_box() {
    let grid = read(&even(0.25));
    let (low, high) = (f64::from(ACTIVE[0]) - 1.0, f64::from(ACTIVE[1]) + 1.0);
    assert_eq!(grid.bounds().min.xyz, DVec3::splat(low));
    assert_eq!(grid.bounds().max.xyz, DVec3::splat(high));
    assert_eq!(grid.occupied_volume(), 22f64.powi(3));
    assert_eq!(grid.max_inside(), 0.25);
    let mut volume = 0.0;
    grid.for_each_occupied(|cells| {
        assert!(grid.bounds().contains(cells.min) && grid.bounds().contains(cells.max));
        volume += cells.size().element_product();
    });
    assert_eq!(volume, 22f64.powi(3));
    let mut voxels = 0;
    grid.for_each_nonzero(|block| {
        voxels += (block.max - block.min + 1).element_product();
        assert_eq!(block.value, 0.25);
    });
    assert_eq!(voxels, 23i32.pow(3));
    let density = Density::Voxel(grid.clone());
    assert!((density.volume().unwrap() / EDGE.powi(3) - 1.0).abs() < 1e-12);
    let at = |x: f64| grid.transform().point_to_world(IndexPoint::new(x, 5.0, 5.0));
    for (x, value) in
        [(low + 0.01, 0.25), (high - 0.01, 0.25), (low - 0.01, 0.0), (high + 0.01, 0.0)]
    {
        assert_eq!(density.value(at(x)), value, "{x}");
        assert_eq!(density.majorant(at(x)), value, "{x}");
    }
}

/// The same of voxels of many values, tiles far off and inactive values beyond the active ones.
#[test]
fn inside_the_box_every_value_counts_and_beyond_none() {
    let noise =
        |v: IVec3| (v.as_vec3().dot(glam::Vec3::new(12.9, 78.2, 37.7)).sin() * 43.7).fract();
    let mut cases = [
        amid(0.5, 2.0, |v| noise(v).abs()),
        amid(0.0, 2.0, |v| noise(v).abs()),
        amid(0.25, 0.0, |v| noise(v).abs()),
        amid(0.3, 0.3, |v| noise(v).abs()),
    ];
    let tile =
        |origin, edge, value, active| Tile { origin, edge, value: [value, 0.0, 0.0], active };
    cases[0].tiles.push(tile(IVec3::new(128, 0, 0), 128, 0.5, false));
    cases[3].tiles.push(tile(IVec3::new(-4096, 0, 0), 4096, 0.125, true));
    for (case, to_write) in cases.iter().enumerate() {
        let (_folder, file) = written(std::slice::from_ref(to_write));
        let grid = file.read_scalar(0, ReadAs::Density).unwrap();
        assert!(grid.is_cut(), "case {case}");
        let [min, max] = grid.statistics().bounds.unwrap().map(|v| IVec3::from(v).as_dvec3());
        let inside = |p: DVec3| p.cmpge(min - 1.0).all() && p.cmple(max + 1.0).all();
        let mut rng = Stream::new(8, Stage::Test, case as u64, 0);
        let points: Vec<DVec3> = (0..20_000)
            .map(|_| DVec3::from(std::array::from_fn(|_| rng.uniform() * 40.0 - 12.0)))
            .collect();
        let density = Density::Voxel(grid.clone());
        for (p, theirs) in points.iter().zip(file.box_sample(0, &points).unwrap()) {
            let expected = if inside(*p) { theirs } else { 0.0 };
            let found = density.value(grid.transform().point_to_world(IndexPoint::from_xyz(*p)));
            assert!((found - expected).abs() < 1e-6 * 2.0, "case {case}, {p}: {found}, {expected}");
        }
        for pair in points.chunks(2).take(40) {
            let direction = pair[1] - pair[0];
            let ray = Ray::new(IndexPoint::from_xyz(pair[0]), direction);
            const STEPS: u32 = 20_000;
            let at = |i: u32| pair[0] + direction * ((f64::from(i) + 0.5) / f64::from(STEPS));
            let value =
                |p: DVec3| if inside(p) { grid.value(IndexPoint::from_xyz(p)) } else { 0.0 };
            let brute = (0..STEPS).map(|i| value(at(i))).sum::<f64>() / f64::from(STEPS);
            let found = grid.integrate(&ray, Span::new(0.0, 1.0));
            assert!((found - brute).abs() < 3e-4, "case {case}: {found} for {brute}");
        }
    }
}

/// Voxels all of which are inactive are no medium, nor is a background alone.
#[test]
fn without_active_voxels_there_is_no_medium() {
    let mut alone = even(1.0);
    alone.blocks.clear();
    let mut inactive = amid(0.0, 2.0, |_| 1.0);
    inactive.blocks.iter_mut().for_each(|block| block.active = Some([0; 8]));
    for to_write in [alone, inactive] {
        let grid = read(&to_write);
        assert!(grid.bounds().is_empty());
        assert_eq!((grid.background_inside(), grid.max_inside()), (None, 0.0));
        let ray = Ray::new(IndexPoint::new(-9.0, 3.0, 3.0), DVec3::X);
        assert_eq!(grid.integrate(&ray, Span::AHEAD), 0.0);
        let density = Density::Voxel(grid);
        assert_eq!(density.value(WorldPoint::new(0.3, 0.0, 0.0)), 0.0);
        assert_eq!(density.volume(), Some(0.0));
    }
}

#[test]
fn photons_leave_all_of_a_glowing_box() {
    const N: u32 = 40_000;
    let color = Rgb::new(2.0, 1.0, 0.25);
    let cases = [
        medium(read(&even(1.0)), 1.0, Some(Emission::Density(color))),
        medium(read(&even(0.5)), 1.0, Some(Emission::Grid { grid: read(&even(1.0)), color })),
    ];
    let expected = color * (4.0 * PI * EDGE.powi(3));
    for (index, medium) in (0..).zip(&cases) {
        let sampler = EmissionSampler::new(medium).unwrap().unwrap();
        let mut rng = Stream::new(4, Stage::Test, index, 0);
        let mut draw = || sampler.emit(medium, &mut rng).map_or(0.0, |s| luminance(s.power));
        let powers: Vec<f64> = (0..N).map(|_| draw()).collect();
        let mean = powers.iter().sum::<f64>() / f64::from(N);
        let variance = powers.iter().map(|p| (p - mean).powi(2)).sum::<f64>() / f64::from(N);
        let error = (variance / f64::from(N)).sqrt();
        let off = mean - luminance(expected);
        assert!(off.abs() <= SIGMAS * error, "{index}: {mean} off by {off}, error {error}");
        // Each of the 23³ voxels whose hats reach into the box counts whole; the density of places is
        // that of the medium inside, and what lies beyond the faces emits nothing.
        let share = sampler.power() / luminance(expected);
        assert!((share / (23.0f64 / 22.0).powi(3) - 1.0).abs() < 1e-6, "{index}: {share}");
    }
}

/// Pictures of 8 x 8 pixels by photon map and by the reference.
fn pictures(to_write: &GridToWrite, text: &str) -> [Rendered; 2] {
    let folder = tempfile::tempdir().unwrap();
    write(&folder.path().join("box.vdb"), std::slice::from_ref(to_write)).unwrap();
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, text).unwrap();
    let scene = Scene::load(&path, &LoadOptions::default()).unwrap();
    let reference = render_reference(&scene, &scene.render, &Silent);
    [render(&scene, &scene.render, &Silent).unwrap(), reference]
}

fn mean(rendered: &Rendered, layer: &str) -> f64 {
    let values = rendered.film.layer(layer).unwrap();
    values.iter().map(|v| f64::from(*v)).sum::<f64>() / values.len() as f64
}

/// The same box, not turned, seen straight on: every ray of the camera crosses all of it.
fn straight(background: f32) -> GridToWrite {
    let transform = DAffine3::from_scale_rotation_translation(
        DVec3::splat(VOXEL),
        DQuat::IDENTITY,
        DVec3::splat(-0.7),
    );
    GridToWrite { transform, ..even(background) }
}

#[test]
fn pictures_of_a_box_are_opaque_as_the_closed_form_says() {
    for (background, sigma_t) in [(1.0f32, 0.5), (0.001, 500.0)] {
        for z in [9.0, 0.0] {
            let length = if z > EDGE { EDGE } else { 0.5 * EDGE };
            let text = format!(
                "camera = {{ type = 'orthographic', position = [0.1, 0.0, {z:?}], \
                 target = [0.1, 0.0, -9.0], height = 1.0 }}\nfilm = {{ size = [8, 8] }}\n\
                 render = {{ rays = 64, photons = 1000 }}\n[[medium]]\nfile = 'box.vdb'\n\
                 sigma_t = {sigma_t:?}\nalbedo = 0.5\n\
                 [[light]]\ntype = 'sun'\ndirection = [0, -1, 0]\nirradiance = 1.0\n"
            );
            let expected = 1.0 - (-sigma_t * f64::from(background) * length).exp();
            let [mapped, reference] = pictures(&straight(background), &text);
            let found = mean(&mapped, "A");
            assert!((found - expected).abs() < 1e-5, "from {z}: A is {found} for {expected}");
            // 8 x 8 x 64 rays, each opaque or not.
            let error = (expected * (1.0 - expected) / 4096.0).sqrt();
            let found = mean(&reference, "A");
            assert!((found - expected).abs() <= SIGMAS * error, "from {z}: A is {found}");
        }
    }
}

/// Against the same box without voxels, by photon map and by the reference, and 1, as a white medium
/// is not seen in a furnace.
#[test]
fn a_box_in_a_furnace_is_as_bright_as_a_region() {
    for (position, albedo) in
        [("[0.3, 0.4, 4.0]", 1.0), ("[0.3, 0.2, 0.1]", 1.0), ("[0.3, 0.2, 0.1]", 0.6)]
    {
        let text = |density: &str| {
            format!(
                "camera = {{ position = {position}, target = [0.0, 0.0, -0.5], fov = 30.0 }}\n\
                 film = {{ size = [8, 8] }}\nrender = {{ rays = 64, photons = 60000 }}\n\
                 [[medium]]\n{density}\nsigma_t = 2.0\nalbedo = {albedo:?}\n\
                 [[light]]\ntype = 'environment'\nradiance = 1.0\n"
            )
        };
        let region = "region = { box = { min = [-1.1, -1.1, -1.1], max = [1.1, 1.1, 1.1] } }";
        let found = pictures(&straight(1.0), &text("file = 'box.vdb'")).map(|r| mean(&r, "G"));
        let expected = pictures(&straight(1.0), &text(region)).map(|r| mean(&r, "G"));
        let told = format!("from {position}, albedo {albedo}: {found:?} for {expected:?}");
        for (found, expected) in found.into_iter().zip(expected) {
            // The noise of 4096 paths, and of photons, is 0.5 %.
            assert!((found / expected - 1.0).abs() < 0.025, "{told}");
            assert!(albedo < 1.0 || (found - 1.0).abs() < 0.05, "{told}");
        }
        assert!((found[0] / found[1] - 1.0).abs() < 0.05, "{told}");
    }
}

/// Grids that are no medium are not cut.
#[test]
fn attributes_have_their_background_outside() {
    let (_folder, file): (_, VdbFile) = written(&[amid(300.0, 300.0, |_| 1000.0)]);
    let grid = file.read_scalar(0, ReadAs::Density).unwrap();
    assert_eq!(grid.value(IndexPoint::new(500.0, 0.0, 0.0)), 300.0);
    assert_eq!(grid.value(IndexPoint::new(5.0, 5.0, 5.0)), 1000.0);
}
