//! Cameras, and what is said of the picture: its size, filter, samples and how long paths are.
//!
//! Mitsuba's cameras look along +z with x to the left; those here look along −z with x to the right.
//! Both are turned the same way by their transforms, so only the names of the axes differ.

use super::document::{Class, View};
use super::scene::Maker;
use crate::camera::{
    AngleOfView, Aperture, AuthoredCamera, AuthoredLens, CameraKind, FocusOn, SENSOR_HEIGHT_MM,
};
use crate::error::SceneError;
use crate::scene::affine::single;
use crate::scene::framing::rescaled;
use crate::shown::shown;
use rutilant::film::Filter;
use rutilant::settings::{Crop, IntegratorKind, Settings};
use rutilant_geom::{DVec3, real};

/// All that are read.
const KNOWN: &[&str] = &["perspective", "thinlens", "orthographic"];

/// The side of a picture that an angle of view is measured along.
#[derive(Clone, Copy)]
enum Axis {
    X,
    Y,
    Diagonal,
    Smaller,
    Larger,
}

impl Maker<'_, '_> {
    /// A camera in words, for a film of `size` pixels.
    pub(super) fn camera(
        &mut self,
        sensor: View<'_, '_>,
        size: [u32; 2],
    ) -> Result<AuthoredCamera, SceneError> {
        if !KNOWN.contains(&sensor.plugin()) {
            return Err(sensor.unknown(KNOWN));
        }
        let own = sensor.transform("to_world")?;
        let world = self.turn * own;
        if own.mirrors() {
            let what = "a camera that mirrors shows what it sees unmirrored";
            sensor.note(what, what);
        }
        sensor.pass_over(&["near_clip", "far_clip", "shutter_open", "shutter_close", "srf"]);
        let [width, height] = size.map(|side| side as f32);
        let aspect = width / height;
        let lens = match sensor.plugin() {
            "thinlens" => {
                let radius = match sensor.optional_number("aperture_radius")? {
                    Some(radius) => radius,
                    None => {
                        let what = "a thinlens needs an aperture_radius";
                        return Err(sensor.document.invalid(sensor.place(), what));
                    }
                };
                let focus = FocusOn::Distance(sensor.number("focus_distance", 1.0)?);
                AuthoredLens { aperture: Aperture::Radius(radius), focus, ..AuthoredLens::PINHOLE }
            }
            _ => {
                sensor.pass_over(&["focus_distance"]);
                AuthoredLens::PINHOLE
            }
        };
        for name in ["principal_point_offset_x", "principal_point_offset_y"] {
            if sensor.number(name, 0.0)? != 0.0 {
                let what =
                    format!("{name} is left out: the middle of the view is that of the picture");
                sensor.note(&what, &what);
            }
        }
        let kind = match sensor.plugin() {
            "orthographic" => {
                // Two units wide by themselves; the transform scales them.
                let [wide, high] = [world.linear[0].length(), world.linear[1].length()];
                if (wide - high).abs() > 1e-4 * wide {
                    let what = "pixels are squares: how an orthographic camera is scaled along its \
                                x counts for its y as well";
                    sensor.note(what, what);
                }
                let height = 2.0 * wide as f32 / aspect;
                CameraKind::Orthographic { height, lens }
            }
            _ => {
                let degrees = self.fov_degrees(sensor, aspect)?;
                let sensor_height_mm = SENSOR_HEIGHT_MM;
                let view = AngleOfView::FovDegrees(degrees);
                CameraKind::Perspective { view, sensor_height_mm, lens }
            }
        };
        let position = world.translation;
        let unit = |axis: DVec3| world.vector(axis).try_normalize();
        let Some((ahead, up)) = unit(DVec3::Z).zip(unit(DVec3::Y)) else {
            let what = "the camera's transform flattens its view";
            return Err(sensor.document.invalid(sensor.place(), what));
        };
        // Far enough for the direction to be told by the difference of two points.
        let distance = position.abs().max_element().max(1.0);
        Ok(AuthoredCamera {
            name: sensor.id().to_owned(),
            position: single(position),
            look_at: single(position + ahead * distance),
            up: single(up),
            kind,
        })
    }

    /// The angle from bottom to top, in degrees.
    fn fov_degrees(&self, sensor: View<'_, '_>, aspect: f32) -> Result<f32, SceneError> {
        let along = sensor.choice(
            "fov_axis",
            &[
                ("x", Axis::X),
                ("y", Axis::Y),
                ("diagonal", Axis::Diagonal),
                ("smaller", Axis::Smaller),
                ("larger", Axis::Larger),
            ],
        )?;
        let (axis, degrees) = match sensor.optional_number("fov")? {
            Some(degrees) => (along, degrees),
            None => {
                // A focal length is one for film of 36 x 24 mm.
                let text = sensor.text("focal_length")?.unwrap_or("50mm");
                let written = text.trim().trim_end_matches("mm").trim().parse::<f32>();
                let Some(length) = written.ok().filter(|length| *length > 0.0) else {
                    let what = format!("\"{}\" is no focal length like 50mm", shown(text));
                    return Err(sensor.document.invalid(sensor.place(), what));
                };
                let half_diagonal = 0.5 * (36.0_f32 * 36.0 + 24.0 * 24.0).sqrt();
                (Axis::Diagonal, 2.0 * real::atan2(half_diagonal, length).to_degrees())
            }
        };
        if !(degrees > 0.0 && degrees < 180.0) {
            let place = sensor.property("fov").map_or(sensor.place(), |written| written.place);
            let what = format!("fov is {degrees}, but must be more than 0 and less than 180");
            return Err(sensor.document.invalid(place, what));
        }
        let half = real::tan(0.5 * degrees.to_radians());
        let half_height = match axis {
            Axis::Y => return Ok(degrees),
            Axis::Smaller if aspect >= 1.0 => return Ok(degrees),
            Axis::Larger if aspect < 1.0 => return Ok(degrees),
            Axis::X | Axis::Smaller | Axis::Larger => half / aspect,
            Axis::Diagonal => half / (1.0 + aspect * aspect).sqrt(),
        };
        Ok(2.0 * real::atan2(half_height, 1.0).to_degrees())
    }

    /// What the film and the sampler of a sensor say of the picture.
    pub(super) fn film(
        &mut self,
        sensor: Option<View<'_, '_>>,
        settings: &mut Settings,
    ) -> Result<(), SceneError> {
        // Mitsuba's own.
        settings.size = [768, 576];
        settings.spp = 4;
        settings.filter = GAUSSIAN;
        let Some(sensor) = sensor else { return Ok(()) };
        if let Some(sampler) = sensor.only(Class::Sampler) {
            let side = 1..=u32::MAX;
            if let Some(count) = sampler.count("sample_count", side)? {
                settings.spp = u64::from(count);
            }
            if let Some(seed) = sampler.integer("seed")? {
                settings.seed = seed.unsigned_abs();
            }
            sampler.pass_over(&["dimension", "jitter", "scramble"]);
        }
        let Some(film) = sensor.only(Class::Film) else { return Ok(()) };
        let side = 1..=Settings::MAX_SIDE;
        let [width, height] = settings.size;
        settings.size = [
            film.count("width", side.clone())?.unwrap_or(width),
            film.count("height", side.clone())?.unwrap_or(height),
        ];
        let [width, height] = settings.size;
        let pixels = u64::from(width) * u64::from(height);
        let allowed = self.options.limits.picture;
        if pixels > allowed && self.options.size.is_none() {
            let kind = crate::error::SceneErrorKind::Limit {
                what: "pixels of the picture",
                asked: pixels,
                allowed,
            };
            return Err(film.document.error(film.place(), kind));
        }
        let crop = Crop {
            x: film.count("crop_offset_x", 0..=width)?.unwrap_or(0),
            y: film.count("crop_offset_y", 0..=height)?.unwrap_or(0),
            width: film.count("crop_width", side.clone())?.unwrap_or(width),
            height: film.count("crop_height", side)?.unwrap_or(height),
        };
        if crop != (Crop { x: 0, y: 0, width, height }) {
            settings.crop = Some(crop);
        }
        // What the caller asks for has the film's shape, and the same part of it is cut out.
        if let Some(size) = self.options.size {
            settings.size = size;
            settings.crop = settings.crop.map(|crop| {
                let [x0, x1] = [crop.x, crop.x.saturating_add(crop.width)]
                    .map(|at| rescaled(at, width, size[0]));
                let [y0, y1] = [crop.y, crop.y.saturating_add(crop.height)]
                    .map(|at| rescaled(at, height, size[1]));
                // One pixel is left at least.
                Crop {
                    x: x0.min(size[0].saturating_sub(1)),
                    y: y0.min(size[1].saturating_sub(1)),
                    width: (x1 - x0).max(1),
                    height: (y1 - y0).max(1),
                }
            });
        }
        film.pass_over(&[
            "file_format",
            "pixel_format",
            "component_format",
            "banner",
            "sample_border",
            "compensate",
            "attach_log",
            "high_quality_edges",
            "gamma",
            "exposure",
            "tonemap_method",
            "key",
            "burn",
        ]);
        if let Some(filter) = film.only(Class::Filter) {
            settings.filter = filter_of(filter)?;
        }
        Ok(())
    }

    /// What the integrator says of paths.
    pub(super) fn integrator(
        &mut self,
        scene: View<'_, '_>,
        settings: &mut Settings,
    ) -> Result<(), SceneError> {
        let mut all = scene.parts(Class::Integrator);
        let Some(integrator) = all.next() else { return Ok(()) };
        if let Some(other) = all.next() {
            let what = "there is more than one integrator: the first one counts";
            other.note(what, what);
        }
        self.integrator_of(integrator, settings, 0)
    }

    fn integrator_of(
        &mut self,
        integrator: View<'_, '_>,
        settings: &mut Settings,
        depth: u32,
    ) -> Result<(), SceneError> {
        match integrator.plugin() {
            "path" => {}
            // What light does up to the first surface that scatters it.
            "direct" => {
                settings.max_depth = Some(2);
                integrator.pass_over(&["emitter_samples", "bsdf_samples", "shading_samples"]);
                return hide_emitters(integrator);
            }
            "depth" => settings.integrator = IntegratorKind::Depth,
            // What is around the integrator that renders: other channels, and their statistics.
            "aov" | "moment" | "multichannel" | "adaptive" | "irrcache" if depth < 4 => {
                let what = format!(
                    "only what is within the integrator \"{}\" is shown",
                    integrator.plugin()
                );
                integrator.note(&what, &what);
                integrator.pass_over(&["aovs"]);
                let inner = integrator.parts(Class::Integrator).next();
                return inner
                    .map_or(Ok(()), |inner| self.integrator_of(inner, settings, depth + 1));
            }
            other => {
                let what = format!(
                    "the integrator \"{}\" is not there: \"path\" finds the same light",
                    shown(other)
                );
                integrator.note(&what, &what);
            }
        }
        let max_depth = integrator.integer("max_depth")?.unwrap_or(-1);
        settings.max_depth = match (max_depth, u32::try_from(max_depth)) {
            (-1, _) => None,
            (1.., Ok(depth)) => Some(depth),
            (_, _) => {
                let written = integrator.property("max_depth");
                let place = written.map_or(integrator.place(), |written| written.place);
                let what = match max_depth {
                    0 => "max_depth is 0, with which nothing is seen: it must be 1 or more, or -1"
                        .to_owned(),
                    _ => {
                        format!("max_depth is {max_depth}, but must be 1 or more, or -1 for no end")
                    }
                };
                return Err(integrator.document.invalid(place, what));
            }
        };
        // When paths end at random changes noise alone: that is for the renderer to say.
        integrator.pass_over(&[
            "rr_depth",
            "strict_normals",
            "emitter_samples",
            "bsdf_samples",
            "shading_samples",
            "samples_per_pass",
            "block_size",
            "timeout",
        ]);
        hide_emitters(integrator)
    }
}

fn hide_emitters(integrator: View<'_, '_>) -> Result<(), SceneError> {
    if integrator.boolean("hide_emitters", false)? {
        let what = "lamps are not hidden: hide_emitters is left out";
        integrator.note(what, what);
    }
    Ok(())
}

/// Mitsuba's own filter.
const GAUSSIAN: Filter = Filter::Gaussian { radius: 2.0, sigma: 0.5 };

fn filter_of(filter: View<'_, '_>) -> Result<Filter, SceneError> {
    let radius = filter.optional_number("radius")?;
    Ok(match filter.plugin() {
        "box" => Filter::Box { radius: radius.unwrap_or(0.5) },
        "tent" => Filter::Tent { radius: radius.unwrap_or(1.0) },
        "gaussian" => {
            let sigma = filter.number("stddev", 0.5)?;
            Filter::Gaussian { radius: radius.unwrap_or(4.0 * sigma), sigma }
        }
        "mitchell" => {
            let b = filter.number("A", filter.number("b", 1.0 / 3.0)?)?;
            let c = filter.number("B", filter.number("c", 1.0 / 3.0)?)?;
            Filter::Mitchell { radius: 2.0, b, c }
        }
        "catmullrom" => Filter::Mitchell { radius: 2.0, b: 0.0, c: 0.5 },
        "lanczos" => {
            let what = "the filter \"lanczos\" is not there: \"catmullrom\", its like, stands in";
            filter.note(what, what);
            filter.pass_over(&["lobes"]);
            Filter::Mitchell { radius: 2.0, b: 0.0, c: 0.5 }
        }
        _ => {
            return Err(filter.unknown(&[
                "box",
                "tent",
                "gaussian",
                "mitchell",
                "catmullrom",
                "lanczos",
            ]));
        }
    })
}
