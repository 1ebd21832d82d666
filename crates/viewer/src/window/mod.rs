//! The window: what is shown of a scene, and what people do with it.
//!
//! It holds no picture of its own and renders nothing: it tells `live.rs` what
//! it wants to see and shows what comes. Each frame it takes a draft of the
//! scene's look, lets keys, mouse and panels change it, and hands it on where
//! it has become another.

mod canvas;
mod panels;
#[cfg(test)]
mod tests;
mod theme;
mod widgets;

use crate::flight::Flight;
use crate::frames::FrameTimes;
use crate::history::History;
use crate::keys::{Action, KeyMap};
use crate::live::{Job, JobState, Live, Shown, Status, Wish};
use crate::merge::merged;
use crate::picture::{BINS, Channel, View};
use crate::pose::{Axis, Pose};
use crate::prefs::Preferences;
use crate::source::{Document, Opening, Reading, Step, text_of};
use crate::watch::Watch;
use canvas::{Canvas, Laid, Tool};
use eframe::egui::{
    self, Align2, CentralPanel, Color32, Context, Event, Key, MenuBar, Panel, ScrollArea,
    TextureHandle, TextureOptions, Ui, ViewportCommand, vec2,
};
use rutilant::image::Image;
use rutilant::light::Environment;
use rutilant::scene::ImageId;
use rutilant_formats::Look;
use rutilant_formats::camera::{AngleOfView, CameraKind, FocusOn};
use rutilant_formats::image::{Format, Pixels, WriteOptions};
use rutilant_geom::Vec2;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};

/// Something that happened in the window that somebody outside may want to know.
#[derive(Clone, Debug)]
pub enum Happened {
    /// A scene was opened.
    Opened {
        /// What people call it.
        name: String,
    },
    /// A picture is on the screen.
    Picture {
        /// Pixels of the picture, reduced or not.
        size: [u32; 2],
        /// Whether it has its full size.
        full: bool,
    },
    /// The user asked where the camera stands: a `[camera]` table.
    Pose {
        /// The table.
        toml: String,
    },
    /// Something was written.
    Wrote {
        /// The file.
        file: PathBuf,
        /// The fingerprint of the picture, where it was one.
        hash: Option<String>,
    },
    /// The window was closed.
    Closed {
        /// How long the interface took for its frames.
        frames: FrameTimes,
        /// The fingerprint of the last picture, and how many samples each of its pixels has.
        picture: Option<(String, u64)>,
    },
    /// Something went wrong; the window says so as well.
    Trouble {
        /// One line.
        what: String,
    },
}

/// Tells what happens in a window.
pub type Report = Box<dyn FnMut(Happened)>;

/// The picture beside the rendered one.
struct Beside {
    name: String,
    image: Arc<Image>,
}

/// What is asked for in a dialog.
#[derive(Clone, Debug, PartialEq)]
enum Dialog {
    Open(String),
    Compare(String),
    SaveScene(String),
    SaveImage(String),
    Render { file: String, spp: u64, size: [u32; 2] },
    Discard(After),
}

/// What happens once changes may be lost.
#[derive(Clone, Debug, PartialEq)]
enum After {
    Close,
    Open(Option<PathBuf>),
}

/// Files that are read or written beside the interface.
enum Work {
    Wrote { file: PathBuf, hash: Option<String>, saved: Option<Arc<Look>> },
    Sky { file: PathBuf, image: Image },
    Beside(Beside),
    Failed(String),
}

/// Everything behind the window.
pub(crate) struct Window {
    reading: Reading,
    live: Live,
    context: Context,
    report: Report,
    preferences: Preferences,
    preferences_file: Option<PathBuf>,
    keys: KeyMap,
    /// The action whose key is being changed.
    remapping: Option<Action>,

    opening: Option<Opening>,
    /// What was opened last, or should have been, and whether it was on the screen already.
    tried: (Option<PathBuf>, bool),
    document: Option<Document>,
    history: Option<History<Look>>,
    /// The look that the file has.
    saved: Option<Arc<Look>>,
    /// Names of all images, those that were added among them.
    image_names: Vec<String>,
    watch: Option<Watch>,

    view: View,
    paused: bool,
    endless: bool,
    beside: Option<Beside>,
    /// What was wished for last.
    wished: Option<Wished>,
    shown: Option<Shown>,
    textures: [Option<TextureHandle>; 2],

    canvas: Canvas,
    flight: Flight,
    /// Counts presses of the mouse and runs of keys: each is one gesture.
    gesture: u64,
    picking: bool,
    /// The depth that H goes back to.
    depth: Option<u32>,
    panels: bool,
    help: bool,
    dialog: Option<Dialog>,
    filter: String,
    /// The last thing that went wrong, and the last that went well.
    trouble: Option<String>,
    message: Option<String>,
    job: Option<JobState>,
    work: (Sender<Work>, Receiver<Work>),
    closing: bool,
}

/// A wish, as far as it can be compared.
#[derive(PartialEq)]
struct Wished {
    look: *const Look,
    view: View,
    paused: bool,
    endless: bool,
    beside: Option<*const Image>,
}

impl Window {
    pub(crate) fn new(
        context: &Context,
        reading: Reading,
        threads: usize,
        file: Option<PathBuf>,
        preferences_file: Option<PathBuf>,
        report: Report,
    ) -> Self {
        theme::apply(context);
        let preferences = preferences_file.as_deref().map(Preferences::read).unwrap_or_default();
        let wake = context.clone();
        let mut window = Self {
            live: Live::start(threads, move || wake.request_repaint()),
            context: context.clone(),
            report,
            keys: preferences.key_map(),
            preferences,
            preferences_file,
            remapping: None,
            reading,
            opening: None,
            tried: (None, false),
            document: None,
            history: None,
            saved: None,
            image_names: Vec::new(),
            watch: None,
            view: View::default(),
            paused: false,
            endless: false,
            beside: None,
            wished: None,
            shown: None,
            textures: [None, None],
            canvas: Canvas::default(),
            flight: Flight::default(),
            gesture: 0,
            picking: false,
            depth: None,
            panels: true,
            help: false,
            dialog: None,
            filter: String::new(),
            trouble: None,
            message: None,
            job: None,
            work: channel(),
            closing: false,
        };
        window.open(file, false);
        window
    }

    /// One frame.
    pub(crate) fn ui(&mut self, ui: &mut Ui) {
        self.receive();
        let before = self.history.as_ref().map(|history| Arc::clone(history.present()));
        let mut draft = before.as_deref().cloned();
        self.hear_keys(ui, draft.as_mut());
        if self.panels {
            self.menu(ui, draft.as_mut());
            self.status_bar(ui);
            self.side_panel(ui, draft.as_mut());
        }
        CentralPanel::no_frame().show(ui, |ui| self.picture(ui, draft.as_mut()));
        self.dialogs(ui.ctx(), draft.as_mut());
        self.commit(ui, before, draft);
        self.close_if_asked(ui.ctx());
    }

    /// Tells that it is closed.
    pub(crate) fn closed(&mut self, frames: FrameTimes) {
        let picture = self.shown.as_ref().map(|shown| {
            let image = &shown.picture.image;
            let counts = image.channel("samples.Y").unwrap_or(&[]);
            let least = counts.iter().copied().fold(f32::INFINITY, f32::min);
            (format!("{:016x}", image.hash()), least as u64)
        });
        (self.report)(Happened::Closed { frames, picture });
    }

    /// Makes a changed draft the present look, and tells the rendering.
    fn commit(&mut self, ui: &Ui, before: Option<Arc<Look>>, draft: Option<Look>) {
        let Some(history) = &mut self.history else { return };
        let (pressed, down) = ui.input(|i| (i.pointer.any_pressed(), i.pointer.any_down()));
        if pressed {
            self.gesture += 1;
        }
        let moving = down || self.flight.is_moving();
        // Undo, or a file that was read again, has the last word.
        let undone = before.is_none_or(|before| !Arc::ptr_eq(&before, history.present()));
        if let Some(draft) = draft.filter(|_| !undone) {
            history.change(draft, moving.then_some(self.gesture));
        }
        if !moving {
            history.end_gesture();
        }
        self.wish();
    }

    /// Tells the rendering what is to be seen, where that has changed.
    fn wish(&mut self) {
        let Some(history) = &self.history else { return };
        let look = Arc::clone(history.present());
        let view = View { display: look.display, ..self.view };
        let beside = self.beside.as_ref().map(|b| Arc::clone(&b.image));
        let (paused, endless) = (self.paused, self.endless);
        let beside_at = beside.as_ref().map(Arc::as_ptr);
        let wished = Wished { look: Arc::as_ptr(&look), view, paused, endless, beside: beside_at };
        if self.wished.as_ref() != Some(&wished) {
            self.wished = Some(wished);
            self.live.wish(Wish { look, view, paused, endless, beside });
        }
    }

    /// Takes what other threads have finished.
    fn receive(&mut self) {
        if let Some(opened) = self.opening.as_ref().and_then(Opening::take)
            && let Some(opening) = self.opening.take()
        {
            match opened {
                Ok(opened) => self.opened(*opened, opening.again),
                Err(what) => self.trouble(what),
            }
        }
        if self.opening.is_none() && self.watch.as_ref().is_some_and(Watch::has_changed) {
            let file = self.document.as_ref().and_then(|d| d.file.clone());
            self.open(file, true);
        }
        while let Ok(work) = self.work.1.try_recv() {
            match work {
                Work::Wrote { file, hash, saved } => {
                    if let Some(look) = saved {
                        self.saved = Some(look);
                    }
                    let hash_shown = hash.as_ref().map(|h| format!(", hash {h}"));
                    let hash_shown = hash_shown.unwrap_or_default();
                    self.message = Some(format!("wrote {}{hash_shown}", file.display()));
                    (self.report)(Happened::Wrote { file, hash });
                }
                Work::Sky { file, image } => self.use_sky(&file, image),
                Work::Beside(beside) => self.beside = Some(beside),
                Work::Failed(what) => self.trouble(what),
            }
        }
        if let Some(found) = self.live.focus() {
            match found {
                Some(focus) => self.edit(|look| {
                    if let Some(lens) = look.camera.kind.lens_mut() {
                        lens.focus = FocusOn::Distance(focus.distance);
                    }
                }),
                None => self.message = Some("there is nothing to focus on there".into()),
            }
            if let Some(focus) = found {
                let distance = focus.distance;
                self.message = Some(format!("focused {distance:.4} m away"));
            }
        }
        self.receive_job();
        self.receive_picture();
    }

    fn receive_job(&mut self) {
        match self.live.job() {
            Some(JobState::Done { image, file, took }) => {
                self.job = None;
                self.message = Some(format!("rendered in {:.1} s", took.as_secs_f64()));
                self.write_image(image, file);
            }
            Some(JobState::Failed { what }) => {
                self.job = None;
                self.trouble(what);
            }
            Some(running) => {
                self.job = Some(running);
                self.context.request_repaint_after(std::time::Duration::from_millis(100));
            }
            None => {}
        }
    }

    fn receive_picture(&mut self) {
        let Some(shown) = self.live.shown() else { return };
        if self.shown.as_ref().is_some_and(|s| s.number == shown.number) {
            return;
        }
        let full =
            self.history.as_ref().is_some_and(|h| h.present().settings.size == shown.picture.size);
        let pictures = [Some(&shown.picture), shown.beside.as_ref()];
        for (texture, picture) in self.textures.iter_mut().zip(pictures) {
            let Some(picture) = picture else {
                *texture = None;
                continue;
            };
            let [width, height] = picture.size.map(|side| side as usize);
            let image = egui::ColorImage::new([width, height], picture.pixels.clone());
            let options = TextureOptions {
                magnification: if full {
                    egui::TextureFilter::Nearest
                } else {
                    egui::TextureFilter::Linear
                },
                minification: egui::TextureFilter::Linear,
                ..TextureOptions::LINEAR
            };
            match texture {
                Some(texture) => texture.set(image, options),
                None => *texture = Some(self.context.load_texture("picture", image, options)),
            }
        }
        (self.report)(Happened::Picture { size: shown.picture.size, full });
        self.shown = Some(shown);
    }

    fn opened(&mut self, (mut stage, document): (crate::live::Stage, Document), again: bool) {
        let theirs = document.look.clone();
        let before = self.document.as_ref().map(|d| d.look.clone());
        let sky_is_mine = |look: &Look| {
            let images = document.image_names.len() as u32;
            matches!(look.environment, Some(Environment {
                light: rutilant::light::EnvironmentLight::Image { image: ImageId(id), .. }, ..
            }) if id >= images)
        };
        let mut look = match (again, &before, &self.history) {
            (true, Some(before), Some(history)) => merged(before, history.present(), &theirs),
            _ => theirs.clone(),
        };
        // An image of the window's own is not there any more after the scene was read anew.
        if sky_is_mine(&look) {
            look.environment = theirs.environment;
        }
        stage.scene.camera = match look.camera.camera(look.settings.size) {
            Ok(camera) => camera,
            Err(_) => stage.scene.camera,
        };
        self.trouble = None;
        (self.report)(Happened::Opened { name: document.name(&self.reading) });
        let history = match self.history.take().filter(|_| again) {
            Some(mut history) => {
                history.change(look, None);
                history
            }
            None => History::new(look),
        };
        self.saved = Some(Arc::new(theirs));
        self.image_names.clone_from(&document.image_names);
        let wake = self.context.clone();
        let watched = document.file.iter().chain(&document.files).cloned();
        self.watch = Some(Watch::begin(watched, move |after| {
            wake.request_repaint_after(after + std::time::Duration::from_millis(10));
        }));
        if let Some(file) = document.file.as_deref().filter(|_| !again) {
            self.preferences.opened(file);
            self.keep_preferences();
        }
        if !again {
            (self.canvas.zoom, self.depth) = (None, None);
        }
        let title = format!("{} – Rutilant", document.name(&self.reading));
        self.context.send_viewport_cmd(ViewportCommand::Title(title));
        let seconds = document.took.map(|t| t.as_secs_f64());
        self.message = Some(format!(
            "{} triangles, read in {:.2} s, prepared in {:.2} s",
            document.triangles, seconds[0], seconds[1]
        ));
        self.document = Some(document);
        let look = Arc::clone(history.present());
        self.history = Some(history);
        let view = View { display: look.display, ..self.view };
        let beside = self.beside.as_ref().map(|b| Arc::clone(&b.image));
        self.live
            .stage(stage, Wish { look, view, paused: self.paused, endless: self.endless, beside });
        self.wished = None;
    }

    fn open(&mut self, file: Option<PathBuf>, again: bool) {
        self.tried = (file.clone(), again);
        let wake = self.context.clone();
        self.opening =
            Some(Opening::begin(file, again, &self.reading, move || wake.request_repaint()));
    }

    /// Opens another scene, once changes to this one are saved or given up.
    fn open_if_saved(&mut self, file: Option<PathBuf>) {
        if self.is_changed() {
            self.dialog = Some(Dialog::Discard(After::Open(file)));
        } else {
            self.open(file, false);
        }
    }

    /// Whether the look differs from the file's in more than where the camera stands.
    fn is_changed(&self) -> bool {
        let (Some(history), Some(saved)) = (&self.history, &self.saved) else { return false };
        let now = history.present();
        Look { camera: saved.camera.clone(), ..Look::clone(now) } != **saved
    }

    fn trouble(&mut self, what: String) {
        (self.report)(Happened::Trouble { what: what.clone() });
        self.trouble = Some(what);
    }

    fn keep_preferences(&self) {
        if let Some(file) = &self.preferences_file {
            // A window that cannot remember is no reason to stop.
            drop(self.preferences.write(file));
        }
    }

    /// A change that is a step of its own.
    fn edit(&mut self, change: impl FnOnce(&mut Look)) {
        if let Some(history) = &mut self.history {
            let mut look = Look::clone(history.present());
            change(&mut look);
            history.change(look, None);
        }
    }

    // What people do.

    fn hear_keys(&mut self, ui: &Ui, mut draft: Option<&mut Look>) {
        let context = ui.ctx();
        let (events, time, focused, command) =
            context.input(|i| (i.events.clone(), i.time, i.raw.focused, i.modifiers.command));
        let speed = self.speed(draft.as_deref());
        let typing = context.text_edit_focused() || self.dialog.is_some();
        if !focused || typing {
            self.flight.release_all();
        }
        let mut pose = draft.as_deref().map(pose_of);
        for event in &events {
            let Event::Key { key, pressed, repeat, .. } = event else { continue };
            if *pressed && !repeat && self.remapping.is_some() {
                self.remap(*key);
                continue;
            }
            let Some(action) = self.keys.action(*key) else { continue };
            match (&mut pose, *pressed) {
                (Some(_), true) if *repeat && !typing && !command => {}
                (Some(pose), true) if !typing && !command => {
                    if !self.flight.is_moving() {
                        self.gesture += 1;
                    }
                    self.flight.press(action, time, pose, speed);
                    self.act(action, pose, draft.as_deref_mut());
                }
                (Some(pose), false) => drop(self.flight.release(action, time, pose, speed)),
                (_, true) if action == Action::Close || action == Action::Help => {
                    if let (false, Some(pose)) = (*repeat, &mut pose) {
                        self.act(action, pose, draft.as_deref_mut());
                    } else if !repeat {
                        self.close_something();
                    }
                }
                _ => {}
            }
        }
        if let Some(pose) = &mut pose {
            self.flight.advance(time, pose, speed);
            if self.flight.is_moving() {
                context.request_repaint();
            }
        }
        if let (Some(draft), Some(pose)) = (draft, pose) {
            put_pose(draft, pose);
        }
        let shortcut = |key| context.input(|i| i.modifiers.command && i.key_pressed(key));
        let shift = context.input(|i| i.modifiers.shift);
        if shortcut(Key::Z) && !shift && !typing {
            self.undo();
        } else if (shortcut(Key::Y) || (shortcut(Key::Z) && shift)) && !typing {
            self.redo();
        } else if shortcut(Key::S) {
            self.save();
        } else if shortcut(Key::O) {
            self.dialog = Some(Dialog::Open(self.folder()));
        }
        let dropped = context.input(|i| i.raw.dropped_files.clone());
        for file in dropped {
            self.dropped(file.path().to_owned());
        }
    }

    fn remap(&mut self, key: Key) {
        if let Some(action) = self.remapping.take() {
            // Escape always means what it says.
            if key != Key::Escape || action == Action::Close {
                self.keys.set(action, key);
                self.preferences.keys = self.keys.to_names();
                self.keep_preferences();
            }
        }
    }

    /// Metres per second: a quarter of the scene's size.
    fn speed(&self, look: Option<&Look>) -> f64 {
        let size = self.scene_size();
        let near = look.map_or(size, |look| 2.0 * pose_of(look).distance());
        0.25 * size.min(near.max(1e-3 * size))
    }

    /// The diagonal of the scene, in metres.
    fn scene_size(&self) -> f64 {
        let bounds = self.document.as_ref().map(|d| d.bounds);
        let size = bounds.filter(|b| !b.is_empty()).map_or(1.0, |b| b.extent().as_dvec3().length());
        if size.is_finite() && size > 0.0 { size } else { 1.0 }
    }

    fn act(&mut self, action: Action, pose: &mut Pose, draft: Option<&mut Look>) {
        let jump = 0.5 * self.scene_size();
        match action {
            Action::JumpForward => pose.fly([0.0, 0.0, jump]),
            Action::JumpBack => pose.fly([0.0, 0.0, -jump]),
            Action::ToggleDepth => {
                if let Some(look) = draft {
                    let depth = &mut look.settings.max_depth;
                    *depth = match *depth {
                        Some(2) => self
                            .depth
                            .or((look.settings.roulette == rutilant::settings::Roulette::Off)
                                .then_some(512)),
                        other => {
                            self.depth = other;
                            Some(2)
                        }
                    };
                }
            }
            Action::PrintPose => {
                if let Some(look) = draft {
                    put_pose(look, *pose);
                    let toml = look.camera.to_toml();
                    self.context.copy_text(toml.clone());
                    self.message = Some("the camera is in the clipboard".into());
                    (self.report)(Happened::Pose { toml });
                }
            }
            Action::Pause => self.paused = !self.paused,
            Action::Panels => self.panels = !self.panels,
            Action::FitAll => {
                if let (Some(document), Some(look)) = (&self.document, draft) {
                    pose.fit(&document.bounds, half_angle(look));
                }
            }
            Action::Overlay => self.view.overlay = !self.view.overlay,
            Action::StoreSnapshot => self.store_snapshot(),
            Action::Help => self.help = !self.help,
            Action::Close => self.close_something(),
            Action::Forward
            | Action::Back
            | Action::Left
            | Action::Right
            | Action::Up
            | Action::Down
            | Action::TurnLeft
            | Action::TurnRight
            | Action::LookUp
            | Action::LookDown => {}
        }
    }

    /// The topmost thing that is open, or the window.
    fn close_something(&mut self) {
        let closed = self.dialog.take().is_some()
            || std::mem::take(&mut self.help)
            || std::mem::take(&mut self.picking)
            || self.trouble.take().is_some();
        if !closed {
            self.ask_to_close();
        }
    }

    fn ask_to_close(&mut self) {
        if self.is_changed() {
            self.dialog = Some(Dialog::Discard(After::Close));
        } else {
            self.closing = true;
        }
    }

    fn close_if_asked(&mut self, context: &Context) {
        if context.input(|i| i.viewport().close_requested()) && !self.closing && self.is_changed() {
            context.send_viewport_cmd(ViewportCommand::CancelClose);
            self.dialog = Some(Dialog::Discard(After::Close));
        } else if self.closing {
            context.send_viewport_cmd(ViewportCommand::Close);
        }
    }

    fn undo(&mut self) {
        if let Some(history) = &mut self.history {
            history.undo();
        }
    }

    fn redo(&mut self) {
        if let Some(history) = &mut self.history {
            history.redo();
        }
    }

    fn store_snapshot(&mut self) {
        if let Some(shown) = &self.shown {
            let image = Arc::clone(&shown.picture.image);
            self.beside = Some(Beside { name: "the kept picture".into(), image });
        }
    }

    /// A scene or mesh is opened; any image becomes the sky.
    fn dropped(&mut self, file: PathBuf) {
        if Format::from_path(&file).is_ok() {
            self.read_image(file, |file, image| Work::Sky { file, image });
        } else {
            self.open_if_saved(Some(file));
        }
    }

    fn read_image(
        &self,
        file: PathBuf,
        then: impl FnOnce(PathBuf, Image) -> Work + Send + 'static,
    ) {
        let limits = self.reading.limits;
        self.beside_the_interface(move || match rutilant_formats::image::read(&file, &limits) {
            Ok(image) if image.rgb().is_some() => then(file, image),
            Ok(_) => Work::Failed(format!("{}: no channels R, G, B (or Y)", file.display())),
            Err(error) => Work::Failed(error.to_string()),
        });
    }

    fn beside_the_interface(&self, work: impl FnOnce() -> Work + Send + 'static) {
        let (sender, wake) = (self.work.0.clone(), self.context.clone());
        std::thread::spawn(move || {
            // Nobody hears it any more once the window is closed.
            drop(sender.send(work()));
            wake.request_repaint();
        });
    }

    fn use_sky(&mut self, file: &Path, image: Image) {
        let Some(document) = &self.document else { return };
        // Beside the scene it is named as the scene would name it.
        let folder = document.file.as_deref().and_then(Path::parent).unwrap_or(Path::new(""));
        let inside = |file: &Path| {
            let (file, folder) = (file.canonicalize().ok()?, folder.canonicalize().ok()?);
            file.strip_prefix(folder).map(Path::to_owned).ok()
        };
        let name = inside(file).unwrap_or_else(|| file.to_owned());
        let id = ImageId(self.image_names.len() as u32);
        self.image_names.push(name.to_string_lossy().replace('\\', "/"));
        self.live.add_image(image);
        self.edit(|look| {
            let rotation = look.environment.map_or(0.0, |sky| sky.rotation);
            look.environment = Some(Environment { rotation, ..Environment::image(id) });
        });
    }

    /// The folder that dialogs begin in.
    fn folder(&self) -> String {
        let file = self.document.as_ref().and_then(|d| d.file.as_deref());
        let folder = file.and_then(Path::parent).filter(|f| !f.as_os_str().is_empty());
        folder.map(|f| format!("{}/", f.display())).unwrap_or_default()
    }

    fn save(&mut self) {
        let Some(document) = &self.document else { return };
        match &document.file {
            Some(file) if document.text.is_some() => self.save_scene(file.clone()),
            _ => {
                let stem = Path::new(&document.name(&self.reading)).with_extension("toml");
                self.dialog =
                    Some(Dialog::SaveScene(format!("{}{}", self.folder(), stem.display())));
            }
        }
    }

    fn save_scene(&mut self, to: PathBuf) {
        let (Some(document), Some(history)) = (&self.document, &self.history) else { return };
        let in_place = document.file.as_deref() == Some(&*to);
        if in_place
            && let Some(text) = &document.text
            && std::fs::read_to_string(&to).is_ok_and(|now| now != *text)
        {
            let to = to.display();
            self.trouble = Some(format!("{to}: it has changed on disk; it will be read first"));
            return;
        }
        // Its text is made here: the document does not change meanwhile.
        let look = Arc::clone(history.present());
        match text_of(document, &look, &self.image_names, &to, &self.reading) {
            Ok(text) => self.beside_the_interface(move || match replace(&to, &text) {
                Ok(()) => Work::Wrote { file: to, hash: None, saved: Some(look) },
                Err(error) => Work::Failed(format!("{}: {error}", to.display())),
            }),
            Err(what) => self.trouble(what),
        }
    }

    fn write_image(&mut self, image: Arc<Image>, file: PathBuf) {
        let Some(history) = &self.history else { return };
        let display = history.present().display;
        self.beside_the_interface(move || {
            let hash = Some(format!("{:016x}", image.hash()));
            let (width, height) = (image.width(), image.height());
            let options = WriteOptions::default();
            let for_display = Format::from_path(&file).is_ok_and(Format::is_for_display);
            let written = if for_display {
                let light = image.rgb().unwrap_or_default();
                let rgb8: Vec<u8> = light.iter().flat_map(|rgb| display.encode(*rgb)).collect();
                let pixels = Pixels::Display { width, height, rgb8: &rgb8 };
                rutilant_formats::image::write(&file, pixels, &options)
            } else {
                rutilant_formats::image::write(&file, &*image, &options)
            };
            match written {
                Ok(()) => Work::Wrote { file, hash, saved: None },
                Err(error) => Work::Failed(error.to_string()),
            }
        });
    }

    fn copy_image(&mut self) {
        if let Some(shown) = &self.shown {
            let size = shown.picture.size.map(|side| side as usize);
            self.context.copy_image(egui::ColorImage::new(size, shown.picture.pixels.clone()));
            self.message = Some("the picture is in the clipboard".into());
        }
    }

    // What they see.

    fn menu(&mut self, ui: &mut Ui, draft: Option<&mut Look>) {
        Panel::top("menu").show(ui, |ui| {
            MenuBar::new().ui(ui, |ui| {
                ui.menu_button("File", |ui| self.file_menu(ui, draft.as_deref()));
                ui.menu_button("Edit", |ui| {
                    let (undo, redo) = self
                        .history
                        .as_ref()
                        .map_or((false, false), |h| (h.can_undo(), h.can_redo()));
                    if ui
                        .add_enabled(undo, egui::Button::new("Undo").shortcut_text("Ctrl+Z"))
                        .clicked()
                    {
                        self.undo();
                    }
                    if ui
                        .add_enabled(redo, egui::Button::new("Redo").shortcut_text("Ctrl+Y"))
                        .clicked()
                    {
                        self.redo();
                    }
                });
                ui.menu_button("Camera", |ui| self.camera_menu(ui, draft));
                ui.menu_button("View", |ui| self.view_menu(ui));
                if ui.button("Keys").clicked() {
                    self.help = !self.help;
                }
                ui.separator();
                ui.selectable_value(&mut self.canvas.tool, Tool::Camera, "Move camera");
                ui.selectable_value(&mut self.canvas.tool, Tool::Picture, "Move picture");
                ui.separator();
                let label = if self.paused { "Continue" } else { "Pause" };
                if ui.button(label).clicked() {
                    self.paused = !self.paused;
                }
                ui.toggle_value(&mut self.endless, "Endless")
                    .on_hover_text("Go on beyond the samples that the scene asks for");
            });
        });
    }

    fn file_menu(&mut self, ui: &mut Ui, draft: Option<&Look>) {
        if ui.add(egui::Button::new("Open…").shortcut_text("Ctrl+O")).clicked() {
            self.dialog = Some(Dialog::Open(self.folder()));
        }
        ui.menu_button("Open recent", |ui| {
            for file in self.preferences.recent.clone() {
                if ui.button(file.display().to_string()).clicked() {
                    self.open_if_saved(Some(file));
                }
            }
            if ui.button("The built-in scene").clicked() {
                self.open_if_saved(None);
            }
        });
        if ui.add(egui::Button::new("Save scene").shortcut_text("Ctrl+S")).clicked() {
            self.save();
        }
        ui.separator();
        let stem = self.document.as_ref().map(|d| d.name(&self.reading)).unwrap_or_default();
        let stem = Path::new(&stem).with_extension("").display().to_string();
        if ui.button("Save image…").clicked() {
            self.dialog = Some(Dialog::SaveImage(format!("{}{stem}.exr", self.folder())));
        }
        if ui.button("Copy image").clicked() {
            self.copy_image();
        }
        if ui.button("Render at full quality…").clicked()
            && let Some(look) = draft
        {
            let file = format!("{}{stem}.exr", self.folder());
            let (spp, size) = (look.settings.spp, look.settings.size);
            self.dialog = Some(Dialog::Render { file, spp, size });
        }
        ui.separator();
        if ui.button("Close").clicked() {
            self.ask_to_close();
        }
    }

    fn camera_menu(&mut self, ui: &mut Ui, draft: Option<&mut Look>) {
        let (Some(look), Some(document)) = (draft, &self.document) else { return };
        for (i, camera) in document.cameras.iter().enumerate() {
            let name = match &*camera.name {
                "" if i == 0 => "The scene's camera",
                "" => "A camera without a name",
                name => name,
            };
            if ui.button(name).clicked() {
                look.camera = camera.clone();
            }
        }
        ui.separator();
        let mut pose = pose_of(look);
        let half_angle = half_angle(look);
        if ui.button("See everything").clicked() {
            pose.fit(&document.bounds, half_angle);
        }
        for (axis, name) in Axis::ALL {
            if ui.button(name).clicked() {
                pose.look_along(axis, &document.bounds, half_angle);
            }
        }
        put_pose(look, pose);
    }

    fn view_menu(&mut self, ui: &mut Ui) {
        for (channel, name) in Channel::ALL {
            ui.selectable_value(&mut self.view.channel, channel, name);
        }
        ui.separator();
        ui.checkbox(&mut self.view.false_color, "False colors");
        ui.checkbox(&mut self.view.overlay, "Mark what cannot be shown");
        ui.separator();
        if ui.button("Fit in the window").clicked() {
            self.canvas.zoom = None;
        }
        if ui.button("Pixel by pixel").clicked() {
            (self.canvas.zoom, self.canvas.offset) =
                (Some(1.0 / ui.ctx().pixels_per_point()), egui::Vec2::ZERO);
        }
        ui.separator();
        if ui.button("Keep this picture to compare").clicked() {
            self.store_snapshot();
        }
        if ui.button("Compare with a file…").clicked() {
            self.dialog = Some(Dialog::Compare(self.folder()));
        }
        if let Some(beside) = &self.beside
            && ui.button(format!("Compare no more with {}", beside.name)).clicked()
        {
            self.beside = None;
        }
    }

    fn side_panel(&mut self, ui: &mut Ui, draft: Option<&mut Look>) {
        Panel::right("panel").default_size(330.0).show(ui, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                let Some(look) = draft else {
                    ui.weak("Nothing is open.");
                    return;
                };
                ui.add_space(4.0);
                panels::display(ui, look);
                self.histogram(ui);
                self.picking = panels::camera(ui, &mut look.camera, self.picking);
                panels::materials(ui, &mut look.materials, &mut self.filter);
                panels::lights(ui, &mut look.lights, look.camera.look_at);
                panels::environment(ui, &mut look.environment, &self.image_names);
                panels::render(ui, look);
                self.notes(ui);
            });
        });
    }

    fn notes(&self, ui: &mut Ui) {
        let status = self.live.status();
        let notes = self.document.iter().flat_map(|d| &d.notes).chain(&status.notes);
        let mut notes: Vec<&String> = notes.collect();
        notes.dedup();
        if notes.is_empty() {
            return;
        }
        egui::CollapsingHeader::new(format!("Notes ({})", notes.len())).show(ui, |ui| {
            for note in notes {
                ui.colored_label(theme::NOTE, note);
            }
        });
    }

    fn histogram(&self, ui: &mut Ui) {
        let Some(shown) = &self.shown else { return };
        let counts = &shown.picture.histogram.counts;
        let size = vec2(ui.available_width(), 56.0);
        let (rect, response) = ui.allocate_exact_size(size, egui::Sense::hover());
        let painter = ui.painter_at(rect);
        painter.rect_filled(rect, 3.0, ui.visuals().extreme_bg_color);
        let most = counts.iter().flatten().copied().max().unwrap_or(0).max(1) as f32;
        let colors = [
            Color32::from_rgb(220, 70, 60),
            Color32::from_rgb(80, 190, 90),
            Color32::from_rgb(80, 120, 230),
        ];
        let at = |bin: usize| rect.left() + rect.width() * bin as f32 / (BINS - 1) as f32;
        for (counts, color) in counts.iter().zip(colors) {
            let height =
                |n: u32| rect.bottom() - 2.0 - (n as f32 / most).sqrt() * (rect.height() - 4.0);
            let line = counts.iter().enumerate().map(|(bin, &n)| egui::pos2(at(bin), height(n)));
            painter.add(egui::Shape::line(line.collect(), egui::Stroke::new(1.2, color)));
        }
        painter.vline(at(BINS / 2), rect.y_range(), egui::Stroke::new(1.0, Color32::from_gray(90)));
        response.on_hover_text(format!(
            "How many pixels are how bright, from 16 stops below white (the line) to 16 above. \
             {} cannot be shown as they are.",
            shown.picture.clipped
        ));
    }

    fn status_bar(&mut self, ui: &mut Ui) {
        Panel::bottom("status").show(ui, |ui| {
            ui.horizontal(|ui| {
                let status = self.live.status();
                ui.label(self.progress_text(&status));
                if let Some(job) = self.job.clone() {
                    self.job_progress(ui, &job);
                }
                if let Some(problem) = &status.problem {
                    ui.colored_label(theme::ERROR, &problem.what);
                } else if let Some(message) = &self.message {
                    ui.weak(message);
                }
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    if let Some(opening) = self.opening.as_ref().filter(|o| o.again) {
                        ui.weak(format!(
                            "reading again… {:.0} s",
                            opening.since.elapsed().as_secs_f32()
                        ));
                    }
                });
            });
        });
    }

    fn job_progress(&self, ui: &mut Ui, job: &JobState) {
        if let JobState::Running { progress } = job {
            let part = progress.samples as f32 / progress.target.max(1) as f32;
            let text = format!("{} of {} samples", progress.samples, progress.target);
            ui.add(egui::ProgressBar::new(part).desired_width(180.0).text(text));
            if ui.button("Stop").clicked() {
                self.live.stop_job();
            }
        }
    }

    fn progress_text(&self, status: &Status) -> String {
        let Some(progress) = status.progress else { return "nothing is rendered".to_owned() };
        let (seconds, divisor) = (status.spent.as_secs_f64(), status.divisor.max(1));
        if divisor > 1 {
            return format!("a first look, 1:{divisor}");
        }
        let of = if self.endless { String::new() } else { format!(" of {}", progress.target) };
        let noise = self.shown.as_ref().and_then(|s| s.picture.noise);
        let noise = noise.map_or(String::new(), |n| format!(", noise {:.2} %", 100.0 * n));
        let state = match (self.paused, progress.finished) {
            (true, _) => ", paused",
            (_, true) => ", done",
            _ => "",
        };
        let samples = progress.samples;
        format!("{samples}{of} samples, {seconds:.1} s{noise}{state}")
    }

    fn picture(&mut self, ui: &mut Ui, draft: Option<&mut Look>) {
        let size = match (&draft, &self.shown) {
            (Some(look), _) => look.settings.size,
            (None, Some(shown)) => shown.picture.size,
            (None, None) => [16, 9],
        };
        let [picture, beside] = &self.textures;
        let laid = self.canvas.show(ui, size, picture.as_ref(), beside.as_ref());
        if let Some(look) = draft {
            self.hear_mouse(ui, &laid, look);
        }
        self.cursor_values(ui, &laid);
        self.what_is_missing(ui, &laid);
    }

    fn hear_mouse(&mut self, ui: &Ui, laid: &Laid, look: &mut Look) {
        let response = &laid.response;
        let (modifiers, scroll) = ui.input(|i| (i.modifiers, i.smooth_scroll_delta().y));
        let at = response.interact_pointer_pos().or(response.hover_pos());
        if let Some(place) = at.and_then(|at| laid.place(at)) {
            let asked = response.double_clicked() || (self.picking && response.clicked());
            if asked && look.camera.kind.lens().is_some() {
                self.live.find_focus(Vec2::new(place.x, place.y));
                self.picking = false;
            }
        }
        if self.canvas.tool == Tool::Picture || modifiers.command || laid.on_wipe {
            return;
        }
        let mut pose = pose_of(look);
        let delta = response.drag_delta();
        // As much as the picture's height turns by this angle.
        let height = laid.rect.height().max(1.0);
        let (right, down) = (f64::from(delta.x / height), f64::from(delta.y / height));
        let (primary, middle, secondary) = (
            response.dragged_by(egui::PointerButton::Primary),
            response.dragged_by(egui::PointerButton::Middle),
            response.dragged_by(egui::PointerButton::Secondary),
        );
        if delta != egui::Vec2::ZERO {
            if middle || (primary && modifiers.shift) {
                let visible = match look.camera.kind {
                    CameraKind::Orthographic { height, .. } => f64::from(height),
                    CameraKind::Perspective { .. } | CameraKind::Equirectangular => {
                        2.0 * pose.distance() * vertical_half_angle(look).tan()
                    }
                };
                pose.pan(-right * visible, down * visible);
            } else if secondary {
                let angle = 2.0 * vertical_half_angle(look);
                pose.turn(right * angle, down * angle);
            } else if primary {
                pose.orbit(-right * std::f64::consts::PI, -down * std::f64::consts::PI);
            }
        }
        if response.hovered() && scroll != 0.0 {
            let factor = (-f64::from(scroll) * 2e-3).exp();
            if let CameraKind::Orthographic { height, .. } = &mut look.camera.kind {
                *height = (f64::from(*height) * factor).clamp(1e-6, 1e12) as f32;
            } else {
                pose.dolly(factor);
            }
        }
        put_pose(look, pose);
    }

    fn cursor_values(&self, ui: &Ui, laid: &Laid) {
        let Some(shown) = &self.shown else { return };
        let Some(at) = laid.response.hover_pos().filter(|_| self.panels) else { return };
        let Some([x, y]) = laid.pixel(at) else { return };
        let image = &shown.picture.image;
        let scale = |at: u32, from: f32, to: u32| {
            ((at as f32 / from * to as f32) as u32).min(to.max(1) - 1)
        };
        let whole = self.history.as_ref().map_or(shown.picture.size, |h| h.present().settings.size);
        let (px, py) =
            (scale(x, whole[0] as f32, image.width()), scale(y, whole[1] as f32, image.height()));
        let i = (py * image.width() + px) as usize;
        let value = |name: &str| image.channel(name).and_then(|c| c.get(i)).copied();
        let [r, g, b] = ["R", "G", "B"].map(|name| value(name).unwrap_or(0.0));
        let count = value("samples.Y").map_or(String::new(), |n| format!("   {n} samples"));
        let text = format!("{x}, {y}   {r:.5}  {g:.5}  {b:.5}{count}");
        let painter = ui.painter();
        let corner = laid.response.rect.left_bottom() + vec2(8.0, -8.0);
        let font = egui::FontId::monospace(12.0);
        let galley = painter.layout_no_wrap(text, font, Color32::from_gray(230));
        let rect = Align2::LEFT_BOTTOM.anchor_size(corner, galley.size());
        painter.rect_filled(rect.expand(4.0), 3.0, Color32::from_black_alpha(170));
        painter.galley(rect.min, galley, Color32::WHITE);
    }

    /// Said over the picture while there is none, or while something is wrong.
    fn what_is_missing(&mut self, ui: &mut Ui, laid: &Laid) {
        let middle = laid.response.rect.center();
        if let Some(opening) = self.opening.as_ref().filter(|o| !o.again) {
            let seconds = opening.since.elapsed().as_secs_f32();
            let name = opening.file.as_deref().and_then(Path::file_name);
            let name = name.map_or("the built-in scene".into(), |n| n.to_string_lossy());
            let step = match opening.step() {
                Step::Reading => format!("Reading {name}…"),
                Step::Building(0) => "Preparing…".to_owned(),
                Step::Building(triangles) => {
                    format!("Building the tree of {triangles} triangles…")
                }
            };
            if seconds > 0.3 || self.shown.is_none() {
                let text = format!("{step}  {seconds:.1} s");
                let font = egui::FontId::proportional(18.0);
                let painter = ui.painter();
                painter.text(middle, Align2::CENTER_CENTER, text, font, Color32::from_gray(170));
            }
            ui.ctx().request_repaint_after(std::time::Duration::from_millis(100));
        } else if self.document.is_none() && self.trouble.is_none() {
            let font = egui::FontId::proportional(18.0);
            let text = "Drop a scene, a mesh or a sky here";
            ui.painter().text(middle, Align2::CENTER_CENTER, text, font, Color32::from_gray(150));
        }
        if let Some(trouble) = self.trouble.clone() {
            let area = egui::Area::new(egui::Id::unique("trouble"))
                .fixed_pos(laid.response.rect.left_top() + vec2(12.0, 12.0));
            area.show(ui.ctx(), |ui| {
                egui::Frame::popup(ui.style()).show(ui, |ui| {
                    ui.set_max_width((laid.response.rect.width() - 60.0).clamp(200.0, 640.0));
                    ui.colored_label(theme::ERROR, &trouble);
                    if self.document.is_some() {
                        ui.weak("The last good scene is still shown.");
                    }
                    ui.horizontal(|ui| {
                        if ui.button("Read again").clicked() {
                            let (file, again) = self.tried.clone();
                            self.open(file, again);
                            self.trouble = None;
                        }
                        if ui.button("Dismiss").clicked() {
                            self.trouble = None;
                        }
                    });
                });
            });
        }
    }

    fn dialogs(&mut self, context: &Context, _draft: Option<&mut Look>) {
        if self.help {
            self.help_window(context);
        }
        let Some(mut dialog) = self.dialog.take() else { return };
        let mut answer = None;
        let modal = egui::Modal::new(egui::Id::unique("dialog")).show(context, |ui| {
            ui.set_width(420.0);
            answer = show_dialog(ui, &mut dialog);
        });
        match answer {
            Some(true) => self.answered(dialog),
            Some(false) => {}
            None if modal.should_close() => {}
            None => self.dialog = Some(dialog),
        }
    }

    fn answered(&mut self, dialog: Dialog) {
        match dialog {
            Dialog::Open(file) => self.open_if_saved(Some(file.into())),
            Dialog::Compare(file) => self.read_image(file.into(), |file, image| {
                let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
                Work::Beside(Beside { name, image: Arc::new(image) })
            }),
            Dialog::SaveScene(file) => self.save_scene(file.into()),
            Dialog::SaveImage(file) => {
                if let Some(shown) = &self.shown {
                    self.write_image(Arc::clone(&shown.picture.image), file.into());
                }
            }
            Dialog::Render { file, spp, size } => {
                if let Some(history) = &self.history {
                    let settings = rutilant::settings::Settings {
                        spp,
                        size,
                        ..history.present().settings.clone()
                    };
                    match rutilant_formats::image::check_writable(Path::new(&file)) {
                        Ok(()) => self.live.begin_job(Job { settings, file: file.into() }),
                        Err(error) => self.trouble(error.to_string()),
                    }
                }
            }
            Dialog::Discard(After::Close) => self.closing = true,
            Dialog::Discard(After::Open(file)) => self.open(file, false),
        }
    }

    fn help_window(&mut self, context: &Context) {
        let mut open = true;
        egui::Window::new("Keys").open(&mut open).resizable(false).show(context, |ui| {
            egui::Grid::new("keys").num_columns(2).striped(true).show(ui, |ui| {
                for action in Action::all() {
                    ui.label(action.label());
                    let waiting = self.remapping == Some(action);
                    let key = if waiting { "press a key…" } else { self.keys.key(action).name() };
                    if ui.button(key).on_hover_text("Click to choose another key").clicked() {
                        self.remapping = Some(action);
                    }
                    ui.end_row();
                }
            });
            if ui.button("The usual keys").clicked() {
                self.keys = KeyMap::default();
                self.preferences.keys.clear();
                self.keep_preferences();
            }
            ui.separator();
            ui.weak(
                "Drag to go around, with Shift or the middle button to shift, with the right button \
                 to look around; the wheel goes nearer. A double click focuses. With Ctrl, drag and \
                 wheel move the picture instead.",
            );
        });
        self.help &= open;
    }
}

/// Asks; true to go on, false to give up.
fn show_dialog(ui: &mut Ui, dialog: &mut Dialog) -> Option<bool> {
    let (title, go_on) = match dialog {
        Dialog::Open(_) => ("Open a scene or a mesh", "Open"),
        Dialog::Compare(_) => ("Compare with an image", "Compare"),
        Dialog::SaveScene(_) => ("Save the scene", "Save"),
        Dialog::SaveImage(_) => ("Save what is shown", "Save"),
        Dialog::Render { .. } => ("Render at full quality", "Render"),
        Dialog::Discard(_) => ("The scene has changes that are not saved", "Discard them"),
    };
    ui.heading(title);
    let mut entered = false;
    match dialog {
        Dialog::Open(file)
        | Dialog::Compare(file)
        | Dialog::SaveScene(file)
        | Dialog::SaveImage(file)
        | Dialog::Render { file, .. } => {
            let label = ui.label("File");
            let field = egui::TextEdit::singleline(file).desired_width(f32::INFINITY);
            let response = ui.add(field).labelled_by(label.id);
            entered = response.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter));
            if !response.has_focus() && !entered && ui.memory(|m| m.focused().is_none()) {
                response.request_focus();
            }
        }
        Dialog::Discard(_) => {}
    }
    if let Dialog::Render { spp, size, .. } = dialog {
        widgets::row(ui, "Samples per pixel", |ui, name| {
            ui.add(egui::DragValue::new(spp).range(1..=1_000_000_u64)).labelled_by(name);
        });
        widgets::row(ui, "Size", |ui, name| {
            for side in size {
                ui.add(egui::DragValue::new(side).range(1..=16_384)).labelled_by(name);
            }
        });
    }
    ui.add_space(6.0);
    let mut answer = entered.then_some(true);
    ui.horizontal(|ui| {
        if ui.button(go_on).clicked() {
            answer = Some(true);
        }
        if ui.button("Cancel").clicked() {
            answer = Some(false);
        }
    });
    answer
}

fn pose_of(look: &Look) -> Pose {
    let camera = &look.camera;
    Pose { position: camera.position, look_at: camera.look_at, up: camera.up }
}

fn put_pose(look: &mut Look, pose: Pose) {
    let camera = &mut look.camera;
    (camera.position, camera.look_at, camera.up) = (pose.position, pose.look_at, pose.up);
}

/// Half of what is seen from top to bottom, in radians.
fn vertical_half_angle(look: &Look) -> f64 {
    match &look.camera.kind {
        CameraKind::Perspective { view: AngleOfView::FovDegrees(degrees), .. } => {
            0.5 * f64::from(*degrees).to_radians()
        }
        CameraKind::Perspective {
            view: AngleOfView::FocalLengthMm(mm), sensor_height_mm, ..
        } => (0.5 * f64::from(*sensor_height_mm / *mm)).atan(),
        CameraKind::Orthographic { .. } | CameraKind::Equirectangular => 0.4,
    }
}

/// Half of what is seen in the narrower direction, in radians.
fn half_angle(look: &Look) -> f64 {
    let [width, height] = look.settings.size.map(f64::from);
    (vertical_half_angle(look).tan() * (width / height).min(1.0)).atan()
}

/// Writes a text in place of a file's, as a whole or not at all.
fn replace(file: &Path, text: &str) -> std::io::Result<()> {
    let folder = file.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut new = tempfile::NamedTempFile::new_in(folder)?;
    std::io::Write::write_all(&mut new, text.as_bytes())?;
    if let Ok(metadata) = std::fs::metadata(file) {
        new.as_file().set_permissions(metadata.permissions())?;
    }
    new.persist(file).map(|_| ()).map_err(|error| error.error)
}
