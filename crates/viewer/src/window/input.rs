//! What keys and the mouse do.

use super::canvas::{Laid, Tool};
use super::report::Happened;
use super::state::{After, Dialog, Window};
use crate::keys::Action;
use crate::pose::{Axis, Pose};
use eframe::egui::{self, Context, Event, Key, Popup, Ui, ViewportCommand};
use rutilant::settings::Roulette;
use rutilant_formats::Look;
use rutilant_formats::camera::{AngleOfView, AuthoredCamera, CameraKind, FocusOn};
use rutilant_geom::{Aabb, Vec2};
use std::sync::Arc;
use std::time::Duration;

impl Window {
    pub(super) fn hear_keys(&mut self, ui: &Ui, mut draft: Option<&mut Look>) {
        let context = ui.ctx();
        let (events, time, focused) = context.input(|i| (i.events.clone(), i.time, i.raw.focused));
        let speed = self.speed(draft.as_deref());
        // A key may have taken the keyboard from a widget just now: it was still meant for that one.
        // Dialogs hear for themselves.
        let typing = self.typing || context.egui_wants_keyboard_input() || self.dialog.is_some();
        if !focused || typing {
            self.flight.release_all();
        }
        let mut pose = draft.as_deref().map(pose_of);
        for event in &events {
            // With the modifiers of its own moment: within a slow frame they come and go.
            let &Event::Key { key, pressed, repeat: false, modifiers, .. } = event else {
                continue;
            };
            if pressed && self.remapping.is_some() {
                self.remap(key);
                continue;
            }
            if pressed && modifiers.command {
                self.hear_shortcut(key, modifiers.shift, typing);
                continue;
            }
            let Some(action) = self.keys.action(key) else { continue };
            if pressed && !typing {
                if let Some(pose) = &mut pose {
                    self.gesture += u64::from(!self.flight.is_moving());
                    self.flight.press(action, time, pose, speed);
                }
                self.act(action, pose.as_mut(), draft.as_deref_mut());
            } else if !pressed && let Some(pose) = &mut pose {
                self.flight.release(action, time, pose, speed);
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
        let dropped = context.input(|i| i.raw.dropped_files.clone());
        for file in dropped {
            self.dropped(file.path().to_owned());
        }
    }

    /// A key with Ctrl, or with ⌘ on a Mac.
    fn hear_shortcut(&mut self, key: Key, shift: bool, typing: bool) {
        match (key, shift) {
            (Key::Z, false) if !typing => self.undo(),
            (Key::Z, true) | (Key::Y, _) if !typing => self.redo(),
            (Key::S, _) if self.dialog.is_none() => self.save(),
            (Key::O, _) if self.dialog.is_none() => {
                self.dialog = Some(Dialog::Open(self.folder()));
            }
            _ => {}
        }
    }

    pub(super) fn remap(&mut self, key: Key) {
        if let Some(action) = self.remapping.take() {
            // Escape always means what it says.
            if key != Key::Escape || action == Action::Close {
                self.keys.set(action, key);
                self.preferences.keys = self.keys.to_names();
                self.keep_preferences();
            }
        }
    }

    /// Metres per second: half of the way to what is looked at, and no more than a quarter of the
    /// scene's size.
    pub(super) fn speed(&self, look: Option<&Look>) -> f64 {
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

    /// Does what a key asks for, as far as there is a scene that it can be done to.
    fn act(&mut self, action: Action, pose: Option<&mut Pose>, look: Option<&mut Look>) {
        // As far as one flies in a second.
        let jump = self.speed(look.as_deref());
        let fly = |pose: Option<&mut Pose>, forward| {
            if let Some(pose) = pose {
                pose.fly([0.0, 0.0, forward]);
            }
        };
        match action {
            Action::JumpForward => fly(pose, jump),
            Action::JumpBack => fly(pose, -jump),
            Action::ToggleDepth => {
                if let Some(look) = look {
                    self.toggle_depth(look);
                }
            }
            Action::PrintPose => {
                if let (Some(pose), Some(look)) = (pose, look) {
                    put_pose(look, *pose);
                    self.print_pose(look);
                }
            }
            Action::Pause => self.paused = !self.paused,
            Action::Panels => self.panels = !self.panels,
            Action::FitAll => {
                if let (Some(document), Some(pose), Some(look)) = (&self.document, pose, look) {
                    see_all(look, pose, &document.bounds, None);
                }
            }
            Action::Overlay => self.view.overlay = !self.view.overlay,
            Action::StoreSnapshot => self.store_snapshot(),
            Action::Help => self.toggle_help(),
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

    /// Shows direct light alone, or all light again.
    pub(super) fn print_pose(&mut self, look: &Look) {
        let toml = look.camera.to_toml();
        self.context.copy_text(toml.clone());
        self.message = Some("the camera is in the clipboard".into());
        (self.report)(Happened::Pose { toml });
    }

    fn toggle_depth(&mut self, look: &mut Look) {
        /// Paths of this length have met a lamp by themselves or after one surface.
        const DIRECT: Option<u32> = Some(2);
        /// For a scene that was read with direct light alone, and needs some end.
        const LONG: Option<u32> = Some(512);
        let depth = &mut look.settings.max_depth;
        *depth = if *depth == DIRECT {
            self.depth.or(if look.settings.roulette == Roulette::Off { LONG } else { None })
        } else {
            self.depth = *depth;
            DIRECT
        };
    }

    /// The topmost thing that is open, or the window.
    pub(super) fn close_something(&mut self) {
        // A menu hears for itself.
        if Popup::is_any_open(&self.context) {
            return;
        }
        let closed = self.dialog.take().is_some()
            || self.close_help()
            || std::mem::take(&mut self.picking)
            || self.trouble.take().is_some()
            || self.beside.take().is_some();
        if !closed {
            self.ask_to_close();
        }
    }

    pub(super) fn toggle_help(&mut self) {
        self.help = !self.close_help();
    }

    /// Whether it was open.
    pub(super) fn close_help(&mut self) -> bool {
        self.remapping = None;
        std::mem::take(&mut self.help)
    }

    pub(super) fn ask_to_close(&mut self) {
        if self.is_changed() {
            self.dialog = Some(Dialog::Discard(After::Close));
        } else {
            self.close_without_changes();
        }
    }

    pub(super) fn close_without_changes(&mut self) {
        if self.job.is_some() {
            self.dialog = Some(Dialog::StopJob);
        } else {
            self.closing = true;
        }
    }

    pub(super) fn close_if_asked(&mut self, context: &Context) {
        let asked = context.input(|i| i.viewport().close_requested());
        if asked && !self.closing {
            self.ask_to_close();
        }
        let writes = Arc::strong_count(&self.writing) > 1;
        if self.closing && !writes {
            context.send_viewport_cmd(ViewportCommand::Close);
        } else if asked {
            context.send_viewport_cmd(ViewportCommand::CancelClose);
        }
        if self.closing && writes {
            self.message = Some("a file is being written…".into());
            context.request_repaint_after(Duration::from_millis(20));
        }
    }

    pub(super) fn hear_mouse(&mut self, ui: &Ui, laid: &Laid, look: &mut Look) {
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
                let angle = match look.camera.kind {
                    CameraKind::Equirectangular => std::f64::consts::PI,
                    CameraKind::Perspective { .. } | CameraKind::Orthographic { .. } => {
                        2.0 * vertical_half_angle(look)
                    }
                };
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
}

pub(super) fn pose_of(look: &Look) -> Pose {
    let camera = &look.camera;
    Pose { position: camera.position, look_at: camera.look_at, up: camera.up }
}

pub(super) fn put_pose(look: &mut Look, pose: Pose) {
    let camera = &mut look.camera;
    (camera.position, camera.look_at, camera.up) = (pose.position, pose.look_at, pose.up);
}

/// Where the point of focus has come to lie behind the camera, which sees nothing then, what is
/// looked at becomes sharp.
pub(super) fn keep_focus_in_front(camera: &mut AuthoredCamera) {
    let (position, view) = (camera.position, camera.look_at - camera.position);
    if let Some(lens) = camera.kind.lens_mut()
        && let FocusOn::Point(point) = lens.focus
        && (point - position).dot(view) <= 0.0
    {
        lens.focus = FocusOn::LookAt;
    }
}

/// Half of what is seen from top to bottom, in radians.
pub(super) fn vertical_half_angle(look: &Look) -> f64 {
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

/// Sees all of `bounds`, along an axis or from the side on which the eye is now.
pub(super) fn see_all(look: &mut Look, pose: &mut Pose, bounds: &Aabb, axis: Option<Axis>) {
    let [width, height] = look.settings.size.map(f64::from);
    let narrower = (width / height).min(1.0);
    let half_angle = (vertical_half_angle(look).tan() * narrower).atan();
    let sees = match axis {
        Some(axis) => pose.look_along(axis, bounds, half_angle),
        None => pose.fit(bounds, half_angle),
    };
    if let CameraKind::Orthographic { height, .. } = &mut look.camera.kind
        && sees
    {
        // As wide as the ball around it, which fills that angle seen from there.
        let visible = 2.0 * pose.distance() * half_angle.sin() / narrower;
        *height = visible.clamp(1e-6, 1e12) as f32;
    }
}
