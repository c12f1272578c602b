//! Size of voxels and distance from the origin; where the camera and the light stand.

use std::f64::consts::TAU;

use glam::{DVec3, IVec3};

use super::judge::{Bounds, checks, judge};
use super::setup::Setup;
use crate::error::Result;
use crate::vdb::GridToWrite;
use crate::verify::case::{Case, Effort, Group};
use crate::verify::{Check, Parts, fields, scenes};

/// Voxels from the middle of a puff to where it ends.
const REACH: f64 = 14.0;

/// A soft ball of smoke.
pub(super) fn puff(voxel: f64) -> GridToWrite {
    let value = |v: IVec3| (1.0 - v.as_dvec3().length() / REACH).max(0.0);
    fields::blocks("density", voxel, IVec3::splat(-2), IVec3::splat(2), value)
}

pub(super) fn cases(effort: Effort) -> Vec<Case> {
    let mut cases = scales(effort);
    cases.extend(lights());
    cases.extend(cameras());
    cases
}

/// The puff at a voxel size and a distance must look like the one of 1 m at the origin.
fn scales(effort: Effort) -> Vec<Case> {
    let words = [
        "scale and translation invariance: the picture of 1 m voxels at the origin",
        "places are rounded to f64: 1e-6 m at 1e7 m is 2e-3 voxels; a photon may turn away",
    ];
    let full = effort == Effort::Full;
    let voxels: &[f64] = if full { &[1e-6, 1e-3, 1.0, 1e3, 1e6] } else { &[1e-6, 1.0, 1e6] };
    let distances: &[f64] = if full { &[0.0, 1.0, 1e3, 1e7] } else { &[0.0, 1e7] };
    let mut cases = Vec::new();
    for &voxel in voxels {
        for &distance in distances {
            let name = format!("matrix/scale/voxel={voxel:e}/distance={distance:e}");
            let case =
                Case::new(Group::Matrix, name, words, move |parts| scale(parts, voxel, distance));
            let plane = "voxel size x distance from the origin, m";
            cases.push(case.at(plane, format!("{voxel:e}"), format!("{distance:e}")));
        }
    }
    cases
}

fn scale(parts: &Parts, voxel: f64, distance: f64) -> Result<Vec<Check>> {
    let picture = |voxel: f64, distance: f64| -> Result<_> {
        let middle = DVec3::new(0.6, -0.48, 0.64) * distance;
        let at = |v: DVec3| (middle + v * voxel).to_array();
        let setup = Setup {
            camera: format!(
                "position = {:?}\ntarget = {:?}\nfov = 30.0",
                at(DVec3::new(0.0, 0.0, 60.0)),
                at(DVec3::ZERO)
            ),
            size: [8, 8],
            photons: 2000,
            medium: format!(
                "file = \"grids.vdb\"\nsigma_t = {:?}\nalbedo = 0.9\ntranslate = {:?}",
                0.2 / voxel,
                middle.to_array()
            ),
            light: format!(
                "type = \"point\"\nposition = {:?}\nintensity = {:?}",
                at(DVec3::new(0.0, 25.0, 0.0)),
                1e3 * voxel * voxel
            ),
            grids: vec![puff(voxel)],
            ..Setup::default()
        };
        let scene = setup.scene()?;
        (parts.render)(&scene, &scene.render)
    };
    let expected = scenes::mean(&picture(1.0, 0.0)?.film);
    let bounds = Bounds { low: 0.97 * expected, high: 1.03 * expected };
    Ok(checks(&picture(voxel, distance)?, bounds))
}

/// A point light in, on and by the puff: no more light leaves than the light gives.
fn lights() -> Vec<Case> {
    let words = [
        "energy: of 4 pi W sent out at most that arrives, in the mean over directions",
        "noise of 5000 photons",
    ];
    let places = [("middle", 0.0), ("inside", 5.0), ("face", REACH), ("voxel outside", 15.0)];
    let mut cases = Vec::new();
    for (row, at) in places {
        for (column, radius) in [("0.1 voxel", 0.1), ("1", 1.0), ("8", 8.0), ("asset", 32.0)] {
            let name = format!("matrix/light/at={row}/radius={column}");
            let case = Case::new(Group::Matrix, name, words, move |parts| lit(parts, at, radius));
            cases.push(case.at("place of a light x gather radius", row.into(), column.into()));
        }
    }
    cases
}

fn lit(parts: &Parts, at: f64, radius: f64) -> Result<Vec<Check>> {
    // Seen from the side by an orthographic camera that holds all of the puff and its light's glow,
    // whose flux through the film is a share of all that is sent out in that direction.
    let setup = Setup {
        camera: "type = \"orthographic\"\nposition = [0.0, 0.0, 100.0]\n\
                 target = [0.0, 0.0, 0.0]\nheight = 64.0"
            .into(),
        size: [16, 16],
        photons: 5000,
        render: format!("radius = {radius:?}"),
        medium: "file = \"grids.vdb\"\nsigma_t = 0.5\nalbedo = 1.0".into(),
        light: format!("type = \"point\"\nposition = [0.1, {at:?}, 0.2]\nintensity = 1.0"),
        grids: vec![puff(1.0)],
        ..Setup::default()
    };
    let scene = setup.scene()?;
    let reference = scenes::mean(
        &(parts.reference)(&scene, &crate::scene::RenderSettings { rays: 64, ..scene.render })?
            .film,
    );
    // Seen from one side only, where the light is on another, more than the mean may leave there.
    let most = 2.0 * 2.0 * TAU / (4.0 * std::f64::consts::PI) / (64.0 * 64.0) * 2.0;
    let mut found = checks(
        &(parts.render)(&scene, &scene.render)?,
        Bounds { low: 0.5 * reference, high: 1.6 * reference },
    );
    found.push(Check::within("reference", reference, 0.0, most));
    Ok(found)
}

/// Cameras in all places, in a white furnace.
fn cameras() -> Vec<Case> {
    let words = ["white furnace: L = 1", "noise of 2000 photons"];
    let look = |position: &str, target: &str| {
        format!("position = {position}\ntarget = {target}\nfov = 20.0")
    };
    let cameras = [
        ("inside", look("[0.3, 0.2, 0.1]", "[5.0, 1.0, 2.0]")),
        ("on a voxel", look("[0.0, 0.0, 0.0]", "[1.0, 0.0, 0.0]")),
        ("touching", look("[0.0, 0.0, 16.0]", "[0.0, 0.0, 0.0]")),
        ("grazing", look("[-40.0, 16.0, 0.0]", "[40.0, 16.0, 0.0]")),
        ("1e9 m away", format!("position = [0.0, 0.0, 1e9]\ntarget = [0.0, 0.0, 0.0]\nfov = 1e-6")),
        (
            "infinitely far",
            "type = \"orthographic\"\nposition = [0.0, 0.0, 1e9]\n\
                            target = [0.0, 0.0, 0.0]\nheight = 20.0"
                .to_owned(),
        ),
    ];
    let mut cases = Vec::new();
    for (row, camera) in cameras {
        for (column, sigma_t) in [("1e-6", 1e-6), ("0.1", 0.1), ("1e3", 1e3)] {
            let name = format!("matrix/camera/at={row}/sigma_t={column}");
            let setup = Setup {
                camera: camera.clone(),
                photons: 2000,
                medium: format!("file = \"grids.vdb\"\nsigma_t = {sigma_t:?}\nalbedo = 1.0"),
                grids: vec![puff(1.0)],
                ..Setup::default()
            };
            let case = Case::new(Group::Matrix, name, words, move |parts| {
                judge(parts, &setup, Bounds::WHITE)
            });
            cases.push(case.at("place of the camera x sigma_t, 1/m", row.into(), column.into()));
        }
    }
    cases
}
