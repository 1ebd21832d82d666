//! Lights: of shapes, of points, and from infinitely far away.
//!
//! A light of pbrt-v4 that is told in red, green and blue has these values in the picture; one that
//! is told by its spectrum has the luminance 1 there. Both times "scale". Where a "power" or an
//! "illuminance" is told, the light has it at a luminance of 1. All of them are brighter by what the
//! film is exposed.
//!
//! Source: Pharr, Jakob, Humphreys, *pbrt-v4 input file format*: "Lights"; *Physically Based
//! Rendering*, 4th ed., chapter 12, for what power and illuminance mean, and section 12.5 for maps.

use super::description::LightStatement;
use super::lexer::Place;
use super::parameters::Parameters;
use super::scene::Maker;
use super::spectra::told;
use super::state::AreaLight;
use crate::error::{SceneError, SceneErrorKind};
use crate::image;
use crate::scene::affine::{Affine, single};
use crate::scene::nearest::nearest;
use crate::scene::origins::PictureOrigin;
use crate::scene::pictures::sky_picture;
use crate::shown::shown;
use rutilant::color::{Rgb, Spectrum};
use rutilant::image::{Channel, Image};
use rutilant::light::{Environment, EnvironmentLight, Light, Projection, SpotLight};
use rutilant::material::{Emission, EmittedLight};
use rutilant::scene::MOST_LIGHT;
use rutilant::texture::Encoding;
use rutilant_geom::{DVec3, Vec3, real};
use std::f32::consts::PI;
use std::sync::Arc;

const KINDS: [&str; 7] =
    ["distant", "exinfinite", "goniometric", "infinite", "point", "projection", "spot"];

/// The world that a scene is rendered in, from the world that it is told in.
pub(super) struct World {
    pub(super) map: Affine,
    /// Whether the picture of the sky is mirrored.
    pub(super) mirrors_sky: bool,
}

/// A sky that comes from a picture; of several the first counts.
pub(super) fn sky_statement(lights: &[LightStatement]) -> Option<&LightStatement> {
    lights.iter().find(|light| {
        let named = |name| light.parameters.get(name).is_some();
        matches!(&*light.kind, "infinite" | "exinfinite") && (named("filename") || named("mapname"))
    })
}

impl World {
    /// Is mirrored where `mirrored`; and is turned so that the picture of a sky stands upright, which
    /// is the only way in which skies stand here.
    pub(super) fn of(sky: Option<&LightStatement>, mirrored: bool) -> Self {
        let plain = |mirrored: bool| Affine {
            linear: [DVec3::X, DVec3::Y, if mirrored { DVec3::NEG_Z } else { DVec3::Z }],
            translation: DVec3::ZERO,
        };
        let turned = sky.and_then(|light| {
            let back = light.map.inverse()?;
            let scale = back.uniform_scale()?;
            // pbrt's maps have +z in their middle, or on top; ours +y. Both are seen from inside, and
            // one of the two worlds is left-handed: see `Projection`.
            let ours = match light.parameters.get("mapname") {
                None => [DVec3::X, DVec3::Z, DVec3::Y],
                Some(_) => [DVec3::Z, DVec3::NEG_X, DVec3::Y],
            };
            let linear = back.linear.map(|axis| axis / scale);
            let turn = Affine { linear, translation: DVec3::ZERO };
            Some(Affine { linear: ours, translation: DVec3::ZERO } * turn)
        });
        match turned {
            Some(map) if map.mirrors() == mirrored => Self { map, mirrors_sky: false },
            Some(map) => {
                let mirror = Affine::scale(DVec3::new(-1.0, 1.0, 1.0));
                Self { map: mirror * map, mirrors_sky: true }
            }
            None => Self { map: plain(mirrored), mirrors_sky: false },
        }
    }
}

impl Maker<'_> {
    /// The light of a parameter, exposed and scaled, and what scales it.
    fn light_of(&mut self, parameters: &Parameters, name: &str) -> Result<(Rgb, f32), SceneError> {
        let as_before = self.description.is_old;
        let mut color = match parameters.get(name) {
            None => Rgb::WHITE,
            Some(parameter) => match told(parameters, parameter, self.library())? {
                Some(told) => told.light(as_before),
                None => {
                    let what =
                        format!("\"{name}\" of {} cannot vary: white stands in", parameters.of);
                    self.note(parameter.place, what);
                    Rgb::WHITE
                }
            },
        };
        let mut scale = self.exposure;
        if let Some(parameter) = parameters.get("scale") {
            let factor = told(parameters, parameter, self.library())?.map(|told| told.numbers());
            let [r, g, b] = factor.unwrap_or(Rgb::WHITE).0;
            if r == g && g == b {
                scale *= r;
            } else {
                color = Rgb([color.0[0] * r, color.0[1] * g, color.0[2] * b]);
            }
        }
        if scale < 0.0 || !color.is_within(0.0..=f32::MAX) {
            let what = format!("{} gives less than no light: none", parameters.of);
            self.note(parameters.place, what);
        }
        Ok((Rgb(color.0.map(|c| c.max(0.0))), scale.max(0.0)))
    }

    /// What a surface with an area light gives. `parts` is how many lights pbrt makes of the shape.
    pub(super) fn emission(
        &mut self,
        light: &AreaLight,
        parts: usize,
    ) -> Result<Option<Emission>, SceneError> {
        let AreaLight { kind, parameters, .. } = light;
        if !matches!(&**kind, "diffuse" | "area") {
            let kind = SceneErrorKind::Unknown {
                what: "type of area lights",
                name: shown(kind),
                closest: nearest(kind, ["diffuse", "area"]).map(str::to_owned),
            };
            return Err(self.texts.error(parameters.place, kind));
        }
        let (color, scale) = self.light_of(parameters, "L")?;
        let two_sided = parameters.truth_or("twosided", false, self.texts)?;
        let power = parameters.number("power", self.texts)?.filter(|power| *power > 0.0);
        parameters.ignore(&["nsamples", "samples"]);
        let mut texture = None;
        if let Some(name) = parameters.text("filename", self.texts)?.map(str::to_owned) {
            texture =
                Some(self.plain_picture(&name, Encoding::Srgb, parameters.place_of("filename")));
        }
        parameters.tell_unused(self.texts, &mut self.notes);
        let light = match power {
            // Each of the parts has all of it.
            Some(power) => EmittedLight::Power(bounded(color, scale * power * parts as f32)),
            None => EmittedLight::Radiance(bounded(color, scale)),
        };
        let is_black = match light {
            EmittedLight::Radiance(rgb) | EmittedLight::Power(rgb) => rgb == Rgb::BLACK,
        };
        let emission = Emission { light, texture, vertex_colors: false, two_sided, group: None };
        Ok((!is_black).then_some(emission))
    }

    /// All lights that have no surface.
    pub(super) fn lights(&mut self) -> Result<(), SceneError> {
        let description = self.description;
        let mut even: Option<Rgb> = None;
        let picture = sky_statement(&description.lights);
        for statement in &description.lights {
            let LightStatement { kind, parameters, map } = statement;
            let place = parameters.place;
            let map = self.world.map * *map;
            let point = |parameters: &Parameters, name: &str, usual: [f32; 3]| {
                let [x, y, z] = parameters.some::<3>(name, self.texts)?.unwrap_or(usual);
                Ok::<_, SceneError>(DVec3::new(x.into(), y.into(), z.into()))
            };
            let (from, to) =
                (point(parameters, "from", [0.0; 3])?, point(parameters, "to", [0.0, 0.0, 1.0])?);
            let (position, direction) =
                (single(map.point(from)), single(map.vector(to - from).normalize_or_zero()));
            let power = parameters.number("power", self.texts)?.filter(|power| *power > 0.0);
            let lux = parameters.number("illuminance", self.texts)?.filter(|lux| *lux > 0.0);
            parameters.ignore(&["nsamples", "samples"]);
            match &**kind {
                "point" | "goniometric" => {
                    let (color, scale) = self.light_of(parameters, "I")?;
                    if kind == "goniometric" {
                        let what = "a goniometric light shines alike in all directions";
                        self.note(place, what);
                        parameters.ignore(&["filename", "mapname"]);
                    }
                    let scale = scale * power.map_or(1.0, |power| power / (4.0 * PI));
                    self.light(
                        place,
                        Light::Point { position, intensity: bounded(color, scale), group: None },
                    );
                }
                "spot" => {
                    let (color, scale) = self.light_of(parameters, "I")?;
                    let cone = parameters.number_or("coneangle", 30.0, self.texts)?;
                    let delta = parameters.number_or("conedeltaangle", 5.0, self.texts)?;
                    let outer = cone.clamp(0.01, 180.0).to_radians();
                    let inner = (cone - delta).clamp(0.0, cone.clamp(0.01, 180.0)).to_radians();
                    let less = |angle: f32| 2.0 * real::sin(0.5 * angle) * real::sin(0.5 * angle);
                    let scale = scale
                        * power.map_or(1.0, |power| power / (PI * (less(inner) + less(outer))));
                    let light = SpotLight::Intensity(bounded(color, scale));
                    if direction == Vec3::ZERO {
                        return Err(self.texts.invalid(place, "this spot light has no direction"));
                    }
                    self.light(
                        place,
                        Light::Spot { position, direction, light, inner, outer, group: None },
                    );
                }
                "distant" => {
                    let (color, scale) = self.light_of(parameters, "L")?;
                    let scale = scale * lux.unwrap_or(1.0);
                    if direction == Vec3::ZERO {
                        return Err(self
                            .texts
                            .invalid(place, "this distant light has no direction"));
                    }
                    let irradiance = bounded(color, scale);
                    self.light(place, Light::Directional { direction, irradiance, group: None });
                }
                "infinite" | "exinfinite" => {
                    let (color, scale) = self.light_of(parameters, "L")?;
                    if parameters.get("portal").is_some() {
                        self.note(place, "a portal is not needed: skies shine everywhere");
                    }
                    let is_the_picture =
                        picture.is_some_and(|other| std::ptr::eq(other, statement));
                    let has_one =
                        ["filename", "mapname"].iter().any(|n| parameters.get(n).is_some());
                    if is_the_picture {
                        self.sky(parameters, color, scale, lux)?;
                    } else if has_one {
                        self.note(place, "there is one picture of the sky: others are left out");
                    } else {
                        let light = bounded(color, scale * lux.map_or(1.0, |lux| lux / PI));
                        let so_far = even.unwrap_or(Rgb::BLACK).0;
                        even = Some(Rgb(std::array::from_fn(|i| so_far[i] + light.0[i])));
                    }
                }
                "projection" => {
                    self.note(place, "lights of type \"projection\" are left out");
                    parameters.ignore(&["filename", "mapname", "fov", "I", "scale"]);
                }
                other => {
                    let kind = SceneErrorKind::Unknown {
                        what: "type of lights",
                        name: shown(other),
                        closest: nearest(other, KINDS).map(str::to_owned),
                    };
                    return Err(self.texts.error(place, kind));
                }
            }
            parameters.tell_unused(self.texts, &mut self.notes);
        }
        match (even, picture) {
            (Some(light), None) => {
                self.scene.environment = Some(Environment::constant(bounded(light, 1.0)));
            }
            (Some(_), Some(picture)) => {
                let what = "an even sky beside the picture of one is left out";
                self.note(picture.parameters.place, what);
            }
            (None, _) => {}
        }
        Ok(())
    }

    fn light(&mut self, place: Place, light: Light) {
        if place.text == 0 {
            let number = self.scene.lights.len();
            self.lines.insert(rutilant::scene::Place::Light(number), place.line);
        }
        self.scene.lights.push(light);
    }

    /// A sky of a picture.
    fn sky(
        &mut self,
        parameters: &Parameters,
        color: Rgb,
        scale: f32,
        lux: Option<f32>,
    ) -> Result<(), SceneError> {
        let place = parameters.place;
        let (key, projection) = match parameters.get("mapname") {
            Some(_) => ("mapname", Projection::Equirectangular),
            None => ("filename", Projection::Octahedral),
        };
        let name = parameters.text(key, self.texts)?.unwrap_or_default().to_owned();
        let named = parameters.place_of(key);
        let invalid = |what: String| self.texts.invalid(named, what);
        let find = || self.files.find(&name).map_err(invalid);
        let (read, mut origin) = sky_picture(self.files, &name, &self.options.limits, find)?;
        if let PictureOrigin::File(file) = &origin {
            self.read_files.push(file.clone());
        }
        let mut picture = read.map_err(|error| invalid(error.to_string()))?;
        let (width, height) = (picture.width(), picture.height());
        if projection == Projection::Octahedral && width != height {
            let what = format!(
                "\"{}\" has {width}x{height} pixels, but the map of a sky in equal areas is a square",
                shown(&name)
            );
            return Err(invalid(what));
        }
        if self.world.mirrors_sky {
            picture = mirrored(&picture);
            let bytes = image::to_exr(&picture).map_err(invalid)?;
            let stem =
                std::path::Path::new(&name).file_stem().unwrap_or_default().to_string_lossy();
            let title = format!("{stem}-mirrored.exr");
            origin = PictureOrigin::Bytes { title, bytes: Arc::new(bytes) };
        }
        if sky_map(&self.description.lights).uniform_scale().is_none() {
            self.note(place, "the picture of the sky is stretched: it is shown as it is");
        }
        let [r, g, b] = color.0;
        let mut scale = scale;
        if r == g && g == b {
            scale *= r;
        } else {
            scale *= Spectrum::from(color).luminance();
            let what =
                "the colour before the picture of the sky is left out, but for its luminance";
            self.note(place, what);
        }
        if let Some(lux) = lux {
            let seen = upper_illuminance(&picture, projection);
            if seen > 0.0 {
                scale *= lux / seen;
            }
        }
        let image = self.scene.add_image(picture);
        self.image_names.push(name);
        self.image_origins.push(origin);
        let light = EnvironmentLight::Image { image, projection };
        self.scene.environment = Some(Environment { light, scale, rotation: 0.0, group: None });
        if place.text == 0 {
            self.lines.insert(rutilant::scene::Place::Environment, place.line);
        }
        Ok(())
    }
}

fn sky_map(lights: &[LightStatement]) -> Affine {
    sky_statement(lights).map_or(Affine::IDENTITY, |light| light.map)
}

/// Light within what a scene may ask for.
fn bounded(color: Rgb, scale: f32) -> Rgb {
    Rgb(color.0.map(|c| {
        let light = c * scale;
        if light.is_nan() { 0.0 } else { light.clamp(0.0, MOST_LIGHT) }
    }))
}

/// The same picture, left and right exchanged.
fn mirrored(picture: &Image) -> Image {
    let width = picture.width() as usize;
    let channels = picture.channels().iter().map(|channel| {
        let rows = channel.values.chunks_exact(width.max(1));
        let values = rows.flat_map(|row| row.iter().rev().copied()).collect();
        Channel { name: channel.name.clone(), values }
    });
    let same = Image::new(picture.width(), picture.height(), channels.collect());
    same.unwrap_or_else(|| picture.clone())
}

/// The luminance that falls onto the ground from the upper half of a sky; of a map of equal areas
/// half of it, for so does pbrt-v4 reckon.
fn upper_illuminance(picture: &Image, projection: Projection) -> f32 {
    let Some(pixels) = picture.rgb() else { return 0.0 };
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    let mut sum = 0.0_f64;
    for (i, pixel) in pixels.into_iter().enumerate() {
        let (column, row) = ((i % width) as f64 + 0.5, (i / width) as f64 + 0.5);
        // How high a pixel stands, and the solid angle that it counts for.
        let (up, angle) = match projection {
            Projection::Octahedral => {
                let [u, v] =
                    [column / width as f64, row / height as f64].map(|x| (2.0 * x - 1.0).abs());
                let inside = 1.0 - (u + v);
                let radius = 1.0 - inside.abs();
                // All pixels are a sphere, but pbrt-v4 takes them for its upper half alone, so that
                // its skies are twice as bright as they say (lights.cpp, `Light::Create`).
                let angle = 2.0 * std::f64::consts::PI / (width * height) as f64;
                ((1.0 - radius * radius) * inside.signum(), angle)
            }
            Projection::Equirectangular | Projection::Cube => {
                let theta = PI * (row / height as f64) as f32;
                let (sin, cos) = real::sin_cos(theta);
                let step = 2.0 * std::f64::consts::PI * std::f64::consts::PI;
                (f64::from(cos), step * f64::from(sin) / (width * height) as f64)
            }
        };
        let light = Spectrum::from(pixel).luminance();
        if up > 0.0 && light.is_finite() {
            sum += up * angle * f64::from(light);
        }
    }
    sum as f32
}
