//! Flags that limit a render: its time, memory and part of the film, and its checkpoints.

use std::path::{Path, PathBuf};
use std::time::Duration;

use super::units::{bytes, time};
use crate::error::{Error, Result};
use crate::image::Window;
use crate::scene::{Aov, PicturePass, Scene};

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
    /// Render only this of several equal passes, such as 3/8: its share of rays and photons, with radii and cells of
    /// the whole; fogbow merge makes that of all passes.
    #[arg(long, value_name = "K/N", conflicts_with = "time")]
    pub(super) pass: Option<PicturePass>,
}

impl LimitArgs {
    /// Gives `scene` the part of its picture that is rendered.
    ///
    /// # Errors
    /// Where the crop reaches beyond the film, the picture cannot be rendered in such passes, or an error is the goal: it is
    /// that of the whole picture, and a reference has none.
    pub(super) fn set_part(&self, scene: &mut Scene, is_reference: bool) -> Result<()> {
        self.check_goal(scene, is_reference)?;
        check_passes(scene, is_reference)?;
        check_deep(scene)?;
        let [width, height] = scene.film.size;
        if let Some(crop) = self.crop.filter(|crop| !crop.fits(scene.film.size)) {
            let problem =
                format!("--crop {crop} reaches beyond the film of {width}x{height} pixels");
            return Err(Error::Usage(problem));
        }
        if let Some(pass) = self.pass {
            let wrong = |problem| Error::Usage(format!("--pass {pass}: {problem}"));
            scene.render.check_pass(pass).map_err(wrong)?;
        }
        scene.render.crop = self.crop;
        scene.render.pass = self.pass.filter(|pass| pass.count > 1);
        Ok(())
    }

    /// Refuses what has no error of its own where that is the goal of `scene`.
    fn check_goal(&self, scene: &Scene, is_reference: bool) -> Result<()> {
        let parts = [
            (is_reference, "--reference", "rays"),
            (self.crop.is_some(), "--crop", "rays and photons"),
            (self.pass.is_some(), "--pass", "rays and photons"),
        ];
        let has_goal = scene.render.error.is_some();
        match parts.into_iter().find(|(is_asked, ..)| has_goal && *is_asked) {
            Some((_, flag, instead)) => Err(Error::Usage(format!(
                "{flag} and an error as the goal exclude each other: give {instead} instead of the error"
            ))),
            None => Ok(()),
        }
    }
}

/// Refuses passes that a reference does not have.
fn check_passes(scene: &Scene, is_reference: bool) -> Result<()> {
    let light: Vec<_> = scene.film.passes.light().map(Aov::name).collect();
    if !is_reference || light.is_empty() {
        return Ok(());
    }
    Err(Error::Usage(format!(
        "--reference does not tell light by component; leave {} out of the passes, or --reference",
        light.join(", ")
    )))
}

/// Refuses a deep picture of what is blurred by motion, whose samples are those of one time.
fn check_deep(scene: &Scene) -> Result<()> {
    if scene.film.deep && !scene.times.is_empty() {
        return Err(Error::Usage(
            "a deep picture and motion blur exclude each other: leave out --deep (film.deep), or give motion.shutter = 0"
                .into(),
        ));
    }
    Ok(())
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
