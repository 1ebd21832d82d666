//! `rutilant info`: what is in a scene, and how well rays find it.

use crate::check::{contents, triangles};
use crate::failure::{Exit, Failure};
use crate::focus::{self, Focus};
use crate::load::{self, Reading, timed};
use crate::options;
use crate::say::{one_line, print_json, print_line, tell};
use crate::text::{bytes, several, significant, time};
use rutilant::light::{EnvironmentLight, Light};
use rutilant::material::MaterialKind;
use rutilant::scene::Scene;
use rutilant::shape::{Object, Shape};
use rutilant_formats::LoadedScene;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::time::Duration;

#[derive(clap::Args)]
pub(crate) struct Args {
    /// A scene: .toml, .gltf, .glb, .pbrt, .xml, .obj, .ply, .stl; the built-in glass cube if none is named
    scene: Option<PathBuf>,
    #[command(flatten)]
    reading: Reading,
    /// Threads that build the ray tree
    #[arg(long, value_name = "N", value_parser = options::threads, default_value_t = options::all_threads())]
    threads: usize,
    /// Say how the camera is focused on what is seen in this pixel
    #[arg(long, value_name = "X,Y", value_parser = options::pixel, allow_hyphen_values = true)]
    focus_on: Option<[u32; 2]>,
    /// Print one line of JSON
    #[arg(long)]
    json: bool,
}

/// Everything that is said about a scene.
#[derive(Serialize)]
struct Info {
    scene: PathBuf,
    size: [u32; 2],
    spp: u64,
    objects: usize,
    meshes: usize,
    triangles: u64,
    /// Triangles that are stored: those of a mesh that is stored once count once.
    stored_triangles: u64,
    /// Meshes that are stored once, and how often those stand in the scene.
    shared_meshes: u64,
    instances: u64,
    vertices: u64,
    /// How its cameras are asked for, the one that sees it first.
    cameras: Vec<String>,
    materials: BTreeMap<&'static str, usize>,
    textures: usize,
    /// What their pictures take in memory, with the smaller versions made of them.
    texture_bytes: u64,
    lights: BTreeMap<&'static str, usize>,
    /// Lower and upper corner in metres; absent for a scene without surfaces.
    bounds: Option<[[f32; 3]; 2]>,
    read_seconds: f64,
    /// Building the tree, and little else.
    prepare_seconds: f64,
    bvh: Tree,
    /// What the camera is focused on, where it was told to find that out.
    focus: Option<Focus>,
    notes: Vec<String>,
}

/// The bounding volume hierarchy.
#[derive(Serialize)]
struct Tree {
    nodes: u64,
    leaves: u64,
    depth: u64,
    sah_cost: f64,
    bytes: u64,
    largest_leaf: u64,
    left_out: u64,
}

pub(crate) fn run(args: &Args) -> Result<Exit, Failure> {
    load::use_threads(args.threads)?;
    let (loaded, reading) = timed(|| load::read(args.scene.as_deref(), &args.reading, None));
    let mut loaded = loaded?;
    if let Some(pixel) = args.focus_on {
        focus::ask(&mut loaded.scene, pixel, loaded.settings.size)?;
    }
    let (prepared, preparing) =
        timed(|| load::prepare(&loaded, options::Build::Default, options::SimdLevel::Auto));
    let prepared = prepared?;
    let report = prepared.report();
    let scene = &loaded.scene;

    let mut notes = load::notes(&loaded, &prepared, &loaded.settings, args.scene.as_deref());
    let (focus, no_focus) = focus::find(scene, &prepared, loaded.settings.size);
    notes.extend(no_focus);
    let bounds = report.bounds;
    let info = Info {
        scene: args.scene.clone().unwrap_or_else(|| load::BUILT_IN.into()),
        size: loaded.settings.size,
        spp: loaded.settings.spp,
        objects: scene.objects.len(),
        meshes: scene.meshes.len(),
        triangles: triangles(scene),
        stored_triangles: report.stored_triangles,
        shared_meshes: report.shared_meshes,
        instances: report.instances,
        vertices: scene.meshes.iter().map(|m| m.positions.len() as u64).sum(),
        cameras: camera_names(&loaded),
        materials: tally(scene.materials.iter().map(|m| kind_of_material(&m.kind))),
        textures: scene.textures.len(),
        texture_bytes: report.texture_bytes,
        lights: tally(kinds_of_lights(scene)),
        bounds: (!bounds.is_empty()).then(|| [bounds.min.to_array(), bounds.max.to_array()]),
        read_seconds: reading.as_secs_f64(),
        prepare_seconds: preparing.as_secs_f64(),
        bvh: Tree {
            nodes: report.bvh.nodes as u64,
            leaves: report.bvh.leaves as u64,
            depth: report.bvh.depth as u64,
            sah_cost: report.bvh.sah_cost,
            bytes: report.bvh.bytes as u64,
            largest_leaf: report.bvh.largest_leaf as u64,
            left_out: report.bvh.left_out.count as u64,
        },
        focus,
        notes,
    };
    for note in &info.notes {
        tell(&format!("note: {note}"));
    }
    if args.json {
        print_json(&info)?;
    } else {
        print_line(describe(&info, &contents(scene)).trim_end())?;
    }
    Ok(Exit::Done)
}

/// The same for people.
fn describe(info: &Info, contents: &str) -> String {
    let mut text = String::new();
    let mut row = |name: &str, value: &str| {
        let _ = writeln!(text, "{name:<11}{value}");
    };
    let seconds = |s: f64| time(Duration::from_secs_f64(s));
    let list = |tally: &BTreeMap<&str, usize>| {
        let parts: Vec<_> = tally.iter().map(|(kind, n)| format!("{n} × {kind}")).collect();
        if parts.is_empty() { "none".to_owned() } else { parts.join(", ") }
    };
    row("scene", &one_line(&format!("{}: {contents}", info.scene.display())));
    row(
        "picture",
        &format!(
            "{}×{}, {}",
            info.size[0],
            info.size[1],
            several(info.spp, "sample per pixel", "samples per pixel")
        ),
    );
    row(
        "geometry",
        &format!(
            "{}, {} with {}; {} in place",
            several(info.objects as u64, "object", "objects"),
            several(info.meshes as u64, "mesh", "meshes"),
            several(info.vertices, "vertex", "vertices"),
            several(info.triangles, "triangle", "triangles"),
        ),
    );
    if info.instances > 0 {
        row(
            "instances",
            &format!(
                "{} of {}; {} stored",
                several(info.instances, "instance", "instances"),
                several(info.shared_meshes, "mesh", "meshes"),
                several(info.stored_triangles, "triangle", "triangles"),
            ),
        );
    }
    if !info.cameras.is_empty() {
        row("cameras", &info.cameras.join(", "));
    }
    row("materials", &list(&info.materials));
    if info.textures > 0 {
        let count = several(info.textures as u64, "texture", "textures");
        row("textures", &format!("{count}, {}", bytes(info.texture_bytes)));
    }
    row("lights", &list(&info.lights));
    match info.bounds {
        Some([min, max]) => {
            let point = |p: [f32; 3]| p.map(significant).join(", ");
            row("bounds", &format!("({}) to ({}) m", point(min), point(max)));
        }
        None => row("bounds", "none: there are no surfaces"),
    }
    if let Some(focus) = &info.focus {
        row("focus", &focus.describe());
    }
    let tree = &info.bvh;
    row(
        "ray tree",
        &format!(
            "{}, {}, depth {}, SAH cost {:.2}, {}",
            several(tree.nodes, "node", "nodes"),
            several(tree.leaves, "leaf", "leaves"),
            tree.depth,
            tree.sah_cost,
            bytes(tree.bytes),
        ),
    );
    if tree.left_out > 0 {
        row(
            "",
            &format!(
                "{} left out: degenerate, NaN or infinite",
                several(tree.left_out, "surface", "surfaces")
            ),
        );
    }
    row(
        "time",
        &format!("read {}, build {}", seconds(info.read_seconds), seconds(info.prepare_seconds)),
    );
    text
}

/// How all cameras are asked for, the one in use first; nothing if it alone is there, without a name.
fn camera_names(loaded: &LoadedScene) -> Vec<String> {
    if let [only] = &loaded.cameras[..]
        && only.name.is_empty()
    {
        return Vec::new();
    }
    let mut labels = loaded.camera_labels();
    labels[..=loaded.camera].rotate_right(1);
    labels
}

fn tally(kinds: impl IntoIterator<Item = &'static str>) -> BTreeMap<&'static str, usize> {
    let mut tally = BTreeMap::new();
    for kind in kinds {
        *tally.entry(kind).or_default() += 1;
    }
    tally
}

fn kind_of_material(kind: &MaterialKind) -> &'static str {
    match kind {
        MaterialKind::Black => "black",
        MaterialKind::Null => "null",
        MaterialKind::Matte(_) => "matte",
        MaterialKind::Mirror(_) => "mirror",
        MaterialKind::Conductor(_) => "conductor",
        MaterialKind::Dielectric(_) => "dielectric",
        MaterialKind::ThinDielectric(_) => "thin-dielectric",
        MaterialKind::Principled(_) => "principled",
        MaterialKind::Mix(_) => "mix",
        MaterialKind::Custom(_) => "custom",
    }
}

fn kinds_of_lights(scene: &Scene) -> Vec<&'static str> {
    let glows = |o: &&Object| {
        scene.materials.get(o.material.0 as usize).is_some_and(|m| m.emission.is_some())
    };
    let glowing = scene.objects.iter().filter(glows).map(|o| match o.shape {
        Shape::Mesh(_) => "glowing mesh",
        Shape::Sphere { .. } => "glowing sphere",
        Shape::Rectangle { .. } => "glowing rectangle",
        Shape::Disk { .. } => "glowing disk",
        Shape::Box { .. } => "glowing box",
        Shape::Custom(_) => "glowing custom shape",
    });
    let lights = scene.lights.iter().map(|light| match light {
        Light::Point { .. } => "point light",
        Light::Spot { .. } => "spot",
        Light::Directional { .. } => "directional light",
    });
    let sky = scene.environment.iter().map(|e| match e.light {
        EnvironmentLight::Constant(_) => "even sky",
        EnvironmentLight::Image { .. } => "sky image",
    });
    glowing.chain(lights).chain(sky).collect()
}
