//! Light along one ray against closed forms: Beer-Lambert, free flight, phase functions.

use std::f64::consts::{PI, TAU};

use glam::{DAffine3, DVec3, IVec3};

use super::case::{Case, Group};
use super::known::erf;
use super::{Check, Parts, fields};
use crate::error::{Error, Result};
use crate::math::{Ray, Rgb, Span, Stage, Stream, World, WorldPoint};
use crate::medium::{Albedo, Density, Media, Medium, Phase};
use crate::shape::{Cuboid, Region};
use crate::vdb::{GridToWrite, Tile};

/// Within this many standard errors a mean is right: one false alarm in 150,000.
const SIGMAS: f64 = 4.5;

pub(super) fn cases() -> Vec<Case> {
    let case = |name: &str, words, run: fn(&Parts) -> Result<Vec<Check>>| {
        Case::new(Group::ClosedForms, name, words, run)
    };
    vec![
        case(
            "beer-lambert/constant",
            ["exp(-sigma_t s)", "rounding in f64, times the optical thickness"],
            constant,
        ),
        case(
            "beer-lambert/ramp",
            ["exp(-integral of a ramp): quadratic", "cells are integrated exactly; f64 rounding"],
            ramp,
        ),
        case(
            "beer-lambert/gaussian",
            [
                "exp(-integral of a Gaussian): erf",
                "voxels are f32 (6e-8 each) and trilinear: the trapezoidal rule, whose error is \
                 h²/12 times the slope at the end",
            ],
            gaussian,
        ),
        case(
            "beer-lambert/tiles",
            ["edge of a block of constant density", "f64 rounding: tiles carry density too"],
            tiles,
        ),
        case(
            "transmittance/reciprocity",
            ["T(a, b) = T(b, a)", "f64 rounding, times the optical thickness"],
            both_ways,
        ),
        case(
            "free-flight/spikes",
            ["probability of no collision: exp(-tau)", "4.5 standard errors, fixed seed"],
            free_flight,
        ),
        case(
            "phase/normalization",
            ["integral over the sphere is 1", "adaptive Simpson to 1e-9"],
            |parts| over_phases(|phase| (over_sphere(parts, phase, |_| 1.0), 1.0)),
        ),
        case(
            "phase/mean-cosine",
            ["mean cosine of the function", "adaptive Simpson to 1e-9"],
            |parts| over_phases(|phase| (over_sphere(parts, phase, |c| c), phase.mean_cosine())),
        ),
        case(
            "phase/samples",
            ["mean cosine of samples is that of the function", "4.5 standard errors, fixed seed"],
            |_| Ok(phases().iter().map(|(name, phase)| sampled(name, phase)).collect()),
        ),
    ]
}

fn constant(parts: &Parts) -> Result<Vec<Check>> {
    let mut checks = Vec::new();
    let grid = fields::bar(64, |_| 1.0);
    let cuboid = Cuboid::new(DVec3::new(0.0, -8.0, -8.0), DVec3::splat(64.0), &DAffine3::IDENTITY)
        .map_err(Error::Usage)?;
    for tau in [1e-8, 1e-3, 1.0, 30.0, 600.0] {
        let sigma_t = tau / 40.0;
        let box_medium = Medium {
            density: Density::Homogeneous(Region::Box(cuboid)),
            sigma_t: Rgb::splat(sigma_t),
            albedo: Albedo::Constant(Rgb::ZERO),
            phase: Phase::ISOTROPIC,
            emission: None,
        };
        let kinds = [
            ("box", Media::new(vec![box_medium])),
            ("grid", fields::medium(parts, &grid, sigma_t, 0.0)?),
        ];
        for (kind, media) in kinds {
            for step in [0.5, 7.0] {
                let span = Span::new(10.0, 50.0);
                let found = (parts.march)(&media, &fields::along_bar(), span, step, 0.5);
                let relative = found.transmittance.x / (-tau).exp() - 1.0;
                let what = format!("{kind}, thickness {tau:e}, step {step}: relative error of T");
                checks.push(Check::near(what, relative, 0.0, 1e-14 + 1e-14 * tau));
            }
        }
    }
    Ok(checks)
}

fn ramp(parts: &Parts) -> Result<Vec<Check>> {
    let media = fields::medium(parts, &fields::bar(64, |x| f64::from(x) / 64.0), 0.5, 0.0)?;
    let thickness = |a: f64, b: f64| 0.5 * (b * b - a * a) / 128.0;
    let spans = [(0.0, 56.0), (3.25, 41.5), (17.0, 17.001)];
    let check = |(a, b): (f64, f64)| {
        let found = (parts.march)(&media, &fields::along_bar(), Span::new(a, b), 1.0, 0.5);
        let relative = found.transmittance.x / (-thickness(a, b)).exp() - 1.0;
        Check::near(format!("{a} to {b} voxels: relative error of T"), relative, 0.0, 1e-12)
    };
    Ok(spans.map(check).to_vec())
}

fn gaussian(parts: &Parts) -> Result<Vec<Check>> {
    let (width, middle) = (8.0, 64.0);
    let density = |x: i32| (-0.5 * ((f64::from(x) - middle) / width).powi(2)).exp();
    let media = fields::medium(parts, &fields::bar(128, density), 0.1, 0.0)?;
    let scale = 0.1 * width * (0.5 * PI).sqrt();
    let check = |deviations: f64| {
        let end = middle + deviations * width;
        let span = Span::new(middle - 7.5 * width, end);
        let found = (parts.march)(&media, &fields::along_bar(), span, 1.0, 0.5);
        let cut = deviations / 2f64.sqrt();
        let thickness = scale * (erf(7.5 / 2f64.sqrt()) + erf(cut));
        let slope = 0.1 * deviations / width * (-0.5 * deviations * deviations).exp();
        let what = format!("to {deviations} standard deviations: optical thickness");
        Check::near(what, -found.transmittance.x.ln(), thickness, 1e-6 + 1.05 * slope / 12.0)
    };
    Ok([0.0, 1.0, 2.0, 7.0].map(check).to_vec())
}

/// A block of 6³ blocks of density 1: leaves on the outside, tiles within.
pub(super) fn tiled_block() -> GridToWrite {
    let mut grid = GridToWrite::fog("density", 1.0, DVec3::ZERO);
    for index in 0..216 {
        let at = IVec3::new(index % 6, index / 6 % 6, index / 36);
        let origin = at * 8;
        if at.cmpeq(IVec3::ZERO).any() || at.cmpeq(IVec3::splat(5)).any() {
            grid.blocks.push(fields::block(origin, |_| 1.0));
        } else {
            grid.tiles.push(Tile { origin, edge: 8, value: [1.0, 0.0, 0.0], active: true });
        }
    }
    grid
}

fn tiles(parts: &Parts) -> Result<Vec<Check>> {
    let media = fields::medium(parts, &tiled_block(), 0.1, 0.0)?;
    let ray = Ray::new(WorldPoint::new(-10.0, 20.3, 25.4), DVec3::X);
    // 47 voxels between the outermost samples, and half a voxel's worth of falling off on each side.
    let found = (parts.march)(&media, &ray, Span::AHEAD, 1.0, 0.5);
    let thickness = -found.transmittance.x.ln();
    Ok(vec![Check::near("optical thickness", thickness, 4.8, 1e-12)])
}

fn both_ways(parts: &Parts) -> Result<Vec<Check>> {
    let media = fields::medium(parts, &spikes(), 0.02, 0.0)?;
    let mut rng = Stream::new(5, Stage::Test, 1, 0);
    let check = |index| {
        let end = |rng: &mut Stream| {
            DVec3::from_array(std::array::from_fn(|_| rng.uniform() * 40.0 - 12.0))
        };
        let (a, b) = (end(&mut rng), end(&mut rng));
        let way = |a: DVec3, b: DVec3| {
            let ray = Ray::new(WorldPoint::from_xyz(a), (b - a).normalize());
            (parts.march)(&media, &ray, Span::new(0.0, (b - a).length()), 1.0, 0.5).transmittance.x
        };
        let relative = way(a, b) / way(b, a) - 1.0;
        // Rounding of a place by 1e-14 voxels moves what a spike of 50 takes out.
        Check::near(format!("ray {index}: relative difference"), relative, 0.0, 1e-11)
    };
    Ok((0..20).map(check).collect())
}

/// Thin smoke with spikes of one voxel.
pub(super) fn spikes() -> GridToWrite {
    fields::blocks("density", 1.0, IVec3::splat(-1), IVec3::splat(2), |v| {
        if (v & 3) == IVec3::splat(1) { 50.0 } else { 0.5 }
    })
}

fn free_flight(parts: &Parts) -> Result<Vec<Check>> {
    const N: u32 = 20_000;
    let media = fields::medium(parts, &spikes(), 0.02, 0.0)?;
    let rays: [(DVec3, DVec3); 3] = [
        (DVec3::new(-20.0, 1.2, 1.1), DVec3::X),
        (DVec3::new(-20.0, 5.3, 0.9), DVec3::new(1.0, 0.03, -0.02)),
        (DVec3::new(2.0, 3.0, 4.0), DVec3::new(0.3, -0.5, 0.6)),
    ];
    let check = |(index, (origin, direction)): (u64, (DVec3, DVec3))| {
        let ray: Ray<World> = Ray::new(WorldPoint::from_xyz(origin), direction.normalize());
        let exact = media.transmittance(&ray, Span::AHEAD).x;
        let mut rng = Stream::new(6, Stage::Test, index, 0);
        let free =
            (0..N).filter(|_| (parts.free_flight)(&media, &ray, Span::AHEAD, &mut rng).is_none());
        let found = free.count() as f64 / f64::from(N);
        let error = (exact * (1.0 - exact) / f64::from(N)).sqrt();
        Check::near(format!("ray {index}: share without a collision"), found, exact, SIGMAS * error)
    };
    Ok((0..).zip(rays).map(check).collect())
}

/// One row a kind, narrow ones included.
fn phases() -> Vec<(String, Phase)> {
    let mut rows =
        vec![("isotropic".to_owned(), Phase::ISOTROPIC), ("rayleigh".to_owned(), Phase::RAYLEIGH)];
    let mut push = |name: String, phase: Result<Phase, String>| {
        rows.extend(phase.ok().map(|phase| (name, phase)));
    };
    for g in [-0.9999, -0.5, 1e-9, 0.5, 0.99, 0.9999] {
        push(format!("henyey-greenstein {g}"), Phase::henyey_greenstein(g));
    }
    push("two-lobe 0.9999 -0.9999".into(), Phase::two_lobe(0.9999, -0.9999, 0.5));
    for diameter in [0.05, 1.0, 20.0, 50.0] {
        push(format!("fog {diameter} um"), Phase::fog(diameter));
    }
    rows
}

fn over_phases(integral: impl Fn(&Phase) -> (f64, f64)) -> Result<Vec<Check>> {
    let check = |(name, phase): (String, Phase)| {
        let (found, expected) = integral(&phase);
        Check::near(name, found, expected, 1e-8)
    };
    Ok(phases().into_iter().map(check).collect())
}

/// Integral of `f` times the phase function over the sphere, on intervals that shrink toward both
/// poles, where the lobes are.
fn over_sphere(parts: &Parts, phase: &Phase, f: impl Fn(f64) -> f64) -> f64 {
    let integrand = |cos_theta: f64| TAU * (parts.phase)(phase, cos_theta) * f(cos_theta);
    let mut edges: Vec<f64> = (0..48).map(|i| 0.5f64.powi(i)).collect();
    edges.push(0.0);
    edges.windows(2).fold(0.0, |sum, pair| {
        let (a, b) = (pair[1], pair[0]);
        sum + simpson(&|drop| integrand(1.0 - drop), a, b, 16)
            + simpson(&|drop| integrand(drop - 1.0), a, b, 16)
    })
}

fn simpson(f: &dyn Fn(f64) -> f64, a: f64, b: f64, depth: u32) -> f64 {
    let rule = |a: f64, b: f64| (b - a) / 6.0 * (f(a) + 4.0 * f(0.5 * (a + b)) + f(b));
    let middle = 0.5 * (a + b);
    let (whole, halves) = (rule(a, b), rule(a, middle) + rule(middle, b));
    if depth == 0 || (whole - halves).abs() < 1e-11 {
        halves + (halves - whole) / 15.0
    } else {
        simpson(f, a, middle, depth - 1) + simpson(f, middle, b, depth - 1)
    }
}

fn sampled(name: &str, phase: &Phase) -> Check {
    const N: u32 = 20_000;
    let mut rng = Stream::new(7, Stage::Test, 0, 0);
    let incoming = DVec3::new(0.6, 0.0, -0.8);
    let (mut sum, mut squares) = (0.0, 0.0);
    for _ in 0..N {
        let cos_theta = phase.sample(incoming, rng.uniform2()).0.dot(incoming);
        sum += cos_theta;
        squares += cos_theta * cos_theta;
    }
    let mean = sum / f64::from(N);
    let error = ((squares / f64::from(N) - mean * mean).max(0.0) / f64::from(N)).sqrt();
    Check::near(name, mean, phase.mean_cosine(), SIGMAS * error + 1e-12)
}
