//! Scenes name files beside them and nothing else, unless the reader is told otherwise.

use crate::HEAD;
use rutilant_formats::{Limits, ReadOptions, SceneErrorKind, read_scene};
use std::fs;
use std::path::Path;

/// What is said about a scene in `folder` that names `file`.
fn said(folder: &Path, file: &str, options: &ReadOptions<'_>) -> String {
    let scene = folder.join("scene.toml");
    let text = format!("{HEAD}[[shape]]\ntype = \"mesh\"\nmaterial = \"grey\"\nfile = '{file}'\n");
    fs::write(&scene, text).expect("a scene");
    let said = read_scene(&scene, options).expect_err(file).to_string();
    said.replace(&scene.display().to_string(), "scene.toml")
}

/// Neither `..`, nor a root, nor a symbolic link leads out; and whether the file outside exists
/// makes no difference to what is said.
#[test]
fn paths_stay_in_the_folder() {
    let outside = tempfile::tempdir().expect("a folder");
    fs::write(outside.path().join("secret.txt"), "").expect("a file");
    let folder = outside.path().join("inside");
    fs::create_dir_all(folder.join("deep")).expect("a folder");
    let absolute = outside.path().join("secret.txt").display().to_string();
    for file in ["../secret.txt", "../none.txt", "deep/../../secret.txt", &*absolute] {
        assert_eq!(
            said(&folder, file, &ReadOptions::default()),
            format!(
                "scene.toml:11:8: \"{file}\" leads out of the scene's folder; \
                 move the file beside the scene, or allow this with --allow-path"
            )
        );
    }
    let allowed = ReadOptions { allow_outside: true, ..ReadOptions::default() };
    for file in ["../secret.txt", "deep/../../secret.txt", &*absolute] {
        let said = said(&folder, file, &allowed);
        assert!(
            said.ends_with("no mesh format .txt; there are .obj, .ply, .stl, .gltf, .glb"),
            "{said}"
        );
    }
}

/// The materials of `a.obj`, which `scene.toml` in `folder` names by `file`.
fn materials(folder: &Path, file: &str, options: &ReadOptions<'_>) -> Vec<String> {
    let scene = folder.join("scene.toml");
    let text = format!("{HEAD}[[shape]]\ntype = \"mesh\"\nmaterial = \"grey\"\nfile = '{file}'\n");
    fs::write(&scene, text).expect("a scene");
    let loaded = read_scene(&scene, options).unwrap_or_else(|error| panic!("{error}"));
    // The first is the scene's own.
    loaded.scene.materials.into_iter().skip(1).map(|material| material.name).collect()
}

/// The files that a mesh file names are held to the scene's folder as well, not to their own:
/// beside it is inside, above the scene is outside.
#[test]
fn material_files_stay_in_the_scenes_folder() {
    let outside = tempfile::tempdir().expect("a folder");
    let folder = outside.path().join("inside");
    fs::create_dir_all(folder.join("meshes")).expect("a folder");
    fs::create_dir_all(folder.join("looks")).expect("a folder");
    fs::write(outside.path().join("secret.mtl"), "newmtl secret\n").expect("a file");
    fs::write(folder.join("looks/red.mtl"), "newmtl red\n").expect("a file");
    let absolute = outside.path().join("secret.mtl").display().to_string();
    let allowed = ReadOptions { allow_outside: true, ..ReadOptions::default() };
    for (library, by_default, if_allowed) in [
        ("../looks/red.mtl", &["red"][..], &["red"][..]),
        ("../../secret.mtl", &[], &["secret"]),
        ("../../none.mtl", &[], &[]),
        (&*absolute, &[], &["secret"]),
    ] {
        let obj = format!("mtllib {library}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
        fs::write(folder.join("meshes/a.obj"), obj).expect("a file");
        for (options, expected) in [(ReadOptions::default(), by_default), (allowed, if_allowed)] {
            assert_eq!(materials(&folder, "meshes/a.obj", &options), expected, "{library}");
        }
        // On its own, the mesh file's folder is the scene's.
        let alone = |options| {
            let loaded = read_scene(&folder.join("meshes/a.obj"), options).expect("a scene");
            loaded.scene.materials.len() - 1
        };
        assert_eq!((alone(&ReadOptions::default()), alone(&allowed)), (0, if_allowed.len()));
    }
}

/// What is not there, or not a file, is said at the key that named it.
#[test]
fn only_regular_files_are_read() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::create_dir(folder.path().join("mesh.obj")).expect("a folder");
    fs::write(folder.path().join("mesh.off"), "").expect("a file");
    for (file, expected) in [
        ("mesh.obj", "scene.toml:11:8: \"mesh.obj\" is a folder, not a file"),
        ("", "scene.toml:11:8: \"\" is a folder, not a file"),
        ("none.obj", "scene.toml:11:8: there is no file \"none.obj\" beside the scene"),
        (
            r"deep\none.obj",
            r#"scene.toml:11:8: there is no file "deep\\none.obj"; write / between folders, not \"#,
        ),
    ] {
        assert_eq!(said(folder.path(), file, &ReadOptions::default()), expected);
    }
}

#[cfg(unix)]
mod unix {
    use super::*;
    use std::os::unix::fs::symlink;

    /// A link is followed, and where it ends decides.
    #[test]
    fn links_stay_in_the_folder_too() {
        let outside = tempfile::tempdir().expect("a folder");
        fs::write(outside.path().join("secret.txt"), "").expect("a file");
        let folder = outside.path().join("inside");
        fs::create_dir(&folder).expect("a folder");
        fs::write(folder.join("mesh.txt"), "").expect("a file");
        symlink("../secret.txt", folder.join("out.txt")).expect("a link");
        symlink("..", folder.join("up")).expect("a link");
        symlink("mesh.txt", folder.join("in.txt")).expect("a link");
        for file in ["out.txt", "up/secret.txt", "up/inside/../secret.txt"] {
            let said = said(&folder, file, &ReadOptions::default());
            assert!(
                said.contains("leads out of the scene's folder through a symbolic link"),
                "{said}"
            );
            assert!(said.contains("--allow-path"), "{said}");
        }
        for file in ["in.txt", "up/inside/mesh.txt"] {
            let said = said(&folder, file, &ReadOptions::default());
            assert!(
                said.ends_with("no mesh format .txt; there are .obj, .ply, .stl, .gltf, .glb"),
                "{said}"
            );
        }
    }

    /// A mesh file inside, named through a folder outside that links back to it, does not bring
    /// the material files of that folder.
    #[test]
    fn links_do_not_move_the_fence() {
        let outside = tempfile::tempdir().expect("a folder");
        let folder = outside.path().join("inside");
        fs::create_dir(&folder).expect("a folder");
        fs::write(outside.path().join("a.mtl"), "newmtl secret\n").expect("a file");
        fs::write(folder.join("a.obj"), "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
            .expect("a file");
        symlink("inside/a.obj", outside.path().join("a.obj")).expect("a link");
        symlink("..", folder.join("up")).expect("a link");
        assert!(materials(&folder, "up/a.obj", &ReadOptions::default()).is_empty());
        let allowed = ReadOptions { allow_outside: true, ..ReadOptions::default() };
        assert_eq!(materials(&folder, "up/a.obj", &allowed), ["secret"]);
    }

    /// A pipe would wait for a writer forever.
    #[test]
    fn pipes_are_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let pipe = folder.path().join("pipe.obj");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        assert!(made.is_ok_and(|status| status.success()), "mkfifo");
        let options = ReadOptions::default();
        let said = said(folder.path(), "pipe.obj", &options);
        assert_eq!(said, "scene.toml:11:8: \"pipe.obj\" is a pipe or a device, not a file");
        let error = read_scene(&pipe, &options).expect_err("a pipe").to_string();
        assert!(error.ends_with("pipe.obj: this is a pipe or a device, not a file"), "{error}");

        // A file of materials is missed rather than refused, for the same reason.
        let obj = folder.path().join("a.obj");
        fs::write(&obj, "mtllib pipe.obj\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").expect("a file");
        let notes = read_scene(&obj, &options).expect("a scene").notes;
        let said =
            "MTL file \"pipe.obj\" is a pipe or a device, not a file: its materials are missing";
        assert!(notes[0].ends_with(said), "{notes:?}");
    }
}

/// A device may never stop sending. It is refused even where any path is allowed.
#[cfg(unix)]
#[test]
fn devices_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    std::os::unix::fs::symlink("/dev/zero", folder.path().join("zero.obj")).expect("a link");
    let allowed = ReadOptions { allow_outside: true, ..ReadOptions::default() };
    for (options, expected) in [
        (ReadOptions::default(), "leads out of the scene's folder through a symbolic link"),
        (allowed, "\"zero.obj\" is a pipe or a device, not a file"),
    ] {
        let said = said(folder.path(), "zero.obj", &options);
        assert!(said.contains(expected), "{said}");
    }
    let error = read_scene(&folder.path().join("zero.obj"), &allowed).expect_err("a device");
    assert!(error.to_string().ends_with("this is a pipe or a device, not a file"), "{error}");
}

/// The scene file itself: missing, a folder, too large, not text, of no known kind.
#[test]
fn scene_files_are_checked() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    fs::create_dir(path("folder.toml")).expect("a folder");
    fs::write(path("large.toml"), HEAD).expect("a file");
    fs::write(path("binary.toml"), b"version = 1\n# \xc3\xa4 \xff").expect("a file");
    fs::write(path("scene.xyz"), "").expect("a file");
    let options = ReadOptions {
        limits: Limits { file_bytes: 50, ..Limits::default() },
        ..ReadOptions::default()
    };
    let said = |name: &str| read_scene(&path(name), &options).expect_err(name);
    assert!(matches!(said("none.toml").kind, SceneErrorKind::Io(_)));
    assert!(matches!(said("large.toml").kind, SceneErrorKind::Limit { allowed: 50, .. }));
    for (name, expected) in [
        ("folder.toml", "folder.toml: this is a folder, not a file"),
        ("binary.toml", "binary.toml:2:5: the text is not UTF-8 here; save the file as UTF-8"),
        (
            "scene.xyz",
            "scene.xyz: no scene format .xyz; there are .toml, .gltf, .glb, .pbrt, .xml, .obj, .ply, .stl",
        ),
        (
            "scene",
            "scene: no extension, so no scene format; there are .toml, .gltf, .glb, .pbrt, .xml, .obj, .ply, .stl",
        ),
    ] {
        let error = said(name).to_string();
        assert!(error.ends_with(expected), "{error}");
    }
}
