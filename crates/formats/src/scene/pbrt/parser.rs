//! From statements to a description: one loop over the statements of all files, and the state that
//! they change.
//!
//! Nothing is nested in the program as it is in the text: begun attributes and included files lie on
//! lists, so that no text can make a stack too small here. Textures of textures and mixtures of
//! mixtures are followed later, by calls within calls, and up to a fixed depth.

use super::description::{
    Description, Eye, Instance, LightStatement, Named, Placed, TextureStatement,
};
use super::gzip;
use super::lexer::{Kind, Lexer, Place, Texts, number};
use super::parameters::{Before, Parameters};
use super::shapes::{self, PlyFiles};
use super::state::{AreaLight, Chosen, Saved, State, TARGETS};
use crate::error::{SceneError, SceneErrorKind};
use crate::file;
use crate::limits::Limits;
use crate::options::ReadOptions;
use crate::scene::affine::Affine;
use crate::scene::files::Files;
use crate::scene::nearest::nearest;
use crate::scene::notes::Notes;
use crate::shown::shown;
use rutilant_geom::DVec3;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// All statements there are.
const STATEMENTS: [&str; 46] = [
    "Accelerator",
    "ActiveTransform",
    "AreaLightSource",
    "Attribute",
    "AttributeBegin",
    "AttributeEnd",
    "Camera",
    "ColorSpace",
    "ConcatTransform",
    "CoordSysTransform",
    "CoordinateSystem",
    "Film",
    "Identity",
    "Import",
    "Include",
    "Integrator",
    "LightSource",
    "LookAt",
    "MakeNamedMaterial",
    "MakeNamedMedium",
    "Material",
    "MediumInterface",
    "NamedMaterial",
    "ObjectBegin",
    "ObjectEnd",
    "ObjectInstance",
    "Option",
    "PixelFilter",
    "Renderer",
    "ReverseOrientation",
    "Rotate",
    "Sampler",
    "Scale",
    "Shape",
    "SurfaceIntegrator",
    "Texture",
    "Transform",
    "TransformBegin",
    "TransformEnd",
    "TransformTimes",
    "Translate",
    "Volume",
    "VolumeIntegrator",
    "VolumeRegion",
    "WorldBegin",
    "WorldEnd",
];

/// So many files may be read into one scene: files that include each other twice would else be read
/// for ever.
const MOST_INCLUDED: usize = 100_000;

/// A text that is being read.
struct Open {
    lexer: Lexer,
    /// The file, the same for every name of it; `None` for the scene itself and what was given.
    identity: Option<PathBuf>,
    /// What is found again at its end, of a file that was imported.
    restores: Option<Box<State>>,
}

/// What is known so far.
pub(super) struct Parser<'o> {
    pub(super) texts: Texts,
    pub(super) notes: Notes,
    pub(super) files: &'o Files<'o>,
    pub(super) limits: &'o Limits,
    pub(super) description: Description,
    pub(super) ply: PlyFiles,
    /// Vertices and triangles that may still come.
    pub(super) vertices_left: u64,
    pub(super) triangles_left: u64,
    state: State,
    saved: Vec<(Saved, Place)>,
    systems: HashMap<String, Affine>,
    in_world: bool,
    /// The name of the object that is being described.
    object: Option<String>,
    area_lights: usize,
    included: usize,
}

impl<'o> Parser<'o> {
    pub(super) fn new(files: &'o Files<'o>, options: &'o ReadOptions<'o>) -> Self {
        Self {
            texts: Texts::default(),
            notes: Notes::default(),
            files,
            limits: &options.limits,
            description: Description::default(),
            ply: PlyFiles::default(),
            vertices_left: options.limits.vertices,
            triangles_left: options.limits.triangles,
            state: State::default(),
            saved: Vec::new(),
            systems: HashMap::new(),
            in_world: false,
            object: None,
            area_lights: 0,
            included: 0,
        }
    }

    /// Reads a scene and all that it includes.
    pub(super) fn read(&mut self, bytes: Vec<u8>, path: &Path) -> Result<(), SceneError> {
        let lexer = self.texts.open(path.to_owned(), bytes);
        let mut open = vec![Open { lexer, identity: path.canonicalize().ok(), restores: None }];
        while let Some(current) = open.last_mut() {
            let Some(token) = current.lexer.take(&self.texts)? else {
                if let Some(state) = open.pop().and_then(|open| open.restores) {
                    self.state = *state;
                }
                continue;
            };
            if token.kind != Kind::Word {
                let found = match token.kind {
                    Kind::Open => "[".to_owned(),
                    Kind::Close => "]".to_owned(),
                    Kind::Word | Kind::Text => current.lexer.shown(&token),
                };
                let what = format!("{found} stands where a statement must begin");
                return Err(self.texts.invalid(token.place, what));
            }
            let name = String::from_utf8_lossy(current.lexer.letters(&token)).into_owned();
            match &*name {
                "Include" | "Import" => {
                    let file = self.text(&mut current.lexer, token.place, &name)?;
                    let next = self.include(&file, token.place, &open, name == "Import")?;
                    open.push(next);
                }
                _ => self.statement(&name, token.place, &mut current.lexer)?,
            }
        }
        if let Some((saved, place)) = self.saved.last() {
            let what = format!("nothing ends this {}", saved.begun_by());
            return Err(self.texts.invalid(*place, what));
        }
        Ok(())
    }

    fn include(
        &mut self,
        name: &str,
        place: Place,
        open: &[Open],
        import: bool,
    ) -> Result<Open, SceneError> {
        let limit = |what, asked, allowed| SceneErrorKind::Limit { what, asked, allowed };
        self.included += 1;
        if self.included > MOST_INCLUDED {
            let most = MOST_INCLUDED as u64;
            return Err(self.texts.error(place, limit("included files", most + 1, most)));
        }
        if open.len() as u64 > self.limits.nesting {
            let asked = open.len() as u64;
            let kind = limit("levels of nesting", asked, self.limits.nesting);
            return Err(self.texts.error(place, kind));
        }
        let (bytes, path, identity) = match self.files.embedded(name) {
            Some(bytes) => (bytes.to_owned(), self.files.path(name), PathBuf::from(name)),
            None => {
                let found =
                    self.files.find(name).map_err(|what| self.texts.invalid(place, what))?;
                let bytes = file::scene_bytes(&found.path, self.limits)?;
                (bytes, found.path, found.identity)
            }
        };
        if open.iter().any(|open| open.identity.as_ref() == Some(&identity)) {
            let what = format!("\"{}\" includes itself", shown(name));
            return Err(self.texts.invalid(place, what));
        }
        let bytes = gzip::unpacked(bytes, &path, self.limits)?;
        if self.files.embedded(name).is_none() && !self.description.files.contains(&identity) {
            self.description.files.push(identity.clone());
        }
        let lexer = self.texts.open(path, bytes);
        let restores = import.then(|| Box::new(self.state.clone()));
        Ok(Open { lexer, identity: Some(identity), restores })
    }

    /// Tells of a statement on the wrong side of `WorldBegin`, which pbrt refuses.
    fn check_side(&mut self, name: &str, place: Place) {
        let what = match name {
            "Camera" | "Film" | "Integrator" | "PixelFilter" | "Sampler" if self.in_world => {
                format!("{name} must stand before WorldBegin: it counts as if it did")
            }
            "Shape" | "LightSource" | "ObjectInstance" if !self.in_world => {
                "there is no WorldBegin before the first thing of the world: it counts as if there \
                 were"
                    .to_owned()
            }
            _ => return,
        };
        self.notes.say(&self.texts, place, what);
    }

    fn statement(&mut self, name: &str, place: Place, lexer: &mut Lexer) -> Result<(), SceneError> {
        self.check_side(name, place);
        match name {
            // Transformations.
            "Identity" => self.state.map = Affine::IDENTITY,
            "Translate" => {
                let by = self.numbers::<3>(lexer, name)?;
                self.multiply(Affine::translate(vector(&by)), place)?;
            }
            "Scale" => {
                let by = self.numbers::<3>(lexer, name)?;
                self.multiply(Affine::scale(vector(&by)), place)?;
            }
            "Rotate" => {
                let [degrees, axis @ ..] = self.numbers::<4>(lexer, name)?;
                let turn = Affine::rotate(degrees, vector(&axis))
                    .ok_or_else(|| self.texts.invalid(place, "the axis of Rotate has no length"))?;
                self.multiply(turn, place)?;
            }
            "LookAt" => {
                let all = self.numbers::<9>(lexer, name)?;
                let [eye, at, up] = [0, 3, 6].map(|i| vector(&[all[i], all[i + 1], all[i + 2]]));
                let map = Affine::look_at(eye, at, up).and_then(|eye| eye.inverse()).ok_or_else(
                    || {
                        let what = "LookAt has no direction: both points are the same, or up is \
                                parallel to the view";
                        self.texts.invalid(place, what)
                    },
                )?;
                self.multiply(map, place)?;
            }
            "Transform" | "ConcatTransform" => {
                let map = self.matrix(lexer, name, place)?;
                if name == "Transform" && self.state.at_start {
                    self.state.map = map;
                } else {
                    self.multiply(map, place)?;
                }
            }
            "CoordinateSystem" => {
                let system = self.text(lexer, place, name)?;
                if self.systems.len() < self.limits.objects as usize {
                    self.systems.insert(system, self.state.map);
                }
            }
            "CoordSysTransform" => {
                let system = self.text(lexer, place, name)?;
                self.state.map = *self.systems.get(&system).ok_or_else(|| {
                    let known = self.systems.keys().map(String::as_str);
                    self.texts.error(
                        place,
                        SceneErrorKind::Unknown {
                            what: "coordinate system",
                            closest: nearest(&system, known).map(shown),
                            name: shown(&system),
                        },
                    )
                })?;
            }
            "ActiveTransform" => {
                let token = lexer.take(&self.texts)?;
                match token.as_ref().map(|token| lexer.letters(token)) {
                    Some(b"All" | b"StartTime") => self.state.at_start = true,
                    Some(b"EndTime") => {
                        self.state.at_start = false;
                        let what =
                            "nothing moves: only the moment at which the shutter opens is shown";
                        self.notes.say(&self.texts, place, what);
                    }
                    Some(_) | None => {
                        let what = "ActiveTransform must be All, StartTime or EndTime";
                        return Err(self.texts.invalid(place, what));
                    }
                }
            }
            "TransformTimes" => {
                self.numbers::<2>(lexer, name)?;
            }

            // What is begun, and ends.
            "AttributeBegin" => {
                self.save(Saved::Attributes(Box::new(self.state.clone())), place)?;
            }
            "TransformBegin" => self.save(Saved::Transform(self.state.map), place)?,
            "ObjectBegin" => {
                let object = self.text(lexer, place, name)?;
                if self.object.is_some() {
                    let what = "an object cannot be described within another one";
                    return Err(self.texts.invalid(place, what));
                }
                self.save(Saved::Object(Box::new(self.state.clone())), place)?;
                self.description.objects.entry(object.clone()).or_default().clear();
                self.object = Some(object);
            }
            "AttributeEnd" | "TransformEnd" | "ObjectEnd" => self.restore(name, place)?,
            "WorldBegin" => {
                self.in_world = true;
                self.state.map = Affine::IDENTITY;
                self.systems.insert("world".to_owned(), Affine::IDENTITY);
            }
            "WorldEnd" => self.description.is_old = true,

            // How to render.
            "Camera" => {
                let (kind, parameters) = self.made(lexer, name, place)?;
                let map = self.state.map;
                if !self.state.outside.is_empty() {
                    let what = "the camera stands in no medium: that around it is left out";
                    self.notes.say(&self.texts, place, what);
                }
                if let Some(back) = map.inverse() {
                    self.systems.insert("camera".to_owned(), back);
                }
                self.description.camera = Some(Eye { kind, parameters, map });
            }
            "Film" => {
                let named = self.named(lexer, name, place)?;
                self.description.is_old |= named.name == "image";
                self.description.film = Some(named);
            }
            "PixelFilter" => self.description.filter = Some(self.named(lexer, name, place)?),
            "Sampler" => self.description.sampler = Some(self.named(lexer, name, place)?),
            "Integrator" | "SurfaceIntegrator" => {
                self.description.integrator = Some(self.named(lexer, name, place)?);
            }
            // Matters of the program, not of the picture.
            "Accelerator" => {
                self.made(lexer, name, place)?;
            }
            "Renderer" | "VolumeIntegrator" => {
                self.made(lexer, name, place)?;
                self.notes.say(&self.texts, place, format!("{name} is left out"));
            }
            "Option" => {
                Parameters::read(name.to_owned(), place, lexer, &self.texts)?;
                self.notes.say(&self.texts, place, "Option is left out");
            }
            "ColorSpace" => {
                let space = self.text(lexer, place, name)?;
                if space != "srgb" {
                    let what = format!(
                        "ColorSpace \"{}\" is left out: colours are taken as those of sRGB",
                        shown(&space)
                    );
                    self.notes.say(&self.texts, place, what);
                }
            }

            // What there is.
            "Shape" => self.shape(lexer, place)?,
            "ObjectInstance" => {
                let object = self.text(lexer, place, name)?;
                if self.object.is_some() {
                    let what = "an object cannot be placed within another one";
                    return Err(self.texts.invalid(place, what));
                }
                self.check_objects(self.description.instances.len() + 1, place)?;
                let map = self.state.map;
                self.description.instances.push(Instance { name: object, map, place });
            }
            "LightSource" => {
                let (kind, parameters) = self.made(lexer, name, place)?;
                let parameters = parameters.with_defaults(&self.state.defaults[1]);
                let map = self.state.map;
                self.check_objects(self.description.lights.len() + 1, place)?;
                self.description.lights.push(LightStatement { kind, parameters, map });
            }
            "AreaLightSource" => {
                let (kind, parameters) = self.made(lexer, name, place)?;
                let parameters = parameters.with_defaults(&self.state.defaults[1]);
                let number = self.area_lights;
                self.area_lights += 1;
                self.state.area_light = Some(Rc::new(AreaLight { number, kind, parameters }));
            }
            "Material" => {
                let (kind, parameters) = self.made(lexer, name, place)?;
                let parameters = parameters.with_defaults(&self.state.defaults[2]);
                self.state.material = Chosen::Own(self.description.own_materials.len());
                self.description.own_materials.push(Named { name: kind, parameters });
            }
            "MakeNamedMaterial" => {
                let (own, parameters) = self.made(lexer, name, place)?;
                let parameters = parameters.with_defaults(&self.state.defaults[2]);
                self.description.named_materials.push(Named { name: own, parameters });
            }
            "NamedMaterial" => {
                let named = self.text(lexer, place, name)?;
                let before = self.description.named_materials.len();
                self.state.material = Chosen::Named { name: named.into(), place, before };
            }
            "Texture" => {
                let texture = self.text(lexer, place, name)?;
                let value = self.text(lexer, place, name)?;
                let colors = match &*value {
                    "float" => false,
                    "spectrum" | "color" => true,
                    other => {
                        let what = format!(
                            "a texture of \"{}\" is none: it must be of \"float\" or \"spectrum\"",
                            shown(other)
                        );
                        return Err(self.texts.invalid(place, what));
                    }
                };
                let (kind, parameters) = self.made(lexer, name, place)?;
                let parameters = parameters.with_defaults(&self.state.defaults[4]);
                let statement = TextureStatement { name: texture, colors, kind, parameters };
                self.description.textures.push(statement);
            }
            "MakeNamedMedium" => {
                let (medium, parameters) = self.made(lexer, name, place)?;
                let parameters = parameters.with_defaults(&self.state.defaults[3]);
                self.description.media.insert(medium, parameters);
            }
            "MediumInterface" => {
                let inside = self.text(lexer, place, name)?;
                let next = lexer.peek(&self.texts)?.filter(|token| token.kind == Kind::Text);
                let outside = match next {
                    Some(_) => self.text(lexer, place, name)?,
                    None => inside.clone(),
                };
                (self.state.inside, self.state.outside) = (inside.into(), outside.into());
            }
            "ReverseOrientation" => self.state.reversed = !self.state.reversed,
            "Attribute" => {
                let target = self.text(lexer, place, name)?;
                let Some(i) = TARGETS.iter().position(|known| *known == target) else {
                    let kind = SceneErrorKind::Unknown {
                        what: "target of Attribute",
                        closest: nearest(&target, TARGETS).map(str::to_owned),
                        name: shown(&target),
                    };
                    return Err(self.texts.error(place, kind));
                };
                let of = format!("Attribute \"{target}\"");
                let parameters = Parameters::read(of, place, lexer, &self.texts)?;
                let defaults = Rc::make_mut(&mut self.state.defaults);
                let mut list = parameters.into_list();
                list.append(&mut defaults[i]);
                list.truncate(MOST_DEFAULTS);
                defaults[i] = list;
            }
            "Volume" | "VolumeRegion" => {
                self.made(lexer, name, place)?;
                self.notes.say(&self.texts, place, format!("{name} is left out"));
            }
            other => {
                let kind = SceneErrorKind::Unknown {
                    what: "statement",
                    name: shown(other),
                    closest: nearest(other, STATEMENTS).map(str::to_owned),
                };
                return Err(self.texts.error(place, kind));
            }
        }
        Ok(())
    }

    fn shape(&mut self, lexer: &mut Lexer, place: Place) -> Result<(), SceneError> {
        let (kind, parameters) = self.made(lexer, "Shape", place)?;
        let parameters = parameters.with_defaults(&self.state.defaults[0]);
        self.check_objects(self.description.shapes.len() + 1, place)?;
        let (form, parts) = shapes::read(&kind, &parameters, self)?;
        let mut state = self.state.clone();
        if self.object.is_some() && state.area_light.take().is_some() {
            let what = "what is placed as an object does not glow: AreaLightSource is left out";
            self.notes.say(&self.texts, place, what);
        }
        let number = self.description.shapes.len();
        self.description.shapes.push(Placed { form, state, parameters, parts });
        match &self.object {
            Some(name) => self.description.objects.entry(name.clone()).or_default().push(number),
            None => self.description.free.push(number),
        }
        Ok(())
    }

    fn check_objects(&self, count: usize, place: Place) -> Result<(), SceneError> {
        let (asked, allowed) = (count as u64, self.limits.objects);
        if asked <= allowed {
            return Ok(());
        }
        let kind = SceneErrorKind::Limit { what: "objects", asked, allowed };
        Err(self.texts.error(place, kind))
    }

    fn save(&mut self, saved: Saved, place: Place) -> Result<(), SceneError> {
        let (asked, allowed) = (self.saved.len() as u64 + 1, self.limits.nesting);
        if asked > allowed {
            let kind = SceneErrorKind::Limit { what: "levels of nesting", asked, allowed };
            return Err(self.texts.error(place, kind));
        }
        self.saved.push((saved, place));
        Ok(())
    }

    fn restore(&mut self, by: &str, place: Place) -> Result<(), SceneError> {
        let Some((saved, begun)) = self.saved.pop() else {
            return Err(self.texts.invalid(place, format!("{by} ends nothing that was begun")));
        };
        match (saved, by) {
            (Saved::Attributes(state), "AttributeEnd") => self.state = *state,
            (Saved::Transform(map), "TransformEnd") => self.state.map = map,
            (Saved::Object(state), "ObjectEnd") => {
                self.state = *state;
                self.object = None;
            }
            (saved, _) => {
                let line = begun.line;
                let what =
                    format!("{by} stands where the {} of line {line} must end", saved.begun_by());
                return Err(self.texts.invalid(place, what));
            }
        }
        Ok(())
    }

    fn multiply(&mut self, by: Affine, place: Place) -> Result<(), SceneError> {
        if !self.state.at_start {
            return Ok(());
        }
        self.state.map = self.state.map * by;
        if self.state.map.is_finite() {
            return Ok(());
        }
        Err(self.texts.invalid(place, "the transformation has grown beyond all numbers"))
    }

    /// The text that must follow.
    fn text(&self, lexer: &mut Lexer, place: Place, of: &str) -> Result<String, SceneError> {
        match lexer.take(&self.texts)? {
            Some(token) if token.kind == Kind::Text => Ok(lexer.string(&token)),
            Some(token) => {
                let what = format!("{of} must be followed by a text between \"\"");
                Err(self.texts.invalid(token.place, what))
            }
            None => {
                let what =
                    format!("{of} must be followed by a text between \"\", but the file ends");
                Err(self.texts.invalid(place, what))
            }
        }
    }

    /// What must follow: a name, and parameters.
    fn made(
        &self,
        lexer: &mut Lexer,
        statement: &str,
        place: Place,
    ) -> Result<(String, Parameters), SceneError> {
        let name = self.text(lexer, place, statement)?;
        let of = format!("{statement} \"{}\"", shown(&name));
        let mut parameters = Parameters::read(of, place, lexer, &self.texts)?;
        parameters.before = Before {
            textures: self.description.textures.len(),
            materials: self.description.named_materials.len(),
        };
        Ok((name, parameters))
    }

    fn named(&self, lexer: &mut Lexer, statement: &str, place: Place) -> Result<Named, SceneError> {
        let (name, parameters) = self.made(lexer, statement, place)?;
        Ok(Named { name, parameters })
    }

    /// The numbers that must follow, in brackets or not.
    fn numbers<const N: usize>(&self, lexer: &mut Lexer, of: &str) -> Result<[f32; N], SceneError> {
        let bracket = lexer.peek(&self.texts)?.is_some_and(|token| token.kind == Kind::Open);
        if bracket {
            lexer.take(&self.texts)?;
        }
        let mut all = [0.0; N];
        for value in &mut all {
            let here = lexer.place();
            let token = lexer.take(&self.texts)?;
            let word = token.as_ref().filter(|token| token.kind == Kind::Word);
            let found = word.and_then(|token| number(lexer.letters(token)));
            *value = found.filter(|value| value.is_finite()).ok_or_else(|| {
                let at = token.as_ref().map_or(here, |token| token.place);
                self.texts.invalid(at, format!("{of} must be followed by {N} finite numbers"))
            })?;
        }
        if bracket {
            let here = lexer.place();
            let token = lexer.take(&self.texts)?;
            if token.as_ref().is_none_or(|token| token.kind != Kind::Close) {
                let at = token.as_ref().map_or(here, |token| token.place);
                return Err(self.texts.invalid(at, format!("{of} has {N} numbers, then a ]")));
            }
        }
        Ok(all)
    }

    fn matrix(&self, lexer: &mut Lexer, of: &str, place: Place) -> Result<Affine, SceneError> {
        let numbers = self.numbers::<16>(lexer, of)?;
        Affine::from_columns(&numbers).ok_or_else(|| {
            let what = format!(
                "the matrix of {of} is not affine: its numbers 4, 8, 12 and 16 must be 0, 0, 0 and 1"
            );
            self.texts.unsupported(place, what)
        })
    }
}

/// More than so many defaults for one target nobody sets.
const MOST_DEFAULTS: usize = 100;

fn vector(v: &[f32; 3]) -> DVec3 {
    DVec3::new(v[0].into(), v[1].into(), v[2].into())
}
