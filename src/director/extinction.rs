//! The X-map, and the picture that it makes of the snapshot.

use rayon::prelude::*;

use super::quantile::quantile;
use super::sight::{Sight, middle};
use crate::image::Image;
use crate::math::{Rgb, Span, luminance};
use crate::scene::Scene;
use crate::work::Work;

/// Share of the snapshot's pixels that are darker than what counts as white in it.
const WHITE: f64 = 0.99;

/// The X-map: transmittance from the eye to the first surface, by luminance, for each pixel; exact
/// (see [`Media::transmittance`](crate::medium::Media::transmittance)), with the distances of
/// `sight` in place of intersections. 0 where no light can come along the ray: nothing is hit and
/// no environment shines (Anson et al. 2006, section 3.1).
pub fn x_map(scene: &Scene, sight: &Sight) -> (Vec<f32>, Work) {
    let pixel = |(index, depth): (usize, &f64)| {
        let ray = middle(scene, index);
        let dark = || scene.lights.environment_radiance(ray.direction) == Rgb::ZERO;
        if depth.is_infinite() && dark() {
            return 0.0;
        }
        luminance(scene.media.transmittance(&ray, Span::new(0.0, *depth))) as f32
    };
    let x = sight.depth.par_iter().enumerate().map(pixel).collect::<Vec<f32>>();
    let marches = if scene.media.is_empty() { 0 } else { x.len() as u64 };
    (x, Work { marches, ..Work::default() })
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
