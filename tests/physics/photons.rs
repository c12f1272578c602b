//! The photon maps against brute force, and their order on one and two threads.

use fogbow::math::{Ray, Rgb, Span, Stage, Stream, World, WorldPoint, warp};
use fogbow::photon::{BeamHit, BeamMap, Photon, PhotonAt, PhotonMap};
use glam::DVec3;

fn stream(index: u64) -> Stream {
    Stream::new(11, Stage::Test, index, 0)
}

/// Photons at `places`, each with its number as power.
fn numbered(places: impl IntoIterator<Item = [f32; 3]>) -> Vec<PhotonAt> {
    let photon = |(i, place)| {
        let power = Rgb::new(f64::from(i), 1.0, 1.0);
        PhotonAt { place, photon: Photon::new(power, DVec3::Z) }
    };
    (0u32..).zip(places).map(photon).collect()
}

fn number(photon: &Photon) -> usize {
    photon.power().x as usize
}

fn random_places(n: usize, index: u64) -> Vec<[f32; 3]> {
    let mut rng = stream(index);
    (0..n).map(|_| std::array::from_fn(|_| (rng.uniform() * 2.0 - 1.0) as f32)).collect()
}

/// What maps are tried on; coordinates up to 1 m from the origin.
fn clouds() -> Vec<(&'static str, Vec<PhotonAt>)> {
    let random = random_places(3000, 0);
    let plane = random.iter().map(|&[x, y, _]| [x, y, 0.25]);
    let line = random.iter().take(500).map(|&[x, _, _]| [x, -0.5, 0.25]);
    let heaps = random.iter().take(8).flat_map(|&place| [place; 100]);
    let mixed = random.iter().copied().chain([[0.125; 3]; 200]);
    vec![
        ("none", Vec::new()),
        ("one", numbered([[0.1, 0.2, 0.3]])),
        ("two", numbered([[0.1, 0.2, 0.3], [-0.1, 0.2, 0.3]])),
        ("random", numbered(random.clone())),
        ("coplanar", numbered(plane)),
        ("collinear", numbered(line)),
        ("33 on one place", numbered([[0.5, -0.5, 0.5]; 33])),
        ("1000 on the origin", numbered([[0.0; 3]; 1000])),
        ("heaps", numbered(heaps)),
        ("a heap among others", numbered(mixed)),
    ]
}

/// World origins of the maps.
fn origins() -> [WorldPoint; 2] {
    [WorldPoint::new(0.0, 0.0, 0.0), WorldPoint::new(1e7, -1e7, 3e6)]
}

fn place(origin: WorldPoint, photon: &PhotonAt) -> WorldPoint {
    origin + DVec3::from(photon.place.map(f64::from))
}

#[test]
fn gathers_within_a_radius_find_what_brute_force_finds() {
    for (name, photons) in clouds() {
        for origin in origins() {
            let map = PhotonMap::new(origin, &photons);
            assert_eq!((map.len(), map.is_empty()), (photons.len(), photons.is_empty()));
            let mut rng = stream(1);
            for query in 0..60 {
                let p = match photons.get(query * 7) {
                    Some(photon) if query % 2 == 0 => place(origin, photon),
                    _ => origin + (warp::uniform_sphere(rng.uniform2()) * 1.5 * rng.uniform()),
                };
                let radius = [0.01, 0.1, 0.4, 4.0][query % 4];
                let mut found = vec![0; photons.len()];
                map.within(p, radius, |photon, distance2| {
                    let expected = (place(origin, &photons[number(photon)]) - p).length_squared();
                    assert!((distance2 - expected).abs() < 1e-6 * (1.0 + expected), "{name}");
                    found[number(photon)] += 1;
                });
                for (photon, times) in photons.iter().zip(found) {
                    let distance = (place(origin, photon) - p).length();
                    let borderline = (distance - radius).abs() < 1e-5;
                    let expected = u32::from(distance < radius);
                    assert!(borderline || times == expected, "{name}: {times} at {distance}");
                }
            }
        }
    }
}

#[test]
fn the_distance_to_the_nearest_is_that_of_brute_force() {
    for (name, photons) in clouds() {
        for origin in origins() {
            let map = PhotonMap::new(origin, &photons);
            let mut rng = stream(2);
            for _ in 0..20 {
                let p = origin + warp::uniform_sphere(rng.uniform2()) * 1.5 * rng.uniform();
                let mut distances: Vec<f64> =
                    photons.iter().map(|photon| (place(origin, photon) - p).length()).collect();
                distances.sort_by(f64::total_cmp);
                assert_eq!(map.distance_to_nearest(p, 0), None);
                for k in [1, 2, 10, 33, 5000] {
                    let expected = distances.get(k.min(distances.len()).wrapping_sub(1));
                    match (map.distance_to_nearest(p, k), expected) {
                        (Some(found), Some(expected)) => {
                            assert!((found - expected).abs() < 1e-5, "{name}, {k}: {found}");
                        }
                        (found, expected) => assert_eq!(found, expected.copied(), "{name}, {k}"),
                    }
                }
            }
        }
    }
}

/// Random rays through the cloud, rays along the axes through photons, rays that miss.
fn rays(origin: WorldPoint, photons: &[PhotonAt], from: f64) -> Vec<Ray<World>> {
    let mut rng = stream(3);
    let mut rays = Vec::new();
    for _ in 0..40 {
        let target = origin + warp::uniform_sphere(rng.uniform2()) * 1.2 * rng.uniform();
        let direction = warp::uniform_sphere(rng.uniform2());
        rays.push(Ray::new(target - direction * from, direction));
    }
    for (i, photon) in photons.iter().step_by(97).take(12).enumerate() {
        let axis = DVec3::AXES[i % 3] * if i % 2 == 0 { 1.0 } else { -1.0 };
        rays.push(Ray::new(place(origin, photon) - axis * from, axis));
        let aside = DVec3::AXES[(i + 1) % 3] * 0.049;
        rays.push(Ray::new(place(origin, photon) + aside - axis * from, axis));
    }
    rays
}

#[test]
fn gathers_along_rays_find_what_brute_force_finds() {
    const RADIUS: f64 = 0.05;
    for (name, photons) in clouds() {
        for origin in origins() {
            let map = BeamMap::new(origin, &photons, &radii(&photons, RADIUS));
            assert_eq!((map.len(), map.is_empty()), (photons.len(), photons.is_empty()));
            for from in [0.0, 3.0, 2e6] {
                // Rounding of a place that far from the ray's start or from the world's origin.
                let tolerance = 1e-8 + 1e-15 * from;
                for ray in rays(origin, &photons, from) {
                    for span in [Span::AHEAD, Span::new(from - 0.2, from + 0.3)] {
                        along_like_brute_force(
                            name, &map, origin, &photons, RADIUS, &ray, span, tolerance,
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn gathers_along_rays_work_at_any_scale() {
    let unit = random_places(2000, 6);
    for scale in [1e-9, 1e-4, 1e5] {
        let photons = numbered(unit.iter().map(|place| place.map(|c| c * scale as f32)));
        let origin = WorldPoint::new(scale, -scale, 0.0);
        let map = BeamMap::new(origin, &photons, &radii(&photons, 0.05 * scale));
        for ray in rays(WorldPoint::new(1.0, -1.0, 0.0), &numbered(unit.iter().copied()), 3.0) {
            let ray = Ray::new(WorldPoint::from_xyz(ray.origin.xyz * scale), ray.direction);
            let tolerance = 1e-8 * scale;
            along_like_brute_force(
                "scaled",
                &map,
                origin,
                &photons,
                0.05 * scale,
                &ray,
                Span::AHEAD,
                tolerance,
            );
        }
    }
}

/// Radii of the photons: every third is half as wide as the widest.
fn radii(photons: &[PhotonAt], widest: f64) -> Vec<f32> {
    let share = |i: usize| if i % 3 == 2 { 0.5 } else { 1.0 };
    (0..photons.len()).map(|i| (share(i) * widest) as f32).collect()
}

#[allow(clippy::too_many_arguments)]
fn along_like_brute_force(
    name: &str,
    map: &BeamMap,
    origin: WorldPoint,
    photons: &[PhotonAt],
    widest: f64,
    ray: &Ray<World>,
    span: Span,
    tolerance: f64,
) {
    let beside = |photon: &PhotonAt| {
        // Relative to the map, where coordinates are small.
        let from_ray = (origin - ray.origin) + DVec3::from(photon.place.map(f64::from));
        let t = from_ray.dot(ray.direction);
        (t, (from_ray - ray.direction * t).length())
    };
    let mut found = vec![0; photons.len()];
    map.along(ray, span, 1.0, |b: BeamHit<'_>| {
        let (t, distance) = beside(&photons[number(b.photon)]);
        assert!((b.t - t).abs() < tolerance, "{name}: {} for {t}", b.t);
        assert!((b.distance2.sqrt() - distance).abs() < 1e-4 * widest, "{name}: {distance}");
        assert!(b.distance2 <= b.radius * b.radius);
        assert!(b.t >= span.start && b.t <= span.end);
        found[number(b.photon)] += 1;
    });
    for ((photon, radius), times) in photons.iter().zip(radii(photons, widest)).zip(found) {
        let (t, distance) = beside(photon);
        let near = |a: f64, b: f64| (a - b).abs() < tolerance;
        let radius = f64::from(radius);
        let borderline = near(distance, radius) || near(t, span.start) || near(t, span.end);
        let inside = distance <= radius && t >= span.start && t <= span.end;
        assert!(
            borderline || times == u32::from(inside),
            "{name}: {times} times at {t}, {distance} from {ray:?} in {span:?}"
        );
    }
}

/// Photon numbers in the order of many gathers.
fn order(photons: &[PhotonAt], threads: usize) -> (Vec<usize>, Vec<usize>) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| {
        let origin = WorldPoint::new(0.0, 0.0, 0.0);
        let (mut along, mut within) = (Vec::new(), Vec::new());
        let beams = BeamMap::new(origin, photons, &radii(photons, 0.02));
        for ray in rays(origin, photons, 3.0) {
            beams.along(&ray, Span::AHEAD, 1.0, |b| along.push(number(b.photon)));
        }
        let map = PhotonMap::new(origin, photons);
        for photon in photons.iter().step_by(photons.len() / 40 + 1) {
            map.within(place(origin, photon), 0.05, |photon, _| within.push(number(photon)));
        }
        (along, within)
    })
}

#[test]
fn maps_are_in_the_same_order_on_any_number_of_threads() {
    let random = random_places(330_000, 4);
    let mut rng = stream(5);
    let mut heaps = || random[(rng.uniform() * 300.0) as usize];
    let cases = [
        ("random", numbered(random.iter().copied())),
        ("heaps", numbered((0..330_000).map(|_| heaps()).collect::<Vec<_>>())),
        ("coplanar", numbered(random.iter().map(|&[x, y, _]| [x, y, 0.25]))),
        ("one place", numbered([[0.5; 3]; 5000])),
        ("few", numbered(random.iter().copied().take(20_000))),
    ];
    for (name, photons) in cases {
        let (along, within) = order(&photons, 1);
        assert!(!along.is_empty() && !within.is_empty(), "{name}");
        for threads in [2, 3] {
            let again = order(&photons, threads);
            assert!(again.0 == along, "{name}: beams differ on {threads} threads");
            assert!(again.1 == within, "{name}: tree differs on {threads} threads");
        }
    }
}
