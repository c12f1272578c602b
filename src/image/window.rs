//! A part of a film.

use std::fmt::{self, Display, Formatter};
use std::ops::Range;
use std::str::FromStr;

/// A rectangle of a film's pixels; row 0 is the top row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// Pixels to the left of it.
    pub left: u32,
    /// Rows above it.
    pub top: u32,
    /// Pixels in a row of it.
    pub width: u32,
    /// Its rows.
    pub height: u32,
}

impl Window {
    /// All of a film of `size`, width and height.
    pub const fn whole([width, height]: [u32; 2]) -> Self {
        Self { left: 0, top: 0, width, height }
    }

    /// Whether it has pixels and all of them lie on a film of `size`.
    pub fn fits(&self, size: [u32; 2]) -> bool {
        let inside = |first: u32, length: u32, all: u32| {
            length > 0 && first.checked_add(length).is_some_and(|end| end <= all)
        };
        inside(self.left, self.width, size[0]) && inside(self.top, self.height, size[1])
    }

    /// It and `reach` pixels on each side, as far as they lie on a film of `size`.
    #[must_use]
    pub fn grown(&self, reach: u32, size: [u32; 2]) -> Self {
        let grown = |first: u32, length: u32, all: u32| {
            let begin = first.saturating_sub(reach);
            [begin, (first + length).saturating_add(reach).min(all) - begin]
        };
        let [left, width] = grown(self.left, self.width, size[0]);
        let [top, height] = grown(self.top, self.height, size[1]);
        Self { left, top, width, height }
    }

    /// The pixels that lie in both; `None` where there are none.
    pub fn intersection(&self, other: &Self) -> Option<Self> {
        let common = |a: u32, a_length: u32, b: u32, b_length: u32| {
            let begin = a.max(b);
            let end = a.saturating_add(a_length).min(b.saturating_add(b_length));
            (begin < end).then(|| [begin, end - begin])
        };
        let [left, width] = common(self.left, self.width, other.left, other.width)?;
        let [top, height] = common(self.top, self.height, other.top, other.height)?;
        Some(Self { left, top, width, height })
    }

    /// The pixels of each of its rows: their indices on a film `width` pixels wide, and among its own.
    pub fn rows(&self, width: usize) -> impl Iterator<Item = (Range<usize>, Range<usize>)> {
        let Self { left, top, width: length, height } = *self;
        let (left, top, length) = (left as usize, top as usize, length as usize);
        (0..height as usize).map(move |row| {
            let begin = (top + row) * width + left;
            (begin..begin + length, row * length..(row + 1) * length)
        })
    }

    /// The values of its pixels in a `plane` of those of the window `larger`, row by row from the top.
    ///
    /// # Panics
    /// Where `larger` does not hold all of it.
    pub(super) fn cut<T: Copy>(&self, plane: &[T], larger: Self) -> Vec<T> {
        assert_eq!(larger.intersection(self), Some(*self), "a part of {larger}");
        let [left, top] = [self.left - larger.left, self.top - larger.top];
        let there = Self { left, top, ..*self };
        let rows = there.rows(larger.width as usize);
        rows.flat_map(|(there, _)| &plane[there]).copied().collect()
    }

    /// Pixels in it.
    pub fn pixels(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }
}

impl Display for Window {
    /// As it is parsed: `left,top,widthxheight`.
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{},{},{}x{}", self.left, self.top, self.width, self.height)
    }
}

impl FromStr for Window {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parse = || {
            let (left, rest) = text.split_once(',')?;
            let (top, size) = rest.split_once(',')?;
            let (width, height) = size.split_once(['x', 'X'])?;
            let number = |text: &str| text.trim().parse::<u32>().ok();
            let (width, height) = (number(width)?, number(height)?);
            let window = Self { left: number(left)?, top: number(top)?, width, height };
            (width > 0 && height > 0).then_some(window)
        };
        parse().ok_or_else(|| {
            "give the upper left pixel and the size as 320,180,640x360, counted from 0".into()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_goes_both_ways() {
        let window = Window { left: 3, top: 0, width: 20, height: 7 };
        assert_eq!(window.to_string().parse(), Ok(window));
        for bad in ["", "1,2", "1,2,3", "1,2,0x4", "-1,2,3x4", "1,2,3x4x5", "1;2;3x4"] {
            assert!(bad.parse::<Window>().is_err(), "{bad}");
        }
    }

    #[test]
    fn two_windows_have_pixels_in_common_or_not() {
        let window = Window { left: 3, top: 1, width: 5, height: 2 };
        let other = Window { left: 6, top: 2, width: 9, height: 9 };
        let common = Window { left: 6, top: 2, width: 2, height: 1 };
        assert_eq!(window.intersection(&other), Some(common));
        assert_eq!(window.intersection(&Window { left: 8, ..other }), None);
    }

    #[test]
    fn rows_lie_where_the_window_does() {
        let window = Window { left: 3, top: 1, width: 2, height: 2 };
        let rows: Vec<_> = window.rows(8).collect();
        assert_eq!(rows, [(11..13, 0..2), (19..21, 2..4)]);
    }

    #[test]
    fn windows_are_cut_out_of_larger_ones() {
        let larger = Window { left: 2, top: 5, width: 4, height: 3 };
        let plane: Vec<u32> = (0..12).collect();
        let window = Window { left: 3, top: 6, width: 2, height: 2 };
        assert_eq!(window.cut(&plane, larger), [5, 6, 9, 10]);
        assert_eq!(larger.cut(&plane, larger), plane);
        assert_eq!(window.grown(1, [5, 9]), Window { left: 2, top: 5, width: 3, height: 4 });
        assert_eq!(window.grown(u32::MAX, [5, 9]), Window::whole([5, 9]));
    }

    #[test]
    fn a_window_lies_on_the_film_or_not() {
        let window = Window { left: 3, top: 1, width: 5, height: 2 };
        assert!(window.fits([8, 3]));
        assert!(!window.fits([7, 3]) && !window.fits([8, 2]));
        assert!(!Window { left: u32::MAX, ..window }.fits([8, 3]));
    }
}
