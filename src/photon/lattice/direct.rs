//! Direct light on a lattice, found where it is first asked for.

use std::marker::PhantomData;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Instant;

use glam::IVec3;

use crate::light::Light;
use crate::math::{Aabb, Rgb, Spectrum, Stage, Stream, World, WorldPoint};
use crate::scene::Scene;
use crate::scene::lighting::{self, Draws};

use super::edge::edge_for_direct;
use super::shape::{BRICK, Cells, VOLUME, cell_index};

/// Cells within which a lamp is too near for its light to be kept.
const NEAR: f64 = 8.0;

/// Marks a cell that has not been asked for: no number.
const UNKNOWN: u32 = u32::MAX;

/// Light that comes straight from lights and is scattered toward the camera by one medium, kept at
/// the centres of cubic cells: what a place costs is paid once, not for each ray that comes by.
#[derive(Debug)]
pub struct DirectLattice<S = Rgb> {
    cells: Cells,
    medium: usize,
    seed: u64,
    /// Indices of the lights whose light is kept.
    lights: Vec<usize>,
    /// Bits of one number a channel, cell by cell.
    values: Vec<AtomicU32>,
    channels: PhantomData<S>,
}

impl<S: Spectrum> DirectLattice<S> {
    /// A lattice for the medium of this index in `scene`, of which the camera sees `visible`
    /// places, for a picture of which each pixel stands for so many of the film along each side.
    /// Nothing where cells would be too thick or too many.
    pub fn new(
        scene: &Scene,
        medium: usize,
        visible: &[WorldPoint],
        pixels: f64,
        seed: u64,
    ) -> Option<Self> {
        let of = scene.media.get(medium);
        let edge = edge_for_direct(scene, of, visible, pixels)?;
        let cells = Cells::around(&of.density, edge, 1)?;
        let near = of.density.bounds()?.grown(NEAR * edge);
        let kept = |light: &Light| is_kept(light, &near);
        let lights = &scene.lights.lights;
        let lights = (0..lights.len()).filter(|&index| kept(&lights[index])).collect();
        let numbers = cells.bricks() * VOLUME * S::CHANNELS;
        let values = (0..numbers).map(|_| AtomicU32::new(UNKNOWN)).collect();
        Some(Self { cells, medium, seed, lights, values, channels: PhantomData })
    }

    /// Edge of a cell, in metres.
    pub const fn edge(&self) -> f64 {
        self.cells.edge
    }

    /// Whether the light of this index is kept.
    pub fn keeps(&self, light: usize) -> bool {
        self.lights.contains(&light)
    }

    /// Bytes in memory.
    pub const fn memory_bytes(&self) -> usize {
        self.values.len() * size_of::<AtomicU32>()
    }

    /// How many cells there are.
    pub const fn cells(&self) -> usize {
        self.values.len() / S::CHANNELS
    }

    fn channels_of(&self, cell: usize) -> &[AtomicU32] {
        &self.values[cell * S::CHANNELS..][..S::CHANNELS]
    }

    /// The bits of what is known of a cell, for storing; nothing where it has not been asked for.
    pub fn known(&self, cell: usize) -> Option<[u32; 3]> {
        let channels = self.channels_of(cell);
        let known = channels[0].load(Ordering::Acquire);
        let channel = |c: usize| channels.get(c).map_or(known, |v| v.load(Ordering::Relaxed));
        (known != UNKNOWN).then(|| [known, channel(1), channel(2)])
    }

    /// Takes back what [`known`](Self::known) told of a cell of the same lattice; no work is counted
    /// for it again.
    pub fn recall(&self, cell: usize, value: [u32; 3]) {
        // The first channel last: it says that the others are there.
        for (channel, bits) in self.channels_of(cell).iter().zip(value).rev() {
            channel.store(bits, Ordering::Release);
        }
    }

    /// The light scattered at `p` per unit of sigma_s, W/(m² sr), of one of the eight cells round it,
    /// drawn with the weight that it has in trilinear interpolation: that is what comes out on
    /// average, and of the cells that few rays ask for an eighth has to be found. 0 where there are
    /// none. `draws` counts the work, each cell's once.
    pub fn near(&self, scene: &Scene, p: WorldPoint, draws: &mut Draws) -> S {
        let local = self.cells.local(p) - 0.5;
        let low = local.floor();
        let [x, y, z] =
            (local - low).to_array().map(|share| i32::from(draws.rng.uniform() < share));
        S::long(self.cell(scene, low.as_ivec3() + IVec3::new(x, y, z), draws))
    }

    /// The value of a cell. Threads that ask for it at once find the same.
    fn cell(&self, scene: &Scene, cell: IVec3, draws: &mut Draws) -> S::Short {
        let Some(brick) = self.cells.brick_anywhere(cell >> BRICK) else {
            return S::Short::default();
        };
        let within = cell & ((1 << BRICK) - 1);
        let index = brick * VOLUME + cell_index(within);
        let channels = self.channels_of(index);
        if channels[0].load(Ordering::Acquire) != UNKNOWN {
            return S::from_channels(|c| f32::from_bits(channels[c].load(Ordering::Relaxed)));
        }
        let start = Instant::now();
        let stream = Stream::new(self.seed, Stage::March, index as u64, u64::MAX);
        let mut own = Draws::new(stream, draws.needs);
        let light = self.light(scene, cell, &mut own).short();
        let light = if S::long(light).is_finite() { light } else { S::Short::default() };
        let bits = |channel| S::short_channel(light, channel).to_bits();
        for (channel, stored) in channels.iter().enumerate().skip(1) {
            stored.store(bits(channel), Ordering::Relaxed);
        }
        let (first, bits) = (&channels[0], bits(0));
        if first.compare_exchange(UNKNOWN, bits, Ordering::AcqRel, Ordering::Relaxed).is_ok() {
            draws.work += own.work;
        }
        draws.once += start.elapsed();
        light
    }

    /// Direct light at the centre of a cell.
    fn light(&self, scene: &Scene, cell: IVec3, draws: &mut Draws) -> S {
        let p = self.cells.world(cell.as_dvec3() + 0.5);
        let toward = scene.camera.toward(p);
        let phase = &scene.media.get(self.medium).phase;
        let mut sum = S::ZERO;
        for &index in &self.lights {
            let light = &scene.lights.lights[index];
            // Cells side by side sample different parts of a light.
            let sample = light.sample(p, spread(cell, self.seed));
            if let Some(light) = sample.filter(|s| s.pdf > 0.0 && s.radiance != Rgb::ZERO) {
                let scatterers = [(phase, S::ONE)];
                let pdf = light.pdf;
                sum += lighting::scattered(scene, p, toward, &scatterers, &light, draws) / pdf;
            }
        }
        sum
    }
}

/// Whether a light's direct light is smooth enough in the box to be kept.
fn is_kept(light: &Light, near: &Aabb<World>) -> bool {
    match light.place() {
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
