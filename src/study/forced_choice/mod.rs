//! Do people see the difference? A two-alternative forced-choice experiment.
//!
//! For each scene a person sees the gold standard and the directed picture once and has to say
//! which is which, in one of the two [`Condition`]s of Anson, Sundstedt, Gutierrez and Chalmers
//! 2006, "Efficient Selective Rendering of Participating Media". Who cannot tell them apart is
//! right half of the time; a chi-square test tells answers from that, as in the paper's Table 3.
//!
//! [`write_trial`] makes the page, [`Server`] shows it and keeps the answers, [`read_answers`] and
//! [`tally()`] count them.

mod answers;
mod page;
mod pair;
mod server;
mod tally;

pub use answers::{Answer, AnswerKey, COLUMNS, Condition, Side, read_answers};
pub use page::{PAGE, check_scenes, write_trial};
pub use pair::{Experiment, Pair, ShownScene};
pub use server::{ANSWERS, Server};
pub use tally::{Tally, tally};
