//! Numbers as they are read.

/// `value` with this many significant digits, with an exponent where it is very large or small.
pub fn significant(value: f64, digits: usize) -> String {
    let magnitude = value.abs();
    let after_first = digits.saturating_sub(1);
    if magnitude == 0.0 {
        "0".into()
    } else if (1e-3..1e5).contains(&magnitude) {
        let decimals = (after_first as i32 - magnitude.log10().floor() as i32).max(0) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{value:.after_first$e}")
    }
}
