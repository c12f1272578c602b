//! Rays and places against shapes: brute force, closed forms, far away and tiny.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use fogbow::math::{Ray, Span, Stage, Stream, WorldPoint, warp};
use fogbow::shape::{
    Bvh, ClosedMesh, Cuboid, Mesh, MeshData, Plane, Quad, Region, Shape, Sphere, load_mesh,
    offset_origin,
};
use glam::{DAffine3, DMat3, DVec3};
use proptest::prelude::*;

use crate::skip;

fn shared(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/meshes").join(name);
    if !path.exists() {
        skip::skip(path.display());
        return None;
    }
    Some(path)
}

fn shared_mesh(name: &str) -> Option<Arc<Mesh>> {
    let loaded = load_mesh(&shared(name)?, &DAffine3::IDENTITY).expect("a good mesh");
    Some(Arc::new(loaded.mesh))
}

/// A closed ball of triangles round `center`, with vertices on a sphere.
fn ball(center: DVec3, radius: f64, rings: u32) -> MeshData {
    let segments = 2 * rings;
    let mut data = MeshData::default();
    for ring in 0..=rings {
        for segment in 0..segments {
            let theta = std::f64::consts::PI * f64::from(ring) / f64::from(rings);
            let phi = 2.0 * std::f64::consts::PI * f64::from(segment) / f64::from(segments);
            let pole = ring == 0 || ring == rings;
            let sine = if pole { 0.0 } else { theta.sin() };
            let up = DVec3::new(sine * phi.cos(), theta.cos(), -sine * phi.sin());
            data.positions.push(center + up * radius);
        }
    }
    for ring in 0..rings {
        for segment in 0..segments {
            let at = |r: u32, s: u32| r * segments + s % segments;
            let [a, b] = [at(ring, segment), at(ring, segment + 1)];
            let [c, d] = [at(ring + 1, segment), at(ring + 1, segment + 1)];
            data.triangles.extend([[a, c, d], [a, d, b]]);
        }
    }
    data
}

/// Möller and Trumbore's test of every triangle, an independent code path.
fn brute_force(mesh: &Mesh, ray: &Ray<fogbow::math::World>) -> Option<f64> {
    (0..mesh.triangle_count() as u32)
        .filter_map(|i| {
            let [a, b, c] = mesh.corners(i);
            let (e1, e2) = (b - a, c - a);
            let p = ray.direction.cross(e2);
            let det = e1.dot(p);
            let s = (ray.origin.xyz - a) / det;
            let q = s.cross(e1);
            let (u, v, t) = (s.dot(p), ray.direction.dot(q), e2.dot(q));
            (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0).then_some(t)
        })
        .min_by(f64::total_cmp)
}

fn random_ray(stream: &mut Stream, center: DVec3, radius: f64) -> Ray<fogbow::math::World> {
    let from = center + warp::uniform_sphere(stream.uniform2()) * radius * 3.0;
    let to = center + warp::uniform_sphere(stream.uniform2()) * radius * stream.uniform();
    let speed = 10f64.powf(4.0 * stream.uniform() - 2.0);
    Ray::new(WorldPoint::from_xyz(from), (to - from).normalize() * speed)
}

#[test]
fn scanned_meshes_agree_with_brute_force() {
    for (name, rays) in [("bunny.obj", 120), ("dragon.obj", 120)] {
        let Some(mesh) = shared_mesh(name) else { continue };
        let bounds = mesh.bounds();
        let (center, radius) = (bounds.center().xyz, bounds.size().length() / 2.0);
        let bvh = Bvh::new(vec![Shape::Mesh(mesh.clone())]);
        let mut stream = Stream::new(1, Stage::Test, 0, 0);
        let mut hits = 0;
        for _ in 0..rays {
            let ray = random_ray(&mut stream, center, radius);
            let found = bvh.intersect(&ray, Span::AHEAD);
            let right = brute_force(&mesh, &ray);
            match (found, right) {
                (Some(hit), Some(t)) => {
                    let gap = (hit.t - t).abs() * ray.direction.length();
                    assert!(gap <= 1e-9 * radius, "{name}: {} {t}", hit.t);
                    assert!(ray.at(hit.t).xyz.distance(hit.point.xyz) <= 1e-9 * radius);
                    assert!((hit.normal.length() - 1.0).abs() < 1e-12);
                    hits += 1;
                }
                (None, None) => {}
                other => panic!("{name}: {ray:?} {other:?}"),
            }
            assert_eq!(bvh.occluded(&ray, Span::AHEAD), right.is_some());
            if let Some(t) = right {
                let before = Span::new(0.0, t * (1.0 - 1e-9));
                assert!(!bvh.occluded(&ray, before));
            }
        }
        assert!(hits > rays / 10, "{name}: {hits} hits");
    }
}

#[test]
fn nearest_agrees_with_brute_force() {
    let Some(mesh) = shared_mesh("spot.obj") else { return };
    let bvh = Bvh::new(vec![
        Shape::Mesh(mesh.clone()),
        Shape::Plane(Plane::new(WorldPoint::new(0.0, -3.0, 0.0), DVec3::Y).unwrap()),
    ]);
    let mut stream = Stream::new(2, Stage::Test, 0, 0);
    for _ in 0..60 {
        let p = warp::uniform_sphere(stream.uniform2()) * 2.0 * stream.uniform();
        let triangles = (0..mesh.triangle_count() as u32).map(|i| distance(p, mesh.corners(i)));
        let right = triangles.fold(p.y + 3.0, f64::min);
        let found = bvh.nearest(WorldPoint::from_xyz(p), f64::INFINITY).unwrap();
        assert!((found.distance - right).abs() < 1e-9, "{} {right}", found.distance);
        assert!((found.normal_toward_point.length() - 1.0).abs() < 1e-9);
        let place = WorldPoint::from_xyz(p);
        assert!(bvh.nearest(place, right * 0.999).is_none());
        assert!(bvh.nearest(place, right * 1.001).is_some());
    }
}

/// Distance to a triangle by its plane and its three edges.
fn distance(p: DVec3, corners: [DVec3; 3]) -> f64 {
    let [a, b, c] = corners;
    let n = (b - a).cross(c - a).normalize_or_zero();
    let foot = p - n * (p - a).dot(n);
    let inside =
        [(a, b), (b, c), (c, a)].iter().all(|(s, e)| (*e - s).cross(foot - s).dot(n) >= 0.0);
    let edge = |s: DVec3, e: DVec3| {
        let d = e - s;
        let t = ((p - s).dot(d) / d.length_squared()).clamp(0.0, 1.0);
        p.distance(s + d * t)
    };
    let edges = edge(a, b).min(edge(b, c)).min(edge(c, a));
    if inside && n != DVec3::ZERO { edges.min(p.distance(foot)) } else { edges }
}

#[test]
fn rays_at_edges_and_corners_never_leak() {
    for (center, radius) in [(DVec3::ZERO, 1.0), (DVec3::splat(1e7), 1.0), (DVec3::ZERO, 1e-6)] {
        let data = ball(center, radius, 12);
        let mesh = Arc::new(Mesh::new(data.clone(), &DAffine3::IDENTITY).unwrap());
        assert!(mesh.is_closed() && mesh.is_oriented());
        let bvh = Bvh::new(vec![Shape::Mesh(mesh.clone())]);
        let region = Region::Mesh(ClosedMesh::new(mesh).unwrap());
        let mut stream = Stream::new(3, Stage::Test, 0, 0);
        let mut spans = Vec::new();
        for triangle in &data.triangles {
            let [a, b, c] = triangle.map(|i| data.positions[i as usize]);
            for target in [a, a + (b - a) * stream.uniform(), a + (c - a) * stream.uniform()] {
                let from = center + warp::uniform_sphere(stream.uniform2()) * radius * 0.5;
                let ray = Ray::new(WorldPoint::from_xyz(from), target - from);
                let hit = bvh.intersect(&ray, Span::AHEAD);
                assert!(hit.is_some_and(|h| (h.t - 1.0).abs() < 0.2), "{from} {target}");
                spans.clear();
                region.spans(&ray, Span::AHEAD, |s| spans.push(s));
                assert_eq!(spans.len(), 1, "{from} {target}");
                assert!(spans[0].start == 0.0 && (spans[0].end - 1.0).abs() < 0.2);
            }
        }
    }
}

#[test]
fn axis_rays_through_a_cube_of_triangles_count_each_edge_once() {
    let mut data = MeshData::default();
    for i in 0..8 {
        let bit = |b: i32| f64::from(i / b % 2);
        data.positions.push(DVec3::new(bit(1), bit(2), bit(4)));
    }
    for [a, b, c, d] in
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    {
        data.triangles.extend([[a, b, c], [a, c, d]]);
    }
    let mesh = Arc::new(Mesh::new(data, &DAffine3::IDENTITY).unwrap());
    let region = Region::Mesh(ClosedMesh::new(mesh).unwrap());
    assert!((region.volume().unwrap() - 1.0).abs() < 1e-12);
    let steps = [0.0, 0.25, 0.5, 0.75, 1.0];
    for axis in DVec3::AXES {
        for (x, y) in steps.iter().flat_map(|x| steps.map(|y| (*x, y))) {
            let start = DVec3::new(x, y, -1.0);
            let origin = if axis.x == 1.0 {
                DVec3::new(start.z, start.x, start.y)
            } else if axis.y == 1.0 {
                DVec3::new(start.x, start.z, start.y)
            } else {
                start
            };
            for (origin, direction) in [(origin, axis), (origin + axis * 3.0, -axis)] {
                let mut spans = Vec::new();
                let ray = Ray::new(WorldPoint::from_xyz(origin), direction);
                region.spans(&ray, Span::AHEAD, |s| spans.push(s));
                let inside = x > 0.0 && x < 1.0 && y > 0.0 && y < 1.0;
                assert!(spans.len() == 1 || (!inside && spans.is_empty()), "{ray:?} {spans:?}");
                for span in spans {
                    assert_eq!((span.start, span.end), (1.0, 2.0));
                }
            }
        }
    }
}

#[test]
fn spans_agree_with_contains() {
    let sheared = DAffine3::from_mat3_translation(
        DMat3::from_cols(DVec3::new(1.0, 0.2, 0.0), DVec3::new(0.4, 2.0, 0.1), DVec3::Z * 0.5),
        DVec3::new(0.2, -0.1, 0.3),
    );
    let mesh = Arc::new(Mesh::new(ball(DVec3::ZERO, 1.0, 10), &sheared).unwrap());
    let mut regions = vec![
        Region::Box(Cuboid::new(DVec3::NEG_ONE, DVec3::ONE, &sheared).unwrap()),
        Region::Sphere(Sphere::new(DVec3::ZERO, 1.0, &sheared).unwrap()),
        Region::Mesh(ClosedMesh::new(mesh).unwrap()),
    ];
    if let Some(spot) = shared_mesh("spot.obj") {
        regions.push(Region::Mesh(ClosedMesh::new(spot).unwrap()));
    }
    let mut stream = Stream::new(4, Stage::Test, 0, 0);
    for region in regions {
        let bounds = region.bounds().unwrap();
        let (mut inside, mut all) = (0, 0);
        for _ in 0..300 {
            let ray = random_ray(&mut stream, bounds.center().xyz, bounds.size().length() * 0.2);
            let mut spans = Vec::new();
            region.spans(&ray, Span::AHEAD, |s| spans.push(s));
            assert!(spans.windows(2).all(|w| w[0].end <= w[1].start));
            for _ in 0..5 {
                let t = stream.uniform() * 4.0 * bounds.size().length() / ray.direction.length();
                let near = |x: f64| (t - x).abs() < 1e-9 * t.max(1.0);
                if spans.iter().any(|s| near(s.start) || near(s.end)) {
                    continue;
                }
                let within = spans.iter().any(|s| t > s.start && t < s.end);
                assert_eq!(within, region.contains(ray.at(t)), "{ray:?} {t} {spans:?}");
                inside += usize::from(within);
                all += 1;
            }
        }
        assert!(inside > all / 20);
    }
}

#[test]
fn volumes_match_closed_forms() {
    let stretch = DAffine3::from_scale(DVec3::new(1.0, 2.0, -3.0));
    let sphere = Sphere::new(DVec3::ONE, 0.5, &stretch).unwrap();
    let right = 4.0 / 3.0 * std::f64::consts::PI * 0.125 * 6.0;
    assert!((Region::Sphere(sphere).volume().unwrap() - right).abs() < 1e-12 * right);
    let cuboid = Cuboid::new(DVec3::ZERO, DVec3::ONE, &stretch).unwrap();
    assert!((Region::Box(cuboid).volume().unwrap() - 6.0).abs() < 1e-12);
    let mesh = Mesh::new(ball(DVec3::ZERO, 0.5, 100), &stretch).unwrap();
    let volume = Region::Mesh(ClosedMesh::new(Arc::new(mesh)).unwrap()).volume().unwrap();
    assert!((volume / right - 1.0).abs() < 2e-3, "{volume} {right}");
    assert!(Region::Everywhere.volume().is_none() && Region::Everywhere.bounds().is_none());
}

#[test]
fn an_open_mesh_bounds_nothing() {
    let mut data = ball(DVec3::ZERO, 1.0, 4);
    data.triangles.pop();
    let mesh = Arc::new(Mesh::new(data, &DAffine3::IDENTITY).unwrap());
    assert!(ClosedMesh::new(mesh).unwrap_err().contains("not closed"));
}

#[test]
fn ellipsoid_hits_satisfy_its_equation() {
    let half = DVec3::new(1.0, 0.25, 3.0);
    let turned = DAffine3::from_rotation_z(0.7) * DAffine3::from_scale(half);
    let sphere = Sphere::new(DVec3::ZERO, 1.0, &turned).unwrap();
    let mut lengths = sphere.half_lengths().to_array();
    lengths.sort_by(f64::total_cmp);
    assert!(lengths.iter().zip([0.25, 1.0, 3.0]).all(|(a, b)| (a - b).abs() < 1e-12));
    let bvh = Bvh::new(vec![Shape::Sphere(sphere)]);
    let mut stream = Stream::new(5, Stage::Test, 0, 0);
    for _ in 0..1000 {
        let inside = turned.transform_point3(warp::uniform_sphere(stream.uniform2()) * 0.5);
        let ray =
            Ray::new(WorldPoint::from_xyz(inside), warp::uniform_sphere(stream.uniform2()) * 7.0);
        let hit = bvh.intersect(&ray, Span::AHEAD).expect("a ray from inside leaves");
        let local = turned.inverse().transform_point3(hit.point.xyz);
        assert!((local.length() - 1.0).abs() < 1e-12);
        assert!(ray.at(hit.t).xyz.distance(hit.point.xyz) < 1e-12);
        let gradient = DAffine3::from_rotation_z(0.7).transform_vector3(local / half).normalize();
        assert!(gradient.distance(hit.normal) < 1e-9 && hit.normal.dot(ray.direction) > 0.0);
        let near = bvh.nearest(ray.origin, 10.0).unwrap();
        assert!(near.distance <= hit.t * 7.0 + 1e-12);
    }
}

#[test]
fn hits_keep_their_precision_far_away_and_tiny() {
    for (center, radius) in [(DVec3::new(1e7, -1e7, 1e7), 1.0), (DVec3::ZERO, 1e-6)] {
        let mut stream = Stream::new(6, Stage::Test, 0, 0);
        let noise = 1e-6 * radius;
        let quad =
            Quad::new(WorldPoint::from_xyz(center), DVec3::X * radius, DVec3::Y * radius).unwrap();
        let solid = DVec3::splat(radius);
        let shapes = [
            Shape::Sphere(Sphere::new(center, radius, &DAffine3::IDENTITY).unwrap()),
            Shape::Box(Cuboid::new(center - solid, center + solid, &DAffine3::IDENTITY).unwrap()),
            Shape::Mesh(Arc::new(
                Mesh::new(ball(center, radius, 20), &DAffine3::IDENTITY).unwrap(),
            )),
            Shape::Quad(quad),
        ];
        for shape in shapes {
            let bvh = Bvh::new(vec![shape.clone()]);
            for _ in 0..200 {
                let target = center + warp::uniform_sphere(stream.uniform2()) * radius * 0.3;
                let target =
                    if matches!(shape, Shape::Quad(_)) { target.with_z(center.z) } else { target };
                let from = center + warp::uniform_sphere(stream.uniform2()) * radius * 50.0;
                let ray = Ray::new(WorldPoint::from_xyz(from), target - from);
                let hit = bvh.intersect(&ray, Span::AHEAD).expect("aimed at the shape");
                assert!(ray.at(hit.t).xyz.distance(hit.point.xyz) < noise, "{shape:?}");
                // A ray that leaves on the near side does not meet the same place again.
                let back = -ray.direction;
                let origin = offset_origin(hit.point, hit.error, hit.normal, back);
                assert!(origin.xyz.distance(hit.point.xyz) < noise);
                assert!(!bvh.occluded(&Ray::new(origin, back), Span::AHEAD), "{shape:?}");
                let onward = offset_origin(hit.point, hit.error, hit.normal, ray.direction);
                let next = bvh.intersect(&Ray::new(onward, ray.direction), Span::AHEAD);
                assert_eq!(next.is_none(), matches!(shape, Shape::Quad(_)));
                let length = ray.direction.length();
                assert!(next.is_none_or(|n| n.t * length > 1e-4 * radius));
            }
        }
    }
}

#[test]
fn an_infinite_plane_stands_beside_the_tree() {
    let plane = Plane::new(WorldPoint::new(0.0, -1.0, 0.0), DVec3::Y * 3.0).unwrap();
    let sphere = Sphere::new(DVec3::ZERO, 0.5, &DAffine3::IDENTITY).unwrap();
    let bvh = Bvh::new(vec![Shape::Plane(plane), Shape::Sphere(sphere)]);
    assert_eq!(bvh.bounds().max.xyz, DVec3::splat(0.5));
    let down = Ray::new(WorldPoint::new(0.0, 5.0, 0.0), DVec3::NEG_Y);
    let hit = bvh.intersect(&down, Span::AHEAD).unwrap();
    assert_eq!((hit.shape, hit.t), (1, 4.5));
    let hit = bvh.intersect(&down, Span::new(5.6, 10.0)).unwrap();
    assert_eq!((hit.shape, hit.t, hit.normal), (0, 6.0, DVec3::Y));
    assert!(bvh.intersect(&down, Span::new(5.6, 6.0)).is_none(), "the span is open");
    assert!(Bvh::new(Vec::new()).bounds().is_empty());
    assert!(!Bvh::new(Vec::new()).occluded(&down, Span::AHEAD));
}

#[test]
fn a_mirrored_mesh_keeps_its_outside() {
    let mirror = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    let mesh = Mesh::new(ball(DVec3::ZERO, 1.0, 8), &mirror).unwrap();
    let bvh = Bvh::new(vec![Shape::Mesh(Arc::new(mesh))]);
    let ray = Ray::new(WorldPoint::new(0.1, 0.2, 5.0), DVec3::NEG_Z);
    assert!(bvh.intersect(&ray, Span::AHEAD).unwrap().normal.z > 0.0);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn random_soup_agrees_with_brute_force(
        seed in 0u64..1_000_000,
        count in 1u32..40,
        exponent in -6.0..7.0f64,
    ) {
        let scale = 10f64.powf(exponent);
        let mut stream = Stream::new(seed, Stage::Test, 7, 0);
        let mut data = MeshData::default();
        for i in 0..count {
            let middle = warp::uniform_sphere(stream.uniform2()) * scale;
            for _ in 0..3 {
                let away = warp::uniform_sphere(stream.uniform2()) * 0.5 * scale;
                data.positions.push(middle + away);
            }
            data.triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
        }
        let mesh = Arc::new(Mesh::new(data, &DAffine3::IDENTITY).unwrap());
        let bvh = Bvh::new(vec![Shape::Mesh(mesh.clone())]);
        for _ in 0..20 {
            let ray = random_ray(&mut stream, DVec3::ZERO, scale);
            let (found, right) = (bvh.intersect(&ray, Span::AHEAD), brute_force(&mesh, &ray));
            prop_assert_eq!(found.is_some(), right.is_some());
            if let (Some(hit), Some(t)) = (found, right) {
                prop_assert!((hit.t - t).abs() <= 1e-9 * t);
            }
        }
    }

    #[test]
    fn the_nearest_point_of_an_ellipsoid_is_nearest(
        half in prop::array::uniform3(0.05..3.0f64),
        p in prop::array::uniform3(-4.0..4.0f64),
        flat in 0usize..8,
    ) {
        let half = DVec3::from(half);
        // Points on the planes and axes of symmetry are the hard ones.
        let p = DVec3::from(std::array::from_fn::<f64, 3, _>(|i| {
            if flat >> i & 1 == 1 { 0.0 } else { p[i] }
        }));
        let sphere = Sphere::new(DVec3::ZERO, 1.0, &DAffine3::from_scale(half)).unwrap();
        let bvh = Bvh::new(vec![Shape::Sphere(sphere)]);
        let near = bvh.nearest(WorldPoint::from_xyz(p), f64::INFINITY).unwrap();
        let foot = p - near.normal_toward_point * near.distance;
        prop_assert!(((foot / half).length() - 1.0).abs() < 1e-6);
        let mut stream = Stream::new(8, Stage::Test, 0, 0);
        for _ in 0..500 {
            let other = warp::uniform_sphere(stream.uniform2()) * half;
            prop_assert!(other.distance(p) >= near.distance - 1e-9);
        }
    }
}
