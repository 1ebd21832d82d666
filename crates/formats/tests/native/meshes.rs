//! Scenes made of mesh files, and mesh files that are scenes by themselves.

use crate::HEAD;
use rutilant::camera::Camera;
use rutilant::color::Rgb;
use rutilant::light::{Environment, EnvironmentLight, Projection};
use rutilant::material::{MaterialKind, Mix};
use rutilant::scene::{MaterialId, MeshId};
use rutilant::shape::Shape;
use rutilant_formats::{LoadedScene, ReadOptions, parse_native, read_scene};
use rutilant_geom::Vec3;
use std::fs;
use std::path::Path;

/// A tetrahedron: one side shiny, one matte, one of an undeclared material, and one of none.
const OBJ: &str = "mtllib mesh.mtl
v 1 1 1\nv 1 -1 -1\nv -1 1 -1\nv -1 -1 1
f 1 2 3
usemtl matte\nf 1 4 2
usemtl shiny\nf 1 3 4
usemtl missing\nf 2 4 3
";
const MTL: &str =
    "newmtl matte\nKd 0.5 0.25 0.125\nnewmtl shiny\nKd 0.5 0.5 0.5\nKs 0.25 0.25 0.25\n";
const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y
property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header
0 0 0\n2 0 0\n0 2 0\n3 0 1 2\n";

/// A folder with mesh files in it, and `scene.toml`: [`HEAD`] and some shapes.
fn folder(shapes: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in [
        ("mesh.obj", OBJ),
        ("mesh.mtl", MTL),
        ("mesh.ply", PLY),
        ("bare.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
        ("empty.obj", ""),
        ("scene.toml", &format!("{HEAD}{shapes}")),
    ] {
        fs::write(folder.path().join(name), text).expect("a file");
    }
    folder
}

fn read(folder: &Path, name: &str) -> LoadedScene {
    read_scene(&folder.join(name), &ReadOptions::default()).expect(name)
}

fn refused(folder: &Path, name: &str) -> String {
    let error = read_scene(&folder.join(name), &ReadOptions::default()).expect_err(name);
    error.to_string().replace(&format!("{}/", folder.display()), "")
}

/// The file's own materials are used; the shape's stands in for what has none, and is said to.
#[test]
fn objects_bring_their_materials() {
    let shape = "[[shape]]\ntype = \"mesh\"\nfile = \"mesh.obj\"\n";
    let folder = folder(&format!("{shape}material = \"grey\"\n{shape}translate = [5, 0, 0]\n"));
    let LoadedScene { scene, notes, .. } = read(folder.path(), "scene.toml");

    let named = |object: usize| &*scene.materials[scene.objects[object].material.0 as usize].name;
    let materials: Vec<_> = (0..8).map(named).collect();
    assert_eq!(materials[..4], ["grey", "matte", "shiny", "grey"]);
    assert_eq!(materials[4..], materials[..4], "the second shape's grey is a stand-in");
    assert_eq!(scene.objects[0].material, MaterialId(0));
    assert_ne!(scene.objects[4].material, MaterialId(0));
    assert_eq!(notes.iter().filter(|n| n.contains("2 triangles have no material")).count(), 2);
    assert!(notes.iter().any(|n| n.ends_with("the shape's own material stands in")), "{notes:?}");
    assert!(notes.iter().any(|n| n.ends_with("matte grey stands in")), "{notes:?}");
    // Each is led by its place: the two shapes, or what their file says.
    let led = |place: &str| notes.iter().filter(|n| n.contains(place)).count();
    assert_eq!((led("scene.toml:8: "), led("scene.toml:12: ")), (1, 1), "{notes:?}");

    // The file was read once: both shapes share its meshes.
    assert_eq!(scene.meshes.len(), 4);
    for i in 0..4 {
        assert_eq!(scene.objects[i].shape, Shape::Mesh(MeshId(i as u32)));
        assert_eq!(scene.objects[i].shape, scene.objects[i + 4].shape);
    }

    // A mix counts its parts in the file's own list, which now stands behind the scene's.
    for material in &scene.materials {
        if let MaterialKind::Mix(Mix { first, second, .. }) = material.kind {
            assert!(first.0 > 0 && second.0 > 0);
        }
    }
}

/// A file that never speaks of materials takes the shape's; without that it is an error.
#[test]
fn plain_meshes_take_the_shapes_material() {
    for file in ["mesh.ply", "bare.obj"] {
        let shape = format!("[[shape]]\ntype = \"mesh\"\nfile = \"{file}\"\n");
        let plain = folder(&format!("{shape}material = \"grey\""));
        let LoadedScene { scene, notes, .. } = read(plain.path(), "scene.toml");
        assert_eq!(scene.objects[0].material, MaterialId(0));
        assert_eq!(notes, [] as [&str; 0]);
        let without = folder(&shape);
        assert_eq!(
            refused(without.path(), "scene.toml"),
            "scene.toml:8:1: a mesh needs \"material\""
        );
    }
}

/// A mesh can be read flat and smooth in the same scene, and each is read once.
#[test]
fn smoothing_makes_another_mesh() {
    let shape = "[[shape]]\ntype = \"mesh\"\nfile = \"mesh.ply\"\nmaterial = \"grey\"\n";
    let smooth = format!("{shape}smooth_degrees = 40\n");
    let folder =
        folder(&format!("{shape}{smooth}{shape}{smooth}fit = {{ size = 4, on_floor = 1 }}"));
    let scene = read(folder.path(), "scene.toml").scene;
    assert_eq!(scene.meshes.len(), 2);
    assert_eq!((scene.meshes[0].normals.len(), scene.meshes[1].normals.len()), (0, 3));
    assert!(scene.meshes[1].normals.iter().all(|n| n.distance(Vec3::Z) < 1e-6));
    let shapes: Vec<_> = scene.objects.iter().map(|o| o.shape.clone()).collect();
    assert_eq!(shapes, [0, 1, 0, 1].map(|i| Shape::Mesh(MeshId(i))));
    let fitted = scene.objects[3].world_from_object;
    assert!(fitted.point(Vec3::new(0.0, 2.0, 0.0)).distance(Vec3::new(-2.0, 5.0, 0.0)) < 1e-5);
}

/// A mesh alone is grey, under a white sky, in front of a camera.
#[test]
fn meshes_are_scenes() {
    let folder = folder("");
    for name in ["mesh.ply", "mesh.obj", "bare.obj"] {
        let LoadedScene { scene, notes, .. } = read(folder.path(), name);
        assert!(!scene.objects.is_empty() && notes.len() >= 2, "{notes:?}");
        assert!(notes.iter().any(|n| n.contains("matte grey stands in")), "{notes:?}");
        let Some(Environment { light, .. }) = scene.environment else { panic!("no sky") };
        assert_eq!(light, EnvironmentLight::Constant(Rgb::WHITE));
        let Camera::Perspective(camera) = scene.camera else { panic!("{:?}", scene.camera) };
        let eye = camera.world_from_camera.translation();
        assert!(eye.x > 0.0 && eye.y > 0.0 && eye.z > 1.0, "{eye}");
    }
    assert!(refused(folder.path(), "empty.obj").starts_with("empty.obj: "));
}

/// Each projection has its sizes of images, and a wrong one is told which there are.
#[test]
fn skies_have_the_size_of_their_projection() {
    let sky = |width: u32, height: u32, projection: &str| {
        let pixels = [128, 128, 128, 129].repeat((width * height) as usize);
        let head = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n");
        let file = [head.as_bytes(), &pixels].concat();
        let options = ReadOptions { embedded: &[("sky.hdr", &file)], ..ReadOptions::default() };
        let text =
            format!("{HEAD}[environment]\nimage = \"sky.hdr\"\nprojection = \"{projection}\"");
        parse_native(&text, Path::new("scene.toml"), &options).map_err(|error| error.to_string())
    };
    for (width, height, name, expected) in [
        (5, 3, "equirectangular", Projection::Equirectangular),
        (3, 3, "octahedral", Projection::Octahedral),
        (8, 6, "cube", Projection::Cube),
        (3, 4, "cube", Projection::Cube),
        (6, 1, "cube", Projection::Cube),
        (2, 12, "cube", Projection::Cube),
    ] {
        let scene = sky(width, height, name).expect("a good size").scene;
        let light = scene.environment.expect("a sky").light;
        let image = rutilant::scene::ImageId(0);
        assert_eq!(light, EnvironmentLight::Image { image, projection: expected });
    }
    for (width, height, name, said) in [
        (4, 3, "octahedral", "9:9: an octahedral map is a square, but the image has 4x3 pixels"),
        (
            5,
            5,
            "cube",
            "9:9: the faces of a cube are 4x3 or 3x4 squares (a cross) or 6x1 or 1x6 (a strip), \
             but the image has 5x5 pixels",
        ),
        (
            9,
            6,
            "cube",
            "9:9: the faces of a cube are 4x3 or 3x4 squares (a cross) or 6x1 or 1x6 (a strip), \
             but the image has 9x6 pixels",
        ),
        (
            2,
            1,
            "fisheye",
            "10:14: no projection \"fisheye\"; there are equirectangular, octahedral, cube",
        ),
        (2, 1, "latlong", "10:14: no projection \"latlong\"; did you mean \"equirectangular\"?"),
        (2, 1, "cubes", "10:14: no projection \"cubes\"; did you mean \"cube\"?"),
    ] {
        let error = sky(width, height, name).expect_err(said);
        assert_eq!(error, format!("scene.toml:{said}"));
    }
}

/// A mesh without faces, written out in the scene, is said to be invisible as one in a file is.
#[test]
fn a_mesh_without_faces_is_noted() {
    let shape = "[[shape]]\ntype = \"mesh\"\nmaterial = \"grey\"\n";
    for (lists, notes) in [
        ("positions = []\ntriangles = []", 1),
        ("positions = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]\ntriangles = []", 1),
        ("positions = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]\ntriangles = [[0, 1, 2]]", 0),
    ] {
        let text = format!("{HEAD}{shape}{lists}");
        let loaded = parse_native(&text, Path::new("scene.toml"), &ReadOptions::default());
        let said = "scene.toml:8: there are no faces in it, so nothing of it can be seen";
        assert_eq!(loaded.expect("a scene").notes, vec![said; notes], "{lists}");
    }
}

/// A sky whose sun grows beyond all numbers is refused, not lost sample by sample.
#[test]
fn a_sky_is_not_scaled_beyond_all_numbers() {
    let sky: &[u8] = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n\x80\x80\x80\xb0";
    let options = ReadOptions { embedded: &[("sky.hdr", sky)], ..ReadOptions::default() };
    let read = |scale: &str| {
        let text = format!("{HEAD}[environment]\nimage = \"sky.hdr\"\nscale = {scale}");
        parse_native(&text, Path::new("scene.toml"), &options).map_err(|error| error.to_string())
    };
    assert!(read("1000").is_ok());
    let said = "scene.toml:10:9: scale is 1e30, but times the image's brightest pixel, \
                1.4073749e14, must be at most 1e18";
    assert_eq!(read("1e30").expect_err("too bright"), said);

    // Where nobody scales it, the image is to blame.
    let sky: &[u8] = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n\x80\x80\x80\xc0";
    let options = ReadOptions { embedded: &[("sky.hdr", sky)], ..ReadOptions::default() };
    let text = format!("{HEAD}[environment]\nimage = \"sky.hdr\"");
    let error = parse_native(&text, Path::new("scene.toml"), &options).expect_err("too bright");
    let said = "scene.toml:9:9: the image's brightest pixel is 9.223372e18, but must be at most \
                1e18; a scale would make it less";
    assert_eq!(error.to_string(), said);
}

/// An embedded image is found by its name, without a disk.
#[test]
fn embedded_images_are_found() {
    let sky: &[u8] =
        b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n\x80\x80\x80\x81\x80\x80\x80\x82";
    let options = ReadOptions { embedded: &[("sky.hdr", sky)], ..ReadOptions::default() };
    let text = format!("{HEAD}[environment]\nimage = \"sky.hdr\"");
    let scene = parse_native(&text, Path::new("built-in.toml"), &options).expect("a scene").scene;
    assert_eq!((scene.images[0].width(), scene.images[0].height()), (2, 1));
    assert_eq!(scene.images[0].rgb().expect("colours")[1], [2.0; 3]);
    let error = parse_native(&text, Path::new("built-in.toml"), &ReadOptions::default());
    let error = error.expect_err("no file").to_string();
    assert_eq!(error, "built-in.toml:9:9: there is no file \"sky.hdr\" beside the scene");
}

/// A shape stands once for each instance, which moves it after its own keys; a file says the same
/// as a list of tables, and is one of those that the scene is made of.
#[test]
fn instances_place_a_shape_again() {
    let shape = "[[shape]]\ntype = \"mesh\"\nfile = \"mesh.ply\"\nmaterial = \"grey\"\nscale = 2\n";
    let tables = "instances = [{}, { translate = [1, 2, 3], scale = 3 }, \
                  { matrix = [[0, 0, 1, 4], [1, 0, 0, 5], [0, 1, 0, 6]] }]\n";
    let ball = "[[shape]]\ntype = \"sphere\"\nradius = 1\nmaterial = \"grey\"\n\
                [[shape.instances]]\ntranslate = [7, 0, 0]\n[[shape.instances]]\n";
    let named = "instances = \"places.txt\"\n";
    let folder = folder(&format!("{shape}{tables}{shape}{named}{ball}"));
    let places = "# Three of them\n0 0 0\n\n3 0 0 1   0 3 0 2   0 0 3 3 # scaled\n\
                  0 0 1 4 1 0 0 5 0 1e0 0 6\n";
    fs::write(folder.path().join("places.txt"), places).expect("a file");
    let LoadedScene { scene, files, lines, .. } = read(folder.path(), "scene.toml");

    assert_eq!(scene.meshes.len(), 1);
    let at = |object: usize, point: Vec3| scene.objects[object].world_from_object.point(point);
    for first in [0, 3] {
        assert_eq!(at(first, Vec3::ONE), Vec3::splat(2.0));
        assert_eq!(at(first + 1, Vec3::X), Vec3::new(7.0, 2.0, 3.0));
        assert_eq!(at(first + 2, Vec3::new(1.0, 2.0, 3.0)), Vec3::new(10.0, 7.0, 10.0));
    }
    assert_eq!((at(6, Vec3::ZERO), at(7, Vec3::ZERO)), (Vec3::X * 7.0, Vec3::ZERO));
    assert!(files.iter().any(|file| file.ends_with("places.txt")), "{files:?}");
    // Each entry of the list answers for itself.
    let line = |object| lines[&rutilant::scene::Place::Object(object)];
    assert_eq!((line(0), line(3), line(6), line(7)), (13, 14, 24, 26));
}

/// What is wrong in a file of instances is shown there.
#[test]
fn bad_instances_are_shown_where_they_stand() {
    let shape = "[[shape]]\ntype = \"disk\"\nradius = 1\nmaterial = \"grey\"\n";
    let folder = folder(&format!("{shape}instances = \"places.txt\"\n"));
    for (text, expected) in [
        (
            "0 0 0\n1 2",
            "2:1: an instance has 12 numbers, the upper three rows of its matrix, or 3, how far it is moved, but here are 2",
        ),
        ("0 0 0\n1 2 x", "2:5: \"x\" is no finite number"),
        ("# none\n 0 inf 0", "2:4: \"inf\" is no finite number"),
        ("1 0 0 0  0 1 0 0  0 0 0 0", "1:1: the matrix flattens the shape, or makes it too large"),
    ] {
        fs::write(folder.path().join("places.txt"), text).expect("a file");
        assert_eq!(refused(folder.path(), "scene.toml"), format!("places.txt:{expected}"));
    }
    fs::write(folder.path().join("places.txt"), "").expect("a file");
    let LoadedScene { scene, notes, .. } = read(folder.path(), "scene.toml");
    assert!(scene.objects.is_empty());
    assert!(
        notes[0].ends_with("there are no instances of it, so nothing of it can be seen"),
        "{notes:?}"
    );
}
