//! A web server that answers the programs of this machine alone.

use std::fmt::{self, Formatter};
use std::io;
use std::net::Ipv4Addr;
use std::time::Duration;

use tiny_http::{Header, Request, Response};

use crate::error::{Error, Result};

/// The type of a text.
const TEXT: &str = "text/plain; charset=utf-8";

/// The type of a page.
const PAGE: &str = "text/html; charset=utf-8";

/// Listens at a port of 127.0.0.1.
pub struct Loopback {
    http: tiny_http::Server,
    port: u16,
}

/// An answer to a request.
#[derive(Debug)]
pub struct Reply {
    /// HTTP status.
    pub status: u16,
    /// Media type.
    pub kind: &'static str,
    /// Content.
    pub body: Vec<u8>,
    /// Names and values of further header lines.
    pub headers: Vec<(&'static str, String)>,
}

impl Reply {
    /// One of this media type.
    pub fn new(kind: &'static str, body: Vec<u8>) -> Self {
        Self { status: 200, kind, body, headers: Vec::new() }
    }

    /// A page.
    pub fn page(html: Vec<u8>) -> Self {
        Self::new(PAGE, html)
    }

    /// A text with an HTTP `status`.
    pub fn text(status: u16, text: impl Into<String>) -> Self {
        Self { status, ..Self::new(TEXT, text.into().into_bytes()) }
    }
}

impl Loopback {
    /// Opens `port`, any free one for 0.
    ///
    /// # Errors
    /// Where the port cannot be had.
    pub fn bind(port: u16) -> Result<Self> {
        let taken = |e| Error::Usage(format!("port {port} cannot be had: {e}; give another"));
        let http = tiny_http::Server::http((Ipv4Addr::LOCALHOST, port)).map_err(taken)?;
        let port = http.server_addr().to_ip().map_or(port, |address| address.port());
        Ok(Self { http, port })
    }

    /// Where its page is.
    pub fn url(&self) -> String {
        format!("http://127.0.0.1:{}/", self.port)
    }

    /// The next request; `None` where none came within the time `patience`. Requests for other servers are refused.
    ///
    /// # Errors
    /// Where none will come any more.
    pub fn receive(&self, patience: Duration) -> io::Result<Option<Request>> {
        let Some(request) = self.http.recv_timeout(patience)? else { return Ok(None) };
        if self.is_meant(&request) {
            return Ok(Some(request));
        }
        send(request, Reply::text(403, "only this machine is answered"));
        Ok(None)
    }

    /// Whether the request is for this server by its own name: a foreign page cannot reach it
    /// through a name of its own that leads here.
    fn is_meant(&self, request: &Request) -> bool {
        let names = ["127.0.0.1", "localhost"].map(|name| format!("{name}:{}", self.port));
        header(request, "Host").is_some_and(|host| names.contains(&host))
    }
}

impl fmt::Debug for Loopback {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.debug_struct("Loopback").field("url", &self.url()).finish_non_exhaustive()
    }
}

/// The value of a header line in lower case.
pub fn header(request: &Request, name: &'static str) -> Option<String> {
    let found = request.headers().iter().find(|header| header.field.equiv(name));
    found.map(|header| header.value.as_str().to_ascii_lowercase())
}

/// Answers `request`. A browser that has closed the connection is no failure.
pub fn send(request: Request, reply: Reply) {
    let Reply { status, kind, body, headers } = reply;
    let usual = [
        ("Content-Type", kind),
        ("X-Content-Type-Options", "nosniff"),
        ("Cache-Control", "no-store"),
        ("Cross-Origin-Resource-Policy", "same-origin"),
    ];
    let mut response = Response::from_data(body).with_status_code(status);
    let more = headers.iter().map(|(name, value)| (*name, value.as_str()));
    for (name, value) in usual.into_iter().chain(more) {
        if let Ok(header) = Header::from_bytes(name, value) {
            response.add_header(header);
        }
    }
    let _ = request.respond(response);
}
