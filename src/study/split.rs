//! Squared errors split into noise, error of the march step, and bias.

use serde::{Deserialize, Serialize};

use super::metric::{Options, mse, relative_map};
use super::request::Metric;
use crate::image::Image;

/// The three parts of a squared error; their sum is the expected error of one render, less the
/// target's own. All are unbiased estimates, so that small parts can be negative.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ErrorSplit {
    /// Variance between seeds.
    pub noise: f64,
    /// Error of the march step: the squared mean difference from renders of the same seeds with the
    /// finest step, at which optical depth is exact. 0 where the step is the finest; `None` where the
    /// finest was not rendered, and then the bias contains it.
    pub step: Option<f64>,
    /// Squared bias of the mean over seeds without the error of the step: the blur of gathers, and the
    /// bias of the target. The noise of that mean and the target's own error are subtracted.
    pub bias: f64,
}

/// Renders of one point, with their target.
#[derive(Clone, Copy, Debug)]
pub(super) struct Measurement<'a> {
    /// The target's picture.
    pub(super) target: &'a Image,
    /// The target's own error.
    pub(super) own: f64,
    /// The mean of the renders.
    pub(super) mean: &'a Image,
    /// The target [`displaced`] by the effect of the step, for each seed that was rendered with the
    /// finest step as well; `None` where none was.
    pub(super) steps: Option<&'a [Image]>,
}

impl Measurement<'_> {
    /// Splits the mean of the `errors` of the renders; `None` for a single render or a metric that is not
    /// squared.
    pub(super) fn split(
        &self,
        errors: &[f64],
        metric: Metric,
        options: &Options,
    ) -> Option<ErrorSplit> {
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
        Some(ErrorSplit { noise, step, bias: systematic - self.own - step.unwrap_or(0.0) })
    }
}

/// `target` plus the difference of `coarse` and `fine`.
pub(super) fn displaced(target: &Image, coarse: &Image, fine: &Image) -> Image {
    let pixels = target.pixels().iter().zip(coarse.pixels()).zip(fine.pixels());
    let pixels = pixels.map(|((t, c), f)| [0, 1, 2].map(|i| t[i] + (c[i] - f[i]))).collect();
    Image::new(target.width(), target.height(), pixels)
}

/// The squared error of a picture by `metric`; `None` for other metrics.
fn squared(metric: Metric, reference: &Image, image: &Image, options: &Options) -> Option<f64> {
    match metric {
        Metric::Mse => Some(mse(reference, image)),
        Metric::RelativeMse => {
            options.epsilon.map(|epsilon| relative_map(reference, image, epsilon).mean())
        }
        _ => None,
    }
}

/// Noise and squared bias of n pictures with these squared `errors`, `of_mean` being the squared error of
/// their mean: the mean of `errors` is bias + noise, and `of_mean` is bias + noise / n.
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
    fn pairs_of_renders_give_the_step_error() {
        // Renders 1 and 3 of a target 0, with the finest step 0.5 and 2.5 from the same seeds: the
        // step adds 0.5 whatever the noise, so that of the 3 of bias 0.25 are its own.
        let (target, mean) = (grey(0.0), grey(2.0));
        let steps = [(1.0, 0.5), (3.0, 2.5)];
        let steps = steps.map(|(coarse, fine)| displaced(&target, &grey(coarse), &grey(fine)));
        let measurement =
            Measurement { target: &target, own: 0.5, mean: &mean, steps: Some(&steps) };
        let split = measurement.split(&[1.0, 9.0], Metric::Mse, &Options::default()).unwrap();
        assert_eq!(split, ErrorSplit { noise: 2.0, step: Some(0.25), bias: 2.25 });
        let sum = split.noise + split.step.unwrap() + split.bias + 0.5;
        assert_eq!(sum, 5.0, "the mean of the errors");
    }
}
