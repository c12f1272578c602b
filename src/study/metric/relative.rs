//! Relative squared error of linear radiance.
//!
//! Per pixel the squared difference, averaged over the channels, over r² + epsilon², where r is the
//! reference's mean over the channels (Rousselle et al. 2011, "Adaptive Sampling and Reconstruction
//! using Greedy Error Minimization", with 0.01 for epsilon²). On grey pictures this is
//! mean((t - r)² / (r² + epsilon²)).

use super::Map;
use super::radiance::mean_radiance;
use crate::image::Image;

/// Share of the pixels, the worst ones, that the trimmed figure leaves out: one firefly can
/// otherwise outweigh the whole picture.
pub const TRIM: f64 = 0.001;

/// The epsilon taken where none is set: half the mean of the reference, so that neither black
/// background nor the unit of radiance decides. `None` where that mean is not above 0.
pub fn default_epsilon(reference: &Image) -> Option<f64> {
    Some(0.5 * mean_radiance(reference)).filter(|epsilon| *epsilon > 0.0)
}

/// The relative squared error of every pixel; `epsilon` is a radiance above 0.
pub fn relative_map(reference: &Image, test: &Image, epsilon: f64) -> Map {
    let pairs = reference.pixels().iter().zip(test.pixels());
    let values = pairs
        .map(|(r, t)| {
            let [r, t] = [r, t].map(|p| p.map(f64::from));
            let squares: f64 = r.iter().zip(t).map(|(r, t)| (t - r).powi(2)).sum();
            let grey = r.iter().sum::<f64>() / 3.0;
            (squares / 3.0 / (grey * grey + epsilon * epsilon)) as f32
        })
        .collect();
    Map { width: reference.width(), height: reference.height(), values }
}
