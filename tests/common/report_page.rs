//! What the page of a study must show.

use fogbow::image::{View, ViewTransform};
use fogbow::math::Rgb;
use serde_json::json;

use super::chromium::Browser;
use super::page::{SIZES, bounds};

/// Sentence, numbers and plot are on the first screen, the legend is beside the plot, and no more
/// than seven hues are drawn.
pub fn assert_answered_at_once(browser: &mut Browser) {
    for selector in ["#sentence", "#numbers", "#plot #data", "#plot svg", "#legend"] {
        let [left, top, right, bottom] = bounds(browser, selector);
        assert!(
            left >= 0.0 && top >= 0.0 && right <= 1400.0 && bottom <= 900.0,
            "{selector}: {bottom}"
        );
        assert!(right > left && bottom > top, "{selector} is not seen");
    }
    let sentence = browser.evaluate("$('sentence').textContent");
    assert!(sentence.as_str().unwrap().contains("xs-error"), "{sentence}");
    for (width, height) in SIZES {
        browser.resize(width, height);
        let [data, legend] = ["#plot #data", "#legend"].map(|selector| bounds(browser, selector));
        let apart =
            |low: usize, high: usize| data[high] <= legend[low] || legend[high] <= data[low];
        assert!(apart(0, 2) || apart(1, 3), "the legend lies over the data at {width}");
    }
    browser.resize(1400, 900);
    browser.evaluate(
        "[...Array(12).keys()].forEach((i) => choose(`other ${i}`, true)); drawPlot(); 0",
    );
    let hues = "new Set([...hueOf.values()]).size";
    assert_eq!(browser.evaluate(hues), json!(7));
    let drawn = "new Set([...document.querySelectorAll('#plot .chosen')].map((g) => getComputedStyle(g).stroke)).size";
    assert!(browser.evaluate(drawn).as_u64().unwrap() <= 8, "seven hues, and ink for gold");
}

/// The viewer's AgX is the one that `fogbow render` shows pictures with.
pub fn assert_shown_as_film(browser: &mut Browser) {
    assert_eq!(browser.evaluate("VIEW.transform"), json!("agx"));
    let view = View { exposure: 0.0, transform: ViewTransform::Agx };
    for radiance in [[0.18, 0.18, 0.18], [4.0, 0.1, 0.02], [0.001, 0.3, 2.0], [60.0, 50.0, 0.0]] {
        let script =
            format!("agx({radiance:?}).map((v) => 255 * encode(Math.min(1, Math.max(0, v))))");
        let told = browser.evaluate(&script);
        let expected = view.develop(Rgb::from_array(radiance));
        for c in 0..3 {
            let off = told[c].as_f64().unwrap() - f64::from(expected[c]);
            assert!(off.abs() <= 0.51, "{radiance:?}: {told} of {expected:?}");
        }
    }
}
