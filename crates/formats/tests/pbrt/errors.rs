//! What is said of mistakes: one line, the place, what is wrong, what would be right.

use crate::{read, said, sound};
use rutilant_formats::{Limits, ReadOptions, SceneErrorKind, parse_pbrt};
use std::path::Path;
use std::time::{Duration, Instant};

/// Each mistake with its one line.
#[test]
fn errors_name_the_place() {
    let mut wrong = Vec::new();
    for (text, expected) in [
        // The text itself.
        ("", "a.pbrt: there is nothing to see in it"),
        ("# nothing", "a.pbrt: there is nothing to see in it"),
        ("Camera \"perspective\" WorldBegin", "a.pbrt: there is nothing to see in it"),
        ("Shpae \"sphere\"", "a.pbrt:1:1: no statement \"Shpae\"; did you mean \"Shape\"?"),
        ("\n  \"sphere\"", "a.pbrt:2:3: \"sphere\" stands where a statement must begin"),
        ("Identity ]", "a.pbrt:1:10: ] stands where a statement must begin"),
        ("Shape \"sphere", "a.pbrt:1:7: there is no \" at the end of this text"),
        ("Shape 1", "a.pbrt:1:7: Shape must be followed by a text between \"\""),
        ("Shape", "a.pbrt:1:1: Shape must be followed by a text between \"\", but the file ends"),
        ("Translate 1 2", "a.pbrt:1:14: Translate must be followed by 3 finite numbers"),
        ("Scale 1 nan 2", "a.pbrt:1:9: Scale must be followed by 3 finite numbers"),
        ("Rotate 5 0 0 0", "a.pbrt:1:1: the axis of Rotate has no length"),
        (
            "LookAt 0 0 0  0 0 1  0 0 1",
            "a.pbrt:1:1: LookAt has no direction: both points are the same, or up is parallel to \
             the view",
        ),
        (
            "Transform [ 1 0 0 .5  0 1 0 0  0 0 1 0  0 0 0 1 ]",
            "a.pbrt:1:1: the matrix of Transform is not affine: its numbers 4, 8, 12 and 16 must \
             be 0, 0, 0 and 1",
        ),
        ("AttributeBegin", "a.pbrt:1:1: nothing ends this AttributeBegin"),
        ("AttributeEnd", "a.pbrt:1:1: AttributeEnd ends nothing that was begun"),
        (
            "AttributeBegin\nTransformEnd",
            "a.pbrt:2:1: TransformEnd stands where the AttributeBegin of line 1 must end",
        ),
        (
            "ObjectBegin \"a\" ObjectBegin \"b\"",
            "a.pbrt:1:17: an object cannot be described within another one",
        ),
        ("ObjectInstance \"a\"", "a.pbrt:1:1: no object \"a\""),
        ("CoordSysTransform \"wrld\" WorldBegin", "a.pbrt:1:1: no coordinate system \"wrld\""),
        // Parameters.
        (
            "Shape \"sphere\" \"radius\" 1",
            "a.pbrt:1:16: \"radius\" is no parameter: it must be a type and a name, as \"float \
             radius\"",
        ),
        (
            "Shape \"sphere\" \"flaot radius\" 1",
            "a.pbrt:1:16: no type of parameters \"flaot\"; did you mean \"float\"?",
        ),
        ("Shape \"sphere\" \"float radius\" x", "a.pbrt:1:31: \"x\" is not a number"),
        ("Shape \"sphere\" \"float radius\"", "a.pbrt:1:30: the values of \"radius\" are missing"),
        (
            "Shape \"sphere\" \"float radius\" [ 1",
            "a.pbrt:1:31: there is no ] behind the values of \"radius\"",
        ),
        (
            "Shape \"sphere\" \"float radius\" [ 1 2 ]",
            "a.pbrt:1:16: \"radius\" is 2 numbers, but must be one number",
        ),
        (
            "Shape \"sphere\" \"string radius\" \"1\"",
            "a.pbrt:1:16: \"radius\" is one text, but must be one number",
        ),
        (
            "Shape \"sphere\" \"float radius\" 0",
            "a.pbrt:1:16: radius is 0, but must be more than 0",
        ),
        (
            "Material \"diffuse\" \"rgb reflectance\" [ 1 2 ] Shape \"sphere\"",
            "a.pbrt:1:20: \"reflectance\" is 2 numbers, but must be 3 numbers",
        ),
        // Shapes.
        (
            "Shape \"loopsubdiv\"",
            "a.pbrt:1:1: shapes of type \"loopsubdiv\" are not read: subdivide it, and give the \
             triangles as a trianglemesh or a PLY file",
        ),
        ("Shape \"spere\"", "a.pbrt:1:1: no type of shapes \"spere\"; did you mean \"sphere\"?"),
        (
            "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ] \"integer indices\" [ 0 1 3 ]",
            "a.pbrt:1:55: \"indices\" has 3, but there are only 3 vertices, from 0 on",
        ),
        (
            "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ] \"integer indices\" [ 0 1 ]",
            "a.pbrt:1:55: 2 \"indices\" are not 3 for each part",
        ),
        (
            "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ] \"normal N\" [ 0 0 1 ]",
            "a.pbrt:1:55: 1 of \"N\" for 3 of \"P\": give one each, or none",
        ),
        (
            "Shape \"plymesh\" \"string filename\" \"../a.ply\"",
            "a.pbrt:1:17: \"../a.ply\" leads out of the scene's folder; move the file beside the \
             scene, or allow this with --allow-path",
        ),
        ("Include \"b.pbrt\"", "a.pbrt:1:1: there is no file \"b.pbrt\" beside the scene"),
        // What things are made of.
        ("NamedMaterial \"red\" Shape \"sphere\"", "a.pbrt:1:1: no material \"red\""),
        (
            "Material \"difuse\" Shape \"sphere\"",
            "a.pbrt:1:1: no type of materials \"difuse\"; did you mean \"diffuse\"?",
        ),
        (
            "Material \"diffuse\" \"texture reflectance\" \"wood\" Shape \"sphere\"",
            "a.pbrt:1:20: no texture \"wood\"",
        ),
        (
            "Texture \"a\" \"float\" \"scale\" \"texture tex\" \"a\" Material \"diffuse\" \
             \"texture reflectance\" \"a\" Shape \"sphere\"",
            "a.pbrt:1:29: the texture \"a\" is made of itself",
        ),
        (
            "MakeNamedMaterial \"a\" \"string type\" \"mix\" \"string materials\" [ \"a\" \"a\" ] \
             NamedMaterial \"a\" Shape \"sphere\"",
            "a.pbrt:1:1: MakeNamedMaterial \"a\" is made of itself",
        ),
        (
            "Material \"conductor\" \"spectrum eta\" \"metal-Xu-eta\" Shape \"sphere\"",
            "a.pbrt:1:22: no spectrum \"metal-Xu-eta\" is known; did you mean \"metal-Au-eta\"?, \
             and there is no file \"metal-Xu-eta\" beside the scene",
        ),
        (
            "Material \"dielectric\" \"float eta\" 0 Shape \"sphere\"",
            "a.pbrt:1:1: \"eta\" of Material \"dielectric\" is 0, but must be more than 0",
        ),
        // Light, and who sees it.
        ("LightSource \"sun\"", "a.pbrt:1:1: no type of lights \"sun\""),
        (
            "LightSource \"infinite\" \"string filename\" \"no.exr\"",
            "a.pbrt:1:24: there is no file \"no.exr\" beside the scene",
        ),
        ("Camera \"fisheye\"", "a.pbrt:1:1: no type of cameras \"fisheye\""),
        (
            "Camera \"perspective\" \"float fov\" 180",
            "a.pbrt:1:22: fov is 180, but must be more than 0 and less than 180",
        ),
        (
            "Scale 1 2 1 Camera \"perspective\"",
            "a.pbrt:1:13: a camera that is stretched or flattened is not made",
        ),
        (
            "Film \"rgb\" \"integer xresolution\" 0",
            "a.pbrt:1:12: xresolution is 0, but must lie between 1 and 65536",
        ),
        (
            "Sampler \"sobol\" \"integer pixelsamples\" 0",
            "a.pbrt:1:17: 0 samples for each pixel are too few",
        ),
        (
            "Camera \"perspective\" \"float shutterclose\" 0",
            "a.pbrt:1:1: the shutter opens at 0 and closes at 0: it must be open for a while",
        ),
    ] {
        let is = said(text);
        if is != expected {
            wrong.push(format!("{text}\n  says {is}\nnot {expected}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Each kind of thing that is left out is told once, at the first place.
#[test]
fn what_is_left_out_is_told_once() {
    let loaded = sound(
        "Option \"bool x\" true\nShape \"sphere\" \"float colour\" 1\nShape \"sphere\" \"float colour\" 2\n\
         Material \"hair\" Shape \"sphere\"\nIntegrator \"mlt\" \"integer chains\" 5\n",
    );
    let notes: Vec<_> = loaded.notes.iter().map(|note| note.replace("nowhere/", "")).collect();
    assert_eq!(
        notes,
        [
            "a.pbrt:1:1: Option is left out",
            "a.pbrt:2:1: there is no WorldBegin before the first thing of the world: it counts as if \
             there were",
            "a.pbrt:5:1: paths are traced where the scene asks for Integrator \"mlt\"",
            "a.pbrt:2:16: \"colour\" of Shape \"sphere\" is left out",
            "a.pbrt:4:1: materials of type \"hair\" are not made: grey stands in",
            "a.pbrt:1:1: there is no light in it: an even white sky stands in",
        ]
    );
}

/// Nothing that would change the picture is left out without a word.
#[test]
fn little_things_are_told() {
    for (text, note) in [
        (
            "MakeNamedMedium \"m\" \"string type\" \"homogeneous\" \"rgb Le\" [ 5 5 5 ] \"float Lescale\" 3",
            "\"Lescale\" of MakeNamedMedium \"m\" is left out",
        ),
        (
            "Integrator \"path\" \"integer pixelbounds\" [ 0 1 0 1 ]",
            "\"pixelbounds\" of Integrator \"path\" is left out",
        ),
        (
            "Integrator \"ao\" \"float maxdistance\" .1",
            "\"maxdistance\" of Integrator \"ao\" is left out",
        ),
        (
            "Shape \"bilinearmesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 1 1 0 ] \"string emissionfilename\" \"a\"",
            "\"emissionfilename\" of Shape \"bilinearmesh\" is left out",
        ),
        (
            "MediumInterface \"\" \"fog\" Camera \"perspective\"",
            "the camera stands in no medium: that around it is left out",
        ),
        (
            "Texture \"t\" \"spectrum\" \"checkerboard\" Material \"diffuse\" \"texture reflectance\" \"t\" \
             Shape \"disk\"",
            "a picture lies on a whole disk from side to side, not around its middle",
        ),
    ] {
        let notes = sound(&format!("{text} Shape \"sphere\"")).notes;
        assert!(notes.iter().any(|said| said.ends_with(note)), "{text}: {notes:?}");
    }
}

/// Bodies of which nothing is left are no error.
#[test]
fn empty_parts_are_nothing() {
    for part in [
        "sphere\" \"float phimax\" 0",
        "sphere\" \"float zmin\" 1 \"float zmax\" 1",
        "disk\" \"float phimax\" 0",
    ] {
        sound(&format!("Shape \"{part} Shape \"sphere\""));
    }
}

/// A parameter that is wrong is told at its own place, in the words of the scene.
#[test]
fn parameters_are_told_at_their_places() {
    for (text, expected) in [
        (
            "Integrator \"path\" \"integer maxdepth\" -1",
            "1:19: maxdepth is -1, but must be 0 or more",
        ),
        ("Shape \"sphere\" \"float radius\" 0", "1:16: radius is 0, but must be more than 0"),
        (
            "Camera \"perspective\" \"float lensradius\" 1 \"float focaldistance\" 0",
            "1:43: focaldistance is 0, but must be more than 0",
        ),
        (
            "Shape \"plymesh\" \"string filename\" \"b.ply\"",
            "1:17: there is no file \"b.ply\" beside the scene",
        ),
        (
            "LightSource \"infinite\" \"string filename\" \"sky.hdr\"",
            "1:24: \"sky.hdr\" has 2x1 pixels, but the map of a sky in equal areas is a square",
        ),
        (
            "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 7 ]",
            "1:22: 10 numbers of \"P\" are not 3 for each vertex",
        ),
    ] {
        assert_eq!(said(text), format!("a.pbrt:{expected}"), "{text}");
    }
    let texture = "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"no.png\" Material \"diffuse\" \
                   \"texture reflectance\" \"t\" Shape \"sphere\"";
    let notes = sound(texture).notes;
    assert!(notes.iter().any(|note| note.contains("a.pbrt:1:35: ")), "{notes:?}");
}

/// What stands on the wrong side of `WorldBegin` counts, and is told.
#[test]
fn sides_of_the_world_are_told() {
    let said = |text: &str| sound(text).notes.join("\n");
    let right = "Camera \"perspective\" WorldBegin LightSource \"infinite\" Shape \"sphere\"";
    assert!(!said(right).contains("WorldBegin"), "{}", said(right));
    for wrong in [
        "WorldBegin LightSource \"infinite\" Camera \"perspective\"",
        "LightSource \"infinite\"",
        "Shape \"sphere\"",
    ] {
        assert!(said(wrong).contains("WorldBegin"), "{wrong}");
    }
}

/// Ten thousand and more levels end in a line, and take no stack.
#[test]
fn nesting_is_limited() {
    for (begin, end) in
        [("AttributeBegin\n", "AttributeEnd\n"), ("TransformBegin\n", "TransformEnd\n")]
    {
        let text = begin.repeat(100_000) + &end.repeat(100_000) + "Shape \"sphere\"";
        assert_eq!(
            said(&text),
            "a.pbrt:65:1: 65 levels of nesting, but at most 64 are allowed; allow more with \
             --limit nesting=N"
        );
        let limits = Limits { nesting: 100_000, ..Limits::default() };
        let options = ReadOptions { limits, ..ReadOptions::default() };
        parse_pbrt(text.into(), Path::new("a.pbrt"), &options).expect("deep, but allowed");
    }
    // Textures and mixtures of one another.
    let mut textures = "Texture \"t0\" \"float\" \"constant\"\n".to_owned();
    let mut mixtures = "MakeNamedMaterial \"m0\" \"string type\" \"diffuse\"\n".to_owned();
    for i in 1..100_000 {
        let last = i - 1;
        textures += &format!("Texture \"t{i}\" \"float\" \"scale\" \"texture tex\" \"t{last}\"\n");
        mixtures += &format!(
            "MakeNamedMaterial \"m{i}\" \"string type\" \"mix\" \"string materials\" [ \"m{last}\" \"m{last}\" ]\n"
        );
    }
    textures += "Material \"diffuse\" \"texture reflectance\" \"t99999\" Shape \"sphere\"";
    mixtures += "NamedMaterial \"m99999\" Shape \"sphere\"";
    for text in [textures, mixtures] {
        let error = read(&text).expect_err("too deep");
        assert!(
            matches!(error.kind, SceneErrorKind::Limit { what: "levels of nesting", .. }),
            "{error}"
        );
        // Whatever the limit, calls within calls end.
        let limits = Limits { nesting: u64::MAX, ..Limits::default() };
        let options = ReadOptions { limits, ..ReadOptions::default() };
        let error = parse_pbrt(text.into(), Path::new("a.pbrt"), &options).expect_err("too deep");
        assert!(
            matches!(
                error.kind,
                SceneErrorKind::Limit { what: "levels of nesting", allowed: 100, .. }
            ),
            "{error}"
        );
    }
}

/// As many levels as can be allowed, of mixtures and of a texture in the innermost, fit in a stack.
#[test]
fn the_deepest_nesting_fits() {
    let mut text = "Texture \"t0\" \"float\" \"constant\"\n".to_owned();
    for i in 1..100 {
        let last = i - 1;
        text += &format!("Texture \"t{i}\" \"float\" \"scale\" \"texture tex\" \"t{last}\"\n");
    }
    text += "MakeNamedMaterial \"m0\" \"string type\" \"diffuse\" \"texture sigma\" \"t99\"\n";
    text += "MakeNamedMaterial \"n\" \"string type\" \"diffuse\"\n";
    for i in 1..100 {
        let last = i - 1;
        text += &format!(
            "MakeNamedMaterial \"m{i}\" \"string type\" \"mix\" \"string materials\" [ \"n\" \"m{last}\" ]\n"
        );
    }
    text += "NamedMaterial \"m99\" Shape \"sphere\"";
    let limits = Limits { nesting: 100, ..Limits::default() };
    let options = ReadOptions { limits, ..ReadOptions::default() };
    parse_pbrt(text.into(), Path::new("a.pbrt"), &options).expect("deep, but allowed");
}

/// Objects count when they are placed, not when they are told.
#[test]
fn objects_are_limited() {
    let mut text = "ObjectBegin \"a\"\n".to_owned();
    text += &"Shape \"sphere\"\n".repeat(100);
    text += "ObjectEnd\n";
    text += &"ObjectInstance \"a\"\n".repeat(100);
    let limits = Limits { objects: 5000, ..Limits::default() };
    let options = ReadOptions { limits, ..ReadOptions::default() };
    let error = parse_pbrt(text.into(), Path::new("a.pbrt"), &options).expect_err("too many");
    assert_eq!(
        error.to_string(),
        "a.pbrt:153:1: 5100 objects, but at most 5000 are allowed; allow more with --limit objects=N"
    );
}

/// What few lines ask for is counted before any of it is made: 25 million objects are refused in no
/// time.
#[test]
fn objects_are_counted_first() {
    let mut text = "ObjectBegin \"a\"\n".to_owned();
    text += &"Shape \"sphere\"\n".repeat(5000);
    text += "ObjectEnd\n";
    text += &"ObjectInstance \"a\"\n".repeat(5000);
    let start = Instant::now();
    assert!(said(&text).contains("objects, but at most 3000000"));
    // Placing them would take many times as long, on any machine.
    assert!(start.elapsed() < Duration::from_secs(1), "{:?}", start.elapsed());
}
