//! The pages in a real browser: they load without a complaint, and work. Skipped, with a message,
//! where there is no Chromium. Screenshots are left in Cargo's folder for tests' files.

#![allow(clippy::print_stderr)] // skipped tests say so

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use fogbow::verify::{
    Case, Check, Effort, Group, Parts, cases, page as verify_page, run as run_cases,
};
use serde_json::{Value, json};

use crate::chromium::Browser;
use crate::page;
use crate::report_page;

/// Pictures of the pages, to be looked at.
fn shot(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.png"))
}

fn fogbow(folder: &Path, args: &[&str]) -> Command {
    let mut command = Command::new(assert_cmd::cargo::cargo_bin!("fogbow"));
    command.current_dir(folder).args(args);
    command
}

fn run(folder: &Path, args: &[&str]) -> String {
    let told = fogbow(folder, args).output().unwrap();
    assert!(told.status.success(), "{}", String::from_utf8_lossy(&told.stderr));
    String::from_utf8(told.stdout).unwrap()
}

fn shipped(name: &str) -> String {
    format!("{}/volumes/{name}", env!("CARGO_MANIFEST_DIR"))
}

fn address(path: &Path) -> String {
    format!("file://{}", path.display())
}

fn assert_content(browser: &Browser, own: &str) {
    let (errors, addresses) = browser.complaints();
    assert!(errors.is_empty(), "{errors:#?}");
    let foreign: Vec<_> = addresses.iter().filter(|a| !a.starts_with(own)).collect();
    assert!(foreign.is_empty(), "the page reaches out: {foreign:?}");
}

/// Numbers in a column of the table of candidates, those without one left out.
fn column(browser: &mut Browser, index: usize) -> Vec<f64> {
    let script = format!(
        "[...document.querySelectorAll('#candidates tbody tr')]
         .map(row => Number.parseFloat(row.cells[{index}].dataset.sort ?? 'x'))
         .filter(value => !Number.isNaN(value))"
    );
    let told = browser.evaluate(&script);
    told.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

/// What the viewer shows.
fn shown(browser: &mut Browser) -> Value {
    browser.evaluate("canvas.toDataURL()")
}

#[test]
fn the_report_of_a_study_works() {
    let Some(mut browser) = Browser::start(1400, 900) else { return };
    let folder = tempfile::tempdir().unwrap();
    let candidates = "fixed,photons,x-transmittance,xs-error";
    run(
        folder.path(),
        &[
            &["study", &shipped("smoke.toml"), "-o", "out", "--quiet"][..],
            &["--size", "48x48", "--photons", "20000", "--rays", "8", "--reference", "64"],
            &["--budgets", "8,2", "--seeds", "2", "--candidates", candidates],
        ]
        .concat(),
    );
    let page = address(&folder.path().join("out/report.html"));
    let drawn = "state.shown.every(Boolean)";
    page::check(&mut browser, &page, drawn, "report", shot);
    browser.prefer("light");
    browser.resize(1400, 900);
    browser.open(&page);
    browser.wait_for(drawn);
    report_page::assert_answered_at_once(&mut browser);
    report_page::assert_shown_as_film(&mut browser);

    // Sorting: up by the first click on a heading, down by the second.
    for (heading, index) in [(3, 2), (5, 4)] {
        let selector = format!("#candidates th:nth-child({heading})");
        browser.click(&selector);
        let rising = column(&mut browser, index);
        assert!(rising.len() > 5 && rising.is_sorted(), "{rising:?}");
        browser.click(&selector);
        let falling = column(&mut browser, index);
        assert!(falling.iter().rev().is_sorted(), "{falling:?}");
    }

    // Sliding: the edge follows the pointer.
    let [x, y] = browser.place("#canvas");
    browser.mouse("mouseMoved", [x - 200.0, y]);
    let left = (browser.evaluate("state.edge"), shown(&mut browser));
    browser.mouse("mouseMoved", [x + 200.0, y]);
    let right = (browser.evaluate("state.edge"), shown(&mut browser));
    assert!(left.0.as_f64() < right.0.as_f64() && left.1 != right.1, "{left:?} {right:?}");
    browser.wait_for("$('readout').textContent.startsWith('Pixel')");
    browser.screenshot(&shot("report-slide"), false);

    // Zooming: what is under the pointer stays there.
    let under = "[(420 - state.x) / state.zoom, (300 - state.y) / state.zoom]";
    browser.place("#canvas");
    let corner = browser.evaluate("(r => [r.x, r.y])(canvas.getBoundingClientRect())");
    let at = [0, 1].map(|i| corner[i].as_f64().unwrap() + [420.0, 300.0][i]);
    let before = (browser.evaluate("state.zoom"), browser.evaluate(under));
    browser.wheel(at, -400.0);
    browser.wait_for(&format!("state.zoom > {}", before.0.as_f64().unwrap() * 1.9));
    let after = browser.evaluate(under);
    for i in [0, 1] {
        let moved = after[i].as_f64().unwrap() - before.1[i].as_f64().unwrap();
        assert!(moved.abs() < 0.5, "{before:?} {after:?}");
    }

    // Panning, exposure and false colour.
    let place = browser.evaluate("state.x").as_f64().unwrap();
    browser.mouse("mousePressed", at);
    browser.mouse("mouseMoved", [at[0] + 60.0, at[1]]);
    browser.mouse("mouseReleased", [at[0] + 60.0, at[1]]);
    let panned = browser.evaluate("state.x").as_f64().unwrap();
    assert!((panned - place - 60.0).abs() < 1.0, "{place} {panned}");
    let plain = shown(&mut browser);
    browser.evaluate("$('exposure').value = 2; $('exposure').dispatchEvent(new Event('input')); 0");
    browser.wait_for("$('stops').value === '2 stops'");
    browser.evaluate("new Promise(resolve => setTimeout(resolve, 100))");
    let bright = shown(&mut browser);
    browser.click("#false");
    browser.evaluate("new Promise(resolve => setTimeout(resolve, 100))");
    let coloured = shown(&mut browser);
    assert!(plain != bright && bright != coloured);
    browser.screenshot(&shot("report-false-colour"), false);

    // Flipping, and back to the whole picture.
    browser.click("#reset");
    browser.click("#flip");
    assert_eq!(browser.evaluate("[mode(), state.second]"), json!(["flip", true]));
    let second = shown(&mut browser);
    browser.click("#flip");
    assert_eq!(browser.evaluate("state.second"), json!(false));
    assert_ne!(shown(&mut browser), second);
    browser.click("#canvas");
    assert_eq!(shown(&mut browser), second, "a click on the picture flips");

    // By keyboard: the edge by the arrows, pictures by the space bar.
    browser.evaluate("document.querySelector('input[value=slide]').click(); canvas.focus(); 0");
    let edge = browser.evaluate("state.edge").as_f64().unwrap();
    browser.press("ArrowLeft");
    let moved = browser.evaluate("state.edge").as_f64().unwrap();
    assert!((edge - moved - 0.02).abs() < 1e-9, "{edge} {moved}");
    browser.press(" ");
    assert_eq!(browser.evaluate("mode()"), json!("flip"));

    browser.click("#all");
    for (name, selector) in [
        ("table", "#candidates tbody tr:nth-child(6)"),
        ("ablation", "#ablation"),
        ("cards", ".panels"),
    ] {
        browser.place(selector);
        browser.screenshot(&shot(&format!("report-{name}")), false);
    }
    assert_content(&browser, &page);
}

#[test]
fn the_page_of_verify_works() {
    let Some(mut browser) = Browser::start(1400, 900) else { return };
    let folder = tempfile::tempdir().unwrap();
    // Of every group, and two that fail.
    let words = ["made for this test", "nothing"];
    let wrong = |name: &str, found: f64| {
        Case::new(Group::Matrix, name, words, move |_: &Parts| {
            Ok(vec![Check::at_most("number", found, 1.0)])
        })
    };
    let chosen = ["beer-lambert", "phase", "stiff", "matrix/lamps"];
    let mut all = cases(Effort::Quick);
    all.retain(|case| chosen.iter().any(|prefix| case.name.starts_with(prefix)));
    all.push(wrong("made/off", 1.4));
    all.push(wrong("made/far-off", f64::INFINITY).at("made", "row".into(), "column".into()));
    let outcomes = run_cases(&all, &Parts::fogbow(), |_| ());
    let path = folder.path().join("verify.html");
    std::fs::write(&path, verify_page(&outcomes, "fogbow verify --quick").unwrap()).unwrap();
    let url = address(&path);
    page::check(&mut browser, &url, "true", "verify", shot);

    browser.resize(1400, 900);
    browser.open(&url);
    let first = browser.evaluate(
        "[...document.querySelectorAll('.case')].slice(0, 3).map((c) => c.className + c.open)",
    );
    assert_eq!(first, json!(["case badtrue", "case badtrue", "casefalse"]), "failures first");
    browser.evaluate("document.querySelectorAll('details').forEach((d) => { d.open = true; }); 0");
    // The pass mark: what holds ends before it, what fails beyond.
    let beyond = browser.evaluate(
        "[...document.querySelectorAll('.case')].every((c) => {
           const track = c.querySelector('.track').getBoundingClientRect();
           const bar = c.querySelector('.track i').getBoundingClientRect();
           const share = (bar.right - track.left) / track.width;
           return c.classList.contains('bad') ? share > 0.8 : share < 0.81; })",
    );
    assert_eq!(beyond, json!(true));
    let mark =
        browser.evaluate("getComputedStyle(document.querySelector('.track'), '::after').left");
    assert_ne!(mark, json!("auto"), "the mark is drawn");
    for selector in ["#sentence", "#strip"] {
        let [_, top, _, bottom] = page::bounds(&mut browser, selector);
        assert!(top >= 0.0 && bottom <= 900.0, "{selector}: {top} to {bottom}");
    }
    assert_content(&browser, &url);
}

/// A running `fogbow trial --serve`, ended with the test.
struct Served(Child);

impl Served {
    fn start(folder: &Path) -> (Self, String) {
        let mut command = fogbow(folder, &["trial", "-o", "out", "--serve", "--quiet"]);
        let mut child = command.stdout(Stdio::piped()).spawn().unwrap();
        let mut url = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut url).unwrap();
        (Self(child), url.trim().to_owned())
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

const STATE: &str = "document.body.dataset.state";

/// Pictures on the stage.
const PICTURES: &str = "document.querySelectorAll('#stage img').length";

/// One person's session in this condition. The first answer is right, the others are wrong.
fn session(browser: &mut Browser, condition: &str, who: &str) {
    browser.wait_for(&format!("{STATE} === 'start'"));
    browser.screenshot(&shot("trial-start"), false);
    browser.evaluate(&format!(
        "$('condition').value = '{condition}'; $('participant').value = '{who}'; 0"
    ));
    browser.stop_time();
    browser.click("#begin");
    for scene in 0..2 {
        let now = |browser: &mut Browser| browser.evaluate(&format!("[{STATE}, {PICTURES}]"));
        browser.wait_for(&format!("{PICTURES} > 0")); // decoded, in time that is not the page's
        if condition == "successive" {
            browser.pass(3900);
            assert_eq!(now(browser), json!(["stage", 1]), "four seconds of one");
            let first = browser.evaluate("document.querySelector('#stage img').src");
            browser.screenshot(&shot("trial-successive"), false);
            browser.pass(200);
            assert_eq!(now(browser), json!(["stage", 0]), "two seconds of grey");
            browser.screenshot(&shot("trial-grey"), false);
            browser.pass(1800);
            assert_eq!(now(browser), json!(["stage", 0]));
            browser.pass(200);
            assert_eq!(now(browser), json!(["stage", 1]), "four seconds of the other");
            assert_ne!(first, browser.evaluate("document.querySelector('#stage img').src"));
            browser.pass(3800);
            assert_eq!(now(browser), json!(["stage", 1]));
            browser.pass(200);
        } else {
            browser.pass(7900);
            assert_eq!(now(browser), json!(["stage", 3]), "eight seconds of all");
            let sources = "[...document.querySelectorAll('#stage img')].map(i => i.src)";
            let told = browser.evaluate(&format!(
                "(([top, left, right]) => [top === left || top === right, left !== right])({sources})"
            ));
            assert_eq!(told, json!([true, true]), "gold on top, both below");
            browser.screenshot(&shot("trial-reference"), false);
            browser.pass(200);
        }
        assert_eq!(now(browser), json!(["question", 0]));
        browser.screenshot(&shot("trial-question"), false);
        browser.pass(1500); // thinking
        let right = "CONDITIONS[session.condition].sides.indexOf(session.trial.gold)";
        let chosen = browser.evaluate(&format!("({right} + {scene}) % 2"));
        // The first by a click, the second by its key.
        match (scene, chosen == json!(0)) {
            (0, true) => browser.click("#a"),
            (0, false) => browser.click("#b"),
            (_, true) => browser.press("ArrowLeft"),
            (_, false) => browser.press("2"),
        }
        browser.pass(100);
        let next = if scene == 0 { "pause" } else { "done" };
        browser.wait_for(&format!("{STATE} === '{next}'"));
        if scene == 0 {
            browser.screenshot(&shot("trial-pause"), false);
            browser.click("#next");
        }
    }
    browser.screenshot(&shot("trial-done"), false);
}

#[test]
fn a_trial_runs_through_to_its_answers() {
    let Some(mut browser) = Browser::start(1280, 900) else { return };
    let folder = tempfile::tempdir().unwrap();
    let scenes = [shipped("smoke.toml"), shipped("balls_a.toml")];
    let [smoke, balls] = scenes.each_ref().map(String::as_str);
    let quick = ["--size", "320x240", "--photons", "5000", "--rays", "4"];
    run(folder.path(), &[&["trial", smoke, balls, "-o", "out", "--quiet"][..], &quick].concat());

    let (served, url) = Served::start(folder.path());
    browser.open(&url);
    session(&mut browser, "successive", "ann");
    assert_eq!(browser.evaluate("$('kept').textContent"), json!("Your answers are stored."));
    assert_content(&browser, &url);
    // Time that was stopped stays so: another browser.
    let mut browser = Browser::start(1280, 900).unwrap();
    browser.open(&url);
    session(&mut browser, "reference", "bob");
    assert_content(&browser, &url);
    drop(served);
    let told = run(folder.path(), &["trial", "--analyse", "out/answers.csv", "--json"]);
    let told: Value = serde_json::from_str(&told).unwrap();
    let tallies = told["tallies"].as_array().unwrap();
    let right: u64 = tallies.iter().map(|t| t["right"].as_u64().unwrap()).sum();
    assert_eq!((tallies.len(), right), (4, 2), "{told}");
    let text = std::fs::read_to_string(folder.path().join("out/answers.csv")).unwrap();
    let seconds = text.lines().nth(1).unwrap().split(',').nth(5).unwrap();
    assert!((1.5..2.0).contains(&seconds.parse::<f64>().unwrap()), "{text}");

    // As a file: the answers are offered for download.
    let page = address(&folder.path().join("out/trial.html"));
    let mut browser = Browser::start(1280, 900).unwrap();
    page::check(&mut browser, &page, &format!("{STATE} === 'start'"), "trial", shot);
    let grey = "getComputedStyle(document.documentElement).backgroundColor";
    assert_eq!(
        browser.evaluate(grey),
        json!("rgb(128, 128, 128)"),
        "neutral in the dark scheme too"
    );
    assert!(
        browser.evaluate("document.body.innerText").as_str().unwrap().contains("Participant ID")
    );
    for state in ["question", "pause", "done"] {
        browser.evaluate(&format!(
            "session = {{ condition: 'successive', answers: [], trial: {{}} }}; ask(); turnTo('{state}'); 0"
        ));
        for (width, height) in page::SIZES {
            browser.resize(width, height);
            browser.screenshot(&shot(&format!("trial-{state}-{width}")), false);
            page::assert_fits(&mut browser, state);
            page::assert_legible(&mut browser, state);
        }
    }
    browser.resize(1280, 900);
    browser.open(&page);
    session(&mut browser, "successive", "a, \"b\"");
    let text = browser.evaluate("fetch($('download').href).then(reply => reply.text())");
    std::fs::write(folder.path().join("mine.csv"), text.as_str().unwrap()).unwrap();
    let told = run(folder.path(), &["trial", "--analyse", "mine.csv", "out/answers.csv", "--json"]);
    let told: Value = serde_json::from_str(&told).unwrap();
    assert_eq!(told["answers"], 6);
    assert_content(&browser, &page);

    // A window that cannot show every pixel says so.
    let mut browser = Browser::start(600, 500).unwrap();
    browser.open(&page);
    browser.wait_for(&format!("{STATE} === 'start'"));
    assert_eq!(browser.evaluate("$('small').hidden"), json!(false));
}
