//! Mixtures of distributions of which the first counts most: it gets half of all samples, or all if it is
//! alone; the others share the rest.

/// Which of `count` distributions the number `u` in [0, 1) picks, and a number in [0, 1) to go on
/// with.
pub(super) fn pick(u: f64, count: usize) -> (usize, f64) {
    let others = count - 1;
    if others == 0 {
        return (0, u);
    }
    if u < 0.5 {
        return (0, 2.0 * u);
    }
    let place = (2.0 * u - 1.0) * others as f64;
    let index = (place as usize).min(others - 1);
    (1 + index, place - index as f64)
}

/// Density of the mixture of `targets`, of which each has the density that `pdf` tells.
pub(super) fn pdf<T: Copy>(targets: &[T], pdf: impl Fn(T) -> f64) -> f64 {
    let Some((first, others)) = targets.split_first() else { return 0.0 };
    if others.is_empty() {
        return pdf(*first);
    }
    let sum: f64 = others.iter().map(|target| pdf(*target)).sum();
    0.5 * (pdf(*first) + sum / others.len() as f64)
}
