//! Everything behind the window, and how what people want becomes what is rendered.

use super::canvas::Canvas;
use super::input::keep_focus_in_front;
use super::listing::Listing;
use super::report::{Happened, Report};
use super::theme;
use crate::Describe;
use crate::flight::Flight;
use crate::history::History;
use crate::keys::{Action, KeyMap};
use crate::live::{JobState, Live, Shown, Wish};
use crate::picture::View;
use crate::prefs::Preferences;
use crate::source::{Document, Opening, Reading};
use crate::watch::Watch;
use eframe::egui::{Context, Id, Memory, TextureHandle, Ui};
use rutilant::image::Image;
use rutilant::light::Environment;
use rutilant_formats::camera::{AuthoredCamera, FocusOn};
use rutilant_formats::{Limits, Look};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};

/// The picture beside the rendered one.
pub(super) struct Beside {
    pub(super) name: String,
    pub(super) image: Arc<Image>,
}

/// Everything behind the window.
pub(crate) struct Window {
    pub(super) reading: Reading,
    pub(super) describe: Describe,
    pub(super) live: Live,
    pub(super) context: Context,
    pub(super) report: Report,
    pub(super) preferences: Preferences,
    pub(super) preferences_file: Option<PathBuf>,
    pub(super) keys: KeyMap,
    /// The action whose key is being changed.
    pub(super) remapping: Option<Action>,

    pub(super) opening: Option<Opening>,
    /// What was opened last, or should have been, and whether it was on the screen already.
    pub(super) tried: (Option<PathBuf>, bool),
    pub(super) document: Option<Document>,
    pub(super) history: Option<History<Look>>,
    /// The look that the file has.
    pub(super) saved: Option<Arc<Look>>,
    /// Names of all images, those that were added at the end.
    pub(super) image_names: Vec<String>,
    /// The images that were added, with their files. Kept, so that a scene that is read again has
    /// them at once.
    pub(super) added_images: Vec<(PathBuf, Arc<Image>)>,
    pub(super) watch: Option<Watch>,

    pub(super) view: View,
    pub(super) paused: bool,
    pub(super) endless: bool,
    pub(super) beside: Option<Beside>,
    /// What was wished for last.
    pub(super) wished: Option<Wish>,
    pub(super) shown: Option<Shown>,
    pub(super) textures: [Option<TextureHandle>; 2],

    pub(super) canvas: Canvas,
    pub(super) flight: Flight,
    /// Counts presses of the mouse and runs of keys: each is one gesture.
    pub(super) gesture: u64,
    pub(super) picking: bool,
    /// The depth that H goes back to.
    pub(super) depth: Option<u32>,
    pub(super) panels: bool,
    pub(super) help: bool,
    pub(super) dialog: Option<Dialog>,
    /// The files that dialogs offer.
    pub(super) listing: Listing,
    /// Whether the frame before left the keyboard to a widget, and to which.
    pub(super) typing: bool,
    pub(super) focused: Option<Id>,
    /// When the wheel was turned last, in seconds.
    pub(super) scrolled: f64,
    /// Whether a gesture was going on in the frame before.
    pub(super) in_gesture: bool,
    /// Held by whoever writes a file.
    pub(super) writing: Arc<()>,
    pub(super) filter: String,
    /// The last thing that went wrong, and the last that went well.
    pub(super) trouble: Option<String>,
    /// Whether the files of the scene that is shown cannot be read as they are now.
    pub(super) unreadable: bool,
    /// Whether nothing is rendered any more.
    pub(super) broken: bool,
    pub(super) message: Option<String>,
    /// The message that is shown, and since when, in seconds.
    pub(super) said: (Option<String>, f64),
    /// The title of the window.
    pub(super) titled: String,
    /// What is to be told once the scene has been read again.
    pub(super) then_say: Option<String>,
    /// What is told as soon as nothing else has to be.
    pub(super) warning: Option<String>,
    pub(super) job: Option<JobState>,
    pub(super) work: (Sender<Work>, Receiver<Work>),
    pub(super) closing: bool,
}

/// What is asked for in a dialog.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Dialog {
    Open(String),
    Compare(String),
    Sky(String),
    SaveScene(String),
    SaveImage(String),
    Render {
        file: String,
        spp: u64,
        size: [u32; 2],
    },
    Discard(After),
    /// Whether the file that another dialog named is to be replaced.
    Replace(Box<Dialog>),
    /// Whether the picture that is being rendered for a file is given up.
    StopJob,
}

/// What happens once changes may be lost.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum After {
    Close,
    Open(Option<PathBuf>),
}

/// A scene that was written.
pub(super) struct Saved {
    /// The file that it was opened from.
    pub(super) of: Option<PathBuf>,
    pub(super) look: Arc<Look>,
    pub(super) text: String,
}

/// Files that are read or written beside the interface.
pub(super) enum Work {
    /// Written; a scene with its look and its text.
    Wrote {
        file: PathBuf,
        hash: Option<String>,
        saved: Option<Saved>,
    },
    /// An image of a sky, to be used as the sky `like` is, in the scene of the file `of`.
    Sky {
        file: PathBuf,
        image: Image,
        like: Environment,
        of: Option<PathBuf>,
    },
    Beside(Beside),
    /// A scene was not saved: its file has changed since it was read.
    Stale {
        file: PathBuf,
    },
    Failed(String),
}

impl Window {
    pub(crate) fn new(
        context: &Context,
        reading: Reading,
        threads: usize,
        file: Option<PathBuf>,
        preferences_file: Option<PathBuf>,
        describe: Describe,
        report: Report,
    ) -> Self {
        theme::apply(context);
        let (preferences, broken) = match preferences_file.as_deref().map(Preferences::read) {
            Some(Ok(preferences)) => (preferences, None),
            Some(Err(what)) => (Preferences::default(), Some(what)),
            None => (Preferences::default(), None),
        };
        // What its owner may want to mend is not written over.
        let preferences_file = preferences_file.filter(|_| broken.is_none());
        let (keys, unknown) = preferences.key_map();
        let unknown = unknown.first().map(|line| {
            let file = preferences_file.as_deref().unwrap_or(Path::new("window.toml"));
            format!("{}: {line} means nothing here", file.display())
        });
        let wake = context.clone();
        let mut window = Self {
            live: Live::start(threads, move || wake.request_repaint()),
            context: context.clone(),
            report,
            keys,
            preferences,
            preferences_file,
            remapping: None,
            reading,
            describe,
            opening: None,
            tried: (None, false),
            document: None,
            history: None,
            saved: None,
            image_names: Vec::new(),
            added_images: Vec::new(),
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
            listing: Listing::default(),
            typing: false,
            focused: None,
            scrolled: f64::NEG_INFINITY,
            in_gesture: false,
            writing: Arc::default(),
            filter: String::new(),
            trouble: None,
            unreadable: false,
            broken: false,
            message: None,
            said: (None, 0.0),
            titled: String::new(),
            then_say: None,
            warning: broken.or(unknown),
            job: None,
            work: channel(),
            closing: false,
        };
        window.open(file, false);
        window
    }

    /// Makes a changed draft the present look, and tells the rendering.
    pub(super) fn commit(&mut self, ui: &Ui, before: Option<Arc<Look>>, draft: Option<Look>) {
        let Some(history) = &mut self.history else { return };
        /// A wheel that was not turned for so long is turned anew, in seconds.
        const WHEEL_RESTS: f64 = 0.3;
        let (pressed, down, time) =
            ui.input(|i| (i.pointer.any_pressed(), i.pointer.any_down(), i.time));
        let scrolls = ui.input(|i| i.smooth_scroll_delta().y != 0.0 || i.zoom_delta() != 1.0);
        let typing = ui.ctx().egui_wants_keyboard_input();
        let turned_anew = scrolls && time - self.scrolled > WHEEL_RESTS;
        if scrolls {
            self.scrolled = time;
        }
        let focused = ui.ctx().memory(Memory::focused);
        let another = std::mem::replace(&mut self.focused, focused) != focused;
        if pressed || turned_anew || (typing && another) {
            self.gesture += 1;
        }
        let moving =
            down || typing || self.flight.is_moving() || time - self.scrolled <= WHEEL_RESTS;
        // What happens in the frame in which a gesture ends belongs to it.
        let was_moving = std::mem::replace(&mut self.in_gesture, moving);
        let in_gesture = moving || was_moving;
        // Undo, or a file that was read again, has the last word.
        let undone = before.is_none_or(|before| !Arc::ptr_eq(&before, history.present()));
        if let Some(mut draft) = draft.filter(|_| !undone) {
            keep_focus_in_front(&mut draft.camera);
            let size = &mut draft.settings.size;
            if *size != history.present().settings.size
                && let Some(what) = too_large(*size, &self.reading.limits)
            {
                *size = history.present().settings.size;
                self.message = Some(what);
            }
            history.change(draft, in_gesture.then_some(self.gesture));
        }
        if !moving {
            history.end_gesture();
        }
        self.wish();
    }

    /// Tells the rendering what is to be seen, where that has changed.
    pub(super) fn wish(&mut self) {
        let Some(history) = &self.history else { return };
        let look = Arc::clone(history.present());
        let view = View { display: look.display, ..self.view };
        let beside = self.beside.as_ref().map(|b| Arc::clone(&b.image));
        let (paused, endless) = (self.paused, self.endless);
        let wish = Wish { look, view, paused, endless, beside };
        if !self.wished.as_ref().is_some_and(|wished| wished.is_same_as(&wish)) {
            self.wished = Some(wish.clone());
            self.live.wish(wish);
        }
    }

    /// A change that is a step of its own.
    pub(super) fn edit(&mut self, change: impl FnOnce(&mut Look)) {
        if let Some(history) = &mut self.history {
            let mut look = Look::clone(history.present());
            change(&mut look);
            history.change(look, None);
        }
    }

    pub(super) fn undo(&mut self) {
        if let Some(history) = &mut self.history {
            history.undo();
        }
    }

    pub(super) fn redo(&mut self) {
        if let Some(history) = &mut self.history {
            history.redo();
        }
    }

    /// Whether anything differs from the file.
    pub(super) fn is_touched(&self) -> bool {
        self.differs(|now, filed| now == filed)
    }

    /// Whether the look differs from the file's in more than where the camera stands.
    pub(super) fn is_changed(&self) -> bool {
        self.differs(|now, filed| {
            let mut kind = now.kind;
            // A point of focus that one has flown past was given up by itself.
            if let (Some(mine), Some(theirs)) = (kind.lens_mut(), filed.kind.lens())
                && matches!((mine.focus, theirs.focus), (FocusOn::LookAt, FocusOn::Point(_)))
            {
                mine.focus = theirs.focus;
            }
            kind == filed.kind
        })
    }

    /// Whether the look differs from the file's, where its camera differs unless they are the `same`.
    fn differs(&self, same: impl Fn(&AuthoredCamera, &AuthoredCamera) -> bool) -> bool {
        let (Some(history), Some(saved)) = (&self.history, &self.saved) else { return false };
        let now = history.present();
        // One may look through another of the file's cameras.
        let mut cameras = self.document.iter().flat_map(|document| &document.cameras);
        let filed = cameras.find(|camera| camera.name == now.camera.name);
        let Look { camera, environment, materials, lights, settings, display } = &**now;
        !same(camera, filed.unwrap_or(&saved.camera))
            || *environment != saved.environment
            || *materials != saved.materials
            || *lights != saved.lights
            || *settings != saved.settings
            || *display != saved.display
    }

    pub(super) fn store_snapshot(&mut self) {
        if let Some(shown) = &self.shown {
            let image = Arc::clone(&shown.picture.image);
            self.beside = Some(Beside { name: "the kept picture".into(), image });
        }
    }

    pub(super) fn trouble(&mut self, what: String) {
        (self.report)(Happened::Trouble { what: what.clone() });
        self.trouble = Some(what);
    }

    pub(super) fn keep_preferences(&self) {
        if let Some(file) = &self.preferences_file {
            // A window that cannot remember is no reason to stop.
            drop(self.preferences.write(file));
        }
    }
}

/// What is said of a picture that has more pixels than a scene may ask for.
pub(super) fn too_large([width, height]: [u32; 2], limits: &Limits) -> Option<String> {
    let (pixels, most) = (u64::from(width) * u64::from(height), limits.picture);
    (pixels > most).then(|| {
        format!(
            "{width}x{height} are {pixels} pixels, and {most} are the limit; --limit picture=N sets it"
        )
    })
}
