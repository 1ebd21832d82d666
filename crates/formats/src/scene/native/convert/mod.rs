//! Any scene as a native one: a text that people can go on with, and the files that it needs.
//!
//! What lies in files that the new scene may name is named; what lies within other files (meshes and
//! pictures of a .glb, say) or elsewhere comes along in a folder beside the text. Nothing is written
//! here. The text is read again, with what comes along, and is given only if it says what was
//! meant, to the last bit.

mod assets;
mod names;
mod objects;
mod same;

use super::said::{self, Group, Written, number, numbers, triple};
use super::{camera, environment, light, light_group, material, placing, render, texture};
use crate::camera::AuthoredCamera;
use crate::converted::{Content, Converted};
use crate::error::{SceneError, SceneErrorKind};
use crate::limits::Limits;
use crate::options::ReadOptions;
use crate::scene::loaded::{LoadedScene, TextureName};
use crate::scene::origins::MeshOrigin;
use crate::scene::ply;
use crate::shown::shown;
use assets::Assets;
use rutilant::light::EnvironmentLight;
use rutilant::material::{Material, MaterialKind, Sides};
use rutilant::scene::{BitmapId, ImageId, MeshId, Scene};
use rutilant::shape::{Mesh, Shape};
use rutilant::texture::{Encoding, ImageTexture, Texture};
use rutilant_geom::{Transform, Vec2, Vec3};
use same::Meant;
use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

/// How a scene is to be written anew.
#[derive(Clone, Copy, Debug, Default)]
pub struct ConvertOptions {
    /// Whether all its files come along, also those that it could name where they are.
    pub copy: bool,
    /// What reading it again may take.
    pub limits: Limits,
}

/// More places than this stand in a file of their own.
const MOST_PLACES: usize = 12;

/// A mesh that the text wrote out is written out again if it has no more vertices or triangles.
const MOST_WRITTEN: usize = 64;

/// See [`convert`](crate::convert).
pub(crate) fn convert(
    loaded: &LoadedScene,
    from: &Path,
    to: &Path,
    options: &ConvertOptions,
) -> Result<Converted, SceneError> {
    // Somebody may have changed it since it was read.
    loaded.scene.validate().map_err(|problem| refused(from, problem.to_string()))?;
    can_be_said(&loaded.scene).map_err(|what| refused(from, what))?;
    let sources = loaded.files.iter().map(AsRef::as_ref).chain([from]);
    let mut writer = Writer {
        loaded,
        scene: &loaded.scene,
        from,
        assets: Assets::new(to, sources, options.copy)?,
        notes: Vec::new(),
    };

    // Cameras, and the names of everything.
    let cameras = writer.cameras();
    let materials = writer.materials();
    let material_names: Vec<String> = materials.iter().map(|m| m.name.clone()).collect();
    let (pictures, textures) = writer.textures()?;
    let skies = writer.skies()?;

    // The tables, in the order of docs/scene-format.md.
    let mut tables = Vec::new();
    let rendering = render::keys_of(&loaded.settings, &loaded.display);
    if said::needed(&rendering).next().is_some() {
        tables.push(said::table("[render]", &rendering));
    }
    let header = if cameras.len() == 1 { "[camera]" } else { "[[camera]]" };
    tables.extend(cameras.iter().map(|one| said::table(header, &camera::keys_of(one))));
    if let Some(sky) = &loaded.scene.environment {
        tables.push(said::table("[environment]", &environment::keys_of(sky, &skies)));
    }
    for (name, texture) in textures.iter().zip(&loaded.scene.textures) {
        if let TextureName::Named(name) = name {
            let groups = texture::keys_of(name, texture, &pictures);
            tables.push(said::table("[[texture]]", &groups));
        }
    }
    for one in &materials {
        // A lamp is only that: what else there is about it needs the long form.
        let is_lamp = one.opacity.is_none() && one.normal_map.is_none() && one.sides == Sides::Both;
        let groups = material::keys_of(one, &material_names, &textures, is_lamp);
        tables.push(said::table("[[material]]", &groups.unwrap_or_default()));
    }
    let groups = objects::grouped(&loaded.scene);
    let mut meshes = HashMap::new();
    for group in &groups {
        tables.push(writer.shape(group, &material_names, &mut meshes));
    }
    tables.extend(loaded.scene.lights.iter().map(|l| said::table("[[light]]", &light::keys_of(l))));
    let text = format!("{}version = 1\n\n{}", heading(from, to), tables.join("\n"));

    // Read again, it is what was meant.
    let Writer { assets, notes, .. } = writer;
    let converted = Converted { text, assets: assets.list, notes };
    let objects = groups.into_iter().flatten().collect();
    let meant =
        Meant { loaded, cameras: &cameras, materials: &materials, textures: &textures, objects };
    verify(&converted, from, to, options, &meant)?;
    Ok(converted)
}

/// Why a scene cannot be written.
fn refused(file: &Path, what: impl Into<String>) -> SceneError {
    SceneError::in_file(file, SceneErrorKind::Unsupported(what.into()))
}

/// What no file can say, by its name.
fn can_be_said(scene: &Scene) -> Result<(), String> {
    for (i, material) in scene.materials.iter().enumerate() {
        if let MaterialKind::Custom(_) = material.kind {
            let name = shown(&material.name);
            return Err(format!(
                "material \"{name}\" (number {i}) is custom, which no file can say"
            ));
        }
    }
    match scene.objects.iter().position(|object| matches!(object.shape, Shape::Custom(_))) {
        Some(i) => Err(format!("shape {i} is custom, which no file can say")),
        None => Ok(()),
    }
}

/// The comment above a scene.
fn heading(from: &Path, to: &Path) -> String {
    let name = |path: &Path| shown(&path.file_name().unwrap_or_default().to_string_lossy());
    let (from, to) = (name(from), name(to));
    // A line that can be typed as it stands needs quotes around what is more than a word.
    let is_word = |c: char| c.is_alphanumeric() || "-_.".contains(c);
    let to = if to.chars().all(is_word) { to } else { format!("\"{to}\"") };
    format!(
        "# Written by `rutilant convert` from {from}.\n\
         # Render it with `rutilant {to}`, move and edit it with `rutilant view {to}`;\n\
         # docs/scene-format.md says what can stand here.\n"
    )
}

/// A scene on its way into a text.
struct Writer<'w> {
    loaded: &'w LoadedScene,
    scene: &'w Scene,
    from: &'w Path,
    assets: Assets,
    notes: Vec<String>,
}

impl Writer<'_> {
    fn note(&mut self, what: &str) {
        self.notes.push(format!("{}: {what}", self.from.display()));
    }

    /// All cameras, the one that sees the scene first, where each has a name if there are several.
    fn cameras(&mut self) -> Vec<AuthoredCamera> {
        let all = &self.loaded.cameras;
        let mut cameras = vec![self.loaded.look().camera.meant()];
        for (i, camera) in all.iter().enumerate().filter(|(i, _)| *i != self.loaded.camera) {
            // Those that nobody looked through may be unsound.
            let sound = camera
                .camera(self.loaded.settings.size)
                .and_then(|camera| Scene::new(camera).validate().map(|()| camera));
            match sound {
                Ok(_) => cameras.push(camera.clone().meant()),
                Err(problem) => {
                    let name = shown(&camera.name);
                    let what =
                        format!("camera \"{name}\" (number {i}) is left out: {}", problem.what);
                    self.note(&what);
                }
            }
        }
        if cameras.len() > 1 {
            let names: Vec<&str> = cameras.iter().map(|camera| camera.name.as_str()).collect();
            let names = names::unique(&names, |_| "camera".to_owned());
            for (camera, name) in cameras.iter_mut().zip(names) {
                camera.name = name;
            }
        }
        cameras
    }

    /// All materials under names that differ.
    fn materials(&mut self) -> Vec<Material> {
        let all = &self.scene.materials;
        let names: Vec<&str> = all.iter().map(|material| material.name.as_str()).collect();
        // What is only there to be mixed is named by what it is mixed into.
        let mut mixes: HashMap<usize, &str> = HashMap::new();
        for material in all {
            if let MaterialKind::Mix(mix) = &material.kind {
                for part in [mix.first, mix.second] {
                    mixes.entry(part.0 as usize).or_insert(&material.name);
                }
            }
        }
        let stand_in = |i: usize| match mixes.get(&i) {
            Some(mix) if !mix.is_empty() => format!("{mix} part"),
            Some(_) | None => "material".to_owned(),
        };
        let unique = names::unique(&names, stand_in);
        let renamed: Vec<(&str, &String)> = names
            .iter()
            .copied()
            .zip(&unique)
            .filter(|(was, is)| !was.is_empty() && was != is)
            .collect();
        if let [(was, is), ..] = renamed[..] {
            let what = format!(
                "materials whose names were taken have new ones: {} (\"{}\" is \"{}\", for example)",
                renamed.len(),
                shown(was),
                shown(is)
            );
            self.note(&what);
        }
        all.iter().zip(unique).map(|(material, name)| material.clone().named(name)).collect()
    }

    /// The name of the picture of each bitmap that is used, and what the text calls each texture:
    /// materials name a picture themselves where that says everything, and where no other does.
    fn textures(&mut self) -> Result<(Vec<String>, Vec<TextureName>), SceneError> {
        let (scene, known) = (self.scene, &self.loaded.texture_names);
        let mut uses: Vec<Vec<Encoding>> = vec![Vec::new(); scene.textures.len()];
        for (id, encoding) in scene.materials.iter().flat_map(material::textures_of) {
            if let Some(uses) = uses.get_mut(id.0 as usize) {
                uses.push(encoding);
            }
        }
        let is_named = |i: usize| matches!(known.get(i), Some(TextureName::Named(_)));
        let mut pictures = vec![String::new(); scene.bitmaps.len()];
        for (i, texture) in scene.textures.iter().enumerate() {
            let Texture::Image(image) = texture else { continue };
            let id = image.bitmap.0 as usize;
            if (uses[i].is_empty() && !is_named(i))
                || pictures.get(id).is_none_or(|p| !p.is_empty())
            {
                continue;
            }
            pictures[id] = self.picture(image.bitmap)?;
        }

        // Names for those that need a table.
        let stem = |picture: &str| {
            let last = picture.rsplit('/').next().unwrap_or_default();
            last.rsplit_once('.').map_or(last, |(stem, _)| stem).to_owned()
        };
        let (mut numbers, mut wanted) = (Vec::new(), Vec::new());
        for (i, texture) in scene.textures.iter().enumerate() {
            let plain = match (texture, &uses[i][..]) {
                _ if is_named(i) => false,
                (_, []) => true,
                (Texture::Image(image), &[encoding]) => {
                    let usual = ImageTexture { encoding, ..ImageTexture::new(image.bitmap) };
                    format!("{usual:?}") == format!("{image:?}")
                }
                (_, _) => false,
            };
            if !plain {
                numbers.push(i);
                wanted.push(match (known.get(i), texture) {
                    (Some(TextureName::Named(name)), _) => name.clone(),
                    (_, Texture::Image(image)) => stem(&pictures[image.bitmap.0 as usize]),
                    (_, Texture::Checker(_)) => "checker".to_owned(),
                    (_, Texture::Bricks(_)) => "bricks".to_owned(),
                    (_, Texture::Noise(_)) => "noise".to_owned(),
                });
            }
        }
        let wanted: Vec<&str> = wanted.iter().map(String::as_str).collect();
        let mut tables = numbers.iter().zip(names::unique(&wanted, |_| "texture".to_owned()));
        let mut next = tables.next();
        let names = scene.textures.iter().enumerate().map(|(i, texture)| match (&next, texture) {
            (Some((number, name)), _) if **number == i => {
                let name = TextureName::Named(name.clone());
                next = tables.next();
                name
            }
            (_, Texture::Image(image)) => {
                TextureName::Image(pictures[image.bitmap.0 as usize].clone())
            }
            (_, Texture::Checker(_) | Texture::Bricks(_) | Texture::Noise(_)) => {
                TextureName::Image(String::new())
            }
        });
        let names = names.collect();
        Ok((pictures, names))
    }

    /// The name of the file that shows a bitmap.
    fn picture(&mut self, id: BitmapId) -> Result<String, SceneError> {
        let unknown = || {
            refused(self.from, format!("picture {} comes from no file, so none can be named", id.0))
        };
        let origin = self.loaded.origins.bitmap(id).ok_or_else(unknown)?;
        Ok(self.assets.picture(origin))
    }

    /// The names of the pictures of the sky, by their numbers.
    fn skies(&mut self) -> Result<Vec<String>, SceneError> {
        let mut names = vec![String::new(); self.scene.images.len()];
        let ImageId(used) = match self.scene.environment.map(|sky| sky.light) {
            Some(EnvironmentLight::Image { image, .. }) => image,
            Some(EnvironmentLight::Constant(_)) | None => return Ok(names),
        };
        let unknown = || {
            refused(self.from, "the picture of the sky comes from no file, so none can be named")
        };
        let origin = self.loaded.origins.image(ImageId(used)).ok_or_else(unknown)?;
        if let Some(name) = names.get_mut(used as usize) {
            *name = self.assets.picture(origin);
        }
        Ok(names)
    }

    /// The table of a shape that stands wherever the objects of a group do.
    fn shape(
        &mut self,
        group: &[usize],
        materials: &[String],
        meshes: &mut HashMap<MeshId, Vec<Group>>,
    ) -> String {
        let scene = self.scene;
        let Some(object) = group.first().map(|first| &scene.objects[*first]) else {
            return String::new();
        };
        let material = materials.get(object.material.0 as usize).map_or("", String::as_str);
        let (mut name, mut centered) = ("shape", true);
        let mut groups = match &object.shape {
            Shape::Mesh(id) => {
                centered = false;
                name = scene.meshes.get(id.0 as usize).map_or("", |mesh| mesh.name.as_str());
                name = if name.is_empty() { material } else { name };
                let known = meshes.get(id).cloned();
                known.unwrap_or_else(|| {
                    let groups = self.mesh(*id, name);
                    meshes.insert(*id, groups.clone());
                    groups
                })
            }
            Shape::Sphere { radius } => sized("sphere", Group::one(&["radius"], number(*radius))),
            Shape::Disk { radius } => sized("disk", Group::one(&["radius"], number(*radius))),
            Shape::Rectangle { size } => {
                let size = numbers(size.to_array().map(number));
                sized("rectangle", Group::one(&["size"], size))
            }
            Shape::Box { size } => sized("box", Group::one(&["size"], triple(*size))),
            Shape::Custom(_) => Vec::new(),
        };
        groups.push(Group::one(&["material"], said::text(material)));
        groups.push(light_group::key_of(object.group));
        // Places that are told together keep a name that all of them have: their own or the mesh's.
        let shared = group.iter().all(|i| scene.objects[*i].name == object.name);
        let called = match &object.shape {
            Shape::Mesh(id) if object.name.is_empty() => {
                scene.meshes.get(id.0 as usize).map_or("", |mesh| &*mesh.name)
            }
            Shape::Mesh(_)
            | Shape::Sphere { .. }
            | Shape::Disk { .. }
            | Shape::Rectangle { .. }
            | Shape::Box { .. }
            | Shape::Custom(_) => &*object.name,
        };
        if shared && !called.is_empty() {
            groups.insert(0, Group::one(&["name"], said::text(called)));
        }
        let places = group.iter().map(|i| &scene.objects[*i].world_from_object);
        let places: Vec<&Transform> = places.collect();
        match places[..] {
            [place] => groups.push(placing::keys_of(place, centered)),
            _ if places.len() <= MOST_PLACES => {
                let each = places.iter().map(|place| {
                    let table = Written::Table(vec![placing::keys_of(place, false)]);
                    format!("\n  {},", table.text())
                });
                let each: String = each.collect();
                groups.push(Group::one(&["instances"], format!("[{each}\n]")));
            }
            _ => {
                let bytes = Arc::new(lines_of(&places).into_bytes());
                let title = format!("{name} places");
                let file = self.assets.bytes(&title, "places", "txt", bytes);
                groups.push(Group::one(&["instances"], said::text(&file)));
            }
        }
        said::table("[[shape]]", &groups)
    }

    /// What a mesh is: a file that is there already, numbers in the text, or a new file.
    fn mesh(&mut self, id: MeshId, name: &str) -> Vec<Group> {
        let kind = Group::one(&["type"], said::text("mesh"));
        let Some(mesh) = self.scene.meshes.get(id.0 as usize) else { return vec![kind] };
        match self.loaded.origins.mesh(id) {
            MeshOrigin::File { path, crease } => {
                let file = self.assets.file(path, "mesh");
                let crease = crease.map(said::degrees);
                vec![
                    kind,
                    Group::one(&["file"], said::text(&file)),
                    Group::maybe(&["smooth_degrees"], crease),
                ]
            }
            MeshOrigin::Text if is_small(mesh) => [vec![kind], written_out(mesh)].concat(),
            MeshOrigin::Text | MeshOrigin::Made => {
                let bytes = Arc::new(ply::to_bytes(mesh));
                let file = self.assets.bytes(name, "mesh", "ply", bytes);
                vec![kind, Group::one(&["file"], said::text(&file))]
            }
        }
    }
}

fn sized(kind: &str, size: Group) -> Vec<Group> {
    vec![Group::one(&["type"], said::text(kind)), size]
}

/// Whether a mesh can stand in the text, and would not fill it.
fn is_small(mesh: &Mesh) -> bool {
    let Mesh { name: _, positions, normals, uvs, more_uvs, tangents, colors, triangles } = mesh;
    positions.len().max(triangles.len()) <= MOST_WRITTEN
        && more_uvs.is_empty()
        && tangents.is_empty()
        && colors.is_empty()
        && positions.iter().chain(normals).all(|v| v.is_finite())
        && uvs.iter().all(|uv| uv.is_finite())
}

/// A mesh in numbers.
fn written_out(mesh: &Mesh) -> Vec<Group> {
    let triples = |all: &[Vec3]| rows(all.iter().map(|v| triple(*v)).collect());
    let pair = |uv: &Vec2| numbers(uv.to_array().map(number));
    let normals = (!mesh.normals.is_empty()).then(|| triples(&mesh.normals));
    let uvs = (!mesh.uvs.is_empty()).then(|| rows(mesh.uvs.iter().map(pair).collect()));
    vec![
        Group::one(&["positions"], triples(&mesh.positions)),
        Group::one(&["triangles"], rows(mesh.triangles.iter().map(|t| numbers(*t)).collect())),
        Group::maybe(&["normals"], normals),
        Group::maybe(&["uvs"], uvs),
    ]
}

/// An array of arrays, four of them in a line.
fn rows(entries: Vec<String>) -> String {
    if entries.len() <= 4 {
        return numbers(entries);
    }
    let lines = entries.chunks(4).map(|line| format!("    {},\n", line.join(", ")));
    format!("[\n{}]", lines.collect::<String>())
}

/// The places of a shape, one in each line: three numbers where all are only moved, else twelve.
fn lines_of(places: &[&Transform]) -> String {
    let is_moved =
        |place: &&Transform| placing::is_same(place, &Transform::translate(place.translation()));
    let only_moved = places.iter().all(is_moved);
    let mut text = String::new();
    for place in places {
        let (linear, moved) = (place.linear(), place.translation());
        let row = |i: usize| [linear.x_axis[i], linear.y_axis[i], linear.z_axis[i], moved[i]];
        let row = |i: usize| row(i).map(number).join(" ");
        text += &match only_moved {
            true => moved.to_array().map(number).join(" "),
            false => [row(0), row(1), row(2)].join(" "),
        };
        text.push('\n');
    }
    text
}

/// Reads what is to be written, and compares it with what was meant.
fn verify(
    converted: &Converted,
    from: &Path,
    to: &Path,
    options: &ConvertOptions,
    meant: &Meant<'_>,
) -> Result<(), SceneError> {
    let mut contents = Vec::with_capacity(converted.assets.len());
    for asset in &converted.assets {
        let bytes = asset.content.bytes().map_err(|error| match &asset.content {
            Content::File(path) => SceneError::in_file(path, SceneErrorKind::Io(error)),
            Content::Bytes(_) => SceneError::in_file(&asset.name, SceneErrorKind::Io(error)),
        })?;
        contents.push((asset.name.as_str(), bytes));
    }
    let embedded: Vec<(&str, &[u8])> =
        contents.iter().map(|(name, bytes)| (*name, &**bytes)).collect();
    let reading =
        ReadOptions { limits: options.limits, embedded: &embedded, ..ReadOptions::default() };
    let read = super::parse(&converted.text, to, &reading).map_err(|error| {
        refused(from, format!("as a native scene it would be refused: {error}"))
    })?;
    match same::difference(&read, meant) {
        None => Ok(()),
        Some(what) => {
            Err(refused(from, format!("{what} cannot be written so that it reads as it is now")))
        }
    }
}
