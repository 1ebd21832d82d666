//! What stands around the picture: the menu, the panels, the line below.

use super::canvas::Tool;
use super::input::{pose_of, put_pose, see_all};
use super::state::{Dialog, Window};
use super::{panels, theme};
use crate::live::{JobState, Status, target};
use crate::picture::{BINS, Channel};
use crate::pose::Axis;
use eframe::egui::{self, Color32, MenuBar, Panel, ScrollArea, Ui, ViewportCommand, vec2};
use rutilant_formats::Look;
use std::path::Path;

impl Window {
    pub(super) fn menu(&mut self, ui: &mut Ui, draft: Option<&mut Look>) {
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
                    self.toggle_help();
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

    /// Says which scene it is, with a star where it is not as in its file.
    pub(super) fn title(&mut self, context: &egui::Context) {
        let Some(document) = &self.document else { return };
        let star = if self.is_touched() { "*" } else { "" };
        let title = format!("{}{star} – Rutilant", document.name(&self.reading));
        if title != self.titled {
            context.send_viewport_cmd(ViewportCommand::Title(title.clone()));
            self.titled = title;
        }
    }

    pub(super) fn file_menu(&mut self, ui: &mut Ui, draft: Option<&Look>) {
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
        if ui.button("Save scene as…").clicked() {
            self.save_as();
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

    pub(super) fn camera_menu(&mut self, ui: &mut Ui, draft: Option<&mut Look>) {
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
        if ui.button("Copy as TOML").clicked() {
            self.print_pose(look);
        }
        ui.separator();
        let Some(document) = &self.document else { return };
        let mut pose = pose_of(look);
        if ui.button("See everything").clicked() {
            see_all(look, &mut pose, &document.bounds, None);
        }
        for (axis, name) in Axis::ALL {
            if ui.button(name).clicked() {
                see_all(look, &mut pose, &document.bounds, Some(axis));
            }
        }
        put_pose(look, pose);
    }

    pub(super) fn view_menu(&mut self, ui: &mut Ui) {
        for (channel, name) in Channel::ALL {
            ui.selectable_value(&mut self.view.channel, channel, name);
        }
        ui.separator();
        ui.checkbox(&mut self.view.false_color, "False colours").on_hover_text(
            "How bright it is, after exposure: from black, eight stops below white, to yellow, \
             eight above",
        );
        ui.checkbox(&mut self.view.overlay, "Mark what cannot be shown").on_hover_text(
            "Red is brighter than the screen can show, blue is negative, magenta no number",
        );
        ui.separator();
        if ui.button("Fit in the window").clicked() {
            (self.canvas.zoom, self.canvas.offset) = (None, egui::Vec2::ZERO);
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

    pub(super) fn side_panel(&mut self, ui: &mut Ui, draft: Option<&mut Look>) {
        Panel::right("panel").default_size(350.0).show(ui, |ui| {
            // What is changed in a scene that is about to be closed would be lost.
            if self.is_opening_another() {
                ui.disable();
            }
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
                panels::lights(ui, &mut look.lights, &look.camera);
                if panels::environment(ui, &mut look.environment, &self.image_names) {
                    self.dialog = Some(Dialog::Sky(self.folder()));
                }
                panels::render(ui, look);
                self.notes(ui);
            });
        });
    }

    pub(super) fn notes(&self, ui: &mut Ui) {
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

    pub(super) fn histogram(&self, ui: &mut Ui) {
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

    pub(super) fn status_bar(&mut self, ui: &mut Ui) {
        /// What went well is told for so long, in seconds.
        const TOLD: f64 = 20.0;
        let now = ui.input(|i| i.time);
        if self.said.0 != self.message {
            self.said = (self.message.clone(), now);
        } else if self.message.is_some() && now - self.said.1 > TOLD {
            self.message = None;
        }
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

    pub(super) fn job_progress(&self, ui: &mut Ui, job: &JobState) {
        if let JobState::Running { progress } = job {
            let part = progress.samples as f32 / progress.target.max(1) as f32;
            let text = format!("{} of {} samples", progress.samples, progress.target);
            ui.add(egui::ProgressBar::new(part).desired_width(180.0).text(text));
            if ui.button("Stop").clicked() {
                self.live.stop_job();
            }
        }
    }

    pub(super) fn progress_text(&self, status: &Status) -> String {
        let Some(progress) = status.progress else { return "nothing is rendered".to_owned() };
        let (seconds, divisor) = (status.spent.as_secs_f64(), status.divisor.max(1));
        if divisor > 1 {
            return format!("a first look, 1:{divisor}");
        }
        let wanted = self.history.as_ref().map(|history| {
            target(&history.present().settings, self.view.channel.integrator(), false)
        });
        let wanted = wanted.filter(|&wanted| !self.endless && progress.samples <= wanted);
        let of = wanted.map_or(String::new(), |wanted| format!(" of {wanted}"));
        let noise = self.shown.as_ref().and_then(|s| s.picture.noise);
        let noise = noise.map_or(String::new(), |n| format!(", noise {:.2} %", 100.0 * n));
        let state = match (self.paused, progress.finished) {
            (true, _) => ", paused",
            (_, true) if progress.panicked => ", broken off",
            (_, true) => ", done",
            _ => "",
        };
        let samples = progress.samples;
        // What is no number is left out of the picture, but not unsaid.
        let dropped = progress.dropped.first.map_or(String::new(), |first| {
            let (count, x, y) = (progress.dropped.count, first.x, first.y);
            format!(", {count} were no numbers and left out, the first in pixel {x}, {y}")
        });
        let unit = if samples == 1 && of.is_empty() { "sample" } else { "samples" };
        format!("{samples}{of} {unit}, {seconds:.1} s{noise}{dropped}{state}")
    }
}
