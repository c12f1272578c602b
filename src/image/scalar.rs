//! Scalar maps as pictures: false colours, a title, a labelled scale; several on one sheet.

use super::palette::viridis;
use super::picture::{LINE, Picture, text_width};

const PAPER: [u8; 3] = [24; 3];
const INK: [u8; 3] = [235; 3];
/// Pixels between the parts of a panel and between panels.
const GAP: usize = 8;
/// Height of the scale.
const SCALE: usize = 12;
/// Width of a panel at least, so that three labels stand side by side.
const NARROWEST: usize = 256;

/// One number a pixel, to be shown.
#[derive(Debug, Clone, Copy)]
pub struct ScalarMap<'a> {
    /// The title, with the unit where there is one.
    pub name: &'a str,
    /// Pixels in a row.
    pub width: usize,
    /// The values, row by row from the top.
    pub values: &'a [f32],
    /// The value at the dark end of the scale, and that at the bright end.
    pub range: [f32; 2],
}

impl<'a> ScalarMap<'a> {
    /// A map whose range is that of its finite values; 0 to 1 where there are none.
    pub fn fitted(name: &'a str, width: usize, values: &'a [f32]) -> Self {
        let finite = values.iter().copied().filter(|v| v.is_finite());
        let range = finite.fold(None, |range: Option<[f32; 2]>, v| {
            let [lo, hi] = range.unwrap_or([v; 2]);
            Some([lo.min(v), hi.max(v)])
        });
        Self { name, width, values, range: range.unwrap_or([0.0, 1.0]) }
    }

    /// The map alone in viridis; what is not finite is grey, what is out of range is clipped.
    ///
    /// # Panics
    /// Where there are no values or they don't fill whole rows.
    pub fn colored(&self) -> Picture {
        assert!(self.width > 0, "a row has at least one pixel");
        assert_eq!(self.values.len() % self.width, 0, "whole rows of {} values", self.width);
        let mut picture = Picture::filled(self.width, self.values.len() / self.width, PAPER);
        for (i, &v) in self.values.iter().enumerate() {
            picture.set(i % self.width, i / self.width, viridis(self.part(v)));
        }
        picture
    }

    /// The map under its name and over its scale, which is labelled at both ends and in the middle.
    ///
    /// # Panics
    /// As [`colored`](Self::colored).
    pub fn panel(&self) -> Picture {
        let map = titled(self.name, &self.colored());
        let top = map.height() + GAP;
        let mut panel = Picture::filled(map.width(), top + SCALE + LINE + 2, PAPER);
        panel.paste(&map, 0, 0);
        let end = map.width() - 1;
        for x in 0..=end {
            let color = viridis(x as f64 / end as f64);
            (top..top + SCALE).for_each(|y| panel.set(x, y, color));
        }
        let [lo, hi] = self.range.map(f64::from);
        let labels = [lo, lo + (hi - lo) / 2.0, hi].map(number);
        for (i, label) in labels.iter().enumerate() {
            let x = i * (map.width() - text_width(label)) / 2;
            panel.write_text(x, top + SCALE + 2, label, INK);
        }
        panel
    }

    /// Where `v` lies between the ends of the scale, 0 to 1; a scale of one value has it at 0.
    fn part(&self, v: f32) -> f64 {
        let [lo, hi] = self.range.map(f64::from);
        let v = f64::from(v);
        if v.is_finite() && hi <= lo { 0.0 } else { (v - lo) / (hi - lo) }
    }
}

/// `picture` under a title.
pub fn titled(title: &str, picture: &Picture) -> Picture {
    let width = picture.width().max(text_width(title)).max(NARROWEST);
    let mut panel = Picture::filled(width, LINE + GAP / 2 + picture.height(), PAPER);
    panel.write_text(0, 0, title, INK);
    panel.paste(picture, 0, LINE + GAP / 2);
    panel
}

/// All `panels` in reading order on one sheet, `columns` side by side, in cells of the size of the
/// largest.
///
/// # Panics
/// Where there are no panels or no columns.
pub fn contact_sheet(panels: &[Picture], columns: usize) -> Picture {
    assert!(!panels.is_empty() && columns > 0, "a sheet has something on it");
    let columns = columns.min(panels.len());
    let largest = |size: fn(&Picture) -> usize| panels.iter().map(size).fold(0, usize::max) + GAP;
    let (width, height) = (largest(Picture::width), largest(Picture::height));
    let rows = panels.len().div_ceil(columns);
    let mut sheet = Picture::filled(columns * width + GAP, rows * height + GAP, PAPER);
    for (i, panel) in panels.iter().enumerate() {
        sheet.paste(panel, GAP + i % columns * width, GAP + i / columns * height);
    }
    sheet
}

/// Four significant digits without trailing zeros, with an exponent where that is shorter.
fn number(v: f64) -> String {
    if v != 0.0 && !(1e-3..1e5).contains(&v.abs()) {
        return format!("{v:.2e}");
    }
    let whole = if v == 0.0 { 0 } else { v.abs().log10().floor() as i32 };
    let decimals = (3 - whole).max(0) as usize;
    let text = format!("{v:.decimals$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::palette::NOT_FINITE;

    #[test]
    fn numbers_are_short() {
        let shown = [0.0, 1.0, 0.5, -0.25, 1234.5, 0.012_345, 1e-9, 3e7, 99_999.4].map(number);
        let expected = ["0", "1", "0.5", "-0.25", "1234", "0.01235", "1.00e-9", "3.00e7", "99999"];
        assert_eq!(shown, expected);
    }

    #[test]
    fn values_take_their_colours() {
        let values = [0.0, 1.0, 2.0, f32::NAN, f32::INFINITY, -5.0];
        let map = ScalarMap { name: "X", width: 3, values: &values, range: [0.0, 2.0] };
        let picture = map.colored();
        let row = |y| [0, 1, 2].map(|x| picture.get(x, y).unwrap());
        assert_eq!(row(0), [viridis(0.0), viridis(0.5), viridis(1.0)]);
        assert_eq!(row(1), [NOT_FINITE, NOT_FINITE, viridis(0.0)]);
    }

    #[test]
    fn any_map_has_a_panel() {
        for (width, values) in [
            (1, vec![3.0]),
            (2, vec![f32::NAN; 4]),
            (2, vec![f32::MAX, f32::MIN]),
            (700, vec![0.0; 700]),
        ] {
            let map = ScalarMap::fitted("a name", width, &values);
            assert!(map.range.iter().all(|v| v.is_finite()));
            let panel = map.panel();
            assert!(panel.width() >= width && panel.height() > values.len() / width);
        }
    }

    #[test]
    fn a_sheet_holds_every_panel() {
        let colors = [[200, 0, 0], [0, 200, 0], [0, 0, 200]];
        let sheet = contact_sheet(&colors.map(|c| Picture::filled(10, 20, c)), 2);
        assert_eq!((sheet.width(), sheet.height()), (2 * 18 + 8, 2 * 28 + 8));
        let corners = [(8, 8), (26, 8), (8, 36)].map(|(x, y)| sheet.get(x, y).unwrap());
        assert_eq!(corners, colors);
    }
}
