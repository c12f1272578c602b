//! The transfer curve of sRGB (IEC 61966-2-1:1999, equations 5 to 8).

/// The sRGB code value, 0 to 1, of a linear value; what lies outside 0 to 1 is clipped, NaN is 0.
pub fn encode(linear: f64) -> f64 {
    let linear = if linear > 0.0 { linear.min(1.0) } else { 0.0 };
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// The linear value of an sRGB code value from 0 to 1.
pub fn decode(code: f64) -> f64 {
    if code <= 0.040_45 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_values() {
        let byte = |v: f64| (encode(v) * 255.0).round();
        assert_eq!(byte(0.0), 0.0);
        assert_eq!(byte(0.18), 118.0);
        assert_eq!(byte(0.5), 188.0);
        assert_eq!(byte(1.0), 255.0);
        assert_eq!(byte(7.0), 255.0);
        assert_eq!(byte(-1.0), 0.0);
        assert_eq!(byte(f64::NAN), 0.0);
        assert_eq!(byte(f64::INFINITY), 255.0);
    }

    #[test]
    fn every_byte_survives_the_way_there_and_back() {
        for byte in 0..=255_u8 {
            let back = encode(decode(f64::from(byte) / 255.0)) * 255.0;
            assert!((back - f64::from(byte)).abs() < 1e-2, "{byte} came back as {back}");
        }
    }
}
