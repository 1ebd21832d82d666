//! The picture itself: where it lies on the screen, and what the mouse does on it.

use super::theme::BACKDROP;
use eframe::egui::{
    Align2, Color32, FontId, Painter, Pos2, Rect, Response, Sense, Stroke, TextureHandle, Ui, Vec2,
    pos2, vec2,
};

/// What the mouse does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Tool {
    /// Moves the camera.
    #[default]
    Camera,
    /// Moves the picture.
    Picture,
}

/// How the picture lies in its place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Canvas {
    /// Points of the screen for a pixel of the picture; `None` fits it in.
    pub(super) zoom: Option<f32>,
    /// Where the middle of the picture lies, from the middle of its place, in pixels of the picture.
    pub(super) offset: Vec2,
    /// Where the picture ends and that beside it begins, from 0 to 1.
    pub(super) wipe: f32,
    pub(super) tool: Tool,
}

impl Default for Canvas {
    fn default() -> Self {
        Self { zoom: None, offset: Vec2::ZERO, wipe: 0.5, tool: Tool::default() }
    }
}

/// The largest and smallest zoom.
const ZOOM: [f32; 2] = [1.0 / 64.0, 128.0];

/// The picture on the screen.
pub(super) struct Laid {
    pub(super) response: Response,
    /// Where it lies.
    pub(super) rect: Rect,
    size: [u32; 2],
    /// Whether the mouse is on the wipe.
    pub(super) on_wipe: bool,
}

impl Laid {
    /// The place of the picture at a point of the screen, from (0, 0) to (1, 1).
    pub(super) fn place(&self, at: Pos2) -> Option<Vec2> {
        let place = (at - self.rect.min) / self.rect.size();
        let inside = |c: f32| (0.0..1.0).contains(&c);
        (inside(place.x) && inside(place.y)).then_some(place)
    }

    /// The pixel at a point of the screen.
    pub(super) fn pixel(&self, at: Pos2) -> Option<[u32; 2]> {
        let place = self.place(at)?;
        let along = |part: f32, side: u32| ((part * side as f32) as u32).min(side - 1);
        Some([along(place.x, self.size[0]), along(place.y, self.size[1])])
    }
}

impl Canvas {
    /// Draws the picture of `size` pixels and, right of the wipe, the one beside it.
    pub(super) fn show(
        &mut self,
        ui: &mut Ui,
        size: [u32; 2],
        picture: Option<&TextureHandle>,
        beside: Option<(&TextureHandle, &str)>,
    ) -> Laid {
        let (outer, response) =
            ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
        let painter = ui.painter_at(outer);
        painter.rect_filled(outer, 0.0, BACKDROP);
        let pixels = vec2(size[0] as f32, size[1] as f32);
        let fitting = (outer.width() / pixels.x).min(outer.height() / pixels.y).max(1e-3);
        if self.tool == Tool::Picture || response.hovered() && ui.input(|i| i.modifiers.command) {
            self.move_picture(ui, &response, outer, fitting);
        }
        let zoom = self.zoom.unwrap_or(fitting);
        let offset = if self.zoom.is_some() { self.offset } else { Vec2::ZERO };
        let rect = Rect::from_center_size(outer.center() + offset * zoom, pixels * zoom);

        let whole = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
        let mut on_wipe = false;
        if let Some(picture) = picture {
            painter.image(picture.id(), rect, whole, Color32::WHITE);
        }
        if let Some((beside, name)) = beside {
            let x = rect.left() + self.wipe * rect.width();
            let right = Rect::from_min_max(pos2(x, rect.top()), rect.max);
            let clipped = painter.with_clip_rect(right.intersect(outer));
            clipped.image(beside.id(), rect, whole, Color32::WHITE);
            let handle = Rect::from_x_y_ranges(x - 5.0..=x + 5.0, rect.y_range()).intersect(outer);
            let wipe = ui.interact(handle, ui.scope_id().with("wipe"), Sense::drag());
            if wipe.dragged()
                && let Some(at) = wipe.interact_pointer_pos()
            {
                self.wipe = ((at.x - rect.left()) / rect.width()).clamp(0.0, 1.0);
            }
            on_wipe = wipe.hovered() || wipe.dragged();
            if on_wipe {
                ui.ctx().set_cursor_icon(eframe::egui::CursorIcon::ResizeHorizontal);
            }
            painter.vline(x, rect.y_range(), Stroke::new(2.0, Color32::from_white_alpha(180)));
            let y = rect.top().max(outer.top()) + 8.0;
            caption(&painter, pos2(x - 12.0, y), Align2::RIGHT_TOP, "now");
            caption(&painter, pos2(x + 12.0, y), Align2::LEFT_TOP, name);
        }
        Laid { response, rect, size, on_wipe }
    }

    /// By wheel and drag.
    fn move_picture(&mut self, ui: &Ui, response: &Response, outer: Rect, fitting: f32) {
        let zoom = self.zoom.unwrap_or(fitting);
        if response.dragged() {
            self.zoom = Some(zoom);
            self.offset += response.drag_delta() / zoom;
        }
        let factor = ui.input(|i| i.zoom_delta() * (i.smooth_scroll_delta().y * 4e-3).exp());
        if let Some(at) = response.hover_pos()
            && factor != 1.0
        {
            let next = (zoom * factor).clamp(ZOOM[0], ZOOM[1]);
            // What is under the mouse stays there.
            let from_middle = at - outer.center();
            self.offset += from_middle / next - from_middle / zoom;
            self.zoom = Some(next);
        }
    }
}

/// Writes on the picture, on a dark ground that lets it be read on any.
pub(super) fn caption(painter: &Painter, at: Pos2, align: Align2, text: &str) {
    let font = FontId::monospace(12.0);
    let galley = painter.layout_no_wrap(text.to_owned(), font, Color32::from_gray(230));
    let rect = align.anchor_size(at, galley.size());
    painter.rect_filled(rect.expand(4.0), 3.0, Color32::from_black_alpha(170));
    painter.galley(rect.min, galley, Color32::WHITE);
}
