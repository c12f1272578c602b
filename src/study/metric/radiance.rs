//! Absolute errors of linear radiance, over all pixels and the three channels alike.

use crate::image::Image;

/// Mean squared error, in radiance squared.
pub fn mse(reference: &Image, test: &Image) -> f64 {
    mean(reference, test, |r, t| (t - r).powi(2))
}

/// Mean absolute error, in radiance.
pub fn mae(reference: &Image, test: &Image) -> f64 {
    mean(reference, test, |r, t| (t - r).abs())
}

/// Signed bias: mean of the test less mean of the reference, in radiance. Noise without bias tends
/// to 0 as pixels grow many, which no squared error does.
pub fn mean_difference(reference: &Image, test: &Image) -> f64 {
    mean(reference, test, |r, t| t - r)
}

/// Signed bias as a ratio: mean of the test over mean of the reference. `None` where the mean of
/// the reference is not above 0.
pub fn mean_ratio(reference: &Image, test: &Image) -> Option<f64> {
    let [below, above] = [reference, test].map(mean_radiance);
    (below > 0.0).then(|| above / below)
}

/// Mean radiance over pixels and channels.
pub(super) fn mean_radiance(image: &Image) -> f64 {
    mean(image, image, |r, _| r)
}

fn mean(reference: &Image, test: &Image, of: impl Fn(f64, f64) -> f64) -> f64 {
    let pairs = reference.pixels().as_flattened().iter().zip(test.pixels().as_flattened());
    let sum: f64 = pairs.map(|(&r, &t)| of(f64::from(r), f64::from(t))).sum();
    sum / (3 * reference.pixels().len()) as f64
}
