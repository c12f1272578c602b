//! The pieces of the renderer that are verified, so that a faulty one can stand in for each.

use crate::error::Result;
use crate::film::{Accumulator, Sample};
use crate::math::{Ray, Rgb, Span, Stream, World};
use crate::medium::{Media, Phase, Profile};
use crate::render::{Rendered, Silent, render, render_reference};
use crate::scene::{RenderSettings, Scene};
use crate::vdb::{Grid, GridToWrite, ReadAs, VdbFile, write};

/// What a march along a ray brings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Marched {
    /// Transmittance of the ray, per channel.
    pub transmittance: Rgb,
    /// Light emitted along it that arrives at its start, W/(m² sr).
    pub emitted: Rgb,
}

/// Marches a span of a ray (unit direction) through media by steps of so many metres, each
/// sampled at the given fraction of it.
pub type March = dyn Fn(&Media, &Ray<World>, Span, f64, f64) -> Marched + Send + Sync;
/// A phase function at a cosine, 1/sr.
pub type PhaseValue = dyn Fn(&Phase, f64) -> f64 + Send + Sync;
/// The mean of many radiances as a film keeps it.
pub type Mean = dyn Fn(&mut dyn Iterator<Item = f64>) -> f64 + Send + Sync;
/// A grid written to a file and read back as a density.
pub type Export = dyn Fn(&GridToWrite) -> Result<Grid<f32>> + Send + Sync;
/// Distance of the first real collision along a span of a ray in grey media, found by free flight.
pub type FreeFlight = dyn Fn(&Media, &Ray<World>, Span, &mut Stream) -> Option<f64> + Send + Sync;
/// Renders a scene by photon map and march, or by the reference.
pub type Render = dyn Fn(&Scene, &RenderSettings) -> Result<Rendered> + Send + Sync;

/// What cases are run on.
pub struct Parts {
    /// The march.
    pub march: Box<March>,
    /// Phase functions.
    pub phase: Box<PhaseValue>,
    /// The accumulation of samples.
    pub mean: Box<Mean>,
    /// Writing and reading of grids.
    pub export: Box<Export>,
    /// Free flight.
    pub free_flight: Box<FreeFlight>,
    /// Pictures by photon map and march.
    pub render: Box<Render>,
    /// Pictures by unbiased path tracing.
    pub reference: Box<Render>,
}

impl Parts {
    /// Fogbow's own.
    pub fn fogbow() -> Self {
        Self {
            march: Box::new(march),
            phase: Box::new(Phase::eval),
            mean: Box::new(mean),
            export: Box::new(export),
            free_flight: Box::new(free_flight),
            render: Box::new(|scene, settings| render(scene, settings, &Silent)),
            reference: Box::new(|scene, settings| Ok(render_reference(scene, settings, &Silent))),
        }
    }
}

impl Default for Parts {
    fn default() -> Self {
        Self::fogbow()
    }
}

impl std::fmt::Debug for Parts {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Parts").finish_non_exhaustive()
    }
}

fn march(media: &Media, ray: &Ray<World>, span: Span, step: f64, jitter: f64) -> Marched {
    let mut profile = Profile::default();
    profile.trace(media, ray, span, step, jitter);
    Marched { transmittance: profile.transmittance(), emitted: profile.emitted() }
}

fn mean(radiances: &mut dyn Iterator<Item = f64>) -> f64 {
    let mut samples = Accumulator::default();
    for radiance in radiances {
        samples.add(Sample { radiance: Rgb::splat(radiance), ..Sample::default() });
    }
    samples.mean().x
}

fn export(grid: &GridToWrite) -> Result<Grid<f32>> {
    let folder = super::scenes::folder()?;
    let path = folder.path().join("grid.vdb");
    write(&path, std::slice::from_ref(grid))?;
    VdbFile::open(&path)?.read_scalar(0, ReadAs::Density)
}

fn free_flight(media: &Media, ray: &Ray<World>, span: Span, rng: &mut Stream) -> Option<f64> {
    let mut flights = media.flights(ray, span, Rgb::ONE, rng);
    while let Some(c) = flights.next(rng) {
        if rng.uniform() * c.majorant < media.get(c.medium).sigma_t.x * c.density {
            return Some(c.t);
        }
    }
    None
}
