//! Lights against closed forms, their densities, and one way of asking against the other.

use std::f64::consts::PI;

use fogbow::light::{
    EmissionTarget, EmitterHit, Environment, Falloff, Light, Lights, MeshLight, PointLight,
    QuadLight, SpotLight, Sun, TargetSphere,
};
use fogbow::math::{Frame, Rgb, Stage, Stream, WorldPoint, warp};
use glam::DVec3;

use crate::chi2::Chi2;
use crate::lights::{Row, WHITE, all, quad_corners, tetrahedron};

/// Where a ray from `from` along the unit `direction` meets the front of a triangle.
fn hit(triangles: &[[DVec3; 3]], from: DVec3, direction: DVec3) -> Option<EmitterHit> {
    triangles.iter().find_map(|[a, b, c]| {
        let normal = (b - a).cross(c - a);
        let distance = (a - from).dot(normal) / direction.dot(normal);
        let p = from + direction * distance;
        let inside = [(a, b), (b, c), (c, a)]
            .iter()
            .all(|(s, e)| (**e - **s).cross(p - **s).dot(normal) >= 0.0);
        (inside && distance > 0.0 && direction.dot(normal) < 0.0)
            .then(|| EmitterHit { distance, normal: normal.normalize() })
    })
}

fn density(row: &Row, at: WorldPoint, direction: DVec3) -> f64 {
    if row.light.is_infinite() {
        return row.light.pdf(at, direction, None);
    }
    let hit = hit(&row.triangles, at.xyz, direction);
    hit.map_or(0.0, |hit| row.light.pdf(at, direction, Some(hit)))
}

/// Places near a rectangle in front of it and on its edge, aside of it above its plane, and far, and one near a
/// parallelogram.
fn by_quads() -> Vec<(Row, WorldPoint)> {
    let u = DVec3::new(2.0, 0.0, 0.0);
    let (rectangle, sheared) = (DVec3::new(0.0, 0.0, -1.0), DVec3::new(0.5, 0.0, -1.0));
    let place = |name, v, [x, y, z]: [f64; 3]| {
        let light = QuadLight::new(WorldPoint::from_xyz(DVec3::ZERO), u, v, WHITE).unwrap();
        let triangles = quad_corners(DVec3::ZERO, u, v);
        (Row { name, light: Light::Quad(light), triangles }, WorldPoint::new(x, y, z))
    };
    vec![
        place("in front", rectangle, [0.2, 0.05, 0.1]),
        place("at a corner", rectangle, [-1.0, 0.3, 0.5]),
        place("aside", rectangle, [1.3, 0.2, -0.2]),
        place("far", rectangle, [40.0, 30.0, 10.0]),
        place("sheared", sheared, [0.2, 0.3, 0.1]),
    ]
}

/// All lights that rays can hit, each with a place that they shine on.
fn seen() -> Vec<(Row, WorldPoint)> {
    let at = WorldPoint::new(0.1, -0.2, 0.3);
    let rows = all(1.0).into_iter().filter(|row| !row.light.is_delta());
    rows.map(|row| (row, at)).chain(by_quads()).collect()
}

#[test]
fn samples_follow_their_density() {
    for (row, at) in seen() {
        let mut stream = Stream::new(4, Stage::Test, 0, 0);
        let first = (0..100).find_map(|_| row.light.sample(at, stream.uniform2()));
        let toward = first.expect("most samples give light").direction;
        let widest = (0..2000)
            .filter_map(|_| row.light.sample(at, stream.uniform2()))
            .map(|s| 0.5 * (s.direction - toward).length_squared())
            .fold(0.0, f64::max);
        Chi2 { axis: toward, one_minus_cos: (1.05 * widest).min(2.0), ..Chi2::default() }.check(
            row.name,
            |stream| row.light.sample(at, stream.uniform2()).map(|s| s.direction),
            |direction| density(&row, at, direction),
        );
    }
}

#[test]
fn what_a_sample_says_is_what_a_ray_finds() {
    for (row, at) in seen() {
        let mut stream = Stream::new(5, Stage::Test, 0, 0);
        for _ in 0..1000 {
            let Some(s) = row.light.sample(at, stream.uniform2()) else { continue };
            // Directions along an edge, where rounding decides, are too rare to be among these.
            let found = hit(&row.triangles, at.xyz, s.direction);
            let seen = row.light.radiance_from(s.direction, found);
            assert!((seen - s.radiance).abs().max_element() < 1e-12, "{}: {seen}", row.name);
            let pdf = density(&row, at, s.direction);
            assert!((pdf / s.pdf - 1.0).abs() < 1e-9, "{}: {pdf} not {}", row.name, s.pdf);
        }
    }
}

/// Near a rectangle, all samples stand for as much light.
#[test]
fn samples_of_a_near_rectangle_are_alike() {
    for (row, at) in by_quads().into_iter().take(3) {
        let mut stream = Stream::new(6, Stage::Test, 0, 0);
        let estimates =
            (0..1000).map(|_| row.light.sample(at, stream.uniform2()).unwrap().pdf.recip());
        let solid_angle = row.light.incident_estimate(at);
        for estimate in estimates {
            assert!((estimate / solid_angle - 1.0).abs() < 1e-9, "{}: {estimate}", row.name);
        }
    }
}

/// Irradiance of the red channel on a surface at `at`, with the standard deviation of the result.
fn irradiance(light: &Light, at: WorldPoint, normal: DVec3, count: u32) -> (f64, f64) {
    let mut stream = Stream::new(6, Stage::Test, 0, 0);
    mean((0..count).map(|_| {
        light
            .sample(at, stream.uniform2())
            .map_or(0.0, |s| s.radiance.x * s.direction.dot(normal).max(0.0) / s.pdf)
    }))
}

/// Mean of the values and its standard deviation.
fn mean(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (mut n, mut sum, mut squares) = (0.0, 0.0, 0.0);
    for value in values {
        n += 1.0;
        sum += value;
        squares += value * value;
    }
    let mean = sum / n;
    (mean, ((squares / n - mean * mean).max(0.0) / n).sqrt())
}

#[test]
fn irradiance_is_that_of_the_closed_form() {
    let origin = WorldPoint::new(0.0, 0.0, 0.0);
    let above = WorldPoint::new(0.0, 2.0, 0.0);
    let point = Light::Point(PointLight::from_power(above, WHITE * 4.0 * PI).unwrap());
    let spot = SpotLight::new(above, DVec3::NEG_Y, WHITE, 20.0, Falloff::Smooth { start: 0.0 });
    let slanted = DVec3::new(1.0, -1.0, 0.0);
    let quad = QuadLight::new(above, DVec3::X * 2.0, DVec3::Z * 2.0, WHITE).unwrap();
    // Configuration factor from a patch to a rectangle with a corner above it (Howell, C-3),
    // here four squares with sides half of the distance.
    let rising = Environment::gradient(&[(0.0, Rgb::ZERO), (90.0, WHITE)]);
    let side = 0.5 / 1.25f64.sqrt();
    let quarter = 2.0 * side * side.atan() / (2.0 * PI);
    for (name, light, expected) in [
        ("point", point, 0.25),
        ("spot", Light::Spot(spot.unwrap()), 0.25),
        ("direction", Light::Sun(Sun::new(slanted, WHITE, 0.0).unwrap()), 0.5f64.sqrt()),
        ("sun", Light::Sun(Sun::new(slanted, WHITE, 0.53).unwrap()), 0.5f64.sqrt()),
        ("wide sun", Light::Sun(Sun::new(DVec3::NEG_Y, WHITE, 100.0).unwrap()), 1.0),
        ("quad", Light::Quad(quad), 4.0 * quarter * PI),
        ("constant", Light::Environment(Environment::constant(WHITE).unwrap()), PI),
        // The cosine times the cosine.
        ("gradient", Light::Environment(rising.unwrap()), 2.0 * PI / 3.0),
    ] {
        let (found, sigma) = irradiance(&light, origin, DVec3::Y, 100_000);
        // 4.5 sigma: one false alarm in 150,000; the rest is rounding.
        assert!((found - expected).abs() < 4.5 * sigma + 1e-9, "{name}: {found} not {expected}");
    }
}

/// Flux of red light through the disk at the origin, from above, by sampling and by photons.
fn compare(name: &str, light: &Light, reach: &EmissionTarget, disk: f64, middle: DVec3) {
    const COUNT: u32 = 100_000;
    let normal = DVec3::new(0.2, 1.0, -0.1).normalize();
    let frame = Frame::around(normal);
    let mut stream = Stream::new(7, Stage::Test, 0, 0);
    let sampled = mean((0..COUNT).map(|_| {
        let p = warp::concentric_disk(stream.uniform2()) * disk;
        let at = WorldPoint::from_xyz(middle + frame.x * p.x + frame.y * p.y);
        light.sample(at, stream.uniform2()).map_or(0.0, |s| {
            s.radiance.x * s.direction.dot(normal).max(0.0) / s.pdf * PI * disk * disk
        })
    }));
    let shot = mean((0..COUNT).map(|_| {
        let [a, b] = stream.uniform2();
        let [c, d] = stream.uniform2();
        light.emit(reach, [a, b, c, d]).map_or(0.0, |start| {
            let (from, along) = (start.ray.origin.xyz - middle, start.ray.direction);
            let t = -from.dot(normal) / along.dot(normal);
            let through = (from + along * t).length() < disk;
            if t > 0.0 && along.dot(normal) < 0.0 && through { start.power.x } else { 0.0 }
        })
    }));
    // 4.5 sigma of the difference: one false alarm in 150,000.
    let off = (sampled.0 - shot.0).abs();
    // A narrow beam passes by a disk aside: then both must be exactly 0.
    assert!(sampled.0 > 0.0 || middle != DVec3::ZERO, "{name}: dark");
    assert!(off <= 4.5 * sampled.1.hypot(shot.1), "{name}: {sampled:?} sampled, {shot:?} shot");
}

#[test]
fn photons_carry_what_samples_say() {
    let reach =
        |radius, outer| EmissionTarget::with_ring(WorldPoint::new(0.0, 0.0, 0.0), radius, outer);
    for row in all(1.0) {
        for (radius, outer) in [(0.5, 0.5), (0.5, 2.0), (0.5, 20.0), (8.0, 8.0), (8.0, 30.0)] {
            let name = format!("{}, reach {radius} to {outer}", row.name);
            compare(&name, &row.light, &reach(radius, outer).unwrap(), 0.45, DVec3::ZERO);
        }
        // Foci: over the disk, beside it, round the light of some rows, and one without weight.
        let focus = |x: f64, radius: f64, weight: f64| TargetSphere {
            center: WorldPoint::new(x, 0.1, -0.1),
            radius,
            weight,
        };
        let foci = vec![
            focus(0.1, 0.2, 3.0),
            focus(-0.3, 0.3, 1.0),
            focus(0.4, 9.0, 0.5),
            focus(0.0, 0.1, 0.0),
        ];
        for outer in [1.0, 20.0] {
            let focused = reach(1.0, outer).unwrap().focused_on(foci.clone());
            let name = format!("{}, focused, reach to {outer}", row.name);
            compare(&name, &row.light, &focused, 0.45, DVec3::ZERO);
        }
        let aside = DVec3::new(0.7, 0.0, 0.7);
        compare(row.name, &row.light, &reach(0.3, 1.6).unwrap(), 0.5, aside);
        // Over ground: for light from far away in the smaller disk, round it, and far from both; for
        // others far outside of both spheres.
        let (height, places) = if row.light.is_infinite() {
            (0.8, vec![(0.3, 1.6, 0.0), (0.3, 1.6, 0.9), (0.3, 30.0, 3.0)])
        } else {
            (0.2, vec![(0.1, 0.3, 0.0), (0.1, 0.3, 0.9)])
        };
        for (radius, outer, x) in places {
            let over_ground = reach(radius, outer).unwrap().over_ground(Some(height));
            let name = format!("{}, over ground, reach to {outer}, {x} m aside", row.name);
            compare(&name, &row.light, &over_ground, 0.5, DVec3::new(x, 0.0, 0.0));
        }
    }
    // Ground beyond the larger sphere.
    let sun = Light::Sun(Sun::new(DVec3::NEG_Y, WHITE, 0.0).unwrap());
    for (outer, x) in [(0.3, 0.9), (1.6, 2.3)] {
        let over_ground = reach(0.3, outer).unwrap().over_ground(Some(0.8));
        compare("sun over ground", &sun, &over_ground, 0.5, DVec3::new(x, 0.0, 0.0));
    }
}

#[test]
fn any_scale_works() {
    for scale in [1e-6, 1e-3, 1e3, 1e7] {
        for row in all(scale) {
            let reach = EmissionTarget::new(WorldPoint::new(0.0, 0.0, 0.0), 0.3 * scale).unwrap();
            let name = format!("{} at {scale} m", row.name);
            compare(&name, &row.light, &reach, 0.25 * scale, DVec3::ZERO);
        }
    }
    // A target of a micrometre, lit from 1e7 m.
    for row in all(1e7) {
        let reach = EmissionTarget::new(WorldPoint::new(0.0, 0.0, 0.0), 1e-6).unwrap();
        compare(row.name, &row.light, &reach, 0.8e-6, DVec3::ZERO);
    }
}

#[test]
fn estimate_is_positive_where_light_can_come() {
    for row in all(1.0) {
        let mut stream = Stream::new(8, Stage::Test, 0, 0);
        for _ in 0..5000 {
            let far = 10f64.powf(6.0 * stream.uniform() - 2.0);
            let at = WorldPoint::from_xyz(warp::uniform_sphere(stream.uniform2()) * far);
            let estimate = row.light.incident_estimate(at);
            assert!(estimate >= 0.0 && estimate.is_finite(), "{}: {estimate}", row.name);
            if row.light.sample(at, stream.uniform2()).is_some() {
                assert!(estimate > 0.0, "{}: 0 at {}", row.name, at.xyz);
            }
        }
    }
}

#[test]
fn environment_picture_density_integrates_to_one_and_finds_a_bright_texel() {
    let mut texels = vec![[0f32; 3]; 64 * 32];
    texels[5 * 64 + 16] = [0.0, 9.0, 0.0];
    let sun = Light::Environment(Environment::picture(64, 32, texels, WHITE, 0.0).unwrap());
    let mut stream = Stream::new(9, Stage::Test, 0, 0);
    for _ in 0..1000 {
        let s = sun.sample(WorldPoint::new(0.0, 0.0, 0.0), stream.uniform2()).unwrap();
        assert_eq!(s.radiance, Rgb::new(0.0, 9.0, 0.0));
        // A quarter from the left looks to +x, the upper rows up.
        assert!(s.direction.x > 0.4 && s.direction.y > 0.8, "{}", s.direction);
    }
    let (row, at) = (all(1.0).pop().unwrap(), WorldPoint::new(0.0, 0.0, 0.0));
    let (integral, sigma) = mean(
        (0..400_000)
            .map(|_| row.light.pdf(at, warp::uniform_sphere(stream.uniform2()), None) * 4.0 * PI),
    );
    assert!((integral - 1.0).abs() < 4.5 * sigma, "{integral} +- {sigma}");
}

#[test]
fn dark_lights_give_nothing() {
    let black = Rgb::ZERO;
    let at = WorldPoint::new(0.0, 1.0, 0.0);
    let (u, v) = (DVec3::X, DVec3::Z);
    let lights = vec![
        Light::Point(PointLight::new(at, black).unwrap()),
        Light::Spot(SpotLight::new(at, u, black, 9.0, Falloff::Cosine { exponent: 2.0 }).unwrap()),
        Light::Sun(Sun::new(u, black, 1.0).unwrap()),
        Light::Sun(Sun::new(u, black, 0.0).unwrap()),
        Light::Quad(QuadLight::new(at, u, v, black).unwrap()),
        Light::Mesh(MeshLight::new(tetrahedron(u), black).unwrap()),
        Light::Environment(Environment::constant(black).unwrap()),
        Light::Environment(Environment::gradient(&[(-9.0, black), (9.0, black)]).unwrap()),
        Light::Environment(Environment::picture(2, 1, vec![[0.0; 3]; 2], WHITE, 0.0).unwrap()),
    ];
    let reach = EmissionTarget::new(WorldPoint::new(0.0, 0.0, 0.0), 1.0).unwrap();
    for light in &lights {
        assert!(light.sample(WorldPoint::new(0.1, 0.2, 0.3), [0.3, 0.6]).is_none(), "{light:?}");
        assert!(light.emit(&reach, [0.3, 0.6, 0.2, 0.8]).is_none(), "{light:?}");
        assert_eq!(light.power(&reach), black, "{light:?}");
        assert_eq!(light.incident_estimate(at), 0.0, "{light:?}");
    }
    let lights = Lights { lights, ..Lights::default() };
    assert!(lights.choose(at, 0.5).is_none());
    assert_eq!(lights.environment_radiance(DVec3::Y), black);
}

#[test]
fn choice_follows_its_probability() {
    let lights = all(1.0).into_iter().map(|row| row.light).collect();
    let lights = Lights { lights, ..Lights::default() };
    let at = WorldPoint::new(0.1, 0.0, 0.2);
    let count = 100_000u32;
    let mut chosen = vec![(0.0, 0.0); lights.lights.len()];
    let mut stream = Stream::new(10, Stage::Test, 0, 0);
    for _ in 0..count {
        let (index, probability) = lights.choose(at, stream.uniform()).unwrap();
        chosen[index] = (chosen[index].0 + 1.0, probability);
    }
    let total: f64 = chosen.iter().map(|c| c.1).sum();
    assert!((total - 1.0).abs() < 1e-3, "{total}");
    for (index, (times, probability)) in chosen.into_iter().enumerate() {
        let expected = probability * f64::from(count);
        assert!((times - expected).abs() <= 5.0 * expected.sqrt() + 1.0, "{index}: {times}");
        if times > 0.0 {
            let asked = lights.choice_probability(at, index);
            assert!((asked - probability).abs() < 1e-12, "{index}: {asked}");
        }
    }
}

#[test]
fn power_of_a_spot_is_what_it_was_made_with() {
    let at = WorldPoint::new(0.0, 0.0, 0.0);
    for falloff in [Falloff::Smooth { start: 5.0 }, Falloff::Cosine { exponent: 30.0 }] {
        let spot = SpotLight::new(at, DVec3::X, WHITE, 60.0, falloff).unwrap();
        let light = Light::Spot(spot.with_power(Rgb::new(5.0, 0.0, 2.0)).unwrap());
        let reach = EmissionTarget::new(at, 1.0).unwrap();
        let mut stream = Stream::new(11, Stage::Test, 0, 0);
        let (power, sigma) = mean((0..100_000).map(|_| {
            let [a, b] = stream.uniform2();
            light.emit(&reach, [a, b, 0.5, 0.5]).map_or(0.0, |start| start.power.x)
        }));
        assert!((power - 5.0).abs() < 4.5 * sigma + 1e-4, "{power} +- {sigma}");
    }
}

#[test]
fn values_out_of_range_are_refused_by_name() {
    let at = WorldPoint::new(0.0, 0.0, 0.0);
    let (x, nan) = (DVec3::X, Rgb::splat(f64::NAN));
    let spot = |angle, falloff| SpotLight::new(at, x, WHITE, angle, falloff).map(|_| ());
    let gradient = |stops: &[(f64, Rgb)]| Environment::gradient(stops).map(|_| ());
    for (found, word) in [
        (PointLight::new(at, -WHITE).map(|_| ()), "intensity"),
        (PointLight::new(WorldPoint::from_xyz(nan), WHITE).map(|_| ()), "position"),
        (spot(0.0, Falloff::Smooth { start: 0.0 }), "cone angle"),
        (spot(30.0, Falloff::Smooth { start: 31.0 }), "falloff"),
        (spot(30.0, Falloff::Cosine { exponent: -1.0 }), "exponent"),
        (Sun::new(DVec3::ZERO, WHITE, 0.5).map(|_| ()), "direction"),
        (Sun::new(x, WHITE, 180.0).map(|_| ()), "angular diameter"),
        (QuadLight::new(at, x, x * 2.0, WHITE).map(|_| ()), "edges"),
        (MeshLight::new(vec![[x; 3]], WHITE).map(|_| ()), "area"),
        (MeshLight::new(vec![[nan; 3]], WHITE).map(|_| ()), "triangle 0"),
        (gradient(&[(0.0, WHITE)]), "stops of a gradient are 1"),
        (gradient(&[(0.0, WHITE), (91.0, WHITE)]), "91°"),
        (gradient(&[(f64::NAN, WHITE), (9.0, WHITE)]), "NaN°"),
        (gradient(&[(9.0, WHITE), (8.0, WHITE)]), "8° comes after 9°"),
        (gradient(&[(0.0, WHITE), (9.0, -WHITE)]), "radiance of a stop"),
        (Environment::constant(nan).map(|_| ()), "radiance"),
        (Environment::picture(2, 2, vec![[1.0; 3]; 3], WHITE, 0.0).map(|_| ()), "2 x 2"),
        (Environment::picture(1, 1, vec![[f32::NAN; 3]], WHITE, 0.0).map(|_| ()), "texel 0"),
        (EmissionTarget::new(at, 0.0).map(|_| ()), "radii"),
    ] {
        let message = found.unwrap_err();
        assert!(message.contains(word) && message.contains("must"), "{message}");
    }
}
