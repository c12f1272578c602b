//! Direct light on a lattice, found where it is first asked for.

use glam::IVec3;

use crate::light::Light;
use crate::math::{Aabb, Rgb, Spectrum, World, WorldPoint};
use crate::scene::Scene;
use crate::transport::{PathContext, direct_light};

use super::cell_size::{Pixel, Widths, thin_edge};
use super::lazy_cells::{EmptyCell, LazyCells};

/// Edge of a cell in pixels, where the camera sees it.
const PIXELS: f64 = 1.5;

/// Rays of a pixel up to which cells may be as wide as thin ones are.
const FEW: u32 = 16;

/// How their edge falls with the number of rays: a pixel's variance falls with that, and the squared bias
/// of what is interpolated with the fourth power of the edge.
const FALL: f64 = -0.25;

/// Cells within which a lamp is too near for its light to be kept.
const NEAR: f64 = 8.0;

/// Light that comes straight from lights and is scattered toward the camera by one medium, kept at
/// the centres of cubic cells: what a place costs is paid once, not for each ray that comes by.
#[derive(Debug)]
pub struct DirectLightCache<S = Rgb> {
    filled: LazyCells<S>,
    medium: usize,
    seed: u64,
    /// Indices of the lights whose light is kept.
    lights: Vec<usize>,
}

impl<S: Spectrum> DirectLightCache<S> {
    /// A lattice for the medium of this index in `scene`, of which the camera sees `visible`
    /// places, for a picture of which each pixel stands for so many of the film along each side and
    /// gets so many rays. Nothing where cells would be too thick or too many.
    pub fn new(
        scene: &Scene,
        medium: usize,
        visible: &[WorldPoint],
        pixels: f64,
        rays: u32,
        seed: u64,
    ) -> Option<Self> {
        let of = scene.media.get(medium);
        let widest = thin_edge(of, visible);
        let widths = Widths { pixels: PIXELS, widest, few: FEW, fall: FALL };
        let cells = Pixel::new(scene, pixels).cells(of, visible, rays, &widths)?;
        let near = of.density.bounds()?.grown(NEAR * cells.edge);
        let kept = |light: &Light| is_kept(light, &near);
        let lights = &scene.lights.lights;
        let lights = (0..lights.len()).filter(|&index| kept(&lights[index])).collect();
        Some(Self { filled: LazyCells::new(cells, seed, medium), medium, seed, lights })
    }

    /// Whether the light of this index is kept.
    pub fn keeps(&self, light: usize) -> bool {
        self.lights.contains(&light)
    }

    /// Its cells.
    pub const fn filled(&self) -> &LazyCells<S> {
        &self.filled
    }

    /// The light scattered at `p` per unit of sigma_s, W/(m² sr): that of one of the eight cells round
    /// it, drawn by its trilinear weight.
    pub fn near(&self, scene: &Scene, p: WorldPoint, ctx: &mut PathContext) -> S {
        self.filled.near(p, 0, ctx, |cell, own| self.light(scene, cell, own))
    }

    /// Direct light at the centre of a cell.
    fn light(
        &self,
        scene: &Scene,
        &EmptyCell { cell, center }: &EmptyCell,
        ctx: &mut PathContext,
    ) -> S {
        let toward = scene.camera.toward(center);
        let phase = &scene.media.get(self.medium).phase;
        let mut sum = S::ZERO;
        for &index in &self.lights {
            let light = &scene.lights.lights[index];
            // Cells side by side sample different parts of a light.
            let sample = light.sample(center, spread(cell, self.seed));
            if let Some(light) = sample.filter(|s| s.pdf > 0.0 && s.radiance != Rgb::ZERO) {
                let scatterers = [(phase, S::ONE)];
                let pdf = light.pdf;
                sum += direct_light::in_scattered(scene, center, toward, &scatterers, &light, ctx)
                    / pdf;
            }
        }
        sum
    }
}

/// Whether a light's direct light is smooth enough in the box to be kept.
fn is_kept(light: &Light, near: &Aabb<World>) -> bool {
    match light.position() {
        Some(place) => !near.contains(place),
        None => !light.is_environment(),
    }
}

/// Two numbers in [0, 1), spread evenly over any 4³ neighbouring cells.
fn spread(cell: IVec3, seed: u64) -> [f64; 2] {
    let part = cell & 3;
    let index = (part.x * 16 + part.y * 4 + part.z) as u32;
    [0, 1].map(|dimension| f64::from(sobol_burley::sample(index, dimension, seed as u32)))
}
