//! What the values of grids stand for, against closed forms: a background that is not 0, a ramp with
//! a jump.

use glam::{DVec3, IVec3};

use super::case::{Case, Group};
use super::{Check, Parts, fields};
use crate::error::{Error, Result};
use crate::math::{Ray, Rgb, Span, Stage, Stream, World, WorldPoint};
use crate::medium::{Albedo, Density, Media, Medium, Phase, Ramped, Remap, Transfer};
use crate::vdb::GridToWrite;

/// Within this many standard errors a mean is right: one false alarm in 150,000.
const SIGMAS: f64 = 4.5;

/// Flights by which a transmittance is estimated.
const FLIGHTS: u32 = 20_000;

pub(super) fn cases() -> Vec<Case> {
    let case = |name: &str, words, run: fn(&Parts) -> Result<Vec<Check>>| {
        Case::new(Group::ClosedForms, name, words, run)
    };
    vec![
        case(
            "background/transmittance",
            [
                "exp(-sigma_t s) over the box of the active voxels and their neighbours",
                "f64 rounding; 4.5 standard errors where flights are counted, fixed seed",
            ],
            background,
        ),
        case(
            "ramp/jump",
            [
                "exp(-integral) of a density that jumps within a cell",
                "f64 rounding and voxels of f32; 4.5 standard errors where flights are counted, \
                 fixed seed",
            ],
            jump,
        ),
    ]
}

/// A grid of 16³ active voxels amid a background of the same value: a box of 17 voxels' edge.
pub(super) fn even_box(value: f32) -> GridToWrite {
    let mut grid = fields::blocks("density", 1.0, IVec3::ZERO, IVec3::splat(2), |_| value.into());
    grid.background = [value, 0.0, 0.0];
    for block in &mut grid.blocks {
        block.active = Some([u64::MAX; 8]);
    }
    grid
}

fn background(parts: &Parts) -> Result<Vec<Check>> {
    let mut checks = Vec::new();
    let rays: [(DVec3, DVec3, f64); 3] = [
        (DVec3::new(-9.0, 3.3, 4.4), DVec3::X, 17.0),
        (DVec3::new(5.5, 20.0, 15.9), DVec3::NEG_Y, 17.0),
        (DVec3::new(4.0, 5.0, 6.0), DVec3::new(0.6, 0.0, 0.8), 12.5),
    ];
    for value in [1.0f32, 0.001] {
        let sigma_t = 0.1 / f64::from(value);
        let media = fields::medium(parts, &even_box(value), sigma_t, 0.0)?;
        for (index, (origin, direction, length)) in (0..).zip(rays) {
            let ray = Ray::new(WorldPoint::from_xyz(origin), direction);
            let what = format!("background {value}, ray {index}");
            checks.extend(against(parts, &media, &ray, 0.1 * length, index, &what));
        }
    }
    Ok(checks)
}

/// A density of 0.5 before and 3 after the plane where the value of a bar crosses one of the stops.
fn jump(parts: &Parts) -> Result<Vec<Check>> {
    let bar = fields::bar(64, |x| f64::from(x) / 64.0);
    let at = 30.7;
    let stops = [(at / 64.0, 0.5), (at / 64.0, 3.0)];
    let transfer = Transfer::new(Remap::default(), &stops).map_err(Error::Usage)?;
    let density = Density::Ramped(Ramped::new((parts.export)(&bar)?, transfer));
    let media = Media::new(vec![Medium {
        density,
        sigma_t: Rgb::splat(0.1),
        albedo: Albedo::Constant(Rgb::ZERO),
        phase: Phase::ISOTROPIC,
        emission: None,
    }]);
    let mut checks = Vec::new();
    for (index, (start, end)) in (10..).zip([(20.0, 30.0), (20.0, 40.0), (30.65, 30.8)]) {
        let mut ray = fields::along_bar();
        ray.origin = ray.origin + DVec3::X * start;
        let before = (at - start).clamp(0.0, end - start);
        let tau = 0.1 * (0.5 * before + 3.0 * (end - start - before));
        let span = Span::new(0.0, end - start);
        let what = format!("{start} to {end} voxels");
        let found = (parts.march)(&media, &ray, span, 1.0, 0.5).transmittance.x;
        let off = found / (-tau).exp() - 1.0;
        checks.push(Check::near(format!("{what}: relative error of T"), off, 0.0, 1e-6));
        checks.push(flown(parts, &media, &ray, span, tau, index, &what));
    }
    Ok(checks)
}

/// Marches by fine and coarse steps and free flight along all of a ray, whose optical thickness is
/// `tau`.
fn against(
    parts: &Parts,
    media: &Media,
    ray: &Ray<World>,
    tau: f64,
    index: u64,
    what: &str,
) -> Vec<Check> {
    let mut checks = Vec::new();
    for step in [0.5, 7.0] {
        let found = (parts.march)(media, ray, Span::AHEAD, step, 0.5).transmittance.x;
        let off = found / (-tau).exp() - 1.0;
        let what = format!("{what}, step {step}: relative error of T");
        checks.push(Check::near(what, off, 0.0, 1e-6));
    }
    checks.push(flown(parts, media, ray, Span::AHEAD, tau, index, what));
    checks
}

/// The share of flights without a collision.
fn flown(
    parts: &Parts,
    media: &Media,
    ray: &Ray<World>,
    span: Span,
    tau: f64,
    index: u64,
    what: &str,
) -> Check {
    let mut rng = Stream::new(9, Stage::Test, index, 0);
    let free = (0..FLIGHTS).filter(|_| (parts.free_flight)(media, ray, span, &mut rng).is_none());
    let found = free.count() as f64 / f64::from(FLIGHTS);
    let expected = (-tau).exp();
    let error = (expected * (1.0 - expected) / f64::from(FLIGHTS)).sqrt();
    Check::near(format!("{what}: share without a collision"), found, expected, SIGMAS * error)
}
