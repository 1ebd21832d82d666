//! What is said of mistakes: one line, the place, what is wrong, what would be right.

use crate::builder::{Builder, glb, read};
use rutilant_formats::scene::gltf::read_bytes;
use rutilant_formats::{Limits, ReadOptions, SceneErrorKind};
use serde_json::{Value, json};
use std::path::Path;

/// What is said of a triangle in which `change` has made a mistake.
fn said(change: impl FnOnce(&mut Builder)) -> String {
    let mut builder = Builder::triangle();
    change(&mut builder);
    builder.error()
}

/// What is said of a triangle with one more key.
fn with(key: &str, value: Value) -> String {
    said(|builder| builder.json[key] = value)
}

/// What is said of a triangle whose primitive has another key.
fn primitive(key: &str, value: Value) -> String {
    said(|builder| builder.json["meshes"][0]["primitives"][0][key] = value)
}

/// Wrong JSON is told by line and column; in a binary file, in words.
#[test]
fn syntax_is_told_by_line_and_column() {
    for (text, expected) in [
        ("{\"asset\":\n  {\"version\" \"2.0\"}}", "2:14: expected `:`"),
        ("{\"é\": 1, \"é\": 2}", "1:12: \"é\" comes twice"),
        ("", "1:1: it is empty"),
        (" \n", "2:1: it is empty"),
        ("{\"a\": [1,", "1:9: it ends in the middle of a value"),
        ("{\"a\": 1e999}", "1:11: number out of range"),
        ("{\"a\": 1}}", "1:9: trailing characters"),
        ("{\"a\": nan}", "1:8: expected ident"),
        ("{\"a\": \"\\ud800\"}", "1:14: unexpected end of hex escape"),
    ] {
        assert_eq!(read(text.as_bytes()).expect_err("no JSON"), expected, "{text}");
    }
    assert_eq!(
        read(&glb(b"{\n\"a\" 1}", b"")).expect_err("no JSON"),
        "its JSON, line 2, column 5: expected `:`"
    );
    assert!(read(b"{\"a\": \"\xff\"}").expect_err("no text").contains("invalid unicode"));
}

/// Levels are counted against the limit, to the last one.
#[test]
fn nesting_is_limited() {
    let text =
        format!(r#"{{"asset":{{"version":"2.0"}},"extras":{}{}}}"#, "[".repeat(9), "]".repeat(9));
    let read = |nesting| {
        let limits = Limits { nesting, ..Limits::default() };
        let options = ReadOptions { limits, ..ReadOptions::default() };
        read_bytes(text.as_bytes(), Path::new("a.gltf"), &options)
    };
    read(10).expect("allowed");
    let error = read(9).expect_err("too deep");
    assert!(matches!(error.kind, SceneErrorKind::Limit { asked: 10, allowed: 9, .. }), "{error}");
    // Deeper than anybody's stack.
    let deep = format!("{{\"a\":{}", "[".repeat(1_000_000));
    let limits = Limits { nesting: u64::MAX, ..Limits::default() };
    let options = ReadOptions { limits, ..ReadOptions::default() };
    read_bytes(deep.as_bytes(), Path::new("a.gltf"), &options).expect_err("too deep");
}

/// Files of other versions, and files that need what is not read.
#[test]
fn what_cannot_be_read_is_named() {
    let asset = |asset: Value| with("asset", asset);
    assert_eq!(asset(json!({"version": "1.0"})), "asset.version is \"1.0\"; only glTF 2.0 is read");
    assert_eq!(
        asset(json!({"version": "2.1", "minVersion": "2.1"})),
        "asset.minVersion is \"2.1\"; only glTF 2.0 is read"
    );
    assert_eq!(asset(json!({})), "asset has no \"version\"");
    assert_eq!(
        with("extensionsRequired", json!(["KHR_texture_basisu"])),
        "it needs the extension KHR_texture_basisu (KTX2 images), which is not read"
    );
    assert_eq!(
        with("extensionsRequired", json!(["A_b", "KHR_materials_ior", "C\nd"])),
        "it needs extensions that are not read: A_b, C\\nd"
    );
    assert_eq!(
        said(|builder| {
            builder.push("images", json!({"uri": "a.ktx2"}));
            let basisu = json!({"KHR_texture_basisu": {"source": 0}});
            builder.push("textures", json!({"extensions": basisu}));
        }),
        "textures[0] has only a KTX2 image (KHR_texture_basisu), which is not read; PNG, JPEG and \
         WebP are"
    );
    let mut builder = Builder::triangle();
    builder.json["extensionsUsed"] = json!(["KHR_materials_ior", "FOO_bar"]);
    assert_eq!(
        builder.read().notes,
        ["nowhere/a.gltf: extensions that are not read, left out: FOO_bar"]
    );
}

/// Binary files whose header, lengths or chunks lie.
#[test]
fn binary_files_are_checked() {
    let file = Builder::triangle().binary();
    let said = |change: &dyn Fn(&mut Vec<u8>)| {
        let mut file = file.clone();
        change(&mut file);
        read(&file).expect_err("a mistake")
    };
    let length = file.len();
    assert_eq!(said(&|f| f.truncate(11)), "the file ends in its header");
    assert_eq!(said(&|f| f[4] = 1), "a binary glTF of version 1; only version 2 is read");
    assert_eq!(said(&|f| f.truncate(100)), format!("the file ends after 100 of {length} bytes"));
    assert_eq!(said(&|f| f[16] = b'j'), "its first chunk is not JSON");
    assert_eq!(
        said(&|f| f[8..12].copy_from_slice(&[16, 0, 0, 0])),
        "the header of chunk 0 is cut off"
    );
    assert_eq!(
        said(&|f| f[12..16].copy_from_slice(&[255; 4])),
        format!("chunk 0 has 4294967295 bytes, but only {} are left", length - 20)
    );
    assert_eq!(
        said(&|f| {
            let at = length - 36 - 8;
            f.truncate(at);
            let length = (at as u32).to_le_bytes();
            f[8..12].copy_from_slice(&length);
        }),
        "meshes[0].primitives[0].attributes.POSITION needs buffers[0], which has no bytes"
    );
}

/// Values of the wrong type, and numbers that are out of range.
#[test]
fn values_are_checked() {
    for (key, value, expected) in [
        ("meshes", json!(7), "meshes is 7, but must be a list"),
        ("meshes", json!([null]), "meshes[0] is null, but must be an object"),
        ("meshes", json!([{}]), "meshes[0] has no \"primitives\""),
        ("scene", json!(-1), "scene is -1, but must lie between 0 and 4294967295"),
        ("scene", json!(0.5), "scene is 0.5, but must be a whole number"),
        ("scene", json!("a"), "scene is \"a\", but must be a whole number"),
        ("scene", json!(1), "scene names scene 1, but there is only one (number 0)"),
        (
            "materials",
            json!([{"doubleSided": 1}]),
            "materials[0].doubleSided is 1, but must be true or false",
        ),
        (
            "materials",
            json!([{"emissiveFactor": [1, 2]}]),
            "materials[0].emissiveFactor has 2 numbers, but must have 3",
        ),
        (
            "materials",
            json!([{"emissiveFactor": [1, 2, "x"]}]),
            "materials[0].emissiveFactor[2] is \"x\", but must be a number",
        ),
        (
            "materials",
            json!([{"emissiveFactor": [1, 2, 1e39]}]),
            "materials[0].emissiveFactor[2] is 1e39, too large for single precision",
        ),
        (
            "materials",
            json!([{"alphaMode": "GLASS"}]),
            "materials[0].alphaMode is \"GLASS\", but must be OPAQUE, MASK or BLEND",
        ),
        (
            "materials",
            json!([{"normalTexture": {"index": 0}}]),
            "materials[0].normalTexture.index names texture 0, but there are none",
        ),
        (
            "materials",
            json!([{"extensions": {"KHR_materials_volume": {"attenuationDistance": 0}}}]),
            "materials[0].extensions.KHR_materials_volume.attenuationDistance is 0, but must be more than 0",
        ),
        (
            "materials",
            json!([{"extensions": {"KHR_materials_ior": 1}}]),
            "materials[0].extensions.KHR_materials_ior is 1, but must be an object",
        ),
        (
            "cameras",
            json!([{"type": "fisheye"}]),
            "cameras[0].type is \"fisheye\", but must be perspective or orthographic",
        ),
        (
            "cameras",
            json!([{"type": "perspective", "perspective": {"yfov": 45, "znear": 1}}]),
            "cameras[0].perspective.yfov is 45, but must lie between 0 and π: it is an angle in radians",
        ),
        (
            "cameras",
            json!([{"type": "perspective", "perspective": {"yfov": 1, "znear": 1, "zfar": 1}}]),
            "cameras[0].perspective.zfar is 1, but must be more than 1",
        ),
        (
            "cameras",
            json!([{"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 0, "znear": 0, "zfar": 1}}]),
            "cameras[0].orthographic.ymag is 0, but must not be",
        ),
        ("images", json!([{}]), "images[0] has neither a \"uri\" nor a \"bufferView\""),
        (
            "images",
            json!([{"uri": "data:;base64,?"}]),
            "images[0].uri is no base64: its data have \"?\" at byte 0",
        ),
        (
            "samplers",
            json!([{"wrapS": 1}]),
            "samplers[0].wrapS is 1, but must be 10497 (repeat), 33648 (mirrored) or 33071 (clamped)",
        ),
        (
            "bufferViews",
            json!([{"buffer": 0, "byteOffset": 4, "byteLength": 36}]),
            "bufferViews[0] has 36 bytes from 4 on, but buffers[0] has only 36",
        ),
        (
            "bufferViews",
            json!([{"buffer": 0, "byteOffset": 9007199254740991_u64, "byteLength": 9007199254740991_u64}]),
            "bufferViews[0] has 9007199254740991 bytes from 9007199254740991 on, but buffers[0] has only 36",
        ),
    ] {
        assert_eq!(with(key, value.clone()), expected, "{value}");
    }
}

/// Accessors that reach beyond their views, and primitives that do not fit together.
#[test]
fn arrays_are_checked() {
    let accessor = |value: Value| {
        said(|builder| {
            builder.push("accessors", value);
        })
    };
    for (value, expected) in [
        (
            json!({"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 4}),
            "accessors[1] needs 48 bytes, but bufferViews[0] has only 36",
        ),
        (
            json!({"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 9007199254740991_u64}),
            "accessors[1] needs 108086391056891892 bytes, but bufferViews[0] has only 36",
        ),
        (
            json!({"bufferView": 0, "componentType": 5124, "type": "VEC3", "count": 1}),
            "accessors[1].componentType is 5124, but must be one of 5120, 5121, 5122, 5123, 5125 and 5126",
        ),
        (
            json!({"componentType": 5126, "type": "VEC5", "count": 1}),
            "accessors[1].type is \"VEC5\", but must be one of SCALAR, VEC2, VEC3, VEC4, MAT2, MAT3, MAT4",
        ),
        (
            json!({"componentType": 5126, "type": "VEC3", "count": 1, "sparse": {"count": 2}}),
            "accessors[1].sparse has 2 exceptions to 1 elements",
        ),
        (
            json!({"componentType": 5126, "type": "VEC3", "count": 1, "sparse": {"count": 1,
            "indices": {"componentType": 5121}, "values": {"bufferView": 0}}}),
            "accessors[1].sparse.indices has no \"bufferView\"",
        ),
    ] {
        assert_eq!(accessor(value.clone()), expected, "{value}");
    }
    assert_eq!(
        primitive("attributes", json!({"POSITION": 1})),
        "meshes[0].primitives[0].attributes.POSITION names accessor 1, but there is only one \
         (number 0)"
    );
    assert_eq!(
        primitive("attributes", json!({"POSITION": 0, "TEXCOORD_0": 0})),
        "meshes[0].primitives[0].attributes.TEXCOORD_0 names accessor 0 of type VEC3, but must be \
         VEC2"
    );
    assert_eq!(
        said(|builder| {
            let normal = builder.floats("VEC3", &[0.0; 6]);
            builder.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normal);
        }),
        "meshes[0].primitives[0].attributes.NORMAL has 2 elements, but POSITION has 3"
    );
    assert_eq!(
        said(|builder| {
            let indices = builder.shorts("SCALAR", 3, &[0, 3, 1]);
            builder.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
        }),
        "meshes[0].primitives[0].indices names an accessor with vertex 3, but there are only 3 \
         (numbered from 0)"
    );
    assert_eq!(
        said(|builder| {
            let indices = builder.floats("SCALAR", &[0.0, 1.0, 2.0]);
            builder.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
        }),
        "meshes[0].primitives[0].indices names accessor 1, which must hold whole numbers without \
         a sign"
    );
    assert_eq!(
        primitive("mode", json!(7)),
        "meshes[0].primitives[0].mode is 7, but must lie between 0 and 6"
    );
    assert_eq!(
        primitive("attributes", json!({"POSITION": 0, "JOINTS_0": 0})),
        "meshes[0].primitives[0].attributes has only one of JOINTS_0 and WEIGHTS_0"
    );
    assert_eq!(
        primitive("targets", json!([{"POSITION": 9}])),
        "meshes[0].primitives[0].targets[0].POSITION names accessor 9, but there is only one \
         (number 0)"
    );
    assert_eq!(
        said(|builder| {
            builder.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": 0}]);
            builder.json["meshes"][0]["weights"] = json!([1, 2]);
        }),
        "meshes[0].weights has 2 numbers for 1 morph targets"
    );
}

/// Nodes that are below themselves or below two others, and what stands nowhere.
#[test]
fn hierarchies_are_checked() {
    let nodes = |nodes: Value| with("nodes", nodes);
    assert_eq!(
        nodes(json!([{}, {"children": [2]}, {"children": [1]}])),
        "nodes[1] is below itself"
    );
    assert_eq!(nodes(json!([{}, {"children": [1]}])), "nodes[1] is below itself");
    assert_eq!(
        nodes(json!([{"children": [2]}, {"children": [2]}, {}])),
        "nodes[1].children[0] names node 2, which nodes[0] has as a child already"
    );
    assert_eq!(
        nodes(json!([{"children": [3]}])),
        "nodes[0].children[0] names node 3, but there is only one (number 0)"
    );
    assert_eq!(
        nodes(json!([{"rotation": [0, 0, 0, 0]}])),
        "nodes[0] has a rotation of length 0, but must have one of length 1"
    );
    assert_eq!(
        nodes(json!([{"matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 2]}])),
        "nodes[0].matrix has a last row [0.0, 0.0, 0.0, 2.0], but must have [0, 0, 0, 1]"
    );
    assert_eq!(
        said(|builder| builder.json["scenes"] = json!([{"nodes": [0, 0]}])),
        "scenes[0].nodes[1] names node 0 once more"
    );
    assert_eq!(
        said(|builder| {
            builder.json["nodes"] = json!([{}, {"children": [0]}]);
        }),
        "scenes[0].nodes[0] names node 0, which is no root but below nodes[1]"
    );
    let mut builder = Builder::triangle();
    builder.json["nodes"] = json!([{"scale": [1e30, 1, 1], "children": [1]},
        {"scale": [1e30, 1, 1], "mesh": 0}]);
    let document = builder.read();
    let error = document.placed(None, &document.pose(None)).expect_err("too large");
    assert_eq!(
        error.to_string(),
        "nowhere/a.gltf: nodes[1] stands where single precision cannot hold it"
    );
}

/// Animations and skins that do not fit what they move.
#[test]
fn movements_are_checked() {
    let animation = |path: &str, times: &[f32], values: &[f32]| {
        said(|builder| {
            let input = builder.floats("SCALAR", times);
            let output = builder.floats("VEC3", values);
            builder.json["animations"] = json!([{"samplers": [{"input": input, "output": output}],
                "channels": [{"sampler": 0, "target": {"node": 0, "path": path}}]}]);
        })
    };
    assert_eq!(
        animation("scale", &[0.0, 0.0], &[0.0; 6]),
        "animations[0].samplers[0].input names times that do not all grow, or are none"
    );
    assert_eq!(
        animation("scale", &[0.0, 1.0], &[0.0; 3]),
        "animations[0].channels[0] has 3 numbers for 2 keyframes of 3"
    );
    assert_eq!(
        animation("scale", &[0.0], &[0.0, f32::NAN, 0.0]),
        "animations[0].samplers[0].output names a value 1 that is not finite"
    );
    assert_eq!(
        said(|builder| {
            let joints = builder.array("VEC4", 5121, 3, &[0, 1, 9, 0].repeat(3));
            let weights = builder.floats("VEC4", &[0.5, 0.5, 0.0, 0.0].repeat(3));
            builder.json["meshes"][0]["primitives"][0]["attributes"] =
                json!({"POSITION": 0, "JOINTS_0": joints, "WEIGHTS_0": weights});
            builder.json["skins"] = json!([{"joints": [0]}]);
            builder.json["nodes"][0]["skin"] = json!(0);
        }),
        "nodes[0].skin names skin 0, which has only 1 joints, but meshes[0] follows joint 1"
    );
    assert_eq!(
        said(|builder| {
            let matrices = builder.floats("MAT4", &[0.0; 16]);
            builder.json["skins"] = json!([{"joints": [0], "inverseBindMatrices": matrices}]);
        }),
        "skins[0].inverseBindMatrices has a matrix 0 that is no affine map"
    );
}

/// What a small file could ask for is bounded by its bytes: zeros without bytes, and the same
/// bytes over and over.
#[test]
fn small_files_take_little_memory() {
    let text = said(|builder| {
        let accessor = json!({"componentType": 5126, "type": "VEC3", "count": 4_000_000_000_u64});
        let position = builder.push("accessors", accessor);
        builder.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(position);
    });
    assert!(
        text.starts_with(
            "meshes[0].primitives[0].attributes.POSITION unpacks, with what was read before, to \
             48000000000 bytes, too many for files of "
        ),
        "{text}"
    );

    let mut builder = Builder::new();
    builder.view(&[0; 120_000]);
    for _ in 0..1000 {
        let accessor =
            json!({"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 10_000});
        let position = builder.push("accessors", accessor);
        builder.push("meshes", json!({"primitives": [{"attributes": {"POSITION": position}}]}));
    }
    let text = builder.error();
    assert!(text.contains("too many for files of"), "{text}");
    // One array that all share is no matter.
    for mesh in 0..1000 {
        builder.json["meshes"][mesh]["primitives"][0]["attributes"]["POSITION"] = json!(0);
        builder.json["meshes"][mesh]["primitives"][0]["indices"] = json!(1000);
    }
    builder.shorts("SCALAR", 3, &[0, 1, 2]);
    assert_eq!(builder.read().meshes.len(), 1000);
}

/// Many keys, and many attributes that nobody reads, take time in proportion only: a quadratic
/// search would take minutes.
#[test]
fn many_keys_are_read_soon() {
    let start = std::time::Instant::now();
    let mut builder = Builder::triangle();
    let attributes = (0..200_000).map(|i| (format!("_{i}"), json!(0)));
    let attributes: serde_json::Map<_, _> =
        [("POSITION".to_owned(), json!(0))].into_iter().chain(attributes).collect();
    builder.json["meshes"][0]["primitives"][0]["attributes"] = json!(attributes);
    builder.read();
    assert!(start.elapsed() < std::time::Duration::from_secs(20), "{:?}", start.elapsed());
}

/// Limits that the caller sets are told with the name by which they can be raised.
#[test]
fn limits_hold() {
    let mut builder = Builder::triangle();
    let translation = builder.floats("VEC3", &[0.0; 9]);
    builder.json["nodes"][0]["extensions"] =
        json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": translation}}});
    let said = |name: &str, most: u64| {
        let mut limits = Limits::default();
        *limits.by_name(name).expect(name) = most;
        let options = ReadOptions { limits, ..ReadOptions::default() };
        let result = read_bytes(builder.text().as_bytes(), Path::new("a.gltf"), &options);
        result.err().map(|error| error.to_string())
    };
    let hint = "allow more with --limit";
    for (name, what, needed) in
        [("vertices", "vertices", 3), ("triangles", "triangle", 1), ("objects", "objects", 3)]
    {
        assert_eq!(said(name, needed), None);
        let expected = format!(
            "a.gltf: {needed} {what}, but at most {} are allowed; {hint} {name}=N",
            needed - 1
        );
        assert_eq!(said(name, needed - 1), Some(expected));
    }
}
