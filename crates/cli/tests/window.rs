//! The real window on a display of its own, with real keys and a look at the screen.
//!
//! Needs Xvfb, xdotool and ImageMagick's `import` (Debian: xvfb, xdotool, imagemagick,
//! libgl1-mesa-dri, libegl1, libxkbcommon-x11-0, libxcursor1, libxi6, libxrandr2). Without them it
//! says that it skips.
#![cfg(all(feature = "window", target_os = "linux"))]

use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

const SCENE: &str = r#"version = 1

[render]
size = [320, 240]
spp = 8

CAMERA
[environment]
color = [0.2, 0.4, 0.9]

[[material]]
name = "clay"
type = "matte"
albedo = [0.7, 0.3, 0.2]

[[shape]]
type = "rectangle"
size = [8, 8]
rotate_degrees = [-90, 0, 0]
material = "clay"
"#;

const CAMERA: &str = "[camera]\nposition = [0, 1.5, 5]\nlook_at = [0, 1, 0]\n";

const PATIENCE: Duration = Duration::from_secs(60);

/// Ends what it holds.
struct Ends(Child);

impl Drop for Ends {
    fn drop(&mut self) {
        // It may have ended by itself.
        drop(self.0.kill());
        drop(self.0.wait());
    }
}

fn is_there(tool: &str) -> bool {
    let path = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&path).any(|folder| folder.join(tool).is_file())
}

/// The lines that a program prints, as they come.
fn lines(out: impl std::io::Read + Send + 'static) -> Receiver<String> {
    let (sender, receiver) = channel();
    std::thread::spawn(move || {
        for line in BufReader::new(out).lines().map_while(Result::ok) {
            if sender.send(line).is_err() {
                break;
            }
        }
    });
    receiver
}

/// A display with a window on it.
struct Stage {
    folder: tempfile::TempDir,
    display: String,
    window: Ends,
    events: Receiver<String>,
    _server: Ends,
}

impl Stage {
    fn open(scene: &str) -> Option<Self> {
        let tools = ["Xvfb", "xdotool", "import"];
        if let Some(missing) = tools.into_iter().find(|tool| !is_there(tool)) {
            eprintln!("skipped: the window is not tested, for there is no {missing} here");
            return None;
        }
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1280x800x24", "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let number = lines(server.stdout.take().unwrap());
        let server = Ends(server);
        let display = format!(":{}", number.recv_timeout(PATIENCE).expect("a display").trim());

        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("scene.toml"), scene).unwrap();
        let mut window = Command::new(env!("CARGO_BIN_EXE_rutilant"))
            .args(["view", "scene.toml", "--json"])
            .current_dir(folder.path())
            .env("DISPLAY", &display)
            .env("XDG_RUNTIME_DIR", folder.path())
            .env("XDG_CONFIG_HOME", folder.path())
            .env("LIBGL_ALWAYS_SOFTWARE", "1")
            .env_remove("WAYLAND_DISPLAY")
            .stdout(Stdio::piped())
            .stderr(Stdio::inherit())
            .spawn()
            .unwrap();
        let events = lines(window.stdout.take().unwrap());
        Some(Self { folder, display, window: Ends(window), events, _server: server })
    }

    /// The next event of this name for which `holds`.
    fn event(&self, name: &str, holds: impl Fn(&Value) -> bool) -> Value {
        let end = Instant::now() + PATIENCE;
        loop {
            let left = end.saturating_duration_since(Instant::now());
            let line = self.events.recv_timeout(left);
            let line = line.unwrap_or_else(|_| panic!("the event \"{name}\" did not come"));
            let event: Value = serde_json::from_str(&line).unwrap();
            if event["event"] == name && holds(&event) {
                return event;
            }
        }
    }

    /// Presses keys, moves the mouse.
    fn input(&self, words: &[&str]) {
        let mut tool = Command::new("xdotool");
        assert!(tool.args(words).env("DISPLAY", &self.display).status().unwrap().success());
    }

    /// Red, green and blue of some points of the screen.
    fn screenshot(&self, points: &[[u32; 2]]) -> Vec<[f32; 3]> {
        let file = self.folder.path().join("screen.png");
        let mut tool = Command::new("import");
        tool.args(["-window", "root"]).arg(&file).env("DISPLAY", &self.display);
        assert!(tool.status().unwrap().success());
        let limits = rutilant_formats::Limits::default();
        let image = rutilant_formats::image::read(&file, &limits).unwrap();
        let (width, pixels) = (image.width(), image.rgb().unwrap());
        points.iter().map(|[x, y]| pixels[(y * width + x) as usize]).collect()
    }
}

/// The hash that the command line gives for a scene.
fn headless(folder: &Path, scene: &str) -> Value {
    std::fs::write(folder.join("headless.toml"), scene).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_rutilant"))
        .args(["headless.toml", "--json", "--quiet", "-o", "headless.png"])
        .current_dir(folder)
        .output()
        .unwrap();
    let result: Value = serde_json::from_slice(&output.stdout).unwrap();
    result["hash"].clone()
}

/// The window comes up, shows the scene, moves by keys, prints where it is, and what it shows in
/// the end has the bits that the command line gives for the printed camera.
#[test]
fn a_window_is_opened_driven_and_closed() {
    let Some(mut stage) = Stage::open(&SCENE.replace("CAMERA", CAMERA)) else { return };
    stage.event("picture", |e| e["full"] == true);
    stage.input(&["search", "--sync", "--name", "Rutilant", "windowfocus", "--sync"]);

    // Sky above, clay in its light below, a panel to the right of both.
    std::thread::sleep(Duration::from_secs(1));
    let seen = stage.screenshot(&[[450, 150], [450, 600], [1180, 700]]);
    for (seen, light) in seen.iter().zip([[0.2, 0.4, 0.9], [0.14, 0.12, 0.18]]) {
        let near = seen.iter().zip(light).all(|(a, b): (&f32, f32)| (a - b).abs() < 0.02);
        assert!(near, "{seen:?} should be {light:?}");
    }
    let [r, g, b] = seen[2];
    assert!(r == g && g == b && r < 0.1, "the panel is {:?}", seen[2]);

    stage.input(&["key", "p"]);
    let pose = |event: &Value| event["toml"].as_str().unwrap_or_default().to_owned();
    let first = pose(&stage.event("pose", |_| true));
    assert_eq!(first, CAMERA);

    // Forward while it is held, then up by the mouse.
    stage.input(&["keydown", "w", "sleep", "0.4", "keyup", "w"]);
    stage.input(&["mousemove", "450", "400", "mousedown", "1"]);
    stage.input(&[
        "mousemove",
        "450",
        "420",
        "sleep",
        "0.1",
        "mousemove",
        "450",
        "440",
        "sleep",
        "0.1",
    ]);
    stage.input(&["mouseup", "1", "sleep", "0.3", "key", "p"]);
    let second = pose(&stage.event("pose", |_| true));
    assert_ne!(first, second);

    // All samples, without an event: the picture has come to rest when no more comes.
    while stage.events.recv_timeout(Duration::from_secs(3)).is_ok() {}
    stage.input(&["key", "Escape"]);
    let closed = stage.event("closed", |_| true);
    assert_eq!(closed["samples"], 8, "{closed}");
    let scene = SCENE.replace("CAMERA", &second);
    assert_eq!(closed["hash"], headless(stage.folder.path(), &scene), "{second}");
    assert!(stage.window.0.wait().unwrap().success());
}

/// Without a display there is one clear line, and no window.
#[test]
fn without_a_display_there_is_a_clear_error() {
    let output = Command::new(env!("CARGO_BIN_EXE_rutilant"))
        .arg("view")
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .output()
        .unwrap();
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{error}");
    assert_eq!(error.lines().count(), 1, "{error}");
    assert!(error.contains("there can be no window") && error.contains("DISPLAY"), "{error}");

    // One that is named, but not there.
    let output = Command::new(env!("CARGO_BIN_EXE_rutilant"))
        .arg("view")
        .env("DISPLAY", ":4711")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .output()
        .unwrap();
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{error}");
    assert_eq!(error.lines().count(), 1, "{error}");
    assert!(error.contains("there can be no window"), "{error}");
}
