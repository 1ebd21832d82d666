//! What other threads have finished: scenes, pictures, files.

use super::files::{added_sky, name_in};
use super::report::Happened;
use super::state::{After, Dialog, Saved, Window, Work};
use crate::history::History;
use crate::live::{JobState, Stage, Wish};
use crate::merge::{changed_over, merged};
use crate::picture::View;
use crate::source::{Document, Opening};
use crate::watch::{Changed, Watch};
use eframe::egui::{self, TextureOptions};
use rutilant::light::{Environment, EnvironmentLight};
use rutilant::scene::ImageId;
use rutilant_formats::camera::FocusOn;
use rutilant_formats::{CameraChoice, Look};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

impl Window {
    pub(super) fn open(&mut self, file: Option<PathBuf>, again: bool) {
        let mut reading = self.reading.clone();
        if !again && self.document.is_some() {
            // What the command line said was said of its own scene; but a sky is there to see any
            // scene by.
            (reading.camera, reading.size) = (CameraChoice::First, None);
            (reading.variant, reading.at_time) = (None, None);
            reading.parameters = Vec::new();
            reading.adjust = Arc::new(|_| {});
        }
        self.tried = (file.clone(), again);
        let files = self.document.as_ref().filter(|_| again).map_or(&[][..], |d| &d.files);
        let wake = self.context.clone();
        let wake = move || wake.request_repaint();
        self.opening = Some(Opening::begin(file, again, files, reading, wake));
    }

    /// Opens another scene, once changes to this one are saved or given up.
    pub(super) fn open_if_saved(&mut self, file: Option<PathBuf>) {
        if self.is_changed() {
            self.dialog = Some(Dialog::Discard(After::Open(file)));
        } else {
            self.open(file, false);
        }
    }

    /// Whether another scene is about to take the place of this one.
    pub(super) fn is_opening_another(&self) -> bool {
        self.opening.as_ref().is_some_and(|opening| !opening.again)
    }

    /// Takes what other threads have finished.
    pub(super) fn receive(&mut self) {
        if let Some(opened) = self.opening.as_ref().and_then(Opening::take)
            && let Some(opening) = self.opening.take()
        {
            match opened {
                Ok(opened) => self.opened(*opened, &opening),
                Err(what) => self.could_not_open(what, &opening),
            }
        }
        match self.watch.as_ref().filter(|_| self.opening.is_none()).map(Watch::changed) {
            Some(Changed::Soon(left)) => self.context.request_repaint_after(left),
            Some(Changed::Files(files)) if self.unreadable || !self.wrote_only(&files) => {
                match &self.document {
                    Some(document) => self.open(document.file.clone(), true),
                    None => self.open(self.tried.0.clone(), false),
                }
            }
            Some(Changed::Files(_) | Changed::Nothing) | None => {}
        }
        while let Ok(work) = self.work.1.try_recv() {
            match work {
                Work::Wrote { file, hash, saved } => {
                    if !self.unreadable {
                        self.trouble = None;
                    }
                    if let Some(saved) = saved {
                        self.saved_as(&file, saved);
                    }
                    let hash_shown = hash.as_ref().map(|h| format!(", hash {h}"));
                    let hash_shown = hash_shown.unwrap_or_default();
                    self.message = Some(format!("wrote {}{hash_shown}", file.display()));
                    (self.report)(Happened::Wrote { file, hash });
                }
                Work::Sky { file, image, like, of } => {
                    // Unless another scene has been opened meanwhile.
                    if self.document.as_ref().is_none_or(|document| document.file == of) {
                        self.use_sky(&file, image, like);
                    }
                }
                Work::Beside(beside) => self.beside = Some(beside),
                Work::Stale { file } if !self.shows(&file) => {}
                Work::Stale { file } => {
                    self.closing = false;
                    self.then_say = Some(format!(
                        "{}: it was not saved, because it had changed on disk; that has been read \
                         now, and you can save again",
                        file.display()
                    ));
                    self.open(Some(file), true);
                }
                Work::Failed(what) => {
                    self.closing = false;
                    self.trouble(what);
                }
            }
        }
        if self.opening.is_none()
            && self.trouble.is_none()
            && let Some(warning) = self.warning.take()
        {
            self.trouble(warning);
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
        if self.live.is_broken() && !self.broken {
            self.broken = true;
            self.trouble("the rendering broke off; please save, and report it as a bug".into());
        }
        self.receive_job();
        self.receive_picture();
    }

    /// A scene was written: from now on it is this file that is shown.
    fn saved_as(&mut self, file: &Path, Saved { of, look, text }: Saved) {
        // Unless another scene has been opened meanwhile, or is about to be.
        let another = self.is_opening_another();
        let document = self.document.as_mut().filter(|d| d.file == of && !another);
        let Some(document) = document else { return };
        let was = &document.look.settings;
        document.filed = changed_over(was, &look.settings, &document.filed);
        document.look = Look::clone(&look);
        self.saved = Some(Arc::clone(&look));
        if document.file.as_deref() == Some(file) && added_sky(document, &look).is_none() {
            // What is rendered goes on.
            let mut cameras = document.cameras.iter_mut();
            if let Some(camera) = cameras.find(|camera| camera.name == look.camera.name) {
                camera.clone_from(&look.camera);
            }
            document.text = Some(text);
        } else {
            // An image that was added is the file's own now, under another number.
            document.look.environment = None;
            self.open(Some(file.to_owned()), true);
        }
    }

    /// Whether this is the file of the scene that is shown, and no other is about to be.
    fn shows(&self, file: &Path) -> bool {
        let own = self.document.as_ref().and_then(|document| document.file.as_deref());
        !self.is_opening_another() && own == Some(file)
    }

    /// Whether of these files only the scene's own has changed, and it says what was read or written
    /// last.
    fn wrote_only(&self, files: &BTreeSet<PathBuf>) -> bool {
        let own = self.document.as_ref().and_then(|d| Some((d.file.as_ref()?, d.text.as_ref()?)));
        own.is_some_and(|(file, text)| {
            let own = file.canonicalize().ok();
            files.iter().all(|changed| Some(changed) == own.as_ref())
                && std::fs::read_to_string(file).is_ok_and(|now| now == *text)
        })
    }

    pub(super) fn receive_job(&mut self) {
        match self.live.job() {
            Some(JobState::Done { image, job, took }) => {
                self.job = None;
                self.message = Some(format!("rendered in {:.1} s", took.as_secs_f64()));
                self.write_image(image, &job.settings, job.display, job.file, &job.mattes);
            }
            Some(JobState::Failed { what }) => {
                self.job = None;
                self.trouble(what);
            }
            Some(running) => {
                self.job = Some(running);
                self.context.request_repaint_after(Duration::from_millis(100));
            }
            // It was stopped.
            None => self.job = None,
        }
    }

    pub(super) fn receive_picture(&mut self) {
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
            let image = Arc::clone(&picture.small);
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

    fn could_not_open(&mut self, what: String, opening: &Opening) {
        if opening.again || self.document.is_none() {
            // It may be a file that is missing: whatever comes beside the scene is worth a try.
            let document = self.document.iter();
            let known = document.flat_map(|d| d.file.iter().chain(&d.files));
            let known: Vec<PathBuf> = known.chain(&opening.file).cloned().collect();
            self.watch_files(known, opening.file.as_deref(), opening);
            self.unreadable = true;
        }
        if self.then_say.take().is_some() {
            self.message = Some("not saved: the file cannot be read as it is now".into());
        }
        self.trouble(what);
    }

    /// Watches files from now on, and what comes `beside` one; what has changed since the `opening`
    /// began counts.
    fn watch_files(
        &mut self,
        files: impl IntoIterator<Item = PathBuf>,
        beside: Option<&Path>,
        opening: &Opening,
    ) {
        let wake = self.context.clone();
        let files: Vec<PathBuf> = files.into_iter().collect();
        let changed = opening.changed_meanwhile(&files);
        let watch = Watch::begin(files, beside, move || wake.request_repaint());
        watch.succeed(&opening.watch);
        watch.note(changed);
        self.watch = Some(watch);
    }

    pub(super) fn opened(
        &mut self,
        (mut stage, mut document): (Stage, Document),
        opening: &Opening,
    ) {
        let again = opening.again;
        self.reading = opening.reading.clone();
        if let Some(before) = self.document.as_ref().filter(|_| again) {
            // What the command line said, and what was set since, stays where the file is as it was.
            let was = &before.look.settings;
            document.look.settings = changed_over(&before.filed, &document.filed, was);
        }
        let theirs = document.look.clone();
        let before = self.document.as_ref().map(|d| d.look.clone());
        let mut look = match (again, &before, &self.history) {
            (true, Some(before), Some(history)) => {
                let old = self.document.as_ref().map_or(&[][..], |document| &document.cameras);
                merged(before, history.present(), &theirs, [old, &document.cameras])
            }
            _ => theirs.clone(),
        };
        // Materials that were edited know the textures of before by their numbers.
        let same_textures =
            self.document.as_ref().is_some_and(|before| before.textures == document.textures);
        if !same_textures {
            look.materials.clone_from(&theirs.materials);
        }
        // Images that were added stay, behind those that the file has now.
        let own_before = self.document.as_ref().map(|before| &before.image_names);
        let same_images = own_before == Some(&document.image_names);
        let unchanged = before.as_ref().is_some_and(|b| b.environment == theirs.environment);
        let added_sky = self.added_sky().filter(|_| again && unchanged);
        if !(again && (same_images || added_sky.is_some())) {
            self.added_images.clear();
        }
        if let Some(number) = added_sky
            && let Some(Environment { light: EnvironmentLight::Image { image, .. }, .. }) =
                &mut look.environment
        {
            *image = ImageId(document.image_names.len() as u32 + number);
        }
        for (_, image) in &self.added_images {
            stage.scene.add_image(Arc::clone(image));
        }
        // States of before fit the scene as long as images and materials have their numbers.
        let names = |look: &Look| look.materials.iter().map(|m| m.name.clone()).collect::<Vec<_>>();
        let fits = same_images
            && same_textures
            && before.as_ref().is_some_and(|before| names(before) == names(&theirs));
        stage.scene.camera = match look.camera.camera(look.settings.size) {
            Ok(camera) => camera,
            Err(_) => stage.scene.camera,
        };
        (self.trouble, self.unreadable) = (None, false);
        if let Some(what) = self.then_say.take() {
            self.trouble(what);
        }
        (self.report)(Happened::Opened { name: document.name(&self.reading) });
        let history = match self.history.take().filter(|_| again && fits) {
            Some(mut history) => {
                if !history.change(look, None) {
                    // The same look of another scene: pictures of before do not show it.
                    history.renew();
                }
                history
            }
            None => History::new(look),
        };
        self.saved = Some(Arc::new(theirs));
        let added = self.added_images.iter().map(|(file, _)| name_in(&document, file));
        self.image_names = document.image_names.iter().cloned().chain(added).collect();
        let watched = document.file.iter().chain(&document.files).cloned();
        self.watch_files(watched.collect::<Vec<_>>(), None, opening);
        let file_before = self.document.as_ref().and_then(|d| d.file.as_ref());
        let another = document.file.as_ref() != file_before;
        if let Some(file) = document.file.as_deref().filter(|_| another || !again) {
            self.preferences.opened(file);
            self.keep_preferences();
        }
        if !again {
            (self.canvas.zoom, self.canvas.offset) = (None, egui::Vec2::ZERO);
            self.depth = None;
        }
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
}
