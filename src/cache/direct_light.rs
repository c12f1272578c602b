//! Direct light on sparse cells, filled where it is first sampled.

use glam::IVec3;

use crate::light::Light;
use crate::math::{Aabb, Rgb, Spectrum, World, WorldPoint};
use crate::medium::SparseCells;
use crate::scene::Scene;
use crate::transport::{PathContext, direct_light};

use super::lazy_cells::{EmptyCell, LazyCells};

/// Distance from the medium, in cells, within which the light of a lamp is not cached: it varies too
/// much over a cell.
///
/// Unit: none. Derivation: a lamp's light is as one over the squared distance: at 8 cells it
/// changes by a quarter over a cell, and linear interpolation is off by less than a hundredth.
const MIN_LAMP_DISTANCE: f64 = 8.0;

/// Light that comes straight from lights and that one medium scatters toward the camera, at the
/// centres of cubic cells: lights are sampled once a cell, not once a ray.
#[derive(Debug)]
pub struct DirectLightCache<S = Rgb> {
    cells: LazyCells<S>,
    medium: usize,
    seed: u64,
    /// Indices of the lights whose light is cached.
    lights: Vec<usize>,
}

impl<S: Spectrum> DirectLightCache<S> {
    /// An empty cache for the medium of this index in `scene` on `cells`; `seed` is that of the random
    /// streams.
    pub fn new(scene: &Scene, medium: usize, cells: SparseCells, seed: u64) -> Self {
        // A medium without an end has no cells.
        let near = scene.media.get(medium).density.bounds().unwrap_or(Aabb::EMPTY);
        let near = near.grown(MIN_LAMP_DISTANCE * cells.edge);
        let lights = &scene.lights.lights;
        let cached = (0..lights.len()).filter(|&index| is_smooth(&lights[index], &near));
        let lights = cached.collect();
        Self { cells: LazyCells::new(cells, seed, medium), medium, seed, lights }
    }

    /// Whether the light of this index is cached.
    pub fn caches(&self, light: usize) -> bool {
        self.lights.contains(&light)
    }

    /// Its cells.
    pub const fn cells(&self) -> &LazyCells<S> {
        &self.cells
    }

    /// An unbiased sample of the trilinear interpolation at `p` of the light scattered toward the
    /// camera per unit of sigma_s, W/(m² sr): that of one of the eight nearest cells.
    pub fn sample(&self, scene: &Scene, p: WorldPoint, ctx: &mut PathContext) -> S {
        self.cells.sample(p, 0, ctx, |cell, own| self.light(scene, cell, own))
    }

    /// Direct light at the centre of a cell.
    fn light(
        &self,
        scene: &Scene,
        &EmptyCell { cell, center }: &EmptyCell,
        ctx: &mut PathContext,
    ) -> S {
        let wo = scene.camera.toward(center);
        let phase = &scene.media.get(self.medium).phase;
        let mut sum = S::ZERO;
        for &index in &self.lights {
            let light = &scene.lights.lights[index];
            // Neighbouring cells sample different parts of a light.
            let sample = light.sample(center, stratified(cell, self.seed));
            if let Some(light) = sample.filter(|s| s.pdf > 0.0 && s.radiance != Rgb::ZERO) {
                let scatterers = [(phase, S::ONE)];
                let pdf = light.pdf;
                sum +=
                    direct_light::in_scattered(scene, center, wo, &scatterers, &light, ctx) / pdf;
            }
        }
        sum
    }
}

/// Whether a light's direct light varies slowly in the box, so that cells can interpolate it. Light
/// from all around is left to photons or gathers.
fn is_smooth(light: &Light, near: &Aabb<World>) -> bool {
    match light.position() {
        Some(position) => !near.contains(position),
        None => !light.is_environment(),
    }
}

/// Two numbers in [0, 1), stratified over any 4³ neighbouring cells (Owen-scrambled Sobol points,
/// Burley 2020).
fn stratified(cell: IVec3, seed: u64) -> [f64; 2] {
    let part = cell & 3;
    let index = (part.x * 16 + part.y * 4 + part.z) as u32;
    [0, 1].map(|dimension| f64::from(sobol_burley::sample(index, dimension, seed as u32)))
}
