//! Rows of a panel: a label, and something to change.

use eframe::egui::emath::Numeric;
use eframe::egui::{DragValue, Id, Slider, SliderClamping, Ui};
use rutilant::color::Rgb;
use std::ops::RangeInclusive;

/// Where what can be changed begins.
const LABEL_WIDTH: f32 = 128.0;

/// A label and what belongs to it: widgets that are `labelled_by` the id that they are given, so that
/// they have a name for those who cannot see.
pub(super) fn row<R>(ui: &mut Ui, label: &str, contents: impl FnOnce(&mut Ui, Id) -> R) -> R {
    ui.horizontal(|ui| {
        let height = ui.spacing().interact_size.y;
        let text = ui.allocate_ui([LABEL_WIDTH, height].into(), |ui| {
            ui.set_min_width(LABEL_WIDTH);
            ui.label(label).id
        });
        ui.push_id(label, |ui| contents(ui, text.inner)).inner
    })
    .inner
}

/// A number of any kind, to be dragged or typed. What lies outside its range stays as it is until
/// it is touched, and what is typed and no number changes nothing.
pub(super) fn drag<N: Numeric>(value: &mut N) -> DragValue<'_> {
    DragValue::new(value).clamp_existing_to_range(false).custom_parser(finite)
}

fn finite(text: &str) -> Option<f64> {
    let text: String = text.chars().filter(|c| !c.is_whitespace() && *c != '°').collect();
    text.replace('−', "-").parse().ok().filter(|value: &f64| value.is_finite())
}

/// A slider. What lies outside its range stays as it is until it is touched, and what is typed and
/// no number changes nothing.
pub(super) fn slider(value: &mut f32, range: RangeInclusive<f32>) -> Slider<'_> {
    Slider::new(value, range).clamping(SliderClamping::Edits).custom_parser(finite)
}

/// A number, on a logarithmic slider where its size can be anything.
pub(super) fn number(
    ui: &mut Ui,
    label: &str,
    value: &mut f32,
    range: RangeInclusive<f32>,
    logarithmic: bool,
) {
    row(ui, label, |ui, name| {
        let slider = slider(value, range).logarithmic(logarithmic).smallest_positive(1e-4);
        ui.add(slider.max_decimals(4)).labelled_by(name);
    });
}

/// An angle in degrees.
pub(super) fn degrees(ui: &mut Ui, label: &str, value: &mut f32, range: RangeInclusive<f32>) {
    row(ui, label, |ui, name| {
        ui.add(slider(value, range).suffix("°").max_decimals(2)).labelled_by(name);
    });
}

/// A colour whose channels lie between 0 and 1.
pub(super) fn color(ui: &mut Ui, label: &str, rgb: &mut Rgb) {
    row(ui, label, |ui, name| {
        let mut shown = rgb.0;
        if ui.color_edit_button_rgb(&mut shown).labelled_by(name).changed() {
            rgb.0 = shown.map(|c| c.clamp(0.0, 1.0));
        }
    });
}

/// An amount of light of nearly any size: a colour, and how much of it.
pub(super) fn light(ui: &mut Ui, label: &str, rgb: &mut Rgb) {
    strong_color(ui, label, rgb, 1e9);
}

/// A colour whose channels lie between 0 and `most`: a colour up to 1, and how much of it.
pub(super) fn strong_color(ui: &mut Ui, label: &str, rgb: &mut Rgb, most: f32) {
    row(ui, label, |ui, name| {
        let strength = rgb.0.into_iter().fold(0.0, f32::max);
        // What was dragged to nothing keeps its colour while it is dragged.
        let kept = ui.scope_id().with("tint");
        let mut tint = if strength > 0.0 {
            rgb.0.map(|c| c / strength)
        } else {
            ui.data(|data| data.get_temp(kept)).unwrap_or([1.0; 3])
        };
        let mut amount = strength;
        let colored = ui.color_edit_button_rgb(&mut tint).labelled_by(name).changed();
        let speed = f64::from(strength).max(0.01) * 0.01;
        let value = drag(&mut amount).speed(speed).range(0.0..=most).max_decimals(4);
        if ui.add(value).labelled_by(name).changed() || colored {
            rgb.0 = tint.map(|c| (c * amount).clamp(0.0, most));
            ui.data_mut(|data| data.insert_temp(kept, tint));
        }
    });
}
