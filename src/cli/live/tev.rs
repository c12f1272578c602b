//! Pictures for the viewer tev, by its network protocol (<https://github.com/Tom94/tev>).

use std::collections::VecDeque;
use std::io;
use std::net::{TcpStream, ToSocketAddrs};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use tev_client::{PacketCreateImage, PacketUpdateImage, TevClient};

use super::super::console;
use crate::error::{Error, Result};
use crate::image::{Film, NOISY_LAYERS};

/// Pixels along each side of the tiles in which a picture is sent: those of tev's own Python client.
const TILE: usize = 128;

/// Longest time to connect.
const CONNECTING: Duration = Duration::from_secs(2);

/// Longest time that tev may leave sent bytes untaken.
const TAKING: Duration = Duration::from_secs(10);

/// Sends pictures from a thread of its own, so that rays do not wait for the network.
#[derive(Debug)]
pub(super) struct Tev {
    queue: Arc<Queue>,
    thread: JoinHandle<()>,
}

/// A picture and its name in tev.
type Named = (String, Arc<Film>);

/// Pictures that are still to be sent.
#[derive(Debug, Default)]
struct Queue {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct State {
    pictures: VecDeque<Named>,
    is_sending: bool,
    is_closed: bool,
    /// Whether tev cannot be reached.
    has_failed: bool,
}

impl State {
    fn is_idle(&self) -> bool {
        self.pictures.is_empty() && !self.is_sending
    }
}

impl Queue {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn wait_while(&self, holds: impl Fn(&State) -> bool) -> MutexGuard<'_, State> {
        let waited = self.changed.wait_while(self.state(), |state| holds(state));
        waited.unwrap_or_else(PoisonError::into_inner)
    }

    fn change(&self, change: impl FnOnce(&mut State)) {
        change(&mut self.state());
        self.changed.notify_all();
    }

    /// The next picture, once there is one; `None` once none will come.
    fn next(&self) -> Option<Named> {
        let mut state = self.wait_while(|state| state.pictures.is_empty() && !state.is_closed);
        let next = state.pictures.pop_front();
        state.is_sending = next.is_some();
        next
    }

    /// Sends pictures to `address` until it is closed or tev cannot be reached.
    fn send_to(&self, address: &str) {
        let sent = Connection::open(address).and_then(|mut connection| {
            while let Some((name, film)) = self.next() {
                connection.send(&name, &film)?;
                self.change(|state| state.is_sending = false);
            }
            Ok(())
        });
        if let Err(error) = sent {
            console::warn(&[format!("tev at {address} cannot be reached: {error}")]);
        }
        self.change(|state| {
            *state = State { has_failed: true, is_closed: state.is_closed, ..State::default() };
        });
    }
}

impl Tev {
    /// Sends pictures to tev at `address`, host and port. Where it cannot be reached that is said once, and nothing is sent.
    ///
    /// # Errors
    /// Where the system starts no thread.
    pub(super) fn start(address: &str) -> Result<Self> {
        let queue = Arc::new(Queue::default());
        let (sending, address) = (queue.clone(), address.to_owned());
        let thread = std::thread::Builder::new()
            .name("tev".into())
            .spawn(move || sending.send_to(&address))
            .map_err(|e| Error::Failed(format!("--tev cannot be served: {e}")))?;
        Ok(Self { queue, thread })
    }

    /// Whether a picture would be sent at once.
    pub(super) fn wants(&self) -> bool {
        let state = self.queue.state();
        state.is_idle() && !state.has_failed
    }

    /// Sends a picture called `name`.
    pub(super) fn show(&self, name: &str, film: Arc<Film>) {
        self.queue.change(|state| {
            if !state.has_failed {
                state.pictures.push_back((name.to_owned(), film));
            }
        });
    }

    /// Waits until all pictures are sent.
    pub(super) fn flush(&self) {
        drop(self.queue.wait_while(|state| !state.is_idle()));
    }

    /// Ends once all pictures are sent.
    pub(super) fn close(self) {
        self.queue.change(|state| state.is_closed = true);
        // A panic of the thread has been printed, and the picture is written.
        let _ = self.thread.join();
    }
}

/// A connection to tev.
struct Connection {
    client: TevClient,
    /// The picture that was made last in tev, and its channels.
    made: Option<(String, Vec<&'static str>)>,
}

impl Connection {
    fn open(address: &str) -> io::Result<Self> {
        let mut problem = io::Error::new(io::ErrorKind::NotFound, "the host has no address");
        for place in address.to_socket_addrs()? {
            match TcpStream::connect_timeout(&place, CONNECTING) {
                Ok(stream) => {
                    stream.set_write_timeout(Some(TAKING))?;
                    return Ok(Self { client: TevClient::wrap(stream), made: None });
                }
                Err(error) => problem = error,
            }
        }
        Err(problem)
    }

    /// Sends all layers of `film`, and first makes the picture `name` where it is a new one.
    fn send(&mut self, name: &str, film: &Film) -> io::Result<()> {
        let (width, height) = (film.width(), film.height());
        if self.made.as_ref().is_none_or(|(made, _)| made != name) {
            let names = film.layers().map(|(layer, _)| layer);
            // The first previews of a picture lack those.
            let channels: Vec<_> = names.filter(|layer| !NOISY_LAYERS.contains(layer)).collect();
            self.client.send(PacketCreateImage {
                image_name: name,
                grab_focus: true,
                width: width as u32,
                height: height as u32,
                channel_names: &channels,
            })?;
            self.made = Some((name.to_owned(), channels));
        }
        let Some((_, channels)) = &self.made else { return Ok(()) };
        let layers: Vec<&[f32]> = channels.iter().filter_map(|name| film.layer(name)).collect();
        let offsets: Vec<u64> = (0..channels.len() as u64).collect();
        let strides = vec![channels.len() as u64; channels.len()];
        for top in (0..height).step_by(TILE) {
            for left in (0..width).step_by(TILE) {
                let (right, bottom) = (width.min(left + TILE), height.min(top + TILE));
                let rows = top..bottom;
                let pixels = rows.flat_map(|y| (left..right).map(move |x| y * width + x));
                let data: Vec<f32> =
                    pixels.flat_map(|pixel| layers.iter().map(move |layer| layer[pixel])).collect();
                self.client.send(PacketUpdateImage {
                    image_name: name,
                    grab_focus: false,
                    channel_names: channels,
                    channel_offsets: &offsets,
                    channel_strides: &strides,
                    x: left as u32,
                    y: top as u32,
                    width: (right - left) as u32,
                    height: (bottom - top) as u32,
                    data: &data,
                })?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::io::Read;
    use std::net::TcpListener;

    use super::*;
    use crate::image::FilmPixel;
    use crate::math::Rgb;

    /// What a packet says after its length, in the order in which tev reads it.
    struct Fields(Vec<u8>);

    impl Fields {
        fn of(kind: u8, grabs_focus: bool) -> Self {
            Self(vec![kind, grabs_focus.into()])
        }

        fn text(mut self, text: &str) -> Self {
            self.0.extend([text.as_bytes(), b"\0"].concat());
            self
        }

        fn texts(self, texts: &[&str]) -> Self {
            let count = self.numbers(&[texts.len() as u32]);
            texts.iter().fold(count, |fields, text| fields.text(text))
        }

        fn numbers(mut self, values: &[u32]) -> Self {
            self.0.extend(values.iter().flat_map(|value| value.to_le_bytes()));
            self
        }

        fn places(mut self, values: impl Iterator<Item = u64>) -> Self {
            self.0.extend(values.flat_map(u64::to_le_bytes));
            self
        }

        fn values(mut self, values: &[f32]) -> Self {
            self.0.extend(values.iter().flat_map(|value| value.to_le_bytes()));
            self
        }

        /// The packet, which begins with the number of all its bytes.
        fn packet(self) -> Vec<u8> {
            let length = self.0.len() as u32 + 4;
            [&length.to_le_bytes()[..], &self.0].concat()
        }
    }

    /// What a viewer gets that is sent the same film twice.
    fn sent(film: &Film) -> Vec<u8> {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap().to_string();
        let mut connection = Connection::open(&address).unwrap();
        connection.send("a.exr", film).unwrap();
        connection.send("a.exr", film).unwrap();
        drop(connection);
        let mut bytes = Vec::new();
        listener.accept().unwrap().0.read_to_end(&mut bytes).unwrap();
        bytes
    }

    /// The layout is that of tev's `Ipc.cpp`: kinds 4, `CreateImage`, and 6, `UpdateImageV3`.
    #[test]
    fn packets_have_the_layout_that_tev_reads() {
        let mut film = Film::new(2, 1);
        let pixel = FilmPixel { radiance: Rgb::new(0.25, 0.5, 1.0), ..FilmPixel::default() };
        film.set(1, 0, &pixel);
        let layers: Vec<_> = film.layers().collect();
        let names: Vec<_> = layers.iter().map(|(name, _)| *name).collect();
        let values: Vec<f32> =
            (0..2).flat_map(|pixel| layers.iter().map(move |(_, layer)| layer[pixel])).collect();
        let count = names.len() as u64;
        let made = Fields::of(4, true).text("a.exr").numbers(&[2, 1]).texts(&names);
        let update = || {
            let region = Fields::of(6, false).text("a.exr").texts(&names).numbers(&[0, 0, 2, 1]);
            let places = region.places(0..count).places((0..count).map(|_| count));
            places.values(&values).packet()
        };
        assert_eq!(values[names.len()..][..3], [0.25, 0.5, 1.0]);
        assert_eq!(sent(&film), [made.packet(), update(), update()].concat());
    }
}
