//! Flags that limit a render: its time, memory and part of the film, and its checkpoints.

use std::path::{Path, PathBuf};
use std::time::Duration;

use super::units::{bytes, time};
use crate::error::{Error, Result};
use crate::image::Window;
use crate::scene::Scene;

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
    /// Write the picture that there is so often while it gets better, such as 5s, the first one at once; without
    /// a unit seconds. The signal USR1 asks for one at any time.
    #[arg(long, value_name = "TIME", value_parser = time)]
    pub(super) preview: Option<Duration>,
    /// Render only this part of the film: its upper left pixel and its size.
    #[arg(long, value_name = "X,Y,WxH")]
    pub(super) crop: Option<Window>,
}

impl LimitArgs {
    /// Gives `scene` the part of its film that is rendered.
    ///
    /// # Errors
    /// Where that lies beyond the film, or an error is the goal: it is that of the whole picture, and a reference has none.
    pub(super) fn set_crop(&self, scene: &mut Scene, is_reference: bool) -> Result<()> {
        if scene.render.error.is_some() && (is_reference || self.crop.is_some()) {
            return Err(Error::Usage(format!(
                "{} and an error as the goal exclude each other: give rays{} instead of the error",
                if is_reference { "--reference" } else { "--crop" },
                if is_reference { "" } else { " and photons" },
            )));
        }
        let Some(crop) = self.crop else { return Ok(()) };
        let [width, height] = scene.film.size;
        if !crop.fits(scene.film.size) {
            return Err(Error::Usage(format!(
                "--crop {crop} reaches beyond the film of {width}x{height} pixels"
            )));
        }
        scene.render.crop = Some(crop);
        Ok(())
    }
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

fn interval(text: &str) -> std::result::Result<CheckpointInterval, String> {
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
