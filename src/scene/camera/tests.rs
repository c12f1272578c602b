use std::f64::consts::PI;

use super::*;

const SIZE: [u32; 2] = [64, 48];
const PINHOLE: Projection =
    Projection::Perspective { fov: 60.0, aperture: 0.0, focus: None, shift: [0.0; 2] };

fn pose() -> Pose {
    Pose { position: DVec3::new(1.0, 2.0, 7.0), target: DVec3::new(-1.0, 0.5, 0.0), up: DVec3::Y }
}

fn camera(projection: Projection) -> Camera {
    Camera::new(&pose(), &projection, SIZE).unwrap()
}

fn all() -> [Projection; 4] {
    [
        PINHOLE,
        Projection::Perspective { fov: 60.0, aperture: 0.3, focus: None, shift: [0.0; 2] },
        Projection::Orthographic { height: 3.0, shift: [0.0; 2] },
        Projection::LatLong,
    ]
}

#[test]
fn the_middle_of_the_film_looks_at_the_target() {
    for projection in all() {
        let ray = camera(projection).ray(32.0, 24.0, [0.2, 0.9]);
        let to_target = pose().target - ray.origin.xyz;
        let miss = ray.direction.cross(to_target).length();
        assert!(miss < 1e-12, "{projection:?} misses by {miss}");
        assert!((ray.direction.length() - 1.0).abs() < 1e-14);
    }
}

#[test]
fn the_film_stands_upright_and_is_not_mirrored() {
    for projection in all() {
        let camera = camera(projection);
        let [right, up, _] = pose().axes().unwrap();
        let (a, b) = (camera.ray(40.0, 10.0, [0.5; 2]), camera.ray(32.0, 24.0, [0.5; 2]));
        let moved = a.at(1.0) - b.at(1.0);
        assert!(moved.dot(right) > 0.0 && moved.dot(up) > 0.0, "{projection:?}");
    }
}

#[test]
fn fov_spans_the_width() {
    let camera = camera(PINHOLE);
    let (a, b) = (camera.ray(0.0, 24.0, [0.5; 2]), camera.ray(64.0, 24.0, [0.5; 2]));
    assert!((a.direction.angle_between(b.direction).to_degrees() - 60.0).abs() < 1e-9);
    let (a, b) = (camera.ray(32.0, 0.0, [0.5; 2]), camera.ray(32.0, 48.0, [0.5; 2]));
    let expected = 2.0 * ((30f64.to_radians().tan()) * 0.75).atan();
    assert!((a.direction.angle_between(b.direction) - expected).abs() < 1e-12);
}

#[test]
fn a_thin_lens_is_sharp_at_the_focus_distance() {
    let projection =
        Projection::Perspective { fov: 40.0, aperture: 0.2, focus: Some(3.0), shift: [0.0; 2] };
    let camera = camera(projection);
    let at_depth = |lens, depth: f64| {
        let ray = camera.ray(10.0, 5.0, lens);
        ray.at(depth / ray.direction.dot(camera.forward())).xyz
    };
    let lenses = [[0.0, 0.0], [1.0, 0.3], [0.4, 0.8], [0.5, 0.5]];
    for lens in lenses {
        assert!(at_depth(lens, 3.0).distance(at_depth([0.5; 2], 3.0)) < 1e-12);
    }
    assert!(at_depth([0.0, 0.0], 6.0).distance(at_depth([0.5; 2], 6.0)) > 0.05);
    let farthest = lenses.iter().map(|&l| camera.ray(0.0, 0.0, l).origin.xyz);
    assert!(farthest.map(|o| o.distance(pose().position)).all(|r| r <= 0.1 + 1e-12));
}

/// Solid angle of pixel (i, j) from its corner directions, as two spherical triangles
/// (Van Oosterom and Strackee 1983).
fn solid_angle(camera: &Camera, i: f64, j: f64) -> f64 {
    let d = |x, y| camera.ray(x, y, [0.5; 2]).direction;
    let triangle = |a: DVec3, b: DVec3, c: DVec3| {
        let down = 1.0 + a.dot(b) + b.dot(c) + c.dot(a);
        2.0 * a.dot(b.cross(c)).abs().atan2(down)
    };
    let (a, b, c, e) = (d(i, j), d(i + 1.0, j), d(i + 1.0, j + 1.0), d(i, j + 1.0));
    triangle(a, b, c) + triangle(a, c, e)
}

#[test]
fn pixels_cover_the_right_solid_angle() {
    let sum = |camera: &Camera| -> f64 {
        (0..48)
            .flat_map(|j| (0..64).map(move |i| (f64::from(i), f64::from(j))))
            .map(|(i, j)| solid_angle(camera, i, j))
            .sum()
    };
    // A rectangle of half sides a and b at distance 1 covers 4 atan(a b / sqrt(1 + a² + b²)).
    let a = 30f64.to_radians().tan();
    let b = a * 0.75;
    let expected = 4.0 * (a * b / (1.0 + a * a + b * b).sqrt()).atan();
    assert!((sum(&camera(PINHOLE)) - expected).abs() < 1e-9);
    // Great circles between the corners of latitude-longitude pixels cut a little off each.
    assert!((sum(&camera(Projection::LatLong)) / (4.0 * PI) - 1.0).abs() < 2e-3);
}

#[test]
fn orthographic_height_is_the_height() {
    let camera = camera(Projection::Orthographic { height: 3.0, shift: [0.0; 2] });
    let (a, b) = (camera.ray(0.0, 0.0, [0.5; 2]), camera.ray(0.0, 48.0, [0.5; 2]));
    assert!((a.origin.xyz.distance(b.origin.xyz) - 3.0).abs() < 1e-12);
    assert_eq!(a.direction, b.direction);
}

#[test]
fn degenerate_poses_are_refused() {
    let at = |position, target, up| Camera::new(&Pose { position, target, up }, &PINHOLE, SIZE);
    assert!(at(DVec3::X, DVec3::X, DVec3::Y).is_none());
    assert!(at(DVec3::X, DVec3::ZERO, DVec3::X).is_none());
    assert!(at(DVec3::X, DVec3::ZERO, DVec3::ZERO).is_none());
}

#[test]
fn extreme_places_give_finite_unit_directions() {
    for scale in [1e-9, 1.0, 1e9, 1e15] {
        let pose = Pose {
            position: DVec3::new(3.0, 1.0, -2.0) * scale,
            target: DVec3::new(-1.0, 4.0, 5.0) * scale,
            up: DVec3::Y * scale,
        };
        for projection in all() {
            let camera = Camera::new(&pose, &projection, [65_536, 1]).unwrap();
            for x in [0.0, 1.0, 65_536.0] {
                let ray = camera.ray(x, 0.5, [0.0, 1.0]);
                assert!((ray.direction.length() - 1.0).abs() < 1e-12 && ray.origin.xyz.is_finite());
            }
        }
    }
}

/// A ray of a shifted film is the ray of the film without a shift, so many widths of the picture farther.
#[test]
fn a_shifted_film_shows_the_same_view_elsewhere() {
    let shift = [0.3, -0.2];
    let kinds = [
        Projection::Perspective { fov: 60.0, aperture: 0.0, focus: None, shift },
        Projection::Perspective { fov: 60.0, aperture: 0.3, focus: None, shift },
        Projection::Orthographic { height: 3.0, shift },
    ];
    for (shifted, plain) in kinds.into_iter().zip(all()) {
        for (x, y) in [(0.0, 0.0), (12.5, 40.0), (32.0, 24.0)] {
            let [a, b] = [[0.5; 2], [0.1, 0.7]].map(|lens| {
                let there = camera(shifted).ray(x, y, lens);
                let here = camera(plain).ray(x + 0.3 * 64.0, y + 0.2 * 64.0, lens);
                (there.origin.xyz - here.origin.xyz).length()
                    + (there.direction - here.direction).length()
            });
            assert!(a < 1e-12 && b < 1e-12, "{shifted:?}: {a} {b}");
        }
    }
}

/// Rays begin and end on two planes square to the view, or on two spheres, and lie on those of a camera that sees
/// everything.
#[test]
fn a_clipped_camera_sees_between_two_planes() {
    let clip = [1.5, 4.0];
    for projection in all() {
        let whole = camera(projection);
        let clipped = whole.clipped(Some(clip));
        for (x, y, lens) in [(3.0, 5.0, [0.5; 2]), (60.0, 40.0, [0.9, 0.2])] {
            let (ray, other) = (clipped.ray(x, y, lens), whole.ray(x, y, lens));
            assert_eq!(ray.direction, other.direction);
            assert!((ray.origin - other.at(clipped.near(&ray))).length() < 1e-12);
            let along = |t: f64| {
                let from = ray.at(t) - other.origin;
                match projection {
                    Projection::LatLong => from.length(),
                    _ => from.dot(whole.forward()),
                }
            };
            assert!((along(0.0) - clip[0]).abs() < 1e-12, "{projection:?}");
            assert!((along(clipped.end(&ray)) - clip[1]).abs() < 1e-12, "{projection:?}");
        }
        let ray = whole.ray(3.0, 5.0, [0.5; 2]);
        assert_eq!((whole.near(&ray), whole.end(&ray)), (0.0, f64::INFINITY));
    }
}
