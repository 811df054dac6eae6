//! Live view of rendering in the viewer tev. In go pictures in progress, out come packets by `tev_client`.
//! Invariant: rendering neither waits for the viewer nor fails with it; a slow viewer misses intermediate
//! pictures.

use super::{CliError, tell};
use std::collections::VecDeque;
use std::net::{TcpStream, ToSocketAddrs};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};
use sunfleck::diagnostic::{Diagnostic, Place};
use sunfleck::film::Frame;
use tev_client::{PacketCreateImage, PacketUpdateImage, TevClient};

/// Default port of tev.
const PORT: u16 = 14158;

/// Timeout for a packet, after which the viewer counts as gone.
const PATIENCE: Duration = Duration::from_secs(3);

/// Maximum number of waiting pictures; older ones are dropped.
const MOST_WAITING: usize = 4;

/// Maximum share of time for intermediate pictures.
const SHARE: f64 = 0.015;

/// Approximate maximum of values in a packet, which the viewer receives as a whole.
const VALUES: usize = 1 << 20;

/// Connection to a viewer, if there is one.
pub(super) struct Live {
    queue: Option<Arc<Queue>>,
    began: Instant,
    /// Time spent on intermediate pictures.
    spent: Mutex<Duration>,
}

#[derive(Default)]
struct Queue {
    state: Mutex<State>,
    news: Condvar,
}

#[derive(Default)]
struct State {
    /// Names and contents of waiting pictures.
    waiting: VecDeque<(String, Frame)>,
    /// Set when no more pictures will come.
    over: bool,
    /// Set when the viewer is gone, or has received all.
    gone: bool,
}

impl Live {
    /// Connects on a thread of its own; without an address it does nothing.
    ///
    /// # Errors
    /// If the address does not exist.
    pub(super) fn new(address: Option<&str>) -> Result<Self, CliError> {
        let to = |queue| Self { queue, began: Instant::now(), spent: Mutex::default() };
        let Some(asked) = address else { return Ok(to(None)) };
        let address = with_port(asked);
        if let Err(error) = address.to_socket_addrs() {
            let found = format!("--live: `{asked}` is no address: {error}");
            let problem = Diagnostic::error(Place::Nowhere, found)
                .expected("a host, and a port behind a colon if tev listens at another than its own")
                .remedy("write --live 127.0.0.1:14158, or start tev here and leave the address out");
            return Err(CliError::Usage(problem));
        }
        let queue = Arc::new(Queue::default());
        {
            let queue = Arc::clone(&queue);
            std::thread::spawn(move || {
                let sent = send(&address, &queue);
                queue.lock().gone = true;
                queue.news.notify_all();
                if let Err(error) = sent {
                    tell(&format!(
                        "warning: --live: the viewer at {address} is not to be had: {error}\n  expected: tev, listening there\n  \
                         remedy: start tev (`tev --host {address}`) before rendering; frames are rendered all the same"
                    ));
                }
            });
        }
        Ok(to(Some(queue)))
    }

    /// Whether a viewer may be connected.
    pub(super) fn is_on(&self) -> bool {
        self.queue.as_ref().is_some_and(|queue| !queue.lock().gone)
    }

    /// Shows an intermediate picture, unless that would exceed its share of time.
    pub(super) fn look(&self, name: &str, so_far: &dyn Fn() -> Frame) {
        let mut spent = self.spent.lock().unwrap_or_else(PoisonError::into_inner);
        if *spent <= self.began.elapsed().mul_f64(SHARE) {
            let started = Instant::now();
            self.show(name, so_far());
            *spent += started.elapsed();
        }
    }

    /// Shows a picture, or a newer state of it. Never blocks.
    pub(super) fn show(&self, name: &str, frame: Frame) {
        let Some(queue) = self.queue.as_ref().filter(|_| self.is_on()) else { return };
        let mut state = queue.lock();
        // Replaces an unsent state of the same picture.
        state.waiting.retain(|(waiting, _)| waiting != name);
        if state.waiting.len() >= MOST_WAITING {
            state.waiting.pop_front();
        }
        state.waiting.push_back((name.to_owned(), frame));
        queue.news.notify_one();
    }
}

impl Drop for Live {
    /// Waits until the last pictures are sent, unless the viewer is too slow.
    fn drop(&mut self) {
        let Some(queue) = &self.queue else { return };
        let mut state = queue.lock();
        state.over = true;
        queue.news.notify_all();
        let waits = |state: &mut State| !state.gone;
        drop(queue.news.wait_timeout_while(state, PATIENCE, waits).unwrap_or_else(PoisonError::into_inner));
    }
}

impl Queue {
    fn lock(&self) -> std::sync::MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for the next picture; `None` at the end.
    fn next(&self) -> Option<(String, Frame)> {
        let mut state = self.lock();
        loop {
            match state.waiting.pop_front() {
                Some(next) => return Some(next),
                None if state.over => return None,
                None => state = self.news.wait(state).unwrap_or_else(PoisonError::into_inner),
            }
        }
    }
}

fn with_port(address: &str) -> String {
    // Colons of an IPv6 address are within brackets.
    let has_port = address.rsplit_once(':').is_some_and(|(_, port)| port.parse::<u16>().is_ok());
    if has_port { address.to_owned() } else { format!("{address}:{PORT}") }
}

/// Sends pictures until no more will come.
fn send(address: &str, queue: &Queue) -> std::io::Result<()> {
    // `localhost` is ::1 first, where tev does not listen.
    let mut connected = Err(std::io::ErrorKind::AddrNotAvailable.into());
    for place in address.to_socket_addrs()? {
        connected = TcpStream::connect_timeout(&place, PATIENCE);
        if connected.is_ok() {
            break;
        }
    }
    let stream = connected?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let mut viewer = TevClient::wrap(stream);
    let mut created: Option<String> = None;
    while let Some((name, frame)) = queue.next() {
        let is_new = created.as_ref() != Some(&name);
        // The client terminates texts by zero bytes.
        send_frame(&mut viewer, &name.replace('\0', ""), &frame, is_new)?;
        created = Some(name);
    }
    Ok(())
}

/// Sends all pixels, some rows a packet; a new picture starts black.
fn send_frame(viewer: &mut TevClient, name: &str, frame: &Frame, is_new: bool) -> std::io::Result<()> {
    let channels = &frame.channels;
    let channel_names: Vec<&str> = channels.iter().map(|channel| channel.name.as_str()).collect();
    if is_new {
        viewer.send(PacketCreateImage {
            image_name: name,
            grab_focus: true,
            width: frame.full.width as u32,
            height: frame.full.height as u32,
            channel_names: &channel_names,
        })?;
    }
    let window = frame.window;
    let most_rows = (VALUES / (window.width * channels.len()).max(1)).max(1);
    for first in (0..window.height).step_by(most_rows) {
        let rows = most_rows.min(window.height - first);
        let part = first * window.width..(first + rows) * window.width;
        // Planar: channel by channel.
        let offsets: Vec<u64> = (0..channels.len()).map(|channel| (channel * part.len()) as u64).collect();
        let data: Vec<f32> =
            channels.iter().flat_map(|channel| &channel.pixels[part.clone()]).copied().collect();
        viewer.send(PacketUpdateImage {
            image_name: name,
            grab_focus: false,
            channel_names: &channel_names,
            channel_offsets: &offsets,
            channel_strides: &vec![1; channels.len()],
            x: window.x as u32,
            y: (window.y + first) as u32,
            width: window.width as u32,
            height: rows as u32,
            data: &data,
        })?;
    }
    Ok(())
}
