//! What holds a render: where it is taken up again, when it ends, what it may take.

use std::path::{Path, PathBuf};
use std::time::Duration;

use super::units::{bytes, time};
use crate::image::Window;

/// How a render is cut short and taken up again, and what it may take.
#[derive(Debug, clap::Args)]
pub(super) struct LimitArgs {
    /// Go on from the checkpoint that a render of the same picture left beside the output; start
    /// from the beginning where there is none.
    #[arg(long)]
    pub(super) resume: bool,
    /// How often the state is kept beside the output, as OUT.exr.checkpoint, or off; without a unit
    /// seconds.
    #[arg(long, value_name = "TIME", default_value = "60s", value_parser = pause)]
    pub(super) checkpoint: Pause,
    /// Be done within this time, such as 90s, 5m or 2h, with the best picture until then; without a
    /// unit seconds.
    #[arg(long, value_name = "TIME", value_parser = time)]
    pub(super) time: Option<Duration>,
    /// Take at most this much memory, such as 4G (10^9 bytes each) or 512MiB: with fewer photons, or not
    /// at all; without a unit bytes.
    #[arg(long, value_name = "SIZE", value_parser = bytes)]
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

fn pause(text: &str) -> Result<Pause, String> {
    if text == "off" {
        return Ok(Pause::Off);
    }
    time(text).map(Pause::Lasts).map_err(|right| format!("{right}, or off"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_state_is_kept_so_often_or_never() {
        assert_eq!(pause("200ms"), Ok(Pause::Lasts(Duration::from_millis(200))));
        assert_eq!(pause("90"), Ok(Pause::Lasts(Duration::from_secs(90))));
        assert_eq!(pause("off"), Ok(Pause::Off));
        assert!(pause("never").unwrap_err().ends_with(", or off"));
    }
}
