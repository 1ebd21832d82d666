//! The image viewer tev as a window on a rendering: its pictures go there over TCP.
//!
//! A thread of its own takes a picture from the session, the newest there is, and sends it whole
//! before it takes another. The rendering never waits for it, and the end of the run not for long:
//! a slow viewer gets fewer pictures, and of one that is gone there is one word.
//!
//! The protocol is little-endian. A packet begins with its length, which counts itself, and its
//! kind; strings end with a zero byte. The crate `tev_client` speaks it too, but asserts where it
//! could refuse, and has had no release since January 2022; three packets are less to look after.
//!
//! Source: tev, <https://github.com/Tom94/tev>, `include/tev/Ipc.h` and `src/Ipc.cpp`.

use crate::failure::Failure;
use rutilant::Session;
use rutilant::image::{Channel, Image};
use rutilant::settings::Crop;
use std::fmt;
use std::io::{ErrorKind, Read, Write};
use std::net::{Ipv6Addr, Shutdown, TcpStream, ToSocketAddrs};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError, Weak};
use std::time::{Duration, Instant};

/// Where a viewer listens.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Address {
    /// A name, or the numbers of IPv4, or those of IPv6 without brackets.
    host: String,
    port: u16,
}

/// Where tev listens unless it is told otherwise.
const PORT: u16 = 14158;

/// A viewer that is taking nothing for so long is given up.
const STALL: Duration = Duration::from_secs(5);

/// The end of the run waits for the last picture to arrive, but not longer.
const FAREWELL: Duration = Duration::from_secs(5);

impl Address {
    /// `host`, `host:port`, `[::1]` or `[::1]:port`.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        const FORM: &str = "write it as HOST:PORT, like localhost:14158 or [::1]:14158";
        let (host, rest) = match text.strip_prefix('[') {
            Some(inner) => inner.split_once(']').ok_or(FORM)?,
            None => text.split_at(text.find(':').unwrap_or(text.len())),
        };
        let is_of_names = |c: char| c.is_alphanumeric() || matches!(c, '-' | '.' | '_');
        let well_formed = if text.starts_with('[') {
            // Behind a percent sign a zone may be named, as in fe80::1%eth0.
            let (ip, zone) = host.split_once('%').unwrap_or((host, ""));
            ip.parse::<Ipv6Addr>().is_ok() && zone.chars().all(is_of_names)
        } else {
            // Digits alone are a port that was left without its host, and a hyphen begins an option.
            host.chars().all(is_of_names)
                && !host.chars().all(|c| c.is_ascii_digit())
                && !host.starts_with('-')
        };
        if !well_formed {
            return Err(FORM.to_owned());
        }
        let port = match rest.strip_prefix(':') {
            None if rest.is_empty() => PORT,
            None => return Err(FORM.to_owned()),
            Some(_) if !text.starts_with('[') && text.matches(':').count() > 1 => {
                return Err(FORM.to_owned());
            }
            Some(digits) => match digits.parse() {
                Ok(port) if port > 0 && digits.starts_with(|c: char| c.is_ascii_digit()) => port,
                _ => return Err(format!("\"{digits}\" is no port; ports are 1 to 65535")),
            },
        };
        Ok(Self { host: host.to_owned(), port })
    }

    /// Connects with the viewer that listens here.
    pub(crate) fn connect(&self) -> Result<Connection, Failure> {
        /// For each of the addresses that a host may have.
        const PATIENCE: Duration = Duration::from_secs(3);
        let addresses = (&*self.host, self.port).to_socket_addrs().map_err(|error| {
            Failure::failed(format!("cannot find the host of tev, \"{}\": {error}", self.host))
        })?;
        let mut reason = ErrorKind::AddrNotAvailable;
        for address in addresses {
            match TcpStream::connect_timeout(&address, PATIENCE) {
                Ok(stream) => return Ok(Connection { stream, address: self.clone() }),
                Err(error) => reason = error.kind(),
            }
        }
        Err(Failure::failed(format!(
            "no tev at {self} ({reason}); start it there, or render without --tev"
        )))
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { host, port } = self;
        if host.contains(':') { write!(f, "[{host}]:{port}") } else { write!(f, "{host}:{port}") }
    }
}

/// A viewer that shows nothing yet.
pub(crate) struct Connection {
    stream: TcpStream,
    address: Address,
}

/// A viewer that shows a rendering.
pub(crate) struct Viewer {
    shared: Arc<Shared>,
    address: Address,
    /// Its end has been asked for and told.
    told: bool,
}

struct Shared {
    state: Mutex<State>,
    /// Told whenever `state` changes.
    changed: Condvar,
}

#[derive(Default)]
struct State {
    /// The picture after which no other comes.
    last: Option<Arc<Image>>,
    /// Set when nothing is sent any more: the last picture has arrived, or what went wrong.
    end: Option<Result<(), String>>,
}

impl Connection {
    /// Shows how `session` goes on, by so many `threads`, as an image called `name`.
    pub(crate) fn show(
        self,
        name: String,
        session: &Arc<Session>,
        threads: usize,
    ) -> Result<Viewer, Failure> {
        let Self { stream, address } = self;
        let shared = Arc::new(Shared { state: Mutex::default(), changed: Condvar::new() });
        // Made here, for a short rendering may be over before the thread begins.
        let first = create(&name, &session.snapshot());
        let (theirs, session) = (Arc::clone(&shared), Arc::downgrade(session));
        let send = move || {
            let end = show(stream, &name, &first, &session, threads, &theirs);
            let end = end.map_err(|error| match error.kind() {
                // How systems say that a time limit is over.
                ErrorKind::WouldBlock | ErrorKind::TimedOut => {
                    format!("it has taken nothing for {} s", STALL.as_secs())
                }
                kind => kind.to_string(),
            });
            theirs.state().end = Some(end);
            theirs.changed.notify_all();
        };
        std::thread::Builder::new()
            .name("tev".to_owned())
            .spawn(send)
            .map_err(|error| Failure::failed(format!("cannot start a thread: {error}")))?;
        Ok(Viewer { shared, address, told: false })
    }
}

impl Viewer {
    /// What went wrong, if that has not been told yet.
    pub(crate) fn trouble(&mut self) -> Option<String> {
        let reason = match &self.shared.state().end {
            Some(Err(reason)) if !self.told => reason.clone(),
            _ => return None,
        };
        self.told = true;
        Some(format!("the connection with tev at {} has ended: {reason}", self.address))
    }

    /// Shows `image`, and nothing after it.
    pub(crate) fn show_last(&self, image: Arc<Image>) {
        self.shared.state().last = Some(image);
        self.shared.changed.notify_all();
    }

    /// Waits a while for the last picture to arrive. Returns what went wrong, if that has not been
    /// told yet.
    pub(crate) fn finish(mut self) -> Option<String> {
        let state = self.shared.state();
        let (state, waited) = self
            .shared
            .changed
            .wait_timeout_while(state, FAREWELL, |state| state.end.is_none())
            .unwrap_or_else(PoisonError::into_inner);
        drop(state);
        if waited.timed_out() {
            let (address, seconds) = (&self.address, FAREWELL.as_secs());
            return Some(format!("tev at {address} has not taken the last picture in {seconds} s"));
        }
        self.trouble()
    }
}

impl Shared {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The last picture, as soon as it is there, but not later than after `pause`.
    fn last_within(&self, pause: Duration) -> Option<Arc<Image>> {
        let state = self.state();
        let (state, _) = self
            .changed
            .wait_timeout_while(state, pause, |state| state.last.is_none())
            .unwrap_or_else(PoisonError::into_inner);
        state.last.clone()
    }
}

/// Sends the packet `first`, and pictures of `session` until the last one has arrived.
fn show(
    mut stream: TcpStream,
    name: &str,
    first: &[u8],
    session: &Weak<Session>,
    threads: usize,
    shared: &Shared,
) -> std::io::Result<()> {
    /// How often to look whether the first pass is over.
    const LOOK: Duration = Duration::from_millis(50);
    let start = Instant::now();
    stream.set_write_timeout(Some(STALL))?;
    stream.set_read_timeout(Some(STALL))?;

    // A black image of the right size shows that the viewer has been found.
    stream.write_all(first)?;

    // Pictures on the way, at moments that are worth it. What is left of one when the last is
    // there would only be painted over.
    let mut pause = LOOK;
    let last = loop {
        if let Some(last) = shared.last_within(pause) {
            break last;
        }
        let Some(session) = session.upgrade() else { continue };
        if session.progress().samples == 0 {
            continue;
        }
        let image = session.snapshot();
        drop(session);
        let mut packed = Duration::ZERO;
        for area in areas(&image) {
            if shared.state().last.is_some() {
                break;
            }
            let packing = Instant::now();
            let packet = update(name, &image, area);
            packed += packing.elapsed();
            stream.write_all(&packet)?;
        }
        pause = pause_after(start.elapsed(), packed, threads);
    };

    // The last picture. When the viewer closes its end as well, it has read everything; it never
    // says anything itself.
    for area in areas(&last) {
        stream.write_all(&update(name, &last, area))?;
    }
    stream.shutdown(Shutdown::Write)?;
    while stream.read(&mut [0; 64])? > 0 {}
    Ok(())
}

/// How long to wait for the next picture, when a rendering by so many `threads` began `elapsed`
/// ago, and the packets of the picture just sent took the time `packed` to make.
fn pause_after(elapsed: Duration, packed: Duration, threads: usize) -> Duration {
    const SHORTEST: Duration = Duration::from_millis(500);
    const LONGEST: Duration = Duration::from_secs(30);
    /// A picture with a twentieth more samples has a fortieth less noise, which nobody sees.
    const GROWTH: u32 = 20;
    /// The whole work in packings: seven for taking the picture, as measured, one for the packing,
    /// and the system and the viewer move the numbers too. Only packing never waits for others.
    const PACKINGS: u32 = 10;
    /// So much longer than that work all threads render: it costs three per cent.
    const SHARE: u32 = 33;
    let work = packed.saturating_mul(PACKINGS * SHARE) / u32::try_from(threads.max(1)).unwrap_or(1);
    (elapsed / GROWTH).clamp(SHORTEST, LONGEST).max(work)
}

/// The parts that `image` is sent in, row by row from above.
fn areas(image: &Image) -> impl Iterator<Item = Crop> + use<> {
    /// Numbers in a packet: with its head it fits in the mebibyte that tev reads at once.
    const MOST: u32 = 250_000;
    let (width, height) = (image.width(), image.height());
    let pixels = MOST / (told(image).len() as u32).clamp(1, MOST);
    let columns = width.clamp(1, pixels);
    let rows = pixels / columns;
    let row = move |y| {
        let height = rows.min(height - y);
        (0..width).step_by(columns as usize).map(move |x| {
            let width = columns.min(width - x);
            Crop { x, y, width, height }
        })
    };
    (0..height).step_by(rows as usize).flat_map(row)
}

/// The channels of light: the others are for files, and those of mattes become more where later
/// samples see more, which tev could not show.
fn told(image: &Image) -> Vec<&Channel> {
    let of_light = |channel: &&Channel| {
        let layer = channel.name.rsplit_once('.').map_or("", |(layer, _)| layer);
        ["", "variance", "samples"].contains(&layer)
    };
    image.channels().iter().filter(of_light).collect()
}

/// The packet that makes a black image with the size and the channels of `image`, and brings it
/// to the front. If there is one of this name, it is replaced.
fn create(name: &str, image: &Image) -> Vec<u8> {
    let mut packet = Packet::new(4, 0);
    packet.byte(1);
    packet.text(name);
    packet.numbers([image.width(), image.height()]);
    packet.names(&told(image));
    packet.finish()
}

/// The packet that puts the part `area` of `image` in its place, and leaves in front what is there.
fn update(name: &str, image: &Image, area: Crop) -> Vec<u8> {
    let Crop { x, y, width, height } = area;
    let channels = told(image);
    let pixels = u64::from(width) * u64::from(height);
    let mut packet = Packet::new(6, channels.len() * pixels as usize * 4);
    packet.byte(0);
    packet.text(name);
    packet.names(&channels);
    packet.numbers([x, y, width, height]);
    // Channel after channel: where each begins, and how far apart its values are.
    (0..channels.len() as u64).for_each(|i| packet.long(i * pixels));
    channels.iter().for_each(|_| packet.long(1));
    for Channel { values, .. } in channels {
        let rows = values.chunks_exact((image.width() as usize).max(1));
        for row in rows.skip(y as usize).take(height as usize) {
            packet.floats(&row[x as usize..][..width as usize]);
        }
    }
    packet.finish()
}

/// A packet in the making.
struct Packet(Vec<u8>);

impl Packet {
    /// Of a kind, with room for so many bytes and a head.
    fn new(kind: u8, room: usize) -> Self {
        let mut bytes = Vec::with_capacity(room + 512);
        bytes.extend([0, 0, 0, 0, kind]);
        Self(bytes)
    }

    fn byte(&mut self, byte: u8) {
        self.0.push(byte);
    }

    fn text(&mut self, text: &str) {
        // A zero would end it early.
        self.0.extend(text.bytes().filter(|byte| *byte != 0));
        self.0.push(0);
    }

    /// Counts and places in pixels: signed in the protocol, but never so large here that it matters.
    fn numbers<const N: usize>(&mut self, numbers: [u32; N]) {
        numbers.iter().for_each(|n| self.0.extend(n.to_le_bytes()));
    }

    fn long(&mut self, number: u64) {
        self.0.extend(number.to_le_bytes());
    }

    fn names(&mut self, channels: &[&Channel]) {
        self.numbers([channels.len() as u32]);
        channels.iter().for_each(|channel| self.text(&channel.name));
    }

    fn floats(&mut self, values: &[f32]) {
        let from = self.0.len();
        self.0.resize(from + 4 * values.len(), 0);
        let places = self.0[from..].as_chunks_mut().0.iter_mut();
        places.zip(values).for_each(|(place, value)| *place = value.to_le_bytes());
    }

    /// With its length in front, which `areas` keeps far below 2³².
    fn finish(mut self) -> Vec<u8> {
        let length = self.0.len() as u32;
        self.0[..4].copy_from_slice(&length.to_le_bytes());
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn address(host: &str, port: u16) -> Result<Address, String> {
        Ok(Address { host: host.to_owned(), port })
    }

    #[test]
    fn addresses_are_hosts_and_ports() {
        assert_eq!(Address::parse("localhost"), address("localhost", 14158));
        assert_eq!(Address::parse("10.0.0.7:80"), address("10.0.0.7", 80));
        assert_eq!(Address::parse("my-desk.example.org:9"), address("my-desk.example.org", 9));
        assert_eq!(Address::parse("[::1]"), address("::1", 14158));
        assert_eq!(Address::parse("[fe80::1%eth0]:65535"), address("fe80::1%eth0", 65535));
        for wrong in [
            "",
            ":",
            ":14158",
            "14158",
            "localhost:",
            "localhost:0",
            "localhost:65536",
            "localhost:-1",
            "localhost:+1",
            "localhost:1:2",
            "localhost: 1",
            "a host:1",
            "-",
            "--quiet",
            "::1",
            "::1:14158",
            "[::1",
            "[::1]14158",
            "[::1]:",
            "[localhost]:1",
            "[fe80::1%a b]:1",
            "[]",
            "]",
            "tcp://localhost:1",
            "localhost/",
            "me@localhost",
        ] {
            assert!(Address::parse(wrong).is_err(), "{wrong}");
        }
        for text in ["localhost:14158", "[::1]:14158"] {
            assert_eq!(Address::parse(text).map(|a| a.to_string()).as_deref(), Ok(text));
        }
    }

    /// Three by two pixels: the value is the place, and the channel the sign.
    fn small() -> Image {
        let channel = |name: &str, sign: f32| Channel {
            name: name.to_owned(),
            values: (0_u8..6).map(|i| sign * f32::from(i)).collect(),
        };
        Image::new(3, 2, vec![channel("R", 1.0), channel("samples.Y", -1.0)]).unwrap()
    }

    /// Byte by byte what tev reads (`IpcPacket::interpretAsCreateImage`).
    #[test]
    fn an_image_is_created_as_tev_reads_it() {
        let expected = [
            &[38, 0, 0, 0, 4, 1][..],
            b"kitchen\0",
            &[3, 0, 0, 0, 2, 0, 0, 0, 2, 0, 0, 0],
            b"R\0",
            b"samples.Y\0",
        ];
        assert_eq!(create("kitchen", &small()), expected.concat());
    }

    /// Byte by byte what tev reads (`IpcPacket::interpretAsUpdateImage`, third version): the two
    /// pixels on the right of the second row.
    #[test]
    fn a_part_is_updated_as_tev_reads_it() {
        let expected = [
            &[88, 0, 0, 0, 6, 0][..],
            b"k\0",
            &[2, 0, 0, 0],
            b"R\0",
            b"samples.Y\0",
            &[1, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 1, 0, 0, 0],
            &[0, 0, 0, 0, 0, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0],
            &[1, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0],
            // 4 is 0x40800000 and 5 is 0x40a00000.
            &[0, 0, 0x80, 0x40, 0, 0, 0xa0, 0x40],
            &[0, 0, 0x80, 0xc0, 0, 0, 0xa0, 0xc0],
        ];
        let area = Crop { x: 1, y: 1, width: 2, height: 1 };
        assert_eq!(update("k", &small(), area), expected.concat());
    }

    /// A picture with layers is told as one without: the channels of an image in tev are those that it
    /// was made with, and mattes may need more of them later.
    #[test]
    fn layers_are_not_told() {
        let mut channels = small().channels().to_vec();
        for name in ["albedo.R", "object.id", "CryptoObject00.R"] {
            channels.push(Channel { name: name.to_owned(), values: vec![9.0; 6] });
        }
        let layered = Image::new(3, 2, channels).unwrap();
        let area = Crop { x: 0, y: 0, width: 3, height: 2 };
        assert_eq!(create("k", &layered), create("k", &small()));
        assert_eq!(update("k", &layered, area), update("k", &small(), area));
    }

    /// The parts of any picture lie side by side and cover it, and no packet is more than tev
    /// reads at once.
    #[test]
    fn parts_cover_the_picture_in_moderate_packets() {
        for (width, height, channels) in
            [(1, 1, 1), (640, 480, 7), (3, 100_000, 3), (300_000, 2, 1), (50_001, 3, 7)]
        {
            let channel = |i: usize| Channel {
                name: format!("channel {i}"),
                values: vec![0.0; width as usize * height as usize],
            };
            let image = Image::new(width, height, (0..channels).map(channel).collect()).unwrap();
            let mut seen = vec![0_u8; width as usize * height as usize];
            for area in areas(&image) {
                assert!(update("name", &image, area).len() <= 1 << 20);
                for y in area.y..area.y + area.height {
                    let from = (y * width + area.x) as usize;
                    seen[from..][..area.width as usize].iter_mut().for_each(|n| *n += 1);
                }
            }
            assert!(seen.iter().all(|n| *n == 1), "{width} x {height}, {channels}");
        }
    }

    /// Twice a second at first, ever less often later, and never so often that it costs the
    /// rendering more than a few per cent.
    #[test]
    fn pauses_grow_with_time_and_with_work() {
        let (second, no) = (Duration::from_secs(1), Duration::ZERO);
        assert_eq!(pause_after(no, no, 1), second / 2);
        assert_eq!(pause_after(60 * second, no, 1), 3 * second);
        assert_eq!(pause_after(36_000 * second, no, 1), 30 * second);
        for threads in [1, 2, 64] {
            let pause = pause_after(60 * second, second, threads).as_secs_f64();
            let work = 10.0 / threads as f64;
            assert!(work / pause <= 0.04, "{pause} s, {threads} threads");
        }
        assert!(pause_after(Duration::MAX, Duration::MAX, 1) > second);
    }
}
