//! The window: what is shown of a scene, and what people do with it.
//!
//! It holds no picture of its own and renders nothing: it tells `live.rs` what
//! it wants to see and shows what comes. Each frame it takes a draft of the
//! scene's look, lets keys, mouse and panels change it, and hands it on where
//! it has become another.

mod around;
mod arrivals;
mod canvas;
mod central;
mod dialogs;
mod files;
mod input;
mod listing;
mod panels;
mod report;
mod state;
#[cfg(test)]
mod tests;
mod theme;
mod widgets;

use crate::frames::FrameTimes;
use crate::picture::samples_of;
use eframe::egui::{CentralPanel, Ui};
pub use report::{Happened, Report};
pub(crate) use state::Window;
use std::sync::Arc;

impl Window {
    /// One frame.
    pub(crate) fn ui(&mut self, ui: &mut Ui) {
        self.view.most_side = Some(ui.input(|i| i.max_texture_side));
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
        self.dialogs(ui.ctx());
        self.commit(ui, before, draft);
        self.title(ui.ctx());
        self.close_if_asked(ui.ctx());
        self.typing = ui.ctx().egui_wants_keyboard_input();
    }

    /// Tells that it is closed.
    pub(crate) fn closed(&mut self, frames: FrameTimes) {
        let picture = self.shown.as_ref().map(|shown| {
            let image = &shown.picture.image;
            (format!("{:016x}", image.hash()), samples_of(image))
        });
        (self.report)(Happened::Closed { frames, picture });
    }
}
