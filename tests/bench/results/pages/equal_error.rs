//! Time to the same error, by straight lines between measured budgets on logarithmic axes.

use std::fmt;

/// Seconds and error of a picture.
pub type Point = (f64, f64);

/// What is known of a figure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bound {
    /// It is less: already the cheapest picture was better.
    Below,
    /// It lies between pictures.
    Exact,
    /// It is more: the dearest picture was not as good. Nothing is extrapolated.
    Above,
}

/// Seconds to an error.
#[derive(Debug, Clone, Copy)]
pub struct Reached {
    seconds: f64,
    bound: Bound,
}

/// Times faster.
#[derive(Debug, Clone, Copy)]
pub struct Faster {
    /// Times.
    pub times: f64,
    /// What is known of it.
    pub bound: Bound,
}

impl Reached {
    /// How many times longer another took with its `seconds`.
    pub fn faster_than(self, seconds: f64) -> Faster {
        let bound = match self.bound {
            Bound::Below => Bound::Above,
            Bound::Exact => Bound::Exact,
            Bound::Above => Bound::Below,
        };
        Faster { times: seconds / self.seconds, bound }
    }

    /// When the later of two errors is reached.
    pub fn and(self, other: Self) -> Self {
        let later = if other.seconds > self.seconds { other } else { self };
        if self.bound == Bound::Above || other.bound == Bound::Above {
            Self { bound: Bound::Above, ..later }
        } else {
            later
        }
    }
}

impl fmt::Display for Faster {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sign = match self.bound {
            Bound::Below => "< ",
            Bound::Exact => "",
            Bound::Above => "> ",
        };
        let decimals = usize::from(self.times < 9.95);
        write!(f, "{sign}{:.*}", if self.times < 0.995 { 2 } else { decimals }, self.times)
    }
}

/// The points that are better than all sooner ones, by time.
pub fn front(points: &[Point]) -> Vec<Point> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut front: Vec<Point> = Vec::new();
    for point in sorted {
        if front.last().is_none_or(|last| point.1 < last.1) {
            front.push(point);
        }
    }
    front
}

/// When a curve of seconds and errors first gets to `error`; nothing where there is no point.
pub fn time_to(curve: &[Point], error: f64) -> Option<Reached> {
    let points = front(curve);
    let first = points.first()?;
    if first.1 <= error {
        return Some(Reached { seconds: first.0, bound: Bound::Below });
    }
    for pair in points.windows(2) {
        let [(t0, e0), (t1, e1)] = [pair[0], pair[1]];
        if e1 <= error {
            let part = (e0 / error).ln() / (e0 / e1).ln();
            return Some(Reached { seconds: t0 * (t1 / t0).powf(part), bound: Bound::Exact });
        }
    }
    let last = curve.iter().map(|point| point.0).max_by(f64::total_cmp)?;
    Some(Reached { seconds: last, bound: Bound::Above })
}
