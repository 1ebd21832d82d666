//! `[[texture]]`: what varies over surfaces; and colours that take one.

use super::draft::Draft;
use super::keys;
use super::said::{self, Group, Said, Written, color, number};
use super::table::{Table, Value};
use crate::error::SceneError;
use crate::scene::loaded::TextureName;
use crate::shown::shown;
use rutilant::color::Rgb;
use rutilant::material::{Bumps, NormalMap, Opacity, OpacityMode};
use rutilant::scene::TextureId;
use rutilant::texture::{
    Bricks, Channel, Checker, ColorInput, Encoding, ImageTexture, Interpolation, Noise,
    ScalarInput, Texture, UvMapping, Wrap,
};
use rutilant_geom::Vec2;

#[derive(Clone, Copy)]
enum Type {
    Image,
    Checker,
    Bricks,
    Noise,
}

const TYPES: &[(&str, Type)] = &[
    ("image", Type::Image),
    ("checker", Type::Checker),
    ("bricks", Type::Bricks),
    ("noise", Type::Noise),
];

/// The usual colours of patterns.
const DARK: Rgb = Rgb::grey(0.2);
const LIGHT: Rgb = Rgb::grey(0.8);
/// The usual width of joints between bricks, and how far rows are usually moved.
const JOINT: f32 = 0.05;
const SHIFT: f32 = 0.5;
/// The usual scales of noise, and how strong each is against the one before.
const OCTAVES: u32 = 6;
const GAIN: f32 = 0.5;

const ENCODINGS: &[(&str, Encoding)] = &[("srgb", Encoding::Srgb), ("linear", Encoding::Linear)];

const WRAPS: &[(&str, Wrap)] =
    &[("repeat", Wrap::Repeat), ("mirror", Wrap::Mirror), ("clamp", Wrap::Clamp)];

const INTERPOLATIONS: &[(&str, Interpolation)] =
    &[("bilinear", Interpolation::Bilinear), ("nearest", Interpolation::Nearest)];

const CHANNELS: &[(&str, Channel)] = &[
    ("red", Channel::Red),
    ("green", Channel::Green),
    ("blue", Channel::Blue),
    ("alpha", Channel::Alpha),
    ("inverse-red", Channel::InverseRed),
    ("inverse-green", Channel::InverseGreen),
    ("inverse-blue", Channel::InverseBlue),
    ("inverse-alpha", Channel::InverseAlpha),
];

pub(super) fn read<'d>(table: &Table<'d>, draft: &mut Draft<'d>) -> Result<(), SceneError> {
    let name = table.must("name", |value| {
        let name = value.text()?;
        if draft.textures.contains_key(name) {
            let what = format!("there is another texture \"{}\"; names must differ", shown(name));
            return Err(value.invalid(what));
        }
        Ok(name)
    })?;
    let called = TextureName::Named(name.to_owned());
    let id = match table.or("type", |v| v.one_of("texture type", TYPES), Type::Image)? {
        Type::Image => {
            let table = table.named("an image texture");
            table.only(&[keys::ANY_TEXTURE, keys::IMAGE_TEXTURE])?;
            let image = ImageTexture {
                bitmap: table.must("image", |value| picture(value, draft))?,
                encoding: table.or(
                    "encoding",
                    |v| v.one_of("encoding", ENCODINGS),
                    Encoding::Srgb,
                )?,
                wrap: table.or("wrap", wraps, [Wrap::Repeat; 2])?,
                interpolation: table.or(
                    "interpolation",
                    |v| v.one_of("interpolation", INTERPOLATIONS),
                    Interpolation::Bilinear,
                )?,
                mapping: mapping(&table)?,
            };
            draft.add_texture(&table, called, image)
        }
        Type::Checker => {
            let table = table.named("a checker");
            table.only(&[keys::ANY_TEXTURE, keys::PATTERN])?;
            let checker = Checker {
                first: table.or("first", Value::color, DARK)?,
                second: table.or("second", Value::color, LIGHT)?,
                mapping: mapping(&table)?,
            };
            draft.add_texture(&table, called, checker)
        }
        Type::Bricks => {
            let table = table.named("bricks");
            table.only(&[keys::ANY_TEXTURE, keys::PATTERN, keys::BRICKS])?;
            let bricks = Bricks {
                first: table.or("first", Value::color, DARK)?,
                second: table.or("second", Value::color, LIGHT)?,
                joint: table.or("joint", one_or_two, Vec2::splat(JOINT))?,
                shift: table.or("shift", Value::number, SHIFT)?,
                mapping: mapping(&table)?,
            };
            draft.add_texture(&table, called, bricks)
        }
        Type::Noise => {
            let table = table.named("noise");
            table.only(&[keys::ANY_TEXTURE, keys::PATTERN, keys::NOISE])?;
            let noise = Noise {
                first: table.or("first", Value::color, DARK)?,
                second: table.or("second", Value::color, LIGHT)?,
                octaves: table.or("octaves", Value::whole, OCTAVES)?,
                gain: table.or("gain", Value::number, GAIN)?,
                mapping: mapping(&table)?,
            };
            draft.add_texture(&table, called, noise)
        }
    };
    draft.textures.insert(name, id);
    Ok(())
}

/// The picture that a value names, to be read later.
fn picture(
    value: &Value<'_>,
    draft: &mut Draft<'_>,
) -> Result<rutilant::scene::BitmapId, SceneError> {
    Ok(draft.pictures.want_named(value.text()?, &draft.files, value.source()))
}

/// One word for both axes, or one for each.
fn wraps(value: &Value<'_>) -> Result<[Wrap; 2], SceneError> {
    const EXPECTED: &str = "a word, or one for u and one for v";
    let wrap = |value: &Value<'_>| value.one_of("wrap", WRAPS);
    if !value.is_array() {
        return wrap(value).map(|both| [both; 2]);
    }
    let each: Vec<Wrap> = value.entries(EXPECTED)?.map(|v| wrap(&v)).collect::<Result<_, _>>()?;
    each.try_into().map_err(|_| value.must_be(EXPECTED))
}

/// One number for both axes, or one for each.
fn one_or_two(value: &Value<'_>) -> Result<Vec2, SceneError> {
    if value.is_number() { value.number().map(Vec2::splat) } else { value.pair() }
}

fn mapping(table: &Table<'_>) -> Result<UvMapping, SceneError> {
    Ok(UvMapping {
        set: table.or("uv_set", Value::whole, 0)?,
        scale: table.or("uv_scale", one_or_two, Vec2::ONE)?,
        rotation: table.or("uv_rotation_degrees", Value::number, 0.0)?.to_radians(),
        offset: table.or("uv_offset", Value::pair, Vec2::ZERO)?,
    })
}

/// A colour, or a table that says more. `owner` is the table that it stands in.
pub(super) fn color_input<'d>(
    value: &Value<'d>,
    owner: &Table<'d>,
    draft: &mut Draft<'d>,
) -> Result<ColorInput, SceneError> {
    if !value.is_table() {
        return value.color().map(ColorInput::from);
    }
    let table = value.table("a textured color")?;
    table.only(&[keys::COLOR_INPUT])?;
    Ok(ColorInput {
        texture: texture_of(&table, owner, Encoding::Srgb, draft)?,
        factor: table.or("factor", Value::color, Rgb::WHITE)?,
        vertex_colors: table.or("vertex_colors", Value::flag, false)?,
    })
}

/// A number, or a table that says more.
pub(super) fn scalar_input<'d>(
    value: &Value<'d>,
    owner: &Table<'d>,
    draft: &mut Draft<'d>,
) -> Result<ScalarInput, SceneError> {
    if !value.is_table() {
        return value.number().map(ScalarInput::from);
    }
    let table = value.table("a textured number")?;
    table.only(&[keys::SCALAR_INPUT])?;
    table.either(["texture", "image"])?;
    let texture = texture_of(&table, owner, Encoding::Linear, draft)?;
    let channel = table.or("channel", |v| v.one_of("channel", CHANNELS), Channel::Red)?;
    let factor = table.or("factor", Value::number, 1.0)?;
    Ok(ScalarInput { factor, texture: texture.map(|id| (id, channel)) })
}

/// A picture of directions along a surface.
pub(super) fn directions<'d>(
    value: &Value<'d>,
    owner: &Table<'d>,
    draft: &mut Draft<'d>,
) -> Result<TextureId, SceneError> {
    let table = value.table("a picture of directions")?;
    table.only(&[keys::DIRECTIONS])?;
    table.either(["texture", "image"])?;
    texture_of(&table, owner, Encoding::Linear, draft)?.ok_or_else(|| table.missing("texture"))
}

/// A picture of normals or of heights, by one of two keys.
pub(super) fn bumps<'d>(
    keys: [&'static str; 2],
    owner: &Table<'d>,
    draft: &mut Draft<'d>,
) -> Result<Option<NormalMap>, SceneError> {
    let [normals, heights] = keys;
    let shows = match owner.at_most_one(&keys)? {
        Some(key) if key == normals => Bumps::Normals,
        _ => Bumps::Heights,
    };
    let key = if shows == Bumps::Normals { normals } else { heights };
    owner.maybe(key, |value| normal_map(value, shows, owner, draft))
}

fn normal_map<'d>(
    value: &Value<'d>,
    shows: Bumps,
    owner: &Table<'d>,
    draft: &mut Draft<'d>,
) -> Result<NormalMap, SceneError> {
    let table = value.table(match shows {
        Bumps::Normals => "a normal map",
        Bumps::Heights => "a bump map",
    })?;
    table.only(&[keys::NORMAL_MAP])?;
    table.either(["texture", "image"])?;
    let texture = texture_of(&table, owner, Encoding::Linear, draft)?;
    let texture = texture.ok_or_else(|| table.missing("texture"))?;
    Ok(NormalMap { texture, scale: table.or("scale", Value::number, 1.0)?, shows })
}

/// A number, or a table that says more: how much of a surface is there.
pub(super) fn opacity<'d>(
    value: &Value<'d>,
    owner: &Table<'d>,
    draft: &mut Draft<'d>,
) -> Result<Opacity, SceneError> {
    if !value.is_table() {
        let amount = value.number()?.into();
        return Ok(Opacity { amount, vertex_colors: false, mode: OpacityMode::Blend });
    }
    let table = value.table("an opacity")?;
    table.only(&[keys::OPACITY])?;
    let texture = texture_of(&table, owner, Encoding::Linear, draft)?;
    let channel = table.maybe("channel", |v| v.one_of("channel", CHANNELS))?;
    if let (None, Some(value)) = (texture, table.get("channel")) {
        return Err(value.invalid("channel needs a texture or an image"));
    }
    let cutoff = table.maybe("cutoff", Value::number)?;
    Ok(Opacity {
        amount: ScalarInput {
            factor: table.or("factor", Value::number, 1.0)?,
            texture: texture.map(|id| (id, channel.unwrap_or(Channel::Alpha))),
        },
        vertex_colors: table.or("vertex_colors", Value::flag, false)?,
        mode: cutoff.map_or(OpacityMode::Blend, |cutoff| OpacityMode::Mask { cutoff }),
    })
}

/// The texture that a table names, or makes of a picture with codes of this `encoding`.
pub(super) fn texture_of<'d>(
    table: &Table<'d>,
    owner: &Table<'d>,
    encoding: Encoding,
    draft: &mut Draft<'d>,
) -> Result<Option<TextureId>, SceneError> {
    Ok(match table.at_most_one(&["texture", "image"])? {
        Some("texture") => Some(table.must("texture", |value| named(value, draft))?),
        Some(_) => Some(table.must("image", |value| {
            let bitmap = picture(value, draft)?;
            let name = TextureName::Image(value.text()?.to_owned());
            let image = ImageTexture { encoding, ..ImageTexture::new(bitmap) };
            Ok(draft.add_texture(owner, name, image))
        })?),
        None => None,
    })
}

/// The texture that a value names.
fn named(value: &Value<'_>, draft: &Draft<'_>) -> Result<TextureId, SceneError> {
    let name = value.text()?;
    draft.textures.get(name).copied().ok_or_else(|| {
        let mut known: Vec<&str> = draft.textures.keys().copied().collect();
        known.sort_unstable();
        value.unknown("texture", name, known)
    })
}

/// The keys that say all of a texture called `name`; `pictures` are the names of all pictures, by
/// [`BitmapId`](rutilant::scene::BitmapId).
pub(super) fn keys_of(name: &str, texture: &Texture, pictures: &[String]) -> Vec<Group> {
    let mut groups = vec![Group::one(&["name"], said::text(name))];
    let mapping = match texture {
        Texture::Image(image) => {
            let file = pictures.get(image.bitmap.0 as usize).map_or("", String::as_str);
            let [u, v] = image.wrap.map(|wrap| said::name(WRAPS, &wrap));
            let wrap = if u == v { u } else { said::numbers([u, v]) };
            groups.extend([
                Group::one(&["image"], said::text(file)),
                Group::or(
                    &["encoding"],
                    said::name(ENCODINGS, &image.encoding),
                    &said::name(ENCODINGS, &Encoding::Srgb),
                ),
                Group::or(&["wrap"], wrap, &said::name(WRAPS, &Wrap::Repeat)),
                Group::or(
                    &["interpolation"],
                    said::name(INTERPOLATIONS, &image.interpolation),
                    &said::name(INTERPOLATIONS, &Interpolation::Bilinear),
                ),
            ]);
            image.mapping
        }
        Texture::Checker(checker) => {
            groups.extend([
                Group::one(&["type"], said::text("checker")),
                Group::or(&["first"], color(checker.first), &color(DARK)),
                Group::or(&["second"], color(checker.second), &color(LIGHT)),
            ]);
            checker.mapping
        }
        Texture::Bricks(bricks) => {
            let both = |Vec2 { x, y }: Vec2| {
                let same = x.to_bits() == y.to_bits();
                if same { number(x) } else { said::numbers([x, y].map(number)) }
            };
            groups.extend([
                Group::one(&["type"], said::text("bricks")),
                Group::or(&["first"], color(bricks.first), &color(DARK)),
                Group::or(&["second"], color(bricks.second), &color(LIGHT)),
                Group::or(&["joint"], both(bricks.joint), &number(JOINT)),
                Group::or(&["shift"], number(bricks.shift), &number(SHIFT)),
            ]);
            bricks.mapping
        }
        Texture::Noise(noise) => {
            groups.extend([
                Group::one(&["type"], said::text("noise")),
                Group::or(&["first"], color(noise.first), &color(DARK)),
                Group::or(&["second"], color(noise.second), &color(LIGHT)),
                Group::or(&["octaves"], noise.octaves.to_string(), &OCTAVES.to_string()),
                Group::or(&["gain"], number(noise.gain), &number(GAIN)),
            ]);
            noise.mapping
        }
    };
    let UvMapping { set, scale: Vec2 { x, y }, rotation, offset } = mapping;
    let scale = match x.to_bits() == y.to_bits() {
        true => number(x),
        false => said::numbers([x, y].map(number)),
    };
    let offset = said::numbers(offset.to_array().map(number));
    groups.extend([
        Group::or(&["uv_set"], set.to_string(), "0"),
        Group::or(&["uv_scale"], scale, "1"),
        Group::or(&["uv_rotation_degrees"], said::degrees(rotation), "0"),
        Group::or(&["uv_offset"], offset, "[0, 0]"),
    ]);
    groups
}

/// A key with a colour that may be textured. `usual` is what is meant where the key is not there.
pub(super) fn said_color(
    key: &'static str,
    input: &ColorInput,
    names: &[TextureName],
    usual: &str,
) -> Said {
    if !input.varies() {
        return Said::or(key, color(input.factor), usual);
    }
    let groups = vec![
        said_texture(input.texture, names),
        Group::or(&["factor"], color(input.factor), "1"),
        Group::or(&["vertex_colors"], input.vertex_colors.to_string(), "false"),
    ];
    Said { key, value: Written::Table(groups), usual: false }
}

/// A key with a number that may be textured. `usual` is what is meant where the key is not there.
pub(super) fn said_scalar(
    key: &'static str,
    input: ScalarInput,
    names: &[TextureName],
    usual: f32,
) -> Said {
    let Some((id, channel)) = input.texture else {
        return Said::or(key, number(input.factor), &number(usual));
    };
    let red = said::name(CHANNELS, &Channel::Red);
    let groups = vec![
        said_texture(Some(id), names),
        Group::or(&["channel"], said::name(CHANNELS, &channel), &red),
        Group::or(&["factor"], number(input.factor), "1"),
    ];
    Said { key, value: Written::Table(groups), usual: false }
}

/// A picture of normals or of heights, by one of two keys.
pub(super) fn said_bumps(
    keys: &'static [&'static str; 2],
    map: Option<&NormalMap>,
    names: &[TextureName],
) -> Group {
    let [normals, heights] = *keys;
    let said = map.map(|&NormalMap { texture, scale, shows }| {
        let key = match shows {
            Bumps::Normals => normals,
            Bumps::Heights => heights,
        };
        let groups =
            vec![said_texture(Some(texture), names), Group::or(&["scale"], number(scale), "1")];
        Said { key, value: Written::Table(groups), usual: false }
    });
    Group::of(keys, said.into_iter().collect::<Vec<_>>())
}

/// A picture of directions along a surface.
pub(super) fn said_directions(
    key: &'static str,
    texture: TextureId,
    names: &[TextureName],
) -> Said {
    let value = Written::Table(vec![said_texture(Some(texture), names)]);
    Said { key, value, usual: false }
}

/// How much of a surface is there.
pub(super) fn said_opacity(opacity: &Opacity, names: &[TextureName]) -> Said {
    let &Opacity { amount: ScalarInput { factor, texture }, vertex_colors, mode } = opacity;
    let value = if (texture, vertex_colors, mode) == (None, false, OpacityMode::Blend) {
        Written::Plain(number(factor))
    } else {
        let usual = said::name(CHANNELS, &Channel::Alpha);
        let channel =
            texture.map(|(_, channel)| Said::or("channel", said::name(CHANNELS, &channel), &usual));
        let cutoff = match mode {
            OpacityMode::Blend => None,
            OpacityMode::Mask { cutoff } => Some(number(cutoff)),
        };
        Written::Table(vec![
            said_texture(texture.map(|(id, _)| id), names),
            Group::of(&["channel"], channel.into_iter().collect::<Vec<_>>()),
            Group::or(&["factor"], number(factor), "1"),
            Group::or(&["vertex_colors"], vertex_colors.to_string(), "false"),
            Group::maybe(&["cutoff"], cutoff),
        ])
    };
    Said { key: "opacity", value, usual: false }
}

/// What a table calls a texture.
pub(super) fn said_texture(texture: Option<TextureId>, names: &[TextureName]) -> Group {
    let said = texture.and_then(|id| names.get(id.0 as usize)).map(|name| match name {
        TextureName::Named(name) => Said::new("texture", said::text(name)),
        TextureName::Image(file) => Said::new("image", said::text(file)),
    });
    Group::of(&["texture", "image"], said.into_iter().collect::<Vec<_>>())
}
