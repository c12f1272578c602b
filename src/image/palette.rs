//! Colours of scalar maps.

/// The colour of what is not finite: a grey that [`viridis`] does not have.
pub const NOT_FINITE: [u8; 3] = [128; 3];

/// The sRGB bytes of viridis (van der Walt and Smith 2015) at `t` from 0 to 1, clipped outside:
/// evenly spaced to the eye, rising in lightness, safe for colour-blind readers. What is not finite
/// is [`NOT_FINITE`].
pub fn viridis(t: f64) -> [u8; 3] {
    if t.is_finite() { colorous::VIRIDIS.eval_continuous(t).as_array() } else { NOT_FINITE }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::srgb_decode;
    use crate::math::{Rgb, luminance};

    #[test]
    fn lightness_rises_all_the_way() {
        let linear = |byte: u8| srgb_decode(f64::from(byte) / 255.0);
        let at = |i: u32| luminance(Rgb::from(viridis(f64::from(i) / 100.0).map(linear)));
        for i in 0..100 {
            assert!(at(i) < at(i + 1), "{i} %");
        }
    }

    #[test]
    fn ends_are_clipped_and_the_rest_is_grey() {
        assert_eq!(viridis(-1.0), viridis(0.0));
        assert_eq!(viridis(2.0), viridis(1.0));
        for t in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(viridis(t), NOT_FINITE);
        }
        assert!((0..=1000).all(|i| viridis(f64::from(i) / 1000.0) != NOT_FINITE));
    }
}
