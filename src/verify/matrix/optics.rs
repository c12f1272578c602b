//! Optical thickness, albedo and mean cosine.

use super::judge::{Bounds, judge};
use super::setup::Setup;
use crate::verify::case::{Case, Effort, Group};

/// A cube of 1 m seen from the front, through all of which rays lead.
const CAMERA: &str = "type = \"orthographic\"\nposition = [0.0, 0.0, 5.0]\n\
                      target = [0.0, 0.0, 0.0]\nheight = 0.98";

const WORDS: [&str; 2] = [
    "furnace of radiance 1: L = 1 for albedo 1, exp(-tau) for albedo 0, between them else",
    "noise of 4000 photons: 30 %, 60 % where few of them are seen, a factor of 3 to 5 where few fly \
     at the eye; less what the cap on a path's scatterings took",
];

pub(super) fn cases(effort: Effort) -> Vec<Case> {
    let quick = effort == Effort::Quick;
    let pick = |all: &'static [f64], few: &'static [f64]| if quick { few } else { all };
    let thicknesses = pick(&[1e-8, 1e-4, 1e-2, 1.0, 1e2, 1e4, 1e6, 1e8], &[1e-8, 1.0, 1e4, 1e8]);
    let albedos = pick(&[0.0, 0.5, 0.999_999, 1.0], &[0.0, 0.5, 1.0]);
    let cosines = pick(&[-0.9999, -0.9, 0.0, 0.9, 0.9999], &[-0.9999, 0.0, 0.9]);
    let mut cases = Vec::new();
    for &g in cosines {
        for &thickness in thicknesses {
            for &albedo in albedos {
                let plane = format!("optical thickness x albedo, g = {g}");
                let name = format!("matrix/optics/thickness={thickness:e}/albedo={albedo}/g={g}");
                let case = Case::new(Group::Matrix, name, WORDS, move |parts| {
                    judge(parts, &setup(thickness, albedo, g), bounds(thickness, albedo, g))
                });
                cases.push(case.at(&plane, format!("{thickness:e}"), albedo.to_string()));
            }
        }
    }
    cases
}

fn setup(thickness: f64, albedo: f64, g: f64) -> Setup {
    Setup {
        camera: CAMERA.into(),
        size: if albedo > 0.0 { [8, 8] } else { [4, 4] },
        photons: if albedo > 0.0 { 4000 } else { 100 },
        medium: format!(
            "region = {{ box = {{ min = [-0.5, -0.5, -0.5], max = [0.5, 0.5, 0.5] }} }}\n\
             sigma_t = {thickness:?}\nalbedo = {albedo:?}\n\
             phase = {{ type = \"henyey-greenstein\", g = {g:?} }}"
        ),
        ..Setup::default()
    }
}

fn bounds(thickness: f64, albedo: f64, g: f64) -> Bounds {
    let straight = (-thickness).exp();
    if albedo == 0.0 {
        // The film holds f32.
        Bounds::mean(straight - 1e-6, straight + 1e-6)
    } else if albedo == 1.0 && thickness >= 1.0 && g > 0.99 {
        // A lobe of 0.006 degrees, at which no photon of some thousands flies.
        Bounds::mean(straight - 1e-6, 3.0)
    } else if albedo == 1.0 && thickness >= 1.0 && g.abs() > 0.5 {
        // Of photons whose light is scattered into a narrow lobe few fly at the eye.
        Bounds::mean(0.2, 3.0)
    } else if albedo == 1.0 && thickness > 1e3 {
        // Most photons lie where nobody sees them.
        Bounds::mean(0.5, 1.6)
    } else if albedo == 1.0 {
        Bounds::WHITE
    } else {
        let high = if thickness > 1e3 { 1.6 } else { Bounds::ENERGY.high };
        Bounds::mean(straight - 1e-6, high)
    }
}
