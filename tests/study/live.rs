//! The page of `fogbow render --view`: in a browser while it renders, and as the server answers.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};
use serde_json::{Value, json};

use crate::chromium::Browser;
use crate::page;

/// Long enough for anything here on a busy machine.
const PATIENCE: Duration = Duration::from_secs(120);

/// `fogbow render` of smoke in `folder`.
fn render(folder: &Path, more: &[&str]) -> Command {
    let scene = format!("{}/volumes/smoke.toml", env!("CARGO_MANIFEST_DIR"));
    let mut command = Command::new(assert_cmd::cargo::cargo_bin!("fogbow"));
    command.current_dir(folder).args(["render", &scene, "-o", "out.exr", "--photons", "5000"]);
    command.args(more);
    command
}

/// A render with a page.
struct Viewed {
    child: Child,
    /// Host and port of the page.
    address: String,
}

impl Viewed {
    fn start(mut command: Command) -> Self {
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let mut messages = BufReader::new(child.stderr.take().unwrap());
        let mut line = String::new();
        messages.read_line(&mut line).unwrap();
        let address = line.strip_prefix("note: the picture is shown at http://");
        let address = address.unwrap_or_else(|| panic!("{line}")).trim_end().trim_end_matches('/');
        assert!(address.starts_with("127.0.0.1:"), "{line}");
        // Nobody else reads them.
        std::thread::spawn(move || std::io::copy(&mut messages, &mut std::io::sink()));
        Self { child, address: address.to_owned() }
    }

    /// Status, head and body of what is answered to a request with this `host`.
    fn ask_as(&self, request: &str, host: &str) -> (u16, String, Vec<u8>) {
        let mut stream = TcpStream::connect(&self.address).unwrap();
        write!(stream, "{request} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n").unwrap();
        let mut reply = Vec::new();
        stream.read_to_end(&mut reply).unwrap();
        let end = reply.windows(4).position(|bytes| bytes == b"\r\n\r\n").unwrap();
        let head = String::from_utf8(reply[..end].to_vec()).unwrap();
        (head.split(' ').nth(1).unwrap().parse().unwrap(), head, reply[end + 4..].to_vec())
    }

    fn ask(&self, request: &str) -> (u16, String, Vec<u8>) {
        self.ask_as(request, &self.address)
    }

    fn state(&self, seen: &str) -> Value {
        let (status, _, body) = self.ask(&format!("GET /state?seen={seen}"));
        assert_eq!(status, 200);
        serde_json::from_slice(&body).unwrap()
    }

    /// Follows the render as a page does, with a look at each picture, and returns all that was told, the last picture and
    /// what the program printed.
    fn follow(self) -> (Vec<Value>, Vec<u8>, Output) {
        let (mut told, mut seen) = (Vec::new(), String::new());
        loop {
            let state = self.state(&seen);
            let version = state["version"].to_string();
            let has_ended = !state["ended"].is_null();
            let mut picture = Vec::new();
            if version != "0" && (version != seen || has_ended) {
                picture = self.picture(&state, "beauty");
            }
            seen = version;
            told.push(state);
            if has_ended {
                return (told, picture, self.child.wait_with_output().unwrap());
            }
        }
    }

    /// A layer as the scene's own view has it.
    fn picture(&self, state: &Value, layer: &str) -> Vec<u8> {
        let (exposure, transform) =
            (&state["view"]["exposure"], state["view"]["transform"].as_str());
        let query = format!("layer={layer}&exposure={exposure}&transform={}", transform.unwrap());
        let (status, head, body) = self.ask(&format!("GET /picture?{query}"));
        assert_eq!(status, 200, "{}", String::from_utf8_lossy(&body));
        assert!(head.contains("Content-Type: image/png") && head.contains("X-Version: "), "{head}");
        body
    }
}

/// A render that ends with the test.
struct Running(Viewed);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.child.kill();
        let _ = self.0.child.wait();
    }
}

fn files(folder: &Path) -> [Vec<u8>; 2] {
    ["out.exr", "out.png"].map(|name| std::fs::read(folder.join(name)).unwrap())
}

#[test]
fn a_page_that_looks_on_changes_no_byte() {
    let folder = tempfile::tempdir().unwrap();
    let settings = ["--size", "96x64", "--rays", "256"];
    let alone = render(folder.path(), &[&settings[..], &["--quiet"]].concat()).output().unwrap();
    assert!(alone.status.success());
    let before = files(folder.path());
    let seen = render(folder.path(), &[&settings[..], &["--json", "--view"]].concat());
    let (told, picture, output) = Viewed::start(seen).follow();
    assert!(output.status.success());
    assert!(files(folder.path()) == before, "other bytes");
    assert!(picture == before[1], "the last picture is not the PNG");
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["complete"], true, "nothing but the report is on stdout");

    let versions: Vec<u64> = told.iter().map(|state| state["version"].as_u64().unwrap()).collect();
    assert!(versions.is_sorted() && versions.last().is_some_and(|last| *last >= 2), "{versions:?}");
    let stages: Vec<&Value> = told.iter().map(|state| &state["stage"]["name"]).collect();
    assert!(stages.contains(&&json!("rays")), "{stages:?}");
    let last = told.last().unwrap();
    assert_eq!([&last["ended"], &last["name"]], ["finished", "out.exr"]);
    assert_eq!((&last["size"], &last["error"]), (&json!([96, 64]), &Value::Null));
}

#[test]
fn a_render_to_a_stated_error_tells_what_it_reached() {
    let folder = tempfile::tempdir().unwrap();
    let command = render(folder.path(), &["--size", "48x32", "--error", "0.2", "--view"]);
    let (told, _, output) = Viewed::start(command).follow();
    assert!(output.status.success());
    let error = &told.last().unwrap()["error"];
    assert_eq!(error["goal"], "20 %");
    let reached = error["reached"].as_str().unwrap();
    let value: f64 = reached.split(' ').next().unwrap().parse().unwrap();
    assert!(value > 0.0 && value <= 20.0, "{reached}");
    assert!(error["rays"].as_u64().unwrap() >= 4, "{error}");
}

#[test]
fn nobody_but_this_machine_is_answered() {
    let folder = tempfile::tempdir().unwrap();
    let endless = ["--size", "32x24", "--rays", "1000000", "--quiet", "--view"];
    let Running(viewed) = &Running(Viewed::start(render(folder.path(), &endless)));
    for foreign in ["evil.example", "localhost", "127.0.0.1"] {
        for place in ["/", "/state", "/picture"] {
            assert_eq!(viewed.ask_as(&format!("GET {place}"), foreign).0, 403, "{foreign} {place}");
        }
    }
    let port = viewed.address.rsplit_once(':').unwrap().1;
    assert_eq!(viewed.ask_as("GET /", &format!("localhost:{port}")).0, 200);
    let (status, head, body) = viewed.ask("GET /");
    assert!(status == 200 && body.starts_with(b"<!doctype html>"));
    assert!(head.contains("Content-Security-Policy: default-src 'none'"), "{head}");
    assert!(head.contains("Cross-Origin-Resource-Policy: same-origin"), "{head}");
    let (status, _, body) = viewed.ask("HEAD /");
    assert!(status == 200 && body.is_empty());

    let begun = Instant::now();
    let mut state = viewed.state("");
    while state["version"] == 0 {
        assert!(begun.elapsed() < PATIENCE, "no picture comes");
        state = viewed.state("0");
    }
    assert!(viewed.picture(&state, "variance").starts_with(b"\x89PNG"));
    for (request, status) in [
        ("GET /picture?layer=none&exposure=0&transform=srgb", 404),
        ("GET /picture?layer=beauty&exposure=bright&transform=srgb", 400),
        ("GET /picture?layer=beauty&exposure=0&transform=film", 400),
        ("GET /picture?%ff&layer=%zz", 400),
        ("GET /out.exr", 404),
        ("GET /../Cargo.toml", 404),
        ("POST /", 405),
        ("PUT /state", 405),
        ("DELETE /picture", 405),
    ] {
        assert_eq!(viewed.ask(request).0, status, "{request}");
    }
}

#[test]
fn a_port_that_is_taken_is_told_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port().to_string();
    let output = render(folder.path(), &[&format!("--view={port}")]).output().unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), message.lines().count()), (Some(2), 1), "{message}");
    assert!(message.contains(&format!("port {port} cannot be had")), "{message}");
    assert!(!folder.path().join("out.exr").exists());
}

#[test]
fn a_word_behind_the_flag_is_told_where_it_belongs() {
    let folder = tempfile::tempdir().unwrap();
    for (word, right) in [("8080", "give --view=8080"), ("srgb", "--view-transform srgb")] {
        let output = render(folder.path(), &["--view", word]).output().unwrap();
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), message.lines().count()), (Some(2), 1), "{message}");
        assert!(message.contains(right), "{message}");
    }
}

/// Pictures of the page, to be looked at.
fn shot(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.png"))
}

/// Number of the picture that the page shows.
const VERSION: &str = "Number(document.body.dataset.version ?? 0)";

/// Waits until a picture that was asked for with `query` is shown; all its bytes, red, green, blue and alpha.
fn shown(browser: &mut Browser, query: &str) -> Vec<f64> {
    browser.wait_for(&format!("(document.body.dataset.shown ?? '').includes({query:?})"));
    // Of a copy: reading the page's own canvas again and again makes Chromium advise against it.
    let bytes = browser.evaluate(
        "(() => {
            const { width, height } = canvas;
            const copy = new OffscreenCanvas(width, height).getContext('2d', { willReadFrequently: true });
            copy.drawImage(canvas, 0, 0);
            return [...copy.getImageData(0, 0, width, height).data];
        })()",
    );
    bytes.as_array().unwrap().iter().map(|byte| byte.as_f64().unwrap()).collect()
}

fn mean(bytes: &[f64]) -> f64 {
    bytes.iter().sum::<f64>() / bytes.len() as f64
}

/// Gives a control a value, as a user does.
fn choose(browser: &mut Browser, control: &str, value: &str) {
    browser.evaluate(&format!(
        "$({control:?}).value = {value:?}; $({control:?}).dispatchEvent(new Event('input')); 0"
    ));
}

#[test]
fn the_page_of_a_render_works() {
    let Some(mut browser) = Browser::start(1400, 900) else { return };
    let folder = tempfile::tempdir().unwrap();
    let endless = ["--size", "240x160", "--rays", "1000000", "--quiet", "--view"];
    let mut running = Running(Viewed::start(render(folder.path(), &endless)));
    let url = format!("http://{}/", running.0.address);
    page::check(
        &mut browser,
        &url,
        &format!("{VERSION} > 0 && !$('layer').disabled"),
        "view",
        shot,
    );

    // The picture comes again and again, and the title says how far it is.
    browser.prefer("light");
    browser.resize(1400, 900);
    browser.open(&url);
    browser.wait_for(&format!("{VERSION} > 0"));
    let first = browser.evaluate(VERSION).as_u64().unwrap();
    browser.wait_for(&format!("{VERSION} >= {}", first + 2));
    browser.wait_for("/^\\d+ % rays - out.exr$/.test(document.title)");
    assert_eq!(browser.evaluate("$('name').textContent"), json!("out.exr"));

    // Exposure and view transform.
    choose(&mut browser, "transform", "srgb");
    choose(&mut browser, "exposure", "-2");
    let dark = shown(&mut browser, "exposure=-2&transform=srgb");
    choose(&mut browser, "exposure", "1");
    let bright = shown(&mut browser, "exposure=1&transform=srgb");
    assert!(mean(&bright) > mean(&dark) + 10.0, "{} {}", mean(&dark), mean(&bright));
    assert_eq!(browser.evaluate("$('stops').textContent"), json!("+1.00 stops"));
    choose(&mut browser, "transform", "agx");
    let agx = shown(&mut browser, "exposure=1&transform=agx");
    assert!((mean(&agx) - mean(&bright)).abs() > 1.0);

    // Layers: one of a single value has the dark end of the scale, another its whole length.
    choose(&mut browser, "layer", "saliency");
    let flat = shown(&mut browser, "layer=saliency");
    assert!(flat.chunks(4).all(|pixel| pixel == [68.0, 1.0, 84.0, 255.0]), "{:?}", &flat[..8]);
    choose(&mut browser, "layer", "transmittance");
    let clear = shown(&mut browser, "layer=transmittance");
    for end in [[68.0, 1.0, 84.0, 255.0], [253.0, 231.0, 37.0, 255.0]] {
        assert!(clear.chunks(4).any(|pixel| pixel == end), "{end:?}");
    }
    assert_eq!(
        browser.evaluate("[$('scale').hidden, $('developed').hidden]"),
        json!([false, true])
    );
    let [low, high] =
        ["low", "high"].map(|id| browser.evaluate(&format!("Number($('{id}').textContent)")));
    assert!(low.as_f64().unwrap() < 0.9 && high.as_f64() == Some(1.0), "{low} to {high}");
    for (width, height) in page::SIZES {
        browser.resize(width, height);
        browser.screenshot(&shot(&format!("view-layer-{width}")), true);
        page::assert_fits(&mut browser, "a layer");
        page::assert_legible(&mut browser, "a layer");
    }
    browser.resize(1400, 900);
    choose(&mut browser, "layer", "beauty");
    browser.click("#reset");
    shown(&mut browser, "layer=beauty&exposure=0&transform=agx");

    // The end: the page keeps the picture, and the program does not wait long.
    kill_process(Pid::from_child(&running.0.child), Signal::TERM).unwrap();
    let begun = Instant::now();
    assert_eq!(running.0.child.wait().unwrap().code(), Some(143));
    assert!(begun.elapsed() < Duration::from_secs(20), "{:?}", begun.elapsed());
    browser.wait_for("document.body.dataset.state === 'ended'");
    let told = browser.evaluate("$('told').textContent");
    assert!(told.as_str().unwrap().starts_with("Interrupted: out.exr has "), "{told}");
    assert_eq!(browser.evaluate("document.title"), json!("ended - out.exr"));
    assert_eq!(browser.evaluate("[$('layer').disabled, canvas.hidden]"), json!([true, false]));
    browser.screenshot(&shot("view-ended"), false);
    page::assert_legible(&mut browser, "the end");
    let (errors, addresses) = browser.complaints();
    assert!(errors.is_empty(), "{errors:#?}");
    assert!(addresses.iter().all(|address| address.starts_with(&url)), "{addresses:?}");
}

/// What is told where `--error` is the goal, and a render that ends by itself.
#[test]
fn the_page_says_that_it_is_finished() {
    let Some(mut browser) = Browser::start(1400, 900) else { return };
    let folder = tempfile::tempdir().unwrap();
    let goal = ["--size", "120x80", "--error", "0.04", "--quiet", "--view"];
    let mut running = Running(Viewed::start(render(folder.path(), &goal)));
    browser.open(&format!("http://{}/", running.0.address));
    browser.wait_for("!$('error').hidden && $('reached').textContent.includes('±')");
    browser.screenshot(&shot("view-error"), false);
    assert_eq!(browser.evaluate("$('goal').textContent"), json!("4 %"));
    browser.wait_for("document.body.dataset.state === 'ended'");
    assert!(running.0.child.wait().unwrap().success());
    assert_eq!(browser.evaluate("$('told').textContent"), json!("Finished: out.exr is written."));
    assert_eq!(browser.evaluate("document.title"), json!("finished - out.exr"));
    assert_eq!(browser.complaints().0, Vec::<String>::new());
    browser.screenshot(&shot("view-finished"), false);
}
