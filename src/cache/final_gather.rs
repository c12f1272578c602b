//! Final gathers on sparse cells, shared by all rays that sample those.

use crate::math::{Ray, Rgb, Span, Spectrum, WorldPoint};
use crate::medium::SparseCells;
use crate::scene::Scene;
use crate::transport::{PathContext, PixelFootprint};

use super::gather_origin::GatherOrigins;
use super::lazy_cells::LazyCells;

/// Gathers per expected lookup of a cell by a ray: about one for each place at which a ray samples.
///
/// Unit: count. Derivation: one for each place at which a ray reads caches.
pub const GATHERS_PER_RAY: f64 = 8.0;

/// Fewest gathers of a cell.
///
/// Unit: count. Limit: on the noise of cells that few rays read.
const MIN_GATHERS: f64 = 4.0;

/// Most gathers of a cell in one pass: they take less than a second, and the Sobol points of their
/// first deflections last for as many.
///
/// Unit: count. Limit: on the time of one cell.
const MAX_GATHERS: f64 = 65_536.0;

/// Some of the rays of each pixel, which are shot together before others are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SamplePass {
    /// Number of passes before.
    pub index: u32,
    /// Rays of a pixel that belong to it, at most.
    pub rays: u32,
}

/// Light that one medium scatters toward the camera, estimated by final gathers that start [where rays
/// sample](GatherOrigins) cubic cells: rays that sample the same cell share its gathers (path space filtering,
/// Keller, Dahm and Binder 2014, on a grid). The light is smooth over a cell, as it comes from all of the
/// sky or has been scattered at least twice.
///
/// The number of gathers is in proportion to the light that rays are expected to take from a cell. Each
/// pass has its own, so that the rays of all passes weigh the same and cells improve with the picture.
#[derive(Debug)]
pub struct FinalGatherCache<S = Rgb> {
    cells: LazyCells<S>,
    medium: usize,
    footprint: PixelFootprint,
    /// Whether the few rays of a pilot measure work: each then does its part of a cell's gathers.
    pilot: bool,
}

impl<S: Spectrum> FinalGatherCache<S> {
    /// An empty cache for the medium of this index on `cells`, in a picture whose pixels have this
    /// `footprint`, or for a `pilot` that measures its work. `seed` is that of the random streams.
    pub fn new(
        medium: usize,
        cells: SparseCells,
        footprint: PixelFootprint,
        seed: u64,
        pilot: bool,
    ) -> Self {
        Self { cells: LazyCells::new(cells, seed, medium), medium, footprint, pilot }
    }

    /// Its cells.
    pub const fn cells(&self) -> &LazyCells<S> {
        &self.cells
    }

    /// An unbiased sample of the trilinear interpolation at `p` of the light scattered toward the
    /// camera per unit of sigma_s, W/(m² sr), for a ray of `pass`: that of one of the eight nearest
    /// cells. `gather` returns the mean of a number of gathers that start at places of a cell.
    pub fn sample(
        &self,
        scene: &Scene,
        p: WorldPoint,
        pass: SamplePass,
        ctx: &mut PathContext,
        gather: impl FnOnce(&GatherOrigins, u32, &mut PathContext) -> S,
    ) -> S {
        let (medium, width, footprint) = (self.medium, self.cells.width(), &self.footprint);
        // Gathers of a cell, by the number of rays that are expected to look it up.
        let wanted = |center: WorldPoint, origins: &GatherOrigins| {
            let rays = origins.opacity() * (width / footprint.width(center)).powi(2);
            GATHERS_PER_RAY * f64::from(pass.rays) * rays
        };
        if self.pilot {
            // What decides their number is work of cells, not of rays.
            let here = GatherOrigins::at::<S>(scene, medium, p, width, footprint, &mut ctx.clone());
            let lookups = wanted(p, &here);
            let part = self.opacity(scene, p) / lookups.max(1.0);
            if ctx.rng.uniform() < part {
                GatherOrigins::in_cell::<S>(scene, medium, p, width, footprint, ctx);
            }
            let count = (lookups.max(MIN_GATHERS) * part + ctx.rng.uniform()) as u32;
            return if count > 0 { gather(&here, count, ctx) } else { S::ZERO };
        }
        // Pass 0 of the cells is that of light which all passes share.
        self.cells.sample(p, 1 + pass.index, ctx, |cell, own| {
            let center = cell.center;
            let origins = GatherOrigins::in_cell::<S>(scene, medium, center, width, footprint, own);
            let count = wanted(center, &origins).clamp(MIN_GATHERS, MAX_GATHERS).round();
            gather(&origins, count as u32, own)
        })
    }

    /// Opacity of the whole camera ray through `p`: where it is low, many rays take little light.
    fn opacity(&self, scene: &Scene, p: WorldPoint) -> f64 {
        let wo = scene.camera.toward(p);
        let parts = [(wo, self.footprint.distance(p)), (-wo, f64::INFINITY)];
        let thickness = parts.map(|(direction, length)| {
            scene.media.optical_thickness(&Ray::new(p, direction), Span::new(0.0, length))
        });
        1.0 - (-(thickness[0] + thickness[1])).exp().max_element()
    }
}
