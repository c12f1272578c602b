//! Times and sizes on the command line, parsed alike for all flags: a number without a unit is in seconds,
//! or in bytes. Times are printed in two units.

use std::time::Duration;

use bytesize::ByteSize;

/// A time above 0: a number of seconds, as 90 or 0.5, or numbers with units, as 90s, 5m, 1.5h or
/// `1h 30m`.
///
/// # Errors
/// Says what to give where it is of another form.
pub(super) fn time(text: &str) -> Result<Duration, String> {
    let time = seconds(text).or_else(|| humantime::parse_duration(text.trim()).ok());
    time.filter(|time| !time.is_zero())
        .ok_or_else(|| "give a time above 0, as 90s, 5m or 1h 30m; without a unit seconds".into())
}

/// One number, whole or not, with at most one unit.
fn seconds(text: &str) -> Option<Duration> {
    let units = [("ms", 1e-3), ("s", 1.0), ("m", 60.0), ("h", 3600.0), ("", 1.0)];
    let (number, unit) =
        units.iter().find_map(|(name, unit)| Some((text.trim().strip_suffix(name)?, *unit)))?;
    Duration::try_from_secs_f64(number.trim().parse::<f64>().ok()? * unit).ok()
}

/// Bytes above 0: a number of them, or one with a unit, as 4G (10^9 bytes each), 4GiB or 512M.
///
/// # Errors
/// Says what to give where it is of another form.
pub(super) fn bytes(text: &str) -> Result<u64, String> {
    let parsed = text.parse::<ByteSize>().ok().map(|size| size.as_u64()).filter(|n| *n > 0);
    parsed.ok_or_else(|| {
        "give a size above 0, as 4G (10^9 bytes each), 4GiB or 512M; without a unit bytes".into()
    })
}

/// `time` in its two largest units: nothing longer fits into a line of 40 columns.
pub(super) fn brief(time: Duration) -> String {
    let all = time.as_secs_f64().round() as u64;
    let (hours, minutes, seconds) = (all / 3600, all / 60 % 60, all % 60);
    match (hours, minutes) {
        (0, 0) => format!("{seconds}s"),
        (0, _) => format!("{minutes}m {seconds}s"),
        (1..100, _) => format!("{hours}h {minutes}m"),
        _ => format!("{}d {}h", hours / 24, hours % 24),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_without_a_unit_are_seconds() {
        for (text, milliseconds) in [
            ("90", 90_000),
            ("0.5", 500),
            ("90s", 90_000),
            ("200ms", 200),
            ("5m", 300_000),
            ("1.5h", 5_400_000),
            ("1h 30m", 5_400_000),
            (" 2 m ", 120_000),
        ] {
            assert_eq!(time(text), Ok(Duration::from_millis(milliseconds)), "{text}");
        }
        for bad in ["", "0", "0s", "-3m", "5 parsecs", "off", "NaN", "inf", "1e99h", "m"] {
            let message = time(bad).unwrap_err();
            assert!(message.contains("without a unit seconds"), "{bad}: {message}");
        }
    }

    #[test]
    fn sizes_without_a_unit_are_bytes() {
        assert_eq!(bytes("4096"), Ok(4096));
        assert_eq!(bytes("4G"), Ok(4_000_000_000));
        assert_eq!(bytes("2GiB"), Ok(2 << 30));
        assert_eq!(bytes("1.5 MiB"), Ok(3 << 19));
        for bad in ["", "0", "-1G", "G", "4 apples", "NaN", "inf"] {
            let message = bytes(bad).unwrap_err();
            assert!(message.contains("without a unit bytes"), "{bad}: {message}");
        }
    }

    #[test]
    fn times_are_short() {
        for (seconds, text) in [
            (0.4, "0s"),
            (43.2, "43s"),
            (59.6, "1m 0s"),
            (754.0, "12m 34s"),
            (7384.0, "2h 3m"),
            (359_999.0, "99h 59m"),
            (900_000.0, "10d 10h"),
        ] {
            assert_eq!(brief(Duration::from_secs_f64(seconds)), text);
        }
    }
}
