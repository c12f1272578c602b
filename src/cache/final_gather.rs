//! What final gathers find, on a lattice.

use crate::math::{Ray, Rgb, Span, Spectrum, WorldPoint};
use crate::scene::Scene;
use crate::transport::PathContext;

use super::cell_size::{Pixel, Widths, thin_edge_for_moments};
use super::gather_origin::{LOOKUPS, start};
use super::lazy_cells::LazyCells;

/// Gathers for each ray whose light comes from a cell: about one for each time that it is asked for,
/// as a ray asks at several places.
const GATHERS: f64 = 8.0;

/// Gathers of a cell, at least.
const LEAST: f64 = 4.0;

/// Gathers of a cell in one round, at most: they take less than a second, and have as many different
/// first deflections.
const MOST: f64 = 65_536.0;

/// Edge of a cell in pixels, where the camera sees it, for [`USUAL`] rays of a pixel.
const PIXELS: f64 = 2.5;

/// See [`PIXELS`].
const USUAL: f64 = 16.0;

/// How that falls with the number of rays: a pixel's variance falls with that and with the square of
/// the edge, its squared bias with the fourth power of the edge; the sum is least where the edge is
/// as the -1/6th power of the number of rays.
const FALL: f64 = -1.0 / 6.0;

/// Edge of a cell in pixels, at least: that of cells for direct light.
const FINEST: f64 = 1.5;

/// Edge of a cell, at most, over that of a thin one, for [`FEW`] rays of a pixel and for fewer.
const THICK: f64 = 1.5;

/// See [`THICK`].
const FEW: u32 = 32;

/// How that falls with the number of rays, each time that they double. Over cells so wide light is rough, and its squared bias
/// falls about with the square of the edge only: the sum of that and of variance is least for the
/// -1/4th power. As the bias has the same sign all over a picture, it is to fall somewhat faster.
const ROUGH_FALL: f64 = -1.0 / 3.0;

/// Some of the rays of each pixel, which are shot together before others are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SamplePass {
    /// How many there were before.
    pub index: u32,
    /// Rays of a pixel that belong to it, at most.
    pub rays: u32,
}

/// Light that one medium scatters toward the camera, as far as final gathers find it, kept near the
/// centres of cubic cells: rays whose light comes from the same cell share its gathers, however many
/// they are and of whatever pixels (path space filtering, Keller, Dahm and Binder 2014, on a grid). It
/// is smooth over a cell, as it comes from all of the sky or has been scattered at least twice.
///
/// Cells get gathers in proportion to the light that the rays of a round are to take from them. Each
/// round finds its own, so that rays in all rounds count the same, and what cells hold gets better as
/// pixels get rays.
#[derive(Debug)]
pub struct FinalGatherCache<S = Rgb> {
    filled: LazyCells<S>,
    medium: usize,
    pixel: Pixel,
    /// Whether only the work is looked at, by few of the rays: each does its part of that for a cell.
    looks: bool,
}

impl<S: Spectrum> FinalGatherCache<S> {
    /// A lattice for the medium of this index in `scene`, of which the camera sees `visible`
    /// places, for a picture of which each pixel stands for so many of the film along each side and
    /// gets so many rays, or for a look at the work of that. Nothing where cells would be too thick or
    /// too many.
    pub fn new(
        scene: &Scene,
        medium: usize,
        visible: &[WorldPoint],
        pixels: f64,
        rays: u32,
        seed: u64,
        looks: bool,
    ) -> Option<Self> {
        let of = scene.media.get(medium);
        let pixel = Pixel::new(scene, pixels);
        let wide = (PIXELS * (f64::from(rays) / USUAL).powf(FALL)).max(FINEST);
        let widest = THICK * thin_edge_for_moments(of, visible);
        let widths = Widths { pixels: wide, widest, few: FEW, fall: ROUGH_FALL };
        let cells = pixel.cells(of, visible, rays, &widths)?;
        Some(Self { filled: LazyCells::new(cells, seed, medium), medium, pixel, looks })
    }

    /// Its cells.
    pub const fn filled(&self) -> &LazyCells<S> {
        &self.filled
    }

    /// The light scattered at `p` per unit of sigma_s, W/(m² sr), for a ray of this round: that of one
    /// of the eight cells round it, drawn by its trilinear weight. `gather` is told a place in a
    /// cell and how many gathers to take the mean of.
    pub fn near(
        &self,
        scene: &Scene,
        p: WorldPoint,
        round: SamplePass,
        ctx: &mut PathContext,
        gather: impl FnOnce(WorldPoint, u32, &mut PathContext) -> S,
    ) -> S {
        let asked = |p: WorldPoint, ctx: &mut PathContext| {
            GATHERS * f64::from(round.rays) * self.rays(scene, p, ctx)
        };
        if self.looks {
            // What decides how many is found for cells, not for each ray.
            let times = asked(p, &mut ctx.clone());
            let part = times.max(LEAST) / times.max(1.0) * self.opacity(scene, p);
            let count = (part + ctx.rng.uniform()) as u32;
            return if count > 0 { gather(p, count, ctx) } else { S::ZERO };
        }
        // The first number is that of light that all rounds share.
        self.filled.near(p, 1 + round.index, ctx, |cell, own| {
            let toward = scene.camera.toward(cell.center);
            let edge = self.filled.edge();
            let place = start(&scene.media, self.medium, cell.center, edge, toward);
            own.work.grid_lookups += LOOKUPS * scene.media.density_grids();
            let count = asked(place, own).clamp(LEAST, MOST).round();
            gather(place, count as u32, own)
        })
    }

    /// Of the ray through `p`: where it is small, many rays ask for little.
    fn opacity(&self, scene: &Scene, p: WorldPoint) -> f64 {
        let toward = scene.camera.toward(p);
        let ways = [(toward, self.pixel.distance(p)), (-toward, f64::INFINITY)];
        let thickness = ways.map(|(direction, length)| {
            scene.media.optical_thickness(&Ray::new(p, direction), Span::new(0.0, length))
        });
        1.0 - (-(thickness[0] + thickness[1])).exp().max_element()
    }

    /// How many rays, of one a pixel, take their light from a cell at `p`.
    fn rays(&self, scene: &Scene, p: WorldPoint, ctx: &mut PathContext) -> f64 {
        let edge = self.filled.edge();
        let medium = scene.media.get(self.medium);
        ctx.work.grid_lookups += u64::from(medium.density.is_voxel());
        let thickness = medium.sigma_t_at(p) * edge;
        let opacity = 1.0 - (-thickness.max_element()).exp();
        let toward = Ray::new(p, scene.camera.toward(p));
        let span = Span::new(0.0, self.pixel.distance(p));
        let seen: S = scene.media.transmittance_counted(&toward, span, &mut ctx.work);
        opacity * seen.max_element() * (edge / self.pixel.edge(p)).powi(2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::WorldPoint;

    /// A ball so thick that cells for very many rays are too many.
    const BALL: &str = r#"
        [camera]
        position = [0.0, 0.0, 5.0]
        target = [0.0, 0.0, 0.0]
        fov = 26.0
        [film]
        size = [64, 64]
        [[medium]]
        region = { sphere = { center = [0.0, 0.0, 0.0], radius = 1.0 } }
        sigma_t = 50.0
        albedo = 0.99
        phase = { type = "henyey-greenstein", g = 0.85 }
    "#;

    #[test]
    fn more_rays_never_make_cells_wider() {
        let scene = Scene::of_text(BALL);
        let visible = [WorldPoint::new(0.0, 0.0, 0.9)];
        let edge = |rays: u32| {
            let lattice = FinalGatherCache::<f64>::new(&scene, 0, &visible, 1.0, rays, 0, false);
            lattice.unwrap().filled.edge()
        };
        let edges = [16, 32, 64, 300, 2500, 20_000, 1 << 20].map(edge);
        assert!(edges.windows(2).all(|pair| pair[1] <= pair[0]), "{edges:?}");
        assert!(edges[3] < 0.6 * edges[1] && edges[4] == edges[6], "{edges:?}");
    }
}
