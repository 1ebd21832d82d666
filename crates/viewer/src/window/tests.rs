//! The window without a screen: driven by its accessibility tree, keys and files.

use super::report::Happened;
use super::state::{Dialog, Window};
use crate::Describe;
use crate::keys::Action;
use crate::live::JobState;
use crate::picture::{Channel, View};
use crate::source::{BuiltIn, Reading};
use eframe::egui::accesskit::Role;
use eframe::egui::{
    DroppedFile, Event, Key, Modifiers, MouseWheelSource, MouseWheelUnit, TouchPhase, Ui, pos2,
    vec2,
};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use rutilant::color::Rgb;
use rutilant::image::Image;
use rutilant::light::Environment;
use rutilant::{Prepared, Session};
use rutilant_formats::Look;
use rutilant_formats::camera::{AngleOfView, CameraKind, FocusOn};
use rutilant_formats::image::WriteOptions;
use rutilant_formats::{CameraChoice, Limits, ReadOptions, SkyChoice, read_scene};
use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;
use std::time::Duration;

const SCENE: &str = r#"version = 1   # a comment that stays

[render]
size = [48, 36]
spp = 6

[camera]
position = [0, 1, 4]
look_at = [0, 0.5, 0]

[environment]
color = [0.6, 0.7, 0.9]

[[material]]
name = "floor"
type = "matte"
albedo = 0.6    # grey

[[material]]
name = "ball"
type = "dielectric"

[[shape]]
type = "rectangle"
size = [6, 6]
rotate_degrees = [-90, 0, 0]
material = "floor"

[[shape]]
type = "sphere"
radius = 0.5
center = [0, 0.5, 0]
material = "ball"
"#;

/// What the built-in scene has in its place of an even sky.
const SKY: &str = "image = \"skies/grey.pfm\"";

/// A window on a scene in a folder of its own.
struct Desk {
    folder: tempfile::TempDir,
    harness: Harness<'static, Option<Window>>,
    happened: Rc<RefCell<Vec<Happened>>>,
}

impl Desk {
    fn new() -> Self {
        let mut desk = Self::with(SCENE, |_| {});
        desk.until("a picture", Window::is_settled);
        desk
    }

    /// Opened with a scene, and with what `change` does to how it is read.
    fn with(text: &str, change: impl Fn(&mut Reading) + 'static) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("scene.toml");
        std::fs::write(&file, text).unwrap();
        let happened = Rc::new(RefCell::new(Vec::new()));
        let theirs = Rc::clone(&happened);
        let frame = move |ui: &mut Ui, window: &mut Option<Window>| {
            let window = window.get_or_insert_with(|| {
                let mut reading = Reading {
                    built_in: BuiltIn {
                        file: "built-in.toml",
                        text: SCENE.replace("color = [0.6, 0.7, 0.9]", SKY).leak(),
                        images: &[("skies/grey.pfm", b"Pf 1 1 -1\n\0\0\x80\x3f")],
                    },
                    limits: Limits::default(),
                    allow_outside: false,
                    strict: false,
                    variant: None,
                    at_time: None,
                    parameters: Vec::new(),
                    camera: CameraChoice::First,
                    sky: SkyChoice::Own,
                    size: None,
                    adjust: Arc::new(|_| {}),
                };
                change(&mut reading);
                let report = Rc::clone(&theirs);
                let report = Box::new(move |what| report.borrow_mut().push(what));
                let describe: Describe = Arc::new(|settings, samples| {
                    vec![("seed".into(), format!("{} {samples}", settings.seed))]
                });
                Window::new(ui.ctx(), reading, 2, Some(file.clone()), None, describe, report)
            });
            window.ui(ui);
        };
        let harness = Harness::builder().with_size([900.0, 700.0]).build_ui_state(frame, None);
        let mut desk = Self { folder, harness, happened };
        desk.harness.step();
        desk
    }

    fn file(&self) -> PathBuf {
        self.folder.path().join("scene.toml")
    }

    fn window(&self) -> &Window {
        self.harness.state().as_ref().unwrap()
    }

    fn window_mut(&mut self) -> &mut Window {
        self.harness.state_mut().as_mut().unwrap()
    }

    fn look(&self) -> Arc<Look> {
        Arc::clone(self.window().history.as_ref().unwrap().present())
    }

    /// Draws frames until something holds.
    fn until(&mut self, what: &str, holds: impl Fn(&Window) -> bool) {
        for _ in 0..3000 {
            self.harness.step();
            if holds(self.window()) {
                return;
            }
            std::thread::sleep(Duration::from_millis(4));
        }
        panic!(
            "{what} did not come: {:?} {:?}",
            self.window().live.status(),
            self.window().trouble
        );
    }

    fn settle(&mut self) {
        self.harness.step();
        self.until("the finished picture", Window::is_settled);
    }

    fn press(&mut self, key: Key) {
        self.harness.key_press(key);
        self.harness.step();
        self.harness.step();
    }

    fn click(&mut self, label: &str) {
        self.harness.get_by_label(label).click();
        self.harness.step();
        self.harness.step();
    }

    /// Lets go of everything, mends the file and waits until all is done.
    fn drop_file(&mut self, file: PathBuf) {
        self.harness.input_mut().dropped_files.push(Arc::new(Dropped(file)));
        self.harness.step();
    }

    fn rest(&mut self, keys: &[Key]) {
        keys.iter().for_each(|key| self.harness.key_up(*key));
        self.harness.drop_at(pos2(1.0, 1.0));
        std::fs::write(self.file(), SCENE).unwrap();
        self.harness.set_size(vec2(900.0, 700.0));
        let window = self.window_mut();
        (window.view, window.paused, window.endless) = (View::default(), false, false);
        (window.dialog, window.help) = (None, false);
        self.quiet();
    }

    /// Waits until all that follows a written file is done: a file may be seen to change twice.
    fn quiet(&mut self) {
        for _ in 0..60 {
            std::thread::sleep(Duration::from_millis(10));
            self.harness.step();
        }
        self.settle();
    }

    /// The hash of what the window shows.
    fn hash(&self) -> u64 {
        self.window().shown.as_ref().unwrap().picture.image.hash()
    }

    /// The hash of a fresh rendering of the present look.
    fn headless(&self) -> u64 {
        let loaded = read_scene(&self.file(), &ReadOptions::default()).unwrap();
        headless(loaded.scene, &self.look())
    }
}

impl Window {
    /// Whether the newest look is shown with all its samples.
    fn is_settled(&self) -> bool {
        let (Some(history), Some(shown)) = (&self.history, &self.shown) else { return false };
        let (look, image) = (history.present(), &shown.picture.image);
        let counts = image.channel("samples.Y").unwrap_or(&[]);
        self.opening.is_none()
            && Arc::ptr_eq(look, &shown.look)
            && shown.picture.size == look.settings.size
            && counts.iter().all(|&n| n as u64 >= look.settings.spp)
            && (shown.finished || self.endless)
    }
}

fn headless(mut scene: rutilant::scene::Scene, look: &Look) -> u64 {
    scene.camera = look.camera.camera(look.settings.size).unwrap();
    scene.environment = look.environment;
    scene.materials.clone_from(&look.materials);
    scene.lights.clone_from(&look.lights);
    let prepared = Arc::new(Prepared::new(&scene).unwrap());
    let session = Session::start(prepared, look.settings.clone(), 1).unwrap();
    while !session.wait(Duration::from_secs(1)) {}
    session.snapshot().hash()
}

/// What the window shows once it is done is what the command line renders.
#[test]
fn the_picture_is_the_command_lines() {
    let desk = Desk::new();
    assert_eq!(desk.hash(), desk.headless());
    desk.harness.get_by_label("Materials");
    desk.harness.get_by_label("Camera and lens");
}

/// Keys move; what P prints, read by the command line, gives the window's bits.
#[test]
fn the_printed_pose_gives_the_same_bits() {
    let mut desk = Desk::new();
    let before = desk.look();
    desk.harness.key_down(Key::W);
    desk.harness.key_down(Key::ArrowLeft);
    (0..20).for_each(|_| desk.harness.step());
    desk.harness.key_up(Key::W);
    desk.harness.key_up(Key::ArrowLeft);
    desk.settle();
    assert_ne!(desk.look().camera, before.camera);
    desk.press(Key::P);
    desk.settle();
    let toml = desk.happened.borrow().iter().find_map(|happened| match happened {
        Happened::Pose { toml } => Some(toml.clone()),
        _ => None,
    });
    let (head, tail) = SCENE.split_once("[camera]").unwrap();
    let (_, tail) = tail.split_once("[environment]").unwrap();
    let text = format!("{head}{}\n[environment]{tail}", toml.unwrap());
    let file = desk.folder.path().join("pose.toml");
    std::fs::write(&file, text).unwrap();
    let loaded = read_scene(&file, &ReadOptions::default()).unwrap();
    let (scene, look) = (loaded.scene.clone(), loaded.look());
    assert_eq!(headless(scene, &look), desk.hash());
}

/// H shows direct light alone, and all light again; holding it down changes nothing more.
#[test]
fn h_toggles_depth_once_a_press() {
    let mut desk = Desk::new();
    desk.harness.key_down(Key::H);
    (0..10).for_each(|_| desk.harness.step());
    desk.harness.key_up(Key::H);
    desk.harness.step();
    assert_eq!(desk.look().settings.max_depth, Some(2));
    desk.settle();
    assert_eq!(desk.hash(), desk.headless());
    desk.press(Key::H);
    assert_eq!(desk.look().settings.max_depth, None);
}

/// A change of a material is rendered, undone, done again and saved, comments kept.
#[test]
fn edits_are_undone_and_saved() {
    let mut desk = Desk::new();
    let before = desk.hash();
    let red = rutilant::color::Rgb([0.8, 0.1, 0.1]);
    desk.window_mut().edit(|look| {
        look.materials[0].kind =
            rutilant::material::MaterialKind::Matte(rutilant::material::Matte::new(red));
    });
    desk.settle();
    let edited = desk.hash();
    assert_ne!(edited, before);
    desk.click("Edit");
    desk.harness.get_by_label_contains("Undo").click();
    desk.settle();
    assert_eq!(desk.hash(), before);
    desk.harness.key_press_modifiers(Modifiers::COMMAND, Key::Y);
    desk.settle();
    assert_eq!(desk.hash(), edited);

    desk.harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    desk.until("a saved file", |w| !w.is_changed());
    let text = std::fs::read_to_string(desk.file()).unwrap();
    assert!(text.contains("# a comment that stays") && text.contains("# grey"), "{text}");

    // What was saved is not read again: the picture goes on.
    let opened = |desk: &Desk| {
        desk.happened.borrow().iter().filter(|h| matches!(h, Happened::Opened { .. })).count()
    };
    for _ in 0..100 {
        desk.harness.step();
        std::thread::sleep(Duration::from_millis(4));
    }
    assert_eq!((opened(&desk), desk.hash()), (1, edited));
    let loaded = read_scene(&desk.file(), &ReadOptions::default()).unwrap();
    assert_eq!(headless(loaded.scene.clone(), &loaded.look()), edited);
}

/// A broken file is told with its place while the last good scene is shown; once mended, it is
/// shown, and the camera is where it was.
#[test]
fn broken_files_keep_the_last_good_scene() {
    let mut desk = Desk::new();
    desk.press(Key::E);
    desk.settle();
    let (camera, before) = (desk.look().camera.clone(), desk.hash());
    std::fs::write(desk.file(), SCENE.replace("albedo = 0.6", "albedo = 1.6")).unwrap();
    desk.until("the error", |w| w.trouble.is_some());
    let trouble = desk.window().trouble.clone().unwrap();
    assert!(trouble.contains("scene.toml:17:10: albedo is 1.6"), "{trouble}");
    desk.harness.step();
    desk.harness.get_by_label(&trouble);
    desk.harness.get_by_label("The last good scene is still shown.");
    assert_eq!(desk.hash(), before);

    std::fs::write(desk.file(), SCENE.replace("albedo = 0.6", "albedo = 0.1")).unwrap();
    desk.until("the mended scene", |w| w.trouble.is_none());
    desk.settle();
    assert_eq!(desk.look().camera, camera);
    assert_ne!(desk.hash(), before);
    assert_eq!(desk.hash(), desk.headless());

    // Broken, and then the very text of before.
    let good = std::fs::read_to_string(desk.file()).unwrap();
    std::fs::write(desk.file(), "version = 1\n[camera").unwrap();
    desk.until("the error", |w| w.trouble.is_some());
    std::fs::write(desk.file(), good).unwrap();
    desk.until("the mended scene", |w| w.trouble.is_none());
}

/// The first scene cannot be read: the window says so, and opens another.
#[test]
fn nothing_to_show_is_told() {
    let mut desk = Desk::new();
    let bad = desk.folder.path().join("none.toml");
    desk.window_mut().open(Some(bad), false);
    desk.until("the error", |w| w.trouble.is_some());
    desk.press(Key::Escape);
    assert!(desk.window().trouble.is_none());
    desk.window_mut().open(None, false);
    desk.until("the built-in scene", |w| w.document.as_ref().is_some_and(|d| d.file.is_none()));
    desk.settle();
}

/// A picture rendered for a file has the command line's hash, and so does what is saved of the
/// window's own.
#[test]
fn files_have_the_command_lines_hash() {
    let mut desk = Desk::new();
    let file = desk.folder.path().join("out.exr");
    let name = file.display().to_string();
    desk.window_mut().answered(Dialog::Render { file: name, spp: 9, size: [31, 17] });
    desk.until("the file", |w| w.message.as_ref().is_some_and(|m| m.contains("hash")));
    let loaded = read_scene(&desk.file(), &ReadOptions::default()).unwrap();
    let mut look = loaded.look();
    (look.settings.spp, look.settings.size) = (9, [31, 17]);
    let hash = headless(loaded.scene.clone(), &look);
    let message = desk.window().message.clone().unwrap();
    assert!(message.ends_with(&format!("hash {hash:016x}")), "{message}");
    let written = rutilant_formats::image::read(&file, &Limits::default()).unwrap();
    assert_eq!((written.width(), written.height()), (31, 17));
    let bytes = std::fs::read(&file).unwrap();
    assert!(bytes.windows(3).any(|words| words == b"0 9"), "its seed and samples are kept with it");
}

/// Escape closes what is open first; with changes it asks before it closes the window.
#[test]
fn escape_closes_one_thing_at_a_time() {
    let mut desk = Desk::new();
    desk.press(Key::F1);
    desk.harness.get_by_label("Jump forward");
    desk.press(Key::Escape);
    assert!(!desk.window().help && !desk.window().closing);
    desk.click("File");
    desk.press(Key::Escape);
    assert!(!desk.window().closing && desk.harness.query_by_label("Copy image").is_none());
    desk.press(Key::B);
    desk.press(Key::Escape);
    assert!(!desk.window().closing && desk.window().beside.is_none());
    desk.window_mut().edit(|look| look.environment = None);
    desk.press(Key::Escape);
    assert!(desk.window().dialog.is_some() && !desk.window().closing);
    desk.click("Discard them");
    assert!(desk.window().closing);
}

/// While something is typed, keys are letters; Escape gives the keyboard back and closes nothing.
#[test]
fn what_is_typed_is_no_command() {
    let mut desk = Desk::new();
    desk.window_mut().edit(|look| look.environment = None);
    let before = desk.look();
    desk.harness.get_by_role_and_label(Role::SpinButton, "Blades").focus();
    desk.harness.step();
    desk.press(Key::E);
    assert_eq!(desk.look().camera, before.camera);
    desk.press(Key::Escape);
    assert!(desk.window().dialog.is_none() && !desk.window().closing);
    desk.press(Key::E);
    assert_ne!(desk.look().camera, before.camera);
}

/// A dialog offers what is in the folder, opens what is chosen, and tells what would be replaced.
#[test]
fn dialogs_offer_files() {
    let mut desk = Desk::new();
    std::fs::write(desk.folder.path().join("other.toml"), SCENE).unwrap();
    std::fs::write(desk.folder.path().join("notes.txt"), "").unwrap();
    desk.harness.key_press_modifiers(Modifiers::COMMAND, Key::O);
    desk.until("the dialog", |w| w.dialog.is_some());
    let listed = |desk: &Desk, name: &str| desk.harness.query_by_label(name).is_some();
    while !listed(&desk, "other.toml") {
        desk.harness.step();
        std::thread::sleep(Duration::from_millis(4));
    }
    assert!(listed(&desk, "scene.toml") && !listed(&desk, "notes.txt"));
    // What is typed takes the place of the name that was offered.
    desk.press(Key::Escape);
    let folder = desk.folder.path().display().to_string();
    desk.window_mut().dialog = Some(Dialog::SaveImage(format!("{folder}/a.exr")));
    (0..3).for_each(|_| desk.harness.step());
    desk.harness.event(Event::Text("b.png".into()));
    desk.harness.step();
    assert_eq!(desk.window().dialog, Some(Dialog::SaveImage(format!("{folder}/b.png"))));
    desk.window_mut().dialog = Some(Dialog::Open(format!("{folder}/")));
    (0..3).for_each(|_| desk.harness.step());
    desk.click("other.toml");
    desk.click("Open");
    desk.until("the other scene", |w| {
        w.document.as_ref().and_then(|d| d.file.as_ref()).is_some_and(|f| f.ends_with("other.toml"))
    });
    desk.settle();

    // What is there already is not replaced unasked.
    let there = desk.folder.path().join("there.png");
    std::fs::write(&there, "mine").unwrap();
    desk.window_mut().answered(Dialog::SaveImage(there.display().to_string()));
    desk.harness.step();
    desk.harness.get_by_label("This file is there already");
    desk.press(Key::Escape);
    assert!(desk.window().dialog.is_none() && !desk.window().closing);
    assert_eq!(std::fs::read(&there).unwrap(), b"mine");
    desk.window_mut().answered(Dialog::SaveImage(there.display().to_string()));
    desk.harness.step();
    desk.click("Replace it");
    desk.until("the file", |w| w.message.as_ref().is_some_and(|m| m.contains("wrote")));
    assert!(std::fs::read(&there).unwrap().starts_with(b"\x89PNG"));
}

/// Keys can be changed, and mean the new thing at once.
#[test]
fn keys_can_be_changed() {
    let mut desk = Desk::new();
    desk.press(Key::F1);
    desk.window_mut().remapping = Some(Action::JumpForward);
    desk.press(Key::N);
    desk.press(Key::F1);
    let before = desk.look();
    desk.press(Key::E);
    assert_eq!(desk.look().camera, before.camera);
    desk.press(Key::N);
    assert_ne!(desk.look().camera, before.camera);
}

/// A file that is dropped onto the window.
#[derive(Debug)]
struct Dropped(PathBuf);

impl DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|error| error.to_string())
    }
}

/// An image that is dropped onto the window becomes the sky, is saved with the scene, and stays
/// when the scene's file changes; a scene is opened.
#[test]
fn what_is_dropped_is_shown() {
    let mut desk = Desk::new();
    let sky = desk.folder.path().join("my sky.pfm");
    let pixels = [[0.1, 0.2, 0.9], [3.0, 2.0, 1.0], [0.0, 0.5, 0.0], [0.3, 0.3, 0.3]];
    let image = Image::from_rgb(4, 1, &pixels).unwrap();
    rutilant_formats::image::write(&sky, &image, &WriteOptions::default()).unwrap();
    desk.drop_file(sky);
    desk.until("the sky", |w| w.added_sky().is_some());
    desk.settle();
    let before = desk.hash();

    // Turned, and then the file changes. What was done before can still be undone.
    desk.window_mut().edit(|look| look.environment.as_mut().unwrap().rotation = 0.5);
    desk.settle();
    assert_ne!(desk.hash(), before);
    std::fs::write(desk.file(), SCENE.replace("albedo = 0.6", "albedo = 0.1")).unwrap();
    desk.until("the changed file", |w| {
        let opened = w.document.as_ref().and_then(|d| d.text.as_ref());
        opened.is_some_and(|text| text.contains("0.1"))
    });

    // The sky is there at once: whoever saves now saves it as well.
    assert_eq!(desk.window().added_sky(), Some(0));
    assert!(desk.window().history.as_ref().unwrap().can_undo());
    assert_eq!(desk.look().environment.unwrap().rotation, 0.5);
    desk.harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    desk.until("a saved file", |w| !w.is_changed());
    desk.quiet();
    assert!(!desk.window().is_changed() && desk.window().added_images.is_empty());
    let hash = desk.hash();
    let loaded = read_scene(&desk.file(), &ReadOptions::default()).unwrap();
    assert_eq!(headless(loaded.scene.clone(), &loaded.look()), hash);

    let other = desk.folder.path().join("other.toml");
    std::fs::write(&other, SCENE).unwrap();
    desk.drop_file(other);
    desk.until("the other scene", |w| {
        w.document.as_ref().and_then(|d| d.file.as_ref()).is_some_and(|f| f.ends_with("other.toml"))
    });
    let nothing = desk.folder.path().join("none.exr");
    desk.drop_file(nothing);
    desk.until("the error", |w| w.trouble.as_ref().is_some_and(|t| t.contains("none.exr")));
}

/// The built-in scene is saved with its own sky, and with another, as a scene that can be read.
#[test]
fn the_built_in_scene_is_saved_with_its_sky() {
    let mut desk = Desk::new();
    desk.window_mut().open(None, false);
    desk.until("the built-in scene", |w| w.document.as_ref().is_some_and(|d| d.file.is_none()));
    desk.settle();
    let file = desk.folder.path().join("built-in.toml");
    desk.window_mut().answered(Dialog::SaveScene(file.display().to_string()));
    let shown = file.clone();
    desk.until("the new file", move |w| w.document.as_ref().unwrap().file == Some(shown.clone()));
    desk.settle();
    assert!(desk.folder.path().join("skies/grey.pfm").exists());
    let loaded = read_scene(&file, &ReadOptions::default()).unwrap();
    assert_eq!(headless(loaded.scene.clone(), &loaded.look()), desk.hash());

    desk.window_mut().open(None, false);
    desk.until("the built-in scene", |w| w.document.as_ref().is_some_and(|d| d.file.is_none()));
    let sky = desk.folder.path().join("sky.pfm");
    let image = Image::from_rgb(2, 1, &[[0.1, 0.2, 0.9], [3.0, 2.0, 1.0]]).unwrap();
    rutilant_formats::image::write(&sky, &image, &WriteOptions::default()).unwrap();
    desk.drop_file(sky);
    desk.until("the sky", |w| w.added_sky().is_some());
    desk.settle();
    let file = desk.folder.path().join("mine.toml");
    desk.window_mut().answered(Dialog::SaveScene(file.display().to_string()));
    desk.until("a saved file", |w| !w.is_changed() || w.trouble.is_some());
    assert_eq!(desk.window().trouble, None);
    desk.settle();
    let loaded = read_scene(&file, &ReadOptions::default()).unwrap();
    assert_eq!(headless(loaded.scene.clone(), &loaded.look()), desk.hash());

    // From then on the window shows that file.
    let shown = file.clone();
    desk.until("the new file", move |w| w.document.as_ref().unwrap().file == Some(shown.clone()));
    desk.settle();
    assert_eq!(headless(loaded.scene.clone(), &loaded.look()), desk.hash());
}

/// A glTF file is saved as a native scene with the files that it needs, as it looks in the window; from
/// then on the window shows that one, which can be edited and saved again.
#[test]
fn a_document_is_saved_as_a_scene() {
    let mut desk = Desk::new();
    let document = r#"{"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}], "meshes": [{"name": "sail", "primitives": [
        {"attributes": {"POSITION": 0}, "material": 0}, {"attributes": {"POSITION": 0}}]}],
        "materials": [{"name": "cloth", "pbrMetallicRoughness": {"metallicFactor": 0}}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36,
        "uri": "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]}"#;
    let from = desk.folder.path().join("sail.gltf");
    std::fs::write(&from, document).unwrap();
    desk.window_mut().open(Some(from.clone()), false);
    desk.until("the document", |w| w.document.as_ref().is_some_and(|d| d.text.is_none()));
    desk.window_mut().edit(|look| (look.settings.size, look.settings.spp) = ([48, 36], 4));
    desk.window_mut().edit(|look| look.environment = Some(Environment::constant(Rgb::grey(0.3))));
    desk.settle();
    let to = desk.folder.path().join("mine.toml");
    desk.window_mut().answered(Dialog::SaveScene(to.display().to_string()));
    let shown = to.clone();
    desk.until("the new file", move |w| {
        w.trouble.is_some() || w.document.as_ref().unwrap().file == Some(shown.clone())
    });
    assert_eq!(desk.window().trouble, None);
    desk.settle();
    assert!(desk.folder.path().join("mine_assets/sail.ply").exists());
    let read = || read_scene(&to, &ReadOptions::default()).unwrap();
    let loaded = read();
    assert_eq!(loaded.scene.environment, Some(Environment::constant(Rgb::grey(0.3))));
    assert_eq!(headless(loaded.scene.clone(), &loaded.look()), desk.hash());

    desk.window_mut().edit(|look| look.settings.spp = 3);
    desk.settle();
    desk.window_mut().save();
    desk.until("a saved file", |w| !w.is_changed() || w.trouble.is_some());
    assert_eq!(desk.window().trouble, None);
    assert_eq!(read().settings.spp, 3);
}

/// A flight, a turn of the wheel and a number that is typed are a step each, from where they began to
/// where they ended.
#[test]
fn a_gesture_is_one_step() {
    let mut desk = Desk::new();
    let start = desk.look();
    let undone = |desk: &mut Desk| {
        assert!(desk.look() != start);
        (0..3).for_each(|_| desk.harness.step());
        desk.window_mut().undo();
        assert_eq!(desk.look(), start);
        assert!(!desk.window().history.as_ref().unwrap().can_undo());
    };
    desk.harness.key_down(Key::W);
    desk.harness.key_down(Key::ArrowLeft);
    (0..5).for_each(|_| desk.harness.step());
    desk.harness.key_up(Key::W);
    desk.harness.key_up(Key::ArrowLeft);
    desk.harness.step();
    undone(&mut desk);

    desk.harness.hover_at(pos2(250.0, 350.0));
    desk.harness.step();
    for _ in 0..4 {
        desk.harness.event(Event::MouseWheel {
            unit: MouseWheelUnit::Line,
            delta: vec2(0.0, 1.0),
            phase: TouchPhase::Move,
            source: MouseWheelSource::Wheel,
            modifiers: Modifiers::NONE,
        });
        desk.harness.step();
    }
    undone(&mut desk);

    desk.harness.get_by_role_and_label(Role::SpinButton, "Blades").focus();
    desk.harness.step();
    for text in ["1", "1", "3"] {
        desk.harness.event(Event::Text(text.into()));
        desk.harness.step();
    }
    desk.press(Key::Enter);
    desk.press(Key::Escape);
    undone(&mut desk);
}

/// What is typed and no number changes nothing.
#[test]
fn nonsense_is_not_typed() {
    let mut desk = Desk::new();
    let start = desk.look();
    for nonsense in ["nan", "inf", "1e400", "x"] {
        desk.harness.get_by_role_and_label(Role::SpinButton, "Blades").focus();
        desk.harness.step();
        desk.harness.event(Event::Text(nonsense.into()));
        desk.press(Key::Enter);
        assert_eq!(desk.look(), start, "{nonsense}");
    }
}

/// Panels leave alone what lies outside of what they offer.
#[test]
fn panels_change_nothing_by_showing_it() {
    let odd = "spp = 6\nexposure = 12.5\nmax_depth = 123456\nseed = 18446744073709551615";
    let text = SCENE
        .replace("spp = 6", odd)
        .replace("type = \"dielectric\"", "type = \"dielectric\"\nior = 9.5");
    let mut desk = Desk::with(&text, |_| {});
    desk.until("a picture", Window::is_settled);
    for section in ["Lights", "Environment", "Render", "floor  ·  matte", "ball  ·  dielectric"] {
        desk.click(section);
    }
    (0..5).for_each(|_| desk.harness.step());
    assert!(!desk.window().history.as_ref().unwrap().can_undo());
    assert!(!desk.window().is_changed());
}

/// What the command line said is not written into the scene, and is not said of other scenes.
#[test]
fn the_command_line_is_not_saved() {
    let mut desk = Desk::with(SCENE, |reading| {
        reading.size = Some([20, 15]);
        reading.adjust = Arc::new(|settings| settings.spp = 2);
    });
    desk.until("a picture", Window::is_settled);
    assert_eq!((desk.look().settings.size, desk.look().settings.spp), ([20, 15], 2));
    for (seed, words) in [(7, "seed = 7"), (8, "seed = 8")] {
        desk.window_mut().edit(|look| look.settings.seed = seed);
        desk.harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
        desk.until("a saved file", |w| !w.is_changed() || w.trouble.is_some());
        let text = std::fs::read_to_string(desk.file()).unwrap();
        assert!(text.contains(words), "{text} {:?}", desk.window().trouble);
        assert!(text.contains("size = [48, 36]") && text.contains("spp = 6"), "{text}");
    }
    let other = desk.folder.path().join("other.toml");
    std::fs::write(&other, SCENE).unwrap();
    desk.window_mut().open(Some(other), false);
    desk.until("the other scene", |w| {
        w.document.as_ref().and_then(|d| d.file.as_ref()).is_some_and(|f| f.ends_with("other.toml"))
    });
    assert_eq!((desk.look().settings.size, desk.look().settings.spp), ([48, 36], 6));
}

/// A sky and a camera that the command line asked for are not written into the scene, but what is
/// done to them in the window is.
#[test]
fn a_sky_that_was_asked_for_is_not_saved() {
    let mut desk = Desk::with(SCENE, |reading| {
        reading.camera = CameraChoice::Auto;
        reading.sky = SkyChoice::Even(Rgb([3.0, 2.0, 1.0]));
    });
    desk.until("a picture", Window::is_settled);
    let asked = desk.look();
    assert_eq!(asked.environment, Some(Environment::constant(Rgb([3.0, 2.0, 1.0]))));
    let own = read_scene(&desk.file(), &ReadOptions::default()).unwrap().look();
    assert_ne!(asked.camera, own.camera);
    let saved = |desk: &mut Desk| {
        desk.harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
        desk.until("a saved file", |w| !w.is_changed() || w.trouble.is_some());
        assert_eq!(desk.window().trouble, None);
        read_scene(&desk.file(), &ReadOptions::default()).unwrap().look()
    };
    desk.window_mut().edit(|look| look.settings.seed = 7);
    let first = saved(&mut desk);
    assert_eq!((first.environment, first.camera), (own.environment, own.camera));
    assert_eq!(first.settings.seed, 7);

    desk.window_mut().edit(|look| {
        look.environment.as_mut().unwrap().scale = 2.0;
        look.camera.position.y += 1.0;
    });
    let second = saved(&mut desk);
    let sky = Environment { scale: 2.0, ..asked.environment.unwrap() };
    assert_eq!(second.environment, Some(sky));
    let moved = asked.camera.position + 1.0 * rutilant_geom::Vec3::Y;
    assert_eq!(second.camera.position, moved);
}

/// A scene that cannot be read when the window opens is read once it is mended.
#[test]
fn a_broken_first_scene_is_mended() {
    let mut desk = Desk::with("version = 1\n[camera", |_| {});
    desk.until("the error", |w| w.trouble.is_some());
    std::fs::write(desk.file(), SCENE.replace("type = \"matte\"", "type = \"mat\"")).unwrap();
    desk.until("the next error", |w| w.trouble.as_ref().is_some_and(|t| t.contains("mat")));
    std::fs::write(desk.file(), SCENE).unwrap();
    desk.until("a picture", Window::is_settled);
    assert_eq!(desk.hash(), desk.headless());
}

/// A mesh that is missing, and comes.
#[test]
fn a_missing_file_is_waited_for() {
    let mut desk = Desk::new();
    let mesh = "\n[[shape]]\ntype = \"mesh\"\nfile = \"new.obj\"\nmaterial = \"floor\"\n";
    std::fs::write(desk.file(), format!("{SCENE}{mesh}")).unwrap();
    desk.until("the error", |w| w.trouble.as_ref().is_some_and(|t| t.contains("new.obj")));
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    std::fs::write(desk.folder.path().join("new.obj"), triangle).unwrap();
    desk.until("the mesh", |w| w.trouble.is_none());
    desk.settle();
    assert_eq!(desk.hash(), desk.headless());
}

/// A file whose bytes are no text any more is not written over.
#[test]
fn what_cannot_be_read_is_not_overwritten() {
    let mut desk = Desk::new();
    desk.window_mut().edit(|look| look.settings.seed = 7);
    let theirs = [b"# M\xfcller\n", SCENE.as_bytes()].concat();
    std::fs::write(desk.file(), &theirs).unwrap();
    desk.until("the error", |w| w.trouble.is_some());
    desk.harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    desk.until("the answer", |w| w.message.as_ref().is_some_and(|m| m.contains("not saved")));
    assert_eq!(std::fs::read(desk.file()).unwrap(), theirs);
    assert!(
        desk.window().trouble.as_ref().unwrap().contains("scene.toml:1:4: the text is not UTF-8")
    );
}

/// A link stays a link, and the scene behind it is saved; a change by somebody else is read before
/// anything is written over it.
#[cfg(unix)]
#[test]
fn links_and_changes_of_others_are_kept() {
    let mut desk = Desk::new();
    let link = desk.folder.path().join("link.toml");
    std::os::unix::fs::symlink(desk.file(), &link).unwrap();
    desk.window_mut().open(Some(link.clone()), false);
    desk.until("the link", |w| {
        w.document.as_ref().and_then(|d| d.file.as_ref()).is_some_and(|f| f.ends_with("link.toml"))
    });
    desk.window_mut().edit(|look| look.settings.seed = 7);
    desk.harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    desk.until("a saved file", |w| !w.is_changed());
    assert!(link.symlink_metadata().unwrap().is_symlink());
    let text = std::fs::read_to_string(desk.file()).unwrap();
    assert!(text.contains("seed = 7"));

    // The window has not heard of it yet.
    desk.window_mut().watch = None;
    std::fs::write(desk.file(), text.replace("spp = 6", "spp = 3")).unwrap();
    desk.window_mut().edit(|look| look.settings.seed = 9);
    desk.harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    desk.until("the refusal", |w| w.trouble.as_ref().is_some_and(|t| t.contains("not saved")));
    assert_eq!((desk.look().settings.spp, desk.look().settings.seed), (3, 9));
    assert!(!std::fs::read_to_string(desk.file()).unwrap().contains("seed = 9"));
    desk.harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    desk.until("a saved file", |w| !w.is_changed());
    let text = std::fs::read_to_string(desk.file()).unwrap();
    assert!(text.contains("seed = 9") && text.contains("spp = 3"));
}

/// One looks through another of a scene's cameras: that is no change, and it stays so when files
/// change; what is saved is its own.
#[test]
fn another_camera_stays_chosen() {
    let side = SCENE.replace("[camera]", "[[camera]]\nname = \"front\"").replace(
        "[environment]",
        "[[camera]]\nname = \"side\"\nposition = [4, 1, 0]\nlook_at = [0, 0.5, 0]\n\n[environment]",
    );
    let mut desk = Desk::with(&side, |reading| reading.adjust = Arc::new(|s| s.spp = 3));
    desk.until("a picture", Window::is_settled);
    desk.click("Camera");
    desk.click("side");
    assert!(!desk.window().is_changed() && !desk.window().is_touched());
    desk.press(Key::E);
    assert!(!desk.window().is_changed() && desk.window().is_touched());
    desk.harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    desk.until("a saved file", |w| !w.is_touched());
    desk.settle();
    let (look, saved) = (desk.look(), std::fs::read_to_string(desk.file()).unwrap());
    assert!(saved.contains("position = [0, 1, 4]") && !saved.contains("position = [4, 1, 0]"));

    // The other camera changes, and then this one's angle.
    for (before, after, fov) in [
        ("position = [0, 1, 4]", "position = [0, 2, 4]", 45.0),
        ("name = \"side\"", "name = \"side\"\nfov_degrees = 30", 30.0),
    ] {
        let text = std::fs::read_to_string(desk.file()).unwrap().replace(before, after);
        std::fs::write(desk.file(), &text).unwrap();
        let opened = text.clone();
        desk.until("the changed file", move |w| {
            w.document.as_ref().is_some_and(|d| d.text.as_ref() == Some(&opened))
        });
        let now = desk.look();
        assert_eq!((&*now.camera.name, now.camera.position), ("side", look.camera.position));
        let CameraKind::Perspective { view: AngleOfView::FovDegrees(degrees), .. } =
            now.camera.kind
        else {
            panic!()
        };
        assert_eq!((degrees, now.settings.spp), (fov, 3));
        assert!(!desk.window().is_touched());
    }
}

/// To fly past the point of focus is to move, and nothing that one is asked about.
#[test]
fn a_flight_past_the_focus_is_no_change() {
    let lens = "look_at = [0, 0.5, 0]\nfocus_at = [0, 0.9, 3.5]\naperture_radius = 0.01";
    let mut desk = Desk::with(&SCENE.replace("look_at = [0, 0.5, 0]", lens), |_| {});
    desk.until("a picture", Window::is_settled);
    desk.press(Key::E);
    let lens = *desk.look().camera.kind.lens().unwrap();
    assert_eq!(lens.focus, FocusOn::LookAt);
    assert!(desk.window().is_touched() && !desk.window().is_changed());
}

/// Nobody drags a picture to a size that takes all memory; what the scene reads is not written over.
#[test]
fn limits_are_kept() {
    let mut desk = Desk::with(SCENE, |reading| reading.limits.picture = 2000);
    desk.until("a picture", Window::is_settled);
    desk.click("Render");
    let width = desk.harness.get_all_by_role_and_label(Role::SpinButton, "Size").next().unwrap();
    width.focus();
    desk.harness.step();
    desk.harness.event(Event::Text("60".into()));
    desk.press(Key::Enter);
    assert_eq!(desk.look().settings.size, [48, 36]);
    assert!(desk.window().message.as_ref().unwrap().contains("limit picture"));
    let file = desk.folder.path().join("a.exr").display().to_string();
    desk.window_mut().answered(Dialog::Render { file, spp: 1, size: [200, 20] });
    assert!(desk.window().message.as_ref().unwrap().contains("200x20"));

    let sky = desk.folder.path().join("sky.pfm");
    let image = Image::from_rgb(1, 1, &[[0.5; 3]]).unwrap();
    rutilant_formats::image::write(&sky, &image, &WriteOptions::default()).unwrap();
    let before = std::fs::read(&sky).unwrap();
    let text = SCENE.replace("color = [0.6, 0.7, 0.9]", "image = \"sky.pfm\"");
    std::fs::write(desk.file(), &text).unwrap();
    desk.until("the sky", |w| w.document.as_ref().is_some_and(|d| d.files.len() == 1));
    for file in [sky.clone(), desk.file()] {
        desk.window_mut().answered(Dialog::SaveImage(file.display().to_string()));
        let trouble = desk.window_mut().trouble.take().unwrap();
        assert!(trouble.ends_with("the scene reads this file"), "{trouble}");
        assert!(desk.window().dialog.is_none());
    }
    assert_eq!(std::fs::read(&sky).unwrap(), before);
}

/// A picture for a file can be given up; closing asks, and waits for what is being written.
#[test]
fn closing_loses_nothing_unasked() {
    let mut desk = Desk::new();
    let file = desk.folder.path().join("long.exr").display().to_string();
    let job = Dialog::Render { file, spp: 1_000_000, size: [64, 48] };
    desk.window_mut().answered(job.clone());
    desk.until("the job", |w| matches!(w.job, Some(JobState::Running { .. })));
    desk.window_mut().answered(job.clone());
    assert!(desk.window().message.as_ref().unwrap().contains("another picture"));
    desk.click("Stop");
    desk.until("its end", |w| w.job.is_none());
    desk.window_mut().answered(job);
    desk.until("the job", |w| w.job.is_some());
    desk.press(Key::Escape);
    assert!(!desk.window().closing);
    desk.click("Give it up");
    assert!(desk.window().closing);

    let mut desk = Desk::new();
    let file = desk.folder.path().join("shown.exr");
    desk.window_mut().answered(Dialog::SaveImage(file.display().to_string()));
    assert!(Arc::strong_count(&desk.window().writing) > 1);
    desk.until("the file", |w| w.message.as_ref().is_some_and(|m| m.contains("hash")));
    assert_eq!(Arc::strong_count(&desk.window().writing), 1);
    let message = desk.window().message.clone().unwrap();
    assert!(message.ends_with(&format!("hash {:016x}", desk.hash())), "{message}");
}

/// States of before a reload are gone where materials or images have other numbers since.
#[test]
fn undo_leads_to_what_fits_the_file() {
    let mut desk = Desk::new();
    desk.window_mut().edit(|look| look.display.exposure = 1.0);
    let opened = |text: &str| {
        let text = text.to_owned();
        move |w: &Window| w.document.as_ref().is_some_and(|d| d.text.as_ref() == Some(&text))
    };
    let other = SCENE.replace("albedo = 0.6", "albedo = 0.1");
    std::fs::write(desk.file(), &other).unwrap();
    desk.until("the changed file", opened(&other));
    assert!(desk.window().history.as_ref().unwrap().can_undo());

    let more = format!("{SCENE}\n[[material]]\nname = \"more\"\ntype = \"black\"\n");
    std::fs::write(desk.file(), &more).unwrap();
    desk.until("the longer file", opened(&more));
    assert!(!desk.window().history.as_ref().unwrap().can_undo());
    assert_eq!(desk.look().display.exposure, 1.0);
}

/// Everything is seen by a camera without perspective as well: its picture gets high enough.
#[test]
fn a_plan_shows_everything() {
    let mut desk = Desk::new();
    desk.window_mut().edit(|look| {
        let lens = look.camera.kind.lens_mut().copied().unwrap();
        look.camera.kind = CameraKind::Orthographic { height: 0.1, lens };
    });
    for _ in 0..2 {
        desk.press(Key::Home);
        desk.settle();
        let CameraKind::Orthographic { height, .. } = desk.look().camera.kind else { panic!() };
        // The floor's diagonal, and a little air.
        assert!((8.4..9.4).contains(&height), "{height}");
        desk.window_mut().edit(|look| {
            if let CameraKind::Orthographic { height, .. } = &mut look.camera.kind {
                *height = 3.0;
            }
        });
    }
}

/// Random edits, moves, resizes, good and broken files, in any order: nothing panics, and what is
/// shown in the end is what a fresh rendering gives. `RUTILANT_ROUNDS` sets how many.
///
/// It has a process of its own, for what memory a process takes is not told by tests.
#[test]
fn anything_may_happen_in_any_order() {
    const ALONE: &str = "RUTILANT_TEST_ALONE";
    if std::env::var_os(ALONE).is_none() {
        let name = "window::tests::anything_may_happen_in_any_order";
        let mut own = std::process::Command::new(std::env::current_exe().unwrap());
        let ran = own.args([name, "--exact", "--nocapture"]).env(ALONE, "1").status().unwrap();
        assert!(ran.success());
        return;
    }
    let rounds = std::env::var("RUTILANT_ROUNDS").ok().and_then(|n| n.parse().ok()).unwrap_or(300);
    let mut desk = Desk::new();
    let mut state = 7_u64;
    let mut random = |n: u64| {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) % n
    };
    let resident = || {
        let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
        let line = status.lines().find(|line| line.starts_with("VmRSS:"));
        line.and_then(|line| line.split_whitespace().nth(1)?.parse::<u64>().ok()).unwrap_or(0)
    };
    let keys = [
        Key::W,
        Key::A,
        Key::S,
        Key::D,
        Key::R,
        Key::F,
        Key::Q,
        Key::E,
        Key::H,
        Key::P,
        Key::Space,
        Key::N,
        Key::Home,
        Key::O,
        Key::B,
        Key::F1,
        Key::ArrowUp,
        Key::ArrowDown,
        Key::ArrowLeft,
    ];
    let mut early = 0;
    for round in 0..rounds {
        let x = random(1000) as f32 / 1000.0;
        match random(14) {
            0 => desk.harness.key_press(keys[random(keys.len() as u64) as usize]),
            1 => desk.harness.key_down(keys[random(6) as usize]),
            2 => keys[..6].iter().for_each(|key| desk.harness.key_up(*key)),
            3 => desk.window_mut().edit(|look| {
                let albedo = rutilant::color::Rgb([x, 0.5, 1.0 - x]);
                look.materials[0].kind =
                    rutilant::material::MaterialKind::Matte(rutilant::material::Matte::new(albedo));
            }),
            4 => desk.window_mut().edit(|look| {
                look.materials[1].emission = (x < 0.5)
                    .then(|| rutilant::material::Emission::radiance(rutilant::color::Rgb::grey(x)));
            }),
            5 => desk.window_mut().edit(|look| {
                look.environment =
                    (x > 0.2).then(|| Environment::constant(rutilant::color::Rgb::grey(x)));
            }),
            6 => {
                let size = [1 + random(60) as u32, 1 + random(40) as u32];
                desk.window_mut().edit(|look| look.settings.size = size);
            }
            7 => {
                let size = vec2(100.0 + 900.0 * x, 80.0 + random(700) as f32);
                desk.harness.set_size(size);
            }
            8 if round % 4 == 0 => {
                let text = match random(4) {
                    0 => SCENE.replace("albedo", "albdo"),
                    1 => SCENE[..random(SCENE.len() as u64) as usize].to_owned(),
                    2 => SCENE.replace("albedo = 0.6", &format!("albedo = {x}")),
                    _ => SCENE.to_owned(),
                };
                std::fs::write(desk.file(), text).unwrap();
                // Long enough for it to be read, most of the time.
                for _ in 0..random(50) {
                    desk.harness.step();
                    std::thread::sleep(Duration::from_millis(10));
                }
            }
            9 => desk.window_mut().undo(),
            10 => desk.window_mut().redo(),
            11 => {
                let at = pos2(600.0 * x, random(600) as f32);
                desk.harness.hover_at(at);
                if x < 0.5 {
                    desk.harness.drag_at(at);
                } else {
                    desk.harness.drop_at(at);
                }
            }
            12 => {
                let channel = Channel::ALL[random(6) as usize].0;
                desk.window_mut().view.channel = channel;
            }
            _ => {
                desk.window_mut().paused = x < 0.3;
                desk.window_mut().endless = x > 0.9;
            }
        }
        desk.harness.step();
        // Sometimes there is time for a picture.
        std::thread::sleep(Duration::from_millis(random(16).saturating_sub(8)));
        if round == rounds / 2 {
            early = resident();
        }
        if round % (rounds / 5).max(1) == 0 {
            desk.rest(&keys);
            assert_eq!(desk.hash(), desk.headless(), "after round {round}");
        }
    }
    let late = resident();
    assert!(late < early + 16_000, "{early} kB grew to {late} kB");

    desk.rest(&keys);
    assert_eq!(desk.hash(), desk.headless());
    let happened = desk.happened.borrow();
    let count = |of: fn(&Happened) -> bool| happened.iter().filter(|h| of(h)).count() as u64;
    let (opened, pictures, troubles) = (
        count(|h| matches!(h, Happened::Opened { .. })),
        count(|h| matches!(h, Happened::Picture { .. })),
        count(|h| matches!(h, Happened::Trouble { .. })),
    );
    println!(
        "{rounds} rounds: {opened} scenes read, {troubles} not, {pictures} pictures; {early} kB, \
         then {late} kB"
    );
    assert!(opened > rounds / 300 && pictures > rounds / 10, "{opened} {pictures}");
}
