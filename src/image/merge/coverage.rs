//! Whether windows fill a film, each pixel once.

use super::super::Window;

/// What is wrong with the windows of a film.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum CoverageError {
    /// Two windows have pixels in common.
    Overlap {
        /// Their indices, the smaller first.
        windows: [usize; 2],
        /// Those pixels.
        place: Window,
    },
    /// No window has these pixels, from the top.
    Gaps(Vec<Window>),
}

/// Checks that each pixel of a film of `size`, width and height, lies in one of `windows`, which all lie on it.
///
/// # Errors
/// The overlap that is nearest to the top, or where there is none all gaps.
pub fn check_coverage(size: [u32; 2], windows: &[Window]) -> Result<(), CoverageError> {
    let mut gaps: Vec<Window> = Vec::new();
    let bands = bands(size[1], windows);
    for band in bands.windows(2) {
        for [left, right] in band_gaps(size[0], band[0], windows)? {
            let gap = Window { left, top: band[0], width: right - left, height: band[1] - band[0] };
            let above = gaps.iter_mut().find(|above| {
                (above.left, above.width) == (gap.left, gap.width)
                    && above.top + above.height == gap.top
            });
            match above {
                Some(above) => above.height += gap.height,
                None => gaps.push(gap),
            }
        }
    }
    if gaps.is_empty() { Ok(()) } else { Err(CoverageError::Gaps(gaps)) }
}

/// The rows at which a window begins or ends, with those at which the film does: between two of them all rows are
/// covered in the same way.
fn bands(height: u32, windows: &[Window]) -> Vec<u32> {
    let ends = windows.iter().flat_map(|window| [window.top, window.top + window.height]);
    let mut rows: Vec<u32> = ends.chain([0, height]).collect();
    rows.sort_unstable();
    rows.dedup();
    rows
}

/// The first column of each gap in `row`, and the one after its last.
fn band_gaps(width: u32, row: u32, windows: &[Window]) -> Result<Vec<[u32; 2]>, CoverageError> {
    let is_there = |window: &Window| window.top <= row && row < window.top + window.height;
    let mut there: Vec<(usize, &Window)> =
        windows.iter().enumerate().filter(|(_, window)| is_there(window)).collect();
    there.sort_by_key(|(index, window)| (window.left, *index));
    let (mut gaps, mut end) = (Vec::new(), 0);
    for (at, &(index, window)) in there.iter().enumerate() {
        if window.left > end {
            gaps.push([end, window.left]);
        }
        // The windows before end where this one begins, or there is an overlap.
        let before = at.checked_sub(1).map(|before| there[before]);
        let common = before.and_then(|(other, before)| Some((other, before.intersection(window)?)));
        if let Some((other, place)) = common {
            let windows = [other.min(index), other.max(index)];
            return Err(CoverageError::Overlap { windows, place });
        }
        end = window.left + window.width;
    }
    if end < width {
        gaps.push([end, width]);
    }
    Ok(gaps)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn window(text: &str) -> Window {
        text.parse().unwrap()
    }

    fn check(windows: &[&str]) -> Result<(), CoverageError> {
        let windows: Vec<Window> = windows.iter().map(|text| window(text)).collect();
        check_coverage([10, 8], &windows)
    }

    #[test]
    fn windows_that_fill_the_film_once_are_right() {
        assert_eq!(check(&["0,0,10x8"]), Ok(()));
        assert_eq!(check(&["7,0,3x5", "0,3,7x5", "0,0,7x3", "7,5,3x3"]), Ok(()));
    }

    #[test]
    fn gaps_are_windows() {
        let gaps = |windows: &[&str]| {
            Err(CoverageError::Gaps(windows.iter().map(|w| window(w)).collect()))
        };
        assert_eq!(check(&[]), gaps(&["0,0,10x8"]));
        assert_eq!(check(&["0,0,7x8"]), gaps(&["7,0,3x8"]));
        // Two columns beside a window that ends between the rows of another.
        assert_eq!(check(&["0,0,4x3", "0,3,4x5", "6,0,4x8"]), gaps(&["4,0,2x8"]));
        assert_eq!(check(&["1,1,8x6"]), gaps(&["0,0,10x1", "0,1,1x6", "9,1,1x6", "0,7,10x1"]));
    }

    #[test]
    fn overlaps_name_both_windows_and_the_place() {
        let overlap =
            |windows, place| Err(CoverageError::Overlap { windows, place: window(place) });
        assert_eq!(check(&["0,0,10x8", "0,0,10x8"]), overlap([0, 1], "0,0,10x8"));
        assert_eq!(check(&["4,2,6x6", "0,0,5x8"]), overlap([0, 1], "4,2,1x6"));
        assert_eq!(check(&["0,0,10x4", "0,4,2x4", "1,5,9x3"]), overlap([1, 2], "1,5,1x3"));
    }

    proptest! {
        #[test]
        fn every_pixel_is_counted(
            sides in prop::collection::vec((0_u32..9, 0_u32..7, 1_u32..9, 1_u32..7), 0..5),
        ) {
            let fits = |w: &Window| w.fits([10, 8]);
            let windows: Vec<Window> = sides
                .into_iter()
                .map(|(left, top, width, height)| Window { left, top, width, height })
                .filter(fits)
                .collect();
            let mut counts = [0_u32; 80];
            let pixels = |w: &Window| w.rows(10).flat_map(|(film, _)| film).collect::<Vec<_>>();
            windows.iter().flat_map(&pixels).for_each(|pixel| counts[pixel] += 1);
            match check_coverage([10, 8], &windows) {
                Ok(()) => prop_assert!(counts.iter().all(|count| *count == 1)),
                Err(CoverageError::Overlap { windows: [a, b], place }) => {
                    prop_assert_eq!(windows[a].intersection(&windows[b]), Some(place));
                }
                Err(CoverageError::Gaps(gaps)) => {
                    gaps.iter().flat_map(&pixels).for_each(|pixel| counts[pixel] += 1);
                    prop_assert!(counts.iter().all(|count| *count == 1));
                }
            }
        }
    }
}
