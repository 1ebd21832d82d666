//! What varies over surfaces, and what does not: colours and numbers of BSDFs and lamps.
//!
//! Texture coordinates are kept as Mitsuba has them. There the first row of a picture is where v is
//! 0, here the last one; so pictures, and only they, are turned over in their mapping.

use super::document::{Class, Place, View, plain_text};
use super::scene::Maker;
use super::value::{Color, Value};
use crate::error::SceneError;
use crate::scene::affine::Affine;
use crate::scene::spectrum::{Sampled, illuminant};
use crate::shown::shown;
use rutilant::color::{Rgb, Spectrum};
use rutilant::scene::TextureId;
use rutilant::texture::{
    Channel, Checker, ColorInput, Encoding, ImageTexture, Interpolation, ScalarInput, Texture,
    UvMapping, Wrap,
};
use rutilant_geom::{Vec2, real};

/// A colour for each place of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Paint {
    pub(super) factor: Rgb,
    pub(super) texture: Option<TextureId>,
    pub(super) vertex_colors: bool,
}

impl Paint {
    pub(super) fn even(factor: Rgb) -> Self {
        Self { factor, texture: None, vertex_colors: false }
    }

    pub(super) fn varies(&self) -> bool {
        self.texture.is_some() || self.vertex_colors
    }

    pub(super) fn input(self) -> ColorInput {
        let Self { factor, texture, vertex_colors } = self;
        ColorInput { factor, texture, vertex_colors }
    }

    /// As a number: the luminance of its factor, and of a texture the red, which is that of all
    /// channels of a grey one.
    pub(super) fn scalar(self) -> ScalarInput {
        let [r, g, b] = self.factor.0;
        let luminance = Spectrum::from(self.factor).luminance();
        let factor = if r == g && g == b { r } else { luminance };
        ScalarInput { factor, texture: self.texture.map(|id| (id, Channel::Red)) }
    }
}

/// What a colour is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Use {
    /// What surfaces send back.
    Surface,
    /// What lamps give.
    Light,
    /// A number for each channel, which is no colour.
    Number,
}

/// Textures refer to textures; no sensible one does so more deeply.
const DEEPEST: u32 = 16;

impl Maker<'_, '_> {
    /// The colour of this name: a property, or a texture.
    pub(super) fn paint(
        &mut self,
        of: View<'_, '_>,
        name: &str,
        used: Use,
    ) -> Result<Option<Paint>, SceneError> {
        if let Some(written) = of.property(name) {
            let rgb = match written.value {
                Value::Color(color) => self.color(color, written.place, used)?,
                Value::Float(x) => Rgb::grey(*x as f32),
                Value::Integer(x) => Rgb::grey(*x as f32),
                other => {
                    let what = format!("{name} is {}, but must be a colour", other.kind());
                    return Err(of.document.invalid(written.place, what));
                }
            };
            return Ok(Some(Paint::even(rgb)));
        }
        match of.part(name) {
            Some(part) => self.texture(part, used, 0).map(Some),
            None => Ok(None),
        }
    }

    /// The same, where nothing may vary: what does is told, and not seen.
    pub(super) fn even_color(
        &mut self,
        of: View<'_, '_>,
        name: &str,
        used: Use,
    ) -> Result<Option<Rgb>, SceneError> {
        let Some(paint) = self.paint(of, name, used)? else { return Ok(None) };
        if paint.varies() {
            let (class, plugin) = (of.class().name(), shown(of.plugin()));
            let what =
                format!("{name} of {class} \"{plugin}\" cannot vary here: its texture is left out");
            of.note(&what, &what);
        }
        Ok(Some(paint.factor))
    }

    /// A number of this name that may vary.
    pub(super) fn scalar(
        &mut self,
        of: View<'_, '_>,
        name: &str,
        default: f32,
    ) -> Result<ScalarInput, SceneError> {
        let paint = self.paint(of, name, Use::Number)?;
        Ok(paint.map_or(ScalarInput::from(default), Paint::scalar))
    }

    /// A number of this name that may not.
    pub(super) fn even_number(
        &mut self,
        of: View<'_, '_>,
        name: &str,
        default: f32,
    ) -> Result<f32, SceneError> {
        let input = self.scalar(of, name, default)?;
        if input.texture.is_none() {
            return Ok(input.factor);
        }
        let plugin = shown(of.plugin());
        let what = format!("{name} of bsdf \"{plugin}\" cannot vary here: {default} stands in");
        of.note(&what, &what);
        Ok(default)
    }

    pub(super) fn color(&self, color: &Color, place: Place, used: Use) -> Result<Rgb, SceneError> {
        let seen = |sampled: &Sampled| match used {
            Use::Surface => sampled.reflectance(),
            Use::Light => sampled.light(),
            Use::Number => sampled.mean(),
        };
        Ok(match color {
            Color::Rgb(rgb) => *rgb,
            // Light that is the same at every wavelength is not white, which is that of the day.
            Color::Even(value) if used == Use::Light => {
                let even = illuminant("E").unwrap_or(Rgb::WHITE);
                Rgb(even.0.map(|c| c * value))
            }
            Color::Even(value) => Rgb::grey(*value),
            Color::Sampled(sampled) => seen(sampled),
            Color::File(name) => seen(&self.sampled_file(name, place)?),
            Color::BlackBody(kelvin, scale) => {
                let light = Sampled::black_body(*kelvin).light();
                Rgb(light.0.map(|c| c * scale))
            }
        })
    }

    /// The samples of a spectrum, where it has some.
    pub(super) fn samples(
        &self,
        of: View<'_, '_>,
        name: &str,
    ) -> Result<Option<Sampled>, SceneError> {
        let Some(written) = of.property(name) else { return Ok(None) };
        match written.value {
            Value::Color(Color::Sampled(sampled)) => Ok(Some(sampled.clone())),
            Value::Color(Color::File(name)) => self.sampled_file(name, written.place).map(Some),
            _ => Ok(None),
        }
    }

    fn sampled_file(&self, name: &str, place: Place) -> Result<Sampled, SceneError> {
        let found = self.document.content(name, place)?;
        let text = plain_text(found.bytes, &found.path)?;
        Sampled::parse(&text).map_err(|what| SceneError::invalid_file(&found.path, what))
    }

    /// What a texture shows, or a spectrum that is an object of its own.
    pub(super) fn texture(
        &mut self,
        texture: View<'_, '_>,
        used: Use,
        depth: u32,
    ) -> Result<Paint, SceneError> {
        if depth > DEEPEST {
            let what = "textures refer to each other over and over";
            return Err(texture.document.invalid(texture.place(), what));
        }
        let key = (texture.number, used);
        if let Some(paint) = self.paints.get(&key) {
            return Ok(*paint);
        }
        let paint = match (texture.class(), texture.plugin()) {
            (Class::Texture, "bitmap") => self.bitmap(texture)?,
            (Class::Texture, "checkerboard") => {
                let first = self.even_color(texture, "color0", Use::Surface)?;
                let second = self.even_color(texture, "color1", Use::Surface)?;
                let checker = Checker {
                    first: first.unwrap_or(Rgb::grey(0.4)),
                    second: second.unwrap_or(Rgb::grey(0.2)),
                    mapping: self.mapping(texture, false)?,
                };
                let id = self.scene.add_texture(checker);
                self.remember(rutilant::scene::Place::Texture(id.0 as usize), texture.place());
                Paint { texture: Some(id), ..Paint::even(Rgb::WHITE) }
            }
            (Class::Texture, "scale") => {
                let factor = texture.number("scale", 1.0)?;
                let inner = texture.parts(Class::Texture).next();
                let inner = match inner {
                    Some(inner) => self.texture(inner, used, depth + 1)?,
                    None => self.paint(texture, "value", used)?.unwrap_or(Paint::even(Rgb::WHITE)),
                };
                Paint { factor: Rgb(inner.factor.0.map(|c| c * factor)), ..inner }
            }
            (Class::Texture, "mesh_attribute") => {
                let name = texture.text("name")?.unwrap_or_default();
                if name != "vertex_color" {
                    let what = format!(
                        "the mesh attribute \"{}\" is not read; only vertex_color is",
                        shown(name)
                    );
                    return Err(texture.document.unsupported(texture.place(), what));
                }
                let scale = texture.number("scale", 1.0)?;
                Paint { vertex_colors: true, ..Paint::even(Rgb::grey(scale)) }
            }
            (Class::Spectrum | Class::Texture, "uniform") => {
                Paint::even(Rgb::grey(texture.number("value", 1.0)?))
            }
            (Class::Spectrum | Class::Texture, "d65") => {
                let scale = texture.number("scale", 1.0)?;
                let color = self.even_color(texture, "color", used)?;
                let color = color.or(self.even_color(texture, "value", used)?);
                let color = color.or_else(|| illuminant("D65")).unwrap_or(Rgb::WHITE);
                Paint::even(Rgb(color.0.map(|c| c * scale)))
            }
            (Class::Spectrum | Class::Texture, "srgb") => {
                let color = self.even_color(texture, "color", used)?;
                Paint::even(color.unwrap_or(Rgb::WHITE))
            }
            (Class::Spectrum | Class::Texture, "blackbody") => {
                let kelvin = texture.number("temperature", 5000.0)?;
                let scale = texture.number("scale", 1.0)?;
                Paint::even(self.color(&Color::BlackBody(kelvin, scale), texture.place(), used)?)
            }
            _ => {
                return Err(texture.unknown(&[
                    "bitmap",
                    "checkerboard",
                    "mesh_attribute",
                    "scale",
                    "uniform",
                    "d65",
                    "srgb",
                    "blackbody",
                ]));
            }
        };
        self.paints.insert(key, paint);
        Ok(paint)
    }

    fn bitmap(&mut self, texture: View<'_, '_>) -> Result<Paint, SceneError> {
        let id = self.picture(texture)?;
        Ok(Paint { texture: Some(id), ..Paint::even(Rgb::WHITE) })
    }

    /// The picture that a bitmap shows.
    pub(super) fn picture(&mut self, texture: View<'_, '_>) -> Result<TextureId, SceneError> {
        let (name, place) = texture.file_name()?;
        let raw = texture.boolean("raw", false)?;
        let gamma = texture.optional_number("gamma")?;
        if gamma.is_some_and(|gamma| gamma > 0.0 && gamma != 1.0) {
            let what = "a gamma of a picture is left out: its colours are taken as sRGB";
            texture.note(what, what);
        }
        let encoding = if raw || gamma == Some(1.0) { Encoding::Linear } else { Encoding::Srgb };
        let interpolation = texture.choice(
            "filter_type",
            &[
                ("bilinear", Interpolation::Bilinear),
                ("nearest", Interpolation::Nearest),
                ("ewa", Interpolation::Bilinear),
                ("trilinear", Interpolation::Bilinear),
            ],
        )?;
        let wraps = [("repeat", Wrap::Repeat), ("mirror", Wrap::Mirror), ("clamp", Wrap::Clamp)];
        let wrap = texture.choice("wrap_mode", &wraps)?;
        let either = |name: &'static str| match texture.text(name)? {
            Some(_) => texture.choice(name, &wraps),
            None => Ok(wrap),
        };
        let wrap = [either("wrap_mode_u")?, either("wrap_mode_v")?];
        texture.pass_over(&["max_anisotropy", "cache", "channel", "accel", "format"]);
        let mapping = self.mapping(texture, true)?;
        let name = self.document.picture(name);
        let at = self.document.source(place);
        let bitmap = self.pictures.want_named(&name, &self.document.files, at);
        let image = ImageTexture { bitmap, encoding, wrap, interpolation, mapping };
        let id = self.scene.add_texture(Texture::from(image));
        self.remember(rutilant::scene::Place::Texture(id.0 as usize), texture.place());
        Ok(id)
    }

    /// From the surface's texture coordinates to those of a texture; pictures are turned over.
    fn mapping(&self, texture: View<'_, '_>, turned: bool) -> Result<UvMapping, SceneError> {
        let matrix = texture.transform("to_uv")?;
        // 0.6 has a factor and an offset for each coordinate.
        let scale = texture.number("uvscale", 1.0)?;
        let [u, v] = ["uscale", "vscale"].map(|name| texture.number(name, scale));
        let [right, up] = ["uoffset", "voffset"].map(|name| texture.number(name, 0.0));
        let (u, v, right, up) = (u?, v?, right?, up?);
        let old = Affine::scale([f64::from(u), f64::from(v), 1.0].into());
        let moved = Affine::translate([f64::from(right), f64::from(up), 0.0].into());
        let (mapping, exact) = mapping_of(&(moved * old * matrix), turned);
        if !exact {
            let what = "a to_uv that shears is shown without its shear";
            texture.note(what, what);
        }
        Ok(mapping)
    }
}

/// Scale, turn and offset of a map of texture coordinates, and whether they are all of it. With
/// F(u, v) = (u, 1 − v) after it, a turn by θ becomes one by −θ of what v is turned over in first.
fn mapping_of(matrix: &Affine, turned: bool) -> (UvMapping, bool) {
    let [[a, c, _], [b, d, _], _] = matrix.linear.map(|column| column.to_array());
    let (rotation, scale, exact) = if b == 0.0 && c == 0.0 {
        (0.0, [a, d], true)
    } else {
        // Degrees, so that a native scene can say it, to the bit.
        let rotation = real::atan2(c as f32, a as f32).to_degrees().to_radians();
        let (s, k) = real::sin_cos(rotation);
        let (s, k) = (f64::from(s), f64::from(k));
        let scale = [a * k + c * s, d * k - b * s];
        let size = a.abs() + b.abs() + c.abs() + d.abs();
        (rotation, scale, (a * b + c * d).abs() <= 1e-5 * size * size)
    };
    let [x, y, _] = matrix.translation.to_array();
    let (rotation, scale, offset) = match turned {
        true => (0.0 - rotation, [scale[0], -scale[1]], [x, 1.0 - y]),
        false => (rotation, scale, [x, y]),
    };
    let pair = |[x, y]: [f64; 2]| Vec2::new(x as f32, y as f32);
    (UvMapping { set: 0, scale: pair(scale), rotation, offset: pair(offset) }, exact)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rutilant_geom::DVec3;

    /// What a mapping does is what the matrix does, turned over at the end where it should be.
    #[test]
    fn mappings_agree() {
        let turn = Affine::rotate(30.0, DVec3::Z).unwrap();
        let scale = Affine::scale(DVec3::new(2.0, -3.0, 1.0));
        let moved = Affine::translate(DVec3::new(0.25, -0.5, 0.0));
        for matrix in [Affine::IDENTITY, scale, moved * turn * scale] {
            for turned in [false, true] {
                let (mapping, exact) = mapping_of(&matrix, turned);
                assert!(exact);
                for uv in [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::new(0.3, 0.9)] {
                    let scaled = uv * mapping.scale;
                    let (s, c) = mapping.rotation.sin_cos();
                    let there = Vec2::new(c * scaled.x - s * scaled.y, s * scaled.x + c * scaled.y)
                        + mapping.offset;
                    let wanted = matrix.point(DVec3::new(uv.x.into(), uv.y.into(), 0.0));
                    let v = if turned { 1.0 - wanted.y } else { wanted.y };
                    let wanted = Vec2::new(wanted.x as f32, v as f32);
                    assert!((there - wanted).length() < 1e-5, "{matrix:?} {uv}");
                }
            }
        }
        let shear =
            Affine { linear: [DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Z], ..Affine::IDENTITY };
        assert!(!mapping_of(&shear, true).1);
    }
}
