//! What documents mean: one truth of the format for each test.

use crate::builder::{Builder, glb, read};
use rutilant_formats::scene::gltf::{
    Alpha, Encoding, Filter, ImageBytes, LightKind, Placement, Primitive, Projection, UvTransform,
    Wrap, read_bytes,
};
use rutilant_formats::{ReadOptions, SceneErrorKind};
use rutilant_geom::{Vec2, Vec3};
use serde_json::json;
use std::fs;

fn first(builder: &Builder) -> Primitive {
    builder.read().meshes[0].primitives[0].clone()
}

/// Text with the bytes in it, one binary file, and text with a file beside it are the same
/// document. In the name of the file a blank may be escaped or not.
#[test]
fn containers_agree() {
    let builder = Builder::triangle();
    let expected = builder.read().meshes;
    assert_eq!(expected[0].primitives[0].positions[1], Vec3::X);
    assert_eq!(*expected[0].primitives[0].triangles, [[0, 1, 2]]);
    assert_eq!(read(&builder.binary()).expect("binary").meshes, expected);
    let bom = [b"\xef\xbb\xbf", builder.text().as_bytes()].concat();
    assert_eq!(read(&bom).expect("with a byte order mark").meshes, expected);

    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.gltf");
    fs::write(folder.path().join("b c%.bin"), &builder.bytes).expect("bytes");
    for name in ["b%20c%25.bin", "b c%.bin", "./b%20c%.bin"] {
        let mut json = builder.json.clone();
        json["buffers"] = json!([{"byteLength": builder.bytes.len(), "uri": name}]);
        let options = ReadOptions::default();
        let document = read_bytes(json.to_string().as_bytes(), &path, &options).expect(name);
        assert_eq!(document.meshes, expected, "{name}");
        assert_eq!(document.files.len(), 1);
    }
}

/// Files stay inside the scene's folder, and are files.
#[test]
fn buffers_stay_beside_the_scene() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::create_dir(folder.path().join("in")).expect("a folder");
    fs::write(folder.path().join("out.bin"), [0; 36]).expect("bytes");
    let path = folder.path().join("in/a.gltf");
    let said = |uri: &str| {
        let mut json = Builder::triangle().json;
        json["buffers"] = json!([{"byteLength": 36, "uri": uri}]);
        let options = ReadOptions::default();
        let result = read_bytes(json.to_string().as_bytes(), &path, &options);
        let text = result.expect_err("refused").to_string();
        text.strip_prefix(&format!("{}: ", path.display())).expect("the file").to_owned()
    };
    let hint = "move the file beside the scene, or allow this with --allow-path";
    for uri in ["../out.bin", "%2e%2e/out.bin", "x/../../out.bin"] {
        assert!(said(uri).ends_with(&format!("leads out of the scene's folder; {hint}")), "{uri}");
    }
    assert_eq!(said("b.bin"), "buffers[0].uri: there is no file \"b.bin\" beside the scene");
    assert_eq!(said("."), "buffers[0].uri: \".\" is a folder, not a file");
    assert_eq!(
        said("https://a/b.bin"),
        "buffers[0].uri names \"https://a/b.bin\", but only files beside the scene and data: URIs \
         are read"
    );
    let mut json = Builder::triangle().json;
    json["buffers"] = json!([{"byteLength": 36, "uri": "../out.bin"}]);
    let options = ReadOptions { allow_outside: true, ..ReadOptions::default() };
    read_bytes(json.to_string().as_bytes(), &path, &options).expect("allowed");
}

/// Section 3.6.2.2 and 3.11: every type of number, as it is and as a part of the largest.
#[test]
fn numbers_of_all_types_are_read() {
    let near = |a: f32, b: f32| (a - b).abs() < 1e-7;
    for (component, bytes, plain, part) in [
        (5120, &[127_u8, 0x81, 0x80][..], [127.0, -127.0, -128.0], [1.0, -1.0, -1.0]),
        (5121, &[255, 51, 0], [255.0, 51.0, 0.0], [1.0, 0.2, 0.0]),
        (5122, &[0xff, 0x7f, 0x00, 0x80, 0, 0], [32767.0, -32768.0, 0.0], [1.0, -1.0, 0.0]),
        (5123, &[0xff, 0xff, 0x33, 0x33, 0, 0], [65535.0, 13107.0, 0.0], [1.0, 0.2, 0.0]),
    ] {
        for (normalized, expected) in [(false, plain), (true, part)] {
            let mut builder = Builder::triangle();
            let three = [bytes, bytes, bytes].concat();
            let position = builder.array("VEC3", component, 3, &three);
            builder.json["accessors"][position]["normalized"] = json!(normalized);
            builder.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(position);
            let read = first(&builder).positions[2].to_array();
            let agrees = read.iter().zip(expected).all(|(a, b)| near(*a, b));
            assert!(agrees, "{component} {normalized}: {read:?}");
        }
    }
}

/// Interleaved vertices, as most engines store them: 12 bytes of position, 8 that are skipped,
/// and one element less than a stride at the end.
#[test]
fn strides_are_followed() {
    let mut builder = Builder::triangle();
    let mut bytes = Vec::new();
    for i in 0..3 {
        for number in [i as f32, 1.0, 2.0, 9.0, 9.0] {
            bytes.extend(number.to_le_bytes());
        }
    }
    bytes.truncate(4 + 2 * 20 + 12);
    bytes.splice(0..0, [7; 4]);
    bytes.truncate(4 + 2 * 20 + 12);
    let view = builder.view(&bytes);
    builder.json["bufferViews"][view]["byteStride"] = json!(20);
    let accessor = json!({"bufferView": view, "byteOffset": 4, "componentType": 5126,
        "type": "VEC3", "count": 3});
    let position = builder.push("accessors", accessor);
    builder.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(position);
    let expected = [0.0, 1.0, 2.0].map(|x| Vec3::new(x, 1.0, 2.0));
    assert_eq!(*first(&builder).positions, expected);
    builder.json["accessors"][position]["byteOffset"] = json!(8);
    assert_eq!(builder.error(), "accessors[1] needs 60 bytes, but bufferViews[1] has only 56");
}

/// Sparse accessors differ from their bytes, or from zeros, in a few elements.
#[test]
fn sparse_accessors_have_exceptions() {
    for base in [false, true] {
        let mut builder = Builder::triangle();
        let indices = builder.view(&[0, 2]);
        let values: Vec<u8> =
            [5.0_f32, 6.0, 7.0, 8.0, 9.0, 10.0].iter().flat_map(|n| n.to_le_bytes()).collect();
        let values = builder.view(&values);
        let accessor = json!({"componentType": 5126, "type": "VEC3", "count": 3, "sparse": {
            "count": 2, "indices": {"bufferView": indices, "componentType": 5121},
            "values": {"bufferView": values}}});
        let position = builder.push("accessors", accessor);
        if base {
            builder.json["accessors"][position]["bufferView"] = json!(0);
        }
        builder.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(position);
        let middle = if base { Vec3::X } else { Vec3::ZERO };
        let expected = [Vec3::new(5.0, 6.0, 7.0), middle, Vec3::new(8.0, 9.0, 10.0)];
        assert_eq!(*first(&builder).positions, expected);

        builder.bytes
            [builder.json["bufferViews"][indices]["byteOffset"].as_u64().unwrap() as usize] = 2;
        assert_eq!(
            builder.error(),
            "meshes[0].primitives[0].attributes.POSITION names an accessor whose sparse index 2 \
             is out of order or not below 3"
        );
    }
}

/// Lists, strips and fans with their winding, with indices and without. A corner that comes
/// twice, by which strips jump, makes no triangle.
#[test]
fn strips_and_fans_are_triangles() {
    let with = |mode: u32, indices: Option<&[u16]>| {
        let mut builder = Builder::triangle();
        let position = builder.floats("VEC3", &[0.5; 18]);
        let primitive = &mut builder.json["meshes"][0]["primitives"][0];
        primitive["attributes"]["POSITION"] = json!(position);
        primitive["mode"] = json!(mode);
        if let Some(indices) = indices {
            let indices = builder.shorts("SCALAR", indices.len(), indices);
            builder.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
        }
        first(&builder).triangles.to_vec()
    };
    assert_eq!(with(4, None), [[0, 1, 2], [3, 4, 5]]);
    assert_eq!(with(4, Some(&[5, 4, 3, 2])), [[5, 4, 3]]);
    // Section 3.7.2.1: every other triangle of a strip is turned, so that all face one way.
    assert_eq!(with(5, None), [[0, 1, 2], [1, 3, 2], [2, 3, 4], [3, 5, 4]]);
    assert_eq!(with(5, Some(&[0, 1, 2, 2, 3, 3, 4, 5])), [[0, 1, 2], [3, 5, 4]]);
    assert_eq!(with(6, None), [[1, 2, 0], [2, 3, 0], [3, 4, 0], [4, 5, 0]]);
    assert_eq!(with(6, Some(&[3, 4, 5])), [[4, 5, 3]]);
    assert_eq!(with(5, Some(&[3, 4])), [[0; 3]; 0]);
}

/// Points and lines beside triangles are left out with a note; alone they are refused.
#[test]
fn points_and_lines_are_left_out() {
    let mut builder = Builder::triangle();
    let lines = json!({"mode": 1, "attributes": {"POSITION": 0}});
    let triangles = builder.json["meshes"][0]["primitives"][0].clone();
    builder.json["meshes"][0]["primitives"] = json!([lines, triangles]);
    let document = builder.read();
    assert_eq!(document.meshes[0].primitives.len(), 1);
    assert_eq!(
        document.notes,
        ["nowhere/a.gltf: points and lines, left out: meshes[0].primitives[0]"]
    );
    builder.json["meshes"][0]["primitives"] = json!([lines]);
    assert_eq!(
        builder.error(),
        "there are only points and lines in it (first meshes[0].primitives[0])"
    );
}

/// All attributes in all their types; colours without alpha are opaque; sets have gaps.
#[test]
fn vertices_have_all_attributes() {
    let mut builder = Builder::triangle();
    let normal = builder.floats("VEC3", &[0.0, 0.0, 1.0].repeat(3));
    let tangent = builder.floats("VEC4", &[1.0, 0.0, 0.0, -1.0].repeat(3));
    let uv = builder.floats("VEC2", &[0.0, 0.25, 0.5, 0.75, 1.0, 1.25]);
    let uv2 = builder.array("VEC2", 5121, 3, &[0, 51, 102, 153, 204, 255]);
    builder.json["accessors"][uv2]["normalized"] = json!(true);
    let rgb = builder.shorts("VEC3", 3, &[65535, 0, 13107].repeat(3));
    let rgba = builder.array("VEC4", 5121, 3, &[255, 0, 51, 102].repeat(3));
    let attributes = json!({"POSITION": 0, "NORMAL": normal, "TANGENT": tangent,
        "TEXCOORD_0": uv, "TEXCOORD_2": uv2, "COLOR_0": rgb, "COLOR_1": rgba, "_MORE": 0,
        "TEXCOORD_01": 0});
    builder.json["meshes"][0]["primitives"][0]["attributes"] = attributes;
    let read = first(&builder);
    assert_eq!(read.normals.as_deref(), Some(&vec![Vec3::Z; 3]));
    assert_eq!(read.tangents.as_deref(), Some(&vec![[1.0, 0.0, 0.0, -1.0]; 3]));
    assert_eq!(read.uvs.keys().copied().collect::<Vec<_>>(), [0, 2]);
    assert_eq!(read.uvs[&0][2], Vec2::new(1.0, 1.25));
    assert_eq!(read.uvs[&2][2], Vec2::new(0.8, 1.0));
    assert_eq!(read.colors[&0][1], [1.0, 0.0, 0.2, 1.0]);
    assert_eq!(read.colors[&1][1], [1.0, 0.0, 0.2, 0.4]);
    assert_eq!(read.material, None);
}

/// Vertices that are no numbers stay: what is wrong with a triangle is found when a scene is
/// prepared, as with all mesh files.
#[test]
fn broken_vertices_are_kept() {
    let mut builder = Builder::triangle();
    builder.bytes[..8].copy_from_slice(&[0, 0, 0xc0, 0x7f, 0, 0, 0x80, 0x7f]);
    let [x, y, z] = first(&builder).positions[0].to_array();
    assert!(x.is_nan() && y == f32::INFINITY && z == 0.0);
}

/// Every factor of every extension arrives in its place. All numbers differ.
#[test]
fn materials_are_kept_whole() {
    let mut builder = Builder::triangle();
    builder.push("images", json!({"uri": "a.png"}));
    for _ in 0..3 {
        builder.push("textures", json!({"source": 0}));
    }
    let texture = json!({"index": 2, "texCoord": 3});
    builder.json["materials"] = json!([{
        "name": "all",
        "pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.2, 0.3, 0.4], "metallicFactor": 0.5,
            "roughnessFactor": 0.6, "baseColorTexture": {"index": 1, "texCoord": 1, "extensions": {
            "KHR_texture_transform": {"offset": [1, 2], "rotation": 3, "scale": [4, 5],
            "texCoord": 6}}}},
        "normalTexture": {"index": 0, "scale": -2},
        "occlusionTexture": {"index": 0, "strength": 0.7},
        "emissiveFactor": [0.8, 0.9, 1],
        "alphaMode": "MASK", "alphaCutoff": 0.25, "doubleSided": true,
        "extensions": {
            "KHR_materials_unlit": {},
            "KHR_materials_emissive_strength": {"emissiveStrength": 11},
            "KHR_materials_ior": {"ior": 1.2},
            "KHR_materials_specular": {"specularFactor": 0.13, "specularColorFactor": [1.4, 0, 1],
                "specularColorTexture": texture},
            "KHR_materials_transmission": {"transmissionFactor": 0.15},
            "KHR_materials_volume": {"thicknessFactor": 16, "attenuationDistance": 17,
                "attenuationColor": [0.18, 0.19, 0.2]},
            "KHR_materials_dispersion": {"dispersion": 0.21},
            "KHR_materials_clearcoat": {"clearcoatFactor": 0.22, "clearcoatRoughnessFactor": 0.23,
                "clearcoatNormalTexture": {"index": 1, "scale": 24}},
            "KHR_materials_sheen": {"sheenColorFactor": [0.25, 0.26, 0.27],
                "sheenRoughnessFactor": 0.28},
            "KHR_materials_anisotropy": {"anisotropyStrength": 0.29, "anisotropyRotation": 30},
            "KHR_materials_iridescence": {"iridescenceFactor": 0.31, "iridescenceIor": 3.2,
                "iridescenceThicknessMinimum": 33, "iridescenceThicknessMaximum": 34},
            "KHR_materials_diffuse_transmission": {"diffuseTransmissionFactor": 0.35,
                "diffuseTransmissionColorFactor": [0.36, 0.37, 0.38]},
        }
    }, {"extensions": {"KHR_materials_pbrSpecularGlossiness": {"diffuseFactor": [0.1, 0.2, 0.3, 1],
        "specularFactor": [0.4, 0.5, 0.6], "glossinessFactor": 0.75,
        "specularGlossinessTexture": texture}}}, {}]);
    let materials = builder.read().materials;
    let all = &materials[0];
    assert_eq!(all.base_color, [0.1, 0.2, 0.3, 0.4]);
    assert_eq!((all.metallic, all.roughness, all.normal_scale), (0.5, 0.6, -2.0));
    assert_eq!((all.occlusion_strength, all.emissive), (0.7, [0.8, 0.9, 1.0]));
    assert_eq!((all.emissive_strength, all.ior, all.dispersion), (11.0, 1.2, 0.21));
    assert_eq!(all.alpha, Alpha::Mask { cutoff: 0.25 });
    assert!(all.double_sided && all.unlit);
    let base = all.base_color_texture.expect("a texture");
    assert_eq!((base.texture, base.set), (1, 6));
    assert_eq!(base.transform.offset, [1.0, 2.0]);
    assert_eq!((base.transform.rotation, base.transform.scale), (3.0, [4.0, 5.0]));
    assert_eq!((all.specular.strength, all.specular.color), (0.13, [1.4, 0.0, 1.0]));
    let color = all.specular.color_texture.expect("a texture");
    assert_eq!((color.texture, color.set, color.transform.scale), (2, 3, [1.0, 1.0]));
    assert_eq!(all.transmission.expect("there").factor, 0.15);
    let volume = all.volume.expect("there");
    assert_eq!((volume.thickness, volume.attenuation_distance), (16.0, 17.0));
    assert_eq!(volume.attenuation_color, [0.18, 0.19, 0.2]);
    let coat = all.clearcoat.expect("there");
    assert_eq!((coat.factor, coat.roughness, coat.normal_scale), (0.22, 0.23, 24.0));
    let sheen = all.sheen.expect("there");
    assert_eq!((sheen.color, sheen.roughness), ([0.25, 0.26, 0.27], 0.28));
    let scratches = all.anisotropy.expect("there");
    assert_eq!((scratches.strength, scratches.rotation), (0.29, 30.0));
    let film = all.iridescence.expect("there");
    assert_eq!((film.factor, film.ior), (0.31, 3.2));
    assert_eq!((film.thickness_minimum_nm, film.thickness_maximum_nm), (33.0, 34.0));
    let through = all.diffuse_transmission.expect("there");
    assert_eq!((through.factor, through.color), (0.35, [0.36, 0.37, 0.38]));

    // The older model in the words of the newer ones.
    let old = &materials[1];
    assert_eq!(old.base_color, [0.1, 0.2, 0.3, 1.0]);
    assert_eq!((old.metallic, old.roughness, old.ior), (0.0, 0.25, 0.0));
    assert_eq!(old.specular.color, [0.4, 0.5, 0.6]);
    assert_eq!(old.specular.color_texture, old.specular_glossiness.expect("there").texture);

    // The defaults of the specifications.
    let plain = &materials[2];
    assert_eq!((plain.base_color, plain.metallic, plain.roughness), ([1.0; 4], 1.0, 1.0));
    assert_eq!((plain.ior, plain.emissive_strength, plain.emissive), (1.5, 1.0, [0.0; 3]));
    assert_eq!((plain.alpha, plain.double_sided, plain.unlit), (Alpha::Opaque, false, false));
    assert_eq!((plain.specular.strength, plain.specular.color), (1.0, [1.0; 3]));
    assert_eq!((plain.transmission, plain.volume, plain.clearcoat), (None, None, None));
}

/// The example of `KHR_texture_transform`: by half, a quarter turn and a move down, the image is
/// its own lower left quarter (v from 1/2 to 1), turned so that its upper left corner is the lower
/// left one of the whole.
#[test]
fn texture_coordinates_are_turned() {
    let quarter = std::f32::consts::FRAC_PI_2;
    let transform = UvTransform { offset: [0.0, 1.0], rotation: quarter, scale: [0.5, 0.5] };
    for (from, to) in [
        ([0.0, 0.0], [0.0, 1.0]),
        ([1.0, 0.0], [0.0, 0.5]),
        ([0.0, 1.0], [0.5, 1.0]),
        ([1.0, 1.0], [0.5, 0.5]),
    ] {
        let there = transform.apply(Vec2::from_array(from));
        assert!((there - Vec2::from_array(to)).length() < 1e-6, "{from:?}: {there}");
    }
    assert_eq!(UvTransform::IDENTITY.apply(Vec2::new(0.3, 0.7)), Vec2::new(0.3, 0.7));
    // Scales come first, so they go along u and v as they are told.
    let wide = UvTransform { offset: [0.0; 2], rotation: quarter, scale: [4.0, 1.0] };
    assert!((wide.apply(Vec2::X) - Vec2::new(0.0, -4.0)).length() < 1e-5);
}

/// Factors outside their range are moved to its end, and told once for all of them. Emission
/// beyond 1 was written before there were strengths, and is meant.
#[test]
fn factors_are_moved_into_their_range() {
    let mut builder = Builder::triangle();
    builder.json["materials"] = json!([{"pbrMetallicRoughness": {"metallicFactor": 1.5,
        "roughnessFactor": -1, "baseColorFactor": [2, 0, 0, 1]}, "emissiveFactor": [5, 0, 0],
        "extensions": {"KHR_materials_ior": {"ior": 0}}}]);
    let document = builder.read();
    let material = &document.materials[0];
    assert_eq!((material.metallic, material.roughness, material.ior), (1.0, 0.0, 0.0));
    assert_eq!((material.base_color[0], material.emissive[0]), (1.0, 5.0));
    assert_eq!(
        document.notes,
        ["nowhere/a.gltf: factors outside their range, moved to its end: 3 (first \
          materials[0].pbrMetallicRoughness.baseColorFactor is 2)"]
    );
}

/// Images in the text, in the bytes and in files; of WebP and PNG the former; of KTX2 and PNG the
/// latter.
#[test]
fn images_are_found() {
    let mut builder = Builder::triangle();
    let png = b"\x89PNG\r\n\x1a\nrest";
    let view = builder.view(png);
    builder.push("images", json!({"bufferView": view, "mimeType": "image/jpeg"}));
    builder.push("images", json!({"uri": "a%20b.JPG", "name": "wood"}));
    builder.push("images", json!({"uri": "data:image/webp;base64,Zm9v"}));
    builder.push("images", json!({"uri": "sky.ktx2"}));
    builder.push("samplers", json!({"magFilter": 9728, "wrapS": 33071, "wrapT": 33648}));
    builder.push("textures", json!({"source": 0, "sampler": 0}));
    builder
        .push("textures", json!({"source": 1, "extensions": {"EXT_texture_webp": {"source": 2}}}));
    builder.push(
        "textures",
        json!({"source": 1, "extensions": {"KHR_texture_basisu": {"source": 3}}}),
    );
    let document = builder.read();
    let image = |i: usize| (&document.images[i].bytes, document.images[i].encoding);
    // What bytes are counts more than what is said of them.
    assert_eq!(image(0), (&ImageBytes::Here(png.to_vec().into()), Some(Encoding::Png)));
    assert_eq!(image(1), (&ImageBytes::File("a%20b.JPG".to_owned()), Some(Encoding::Jpeg)));
    assert_eq!(image(2), (&ImageBytes::Here(b"foo".to_vec().into()), Some(Encoding::WebP)));
    assert_eq!(image(3).1, None);
    let texture = &document.textures[0];
    assert_eq!((texture.image, texture.filter), (0, Filter::Nearest));
    assert_eq!(texture.wrap, [Wrap::Clamp, Wrap::Mirror]);
    assert_eq!(document.textures[1].wrap, [Wrap::Repeat; 2]);
    assert_eq!((document.textures[1].image, document.textures[2].image), (2, 1));
    assert_eq!(document.notes.len(), 1, "{:?}", document.notes);
}

/// Cameras with and without an end, and lights with their defaults.
#[test]
fn cameras_and_lights_are_read() {
    let mut builder = Builder::triangle();
    builder.json["cameras"] = json!([
        {"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}},
        {"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1, "zfar": 9,
            "aspectRatio": 2}},
        {"type": "orthographic", "orthographic": {"xmag": 2, "ymag": 1, "znear": 0, "zfar": 9}},
    ]);
    builder.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [
        {"type": "spot", "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.2}, "intensity": 3},
        {"type": "spot"},
        {"type": "spot", "spot": {"innerConeAngle": 0.5, "outerConeAngle": 0.5}},
        {"type": "spot", "spot": {"innerConeAngle": 1, "outerConeAngle": 0}, "intensity": 1e30},
        {"type": "directional", "color": [1, 0.5, 0], "range": 7},
    ]}});
    builder.json["nodes"][0]["extensions"] = json!({"KHR_lights_punctual": {"light": 4}});
    builder.json["nodes"][0]["camera"] = json!(1);
    let document = builder.read();
    let cameras: Vec<_> = document.cameras.iter().map(|camera| camera.projection).collect();
    let perspective =
        |aspect, far| Projection::Perspective { vertical: 0.5, aspect, near: 0.1, far };
    assert_eq!(cameras[0], perspective(None, f32::INFINITY));
    assert_eq!(cameras[1], perspective(Some(2.0), 9.0));
    assert_eq!(cameras[2], Projection::Orthographic { half: [2.0, 1.0], near: 0.0, far: 9.0 });
    let lights = &document.lights;
    assert_eq!(lights[0].kind, LightKind::Spot { inner: 0.1, outer: 0.2 });
    assert_eq!((lights[0].intensity, lights[0].color), (3.0, [1.0; 3]));
    let quarter = std::f32::consts::FRAC_PI_4;
    assert_eq!(lights[1].kind, LightKind::Spot { inner: 0.0, outer: quarter });
    assert_eq!((lights[1].intensity, lights[1].range), (1.0, f32::INFINITY));
    assert_eq!(lights[2].kind, LightKind::Spot { inner: 0.5, outer: 0.5 });
    let least = rutilant::light::MIN_CONE;
    assert_eq!(lights[3].kind, LightKind::Spot { inner: least, outer: least });
    assert_eq!(lights[3].intensity, rutilant::scene::MOST_LIGHT);
    assert!(
        document.notes[0].contains("outside their range, moved to its end: 3 (first "),
        "{:?}",
        document.notes
    );
    assert_eq!((lights[4].kind, lights[4].range), (LightKind::Directional, 7.0));
    assert_eq!((document.nodes[0].camera, document.nodes[0].light), (Some(1), Some(4)));
}

/// A variant gives some primitives another material, and is chosen by its name.
#[test]
fn variants_change_materials() {
    let mut builder = Builder::triangle();
    builder.json["materials"] = json!([{}, {}, {}]);
    builder.json["extensions"] =
        json!({"KHR_materials_variants": {"variants": [{"name": "red"}, {"name": "green"}]}});
    builder.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    builder.json["meshes"][0]["primitives"][0]["extensions"] =
        json!({"KHR_materials_variants": {"mappings": [{"material": 2, "variants": [1]}]}});
    let document = builder.read();
    let primitive = &document.meshes[0].primitives[0];
    let material = |name: &str| document.material(primitive, Some(document.variant(name).unwrap()));
    assert_eq!(document.material(primitive, None), Some(0));
    assert_eq!((material("red"), material("green")), (Some(0), Some(2)));
    let error = document.variant("grene").expect_err("no such name");
    assert_eq!(error.to_string(), "nowhere/a.gltf: no variant \"grene\"; did you mean \"green\"?");
    assert!(matches!(error.kind, SceneErrorKind::Unknown { .. }));
}

/// A matrix stands as it is, columns first.
#[test]
fn matrices_are_column_by_column() {
    let mut builder = Builder::triangle();
    builder.json["nodes"][0]["matrix"] = json!([0, 0, -2, 0, 0, 3, 0, 0, 4, 0, 0, 0, 5, 6, 7, 1]);
    let document = builder.read();
    let Placement::Matrix(affine) = document.nodes[0].placement else { panic!("no matrix") };
    let transform = affine.to_transform().expect("finite");
    assert_eq!(transform.point(Vec3::new(1.0, 1.0, 1.0)), Vec3::new(9.0, 9.0, 5.0));
}

/// Compressed views give what the same numbers without compression do: here differences of
/// nothing, so that every element is the first.
#[test]
fn compressed_views_are_unpacked() {
    let mut builder = Builder::triangle();
    let point = [1.0_f32, 2.0, 3.0].map(f32::to_le_bytes).concat();
    // Version 0: of each of 12 bytes one group of differences, all nought; then the tail.
    let stream = [&[0xa0][..], &[0; 12], &[0; 20], &point].concat();
    let offset = builder.bytes.len();
    builder.view(&stream);
    for name in ["EXT_meshopt_compression", "KHR_meshopt_compression"] {
        builder.json["extensionsRequired"] = json!([name]);
        builder.json["bufferViews"][0] = json!({"buffer": 0, "byteLength": 36, "extensions": {
            name: {"buffer": 0, "byteOffset": offset, "byteLength": stream.len(),
            "byteStride": 12, "count": 3, "mode": "ATTRIBUTES"}}});
        assert_eq!(*first(&builder).positions, [Vec3::new(1.0, 2.0, 3.0); 3]);
    }
    builder.json["bufferViews"][0]["extensions"]["KHR_meshopt_compression"]["byteLength"] =
        json!(stream.len() - 1);
    assert_eq!(builder.error(), "bufferViews[0].extensions.KHR_meshopt_compression is cut off");
}

/// A hilly square of 5x5 points that Google's own encoder compressed in two ways (along edges, and
/// row by row): the same points, within the 12 bits that it kept, each with its texture
/// coordinates, and the same triangles.
#[test]
fn draco_is_decoded() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fuzz/corpus/gltf/");
    let height = |x: usize, y: usize| ((x * x + 3 * y) % 4) as f32 / 4.0;
    let corner = |i: usize| Vec3::new((i % 5) as f32, (i / 5) as f32, height(i % 5, i / 5));
    // Each triangle once, beginning with its first point in the order of rows.
    let sorted = |mut triangle: [usize; 3]| {
        let first = (0..3).min_by_key(|&i| triangle[i]).unwrap_or(0);
        triangle.rotate_left(first);
        triangle
    };
    let mut expected = Vec::new();
    for a in (0..20).filter(|a| a % 5 < 4) {
        expected.extend([[a, a + 1, a + 5], [a + 1, a + 6, a + 5]].map(sorted));
    }
    expected.sort();
    for name in ["draco-edges.glb", "draco-rows.glb"] {
        let document = read(&fs::read(format!("{folder}{name}")).expect(name)).expect(name);
        let read = &document.meshes[0].primitives[0];
        // Which point each vertex is, by its place in the plane.
        let points: Vec<usize> = read
            .positions
            .iter()
            .zip(read.uvs[&0].iter())
            .map(|(p, uv)| {
                let i = p.x.round() as usize + 5 * p.y.round() as usize;
                assert!((*p - corner(i)).length() < 4.0 / 4096.0, "{name}: {p}");
                assert!((*uv * 4.0 - Vec2::new(p.x, p.y)).length() < 4.0 / 1024.0, "{name}: {uv}");
                i
            })
            .collect();
        let mut triangles: Vec<_> =
            read.triangles.iter().map(|t| sorted(t.map(|v| points[v as usize]))).collect();
        triangles.sort();
        assert_eq!(triangles, expected, "{name}");
        let normals = read.normals.as_ref().expect("normals");
        assert!(normals.iter().all(|n| (*n - Vec3::Z).length() < 0.01), "{name}");
    }
}

/// Compressed meshes that do not hold what their accessors say, or nothing at all.
#[test]
fn draco_has_to_fit() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fuzz/corpus/gltf/");
    let file = fs::read(format!("{folder}draco-rows.glb")).expect("a file");
    let said = |from: &str, to: &str| {
        assert_eq!(from.len(), to.len());
        let at = file.windows(from.len()).position(|w| w == from.as_bytes()).expect(from);
        let mut file = file.clone();
        file[at..at + to.len()].copy_from_slice(to.as_bytes());
        read(&file).expect_err("a mistake")
    };
    let place = "meshes[0].primitives[0].extensions.KHR_draco_mesh_compression";
    assert_eq!(
        said("\"count\":96", "\"count\":99"),
        format!("{place} has 32 triangles for 99 indices")
    );
    let cut = said("\"count\":96", "\"count\":93");
    assert!(cut.starts_with(&format!("{place}: Draco cannot decode it: ")), "{cut}");
    let none = said("DRACO", "DRACA");
    assert!(none.starts_with(&format!("{place}: Draco cannot decode it: ")), "{none}");
    assert_eq!(
        said("\"POSITION\":10", "\"POSITION\":11"),
        format!("{place} has no attribute 11 that fits accessors[3]")
    );
}

/// A binary file with chunks of unknown kinds, and with bytes behind its end.
#[test]
fn unknown_chunks_are_skipped() {
    let builder = Builder::triangle();
    let mut file = builder.binary();
    file.extend(4_u32.to_le_bytes());
    file.extend(b"ABCD1234");
    let length = (file.len() as u32).to_le_bytes();
    file[8..12].copy_from_slice(&length);
    assert_eq!(read(&file).expect("read").notes.len(), 0);
    file.extend([1, 2, 3]);
    assert_eq!(
        read(&file).expect("read").notes,
        ["nowhere/a.gltf: bytes after the end that the header tells, left out: 3"]
    );
    assert_eq!(read(&glb(b"{}", b"")).expect_err("nothing"), "the document has no \"asset\"");
}
