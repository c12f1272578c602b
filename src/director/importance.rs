//! Importance of pixels: the two X-maps, the false medium, and XS.

use rayon::prelude::*;

use super::snapshot::{Snapshot, middle};
use crate::image::{Film, Image, averages, srgb_encode};
use crate::math::{Ray, Rgb, Span, World, luminance, nth_smallest};
use crate::scene::plan::Needs;
use crate::scene::{Operator, Scene};
use crate::work::Work;

/// Quantile of the luminances above 0 that counts as the white of a picture without an exposure.
///
/// Unit: none. Bench: `cargo bench --bench results -- --only director`.
const WHITE: f64 = 0.99;

/// Quantile of the deviations above 0 that gets the importance 1, so that few outliers do not make the
/// rest unimportant.
///
/// Unit: none. Bench: `cargo bench --bench results -- --only director`.
const FULL: f64 = 0.95;

/// Least importance of a pixel that receives light: the few rays of a pilot may have missed its noise.
///
/// Unit: none. Bench: `cargo bench --bench results -- --only director`.
const MIN_LIT: f32 = 0.02;

/// The X-map of transmittance: from the eye to the first surface, by luminance, for each pixel; exact
/// (see [`Media::transmittance`](crate::medium::Media::transmittance)), with the distances of
/// `snapshot` in place of intersections. 0 where no light can come along the ray: nothing is hit and
/// no environment shines (Anson et al. 2006, section 3.1).
/// Without media in `needs` it is 1, without an environment 0 where nothing is hit.
pub fn x_map(scene: &Scene, snapshot: &Snapshot, needs: Needs) -> (Vec<f32>, Work) {
    let width = snapshot.snapshot.width();
    let size = [width, snapshot.snapshot.height()].map(|side| side as u32);
    let is_dark =
        |ray: &Ray<World>| scene.lights.seen_environment_radiance(ray.direction) == Rgb::ZERO;
    let pixel = |index: usize, depth: f64, work: &mut Work| {
        if depth.is_infinite() && !needs.environment {
            return 0.0;
        }
        let ray = middle(scene, size, index);
        if depth.is_infinite() && is_dark(&ray) {
            return 0.0;
        }
        if !needs.media {
            return 1.0;
        }
        let (near, end) = (scene.camera.near(&ray), scene.camera.end(&ray));
        let span = Span::new(0.0, (depth - near).min(end));
        luminance(scene.media.transmittance_counted(&ray, span, work)) as f32
    };
    let row = |(y, row): (usize, &[f64])| {
        let mut work = Work::default();
        let indices = y * width..;
        let x = indices.zip(row).map(|(index, depth)| pixel(index, *depth, &mut work)).collect();
        (x, work)
    };
    let rows = snapshot.depth.par_chunks(width).enumerate().map(row);
    let rows: Vec<(Vec<f32>, Work)> = rows.collect();
    let work = rows.iter().map(|(_, work)| *work).sum();
    (rows.into_iter().flat_map(|(x, _)| x).collect(), work)
}

/// The false medium: the snapshot seen through `x` with the inverted `x` over it, 1 being the
/// snapshot's white (Anson et al. 2006, section 3.2).
pub fn false_medium(snapshot: &Image, x: &[f32]) -> Image {
    let white = self::white(snapshot.luminances()).map_or(1.0, |w| w as f32);
    let over = |(pixel, x): (&[f32; 3], &f32)| pixel.map(|v| v / white * x + (1.0 - x));
    let pixels = snapshot.pixels().iter().zip(x).map(over).collect();
    Image::new(snapshot.width(), snapshot.height(), pixels)
}

/// The X-map of scattered light, 0 to 1, in the pixels of `pilot`: the standard deviation of a ray's
/// luminance in display values, averaged over the neighbours of a pixel. Edges within a pixel raise it as
/// the noise of shadows and scattering does; it is 0 where no light is.
///
/// Rays in proportion to it minimise the sum of squared errors for their number (Neyman 1934,
/// "On the Two Different Aspects of the Representative Method", optimum allocation).
pub fn scattering_x_map(pilot: &Film) -> Vec<f32> {
    let lights: Vec<f64> = pilot.image().luminances().collect();
    let layer = |name: &str| pilot.layer(name).unwrap_or_default().iter().map(|v| f64::from(*v));
    let Some(white) = self::white(lights.iter().copied()) else {
        return vec![0.0; lights.len()];
    };
    // The layer holds the variance of the mean of a pixel's rays.
    let deviations: Vec<f64> = layer("variance")
        .zip(layer("rays"))
        .zip(&lights)
        .map(|((variance, rays), light)| {
            let deviation = (variance * rays).sqrt();
            let shown = |light: f64| srgb_encode((light / white).clamp(0.0, 1.0));
            0.5 * (shown(light + deviation) - shown(light - deviation))
        })
        .collect();
    let map = averages([pilot.width(), pilot.height()], &deviations, 1);
    let full = quantile(map.iter().copied(), FULL);
    let importance = |(deviation, light): (&f64, &f64)| {
        let least = if *light > 0.0 { MIN_LIT } else { 0.0 };
        full.map_or(least, |full| ((deviation / full) as f32).clamp(least, 1.0))
    };
    map.iter().zip(&lights).map(importance).collect()
}

/// The XS-map, 0 to 1: w_x X + w_s S, or X^w_x S^w_s (Anson et al. 2006, section 3.3, whose own
/// weights are (0.5, 0.5) with the sum), or X^w_x / (1 + w_s (1 - S)), by which 1 + w_s times the error
/// passes where S is 0. The two maps have one value a pixel each, 0 to 1; a map whose weight is 0 is not
/// read and may be empty.
pub fn xs_map(x: &[f32], s: &[f32], weights: [f64; 2], operator: Operator) -> Vec<f32> {
    let value = |map: &[f32], weight: f64, index: usize| {
        if weight == 0.0 { None } else { map.get(index).map(|v| f64::from(v.clamp(0.0, 1.0))) }
    };
    let one = |index| {
        let parts = [(x, weights[0]), (s, weights[1])];
        let parts = parts.into_iter().filter_map(|(map, w)| Some((value(map, w, index)?, w)));
        let xs: f64 = match operator {
            Operator::Sum => parts.map(|(v, w)| v * w).sum(),
            Operator::Product => parts.map(|(v, w)| v.powf(w)).product(),
            Operator::Tolerance => {
                let x = value(x, weights[0], index).map_or(1.0, |x| x.powf(weights[0]));
                let s = value(s, weights[1], index).unwrap_or(1.0);
                x / (1.0 + weights[1] * (1.0 - s))
            }
        };
        xs.clamp(0.0, 1.0) as f32
    };
    (0..x.len().max(s.len())).map(one).collect()
}

/// The luminance of a picture that counts as its white, of these `luminances`; `None` where all is black.
pub(super) fn white(luminances: impl Iterator<Item = f64>) -> Option<f64> {
    quantile(luminances, WHITE)
}

/// The `share` quantile, 0 to 1, of the n `values` above 0: that of the rank floor((n - 1) `share`),
/// counted from 0. `None` where there are none.
fn quantile(values: impl Iterator<Item = f64>, share: f64) -> Option<f64> {
    let values: Vec<f64> = values.filter(|v| *v > 0.0).collect();
    let rank = (values.len().checked_sub(1)? as f64 * share) as usize;
    nth_smallest(values, rank)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn combines_as_the_paper_does() {
        let (x, s) = ([1.0, 0.5, 0.0], [0.0, 0.5, 1.0]);
        assert_eq!(xs_map(&x, &s, [0.5, 0.5], Operator::Sum), [0.5, 0.5, 0.5]);
        assert_eq!(xs_map(&x, &s, [1.0, 1.0], Operator::Product), [0.0, 0.25, 0.0]);
        assert_eq!(xs_map(&x, &[], [1.0, 0.0], Operator::Sum), x);
        assert_eq!(xs_map(&[], &s, [0.0, 1.0], Operator::Product), s);
        assert_eq!(xs_map(&x, &s, [3.0, 0.0], Operator::Sum), [1.0, 1.0, 0.0]);
    }

    #[test]
    fn quantiles_ignore_what_is_black() {
        let values = || [0.0, 4.0, 1.0, 0.0, 3.0, 2.0, 5.0].into_iter();
        assert_eq!(
            [0.0, 0.5, 1.0].map(|share| quantile(values(), share)),
            [1.0, 3.0, 5.0].map(Some)
        );
        assert_eq!(quantile([0.0].into_iter(), 0.5), None);
    }
}
