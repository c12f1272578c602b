//! Free flight, ratio tracking, profiles and emission against exact optical thickness and integrals.
//!
//! Seeds are fixed. Each comparison of a mean allows 4.5 standard errors, each distribution a false
//! alarm in 10^6; with some hundred of them a sound build fails with a chance below 10^-3.

use std::f64::consts::PI;

use fogbow::math::{Ray, Rgb, Span, Stage, Stream, World, WorldPoint, luminance};
use fogbow::medium::blackbody::Blackbody;
use fogbow::medium::{
    Albedo, Density, Emission, EmissionSampler, Media, Medium, Phase, Piece, Profile,
};
use fogbow::shape::{Cuboid, Region, Sphere};
use fogbow::vdb::{Grid, Tile};
use fogbow::work::Work;
use glam::{DAffine3, DVec3, IVec3};

use crate::fields::{VOXEL, grid, puffs};

const SIGMAS: f64 = 4.5;

fn stream(index: u64) -> Stream {
    Stream::new(5, Stage::Test, index, 0)
}

/// Noise from voxel to voxel, which local majorants bound badly.
fn speckles(p: DVec3) -> f64 {
    let hash = (p.dot(DVec3::new(127.1, 311.7, 74.7)).sin() * 43_758.547).fract().abs();
    if p.abs().max_element() < 0.9 && hash > 0.7 { hash } else { 0.0 }
}

fn medium(density: Density, sigma_t: Rgb) -> Medium {
    let albedo = Albedo::Constant(Rgb::splat(0.5));
    Medium { density, sigma_t, albedo, phase: Phase::ISOTROPIC, emission: None }
}

fn cuboid(min: DVec3, max: DVec3) -> Density {
    Density::Homogeneous(Region::Box(Cuboid::new(min, max, &DAffine3::IDENTITY).unwrap()))
}

fn ball(radius: f64) -> Density {
    let center = DVec3::new(0.1, 0.0, -0.1);
    Density::Homogeneous(Region::Sphere(Sphere::new(center, radius, &DAffine3::IDENTITY).unwrap()))
}

/// Media of every kind, alone and overlapping.
fn fixtures() -> Vec<(&'static str, Media)> {
    let grey = Rgb::splat;
    let coloured = Rgb::new(3.0, 1.0, 0.2);
    let tile = Tile { origin: IVec3::new(16, 0, 0), edge: 8, value: [0.5, 0.0, 0.0], active: true };
    let side = cuboid(DVec3::new(-0.5, -0.6, -0.7), DVec3::new(0.2, 0.5, 0.4));
    vec![
        ("box", Media::new(vec![medium(cuboid(-DVec3::ONE, DVec3::ONE), grey(1.2))])),
        ("ball", Media::new(vec![medium(ball(0.6), coloured)])),
        ("grid", Media::new(vec![medium(Density::Voxel(grid(0.0, puffs, vec![])), grey(2.5))])),
        (
            "turned grid with a tile",
            Media::new(vec![medium(Density::Voxel(grid(0.7, puffs, vec![tile])), coloured)]),
        ),
        (
            "thick speckles",
            Media::new(vec![medium(Density::Voxel(grid(0.2, speckles, vec![])), grey(8.0))]),
        ),
        (
            "grid in a box",
            Media::new(vec![
                medium(Density::Voxel(grid(0.3, puffs, vec![])), grey(1.5)),
                medium(side, coloured),
            ]),
        ),
        (
            "two grids and a ball",
            Media::new(vec![
                medium(Density::Voxel(grid(0.0, puffs, vec![])), coloured),
                medium(Density::Voxel(grid(1.1, speckles, vec![])), grey(1.0)),
                medium(ball(0.5), Rgb::new(0.0, 0.3, 0.6)),
            ]),
        ),
    ]
}

/// Rays from outside, from within, along an axis; endless and ended.
fn rays() -> Vec<(Ray<World>, Span)> {
    let ray = |o: [f64; 3], d: [f64; 3]| {
        Ray::new(WorldPoint::from_xyz(DVec3::from(o)), DVec3::from(d).normalize())
    };
    vec![
        (ray([-3.0, 0.1, 0.2], [1.0, 0.02, -0.05]), Span::AHEAD),
        (ray([0.05, 0.3, 4.0], [0.0, 0.0, -1.0]), Span::AHEAD),
        (ray([0.1, -0.1, 0.0], [0.3, 0.5, -0.4]), Span::AHEAD),
        (ray([2.0, 1.9, 2.1], [-1.0, -1.0, -1.0]), Span::new(1.0, 3.7)),
    ]
}

#[test]
fn the_first_real_collision_is_distributed_as_optical_depth_says() {
    const N: u32 = 4000;
    // Massart 1990: P(sup |F_n - F| > x) <= 2 exp(-2 n x²), also with an atom at the end.
    let limit = ((2e6_f64).ln() / (2.0 * f64::from(N))).sqrt();
    let mut index = 100;
    for (name, media) in fixtures() {
        for (ray, span) in rays() {
            for channel in 0..3 {
                index += 1;
                let mut rng = stream(index);
                let mut collisions = Vec::new();
                for _ in 0..N {
                    let mut flights = media.flights(&ray, span, Rgb::ONE, &mut rng);
                    while let Some(c) = flights.next(&mut rng) {
                        let real = media.get(c.medium).sigma_t[channel] * c.density / c.majorant;
                        assert!(real <= 1.0 + 1e-12, "{name}: majorant exceeded by {real}");
                        if rng.uniform() < real {
                            collisions.push(c.t);
                            break;
                        }
                    }
                }
                collisions.sort_by(f64::total_cmp);
                let mut distance: f64 = 0.0;
                let opacity =
                    |end: f64| 1.0 - media.transmittance(&ray, Span::new(span.start, end))[channel];
                for (i, t) in collisions.iter().enumerate() {
                    let expected = opacity(*t) * f64::from(N);
                    let (below, above) = (i as f64 - expected, (i + 1) as f64 - expected);
                    distance = distance.max(below.abs()).max(above.abs());
                }
                let at_end = collisions.len() as f64 - opacity(span.end) * f64::from(N);
                let distance = distance.max(at_end.abs()) / f64::from(N);
                assert!(distance < limit, "{name}, channel {channel}: {distance} over {limit}");
            }
        }
    }
}

/// Mean of `n` draws per channel is `expected`, within [`SIGMAS`] standard errors.
fn assert_mean(what: &str, n: u32, expected: Rgb, mut draw: impl FnMut() -> Rgb) {
    let (mut sum, mut squares) = (Rgb::ZERO, Rgb::ZERO);
    for _ in 0..n {
        let value = draw() - expected;
        sum += value;
        squares += value * value;
    }
    let n = f64::from(n);
    let off = (sum / n).abs();
    let error = Rgb::from(((squares / n - off * off) / n).to_array().map(|v| v.max(0.0).sqrt()));
    let limit = error * SIGMAS + expected.abs() * 1e-9 + 1e-12;
    assert!(off.cmple(limit).all(), "{what}: {expected} off by {off}, one sigma {error}");
}

#[test]
fn ratio_tracking_is_unbiased() {
    let mut index = 1000;
    for (name, media) in fixtures() {
        for (ray, span) in rays() {
            index += 1;
            let mut rng = stream(index);
            let mut work = Work::default();
            assert_mean(name, 4000, media.transmittance(&ray, span), || {
                media.ratio_tracking(&ray, span, &mut rng, &mut work)
            });
        }
    }
}

fn traced(media: &Media, ray: &Ray<World>, span: Span, step: f64, jitter: f64) -> Profile {
    let mut profile = Profile::default();
    profile.trace(media, ray, span, step, jitter);
    profile
}

#[test]
fn a_fine_profile_is_exact() {
    for (name, media) in fixtures() {
        for (ray, span) in rays() {
            let profile = traced(&media, &ray, span, VOXEL * 0.5, 0.3);
            let near = |a: Rgb, b: Rgb| (a - b).abs().cmple(b.abs() * 1e-9 + 1e-12).all();
            let exact = media.optical_thickness(&ray, span);
            let found = profile.optical_thickness();
            assert!(near(found, exact), "{name}: {found} for {exact}");
            assert!(near(profile.transmittance(), (-exact).exp()), "{name}");

            let mut end = span.start;
            for piece in profile.pieces() {
                assert!(piece.span.start >= end && !piece.span.is_empty(), "{name}: {piece:?}");
                end = piece.span.end;
                // Where media overlap a cell may be cut, with its mean on both sides.
                let until = media.optical_thickness(&ray, Span::new(span.start, piece.span.start));
                let exact = near(piece.before, until) || media.len() > 1;
                assert!(exact, "{name}: {piece:?} after {until}");

                let middle = (piece.span.start + piece.span.end) / 2.0;
                let (transmittance, sigma_t) = profile.at(middle).unwrap();
                let along = middle - piece.span.start;
                assert_eq!(transmittance, (-piece.thickness_to(along)).exp(), "{name}");
                assert!(near(sigma_t, piece.sigma_t), "{name}");
                assert_eq!(sigma_t, piece.sigma_t_at(along), "{name}");
            }
            assert!(end <= span.end);
            assert!(profile.at(end + 1.0).is_none() && profile.at(span.start - 1.0).is_none());
        }
    }
}

/// Where density is a straight line within each cell, a profile is exact also between its borders,
/// however thick a cell is.
#[test]
fn a_profile_knows_how_extinction_rises_within_cells() {
    let stripes = |p: DVec3| (p.x / VOXEL * 12.9898).sin().abs();
    let other = |p: DVec3| (p.y / VOXEL * 78.233).sin().abs();
    for sigma_t in [1.0, 300.0, 1e5] {
        let along_x = || medium(Density::Voxel(grid(0.4, stripes, vec![])), Rgb::splat(sigma_t));
        let along_y =
            || medium(Density::Voxel(grid(1.3, other, vec![])), Rgb::splat(sigma_t) * 0.3);
        for media in [vec![along_x()], vec![along_x(), along_y()]] {
            let media = Media::new(media);
            for (ray, _) in rays() {
                // Where no cell touches the faces of the grid.
                let middle = -ray.origin.xyz.dot(ray.direction);
                let span = Span::new(middle - 0.6, middle + 0.6).intersect(Span::AHEAD);
                let profile = traced(&media, &ray, span, 0.0, 0.5);
                for i in 0..500 {
                    let t = span.start + span.length() * (f64::from(i) + 0.5) / 500.0;
                    let Some((transmittance, extinction)) = profile.at(t) else { panic!("{t}") };
                    let density = |m: &Medium| m.sigma_t * m.density.value(ray.at(t));
                    let expected: Rgb = media.iter().map(density).sum();
                    let off = (extinction - expected).abs().max_element();
                    assert!(off < 1e-6 * sigma_t, "{extinction} for {expected} at {t}");
                    let thickness = media.optical_thickness(&ray, Span::new(span.start, t)).x;
                    if thickness < 600.0 {
                        let off = (-transmittance.x.ln() - thickness).abs();
                        assert!(off < 1e-6 * (1.0 + thickness), "{off} at {t} behind {thickness}");
                    }
                }
            }
        }
    }
}

/// Light scatters where it does by the exact optical thickness, to a 32nd, however thick a cell is and
/// however its density bends.
#[test]
fn a_profile_tells_where_light_scatters_in_thick_cells() {
    for (name, field) in [("speckles", speckles as fn(DVec3) -> f64), ("puffs", puffs)] {
        for sigma_t in [1.0, 3.0, 10.0, 30.0, 1e3, 1e6, 1e9] {
            let density = Density::Voxel(grid(0.2, field, vec![]));
            let media = Media::new(vec![medium(density, Rgb::splat(sigma_t))]);
            for (ray, span) in rays() {
                let profile = traced(&media, &ray, span, 0.0, 0.5);
                let opacity = 1.0 - profile.transmittance().x;
                for i in 0..300 {
                    let u = (f64::from(i) + 0.5) / 300.0;
                    let Some(place) = profile.sample([u, 0.5]) else { continue };
                    let thickness = media.optical_thickness(&ray, Span::new(span.start, place.t)).x;
                    let wanted = -(-u * opacity).ln_1p();
                    let off = (thickness - wanted).abs();
                    assert!(off < 1.0 / 31.0, "{name} of {sigma_t:e}: {thickness} for {wanted}");
                }
            }
        }
    }
}

#[test]
fn a_profile_has_nothing_in_its_gaps() {
    let near = medium(cuboid(DVec3::splat(-1.0), DVec3::splat(-0.5)), Rgb::ONE);
    let far = medium(cuboid(DVec3::splat(0.5), DVec3::splat(1.0)), Rgb::ONE);
    let media = Media::new(vec![near, far]);
    let ray = Ray::new(WorldPoint::new(-2.0, -2.0, -2.0), DVec3::ONE.normalize());
    let profile = traced(&media, &ray, Span::AHEAD, 0.1, 0.5);
    let diagonal = 3f64.sqrt();
    assert_eq!(profile.pieces().len(), 2);
    assert!(profile.at(2.0 * diagonal).is_none());
    assert!(profile.at(1.25 * diagonal).is_some() && profile.at(2.75 * diagonal).is_some());
}

/// A source function that is neither smooth nor grey.
fn source(t: f64) -> Rgb {
    Rgb::new(1.0 + (3.0 * t).sin(), t.fract(), (-t).exp())
}

/// The integral of T sigma_t S over a piece, by the midpoint rule.
fn source_integral(piece: &Piece) -> Rgb {
    const N: u32 = 400;
    let dt = piece.span.length() / f64::from(N);
    (0..N)
        .map(|i| {
            let s = (f64::from(i) + 0.5) * dt;
            let flux = (-piece.thickness_to(s)).exp() * piece.sigma_t_at(s);
            flux * source(piece.span.start + s) * dt
        })
        .sum()
}

#[test]
fn places_in_a_profile_estimate_source_integrals_without_bias() {
    let mut index = 2000;
    let mut cases = fixtures();
    let one_channel = Rgb::new(0.0, 4.0, 0.0);
    cases.push(("green", Media::new(vec![medium(ball(0.7), one_channel)])));
    for (name, media) in cases {
        for (ray, span) in rays() {
            let profile = traced(&media, &ray, span, VOXEL, 0.5);
            let expected: Rgb = profile.pieces().iter().map(source_integral).sum();
            index += 1;
            let mut rng = stream(index);
            // The quadrature misses jumps of the source function by up to its spacing.
            let slack = expected * 1e-3;
            let (mut n, mut mean, mut squares) = (0.0, Rgb::ZERO, Rgb::ZERO);
            for _ in 0..20_000 {
                let sampled = profile.sample(rng.uniform2()).map(|place| (place.t, place.weight));
                let value = sampled.map_or(Rgb::ZERO, |(t, weight)| {
                    assert!(profile.at(t).is_some(), "{name}: {t} is in a gap");
                    weight * source(t)
                });
                n += 1.0;
                let before = value - mean;
                mean += before / n;
                squares += before * (value - mean);
            }
            let error = Rgb::from((squares / (n * n)).to_array().map(f64::sqrt));
            let off = (mean - expected).abs();
            let limit = error * SIGMAS + slack + 1e-12;
            assert!(off.cmple(limit).all(), "{name}: {mean} for {expected}, one sigma {error}");
        }
    }
}

#[test]
fn coarse_steps_converge_and_their_jitter_has_no_bias() {
    const N: u32 = 1000;
    for (name, media) in fixtures() {
        for (ray, span) in rays() {
            let exact = media.optical_thickness(&ray, span);
            let spread = |step: f64| -> Rgb {
                let offs = (0..N).map(|i| {
                    let jitter = (f64::from(i) + 0.5) / f64::from(N);
                    traced(&media, &ray, span, step, jitter).optical_thickness() - exact
                });
                let (sum, squares) = offs.fold((Rgb::ZERO, Rgb::ZERO), |(sum, squares), off| {
                    (sum + off, squares + off * off)
                });
                let bias = (sum / f64::from(N)).abs();
                assert!(
                    bias.cmple(exact * 2e-3 + 1e-9).all(),
                    "{name}, step {step}: {exact} off by {bias} in the mean"
                );
                Rgb::from((squares / f64::from(N)).to_array().map(f64::sqrt))
            };
            let (coarse, fine) = (spread(8.0 * VOXEL), spread(1.01 * VOXEL));
            assert!(
                fine.cmple(coarse * 0.5 + exact * 0.01 + 1e-9).all(),
                "{name}: {fine}, {coarse}"
            );
        }
    }
}

/// Blackbody emission of `grid`, in kelvin per unit.
fn blackbody(grid: Grid<f32>) -> Emission {
    Emission::Blackbody {
        grid,
        ramp: None,
        kelvin_scale: 1500.0,
        kelvin_offset: 300.0,
        scale: 1e-3,
        table: Blackbody::new(),
    }
}

fn warmth(p: DVec3) -> f64 {
    (1.2 - p.length()).max(0.0)
}

/// Glowing media of every kind.
fn glowing() -> Vec<(&'static str, Medium)> {
    let color = Rgb::new(2.0, 1.0, 0.25);
    let smoke = || medium(Density::Voxel(grid(0.4, puffs, vec![])), Rgb::new(1.0, 2.0, 3.0));
    let flames = || grid(0.9, puffs, vec![]);
    vec![
        ("density", Medium { emission: Some(Emission::Density(color)), ..smoke() }),
        ("grid", Medium { emission: Some(Emission::Grid { grid: flames(), color }), ..smoke() }),
        (
            "grid in a ball",
            Medium {
                emission: Some(Emission::Grid { grid: flames(), color }),
                ..medium(ball(0.5), Rgb::ONE)
            },
        ),
        (
            "ball",
            Medium { emission: Some(Emission::Density(color)), ..medium(ball(0.5), Rgb::ONE) },
        ),
        ("blackbody", Medium { emission: Some(blackbody(grid(0.4, warmth, vec![]))), ..smoke() }),
    ]
}

/// 4 pi times the integral of emission over each octant, by an even raster.
fn octant_powers(medium: &Medium) -> [Rgb; 8] {
    const N: i32 = 180;
    let half = 2.0;
    let edge = 2.0 * half / f64::from(N);
    let mut powers = [Rgb::ZERO; 8];
    for x in 0..N {
        for y in 0..N {
            for z in 0..N {
                let p = (IVec3::new(x, y, z).as_dvec3() + 0.5) * edge - half;
                powers[octant(p)] += medium.emission_at(WorldPoint::from_xyz(p));
            }
        }
    }
    powers.map(|sum| sum * 4.0 * PI * edge.powi(3))
}

fn octant(p: DVec3) -> usize {
    p.cmpgt(DVec3::ZERO).bitmask() as usize
}

#[test]
fn emission_sampling_gives_the_power_of_every_part() {
    const N: u32 = 40_000;
    for (index, (name, medium)) in (3000..).zip(glowing()) {
        let sampler = EmissionSampler::new(&medium).unwrap().unwrap();
        let expected = octant_powers(&medium);
        let mut rng = stream(index);
        let (mut sums, mut squares) = ([Rgb::ZERO; 8], [Rgb::ZERO; 8]);
        for _ in 0..N {
            if let Some(start) = sampler.emit(&medium, &mut rng) {
                assert!((start.ray.direction.length() - 1.0).abs() < 1e-12);
                let part = octant(start.ray.origin.xyz);
                sums[part] += start.power;
                squares[part] += start.power * start.power;
            }
        }
        let n = f64::from(N);
        for part in 0..8 {
            let mean = sums[part] / n;
            let variance = (squares[part] / n - mean * mean) / n;
            let error = Rgb::from(variance.to_array().map(|v| v.max(0.0).sqrt()));
            let off = (mean - expected[part]).abs();
            // The raster is good to a few parts in a thousand.
            let limit = error * SIGMAS + expected[part] * 4e-3;
            assert!(off.cmple(limit).all(), "{name}: {mean} for {}", expected[part]);
        }
        let power = luminance(expected.iter().sum());
        let near = if name.starts_with("blackbody") { 0.1 } else { 4e-3 };
        assert!((sampler.power() / power - 1.0).abs() < near, "{name}: {}", sampler.power());
    }
}

/// Soot on one side of a face and heat on the other: what glows lies between voxels of which none
/// does. Against places spread evenly over that layer.
#[test]
fn emission_sampling_misses_nothing_between_voxels() {
    const N: u32 = 1_000_000;
    let soot = |p: DVec3| if p.x < 0.0 { puffs(p) } else { 0.0 };
    let heat = |p: DVec3| if p.x < 0.0 { 0.0 } else { 2.0 * warmth(p) };
    let density = Density::Voxel(grid(0.0, soot, vec![]));
    let emission = Some(blackbody(grid(0.0, heat, vec![])));
    let medium = Medium { emission, ..medium(density, Rgb::ONE) };
    let sampler = EmissionSampler::new(&medium).unwrap().unwrap();
    let mut rng = stream(3500);
    let (low, size) = (DVec3::new(-0.2, -1.0, -1.0), DVec3::new(0.3, 2.0, 2.0));
    let mut evenly = || {
        let u = DVec3::from(std::array::from_fn(|_| rng.uniform()));
        let emission = medium.emission_at(WorldPoint::from_xyz(low + u * size));
        luminance(emission) * 4.0 * PI * size.element_product()
    };
    let expected = mean_and_error((0..N).map(|_| evenly()).collect());
    let mut rng = stream(3501);
    let mut photon = || sampler.emit(&medium, &mut rng).map_or(0.0, |s| luminance(s.power));
    let found = mean_and_error((0..N).map(|_| photon()).collect());
    let error = expected[1].hypot(found[1]);
    assert!(error < 0.02 * expected[0], "{expected:?}, {found:?}");
    assert!((found[0] - expected[0]).abs() < SIGMAS * error, "{expected:?}, {found:?}");
    // Eight places in a cell tell about how much it emits.
    assert!((sampler.power() / found[0]).log2().abs() < 1.0, "{} for {found:?}", sampler.power());
}

fn mean_and_error(values: Vec<f64>) -> [f64; 2] {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n;
    [mean, (variance / n).sqrt()]
}

/// Where emission is trilinear its density is that of the places, so that all photons are equal.
#[test]
fn photons_of_a_density_are_of_one_power() {
    for (name, medium) in glowing() {
        if name.starts_with("blackbody") {
            continue;
        }
        let sampler = EmissionSampler::new(&medium).unwrap().unwrap();
        let mut rng = stream(4000);
        for _ in 0..2000 {
            let start = sampler.emit(&medium, &mut rng).unwrap();
            let power = luminance(start.power);
            assert!((power / sampler.power() - 1.0).abs() < 1e-5, "{name}: {power}");
        }
    }
}

#[test]
fn what_does_not_glow_has_no_sampler_and_what_glows_without_end_is_refused() {
    let endless = || medium(Density::Homogeneous(Region::Everywhere), Rgb::ONE);
    assert!(EmissionSampler::new(&endless()).unwrap().is_none());
    let black =
        Medium { emission: Some(Emission::Density(Rgb::ZERO)), ..medium(ball(1.0), Rgb::ONE) };
    assert!(EmissionSampler::new(&black).unwrap().is_none());
    let glow = Medium { emission: Some(Emission::Density(Rgb::ONE)), ..endless() };
    let error = EmissionSampler::new(&glow).unwrap_err().to_string();
    assert!(error.contains("without end"), "{error}");
}

/// A medium without emission has a shorter way of its own.
#[test]
fn no_emission_is_traced_as_black_emission_is() {
    let smoke = |emission| {
        let density = Density::Voxel(grid(0.7, puffs, vec![]));
        Media::new(vec![Medium { emission, ..medium(density, Rgb::new(3.0, 1.0, 0.2)) }])
    };
    let (none, black) = (smoke(None), smoke(Some(Emission::Density(Rgb::ZERO))));
    for step in [0.5 * VOXEL, 4.0 * VOXEL] {
        for (ray, span) in rays() {
            let [a, b] = [&none, &black].map(|media| traced(media, &ray, span, step, 0.3));
            assert_eq!(a.optical_thickness(), b.optical_thickness());
            assert_eq!(a.pieces().len(), b.pieces().len());
            for (a, b) in a.pieces().iter().zip(b.pieces()) {
                assert_eq!((a.span, a.sigma_t, a.before), (b.span, b.sigma_t, b.before));
                assert_eq!((a.emission, b.emission), (Rgb::ZERO, Rgb::ZERO));
            }
            let [a, b] = [a, b].map(|profile| {
                let mut work = Work::default();
                profile.count(&mut work);
                work
            });
            assert_eq!(a, b);
        }
    }
}
