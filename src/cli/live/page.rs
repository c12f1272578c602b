//! What the page shows: written by the render, read by the server.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::super::progress::{StageProgress, Watch};
use super::super::units;
use super::develop;
use crate::image::{Film, View};
use crate::render::{PREVIEW_RATIO, ReachedError};
use crate::scene::ErrorGoal;

/// Least time between two pictures.
const REFRESH: Duration = Duration::from_millis(900);

/// Time since its last request after which nobody looks at the page: several of its questions long.
const LOOKING: Duration = Duration::from_secs(3);

/// The picture and all that is told beside it.
#[derive(Debug)]
pub(super) struct Page {
    state: Mutex<State>,
}

#[derive(Debug)]
struct State {
    /// The file that is rendered.
    name: String,
    /// How its picture is developed at first.
    view: View,
    watch: Option<Watch>,
    /// The newest picture.
    film: Option<Arc<Film>>,
    /// Pictures so far.
    version: u64,
    /// When the last one came.
    shown: Instant,
    /// Time that developing it took.
    developing: Duration,
    /// When a page last asked for anything.
    looked: Option<Instant>,
    /// How the render ended, and when.
    ended: Option<(String, Instant)>,
}

impl Page {
    /// One without a picture, for a file that will be called `name`.
    pub(super) fn new(name: &str) -> Self {
        let state = State {
            name: name.to_owned(),
            view: View::default(),
            watch: None,
            film: None,
            version: 0,
            shown: Instant::now(),
            developing: Duration::ZERO,
            looked: None,
            ended: None,
        };
        Self { state: Mutex::new(state) }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A picture begins.
    pub(super) fn begin(&self, name: &str, view: View, watch: Watch) {
        let mut state = self.state();
        (state.name, state.view, state.watch) = (name.to_owned(), view, Some(watch));
    }

    /// Whether a new picture would be seen. The last one is shown for several times as long as its development took, so
    /// that a large one does not take much of the time from the rays.
    pub(super) fn wants(&self) -> bool {
        let state = self.state();
        let pause = REFRESH.max(state.developing * PREVIEW_RATIO);
        is_recent(state.looked) && state.shown.elapsed() >= pause
    }

    /// Shows a picture.
    pub(super) fn show(&self, film: Arc<Film>) {
        let mut state = self.state();
        state.film = Some(film);
        state.version += 1;
        state.shown = Instant::now();
    }

    /// The render is over: `how`.
    pub(super) fn end(&self, how: &str) {
        self.state().ended = Some((how.to_owned(), Instant::now()));
    }

    /// Time since the render ended; `None` while it runs.
    pub(super) fn ended(&self) -> Option<Duration> {
        self.state().ended.as_ref().map(|(_, at)| at.elapsed())
    }

    /// A page asked for something.
    pub(super) fn look(&self) {
        self.state().looked = Some(Instant::now());
    }

    /// Whether a page asked for something lately.
    pub(super) fn is_looked_at(&self) -> bool {
        is_recent(self.state().looked)
    }

    /// The number of the newest picture.
    pub(super) fn version(&self) -> u64 {
        self.state().version
    }

    /// The newest picture with its number.
    pub(super) fn picture(&self) -> Option<(Arc<Film>, u64)> {
        let state = self.state();
        state.film.clone().map(|film| (film, state.version))
    }

    /// Development of the picture took this long.
    pub(super) fn developed(&self, took: Duration) {
        self.state().developing = took;
    }

    /// All that is told beside the picture, as JSON.
    pub(super) fn status(&self) -> Value {
        let state = self.state();
        let stage = state.watch.as_ref().and_then(Watch::stage);
        let error = state.watch.as_ref().and_then(Watch::reached);
        json!({
            "name": state.name,
            "version": state.version,
            "size": state.film.as_ref().map(|film| [film.width(), film.height()]),
            "layers": state.film.as_ref().map_or_else(Vec::new, |film| develop::layers(film)),
            "view": state.view,
            "loaded": state.watch.is_some(),
            "stage": stage.map(|stage| stage_status(&stage)),
            "error": error.map(|error| error_status(&error)),
            "ended": state.ended.as_ref().map(|(how, _)| how),
        })
    }
}

fn is_recent(moment: Option<Instant>) -> bool {
    moment.is_some_and(|moment| moment.elapsed() < LOOKING)
}

fn stage_status(stage: &StageProgress) -> Value {
    json!({
        "name": stage.name,
        "share": stage.share,
        "worked": units::brief(stage.worked),
        "left": stage.left.map(units::brief),
    })
}

/// The error in words, of the picture and of the goal, with what it took.
fn error_status(error: &ReachedError) -> Value {
    let ReachedError { goal, stated, photons, rays } = error;
    let unit = match goal {
        ErrorGoal::Relative(_) => "%",
        ErrorGoal::Visible => "% of what is visible",
    };
    let reached = stated.map(|stated| {
        let [value, sure] = stated.percent();
        format!("{value:.2} ± {sure:.2} {unit}")
    });
    let rounded = (100.0 * goal.value() * 1e6).round() / 1e6;
    json!({
        "reached": reached,
        "goal": format!("{rounded} {unit}"),
        "rays": rays,
        "photons": photons,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::StatedError;

    #[test]
    fn pictures_are_wanted_where_somebody_looks_and_not_at_once_again() {
        let page = Page::new("a.exr");
        std::thread::sleep(REFRESH);
        assert!(!page.wants(), "nobody looks");
        page.look();
        assert!(page.wants());
        page.show(Arc::new(Film::new(2, 2)));
        assert!(!page.wants(), "one was shown just before");
        assert_eq!(page.version(), 1);
        page.developed(Duration::from_secs(3600));
        std::thread::sleep(REFRESH);
        page.look();
        assert!(!page.wants(), "development takes long");
    }

    #[test]
    fn errors_are_told_beside_their_goals() {
        let stated = Some(StatedError { value: 0.0342, uncertainty: 0.05 });
        let of = |goal| error_status(&ReachedError { goal, stated, photons: 5, rays: 4 });
        let relative = of(ErrorGoal::Relative(0.02));
        assert_eq!([&relative["reached"], &relative["goal"]], ["3.42 ± 0.17 %", "2 %"]);
        assert_eq!(of(ErrorGoal::Visible)["goal"], "100 % of what is visible");
    }
}
