//! Where a squared error comes from.

use serde::{Deserialize, Serialize};

use super::metric::{Options, mse, relative_map};
use super::request::Metric;
use crate::image::Image;

/// A squared error split in three; their sum is the expected error of one render, less the
/// target's own. All are unbiased estimates, so that what is hardly there can come out below 0.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Split {
    /// What differs between seeds.
    pub noise: f64,
    /// What the march step does: the squared mean difference from renders of the same seeds with
    /// the finest step, at which optical depth is exact. 0 where the step is the finest, nothing
    /// where that was not rendered, which leaves it in the bias.
    pub step: Option<f64>,
    /// All else that is left in the mean over seeds, less what noise leaves there and the target's
    /// own error: what gathers blur, and what the target itself has wrong.
    pub bias: f64,
}

/// Renders of one point, and what they are measured against.
#[derive(Clone, Copy, Debug)]
pub(super) struct Measurement<'a> {
    /// The target's picture.
    pub(super) target: &'a Image,
    /// The target's own error.
    pub(super) own: f64,
    /// The mean of the renders.
    pub(super) mean: &'a Image,
    /// Of each render from a seed that was rendered with the finest step as well: how far the
    /// target would be off by what the step changes. Nothing where steps were not measured.
    pub(super) steps: Option<&'a [Image]>,
}

impl Measurement<'_> {
    /// Splits the mean of these `errors` of the renders, nothing for one alone or another metric
    /// than a squared one.
    pub(super) fn split(&self, errors: &[f64], metric: Metric, options: &Options) -> Option<Split> {
        let of = |image: &Image| squared(metric, self.target, image, options);
        let (noise, systematic) = noise_and_bias(errors, of(self.mean)?)?;
        let step = match self.steps {
            None => None,
            Some([]) => Some(0.0),
            Some(steps) => {
                let each: Vec<f64> = steps.iter().map(of).collect::<Option<_>>()?;
                let mean = super::target::mean(&steps.iter().collect::<Vec<_>>())?;
                Some(noise_and_bias(&each, of(&mean)?)?.1)
            }
        };
        Some(Split { noise, step, bias: systematic - self.own - step.unwrap_or(0.0) })
    }
}

/// `target` with what differs between `coarse` and `fine` added.
pub(super) fn displaced(target: &Image, coarse: &Image, fine: &Image) -> Image {
    let pixels = target.pixels().iter().zip(coarse.pixels()).zip(fine.pixels());
    let pixels = pixels.map(|((t, c), f)| [0, 1, 2].map(|i| t[i] + (c[i] - f[i]))).collect();
    Image::new(target.width(), target.height(), pixels)
}

/// A squared error of one picture.
fn squared(metric: Metric, reference: &Image, image: &Image, options: &Options) -> Option<f64> {
    match metric {
        Metric::Mse => Some(mse(reference, image)),
        Metric::RelativeMse => {
            options.epsilon.map(|epsilon| relative_map(reference, image, epsilon).mean())
        }
        _ => None,
    }
}

/// Noise and squared bias of pictures with these squared `errors`, whose mean has `of_mean`. With n
/// pictures the mean of `errors` is bias + noise and `of_mean` bias + noise / n.
fn noise_and_bias(errors: &[f64], of_mean: f64) -> Option<(f64, f64)> {
    let n = errors.len() as f64;
    let all = errors.iter().sum::<f64>() / n;
    let noise = (all - of_mean) * n / (n - 1.0);
    (errors.len() > 1).then_some((noise, of_mean - noise / n))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(value: f32) -> Image {
        Image::new(1, 1, vec![[value; 3]])
    }

    #[test]
    fn noise_and_bias_of_numbers_worked_by_hand() {
        // Two renders 1 and 3 of a target 0: errors 1 and 9, mean picture 2 with error 4. The
        // variance is 2, and the squared bias 4 less half of it.
        assert_eq!(noise_and_bias(&[1.0, 9.0], 4.0), Some((2.0, 3.0)));
        assert_eq!(noise_and_bias(&[1.0], 1.0), None);
    }

    #[test]
    fn a_step_error_is_told_from_pairs() {
        // Renders 1 and 3 of a target 0, with the finest step 0.5 and 2.5 from the same seeds: the
        // step adds 0.5 whatever the noise, so that of the 3 of bias 0.25 are its own.
        let (target, mean) = (grey(0.0), grey(2.0));
        let steps = [(1.0, 0.5), (3.0, 2.5)];
        let steps = steps.map(|(coarse, fine)| displaced(&target, &grey(coarse), &grey(fine)));
        let measurement =
            Measurement { target: &target, own: 0.5, mean: &mean, steps: Some(&steps) };
        let split = measurement.split(&[1.0, 9.0], Metric::Mse, &Options::default()).unwrap();
        assert_eq!(split, Split { noise: 2.0, step: Some(0.25), bias: 2.25 });
        let sum = split.noise + split.step.unwrap() + split.bias + 0.5;
        assert_eq!(sum, 5.0, "the mean of the errors");
    }
}
