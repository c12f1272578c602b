//! Visual saliency: what draws the eye before anything is understood.
//!
//! After Itti, Koch and Niebur 1998, "A Model of Saliency-Based Visual Attention for Rapid Scene
//! Analysis", IEEE PAMI 20(11). The steps are those of its figure 1:
//!
//! 1. linear filtering: intensity, the two colour opponencies, four orientations (`opponent`,
//!    `gabor`), each as a dyadic Gaussian pyramid of nine levels (`surround`);
//! 2. centre-surround differences at six pairs of scales, and N of each: the feature maps
//!    (`surround`, `normalize`);
//! 3. their sum across scales, and N of it: one conspicuity map each for intensity, colour and
//!    orientation (equations 5 to 7);
//! 4. the mean of the three: the saliency map (equation 8).
//!
//! N promotes maps with few strong peaks over maps with many. Through the N of the conspicuity maps
//! a target that stands out in one feature alone is salient alone, and features in which all things
//! are alike vanish. Programs that leave this N out (pySaliencyMap and those made from it) keep all
//! things in the map; the maps agree where it is left out of these as well, as
//! `tests/check/saliency.py` shows.

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
use surround::{Features, Scales, range};

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
    pub fn from_image(image: &Image) -> Self {
        let (width, height) = (image.width(), image.height());
        let scales = Scales::new(width, height);
        let channels = Channels::new(width, height, &display::encode(image));
        let ((intensity, orientation), color) = join(
            || {
                let pyramid = scales.pyramid(channels.intensity);
                join(|| by_intensity(&scales, &pyramid), || by_orientation(&scales, &pyramid))
            },
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

/// N of the conspicuity by intensity (Itti et al. 1998, equation 5).
fn by_intensity(scales: &Scales, pyramid: &[Plane]) -> Plane {
    let features = scales.features(pyramid);
    let range = features.range();
    conspicuity(vec![features.combined(range)])
}

/// N of the conspicuity by colour, the sum of both opponencies (Itti et al. 1998, equation 6).
///
/// Each opponency has a range of its own: a faint blue thing among red and green ones is not lost
/// to their contrast. It is added with the weight of its range, so that a tint that is hardly seen
/// does not weigh as much as a saturated hue.
fn by_color(scales: &Scales, red_green: Plane, blue_yellow: Plane) -> Plane {
    let features = |channel| scales.features(&scales.pyramid(channel));
    let (red_green, blue_yellow) = join(|| features(red_green), || features(blue_yellow));
    let opponencies = [red_green, blue_yellow];
    let widest = opponencies.iter().map(Features::range).fold(f32::MIN_POSITIVE, f32::max);
    let combined = opponencies.iter().map(|features| {
        let range = features.range();
        features.combined(range).map(|v| range / widest * v)
    });
    conspicuity(combined.collect())
}

/// N of the conspicuity by orientation: the sums of each angle across scales go through N again
/// before they are added (Itti et al. 1998, equation 7). The four angles share one range, as their
/// filters have one gain.
fn by_orientation(scales: &Scales, intensity: &[Plane]) -> Plane {
    let energies: Vec<[Plane; 4]> = intensity.par_iter().map(gabor::energies).collect();
    let angle = |a: usize| energies.iter().map(|level| level[a].clone()).collect::<Vec<_>>();
    let features: Vec<Features> =
        (0..4).into_par_iter().map(|a| scales.features(&angle(a))).collect();
    let widest = features.iter().map(Features::range).fold(0.0, f32::max);
    let sums: Vec<Plane> = features.iter().map(|features| features.combined(widest)).collect();
    let widest = range(&sums);
    conspicuity(sums.into_iter().map(|sum| normalized(sum, widest)).collect())
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
