//! Dark and calm: the picture is what shines.

use eframe::egui::{Color32, Context, CornerRadius, Stroke, Theme, Visuals, vec2};

/// Around the picture: neutral, so that it does not tint what is seen beside it.
pub(super) const BACKDROP: Color32 = Color32::from_gray(24);
/// Behind panels.
const PANEL: Color32 = Color32::from_gray(32);
/// What can be changed.
const FIELD: Color32 = Color32::from_gray(46);
/// What is chosen: the red of rutile.
pub(super) const ACCENT: Color32 = Color32::from_rgb(196, 78, 46);
/// What went wrong.
pub(super) const ERROR: Color32 = Color32::from_rgb(240, 120, 100);
/// What one should know.
pub(super) const NOTE: Color32 = Color32::from_rgb(220, 190, 120);

pub(super) fn apply(context: &Context) {
    context.set_theme(Theme::Dark);
    let mut visuals = Visuals::dark();
    visuals.panel_fill = PANEL;
    visuals.window_fill = PANEL;
    visuals.extreme_bg_color = Color32::from_gray(20);
    visuals.faint_bg_color = Color32::from_gray(38);
    visuals.selection.bg_fill = ACCENT.linear_multiply(0.45);
    visuals.selection.stroke = Stroke::new(1.0, Color32::from_gray(240));
    visuals.hyperlink_color = Color32::from_rgb(230, 150, 110);
    visuals.error_fg_color = ERROR;
    visuals.warn_fg_color = NOTE;
    visuals.window_corner_radius = CornerRadius::same(6);
    let widgets = &mut visuals.widgets;
    for (widget, fill) in [
        (&mut widgets.inactive, FIELD),
        (&mut widgets.hovered, Color32::from_gray(60)),
        (&mut widgets.active, Color32::from_gray(72)),
        (&mut widgets.open, Color32::from_gray(54)),
    ] {
        (widget.bg_fill, widget.weak_bg_fill) = (fill, fill);
        widget.corner_radius = CornerRadius::same(3);
        widget.fg_stroke.color = Color32::from_gray(215);
    }
    widgets.noninteractive.fg_stroke.color = Color32::from_gray(190);
    widgets.noninteractive.bg_stroke.color = Color32::from_gray(50);
    context.set_visuals_of(Theme::Dark, visuals);
    context.all_styles_mut(|style| {
        style.spacing.item_spacing = vec2(8.0, 5.0);
        style.spacing.slider_width = 130.0;
    });
}
