//! Documents as scenes of the renderer.

use crate::builder::Builder;
use image::{ExtendedColorType, ImageEncoder};
use rutilant::color::Rgb;
use rutilant::light::{Environment, Light};
use rutilant::material::{
    Absorption, Emission, EmittedLight, Material, MaterialKind, OpacityMode, Principled, Sides,
};
use rutilant::scene::Scene;
use rutilant::shape::Shape;
use rutilant::texture::{Channel, Encoding, Texels, Texture};
use rutilant_formats::{LoadedScene, ReadOptions, read_scene};
use rutilant_geom::{Vec2, Vec3};
use serde_json::json;

/// The scene of a document, and what is said of it without the file's name.
fn scene(builder: &Builder, options: &ReadOptions<'_>) -> Result<LoadedScene, String> {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("a.glb");
    std::fs::write(&file, builder.binary()).expect("a file");
    let short = |text: String| text.replace(&file.display().to_string(), "a.glb");
    match read_scene(&file, options) {
        Ok(mut loaded) => {
            loaded.notes = loaded.notes.into_iter().map(short).collect();
            Ok(loaded)
        }
        Err(error) => Err(short(error.to_string())),
    }
}

fn sound(builder: &Builder) -> LoadedScene {
    scene(builder, &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

fn principled(material: &Material) -> &Principled {
    match &material.kind {
        MaterialKind::Principled(principled) => principled,
        other => panic!("{other:?}"),
    }
}

/// A picture of one texel, in the document's own bytes.
fn picture(builder: &mut Builder, rgba: [u8; 4]) -> usize {
    let mut png = Vec::new();
    let encoder = image::codecs::png::PngEncoder::new(&mut png);
    encoder.write_image(&rgba, 1, 1, ExtendedColorType::Rgba8).expect("encoded");
    let view = builder.view(&png);
    let image = builder.push("images", json!({"bufferView": view, "mimeType": "image/png"}));
    builder.push("textures", json!({"source": image}))
}

/// The texel that a texture shows, and how it is decoded.
fn texel(scene: &Scene, id: rutilant::scene::TextureId) -> (Vec<u8>, Encoding) {
    let Texture::Image(image) = &scene.textures[id.0 as usize] else { panic!("no image") };
    let Texels::Eight(codes) = scene.bitmaps[image.bitmap.0 as usize].texels() else { panic!() };
    (codes.clone(), image.encoding)
}

/// What a material says beyond what is shown is told.
#[test]
fn what_is_not_shown_is_told() {
    let mut builder = Builder::triangle();
    let image = picture(&mut builder, [255; 4]);
    let primitive = |material| json!({"attributes": {"POSITION": 0}, "material": material});
    builder.json["meshes"] = json!([{"primitives": [primitive(0), primitive(1)]}]);
    for (name, factor) in [("old", 0.5), ("glossy", 1.0)] {
        let gloss = json!({
            "glossinessFactor": factor, "specularGlossinessTexture": {"index": image}
        });
        let extensions = json!({"KHR_materials_pbrSpecularGlossiness": gloss});
        builder.push("materials", json!({"name": name, "extensions": extensions}));
    }
    let loaded = sound(&builder);
    let old = principled(&loaded.scene.materials[0]);
    assert_eq!((old.roughness, old.textures.roughness), (0.5, None));
    // Where the picture says all, it is told as what gloss lacks to 1.
    let glossy = principled(&loaded.scene.materials[1]);
    let (texture, channel) = glossy.textures.roughness.expect("a picture");
    assert_eq!((glossy.roughness, channel), (1.0, Channel::InverseAlpha));
    assert_eq!(texel(&loaded.scene, texture), (vec![255; 4], Encoding::Linear));
    let notes = loaded.notes;
    assert!(!notes.iter().any(|note| note.contains("glossy")), "{notes:?}");
    let expected =
        "a.glb: material \"old\": the gloss in its specularGlossinessTexture is left out";
    assert!(notes.iter().any(|note| note == expected), "{notes:?}");
}

/// Every word of a material that is shown arrives, its pictures with the right channels and
/// encodings; the same picture is in memory once.
#[test]
fn materials_arrive() {
    let mut builder = Builder::triangle();
    let uv = builder.floats("VEC2", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    let normal = builder.floats("VEC3", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    let [first, second] = [[10, 20, 30, 40], [1, 2, 3, 4]].map(|c| picture(&mut builder, c));
    let attributes = json!({"POSITION": 0, "TEXCOORD_0": uv, "NORMAL": normal});
    builder.json["meshes"] = json!([{"primitives": [{"attributes": attributes, "material": 0}]}]);
    builder.json["materials"] = json!([{
        "name": "all",
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.5, 0.6, 0.7, 0.8],
            "baseColorTexture": {"index": first},
            "metallicFactor": 0.25, "roughnessFactor": 0.75,
            "metallicRoughnessTexture": {"index": second},
        },
        "normalTexture": {"index": second, "scale": 0.5},
        "emissiveFactor": [1.0, 0.5, 0.0],
        "emissiveTexture": {"index": first},
        "alphaMode": "MASK", "alphaCutoff": 0.3, "doubleSided": true,
        "extensions": {
            "KHR_materials_emissive_strength": {"emissiveStrength": 4.0},
            "KHR_materials_ior": {"ior": 1.4},
            "KHR_materials_specular": {"specularFactor": 0.9, "specularTexture": {"index": first}},
            "KHR_materials_transmission": {"transmissionFactor": 0.4},
            "KHR_materials_dispersion": {"dispersion": 0.3},
            "KHR_materials_volume": {
                "thicknessFactor": 1.0, "attenuationDistance": 2.0,
                "attenuationColor": [0.5, 0.25, 1.0],
            },
            "KHR_materials_clearcoat": {"clearcoatFactor": 0.6, "clearcoatRoughnessFactor": 0.1},
            "KHR_materials_anisotropy": {
                "anisotropyStrength": 0.5, "anisotropyRotation": 0.25,
                "anisotropyTexture": {"index": second},
            },
            "KHR_materials_sheen": {"sheenColorFactor": [0.1, 0.2, 0.3]},
            "KHR_materials_iridescence": {
                "iridescenceFactor": 0.7, "iridescenceIor": 1.2,
                "iridescenceThicknessMinimum": 50.0, "iridescenceThicknessMaximum": 500.0,
            },
        },
    }]);
    let loaded = sound(&builder);
    let scene = &loaded.scene;
    assert_eq!(scene.bitmaps.len(), 2);
    let material = &scene.materials[0];
    assert_eq!((&*material.name, material.sides), ("all", Sides::Both));
    let p = principled(material);
    assert_eq!((p.base_color, p.metallic, p.roughness), (Rgb::new(0.5, 0.6, 0.7), 0.25, 0.75));
    assert_eq!((p.ior, p.specular, p.transmission), (1.4, 0.9, 0.4));
    assert!(!p.thin_walled && p.dispersion == 0.3 && p.iridescence_thickness_minimum_nm == 50.0);
    let color = Rgb::new(0.5, 0.25, 1.0);
    assert_eq!(p.absorption, Absorption::ColorAtDistance { color, distance: 2.0 });
    assert_eq!((p.coat, p.coat_roughness), (0.6, 0.1));
    assert_eq!((p.anisotropy, p.anisotropy_rotation), (0.5, 0.25));
    assert_eq!(p.sheen_color, Rgb::new(0.1, 0.2, 0.3));
    assert_eq!((p.iridescence, p.iridescence_ior, p.iridescence_thickness_nm), (0.7, 1.2, 500.0));
    let shown = |id| texel(scene, id);
    let [one, two] = [vec![10, 20, 30, 40], vec![1, 2, 3, 4]];
    let of = &p.textures;
    assert_eq!(shown(of.base_color.unwrap()), (one.clone(), Encoding::Srgb));
    let (metallic, channel) = of.metallic.unwrap();
    assert_eq!((shown(metallic), channel), ((two.clone(), Encoding::Linear), Channel::Blue));
    assert_eq!(of.roughness, Some((metallic, Channel::Green)));
    let (specular, channel) = of.specular.unwrap();
    assert_eq!((shown(specular), channel), ((one.clone(), Encoding::Linear), Channel::Alpha));
    assert_eq!(of.anisotropy, Some((metallic, Channel::Blue)));
    assert_eq!(of.anisotropy_direction, Some(metallic));
    let map = material.normal_map.unwrap();
    assert_eq!((shown(map.texture), map.scale), ((two, Encoding::Linear), 0.5));
    let opacity = material.opacity.unwrap();
    assert_eq!(opacity.mode, OpacityMode::Mask { cutoff: 0.3 });
    assert_eq!(opacity.amount.factor, 0.8);
    assert_eq!(opacity.amount.texture, of.base_color.map(|id| (id, Channel::Alpha)));
    let emission = material.emission.unwrap();
    assert_eq!(emission.light, EmittedLight::Radiance(Rgb::new(4.0, 2.0, 0.0)));
    assert!(emission.two_sided && emission.texture == of.base_color);
    // v is turned over, and u grows along x.
    let mesh = &scene.meshes[0];
    assert_eq!(mesh.uvs, [Vec2::new(0.0, 1.0), Vec2::new(1.0, 1.0), Vec2::ZERO]);
    assert_eq!(mesh.tangents[0], [1.0, 0.0, 0.0, -1.0]);
}

/// What is unlit glows in its colour; what has no material is a plain grey one; vertex colours
/// count where there are some.
#[test]
fn plain_things_are_plain() {
    let mut builder = Builder::triangle();
    let colors = builder.floats("VEC3", &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    builder.json["meshes"] = json!([{"primitives": [
        {"attributes": {"POSITION": 0, "COLOR_0": colors}},
        {"attributes": {"POSITION": 0}},
        {"attributes": {"POSITION": 0}, "material": 0},
        {"attributes": {"POSITION": 0, "COLOR_0": colors}, "material": 0},
    ]}]);
    builder.json["materials"] = json!([{
        "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.25, 0.125, 1.0]},
        "extensions": {"KHR_materials_unlit": {}},
    }]);
    let scene = sound(&builder).scene;
    let vary = |i: usize| {
        let object = &scene.objects[i];
        principled(&scene.materials[object.material.0 as usize]).textures.vertex_colors
    };
    assert_eq!([vary(0), vary(1)], [true, false]);
    let Shape::Mesh(mesh) = scene.objects[0].shape else { panic!() };
    assert_eq!(scene.meshes[mesh.0 as usize].colors[1], [0.0, 1.0, 0.0, 1.0]);
    let unlit = &scene.materials[scene.objects[2].material.0 as usize];
    let light = EmittedLight::Radiance(Rgb::new(0.5, 0.25, 0.125));
    assert_eq!(unlit.kind, MaterialKind::Black);
    let light = Emission { light, ..Emission::radiance(Rgb::WHITE) };
    assert_eq!(unlit.emission, Some(light));
    let painted = &scene.materials[scene.objects[3].material.0 as usize];
    assert_eq!(painted.emission, Some(Emission { vertex_colors: true, ..light }));
    // Both have only a front, unless they say otherwise.
    assert!(scene.materials.iter().all(|m| m.sides == Sides::Front));
}

/// An index of 0 stands for one without end: at normal incidence everything is reflected, but for
/// the specular colour. `KHR_materials_pbrSpecularGlossiness` says how much, and means it.
#[test]
fn an_endless_index_is_a_mirror() {
    let mut builder = Builder::triangle();
    builder.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    for (extension, what, expected) in [
        ("KHR_materials_ior", json!({"ior": 0}), [1.0; 3]),
        (
            "KHR_materials_pbrSpecularGlossiness",
            json!({"specularFactor": [1, 0.5, 0.1]}),
            [1.0, 0.5, 0.1],
        ),
    ] {
        builder.json["materials"] = json!([{"extensions": {extension: what}}]);
        builder.json["extensionsUsed"] = json!([extension]);
        let scene = sound(&builder).scene;
        let mirror = principled(&scene.materials[0]);
        let normal = ((mirror.ior - 1.0) / (mirror.ior + 1.0)).powi(2);
        let reflected = mirror.specular_color.0.map(|c| normal * c);
        for (got, wanted) in reflected.into_iter().zip(expected) {
            assert!((got - wanted).abs() < 1e-6, "{extension}: {reflected:?}");
        }
    }
}

/// A smooth body may have any index; a rough one is moved to where it is known, and that is told.
#[test]
fn only_rough_glass_is_kept_from_high_indices() {
    let mut builder = Builder::triangle();
    builder.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    for (roughness, expected) in [(0.0, 3.0), (0.5, 2.5)] {
        builder.json["materials"] = json!([{
            "name": "gem",
            "pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": roughness},
            "extensions": {
                "KHR_materials_ior": {"ior": 3},
                "KHR_materials_transmission": {"transmissionFactor": 1},
                "KHR_materials_volume": {"thicknessFactor": 1},
            },
        }]);
        let loaded = sound(&builder);
        assert_eq!(principled(&loaded.scene.materials[0]).ior, expected);
        let told =
            loaded.notes.iter().any(|note| note.contains("\"gem\": glass that is not smooth"));
        assert_eq!(told, roughness > 0.0, "{:?}", loaded.notes);
    }
}

/// Lights and cameras stand where their nodes do; where there are none, a sky and an eye do.
#[test]
fn lights_and_cameras_stand_where_nodes_do() {
    let mut builder = Builder::triangle();
    let alone = sound(&builder);
    assert_eq!(alone.scene.environment, Some(Environment::constant(Rgb::WHITE)));
    assert_eq!(
        alone.notes,
        [
            "a.glb: there is no light in it: an even white sky stands in",
            "a.glb: there is no camera in it: one was chosen that sees everything",
        ]
    );
    builder.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [
        {"type": "point", "color": [1.0, 0.5, 0.0], "intensity": 10.0},
        {"type": "directional", "intensity": 3.0},
        {"type": "spot", "intensity": 2.0, "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.2}},
    ]}});
    builder.json["cameras"] =
        json!([{"name": "eye", "type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}}]);
    let light = |i: u32| json!({"KHR_lights_punctual": {"light": i}});
    let half = std::f32::consts::FRAC_1_SQRT_2;
    builder.json["nodes"] = json!([
        {"mesh": 0},
        {"translation": [1.0, 2.0, 3.0], "extensions": light(0)},
        // -z becomes -y.
        {"rotation": [-half, 0.0, 0.0, half], "extensions": light(1)},
        {"extensions": light(2)},
        {"translation": [0.0, 0.0, 5.0], "camera": 0},
    ]);
    builder.json["scenes"] = json!([{"nodes": [0, 1, 2, 3, 4]}]);
    let loaded = sound(&builder);
    assert_eq!(loaded.notes, [""; 0]);
    assert_eq!(loaded.scene.environment, None);
    let intensity = Rgb::new(10.0, 5.0, 0.0);
    let lights = &loaded.scene.lights;
    assert_eq!(
        lights[0],
        Light::Point { position: Vec3::new(1.0, 2.0, 3.0), intensity, group: None }
    );
    let Light::Directional { direction, irradiance, group: None } = lights[1] else { panic!() };
    assert!((direction - Vec3::NEG_Y).length() < 1e-6 && irradiance == Rgb::grey(3.0));
    assert!(matches!(lights[2], Light::Spot { inner: 0.1, outer: 0.2, .. }));
    let camera = &loaded.cameras[0];
    assert_eq!((&*camera.name, camera.position), ("eye", Vec3::new(0.0, 0.0, 5.0)));
    let pose = loaded.scene.camera.world_from_camera();
    assert!((pose.vector(Vec3::NEG_Z) - Vec3::NEG_Z).length() < 1e-6);
}

/// A mesh is stored once however often it stands somewhere; what is scaled to nothing is not there.
#[test]
fn meshes_are_shared() {
    let mut builder = Builder::triangle();
    let places = builder.floats("VEC3", &[0.0, 0.0, 0.0, 5.0, 0.0, 0.0]);
    builder.json["nodes"] = json!([
        {"mesh": 0},
        {"mesh": 0, "scale": [-1.0, 1.0, 1.0]},
        {"mesh": 0, "scale": [0.0, 0.0, 0.0]},
        {"mesh": 0, "translation": [0.0, 1.0, 0.0],
         "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": places}}}},
    ]);
    builder.json["scenes"] = json!([{"nodes": [0, 1, 2, 3]}]);
    let scene = sound(&builder).scene;
    assert_eq!((scene.meshes.len(), scene.objects.len()), (1, 4));
    assert!(scene.objects[1].world_from_object.mirrors());
    assert_eq!(scene.objects[3].world_from_object.translation(), Vec3::new(5.0, 1.0, 0.0));
}

/// A picture that is missing is magenta, or refused; so is a variant that there is not.
#[test]
fn what_is_missing_is_told() {
    let mut builder = Builder::triangle();
    builder.push("images", json!({"uri": "none%20there.png"}));
    builder.push("textures", json!({"source": 0}));
    builder.json["materials"] =
        json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]);
    builder.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    let loaded = sound(&builder);
    let what = "a.glb: there is no file \"none%20there.png\" beside the scene";
    assert_eq!(loaded.notes[0], format!("{what}: magenta stands in"));
    let strict = ReadOptions { strict: true, ..ReadOptions::default() };
    assert_eq!(scene(&builder, &strict).expect_err("missing"), what);
    let variant = ReadOptions { variant: Some("red"), ..ReadOptions::default() };
    let error = scene(&builder, &variant).expect_err("no such");
    assert_eq!(error, "a.glb: no variant \"red\": the file has none");
    // Nor is there an animation, and no time is no number.
    let at = |seconds| ReadOptions { at_time: Some(seconds), ..ReadOptions::default() };
    let notes = scene(&builder, &at(1.0)).expect("a scene").notes;
    assert!(notes.contains(&"a.glb: nothing in it moves, whatever time is asked for".to_owned()));
    for seconds in [f32::NAN, f32::INFINITY] {
        let error = scene(&builder, &at(seconds)).expect_err("no time");
        assert!(error.ends_with("s, but must be finite"), "{error}");
    }
}

/// A picture in the document that is none, or of another kind, is told by what it is.
#[test]
fn other_pictures_are_magenta() {
    let mut builder = Builder::triangle();
    let view = builder.view(b"\xabKTX 20\xbb\r\n\x1a\n");
    builder.push("images", json!({"bufferView": view, "mimeType": "image/ktx2"}));
    builder.push("textures", json!({"source": 0}));
    builder.json["materials"] =
        json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]);
    builder.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    let what = "a.glb: images[0]: its 12 bytes are of no image format read here: magenta stands in";
    assert_eq!(sound(&builder).notes[0], what);
}

/// What no weight and no skin bends is one mesh, however often it stands somewhere; what is bent is
/// another one at each node, counts for the limits, and is refused before copies of a small file take
/// a large machine.
#[test]
fn bent_copies_are_counted() {
    let mut builder = Builder::triangle();
    let up = builder.floats("VEC3", &[0.0, 0.0, 8.0].repeat(3));
    let targets = json!([{"POSITION": up}]);
    builder.json["meshes"][0]["primitives"][0]["targets"] = targets.clone();
    let node = |weight: f32| json!({"mesh": 0, "weights": [weight]});
    builder.json["nodes"] = json!([node(1.0), node(0.0), node(0.5), node(0.0)]);
    builder.json["scenes"] = json!([{"nodes": [0, 1, 2, 3]}]);
    let loaded = sound(&builder);
    let heights: Vec<_> = loaded
        .scene
        .objects
        .iter()
        .map(|object| match object.shape {
            Shape::Mesh(id) => loaded.scene.meshes[id.0 as usize].positions[0].z,
            ref other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!((heights, loaded.scene.meshes.len()), (vec![8.0, 0.0, 4.0, 0.0], 3));
    for (name, needed) in [("vertices", 9), ("triangles", 3)] {
        let mut options = ReadOptions::default();
        *options.limits.by_name(name).expect(name) = needed;
        assert!(scene(&builder, &options).is_ok());
        *options.limits.by_name(name).expect(name) = needed - 1;
        let error = scene(&builder, &options).expect_err("too many");
        let expected = format!(
            "a.glb: {needed} {name}, but at most {} are allowed; allow more with --limit {name}=N",
            needed - 1
        );
        assert_eq!(error, expected);
    }

    // Vertices that no bytes back: a copy takes 60,000 of 40 bytes, 20,000 triangles of 12.
    let many =
        builder.push("accessors", json!({"componentType": 5126, "type": "VEC3", "count": 60_000}));
    let mut bomb = |targets: &serde_json::Value, weight| {
        builder.json["meshes"] =
            json!([{"primitives": [{"attributes": {"POSITION": many}, "targets": targets}]}]);
        builder.json["nodes"] = json!(vec![node(weight); 100]);
        builder.json["scenes"] = json!([{"nodes": (0..100).collect::<Vec<_>>()}]);
        scene(&builder, &ReadOptions::default())
    };
    let targets = json!([{"POSITION": many}]);
    let loaded = bomb(&targets, 0.0).expect("nothing bends it");
    assert_eq!((loaded.scene.meshes.len(), loaded.scene.objects.len()), (1, 100));
    // A target that says nothing bends nothing.
    assert_eq!(bomb(&json!([{}]), 1.0).expect("nothing bends it").scene.meshes.len(), 1);
    let error = bomb(&targets, 1.0).expect_err("too much");
    assert!(
        error.contains("bends its mesh, which makes, with those before it, copies of"),
        "{error}"
    );
}

/// Images that are the same bytes are one picture, unpacked once.
#[test]
fn one_view_is_one_picture() {
    let mut builder = Builder::triangle();
    let first = picture(&mut builder, [10, 20, 30, 255]);
    let other = picture(&mut builder, [40, 50, 60, 255]);
    let image = builder.json["images"][0].clone();
    let image = builder.push("images", image);
    let again = builder.push("textures", json!({"source": image}));
    let primitive = |material| json!({"attributes": {"POSITION": 0}, "material": material});
    builder.json["meshes"] = json!([{"primitives": [primitive(0), primitive(1), primitive(2)]}]);
    for texture in [first, again, other] {
        let color = json!({"baseColorTexture": {"index": texture}});
        builder.push("materials", json!({"pbrMetallicRoughness": color}));
    }
    let scene = sound(&builder).scene;
    assert_eq!((scene.textures.len(), scene.bitmaps.len()), (3, 2));
    let shown = scene.materials.iter().map(|material| {
        let id = principled(material).textures.base_color.expect("a picture");
        texel(&scene, id).0[0]
    });
    assert_eq!(shown.collect::<Vec<_>>(), [10, 10, 40]);
}

/// Very many pictures that are missing are a few lines and a number.
#[test]
fn notes_on_pictures_come_to_an_end() {
    let mut builder = Builder::triangle();
    let mut primitives = Vec::new();
    for i in 0..1000 {
        builder.push("images", json!({"uri": format!("p{i}.png")}));
        builder.push("textures", json!({"source": i}));
        let color = json!({"baseColorTexture": {"index": i}});
        builder.push("materials", json!({"pbrMetallicRoughness": color}));
        primitives.push(json!({"attributes": {"POSITION": 0}, "material": i}));
    }
    builder.json["meshes"] = json!([{"primitives": primitives}]);
    let notes = sound(&builder).notes;
    assert!(notes.len() < 20, "{}", notes.len());
    assert!(notes[15].contains("\"p15.png\""), "{}", notes[15]);
    let more = "a.glb: … and 984 more pictures that cannot be read: magenta stands in";
    assert!(notes.iter().any(|note| note == more), "{notes:?}");
}
