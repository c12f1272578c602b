//! Optical thickness between a medium's cells and the camera.

use crate::math::{Ray, Span, Spectrum, WorldPoint};
use crate::medium::SparseCells;
use crate::scene::Scene;
use crate::transport::{PathContext, PixelFootprint};

use super::lazy_cells::LazyCells;

/// Difference in optical thickness of eight cells, at most, between which it is interpolated.
///
/// Unit: none. Limit: on how far interpolation is off: at a hard face, where thickness has a kink, by a quarter of it.
const MAX_DIFFERENCE: f64 = 1.5;

/// Optical thickness from places in a medium to the camera, found at the centres of cells by one march each. It depends on
/// neither photons nor random numbers: all passes of a picture share it, and both halves of its photons.
#[derive(Debug)]
pub struct CameraThickness<S> {
    cells: LazyCells<S>,
}

impl<S: Spectrum> CameraThickness<S> {
    /// No thickness found yet in `cells` of the medium of this index.
    pub fn new(cells: SparseCells, medium: usize) -> Self {
        Self { cells: LazyCells::new(cells, 0, medium) }
    }

    /// Its cells.
    pub const fn cells(&self) -> &LazyCells<S> {
        &self.cells
    }

    /// Fills the eight cells nearest to `p`, if there are so many.
    pub fn fill(
        &self,
        scene: &Scene,
        p: WorldPoint,
        footprint: &PixelFootprint,
        ctx: &mut PathContext,
    ) {
        self.interpolated(scene, p, footprint, |_, _| true, ctx);
    }

    /// Transmittance of media from `p` to the camera: by the thickness interpolated between the eight nearest cells, or
    /// by a march of its own where those differ much or are not all there.
    pub fn transmittance(
        &self,
        scene: &Scene,
        p: WorldPoint,
        footprint: &PixelFootprint,
        ctx: &mut PathContext,
    ) -> S {
        let is_smooth = |least: f64, most: f64| most - least <= MAX_DIFFERENCE;
        let found = self.interpolated(scene, p, footprint, is_smooth, ctx);
        (-found.unwrap_or_else(|| march(scene, p, footprint, ctx))).exp()
    }

    /// Optical thickness from `p` to the camera, where the least and the most of the eight nearest cells are alike.
    fn interpolated(
        &self,
        scene: &Scene,
        p: WorldPoint,
        footprint: &PixelFootprint,
        are_alike: impl Fn(f64, f64) -> bool,
        ctx: &mut PathContext,
    ) -> Option<S> {
        self.cells.interpolate(p, 0, are_alike, ctx, |cell, own| {
            march(scene, cell.center, footprint, own)
        })
    }
}

/// Optical thickness of media from `p` to the camera, by a march that is counted.
pub fn march<S: Spectrum>(
    scene: &Scene,
    p: WorldPoint,
    footprint: &PixelFootprint,
    ctx: &mut PathContext,
) -> S {
    let (ray, distance) = (Ray::new(p, scene.camera.toward(p)), footprint.distance(p));
    let thickness: S = scene.media.thickness_counted(&ray, Span::new(0.0, distance), &mut ctx.work);
    // Cells hold finite numbers of f32.
    thickness.map(|channel| channel.min(f64::from(f32::MAX)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Stage, Stream};
    use crate::scene::plan::Needs;

    /// Transmittance of a box whose upper side is at y = 9, seen from above, at this height in cells of width 1; with the
    /// marches of the place itself and of cells.
    fn through_box(sigma_t: f64, y: f64) -> (f64, [u64; 2]) {
        let scene = Scene::of_text(&format!(
            "
            [camera]
            type = 'orthographic'
            position = [0.0, 50.0, 0.0]
            target = [0.0, 0.0, 0.0]
            up = [0.0, 0.0, 1.0]
            height = 4.0
            [film]
            size = [4, 4]
            [[medium]]
            region = {{ box = {{ min = [-9.0, -9.0, -9.0], max = [9.0, 9.0, 9.0] }} }}
            sigma_t = {sigma_t}
            "
        ));
        let cells = SparseCells::covering(&scene.media.get(0).density, 1.0, 1).unwrap();
        let thickness = CameraThickness::<f64>::new(cells, 0);
        let footprint = PixelFootprint::new(&scene, 1.0);
        let mut ctx = PathContext::new(Stream::new(1, Stage::Test, 0, 0), Needs::EVERYTHING);
        let p = WorldPoint::new(0.2, y, 0.3);
        let seen = [(); 2].map(|()| thickness.transmittance(&scene, p, &footprint, &mut ctx));
        assert_eq!(seen[0], seen[1], "what is found stays");
        (seen[0], [ctx.work.marches, ctx.amortized.work.marches])
    }

    #[test]
    fn thickness_is_interpolated_where_it_is_smooth() {
        for y in [8.5, 5.1, -3.9] {
            let (seen, marches) = through_box(0.3, y);
            let right = (-0.3 * (9.0 - y)).exp();
            assert!((seen / right - 1.0).abs() < 1e-4, "{seen} for {right} at {y}");
            assert_eq!(marches, [0, 8]);
        }
        assert_eq!(through_box(0.3, 9.9).0, 1.0);
    }

    #[test]
    fn a_place_has_a_march_of_its_own_where_cells_differ_or_are_missing() {
        let (seen, [own, _]) = through_box(2.0, 5.1);
        assert!((seen / (-2.0_f64 * 3.9).exp() - 1.0).abs() < 1e-9 && own == 2, "{seen}");
        let (seen, [own, _]) = through_box(0.3, 40.0);
        assert_eq!((seen, own), (1.0, 2));
    }
}
