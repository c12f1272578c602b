//! What holds a render: where it is taken up again, when it ends, what it may take.

use std::path::{Path, PathBuf};
use std::time::Duration;

use bytesize::ByteSize;

use crate::image::Window;

/// How a render is cut short and taken up again, and what it may take.
#[derive(Debug, clap::Args)]
pub(super) struct HoldArgs {
    /// Go on from the checkpoint that a render of the same picture left beside the output; start
    /// from the beginning where there is none.
    #[arg(long)]
    pub(super) resume: bool,
    /// How often the state is kept beside the output, as OUT.exr.checkpoint, or off.
    #[arg(long, value_name = "TIME", default_value = "60s", value_parser = pause)]
    pub(super) checkpoint: Pause,
    /// Be done within this time, such as 90s, 5m or 2h, with the best picture until then.
    #[arg(long, value_name = "TIME", value_parser = time)]
    pub(super) time: Option<Duration>,
    /// Take at most this much memory, such as 4G or 512MiB: with fewer photons, or not at all.
    #[arg(long, value_name = "BYTES", value_parser = bytes)]
    pub(super) memory: Option<u64>,
    /// Render only this part of the film: its upper left pixel and its size.
    #[arg(long, value_name = "X,Y,WxH")]
    pub(super) crop: Option<Window>,
}

/// How long the state is not kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Pause {
    /// It is never kept.
    Off,
    /// So long.
    Lasts(Duration),
}

/// Where the state of a render to `output` is kept.
pub(super) fn checkpoint_path(output: &Path) -> PathBuf {
    let mut name = output.as_os_str().to_owned();
    name.push(".checkpoint");
    PathBuf::from(name)
}

fn time(text: &str) -> Result<Duration, String> {
    let parsed = humantime::parse_duration(text).ok().filter(|time| !time.is_zero());
    parsed.ok_or_else(|| "give a time above 0 with its unit, as 90s, 5m or 1h 30m".into())
}

fn pause(text: &str) -> Result<Pause, String> {
    if text == "off" {
        return Ok(Pause::Off);
    }
    let lasts = time(text).map(Pause::Lasts);
    lasts.map_err(|_| "give a time above 0 with its unit, as 90s or 5m, or off".into())
}

fn bytes(text: &str) -> Result<u64, String> {
    let parsed = text.parse::<ByteSize>().ok().map(|size| size.as_u64()).filter(|n| *n > 0);
    parsed.ok_or_else(|| "give a size above 0, as 4G (10^9 bytes each), 4GiB or 512M".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_have_units() {
        assert_eq!(time("90s"), Ok(Duration::from_secs(90)));
        assert_eq!(time("1h 30m"), Ok(Duration::from_secs(5400)));
        assert_eq!(pause("200ms"), Ok(Pause::Lasts(Duration::from_millis(200))));
        assert_eq!(pause("off"), Ok(Pause::Off));
        for bad in ["", "5", "0s", "-3m", "5 parsecs", "off"] {
            assert!(time(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn sizes_are_decimal_or_binary() {
        assert_eq!(bytes("4G"), Ok(4_000_000_000));
        assert_eq!(bytes("2GiB"), Ok(2 << 30));
        assert_eq!(bytes("1.5 MiB"), Ok(3 << 19));
        for bad in ["", "0", "-1G", "G", "4 apples", "NaN", "inf"] {
            assert!(bytes(bad).is_err(), "{bad}");
        }
    }
}
