//! Rays that a director gives the pixels around a place of the scene.

use std::ops::Range;

use glam::DVec2;

use crate::math::WorldPoint;
use crate::scene::Scene;

/// Pixels along each side of a block, of which the mean is kept.
///
/// Unit: pixels. Derivation: cells that rays share are about as wide in the picture.
const BLOCK: usize = 4;

/// The rays of each pass that pixels of a directed picture shoot, in blocks of pixels.
#[derive(Debug)]
pub struct DirectedRays {
    size: [u32; 2],
    /// Blocks along each side of the film.
    blocks: [usize; 2],
    passes: Vec<PassShares>,
    /// Whether mirrors may show any place to rays of any pixel.
    has_mirrors: bool,
}

/// The rays of one pass.
#[derive(Debug)]
struct PassShares {
    /// Most rays of a pixel.
    rays: f64,
    /// One number more than blocks along each side, row by row: the sum over all blocks above and left of a corner of
    /// the share of the rays that is shot (Crow 1984, "Summed-Area Tables for Texture Mapping").
    sums: Vec<f64>,
}

impl DirectedRays {
    /// Those of a film of `size` whose pixel (x, y) gets `rays`; each of the `passes` has a range of their numbers. Of the
    /// rays of a pass, `of_cache` read the same cache. Where mirrors may show any place, none has fewer rays than the mean.
    pub fn new(
        size: [u32; 2],
        rays: impl Fn(u32, u32) -> u32,
        passes: &[Range<u32>],
        of_cache: impl Fn(u32) -> u32,
        has_mirrors: bool,
    ) -> Self {
        let blocks = size.map(|side| (side as usize).div_ceil(BLOCK));
        let of_pass = |pass: &Range<u32>| {
            let all = pass.end - pass.start;
            let share = |x: u32, y: u32| {
                f64::from(rays(x, y).clamp(pass.start, pass.end) - pass.start) / f64::from(all)
            };
            let sums = summed(blocks, |block| {
                let [columns, rows] = [0, 1].map(|axis| {
                    let start = (block[axis] * BLOCK) as u32;
                    start..(start + BLOCK as u32).min(size[axis])
                });
                let pixels =
                    f64::from(columns.end - columns.start) * f64::from(rows.end - rows.start);
                let all = rows.flat_map(|y| columns.clone().map(move |x| (x, y)));
                all.map(|(x, y)| share(x, y)).sum::<f64>() / pixels
            });
            PassShares { rays: of_cache(all).into(), sums }
        };
        Self { size, blocks, passes: passes.iter().map(of_pass).collect(), has_mirrors }
    }

    /// The mean number of rays of the pass of this index that pixels within `radius`, in pixels, of the place of `p` in the
    /// picture of `scene` shoot; of all pixels where `p` has no place in it.
    pub(super) fn rays(&self, scene: &Scene, p: WorldPoint, radius: f64, pass: u32) -> f64 {
        let Some(PassShares { rays, sums }) = self.passes.get(pass as usize) else { return 0.0 };
        let mean = self.mean(sums, &self.blocks.map(|blocks| 0..blocks));
        let matrices = scene.camera.matrices(self.size);
        let share = match matrices.and_then(|matrices| matrices.place(p.xyz, self.size)) {
            Some(place) => self.mean(sums, &self.near(place, radius)),
            None => mean,
        };
        rays * if self.has_mirrors { share.max(mean) } else { share }
    }

    /// Columns and rows of the blocks within `radius` of a place of the film, both in pixels. What lies beyond an edge of the
    /// film is read by the rays next to it.
    fn near(&self, place: DVec2, radius: f64) -> [Range<usize>; 2] {
        [0, 1].map(|axis| {
            let last = self.blocks[axis] - 1;
            let block = |at: f64| ((at / BLOCK as f64).max(0.0) as usize).min(last);
            block(place[axis] - radius)..block(place[axis] + radius) + 1
        })
    }

    /// The mean over blocks in these columns and rows.
    fn mean(&self, sums: &[f64], [columns, rows]: &[Range<usize>; 2]) -> f64 {
        let at = |column: usize, row: usize| sums[row * (self.blocks[0] + 1) + column];
        let above = |row: usize| at(columns.end, row) - at(columns.start, row);
        (above(rows.end) - above(rows.start)) / (columns.len() * rows.len()) as f64
    }
}

/// The sums of `value`, by column and row, over what is above and left of each corner.
fn summed([columns, rows]: [usize; 2], value: impl Fn([usize; 2]) -> f64) -> Vec<f64> {
    let width = columns + 1;
    let mut sums = vec![0.0; width * (rows + 1)];
    for row in 0..rows {
        let mut of_row = 0.0;
        for column in 0..columns {
            of_row += value([column, row]);
            sums[(row + 1) * width + column + 1] = sums[row * width + column + 1] + of_row;
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A film of 64 x 48 pixels of a camera that looks along -z, the right quarter of which gets 16 rays and the rest 4.
    fn directed(has_mirrors: bool) -> (Scene, DirectedRays) {
        let scene = Scene::of_text(
            "
            [camera]
            position = [0.0, 0.0, 5.0]
            target = [0.0, 0.0, 0.0]
            [film]
            size = [64, 48]
            ",
        );
        let rays = |x: u32, _| if x >= 48 { 16 } else { 4 };
        let halves = |rays: u32| rays.div_ceil(2);
        let directed =
            DirectedRays::new(scene.film.size, rays, &[0..4, 4..16], halves, has_mirrors);
        (scene, directed)
    }

    /// What the pixel (x, y) shows.
    fn seen(scene: &Scene, x: f64, y: f64) -> WorldPoint {
        scene.camera.ray(x, y, [0.5; 2]).at(7.0)
    }

    #[test]
    fn rays_are_those_of_the_pixels_around() {
        let (scene, directed) = directed(false);
        let rays = |x: f64, radius: f64, pass: u32| {
            directed.rays(&scene, seen(&scene, x, 20.0), radius, pass)
        };
        assert_eq!((rays(20.0, 2.0, 0), rays(60.0, 2.0, 0)), (2.0, 2.0), "all have the first pass");
        assert_eq!((rays(20.0, 2.0, 1), rays(60.0, 2.0, 1)), (0.0, 6.0));
        // Blocks from 40 to 56, half of which get rays.
        assert_eq!(rays(47.9, 6.0, 1), 3.0);
        assert_eq!((rays(-20.0, 1.0, 1), rays(90.0, 1.0, 1)), (0.0, 6.0), "beyond the edges");
        assert_eq!(rays(32.0, 500.0, 1), 1.5, "all of the film");
        assert_eq!(rays(60.0, 2.0, 2), 0.0, "there is no such pass");
    }

    #[test]
    fn what_no_pixel_shows_directly_has_the_mean() {
        let (scene, without) = directed(false);
        let behind = WorldPoint::new(0.0, 0.0, 9.0);
        assert_eq!(without.rays(&scene, behind, 2.0, 1), 1.5);
        // A mirror may show any place.
        let (_, with) = directed(true);
        let rays = |x: f64| with.rays(&scene, seen(&scene, x, 20.0), 2.0, 1);
        assert_eq!((rays(20.0), rays(60.0)), (1.5, 6.0));
    }

    /// The last blocks of a film whose sides are no multiples of theirs have fewer pixels.
    #[test]
    fn films_of_any_size_have_blocks() {
        let (scene, _) = directed(false);
        for size in [[1, 1], [3, 9], [64, 48], [65, 47]] {
            let directed = DirectedRays::new(
                size,
                |x, _| 1 + x % 2,
                &[Range { start: 0, end: 2 }],
                |rays| rays,
                false,
            );
            let behind = WorldPoint::new(0.0, 0.0, 9.0);
            let mean = directed.rays(&scene, behind, 1.0, 0);
            assert!((1.0..=1.5).contains(&mean), "{mean} of {size:?}");
        }
    }
}
