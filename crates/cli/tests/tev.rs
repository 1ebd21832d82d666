//! `--tev`: what the viewer is sent is what is written, and no viewer can hold a rendering up.
//!
//! The viewer here is a small one of our own. It reads packets as tev does (`src/Ipc.cpp`).

use rutilant::image::Image;
use rutilant_formats::{Limits, image};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::io::Read;
use std::net::{TcpListener, TcpStream};
use std::process::{Command, Stdio};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// A ball under a sky, on a floor.
const BALL: &str = r#"
version = 1

[render]
size = [101, 97]
spp = 4

[camera]
position = [0, 1, 4]
look_at = [0, 0.6, 0]
fov_degrees = 40

[environment]
color = [0.2, 0.3, 0.5]

[[material]]
name = "grey"
type = "matte"
albedo = [0.6, 0.5, 0.4]

[[shape]]
type = "rectangle"
size = [6, 6]
rotate_degrees = [-90, 0, 0]
material = "grey"

[[shape]]
type = "sphere"
radius = 0.5
center = [0, 0.5, 0]
material = "grey"
"#;

// ---- the program ----

/// A folder with the scene in it, where the program runs.
struct Desk(TempDir);

/// What a run left behind.
struct Ran {
    status: Option<i32>,
    out: String,
    error: String,
    time: Duration,
}

impl Desk {
    fn new() -> Self {
        let folder = TempDir::new().unwrap();
        fs::write(folder.path().join("ball.v2.toml"), BALL).unwrap();
        Self(folder)
    }

    fn run(&self, arguments: &str) -> Ran {
        let start = Instant::now();
        let output = Command::new(env!("CARGO_BIN_EXE_rutilant"))
            .current_dir(self.0.path())
            .args(["render", "ball.v2.toml", "-o", "a.exr"])
            .args(arguments.split_whitespace())
            .stdin(Stdio::null())
            .output()
            .unwrap();
        Ran {
            status: output.status.code(),
            out: String::from_utf8(output.stdout).unwrap(),
            error: String::from_utf8(output.stderr).unwrap(),
            time: start.elapsed(),
        }
    }

    fn image(&self) -> Image {
        image::read(&self.0.path().join("a.exr"), &Limits::default()).unwrap()
    }

    fn wrote(&self) -> bool {
        self.0.path().join("a.exr").exists()
    }
}

impl Ran {
    fn json(&self) -> Value {
        assert_eq!(self.status, Some(0), "{}", self.error);
        serde_json::from_str(&self.out).unwrap()
    }

    /// The notes about the viewer in the result.
    fn notes(&self) -> Vec<String> {
        let result = self.json();
        let notes = result["notes"].as_array().unwrap().iter();
        notes.map(|n| n.as_str().unwrap().to_owned()).filter(|n| n.contains("tev")).collect()
    }
}

// ---- the viewer ----

/// What a viewer shows in the end, and how it came there.
#[derive(Default)]
struct Shown {
    name: String,
    size: [usize; 2],
    channels: BTreeMap<String, Vec<f32>>,
    /// How often the lower right pixel was sent, which comes last.
    pictures: usize,
    /// Packets that took the focus.
    grabs: usize,
    largest_packet: usize,
}

/// Listens where a system gives it room, and does `serve` with the first who comes.
fn viewer<T: Send + 'static>(
    host: &str,
    serve: impl FnOnce(TcpStream) -> T + Send + 'static,
) -> Option<(String, JoinHandle<T>)> {
    let listener = TcpListener::bind(format!("{host}:0")).ok()?;
    let address = listener.local_addr().unwrap().to_string();
    Some((address, std::thread::spawn(move || serve(listener.accept().unwrap().0))))
}

/// Reads all that is sent, as tev does.
fn show(mut stream: TcpStream) -> Shown {
    let mut shown = Shown::default();
    let mut length = [0; 4];
    while stream.read_exact(&mut length).is_ok() {
        let length = u32::from_le_bytes(length) as usize;
        let mut packet = vec![0; length.checked_sub(4).unwrap()];
        stream.read_exact(&mut packet).unwrap();
        shown.largest_packet = shown.largest_packet.max(length);
        let mut packet = Packet(&packet);
        let [kind, grab] = packet.take();
        shown.grabs += usize::from(grab == 1);
        let name = packet.text();
        match kind {
            4 => {
                assert_eq!(shown.name, "", "a second image: {name}");
                shown.name = name;
                shown.size = [packet.int(), packet.int()];
                let zeros = vec![0.0; shown.size[0] * shown.size[1]];
                let names: Vec<String> = (0..packet.int()).map(|_| packet.text()).collect();
                shown.channels = names.into_iter().map(|name| (name, zeros.clone())).collect();
            }
            6 => {
                assert_eq!(shown.name, name);
                let names: Vec<String> = (0..packet.int()).map(|_| packet.text()).collect();
                let [x, y, width, height] = [(); 4].map(|()| packet.int());
                let offsets: Vec<usize> = names.iter().map(|_| packet.long()).collect();
                let strides: Vec<usize> = names.iter().map(|_| packet.long()).collect();
                let mut values = Vec::new();
                while !packet.0.is_empty() {
                    values.push(f32::from_le_bytes(packet.take()));
                }
                assert!(x + width <= shown.size[0] && y + height <= shown.size[1]);
                for ((name, offset), stride) in names.iter().zip(offsets).zip(strides) {
                    let channel = shown.channels.get_mut(name).unwrap();
                    for i in 0..width * height {
                        let at = (y + i / width) * shown.size[0] + x + i % width;
                        channel[at] = values[offset + i * stride];
                    }
                }
                let is_last = [x + width, y + height] == shown.size;
                shown.pictures += usize::from(is_last);
            }
            other => panic!("a packet of kind {other}"),
        }
        assert!(packet.0.is_empty());
    }
    shown
}

/// What is left of a packet.
struct Packet<'a>(&'a [u8]);

impl Packet<'_> {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        let (head, rest) = self.0.split_first_chunk().unwrap();
        self.0 = rest;
        *head
    }

    fn text(&mut self) -> String {
        let end = self.0.iter().position(|byte| *byte == 0).unwrap();
        let text = String::from_utf8(self.0[..end].to_vec()).unwrap();
        self.0 = &self.0[end + 1..];
        text
    }

    fn int(&mut self) -> usize {
        i32::from_le_bytes(self.take()).try_into().unwrap()
    }

    fn long(&mut self) -> usize {
        i64::from_le_bytes(self.take()).try_into().unwrap()
    }
}

/// Every number of every channel, bit by bit.
#[track_caller]
fn assert_shows(shown: &Shown, written: &Image) {
    assert_eq!(shown.size, [written.width() as usize, written.height() as usize]);
    let names = ["B", "G", "R", "samples.Y", "variance.B", "variance.G", "variance.R"];
    assert!(shown.channels.keys().eq(names));
    for (name, values) in &shown.channels {
        let bits = |values: &[f32]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(values), bits(written.channel(name).unwrap()), "{name}");
    }
    assert!(shown.channels["R"].iter().any(|r| *r > 0.0));
}

// ---- what is shown ----

/// The last picture that the viewer shows is the one in the file, in all channels; it changes no
/// bit of it, and is named after the scene. In a size that takes many packets none is larger than
/// a mebibyte.
#[test]
fn the_viewer_shows_what_is_written() {
    for (options, size) in [
        ("", [101, 97]),
        ("--size 900x700 --spp 2", [900, 700]),
        ("--size 101x97 --crop 20,30,64,32", [64, 32]),
    ] {
        let desk = Desk::new();
        let alone = desk.run(&format!("{options} --json"));
        let (address, viewer) = viewer("127.0.0.1", show).unwrap();
        let ran = desk.run(&format!("{options} --json --tev {address}"));
        let shown = viewer.join().unwrap();
        assert_eq!(ran.json()["hash"], alone.json()["hash"], "{options}");
        assert_eq!((shown.name.as_str(), shown.size), ("ball.v2", size), "{options}");
        assert_shows(&shown, &desk.image());
        assert!(shown.pictures >= 1 && shown.largest_packet <= 1 << 20);
        // It comes to the front once, and may be put away.
        assert_eq!(shown.grabs, 1);
        assert_eq!(ran.notes(), [""; 0]);
    }
}

/// While the rendering goes on there is something to see, but hardly more than twice a second.
#[test]
fn pictures_come_on_the_way() {
    let desk = Desk::new();
    let (address, viewer) = viewer("127.0.0.1", show).unwrap();
    // Some fifteen passes, which take longer than half a second on any machine.
    let ran = desk.run(&format!("--threads 1 --spp 800 --tev {address}"));
    let shown = viewer.join().unwrap();
    assert_eq!(ran.status, Some(0), "{}", ran.error);
    assert_shows(&shown, &desk.image());
    // The first, one on the way, and the last at least; the first and the last come on their own.
    let most = 2 + (ran.time.as_secs_f64() / 0.5) as usize;
    assert!((3..=most).contains(&shown.pictures), "{} in {:?}", shown.pictures, ran.time);
}

/// Where there is IPv6 its addresses are understood.
#[test]
fn addresses_in_brackets_are_understood() {
    let Some((address, viewer)) = viewer("[::1]", show) else { return };
    let desk = Desk::new();
    let ran = desk.run(&format!("--tev {address}"));
    assert_eq!(ran.status, Some(0), "{}", ran.error);
    assert_shows(&viewer.join().unwrap(), &desk.image());
}

/// Nothing but the result is said where that was asked for.
#[test]
fn a_viewer_makes_no_noise() {
    let desk = Desk::new();
    let (address, viewer) = viewer("127.0.0.1", show).unwrap();
    let ran = desk.run(&format!("--quiet --progress json --tev {address}"));
    viewer.join().unwrap();
    assert_eq!((ran.status, &*ran.error), (Some(0), ""));
    assert!(ran.out.lines().all(|line| serde_json::from_str::<Value>(line).is_ok()));
}

// ---- what goes wrong ----

/// A viewer that goes away is told of once, and the picture is the same as without it.
#[test]
fn a_viewer_that_leaves_is_told_of_once() {
    let leave = |mut stream: TcpStream| stream.read_exact(&mut [0; 100]).unwrap();
    let desk = Desk::new();
    let alone = desk.run("--json --spp 64").json();
    for quiet in ["", "--quiet"] {
        let (address, viewer) = viewer("127.0.0.1", leave).unwrap();
        let ran = desk.run(&format!("--json --spp 64 {quiet} --tev {address}"));
        viewer.join().unwrap();
        assert_eq!(ran.json()["hash"], alone["hash"]);
        let notes = ran.notes();
        assert!(matches!(&notes[..], [one] if one.contains(&address)), "{notes:?}");
        let told = ran.error.lines().filter(|line| line.contains("tev")).collect::<Vec<_>>();
        match (quiet, &told[..]) {
            ("", [line]) => assert!(line.starts_with(&format!("note: {}", notes[0])), "{line}"),
            ("--quiet", []) => assert_eq!(ran.error, ""),
            _ => panic!("{told:?}"),
        }
    }
}

/// A viewer that takes nothing holds up neither the rendering nor, for long, the end: with a small
/// picture, which systems take for it, and with one that they do not.
#[test]
fn a_viewer_that_never_reads_is_left_behind() {
    for options in ["", "--size 1500x1000 --spp 1 --integrator normals"] {
        // The connection stays open until the run has ended.
        let (address, viewer) = viewer("127.0.0.1", |stream| stream).unwrap();
        let desk = Desk::new();
        let alone = desk.run(&format!("{options} --json"));
        let ran = desk.run(&format!("{options} --json --tev {address}"));
        drop(viewer.join().unwrap());
        assert_eq!(ran.json()["hash"], alone.json()["hash"]);
        assert!(desk.wrote());
        assert_eq!(ran.notes().len(), 1, "{:?}", ran.notes());
        let longer = ran.time.saturating_sub(alone.time);
        assert!(longer < Duration::from_secs(12), "{longer:?}");
        let rendering = ran.json()["seconds"]["render"].as_f64().unwrap();
        let before = alone.json()["seconds"]["render"].as_f64().unwrap();
        assert!(rendering < 2.0 * before + 2.0, "{rendering} s, and {before} s without it");
    }
}

/// Without a viewer there is one line, and nothing has begun.
#[test]
fn a_viewer_that_is_not_there_is_missed_at_once() {
    let desk = Desk::new();
    let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    for host in ["127.0.0.1", "localhost"] {
        let ran = desk.run(&format!("--time 1h --tev {host}:{port}"));
        let expected = format!(
            "error: no tev at {host}:{port} (connection refused); \
             start it there, or render without --tev\n"
        );
        assert_eq!((ran.status, ran.error), (Some(1), expected));
        assert!(ran.out.is_empty() && !desk.wrote());
    }
}

/// What is no address is a mistake in the command line.
#[test]
fn addresses_that_are_none_are_bad_usage() {
    let desk = Desk::new();
    for wrong in ["14158", "localhost:", "localhost:0", "localhost:70000", "::1", "[::1", "-", ":1"]
    {
        let ran = desk.run(&format!("--tev {wrong}"));
        assert_eq!(ran.status, Some(2), "{wrong}: {}", ran.error);
        assert_eq!(ran.error.lines().count(), 1, "{wrong}: {}", ran.error);
        assert!(ran.error.contains("HOST:PORT") && !desk.wrote(), "{wrong}: {}", ran.error);
    }
}
