//! Densities that are hard on majorants and grids: spikes, a wall, puffs far apart.

use glam::{DVec3, IVec3};

use super::judge::{Bounds, judge};
use super::setup::Setup;
use crate::vdb::GridToWrite;
use crate::verify::case::{Case, Effort, Group};
use crate::verify::fields;

/// Thin smoke with single voxels a million times as dense.
fn spikes() -> GridToWrite {
    fields::blocks("density", 1.0, IVec3::splat(-2), IVec3::splat(2), |v| {
        if (v & 15) == IVec3::splat(7) { 1e6 } else { 1.0 }
    })
}

/// Density 1 on one side of a plane between voxels, nothing on the other.
fn wall() -> GridToWrite {
    fields::blocks("density", 1.0, IVec3::splat(-2), IVec3::splat(2), |v| f64::from(v.x < 0))
}

/// Two puffs of 16 voxels a hundred thousand voxels apart.
fn far_apart() -> GridToWrite {
    let mut grid = GridToWrite::fog("density", 1.0, DVec3::ZERO);
    for corner in 0..8 {
        let at = IVec3::new(corner & 1, corner >> 1 & 1, corner >> 2) * 8 - 8;
        for middle in [IVec3::ZERO, IVec3::new(100_000, 0, 0)] {
            let value = |v: IVec3| (1.0 - (v - middle).as_dvec3().length() / 7.0).max(0.0);
            grid.blocks.push(fields::block(at + middle, value));
        }
    }
    grid
}

/// Tentative collisions a photon path may take: some dozens a brick that it crosses and a few a
/// scattering, where the majorant of a spike's brick alone would bring millions.
const COLLISIONS: f64 = 2e4;

type Shape = (&'static str, fn() -> GridToWrite);

pub(super) fn cases(effort: Effort) -> Vec<Case> {
    let words = [
        "white furnace: L = 1; L from 0 to 1 for albedo 0.5",
        "noise of 2000 photons: 30 %, a factor of 2 to 3 where few are seen",
    ];
    let camera = "type = \"orthographic\"\nposition = [50000.0, 0.0, 50000.0]\n\
                  target = [0.2, 0.3, 0.1]\nheight = 12.0";
    let shapes: [Shape; 3] =
        [("spikes of 1e6", spikes), ("wall", wall), ("puffs 1e5 voxels apart", far_apart)];
    let thicknesses: &[f64] =
        if effort == Effort::Full { &[1e-6, 1e-3, 1.0, 1e3] } else { &[1e-3, 1.0] };
    let mut cases = Vec::new();
    for (row, grid) in shapes {
        for &sigma_t in thicknesses {
            for albedo in [0.5, 1.0] {
                let name = format!("matrix/shape/{row}/sigma_t={sigma_t:e}/albedo={albedo}");
                let case = Case::new(Group::Matrix, name, words, move |parts| {
                    let setup = Setup {
                        camera: camera.into(),
                        photons: 2000,
                        medium: format!(
                            "file = \"grids.vdb\"\nsigma_t = {sigma_t:?}\nalbedo = {albedo:?}"
                        ),
                        grids: vec![grid()],
                        ..Setup::default()
                    };
                    let bounds = match albedo < 1.0 {
                        true => Bounds::ENERGY,
                        // Most photons lie where nobody sees them.
                        false if sigma_t > 1.0 => Bounds::mean(0.3, 1.8),
                        false => Bounds::WHITE,
                    };
                    let bounds = Bounds { collisions: COLLISIONS, ..bounds };
                    judge(parts, &setup, bounds)
                });
                let column = format!("{sigma_t:e}, {albedo}");
                cases.push(case.at("shape of the density x sigma_t, albedo", row.into(), column));
            }
        }
    }
    cases
}
