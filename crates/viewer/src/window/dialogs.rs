//! Questions to the user: which file, how large, and whether changes may be lost.

use super::listing::Listing;
use super::state::{After, Beside, Dialog, Window, Work, too_large};
use super::widgets;
use crate::keys::{Action, KeyMap};
use crate::live::Job;
use crate::source::is_native;
use eframe::egui::text::{CCursor, CCursorRange};
use eframe::egui::{self, Context, Key, Ui};
use rutilant::settings::{Layers, Settings};
use rutilant_formats::image::Format;
use std::path::Path;
use std::sync::Arc;

impl Window {
    pub(super) fn dialogs(&mut self, context: &Context) {
        if self.help {
            self.help_window(context);
        }
        let Some(mut dialog) = self.dialog.take() else { return };
        let mut answer = None;
        let modal = egui::Modal::new(egui::Id::unique("dialog")).show(context, |ui| {
            ui.set_width(460.0);
            answer = show_dialog(ui, &mut dialog, &mut self.listing);
        });
        match answer {
            Some(true) => self.answered(dialog),
            Some(false) => {}
            None if modal.should_close() => {}
            None => self.dialog = Some(dialog),
        }
    }

    /// Asks once more where the dialog's file is there already, and is not the scene's own.
    pub(super) fn answered(&mut self, dialog: Dialog) {
        let own = self.document.as_ref().and_then(|d| d.file.as_deref());
        let read = |file: &Path| self.reads(file, matches!(dialog, Dialog::SaveScene(_)));
        match dialog.replaces() {
            Some(file) if matches!(dialog, Dialog::SaveScene(_)) && !is_native(file) => {
                let what = format!("{}: scenes are saved as .toml", file.display());
                self.trouble(what);
            }
            Some(file) if read(file) => {
                let what = format!("{}: the scene reads this file", file.display());
                self.trouble(what);
            }
            Some(file) if file.exists() && Some(file) != own => {
                self.dialog = Some(Dialog::Replace(Box::new(dialog)));
            }
            _ => self.do_it(dialog),
        }
    }

    /// Whether the scene that is shown is made of a file; its own one may be another scene's place.
    fn reads(&self, file: &Path, may_be_own: bool) -> bool {
        let (Some(document), Ok(file)) = (&self.document, file.canonicalize()) else {
            return false;
        };
        let own = document.file.as_ref().and_then(|own| own.canonicalize().ok());
        let is_own = own.as_ref() == Some(&file);
        (is_own && (!may_be_own || document.text.is_none()))
            || (!is_own && document.files.contains(&file))
    }

    fn do_it(&mut self, dialog: Dialog) {
        match dialog {
            Dialog::Replace(dialog) => self.do_it(*dialog),
            Dialog::Open(file) => self.open_if_saved(Some(file.into())),
            Dialog::Compare(file) => self.read_image(file.into(), |file, image| {
                let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
                Work::Beside(Beside { name, image: Arc::new(image) })
            }),
            Dialog::Sky(file) => self.read_sky(file.into(), self.new_sky()),
            Dialog::SaveScene(file) => self.save_scene(file.into()),
            Dialog::SaveImage(file) => {
                if let Some(shown) = &self.shown {
                    let image = Arc::clone(&shown.picture.image);
                    self.write_image(image, &shown.settings, shown.look.display, file.into(), &[]);
                }
            }
            Dialog::Render { file, spp, size } => {
                if let Some(history) = &self.history {
                    let display = history.present().display;
                    let path = Path::new(&file);
                    let settings = &history.present().settings;
                    let layered = Format::from_path(path).is_ok_and(Format::holds_layers);
                    let layers = if layered { settings.layers } else { Layers::NONE };
                    let settings = Settings { spp, size, layers, ..settings.clone() };
                    let fits = rutilant_formats::image::check_size(path, size[0], size[1]);
                    let fits = fits.and_then(|()| rutilant_formats::image::check_writable(path));
                    if let Some(what) = too_large(size, &self.reading.limits) {
                        self.message = Some(what);
                        return;
                    }
                    match fits {
                        Ok(()) => {
                            let (file, mattes) = (file.into(), Vec::new());
                            let begun = Job { settings, display, file, mattes };
                            if !self.live.begin_job(begun) {
                                let what = "another picture is being rendered for a file";
                                self.message = Some(format!("not begun: {what}"));
                            }
                        }
                        Err(error) => self.trouble(error.to_string()),
                    }
                }
            }
            Dialog::Discard(After::Close) => self.close_without_changes(),
            Dialog::StopJob => {
                self.live.stop_job();
                self.closing = true;
            }
            Dialog::Discard(After::Open(file)) => self.open(file, false),
        }
    }

    pub(super) fn help_window(&mut self, context: &Context) {
        let mut open = true;
        egui::Window::new("Keys").open(&mut open).default_pos([16.0, 36.0]).resizable(false).show(context, |ui| {
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
        if !open {
            self.close_help();
        }
    }
}

/// Selects what stands behind the folder in a field, so that what is typed takes its place.
fn select_name(context: &Context, field: egui::Id, path: &str) {
    let Some(mut state) = egui::TextEdit::load_state(context, field) else { return };
    let name = path.rfind(std::path::is_separator).map_or(0, |last| last + 1);
    let [begin, end] = [&path[..name], path].map(|part| CCursor::new(part.chars().count()));
    state.cursor.set_char_range(Some(CCursorRange::two(begin, end)));
    state.store(context, field);
}

impl Dialog {
    /// The file that it writes.
    fn replaces(&self) -> Option<&Path> {
        match self {
            Self::SaveScene(file) | Self::SaveImage(file) | Self::Render { file, .. } => {
                Some(Path::new(file))
            }
            Self::Open(_)
            | Self::Compare(_)
            | Self::Sky(_)
            | Self::Discard(_)
            | Self::Replace(_)
            | Self::StopJob => None,
        }
    }
}

/// Asks; true to go on, false to give up.
pub(super) fn show_dialog(ui: &mut Ui, dialog: &mut Dialog, listing: &mut Listing) -> Option<bool> {
    let (title, go_on) = match dialog {
        Dialog::Open(_) => ("Open a scene or a mesh", "Open"),
        Dialog::Compare(_) => ("Compare with an image", "Compare"),
        Dialog::Sky(_) => ("An image of the sky, in latitude and longitude", "Use"),
        Dialog::SaveScene(_) => ("Save the scene", "Save"),
        Dialog::SaveImage(_) => ("Save what is shown", "Save"),
        Dialog::Render { .. } => ("Render at full quality", "Render"),
        Dialog::Discard(_) => ("The scene has changes that are not saved", "Discard them"),
        Dialog::StopJob => ("A picture is being rendered for a file", "Give it up"),
        Dialog::Replace(_) => ("This file is there already", "Replace it"),
    };
    /// What can be opened.
    const SCENES: &[&str] = &["toml", "gltf", "glb", "pbrt", "xml", "obj", "ply", "stl"];
    /// What can be compared with, or be a sky.
    const IMAGES: &[&str] = &["exr", "hdr", "pfm", "png", "jpg", "jpeg"];
    ui.heading(title);
    let mut entered = false;
    let extensions = match dialog {
        Dialog::Open(_) => SCENES,
        Dialog::Compare(_) | Dialog::Sky(_) | Dialog::SaveImage(_) | Dialog::Render { .. } => {
            IMAGES
        }
        Dialog::SaveScene(_) => &["toml"],
        Dialog::Discard(_) | Dialog::StopJob | Dialog::Replace(_) => &[],
    };
    match dialog {
        Dialog::Open(file)
        | Dialog::Compare(file)
        | Dialog::Sky(file)
        | Dialog::SaveScene(file)
        | Dialog::SaveImage(file)
        | Dialog::Render { file, .. } => {
            let label = ui.label("File");
            let field = egui::TextEdit::singleline(file).desired_width(f32::INFINITY);
            let response = ui.add(field).labelled_by(label.id);
            entered = response.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter));
            if !response.has_focus() && !entered && ui.memory(|m| m.focused().is_none()) {
                response.request_focus();
                select_name(ui.ctx(), response.id, file);
            }
            entered |= listing.show(ui, file, extensions);
        }
        Dialog::Replace(dialog) => {
            let file = dialog.replaces().map(|file| file.display().to_string());
            ui.label(file.unwrap_or_default());
        }
        Dialog::Discard(_) | Dialog::StopJob => {}
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
