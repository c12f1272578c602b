//! What the stages of a render take.

use std::sync::Mutex;
use std::time::Instant;

use fogbow::render::{Progress, Rendered, render};
use fogbow::scene::Scene;
use rayon::ThreadPool;

use super::spent::Spent;

/// Stages of a render: paths are traced, maps built of what they left, rays marched. The last paths
/// may still fly while maps are said to be built.
pub const STAGES: [&str; 3] = ["photons", "photon map", "rays"];

/// Notes when stages begin.
struct Watch {
    start: Instant,
    begun: Mutex<Vec<(String, Spent)>>,
}

impl Progress for Watch {
    fn stage(&self, name: &str, _: u64) {
        let now = Spent::now(self.start);
        self.begun.lock().expect("no panic").push((name.into(), now));
    }

    fn advance(&self, _: u64) {}

    fn finish(&self) {}
}

/// A picture, what each of [`STAGES`] took and what the whole did.
pub struct Timed {
    /// The picture.
    pub rendered: Rendered,
    /// Nothing for a stage that was left out.
    pub stages: [Spent; STAGES.len()],
    /// All of it.
    pub whole: Spent,
}

/// Renders `scene` in `pool`.
pub fn timed(scene: &Scene, pool: &ThreadPool) -> fogbow::Result<Timed> {
    let work = |watch: &dyn Progress| pool.install(|| render(scene, &scene.render, watch));
    let Watched { done, begun, whole } = watched(work)?;
    let mut stages = [Spent::default(); STAGES.len()];
    for (name, took) in begun {
        if let Some(index) = STAGES.iter().position(|stage| *stage == name) {
            stages[index] = took;
        }
    }
    Ok(Timed { rendered: done, stages, whole })
}

/// What some work gave and took.
pub struct Watched<T> {
    /// What it gave.
    pub done: T,
    /// Stages that it told, in order; each lasts until the next, or the end.
    pub begun: Vec<(String, Spent)>,
    /// All of it.
    pub whole: Spent,
}

impl<T> Watched<T> {
    /// What the stages of this name took together.
    pub fn stage(&self, name: &str) -> Spent {
        let own = self.begun.iter().filter(|(begun, _)| begun == name);
        own.fold(Spent::default(), |sum, (_, took)| sum + *took)
    }

    /// What it took before its first stage.
    pub fn before(&self) -> Spent {
        self.begun.iter().fold(self.whole, |left, (_, took)| left - *took)
    }
}

/// Does `work`, which tells its stages.
pub fn watched<T>(
    work: impl FnOnce(&dyn Progress) -> fogbow::Result<T>,
) -> fogbow::Result<Watched<T>> {
    let start = Instant::now();
    let watch = Watch { start, begun: Mutex::default() };
    let before = Spent::now(start);
    let done = work(&watch)?;
    let after = Spent::now(start);
    let begun = watch.begun.into_inner().expect("no panic");
    let ends: Vec<Spent> = begun.iter().skip(1).map(|(_, next)| *next).chain([after]).collect();
    let begun = begun.into_iter().zip(ends).map(|((name, begin), end)| (name, end - begin));
    Ok(Watched { done, begun: begun.collect(), whole: after - before })
}
