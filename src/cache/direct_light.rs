//! Direct light on sparse cells, filled where it is first sampled.

use glam::IVec3;

use crate::light::{LightBounds, LightRegion, LightSample};
use crate::math::{Aabb, Rgb, Spectrum, WorldPoint};
use crate::medium::SparseCells;
use crate::scene::Scene;
use crate::transport::{PathContext, direct_light};

use super::lazy_cells::{EmptyCell, LazyCells};

/// Distance from a lamp, in cells, within which its light is not cached: it varies too much over a cell.
///
/// Unit: none. Derivation: a lamp's light is as one over the squared distance: at 8 cells it
/// changes by a quarter over a cell, and linear interpolation is off by less than a hundredth.
const MIN_LAMP_DISTANCE: f64 = 8.0;

/// Ratio of the brightest to the darkest of eight cells, at most, between which light is interpolated.
///
/// Unit: none. Limit: on how far interpolation is off: exponential light is interpolated too bright by about
/// ln(r)² / 12 of it, in the mean, where it falls by the ratio r over an edge of a cell.
const MAX_RATIO: f64 = 4.0;

/// Light that comes straight from lights and that one medium scatters toward the camera. Where many rays read the
/// same cells, it is kept at the centres of those: lights are sampled once a cell, not once a ray. Where light
/// changes much from cell to cell, as at edges of shadows and where it grazes a dense medium, nothing is
/// interpolated.
#[derive(Debug)]
pub struct DirectLightCache<S = Rgb> {
    /// None where few rays would share a cell.
    cells: Option<LazyCells<S>>,
    /// Width of the cells, in metres.
    width: f64,
    medium: usize,
    seed: u64,
    lights: Vec<CachedLight>,
}

/// A light whose light is cached.
#[derive(Debug, Clone, Copy)]
struct CachedLight {
    /// Its index among the scene's lights.
    index: usize,
    /// Where it is not cached, if it shines from near the medium.
    near: Option<LightBounds>,
}

impl CachedLight {
    /// Whether its light is not cached at `p`.
    fn is_near(&self, p: WorldPoint) -> bool {
        self.near.is_some_and(|near| near.contains(p))
    }
}

impl<S: Spectrum> DirectLightCache<S> {
    /// An empty cache for the medium of this index in `scene` on `cells`, where many rays share them; `seed`
    /// is that of the random streams.
    pub fn new(
        scene: &Scene,
        medium: usize,
        cells: SparseCells,
        are_shared: bool,
        seed: u64,
    ) -> Self {
        // A medium without an end has no cells.
        let bounds = scene.media.get(medium).density.bounds().unwrap_or(Aabb::EMPTY);
        let width = cells.edge;
        let lights = scene.lights.lights.iter().enumerate();
        // Light from all around is left to photons or gathers.
        let lights = lights.filter(|(_, light)| !light.is_environment());
        let cached = lights.map(|(index, light)| {
            let near = light.bounds().map(|light| light.grown(MIN_LAMP_DISTANCE * width));
            CachedLight { index, near: near.filter(|near| near.touches(&bounds)) }
        });
        let lights = cached.collect();
        let cells = are_shared.then(|| LazyCells::new(cells, seed, medium));
        Self { cells, width, medium, seed, lights }
    }

    /// Where the light of this index is not cached.
    pub fn uncached(&self, light: usize) -> LightRegion {
        match self.lights.iter().find(|cached| cached.index == light) {
            None => LightRegion::Everywhere,
            Some(CachedLight { near: Some(near), .. }) => LightRegion::Within(*near),
            Some(CachedLight { near: None, .. }) => LightRegion::Nowhere,
        }
    }

    /// Its cells, if it keeps any light.
    pub const fn cells(&self) -> Option<&LazyCells<S>> {
        self.cells.as_ref()
    }

    /// Width of its cells in metres, which it has where they are shared.
    pub const fn width(&self) -> f64 {
        self.width
    }

    /// The cached light scattered toward the camera at `p` per unit of sigma_s, W/(m² sr): interpolated between the
    /// eight nearest cells, or sampled at `p` where those differ much or are not shared, and near lamps.
    pub fn at(&self, scene: &Scene, p: WorldPoint, ctx: &mut PathContext) -> S {
        self.interpolated(scene, p, ctx).unwrap_or_else(|| {
            let u = ctx.rng.uniform2();
            self.sampled(scene, p, |light| !light.is_near(p), u, ctx)
        })
    }

    /// The cached light at `p`, which fills the cells around: where those are shared and alike, and no lamp is near.
    pub fn interpolated(&self, scene: &Scene, p: WorldPoint, ctx: &mut PathContext) -> Option<S> {
        // Neighbouring cells sample different parts of a light.
        let fill = |&EmptyCell { cell, center, .. }: &EmptyCell, own: &mut PathContext| {
            self.sampled(scene, center, |_| true, stratified(cell, self.seed), own)
        };
        let cells = self.cells.as_ref();
        let cells = cells.filter(|_| !self.lights.iter().any(|light| light.is_near(p)));
        let are_alike = |darkest: f64, brightest: f64| brightest <= MAX_RATIO * darkest;
        cells?.interpolate(p, 0, are_alike, ctx, fill)
    }

    /// A sample of the direct light at `p` of the lights that `is_included`; `u` chooses a part of each.
    fn sampled(
        &self,
        scene: &Scene,
        p: WorldPoint,
        is_included: impl Fn(&CachedLight) -> bool,
        u: [f64; 2],
        ctx: &mut PathContext,
    ) -> S {
        let wo = scene.camera.toward(p);
        let phase = &scene.media.get(self.medium).phase;
        let mut sum = S::ZERO;
        for CachedLight { index, .. } in self.lights.iter().filter(|light| is_included(light)) {
            let light = &scene.lights.lights[*index];
            let sample = light.sample(p, u);
            if let Some(light) = sample.filter(LightSample::shines) {
                let scatterers = [(phase, S::ONE)];
                let pdf = light.pdf;
                let light = direct_light::in_scattered(scene, p, wo, &scatterers, &light, ctx);
                sum += (light / pdf).in_group(scene.groups.of_light(*index));
            }
        }
        sum
    }
}

/// Two numbers in [0, 1), stratified over any 4³ neighbouring cells (Owen-scrambled Sobol points,
/// Burley 2020).
fn stratified(cell: IVec3, seed: u64) -> [f64; 2] {
    let part = cell & 3;
    let index = (part.x * 16 + part.y * 4 + part.z) as u32;
    [0, 1].map(|dimension| f64::from(sobol_burley::sample(index, dimension, seed as u32)))
}
