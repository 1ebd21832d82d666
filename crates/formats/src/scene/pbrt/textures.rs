//! What varies over surfaces: statements become textures of the scene, and factors on them.
//!
//! A texture of the scene is a picture or a checker; materials take a colour times one of them.
//! Products with constants, mixtures of constants and the like come down to that. What does not is
//! told in a note.

use super::description::TextureStatement;
use super::lexer::Place;
use super::parameters::{Before, Parameter, Parameters};
use super::scene::Maker;
use super::spectra::{Told, told};
use crate::error::{SceneError, SceneErrorKind};
use crate::scene::nearest::nearest;
use crate::shown::shown;
use rutilant::color::{Rgb, Spectrum};
use rutilant::scene::{BitmapId, TextureId};
use rutilant::texture::{
    Channel, Checker, Encoding, ImageTexture, Interpolation, Texture, UvMapping, Wrap,
};
use rutilant_geom::Vec2;

/// A colour times what varies.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Texel {
    pub(super) factor: Rgb,
    pub(super) varies: Option<Varies>,
}

/// What varies.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Varies {
    Picture(Picture),
    Checker(Checker),
}

/// A picture on a surface.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Picture {
    bitmap: BitmapId,
    /// How the file is called.
    name: String,
    encoding: Encoding,
    wrap: Wrap,
    interpolation: Interpolation,
    mapping: UvMapping,
    /// What is done to its values, in this order.
    pub(super) changes: Vec<Change>,
}

/// What is done to each value of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Change {
    /// What it lacks to 1.
    Invert,
    /// What a matte body of this colour sends back below a surface that sends this part of diffuse
    /// light back inside: see [`below_surface`].
    Below(f32),
    /// A power of it.
    Power(f32),
    /// A multiple of it.
    Times(f32),
}

impl Change {
    pub(super) fn apply(self, value: f32) -> f32 {
        match self {
            Self::Invert => 1.0 - value,
            Self::Below(inside) => below_surface(value, inside),
            Self::Power(exponent) => rutilant_geom::real::pow(value.max(0.0), exponent),
            Self::Times(factor) => value * factor,
        }
    }
}

/// The part of light that gets out again of what has entered a clear layer above a matte body of
/// `albedo`, where the layer's surface sends the part `inside` of diffuse light back to the body:
/// a (1 − i) / (1 − a i), the sum of a geometric series (Saunderson 1942).
pub(super) fn below_surface(albedo: f32, inside: f32) -> f32 {
    let albedo = albedo.clamp(0.0, 1.0);
    albedo * (1.0 - inside) / (1.0 - albedo * inside).max(1e-6)
}

impl Texel {
    pub(super) fn constant(factor: Rgb) -> Self {
        Self { factor, varies: None }
    }

    pub(super) fn number(value: f32) -> Self {
        Self::constant(Rgb::grey(value))
    }

    /// The same everywhere?
    pub(super) fn as_constant(&self) -> Option<Rgb> {
        self.varies.is_none().then_some(self.factor)
    }

    /// The mean of its channels, where it is the same everywhere.
    pub(super) fn as_number(&self) -> Option<f32> {
        let [r, g, b] = self.factor.0;
        self.varies.is_none().then_some(if r == g && g == b { r } else { (r + g + b) / 3.0 })
    }

    pub(super) fn times(mut self, factor: Rgb) -> Self {
        for (own, factor) in self.factor.0.iter_mut().zip(factor.0) {
            *own *= factor;
        }
        self
    }

    /// The same with each value changed; the factor of a picture takes part where it is the same as
    /// if the picture had it.
    pub(super) fn changed(mut self, change: Change) -> Self {
        match &mut self.varies {
            None => self.factor = Rgb(self.factor.0.map(|c| change.apply(c))),
            Some(Varies::Checker(checker)) => {
                let factor = self.factor.0;
                for color in [&mut checker.first, &mut checker.second] {
                    *color = Rgb(std::array::from_fn(|i| change.apply(color.0[i] * factor[i])));
                }
                self.factor = Rgb::WHITE;
            }
            Some(Varies::Picture(picture)) => {
                let [r, g, b] = self.factor.0;
                match change {
                    Change::Power(_) => {
                        self.factor = Rgb(self.factor.0.map(|c| change.apply(c)));
                    }
                    Change::Invert | Change::Below(_) | Change::Times(_) => {
                        if r == g && g == b && r != 1.0 {
                            picture.changes.push(Change::Times(r));
                            self.factor = Rgb::WHITE;
                        }
                    }
                }
                picture.changes.push(change);
            }
        }
        self
    }
}

impl Maker<'_> {
    /// A colour that a parameter tells, or `default`.
    pub(super) fn color(
        &mut self,
        parameters: &Parameters,
        name: &str,
        default: Rgb,
    ) -> Result<Texel, SceneError> {
        self.value(parameters, name, default, true)
    }

    /// A number that a parameter tells, or `default`.
    pub(super) fn number(
        &mut self,
        parameters: &Parameters,
        name: &str,
        default: f32,
    ) -> Result<Texel, SceneError> {
        self.value(parameters, name, Rgb::grey(default), false)
    }

    fn value(
        &mut self,
        parameters: &Parameters,
        name: &str,
        default: Rgb,
        colors: bool,
    ) -> Result<Texel, SceneError> {
        let Some(parameter) = parameters.get(name) else { return Ok(Texel::constant(default)) };
        match told(parameters, parameter, self.library())? {
            Some(told) => Ok(Texel::constant(told.reflectance())),
            None => self.texture_of(parameters, parameter, colors),
        }
    }

    /// The spectrum of a parameter that may not vary.
    pub(super) fn spectrum(
        &mut self,
        parameters: &Parameters,
        name: &str,
    ) -> Result<Option<Told>, SceneError> {
        let Some(parameter) = parameters.get(name) else { return Ok(None) };
        if let Some(told) = told(parameters, parameter, self.library())? {
            return Ok(Some(told));
        }
        let texel = self.texture_of(parameters, parameter, true)?;
        if texel.varies.is_some() {
            let what = format!("\"{name}\" of {} cannot vary: its mean stands in", parameters.of);
            self.note(parameter.place, what);
        }
        Ok(Some(Told::Rgb(mean(&texel))))
    }

    /// The number of a parameter that may not vary.
    pub(super) fn plain_number(
        &mut self,
        parameters: &Parameters,
        name: &str,
        default: f32,
    ) -> Result<f32, SceneError> {
        let texel = self.number(parameters, name, default)?;
        if texel.varies.is_some() {
            let what = format!("\"{name}\" of {} cannot vary: its mean stands in", parameters.of);
            self.note(parameters.place, what);
        }
        let [r, g, b] = mean(&texel).0;
        Ok(if r == g && g == b { r } else { (r + g + b) / 3.0 })
    }

    fn texture_of(
        &mut self,
        parameters: &Parameters,
        parameter: &Parameter,
        colors: bool,
    ) -> Result<Texel, SceneError> {
        let Some(name) = parameters.text(&parameter.name, self.texts)? else {
            return Ok(Texel::number(1.0));
        };
        self.texture_named(name, parameter.place, parameters.before, colors)
    }

    /// The texture that a name means in a statement before which so many had been declared.
    pub(super) fn texture_named(
        &mut self,
        name: &str,
        place: Place,
        before: Before,
        colors: bool,
    ) -> Result<Texel, SceneError> {
        let Some(number) = self.names.texture(name, colors, before.textures) else {
            let known = self.description.textures.iter().map(|texture| &*texture.name);
            let kind = SceneErrorKind::Unknown {
                what: "texture",
                name: shown(name),
                closest: nearest(name, known).map(shown),
            };
            return Err(self.texts.error(place, kind));
        };
        match self.texels.get(&number) {
            Some(Some(texel)) => return Ok(texel.clone()),
            Some(None) => {
                let what = format!("the texture \"{}\" is made of itself", shown(name));
                return Err(self.texts.invalid(place, what));
            }
            None => {}
        }
        let (asked, allowed) = (self.depth + 1, self.options.limits.nesting);
        if asked > allowed {
            let kind = SceneErrorKind::Limit { what: "levels of nesting", asked, allowed };
            return Err(self.texts.error(place, kind));
        }
        self.texels.insert(number, None);
        self.depth += 1;
        let description = self.description;
        let texel = self.made_texture(&description.textures[number])?;
        self.depth -= 1;
        self.texels.insert(number, Some(texel.clone()));
        Ok(texel)
    }

    fn made_texture(&mut self, statement: &TextureStatement) -> Result<Texel, SceneError> {
        let TextureStatement { colors, kind, parameters, .. } = statement;
        let either = |maker: &mut Self, name: &str, default: f32| {
            if *colors {
                maker.color(parameters, name, Rgb::grey(default))
            } else {
                maker.number(parameters, name, default)
            }
        };
        let texel = match &**kind {
            "constant" => either(self, "value", 1.0)?,
            "imagemap" => self.picture(statement)?,
            "scale" => {
                // Older scenes multiply any two.
                let (first, second) = if parameters.get("tex1").is_some() {
                    (either(self, "tex1", 1.0)?, either(self, "tex2", 1.0)?)
                } else {
                    (either(self, "tex", 1.0)?, self.number(parameters, "scale", 1.0)?)
                };
                match (first.as_constant(), second.as_constant()) {
                    (Some(constant), _) => second.times(constant),
                    (_, Some(constant)) => first.times(constant),
                    (None, None) => {
                        self.note(
                            parameters.place,
                            "the product of two textures that vary is not made: the mean of the \
                             second stands in for it",
                        );
                        let constant = mean(&second);
                        first.times(constant)
                    }
                }
            }
            "mix" | "directionmix" => {
                if kind == "directionmix" {
                    self.note(parameters.place, "a directionmix does not heed the direction");
                }
                let (first, second) = (either(self, "tex1", 0.0)?, either(self, "tex2", 1.0)?);
                let amount = self.number(parameters, "amount", 0.5)?;
                self.mixed(first, second, amount, parameters.place)
            }
            "checkerboard" => {
                let (first, second) = (either(self, "tex1", 1.0)?, either(self, "tex2", 0.0)?);
                if parameters.whole("dimension", self.texts)?.unwrap_or(2) != 2 {
                    self.note(parameters.place, "a checkerboard in space lies on the surface here");
                }
                parameters.ignore(&["aamode"]);
                if first.varies.is_some() || second.varies.is_some() {
                    let what = "a checkerboard of textures that vary is one of their means";
                    self.note(parameters.place, what);
                }
                let mapping = self.mapping(parameters, 0.5)?;
                let (first, second) = (mean(&first), mean(&second));
                let varies = Some(Varies::Checker(Checker { first, second, mapping }));
                Texel { factor: Rgb::WHITE, varies }
            }
            other => {
                let what =
                    format!("textures of type \"{}\" are not made: grey stands in", shown(other));
                self.note(parameters.place, what);
                return Ok(Texel::number(0.5));
            }
        };
        parameters.tell_unused(self.texts, &mut self.notes);
        Ok(texel)
    }

    /// `first` where `amount` is 0, `second` where it is 1.
    fn mixed(&mut self, first: Texel, second: Texel, amount: Texel, place: Place) -> Texel {
        let lerp = |a: Rgb, b: Rgb, t: Rgb| {
            Rgb(std::array::from_fn(|i| a.0[i] + (b.0[i] - a.0[i]) * t.0[i]))
        };
        match (first.as_constant(), second.as_constant(), &amount.varies) {
            (Some(a), Some(b), None) => Texel::constant(lerp(a, b, amount.factor)),
            (Some(a), Some(b), Some(Varies::Checker(checker))) => {
                let at = |t: Rgb| lerp(a, b, Texel::constant(amount.factor).times(t).factor);
                let (first, second) = (at(checker.first), at(checker.second));
                let varies = Some(Varies::Checker(Checker { first, second, ..*checker }));
                Texel { factor: Rgb::WHITE, varies }
            }
            (Some(Rgb::BLACK), Some(b), Some(_)) => amount.times(b),
            (Some(a), None, None) if a == Rgb::BLACK => second.times(amount.factor),
            (None, Some(b), None) if b == Rgb::BLACK => {
                first.times(Rgb(amount.factor.0.map(|t| 1.0 - t)))
            }
            (Some(a), Some(Rgb::BLACK), Some(Varies::Picture(_)))
                if amount.factor == Rgb::WHITE =>
            {
                amount.changed(Change::Invert).times(a)
            }
            _ => {
                let what = "a mixture of textures that vary is not made: the mean of what there is \
                            less of stands in for it, or of both";
                self.note(place, what);
                Texel::constant(lerp(mean(&first), mean(&second), mean(&amount)))
            }
        }
    }

    /// How a texture lies on surfaces, with a factor on its scale.
    fn mapping(&mut self, parameters: &Parameters, factor: f32) -> Result<UvMapping, SceneError> {
        let texts = self.texts;
        if let Some(other) = parameters.text("mapping", texts)?.filter(|kind| *kind != "uv") {
            let what = format!(
                "textures lie on surfaces by their own coordinates, not by mapping \"{}\"",
                shown(other)
            );
            self.note(parameters.place, what);
            parameters.ignore(&["v1", "v2"]);
        }
        let number = |name: &str, default: f32| parameters.number_or(name, default, texts);
        let scale = Vec2::new(number("uscale", 1.0)?, number("vscale", 1.0)?) * factor;
        let offset = Vec2::new(number("udelta", 0.0)?, number("vdelta", 0.0)?) * factor;
        Ok(UvMapping { scale, offset, ..UvMapping::default() })
    }

    fn picture(&mut self, statement: &TextureStatement) -> Result<Texel, SceneError> {
        let TextureStatement { parameters, .. } = statement;
        let texts = self.texts;
        let place = parameters.place;
        let name = parameters.text("filename", texts)?.unwrap_or_default().to_owned();
        let wrap = match parameters.text("wrap", texts)? {
            None | Some("repeat") => Wrap::Repeat,
            Some("clamp") => Wrap::Clamp,
            Some(other) => {
                let what =
                    format!("pictures do not wrap as \"{}\": their edges go on", shown(other));
                self.note(place, what);
                Wrap::Clamp
            }
        };
        let interpolation = match parameters.text("filter", texts)? {
            Some("point") => Interpolation::Nearest,
            Some(_) | None => Interpolation::Bilinear,
        };
        let encoding = match parameters.text("encoding", texts)? {
            Some("linear") => Encoding::Linear,
            None | Some("sRGB") => Encoding::Srgb,
            Some(other) => {
                let gamma = other.strip_prefix("gamma").and_then(|g| g.trim().parse::<f32>().ok());
                match gamma {
                    Some(1.0) => Encoding::Linear,
                    Some(gamma) if (2.1..=2.3).contains(&gamma) => Encoding::Srgb,
                    _ => {
                        let what = format!("the encoding \"{}\" is taken as sRGB", shown(other));
                        self.note(place, what);
                        Encoding::Srgb
                    }
                }
            }
        };
        // Older scenes say whether there is a gamma.
        let encoding = match parameters.truth_or("gamma", encoding == Encoding::Srgb, texts)? {
            true => Encoding::Srgb,
            false => Encoding::Linear,
        };
        parameters.ignore(&["trilinear", "maxanisotropy"]);
        let scale = parameters.number_or("scale", 1.0, texts)?;
        let changes = match parameters.truth_or("invert", false, texts)? {
            true => vec![Change::Invert],
            false => Vec::new(),
        };
        let mapping = self.mapping(parameters, 1.0)?;
        let source = texts.source(parameters.place_of("filename"));
        let bitmap = self.pictures.want_named(&name, self.files, source);
        let picture = Picture { bitmap, name, encoding, wrap, interpolation, mapping, changes };
        Ok(Texel { factor: Rgb::grey(scale), varies: Some(Varies::Picture(picture)) })
    }

    /// A picture that lies on surfaces as it is.
    pub(super) fn plain_picture(
        &mut self,
        name: &str,
        encoding: Encoding,
        place: Place,
    ) -> TextureId {
        let bitmap = self.pictures.want_named(name, self.files, self.texts.source(place));
        let (wrap, interpolation) = (Wrap::Repeat, Interpolation::Bilinear);
        let (mapping, changes) = (UvMapping::default(), Vec::new());
        let name = name.to_owned();
        self.texture(&Varies::Picture(Picture {
            bitmap,
            name,
            encoding,
            wrap,
            interpolation,
            mapping,
            changes,
        }))
    }

    /// The scene's texture for what varies.
    pub(super) fn texture(&mut self, varies: &Varies) -> TextureId {
        let key = format!("{varies:?}");
        if let Some(id) = self.texture_ids.get(&key) {
            return *id;
        }
        let id = match varies {
            Varies::Checker(checker) => {
                self.texture_names.push(String::new());
                self.scene.add_texture(Texture::Checker(*checker))
            }
            Varies::Picture(picture) => {
                self.texture_names.push(picture.name.clone());
                let id = self.scene.add_texture(Texture::Image(ImageTexture {
                    bitmap: picture.bitmap,
                    encoding: picture.encoding,
                    wrap: [picture.wrap; 2],
                    interpolation: picture.interpolation,
                    mapping: picture.mapping,
                }));
                if !picture.changes.is_empty() {
                    self.changed.push((id, picture.changes.clone()));
                }
                id
            }
        };
        self.texture_ids.insert(key, id);
        id
    }

    /// Factor and texture for a colour that a surface has.
    pub(super) fn input(&mut self, texel: &Texel) -> (Rgb, Option<TextureId>) {
        (texel.factor, texel.varies.as_ref().map(|varies| self.texture(varies)))
    }

    /// Factor and channel for a number that a surface has; of a picture that lacks to 1, where that
    /// is all that is done to it.
    pub(super) fn scalar(&mut self, texel: &Texel) -> (f32, Option<(TextureId, Channel)>) {
        let [r, g, b] = texel.factor.0;
        let factor = if r == g && g == b { r } else { Spectrum::from(texel.factor).luminance() };
        let texture = match &texel.varies {
            None => None,
            Some(Varies::Picture(picture)) if picture.changes == [Change::Invert] => {
                let plain = Picture { changes: Vec::new(), ..picture.clone() };
                Some((self.texture(&Varies::Picture(plain)), Channel::InverseRed))
            }
            Some(varies) => Some((self.texture(varies), Channel::Red)),
        };
        (factor, texture)
    }
}

/// The mean over a surface; of a picture nothing is known yet, and a half stands in.
pub(super) fn mean(texel: &Texel) -> Rgb {
    let of = match &texel.varies {
        None => Rgb::WHITE,
        Some(Varies::Checker(checker)) => {
            Rgb(std::array::from_fn(|i| 0.5 * (checker.first.0[i] + checker.second.0[i])))
        }
        Some(Varies::Picture(_)) => Rgb::grey(0.5),
    };
    Texel::constant(texel.factor).times(of).factor
}
