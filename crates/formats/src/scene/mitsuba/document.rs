//! What a scene's text says, before anything of it has a meaning: objects with properties and parts.
//!
//! Included files are taken in where they are named, `$names` are replaced, names of Mitsuba 0.6
//! become those of Mitsuba 3, and references are followed. What properties mean is for those who
//! read them; a document remembers which were read, so that the others can be told.

use super::parameters::Parameters;
use super::value::{self, Value};
use super::xml::{self, Attribute, Element, Tree};
use crate::error::{SceneError, SceneErrorKind, Source};
use crate::file;
use crate::limits::Limits;
use crate::options::ReadOptions;
use crate::scene::affine::Affine;
use crate::scene::files::{Files, Found};
use crate::scene::nearest::nearest;
use crate::scene::notes::Notes;
use crate::scene::text;
use crate::shown::shown;
use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::hash::Hash;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// A place in one of a scene's files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Place {
    file: u32,
    at: usize,
}

/// What kind of thing an object is: its tag.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Class {
    Scene,
    Shape,
    Bsdf,
    Texture,
    Emitter,
    Sensor,
    Film,
    Filter,
    Sampler,
    Integrator,
    Medium,
    Phase,
    Volume,
    Spectrum,
}

/// Tags and what they stand for; of several for the same, the first is the newest.
const CLASSES: &[(&str, Class)] = &[
    ("scene", Class::Scene),
    ("shape", Class::Shape),
    ("bsdf", Class::Bsdf),
    ("texture", Class::Texture),
    ("emitter", Class::Emitter),
    ("luminaire", Class::Emitter),
    ("sensor", Class::Sensor),
    ("camera", Class::Sensor),
    ("film", Class::Film),
    ("rfilter", Class::Filter),
    ("sampler", Class::Sampler),
    ("integrator", Class::Integrator),
    ("medium", Class::Medium),
    ("phase", Class::Phase),
    ("volume", Class::Volume),
    ("spectrum", Class::Spectrum),
];

impl Class {
    /// Its tag.
    pub(super) fn name(self) -> &'static str {
        CLASSES.iter().find(|(_, class)| *class == self).map_or("object", |(name, _)| name)
    }
}

/// An object: a shape, a BSDF, …
#[derive(Debug)]
pub(super) struct Object {
    pub(super) class: Class,
    /// What it is of its class: its `type`.
    pub(super) plugin: String,
    pub(super) id: String,
    pub(super) place: Place,
    properties: Vec<Property>,
    parts: Vec<Part>,
    /// Whether anyone looked at it.
    seen: Cell<bool>,
}

#[derive(Debug)]
struct Property {
    name: String,
    value: Value,
    place: Place,
    read: Cell<bool>,
}

/// An object within another one, or one that it refers to.
#[derive(Debug)]
struct Part {
    name: String,
    object: usize,
    place: Place,
    read: Cell<bool>,
}

/// A scene's files, taken apart.
pub(super) struct Document<'o> {
    pub(super) files: Files<'o>,
    limits: Limits,
    /// Further folders in which files are looked for, by `<path>`.
    folders: Vec<String>,
    sources: Vec<(PathBuf, Rc<str>)>,
    pub(super) objects: Vec<Object>,
    /// The files that were found, each once.
    pub(super) found: RefCell<Vec<PathBuf>>,
    notes: RefCell<Notes>,
}

/// A file that has been read.
pub(super) struct Content {
    pub(super) bytes: Vec<u8>,
    /// Its path in the words of the scene, for messages.
    pub(super) path: PathBuf,
    /// The same for every name of the same file.
    pub(super) identity: PathBuf,
}

/// No object of any version of Mitsuba has nearly as many properties; each is looked for among all.
const MOST_PROPERTIES: u64 = 1000;
/// How deep files may include each other; Mitsuba's own limit.
const DEEPEST_INCLUDE: usize = 15;
/// How many files may be included in all: a few files could name each other very often.
const MOST_INCLUDES: usize = 256;

impl<'o> Document<'o> {
    /// Takes the text of the file at `path` apart.
    pub(super) fn parse(
        text: String,
        path: &Path,
        options: &'o ReadOptions<'o>,
    ) -> Result<Self, SceneError> {
        let scene = Object {
            class: Class::Scene,
            plugin: String::new(),
            id: String::new(),
            place: Place::default(),
            properties: Vec::new(),
            parts: Vec::new(),
            seen: Cell::new(true),
        };
        let document = Self {
            files: Files::beside(path, options),
            limits: options.limits,
            folders: Vec::new(),
            sources: Vec::new(),
            objects: vec![scene],
            found: RefCell::default(),
            notes: RefCell::default(),
        };
        let mut builder = Builder {
            document,
            options,
            parameters: Parameters::new(options.parameters),
            ids: HashMap::new(),
            references: Vec::new(),
            aliases: Vec::new(),
            includes: 0,
        };
        builder.file(path.to_owned(), &text.into(), 0, &mut Vec::new())?;
        builder.resolve()?;
        builder.parameters.finish(path, &builder.document)?;
        Ok(builder.document)
    }

    /// Where a byte stands, for people.
    pub(super) fn source(&self, place: Place) -> Source {
        match self.sources.get(place.file as usize) {
            Some((path, text)) => text::place(path, text.as_bytes(), place.at),
            None => Source::default(),
        }
    }

    /// The lines of the scene's own file that places are on; those of other files are left out.
    pub(super) fn lines<P: Copy + Eq + Hash>(&self, places: &HashMap<P, Place>) -> HashMap<P, u32> {
        let Some((_, text)) = self.sources.first() else { return HashMap::new() };
        let ends: Vec<usize> = text::line_ends(text.as_bytes()).collect();
        let own = places.iter().filter(|(_, place)| place.file == 0);
        // Lines count from 1.
        own.map(|(part, place)| (*part, ends.partition_point(|end| *end < place.at) as u32 + 1))
            .collect()
    }

    pub(super) fn error(&self, place: Place, kind: SceneErrorKind) -> SceneError {
        SceneError { at: self.source(place), kind }
    }

    pub(super) fn invalid(&self, place: Place, what: impl Into<String>) -> SceneError {
        self.error(place, SceneErrorKind::Invalid(what.into()))
    }

    pub(super) fn unsupported(&self, place: Place, what: impl Into<String>) -> SceneError {
        self.error(place, SceneErrorKind::Unsupported(what.into()))
    }

    /// Tells people something, once for each kind.
    pub(super) fn note(&self, place: Place, kind: &str, what: &str) {
        self.notes.borrow_mut().once(kind, || format!("{}: {what}", self.source(place)));
    }

    /// The file `name` beside the scene, or in a folder that it says.
    pub(super) fn find(&self, name: &str, place: Place) -> Result<Found, SceneError> {
        let first = self.files.find(name);
        let found = match first {
            Ok(found) => Ok(found),
            Err(what) => {
                let other = |folder: &String| self.files.find(&format!("{folder}/{name}")).ok();
                self.folders.iter().find_map(other).ok_or(what)
            }
        };
        let found = found.map_err(|what| self.invalid(place, what))?;
        let mut files = self.found.borrow_mut();
        if !files.contains(&found.identity) {
            files.push(found.identity.clone());
        }
        Ok(found)
    }

    /// The content of the file `name`, which may need no disk.
    pub(super) fn content(&self, name: &str, place: Place) -> Result<Content, SceneError> {
        if let Some(bytes) = self.files.embedded(name) {
            let path = self.files.path(name);
            return Ok(Content { bytes: bytes.to_owned(), identity: path.clone(), path });
        }
        let Found { path, identity } = self.find(name, place)?;
        Ok(Content { bytes: file::scene_bytes(&path, &self.limits)?, identity, path })
    }

    /// The name of a picture as it is found: beside the scene, or in a folder that it says.
    pub(super) fn picture(&self, name: &str) -> String {
        if self.files.embedded(name).is_some() || self.files.find(name).is_ok() {
            return name.to_owned();
        }
        let elsewhere = self.folders.iter().map(|folder| format!("{folder}/{name}"));
        elsewhere.into_iter().find(|name| self.files.find(name).is_ok()).unwrap_or(name.to_owned())
    }

    /// The object of a number, to be read.
    pub(super) fn object(&self, number: usize) -> View<'_, 'o> {
        let object = &self.objects[number];
        object.seen.set(true);
        View { document: self, object, number }
    }

    /// All notes, with those on what nobody read.
    pub(super) fn finish(&self, path: &Path) -> Vec<String> {
        for object in self.objects.iter().filter(|object| object.seen.get()) {
            let of = match (object.class, &*object.plugin) {
                (Class::Scene, _) => "the scene".to_owned(),
                (class, plugin) => format!("{} \"{}\"", class.name(), shown(plugin)),
            };
            for property in object.properties.iter().filter(|property| !property.read.get()) {
                let name = shown(&property.name);
                let what = format!("\"{name}\" of {of} is left out");
                self.note(property.place, &what, &what);
            }
            for part in object.parts.iter().filter(|part| !part.read.get()) {
                let part_of = &self.objects[part.object];
                let what = format!(
                    "{} \"{}\" in {of} is left out",
                    part_of.class.name(),
                    shown(&part_of.plugin)
                );
                self.note(part.place, &what, &what);
            }
        }
        self.notes.take().into_list(path)
    }
}

/// An object that is being read.
#[derive(Clone, Copy)]
pub(super) struct View<'d, 'o> {
    pub(super) document: &'d Document<'o>,
    object: &'d Object,
    pub(super) number: usize,
}

/// A property that is there.
#[derive(Clone, Copy)]
pub(super) struct Written<'d> {
    pub(super) value: &'d Value,
    pub(super) place: Place,
}

impl<'d, 'o> View<'d, 'o> {
    pub(super) fn class(&self) -> Class {
        self.object.class
    }

    pub(super) fn plugin(&self) -> &'d str {
        &self.object.plugin
    }

    pub(super) fn id(&self) -> &'d str {
        &self.object.id
    }

    pub(super) fn place(&self) -> Place {
        self.object.place
    }

    pub(super) fn note(&self, kind: &str, what: &str) {
        self.document.note(self.place(), kind, what);
    }

    /// `no bsdf "…"`, with the nearest of those there are.
    pub(super) fn unknown(&self, known: &[&str]) -> SceneError {
        let what = self.class().name();
        let name = shown(self.plugin());
        let closest = nearest(self.plugin(), known.iter().copied()).map(str::to_owned);
        let kind = match closest {
            Some(_) => SceneErrorKind::Unknown { what, name, closest },
            None => {
                let known = known.join(", ");
                let what = format!("{what} \"{name}\" is not read; there are {known}");
                SceneErrorKind::Unsupported(what)
            }
        };
        self.document.error(self.place(), kind)
    }

    pub(super) fn property(&self, name: &str) -> Option<Written<'d>> {
        let property = self.object.properties.iter().find(|property| property.name == name)?;
        property.read.set(true);
        Some(Written { value: &property.value, place: property.place })
    }

    /// Properties that have no meaning here, and need not be told.
    pub(super) fn pass_over(&self, names: &[&str]) {
        for property in &self.object.properties {
            if names.contains(&&*property.name) {
                property.read.set(true);
            }
        }
    }

    /// All of its parts count as read.
    pub(super) fn pass_over_parts(&self) {
        self.object.parts.iter().for_each(|part| part.read.set(true));
    }

    /// The part of this name.
    pub(super) fn part(&self, name: &str) -> Option<View<'d, 'o>> {
        let part = self.object.parts.iter().find(|part| part.name == name)?;
        part.read.set(true);
        Some(self.document.object(part.object))
    }

    /// Its parts of a class, in their order.
    pub(super) fn parts(&self, class: Class) -> impl Iterator<Item = View<'d, 'o>> + use<'d, 'o> {
        let (document, object) = (self.document, self.object);
        let of_class = move |part: &&'d Part| document.objects[part.object].class == class;
        object.parts.iter().filter(of_class).map(move |part| {
            part.read.set(true);
            document.object(part.object)
        })
    }

    /// The one part of a class; of several the first.
    pub(super) fn only(&self, class: Class) -> Option<View<'d, 'o>> {
        let (document, object) = (self.document, self.object);
        let part = object.parts.iter().find(|p| document.objects[p.object].class == class)?;
        part.read.set(true);
        Some(document.object(part.object))
    }

    fn wrong_type(&self, name: &str, written: Written<'_>, wanted: &str) -> SceneError {
        let what = format!("{name} is {}, but must be {wanted}", written.value.kind());
        self.document.invalid(written.place, what)
    }

    pub(super) fn optional_number(&self, name: &str) -> Result<Option<f32>, SceneError> {
        let Some(written) = self.property(name) else { return Ok(None) };
        match *written.value {
            Value::Float(x) => Ok(Some(x as f32)),
            Value::Integer(x) => Ok(Some(x as f32)),
            _ => Err(self.wrong_type(name, written, "a number")),
        }
    }

    pub(super) fn number(&self, name: &str, default: f32) -> Result<f32, SceneError> {
        Ok(self.optional_number(name)?.unwrap_or(default))
    }

    pub(super) fn integer(&self, name: &str) -> Result<Option<i64>, SceneError> {
        let Some(written) = self.property(name) else { return Ok(None) };
        match *written.value {
            Value::Integer(x) => Ok(Some(x)),
            _ => Err(self.wrong_type(name, written, "a whole number")),
        }
    }

    /// A whole number in a range.
    pub(super) fn count(
        &self,
        name: &str,
        range: std::ops::RangeInclusive<u32>,
    ) -> Result<Option<u32>, SceneError> {
        let Some(given) = self.integer(name)? else { return Ok(None) };
        match u32::try_from(given).ok().filter(|count| range.contains(count)) {
            Some(count) => Ok(Some(count)),
            None => {
                let place = self.property(name).map_or(self.place(), |written| written.place);
                let (least, most) = range.into_inner();
                let what = format!("{name} is {given}, but must lie between {least} and {most}");
                Err(self.document.invalid(place, what))
            }
        }
    }

    pub(super) fn boolean(&self, name: &str, default: bool) -> Result<bool, SceneError> {
        let Some(written) = self.property(name) else { return Ok(default) };
        match *written.value {
            Value::Boolean(yes) => Ok(yes),
            _ => Err(self.wrong_type(name, written, "true or false")),
        }
    }

    pub(super) fn text(&self, name: &str) -> Result<Option<&'d str>, SceneError> {
        let Some(written) = self.property(name) else { return Ok(None) };
        match written.value {
            Value::Text(text) => Ok(Some(text)),
            _ => Err(self.wrong_type(name, written, "a string")),
        }
    }

    /// One of several words; the first where there is none.
    pub(super) fn choice<T: Copy>(
        &self,
        name: &'static str,
        choices: &[(&str, T)],
    ) -> Result<T, SceneError> {
        let Some(word) = self.text(name)? else { return Ok(choices[0].1) };
        if let Some((_, choice)) = choices.iter().find(|(known, _)| *known == word) {
            return Ok(*choice);
        }
        let place = self.property(name).map_or(self.place(), |written| written.place);
        let known = || choices.iter().map(|(known, _)| *known);
        Err(match nearest(word, known()) {
            Some(closest) => {
                let (what, name, closest) = (name, shown(word), Some(closest.to_owned()));
                self.document.error(place, SceneErrorKind::Unknown { what, name, closest })
            }
            None => {
                let known: Vec<_> = known().collect();
                let (word, known) = (shown(word), known.join(", "));
                self.document.invalid(place, format!("no {name} \"{word}\"; there are {known}"))
            }
        })
    }

    pub(super) fn vector(&self, name: &str) -> Result<Option<[f64; 3]>, SceneError> {
        let Some(written) = self.property(name) else { return Ok(None) };
        match *written.value {
            Value::Vector(v) => Ok(Some(v)),
            _ => Err(self.wrong_type(name, written, "a point or a vector")),
        }
    }

    pub(super) fn transform(&self, name: &str) -> Result<Affine, SceneError> {
        let Some(written) = self.property(name) else { return Ok(Affine::IDENTITY) };
        match *written.value {
            Value::Transform(matrix) => Ok(matrix),
            _ => Err(self.wrong_type(name, written, "a transform")),
        }
    }

    /// The name of a file, which must be there.
    pub(super) fn file_name(&self) -> Result<(&'d str, Place), SceneError> {
        match (self.text("filename")?, self.property("filename")) {
            (Some(name), Some(written)) => Ok((name, written.place)),
            _ => {
                let (class, plugin) = (self.class().name(), shown(self.plugin()));
                let what = format!("{class} \"{plugin}\" needs a filename");
                Err(self.document.invalid(self.place(), what))
            }
        }
    }
}

/// A document that is being put together.
struct Builder<'o> {
    document: Document<'o>,
    options: &'o ReadOptions<'o>,
    parameters: Parameters,
    ids: HashMap<String, usize>,
    /// An object, the number of its part, the name of what it refers to.
    references: Vec<(usize, usize, String)>,
    /// New names for old ones.
    aliases: Vec<(String, String, Place)>,
    includes: usize,
}

/// Where elements are taken in: a file, and whether it was written for an old version.
#[derive(Clone, Copy)]
struct Here {
    file: u32,
    old: bool,
}

impl Builder<'_> {
    /// Takes a file in, as a part of the object `into`.
    fn file(
        &mut self,
        path: PathBuf,
        text: &Rc<str>,
        into: usize,
        within: &mut Vec<PathBuf>,
    ) -> Result<(), SceneError> {
        let number = self.document.sources.len() as u32;
        let tree = xml::parse(text, &self.options.limits);
        let tree = tree.map_err(|(at, kind)| SceneError {
            at: text::place(&path, text.as_bytes(), at),
            kind,
        })?;
        // The places of what is read next are told by the text.
        self.document.sources.push((path, Rc::clone(text)));
        let root = &tree.elements[0];
        let here = Here { file: number, old: is_old(root) };
        if root.tag != "scene" {
            if into == 0 && number == 0 {
                let place = Place { file: number, at: root.at };
                let what =
                    format!("a Mitsuba scene begins with <scene>, not <{}>", shown(root.tag));
                return Err(self.document.invalid(place, what));
            }
            return self.element(&tree, 0, into, here, within);
        }
        for &child in &root.children {
            self.element(&tree, child, into, here, within)?;
        }
        Ok(())
    }

    fn element(
        &mut self,
        tree: &Tree<'_>,
        number: usize,
        parent: usize,
        here: Here,
        within: &mut Vec<PathBuf>,
    ) -> Result<(), SceneError> {
        let element = &tree.elements[number];
        let place = Place { file: here.file, at: element.at };
        match element.tag {
            "default" => {
                let [name, value] = self.attributes(element, here, ["name", "value"])?;
                let (name, value) =
                    (self.needed(name, "name", place)?, self.needed(value, "value", place)?);
                self.parameters.declare(&name, value);
                self.childless(tree, element, here)
            }
            "include" => {
                let [name] = self.attributes(element, here, ["filename"])?;
                let name = self.needed(name, "filename", place)?;
                self.childless(tree, element, here)?;
                self.include(&name, place, parent, within)
            }
            "path" => {
                let [value] = self.attributes(element, here, ["value"])?;
                let folder = self.needed(value, "value", place)?;
                self.document.folders.push(folder);
                self.childless(tree, element, here)
            }
            "alias" => {
                let [id, new] = self.attributes(element, here, ["id", "as"])?;
                let (id, new) = (self.needed(id, "id", place)?, self.needed(new, "as", place)?);
                self.aliases.push((id, new, place));
                self.childless(tree, element, here)
            }
            "ref" => {
                let [id, name] = self.attributes(element, here, ["id", "name"])?;
                let id = self.needed(id, "id", place)?;
                self.childless(tree, element, here)?;
                let name = renamed(name.unwrap_or_default(), here.old);
                let object = &mut self.document.objects[parent];
                self.references.push((parent, object.parts.len(), id));
                object.parts.push(Part { name, object: 0, place, read: Cell::new(false) });
                Ok(())
            }
            "null" => Ok(()),
            tag => {
                let typed = element.attributes.iter().any(|a| a.name == "type");
                let class = CLASSES.iter().find(|(name, _)| *name == tag).map(|(_, class)| *class);
                match class {
                    Some(Class::Spectrum) if !typed => self.property(tree, element, parent, here),
                    Some(Class::Scene) => {
                        Err(self.document.invalid(place, "a <scene> cannot stand within another"))
                    }
                    Some(class) => self.object(tree, element, class, parent, here, within),
                    None => self.property(tree, element, parent, here),
                }
            }
        }
    }

    fn object(
        &mut self,
        tree: &Tree<'_>,
        element: &Element<'_>,
        class: Class,
        parent: usize,
        here: Here,
        within: &mut Vec<PathBuf>,
    ) -> Result<(), SceneError> {
        let place = Place { file: here.file, at: element.at };
        let [plugin, id, name] = self.attributes(element, here, ["type", "id", "name"])?;
        let plugin = self.needed(plugin, "type", place)?;
        let id = id.unwrap_or_default();
        let number = self.document.objects.len();
        let allowed = self.options.limits.objects;
        if number as u64 > allowed {
            let asked = number as u64;
            return Err(self
                .document
                .error(place, SceneErrorKind::Limit { what: "objects", asked, allowed }));
        }
        if !id.is_empty() && self.ids.insert(id.clone(), number).is_some() {
            let what = format!("there is another object with the id \"{}\"", shown(&id));
            return Err(self.document.invalid(place, what));
        }
        let name = renamed(name.unwrap_or_default(), here.old);
        let part = Part { name, object: number, place, read: Cell::new(false) };
        self.document.objects[parent].parts.push(part);
        self.document.objects.push(Object {
            class,
            plugin,
            id,
            place,
            properties: Vec::new(),
            parts: Vec::new(),
            seen: Cell::new(false),
        });
        for &child in &element.children {
            self.element(tree, child, number, here, within)?;
        }
        Ok(())
    }

    fn property(
        &mut self,
        tree: &Tree<'_>,
        element: &Element<'_>,
        parent: usize,
        here: Here,
    ) -> Result<(), SceneError> {
        let place = Place { file: here.file, at: element.at };
        if !value::TAGS.contains(&element.tag) {
            let known = value::TAGS.iter().copied().chain(CLASSES.iter().map(|(name, _)| *name));
            let closest = nearest(element.tag, known).map(str::to_owned);
            let name = shown(element.tag);
            return Err(self
                .document
                .error(place, SceneErrorKind::Unknown { what: "element", name, closest }));
        }
        let words = self.words(element, here)?;
        let mut steps = Vec::new();
        for &child in &element.children {
            let step = &tree.elements[child];
            let words = self.words(step, here)?;
            steps.push((step.tag, words, step.at));
            self.childless(tree, step, here)?;
        }
        let at_fault = |at: usize| Place { file: here.file, at };
        let read = value::read(element.tag, element.at, &words, &steps);
        let value = read.map_err(|(at, kind)| self.document.error(at_fault(at), kind))?;
        let name = words.iter().find(|word| word.name == "name").map(|word| word.value.clone());
        let name = renamed(self.needed(name, "name", place)?, here.old);
        let object = &mut self.document.objects[parent];
        if object.properties.iter().any(|property| property.name == name) {
            let what = format!("{} comes twice", shown(&name));
            return Err(self.document.invalid(place, what));
        }
        let (asked, allowed) = (object.properties.len() as u64 + 1, MOST_PROPERTIES);
        if asked > allowed {
            let what = "properties of one object";
            let kind = SceneErrorKind::Limit { what, asked, allowed };
            return Err(self.document.error(place, kind));
        }
        object.properties.push(Property { name, value, place, read: Cell::new(false) });
        Ok(())
    }

    fn include(
        &mut self,
        name: &str,
        place: Place,
        parent: usize,
        within: &mut Vec<PathBuf>,
    ) -> Result<(), SceneError> {
        let found = self.document.content(name, place)?;
        if within.contains(&found.identity) {
            let what = format!("\"{}\" includes itself, by itself or by others", shown(name));
            return Err(self.document.invalid(place, what));
        }
        let asked = within.len() as u64 + 1;
        if asked > DEEPEST_INCLUDE as u64 {
            let (what, allowed) = ("levels of included files", DEEPEST_INCLUDE as u64);
            return Err(self.document.error(place, SceneErrorKind::Limit { what, asked, allowed }));
        }
        self.includes += 1;
        if self.includes > MOST_INCLUDES {
            let (asked, allowed) = (self.includes as u64, MOST_INCLUDES as u64);
            let what = "included files";
            return Err(self.document.error(place, SceneErrorKind::Limit { what, asked, allowed }));
        }
        let text = plain_text(found.bytes, &found.path)?;
        within.push(found.identity);
        self.file(found.path, &text.into(), parent, within)?;
        within.pop();
        Ok(())
    }

    /// Follows all references.
    fn resolve(&mut self) -> Result<(), SceneError> {
        for (old, new, place) in std::mem::take(&mut self.aliases) {
            match self.ids.get(&old).copied() {
                Some(number) => {
                    self.ids.insert(new, number);
                }
                None => return Err(self.no_such_id(&old, place)),
            }
        }
        for (object, part, id) in std::mem::take(&mut self.references) {
            let place = self.document.objects[object].parts[part].place;
            match self.ids.get(&id) {
                Some(&number) => self.document.objects[object].parts[part].object = number,
                None => return Err(self.no_such_id(&id, place)),
            }
        }
        Ok(())
    }

    fn no_such_id(&self, id: &str, place: Place) -> SceneError {
        let closest = nearest(id, self.ids.keys().map(String::as_str)).map(shown);
        let kind = SceneErrorKind::Unknown { what: "object with the id", name: shown(id), closest };
        self.document.error(place, kind)
    }

    /// The values of attributes, with `$names` replaced; others must not be there.
    fn attributes<const N: usize>(
        &mut self,
        element: &Element<'_>,
        here: Here,
        names: [&'static str; N],
    ) -> Result<[Option<String>; N], SceneError> {
        if let Some(other) = element.attributes.iter().find(|a| !names.contains(&a.name)) {
            let closest = nearest(other.name, names).map(str::to_owned);
            let kind =
                SceneErrorKind::Unknown { what: "attribute", name: shown(other.name), closest };
            return Err(self.document.error(Place { file: here.file, at: other.at }, kind));
        }
        let mut values = [const { None }; N];
        for (value, name) in values.iter_mut().zip(names) {
            if let Some(attribute) = element.attributes.iter().find(|a| a.name == name) {
                *value = Some(self.replaced(attribute, here)?);
            }
        }
        Ok(values)
    }

    /// All attributes, with `$names` replaced.
    fn words(&mut self, element: &Element<'_>, here: Here) -> Result<Vec<value::Word>, SceneError> {
        let each = element.attributes.iter().map(|attribute| {
            let value = self.replaced(attribute, here)?;
            Ok(value::Word { name: attribute.name.to_owned(), value, at: attribute.at })
        });
        each.collect()
    }

    fn replaced(&mut self, attribute: &Attribute<'_>, here: Here) -> Result<String, SceneError> {
        let place = Place { file: here.file, at: attribute.at };
        let replaced = self.parameters.replace(&attribute.value);
        replaced.map_err(|kind| self.document.error(place, kind))
    }

    fn needed(
        &self,
        value: Option<String>,
        name: &str,
        place: Place,
    ) -> Result<String, SceneError> {
        value.ok_or_else(|| self.document.invalid(place, format!("{name} is missing")))
    }

    fn childless(
        &self,
        tree: &Tree<'_>,
        element: &Element<'_>,
        here: Here,
    ) -> Result<(), SceneError> {
        let Some(&child) = element.children.first() else { return Ok(()) };
        let child = &tree.elements[child];
        let place = Place { file: here.file, at: child.at };
        let what = format!("<{}> cannot stand within <{}>", shown(child.tag), shown(element.tag));
        Err(self.document.invalid(place, what))
    }
}

/// Whether a file was written for a version before 2, with names in camelCase.
fn is_old(root: &Element<'_>) -> bool {
    let version = root.attributes.iter().find(|attribute| attribute.name == "version");
    let major =
        version.and_then(|version| version.value.split('.').next()?.trim().parse::<u32>().ok());
    major.is_some_and(|major| major < 2)
}

/// A property's name as Mitsuba 3 has it.
fn renamed(name: String, old: bool) -> String {
    if !old {
        return name;
    }
    match &*name {
        "intIOR" => return "int_ior".to_owned(),
        "extIOR" => return "ext_ior".to_owned(),
        _ => {}
    }
    let mut new = String::new();
    for c in name.chars() {
        if c.is_ascii_uppercase() && !new.is_empty() {
            new.push('_');
        }
        new.push(c.to_ascii_lowercase());
    }
    new
}

/// Bytes as text, without the byte order mark.
pub(super) fn plain_text(bytes: Vec<u8>, path: &Path) -> Result<String, SceneError> {
    let text = text::in_utf8(bytes, path)?;
    Ok(match text.strip_prefix('\u{feff}') {
        Some(rest) => rest.to_owned(),
        None => text,
    })
}
