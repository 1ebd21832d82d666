//! A glTF document, read: everything decoded, every number of a part checked.

use super::accessor::Accessors;
use super::animation::{self, Animation};
use super::entry::{Entry, Notes, Result};
use super::glb;
use super::json;
use super::material::{self, Material};
use super::mesh::{self, Mesh};
use super::node::{self, Camera, Light, Node, Nodes, Skin};
use super::store::Store;
use super::texture::{self, Image, Texture};
use crate::error::{SceneError, SceneErrorKind};
use crate::options::ReadOptions;
use crate::scene::files::Files;
use crate::scene::nearest::nearest;
use crate::shown::shown;
use std::path::{Path, PathBuf};

/// Nodes that are seen together.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneRoots {
    /// What the author calls it; may be empty.
    pub name: String,
    /// Roots of the hierarchy; each once.
    pub nodes: Vec<usize>,
}

/// A glTF document.
///
/// Parts name each other by their numbers in these arrays, from 0, and all
/// those numbers exist. To show it: choose a [`pose`](Self::pose), see what it
/// has [`placed`](Self::placed), and for each primitive take the vertices that
/// are [`bent`](Self::bent) there and its [`material`](Self::material).
#[derive(Clone, Debug)]
pub struct Document {
    /// Which nodes are seen.
    pub scenes: Vec<SceneRoots>,
    /// The scene that the author wants seen.
    pub scene: Option<usize>,
    /// The hierarchy.
    pub nodes: Vec<Node>,
    /// What triangles there are.
    pub meshes: Vec<Mesh>,
    /// What bends them.
    pub skins: Vec<Skin>,
    /// What moves them.
    pub animations: Vec<Animation>,
    /// From where they are seen.
    pub cameras: Vec<Camera>,
    /// What shines on them.
    pub lights: Vec<Light>,
    /// What they are made of.
    pub materials: Vec<Material>,
    /// Images and how they are looked up.
    pub textures: Vec<Texture>,
    /// Encoded images.
    pub images: Vec<Image>,
    /// The names of the variants that materials come in: `KHR_materials_variants`.
    pub variants: Vec<String>,
    /// What a person should know: what was left out or changed. One line each, which begins
    /// with the file.
    pub notes: Vec<String>,
    /// The files that buffers were read from, symbolic links followed. Images are not among
    /// them.
    pub files: Vec<PathBuf>,
    /// The document's own file, for messages.
    pub(super) file: PathBuf,
    /// Bytes that copies of bent meshes may take.
    pub(super) bendable: u64,
    /// Every node once, parents first.
    pub(super) order: Vec<usize>,
}

impl Document {
    /// The number of the variant of that name.
    ///
    /// # Errors
    /// A name that no variant has, with the nearest one that there is.
    pub fn variant(&self, name: &str) -> std::result::Result<usize, SceneError> {
        self.variants.iter().position(|variant| variant == name).ok_or_else(|| {
            if self.variants.is_empty() {
                let what = format!("no variant \"{}\": the file has none", shown(name));
                return SceneError::invalid_file(&self.file, what);
            }
            let names = self.variants.iter().map(String::as_str);
            let kind = match nearest(name, names.clone()) {
                Some(closest) => SceneErrorKind::Unknown {
                    what: "variant",
                    name: shown(name),
                    closest: Some(shown(closest)),
                },
                None => {
                    let known: Vec<String> = names.take(20).map(shown).collect();
                    let (name, known) = (shown(name), known.join(", "));
                    SceneErrorKind::Invalid(format!("no variant \"{name}\"; there are {known}"))
                }
            };
            SceneError::in_file(&self.file, kind)
        })
    }

    /// The material of a primitive in a variant; `None` for the default material. A primitive
    /// that the variant does not speak of keeps its own.
    pub fn material(&self, of: &mesh::Primitive, variant: Option<usize>) -> Option<usize> {
        let mapped = of.variants.iter().find(|(number, _)| Some(*number) == variant);
        mapped.map(|(_, material)| *material).or(of.material)
    }
}

/// Extensions that are read, or that change nothing of a picture.
const READ: &[&str] = &[
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_node_visibility",
    "KHR_texture_transform",
    "KHR_xmp",
    "KHR_xmp_json_ld",
];

/// Extensions that are not read, in words.
const NOT_READ: &[(&str, &str)] = &[
    ("KHR_texture_basisu", "KTX2 images"),
    ("MSFT_texture_dds", "DDS images"),
    ("EXT_texture_avif", "AVIF images"),
    ("KHR_animation_pointer", "animations of anything"),
];

/// Reads the content of a file; see [`super::read_bytes`].
pub(super) fn read(
    bytes: &[u8],
    path: &Path,
    options: &ReadOptions<'_>,
) -> std::result::Result<Document, SceneError> {
    let notes = Notes::default();
    let in_file = |kind| SceneError::in_file(path, kind);
    let (text, binary) = match bytes.starts_with(glb::MAGIC) {
        true => {
            let chunks = glb::open(bytes, &notes).map_err(in_file)?;
            (chunks.json, Some(chunks.binary))
        }
        false => (bytes, None),
    };
    let json = json::parse(text, path, binary.is_some(), &options.limits)?;
    let root = Entry::root(&json, &notes);
    let binary = binary.flatten();
    let mut document = parts(&root, text.len(), binary, path, options).map_err(in_file)?;
    let lines = notes.lines();
    document.notes = lines.iter().map(|line| format!("{}: {line}", path.display())).collect();
    Ok(document)
}

fn parts(
    root: &Entry<'_, '_>,
    text_bytes: usize,
    binary: Option<&[u8]>,
    path: &Path,
    options: &ReadOptions<'_>,
) -> Result<Document> {
    // Whether it can be read at all.
    version(root)?;
    extensions(root)?;

    // Bytes, and the arrays in them.
    let files = Files::beside(path, options);
    let store = Store::read(root, text_bytes, binary, &files, &options.limits)?;
    let mut accessors = Accessors::read(root, store)?;

    // How things look.
    let images = texture::images(root, &mut accessors)?;
    let textures = texture::textures(root, images.len())?;
    let materials = root.each("materials", |entry| material::material(entry, textures.len()))?;
    let variants = match root.extension("KHR_materials_variants")? {
        Some(extension) => extension.each("variants", |entry| {
            entry.need("name").and_then(|name| Ok(name.text()?.to_owned()))
        })?,
        None => Vec::new(),
    };

    // What there is, and where.
    let counts = mesh::Counts { materials: materials.len(), variants: variants.len() };
    let meshes = mesh::meshes(root, &mut accessors, &counts, &options.limits)?;
    let cameras = node::cameras(root)?;
    let lights = node::lights(root)?;
    let counts = node::Counts {
        meshes: &meshes,
        skins: root.count("skins")?,
        cameras: cameras.len(),
        lights: lights.len(),
    };
    let Nodes { nodes, order } = node::nodes(root, &mut accessors, &counts)?;
    objects(&nodes, &meshes, options.limits.objects)?;
    let skins = node::skins(root, &mut accessors, nodes.len())?;
    for (i, node) in nodes.iter().enumerate() {
        let (Some(mesh), Some(skin)) = (node.mesh, node.skin) else { continue };
        let ends = meshes[mesh].primitives.iter().map(|primitive| primitive.joints_end);
        let (end, joints) = (ends.max().unwrap_or(0), skins[skin].joints.len());
        if end > joints {
            return Err(SceneErrorKind::Invalid(format!(
                "nodes[{i}].skin names skin {skin}, which has only {joints} joints, but \
                 meshes[{mesh}] follows joint {}",
                end - 1
            )));
        }
    }
    let animations = animation::animations(root, &mut accessors, &nodes, &meshes)?;
    let scenes = root.each("scenes", |entry| scene(entry, &nodes))?;
    let scene = root.index_of("scene", "scene", scenes.len())?;

    Ok(Document {
        scenes,
        scene,
        nodes,
        meshes,
        skins,
        animations,
        cameras,
        lights,
        materials,
        textures,
        images,
        variants,
        notes: Vec::new(),
        bendable: accessors.store.budget.bendable(),
        files: accessors.store.files,
        file: path.to_owned(),
        order,
    })
}

fn version(root: &Entry<'_, '_>) -> Result<()> {
    let asset = root.need("asset")?;
    let (version, least) = (asset.need("version")?, asset.get("minVersion")?);
    for entry in [Some(version), least].into_iter().flatten() {
        let text = entry.text()?;
        let (major, minor) = text.split_once('.').unwrap_or((text, "0"));
        let is_least = matches!(entry.place, super::entry::Place::Key(_, "minVersion"));
        if major != "2" || (is_least && minor != "0") {
            let what = format!("{} is \"{}\"; only glTF 2.0 is read", entry.place, shown(text));
            return Err(SceneErrorKind::Unsupported(what));
        }
    }
    Ok(())
}

/// Refuses what a document cannot do without, and notes what it can.
fn extensions(root: &Entry<'_, '_>) -> Result<()> {
    let told = |name: &str| match NOT_READ.iter().find(|(other, _)| *other == name) {
        Some((_, what)) => format!("{name} ({what})"),
        None => shown(name),
    };
    let list = |key| -> Result<(usize, String)> {
        let unread = root.each(key, |entry| entry.text().map(str::to_owned))?;
        let unread: Vec<_> = unread.iter().filter(|name| !READ.contains(&name.as_str())).collect();
        let dots = if unread.len() > 8 { ", …" } else { "" };
        let names: Vec<_> = unread.iter().take(8).map(|name| told(name)).collect();
        Ok((unread.len(), names.join(", ") + dots))
    };
    match list("extensionsRequired")? {
        (0, _) => {}
        (1, name) => {
            let what = format!("it needs the extension {name}, which is not read");
            return Err(SceneErrorKind::Unsupported(what));
        }
        (_, names) => {
            let what = format!("it needs extensions that are not read: {names}");
            return Err(SceneErrorKind::Unsupported(what));
        }
    }
    let (count, names) = list("extensionsUsed")?;
    if count > 0 {
        root.notes.add("extensions that are not read, left out", || names);
    }
    Ok(())
}

/// Refuses a document that places more than the caller allows.
fn objects(nodes: &[Node], meshes: &[Mesh], allowed: u64) -> Result<()> {
    let each = nodes.iter().filter_map(|node| {
        let copies = node.instances.as_ref().map_or(1, |copies| copies.len() as u64);
        Some(copies.saturating_mul(meshes[node.mesh?].primitives.len() as u64))
    });
    let asked = each.fold(0_u64, u64::saturating_add);
    match asked <= allowed {
        true => Ok(()),
        false => Err(SceneErrorKind::Limit { what: "objects", asked, allowed }),
    }
}

fn scene(entry: &Entry<'_, '_>, nodes: &[Node]) -> Result<SceneRoots> {
    let mut seen = std::collections::HashSet::new();
    let roots = entry.each("nodes", |root| {
        let node = root.index("node", nodes.len())?;
        if let Some(parent) = nodes[node].parent {
            let what = format!("names node {node}, which is no root but below nodes[{parent}]");
            return Err(root.wrong(what));
        }
        match seen.insert(node) {
            true => Ok(node),
            false => Err(root.wrong(format_args!("names node {node} once more"))),
        }
    })?;
    Ok(SceneRoots { name: entry.name()?, nodes: roots })
}
