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
    let start = Instant::now();
    let watch = Watch { start, begun: Mutex::default() };
    let before = Spent::now(start);
    let rendered = pool.install(|| render(scene, &scene.render, &watch))?;
    let after = Spent::now(start);
    let mut stages = [Spent::default(); STAGES.len()];
    let begun = watch.begun.into_inner().expect("no panic");
    let ends = begun.iter().skip(1).map(|(_, next)| *next).chain([after]);
    for ((name, begin), end) in begun.iter().zip(ends) {
        if let Some(index) = STAGES.iter().position(|stage| stage == name) {
            stages[index] = end - *begin;
        }
    }
    Ok(Timed { rendered, stages, whole: after - before })
}
