//! The panels: everything of a scene's look that can be changed by hand.
//!
//! They change a draft of the look; the window compares it with what there was.

use super::widgets::{color, degrees, drag, light, number, row, slider, strong_color};
use eframe::egui::{CollapsingHeader, ComboBox, Ui};
use rutilant::color::Rgb;
use rutilant::display::Curve;
use rutilant::light::{Environment, EnvironmentLight, Light, SpotLight};
use rutilant::material::{
    Absorption, Conductor, Dielectric, Emission, EmittedLight, MAX_DISPERSION, MAX_SPECULAR_COLOR,
    Material, MaterialKind, Matte, Metal, Mirror, Principled, Sides, ThinDielectric,
    most_rough_dispersion,
};
use rutilant::settings::{Heuristic, IntegratorKind, Roulette, SamplerKind};
use rutilant_formats::Look;
use rutilant_formats::camera::{AngleOfView, Aperture, AuthoredCamera, CameraKind, FocusOn};
use rutilant_geom::Vec3;

/// Names of curves, as the scene format has them.
pub(super) const CURVES: [(Curve, &str); 5] = [
    (Curve::Clip, "clip"),
    (Curve::Filmic, "filmic"),
    (Curve::Reinhard, "reinhard"),
    (Curve::Aces, "aces"),
    (Curve::Agx, "agx"),
];

const INTEGRATORS: [(IntegratorKind, &str); 7] = [
    (IntegratorKind::Path, "path"),
    (IntegratorKind::Naive, "naive"),
    (IntegratorKind::Direct, "direct"),
    (IntegratorKind::AmbientOcclusion, "ao"),
    (IntegratorKind::Normals, "normals"),
    (IntegratorKind::Albedo, "albedo"),
    (IntegratorKind::Depth, "depth"),
];

/// One of several values, by its name.
pub(super) fn choose<T: PartialEq + Copy>(
    ui: &mut Ui,
    label: &str,
    value: &mut T,
    names: &[(T, &'static str)],
) {
    row(ui, label, |ui, name| {
        let current = names.iter().find(|(v, _)| v == value).map_or("", |(_, text)| text);
        let choice = ComboBox::from_id_salt(label).selected_text(current).show_ui(ui, |ui| {
            for (other, name) in names {
                ui.selectable_value(value, *other, *name);
            }
        });
        choice.response.labelled_by(name);
    });
}

fn section(ui: &mut Ui, title: &str, open: bool, contents: impl FnOnce(&mut Ui)) {
    CollapsingHeader::new(title).default_open(open).show(ui, contents);
}

/// Where the camera stands, and its lens. Returns true where the next click shall focus.
pub(super) fn camera(ui: &mut Ui, camera: &mut AuthoredCamera, picking: bool) -> bool {
    let mut pick = picking;
    section(ui, "Camera and lens", true, |ui| {
        point(ui, "Position", &mut camera.position);
        point(ui, "Looks at", &mut camera.look_at);
        match &mut camera.kind {
            CameraKind::Perspective { view, lens, .. } => {
                match view {
                    AngleOfView::FovDegrees(fov) => degrees(ui, "Field of view", fov, 1.0..=170.0),
                    AngleOfView::FocalLengthMm(length) => {
                        number(ui, "Focal length, mm", length, 1.0..=1000.0, true);
                    }
                }
                match &mut lens.aperture {
                    Aperture::Radius(radius) => {
                        number(ui, "Aperture radius, m", radius, 0.0..=10.0, true);
                    }
                    Aperture::FNumber(f) => number(ui, "f-number", f, 0.1..=128.0, true),
                }
            }
            CameraKind::Orthographic { height, lens } => {
                number(ui, "Height, m", height, 1e-3..=1e6, true);
                if let Aperture::Radius(radius) = &mut lens.aperture {
                    number(ui, "Aperture radius, m", radius, 0.0..=10.0, true);
                }
            }
            CameraKind::Equirectangular => {}
        }
        let along = (camera.look_at - camera.position).length();
        if let Some(lens) = camera.kind.lens_mut() {
            row(ui, "Blades", |ui, name| {
                let mut blades = lens.blades;
                ui.add(drag(&mut blades).range(0..=100).speed(0.05)).labelled_by(name);
                // Two edges make no polygon.
                let more = blades > lens.blades;
                lens.blades = match blades {
                    1 | 2 => {
                        if more {
                            3
                        } else {
                            0
                        }
                    }
                    _ => blades,
                };
            });
            let mut distance = match lens.focus {
                FocusOn::Distance(distance) => distance,
                FocusOn::Point(at) => {
                    (at - camera.position).dot(camera.look_at - camera.position) / along
                }
                FocusOn::LookAt | FocusOn::Pixel(_) => along,
            };
            let before = distance;
            number(ui, "Focus distance, m", &mut distance, 1e-3..=1e6, true);
            if distance != before {
                lens.focus = FocusOn::Distance(distance);
            }
            ui.horizontal(|ui| {
                ui.toggle_value(&mut pick, "Focus by a click").on_hover_text(
                    "Then click on it, through glass or in mirrors. A double click does the same",
                );
                if ui.button("On what it looks at").clicked() {
                    lens.focus = FocusOn::LookAt;
                }
            });
        }
    });
    pick
}

fn point(ui: &mut Ui, label: &str, point: &mut Vec3) {
    row(ui, label, |ui, name| {
        let speed = f64::from(point.abs().max_element()).max(0.1) * 2e-3;
        for (i, axis) in ["x", "y", "z"].iter().enumerate() {
            let value = drag(&mut point[i]).speed(speed).range(-1e12..=1e12).max_decimals(3);
            ui.add(value).labelled_by(name).on_hover_text(*axis);
        }
    });
}

/// All materials.
pub(super) fn materials(ui: &mut Ui, materials: &mut [Material], filter: &mut String) {
    /// More would make the panel slow; the filter finds the others.
    const MOST: usize = 60;
    section(ui, "Materials", true, |ui| {
        let many = materials.len() > 8;
        if many {
            row(ui, "Find", |ui, name| ui.text_edit_singleline(filter).labelled_by(name));
        }
        let mut left = MOST;
        for (i, material) in materials.iter_mut().enumerate() {
            if many && !material.name.to_lowercase().contains(&filter.to_lowercase()) {
                continue;
            }
            let Some(less) = left.checked_sub(1) else {
                ui.weak("… and more: name one above");
                break;
            };
            left = less;
            let name = if material.name.is_empty() { "without a name" } else { &material.name };
            let glows = if material.emission.is_some() { ", glows" } else { "" };
            let title = format!("{name}  ·  {}{glows}", kind_name(&material.kind));
            CollapsingHeader::new(title).id_salt(i).show(ui, |ui| one_material(ui, material));
        }
    });
}

fn kind_name(kind: &MaterialKind) -> &'static str {
    match kind {
        MaterialKind::Black => "black",
        MaterialKind::Matte(_) => "matte",
        MaterialKind::Mirror(_) => "mirror",
        MaterialKind::Conductor(_) => "conductor",
        MaterialKind::Dielectric(_) => "dielectric",
        MaterialKind::ThinDielectric(_) => "thin-dielectric",
        MaterialKind::Principled(_) => "principled",
        MaterialKind::Null => "null",
        MaterialKind::Mix(_) => "mix",
        MaterialKind::Custom(_) => "custom",
    }
}

fn one_material(ui: &mut Ui, material: &mut Material) {
    change_kind(ui, material);
    match &mut material.kind {
        MaterialKind::Black | MaterialKind::Null => {}
        MaterialKind::Matte(m) => {
            let name = if m.albedo.varies() { "Albedo × texture" } else { "Albedo" };
            color(ui, name, &mut m.albedo.factor);
            if m.sampling == rutilant::material::HemisphereSampling::Cosine {
                number(ui, "Roughness", &mut m.roughness, 0.0..=1.0, false);
            }
        }
        MaterialKind::Mirror(m) => color(ui, "Reflectance", &mut m.reflectance),
        MaterialKind::Conductor(m) => {
            row(ui, "Metal", |ui, _| {
                for (metal, name) in [
                    (Metal::Gold, "gold"),
                    (Metal::Copper, "copper"),
                    (Metal::Silver, "silver"),
                    (Metal::Aluminium, "aluminium"),
                ] {
                    let distribution = m.distribution;
                    let measured = Conductor { distribution, ..metal.conductor(m.roughness) };
                    if ui.selectable_label(*m == measured, name).clicked() {
                        *m = measured;
                    }
                }
            });
            number(ui, "Roughness", &mut m.roughness, 0.0..=1.0, false);
        }
        MaterialKind::Dielectric(m) => dielectric(ui, m),
        MaterialKind::ThinDielectric(m) => {
            number(ui, "Index of refraction", &mut m.ior, 1.0..=3.0, false);
            color(ui, "Colour", &mut m.color);
        }
        MaterialKind::Principled(m) => principled(ui, m),
        MaterialKind::Mix(m) => number(ui, "Amount of the second", &mut m.amount, 0.0..=1.0, false),
        MaterialKind::Custom(_) => {
            ui.weak("made by a program; it cannot be changed here");
        }
    }
    let priority = match &material.kind {
        MaterialKind::Dielectric(m) => m.priority,
        MaterialKind::Principled(m) => m.priority,
        MaterialKind::Black
        | MaterialKind::Null
        | MaterialKind::Matte(_)
        | MaterialKind::Mirror(_)
        | MaterialKind::Conductor(_)
        | MaterialKind::ThinDielectric(_)
        | MaterialKind::Mix(_)
        | MaterialKind::Custom(_) => None,
    };
    if priority.is_none() {
        emission(ui, &mut material.emission);
    }
    let mut single_sided = material.sides == Sides::Front;
    if ui.checkbox(&mut single_sided, "Single-sided").changed() {
        material.sides = if single_sided { Sides::Front } else { Sides::Both };
    }
}

fn dielectric(ui: &mut Ui, m: &mut Dielectric) {
    // Rough borders have less room.
    let highest = if m.roughness > 0.0 { 2.4 } else { 4.0 };
    // Violet light must get out of rough glass as well.
    if m.dispersion == 0.0 || m.roughness == 0.0 {
        number(ui, "Index of refraction", &mut m.interior.ior, 1.0..=highest, false);
    }
    let may_be_rough = m.fresnel == rutilant::bsdf::Fresnel::Exact
        && m.interior.ior.max(m.exterior.ior) <= 2.4 * m.interior.ior.min(m.exterior.ior)
        && m.dispersion <= most_rough_dispersion(m.interior.ior);
    if may_be_rough {
        number(ui, "Roughness", &mut m.roughness, 0.0..=1.0, false);
    }
    let most =
        if m.roughness > 0.0 { most_rough_dispersion(m.interior.ior) } else { MAX_DISPERSION };
    number(ui, "Dispersion", &mut m.dispersion, 0.0..=most, false);
    absorption(ui, &mut m.interior.absorption);
}

/// Layers over a base. What would lie outside of what can be rendered is not offered.
fn principled(ui: &mut Ui, m: &mut Principled) {
    color(ui, "Base colour", &mut m.base_color);
    // A priority is for what light goes through.
    if m.priority.is_none() {
        number(ui, "Metallic", &mut m.metallic, 0.0..=1.0, false);
    }
    // Light must get out of rough glass again.
    let violet_may_be_rough = m.dispersion <= most_rough_dispersion(m.ior);
    if m.thin_walled || m.ior <= 2.4 && violet_may_be_rough {
        number(ui, "Roughness", &mut m.roughness, 0.0..=1.0, false);
        number(ui, "Anisotropy", &mut m.anisotropy, 0.0..=1.0, false);
    }
    number(ui, "Diffuse roughness", &mut m.diffuse_roughness, 0.0..=1.0, false);
    number(ui, "Specular", &mut m.specular, 0.0..=1.0, false);
    strong_color(ui, "Specular colour", &mut m.specular_color, MAX_SPECULAR_COLOR);
    let is_smooth = m.roughness == 0.0 && m.anisotropy == 0.0;
    let highest = if m.thin_walled || is_smooth { 4.0 } else { 2.4 };
    if m.thin_walled || is_smooth || m.dispersion == 0.0 {
        number(ui, "Index of refraction", &mut m.ior, 1.0..=highest, false);
    }
    if m.priority.is_none() {
        number(ui, "Transmission", &mut m.transmission, 0.0..=1.0, false);
        number(ui, "Diffuse transmission", &mut m.diffuse_transmission, 0.0..=1.0, false);
        if is_smooth || m.ior <= 2.4 && violet_may_be_rough {
            ui.checkbox(&mut m.thin_walled, "Thin-walled");
        }
    }
    if m.diffuse_transmission > 0.0 {
        color(ui, "Colour of that", &mut m.diffuse_transmission_color);
    }
    if m.has_inside() {
        let most = if is_smooth { MAX_DISPERSION } else { most_rough_dispersion(m.ior) };
        number(ui, "Dispersion", &mut m.dispersion, 0.0..=most, false);
        absorption(ui, &mut m.absorption);
    }
    number(ui, "Coat", &mut m.coat, 0.0..=1.0, false);
    if m.coat > 0.0 {
        color(ui, "Coat colour", &mut m.coat_color);
        number(ui, "Coat roughness", &mut m.coat_roughness, 0.0..=1.0, false);
        number(ui, "Coat index", &mut m.coat_ior, 1.0..=3.0, false);
    }
    color(ui, "Sheen colour", &mut m.sheen_color);
    if m.sheen_color != Rgb::BLACK {
        number(ui, "Sheen roughness", &mut m.sheen_roughness, 0.0..=1.0, false);
    }
    number(ui, "Iridescence", &mut m.iridescence, 0.0..=1.0, false);
    if m.iridescence > 0.0 {
        number(ui, "Film index", &mut m.iridescence_ior, 1.0..=3.0, false);
        number(ui, "Film thickness, nm", &mut m.iridescence_thickness_nm, 0.0..=1500.0, false);
    }
}

/// The colour that light takes on inside.
fn absorption(ui: &mut Ui, absorption: &mut Absorption) {
    match absorption {
        Absorption::None => {
            if ui.button("Give it a colour").clicked() {
                let color = Rgb([0.7, 0.85, 0.8]);
                *absorption = Absorption::ColorAtDistance { color, distance: 0.1 };
            }
        }
        Absorption::Coefficient(sigma) => light(ui, "Absorption, 1/m", sigma),
        Absorption::ColorAtDistance { color: tint, distance } => {
            let before = *tint;
            color(ui, "Colour inside", tint);
            if *tint != before {
                // Black after any distance would have no coefficient.
                tint.0 = tint.0.map(|c| c.max(1e-4));
            }
            number(ui, "It has after, m", distance, 1e-4..=1e4, true);
        }
    }
}

fn emission(ui: &mut Ui, emission: &mut Option<Emission>) {
    let mut glows = emission.is_some();
    if ui.checkbox(&mut glows, "Glows").changed() {
        *emission = glows.then(|| Emission::radiance(Rgb::WHITE));
    }
    if let Some(Emission { light: amount, two_sided, .. }) = emission {
        match amount {
            EmittedLight::Radiance(rgb) => light(ui, "Radiance, W/(m² sr)", rgb),
            EmittedLight::Power(rgb) => light(ui, "Power, W", rgb),
        }
        ui.checkbox(two_sided, "On both sides");
    }
}

fn change_kind(ui: &mut Ui, material: &mut Material) {
    if matches!(material.kind, MaterialKind::Mix(_) | MaterialKind::Custom(_) | MaterialKind::Null)
    {
        return;
    }
    row(ui, "Type", |ui, label| {
        let kind = kind_name(&material.kind);
        let choice = ComboBox::from_id_salt("type").selected_text(kind).show_ui(ui, |ui| {
            let kinds = [
                MaterialKind::Matte(Matte::new(Rgb::grey(0.5))),
                MaterialKind::Mirror(Mirror { reflectance: Rgb::WHITE }),
                MaterialKind::Conductor(Metal::Gold.conductor(0.2)),
                MaterialKind::Dielectric(Dielectric::new(1.5)),
                MaterialKind::ThinDielectric(ThinDielectric { ior: 1.5, color: Rgb::WHITE }),
                MaterialKind::Principled(Box::default()),
                MaterialKind::Black,
            ];
            for kind in kinds {
                let name = kind_name(&kind);
                let same = name == kind_name(&material.kind);
                if ui.selectable_label(same, name).clicked() && !same {
                    material.kind = kind;
                }
            }
        });
        choice.response.labelled_by(label);
    });
}

/// Lights without a surface.
/// Those that are added stand where the camera does, and shine where it looks.
pub(super) fn lights(ui: &mut Ui, lights: &mut Vec<Light>, camera: &AuthoredCamera) {
    section(ui, "Lights", false, |ui| {
        let mut removed = None;
        for (i, lamp) in lights.iter_mut().enumerate() {
            ui.push_id(i, |ui| {
                let name = match lamp {
                    Light::Point { .. } => "Point",
                    Light::Directional { .. } => "Directional",
                    Light::Spot { .. } => "Spot",
                };
                ui.horizontal(|ui| {
                    ui.strong(format!("{name} {}", i + 1));
                    if ui.small_button("Remove").clicked() {
                        removed = Some(i);
                    }
                });
                match lamp {
                    Light::Point { position, intensity, group: _ } => {
                        point(ui, "Position", position);
                        light(ui, "Intensity, W/sr", intensity);
                    }
                    Light::Directional { direction, irradiance, group: _ } => {
                        let before = *direction;
                        point(ui, "Direction", direction);
                        if direction.length_squared() < 1e-12 {
                            *direction = before;
                        }
                        light(ui, "Irradiance, W/m²", irradiance);
                    }
                    Light::Spot { position, direction, light: amount, inner, outer, group: _ } => {
                        point(ui, "Position", position);
                        let before = *direction;
                        point(ui, "Direction", direction);
                        if direction.length_squared() < 1e-12 {
                            *direction = before;
                        }
                        match amount {
                            SpotLight::Intensity(rgb) => light(ui, "Intensity, W/sr", rgb),
                            SpotLight::Power(rgb) => light(ui, "Power, W", rgb),
                        }
                        angle(ui, "Outer half angle", outer, 0.5..=180.0);
                        let widest = outer.to_degrees();
                        angle(ui, "Inner half angle", inner, 0.0..=widest);
                        *inner = inner.min(*outer);
                    }
                }
            });
            ui.separator();
        }
        if let Some(i) = removed {
            lights.remove(i);
        }
        ui.horizontal(|ui| {
            if ui.button("Add a point light").clicked() {
                lights.push(Light::Point {
                    position: camera.position,
                    intensity: Rgb::grey(10.0),
                    group: None,
                });
            }
            if ui.button("Add a spot").clicked() {
                lights.push(Light::Spot {
                    position: camera.position,
                    direction: camera.look_at - camera.position,
                    light: SpotLight::Intensity(Rgb::grey(10.0)),
                    inner: 20_f32.to_radians(),
                    outer: 30_f32.to_radians(),
                    group: None,
                });
            }
            if ui.button("Add a sun").clicked() {
                let direction = Vec3::new(-0.4, -1.0, -0.6);
                lights.push(Light::Directional {
                    direction,
                    irradiance: Rgb::grey(3.0),
                    group: None,
                });
            }
        });
    });
}

/// Radians, changed in whole degrees' own numbers, so that a file can hold them.
fn angle(ui: &mut Ui, label: &str, radians: &mut f32, range: std::ops::RangeInclusive<f32>) {
    let mut shown = radians.to_degrees();
    let before = shown;
    degrees(ui, label, &mut shown, range);
    if shown != before {
        *radians = shown.to_radians();
    }
}

/// The sky. Returns true where another image of one is to be chosen.
pub(super) fn environment(
    ui: &mut Ui,
    environment: &mut Option<Environment>,
    names: &[String],
) -> bool {
    let mut choose = false;
    section(ui, "Environment", false, |ui| {
        let Some(sky) = environment else {
            ui.weak("There is no sky. Drop an image of one onto the window, or");
            ui.horizontal(|ui| {
                choose = ui.button("Choose an image…").clicked();
                if ui.button("Add an even sky").clicked() {
                    *environment = Some(Environment::constant(Rgb::grey(0.5)));
                }
            });
            return;
        };
        match &mut sky.light {
            EnvironmentLight::Constant(rgb) => light(ui, "Radiance", rgb),
            EnvironmentLight::Image { image, .. } => {
                row(ui, "Image", |ui, _| {
                    ui.label(names.get(image.0 as usize).map_or("", |name| name));
                });
                angle(ui, "Rotation", &mut sky.rotation, -360.0..=360.0);
            }
        }
        number(ui, "Scale", &mut sky.scale, 0.0..=1000.0, true);
        ui.horizontal(|ui| {
            choose = ui.button("Choose an image…").clicked();
            if ui.button("Remove the sky").clicked() {
                *environment = None;
            }
        });
    });
    choose
}

/// How the picture is rendered.
pub(super) fn render(ui: &mut Ui, look: &mut Look) {
    section(ui, "Render", false, |ui| {
        let settings = &mut look.settings;
        row(ui, "Size", |ui, name| {
            for side in &mut settings.size {
                let value = drag(side).range(1..=16_384).update_while_editing(false);
                ui.add(value).labelled_by(name);
            }
        });
        row(ui, "Samples per pixel", |ui, name| {
            let value = drag(&mut settings.spp).range(1..=1_000_000_u64);
            ui.add(value.update_while_editing(false)).labelled_by(name);
        });
        row(ui, "Longest path", |ui, name| {
            let mut bounded = settings.max_depth.is_some();
            if ui.checkbox(&mut bounded, "").labelled_by(name).changed() {
                let off = settings.roulette == Roulette::Off;
                settings.max_depth = (bounded || off).then_some(8);
            }
            match &mut settings.max_depth {
                Some(depth) => {
                    drop(ui.add(drag(depth).range(1..=1000).speed(0.05)).labelled_by(name));
                }
                None => drop(ui.weak("unbounded")),
            }
        });
        choose(ui, "Integrator", &mut settings.integrator, &INTEGRATORS);
        let samplers = [(SamplerKind::Sobol, "sobol"), (SamplerKind::Independent, "independent")];
        choose(ui, "Sampler", &mut settings.sampler, &samplers);
        let heuristics = [
            (Heuristic::Balance, "balance"),
            (Heuristic::Power, "power"),
            (Heuristic::Optimal, "optimal"),
        ];
        choose(ui, "Heuristic", &mut settings.heuristic, &heuristics);
        let roulettes = [
            (Roulette::Throughput, "throughput"),
            (Roulette::Albedo, "albedo"),
            (Roulette::Off, "off"),
        ];
        choose(ui, "Roulette", &mut settings.roulette, &roulettes);
        if settings.roulette == Roulette::Off {
            // Something must end the paths.
            settings.max_depth = settings.max_depth.or(Some(32));
        }
        row(ui, "Seed", |ui, name| {
            ui.add(drag(&mut settings.seed)).labelled_by(name);
        });
        ui.checkbox(&mut settings.caustics, "Caustics by paths from lights");
    });
}

/// Exposure and curve.
pub(super) fn display(ui: &mut Ui, look: &mut Look) {
    row(ui, "Exposure", |ui, name| {
        ui.add(slider(&mut look.display.exposure, -8.0..=8.0).max_decimals(2)).labelled_by(name);
    });
    choose(ui, "Curve", &mut look.display.curve, &CURVES);
}
