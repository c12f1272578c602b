//! Chromium without a window, spoken to in the DevTools protocol through a pair of pipes: messages
//! are JSON, each ended by a zero byte (`--remote-debugging-pipe`).

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use base64::Engine;
use serde_json::{Value, json};

use crate::skip;

/// Names under which Chromium is installed.
const PROGRAMS: [&str; 4] =
    ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];

/// How long anything may take.
const PATIENCE: Duration = Duration::from_secs(60);

/// A browser with one page.
pub struct Browser {
    child: Child,
    input: Option<ChildStdin>,
    messages: Receiver<Value>,
    asked: u64,
    session: Option<String>,
    events: Vec<Value>,
    _profile: tempfile::TempDir,
}

impl Browser {
    /// A browser with an empty page of this size; nothing, with a message, where there is none on
    /// this machine.
    pub fn start(width: u32, height: u32) -> Option<Self> {
        let runs = |name: &&str| {
            let asked = Command::new(name).arg("--version").stderr(Stdio::null()).output();
            asked.is_ok_and(|told| told.status.success())
        };
        let Some(program) = PROGRAMS.iter().find(|name| runs(name)) else {
            skip::skip("Chromium; apt-get install chromium");
            return None;
        };
        let profile = tempfile::tempdir().unwrap();
        // The pipes have to be numbers 3 and 4.
        let mut child = Command::new("sh")
            .args(["-c", "exec \"$0\" \"$@\" 3<&0 4>&1 0</dev/null 1>/dev/null 2>&1", program])
            .args(["--headless=new", "--remote-debugging-pipe", "--no-sandbox", "--disable-gpu"])
            .args(["--no-first-run", "--disable-dev-shm-usage", "--disable-background-networking"])
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .arg("about:blank")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let output = BufReader::new(child.stdout.take().unwrap());
        let (sender, messages) = channel();
        std::thread::spawn(move || {
            for message in output.split(0).map_while(Result::ok) {
                let Ok(message) = serde_json::from_slice(&message) else { break };
                if sender.send(message).is_err() {
                    break;
                }
            }
        });
        let input = child.stdin.take();
        let mut browser = Self {
            child,
            input,
            messages,
            asked: 0,
            session: None,
            events: Vec::new(),
            _profile: profile,
        };
        let target = browser.ask("Target.createTarget", json!({ "url": "about:blank" }));
        let attached = browser.ask(
            "Target.attachToTarget",
            json!({ "targetId": target["targetId"], "flatten": true }),
        );
        browser.session = Some(attached["sessionId"].as_str().unwrap().to_owned());
        for domain in ["Page", "Runtime", "Log", "Network"] {
            browser.ask(&format!("{domain}.enable"), json!({}));
        }
        browser.resize(width, height);
        Some(browser)
    }

    /// Makes the window this large.
    pub fn resize(&mut self, width: u32, height: u32) {
        let size = json!({
            "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false
        });
        self.ask("Emulation.setDeviceMetricsOverride", size);
    }

    /// Prefers the `light` or the `dark` scheme of colours.
    pub fn prefer(&mut self, scheme: &str) {
        let features = json!([{ "name": "prefers-color-scheme", "value": scheme }]);
        self.ask("Emulation.setEmulatedMedia", json!({ "features": features }));
    }

    /// Presses and releases a key by its name in the DOM.
    pub fn press(&mut self, key: &str) {
        let code = match key {
            "Tab" => 9,
            "ArrowLeft" => 37,
            "ArrowRight" => 39,
            _ => u32::from(key.bytes().next().unwrap_or_default()),
        };
        let mut event = json!({ "type": "keyDown", "key": key, "windowsVirtualKeyCode": code });
        if key.len() == 1 {
            event["text"] = json!(key);
        }
        self.ask("Input.dispatchKeyEvent", event.clone());
        event["type"] = json!("keyUp");
        self.ask("Input.dispatchKeyEvent", event);
    }

    /// Loads `url` and waits until it is.
    pub fn open(&mut self, url: &str) {
        let told = self.ask("Page.navigate", json!({ "url": url }));
        assert_eq!(told.get("errorText"), None, "{url}");
        self.event("Page.loadEventFired");
    }

    /// The value of a JavaScript expression, awaited where it is a promise.
    pub fn evaluate(&mut self, expression: &str) -> Value {
        let told = self.ask(
            "Runtime.evaluate",
            json!({ "expression": expression, "returnByValue": true, "awaitPromise": true }),
        );
        assert_eq!(told.get("exceptionDetails"), None, "{expression}");
        told["result"].get("value").cloned().unwrap_or(Value::Null)
    }

    /// Waits until a JavaScript expression is true.
    pub fn wait_for(&mut self, expression: &str) {
        let begun = Instant::now();
        while self.evaluate(expression) != json!(true) {
            assert!(begun.elapsed() < PATIENCE, "never came true: {expression}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Stops the page's own time, but for what [`pass`](Self::pass) lets pass.
    pub fn stop_time(&mut self) {
        self.ask("Emulation.setVirtualTimePolicy", json!({ "policy": "pause" }));
    }

    /// Lets this much of the page's own time pass, in milliseconds, at once.
    pub fn pass(&mut self, milliseconds: u32) {
        let budget = json!({ "policy": "advance", "budget": milliseconds });
        self.ask("Emulation.setVirtualTimePolicy", budget);
        self.event("Emulation.virtualTimeBudgetExpired");
    }

    /// The middle of the element that `selector` finds, scrolled into view.
    pub fn place(&mut self, selector: &str) -> [f64; 2] {
        let script = format!(
            "(() => {{ const e = document.querySelector({selector:?});
             e.scrollIntoView({{ block: 'center', inline: 'center' }});
             const r = e.getBoundingClientRect();
             return [r.x + r.width / 2, r.y + r.height / 2]; }})()"
        );
        let place = self.evaluate(&script);
        [0, 1].map(|i| place[i].as_f64().unwrap())
    }

    /// Clicks the element that `selector` finds.
    pub fn click(&mut self, selector: &str) {
        let place = self.place(selector);
        self.mouse("mouseMoved", place);
        self.mouse("mousePressed", place);
        self.mouse("mouseReleased", place);
    }

    /// A mouse event of the left button at a place of the window.
    pub fn mouse(&mut self, kind: &str, [x, y]: [f64; 2]) {
        let (button, count) = if kind == "mouseMoved" { ("none", 0) } else { ("left", 1) };
        let event = json!({ "type": kind, "x": x, "y": y, "button": button, "clickCount": count });
        self.ask("Input.dispatchMouseEvent", event);
    }

    /// Turns the wheel at a place of the window, with the Ctrl key down.
    pub fn wheel(&mut self, [x, y]: [f64; 2], down: f64) {
        let event = json!({
            "type": "mouseWheel", "x": x, "y": y, "deltaX": 0, "deltaY": down, "modifiers": 2
        });
        self.ask("Input.dispatchMouseEvent", event);
    }

    /// Writes what is seen as a PNG; with `whole` the page in full length.
    pub fn screenshot(&mut self, path: &Path, whole: bool) {
        let mut asked = json!({ "format": "png", "captureBeyondViewport": whole });
        if whole {
            let size = self.ask("Page.getLayoutMetrics", json!({}))["cssContentSize"].clone();
            asked["clip"] = json!({
                "x": 0, "y": 0, "width": size["width"], "height": size["height"], "scale": 1
            });
        }
        let told = self.ask("Page.captureScreenshot", asked);
        let bytes =
            base64::engine::general_purpose::STANDARD.decode(told["data"].as_str().unwrap());
        std::fs::write(path, bytes.unwrap()).unwrap();
    }

    /// Errors and warnings that the page caused so far, and addresses that it asked for.
    pub fn complaints(&self) -> (Vec<String>, Vec<String>) {
        let mut errors = Vec::new();
        let mut addresses = Vec::new();
        for event in &self.events {
            let params = &event["params"];
            match event["method"].as_str().unwrap_or_default() {
                "Runtime.exceptionThrown" => errors.push(params.to_string()),
                "Runtime.consoleAPICalled"
                    if ["error", "warning"].contains(&word(&params["type"])) =>
                {
                    errors.push(params.to_string());
                }
                "Log.entryAdded"
                    if ["error", "warning"].contains(&word(&params["entry"]["level"])) =>
                {
                    errors.push(params.to_string());
                }
                "Network.requestWillBeSent" => {
                    addresses.push(word(&params["request"]["url"]).to_owned());
                }
                _ => {}
            }
        }
        addresses.retain(|address| !address.starts_with("data:") && !address.starts_with("blob:"));
        (errors, addresses)
    }

    fn ask(&mut self, method: &str, params: Value) -> Value {
        self.asked += 1;
        let mut message = json!({ "id": self.asked, "method": method, "params": params });
        if let Some(session) = &self.session {
            message["sessionId"] = json!(session);
        }
        let mut bytes = message.to_string().into_bytes();
        bytes.push(0);
        self.input.as_mut().unwrap().write_all(&bytes).unwrap();
        loop {
            let mut message = self.next(method);
            if message["id"] == json!(self.asked) {
                assert_eq!(message.get("error"), None, "{method}");
                return message["result"].take();
            }
            self.events.push(message);
        }
    }

    /// Waits for an event that has not been seen yet.
    fn event(&mut self, method: &str) {
        if let Some(at) = self.events.iter().position(|event| event["method"] == method) {
            self.events.remove(at);
            return;
        }
        loop {
            let message = self.next(method);
            if message["method"] == method {
                return;
            }
            self.events.push(message);
        }
    }

    fn next(&self, what: &str) -> Value {
        let message = self.messages.recv_timeout(PATIENCE);
        message.unwrap_or_else(|e| panic!("the browser does not answer to {what}: {e}"))
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        // A browser whose pipe is closed ends by itself, with all its processes.
        drop(self.input.take());
        let begun = Instant::now();
        while begun.elapsed() < Duration::from_secs(5) {
            if matches!(self.child.try_wait(), Ok(Some(_))) {
                return;
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn word(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
}
