//! The web server of the page.

use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use tiny_http::{Method, Request};

use super::develop::{Developed, develop};
use super::page::Page;
use crate::error::{Error, Result};
use crate::image::{View, viridis};
use crate::loopback::{Loopback, Reply, send};

/// Time between two looks at what was asked.
const TICK: Duration = Duration::from_millis(50);

/// Longest time that a page waits for news.
const HOLD: Duration = Duration::from_millis(500);

/// Longest time that the end of the program waits for pages that get the last picture.
const PARTING: Duration = Duration::from_secs(2);

/// Time without a request after which no page is on its way to ask for the end: they ask again at once.
const QUIET: Duration = Duration::from_millis(200);

/// Largest exposure, in stops up and down: beyond what a display shows of any radiance.
const MAX_EXPOSURE: f64 = 128.0;

/// Colours of the scale beside layers in false colours.
const SCALE_STEPS: u32 = 16;

/// What the page may use: its own style, script and pictures.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; \
    connect-src 'self'; img-src data:";

/// Serves a page until it is closed.
#[derive(Debug)]
pub(super) struct Server {
    pub(super) page: Arc<Page>,
    url: String,
    thread: JoinHandle<()>,
}

impl Server {
    /// Opens `port`, any free one for 0, for the picture of the file `name`.
    ///
    /// # Errors
    /// Where the port cannot be had.
    pub(super) fn start(port: u16, name: &str) -> Result<Self> {
        let http = Loopback::bind(port)?;
        let (url, page) = (http.url(), Arc::new(Page::new(name)));
        let serving = Serving {
            http,
            page: page.clone(),
            html: html(),
            waiting: Vec::new(),
            asked: Instant::now(),
            told: 0,
            parted: 0,
        };
        let thread = std::thread::Builder::new()
            .name("view".into())
            .spawn(move || serving.run())
            .map_err(|e| Error::Failed(format!("--view cannot be served: {e}")))?;
        Ok(Self { page, url, thread })
    }

    /// Where the page is.
    pub(super) fn url(&self) -> &str {
        &self.url
    }

    /// Tells pages `how` the render ended and ends once they have the last picture, or soon where none looks.
    pub(super) fn close(self, how: &str) {
        self.page.end(how);
        // A panic of the server's thread has been printed, and the picture is written.
        let _ = self.thread.join();
    }
}

/// The page as it is sent.
fn html() -> Vec<u8> {
    let steps = (0..=SCALE_STEPS).map(|i| viridis(f64::from(i) / f64::from(SCALE_STEPS)));
    let colors: Vec<String> = steps.map(|[r, g, b]| format!("#{r:02x}{g:02x}{b:02x}")).collect();
    include_str!("page.html")
        .replace("/* style */", include_str!("page.css"))
        .replace("/* script */", include_str!("page.js"))
        .replace("/* viridis */", &colors.join(", "))
        .into_bytes()
}

/// A question for news.
struct Waiting {
    request: Request,
    since: Instant,
    /// The number of the picture that the page has.
    seen: Option<u64>,
}

/// State of the server's thread.
struct Serving {
    http: Loopback,
    page: Arc<Page>,
    html: Vec<u8>,
    waiting: Vec<Waiting>,
    /// When the last request came.
    asked: Instant,
    /// Pages that were told of the end.
    told: usize,
    /// Pages that got the last picture after that.
    parted: usize,
}

impl Serving {
    fn run(mut self) {
        while let Ok(request) = self.http.receive(TICK) {
            if let Some(request) = request {
                self.page.look();
                self.asked = Instant::now();
                self.answer(request);
            }
            self.tell();
            if self.is_over() {
                return;
            }
        }
    }

    fn answer(&mut self, request: Request) {
        let (path, query) = request.url().split_once('?').unwrap_or((request.url(), ""));
        let is_known = ["/", "/state", "/picture"].contains(&path);
        let reply = match (request.method(), path) {
            (Method::Get | Method::Head, "/") => {
                let policy = ("Content-Security-Policy", POLICY.to_owned());
                Reply { headers: vec![policy], ..Reply::page(self.html.clone()) }
            }
            (Method::Get | Method::Head, "/state") => {
                let seen = value(query, "seen").and_then(|seen| seen.parse().ok());
                self.waiting.push(Waiting { request, since: Instant::now(), seen });
                return;
            }
            (Method::Get | Method::Head, "/picture") => {
                let reply = self.picture(query);
                self.parted += usize::from(self.told > 0);
                reply
            }
            _ if is_known => Reply::text(405, "GET or HEAD"),
            _ => Reply::text(404, "there is /, /state and /picture"),
        };
        send(request, reply);
    }

    /// Answers questions for news: where there are some, or after a while.
    fn tell(&mut self) {
        let (version, has_ended) = (self.page.version(), self.page.ended().is_some());
        let is_due = |waiting: &mut Waiting| {
            has_ended || waiting.seen != Some(version) || waiting.since.elapsed() >= HOLD
        };
        for Waiting { request, .. } in self.waiting.extract_if(.., is_due) {
            let status = self.page.status();
            self.told += usize::from(!status["ended"].is_null());
            send(request, Reply::new("application/json", status.to_string().into_bytes()));
        }
    }

    /// Whether the render has ended and whoever looks at its page has the last picture.
    fn is_over(&self) -> bool {
        let Some(ago) = self.page.ended() else { return false };
        let is_seen = self.told > 0 && (self.parted >= self.told || self.page.version() == 0);
        let is_alone = self.told == 0 && !self.page.is_looked_at();
        (is_seen && self.asked.elapsed() > QUIET) || is_alone || ago > PARTING
    }

    /// The newest picture, as `query` asks to see it.
    fn picture(&self, query: &str) -> Reply {
        let Some((film, version)) = self.page.picture() else {
            return Reply::text(404, "there is no picture yet");
        };
        let view = match view(query) {
            Ok(view) => view,
            Err(problem) => return Reply::text(400, problem),
        };
        let layer = value(query, "layer").unwrap_or_default();
        let start = Instant::now();
        let reply = match develop(&film, &layer, &view) {
            Ok(Some(Developed { png, range })) => {
                let range = range.map(|[low, high]| ("X-Range", format!("{low} {high}")));
                let mut headers = vec![("X-Version", version.to_string())];
                headers.extend(range);
                Reply { headers, ..Reply::new("image/png", png) }
            }
            Ok(None) => Reply::text(404, format!("there is no layer \"{layer}\"")),
            Err(error) => Reply::text(500, error.to_string()),
        };
        self.page.developed(start.elapsed());
        reply
    }
}

/// The view that `query` asks for; what is wrong with it otherwise.
fn view(query: &str) -> Result<View, String> {
    let exposure = value(query, "exposure").and_then(|text| text.parse::<f64>().ok());
    let exposure = exposure.filter(|stops| stops.abs() <= MAX_EXPOSURE).ok_or_else(|| {
        format!("exposure: give a number of stops from -{MAX_EXPOSURE} to {MAX_EXPOSURE}")
    })?;
    let transform = value(query, "transform").unwrap_or_default();
    Ok(View { exposure, transform: transform.parse().map_err(|e: Error| e.to_string())? })
}

/// The value of `name` in a query, decoded.
fn value(query: &str, name: &str) -> Option<String> {
    let mut pairs = query.split('&').filter_map(|pair| pair.split_once('='));
    let (_, value) = pairs.find(|(key, _)| *key == name)?;
    Some(urlencoding::decode(value).ok()?.into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn queries_say_how_a_picture_is_seen() {
        let query = "version=3&layer=a%20b&exposure=-1.5&transform=agx";
        assert_eq!(value(query, "layer").as_deref(), Some("a b"));
        assert_eq!(view(query).unwrap().exposure, -1.5);
        for wrong in ["", "exposure=NaN&transform=agx", "exposure=1e9&transform=agx"] {
            assert!(view(wrong).unwrap_err().starts_with("exposure: give"), "{wrong}");
        }
        assert!(view("exposure=0&transform=film").unwrap_err().contains("srgb or agx"));
    }

    #[test]
    fn the_page_is_whole() {
        let html = String::from_utf8(html()).unwrap();
        assert!(!html.contains("/* style */") && !html.contains("/* script */"));
        assert!(html.contains("#440154") && !html.contains("/* viridis */"));
    }
}
