//! The march from thin to stiff: sigma_t dt from 1e-6 to 1e6, and its order of accuracy.

use super::case::{Case, Curve, Findings, Group};
use super::parts::Marched;
use super::{Check, Parts, fields};
use crate::error::Result;
use crate::math::Span;
use crate::medium::Media;

/// Steps of the sweep, in metres; voxels are 1 m.
const STEP: f64 = 4.0;
/// Where the marched span begins, in metres.
const START: f64 = 8.0;

pub(super) fn cases() -> Vec<Case> {
    vec![
        Case::new(
            Group::StiffSweep,
            "stiff/bounds",
            [
                "0 <= T <= 1; 0 <= L <= source function; L rises and T falls with depth",
                "rounding in f64",
            ],
            bounds,
        ),
        Case::new(
            Group::StiffSweep,
            "stiff/constant",
            ["L = 1 - exp(-tau): the step is exact for constant coefficients", "rounding in f64"],
            constant,
        ),
        Case::new(
            Group::StiffSweep,
            "stiff/order-at-the-middle",
            ["midpoint rule in tau: order 2", "observed between steps of 16 and 8 voxels"],
            |parts| order(parts, 0.5, 2.0),
        ),
        Case::new(
            Group::StiffSweep,
            "stiff/order-at-the-end",
            ["rectangle rule in tau: order 1", "observed between steps of 16 and 8 voxels"],
            |parts| order(parts, 0.0, 1.0),
        ),
        Case::new(
            Group::StiffSweep,
            "stiff/mean-over-jitter",
            [
                "the optical thickness of a jittered march has the exact mean",
                "512 jitters of a smooth density: rounding of voxels to f32",
            ],
            jittered,
        ),
    ]
}

/// sigma_t dt of the sweep.
fn sweep() -> impl Iterator<Item = f64> {
    (-12..=12).map(|i| 10f64.powf(f64::from(i) / 2.0))
}

/// Density that swells and ebbs, or is the same everywhere, emitting so that the source function
/// is 1.
fn medium(parts: &Parts, smooth: bool, sigma_t: f64) -> Result<Media> {
    let density = |x: i32| if smooth { 1.0 + 0.5 * (0.1 * f64::from(x)).sin() } else { 1.0 };
    fields::medium(parts, &fields::bar(64, density), sigma_t, sigma_t)
}

fn march(parts: &Parts, media: &Media, length: f64) -> Marched {
    let span = Span::new(START, START + length);
    (parts.march)(media, &fields::along_bar(), span, STEP, 0.5)
}

fn bounds(parts: &Parts) -> Result<Vec<Check>> {
    let mut checks = Vec::new();
    for x in sweep() {
        let media = medium(parts, true, x / STEP)?;
        let (mut light, mut through) = (0.0, 1.0);
        let (mut lowest, mut highest) = (f64::INFINITY, f64::NEG_INFINITY);
        let (mut fall, mut rise): (f64, f64) = (0.0, 0.0);
        for steps in 1..=10 {
            let marched = march(parts, &media, f64::from(steps) * STEP);
            let (l, t) = (marched.emitted.x, marched.transmittance.x);
            lowest = lowest.min(l).min(t);
            highest = highest.max(l).max(t);
            fall = fall.max(light - l);
            rise = rise.max(t - through);
            (light, through) = (l, t);
        }
        let name = |what: &str| format!("sigma_t dt = {x:.1e}: {what}");
        checks.push(Check::within(name("least of L and T"), lowest, 0.0, 1.0));
        checks.push(Check::within(name("most of L and T"), highest, 0.0, 1.0 + 1e-12));
        // A step resamples the density elsewhere where the span is longer; what was seen before
        // stays as it was, for the steps are the same.
        checks.push(Check::at_most(name("largest fall of L with depth"), fall, 1e-12));
        checks.push(Check::at_most(name("largest rise of T with depth"), rise, 1e-12));
    }
    Ok(checks)
}

/// Relative error that rounding may bring.
const RELATIVE: f64 = 1e-12;

fn constant(parts: &Parts) -> Result<Findings> {
    let mut findings = Findings::default();
    let mut points = Vec::new();
    for x in sweep() {
        let marched = march(parts, &medium(parts, false, x / STEP)?, 10.0 * STEP);
        let tau = 10.0 * x;
        let error = marched.emitted.x / -(-tau).exp_m1() - 1.0;
        let what = format!("sigma_t dt = {x:.1e}: relative error of L");
        findings.checks.push(Check::near(what, error, 0.0, RELATIVE));
        let off = marched.transmittance.x - (-tau).exp();
        let what = format!("sigma_t dt = {x:.1e}: error of T");
        findings.checks.push(Check::near(what, off, 0.0, 1e-13));
        points.push([x, error.abs().max(1e-17)]);
    }
    let theory = points.iter().map(|p| [p[0], RELATIVE]).collect();
    findings.curves.push(Curve {
        name: "Exponential integrator in a constant medium".into(),
        axes: ["sigma_t dt", "relative error of L"],
        points,
        theory,
        theory_name: "bound",
    });
    Ok(findings)
}

/// A smooth density and its optical thickness for sigma_t = 1 over the marched span.
const LENGTH: f64 = 256.0;

fn rising(x: i32) -> f64 {
    (f64::from(x) / LENGTH).powi(2) / LENGTH
}

fn error_at(parts: &Parts, step: f64, jitter: f64) -> Result<f64> {
    let media = fields::medium(parts, &fields::bar(272, rising), 4.0, 0.0)?;
    let ray = fields::along_bar();
    let exact = media.optical_thickness(&ray, Span::new(0.0, LENGTH)).x;
    let marched = (parts.march)(&media, &ray, Span::new(0.0, LENGTH), step, jitter);
    Ok((marched.transmittance.x - (-exact).exp()).abs())
}

fn order(parts: &Parts, jitter: f64, theory: f64) -> Result<Findings> {
    let mut points = Vec::new();
    for step in [64.0, 32.0, 16.0, 8.0, 4.0] {
        points.push([step, error_at(parts, step, jitter)?]);
    }
    let observed = (points[2][1] / points[3][1]).log2();
    let checks = vec![Check::near("observed order", observed, theory, 0.1)];
    let last = points[points.len() - 1];
    let theory = points.iter().map(|p| [p[0], last[1] * (p[0] / last[0]).powf(theory)]).collect();
    let curve = Curve {
        name: format!("Order of accuracy, density sampled at {jitter} of a step: {observed:.3}"),
        axes: ["step, voxels", "error of T"],
        points,
        theory,
        theory_name: "theory",
    };
    Ok(Findings { checks, curves: vec![curve] })
}

fn jittered(parts: &Parts) -> Result<Vec<Check>> {
    const N: u32 = 512;
    let media = fields::medium(parts, &fields::bar(272, rising), 4.0, 0.0)?;
    let ray = fields::along_bar();
    let span = Span::new(0.0, LENGTH);
    let exact = media.optical_thickness(&ray, span).x;
    let check = |step: f64| {
        let thickness = |i: u32| {
            let jitter = (f64::from(i) + 0.5) / f64::from(N);
            -(parts.march)(&media, &ray, span, step, jitter).transmittance.x.ln()
        };
        let mean = (0..N).map(thickness).sum::<f64>() / f64::from(N);
        Check::near(format!("step {step}: relative error"), mean / exact - 1.0, 0.0, 1e-4)
    };
    Ok([3.7, 16.0, 100.0, 1e4].map(check).to_vec())
}
