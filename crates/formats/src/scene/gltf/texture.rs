//! Images, how they are sampled, and how materials refer to them.
//!
//! Images are not decoded here: they are bytes, or the name of a file that is
//! found by the same rule as all files of a scene. Images that are not read
//! (KTX2, DDS, AVIF) are refused by name, unless the texture names another one
//! to fall back to.
//!
//! Sources: Khronos Group, *glTF 2.0 Specification*, 2021, section 3.8;
//! `KHR_texture_transform`, `EXT_texture_webp`.

use super::accessor::Accessors;
use super::entry::{Entry, Result};
use super::store::unsupported;
use super::uri::{self, Meant};
use rutilant_geom::{Vec2, real};
use std::collections::HashMap;
use std::sync::Arc;

/// How an image is encoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// PNG.
    Png,
    /// JPEG.
    Jpeg,
    /// WebP.
    WebP,
}

/// Where an image's bytes are.
#[derive(Clone, Debug, PartialEq)]
pub enum ImageBytes {
    /// Here. Images that share a view share them.
    Here(Arc<Vec<u8>>),
    /// In a file. The name is as written, perhaps with escapes like `%20`.
    File(String),
}

/// An encoded image.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// What the author calls it; may be empty.
    pub name: String,
    /// Its encoding, by its first bytes, its type or its name; `None` where none of them tells.
    pub encoding: Option<Encoding>,
    /// Its bytes, or the file that holds them.
    pub bytes: ImageBytes,
}

/// What lies beyond an edge of a texture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// The texture again.
    #[default]
    Repeat,
    /// The texture again, every other time mirrored.
    Mirror,
    /// Its last texels.
    Clamp,
}

/// How a texture is looked up between its texels. Mip levels have no meaning for a path tracer
/// and are left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Filter {
    /// Linearly between the four around.
    #[default]
    Linear,
    /// At the nearest one.
    Nearest,
}

/// An image and how it is sampled.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// What the author calls it; may be empty.
    pub name: String,
    /// The number of its image in [`Document::images`](super::Document::images).
    pub image: usize,
    /// What lies beyond its edges, along u and v.
    pub wrap: [Wrap; 2],
    /// How it is looked up where it is magnified.
    pub filter: Filter,
}

/// Where in a texture a texture coordinate points: it is scaled, turned, then moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UvTransform {
    /// Added last, in widths and heights of the texture.
    pub offset: [f32; 2],
    /// Radians by which it is turned around the origin: counter-clockwise as one sees it with v
    /// downwards, so that the image on a surface turns clockwise.
    pub rotation: f32,
    /// Factors along u and v.
    pub scale: [f32; 2],
}

impl UvTransform {
    /// Changes nothing.
    pub const IDENTITY: Self = Self { offset: [0.0; 2], rotation: 0.0, scale: [1.0; 2] };

    /// Where a texture coordinate points.
    ///
    /// The listing in early versions of the extension turns the other way than its words and its
    /// example; implementations follow the latter (KhronosGroup/glTF, issue 1563).
    pub fn apply(&self, uv: Vec2) -> Vec2 {
        let (s, c) = real::sin_cos(self.rotation);
        let scaled = uv * Vec2::from_array(self.scale);
        let turned = Vec2::new(c * scaled.x + s * scaled.y, c * scaled.y - s * scaled.x);
        turned + Vec2::from_array(self.offset)
    }
}

/// A texture as a material uses it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureRef {
    /// The number of the texture in [`Document::textures`](super::Document::textures).
    pub texture: usize,
    /// Which texture coordinates: `TEXCOORD_n`. A mesh may lack them.
    pub set: u32,
    /// What is done to them.
    pub transform: UvTransform,
}

/// Images of a document. What has bytes takes them along.
pub(super) fn images(root: &Entry<'_, '_>, accessors: &mut Accessors<'_>) -> Result<Vec<Image>> {
    let mut by_view: HashMap<usize, Arc<Vec<u8>>> = HashMap::new();
    root.each("images", |entry| {
        let name = entry.name()?;
        let mime = entry.text_or_empty("mimeType")?;
        let view = entry.index_of("bufferView", "buffer view", accessors.store.views())?;
        let (bytes, kind) = match (entry.get("uri")?, view) {
            (Some(uri), None) => {
                match uri::understand(uri.text()?).map_err(|what| uri.wrong(what))? {
                    Meant::Bytes(bytes, media) => (ImageBytes::Here(Arc::new(bytes)), media),
                    Meant::File(file) => {
                        let plain = uri::file_name(file).unwrap_or_default();
                        let ending = plain.rsplit('.').next().unwrap_or_default();
                        let media = format!("image/{}", ending.to_ascii_lowercase());
                        (ImageBytes::File(file.to_owned()), media)
                    }
                }
            }
            (None, Some(view)) => {
                let bytes = match by_view.get(&view) {
                    Some(known) => known.clone(),
                    None => {
                        accessors.store.budget.take(accessors.store.length(view), 1, entry)?;
                        let bytes = Arc::new(accessors.store.bytes(view, entry)?.to_vec());
                        by_view.insert(view, bytes.clone());
                        bytes
                    }
                };
                (ImageBytes::Here(bytes), String::new())
            }
            (Some(_), Some(_)) => {
                return Err(entry.wrong("has both a \"uri\" and a \"bufferView\""));
            }
            (None, None) => {
                return Err(entry.wrong("has neither a \"uri\" nor a \"bufferView\""));
            }
        };
        // What the bytes are counts, then what is said of them.
        let encoding = match &bytes {
            ImageBytes::Here(bytes) => by_signature(bytes),
            ImageBytes::File(_) => None,
        };
        let encoding = encoding.or_else(|| by_media_type(mime)).or_else(|| by_media_type(&kind));
        Ok(Image { name, encoding, bytes })
    })
}

fn by_signature(bytes: &[u8]) -> Option<Encoding> {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => Some(Encoding::Png),
        [0xff, 0xd8, 0xff, ..] => Some(Encoding::Jpeg),
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => Some(Encoding::WebP),
        _ => None,
    }
}

fn by_media_type(kind: &str) -> Option<Encoding> {
    match kind {
        "image/png" => Some(Encoding::Png),
        "image/jpeg" | "image/jpg" => Some(Encoding::Jpeg),
        "image/webp" => Some(Encoding::WebP),
        _ => None,
    }
}

/// Images of other kinds that a texture may name, by their extension.
const OTHER_IMAGES: [(&str, &str); 3] =
    [("KHR_texture_basisu", "KTX2"), ("MSFT_texture_dds", "DDS"), ("EXT_texture_avif", "AVIF")];

/// Textures of a document with so many images.
pub(super) fn textures(root: &Entry<'_, '_>, images: usize) -> Result<Vec<Texture>> {
    let samplers = root.each("samplers", |entry| {
        let nearest = match entry.get("magFilter")? {
            None => false,
            Some(filter) => match filter.whole(u64::from(u32::MAX))? {
                9728 => true,
                9729 => false,
                other => {
                    return Err(filter.wrong(format_args!(
                        "is {other}, but must be 9728 (nearest) or 9729 (linear)"
                    )));
                }
            },
        };
        let filter = if nearest { Filter::Nearest } else { Filter::Linear };
        Ok(([wrap(entry, "wrapS")?, wrap(entry, "wrapT")?], filter))
    })?;
    root.each("textures", |entry| {
        let name = entry.name()?;
        let sampler = entry.index_of("sampler", "sampler", samplers.len())?;
        let (wrap, filter) = sampler.map(|i| samplers[i]).unwrap_or_default();
        let webp = entry.extension("EXT_texture_webp")?;
        let image = match webp {
            Some(webp) => Some(webp.need("source")?.index("image", images)?),
            None => entry.index_of("source", "image", images)?,
        };
        let mut other = None;
        for (extension, kind) in OTHER_IMAGES {
            if entry.extension(extension)?.is_some() {
                other = other.or(Some((extension, kind)));
            }
        }
        match (image, other) {
            (Some(image), other) => {
                if let Some((_, kind)) = other {
                    entry.notes.add("textures read from the image they fall back to", || {
                        format!("{}, which has a {kind} image as well", entry.place)
                    });
                }
                Ok(Texture { name, image, wrap, filter })
            }
            (None, Some((extension, kind))) => Err(unsupported(
                entry,
                format_args!(
                    "has only a {kind} image ({extension}), which is not read; PNG, JPEG and \
                     WebP are"
                ),
            )),
            (None, None) => Err(entry.wrong("has no \"source\"")),
        }
    })
}

fn wrap(sampler: &Entry<'_, '_>, key: &str) -> Result<Wrap> {
    let Some(entry) = sampler.get(key)? else { return Ok(Wrap::Repeat) };
    match entry.whole(u64::from(u32::MAX))? {
        10497 => Ok(Wrap::Repeat),
        33648 => Ok(Wrap::Mirror),
        33071 => Ok(Wrap::Clamp),
        other => Err(entry.wrong(format_args!(
            "is {other}, but must be 10497 (repeat), 33648 (mirrored) or 33071 (clamped)"
        ))),
    }
}

/// The texture that a key of a material names, among so many; and what else stands with it.
pub(super) fn texture_ref(
    material: &Entry<'_, '_>,
    key: &str,
    textures: usize,
) -> Result<Option<TextureRef>> {
    let Some(entry) = material.get(key)? else { return Ok(None) };
    let texture = entry.need("index")?.index("texture", textures)?;
    let mut set = set(&entry)?.unwrap_or(0);
    let mut transform = UvTransform::IDENTITY;
    if let Some(change) = entry.extension("KHR_texture_transform")? {
        transform = UvTransform {
            offset: change.numbers_or("offset", [0.0; 2])?,
            rotation: change.number_or("rotation", 0.0)?,
            scale: change.numbers_or("scale", [1.0; 2])?,
        };
        set = self::set(&change)?.unwrap_or(set);
    }
    Ok(Some(TextureRef { texture, set, transform }))
}

fn set(entry: &Entry<'_, '_>) -> Result<Option<u32>> {
    let set = entry.get("texCoord")?.map(|set| set.whole(u64::from(u32::MAX))).transpose()?;
    Ok(set.map(|set| set as u32))
}

/// What stands behind a name with a number, "TEXCOORD_1" for example.
pub(super) fn numbered(name: &str, stem: &str) -> Option<u32> {
    let digits = name.strip_prefix(stem)?;
    let is_plain = digits == "0" || digits.bytes().next().is_some_and(|b| b != b'0');
    (is_plain && digits.bytes().all(|b| b.is_ascii_digit())).then(|| digits.parse().ok())?
}
