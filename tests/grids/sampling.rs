//! Grids sampled and integrated, beside OpenVDB's own sampler and brute force.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use fogbow::math::{Index, IndexPoint, Point, Ray, Span, Stage, Stream};
use fogbow::vdb::{Block, Grid, GridToWrite, ReadAs, Tile, VdbFile};
use glam::{DAffine3, DMat3, DQuat, DVec3, IVec3};

use crate::common::{shared, written};

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder)
        .unwrap()
        .flat_map(|sub| std::fs::read_dir(sub.unwrap().path()).into_iter().flatten())
        .map(|file| file.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "vdb"))
        .collect();
    files.sort();
    files
}

/// The largest magnitude among the eight voxels round `p`: the scale that rounding in a blend of them
/// is relative to (`BoxSampler` blends in single precision).
fn scale(grid: &Grid<f32>, p: DVec3) -> f64 {
    let base = p.floor();
    (0..8)
        .map(|i| {
            let corner = IVec3::new(i >> 2, i >> 1 & 1, i & 1).as_dvec3();
            grid.value(IndexPoint::from_xyz(base + corner)).abs()
        })
        .fold(0.0, f64::max)
}

/// Random points a grid is compared at: of a part of one in 50,000 that is wrong, one in 150 such
/// comparisons would see nothing.
const POINTS: u64 = 250_000;

/// Compares `n` random points inside the bounds and a little around them, and all corner voxels.
fn compare(file: &VdbFile, index: usize, grid: &Grid<f32>, n: u64) {
    let (min, size) = if grid.bounds().is_empty() {
        (DVec3::splat(-20.0), DVec3::splat(40.0))
    } else {
        let b = grid.bounds().grown(9.0);
        (b.min.xyz, b.size())
    };
    let mut random = Stream::new(1, Stage::Test, index as u64, 0);
    let mut points: Vec<DVec3> = (0..n)
        .map(|_| min + size * DVec3::new(random.uniform(), random.uniform(), random.uniform()))
        .collect();
    for p in points.iter_mut().step_by(7) {
        *p = p.round(); // voxels themselves, and faces of cells
    }
    let theirs = file.box_sample(index, &points).unwrap();
    for (p, theirs) in points.into_iter().zip(theirs) {
        let ours = grid.value(IndexPoint::from_xyz(p));
        let off = (ours - theirs).abs();
        if off > 1e-6 * theirs.abs() {
            let name = file.grids()[index].label();
            assert!(off <= 1e-6 * scale(grid, p), "{name} at {p}: {ours} beside {theirs}");
        }
    }
}

#[test]
fn every_asset_samples_as_box_sampler_does() {
    let Some(folder) = shared("") else { return };
    for path in files(&folder) {
        let file = VdbFile::open(&path).unwrap();
        // Not those of integers, which BoxSampler blends in whole numbers.
        for i in (0..file.grids().len()).filter(|&i| file.grids()[i].value_type == "float") {
            let grid = file.read_scalar(i, ReadAs::Raw).unwrap();
            compare(&file, i, &grid, POINTS);
        }
    }
}

/// Smooth noise with holes, negative indices and a few tiles.
fn made(background: f32, tiles: bool) -> GridToWrite {
    let mut grid = GridToWrite::fog("density", 0.1, DVec3::ZERO);
    grid.background = [background, 0.0, 0.0];
    let mut random = Stream::new(7, Stage::Test, 0, 0);
    for x in -2..3 {
        for y in -2..2 {
            for z in -3..2 {
                if random.uniform() < 0.4 {
                    let values = (0..512).map(|_| random.uniform() as f32).collect();
                    let active = (random.uniform() < 0.5).then_some([0x5555_5555_5555_5555; 8]);
                    grid.blocks.push(Block { origin: IVec3::new(x, y, z) * 8, values, active });
                }
            }
        }
    }
    if tiles {
        let mut tile = |origin: [i32; 3], edge, value: f32, active| {
            let origin = IVec3::from(origin);
            grid.tiles.push(Tile { origin, edge, value: [value, 0.0, 0.0], active });
        };
        tile([24, 8, 8], 8, 0.75, true);
        tile([32, 8, 8], 8, 0.25, false);
        tile([128, 0, 0], 128, 0.5, true);
        tile([0, -128, 0], 128, 2.0, false);
        tile([-8192, 0, 0], 4096, 1.5, true);
    }
    grid
}

#[test]
fn made_grids_sample_as_box_sampler_does() {
    let mut only_tiles = made(0.0, true);
    only_tiles.blocks.clear();
    for grid in [made(0.0, false), made(0.0, true), made(0.3, true), only_tiles] {
        let (_folder, file) = written(&[grid]);
        let grid = file.read_scalar(0, ReadAs::Raw).unwrap();
        assert!(grid.memory_bytes() < 100 << 20, "{} bytes", grid.memory_bytes());
        compare(&file, 0, &grid, POINTS);
        // Points near the corners of tiles, which uniform points over a large box miss.
        let mut random = Stream::new(2, Stage::Test, 0, 0);
        let corners = [[24, 8, 8], [40, 16, 16], [128, 0, 0], [256, 128, 128], [-4096, 4096, 0]];
        let points: Vec<DVec3> = (0..200_000)
            .map(|i| {
                let corner = IVec3::from(corners[i % corners.len()]).as_dvec3();
                corner + DVec3::from_array(std::array::from_fn(|_| random.uniform() * 4.0 - 2.0))
            })
            .collect();
        for (p, theirs) in points.iter().zip(file.box_sample(0, &points).unwrap()) {
            let ours = grid.value(IndexPoint::from_xyz(*p));
            assert!((ours - theirs).abs() <= 1e-6 * scale(&grid, *p), "{p}: {ours} {theirs}");
        }
    }
}

#[test]
fn world_points_sample_as_box_sampler_does() {
    let turn = DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -0.7, 1.1);
    let scale = |x, y, z| DMat3::from_diagonal(DVec3::new(x, y, z));
    let matrices = [
        DMat3::from_quat(turn) * 0.1,
        scale(-0.1, 0.1, 0.1),
        scale(0.05, 0.2, 0.7),
        DMat3::from_quat(turn) * scale(0.05, -0.2, 0.7) * DMat3::from_quat(turn),
    ];
    for (i, matrix3) in matrices.into_iter().enumerate() {
        let mut grid = made([0.0, 0.3][i % 2], true);
        let to_world = DAffine3 { matrix3, translation: DVec3::new(5.0, -6.0, 7.0) };
        grid.transform = to_world;
        let (_folder, file) = written(&[grid]);
        let grid = file.read_scalar(0, ReadAs::Raw).unwrap();
        let to_index = to_world.inverse(); // of what was written, not of what was read
        let mut random = Stream::new(5, Stage::Test, i as u64, 0);
        let world: Vec<DVec3> = (0..POINTS)
            .map(|_| DVec3::from_array(std::array::from_fn(|_| random.uniform() * 60.0 - 30.0)))
            .map(|p| to_world.transform_point3(p))
            .collect();
        let index: Vec<DVec3> = world.iter().map(|&p| to_index.transform_point3(p)).collect();
        for (p, theirs) in world.into_iter().zip(file.box_sample(0, &index).unwrap()) {
            let local = grid.transform().point_to_local(Point::from_xyz(p));
            let off = (grid.value(local) - theirs).abs();
            if off > 1e-6 * theirs.abs() {
                assert!(off <= 1e-6 * self::scale(&grid, local.xyz), "{p}: {off} of {theirs}");
            }
        }
    }
}

fn direction(random: &mut Stream, i: usize) -> DVec3 {
    let mut d = fogbow::math::warp::uniform_sphere(random.uniform2());
    if i % 5 == 1 {
        d[i % 3] = 0.0;
    } else if i % 5 == 2 {
        d = DVec3::AXES[i % 3];
    }
    d * 10f64.powf(random.uniform() * 4.0 - 2.0)
}

#[test]
fn pieces_follow_one_another_and_sum_up() {
    let (_folder, file) = written(&[made(0.0, true)]);
    let grid = file.read_scalar(0, ReadAs::Density).unwrap();
    let mut random = Stream::new(3, Stage::Test, 0, 0);
    for i in 0..4000 {
        let scale = if i % 10 == 0 { 3000.0 } else { 30.0 };
        let mut origin =
            DVec3::from_array(std::array::from_fn(|_| (random.uniform() * 2.0 - 1.0) * scale));
        if i % 7 == 0 {
            origin = origin.round(); // on faces and edges
        }
        let d = direction(&mut random, i);
        let far = if i % 11 == 0 { 1e7 } else { 0.0 };
        let ray = Ray::<Index>::new(IndexPoint::from_xyz(origin - d * far), d);
        let span = if i % 2 == 0 {
            Span::new(f64::NEG_INFINITY, f64::INFINITY)
        } else {
            Span::new(far - 5.0, far + random.uniform() * 20.0)
        };
        let (mut sum, mut last) = (0.0, f64::NEG_INFINITY);
        let _ = grid.cells(&ray, span, |piece, integral, rise| {
            assert!(piece.start >= last && piece.end >= piece.start, "{piece:?} after {last}");
            assert!(integral.is_finite() && integral >= 0.0 && rise.is_finite());
            last = piece.end;
            sum += integral;
            ControlFlow::Continue(())
        });
        assert_eq!(sum, grid.integrate(&ray, span));
        let mut end = None;
        for segment in grid.bricks(&ray, span) {
            if let Some(end) = end {
                assert_eq!(segment.span.start, end);
            }
            end = Some(segment.span.end);
            for _ in 0..4 {
                let t = segment.span.start + segment.span.length() * random.uniform();
                let p = ray.at(t);
                let value = grid.value_in(segment.brick, p);
                let slack = 1e-6 + d.length() * far * 1e-14;
                assert!(value <= f64::from(segment.max), "{value} {segment:?}");
                assert!(value >= f64::from(segment.min), "{value} {segment:?}");
                assert!((value - grid.value(p)).abs() <= 1e-9 + 4.0 * slack, "{value} at {p:?}");
            }
        }
    }
}

#[test]
fn integrals_agree_with_brute_force() {
    for background in [0.0, 0.3] {
        let (_folder, file) = written(&[made(background, true)]);
        let grid = file.read_scalar(0, ReadAs::Density).unwrap();
        let mut random = Stream::new(4, Stage::Test, 0, 0);
        for i in 0..200 {
            let origin = DVec3::from_array(std::array::from_fn(|_| random.uniform() * 60.0 - 30.0));
            let d = direction(&mut random, i);
            let ray = Ray::<Index>::new(IndexPoint::from_xyz(origin), d);
            let length = 40.0 / d.length();
            let n = 40_000;
            let dt = length / f64::from(n);
            let inside = |p| if grid.bounds().contains(p) { grid.value(p) } else { 0.0 };
            let brute: f64 =
                (0..n).map(|k| inside(ray.at((f64::from(k) + 0.5) * dt))).sum::<f64>() * dt;
            let exact = grid.integrate(&ray, Span::new(0.0, length));
            // At the faces of the box, where values are cut off, brute force is off by up to a step.
            let cut = if grid.is_cut() { dt * f64::from(grid.max_inside()) } else { 0.0 };
            let limit = 1e-5 * (exact + 1e-3 * length) + cut;
            assert!((brute - exact).abs() <= limit, "{brute} {exact}");
            let (mut sum, mut count) = (0.0, 0);
            grid.samples(&ray, Span::new(0.0, length), 0.5 * dt, dt, |t, value| {
                assert!((value - grid.value(ray.at(t))).abs() < 1e-9);
                sum += value * dt;
                count += 1;
            });
            assert!(
                (sum - brute).abs() <= 1e-9 * brute.max(1e-9 * length) + 2.0 * dt,
                "{sum} {brute}"
            );
            assert!(count <= n);
        }
    }
}

#[test]
fn closed_forms() {
    // One tile of 8³ voxels with value 2 at 0..8: along x the value rises over one cell, is 2 for
    // seven, and falls over one.
    let mut grid = GridToWrite::fog("density", 1.0, DVec3::ZERO);
    grid.tiles.push(Tile { origin: IVec3::ZERO, edge: 8, value: [2.0, 0.0, 0.0], active: true });
    let (_folder, file) = written(&[grid]);
    let grid = file.read_scalar(0, ReadAs::Density).unwrap();
    let along = Ray::<Index>::new(IndexPoint::new(-50.0, 3.5, 4.0), DVec3::X * 0.5);
    assert!((grid.integrate(&along, Span::AHEAD) - 2.0 * 8.0 / 0.5).abs() < 1e-12);
    // Along a face of cells, half a cell outside the tile: half the value.
    let edge = Ray::<Index>::new(IndexPoint::new(-50.0, 7.5, 4.0), DVec3::X);
    assert!((grid.integrate(&edge, Span::AHEAD) - 8.0).abs() < 1e-12);
    // Diagonally in a linear ramp in x and y at a corner: the integral of 2 u² over a cell is 2/3.
    let corner = Ray::<Index>::new(IndexPoint::new(-1.0, -1.0, 4.0), DVec3::new(1.0, 1.0, 0.0));
    assert!((grid.integrate(&corner, Span::new(0.0, 1.0)) - 2.0 / 3.0).abs() < 1e-12);
    // Nothing ahead, nothing on the way, nothing at all.
    let away = Ray::<Index>::new(IndexPoint::new(-50.0, 3.5, 4.0), DVec3::NEG_X);
    assert_eq!(grid.integrate(&away, Span::AHEAD), 0.0);
    assert_eq!(grid.integrate(&along, Span::new(5.0, 5.0)), 0.0);
    let lost = Ray::<Index>::new(IndexPoint::new(f64::NAN, 0.0, 0.0), DVec3::X);
    assert_eq!(grid.integrate(&lost, Span::AHEAD), 0.0);
}
