//! Flags that limit a render: its time, memory and part of the film, and its checkpoints.

use std::path::{Path, PathBuf};
use std::time::Duration;

use super::units::{bytes, time};
use crate::image::Window;

/// Limits and checkpoints of a render.
#[derive(Debug, clap::Args)]
pub(super) struct LimitArgs {
    /// Go on from the checkpoint that a render of the same picture left beside the output; start
    /// from the beginning where there is none.
    #[arg(long)]
    pub(super) resume: bool,
    /// How often the state is kept beside the output, as OUT.exr.checkpoint, or off; without a unit
    /// seconds.
    #[arg(long, value_name = "TIME", default_value = "60s", value_parser = interval)]
    pub(super) checkpoint: CheckpointInterval,
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

/// Time between checkpoints.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum CheckpointInterval {
    /// No checkpoint is written.
    Off,
    /// One is written whenever such a time has passed.
    Every(Duration),
}

/// The checkpoint file of a render to `output`.
pub(super) fn checkpoint_path(output: &Path) -> PathBuf {
    let mut name = output.as_os_str().to_owned();
    name.push(".checkpoint");
    PathBuf::from(name)
}

fn interval(text: &str) -> Result<CheckpointInterval, String> {
    if text == "off" {
        return Ok(CheckpointInterval::Off);
    }
    time(text).map(CheckpointInterval::Every).map_err(|right| format!("{right}, or off"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interval_is_a_time_or_off() {
        assert_eq!(interval("200ms"), Ok(CheckpointInterval::Every(Duration::from_millis(200))));
        assert_eq!(interval("90"), Ok(CheckpointInterval::Every(Duration::from_secs(90))));
        assert_eq!(interval("off"), Ok(CheckpointInterval::Off));
        assert!(interval("never").unwrap_err().ends_with(", or off"));
    }
}
