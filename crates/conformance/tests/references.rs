//! Scenes of other people look as another renderer shows them.

use rutilant_conformance::references;

/// With four samples per pixel, the means of squares of 32 × 32 pixels, and of the whole pictures.
/// A wrong unit, side, angle or transform is none of the renderer's own proofs' business, but
/// shows here. Needs pictures that do not ship: see `references`.
#[test]
fn scenes_look_as_in_another_renderer() {
    let Some(data) = references::data() else {
        eprintln!("SKIPPED: RUTILANT_DATA names no folder with the reference pictures");
        return;
    };
    for reference in references::ALL.iter().filter(|reference| reference.same) {
        let measured = reference.measure(&data, 4, 32, 2).unwrap();
        println!("{}: {measured:?}", reference.name);
        match measured {
            None => eprintln!("SKIPPED: {} is absent", reference.picture),
            Some(measured) => assert!(measured.agrees(), "{}: {measured:?}", reference.name),
        }
    }
}

/// The same for scenes that are read as their authors wrote them: a wrong unit of light, a roughness that
/// is remapped, a body without the light that goes to and fro below its gloss would show.
#[test]
fn scenes_of_others_look_as_in_another_renderer() {
    let Some(data) = references::data() else {
        eprintln!("SKIPPED: RUTILANT_DATA names no folder with the reference pictures");
        return;
    };
    for reference in references::FOREIGN {
        let measured = reference.measure(&data, 2, 40, 2).unwrap();
        println!("{}: {measured:?}", reference.scene);
        match measured {
            None => eprintln!("SKIPPED: {} is absent", reference.scene),
            Some(measured) => assert!(measured.agrees(), "{}: {measured:?}", reference.scene),
        }
    }
}

/// The scenes that ship with this crate are sound, with or without their reference.
#[test]
fn transcribed_scenes_can_be_read() {
    use rutilant_formats::{ReadOptions, parse_native};
    for reference in references::ALL {
        let name = format!("{}.toml", reference.name);
        let loaded = parse_native(reference.scene, name.as_ref(), &ReadOptions::default()).unwrap();
        assert_eq!(loaded.notes, Vec::<String>::new(), "{name}");
        rutilant::Prepared::new(&loaded.scene).unwrap();
    }
}
