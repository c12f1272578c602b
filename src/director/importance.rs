//! X and S become one: the XS-map.

use crate::scene::Operator;

/// The XS-map, 0 to 1: w_x X + w_s S, or X^w_x S^w_s (Anson et al. 2006, section 3.3, whose own
/// weights are (0.5, 0.5) with the sum). The two maps have one value a pixel each, 0 to 1; a map
/// whose weight is 0 is not looked at and may be empty.
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
        };
        xs.clamp(0.0, 1.0) as f32
    };
    (0..x.len().max(s.len())).map(one).collect()
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
}
