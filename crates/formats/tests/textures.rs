//! Pictures on surfaces: from files of all kinds to textures, and what stands in for those that
//! cannot be read.

use image::{ExtendedColorType, ImageEncoder};
use rutilant::color::Rgb;
use rutilant::material::{Bumps, MaterialKind, Matte, Opacity, OpacityMode};
use rutilant::scene::{BitmapId, Scene, TextureId};
use rutilant::texture::{
    Bitmap, Bricks, Channel, Checker, ColorInput, Encoding, ImageTexture, Interpolation, Noise,
    ScalarInput, Texels, Texture, UvMapping, Wrap,
};
use rutilant_formats::image::{Pixels, WriteOptions, write};
use rutilant_formats::{Limits, LoadedScene, ReadOptions, read_scene};
use rutilant_geom::Vec2;
use std::fs;
use std::path::Path;

const HEAD: &str = "version = 1\n[camera]\nposition = [0, 0, 3]\nlook_at = [0, 0, 0]\n";

fn load(folder: &Path, text: &str, options: &ReadOptions<'_>) -> Result<LoadedScene, String> {
    let file = folder.join("scene.toml");
    fs::write(&file, format!("{HEAD}{text}")).expect("a scene");
    let short = |text: String| text.replace(&format!("{}/", folder.display()), "");
    match read_scene(&file, options) {
        Ok(mut loaded) => {
            loaded.notes = loaded.notes.into_iter().map(short).collect();
            Ok(loaded)
        }
        Err(error) => Err(short(error.to_string())),
    }
}

fn matte(scene: &Scene, number: usize) -> &Matte {
    match &scene.materials[number].kind {
        MaterialKind::Matte(matte) => matte,
        other => panic!("{other:?}"),
    }
}

/// A PNG of 2x1 texels.
fn png(path: &Path, color: ExtendedColorType, samples: &[u8]) {
    let mut bytes = Vec::new();
    let encoder = image::codecs::png::PngEncoder::new(&mut bytes);
    encoder.write_image(samples, 2, 1, color).expect("encoded");
    fs::write(path, bytes).expect("written");
}

/// Modelling programs write a picture of normals as MTL's heights. It is known by its looks, in a
/// bare file and in a scene; a picture of heights stays one, grey or in colour.
#[test]
fn normals_are_told_from_heights() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = |name: &str| folder.path().join(name);
    fs::write(file("a.obj"), "mtllib a.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
        .unwrap();
    fs::write(file("a.mtl"), "newmtl m\nKd .5\nmap_Bump -bm 0.5 a.png\n").unwrap();
    let scene = "[[shape]]\ntype = \"mesh\"\nfile = \"a.obj\"\n";
    let note = "material \"m\": its bump looks like normals, and is read as such";
    // Of a picture whose rows are a power of two, all of it counts: neither a black margin of one
    // column nor a blue one changes what it is.
    for (inside, margin, shows) in
        [([128, 128, 255], [0; 3], Bumps::Normals), ([90; 3], [128, 128, 255], Bumps::Heights)]
    {
        let texels = (0..512 * 512).flat_map(|i| if i % 512 == 0 { margin } else { inside });
        let mut bytes = Vec::new();
        let encoder = image::codecs::png::PngEncoder::new(&mut bytes);
        let texels: Vec<u8> = texels.collect();
        encoder.write_image(&texels, 512, 512, ExtendedColorType::Rgb8).expect("encoded");
        fs::write(file("a.png"), bytes).expect("written");
        let bare = read_scene(&file("a.obj"), &ReadOptions::default()).expect("a mesh");
        assert_eq!(bare.scene.materials[0].normal_map.expect("bumps").shows, shows);
    }
    for (kind, samples, shows) in [
        (ExtendedColorType::Rgb8, &[128, 128, 255, 118, 138, 254][..], Bumps::Normals),
        (ExtendedColorType::Rgba8, &[128, 128, 255, 255, 160, 100, 248, 255], Bumps::Normals),
        (ExtendedColorType::Rgb8, &[128, 128, 128, 200, 200, 200], Bumps::Heights),
        (ExtendedColorType::Rgb8, &[0, 0, 255, 128, 128, 255], Bumps::Heights),
        (ExtendedColorType::L8, &[128, 255], Bumps::Heights),
    ] {
        png(&file("a.png"), kind, samples);
        let bare = read_scene(&file("a.obj"), &ReadOptions::default()).expect("a mesh");
        let named = load(folder.path(), scene, &ReadOptions::default()).expect("a scene");
        for loaded in [bare, named] {
            let map = loaded.scene.materials[0].normal_map.expect("bumps");
            assert_eq!((map.shows, map.scale), (shows, 0.5), "{samples:?}");
            let told = loaded.notes.iter().any(|n| n.ends_with(note));
            assert_eq!(told, shows == Bumps::Normals, "{:?}", loaded.notes);
        }
    }
}

/// Everything that a table can say arrives, and what it does not say is as documented.
#[test]
fn tables_mean_what_they_say() {
    let folder = tempfile::tempdir().expect("a folder");
    png(&folder.path().join("a.png"), ExtendedColorType::Rgb8, &[1, 2, 3, 4, 5, 6]);
    let text = r#"
[[texture]]
name = "plain"
image = "a.png"
[[texture]]
name = "all"
type = "image"
image = "a.png"
encoding = "linear"
wrap = ["mirror", "clamp"]
interpolation = "nearest"
uv_scale = [2, 3]
uv_rotation_degrees = 90
uv_offset = [0.5, 0.25]
uv_set = 1
[[texture]]
name = "board"
type = "checker"
first = [1, 0, 0]
uv_scale = 4
[[texture]]
name = "wall"
type = "bricks"
second = 0.5
joint = [0.1, 0.2]
shift = 0.25
[[texture]]
name = "clouds"
type = "noise"
octaves = 3
gain = 0.75
[[material]]
name = "a"
type = "matte"
albedo = { texture = "all", factor = 0.5, vertex_colors = true }
[[material]]
name = "b"
type = "matte"
albedo = { image = "a.png" }
opacity = { texture = "all", channel = "red", factor = 0.5, cutoff = 0.25, vertex_colors = true }
"#;
    let loaded = load(folder.path(), text, &ReadOptions::default()).expect("a scene");
    let scene = &loaded.scene;
    assert_eq!(loaded.notes, [""; 0]);
    // The same file is read once.
    let texels = Texels::Eight(vec![1, 2, 3, 4, 5, 6]);
    assert_eq!(scene.bitmaps.len(), 1);
    assert_eq!(*scene.bitmaps[0], Bitmap::new(2, 1, 3, texels).unwrap());
    let plain = ImageTexture::new(BitmapId(0));
    let mapping = UvMapping {
        set: 1,
        scale: Vec2::new(2.0, 3.0),
        rotation: 90.0_f32.to_radians(),
        offset: Vec2::new(0.5, 0.25),
    };
    let all = ImageTexture {
        encoding: Encoding::Linear,
        wrap: [Wrap::Mirror, Wrap::Clamp],
        interpolation: Interpolation::Nearest,
        mapping,
        ..plain
    };
    let mapping = UvMapping { scale: Vec2::splat(4.0), ..UvMapping::default() };
    let (first, second) = (Rgb::new(1.0, 0.0, 0.0), Rgb::grey(0.8));
    let expected = [
        plain.into(),
        all.into(),
        Texture::Checker(Checker { first, second, mapping }),
        Texture::Bricks(Bricks {
            first: Rgb::grey(0.2),
            second: Rgb::grey(0.5),
            joint: Vec2::new(0.1, 0.2),
            shift: 0.25,
            mapping: UvMapping::default(),
        }),
        Texture::Noise(Noise {
            first: Rgb::grey(0.2),
            second: Rgb::grey(0.8),
            octaves: 3,
            gain: 0.75,
            mapping: UvMapping::default(),
        }),
        plain.into(),
    ];
    assert_eq!(scene.textures, expected);
    let input = |factor, texture, vertex_colors| ColorInput {
        factor: Rgb::grey(factor),
        texture: Some(TextureId(texture)),
        vertex_colors,
    };
    assert_eq!(matte(scene, 0).albedo, input(0.5, 1, true));
    assert_eq!(matte(scene, 1).albedo, input(1.0, 5, false));
    let amount = ScalarInput { factor: 0.5, texture: Some((TextureId(1), Channel::Red)) };
    let mode = OpacityMode::Mask { cutoff: 0.25 };
    assert_eq!(scene.materials[1].opacity, Some(Opacity { amount, vertex_colors: true, mode }));
    let identity = folder.path().join("a.png").canonicalize().expect("there");
    assert_eq!(loaded.files, [identity]);
}

/// Codes of 8 and 16 bits stay as they are, of any number of channels; light stays light.
#[test]
fn pictures_keep_their_depth() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    png(&path("l8.png"), ExtendedColorType::L8, &[7, 9]);
    png(&path("la8.png"), ExtendedColorType::La8, &[7, 1, 9, 2]);
    png(&path("rgba8.png"), ExtendedColorType::Rgba8, &[1, 2, 3, 4, 5, 6, 7, 8]);
    let words: Vec<u8> = [300_u16, 65535].iter().flat_map(|w| w.to_ne_bytes()).collect();
    png(&path("l16.png"), ExtendedColorType::L16, &words);
    let mut webp = Vec::new();
    let encoder = image::codecs::webp::WebPEncoder::new_lossless(&mut webp);
    encoder.write_image(&[1, 2, 3, 4, 5, 6], 2, 1, ExtendedColorType::Rgb8).expect("encoded");
    fs::write(path("rgb.webp"), webp).expect("written");
    let light = rutilant::image::Image::from_rgb(2, 1, &[[0.5, 2.0, 0.0], [1.0; 3]]).unwrap();
    for name in ["light.exr", "light.hdr", "light.pfm"] {
        write(&path(name), &light, &WriteOptions::default()).expect("written");
    }
    let (width, height, rgb8) = (2, 1, &[10; 6][..]);
    write(&path("a.jpg"), Pixels::Display { width, height, rgb8 }, &WriteOptions::default())
        .expect("written");
    let eight = |channels, codes: &[u8]| Bitmap::new(2, 1, channels, Texels::Eight(codes.to_vec()));
    let float = Bitmap::new(2, 1, 3, Texels::Float(vec![0.5, 2.0, 0.0, 1.0, 1.0, 1.0]));
    for (name, expected) in [
        ("l8.png", eight(1, &[7, 9])),
        ("la8.png", eight(2, &[7, 1, 9, 2])),
        ("rgba8.png", eight(4, &[1, 2, 3, 4, 5, 6, 7, 8])),
        ("l16.png", Bitmap::new(2, 1, 1, Texels::Sixteen(vec![300, 65535]))),
        ("rgb.webp", eight(3, &[1, 2, 3, 4, 5, 6])),
        ("a.jpg", eight(3, &[10; 6])),
        ("light.exr", float.clone()),
        ("light.hdr", float.clone()),
        ("light.pfm", float),
    ] {
        let text = format!("[[texture]]\nname = \"t\"\nimage = \"{name}\"\n");
        let options = ReadOptions { strict: true, ..ReadOptions::default() };
        let loaded = load(folder.path(), &text, &options).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(*loaded.scene.bitmaps[0], expected.unwrap(), "{name}");
    }
}

/// A picture that is missing, outside or damaged is magenta, and said so; or an error, if asked.
#[test]
fn what_is_missing_is_magenta() {
    let outside = tempfile::tempdir().expect("a folder");
    let folder = outside.path().join("inside");
    fs::create_dir(&folder).expect("a folder");
    png(&outside.path().join("there.png"), ExtendedColorType::L8, &[7, 9]);
    fs::write(folder.join("cut.png"), b"\x89PNG\r\n\x1a\n").expect("a file");
    fs::write(folder.join("text.png"), "hello").expect("a file");
    for (name, what) in [
        ("none.png", "there is no file \"none.png\" beside the scene"),
        (
            "../there.png",
            "\"../there.png\" leads out of the scene's folder; move the file beside the scene, or \
             allow this with --allow-path",
        ),
        ("cut.png", "cut.png: the file ends in its header"),
    ] {
        let text = format!("[[texture]]\nname = \"t\"\nimage = \"{name}\"\n");
        let loaded = load(&folder, &text, &ReadOptions::default()).expect("a scene");
        assert_eq!(*loaded.scene.bitmaps[0], Bitmap::solid([255, 0, 255, 255]));
        assert_eq!(loaded.notes[0], format!("scene.toml:7:9: {what}: magenta stands in"));
        let strict = ReadOptions { strict: true, ..ReadOptions::default() };
        let error = load(&folder, &text, &strict).expect_err(name);
        assert_eq!(error, format!("scene.toml:7:9: {what}"));
    }
    let text = "[[texture]]\nname = \"t\"\nimage = \"text.png\"\n";
    let loaded = load(&folder, text, &ReadOptions::default()).expect("a scene");
    assert!(loaded.notes[0].starts_with("scene.toml:7:9: text.png: "), "{:?}", loaded.notes);
}

/// Mistakes in tables of textures are told with their places.
#[test]
fn mistakes_are_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let material = |albedo: &str| {
        format!(
            "[[texture]]\nname = \"wood\"\ntype = \"checker\"\n[[material]]\nname = \"m\"\n\
             type = \"matte\"\nalbedo = {albedo}\n"
        )
    };
    let texture = |lines: &str| format!("[[texture]]\nname = \"t\"\n{lines}\n");
    for (text, expected) in [
        (
            material("{ texture = \"wod\" }"),
            "scene.toml:11:22: no texture \"wod\"; did you mean \"wood\"?",
        ),
        (
            material("{ texture = \"wood\", image = \"a.png\" }"),
            "scene.toml:11:38: give texture or image, not both",
        ),
        (
            material("{ texture = \"wood\", factor = 2 }"),
            "scene.toml:11:10: albedo is 2, but must lie between 0 and 1",
        ),
        (material("{ fctor = 1 }"), "scene.toml:11:12: no key \"fctor\"; did you mean \"factor\"?"),
        (texture("type = \"image\""), "scene.toml:5:1: an image texture needs \"image\""),
        (
            texture("type = \"cheker\""),
            "scene.toml:7:8: no texture type \"cheker\"; did you mean \"checker\"?",
        ),
        (
            texture("image = \"a.png\"\nwrap = [\"repeat\"]"),
            "scene.toml:8:8: wrap must be a word, or one for u and one for v, not an array with 1 entry",
        ),
        (
            texture("type = \"checker\"\nimage = \"a.png\""),
            "scene.toml:8:1: no key \"image\" in a checker, only in [environment] or an image \
             texture or a textured color or a textured number or a picture of directions or a normal or bump map or opacity or an \
             emissive material or emission",
        ),
        (
            material("0.5\nopacity = 1.5"),
            "scene.toml:12:11: opacity is 1.5, but must lie between 0 and 1",
        ),
        (
            material("0.5\nopacity = { channel = \"red\" }"),
            "scene.toml:12:23: channel needs a texture or an image",
        ),
        (
            material("0.5") + "[[material]]\nname = \"p\"\ntype = \"principled\"\nroughness = {}\n",
            "scene.toml:15:13: a textured number needs \"texture\" or \"image\"",
        ),
        (
            texture("type = \"checker\"\nfirst = -1"),
            "scene.toml:8:9: first is -1, but must lie between 0 and 1e18",
        ),
        (
            texture("type = \"checker\"") + &texture("type = \"checker\""),
            "scene.toml:9:8: there is another texture \"t\"; names must differ",
        ),
    ] {
        let error = load(folder.path(), &text, &ReadOptions::default()).expect_err(&text);
        assert_eq!(error, expected);
    }
}

/// Variants and times belong to glTF files: others say so instead of showing what was not asked for.
#[test]
fn variants_and_times_are_of_documents() {
    let folder = tempfile::tempdir().expect("a folder");
    let red = ReadOptions { variant: Some("red"), ..ReadOptions::default() };
    let error = load(folder.path(), "", &red).expect_err("no variants");
    assert_eq!(error, "scene.toml: no variant \"red\": only glTF files have variants");
    let later = ReadOptions { at_time: Some(2.0), ..ReadOptions::default() };
    let notes = load(folder.path(), "", &later).expect("a scene").notes;
    assert_eq!(notes.len(), 1, "{notes:?}");
    assert!(notes[0].ends_with("scene.toml: nothing in it moves, whatever time is asked for"));
}

/// All pictures together may take so much and no more; each may have so many pixels.
#[test]
fn memory_is_bounded() {
    let folder = tempfile::tempdir().expect("a folder");
    png(&folder.path().join("a.png"), ExtendedColorType::Rgb8, &[1, 2, 3, 4, 5, 6]);
    png(&folder.path().join("b.png"), ExtendedColorType::Rgb8, &[1, 2, 3, 4, 5, 6]);
    let text = "[[texture]]\nname = \"a\"\nimage = \"a.png\"\n\
                [[texture]]\nname = \"b\"\nimage = \"b.png\"\n";
    let limits = Limits { texture_bytes: 11, ..Limits::default() };
    let options = ReadOptions { limits, ..ReadOptions::default() };
    assert_eq!(
        load(folder.path(), text, &options).expect_err("too much"),
        "scene.toml:10:9: 12 bytes of textures, but at most 11 are allowed; allow more with \
         --limit textures=N"
    );
    let limits = Limits { pixels: 1, texture_bytes: 12, ..Limits::default() };
    let options = ReadOptions { limits, ..ReadOptions::default() };
    let notes = load(folder.path(), text, &options).expect("a scene").notes;
    assert!(notes[0].contains("a.png: 2x1 are 2 pixels, but at most 1 are allowed"), "{notes:?}");
}

/// MTL files name their pictures as OBJ exporters do: beside them, in other folders, with the
/// slashes and the paths of other machines, with options.
#[test]
fn material_libraries_bring_pictures() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::create_dir(folder.path().join("maps")).expect("a folder");
    png(&folder.path().join("maps/my wood.png"), ExtendedColorType::L8, &[7, 9]);
    png(&folder.path().join("stone.png"), ExtendedColorType::L8, &[1, 2]);
    let mtl = "newmtl a\nKd .5 .25 1\nmap_Kd maps\\my wood.png\n\
               newmtl b\nmap_Kd -blendu on -s 2 3 -o .5 -clamp on C:\\art\\stone.png\n\
               newmtl c\nKd 0 0 0\nKs .5\nNs 100\nmap_Kd maps/my wood.png\n\
               newmtl d\nmap_Kd none.png\n";
    fs::write(folder.path().join("a.mtl"), mtl).expect("a file");
    let faces: String = ["a", "b", "c", "d"].map(|m| format!("usemtl {m}\nf 1 2 3\n")).concat();
    let obj = format!("mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n{faces}");
    fs::write(folder.path().join("a.obj"), obj).expect("a file");
    let text = "[[texture]]\nname = \"own\"\nimage = \"stone.png\"\n\
                [[material]]\nname = \"mine\"\ntype = \"matte\"\nalbedo = { texture = \"own\" }\n\
                [[shape]]\ntype = \"mesh\"\nfile = \"a.obj\"\n";
    let in_scene = load(folder.path(), text, &ReadOptions::default()).expect("a scene");
    let alone = read_scene(&folder.path().join("a.obj"), &ReadOptions::default()).expect("meshes");
    for (loaded, first) in [(&in_scene, 1), (&alone, 0)] {
        let scene = &loaded.scene;
        let shown = |number: usize| {
            let albedo = matte(scene, first + number).albedo;
            let Some(TextureId(id)) = albedo.texture else { panic!("{number} has no texture") };
            let Texture::Image(image) = scene.textures[id as usize] else { panic!("no image") };
            (albedo.factor, image, scene.bitmaps[image.bitmap.0 as usize].texels().clone())
        };
        let (factor, image, texels) = shown(0);
        assert_eq!(factor, Rgb::new(0.5, 0.25, 1.0));
        assert_eq!(image.mapping, UvMapping::default());
        assert_eq!(texels, Texels::Eight(vec![7, 9]));
        let (factor, image, texels) = shown(1);
        assert_eq!(factor, Rgb::WHITE);
        assert_eq!(image.wrap, [Wrap::Clamp; 2]);
        let mapping = UvMapping {
            scale: Vec2::new(2.0, 3.0),
            offset: Vec2::new(0.5, 0.0),
            ..UvMapping::default()
        };
        assert_eq!((image.mapping, texels), (mapping, Texels::Eight(vec![1, 2])));
        // A gloss over matte is a mix; its parts follow it.
        let (factor, _, texels) = shown(3);
        assert!(factor.0[0] > 0.6, "{factor:?}");
        assert_eq!(texels, Texels::Eight(vec![7, 9]));
        let (_, _, texels) = shown(5);
        assert_eq!(texels, Bitmap::solid([255, 0, 255, 255]).texels().clone());
        let said = |what: &str| loaded.notes.iter().any(|note| note.contains(what));
        assert!(said("a.mtl:6: material \"c\": Kd 0 0 0 is taken as 1 1 1 for its map_Kd"));
        let missing = "a.mtl:12:1: there is no picture \"none.png\" beside the MTL file: magenta";
        assert!(said(missing), "{:?}", loaded.notes);
    }
    // The scene's own texture and the library's show the same picture.
    assert_eq!(in_scene.scene.bitmaps.len(), 3);
}
