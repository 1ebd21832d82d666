//! Documents of other people.

use rutilant_formats::ReadOptions;
use rutilant_formats::scene::gltf::{self, Document};
use std::path::Path;

/// How much there is: meshes, triangles, vertices of all primitives, materials, textures, and
/// things that the scene places.
fn counts(document: &Document) -> [usize; 6] {
    let primitives = || document.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let placed = document.placed(None, &document.pose(None)).expect("finite");
    [
        document.meshes.len(),
        primitives().map(|p| p.triangles.len()).sum(),
        primitives().map(|p| p.positions.len()).sum(),
        document.materials.len(),
        document.textures.len(),
        placed.len(),
    ]
}

#[test]
fn dump() {
    let Some(data) = std::env::var_os("RUTILANT_DATA") else {
        eprintln!("skipped: RUTILANT_DATA names no folder with gltf");
        return;
    };
    let mut stack = vec![Path::new(&data).join("gltf")];
    let mut files = Vec::new();
    while let Some(folder) = stack.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                stack.push(path);
            } else if path.extension().is_some_and(|e| e == "glb" || e == "gltf") {
                files.push(path);
            }
        }
    }
    files.sort();
    for path in files {
        let start = std::time::Instant::now();
        let name = path.strip_prefix(&data).unwrap().strip_prefix("gltf").unwrap().display();
        match gltf::read(&path, &ReadOptions::default()) {
            Ok(document) => println!(
                "(\"{name}\", {:?}), // {:.1?} {:?}",
                counts(&document),
                start.elapsed(),
                document.notes
            ),
            Err(error) => println!("ERR {name}: {error}"),
        }
    }
}
