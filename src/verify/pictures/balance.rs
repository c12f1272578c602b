//! What must be kept: energy, temperature, scale.

use glam::IVec3;

use super::super::case::{Case, Effort, Group};
use super::super::{Check, fields, scenes, values};
use super::{Closeness, Work, both, compare, compare_scene};
use crate::error::{Error, Result};
use crate::image::Film;
use crate::math::{Rgb, luminance};
use crate::medium::blackbody::blackbody_radiance;
use crate::medium::{Density, Media, Medium, Ramped, Remap, Transfer};

pub(super) fn cases(effort: Effort) -> Vec<Case> {
    let mut cases = furnaces(effort);
    cases.extend(grid_furnaces(effort));
    cases.push(blackbody());
    cases.extend(scale_invariances());
    cases
}

fn furnaces(effort: Effort) -> Vec<Case> {
    let case = |(name, g, radiance): (&str, f64, f64)| {
        let text = move |rays, photons| {
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
                "#
            )
        };
        let name = format!("white-furnace/{name}");
        let source = "energy is kept: the sky's radiance";
        both(&name, source, scenes::mean, radiance, Work::new(effort, 8, 40_000, 32), vec![], text)
    };
    [("isotropic", 0.0, 1.0), ("g=0.9", 0.9, 1.0), ("bright", 0.0, 1e5)].map(case).into()
}

/// White furnaces of grids that reach their box's faces, by a background and by a ramp with jumps.
fn grid_furnaces(effort: Effort) -> [Case; 2] {
    const SOURCE: &str = "energy is kept: the sky's radiance";
    const TEXT: &str = r#"
        [camera]
        position = [0.3, 0.4, 4.0]
        target = [0.0, 0.0, 0.0]
        fov = 30.0
        [film]
        size = [8, 8]
        [render]
        rays = RAYS
        photons = PHOTONS
        [[medium]]
        file = "grids.vdb"
        sigma_t = 2.0
        albedo = 1.0
        scale = 0.1
        translate = [-0.75, -0.75, -0.75]
        [[light]]
        type = "environment"
        radiance = 1.0
    "#;
    let work = Work::new(effort, 8, 40_000, 32);
    let text = |rays: u64, photons: u64| {
        TEXT.replace("RAYS", &rays.to_string()).replace("PHOTONS", &photons.to_string())
    };
    let grids = vec![values::even_box(1.0)];
    let name = "white-furnace/background";
    let background = both(name, SOURCE, scenes::mean, 1.0, work, grids, text);
    let words = [SOURCE, super::NOISE];
    let ramp = Case::new(Group::ClosedForms, "white-furnace/ramp", words, move |parts| {
        let waves = |v: IVec3| 0.5 + 0.5 * (v.as_dvec3() * 0.7).map(f64::sin).element_product();
        let grid = fields::blocks("density", 1.0, IVec3::ZERO, IVec3::splat(2), waves);
        let stops = [(0.0, 0.0), (0.3, 0.2), (0.45, 0.2), (0.45, 2.0), (0.6, 2.0), (0.6, 0.5)];
        let mut checks = Vec::new();
        for (what, render, rays, photons, bias) in [
            ("photon map", &parts.render, work.rays, work.photons, 0.01),
            ("reference", &parts.reference, work.reference, 0, 0.0),
        ] {
            let mut scene = scenes::scene(&text(rays, photons), std::slice::from_ref(&grid))?;
            let transfer = Transfer::new(Remap::default(), &stops).map_err(Error::Usage)?;
            scene.media = ramped(scene.media, &transfer);
            let close = Closeness { bias, error: work.error };
            checks.extend(compare_scene(what, render, &scene, scenes::mean, 1.0, close)?);
        }
        Ok(checks)
    });
    [background, ramp]
}

/// The media with the densities of their grids under a transfer function.
fn ramped(media: Media, transfer: &Transfer<f64>) -> Media {
    let under = |medium: Medium| Medium {
        density: match medium.density {
            Density::Voxel(grid) => Density::Ramped(Ramped::new(grid, transfer.clone())),
            other @ (Density::Homogeneous(_) | Density::Ramped(_)) => other,
        },
        ..medium
    };
    Media::new(media.into_iter().map(under).collect())
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
            let [r, g, b] = ["R", "G", "B"].map(|channel| scenes::sum(film, channel));
            luminance(Rgb::new(r, g, b)) / (film.width() * film.height()) as f64
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
