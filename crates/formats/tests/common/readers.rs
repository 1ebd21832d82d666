//! Every reader of untrusted bytes, and what must hold for whatever it is given: a sound value,
//! or an error of one line. Never a panic.
//!
//! Tests, the `mutate` example and the fuzz targets all hold the readers to this.

use rutilant::camera::Perspective;
use rutilant::geom::Vec3;
use rutilant::scene::Scene;
use rutilant::settings::Settings;
use rutilant::shape::Mesh;
use rutilant::texture::{Bitmap, Texture};
use rutilant::{Prepared, Session};
use rutilant_formats::scene::gltf::{self, Moment};
use rutilant_formats::scene::mitsuba::serialized;
use rutilant_formats::scene::{mtl, obj, ply, stl};
use rutilant_formats::{
    Limits, LoadedScene, ReadOptions, SceneError, image, parse_mitsuba, parse_native, parse_pbrt,
};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// A reader, by the name of its folder in `fuzz/corpus`.
#[derive(Clone, Copy)]
pub(crate) struct Reader {
    pub(crate) name: &'static str,
    /// Reads, and says whether there was something sound to read; panics where a promise is broken.
    pub(crate) check: fn(&[u8]) -> bool,
    /// Words that matter to the format, to be put where they hurt; a fuzzer finds its own.
    #[allow(dead_code, reason = "fuzz targets do not use them")]
    pub(crate) words: &'static [&'static [u8]],
}

/// All of them.
pub(crate) const READERS: &[Reader] = &[
    Reader { name: "native", check: native, words: NATIVE_WORDS },
    Reader { name: "obj", check: obj, words: OBJ_WORDS },
    Reader { name: "mtl", check: mtl, words: MTL_WORDS },
    Reader { name: "ply", check: ply, words: PLY_WORDS },
    Reader { name: "gltf", check: gltf, words: GLTF_WORDS },
    Reader { name: "pbrt", check: pbrt, words: PBRT_WORDS },
    Reader { name: "mitsuba", check: mitsuba, words: MITSUBA_WORDS },
    Reader {
        name: "serialized",
        check: serialized,
        words: &[b"\x1c\x04\x03\0", b"\x1c\x04\x04\0", b"\x78\xda"],
    },
    Reader { name: "stl", check: stl, words: STL_WORDS },
    Reader { name: "exr", check: |bytes| image(bytes, "a.exr"), words: &[] },
    Reader { name: "hdr", check: |bytes| image(bytes, "a.hdr"), words: &[] },
    Reader { name: "pfm", check: |bytes| image(bytes, "a.pfm"), words: &[] },
    Reader {
        name: "png",
        check: |bytes| image(bytes, "a.png"),
        words: &[b"zTXt", b"PLTE", b"tRNS"],
    },
    Reader {
        name: "jpeg",
        check: |bytes| image(bytes, "a.jpg"),
        words: &[b"\xff\xda", b"\xff\xd9"],
    },
    Reader { name: "tga", check: |bytes| image(bytes, "a.tga"), words: &[] },
    Reader { name: "scene_render", check: scene_render, words: NATIVE_WORDS },
];

/// Pieces that matter to TOML, or to the scenes written in it.
const NATIVE_WORDS: &[&[u8]] = &[
    b"[",
    b"]",
    b"[[",
    b"]]",
    b"{",
    b"}",
    b"\"",
    b"\"\"\"",
    b"'",
    b"=",
    b".",
    b",",
    b"0x",
    b"true",
    "\u{e9}".as_bytes(),
    "\u{feff}".as_bytes(),
    b"1979-05-27T07:32:00Z",
    b"[shape]\n",
    b"[[shape]]\n",
    b"[[light]]\n",
    b"type = ",
    b"\"mesh\"",
    b"\"\"",
    b"size = 0\n",
    b"[material.emission]\n",
    b"version",
    b"1e38",
    b"1e-45",
    b"1e-20",
    b"1e7",
    b"-1e7",
    b"radius",
    b"scale",
    b"max_depth = 1\n",
    b"\"dielectric\"",
    b"\"mix\"",
    b"\"depth\"",
];
const OBJ_WORDS: &[&[u8]] = &[
    b"f ",
    b"v ",
    b"vt ",
    b"vn ",
    b"usemtl ",
    b"mtllib ",
    b"-2",
    b"1/1/1",
    b"1//1",
    b"\nf 1 1 1\n",
    b"\xef\xbb\xbf",
];
const MTL_WORDS: &[&[u8]] = &[
    b"newmtl ",
    b"Kd ",
    b"Ks ",
    b"Ke ",
    b"Tf ",
    b"Ni ",
    b"d ",
    b"Tr ",
    b"illum ",
    b"Pr ",
    b"Pm ",
    b"map_Kd ",
    b"map_Tr a.png\n",
    b"map_Ks a.png\nKs 0.5\nNs 9\n",
    b"bump -bm -2 a.png\n",
    b"map_Kd -s 2 3 -o 1 -clamp on a.png\n",
    b"-halo ",
    b"spectral ",
    b"xyz ",
    b"1e-40",
    b"3e38",
];
const PLY_WORDS: &[&[u8]] = &[
    b"list ",
    b"property ",
    b"element ",
    b"vertex ",
    b"face ",
    b"tristrips ",
    b"uchar ",
    b"double ",
    b"char ",
    b"end_header\n",
    b"vertex_indices\n",
];

/// Pieces that matter to JSON, to the documents written in it, and to binary ones.
const GLTF_WORDS: &[&[u8]] = &[
    b"{",
    b"}",
    b"[",
    b"]",
    b",",
    b":",
    b"\"",
    b"\\u0000",
    b"null",
    b"true",
    b"{}",
    b"[]",
    b"1e38",
    b"-1e38",
    b"1e-45",
    b"0.5",
    b"16",
    b"255",
    b"9007199254740991",
    b"\"count\":",
    b"\"byteStride\":",
    b"\"byteOffset\":",
    b"\"sparse\":{}",
    b"\"normalized\":true,",
    b"\"mode\":6,",
    b"\"children\":[0],",
    b"5121",
    b"5123",
    b"5125",
    b"5126",
    b"MAT4",
    b"VEC4",
    b"SCALAR",
    b"data:,",
    b"\xa1",
    b"\xe1",
    b"JSON",
    b"BIN\0",
];

const PBRT_WORDS: &[&[u8]] = &[
    b"[",
    b"]",
    b"\"",
    b"AttributeBegin\n",
    b"AttributeEnd\n",
    b"ObjectBegin \"thing\"\n",
    b"ObjectEnd\n",
    b"ObjectInstance \"thing\"\n",
    b"Include \"scene.pbrt\"\n",
    b"ReverseOrientation\n",
    b"WorldBegin\n",
    b"WorldEnd\n",
    b"Scale 0 1 1\n",
    b"Scale 1e30 1e30 1e30\n",
    b"Identity\n",
    b"Material \"mix\"",
    b"\"texture reflectance\" \"dark\"",
    b"\"spectrum L\" ",
    b"\"blackbody L\" 1e-30",
    b"\"string materials\" [ \"both\" \"cut\" ]",
    b"\"float alpha\" ",
    b"\"integer indices\" [ 0 1 2 ]",
    b"\"float scale\" -1",
    b"1e38",
    b"-1e38",
    b"1e-45",
    b"2147483647",
    b"true",
];

/// Pieces that matter to XML, or to the scenes written in it.
const MITSUBA_WORDS: &[&[u8]] = &[
    b"<",
    b">",
    b"/>",
    b"\"",
    b"=",
    b"&amp;",
    b"&#x10ffff;",
    b"&e;",
    b"<!--",
    b"-->",
    b"<![CDATA[",
    b"<!DOCTYPE a>",
    b"<?xml version=\"1.0\"?>",
    b"$res",
    b"$",
    b"1e38",
    b"-1e38",
    b"1e-45",
    b"400:1, 700:2",
    b"#ff8000",
    b"<ref id=\"grey\"/>",
    b"<ref id=\"painted\"/>",
    b"<include filename=\"a.obj\"/>",
    b"<shape type=\"sphere\"/>",
    b"<bsdf type=\"twosided\">",
    b"<bsdf type=\"dielectric\"/>",
    b"<texture type=\"checkerboard\"/>",
    b"<emitter type=\"area\"/>",
    b"<emitter type=\"constant\"/>",
    b"<float name=\"scale\" value=\"0\"/>",
    b"<integer name=\"shape_index\" value=\"1\"/>",
    b"<boolean name=\"flip_normals\" value=\"true\"/>",
    b"<scale value=\"0\"/>",
    b"<rotate x=\"1\" angle=\"33\"/>",
    b"name=\"interior\"",
    b"version=\"0.6.0\"",
    b"instance",
    b"shapegroup",
    b"roughdielectric",
    b"principled",
    b"cylinder",
];
const STL_WORDS: &[&[u8]] = &[
    b"solid",
    b"facet normal",
    b"outer loop",
    b"vertex ",
    b"endloop",
    b"endfacet",
    b"endsolid",
    b"\0\0\0\0\0\0",
];

/// An error of one line that is no page: nothing was read.
fn refused(error: &dyn std::error::Error) -> bool {
    let text = error.to_string();
    assert!(!text.contains(['\n', '\r']), "several lines: {text:?}");
    assert!(text.len() < 1000, "{} bytes", text.len());
    assert!(!text.contains("stumbled"), "the last net caught a panic of a decoder");
    false
}

fn checked_notes(notes: &[String]) {
    assert!(
        notes.iter().all(|note| !note.contains(['\n', '\r']) && note.len() < 2000),
        "{notes:?}"
    );
}

fn checked_mesh(mesh: &Mesh) {
    let count = mesh.positions.len();
    assert!(mesh.triangles.iter().flatten().all(|&v| (v as usize) < count));
    assert!(mesh.normals.is_empty() || mesh.normals.len() == count);
    assert!(mesh.uvs.is_empty() || mesh.uvs.len() == count);
}

/// The scenes name this sky, and a folder that does not exist: nothing of the disk is read.
const SKY: &[u8] = b"#?RADIANCE\n\n-Y 1 +X 2\n\x80\x80\x80\x81\x20\x40\x60\x84";

fn options() -> ReadOptions<'static> {
    ReadOptions { embedded: &[("sky.hdr", SKY)], ..ReadOptions::default() }
}

/// The files that Mitsuba's scenes name as well.
const MITSUBA_FILES: &[(&str, &[u8])] = &[
    ("sky.hdr", SKY),
    ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n"),
    ("a.ply", include_bytes!("../../../../fuzz/corpus/ply/little.ply")),
    ("a.serialized", include_bytes!("../../../../fuzz/corpus/serialized/v4.serialized")),
];

/// A scene that was read is one that can be rendered.
fn checked_scene(read: &Result<LoadedScene, SceneError>) -> bool {
    match read {
        Ok(loaded) => {
            checked_notes(&loaded.notes);
            loaded.scene.meshes.iter().for_each(checked_mesh);
            loaded.scene.validate().unwrap_or_else(|problem| panic!("{problem}"));
            loaded.settings.validate().unwrap_or_else(|problem| panic!("{problem}"));
            true
        }
        Err(error) => refused(error),
    }
}

fn mitsuba(bytes: &[u8]) -> bool {
    let options = ReadOptions { embedded: MITSUBA_FILES, ..ReadOptions::default() };
    checked_scene(&parse_mitsuba(bytes.to_vec(), Path::new("nowhere/scene.xml"), &options))
}

fn serialized(bytes: &[u8]) -> bool {
    let (path, limits) = (Path::new("a.serialized"), Limits::default());
    let count = match serialized::count(bytes, path) {
        Ok(count) => count,
        Err(error) => return refused(&error),
    };
    let mut read = true;
    for number in (0..count.min(4)).chain([count, u32::MAX]) {
        match serialized::read_bytes(bytes, number, path, &limits) {
            Ok(mesh) => checked_mesh(&mesh),
            Err(error) => read &= refused(&error) || number >= count,
        }
    }
    read
}

fn stl(bytes: &[u8]) -> bool {
    match stl::read_bytes(bytes, Path::new("a.stl"), &Limits::default()) {
        Ok((mesh, notes)) => {
            checked_notes(&notes);
            checked_mesh(&mesh);
            true
        }
        Err(error) => refused(&error),
    }
}

fn native(bytes: &[u8]) -> bool {
    let text = String::from_utf8_lossy(bytes);
    checked_scene(&parse_native(&text, Path::new("nowhere/scene.toml"), &options()))
}

fn obj(bytes: &[u8]) -> bool {
    match obj::read_bytes(bytes, Path::new("a.obj"), &Limits::default()) {
        Ok(scene) => {
            checked_notes(&scene.notes);
            scene.meshes.iter().for_each(|(mesh, _)| checked_mesh(mesh));
            true
        }
        Err(error) => refused(&error),
    }
}

fn mtl(bytes: &[u8]) -> bool {
    match mtl::read_bytes(bytes, Path::new("a.mtl")) {
        Ok(library) => {
            checked_notes(&library.notes);
            let camera = Perspective::look_at(Vec3::Z, Vec3::ZERO, 1.0).expect("a view");
            let mut scene = Scene::new(camera);
            scene.materials = library.materials;
            let solid = || Arc::new(Bitmap::solid([0; 4]));
            scene.bitmaps = library.pictures.iter().map(|_| solid()).collect();
            scene.textures = library.textures.into_iter().map(Texture::from).collect();
            scene.validate().unwrap_or_else(|problem| panic!("{problem}"));
            true
        }
        Err(error) => refused(&error),
    }
}

fn ply(bytes: &[u8]) -> bool {
    match ply::read_bytes(bytes, Path::new("a.ply"), &Limits::default()) {
        Ok((mesh, notes)) => {
            checked_notes(&notes);
            checked_mesh(&mesh);
            true
        }
        Err(error) => refused(&error),
    }
}

/// More vertices than that are not bent: a document may place the same mesh many times.
const MOST_BENT: usize = 100_000;

fn gltf(bytes: &[u8]) -> bool {
    let document = match gltf::read_bytes(bytes, Path::new("nowhere/a.gltf"), &options()) {
        Ok(document) => document,
        Err(error) => return refused(&error),
    };
    checked_notes(&document.notes);
    let mut bent = 0;
    for moment in [None, Some(0.0), Some(0.3), Some(1e9)] {
        let pose = document.pose(moment.map(|seconds| Moment { animation: 0, seconds }));
        let placed = match document.placed(None, &pose) {
            Ok(placed) => placed,
            Err(error) => {
                refused(&error);
                continue;
            }
        };
        for placed in placed {
            let mesh = placed.mesh.map(|mesh| &document.meshes[mesh]);
            for primitive in mesh.iter().flat_map(|mesh| &mesh.primitives) {
                let count = primitive.positions.len();
                assert!(primitive.triangles.iter().flatten().all(|&v| (v as usize) < count));
                assert!(primitive.uvs.values().all(|uvs| uvs.len() == count));
                assert!(primitive.colors.values().all(|colors| colors.len() == count));
                let material = document.material(primitive, Some(0));
                assert!(material.is_none_or(|material| material < document.materials.len()));
                bent += count;
                if bent > MOST_BENT {
                    return true;
                }
                let bent = document.bent(&pose, placed.node, primitive);
                assert_eq!(bent.positions.len(), count);
                assert!(bent.normals.is_none_or(|normals| normals.len() == count));
                assert!(bent.tangents.is_none_or(|tangents| tangents.len() == count));
            }
        }
    }
    true
}

fn pbrt(bytes: &[u8]) -> bool {
    checked_scene(&parse_pbrt(bytes.to_owned(), Path::new("nowhere/scene.pbrt"), &options()))
}

fn image(bytes: &[u8], name: &str) -> bool {
    match image::read_bytes(bytes, Path::new(name), &Limits::default()) {
        Ok(image) => {
            let pixels = image.width() as usize * image.height() as usize;
            assert!(pixels > 0 && image.channels().iter().all(|c| c.values.len() == pixels));
            true
        }
        Err(error) => refused(&error),
    }
}

/// From text to a picture of 8x8 pixels, everything limited: all of the renderer behind the
/// reader. Whatever the scene, the picture is finite.
fn scene_render(bytes: &[u8]) -> bool {
    let limits = Limits {
        vertices: 1000,
        triangles: 1000,
        objects: 200,
        pixels: 1 << 12,
        ..Limits::default()
    };
    let text = String::from_utf8_lossy(bytes);
    let options = ReadOptions { limits, ..options() };
    let Ok(loaded) = parse_native(&text, Path::new("nowhere/scene.toml"), &options) else {
        return false;
    };
    let prepared = match Prepared::new(&loaded.scene) {
        Ok(prepared) => Arc::new(prepared),
        Err(problem) => panic!("what validates can be prepared, but {problem}"),
    };
    let max_depth = loaded.settings.max_depth.unwrap_or(u32::MAX).min(8);
    let settings = Settings {
        size: [8, 8],
        crop: None,
        spp: 1,
        max_depth: Some(max_depth),
        ..loaded.settings
    };
    let session = Session::start(prepared, settings, 1).unwrap_or_else(|e| panic!("{e}"));
    // Longer than any such picture takes: whoever calls has a clock of their own.
    assert!(session.wait(Duration::from_secs(60)), "no end");
    let progress = session.progress();
    assert_eq!(progress.samples, 1, "the rendering ended by itself");
    let image = session.snapshot();
    assert!(image.channels().iter().all(|c| c.values.iter().all(|v| v.is_finite())));
    true
}
