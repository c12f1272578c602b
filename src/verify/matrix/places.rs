//! Size of voxels and distance from the origin; where the camera stands.

use glam::{DVec3, IVec3};

use super::judge::{Bounds, checks, judge};
use super::setup::Setup;
use crate::vdb::GridToWrite;
use crate::verify::case::{Case, Effort, Group};
use crate::verify::{fields, scenes};

/// Voxels from the middle of a puff to where it ends.
pub(super) const REACH: f64 = 14.0;

/// A soft ball of smoke, of voxels of 1 m.
pub(super) fn puff() -> GridToWrite {
    let value = |v: IVec3| (1.0 - v.as_dvec3().length() / REACH).max(0.0);
    fields::blocks("density", 1.0, IVec3::splat(-2), IVec3::splat(2), value)
}

pub(super) fn cases(effort: Effort) -> Vec<Case> {
    let mut cases = scales(effort);
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
            let case = Case::new(Group::Matrix, name, words, move |parts| {
                let picture = |voxel: f64, distance: f64| {
                    let scene = scaled(voxel, distance).scene()?;
                    (parts.render)(&scene, &scene.render)
                };
                let expected = scenes::mean(&picture(1.0, 0.0)?.film);
                let bounds = Bounds::mean(0.97 * expected, 1.03 * expected);
                Ok(checks(&picture(voxel, distance)?, bounds))
            });
            let plane = "voxel size x distance from the origin, m";
            cases.push(case.at(plane, format!("{voxel:e}"), format!("{distance:e}")));
        }
    }
    cases
}

/// The puff with voxels of this edge, this far from the origin, in metres. The file has voxels of
/// 1 m, for OpenVDB itself refuses any below 1.5e-5 m; the scene scales them.
fn scaled(voxel: f64, distance: f64) -> Setup {
    let middle = DVec3::new(0.6, -0.48, 0.64) * distance;
    let at = |v: DVec3| (middle + v * voxel).to_array();
    let (eye, target) = (at(DVec3::new(0.0, 0.0, 60.0)), at(DVec3::ZERO));
    Setup {
        camera: format!("position = {eye:?}\ntarget = {target:?}\nfov = 30.0"),
        size: [8, 8],
        // As much as makes pictures alike by all strategies: rounding decides between two that are as good.
        rays: 16,
        photons: 20_000,
        medium: format!(
            "file = \"grids.vdb\"\nsigma_t = {:?}\nalbedo = 0.9\nscale = {voxel:?}\n\
             translate = {:?}",
            0.2 / voxel,
            middle.to_array()
        ),
        light: format!(
            "type = \"point\"\nposition = {:?}\nintensity = {:?}",
            at(DVec3::new(0.0, 25.0, 0.0)),
            1e3 * voxel * voxel
        ),
        grids: vec![puff()],
        ..Setup::default()
    }
}

/// Cameras in all places, in a white furnace.
fn cameras() -> Vec<Case> {
    let words = [
        "white furnace: L = 1",
        "noise of 1000 to 4000 photons, 30 %, twice that where few of them are seen; nothing is asked where none arrives; less what the cap on a path's scatterings took",
    ];
    let look = |position: &str, target: &str| {
        format!("position = {position}\ntarget = {target}\nfov = 20.0")
    };
    let cameras = [
        ("inside", look("[0.3, 0.2, 0.1]", "[5.0, 1.0, 2.0]")),
        ("on a voxel", look("[0.0, 0.0, 0.0]", "[1.0, 0.0, 0.0]")),
        ("touching", look("[0.0, 0.0, 16.0]", "[0.0, 0.0, 0.0]")),
        ("grazing", look("[-40.0, 16.0, 0.0]", "[40.0, 16.0, 0.0]")),
        (
            "1e9 m away",
            "position = [0.0, 0.0, 1e9]\ntarget = [0.0, 0.0, 0.0]\nfov = 1e-6".to_owned(),
        ),
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
            // Into the middle of a thickness of 7000 free paths no photon of a few thousand comes.
            let blind = sigma_t > 1.0 && ["inside", "on a voxel"].contains(&row);
            let setup = Setup {
                camera: camera.clone(),
                photons: if sigma_t > 1.0 && !blind { 4000 } else { 1000 },
                medium: format!("file = \"grids.vdb\"\nsigma_t = {sigma_t:?}\nalbedo = 1.0"),
                grids: vec![puff()],
                ..Setup::default()
            };
            let bounds = match (blind, sigma_t > 1.0) {
                (true, _) => Bounds::ENERGY,
                (false, true) => Bounds::mean(0.5, 1.6),
                (false, false) => Bounds::WHITE,
            };
            let case =
                Case::new(Group::Matrix, name, words, move |parts| judge(parts, &setup, bounds));
            cases.push(case.at("place of the camera x sigma_t, 1/m", row.into(), column.into()));
        }
    }
    cases
}
