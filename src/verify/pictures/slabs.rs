//! Slabs and half-spaces: what they send back and let through.

use glam::IVec3;

use super::super::adding_doubling::slab;
use super::super::case::{Case, Curve, Effort, Findings, Group};
use super::super::known::HALF_SPACES;
use super::super::{Check, fields, scenes};
use super::{Closeness, Work, both, compare};
use crate::error::Result;

pub(super) fn cases(effort: Effort) -> Vec<Case> {
    let mut cases = slabs(effort);
    if effort == Effort::Full {
        cases.push(convergence());
    }
    cases.extend(half_spaces(effort));
    cases.extend(half_spaces_of_voxels(effort));
    cases.push(reciprocity(effort));
    cases
}

/// A medium seen from one place toward another, `height` metres of it, with these keys of `[render]`, of
/// `[[medium]]` and of `[[light]]`.
pub(super) fn orthographic(
    [from, to]: [[f64; 3]; 2],
    height: f64,
    render: &str,
    medium: &str,
    light: &str,
) -> String {
    format!(
        r#"
        [camera]
        type = "orthographic"
        position = {from:?}
        target = {to:?}
        up = [0.0, 0.0, 1.0]
        height = {height:?}
        [film]
        size = [8, 8]
        [render]
        {render}
        [[medium]]
        {medium}
        [[light]]
        {light}
        "#
    )
}

/// The keys of a sky that shines from above.
const SKY: &str = "type = 'environment'\ntexture = 'sky.exr'";

/// The keys of a budget.
fn budget([rays, photons]: [u64; 2]) -> String {
    format!("rays = {rays}\nphotons = {photons}")
}

/// A slab between y = 0 and y = 1.
#[derive(Clone, Copy)]
struct Slab {
    albedo: f64,
    thickness: f64,
    g: f64,
    /// From the middle to its edges, in metres: so far that what leaves there is below 1e-3.
    reach: f64,
    /// Edge of the square that is seen, in metres.
    seen: f64,
}

impl Slab {
    /// Under a sky that shines from above, with these keys of `[render]`: seen straight down for its reflectance
    /// (by reciprocity), straight up for its transmittance.
    fn text(&self, from_above: bool, render: &str) -> String {
        let Self { albedo, thickness, g, reach, seen } = self;
        let y = if from_above { 2.0 } else { -1.0 };
        let medium = format!(
            r#"
            region = {{ box = {{ min = [-{reach:?}, 0.0, -{reach:?}], max = [{reach:?}, 1.0, {reach:?}] }} }}
            sigma_t = {thickness:?}
            albedo = {albedo:?}
            phase = {{ type = "henyey-greenstein", g = {g:?} }}
            "#
        );
        orthographic([[0.0, y, 0.0], [0.0, 0.5, 0.0]], *seen, render, &medium, SKY)
    }
}

fn slabs(effort: Effort) -> Vec<Case> {
    let mut cases = Vec::new();
    for [albedo, thickness, g] in
        [[0.9, 1.0, 0.0], [1.0, 4.0, 0.0], [0.9, 2.0, 0.75], [0.99, 8.0, 0.85]]
    {
        let exact = slab(thickness, albedo, g);
        let of = Slab { albedo, thickness, g, reach: 6.0, seen: 2.0 };
        let sides = [
            ("reflectance", true, exact.reflectance),
            ("transmittance", false, exact.transmittance),
        ];
        for (what, from_above, expected) in sides {
            let name = format!("slab/{what}/albedo={albedo}/thickness={thickness}/g={g}");
            let text = move |rays, photons| of.text(from_above, &budget([rays, photons]));
            let work = Work::new(effort, 16, 20_000, 32);
            cases.push(both(&name, "adding-doubling", scenes::mean, expected, work, vec![], text));
        }
    }
    cases
}

/// What a very thick slab of forward scattering sends back and lets through, by moments of more and more photons:
/// cells are as wide as photons^(-1/5), and interpolation is off as the square of that.
fn convergence() -> Case {
    const PHOTONS: [u64; 3] = [12_500, 50_000, 200_000];
    let of = Slab { albedo: 1.0, thickness: 64.0, g: 0.9, reach: 6.0, seen: 2.0 };
    let name = "slab/convergence/albedo=1/thickness=64/g=0.9";
    let words = [
        "adding-doubling",
        "6.9 standard errors over six seeds (Student's t, fixed seeds), and for blur 1.5 % with the most photons \
         and as photons^(-2/5) with fewer",
    ];
    Case::new(Group::ClosedForms, name, words, move |parts| {
        let exact = slab(of.thickness, of.albedo, of.g);
        let mut findings = Findings::default();
        for (what, from_above, expected) in [
            ("reflectance", true, exact.reflectance),
            ("transmittance", false, exact.transmittance),
        ] {
            let mut points = Vec::new();
            for photons in PHOTONS {
                let render = budget([64, photons]) + "\nstrategy = 'moments'";
                let text = of.text(from_above, &render);
                // With fewer photons blur may be as much larger as theory says.
                let fewer = PHOTONS[PHOTONS.len() - 1] as f64 / photons as f64;
                let close = Closeness { bias: 0.015 * fewer.powf(0.4), error: 0.1 };
                let name = format!("{what} by {photons} photons");
                let checks =
                    compare(&name, &parts.render, &text, &[], scenes::mean, expected, close)?;
                let off = (checks[0].found / expected - 1.0).abs();
                points.push([photons as f64, off.max(1e-4)]);
                findings.checks.extend(checks);
            }
            let theory = PHOTONS
                .map(|n| n as f64)
                .map(|n| [n, points[0][1] * (n / points[0][0]).powf(-0.4)]);
            findings.curves.push(Curve {
                name: format!("Moments in a slab of thickness 64, g = 0.9: {what}"),
                axes: ["photons", "relative error"],
                theory: theory.into(),
                theory_name: "photons^(-2/5)",
                points,
            });
        }
        Ok(findings)
    })
}

fn half_spaces(effort: Effort) -> Vec<Case> {
    let case = |(albedo, expected): (f64, f64)| {
        let name = format!("half-space/albedo={albedo}");
        // Light spreads over 1 / sqrt(3 (1 - albedo)) free paths: up to 0.04 m.
        let of = Slab { albedo, thickness: 500.0, g: 0.0, reach: 0.5, seen: 0.2 };
        let text = move |rays, photons| of.text(true, &budget([rays, photons]));
        // Where much is absorbed paths are short and few come back.
        let rays = if albedo < 0.8 { 32 } else { 8 };
        let source = "1 - H(1) sqrt(1 - albedo), Chandrasekhar 1960";
        let work = Work::new(effort, 16, 20_000, rays);
        both(&name, source, scenes::mean, expected, work, vec![], text)
    };
    HALF_SPACES.map(case).into()
}

/// Half-spaces that begin within one voxel, however thick it is: what they send back depends on
/// optical thickness alone, and not on how density rises.
fn half_spaces_of_voxels(effort: Effort) -> Vec<Case> {
    let (thicknesses, spaces): (&[f64], _) = match effort {
        Effort::Quick => (&[1.0, 1000.0], &HALF_SPACES[..1]),
        Effort::Full => (&[1.0, 30.0, 1000.0], &HALF_SPACES[..2]),
    };
    let mut cases = Vec::new();
    for &sigma_t in thicknesses {
        for &(albedo, expected) in spaces {
            let name = format!("half-space/voxels/sigma_t={sigma_t:e}/albedo={albedo}");
            let text = move |rays, photons| {
                let medium =
                    format!("file = 'grids.vdb'\nsigma_t = {sigma_t:?}\nalbedo = {albedo:?}");
                let line = [[0.1, 20.0, 0.2], [0.1, 0.0, 0.2]];
                orthographic(line, 4.0, &budget([rays, photons]), &medium, SKY)
            };
            let (min, end) = (IVec3::new(-3, -3, -3), IVec3::new(3, 1, 3));
            let grid = fields::blocks("density", 1.0, min, end, |voxel| f64::from(voxel.y < 0));
            let source = "1 - H(1) sqrt(1 - albedo), Chandrasekhar 1960";
            let work = Work::new(effort, 16, 20_000, 32);
            cases.push(both(&name, source, scenes::mean, expected, work, vec![grid], text));
        }
    }
    cases
}

/// A slab under the sun, seen from one angle and lit from another: L(a, b) / cos b is that of the
/// angles exchanged (van de Hulst 1980, section 3.1).
fn reciprocity(effort: Effort) -> Case {
    let words = [
        "reciprocity: R(a, b) = R(b, a)",
        "4.5 standard errors by the film's variance, fixed seed",
    ];
    let rays = Work::new(effort, 0, 0, 1000).reference;
    Case::new(Group::ClosedForms, "slab/reciprocity", words, move |parts| {
        let reflected = |seen: f64, lit: f64| {
            let (x, y) = (30.0 * seen.sin(), 30.0 * seen.cos());
            let irradiance = 1.0 / lit.cos();
            let (sx, sy) = (lit.sin(), -lit.cos());
            let medium = r#"
                region = { box = { min = [-40.0, -1.0, -40.0], max = [40.0, 0.0, 40.0] } }
                sigma_t = 2.0
                albedo = 0.95
                phase = { type = "henyey-greenstein", g = 0.6 }
            "#;
            let light = format!(
                "type = 'sun'\ndirection = [{sx:?}, {sy:?}, 0.0]\nirradiance = {irradiance:?}"
            );
            let line = [[x, y, 0.0], [0.0; 3]];
            orthographic(line, 1.0, &format!("rays = {rays}"), medium, &light)
        };
        // What is seen, by the light that falls on the slab, over the cosine of where it is seen
        // from: symmetric in the two angles.
        let mean = |text: String| -> Result<(f64, f64)> {
            let scene = scenes::scene(&text, &[])?;
            let film = (parts.reference)(&scene, &scene.render)?.film;
            Ok((scenes::mean(&film), scenes::sum(&film, "variance").sqrt() / 64.0))
        };
        let (a, b) = (0.3f64, 1.1f64);
        let (one, other) = (mean(reflected(a, b))?, mean(reflected(b, a))?);
        let error = one.1.hypot(other.1);
        Ok(vec![
            Check::near("difference of R(a, b) and R(b, a)", one.0 - other.0, 0.0, 4.5 * error),
            Check::at_most("standard error over R", error / one.0, 0.02),
        ])
    })
}
