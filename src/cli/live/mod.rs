//! The picture while it gets better, beside its files: on a page and in tev.

mod develop;
mod page;
mod server;
mod tev;

use std::ffi::OsString;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use server::Server;
use tev::Tev;

use super::console;
use super::progress::Watch;
use crate::error::Result;
use crate::image::{Film, View, ViewTransform};

/// Time between two moments at which a picture may be shown.
const REFRESH: Duration = Duration::from_secs(1);

/// Films in memory beside the render's own: the one that is shown, and the next.
const FILMS: u64 = 2;

/// Where pictures are shown.
#[derive(Debug, clap::Args)]
pub(super) struct LiveArgs {
    /// Show the picture while it gets better on a page for this machine alone, with all layers; its address is printed. Any
    /// free port where none is given.
    #[arg(
        long,
        value_name = "PORT",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "0",
        value_parser = port
    )]
    view: Option<u16>,
    /// Send the picture while it gets better, and in the end, to the viewer tev; its own port is 14158.
    #[arg(long, value_name = "HOST:PORT", value_parser = address)]
    tev: Option<String>,
}

/// Shows pictures on a page and in tev, as far as either was asked for.
#[derive(Debug)]
pub(super) struct Live {
    server: Option<Server>,
    tev: Option<Tev>,
}

impl Live {
    /// Opens what `args` ask for, for the picture `output`, and prints where the page is.
    ///
    /// # Errors
    /// Where the port of the page cannot be had, or the system starts no thread.
    pub(super) fn open(args: &LiveArgs, output: &Path) -> Result<Self> {
        let start = |port| Server::start(port, &name(output));
        let server = args.view.map(start).transpose()?;
        if let Some(server) = &server {
            console::message(&format!("note: the picture is shown at {}", server.url()));
        }
        Ok(Self { server, tev: args.tev.as_deref().map(Tev::start).transpose()? })
    }

    /// Time between two moments at which a picture may be shown; `None` where none is.
    pub(super) fn every(&self) -> Option<Duration> {
        (self.server.is_some() || self.tev.is_some()).then_some(REFRESH)
    }

    /// Bytes that it takes for a picture of so many `pixels`.
    pub(super) fn memory(&self, pixels: u64) -> u64 {
        let films = if self.every().is_some() { FILMS } else { 0 };
        films * pixels * Film::PIXEL_BYTES as u64
    }

    /// The picture `output` begins, which is developed by `view` and rendered as `watch` tells.
    pub(super) fn begin(&self, output: &Path, view: View, watch: Watch) {
        if let Some(server) = &self.server {
            server.page.begin(&name(output), view, watch);
        }
    }

    /// Whether anybody would see a new picture.
    pub(super) fn wants(&self) -> bool {
        self.server.as_ref().is_some_and(|server| server.page.wants())
            || self.tev.as_ref().is_some_and(Tev::wants)
    }

    /// Shows the picture `output` so far. It has to be called rarely: as often as somebody [wants](Self::wants) it.
    pub(super) fn show(&self, output: &Path, film: Film) {
        let film = Arc::new(film);
        if let Some(server) = &self.server {
            server.page.show(film.clone());
        }
        if let Some(tev) = self.tev.as_ref().filter(|tev| tev.wants()) {
            tev.show(&name(output), film);
        }
    }

    /// Shows the picture `output` as it is written.
    pub(super) fn finish(&self, output: &Path, film: &Film) {
        if self.every().is_none() {
            return;
        }
        let film = Arc::new(film.clone());
        if let Some(server) = &self.server {
            server.page.show(film.clone());
        }
        if let Some(tev) = &self.tev {
            tev.show(&name(output), film);
            tev.flush();
        }
    }

    /// Says how the run ended, and waits until the last picture is where somebody looks, two seconds at most for the page.
    pub(super) fn close(self, result: &Result<()>) {
        if let Some(tev) = self.tev {
            tev.close();
        }
        if let Some(server) = self.server {
            match result {
                Ok(()) => server.close("finished"),
                Err(error) => server.close(&error.to_string()),
            }
        }
    }
}

/// What a picture is called.
fn name(output: &Path) -> String {
    output.display().to_string()
}

/// A port, 0 for any.
fn port(text: &str) -> std::result::Result<u16, String> {
    let problem = "give a port, as 8080; the view transform is --view-transform";
    text.parse().map_err(|_| problem.into())
}

/// What is wrong with a word of the `arguments` that stands behind `--view` and was meant for it; `None` where there is none.
pub(super) fn misplaced_word(arguments: &[OsString]) -> Option<String> {
    let behind = arguments.windows(2).filter(|pair| pair[0] == "--view");
    behind.filter_map(|pair| pair[1].to_str()).find_map(|word| {
        if word.parse::<u16>().is_ok() {
            Some(format!("--view {word}: the port stands behind an equals sign; give --view={word}"))
        } else if word.parse::<ViewTransform>().is_ok() {
            Some(format!(
                "--view {word}: --view shows the picture on a page; the view transform is --view-transform {word}"
            ))
        } else {
            None
        }
    })
}

/// A host and a port.
fn address(text: &str) -> std::result::Result<String, String> {
    let parts = text.rsplit_once(':');
    let is_right =
        parts.is_some_and(|(host, port)| !host.is_empty() && port.parse::<u16>().is_ok());
    is_right.then(|| text.to_owned()).ok_or_else(|| "give host and port, as localhost:14158".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_has_a_host_and_a_port() {
        for right in ["localhost:14158", "[::1]:14158", "192.168.0.7:1"] {
            assert_eq!(address(right).as_deref(), Ok(right));
        }
        for wrong in ["", "localhost", ":14158", "localhost:tev", "localhost:99999"] {
            assert!(address(wrong).unwrap_err().contains("host and port"), "{wrong}");
        }
    }
}
