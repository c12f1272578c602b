//! What must be true of every page: it fits a telephone, is legible in light and dark, and every
//! control is reached by the Tab key.

use std::path::Path;

use serde_json::{Value, json};

use super::chromium::Browser;

/// Windows that pages are made for: a desk and a telephone.
pub const SIZES: [(u32, u32); 2] = [(1400, 900), (390, 844)];

/// The least contrast of text (WCAG 2.2, success criterion 1.4.3).
const LEAST_CONTRAST: f64 = 4.5;

/// Text that is seen, with its contrast against the nearest background that is not transparent
/// (WCAG 2.2, relative luminance and contrast ratio).
const CONTRASTS: &str = "(() => {
  const parse = (color) => color.match(/[\\d.]+/g).map(Number);
  const linear = (v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
  const luminance = ([r, g, b]) => [[0.2126, r], [0.7152, g], [0.0722, b]]
    .reduce((sum, [weight, v]) => sum + weight * linear(v / 255), 0);
  const behind = (element) => {
    for (let e = element; e; e = e.parentElement) {
      const color = parse(getComputedStyle(e).backgroundColor);
      if (color.length < 4 || color[3] > 0) return color;
    }
    return [255, 255, 255];
  };
  const texts = [...document.querySelectorAll('body *')].filter((e) =>
    [...e.childNodes].some((n) => n.nodeType === 3 && n.data.trim())
    && !['SCRIPT', 'STYLE', 'OPTION', 'TITLE', 'title'].includes(e.tagName)
    && e.checkVisibility() && e.getClientRects().length > 0);
  return texts.map((e) => {
    const style = getComputedStyle(e);
    const front = parse(e instanceof SVGElement ? style.fill : style.color);
    const [high, low] = [luminance(front), luminance(behind(e))].sort((a, b) => b - a);
    return [(high + 0.05) / (low + 0.05), e.textContent.trim().slice(0, 40)];
  });
})()";

/// Controls that are seen and not switched off; of a group of radio buttons the chosen one.
const CONTROLS: &str = "[...document.querySelectorAll(
    'a[href], button, input, select, textarea, summary, [tabindex=\"0\"]')]
  .filter((e) => !e.disabled && e.checkVisibility() && (e.type !== 'radio' || e.checked))";

/// Opens `url` in every window and scheme, checks it and leaves screenshots, `shot` of a name each.
/// The page is whole where `ready` is true.
pub fn check(
    browser: &mut Browser,
    url: &str,
    ready: &str,
    name: &str,
    shot: impl Fn(&str) -> std::path::PathBuf,
) {
    for scheme in ["light", "dark"] {
        browser.prefer(scheme);
        for (width, height) in SIZES {
            browser.resize(width, height);
            browser.open(url);
            browser.wait_for(ready);
            browser.screenshot(&shot(&format!("{name}-{width}-{scheme}")), false);
            let whole: std::path::PathBuf = shot(&format!("{name}-{width}-{scheme}-whole"));
            browser.screenshot(Path::new(&whole), true);
            assert_fits(browser, name);
            assert_legible(browser, &format!("{name}, {scheme}"));
        }
    }
    assert_reached(browser, name);
}

/// Nothing is wider than the window.
pub fn assert_fits(browser: &mut Browser, name: &str) {
    let wide = browser.evaluate("[document.documentElement.scrollWidth, innerWidth]");
    assert!(wide[0].as_f64() <= wide[1].as_f64(), "{name} scrolls sideways: {wide}");
}

/// All text stands out from its background.
pub fn assert_legible(browser: &mut Browser, name: &str) {
    let told = browser.evaluate(CONTRASTS);
    let texts = told.as_array().unwrap();
    let faint = |text: &&Value| text[0].as_f64().is_none_or(|ratio| ratio < LEAST_CONTRAST);
    let faint: Vec<&Value> = texts.iter().filter(faint).collect();
    assert!(!texts.is_empty() && faint.is_empty(), "{name}: {faint:?}");
}

/// The Tab key reaches every control, and the ring that shows it is seen.
pub fn assert_reached(browser: &mut Browser, name: &str) {
    let count = browser.evaluate(&format!("{CONTROLS}.length")).as_u64().unwrap();
    assert!(count > 0, "{name} has no controls");
    browser.evaluate("document.activeElement.blur(); scrollTo(0, 0); 0");
    for _ in 0..2 * count {
        browser.press("Tab");
        let ring = browser.evaluate(
            "(e => { if (e === document.body) return true;
               e.dataset.reached = 1; return getComputedStyle(e).outlineStyle !== 'none'; })(document.activeElement)",
        );
        assert_eq!(ring, json!(true), "{name}: a focus that is not seen");
    }
    let missed = browser.evaluate(&format!(
        "{CONTROLS}.filter((e) => !e.dataset.reached).map((e) => e.outerHTML.slice(0, 80))"
    ));
    assert_eq!(missed, json!([]), "{name}");
}

/// The box of what `selector` finds: left, top, right, bottom.
pub fn bounds(browser: &mut Browser, selector: &str) -> [f64; 4] {
    let script = format!(
        "(r => [r.left, r.top, r.right, r.bottom])(document.querySelector({selector:?}).getBoundingClientRect())"
    );
    let told = browser.evaluate(&script);
    [0, 1, 2, 3].map(|i| told[i].as_f64().unwrap())
}
