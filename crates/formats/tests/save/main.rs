//! Edited scenes in their authors' text.

#[path = "../common/mod.rs"]
mod common;

use common::Random;
use rutilant::bsdf::{Distribution, Fresnel};
use rutilant::color::Rgb;
use rutilant::display::Curve;
use rutilant::film::Filter;
use rutilant::geom::Vec3;
use rutilant::light::{Environment, EnvironmentLight, Light, LightGroup, SpotLight};
use rutilant::material::{
    Absorption, Conductor, Dielectric, Emission, EmittedLight, HemisphereSampling, Material,
    MaterialKind, Matte, Metal, Mirror, Mix, Principled, Sides, ThinDielectric,
};
use rutilant::scene::MaterialId;
use rutilant::settings::{Heuristic, IntegratorKind, SamplerKind};
use rutilant_formats::camera::{AngleOfView, Aperture, CameraKind, FocusOn};
use rutilant_formats::{
    LoadedScene, Look, ReadOptions, native_for_mesh, parse_native, read_scene, rewrite,
};
use std::path::{Path, PathBuf};

const DOCUMENTATION: &str = include_str!("../../../../docs/scene-format.md");

/// A scene in every form that TOML has for its tables.
const FORMS: &str = r#"# Forms
version = 1 # first
render.spp = 4 # dotted
camera = { position = [0, 0, 5], look_at = [0, 0, 0], f_number = 2.80, focal_length_mm = 50 } # in
environment.color = "\u0023336699" # sky
light = [{ type = "point", position = [0, 1, 0], intensity = 3 }, { type = "spot", position = [0, 2, 0], look_at = [0, 0, 0], power = 5 }] # inline

  [[material]] # indented
  name = "a"
  type = "conductor"
  metal = "gold" # precious
# between
[material.emission]
radiance = 2.50 # glows
# after
[[material]]
name = 'b'
type = "matte"
emission.power = 3
emission.two_sided = true # both
[[material]]
name = "c"
type = "emissive"
power = 3
[[shape]]
type = "sphere"
radius = 1
material = 'a'
# the end"#;

/// Texts of scenes, and where they stand.
fn scenes() -> Vec<(String, PathBuf)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let here = folder.join("embedded.toml");
    let (_, example) = DOCUMENTATION.split_once("```toml\n").expect("an example");
    let example = example.split_once("```").expect("the end of the example").0;
    let least = "version = 1\n[[material]]\nname = \"a\"\ntype = \"matte\"\n\
                 [[shape]]\ntype = \"sphere\"\nradius = 1\nmaterial = \"a\"";
    let mut scenes: Vec<_> = [
        example.to_owned(),
        format!("\u{feff}{}", example.replace('\n', "\r\n")),
        FORMS.to_owned(),
        FORMS.replace('\n', "\r\n"),
        least.to_owned(),
        format!(
            "{least}\n[[camera]]\nname='x'\nposition=[0,0,9]\nlook_at=[0,0,0]\n\
                 [[camera]]\nname='y'\nposition=[0,9,9]\nlook_at=[0,0,0]\n"
        ),
    ]
    .map(|text| (text, here.clone()))
    .to_vec();
    for entry in std::fs::read_dir(&folder).expect("scenes") {
        let path = entry.expect("an entry").path();
        if path.extension().is_some_and(|end| end == "toml")
            && std::fs::metadata(&path).expect("a file").len() < 100_000
        {
            let text = std::fs::read_to_string(&path).expect("text");
            // Large meshes are read again for every edit.
            if read(&text, &path)
                .is_some_and(|s| s.scene.meshes.iter().all(|m| m.triangles.len() < 5000))
            {
                scenes.push((text, path));
            }
        }
    }
    scenes
}

fn read(text: &str, file: &Path) -> Option<LoadedScene> {
    parse_native(text, file, &ReadOptions::default()).ok()
}

fn save(text: &str, file: &Path, before: &LoadedScene, after: &Look) -> Result<String, String> {
    let options = ReadOptions::default();
    rewrite(text, file, &options, before, after, &before.image_names).map_err(|e| e.to_string())
}

fn rgb(random: &mut Random) -> Rgb {
    match random.below(3) {
        0 => Rgb::grey(random.unit()),
        1 => Rgb([random.unit(), random.unit(), random.unit()]),
        _ => Rgb([1.0, 0.5, 0.25]),
    }
}

fn point(random: &mut Random) -> Vec3 {
    Vec3::new(random.unit() * 9.0 - 4.0, random.unit() * 5.0, 4.0 + random.unit())
}

fn group(random: &mut Random) -> Option<LightGroup> {
    [None, Some("key"), Some("Fill_2")][random.below(3)].and_then(|name| LightGroup::new(name).ok())
}

fn emission(random: &mut Random) -> Emission {
    let light = rgb(random);
    let light = if random.below(2) == 0 {
        EmittedLight::Radiance(light)
    } else {
        EmittedLight::Power(light)
    };
    let (two_sided, group) = (random.below(2) == 0, group(random));
    Emission { light, two_sided, group, ..Emission::radiance(Rgb::WHITE) }
}

fn kind(random: &mut Random, plain: bool, parts: &[u32]) -> MaterialKind {
    match random.below(if plain { 6 } else { 9 }) {
        0 => MaterialKind::Black,
        1 => MaterialKind::Null,
        2 => MaterialKind::Matte(Matte {
            albedo: rgb(random).into(),
            roughness: 0.0,
            sampling: [HemisphereSampling::Cosine, HemisphereSampling::Uniform][random.below(2)],
        }),
        3 => MaterialKind::Mirror(Mirror { reflectance: rgb(random) }),
        4 => MaterialKind::Conductor(match random.below(2) {
            0 => Metal::Copper.conductor(random.unit()),
            _ => Conductor {
                distribution: [Distribution::Ggx, Distribution::Beckmann][random.below(2)],
                ..Conductor::new(rgb(random), rgb(random), 0.0)
            },
        }),
        5 => MaterialKind::ThinDielectric(ThinDielectric {
            ior: 1.0 + random.unit(),
            color: rgb(random),
        }),
        6 if parts.len() > 1 => MaterialKind::Mix(Mix {
            first: MaterialId(parts[random.below(parts.len())]),
            second: MaterialId(parts[random.below(parts.len())]),
            amount: random.unit(),
        }),
        7 => MaterialKind::Principled(Box::new(Principled {
            base_color: rgb(random),
            roughness: random.unit(),
            anisotropy_rotation: (360.0 * random.unit()).to_radians(),
            thin_walled: random.below(2) == 0,
            transmission: random.unit(),
            absorption: Absorption::Coefficient(rgb(random)),
            coat: random.unit(),
            coat_color: rgb(random),
            sheen_color: rgb(random),
            iridescence: random.unit(),
            iridescence_thickness_nm: 900.0 * random.unit(),
            iridescence_thickness_minimum_nm: 90.0 * random.unit(),
            ..Principled::default()
        })),
        _ => {
            let mut glass = Dielectric::new(1.0 + random.unit());
            glass.interior.absorption = match random.below(3) {
                0 => Absorption::None,
                1 => Absorption::Coefficient(rgb(random)),
                _ => Absorption::ColorAtDistance {
                    color: Rgb([0.1 + 0.5 * random.unit(), 0.5, 0.25]),
                    distance: [1.0, 0.3][random.below(2)],
                },
            };
            glass.dispersion = [0.0, 0.36][random.below(2)];
            glass.fresnel = [Fresnel::Exact, Fresnel::Schlick][random.below(2)];
            MaterialKind::Dielectric(glass)
        }
    }
}

fn light(random: &mut Random) -> Light {
    match random.below(3) {
        0 => Light::Point { position: point(random), intensity: rgb(random), group: group(random) },
        1 => Light::Directional {
            direction: point(random),
            irradiance: rgb(random),
            group: group(random),
        },
        _ => Light::Spot {
            position: point(random),
            direction: point(random),
            light: if random.below(2) == 0 {
                SpotLight::Power(rgb(random))
            } else {
                SpotLight::Intensity(rgb(random))
            },
            inner: (10.0 * random.unit()).to_radians(),
            outer: (20.0 + 20.0 * random.unit()).to_radians(),
            group: group(random),
        },
    }
}

/// One random change.
fn edit(look: &mut Look, random: &mut Random, own: usize) {
    let parts: Vec<u32> = (0..own as u32)
        .filter(|i| {
            !matches!(
                look.materials[*i as usize].kind,
                MaterialKind::Mix(_)
                    | MaterialKind::Dielectric(_)
                    | MaterialKind::Principled(_)
                    | MaterialKind::Custom(_)
            )
        })
        .collect();
    match random.below(16) {
        0 => look.camera.position = point(random),
        1 => {
            if let CameraKind::Perspective { view, .. } = &mut look.camera.kind {
                *view = match random.below(2) {
                    0 => AngleOfView::FovDegrees(10.0 + 60.0 * random.unit()),
                    _ => AngleOfView::FocalLengthMm(20.0 + 60.0 * random.unit()),
                };
            }
        }
        2 => {
            if let CameraKind::Perspective { lens, .. } = &mut look.camera.kind {
                lens.aperture = match random.below(3) {
                    0 => Aperture::Radius(0.0),
                    1 => Aperture::Radius(0.01 * random.unit()),
                    _ => Aperture::FNumber(1.0 + random.unit()),
                };
                lens.blades = [0, 5, 6][random.below(3)];
                lens.blade_rotation_degrees = 10.0 * random.unit();
            }
        }
        3 => {
            if let Some(lens) = look.camera.kind.lens_mut() {
                lens.focus = match random.below(3) {
                    0 => FocusOn::LookAt,
                    1 => FocusOn::Distance(1.0 + random.unit()),
                    _ => FocusOn::Pixel([1, 2]),
                };
            }
        }
        4 => look.camera.name = ["", "new \"one\"\n", "é"][random.below(3)].to_owned(),
        5 => {
            let image = look.environment.map(|sky| sky.light);
            look.environment = match random.below(3) {
                0 => None,
                1 => Some(Environment::constant(rgb(random))),
                _ => Some(Environment {
                    light: image.unwrap_or(EnvironmentLight::Constant(rgb(random))),
                    scale: random.unit(),
                    rotation: (360.0 * random.unit()).to_radians(),
                    group: group(random),
                }),
            };
        }
        6 | 7 if own > 0 => {
            // Nothing that others are mixed of may become what cannot be mixed.
            let i = random.below(own);
            let used = |m: &Material| matches!(&m.kind, MaterialKind::Mix(x) if [x.first.0, x.second.0].contains(&(i as u32)));
            let plain = look.materials.iter().any(used);
            let parts: Vec<u32> = parts.iter().copied().filter(|p| *p as usize != i).collect();
            let material = &mut look.materials[i];
            material.sides = [Sides::Both, Sides::Front][random.below(2)];
            material.kind = kind(random, plain, &parts);
            if matches!(&material.kind, MaterialKind::Dielectric(_)) {
                material.emission = None;
            }
        }
        8 if own > 0 => {
            let i = random.below(own);
            let glows = random.below(3) > 0;
            let material = &mut look.materials[i];
            let is_ordered =
                matches!(&material.kind, MaterialKind::Dielectric(d) if d.priority.is_some());
            material.emission = (glows && !is_ordered).then(|| emission(random));
        }
        9 if own > 0 => {
            let i = random.below(own);
            look.materials[i].name = format!("\"{i}\" is\n'renamed' é {}", random.below(1000));
        }
        10 => {
            let name = format!("new {}", look.materials.len());
            let kind = kind(random, false, &parts);
            look.materials.push(Material::new(kind).named(name));
        }
        11 => {
            let at = random.below(look.lights.len() + 1);
            look.lights.insert(at, light(random));
        }
        12 if !look.lights.is_empty() => {
            let at = random.below(look.lights.len());
            look.lights.remove(at);
        }
        13 if !look.lights.is_empty() => {
            let at = random.below(look.lights.len());
            look.lights[at] = light(random);
        }
        14 => {
            look.settings.spp = 1 + random.next() % 1000;
            look.settings.seed = random.next() >> 1;
            look.settings.max_depth = [None, Some(5)][random.below(2)];
            look.settings.integrator =
                [IntegratorKind::Path, IntegratorKind::Naive][random.below(2)];
            look.settings.sampler = SamplerKind::Independent;
            look.settings.heuristic = Heuristic::Balance;
            look.settings.filter = match random.below(3) {
                0 => Filter::Tent { radius: 0.5 },
                1 => Filter::Mitchell { radius: 2.0, b: random.unit(), c: 0.5 },
                _ => Filter::Gaussian { radius: 1.5, sigma: random.unit() + 0.1 },
            };
        }
        _ => {
            look.display.exposure = random.unit();
            look.display.curve = [Curve::Clip, Curve::Agx][random.below(2)];
        }
    }
}

/// What is not changed stays byte by byte.
#[test]
fn an_unchanged_look_leaves_the_text() {
    for (text, file) in scenes() {
        let before = read(&text, &file).unwrap_or_else(|| panic!("{}", file.display()));
        assert_eq!(save(&text, &file, &before, &before.look()).as_ref(), Ok(&text));
    }
}

/// Whatever is changed comes back, and no comment line is lost. That it comes back is what
/// `rewrite` itself checks before it gives a text; here it is that it gives one.
#[test]
fn edits_come_back() {
    let mut random = Random(5);
    let (mut done, mut refused) = (0, 0);
    for (text, file) in scenes() {
        let before = read(&text, &file).expect("a scene");
        let own = text.matches("[[material]]").count();
        for _ in 0..60 {
            let mut after = before.look();
            for _ in 0..=random.below(4) {
                edit(&mut after, &mut random, own);
            }
            let saved = match save(&text, &file, &before, &after) {
                Ok(saved) => saved,
                // Some edits make no sense together; the reader says so.
                Err(error) if error.contains("with these changes it would be refused") => {
                    let known = [
                        "the lens has a radius",
                        "behind the camera",
                        "a priority",
                        "cannot be mixed",
                        "itself a mix",
                        "needs a name",
                        "names must differ",
                        "name is empty",
                        "each needs one",
                        "needs \"name\"",
                        "schlick",
                    ];
                    assert!(known.iter().any(|k| error.contains(k)), "{error}\n{after:?}\n{text}");
                    refused += 1;
                    continue;
                }
                Err(error) => panic!("{error}\n{:?}\n{after:?}\n{text}", before.look()),
            };
            done += 1;
            let read = read(&saved, &file).expect("a scene");
            assert_eq!(read.look().lights, after.lights);
            assert_eq!(read.look().settings, after.settings);
            if after.lights.len() >= before.scene.lights.len() && after.environment.is_some() {
                let mut lines = saved.lines();
                for comment in text.lines().filter(|line| line.starts_with('#')) {
                    assert!(lines.any(|line| line == comment), "{comment}\n{saved}");
                }
            }
            if text.contains("\r\n") {
                assert_eq!(saved.matches('\n').count(), saved.matches("\r\n").count(), "{saved}");
            }
        }
    }
    assert!(done > 10 * refused, "{done} {refused}");
}

/// A value is changed in its place, and what says the same in another way gives way.
#[test]
fn edits_are_small() {
    let file = Path::new("scene.toml");
    let before = read(FORMS, file).expect("a scene");
    let changed = |change: &dyn Fn(&mut Look), from: &str, to: &str| {
        let mut after = before.look();
        change(&mut after);
        let saved = save(FORMS, file, &before, &after).expect("a text");
        assert_eq!(saved, FORMS.replacen(from, to, 1));
    };
    changed(&|look| look.settings.spp = 9, "render.spp = 4 #", "render.spp = 9 #");
    changed(&|look| look.settings.seed = 9, "# dotted\n", "# dotted\nrender.seed = 9\n");
    changed(&|look| look.camera.position.x = 1.5, "position = [0, 0, 5]", "position = [1.5, 0, 5]");
    changed(
        &|look| {
            if let Some(lens) = look.camera.kind.lens_mut() {
                lens.aperture = Aperture::Radius(0.01);
            }
        },
        "f_number = 2.80",
        "aperture_radius = 0.01",
    );
    changed(
        &|look| {
            if let MaterialKind::Conductor(metal) = &mut look.materials[0].kind {
                metal.k = Rgb([1.0, 2.0, 3.0]);
            }
        },
        "  metal = \"gold\" # precious\n",
        "  eta = [0.301, 0.554, 1.35] # precious\n  k = [1, 2, 3]\n",
    );
    changed(
        &|look| look.materials[0].emission = Some(Emission::radiance(Rgb::grey(4.0))),
        "radiance = 2.50 #",
        "radiance = 4 #",
    );
    changed(
        &|look| {
            look.lights.remove(0);
        },
        "{ type = \"point\", position = [0, 1, 0], intensity = 3 }, ",
        "",
    );
    changed(
        &|look| look.environment = None,
        "environment.color = \"\\u0023336699\" # sky",
        "# sky",
    );
}

/// What a text cannot hold is an error, and so is the text of another scene.
#[test]
fn what_cannot_be_written_is_refused() {
    let file = Path::new("scene.toml");
    let before = read(FORMS, file).expect("a scene");
    let mut after = before.look();
    assert!(save(&FORMS.replace("radius = 1", "radius = 1 # 2"), file, &before, &after).is_ok());
    let other = FORMS.replace("intensity = 3", "intensity = 4");
    assert!(save(&other, file, &before, &after).is_err());
    for broken in ["", "version = 1", "[", "\u{feff}", "a = \"\"\"", "light = 5\nversion = 1"] {
        assert!(save(broken, file, &before, &after).is_err(), "{broken}");
    }
    after.materials.pop();
    let said = save(FORMS, file, &before, &after).expect_err("fewer materials");
    assert!(said.contains("materials cannot be taken away"), "{said}");
    let mut after = before.look();
    after.camera.position = Vec3::NAN;
    assert!(save(FORMS, file, &before, &after).is_err());
}

/// Damaged texts give errors, or texts, but no panics.
#[test]
fn damaged_texts_do_no_harm() {
    let file = Path::new("scene.toml");
    let before = read(FORMS, file).expect("a scene");
    let mut random = Random(3);
    let words: [&[u8]; 6] = [b"[[light]]\n", b"{", b"}", b"'''", b"\"", b"camera."];
    for seed in 0..3000 {
        let text = common::mutant(FORMS.as_bytes(), &words, seed);
        let Ok(text) = String::from_utf8(text) else { continue };
        let before = read(&text, file).unwrap_or_else(|| before.clone());
        let mut after = before.look();
        let own = text.matches("[[material]]").count().min(after.materials.len());
        edit(&mut after, &mut random, own);
        let _ = save(&text, file, &before, &after);
    }
}

/// A mesh file becomes a scene that shows the same.
#[test]
fn mesh_files_become_scenes() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let write = |name: &str, text: &str| std::fs::write(at(name), text).expect("a file");
    let faces = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
    write("own.mtl", "newmtl red\nKd 1 0 0\nnewmtl grey\nKd .1 .1 .1\nKs .5 .5 .5\nNs 9\n");
    write("bare \"é\".obj", &format!("{faces}f 1 2 3\n"));
    write(
        "own.obj",
        &format!("mtllib own.mtl\n{faces}f 2 3 4\nusemtl red\nf 1 2 3\nusemtl grey\nf 1 2 4\n"),
    );
    for name in ["bare \"é\".obj", "own.obj"] {
        let options = ReadOptions::default();
        let before = read_scene(&at(name), &options).expect("a mesh");
        let save = |after: &Look| {
            native_for_mesh(name, &at("new.toml"), &options, &before, after, &[])
                .map_err(|error| error.to_string())
        };
        let text = save(&before.look()).expect("a scene");
        let read = parse_native(&text, &at("new.toml"), &options).expect("a scene");
        assert_eq!(read.scene.camera, before.scene.camera);
        assert_eq!(read.scene.meshes.len(), before.scene.meshes.len());
        for (a, b) in read.scene.objects.iter().zip(&before.scene.objects) {
            let of =
                |s: &LoadedScene, id: MaterialId| s.scene.materials[id.0 as usize].name.clone();
            assert_eq!(of(&read, a.material), of(&before, b.material), "{text}");
        }
        let mut after = before.look();
        after.lights.push(light(&mut Random(1)));
        after.materials.last_mut().expect("grey").kind = MaterialKind::Black;
        after.materials.push(Material::from(Mirror { reflectance: Rgb::WHITE }).named("new"));
        save(&after).expect("a scene");
        if name == "own.obj" {
            after.materials[0].name = "blue".to_owned();
            let said = save(&after).expect_err("a change in the .mtl");
            assert!(said.contains("\"red\"") && said.contains("comes from a mesh file"), "{said}");
        }
    }
}

/// Materials of mesh files stay theirs; new ones come before them in the file. Maps of the sky keep
/// their names, whatever their numbers.
#[test]
fn materials_and_images_of_files_stay_theirs() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let write = |name: &str, text: &str| std::fs::write(at(name), text).expect("a file");
    write("a.mtl", "newmtl red\nKd 1 0 0\n");
    write("a.obj", "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n");
    let text = "version = 1\n[environment]\nimage = 'a.hdr'\n[[material]]\nname = \"own\"\n\
                type = \"matte\"\n[[shape]]\ntype = \"mesh\"\nfile = \"a.obj\"\n";
    let sky: &[u8] = b"PF\n2 1\n-1\n\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0";
    let embedded = [("a.hdr", sky), ("b \"b\".pfm", sky)];
    let hdr = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n\0\0\0\0\0\0\0\0";
    let embedded = [(embedded[0].0, &hdr[..]), embedded[1]];
    let options = ReadOptions { embedded: &embedded, ..ReadOptions::default() };
    let file = at("scene.toml");
    let before = parse_native(text, &file, &options).expect("a scene");
    let save = |after: &Look, names: &[String]| {
        rewrite(text, &file, &options, &before, after, names).map_err(|error| error.to_string())
    };

    let mut after = before.look();
    after.materials.push(Material::from(Matte::new(Rgb::WHITE)).named("new"));
    let saved = save(&after, &before.image_names).expect("a text");
    let names = parse_native(&saved, &file, &options).expect("a scene").scene.materials;
    let names: Vec<_> = names.iter().map(|material| material.name.as_str()).collect();
    assert_eq!(names, ["own", "new", "red"]);

    let mut after = before.look();
    let names = ["a.hdr".to_owned(), "b \"b\".pfm".to_owned()];
    after.environment = Some(Environment::image(rutilant::scene::ImageId(1)));
    let saved = save(&after, &names).expect("a text");
    assert_eq!(saved, text.replace("'a.hdr'", r#""b \"b\".pfm""#));

    let mut after = before.look();
    after.materials[1].name = "blue".to_owned();
    let said = save(&after, &before.image_names).expect_err("a change in the .mtl");
    let expected = "scene.toml: material \"red\" (number 1) comes from a mesh file, so the scene's \
                    text cannot change it";
    assert!(said.ends_with(expected), "{said}");
}
