//! Materials: energy, reciprocity, densities.

use fogbow::math::{Rgb, Stage, Stream, WorldPoint, warp};
use fogbow::surface::{
    Glass, Material, Metal, Plastic, SurfaceHit, Texture, TransportMode, dielectric_reflectance,
};
use glam::{DVec2, DVec3};
use statrs::distribution::{ChiSquared, ContinuousCDF};

fn hit(material: &Material, shading_normal: DVec3) -> SurfaceHit<'_> {
    SurfaceHit {
        t: 1.0,
        point: WorldPoint::new(0.0, 0.0, 0.0),
        error: 1e-15,
        normal: DVec3::Z,
        shading_normal,
        uv: DVec2::ZERO,
        material,
        light: None,
        surface: 0,
        primitive: 0,
    }
}

fn white() -> Material {
    Material::Diffuse { reflectance: Texture::Constant(Rgb::ONE) }
}

/// Mean weight of a scattered path: what a furnace of radiance 1 all round sends back.
fn albedo(material: &Material, incoming: DVec3, ns: DVec3, mode: TransportMode) -> f64 {
    let mut stream = Stream::new(1, Stage::Test, 0, 0);
    let hit = hit(material, ns);
    let count = 50_000;
    let sum: f64 = (0..count)
        .filter_map(|_| {
            let u = [stream.uniform(), stream.uniform(), stream.uniform()];
            material.scatter(incoming, &hit, u, mode).map(|s| s.weight.x)
        })
        .sum();
    sum / f64::from(count)
}

#[test]
fn white_materials_keep_all_energy_and_never_make_any() {
    let glass = Material::Glass(Glass { ior: 1.5, tint: Rgb::ONE });
    for incoming in
        [DVec3::NEG_Z, DVec3::Z, DVec3::new(0.6, 0.0, -0.8), DVec3::new(0.96, 0.0, 0.28)]
    {
        for (material, mode) in [
            (white(), TransportMode::Radiance),
            (white(), TransportMode::Importance),
            (Material::Mirror { reflectance: Rgb::ONE }, TransportMode::Radiance),
            (glass.clone(), TransportMode::Importance),
        ] {
            assert!((albedo(&material, incoming, DVec3::Z, mode) - 1.0).abs() < 1e-12);
            let bent = DVec3::new(0.3, 0.2, 1.0).normalize();
            let kept = albedo(&material, incoming, bent, TransportMode::Radiance);
            assert!(kept <= 1.0 + 1e-12 || material.is_specular());
        }
        assert_eq!(albedo(&Material::Black, incoming, DVec3::Z, TransportMode::Radiance), 0.0);
    }
}

#[test]
fn radiance_through_glass_scales_with_the_index_squared() {
    let glass = Material::Glass(Glass { ior: 1.5, tint: Rgb::ONE });
    let hit = hit(&glass, DVec3::Z);
    for (incoming, factor, crossing) in [(DVec3::NEG_Z, 1.0 / 2.25, 1), (DVec3::Z, 2.25, -1)] {
        let s = glass.scatter(incoming, &hit, [0.5; 3], TransportMode::Radiance).unwrap();
        assert!((s.weight.x - factor).abs() < 1e-12 && s.crossing == crossing);
        assert!(s.direction.distance(incoming) < 1e-12);
    }
}

#[test]
fn fresnel_matches_known_values_and_snell_reverses() {
    assert!((dielectric_reflectance(1.0, 1.0 / 1.5) - 0.04).abs() < 1e-15);
    assert_eq!(dielectric_reflectance(0.5, 1.5), 1.0);
    assert!((dielectric_reflectance(0.0, 1.0 / 1.5) - 1.0).abs() < 1e-12);
    assert!(dielectric_reflectance(0.3, 1.0) < 1e-30);
    // R is the same from both sides of the refracted path, so 1 - R carries the same power.
    for i in 1..100 {
        let cos_i = f64::from(i) / 100.0;
        let sin_t = (1.0 - cos_i * cos_i).sqrt() / 1.5;
        let back = dielectric_reflectance((1.0 - sin_t * sin_t).sqrt(), 1.5);
        assert!((dielectric_reflectance(cos_i, 1.0 / 1.5) - back).abs() < 1e-12);
    }
}

#[test]
fn total_internal_reflection_stays_inside() {
    let glass = Material::Glass(Glass { ior: 1.5, tint: Rgb::ZERO });
    let hit = hit(&glass, DVec3::Z);
    let incoming = DVec3::new(0.8, 0.0, 0.6);
    let s = glass.scatter(incoming, &hit, [0.999; 3], TransportMode::Radiance).unwrap();
    assert!(s.crossing == 0 && s.weight == Rgb::ONE);
    assert!(s.direction.distance(DVec3::new(0.8, 0.0, -0.6)) < 1e-12);
}

#[test]
fn diffuse_is_reciprocal_and_never_leaks() {
    let material = white();
    let mut stream = Stream::new(2, Stage::Test, 0, 0);
    for _ in 0..2000 {
        let hit = hit(&material, DVec3::new(0.5, -0.2, 1.0).normalize());
        let a = warp::uniform_sphere(stream.uniform2());
        let b = warp::uniform_sphere(stream.uniform2());
        let radiance = material.eval(-a, b, &hit, TransportMode::Radiance);
        assert_eq!(radiance, material.eval(-b, a, &hit, TransportMode::Radiance));
        if a.z * b.z < 0.0 {
            assert_eq!(radiance, Rgb::ZERO);
        }
        // Veach 1997, equation 5.19: both modes measure the same light along the path.
        let importance = material.eval(-b, a, &hit, TransportMode::Importance);
        let (ng, ns) = (hit.normal, hit.shading_normal);
        let forward = radiance * (b.dot(ns) * a.dot(ng)).abs();
        let backward = importance * (a.dot(ns) * b.dot(ng)).abs();
        assert!(forward.distance(backward) < 1e-12);
    }
}

/// Chi-square over 10 x 20 cells of equal probability; a false alarm in 1 of 10,000 runs, and the
/// seed is fixed.
#[test]
fn diffuse_samples_follow_their_density() {
    let material = white();
    let hit = hit(&material, DVec3::Z);
    let mut stream = Stream::new(3, Stage::Test, 0, 0);
    let (rings, sectors, count) = (10, 20, 200_000);
    let mut cells = vec![0u32; rings * sectors];
    for _ in 0..count {
        let u = [stream.uniform(), stream.uniform(), stream.uniform()];
        let s =
            material.scatter(DVec3::new(0.6, 0.0, -0.8), &hit, u, TransportMode::Radiance).unwrap();
        let d = s.direction;
        assert!((s.pdf - material.pdf(DVec3::NEG_Z, d, &hit)).abs() < 1e-12);
        assert!((s.pdf - d.z / std::f64::consts::PI).abs() < 1e-12);
        let ring = ((1.0 - d.z * d.z) * rings as f64) as usize; // sin² is uniform
        let turn = d.y.atan2(d.x) / (2.0 * std::f64::consts::PI) + 0.5;
        let sector = (turn * sectors as f64) as usize;
        cells[ring.min(rings - 1) * sectors + sector.min(sectors - 1)] += 1;
    }
    let expected = f64::from(count) / cells.len() as f64;
    let statistic: f64 = cells.iter().map(|c| (f64::from(*c) - expected).powi(2) / expected).sum();
    let limit = ChiSquared::new(cells.len() as f64 - 1.0).unwrap().inverse_cdf(1.0 - 1e-4);
    assert!(statistic < limit, "{statistic} {limit}");
}

/// Rough materials, of colours that take nothing away, with their names.
fn rough() -> Vec<(String, Material)> {
    let white = || Texture::Constant(Rgb::ONE);
    let mut materials = Vec::new();
    for roughness in [0.1_f64, 0.2, 0.3, 0.4, 0.5, 0.6, 1.0] {
        let alpha = roughness * roughness;
        let metal = Material::Metal(Metal::new(white(), alpha));
        materials.push((format!("metal {roughness}"), metal));
        for ior in [1.2, 1.5, 2.4] {
            let plastic = Material::Plastic(Plastic::new(white(), ior, alpha));
            materials.push((format!("plastic {roughness} {ior}"), plastic));
        }
    }
    materials
}

/// Directions toward a surface with the normal z, from straight to grazing.
fn slants() -> impl Iterator<Item = DVec3> {
    [0.0_f64, 30.0, 60.0, 80.0, 87.0].into_iter().map(|angle| {
        let (sin, cos) = angle.to_radians().sin_cos();
        DVec3::new(0.8 * sin, 0.6 * sin, -cos)
    })
}

/// The integral of `value` over outgoing directions, by the midpoint rule over angles, finest around the mirrored
/// direction and at the horizon.
fn integral(incoming: DVec3, value: impl Fn(DVec3) -> f64) -> f64 {
    let mirrored = incoming * DVec3::new(1.0, 1.0, -1.0);
    let frame = fogbow::math::Frame::around(mirrored);
    let (rings, sectors) = (4000, 360);
    let mut sum = 0.0;
    for ring in 0..rings {
        // Squared, so that rings are narrow around the middle.
        let [low, high] = [ring, ring + 1]
            .map(|edge| (f64::from(edge) / f64::from(rings)).powi(2) * std::f64::consts::PI);
        let middle = f64::midpoint(low, high);
        let solid_angle = (low.cos() - high.cos()) * std::f64::consts::TAU / f64::from(sectors);
        for sector in 0..sectors {
            let turn = (f64::from(sector) + 0.5) / f64::from(sectors) * std::f64::consts::TAU;
            let direction = frame.to_world(warp::spherical(middle.cos(), turn));
            if direction.z > 0.0 {
                sum += value(direction) * solid_angle;
            }
        }
    }
    sum
}

/// White metals and plastics neither lose energy nor make any. What sampling has in the mean is what values have, within
/// 4.5 standard errors: a false alarm of 7e-6 for each of 140 means, at a fixed seed.
#[test]
fn rough_materials_make_no_energy_and_sampling_has_what_values_have() {
    for (name, material) in rough() {
        let hit = hit(&material, DVec3::Z);
        for incoming in slants() {
            let value = |direction: DVec3| {
                material.eval(incoming, direction, &hit, TransportMode::Radiance).x * direction.z
            };
            let albedo = integral(incoming, value);
            let slant = incoming.z;
            // The tables of albedos and this quadrature are within 5e-3.
            assert!(albedo < 1.005, "{name} {slant}: {albedo}");
            assert!(albedo > 0.99, "{name} {slant}: {albedo}");
            let mut stream = Stream::new(5, Stage::Test, 0, 0);
            let count = 20_000;
            let (mut sum, mut squares) = (0.0, 0.0);
            for _ in 0..count {
                let u = [stream.uniform(), stream.uniform(), stream.uniform()];
                let scattered = material.scatter(incoming, &hit, u, TransportMode::Radiance);
                let weight = scattered.map_or(0.0, |s| s.weight.x);
                assert!((0.0..30.0).contains(&weight), "{name} {slant}: {weight}");
                sum += weight;
                squares += weight * weight;
            }
            let mean = sum / f64::from(count);
            let variance = squares / f64::from(count) - mean * mean;
            let bound = 4.5 * (variance / f64::from(count)).sqrt() + 5e-3;
            assert!((mean - albedo).abs() < bound, "{name} {slant}: {mean} not {albedo}");
        }
    }
}

#[test]
fn rough_materials_are_reciprocal_and_never_leak() {
    let mut stream = Stream::new(6, Stage::Test, 0, 0);
    for (name, material) in rough() {
        for _ in 0..200 {
            let hit = hit(&material, DVec3::new(0.5, -0.2, 1.0).normalize());
            let a = warp::uniform_sphere(stream.uniform2());
            let b = warp::uniform_sphere(stream.uniform2());
            let there = material.eval(-a, b, &hit, TransportMode::Radiance).x;
            let back = material.eval(-b, a, &hit, TransportMode::Radiance).x;
            assert!((there - back).abs() <= 1e-9 * there, "{name}: {there} {back}");
            if a.z * b.z < 0.0 {
                assert_eq!(there, 0.0, "{name}");
                assert_eq!(material.pdf(-a, b, &hit), 0.0, "{name}");
            }
        }
    }
}

/// Chi-square of directions against their density, over cells of the hemisphere that have 20 samples or more and
/// one of all others. A false alarm in 1 of 100,000 runs for each of 30, and the seed is fixed.
#[test]
fn rough_samples_follow_their_density() {
    const RINGS: usize = 40;
    const SECTORS: usize = 24;
    /// Places along both sides of a cell: seen at grazing, lobes are narrow to the side.
    const PLACES: [usize; 2] = [12, 96];
    // Lobes of less roughness are too narrow for these cells.
    let wide = |name: &str| {
        !name.contains(" 0.1")
            && !name.contains(" 0.2")
            && !name.ends_with("1.2")
            && !name.ends_with("2.4")
    };
    for (name, material) in rough().into_iter().filter(|(name, _)| wide(name)) {
        let hit = hit(&material, DVec3::Z);
        for incoming in slants() {
            let direction = |ring: f64, sector: f64| {
                let turn = (sector / SECTORS as f64) * std::f64::consts::TAU;
                warp::spherical(ring / RINGS as f64, turn)
            };
            // Cells are even in the cosine, and so in solid angle.
            let size = std::f64::consts::TAU / (RINGS * SECTORS * PLACES[0] * PLACES[1]) as f64;
            let probability = |cell: usize| -> f64 {
                let (ring, sector) = (cell / SECTORS, cell % SECTORS);
                let place = |i: usize, of: usize| (i as f64 + 0.5) / of as f64;
                let places = (0..PLACES[0] * PLACES[1]).map(|i| {
                    let [x, y] = [place(i / PLACES[1], PLACES[0]), place(i % PLACES[1], PLACES[1])];
                    let direction = direction(ring as f64 + x, sector as f64 + y);
                    material.pdf(incoming, direction, &hit)
                });
                places.sum::<f64>() * size
            };
            let expected: Vec<_> = (0..RINGS * SECTORS).map(probability).collect();
            let mut stream = Stream::new(7, Stage::Test, 0, 0);
            let count = 40_000;
            let mut found = vec![0.0; RINGS * SECTORS];
            for _ in 0..count {
                let u = [stream.uniform(), stream.uniform(), stream.uniform()];
                let scattered = material.scatter(incoming, &hit, u, TransportMode::Radiance);
                let Some(scattered) = scattered else { continue };
                let d = scattered.direction;
                let pdf = material.pdf(incoming, d, &hit);
                assert!((scattered.pdf - pdf).abs() <= 1e-6 * pdf, "{name}");
                let ring = (d.z * RINGS as f64) as usize;
                let turn = (d.y.atan2(d.x) / std::f64::consts::TAU).rem_euclid(1.0);
                let sector = (turn * SECTORS as f64) as usize;
                found[ring.min(RINGS - 1) * SECTORS + sector.min(SECTORS - 1)] += 1.0;
            }
            let (mut statistic, mut cells) = (0.0, 0_u32);
            let mut others = [f64::from(count), f64::from(count)];
            for (found, expected) in found.into_iter().zip(expected) {
                let expected = expected * f64::from(count);
                if expected >= 20.0 {
                    statistic += (found - expected).powi(2) / expected;
                    cells += 1;
                    others[0] -= found;
                    others[1] -= expected;
                }
            }
            if others[1] > 20.0 {
                statistic += (others[0] - others[1]).powi(2) / others[1];
            }
            let limit = ChiSquared::new(f64::from(cells)).unwrap().inverse_cdf(1.0 - 1e-5);
            assert!(statistic < limit, "{name} {}: {statistic} {limit} of {cells}", incoming.z);
        }
    }
}
