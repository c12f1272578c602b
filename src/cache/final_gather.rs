//! Final gathers on sparse cells, shared by all rays that sample those.

use std::ops::Range;
use std::sync::Arc;

use crate::math::{Ray, Rgb, Span, Spectrum, Stage, Stream, WorldPoint};
use crate::medium::SparseCells;
use crate::scene::Scene;
use crate::transport::{PathContext, PixelFootprint};

use super::cell_origins::CellOrigins;
use super::directed_rays::DirectedRays;
use super::gather_origin::{GatherCell, GatherOrigins};
use super::lazy_cells::{EmptyCell, LazyCells};
use super::sample_pass::{MAX_GATHERS, ReadingRays, SamplePass};

/// Gathers of a cell for each ray that is expected to look it up.
///
/// Unit: count. Derivation: one for every two of the four cells that it reads at a place.
pub const GATHERS_PER_RAY: f64 = 2.0 * PLACES_PER_RAY;

/// Places along a ray at which it reads caches.
///
/// Unit: count. Definition: `PLACES` of `strategy/cell_width.rs`.
pub const PLACES_PER_RAY: f64 = 4.0;

/// Passes of cells before the first pass of rays: pass 0 holds light that all rays share.
///
/// Unit: count. Definition: of that pass.
const CELL_PASSES: u32 = 1;

/// Least expected number of gathers that is rounded to one.
///
/// Unit: count. Definition: of rounding.
const ROUNDED_TO_ONE: f64 = 0.5;

/// Fewest gathers of a cell.
///
/// Unit: count. Limit: on the noise of cells that few rays read.
const MIN_GATHERS: f64 = 4.0;

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
/// pass has its own, so that the rays of all passes weigh the same and cells improve with the picture. In a directed
/// picture a pass in which few rays read a cell makes few gathers for it, and cannot know which pixels have many of those
/// rays: a cell is then the mean of all gathers up to that pass, never noisier than before it. Where other
/// renders shoot some of the rays of a pass, they have their share of the gathers of a cell, which start at the same
/// places by Sobol points of one sequence: together they are as well stratified as in one render.
#[derive(Debug)]
pub struct FinalGatherCache<S = Rgb> {
    cells: LazyCells<S>,
    medium: usize,
    /// Seed of the Sobol points of gathers, the same in all renders that share them.
    points_seed: u64,
    footprint: PixelFootprint,
    /// Share of the rays of a pass that are expected to look cells up, by their time.
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

    /// The same for this share of the rays: of those that choose among times of a scene. It gets as much less of the
    /// gathers.
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
    /// camera per unit of sigma_s, W/(m² sr), for one of these `rays`: the mean of four of the eight nearest
    /// cells, drawn with `u` in [0, 1); where other renders share their pass, the interpolation itself. `gather`
    /// returns the mean of gathers that start at places of a cell by these points.
    pub fn sample(
        &self,
        scene: &Scene,
        p: WorldPoint,
        u: f64,
        rays: ReadingRays<'_>,
        ctx: &mut PathContext,
        gather: impl Fn(&GatherOrigins, GatherPoints, &mut PathContext) -> S,
    ) -> S {
        let Some(origins) = &self.origins else {
            return self.part_of_cell(scene, p, rays.pass, ctx, gather);
        };
        // Renders that share a pass have few rays each: drawn cells would count often in one of them and seldom in another, and
        // the mean over the renders would be noisier.
        let u = (!rays.pass.is_shared()).then_some(u);
        self.cells.at(p, u, CELL_PASSES + rays.pass.index, ctx, |cell, own| {
            self.in_cell(scene, origins, cell, rays, own, &gather)
        })
    }

    /// The light of a cell for these `rays`. In a directed picture it is the mean over the gathers of their pass and of all
    /// passes before.
    fn in_cell(
        &self,
        scene: &Scene,
        origins: &CellOrigins<S>,
        cell: &EmptyCell,
        rays: ReadingRays<'_>,
        ctx: &mut PathContext,
        gather: &impl Fn(&GatherOrigins, GatherPoints, &mut PathContext) -> S,
    ) -> S {
        let ReadingRays { pass, directed } = rays;
        let earlier = pass.index.checked_sub(1).filter(|_| directed.is_some());
        let earlier = earlier.map(|index| {
            let rays = ReadingRays { pass: SamplePass { index, ..pass }, ..rays };
            self.cells.in_earlier_pass(cell, CELL_PASSES + index, ctx, |cell, ctx| {
                self.in_cell(scene, origins, cell, rays, ctx, gather)
            })
        });
        let radius = 0.5 * self.cells.width() / self.footprint.width(cell.center);
        let rays_around = |index: u32| {
            let of_pixels = |of: &DirectedRays| of.rays(scene, cell.center, radius, index);
            directed.map_or_else(|| pass.rays.into(), of_pixels)
        };
        let own_rays = rays_around(pass.index);
        if let Some(light) = earlier
            && self.wanted(cell.center, 1.0, own_rays) < ROUNDED_TO_ONE
        {
            return light;
        }
        let start = origins.of(scene, cell, &self.footprint, ctx);
        // Nothing is gathered for few rays that add to an earlier pass.
        let wanted = |rays: f64, least: f64| {
            self.wanted(cell.center, start.opacity(), rays).clamp(least, MAX_GATHERS)
        };
        let own = wanted(own_rays, if earlier.is_some() { 0.0 } else { MIN_GATHERS });
        // Renders that share the rays of a pass count the same gathers, and start them by the same points.
        let (stage, index) = (Stage::GatherPoints, pass.index.into());
        let scramble = Stream::new(self.points_seed, stage, cell.key, index).scramble();
        let indices = pass.gathers(pass.even(own));
        let count = indices.len() as f64;
        let mut light = || gather(&start, GatherPoints { indices: indices.clone(), scramble }, ctx);
        match earlier {
            None => light(),
            Some(earlier) if own < ROUNDED_TO_ONE => earlier,
            Some(earlier) => {
                let least = |index: u32| if index == 0 { MIN_GATHERS } else { 0.0 };
                let before = (0..pass.index).map(|i| wanted(rays_around(i), least(i))).sum::<f64>();
                (earlier * before + light() * count) / (before + count)
            }
        }
    }

    /// In a pilot, the part that a ray has in filling the cells round `p`: what decides their number is work of cells, not of
    /// rays.
    fn part_of_cell(
        &self,
        scene: &Scene,
        p: WorldPoint,
        pass: SamplePass,
        ctx: &mut PathContext,
        gather: impl Fn(&GatherOrigins, GatherPoints, &mut PathContext) -> S,
    ) -> S {
        let (medium, width, footprint) = (self.medium, self.cells.width(), &self.footprint);
        let here = GatherOrigins::at::<S>(scene, medium, p, width, footprint, &mut ctx.clone());
        let gathers = self.wanted(p, here.opacity(), pass.rays.into());
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
        gather(&here, points, ctx)
    }

    /// Gathers of a cell round `center` where the camera sees this `opacity` and pixels have so many `rays`: by how many of those
    /// are expected to look it up.
    fn wanted(&self, center: WorldPoint, opacity: f64, rays: f64) -> f64 {
        let pixels = (self.cells.width() / self.footprint.width(center)).powi(2);
        GATHERS_PER_RAY * rays * self.share * opacity * pixels
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

    use super::*;
    use crate::scene::plan::Needs;

    /// A ball of fog, and the centre of one of its cells.
    fn ball() -> (Scene, WorldPoint) {
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
        let cells = cells_of(&scene);
        let nearest = cells.to_cells(WorldPoint::new(0.3, 0.2, 1.7)).floor();
        let p = cells.to_world(nearest + 0.5);
        (scene, p)
    }

    fn cells_of(scene: &Scene) -> SparseCells {
        SparseCells::covering(&scene.media.get(0).density, 0.5, 1).unwrap()
    }

    /// An empty cache of the cells of `scene` in a render whose cells have this `seed`.
    fn cache(scene: &Scene, seed: u64) -> FinalGatherCache<f64> {
        let (cells, footprint) = (cells_of(scene), PixelFootprint::new(scene, 1.0));
        let origins = Some(Arc::new(CellOrigins::new(cells.clone(), 0, 7)));
        FinalGatherCache::new(0, cells, footprint, [seed, 7], origins)
    }

    /// What the gathers of one cell start by: two places, and their Sobol points.
    type Start = ([WorldPoint; 2], GatherPoints);

    /// That of the gathers which a render whose cells have this `seed` makes at `p` for its rays of `pass`.
    fn start(scene: &Scene, p: WorldPoint, seed: u64, pass: SamplePass) -> Start {
        start_with(1.0, scene, p, seed, pass)
    }

    /// As [`start`], with the gathers of this share of the rays.
    fn start_with(share: f64, scene: &Scene, p: WorldPoint, seed: u64, pass: SamplePass) -> Start {
        let cache = cache(scene, seed).with_share(share);
        let mut ctx = PathContext::new(Stream::new(seed, Stage::Test, 0, 0), Needs::EVERYTHING);
        let starts = RefCell::new(Vec::new());
        let rays = ReadingRays { pass, directed: None };
        cache.sample(scene, p, 0.3, rays, &mut ctx, |origins, points, _| {
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
        let (scene, p) = ball();
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

    /// In a directed picture gathers follow the rays of the pixels around, and a cell of a later pass is the mean of all of
    /// them: of the first pass alone where no pixel around has rays of the later one.
    #[test]
    fn directed_cells_are_the_mean_of_all_gathers_so_far() {
        let (scene, p) = ball();
        let light = |rays: u32| {
            let directed =
                DirectedRays::new([64, 64], |_, _| rays, &[0..4, 4..64], |rays| rays, false);
            let cache = cache(&scene, 1);
            let counts = RefCell::new(Vec::new());
            let of_pass = |index: u32, rays: u32| {
                let mut ctx =
                    PathContext::new(Stream::new(1, Stage::Test, 0, 0), Needs::EVERYTHING);
                let pass = SamplePass { index, rays, first: 0, shot: rays };
                let rays = ReadingRays { pass, directed: Some(&directed) };
                cache.sample(&scene, p, 0.3, rays, &mut ctx, |_, points, _| {
                    counts.borrow_mut().push(points.indices.len());
                    // Light of each pass is told by its number.
                    1.0 + f64::from(index)
                })
            };
            let found = [of_pass(0, 4), of_pass(1, 60)];
            (found, counts.into_inner())
        };
        let (found, first) = light(4);
        assert_eq!((found, first.len()), ([1.0, 1.0], 1), "nothing is gathered for no ray");
        let (found, counts) = light(16);
        let [few, more] = counts[..] else { panic!("{counts:?}") };
        assert_eq!(few, first[0]);
        assert!((more as f64 - 3.0 * few as f64).abs() <= 2.0, "12 rays after 4: {counts:?}");
        assert!((found[1] - 1.75).abs() < 0.01, "three of four gathers: {found:?}");
    }
}
