//! Logarithmic axes of plots, and the colours of what is drawn between them.

use plotters::style::{Color, HSLColor, RGBAColor};

/// Where an axis begins and ends.
pub type Ends = (f64, f64);

/// Ends of an axis that has all `values` on it, and a `margin` as a factor on both sides. Wider
/// intervals are cut off there: those of two seeds can span many decades.
pub fn around(values: impl Iterator<Item = f64>, margin: f64) -> Option<Ends> {
    let ends = values.fold(None, |ends: Option<Ends>, v| {
        let (low, high) = ends.unwrap_or((v, v));
        Some((low.min(v), high.max(v)))
    });
    ends.map(|(low, high)| (low / margin, high * margin))
}

/// Places on an axis that are told: powers of ten, with their doubles and fives where there are few;
/// not more than `most`, unless there are as many powers of ten.
pub fn ticks((low, high): Ends, most: usize) -> Vec<f64> {
    let powers = low.log10().floor() as i32..=high.log10().ceil() as i32;
    let at = |steps: &[f64]| -> Vec<f64> {
        let all = powers.clone().flat_map(|power| steps.iter().map(move |s| s * 10f64.powi(power)));
        all.filter(|tick| (low..=high).contains(tick)).collect()
    };
    [&[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0][..], &[1.0, 2.0, 5.0], &[1.0]]
        .iter()
        .map(|steps| at(steps))
        .find(|ticks| ticks.len() <= most)
        .unwrap_or_else(|| at(&[1.0]))
}

/// Colours evenly round the wheel, every other one darker, so that neighbours differ.
pub fn color_of(index: usize, of: usize) -> RGBAColor {
    let lightness = if index.is_multiple_of(2) { 0.55 } else { 0.35 };
    HSLColor(index as f64 / of as f64, 0.75, lightness).to_rgba()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_is_told_at_several_places() {
        assert_eq!(ticks((0.95, 2.2), 10), [1.0, 1.5, 2.0]);
        assert_eq!(ticks((0.15, 25.0), 10), [0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0]);
        assert_eq!(ticks((0.5e-6, 2.0), 10).len(), 7);
    }
}
