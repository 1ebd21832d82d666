//! Lights: surfaces that glow, points, spots, the sun, and the sky.
//!
//! The sky of Mitsuba may stand in any way; here +y is up in it. Where it does not stand upright the
//! whole scene is turned until it does: nothing else changes, and nothing is lost.

use super::document::{Class, View};
use super::scene::Maker;
use super::texture::Use;
use crate::error::SceneError;
use crate::scene::affine::{Affine, single};
use crate::scene::pictures::sky_picture;
use rutilant::color::Rgb;
use rutilant::light::{Environment, EnvironmentLight, Light, Projection, SpotLight};
use rutilant::material::{Emission, EmittedLight};
use rutilant::scene::Place;
use rutilant_geom::{DVec3, real};

/// All that are read.
const KNOWN: &[&str] = &["area", "constant", "envmap", "point", "spot", "directional"];

impl Maker<'_, '_> {
    /// The light that a shape gives.
    pub(super) fn emission(&mut self, emitter: View<'_, '_>) -> Result<Emission, SceneError> {
        if emitter.plugin() != "area" {
            let what = "a shape can only have an emitter of type \"area\"";
            return Err(emitter.document.invalid(emitter.place(), what));
        }
        let radiance = self.paint(emitter, "radiance", Use::Light)?;
        emitter.pass_over(&["sampling_weight"]);
        let (factor, texture, vertex_colors) = match radiance {
            Some(paint) => (paint.factor, paint.texture, paint.vertex_colors),
            None => (Rgb::WHITE, None, false),
        };
        let light = EmittedLight::Radiance(factor);
        Ok(Emission { light, texture, vertex_colors, two_sided: false, group: None })
    }

    /// A light that is no shape's.
    pub(super) fn emitter(&mut self, emitter: View<'_, '_>) -> Result<(), SceneError> {
        emitter.pass_over(&["sampling_weight", "samples"]);
        let place = Place::Light(self.scene.lights.len());
        let light = match emitter.plugin() {
            // Shapes refer to it.
            "area" => return Ok(()),
            "constant" => {
                let radiance = self.even_color(emitter, "radiance", Use::Light)?;
                let sky = Environment::constant(radiance.unwrap_or(Rgb::WHITE));
                return self.sky(emitter, sky);
            }
            "envmap" => return self.map(emitter),
            "point" => {
                let to_world = self.stand(emitter)?;
                let intensity = self.even_color(emitter, "intensity", Use::Light)?;
                let intensity = intensity.unwrap_or(Rgb::WHITE);
                Light::Point { position: single(to_world.translation), intensity, group: None }
            }
            "spot" => {
                let to_world = self.stand(emitter)?;
                let intensity = self.even_color(emitter, "intensity", Use::Light)?;
                let outer = emitter.number("cutoff_angle", 20.0)?;
                let inner = emitter.number("beam_width", outer * 0.75)?;
                if emitter.part("texture").is_some() {
                    let what = "the texture of a spot is left out";
                    emitter.note(what, what);
                }
                if inner != outer {
                    let what = "between beam_width and cutoff_angle a spot fades by a smooth curve \
                                here, not in proportion to the angle";
                    emitter.note(what, what);
                }
                Light::Spot {
                    position: single(to_world.translation),
                    direction: single(to_world.vector(DVec3::Z)),
                    light: SpotLight::Intensity(intensity.unwrap_or(Rgb::WHITE)),
                    inner: inner.to_radians(),
                    outer: outer.to_radians(),
                    group: None,
                }
            }
            "directional" => {
                let to_world = self.stand(emitter)?;
                let own = emitter.vector("direction")?.map(DVec3::from);
                let direction = match own {
                    Some(direction) => self.turn.vector(direction),
                    None => to_world.vector(DVec3::Z),
                };
                let irradiance = self.even_color(emitter, "irradiance", Use::Light)?;
                let irradiance = irradiance.unwrap_or(Rgb::WHITE);
                Light::Directional { direction: single(direction), irradiance, group: None }
            }
            _ => return Err(emitter.unknown(KNOWN)),
        };
        self.remember(place, emitter.place());
        self.scene.lights.push(light);
        Ok(())
    }

    /// Where a light stands; `position` is another word for a translation.
    fn stand(&self, emitter: View<'_, '_>) -> Result<Affine, SceneError> {
        let to_world = emitter.transform("to_world")?;
        let position = emitter.vector("position")?.map(DVec3::from);
        let to_world = position.map_or(to_world, Affine::translate);
        Ok(self.turn * to_world)
    }

    fn sky(&mut self, emitter: View<'_, '_>, sky: Environment) -> Result<(), SceneError> {
        if self.scene.environment.is_some() {
            let what = "there is more than one sky; a scene has one";
            return Err(emitter.document.invalid(emitter.place(), what));
        }
        self.remember(Place::Environment, emitter.place());
        self.scene.environment = Some(sky);
        Ok(())
    }

    fn map(&mut self, emitter: View<'_, '_>) -> Result<(), SceneError> {
        let (name, place) = emitter.file_name()?;
        let scale = emitter.number("scale", 1.0)?;
        let to_world = emitter.transform("to_world")?;
        emitter.pass_over(&["mis_compensation"]);
        let find = || self.document.find(name, place);
        let (picture, origin) =
            sky_picture(&self.document.files, name, &self.options.limits, find)?;
        self.image_origins.push(origin);
        let picture = picture.map_err(|error| SceneError::invalid_file(&error.file, error.what))?;
        if to_world.mirrors() {
            let what = "a sky that is mirrored is shown as it is";
            emitter.note(what, what);
        }
        let image = self.scene.add_image(picture);
        self.image_names.push(self.document.picture(name));
        let light = EnvironmentLight::Image { image, projection: Projection::Equirectangular };
        // The middle of the picture lies at +z in Mitsuba, and at −z here: half a turn away.
        let rotation = (180.0 + heading_degrees(&(self.turn * to_world))).to_radians();
        self.sky(emitter, Environment { light, scale, rotation, group: None })
    }
}

/// Where +z goes, counter-clockwise from +z as seen from above, in degrees.
fn heading_degrees(world_from_sky: &Affine) -> f32 {
    let ahead = world_from_sky.vector(DVec3::Z);
    real::atan2(ahead.x as f32, ahead.z as f32).to_degrees()
}

/// What turns a scene until its sky stands upright; `None` where it does.
pub(super) fn upright(scene: View<'_, '_>) -> Result<Option<Affine>, SceneError> {
    let Some(sky) = scene.parts(Class::Emitter).find(|emitter| emitter.plugin() == "envmap") else {
        return Ok(None);
    };
    let to_world = sky.transform("to_world")?;
    let Some(up) = to_world.vector(DVec3::Y).try_normalize() else { return Ok(None) };
    if (up - DVec3::Y).length() < 1e-5 {
        return Ok(None);
    }
    let what = "the sky does not stand upright: all of the scene is turned until its up is +y";
    sky.note(what, what);
    // The shortest way, around what is square to both.
    let axis = up.cross(DVec3::Y);
    let sine = axis.length();
    let degrees = real::atan2(sine as f32, up.y as f32).to_degrees();
    Ok(Affine::rotate(degrees, if sine < 1e-9 { DVec3::X } else { axis }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Headings grow counter-clockwise as seen from above, from +z towards +x.
    #[test]
    fn headings() {
        assert_eq!(heading_degrees(&Affine::IDENTITY), 0.0);
        let turned = Affine::rotate(90.0, DVec3::Y).unwrap();
        assert!((heading_degrees(&turned) - 90.0).abs() < 1e-4);
    }
}
