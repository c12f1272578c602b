//! Pages, plots and quoted figures are those that the records of measurements give.

use std::collections::BTreeMap;
use std::fs;

use crate::documents::documents;
use crate::marked::MarkedText;
use crate::pages::equal_error::{front, time_to};
use crate::pages::strategy::{self, Comparison, Figures};
use crate::pages::{PAGES, Places, quoted};

#[test]
fn every_measurement_has_a_record() {
    let places = Places::checked_in();
    for page in &PAGES {
        assert!(places.record(page.name).unwrap().is_some(), "{}.json is missing", page.name);
    }
}

#[test]
fn what_is_checked_in_is_what_the_records_give() {
    for (path, text) in Places::checked_in().rendered().unwrap() {
        let there = fs::read_to_string(&path).unwrap_or_default();
        assert!(
            there == text,
            "{} is not what its record gives: run cargo bench --bench results -- --render",
            path.display()
        );
    }
}

#[test]
fn quoted_figures_are_those_measured() {
    let measured = quoted::figures(&Places::checked_in()).unwrap();
    for path in documents() {
        let text = MarkedText::new(&fs::read_to_string(&path).unwrap()).unwrap();
        let wrong = text.differing(&measured);
        assert!(wrong.is_empty(), "{}: {}", path.display(), wrong.join("; "));
    }
}

#[test]
fn no_figure_of_speed_or_error_stands_in_prose_unmarked() {
    for path in documents() {
        let text = MarkedText::new(&fs::read_to_string(&path).unwrap()).unwrap();
        let found = text.unmarked();
        assert!(
            found.is_empty(),
            "{}: mark as a figure of readme.json, or as given:\n{}",
            path.display(),
            found.join("\n")
        );
    }
}

#[test]
fn a_quoted_figure_that_differs_or_is_unknown_is_told() {
    let measured = BTreeMap::from([("a.b".to_owned(), "2.3".to_owned())]);
    let differing = |text: &str| MarkedText::new(text).unwrap().differing(&measured);
    assert!(differing("is <!-- figure a.b -->2.3<!-- / --> times as fast").is_empty());
    assert_eq!(differing("<!-- figure a.b -->2.4<!-- / -->"), ["a.b is 2.3 and not 2.4"]);
    assert_eq!(differing("<!-- figure a.c -->2.3<!-- / -->"), ["a.c was not measured"]);
    assert!(MarkedText::new("<!-- figure a.b -->2.3").is_err());
}

#[test]
fn figures_of_speed_and_error_are_found_where_they_are_not_marked() {
    let found = |text: &str| MarkedText::new(text).unwrap().unmarked().len();
    for text in [
        "fogbow is 2.4 times as fast",
        "fogbow is 2.4\ntimes as fast",
        "an error of 0.03 %, at most",
        "takes 5% of it",
        "took (12 CPU s)",
        "<!-- a comment --> 1.5 times",
    ] {
        assert_eq!(found(text), 1, "{text}");
    }
    for text in [
        "<!-- figure a -->2.4<!-- / --> times as fast",
        "of 64 <!-- figure a -->2.4<!-- / --> times as fast",
        "at most <!-- given -->5 %<!-- / --> of the time",
        "many times, with 16 rays a pixel",
        "`--rays 16 %` in code",
        "```sh\necho 5 %\n```",
        "    indented 5 % code",
        "100 \u{d7} 100 pixels, 20 seconds",
    ] {
        assert_eq!(found(text), 0, "{text}");
    }
}

#[test]
fn times_to_an_error_lie_on_lines_between_logarithms() {
    // The second point is no better than the first, and so no part of the curve.
    let curve = [(1.0, 1.0), (2.0, 1.5), (4.0, 0.01)];
    assert_eq!(front(&curve), [(1.0, 1.0), (4.0, 0.01)]);
    let faster = |error: f64| time_to(&curve, error).unwrap().faster_than(8.0).to_string();
    assert_eq!(faster(0.1), "4.0"); // after 2 s
    assert_eq!(faster(2.0), "> 8.0"); // sooner than the cheapest
    assert_eq!(faster(0.001), "< 2.0"); // later than the dearest
    assert!(time_to(&[], 1.0).is_none());
}

#[test]
fn a_regret_passes_by_the_lower_end_of_its_interval() {
    let comparison = |regret, interval| Comparison {
        best: "beams".into(),
        compared: [Figures { error: 0.5, seconds: 2.0 }; 2],
        regret,
        interval,
    };
    let row = |scene: &str, regret, interval| strategy::Row {
        scene: scene.into(),
        reference_rays: 1,
        reference_error: 0.0,
        is_reference_enough: true,
        candidates: Vec::new(),
        trimmed: comparison(regret, interval),
        of_all_pixels: Some(comparison(1.0, [0.9, 1.2])),
    };
    let page = strategy::tables(&[row("a", 1.0, [0.9, 1.1]), row("b", 4.0, [1.25, 9.0])]);
    assert!(
        page.contains("1 of 2 scenes pass; the geometric mean of the regrets is 2.00"),
        "{page}"
    );
    let rest = "the largest is 4.00, of b. By the errors of all pixels 2 pass.";
    assert!(page.contains(rest), "{page}");
}
