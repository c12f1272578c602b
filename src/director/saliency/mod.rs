//! Visual saliency: what draws the eye before anything is understood.
//!
//! After Itti, Koch and Niebur 1998, "A Model of Saliency-Based Visual Attention for Rapid Scene
//! Analysis", IEEE PAMI 20(11). A picture is split into intensity, colour opponency and local
//! orientation; each is compared with its surround at several scales; maps with few strong peaks
//! are promoted over maps with many, and all are added.

mod display;
mod gabor;
mod normalize;
mod opponent;
mod plane;
mod surround;

use rayon::join;
use rayon::prelude::*;

use crate::image::Image;
use normalize::normalized;
use opponent::Channels;
use plane::Plane;
use surround::Scales;

/// Saliency of a picture and the conspicuities that it is made of: maps of the picture's size, row
/// by row from the top. All values are 0 where a picture has nothing that differs from its
/// surround.
#[derive(Debug, Clone, PartialEq)]
pub struct Saliency {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// N(I): conspicuity by intensity, 0 to 1.
    pub intensity: Vec<f32>,
    /// N(C): conspicuity by red against green and blue against yellow, 0 to 1.
    pub color: Vec<f32>,
    /// N(O): conspicuity by orientation, 0 to 1.
    pub orientation: Vec<f32>,
    /// S: the mean of the three over its greatest value, 0 to 1.
    pub map: Vec<f32>,
}

impl Saliency {
    /// The saliency of `image`, linear Rec.709 of any dynamic range and size. The exposure is found
    /// from the picture: a multiple of it has the same saliency. Negative values and those that are
    /// not finite count as 0. The number of threads makes no difference.
    pub fn of(image: &Image) -> Self {
        let (width, height) = (image.width(), image.height());
        let scales = Scales::of(width, height);
        let channels = Channels::new(width, height, &display::encode(image));
        let ((intensity, orientation), color) = join(
            || by_intensity_and_orientation(&scales, channels.intensity),
            || by_color(&scales, channels.red_green, channels.blue_yellow),
        );

        let mut sum = intensity.clone();
        sum.add(&color);
        sum.add(&orientation);
        let full = |map: &Plane| map.enlarged(width, height).values;
        let ((intensity, color), (orientation, map)) = join(
            || (full(&intensity), full(&color)),
            || (full(&orientation), scaled_to_one(full(&sum))),
        );
        Self { width, height, intensity, color, orientation, map }
    }
}

/// N of the conspicuities by intensity and by orientation (Itti et al. 1998, equations 5 and 7).
fn by_intensity_and_orientation(scales: &Scales, intensity: Plane) -> (Plane, Plane) {
    let pyramid = scales.pyramid(intensity);
    let energies: Vec<[Plane; 4]> = pyramid.par_iter().map(gabor::energies).collect();
    let angles = (0..4).map(|a| energies.iter().map(|level| level[a].clone()).collect());
    let angles: Vec<Vec<Plane>> = angles.collect();
    join(
        || conspicuity(scales.contrasts(&[pyramid])),
        || {
            let maps = scales.contrasts(&angles);
            let range = maps.iter().map(Plane::greatest_modulus).fold(0.0, f32::max);
            conspicuity(maps.into_iter().map(|map| normalized(map, range)).collect())
        },
    )
}

/// N of the conspicuity by colour (Itti et al. 1998, equation 6).
fn by_color(scales: &Scales, red_green: Plane, blue_yellow: Plane) -> Plane {
    let (red_green, blue_yellow) =
        join(|| scales.pyramid(red_green), || scales.pyramid(blue_yellow));
    conspicuity(scales.contrasts(&[red_green, blue_yellow]))
}

/// N of the sum of maps, its range scaled to 1.
fn conspicuity(maps: Vec<Plane>) -> Plane {
    let sum = maps.into_iter().reduce(|mut sum, map| {
        sum.add(&map);
        sum
    });
    let sum = sum.expect("a feature has a channel");
    let range = sum.greatest_modulus();
    normalized(sum, range)
}

/// A map of values that are at least 0 over its greatest; all 0 stays so.
fn scaled_to_one(mut map: Vec<f32>) -> Vec<f32> {
    let greatest = map.iter().copied().fold(0.0, f32::max);
    if greatest > 0.0 {
        map.iter_mut().for_each(|v| *v /= greatest);
    }
    map
}
