//! Materials: energy, reciprocity, densities.

use fogbow::math::{Rgb, Stage, Stream, WorldPoint, warp};
use fogbow::surface::{
    Glass, Material, SurfaceHit, Texture, TransportMode, dielectric_reflectance,
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
