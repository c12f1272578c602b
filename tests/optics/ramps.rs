//! Transfer functions: integrals, free flight, photons and majorants against brute force.
//!
//! Seeds are fixed. Each comparison of a mean allows 4.5 standard errors: one false alarm in 150,000,
//! a hundred of them here.

use std::f64::consts::PI;

use fogbow::math::{IndexPoint, Ray, Rgb, Span, Stage, Stream, World, WorldPoint, luminance};
use fogbow::medium::blackbody::Blackbody;
use fogbow::medium::{
    Albedo, Density, Emission, EmissionSampler, Media, Medium, Phase, Profile, Ramped, Remap,
    Transfer,
};
use fogbow::vdb::Grid;
use fogbow::work::Work;
use glam::DVec3;
use proptest::prelude::*;

use crate::fields::{self, VOXEL, puffs};

const SIGMAS: f64 = 4.5;

/// The grid of `fields`, turned, with values of `value` in metres.
fn grid(value: impl Fn(DVec3) -> f64) -> Grid<f32> {
    fields::grid(0.6, value, Vec::new())
}

/// Noise from voxel to voxel.
fn speckles(p: DVec3) -> f64 {
    let hash = (p.dot(DVec3::new(127.1, 311.7, 74.7)).sin() * 43_758.547).fract().abs();
    if p.abs().max_element() < 0.9 { hash } else { 0.0 }
}

/// A jump, a ramp up and down, a gamma, one that makes something of nothing, one that is 0 in between.
fn transfers() -> Vec<Transfer<f64>> {
    let plain = Remap::default();
    let closed = Remap { clamp: true, ..plain };
    let ramp = |remap, stops: &[(f64, f64)]| Transfer::new(remap, stops).unwrap();
    vec![
        ramp(plain, &[(0.35, 0.0), (0.35, 2.0)]),
        ramp(plain, &[(0.1, 0.0), (0.3, 1.5), (0.6, 0.2), (0.9, 3.0)]),
        Transfer::remapped(Remap { max: 0.8, gamma: 2.2, ..closed }).unwrap(),
        Transfer::remapped(Remap { min: 0.2, max: 0.7, ..plain }).unwrap(),
        ramp(closed, &[(0.0, 0.5), (0.3, 0.0), (0.5, 0.0), (0.5, 1.0), (0.6, 1.0), (0.6, 0.25)]),
    ]
}

fn rays() -> Vec<(Ray<World>, Span)> {
    let ray = |o: [f64; 3], d: [f64; 3]| {
        Ray::new(WorldPoint::from_xyz(DVec3::from(o)), DVec3::from(d).normalize())
    };
    vec![
        (ray([-3.0, 0.1, 0.2], [1.0, 0.02, -0.05]), Span::new(0.0, 7.0)),
        (ray([0.1, -0.1, 0.0], [0.3, 0.5, -0.4]), Span::new(0.0, 5.0)),
        (ray([2.0, 1.9, 2.1], [-1.0, -1.0, -1.0]), Span::new(1.0, 4.5)),
    ]
}

fn medium(density: Density, emission: Option<Emission>) -> Medium {
    let albedo = Albedo::Constant(Rgb::splat(0.5));
    Medium { density, sigma_t: Rgb::splat(2.0), albedo, phase: Phase::ISOTROPIC, emission }
}

#[test]
fn integrals_agree_with_brute_force() {
    const N: u32 = 1_000_000;
    for grid in [grid(puffs), grid(speckles)] {
        for (index, transfer) in transfers().into_iter().enumerate() {
            let ramped = Ramped::new(grid.clone(), transfer.clone());
            let peak = ramped.peak();
            let density = Density::Ramped(ramped);
            for (ray, span) in rays() {
                let dt = span.length() / f64::from(N);
                let value = |i: u32| density.value(ray.at(span.start + (f64::from(i) + 0.5) * dt));
                let brute = (0..N).map(value).sum::<f64>() * dt;
                let found = density.integrate(&ray, span, &mut Work::default());
                // A jump is missed by a step at most, of some fifty on the way.
                let off = (found - brute).abs();
                assert!(off < 50.0 * peak * dt, "transfer {index}: {found} for {brute}");
                assert!(found > 0.0, "transfer {index}");
            }
        }
    }
}

#[test]
fn a_jump_within_a_cell_is_met_exactly() {
    // Along x the value is x / 8 voxel for voxel, and the jump lies within the fourth cell.
    let slope = grid(|p| (p.x / VOXEL + 8.0) / 24.0);
    let jump = 11.4 / 24.0;
    let transfer = Transfer::new(Remap::default(), &[(jump, 1.0), (jump, 5.0)]).unwrap();
    let density = Density::Ramped(Ramped::new(slope.clone(), transfer));
    let start = IndexPoint::new(1.25, 0.3, 0.6);
    let transform = slope.transform();
    let direction = transform.vector_to_world(DVec3::X).normalize();
    let ray = Ray::new(transform.point_to_world(start), direction);
    let span = Span::new(0.0, 6.0 * VOXEL);
    let exact = VOXEL * ((3.4 - 1.25) + 5.0 * (7.25 - 3.4));
    let found = density.integrate(&ray, span, &mut Work::default());
    assert!((found - exact).abs() < 1e-6 * exact, "{found} for {exact}");
    // And in pieces: optical depth grows at its rate on both sides.
    let media = Media::new(vec![medium(density, None)]);
    for end in [2.0, 2.1, 2.2, 3.0] {
        let part = Span::new(0.0, end * VOXEL);
        let before = f64::min(end, 2.15);
        let exact = 2.0 * VOXEL * (before + 5.0 * (end - before));
        let found = media.optical_thickness(&ray, part).x;
        assert!((found - exact).abs() < 3e-6, "to {end}: {found} for {exact}");
    }
}

#[test]
fn flights_and_marches_agree_with_the_exact_depth() {
    const N: u32 = 20_000;
    let mut index = 0;
    for grid in [grid(puffs), grid(speckles)] {
        for transfer in transfers() {
            let density = Density::Ramped(Ramped::new(grid.clone(), transfer));
            let media = Media::new(vec![medium(density, None)]);
            for (ray, span) in rays() {
                index += 1;
                let exact = media.optical_thickness(&ray, span).x;
                let mut profile: Profile = Profile::default();
                profile.trace(&media, &ray, span, 0.5 * VOXEL, 0.5);
                let found = profile.optical_thickness().x;
                assert!((found - exact).abs() < 1e-9 * (1.0 + exact), "{found} for {exact}");
                let mut sum = 0.0;
                for i in 0..1000 {
                    let jitter = (f64::from(i) + 0.5) / 1000.0;
                    profile.trace(&media, &ray, span, 3.0 * VOXEL, jitter);
                    sum += profile.optical_thickness().x / 1000.0;
                }
                assert!((sum - exact).abs() < 1e-2 * (1.0 + exact), "{sum} for {exact}");

                let mut rng = Stream::new(3, Stage::Test, index, 0);
                let free = (0..N).filter(|_| {
                    let mut flights = media.flights(&ray, span, Rgb::ONE, &mut rng);
                    while let Some(c) = flights.next(&mut rng) {
                        assert!(c.density * 2.0 <= c.majorant * (1.0 + 1e-12));
                        if rng.uniform() * c.majorant < 2.0 * c.density {
                            return false;
                        }
                    }
                    true
                });
                let (found, expected) = (free.count() as f64 / f64::from(N), (-exact).exp());
                let error = (expected * (1.0 - expected) / f64::from(N)).sqrt();
                let off = (found - expected).abs();
                assert!(off <= SIGMAS * error, "case {index}: {found} for {expected}");
            }
        }
    }
}

fn stops() -> impl Strategy<Value = Vec<(f64, f64)>> {
    let stop = (0.0..1.0f64, prop_oneof![Just(0.0), 0.0..4.0f64]);
    prop::collection::vec(stop, 1..6).prop_map(|mut stops| {
        stops.sort_by(|a, b| a.0.total_cmp(&b.0));
        if stops.len() > 2 {
            stops[1].0 = stops[0].0; // a jump
        }
        stops
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]
    #[test]
    fn majorants_bound_and_what_is_left_out_is_0(stops in stops(), seed in 0..1000u64) {
        let grid = grid(speckles);
        let ramped = Ramped::new(grid.clone(), Transfer::new(Remap::default(), &stops).unwrap());
        let mut occupied = Vec::new();
        ramped.for_each_occupied(|cells| occupied.push(cells));
        let (peak, density) = (ramped.peak(), Density::Ramped(ramped.clone()));
        let mut rng = Stream::new(seed, Stage::Test, 0, 0);
        for _ in 0..500 {
            let p = DVec3::from(std::array::from_fn(|_| rng.uniform() * 26.0 - 10.0));
            let local = IndexPoint::from_xyz(p);
            let p = grid.transform().point_to_world(local);
            let value = density.value(p);
            prop_assert!(value <= density.majorant(p) * (1.0 + 1e-12), "{value} at {p:?}");
            prop_assert!(value <= peak * (1.0 + 1e-12));
            let is_occupied = occupied.iter().any(|cells| cells.contains(local));
            prop_assert!(is_occupied || value == 0.0, "{value} at {local:?}");
        }
        // Majorants as flights see them, brick by brick.
        let (ray, span) = rays()[0];
        let local = grid.transform().ray_to_local(&ray);
        for segment in grid.bricks(&local, span) {
            let [low, high] = ramped.transfer().range([segment.min, segment.max].map(f64::from));
            for _ in 0..8 {
                let t = segment.span.start + segment.span.length() * rng.uniform();
                let value = ramped.transfer().at(grid.value_in(segment.brick, local.at(t)));
                prop_assert!(value >= low - 1e-12 && value <= high + 1e-12);
            }
        }
    }
}

/// A colour ramp with jumps: nothing, red, nothing, white.
fn flame() -> Transfer<Rgb> {
    let red = Rgb::new(3.0, 0.5, 0.0);
    let stops =
        [(0.3, Rgb::ZERO), (0.3, red), (0.5, red), (0.5, Rgb::ZERO), (0.8, Rgb::splat(4.0))];
    Transfer::new(Remap::default(), &stops).unwrap()
}

fn glowing() -> Vec<(&'static str, Medium)> {
    let kelvin = Transfer::new(Remap::default(), &[(0.6, 0.0), (0.6, 1500.0), (1.0, 2400.0)]);
    let fire = |ramp| Emission::Blackbody {
        grid: grid(speckles),
        ramp,
        kelvin_scale: 1.0,
        kelvin_offset: 0.0,
        scale: 1e-3,
        table: Blackbody::new(),
    };
    let smoke = || Density::Voxel(grid(puffs));
    let thick = || Density::Ramped(Ramped::new(grid(puffs), transfers().remove(0)));
    let flames = || Emission::Ramped(Ramped::new(grid(puffs), flame()));
    let color = Rgb::new(2.0, 1.0, 0.5);
    vec![
        ("flames", medium(smoke(), Some(flames()))),
        ("flames in flames", medium(thick(), Some(flames()))),
        ("density", medium(thick(), Some(Emission::Density(color)))),
        ("kelvin", medium(smoke(), Some(fire(Some(kelvin.unwrap()))))),
    ]
}

#[test]
fn emission_under_a_ramp_is_integrated_exactly() {
    const N: u32 = 400_000;
    let ramped = Ramped::new(grid(puffs), flame());
    let medium = medium(Density::Voxel(grid(puffs)), Some(Emission::Ramped(ramped)));
    let clear = Medium { sigma_t: Rgb::ZERO, ..medium };
    for (ray, span) in rays() {
        let dt = span.length() / f64::from(N);
        let at = |i: u32| clear.emission_at(ray.at(span.start + (f64::from(i) + 0.5) * dt));
        let brute = (0..N).map(at).sum::<Rgb>() * dt;
        let found = clear.emission_apart(&ray, span);
        let limit = 50.0 * 4.0 * dt;
        assert!((found - brute).abs().max_element() < limit, "{found} for {brute}");
    }
    let rays = rays();
    let media = Media::new(vec![clear]);
    for (ray, span) in rays {
        let mut profile: Profile = Profile::default();
        profile.trace(&media, &ray, span, 0.5 * VOXEL, 0.5);
        let off = profile.emitted() - media.get(0).emission_apart(&ray, span);
        assert!(off.abs().max_element() < 1e-9, "{off}");
    }
}

/// Photons carry all the power, against places spread evenly over the box.
#[test]
fn photons_leave_all_that_a_ramp_makes_glow() {
    const N: u32 = 400_000;
    for (index, (name, medium)) in (0..).zip(glowing()) {
        let sampler = EmissionSampler::new(&medium).unwrap().unwrap();
        let mut rng = Stream::new(5, Stage::Test, index, 0);
        let side = 2.4;
        let mut evenly = || {
            let p = DVec3::from(std::array::from_fn(|_| (rng.uniform() - 0.5) * side));
            luminance(medium.emission_at(WorldPoint::from_xyz(p))) * 4.0 * PI * side.powi(3)
        };
        let expected = mean_and_error((0..N).map(|_| evenly()).collect());
        let mut rng = Stream::new(6, Stage::Test, index, 0);
        let mut photon = || sampler.emit(&medium, &mut rng).map_or(0.0, |s| luminance(s.power));
        let found = mean_and_error((0..N).map(|_| photon()).collect());
        let error = expected[1].hypot(found[1]);
        assert!(error < 0.03 * expected[0], "{name}: {expected:?}, {found:?}");
        assert!((found[0] - expected[0]).abs() < SIGMAS * error, "{name}: {expected:?}, {found:?}");
        let off = (sampler.power() / found[0]).log2().abs();
        assert!(off < 2.0, "{name}: {} for {found:?}", sampler.power());
    }
}

fn mean_and_error(values: Vec<f64>) -> [f64; 2] {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n;
    [mean, (variance / n).sqrt()]
}

#[test]
fn an_albedo_is_the_colour_of_the_value() {
    let stops = [(0.0, Rgb::ZERO), (1.0, Rgb::new(2.0, 1.0, 0.5))];
    let transfer = Transfer::new(Remap::default(), &stops).unwrap();
    let grid = grid(|p| (p.x / VOXEL + 8.0) / 24.0);
    let albedo = Albedo::Ramped(Ramped::new(grid.clone(), transfer));
    assert!(!albedo.is_grey() && !albedo.is_constant());
    for x in [0.0, 4.0, 10.5] {
        let p = grid.transform().point_to_world(IndexPoint::new(x, 3.0, 3.0));
        let value = (x + 8.0) / 24.0;
        let expected = Rgb::new((2.0 * value).min(1.0), value, 0.5 * value);
        assert!((albedo.at(p) - expected).abs().max_element() < 1e-6, "{}", albedo.at(p));
    }
}
