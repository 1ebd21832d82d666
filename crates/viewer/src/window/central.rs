//! The picture, and what is said over it.

use super::canvas::{Laid, caption};
use super::state::Window;
use super::theme;
use crate::picture::Channel;
use crate::source::Step;
use eframe::egui::{self, Align2, Color32, Ui, vec2};
use rutilant_formats::Look;
use std::path::Path;

impl Window {
    pub(super) fn picture(&mut self, ui: &mut Ui, draft: Option<&mut Look>) {
        let size = match (&draft, &self.shown) {
            (Some(look), _) => look.settings.size,
            (None, Some(shown)) => shown.picture.size,
            (None, None) => [16, 9],
        };
        let [picture, beside] = &self.textures;
        let name = self.beside.as_ref().map(|beside| &*beside.name);
        let laid = self.canvas.show(ui, size, picture.as_ref(), beside.as_ref().zip(name));
        if let Some(look) = draft {
            self.hear_mouse(ui, &laid, look);
        }
        self.cursor_values(ui, &laid);
        self.what_is_missing(ui, &laid);
    }

    pub(super) fn cursor_values(&self, ui: &Ui, laid: &Laid) {
        let Some(shown) = &self.shown else { return };
        let Some(at) = laid.response.hover_pos().filter(|_| self.panels) else { return };
        let Some([x, y]) = laid.pixel(at) else { return };
        let kept = laid.place(at).is_some_and(|place| place.x >= self.canvas.wipe);
        let image = match &self.beside {
            Some(beside) if kept => &beside.image,
            _ => &shown.picture.image,
        };
        let scale = |at: u32, from: f32, to: u32| {
            ((at as f32 / from * to as f32) as u32).min(to.max(1) - 1)
        };
        let whole = self.history.as_ref().map_or(shown.picture.size, |h| h.present().settings.size);
        let (px, py) =
            (scale(x, whole[0] as f32, image.width()), scale(y, whole[1] as f32, image.height()));
        let i = (py * image.width() + px) as usize;
        let value = |name: &str| image.channel(name).and_then(|c| c.get(i)).copied();
        let [r, g, b] = ["R", "G", "B"].map(|name| value(name).unwrap_or(0.0));
        let count = value("samples.Y").map_or(String::new(), |n| {
            format!("   {n} {}", if n == 1.0 { "sample" } else { "samples" })
        });
        let error = match (self.view.channel, value("variance.G")) {
            (Channel::Variance, Some(variance)) => {
                format!("   G ± {:.5}", variance.max(0.0).sqrt())
            }
            _ => String::new(),
        };
        let text = format!("{x}, {y}   {r:.5}  {g:.5}  {b:.5}{count}{error}");
        let corner = laid.response.rect.left_bottom() + vec2(8.0, -8.0);
        caption(ui.painter(), corner, Align2::LEFT_BOTTOM, &text);
    }

    /// Said over the picture while there is none, or while something is wrong.
    pub(super) fn what_is_missing(&mut self, ui: &mut Ui, laid: &Laid) {
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
            let text = "Drop a scene or a mesh here";
            ui.painter().text(middle, Align2::CENTER_CENTER, text, font, Color32::from_gray(150));
        }
        if let Some(trouble) = self.trouble.clone() {
            let area = egui::Area::new(egui::Id::unique("trouble"))
                .fixed_pos(laid.response.rect.left_top() + vec2(12.0, 12.0));
            area.show(ui.ctx(), |ui| {
                egui::Frame::popup(ui.style()).show(ui, |ui| {
                    ui.set_max_width((laid.response.rect.width() - 60.0).clamp(200.0, 640.0));
                    ui.colored_label(theme::ERROR, &trouble);
                    if self.unreadable && self.document.is_some() {
                        ui.weak("The last good scene is still shown.");
                    }
                    ui.horizontal(|ui| {
                        if self.unreadable && ui.button("Read again").clicked() {
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
}
