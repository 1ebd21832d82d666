//! Cryptomatte: mattes of everything that has a name, found again by the name's hash.
//!
//! Each pixel lists the ids of what is seen in it and how much of the pixel
//! each covers, the largest first. An id is a hash of a name, read as a number
//! of 32 bits; the file's header lists names and ids in a manifest. Blender,
//! Nuke, Fusion and Houdini read it. How it is made here:
//!
//! - Channels `CryptoObject00.R`, `.G`, `.B`, `.A`, `CryptoObject01.R` and so on hold an id, its
//!   coverage, the next id and its coverage. There are six ids for each pixel, and more where a
//!   pixel of the picture sees more, so that none is lost.
//! - Where nothing is seen the id is 0, which is no hash of any name. Its coverage counts as that of
//!   a thing does, so that the coverages of each pixel add up to 1.
//! - A coverage is a share of samples. They lie as the pixel's filter says (its absolute value, where
//!   it has negative lobes), so no coverage is negative.
//! - Things of one name are one thing.
//!
//! Source: Friedman and Jones, "Fully Automatic ID Mattes with Support for
//! Motion Blur and Transparency", SIGGRAPH 2015 posters; *Cryptomatte
//! Specification*, version 1.2.0, Psyop 2018; Appleby, MurmurHash3, 2011.

use crate::scene::Scene;
use crate::shape::Shape;
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::sync::Arc;

/// The layers: their names, in the order in which they are kept.
pub const NAMES: [&str; 3] = ["CryptoObject", "CryptoMaterial", "CryptoAsset"];

/// What an EXR file's header has to say for its Cryptomatte layers to be read, as names and texts.
/// All characters are ASCII.
pub fn metadata(scene: &Scene) -> Vec<(String, String)> {
    let objects = || (0..scene.objects.len()).map(|i| object_name(scene, i));
    let materials = (0..scene.materials.len()).map(|i| material_name(scene, i));
    let manifests = [
        manifest(objects()),
        manifest(materials),
        manifest(objects().map(|name| Cow::Owned(asset_of(&name).to_owned()))),
    ];
    let of_layer = |(layer, manifest): (&str, String)| {
        let key = hex(id(layer));
        let said =
            |what: &str, text: &str| (format!("cryptomatte/{}/{what}", &key[..7]), text.to_owned());
        [
            said("name", layer),
            said("hash", "MurmurHash3_32"),
            said("conversion", "uint32_to_float32"),
            said("manifest", &manifest),
        ]
    };
    NAMES.into_iter().zip(manifests).flat_map(of_layer).collect()
}

/// What mattes call object number `index` of a scene: its own name, or else its mesh's, or else
/// "object 1" for the first, and so on.
pub fn object_name(scene: &Scene, index: usize) -> Cow<'_, str> {
    let object = &scene.objects[index];
    let of_mesh = || match object.shape {
        Shape::Mesh(id) => scene.meshes.get(id.0 as usize).map_or("", |mesh| &*mesh.name),
        Shape::Sphere { .. }
        | Shape::Rectangle { .. }
        | Shape::Disk { .. }
        | Shape::Box { .. }
        | Shape::Custom(_) => "",
    };
    let name = if object.name.is_empty() { of_mesh() } else { &*object.name };
    if name.is_empty() { format!("object {}", index + 1).into() } else { name.into() }
}

/// What mattes call material number `index` of a scene: its name, or "material 1" for the first,
/// and so on.
pub fn material_name(scene: &Scene, index: usize) -> Cow<'_, str> {
    match &*scene.materials[index].name {
        "" => format!("material {}", index + 1).into(),
        name => name.into(),
    }
}

/// The asset that an object of this name belongs to: what comes before the first slash, as "house"
/// is in "house/roof".
pub fn asset_of(object_name: &str) -> &str {
    match object_name.split_once('/') {
        Some((asset, _)) if !asset.is_empty() => asset,
        _ => object_name,
    }
}

/// A name's id, as the bits of a number in single precision that is neither 0 nor tiny, infinite or
/// no number.
pub fn id(name: &str) -> u32 {
    let hash = murmur3(name.as_bytes());
    // "Floating point conversion" in the specification: exponents of all zeros and all ones are
    // avoided by turning the lowest bit of the exponent.
    match hash >> 23 & 0xff {
        0 | 0xff => hash ^ (1 << 23),
        _ => hash,
    }
}

/// `MurmurHash3_x86_32` with seed 0.
fn murmur3(bytes: &[u8]) -> u32 {
    let mixed =
        |word: u32| word.wrapping_mul(0xcc9e_2d51).rotate_left(15).wrapping_mul(0x1b87_3593);
    let (words, rest) = bytes.as_chunks::<4>();
    let mut hash = words.iter().fold(0_u32, |hash, &word| {
        let hash = (hash ^ mixed(u32::from_le_bytes(word))).rotate_left(13);
        hash.wrapping_mul(5).wrapping_add(0xe654_6b64)
    });
    let mut last = [0; 4];
    last[..rest.len()].copy_from_slice(rest);
    hash ^= mixed(u32::from_le_bytes(last));
    hash ^= bytes.len() as u32;
    hash = (hash ^ hash >> 16).wrapping_mul(0x85eb_ca6b);
    hash = (hash ^ hash >> 13).wrapping_mul(0xc2b2_ae35);
    hash ^ hash >> 16
}

fn hex(id: u32) -> String {
    format!("{id:08x}")
}

/// Names and their ids as an object of JSON, in the order of the names.
fn manifest<'s>(names: impl Iterator<Item = Cow<'s, str>>) -> String {
    let sorted: BTreeSet<_> = names.collect();
    let mut text = String::from("{");
    for (i, name) in sorted.iter().enumerate() {
        text.push_str(if i > 0 { ",\"" } else { "\"" });
        for unit in name.encode_utf16() {
            match u8::try_from(unit) {
                Ok(byte @ (b'"' | b'\\')) => text.extend(['\\', byte.into()]),
                Ok(byte @ b' '..=b'~') => text.push(byte.into()),
                // Nothing but ASCII fits every reader of headers.
                Ok(_) | Err(_) => text.push_str(&format!("\\u{unit:04x}")),
            }
        }
        text.push_str(&format!("\":\"{}\"", hex(id(name))));
    }
    text + "}"
}

/// The ids of all objects and materials of a scene.
#[derive(Clone, Debug, Default)]
pub(crate) struct Ids {
    objects: Arc<[u32]>,
    assets: Arc<[u32]>,
    materials: Arc<[u32]>,
    /// The number of each object's material.
    material_of_object: Arc<[u32]>,
}

impl Ids {
    pub(crate) fn new(scene: &Scene) -> Self {
        let objects = (0..scene.objects.len()).map(|i| {
            let name = object_name(scene, i);
            (id(&name), id(asset_of(&name)))
        });
        let (objects, assets): (Vec<_>, Vec<_>) = objects.unzip();
        Self {
            objects: objects.into(),
            assets: assets.into(),
            materials: (0..scene.materials.len()).map(|i| id(&material_name(scene, i))).collect(),
            material_of_object: scene.objects.iter().map(|object| object.material.0).collect(),
        }
    }

    /// The ids that object number `object` has in the layers of [`NAMES`].
    pub(crate) fn of(&self, object: u32) -> [u32; 3] {
        let material = self.material_of(object);
        [
            self.objects[object as usize],
            self.materials[material as usize],
            self.assets[object as usize],
        ]
    }

    /// The number of the material of object number `object`.
    pub(crate) fn material_of(&self, object: u32) -> u32 {
        self.material_of_object[object as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of others: the test vectors of MurmurHash3 that its users share.
    #[test]
    fn the_hash_is_murmurs() {
        for (text, hash) in [
            ("", 0),
            ("test", 0xba6b_d213),
            ("Hello, world!", 0xc036_3e43),
            ("The quick brown fox jumps over the lazy dog", 0x2e4f_f723),
        ] {
            assert_eq!(murmur3(text.as_bytes()), hash, "{text}");
        }
    }

    /// What another implementation of the hash says, and the keys that layers of these names have
    /// in the files of other renderers.
    #[test]
    fn ids_are_those_of_the_specification() {
        assert_eq!(id("hello"), 0x248b_fa47);
        assert_eq!(id("ü"), 0x7840_e6aa);
        let keys = NAMES.map(|name| hex(id(name))[..7].to_owned());
        assert_eq!(keys, ["3ae39a5", "be359d6", "f42029d"]);
    }

    /// No id is 0, subnormal, infinite or NaN: comparing such numbers would fail, and 0 is nothing.
    #[test]
    fn ids_are_plain_numbers() {
        for i in 0..100_000 {
            assert!(f32::from_bits(id(&i.to_string())).is_normal(), "{i}");
        }
    }

    /// A manifest is JSON whatever a name holds, and ASCII.
    #[test]
    fn manifests_quote_what_must_be() {
        let names = ["b", "a\"\\\n", "ü", "𝄞", "b"].map(Cow::Borrowed);
        let text = manifest(names.into_iter());
        let id = |name| hex(id(name));
        let expected = format!(
            r#"{{"a\"\\\u000a":"{}","b":"{}","\u00fc":"{}","\ud834\udd1e":"{}"}}"#,
            id("a\"\\\n"),
            id("b"),
            id("ü"),
            id("𝄞"),
        );
        assert_eq!(text, expected);
        assert!(text.is_ascii());
        assert_eq!(manifest(std::iter::empty()), "{}");
    }

    #[test]
    fn assets_are_first_parts_of_paths() {
        for (name, asset) in [("house/roof/tile", "house"), ("house", "house"), ("/a", "/a")] {
            assert_eq!(asset_of(name), asset);
        }
    }
}
