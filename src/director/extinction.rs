//! The X-map, and the picture that it makes of the snapshot.

use rayon::prelude::*;

use super::quantile::quantile;
use super::snapshot::{Snapshot, middle};
use crate::image::Image;
use crate::math::{Ray, Rgb, Span, World, luminance};
use crate::scene::Scene;
use crate::scene::plan::Needs;
use crate::work::Work;

/// Share of the snapshot's pixels that are darker than what counts as white in it.
const WHITE: f64 = 0.99;

/// The X-map: transmittance from the eye to the first surface, by luminance, for each pixel; exact
/// (see [`Media::transmittance`](crate::medium::Media::transmittance)), with the distances of
/// `sight` in place of intersections. 0 where no light can come along the ray: nothing is hit and
/// no environment shines (Anson et al. 2006, section 3.1).
/// Without media in `needs` it is 1, without an environment 0 where nothing is hit.
pub fn x_map(scene: &Scene, sight: &Snapshot, needs: Needs) -> (Vec<f32>, Work) {
    let width = sight.snapshot.width();
    let size = [width, sight.snapshot.height()].map(|side| side as u32);
    let dark = |ray: &Ray<World>| scene.lights.environment_radiance(ray.direction) == Rgb::ZERO;
    let pixel = |index: usize, depth: f64, work: &mut Work| {
        if depth.is_infinite() && !needs.environment {
            return 0.0;
        }
        let ray = middle(scene, size, index);
        if depth.is_infinite() && dark(&ray) {
            return 0.0;
        }
        if !needs.media {
            return 1.0;
        }
        let span = Span::new(0.0, depth);
        luminance(scene.media.transmittance_counted(&ray, span, work)) as f32
    };
    let row = |(y, row): (usize, &[f64])| {
        let mut work = Work::default();
        let indices = y * width..;
        let x = indices.zip(row).map(|(index, depth)| pixel(index, *depth, &mut work)).collect();
        (x, work)
    };
    let rows: Vec<(Vec<f32>, Work)> = sight.depth.par_chunks(width).enumerate().map(row).collect();
    let work = rows.iter().map(|(_, work)| *work).sum();
    (rows.into_iter().flat_map(|(x, _)| x).collect(), work)
}

/// The false medium: the snapshot seen through `x` with the inverted `x` over it, 1 being the
/// snapshot's white (Anson et al. 2006, section 3.2).
pub fn false_medium(snapshot: &Image, x: &[f32]) -> Image {
    let white = white(snapshot);
    let over = |(pixel, x): (&[f32; 3], &f32)| pixel.map(|v| v / white * x + (1.0 - x));
    let pixels = snapshot.pixels().iter().zip(x).map(over).collect();
    Image::new(snapshot.width(), snapshot.height(), pixels)
}

/// The luminance that nearly all pixels stay below, or 1 where all are black.
fn white(image: &Image) -> f32 {
    let level = |pixel: &[f32; 3]| luminance(Rgb::from(pixel.map(f64::from)));
    quantile(image.pixels().iter().map(level), WHITE).map_or(1.0, |white| white as f32)
}
