//! MTL: what materials of several exporters become, worked out by hand; and no material at all.
//!
//! Single statements, notes and errors are in `obj.rs`.

use rutilant::color::Rgb;
use rutilant::material::{
    Absorption, Bumps, EmittedLight, Material, MaterialKind, Opacity, OpacityMode,
};
use rutilant::scene::TextureId;
use rutilant::texture::{Channel, Encoding};
use rutilant::{Prepared, Session};
use rutilant_formats::scene::mtl;
use rutilant_formats::{Limits, ReadOptions, read_scene};
use rutilant_geom::Vec2;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// A line for each material, and one for each part of a mix.
fn dump(materials: &[Material]) -> String {
    let mut text = String::new();
    for material in materials {
        let name = if material.name.is_empty() { "  part" } else { &*material.name };
        write!(text, "{name}: {}", kind(&material.kind)).expect("text");
        if let Some(emission) = material.emission {
            let EmittedLight::Radiance(radiance) = emission.light else { panic!("a power") };
            assert!(!emission.two_sided);
            write!(text, ", glows {}", color(radiance)).expect("text");
        }
        text.push('\n');
    }
    text
}

fn kind(kind: &MaterialKind) -> String {
    let rough = |roughness: f32| match roughness {
        0.0 => String::new(),
        _ => format!(", rough {}", number(roughness)),
    };
    match kind {
        MaterialKind::Matte(matte) => {
            format!("matte {}{}", color(matte.albedo.factor), rough(matte.roughness))
        }
        MaterialKind::Mirror(mirror) => format!("mirror {}", color(mirror.reflectance)),
        MaterialKind::Conductor(metal) => {
            // Fresnel's equations at normal incidence: what is seen of the index.
            let seen = std::array::from_fn(|c| {
                let (n, k) = (metal.eta.0[c], metal.k.0[c]);
                ((n - 1.0) * (n - 1.0) + k * k) / ((n + 1.0) * (n + 1.0) + k * k)
            });
            format!("metal {}{}", color(Rgb(seen)), rough(metal.roughness))
        }
        MaterialKind::Dielectric(glass) => {
            let tint = match glass.interior.absorption {
                Absorption::None => String::new(),
                Absorption::ColorAtDistance { color: tint, distance } => {
                    format!(", {} after {} m", color(tint), number(distance))
                }
                Absorption::Coefficient(_) => panic!("no statement gives a coefficient"),
            };
            format!("glass {}{}{tint}", number(glass.interior.ior), rough(glass.roughness))
        }
        MaterialKind::Principled(p) => {
            let mut text = format!("layers {}{}", color(p.base_color), rough(p.roughness));
            for (name, part) in [
                ("metal", p.metallic),
                ("coat", p.coat),
                ("coat rough", p.coat_roughness),
                ("sheen", p.sheen_color.0[0]),
                ("brushed", p.anisotropy),
                ("turned", p.anisotropy_rotation.to_degrees()),
                ("clear", p.transmission),
            ] {
                if part != 0.0 {
                    write!(text, ", {name} {}", number(part)).expect("text");
                }
            }
            text
        }
        MaterialKind::Mix(mix) => format!("mix {}", number(mix.amount)),
        other => format!("{other:?}"),
    }
}

fn color(color: Rgb) -> String {
    color.0.map(number).join(" ")
}

/// Three digits behind the point, without the zeros.
fn number(number: f32) -> String {
    let text = format!("{number:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// A file, what it becomes, and what is said about it.
const GOLDEN: &[(&str, &str, &[&str])] = &[
    // Blender. Its Ks of 0.5 is its own default, and Ni that of a varnish, which reflects
    // (0.45 / 2.45)² = 0.0337 of the light: half of that is 0.0169, and 0.8 / (1 - 0.0169) is
    // 0.814. Ns 250: α = √(2 / 252) = 0.0891, whose root is 0.298. Metal is illum 3: with Kd 0.8
    // and Ks 0.5 it would send back 1.3, so both are dimmed by that: a share of 0.5 / 1.3.
    (
        "# Blender 3.6\nnewmtl Material\nNs 250.000000\nKa 1.0 1.0 1.0\nKd 0.8 0.8 0.8\n\
         Ks 0.5 0.5 0.5\nKe 0.0 0.0 0.0\nNi 1.450000\nd 1.000000\nillum 2\n\
         newmtl Glass\nNs 1000\nKd 0.8 0.8 0.8\nKs 0.5 0.5 0.5\nNi 1.45\nd 0.2\nillum 9\n\
         newmtl Metal\nNs 1000\nKa .9 .9 .9\nKd .8 .8 .8\nKs .5 .5 .5\nNi 1.45\nd 1\nillum 3\n\
         newmtl Lamp\nKd .8\nKs .5\nKe 5 4 3\nNi 1.45\nillum 1\n",
        "Material: mix 0.017\n  part: matte 0.814 0.814 0.814\n  part: metal 1 1 1, rough 0.298\n\
         Glass: glass 1.45\n\
         Metal: mix 0.385\n  part: matte 1 1 1\n  part: metal 1 1 1, rough 0.211\n\
         Lamp: matte 0.8 0.8 0.8, glows 5 4 3\n",
        &[],
    ),
    // The physically based additions: layers over Kd, a quarter of a turn being 90°. Glass without
    // layers is plain glass; a coat's roughness is nothing without a coat.
    (
        "newmtl gold\nKd 1 .77 .34\nPm 1\nPr .3\nPs 0\nPc 0\nPcr 0.03\naniso 0\nanisor 0\n\
         newmtl worn\nKd .5\nPm .5\nPr .2\n\
         newmtl plastic\nKd .2 .4 .6\nKs 1 1 1\nNs 10\nPm 0\nPr .4\nillum 2\n\
         newmtl frosted\nKd .8\nPr .5\nNi 1.33\nTf .9 1 .9\nillum 7\n\
         newmtl polished\nKd .9\nPm 1\nPr 0\n\
         newmtl car\nKd .1 0 0\nPr .4\nPc 1\nPcr .1\nPs .3\nnorm -imfchan l flakes.png\n\
         newmtl brushed\nPm 0\naniso .6\nanisor .25\nnewmtl bottle\nd .5\nPc .5\n",
        "gold: layers 1 0.77 0.34, rough 0.3, metal 1\n\
         worn: layers 0.5 0.5 0.5, rough 0.2, metal 0.5\n\
         plastic: layers 0.2 0.4 0.6, rough 0.4\n\
         frosted: glass 1.33, rough 0.5, 0.9 1 0.9 after 1 m\n\
         polished: layers 0.9 0.9 0.9, metal 1\n\
         car: layers 0.1 0 0, rough 0.4, coat 1, coat rough 0.1, sheen 0.3\n\
         brushed: layers 0.8 0.8 0.8, rough 0.5, brushed 0.6, turned 90\n\
         bottle: layers 1 1 1, coat 0.5, clear 1\n",
        &[],
    ),
    // A classic: mirror and glass by illum, a lamp by Ke; Ks without an index is meant as it is.
    // 0.725 + 0.725 = 1.45: half and half. Ns 500: α = √(2 / 502) = 0.0631, its root 0.251.
    (
        "newmtl floor\nNs 10\nNi 1\nillum 2\nKa .725 .71 .68\nKd 0.725 0.71 0.68\nKs 0 0 0\n\
         newmtl box\nNs 500\nNi 1\nillum 2\nKd 0.725 0.725 0.725\nKs 0.725 0.725 0.725\n\
         newmtl left\nNs 1000\nNi 1.5\nillum 5\nKd 0 0 0\nKs .95 .95 .95\n\
         newmtl right\nNs 200\nNi 1.5\nillum 7\nKd .01 .01 .01\nKs .95 .95 .95\nTf 1 1 1\n\
         newmtl light\nKd .78\nKe 17 12 4\n",
        "floor: matte 0.725 0.71 0.68\n\
         box: mix 0.5\n  part: matte 1 1 1\n  part: metal 1 1 1, rough 0.251\n\
         left: mirror 0.95 0.95 0.95\n\
         right: glass 1.5\n\
         light: matte 0.78 0.78 0.78, glows 17 12 4\n",
        &[],
    ),
    // 3ds Max: tabs, blanks in names, Tr beside d, empty map statements, names with backslashes.
    (
        "newmtl _Material #25\n\tNs 32.0000\n\tNi 1.5000\n\td 1.0000\n\tTr 0.0000\n\
         \tTf 1.0000 1.0000 1.0000 \n\tillum 2\n\tKa 0.588 0.588 0.588\n\tKd 0.588 0.588 0.588\n\
         \tKs 0.0000 0.0000 0.0000\n\tKe 0.0000 0.0000 0.0000\n\tmap_Ka \n\
         \tmap_Kd maps\\wood floor.jpg\n\tmap_bump -bm 0.3 -s 2 2 wood b.jpg\n\
         \tbump wood b.jpg\n\trefl -type sphere -mm 0 1 clouds.mpc\n",
        "_Material #25: matte 0.588 0.588 0.588\n",
        &["a.mtl:16: textures of other kinds are not read: 1 (refl; first \"clouds.mpc\")"],
    ),
    // How light goes through: d and Tr are one thing, and illum another word for it.
    (
        "newmtl a\nd 0.99\nnewmtl b\nTr 0.01\nnewmtl c\nTr 0\nnewmtl d\nillum 6\nNi 2.4\n\
         newmtl e\nillum 4\nKd 0 0 0\nnewmtl f\nd -halo 0.5\nTf 0.5\n",
        "a: glass 1.5\nb: glass 1.5\nc: matte 0.8 0.8 0.8\nd: glass 2.4\ne: glass 1.5\n\
         f: glass 1.5, 0.5 0.5 0.5 after 1 m\n",
        &["a.mtl:14: \"d -halo\" is not read"],
    ),
    // Gloss by illum: none for 0 and 1, none without a width for 2, sharp for 5. A dark Kd is a
    // metal's, whatever Ni. The gloss takes the share of its brightest channel, and has its
    // colour of that.
    (
        "newmtl off\nillum 0\nKs 1\nNs 9\nKd .5\nnewmtl plain\nillum 1\nKs 1\nNs 9\nKd .5\n\
         newmtl wide\nKs .4\nKd .5\n\
         newmtl copper\nillum 2\nKd 0\nKs .9 .6 .3\nNs 14\nNi 1.5\n\
         newmtl tinted\nillum 5\nKd .2 .4 .3\nKs .5 .25 0\nNs 14\n\
         newmtl sharp\nillum 3\nKd .5\nKs .25\n\
         newmtl eight\nillum 8\nKd 0\nKs .5\nNs 0\n",
        "off: matte 0.5 0.5 0.5\nplain: matte 0.5 0.5 0.5\nwide: matte 0.5 0.5 0.5\n\
         copper: metal 0.9 0.6 0.3, rough 0.595\n\
         tinted: mix 0.5\n  part: matte 0.4 0.8 0.6\n  part: mirror 1 0.5 0\n\
         sharp: mix 0.25\n  part: matte 0.667 0.667 0.667\n  part: mirror 1 1 1\n\
         eight: metal 0.5 0.5 0.5, rough 1\n",
        &[],
    ),
    // Highlights of 1990: without any Ni, Ks times 8 / (Ns + 2), 0.04 at least and 1 at most.
    // roof: 0.45 · 8/34 = 0.106, 0.588 / (1 − 0.106) = 0.658, (2/34)^¼ = 0.492. sharp: 0.5 · 0.04.
    (
        "newmtl roof\nillum 2\nKd .588\nKs .45\nNs 32\nnewmtl sharp\nKd .5\nKs .5\nNs 1000\n\
         newmtl wide\nKd .5\nKs .5\nNs 2\nnewmtl steel\nKd 0\nKs .9\nNs 32\n",
        "roof: mix 0.106\n  part: matte 0.658 0.658 0.658\n  part: metal 1 1 1, rough 0.492\n\
         sharp: mix 0.02\n  part: matte 0.51 0.51 0.51\n  part: metal 1 1 1, rough 0.211\n\
         wide: mix 0.5\n  part: matte 1 1 1\n  part: metal 1 1 1, rough 0.841\n\
         steel: metal 0.9 0.9 0.9, rough 0.492\n",
        &[],
    ),
];

#[test]
fn materials_become_what_was_worked_out() {
    for (text, expected, notes) in GOLDEN {
        let library = mtl::read_bytes(text.as_bytes(), Path::new("a.mtl"))
            .unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(dump(&library.materials), *expected, "{text}");
        assert_eq!(library.notes, *notes, "{text}");
    }
}

/// Pictures of gloss, of what is not there, and of heights. A gloss that is painted is that of layers of
/// index 1.5, or of Ni, which reflect Ks (times 0.04 or 8/34) where the picture is white.
#[test]
fn gloss_holes_and_heights_are_painted() {
    let text = "newmtl varnish\nKd .5\nKs .5 .25 0\nNs 32\nNi 1.5\nmap_Ks a.png\nmap_Kd b.png\n\
                newmtl bare\nKd .5\nNs 32\nmap_Ks a.png\n\
                newmtl mirror\nKd .2\nKs .3\nillum 5\nmap_Ks a.png\n\
                newmtl dull\nKd .5\nillum 1\nNs 9\nmap_Ks a.png\n\
                newmtl leaf\nTr 1\nmap_Tr c.png\n\
                newmtl veil\nd .5\nmap_Kd b.png\nmap_Tr b.png\n\
                newmtl bumpy\nmap_bump -s 2 2 -bm 0.03 c.png\n\
                newmtl bumps\nbump c.png\n\
                newmtl both\nnorm a.png\nmap_Bump -bm 2 c.png\n\
                newmtl paint\nPr .3\nNi 12\nmap_Ks a.png\n\
                newmtl jar\nd .5\nmap_Ks a.png\n";
    let library = mtl::read_bytes(text.as_bytes(), Path::new("a.mtl")).expect("materials");
    let named = |name: &str| library.materials.iter().find(|m| m.name == name).expect("it");
    let file = |id: TextureId| {
        let texture = &library.textures[id.0 as usize];
        (&*library.pictures[texture.bitmap.0 as usize].name, texture.encoding)
    };
    let layers = |name: &str| match &named(name).kind {
        MaterialKind::Principled(layers) => **layers,
        other => panic!("{other:?}"),
    };
    for (name, expected, roughness) in [
        ("varnish", [0.5, 0.25, 0.0], 0.492),
        ("bare", [8.0 / 34.0 / 0.04; 3], 0.492),
        ("mirror", [0.3 / 0.04; 3], 0.0),
    ] {
        let layers = layers(name);
        let picture = layers.textures.specular_color.expect("a picture");
        assert_eq!(file(picture), ("a.png", Encoding::Srgb));
        assert!((layers.roughness - roughness).abs() < 1e-3 && layers.ior == 1.5, "{name}");
        for (found, expected) in layers.specular_color.0.into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-4 * expected.max(1.0), "{name}: {found}");
        }
    }
    let painted = layers("varnish").textures.base_color.expect("a picture");
    assert_eq!(file(painted), ("b.png", Encoding::Srgb));
    assert!(matches!(named("dull").kind, MaterialKind::Matte(_)));

    for (name, picture, channel, factor) in
        [("leaf", "c.png", Channel::InverseRed, 1.0), ("veil", "b.png", Channel::InverseAlpha, 0.5)]
    {
        let amount = named(name).opacity.expect("holes").amount;
        let (texture, of) = amount.texture.expect("a picture");
        assert_eq!((file(texture), of), ((picture, Encoding::Linear), channel), "{name}");
        assert_eq!(amount.factor, factor, "{name}");
        assert!(matches!(named(name).kind, MaterialKind::Matte(_)), "{name} is no glass");
    }

    for (name, picture, scale, shows) in [
        ("bumpy", "c.png", 0.03, Bumps::Heights),
        ("bumps", "c.png", 1.0, Bumps::Heights),
        ("both", "a.png", 1.0, Bumps::Normals),
    ] {
        let map = named(name).normal_map.expect("bumps");
        assert_eq!((map.scale, map.shows), (scale, shows), "{name}");
        assert_eq!(file(map.texture), (picture, Encoding::Linear), "{name}");
    }
    let bumpy = named("bumpy").normal_map.expect("bumps").texture;
    assert_eq!(library.textures[bumpy.0 as usize].mapping.scale, Vec2::splat(2.0));
    let left_out = "map_Ks is left out on glass and beside Pr, Pm, Pc, Ps, aniso";
    assert_eq!(
        library.notes,
        [
            "a.mtl:33: material \"both\": bump is left out beside norm",
            &format!("a.mtl:36: material \"paint\": {left_out}"),
            "a.mtl:36: material \"paint\": Ni 12 is taken as 10",
            &format!("a.mtl:40: material \"jar\": {left_out}"),
        ]
    );
}

/// No material sends back more than it gets, in any channel, whatever Kd and Ks are.
#[test]
fn nothing_sends_back_more_than_it_gets() {
    let steps = [0.0_f32, 0.01, 0.3, 0.5, 0.8, 1.0];
    for kd in steps {
        for ks in steps {
            for rest in
                ["illum 5", "illum 3\nNs 20", "illum 2\nNs 5", "illum 2\nNs 5\nNi 1.5", "Pr .2"]
            {
                let text = format!("newmtl m\nKd {kd} 0.2 0.4\nKs {ks} 0.5 0.1\n{rest}\n");
                let library = mtl::read_bytes(text.as_bytes(), Path::new("a.mtl")).expect("read");
                let [mixed, parts @ ..] = &*library.materials else { panic!("materials") };
                let color_of = |material: &Material| match &material.kind {
                    MaterialKind::Matte(matte) => matte.albedo.factor.0,
                    MaterialKind::Mirror(mirror) => mirror.reflectance.0,
                    // That of a metal is at most 1 by Fresnel.
                    _ => [1.0; 3],
                };
                if let (MaterialKind::Mix(mix), [below, gloss]) = (&mixed.kind, parts) {
                    for channel in 0..3 {
                        let sum = (1.0 - mix.amount) * color_of(below)[channel]
                            + mix.amount * color_of(gloss)[channel];
                        assert!(sum <= 1.000_001, "{text}: {sum}");
                    }
                    // And nothing was dimmed that need not be.
                    let fits = kd.max(0.4) + ks.max(0.5) <= 1.0;
                    if rest == "illum 5" && fits {
                        let kept = color_of(below)[0] * (1.0 - mix.amount);
                        assert!((kept - kd).abs() < 1e-6, "{text}: {kept}");
                    }
                }
            }
        }
    }
}

/// The picture of an OBJ file of two materials, of which the second has no `usemtl` of its own.
fn picture(obj: &str, shape: &str) -> u64 {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = format!(
        "version = 1\nrender = {{ size = [24, 16], spp = 4 }}\n\
         camera = {{ position = [0, 0, 4], look_at = [0, 0, 0] }}\n\
         environment = {{ color = [0.5, 0.7, 0.9] }}\n\
         [[material]]\nname = \"backup\"\ntype = \"matte\"\nalbedo = [0.25, 0.5, 0.75]\n\
         [[shape]]\ntype = \"mesh\"\nfile = \"a.obj\"\n{shape}\n"
    );
    fs::write(folder.path().join("scene.toml"), scene).expect("a scene");
    fs::write(folder.path().join("a.obj"), obj).expect("a mesh");
    fs::write(
        folder.path().join("a.mtl"),
        "newmtl own\nKd 0.25 0.5 0.75\nillum 1\nnewmtl red\nKd 1 0 0\nillum 1\n",
    )
    .expect("materials");
    let loaded = read_scene(&folder.path().join("scene.toml"), &ReadOptions::default())
        .unwrap_or_else(|error| panic!("{error}"));
    let prepared = Arc::new(Prepared::new(&loaded.scene).expect("a scene"));
    let session = Session::start(prepared, loaded.settings, 1).expect("settings");
    assert!(session.wait(Duration::from_secs(60)), "no end");
    session.snapshot().hash()
}

/// A mesh without a material renders as its backup material, to the bit: as if the file had
/// that material. The old program gave such meshes whatever the last one had.
#[test]
fn a_mesh_without_material_is_its_backup() {
    const VERTICES: &str =
        "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nv -1 -1 1\nv 0 -1 1\nv -1 0 1\n";
    let with =
        |first: &str, second: &str| format!("{VERTICES}{first}f 1 2 3\nf 1 3 4\n{second}f 5 6 7\n");
    let expected = picture(&with("mtllib a.mtl\nusemtl own\n", "usemtl red\n"), "");
    for first in ["mtllib a.mtl\n", "mtllib a.mtl\nusemtl undeclared\n", "mtllib a.mtl\nusemtl\n"] {
        let obj = with(first, "usemtl red\n");
        assert_eq!(picture(&obj, "material = \"backup\""), expected, "{first}");
    }
    // Where the file speaks of no material at all.
    let plain = with("", "");
    let all_own = with("mtllib a.mtl\nusemtl own\n", "");
    assert_eq!(picture(&plain, "material = \"backup\""), picture(&all_own, ""));
    // A backup is for what has none: it changes nothing where the file has its own.
    assert_eq!(picture(&all_own, "material = \"backup\""), picture(&all_own, ""));
}

/// What the MTL files of other people become, kinds counted by hand from the files.
#[test]
fn real_files_become_what_they_say() {
    let Some(data) = std::env::var_os("RUTILANT_DATA") else {
        eprintln!("skipped: RUTILANT_DATA names no folder with obj-mtl");
        return;
    };
    for (file, expected) in REAL {
        let path = Path::new(&data).join("obj-mtl").join(file);
        let library = mtl::read(&path, &Limits::default()).unwrap_or_else(|e| panic!("{e}"));
        let mut counts = [0; 5];
        for material in library.materials.iter().filter(|m| !m.name.is_empty()) {
            counts[match material.kind {
                MaterialKind::Matte(_) => 0,
                MaterialKind::Mirror(_) | MaterialKind::Conductor(_) => 1,
                MaterialKind::Principled(_) => 3,
                MaterialKind::Dielectric(_) => 2,
                MaterialKind::Mix(_) => 3,
                _ => panic!("{file}: {material:?}"),
            }] += 1;
            counts[4] += usize::from(material.emission.is_some());
        }
        assert_eq!(counts, *expected, "{file}: {}", dump(&library.materials));
    }
}

/// Matte, mirrors and metals, glass, mixes; and how many of them glow.
const REAL: &[(&str, [usize; 5])] = &[
    ("cornell-mcguire/cornell_box.mtl", [8, 0, 0, 0, 1]),
    ("cornell-mcguire/cornell_box_glossy.mtl", [6, 0, 0, 2, 2]),
    ("cornell-mcguire/cornell_box_specular.mtl", [5, 0, 1, 2, 1]),
    ("cornell-mcguire/cornell_box_water.mtl", [5, 0, 2, 2, 1]),
    ("medieval-building/Medieval_building.mtl", [44, 0, 0, 18, 0]),
    ("simple/cube.mtl", [0, 0, 0, 1, 0]),
    ("simple/cube_multi.mtl", [6, 0, 0, 0, 0]),
    ("simple/plane.mtl", [0, 0, 0, 1, 0]),
    ("spider/spider.mtl", [5, 0, 0, 0, 0]),
    ("sponza-dabrovic/sponza.mtl", [19, 0, 0, 0, 0]),
    ("tinyobj-cornell/cornell_box.mtl", [5, 0, 0, 0, 0]),
];

/// Pictures arrive where they belong, with what their codes mean: light and colour as sRGB, numbers
/// and normals as they are. Numbers that a picture multiplies are 1 where they are absent or 0, and
/// holes are in the alpha of the picture of colours where it is the same.
#[test]
fn pictures_arrive() {
    let text = "newmtl a\nmap_Kd leaf.png\nmap_d leaf.png\nmap_Ke glow.png\nKe 0 0 0\n\
                newmtl b\nmap_d -s 2 2 holes.png\nd 0.5\nKe 1 2 3\nmap_Ke glow.png\n\
                newmtl c\nPr 0.5\nmap_Pr worn.png\nmap_Pm worn.png\nnorm bumps.png\n";
    let library = mtl::read_bytes(text.as_bytes(), "a.mtl".as_ref()).expect("sound");
    assert_eq!(library.notes, [""; 0]);
    let shown = |id: TextureId| {
        let texture = &library.textures[id.0 as usize];
        (&*library.pictures[texture.bitmap.0 as usize].name, texture.encoding)
    };
    let [a, b, c] = &library.materials[..] else { panic!("{:?}", library.materials) };
    let opacity = |material: &Material| {
        let Opacity { amount, mode, .. } = material.opacity.expect("holes");
        assert_eq!(mode, OpacityMode::Blend);
        let (id, channel) = amount.texture.expect("a picture");
        (amount.factor, shown(id), channel)
    };
    assert_eq!(opacity(a), (1.0, ("leaf.png", Encoding::Linear), Channel::Alpha));
    assert_eq!(opacity(b), (0.5, ("holes.png", Encoding::Linear), Channel::Red));
    for (material, radiance) in [(a, Rgb::WHITE), (b, Rgb::new(1.0, 2.0, 3.0))] {
        assert!(matches!(material.kind, MaterialKind::Matte(_)), "{material:?}");
        let emission = material.emission.expect("light");
        assert_eq!(emission.light, EmittedLight::Radiance(radiance));
        assert_eq!(emission.texture.map(shown), Some(("glow.png", Encoding::Srgb)));
    }
    let MaterialKind::Principled(layers) = &c.kind else { panic!("{c:?}") };
    assert_eq!((layers.roughness, layers.metallic), (0.5, 1.0));
    let worn = ("worn.png", Encoding::Linear);
    for texture in [layers.textures.roughness, layers.textures.metallic] {
        assert_eq!(texture.map(|(id, channel)| (shown(id), channel)), Some((worn, Channel::Red)));
    }
    let bumps = c.normal_map.expect("bumps");
    assert_eq!((shown(bumps.texture), bumps.scale), (("bumps.png", Encoding::Linear), 1.0));
}

/// Very many textures take a moment: each is looked up, and the file is walked once. When each was
/// compared with all before it, these took minutes.
#[test]
fn many_textures_are_read_at_once() {
    const COUNT: usize = 100_000;
    for (line, textures, pictures) in [
        (&(|i| format!("map_Kd p{i}.png\n")) as &dyn Fn(usize) -> String, COUNT, COUNT),
        (&|i| format!("map_Kd -s {i} 1 p.png\n"), COUNT, 1),
        (&|i| format!("map_Kd -o 0 {} p{}.png\n", i % 2, i % 3), 6, 3),
    ] {
        let text = format!("newmtl a\n{}", (0..COUNT).map(line).collect::<String>());
        let began = std::time::Instant::now();
        let library = mtl::read_bytes(text.as_bytes(), Path::new("a.mtl")).expect("read");
        assert_eq!((library.textures.len(), library.pictures.len()), (textures, pictures));
        let last = &library.pictures[pictures - 1];
        assert_eq!((last.at.line, last.at.column), (pictures as u32 + 1, 1));
        assert!(began.elapsed().as_secs() < 10, "{:?}", began.elapsed());
    }
}

/// Very many materials with the same flaw are a few lines and a number.
#[test]
fn notes_on_materials_come_to_an_end() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.obj");
    let group = |i: usize| format!("usemtl m{i}\nf 1/1 2/1 3/1\nf 1 2 3\n");
    let groups: String = (0..1000).map(group).collect();
    let text = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\n{groups}");
    fs::write(&path, text).expect("written");
    let notes = read_scene(&path, &ReadOptions::default()).expect("read").notes;
    let about = |note: &&String| note.contains("without texture coordinates");
    let about: Vec<_> = notes.iter().filter(about).collect();
    assert_eq!(about.len(), 17);
    assert!(about[15].ends_with(
        "triangles of material \"m15\" without texture coordinates, given (0, 0): 1 of 2"
    ));
    assert!(about[16].contains(": … and 984 more materials with triangles"), "{}", about[16]);
}
