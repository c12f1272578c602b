//! Frames of a sequence, read one ahead of the one that is rendered.

use std::path::Path;
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread::Scope;
use std::time::{Duration, Instant};

use clap::builder::{PossibleValuesParser, TypedValueParser};

use super::load;
use crate::error::{Error, Result};
use crate::scene::{Scene, Sequence};
use crate::sequence::{FrameTime, Frames};

/// Most runs of missing frames that a message lists.
const MAX_LISTED_RUNS: usize = 10;

/// Frames to render, and the policy for missing and empty ones.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Sequences")]
pub(super) struct FrameArgs {
    /// Frames to render, such as 1-100, 1-100x2 or 1,4,9-12: their numbers go where #### or %04d
    /// stands in the names of files. With decimals, such as 12-13x0.25, also times between two frames, at which
    /// velocities carry the smoke of both.
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    pub(super) frames: Option<Frames>,
    /// What to do of a frame whose file is missing, broken or empty: stop, render the one before it
    /// again, or make no picture; `fail` by default.
    #[arg(long, value_name = "WHAT", requires = "frames", value_parser = policy())]
    missing: Option<MissingPolicy>,
    /// Render frames whose volume is empty as they are, without it.
    #[arg(long, requires = "frames")]
    empty: bool,
}

/// What is done about a frame whose files are missing, broken or empty.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum MissingPolicy {
    /// The run stops.
    Fail,
    /// The frame before it is rendered again.
    Hold,
    /// It gets no picture.
    Skip,
}

fn policy() -> impl TypedValueParser<Value = MissingPolicy> {
    PossibleValuesParser::new(["fail", "hold", "skip"]).map(|word| match word.as_str() {
        "hold" => MissingPolicy::Hold,
        "skip" => MissingPolicy::Skip,
        _ => MissingPolicy::Fail,
    })
}

/// A frame that was read.
#[derive(Debug)]
pub(super) struct Frame {
    pub(super) time: FrameTime,
    /// Its scene; `None` where it is skipped.
    pub(super) scene: Option<Box<Scene>>,
    /// The earlier frame whose files stand in for its own, if any.
    pub(super) held: Option<i64>,
    /// Why its own files cannot be used, if so.
    pub(super) problem: Option<String>,
    /// Time spent on reading.
    pub(super) loading: Duration,
}

/// Reads frames under a policy for missing ones.
#[derive(Debug)]
pub(super) struct Reader<'a> {
    sequence: &'a Sequence,
    missing: MissingPolicy,
    empty: bool,
}

impl<'a> Reader<'a> {
    /// A reader of the frames of `sequence`.
    pub(super) fn new(sequence: &'a Sequence, args: &FrameArgs) -> Self {
        Self { sequence, missing: args.missing.unwrap_or(MissingPolicy::Fail), empty: args.empty }
    }

    /// Checks that the files of `frames` exist. Returns a message that lists those that are missing.
    ///
    /// # Errors
    /// Where the first frame without files can be neither left out nor replaced.
    pub(super) fn check(&self, frames: &[FrameTime]) -> Result<Option<String>> {
        let is_absent = |frame: &FrameTime| self.sequence.missing(*frame).is_some();
        let absent: Vec<FrameTime> = frames.iter().copied().filter(is_absent).collect();
        let Some(&first) = absent.first() else { return Ok(None) };
        let count = format!("{} of {} frames have no file", absent.len(), frames.len());
        let list = listed(&absent);
        let action = match self.missing {
            MissingPolicy::Fail => {
                let file = self.sequence.missing(first).unwrap_or_default();
                let problem = format!("{}: no such file; {count}: {list}", file.display());
                return Err(frame_error(first, &problem));
            }
            MissingPolicy::Skip => "no picture for them",
            MissingPolicy::Hold => {
                let lowest = absent.iter().copied().min().unwrap_or(first);
                if self.earlier(lowest).is_empty() {
                    return Err(self.nothing_to_hold(lowest));
                }
                "the one before is rendered again"
            }
        };
        Ok(Some(format!("{count}: {list}; {action}")))
    }

    /// Reads `frames` in their order on a thread of its own, the next one while the one before is in
    /// use and none beyond it. A frame that ends the run is the last.
    pub(super) fn ahead<'scope>(
        self,
        scope: &'scope Scope<'scope, '_>,
        frames: &'a [FrameTime],
    ) -> Result<Receiver<Result<Frame>>>
    where
        'a: 'scope,
    {
        // A separate pool, so that reading does not wait for the rays of the picture.
        let pool = load::thread_pool(Some(1))?;
        let (sender, receiver) = sync_channel(0);
        scope.spawn(move || {
            for &time in frames {
                let frame = pool.install(|| self.read(time));
                let failed = frame.is_err();
                if sender.send(frame).is_err() || failed {
                    break;
                }
            }
        });
        Ok(receiver)
    }

    fn read(&self, time: FrameTime) -> Result<Frame> {
        let start = Instant::now();
        let frame = |scene: Option<Scene>, held, problem| Frame {
            time,
            scene: scene.map(Box::new),
            held,
            problem,
            loading: start.elapsed(),
        };
        let problem = match self.load(time) {
            Ok(scene) => return Ok(frame(Some(scene), None, None)),
            Err(problem) => problem.to_string(),
        };
        match self.missing {
            MissingPolicy::Fail => Err(frame_error(time, &problem)),
            MissingPolicy::Skip => Ok(frame(None, None, Some(problem))),
            MissingPolicy::Hold => {
                let earlier = self.earlier(time).into_iter().rev();
                let mut earlier = earlier.filter_map(|n| Some((n, self.load(n.into()).ok()?)));
                let (held, scene) = earlier.next().ok_or_else(|| self.nothing_to_hold(time))?;
                Ok(frame(Some(scene), Some(held), Some(problem)))
            }
        }
    }

    /// Loads the scene of a frame.
    ///
    /// # Errors
    /// Where its file is missing or broken, or its volume empty and `--empty` was not given.
    fn load(&self, time: FrameTime) -> Result<Scene> {
        if let Some(path) = self.sequence.missing(time) {
            return Err(Error::file(path, "no such file"));
        }
        let scene = self.sequence.load(time)?;
        if scene.is_clear() && !self.empty {
            let files = self.sequence.files(time);
            let problem =
                "is empty, no voxel has a density above 0; --empty renders it all the same";
            return Err(Error::file(files.first().map_or(Path::new(""), |path| path), problem));
        }
        Ok(scene)
    }

    /// The frames before `time` whose files exist, in `--frames` or not, so that the frame that is held
    /// does not depend on the list.
    fn earlier(&self, time: FrameTime) -> Vec<i64> {
        let numbers = self.sequence.numbers().into_iter();
        numbers.take_while(|earlier| FrameTime::from(*earlier) < time).collect()
    }

    fn nothing_to_hold(&self, frame: FrameTime) -> Error {
        let file = self.sequence.files(frame).into_iter().next().unwrap_or_default();
        let problem = format!(
            "{}: cannot be used, and no frame before it can be held; begin with a later frame or \
             give --missing skip",
            file.display()
        );
        Error::Frame { frame, problem }
    }
}

fn frame_error(frame: FrameTime, problem: &str) -> Error {
    let problem = format!("{problem}; --missing hold or --missing skip goes on without");
    Error::Frame { frame, problem }
}

/// `frames` as `1, 4, 7 to 9`; of many only the first runs.
fn listed(frames: &[FrameTime]) -> String {
    let mut runs: Vec<(FrameTime, FrameTime)> = Vec::new();
    for &frame in frames {
        match runs.last_mut() {
            Some((_, last)) if last.is_followed_by(frame) => *last = frame,
            _ => runs.push((frame, frame)),
        }
    }
    let word = |(a, b): &(FrameTime, FrameTime)| {
        if a == b { a.to_string() } else { format!("{a} to {b}") }
    };
    let more = (runs.len() > MAX_LISTED_RUNS).then(|| "and more".to_owned());
    runs.iter().take(MAX_LISTED_RUNS).map(word).chain(more).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, IVec3};

    use super::*;
    use crate::scene::LoadOptions;
    use crate::vdb::{Block, GridToWrite, write};

    fn frames() -> [FrameTime; 3] {
        [7, 8, 9].map(FrameTime::from)
    }

    fn file(folder: &Path, frame: FrameTime) -> std::path::PathBuf {
        folder.join(format!("cube_{frame}.vdb"))
    }

    fn sequence(folder: &Path) -> Sequence {
        let mut grid = GridToWrite::fog("density", 0.5, DVec3::ZERO);
        let (origin, values) = (IVec3::ZERO, vec![1.0; 512]);
        grid.blocks.push(Block { origin, values, active: None });
        for frame in frames() {
            write(&file(folder, frame), std::slice::from_ref(&grid)).unwrap();
        }
        Sequence::open(&folder.join("cube_#.vdb"), &LoadOptions::default()).unwrap()
    }

    fn reader(sequence: &Sequence) -> Reader<'_> {
        Reader { sequence, missing: MissingPolicy::Fail, empty: false }
    }

    #[test]
    fn one_frame_is_read_ahead_and_no_more() {
        let folder = tempfile::tempdir().unwrap();
        let (sequence, all) = (sequence(folder.path()), frames());
        std::thread::scope(|scope| {
            let [seven, eight, nine] = all;
            let frames = reader(&sequence).ahead(scope, &all).unwrap();
            assert_eq!(frames.recv().unwrap().unwrap().time, seven);
            // Whoever reads 9 waits until 8 is taken.
            std::fs::remove_file(file(folder.path(), nine)).unwrap();
            assert_eq!(frames.recv().unwrap().unwrap().time, eight);
            let problem = frames.recv().unwrap().unwrap_err().to_string();
            assert!(problem.contains("frame 9") && problem.contains("no such file"), "{problem}");
            assert!(frames.recv().is_err(), "a frame that fails is the last");
        });
    }

    /// A frame whose file is deleted while the one before is in use has been read by then, given time.
    #[test]
    fn the_next_frame_is_read_meanwhile() {
        let folder = tempfile::tempdir().unwrap();
        let was_read = |milliseconds| {
            let (sequence, all) = (sequence(folder.path()), frames());
            std::thread::scope(|scope| {
                let frames = reader(&sequence).ahead(scope, &all).unwrap();
                frames.recv().unwrap().unwrap();
                std::thread::sleep(Duration::from_millis(milliseconds));
                std::fs::remove_file(file(folder.path(), all[1])).unwrap();
                frames.recv().unwrap().is_ok()
            })
        };
        assert!([50, 200, 1000, 5000].into_iter().any(was_read));
    }

    #[test]
    fn lists_of_frames_are_short() {
        assert_eq!(listed(&[1, 4, 5, 6, 9, 8].map(FrameTime::from)), "1, 4 to 6, 9, 8");
        let between = "1,2,2.5,3.5".parse::<Frames>().unwrap();
        assert_eq!(listed(between.times()), "1 to 2, 2.5, 3.5");
        let odd: Vec<_> = (0..1000).map(|i| FrameTime::from(2 * i + 1)).collect();
        assert!(listed(&odd).ends_with("17, 19, and more"));
    }
}
