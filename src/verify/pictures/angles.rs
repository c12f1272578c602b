//! Slabs under the sun, seen at angles from both sides.

use super::super::adding_doubling::{SEEN_FROM, slab};
use super::super::case::{Case, Effort, Group};
use super::super::{Parts, scenes};
use super::slabs::orthographic;
use super::{Closeness, NOISE, Work, compare};
use crate::image::Film;

/// A slab, and how it is rendered.
#[derive(Clone, Copy)]
struct Slab {
    albedo: f64,
    thickness: f64,
    g: f64,
    /// How photons light it: each strategy has its slab.
    strategy: &'static str,
    /// Rays a pixel of the reference in a quick run, of the side that is lit and of the other.
    rays: [u64; 2],
}

/// The first is that of a quick run.
const SLABS: [Slab; 4] = [
    Slab { albedo: 0.9, thickness: 4.0, g: 0.5, strategy: "shared-gathers", rays: [32, 32] },
    Slab { albedo: 1.0, thickness: 16.0, g: 0.0, strategy: "fluence-toward-eye", rays: [32, 64] },
    Slab {
        albedo: 0.99,
        thickness: 16.0,
        g: -0.5,
        strategy: "fluence-toward-eye",
        rays: [32, 128],
    },
    Slab { albedo: 0.99, thickness: 16.0, g: 0.9, strategy: "moments", rays: [64, 64] },
];

pub(super) fn cases(effort: Effort) -> Vec<Case> {
    let slabs = if effort == Effort::Quick { &SLABS[..1] } else { &SLABS };
    slabs.iter().flat_map(|slab| [true, false].map(|lit| case(effort, *slab, lit))).collect()
}

/// The light that the lit side of a slab, or the other, sends toward each of the angles.
fn case(effort: Effort, of: Slab, lit: bool) -> Case {
    let Slab { albedo, thickness, g, strategy, rays } = of;
    let side = if lit { "reflected" } else { "transmitted" };
    let name = format!("slab/{side}/albedo={albedo}/thickness={thickness}/g={g}");
    Case::new(Group::ClosedForms, name, ["adding-doubling", NOISE], move |parts: &Parts| {
        let light = slab(thickness, albedo, g);
        let expected = if lit { light.reflected } else { light.transmitted };
        let work = Work::new(effort, 16, 25_000, rays[usize::from(!lit)]);
        let mut checks = Vec::new();
        for (angle, expected) in SEEN_FROM.into_iter().zip(expected) {
            let text = |budget| text(of, lit, angle, budget);
            let by_map = (strategy, &parts.render, text([work.rays, work.photons]), 0.01);
            let reference = ("reference", &parts.reference, text([work.reference, 0]), 0.0);
            for (what, render, text, bias) in [by_map, reference] {
                let what = format!("{what}, {angle} degrees");
                let close = Closeness { bias, error: work.error };
                checks.extend(compare(&what, render, &text, &[], pi_times_mean, expected, close)?);
            }
        }
        Ok(checks)
    })
}

/// Pi times the mean radiance: over the irradiance, which is 1, what is held against a white diffuser.
fn pi_times_mean(film: &Film) -> f64 {
    std::f64::consts::PI * scenes::mean(film)
}

/// A slab from y = -1 to y = 0 under the sun at its zenith, seen at an angle from its normal.
fn text(of: Slab, lit: bool, angle: f64, [rays, photons]: [u64; 2]) -> String {
    let Slab { albedo, thickness, g, strategy, .. } = of;
    let (sine, cosine) = angle.to_radians().sin_cos();
    let (face, side) = if lit { (0.0, 1.0) } else { (-1.0, -1.0) };
    let line = [[20.0 * sine, face + 20.0 * side * cosine, 0.0], [0.0, face, 0.0]];
    let render = format!("rays = {rays}\nphotons = {photons}\nstrategy = '{strategy}'");
    let medium = format!(
        r#"
        region = {{ box = {{ min = [-6.0, -1.0, -6.0], max = [6.0, 0.0, 6.0] }} }}
        sigma_t = {thickness:?}
        albedo = {albedo:?}
        phase = {{ type = "henyey-greenstein", g = {g:?} }}
        "#
    );
    // The sun has no size, so that it is not seen through the slab.
    let sun = "type = 'sun'\ndirection = [0.0, -1.0, 0.0]\nirradiance = 1.0\nangle = 0.0";
    orthographic(line, 1.0, &render, &medium, sun)
}
