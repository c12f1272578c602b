//! Whole pictures against closed forms, published values and independent methods.
//!
//! Each picture is made with several seeds; a mean must lie within 4.5 standard errors of what is
//! expected, and those must be small enough for the answer to say something.

use std::f64::consts::PI;

use glam::IVec3;

use super::adding_doubling::slab;
use super::case::{Case, Effort, Group};
use super::known::{HALF_SPACES, POINT_FLUENCES, airlight};
use super::parts::Render;
use super::{Check, Parts, fields, scenes};
use crate::error::Result;
use crate::image::Film;
use crate::math::luminance;
use crate::medium::blackbody::blackbody_radiance;
use crate::vdb::GridToWrite;

/// Pictures a mean is taken over.
const SEEDS: u32 = 6;

/// Student's t for five degrees of freedom at 1e-3, two-sided: what [`SEEDS`] seeds tell of a
/// standard error.
const STUDENT: f64 = 6.87;

const NOISE: &str = "6.9 standard errors over six seeds (Student's t, one false alarm in a \
                     thousand, fixed seeds) and the gather's blur";

pub(super) fn cases(effort: Effort) -> Vec<Case> {
    let scale = if effort == Effort::Quick { 1 } else { 16 };
    let mut cases = slabs(scale);
    cases.extend(half_spaces(scale));
    cases.extend(fluences(scale));
    cases.extend(airlights());
    cases.extend(furnaces(scale));
    cases.push(blackbody());
    cases.push(reciprocity(scale));
    cases.extend(scale_invariances());
    cases
}

/// How closely a mean must be met, beside its noise.
#[derive(Clone, Copy)]
struct Closeness {
    /// Bias that is allowed, relative.
    bias: f64,
    /// Largest standard error that still says something, relative.
    error: f64,
}

/// Mean over seeds of `measure` on pictures of a scene against what is expected.
fn compare(
    what: &str,
    render: &Render,
    text: &str,
    grids: &[GridToWrite],
    measure: impl Fn(&Film) -> f64,
    expected: f64,
    close: Closeness,
) -> Result<Vec<Check>> {
    let scene = scenes::scene(text, grids)?;
    let mut values = Vec::new();
    let mut dropped = 0;
    for seed in 0..SEEDS {
        let rendered = render(&scene, &scenes::seeded(&scene, u64::from(seed)))?;
        dropped += rendered.work.dropped_samples + rendered.film.repaired();
        values.push(measure(&rendered.film));
    }
    let mean = values.iter().sum::<f64>() / f64::from(SEEDS);
    let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    let error = (squares / f64::from(SEEDS * (SEEDS - 1))).sqrt();
    Ok(vec![
        Check::near(what, mean, expected, STUDENT * error + close.bias * expected.abs()),
        Check::within(format!("{what}: standard error"), error, 0.0, close.error * expected.abs()),
        Check::near(format!("{what}: dropped samples"), dropped as f64, 0.0, 0.0),
    ])
}

/// A case run by the photon map and by the reference.
fn both(
    name: &str,
    source: &'static str,
    measure: impl Fn(&Film) -> f64 + Copy + Send + Sync + 'static,
    expected: f64,
    text: impl Fn(u64) -> String + Send + Sync + 'static,
) -> Case {
    Case::new(Group::ClosedForms, name, [source, NOISE], move |parts: &Parts| {
        let close = Closeness { bias: 0.01, error: 0.02 };
        let mut checks =
            compare("photon map", &parts.render, &text(1), &[], measure, expected, close)?;
        let close = Closeness { bias: 0.0, ..close };
        checks.extend(compare(
            "reference",
            &parts.reference,
            &text(8),
            &[],
            measure,
            expected,
            close,
        )?);
        Ok(checks)
    })
}

/// A slab between y = 0 and y = 1 under a sky that shines from above, seen straight down for its
/// reflectance (by reciprocity), straight up for its transmittance.
fn slab_text(
    [albedo, thickness, g]: [f64; 3],
    from_above: bool,
    side: u32,
    rays: u64,
    photons: u64,
) -> String {
    let y = if from_above { 2.0 } else { -1.0 };
    format!(
        r#"
        [camera]
        type = "orthographic"
        position = [0.0, {y:?}, 0.0]
        target = [0.0, 0.5, 0.0]
        up = [0.0, 0.0, 1.0]
        height = 4.0
        [film]
        size = [{side}, {side}]
        [render]
        rays = {rays}
        photons = {photons}
        [[medium]]
        region = {{ box = {{ min = [-20.0, 0.0, -20.0], max = [20.0, 1.0, 20.0] }} }}
        sigma_t = {thickness:?}
        albedo = {albedo:?}
        phase = {{ type = "henyey-greenstein", g = {g:?} }}
        [[light]]
        type = "environment"
        texture = "sky.exr"
        "#
    )
}

fn slabs(scale: u64) -> Vec<Case> {
    let mut cases = Vec::new();
    for of in [[0.9, 1.0, 0.0], [1.0, 4.0, 0.0], [0.9, 2.0, 0.75], [0.99, 8.0, 0.85]] {
        let [albedo, thickness, g] = of;
        let exact = slab(thickness, albedo, g);
        let sides = [
            ("reflectance", true, exact.reflectance),
            ("transmittance", false, exact.transmittance),
        ];
        for (what, from_above, expected) in sides {
            let name = format!("slab/{what}/albedo={albedo}/thickness={thickness}/g={g}");
            let text = move |more| slab_text(of, from_above, 8, 32 * scale * more, 20_000 * scale);
            cases.push(both(&name, "adding-doubling", scenes::mean, expected, text));
        }
    }
    cases
}

fn half_spaces(scale: u64) -> Vec<Case> {
    let case = |(albedo, expected): (f64, f64)| {
        let name = format!("half-space/albedo={albedo}");
        let text =
            move |more| slab_text([albedo, 500.0, 0.0], true, 8, 32 * scale * more, 20_000 * scale);
        both(&name, "1 - H(1) sqrt(1 - albedo), Chandrasekhar 1960", scenes::mean, expected, text)
    };
    HALF_SPACES.map(case).into()
}

/// Fluence is radiance over the sphere of directions: a latlong camera sees it, but for the light
/// that comes straight from the source, which is known.
fn fluences(scale: u64) -> Vec<Case> {
    const HEIGHT: usize = 32;
    let case = |(distance, expected): (f64, f64)| {
        let straight = (-distance).exp() / (4.0 * PI * distance * distance);
        let measure = |film: &Film| {
            let row = |y: usize| (PI * (y as f64 + 0.5) / HEIGHT as f64).sin();
            4.0 * PI * scenes::weighted_mean(film, row)
        };
        let text = move |more| {
            format!(
                r#"
                [camera]
                type = "latlong"
                position = [0.0, 0.0, 0.0]
                target = [0.3, {distance:?}, 0.0]
                up = [0.0, 0.0, 1.0]
                [film]
                size = [{HEIGHT}, {HEIGHT}]
                [render]
                rays = {rays}
                photons = {photons}
                [[medium]]
                region = "everywhere"
                sigma_t = 1.0
                albedo = 0.9
                [[light]]
                type = "point"
                position = [0.0, {distance:?}, 0.0]
                power = 1.0
                "#,
                rays = 4 * scale * more,
                photons = 20_000 * scale,
            )
        };
        let name = format!("point-source/r={distance}");
        let source = "transport round a point source, Case, de Hoffmann and Placzek 1953";
        both(&name, source, measure, expected - straight, text)
    };
    POINT_FLUENCES.map(case).into()
}

fn airlights() -> Vec<Case> {
    let case = |angle: f64| {
        let expected = airlight(0.1, 0.1, 10.0, angle);
        let text = move |more: u64| {
            let (x, z) = (10.0 * angle.sin(), 10.0 * angle.cos());
            format!(
                r#"
                [camera]
                position = [0.0, 0.0, 0.0]
                target = [0.0, 0.0, 1.0]
                fov = 0.001
                [film]
                size = [4, 4]
                [render]
                max_scatter = 1
                rays = {rays}
                photons = 1000
                [[medium]]
                region = "everywhere"
                sigma_t = 0.1
                albedo = 1.0
                [[light]]
                type = "point"
                position = [{x:?}, 0.0, {z:?}]
                intensity = 1.0
                "#,
                rays = 500 * more,
            )
        };
        both(
            &format!("airlight/angle={angle}"),
            "Sun et al. 2005, equation 9",
            scenes::mean,
            expected,
            text,
        )
    };
    [0.1, 0.5, 1.0, 2.0, 3.0].map(case).into()
}

fn furnaces(scale: u64) -> Vec<Case> {
    let case = |(name, g, radiance): (&str, f64, f64)| {
        let text = move |more| {
            format!(
                r#"
                [camera]
                position = [0.3, 0.4, 4.0]
                target = [0.0, 0.0, 0.0]
                fov = 30.0
                [film]
                size = [8, 8]
                [render]
                rays = {rays}
                photons = {photons}
                [[medium]]
                albedo = 1.0
                sigma_t = 3.0
                region = {{ sphere = {{ center = [0.0, 0.0, 0.0], radius = 1.0 }} }}
                phase = {{ type = "henyey-greenstein", g = {g:?} }}
                [[light]]
                type = "environment"
                radiance = {radiance:?}
                "#,
                rays = 16 * scale * more,
                photons = 20_000 * scale,
            )
        };
        let name = format!("white-furnace/{name}");
        both(&name, "energy is kept: the sky's radiance", scenes::mean, radiance, text)
    };
    [("isotropic", 0.0, 1.0), ("g=0.9", 0.9, 1.0), ("bright", 0.0, 1e5)].map(case).into()
}

fn blackbody() -> Case {
    let words = [
        "Kirchhoff's law: a thick hot slab shines as a blackbody",
        "the table of radiances is good to 1e-3",
    ];
    Case::new(Group::ClosedForms, "blackbody", words, |parts| {
        let expected = luminance(blackbody_radiance(1800.0));
        let (min, end) = (IVec3::splat(-2), IVec3::splat(2));
        let grids = [
            fields::blocks("density", 0.1, min, end, |_| 1.0),
            fields::blocks("temperature", 0.1, min * 2, end * 2, |_| 1800.0),
        ];
        let text = r#"
            [camera]
            type = "orthographic"
            position = [0.1, 0.2, 9.0]
            target = [0.1, 0.2, 0.0]
            height = 1.0
            [film]
            size = [4, 4]
            [render]
            rays = 4
            photons = 100
            max_scatter = 0
            [[medium]]
            file = "grids.vdb"
            grid = "density"
            sigma_t = 100.0
            albedo = 0.0
            emission = { temperature = "temperature" }
        "#;
        let measure = |film: &Film| {
            let mean = |name: &str| {
                let layer = film.layer(name).unwrap_or_default();
                layer.iter().map(|v| f64::from(*v)).sum::<f64>() / layer.len() as f64
            };
            luminance(crate::math::Rgb::new(mean("R"), mean("G"), mean("B")))
        };
        let close = Closeness { bias: 1e-3, error: 1e-3 };
        let mut checks =
            compare("photon map", &parts.render, text, &grids, measure, expected, close)?;
        checks.extend(compare(
            "reference",
            &parts.reference,
            &text.replace("rays = 4", "rays = 400"),
            &grids,
            measure,
            expected,
            Closeness { bias: 1e-3, error: 0.01 },
        )?);
        Ok(checks)
    })
}

/// A slab under the sun, seen from one angle and lit from another: L(a, b) / cos b is that of the
/// angles exchanged (van de Hulst 1980, section 3.1).
fn reciprocity(scale: u64) -> Case {
    let words = ["reciprocity: R(a, b) = R(b, a)", NOISE];
    Case::new(Group::ClosedForms, "slab/reciprocity", words, move |parts| {
        let reflected = |seen: f64, lit: f64, rays: u64| {
            let (x, y) = (30.0 * seen.sin(), 30.0 * seen.cos());
            let irradiance = 1.0 / lit.cos();
            let (sx, sy) = (lit.sin(), -lit.cos());
            format!(
                r#"
                [camera]
                type = "orthographic"
                position = [{x:?}, {y:?}, 0.0]
                target = [0.0, 0.0, 0.0]
                up = [0.0, 0.0, 1.0]
                height = 1.0
                [film]
                size = [8, 8]
                [render]
                rays = {rays}
                photons = 1000
                [[medium]]
                region = {{ box = {{ min = [-40.0, -1.0, -40.0], max = [40.0, 0.0, 40.0] }} }}
                sigma_t = 2.0
                albedo = 0.95
                phase = {{ type = "henyey-greenstein", g = 0.6 }}
                [[light]]
                type = "sun"
                direction = [{sx:?}, {sy:?}, 0.0]
                irradiance = {irradiance:?}
                "#
            )
        };
        // What is seen, by the light that falls on the slab, over the cosine of where it is seen
        // from: symmetric in the two angles.
        let mean = |text: String| -> Result<(f64, f64)> {
            let scene = scenes::scene(&text, &[])?;
            let rendered = (parts.reference)(&scene, &scene.render)?;
            let noise: f64 = rendered
                .film
                .layer("variance")
                .unwrap_or_default()
                .iter()
                .map(|v| f64::from(*v))
                .sum();
            Ok((scenes::mean(&rendered.film), noise.sqrt() / 64.0))
        };
        let (a, b) = (0.3f64, 1.1f64);
        let rays = 400 * scale;
        let (one, other) = (mean(reflected(a, b, rays))?, mean(reflected(b, a, rays))?);
        let error = one.1.hypot(other.1);
        Ok(vec![
            Check::near("difference of R(a, b) and R(b, a)", one.0 - other.0, 0.0, 4.5 * error),
            Check::within("standard error over R", error / one.0, 0.0, 0.02),
        ])
    })
}

/// World times k, extinction over k: the same picture.
fn scale_invariances() -> Vec<Case> {
    let text = |k: f64| {
        let [eye, radius, light] = [4.0 * k, k, 1.5 * k];
        format!(
            r#"
            [camera]
            position = [0.0, 0.0, {eye:?}]
            target = [0.0, 0.0, 0.0]
            fov = 35.0
            [film]
            size = [8, 8]
            [render]
            rays = 8
            photons = 5000
            [[medium]]
            albedo = 0.8
            sigma_t = {sigma_t:?}
            region = {{ sphere = {{ center = [0.0, 0.0, 0.0], radius = {radius:?} }} }}
            phase = {{ type = "henyey-greenstein", g = 0.5 }}
            [[light]]
            type = "point"
            position = [0.0, {light:?}, 0.0]
            intensity = {intensity:?}
            "#,
            sigma_t = 3.0 / k,
            intensity = k * k,
        )
    };
    let case = move |(name, k, tolerance): (&str, f64, f64)| {
        let words = [
            "lengths times k, extinction over k, intensity times k²: the same picture",
            "powers of two are exact; others round places to 24 bits, which may turn a photon away",
        ];
        let name = format!("scale-invariance/{name}");
        Case::new(Group::ClosedForms, name, words, move |parts| {
            let picture = |k| -> Result<f64> {
                let scene = scenes::scene(&text(k), &[])?;
                Ok(scenes::mean(&(parts.render)(&scene, &scene.render)?.film))
            };
            let relative = picture(k)? / picture(1.0)? - 1.0;
            Ok(vec![Check::near("relative difference of the means", relative, 0.0, tolerance)])
        })
    };
    [
        ("2^-20", 0.5f64.powi(20), 1e-7),
        ("2^20", 2f64.powi(20), 1e-7),
        ("1e-6", 1e-6, 1e-3),
        ("1e6", 1e6, 1e-3),
    ]
    .map(case)
    .into()
}
