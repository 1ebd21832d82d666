//! Scenes written: an edited one in its author's text, or a mesh file made a scene.
//!
//! Only what has changed is touched; comments, order and line ends stay. What
//! comes out is read again, and is given only if it is what was meant, to the
//! last bit: the text may be laid out in ways that nobody thought of.

use super::edit::Edits;
use super::layout::Layout;
use super::said::{self, Group};
use super::{Document, camera, environment, light, material, render, with_room};
use crate::error::{SceneError, SceneErrorKind};
use crate::look::Look;
use crate::options::ReadOptions;
use crate::scene::loaded::{LoadedScene, TextureName};
use crate::shown::shown;
use rutilant::light::{Environment, EnvironmentLight, Light};
use rutilant::material::{Material, MaterialKind};
use std::collections::HashMap;
use std::path::Path;
use toml::de::DeTable;

/// Why a look cannot be written.
fn refused(file: &Path, what: impl Into<String>) -> SceneError {
    SceneError::in_file(file, SceneErrorKind::Unsupported(what.into()))
}

/// See [`rewrite`](crate::rewrite).
pub(crate) fn rewrite(
    text: &str,
    file: &Path,
    options: &ReadOptions<'_>,
    before: &LoadedScene,
    after: &Look,
    image_names: &[String],
) -> Result<String, SceneError> {
    let (written, own) =
        with_room(file, || edited(text, file, options, before, after, image_names))?;
    // The text's own first, then new ones, then those of mesh files.
    let old = before.scene.materials.len();
    let order = Order::new((0..own).chain(old..after.materials.len()).chain(own..old));
    verify(&written, file, options, before, after, image_names, &order)?;
    Ok(written)
}

/// The edited text, and how many materials are its own.
fn edited(
    text: &str,
    file: &Path,
    options: &ReadOptions<'_>,
    before: &LoadedScene,
    after: &Look,
    image_names: &[String],
) -> Result<(String, usize), SceneError> {
    let document = Document::new(text, file);
    let tree = document.parse()?;
    document.must_be_shallow(tree.get_ref(), options.limits.nesting)?;
    let unknown = || refused(file, "the text is laid out in a way that cannot be edited");
    let layout = Layout::of(text).ok_or_else(unknown)?;
    let mut edits = Edits::new(text);
    let old = before.look();

    let was = render::keys_of(&old.settings, &old.display);
    let now = render::keys_of(&after.settings, &after.display);
    change(&layout, "render", Some(&was), Some(&now), &[""], &mut edits);

    let was = camera::keys_of(&old.camera);
    let now = camera::keys_of(&after.camera.clone().meant());
    let (cameras, _) = layout.tables("camera");
    if let Some(table) = cameras.get(before.camera) {
        layout.apply(table, &was, &now, &mut edits);
    } else if layout.table("camera").is_some() {
        change(&layout, "camera", Some(&was), Some(&now), &[], &mut edits);
    } else if was != now || old.settings.size != after.settings.size {
        // One that was chosen depends on the size of the picture.
        change(&layout, "camera", None, Some(&now), &["render", ""], &mut edits);
    }

    let was = old.environment.map(|sky| environment::keys_of(&sky, &before.image_names));
    let now = after.environment.map(|sky| environment::keys_of(&sky, image_names));
    let above = ["camera", "render", ""];
    change(&layout, "environment", was.as_deref(), now.as_deref(), &above, &mut edits);

    let textures = &before.texture_names;
    let own =
        materials(&layout, tree.get_ref(), file, &old.materials, textures, after, &mut edits)?;
    lights(&layout, &old.lights, &after.lights, &mut edits);
    Ok((edits.finish().ok_or_else(unknown)?, own))
}

/// Changes a table that there is once, makes it, or takes it away.
fn change(
    layout: &Layout,
    key: &'static str,
    was: Option<&[Group]>,
    now: Option<&[Group]>,
    above: &[&str],
    edits: &mut Edits<'_>,
) {
    match (layout.table(key), now) {
        (_, _) if was == now => {}
        (Some(table), Some(now)) => layout.apply(&table, was.unwrap_or_default(), now, edits),
        (Some(_), None) => layout.remove(key, edits),
        (None, Some(now)) => {
            let at = above.iter().find_map(|key| layout.end_of(key)).unwrap_or_default();
            edits.insert_table(at, &said::table(&format!("[{key}]"), now));
        }
        (None, None) => {}
    }
}

/// Puts tables at the end of an array of tables, where it has none at the end of the text.
fn append(layout: &Layout, key: &str, new: &[Vec<Group>], edits: &mut Edits<'_>, gone: &[bool]) {
    let (_, node) = layout.tables(key);
    if let Some(node) = node {
        let super::layout::NodeKind::Array(items) = &node.kind else { return };
        let items: Vec<_> = items.iter().map(|item| item.at.clone()).collect();
        let new: Vec<_> =
            new.iter().map(|groups| said::Written::Table(groups.clone()).text()).collect();
        edits.change_list(node.at.clone(), &items, gone, &new);
        return;
    }
    let at = layout.end_of(key).unwrap_or(usize::MAX);
    let header = format!("[[{key}]]");
    let tables: Vec<_> = new.iter().map(|groups| said::table(&header, groups)).collect();
    if !tables.is_empty() {
        edits.insert_table(at, &tables.join("\n"));
    }
}

/// Changes the materials, and gives how many the text has of its own.
fn materials(
    layout: &Layout,
    tree: &DeTable<'_>,
    file: &Path,
    old: &[Material],
    textures: &[TextureName],
    after: &Look,
    edits: &mut Edits<'_>,
) -> Result<usize, SceneError> {
    let (tables, _) = layout.tables("material");
    let own = tables.len();
    if own > old.len() || after.materials.len() < old.len() {
        return Err(refused(file, "materials cannot be taken away: shapes may need them"));
    }
    let names = |materials: &[Material]| -> Vec<String> {
        materials.iter().map(|material| material.name.clone()).collect()
    };
    let (old_names, new_names) = (names(old), names(&after.materials));
    for (i, (was, now)) in old.iter().zip(&after.materials).enumerate().skip(own) {
        if format!("{was:?}") != format!("{now:?}") {
            return Err(from_mesh_file(file, was, i));
        }
    }
    let in_text = |id: usize| id < own || id >= old.len();
    let keys = |i: usize, material: &Material, names: &[String], lamp: bool| {
        let called = shown(&material.name);
        if let MaterialKind::Mix(mix) = &material.kind
            && let Some(part) = [mix.first, mix.second].into_iter().find(|p| !in_text(p.0 as usize))
        {
            let part = names.get(part.0 as usize).map_or("", String::as_str);
            let what = format!(
                "material \"{called}\" mixes \"{}\", which comes from a mesh file and has no name \
                 in the scene's text",
                shown(part)
            );
            return Err(refused(file, what));
        }
        material::keys_of(material, names, textures, lamp).ok_or_else(|| {
            let what =
                format!("material \"{called}\" (number {i}) is custom, which no file can say");
            refused(file, what)
        })
    };
    let array = tree.get("material").and_then(|value| value.get_ref().as_array());
    for (i, table) in tables.iter().enumerate() {
        let (was, now) = (&old[i], &after.materials[i]);
        let entry = array.and_then(|array| array.get(i)).and_then(|v| v.get_ref().as_table());
        let kind = entry.and_then(|entry| entry.get("type")?.get_ref().as_str());
        let lamp = kind != Some("black");
        let [was, now] = [keys(i, was, &old_names, lamp), keys(i, now, &new_names, lamp)];
        layout.apply(table, &was?, &now?, edits);
    }
    let new: Result<Vec<_>, _> = after
        .materials
        .iter()
        .enumerate()
        .skip(old.len())
        .map(|(i, material)| keys(i, material, &new_names, true))
        .collect();
    append(layout, "material", &new?, edits, &[]);

    // Shapes call materials by their names.
    let renamed: HashMap<&str, &str> = (0..own)
        .map(|i| (old_names[i].as_str(), new_names[i].as_str()))
        .filter(|(was, now)| was != now)
        .collect();
    let shapes = tree.get("shape").and_then(|value| value.get_ref().as_array());
    let (places, _) = layout.tables("shape");
    for (place, shape) in places.iter().zip(shapes.into_iter().flat_map(|shapes| shapes.iter())) {
        let shape = shape.get_ref().as_table();
        let name = shape.and_then(|shape| shape.get("material")?.get_ref().as_str());
        if let Some(now) = name.and_then(|name| renamed.get(name))
            && let Some(entry) = place.entry("material")
        {
            edits.replace(entry.value.at.clone(), said::text(now));
        }
    }
    Ok(own)
}

fn from_mesh_file(file: &Path, material: &Material, number: usize) -> SceneError {
    let name = shown(&material.name);
    refused(
        file,
        format!(
            "material \"{name}\" (number {number}) comes from a mesh file, so the scene's text \
             cannot change it"
        ),
    )
}

/// The most pairs of lights that are compared to find out which are which.
const MOST_PAIRS: usize = 1 << 20;

/// Changes the lights: those that are the same keep their tables, whatever their numbers.
fn lights(layout: &Layout, old: &[Light], new: &[Light], edits: &mut Edits<'_>) {
    let words =
        |lights: &[Light]| -> Vec<Vec<Group>> { lights.iter().map(light::keys_of).collect() };
    let (was, now) = (words(old), words(new));
    if was == now {
        return;
    }
    let (tables, node) = layout.tables("light");
    let mut gone = vec![false; was.len()];
    let mut added = Vec::new();
    for (i, j) in pairs(&was, &now) {
        match (i, j) {
            (Some(i), Some(j)) => {
                if let Some(table) = tables.get(i) {
                    layout.apply(table, &was[i], &now[j], edits);
                }
            }
            (Some(i), None) => gone[i] = true,
            (None, Some(j)) => added.push(now[j].clone()),
            (None, None) => {}
        }
    }
    if node.is_none() {
        for (table, _) in tables.iter().zip(&gone).filter(|(_, gone)| **gone) {
            layout.remove_item(table, edits);
        }
    }
    append(layout, "light", &added, edits, &gone);
}

/// Which old one has become which new one; only at the end are there new ones of no old.
fn pairs(was: &[Vec<Group>], now: &[Vec<Group>]) -> Vec<(Option<usize>, Option<usize>)> {
    let spare = was.len().saturating_sub(now.len());
    let mut pairs = Vec::new();
    let (mut i, mut j, mut left) = (0, 0, spare);
    // Where some are gone, these are the first that have no equal.
    let cheap = was.len().saturating_mul(spare) <= MOST_PAIRS;
    while i < was.len() {
        let rest = &was[i..];
        let ahead = j < now.len() && was[i] != now[j] && left > 0 && cheap;
        let found = ahead.then(|| rest.iter().take(left + 1).position(|w| *w == now[j])).flatten();
        if j == now.len() || found.is_some_and(|skip| skip > 0) {
            pairs.push((Some(i), None));
            left = left.saturating_sub(1);
        } else {
            pairs.push((Some(i), Some(j)));
            j += 1;
        }
        i += 1;
    }
    pairs.extend((j..now.len()).map(|j| (None, Some(j))));
    pairs
}

/// Where the materials of a look stand in the scene that is written.
struct Order {
    /// The number in the look of each of the scene's.
    from: Vec<usize>,
    /// The number in the scene of each of the look's.
    to: HashMap<usize, u32>,
}

impl Order {
    fn new(from: impl IntoIterator<Item = usize>) -> Self {
        let from: Vec<usize> = from.into_iter().collect();
        let to = from.iter().copied().zip(0..).collect();
        Self { from, to }
    }

    /// The number in the scene of one in the look.
    fn to(&self, number: u32) -> u32 {
        self.to.get(&(number as usize)).copied().unwrap_or(u32::MAX)
    }

    fn materials(&self, look: &Look) -> Vec<Material> {
        let all = self.from.iter().filter_map(|from| look.materials.get(*from)).cloned();
        all.map(|mut material| {
            if let MaterialKind::Mix(mix) = &mut material.kind {
                for part in [&mut mix.first, &mut mix.second] {
                    part.0 = self.to(part.0);
                }
            }
            material
        })
        .collect()
    }
}

/// A sky in words that do not depend on the numbers of images.
fn sky(sky: Option<Environment>, names: &[String]) -> String {
    let image = match sky.map(|sky| sky.light) {
        Some(EnvironmentLight::Image { image, .. }) => names.get(image.0 as usize),
        Some(EnvironmentLight::Constant(_)) | None => None,
    };
    let sky = sky.map(|mut sky| {
        if let EnvironmentLight::Image { image, .. } = &mut sky.light {
            image.0 = 0;
        }
        sky
    });
    format!("{sky:?} {image:?}")
}

/// Reads what was written, and compares it with what was meant.
fn verify(
    written: &str,
    file: &Path,
    options: &ReadOptions<'_>,
    before: &LoadedScene,
    after: &Look,
    image_names: &[String],
    order: &Order,
) -> Result<(), SceneError> {
    // The camera may have another name now.
    let options = ReadOptions { camera: Default::default(), ..*options };
    let read = super::parse(written, file, &options).map_err(|error| {
        refused(file, format!("with these changes it would be refused: {}", error.kind))
    })?;
    let differs = |what: &str| {
        let what = format!("{what} cannot be written so that it reads as it is now");
        Err(refused(file, what))
    };

    // Words in Rust have all digits of a number, and tell −0 from 0.
    let camera = after.camera.clone().meant();
    let others = |cameras: &[_]| {
        let others = cameras.iter().enumerate().filter(|(i, _)| *i != before.camera);
        format!("{:?}", others.collect::<Vec<_>>())
    };
    let seen = read.cameras.get(before.camera);
    if format!("{seen:?}") != format!("{:?}", Some(camera))
        || others(&read.cameras) != others(&before.cameras)
    {
        return differs("the camera");
    }
    if sky(read.scene.environment, &read.image_names) != sky(after.environment, image_names) {
        return differs("the environment");
    }
    let expected = order.materials(after);
    for (read, meant) in read.scene.materials.iter().zip(&expected) {
        if format!("{read:?}") != format!("{meant:?}") {
            return differs(&format!("material \"{}\"", shown(&meant.name)));
        }
    }
    if read.scene.materials.len() != expected.len() {
        return differs("the list of materials");
    }
    if format!("{:?}", read.scene.lights) != format!("{:?}", after.lights) {
        let mut both = read.scene.lights.iter().zip(&after.lights);
        let wrong = both.position(|(a, b)| format!("{a:?}") != format!("{b:?}"));
        let wrong = wrong.unwrap_or(after.lights.len().min(read.scene.lights.len()));
        return differs(&format!("light {wrong}"));
    }
    // How many samples are planned is no file's business.
    let settings = rutilant::settings::Settings { planned_spp: None, ..after.settings.clone() };
    if format!("{:?}{:?}", read.settings, read.display)
        != format!("{settings:?}{:?}", after.display)
    {
        return differs("what [render] says");
    }
    let (objects, were) = (&read.scene.objects, &before.scene.objects);
    let stay = objects.len() == were.len()
        && objects.iter().zip(were).all(|(object, was)| {
            object.material.0 == order.to(was.material.0)
                && object.world_from_object == was.world_from_object
        });
    if stay { Ok(()) } else { differs("what stands in the scene") }
}

/// See [`native_for_mesh`](crate::native_for_mesh).
pub(crate) fn native_for_mesh(
    mesh: &str,
    file: &Path,
    options: &ReadOptions<'_>,
    before: &LoadedScene,
    after: &Look,
    image_names: &[String],
) -> Result<String, SceneError> {
    // The last material is what stands in where the file has none.
    let old = before.scene.materials.len();
    let Some(stand_in) = old.checked_sub(1).filter(|_| after.materials.len() >= old) else {
        return Err(refused(file, "it was not read from a mesh file alone"));
    };
    let own: Vec<usize> = std::iter::once(stand_in).chain(old..after.materials.len()).collect();
    for (i, was) in before.scene.materials.iter().enumerate().take(stand_in) {
        if format!("{was:?}") != format!("{:?}", after.materials[i]) {
            return Err(from_mesh_file(file, was, i));
        }
    }
    let mut parts = vec!["version = 1\n".to_owned()];
    let rendering = render::keys_of(&after.settings, &after.display);
    if said::needed(&rendering).next().is_some() {
        parts.push(said::table("[render]", &rendering));
    }
    parts.push(after.camera.clone().meant().to_toml());
    if let Some(sky) = &after.environment {
        parts.push(said::table("[environment]", &environment::keys_of(sky, image_names)));
    }
    let names: Vec<String> = after.materials.iter().map(|m| m.name.clone()).collect();
    for &i in &own {
        let material = &after.materials[i];
        let groups = material::keys_of(material, &names, &[], true).ok_or_else(|| {
            let name = shown(&material.name);
            refused(file, format!("material \"{name}\" is custom, which no file can say"))
        })?;
        parts.push(said::table("[[material]]", &groups));
    }
    parts.push(format!(
        "[[shape]]\ntype = \"mesh\"\nfile = {}\nmaterial = {}\n",
        said::text(mesh),
        said::text(&names[stand_in])
    ));
    for light in &after.lights {
        parts.push(said::table("[[light]]", &light::keys_of(light)));
    }
    let written = parts.join("\n");
    let order = Order::new(own.into_iter().chain(0..stand_in));
    let before = LoadedScene { cameras: vec![after.camera.clone()], camera: 0, ..before.clone() };
    verify(&written, file, options, &before, after, image_names, &order)?;
    Ok(written)
}
