//! Final gathers on sparse cells, shared by all rays that sample those.

use std::ops::Range;
use std::sync::Arc;

use crate::math::{Ray, Rgb, Span, Spectrum, Stage, Stream, WorldPoint};
use crate::medium::SparseCells;
use crate::scene::Scene;
use crate::transport::{PathContext, PixelFootprint};

use super::cell_origins::CellOrigins;
use super::gather_origin::{GatherCell, GatherOrigins};
use super::lazy_cells::LazyCells;

/// Gathers of a cell for each ray that is expected to look it up.
///
/// Unit: count. Derivation: one for every two of the four cells that it reads at a place.
pub const GATHERS_PER_RAY: f64 = 2.0 * PLACES_PER_RAY;

/// Places along a ray at which it reads caches.
///
/// Unit: count. Definition: `PLACES` of `strategy/cell_width.rs`.
pub const PLACES_PER_RAY: f64 = 4.0;

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
    /// How many of them other renders shoot before those of this one.
    pub first: u32,
    /// How many of them this render shoots.
    pub shot: u32,
}

impl SamplePass {
    /// The number of gathers nearest to `all` that can be shared evenly, at least one each, among renders that shoot as many rays
    /// as this one. Their pictures have the same weight, so that one with fewer gathers than others would add noise.
    fn even(&self, all: f64) -> u32 {
        let renders = (f64::from(self.rays.max(1)) / f64::from(self.shot.max(1))).round();
        let each = (all / renders).round().min((MAX_GATHERS / renders).floor());
        (each.max(1.0) * renders) as u32
    }

    /// The numbers of the gathers that its rays have of `all` in a cell: in proportion to the rays that are shot, and at
    /// least one.
    fn gathers(&self, all: u32) -> Range<u32> {
        let before =
            |rays: u32| (u64::from(all) * u64::from(rays) / u64::from(self.rays.max(1))) as u32;
        let start = before(self.first).min(all.saturating_sub(1));
        start..before(self.first + self.shot).max(start + 1)
    }
}

/// The Sobol points by which gathers start.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GatherPoints {
    /// Their indices.
    pub indices: Range<u32>,
    /// What their sequence is scrambled by.
    pub scramble: u32,
}

/// Light that one medium scatters toward the camera, estimated by final gathers that start [where rays
/// sample](GatherOrigins) cubic cells: rays that sample the same cell share its gathers (path space filtering,
/// Keller, Dahm and Binder 2014, on a grid). The light is smooth over a cell, as it comes from all of the
/// sky or has been scattered at least twice.
///
/// The number of gathers is in proportion to the light that rays are expected to take from a cell. Each
/// pass has its own, so that the rays of all passes weigh the same and cells improve with the picture. Where other
/// renders shoot some of the rays of a pass, they have their share of the gathers of a cell, which start at the same
/// places by Sobol points of one sequence: together they are as well stratified as in one render.
#[derive(Debug)]
pub struct FinalGatherCache<S = Rgb> {
    cells: LazyCells<S>,
    medium: usize,
    /// Seed of the Sobol points of gathers, the same in all renders that share them.
    points_seed: u64,
    footprint: PixelFootprint,
    /// Share of the rays of a pass that are expected to look cells up.
    share: f64,
    /// Where gathers of its cells start. None in a pilot, whose few rays measure work: each does its part of what a cell takes.
    origins: Option<Arc<CellOrigins<S>>>,
}

impl<S: Spectrum> FinalGatherCache<S> {
    /// An empty cache for the medium of this index on `cells`, in a picture whose pixels have this
    /// `footprint`: with the `origins` of the same cells, or without them for a pilot that measures its work. The seeds are
    /// those of the random streams and of the Sobol points of gathers.
    pub fn new(
        medium: usize,
        cells: SparseCells,
        footprint: PixelFootprint,
        [seed, points_seed]: [u64; 2],
        origins: Option<Arc<CellOrigins<S>>>,
    ) -> Self {
        let cells = LazyCells::new(cells, seed, medium);
        Self { cells, medium, points_seed, footprint, share: 1.0, origins }
    }

    /// The same for this share of the rays: of those that choose among times of a scene, or that a director leaves. It gets as
    /// much less of the gathers.
    #[must_use]
    pub fn with_share(self, share: f64) -> Self {
        Self { share, ..self }
    }

    /// Its cells of light.
    pub const fn cells(&self) -> &LazyCells<S> {
        &self.cells
    }

    /// Where gathers of the same cells start, but in a pilot.
    pub fn origins(&self) -> Option<&CellOrigins<S>> {
        self.origins.as_deref()
    }

    /// An unbiased sample of the trilinear interpolation at `p` of the light scattered toward the
    /// camera per unit of sigma_s, W/(m² sr), for a ray of `pass`: the mean of four of the eight nearest
    /// cells, drawn with `u` in [0, 1). `gather` returns the mean of gathers that start at places of a cell by these points.
    pub fn sample(
        &self,
        scene: &Scene,
        p: WorldPoint,
        u: f64,
        pass: SamplePass,
        ctx: &mut PathContext,
        gather: impl Fn(&GatherOrigins, GatherPoints, &mut PathContext) -> S,
    ) -> S {
        let (medium, width, footprint) = (self.medium, self.cells.width(), &self.footprint);
        // Gathers of a cell, by the number of rays that are expected to look it up.
        let wanted = |center: WorldPoint, origins: &GatherOrigins| {
            let rays = origins.opacity() * (width / footprint.width(center)).powi(2);
            GATHERS_PER_RAY * f64::from(pass.rays) * self.share * rays
        };
        let Some(origins) = &self.origins else {
            // What decides their number is work of cells, not of rays.
            let here = GatherOrigins::at::<S>(scene, medium, p, width, footprint, &mut ctx.clone());
            let gathers = wanted(p, &here);
            let lookups = gathers * PLACES_PER_RAY / GATHERS_PER_RAY;
            let part = self.opacity(scene, p) / lookups.max(1.0);
            if ctx.rng.uniform() < part {
                let cell = GatherCell { center: p, width, scramble: ctx.rng.scramble() };
                GatherOrigins::in_cell::<S>(scene, medium, cell, footprint, None, ctx);
            }
            let count = (gathers.max(MIN_GATHERS) * part + ctx.rng.uniform()) as u32;
            if count == 0 {
                return S::ZERO;
            }
            let points = GatherPoints { indices: 0..count, scramble: ctx.rng.scramble() };
            return gather(&here, points, ctx);
        };
        // Pass 0 of the cells is that of light which all passes share.
        self.cells.sample(p, u, 1 + pass.index, ctx, |cell, own| {
            // Renders that share the rays of a pass count the same gathers, and start them by the same points.
            let (stage, index) = (Stage::GatherPoints, pass.index.into());
            let mut shared = Stream::new(self.points_seed, stage, cell.key, index);
            let scramble = shared.scramble();
            let origins = origins.of(scene, cell, footprint, own);
            let all = wanted(cell.center, &origins).clamp(MIN_GATHERS, MAX_GATHERS);
            let indices = pass.gathers(pass.even(all));
            gather(&origins, GatherPoints { indices, scramble }, own)
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

#[cfg(test)]
mod tests {
    use std::cell::RefCell;

    use proptest::prelude::*;

    use super::*;
    use crate::scene::plan::Needs;

    /// What the gathers of one cell start by: two places, and their Sobol points.
    type Start = ([WorldPoint; 2], GatherPoints);

    /// That of the gathers which a render whose cells have this `seed` makes at `p` for its rays of `pass`.
    fn start(scene: &Scene, p: WorldPoint, seed: u64, pass: SamplePass) -> Start {
        start_with(1.0, scene, p, seed, pass)
    }

    /// As [`start`], with the gathers of this share of the rays.
    fn start_with(share: f64, scene: &Scene, p: WorldPoint, seed: u64, pass: SamplePass) -> Start {
        let cells = SparseCells::covering(&scene.media.get(0).density, 0.5, 1).unwrap();
        let footprint = PixelFootprint::new(scene, 1.0);
        let origins = Some(Arc::new(CellOrigins::new(cells.clone(), 0, 7)));
        let cache = FinalGatherCache::<f64>::new(0, cells, footprint, [seed, 7], origins);
        let cache = cache.with_share(share);
        let mut ctx = PathContext::new(Stream::new(seed, Stage::Test, 0, 0), Needs::EVERYTHING);
        let starts = RefCell::new(Vec::new());
        cache.sample(scene, p, 0.3, pass, &mut ctx, |origins, points, _| {
            starts.borrow_mut().push(([0.2, 0.7].map(|u| origins.place(u)), points));
            0.0
        });
        let mut starts = starts.into_inner();
        assert_eq!(starts.len(), 1, "one cell is read at its centre");
        starts.remove(0)
    }

    /// Renders that share the rays of a pass start its gathers at the same places, whatever numbers else they draw, and
    /// have each index of one sequence once, and as many as each other.
    #[test]
    fn renders_of_one_pass_share_points_and_all_share_places() {
        let scene = Scene::of_text(
            "
            [camera]
            position = [0.0, 0.0, 9.0]
            target = [0.0, 0.0, 0.0]
            [film]
            size = [64, 64]
            [[medium]]
            region = { sphere = { center = [0.0, 0.0, 0.0], radius = 2.0 } }
            sigma_t = 1.0
            ",
        );
        let cells = SparseCells::covering(&scene.media.get(0).density, 0.5, 1).unwrap();
        let nearest = cells.to_cells(WorldPoint::new(0.3, 0.2, 1.7)).floor();
        let p = cells.to_world(nearest + 0.5);
        let pass = |first, shot| SamplePass { index: 1, rays: 64, first, shot };
        let (places, whole) = start(&scene, p, 1, pass(0, 64));
        let (mut next, mut counts) = (0, Vec::new());
        for render in 0..8 {
            let (own, points) = start(&scene, p, 10 + u64::from(render), pass(8 * render, 8));
            assert_eq!((own, points.scramble), (places, whole.scramble));
            assert_eq!(points.indices.start, next);
            next = points.indices.end;
            counts.push(points.indices.len());
        }
        // As many gathers in each, as near to those of the whole as that allows.
        let each = (f64::from(whole.indices.end) / 8.0).round() as usize;
        assert_eq!(counts, [each; 8]);
        // Another pass has its own points.
        let (others, points) = start(&scene, p, 1, SamplePass { index: 2, ..pass(0, 64) });
        assert!(others == places && points.scramble != whole.scramble);
        // A quarter of the rays has as much of the gathers.
        let (_, quarter) = start_with(0.25, &scene, p, 1, pass(0, 64));
        let [all, quarter] = [&whole, &quarter].map(|points| f64::from(points.indices.end));
        assert!(all > 40.0 && (quarter - all / 4.0).abs() <= 0.5, "{quarter} of {all}");
    }

    proptest! {
        /// Renders that share the rays of a pass have the gathers of a cell once between them, where each can have one.
        #[test]
        fn gathers_are_shared_as_rays_are(all in 1_u32..100_000, shares in prop::collection::vec(1_u32..50, 1..12)) {
            let rays = shares.iter().sum();
            let (mut first, mut made) = (0, 0);
            let mut numbers = Vec::new();
            for shot in shares.iter().copied() {
                let own = SamplePass { index: 0, rays, first, shot }.gathers(all);
                prop_assert!(!own.is_empty() && own.end <= all);
                made += own.len() as u32;
                first += shot;
                numbers.push(own);
            }
            prop_assert_eq!((numbers[0].start, numbers.last().map(|own| own.end)), (0, Some(all)));
            if shares.iter().all(|shot| all * shot >= rays) {
                prop_assert_eq!(made, all);
                prop_assert!(numbers.windows(2).all(|pair| pair[0].end == pair[1].start));
            }
            let whole = SamplePass { index: 2, rays, first: 0, shot: rays };
            prop_assert_eq!(whole.gathers(all), 0..all);
        }

        /// Renders with as many rays have as many gathers of a cell, each of them once, and in all of them together hardly more or
        /// fewer than in one render.
        #[test]
        fn even_parts_have_as_many_gathers(
            all in MIN_GATHERS..=MAX_GATHERS, shot in 1_u32..50, renders in 1_u32..40,
        ) {
            let pass = |first| SamplePass { index: 0, rays: renders * shot, first, shot };
            let even = pass(0).even(all);
            prop_assert!(f64::from(even) <= MAX_GATHERS);
            let each = even / renders;
            prop_assert!(each == 1 || f64::from(even) - all >= -f64::from(renders));
            prop_assert!(each == 1 || f64::from(even) - all <= 0.5 * f64::from(renders));
            for render in 0..renders {
                prop_assert_eq!(pass(render * shot).gathers(even), render * each..(render + 1) * each);
            }
        }
    }
}
