//! Where scenes come from, and how they are read: from a file or built in.

use rutilant::Prepared;
use rutilant::settings::Settings;
use rutilant::texture::Texture;
use rutilant_formats::camera::AuthoredCamera;
use rutilant_formats::{
    CameraChoice, ConvertOptions, Converted, Limits, LoadedScene, Look, PictureOrigin, ReadOptions,
    SkyChoice, TextureName, named_from, native_text, parse_native, read_scene,
};
use rutilant_geom::Aabb;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant, SystemTime};

use crate::live::{Stage, window_settings};
use crate::merge::changed_over;
use crate::watch::Watch;

/// A scene that needs no disk.
#[derive(Clone, Copy, Debug)]
pub struct BuiltIn {
    /// The file that it would stand in.
    pub file: &'static str,
    /// Its text, in the native format.
    pub text: &'static str,
    /// The images that it uses, by the names that it uses.
    pub images: &'static [(&'static str, &'static [u8])],
}

/// How scenes are read.
#[derive(Clone)]
pub struct Reading {
    /// What is shown where no file is named.
    pub built_in: BuiltIn,
    /// How much files may ask for.
    pub limits: Limits,
    /// Whether scenes may name files outside their own folders.
    pub allow_outside: bool,
    /// Whether a picture that is missing is an error.
    pub strict: bool,
    /// The variant of a glTF file's materials, by its name.
    pub variant: Option<String>,
    /// The time at which its animation stands, in seconds.
    pub at_time: Option<f32>,
    /// Names and values of a Mitsuba scene's parameters.
    pub parameters: Vec<(String, String)>,
    /// The camera to begin with.
    pub camera: CameraChoice,
    /// The sky to begin with.
    pub sky: SkyChoice,
    /// The size of the picture, whatever the scene says.
    pub size: Option<[u32; 2]>,
    /// What else of its settings the scene does not decide.
    pub adjust: Arc<dyn Fn(&mut Settings) + Send + Sync>,
}

impl Reading {
    /// How the scene in `file`, or the built-in one, is read by itself: in the size, by the camera and
    /// under the sky that it has.
    fn of_the_scene(&self, file: Option<&Path>) -> ReadOptions<'_> {
        ReadOptions {
            limits: self.limits,
            allow_outside: self.allow_outside,
            strict: self.strict,
            variant: self.variant.as_deref(),
            at_time: self.at_time,
            parameters: &self.parameters,
            embedded: if file.is_none() { self.built_in.images } else { &[] },
            ..ReadOptions::default()
        }
    }
}

/// A scene that has been read, without what is traced.
#[derive(Clone)]
pub(crate) struct Document {
    /// `None` for the built-in one.
    pub(crate) file: Option<PathBuf>,
    /// Its text, where it is a native scene.
    pub(crate) text: Option<String>,
    /// How it looks by its file, and by what was said when the window was opened.
    pub(crate) look: Look,
    /// Its settings by its file alone.
    pub(crate) filed: Settings,
    /// Its cameras by the file.
    pub(crate) cameras: Vec<AuthoredCamera>,
    pub(crate) image_names: Vec<String>,
    /// How many of the images are the file's own; the others are there because the window was
    /// opened with them.
    pub(crate) own_images: usize,
    /// What varies over surfaces, and what the text calls it.
    pub(crate) textures: (Vec<Texture>, Vec<TextureName>),
    /// The files that it is made of, its own not among them.
    pub(crate) files: Vec<PathBuf>,
    pub(crate) notes: Vec<String>,
    pub(crate) bounds: Aabb,
    pub(crate) triangles: u64,
    /// How long it took to read it, and to make it traceable.
    pub(crate) took: [Duration; 2],
}

impl Document {
    /// What people call it.
    pub(crate) fn name(&self, reading: &Reading) -> String {
        let file = self.file.as_deref().unwrap_or(Path::new(reading.built_in.file));
        file.file_name().unwrap_or_default().to_string_lossy().into_owned()
    }
}

/// What is being done to open a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    Reading,
    /// Building the tree of so many triangles.
    Building(u64),
}

/// A scene that is being opened on a thread of its own.
pub(crate) struct Opening {
    pub(crate) file: Option<PathBuf>,
    pub(crate) since: Instant,
    /// The same by the clock that files are dated by.
    began: SystemTime,
    /// Whether it is the scene that is shown already.
    pub(crate) again: bool,
    pub(crate) reading: Reading,
    /// Its file, and all that it is known to be made of.
    pub(crate) watch: Watch,
    thread: JoinHandle<()>,
    shared: Arc<Mutex<(Step, Option<Opened>)>>,
}

/// A scene, or the one line that says why there is none.
pub(crate) type Opened = Result<Box<(Stage, Document)>, String>;

impl Opening {
    /// Begins to open a scene, the built-in one without a file, which is made of `files` as well, as
    /// far as is known; `wake` is called at each step.
    pub(crate) fn begin(
        file: Option<PathBuf>,
        again: bool,
        files: &[PathBuf],
        reading: Reading,
        wake: impl Fn() + Clone + Send + 'static,
    ) -> Self {
        let began = SystemTime::now();
        // What changes while it is read will have to be read again.
        let watch = Watch::begin(file.iter().chain(files).cloned(), None, wake.clone());
        let shared = Arc::new(Mutex::new((Step::Reading, None)));
        let (theirs, path, reading_here) = (Arc::clone(&shared), file.clone(), reading.clone());
        let thread = std::thread::spawn(move || {
            let step = |step| {
                lock(&theirs).0 = step;
                wake();
            };
            let opened = open(path.as_deref(), &reading_here, step).map(Box::new);
            lock(&theirs).1 = Some(opened);
            wake();
        });
        Self { file, since: Instant::now(), began, again, reading, watch, thread, shared }
    }

    /// Those of these files that have been written since it began, by their dates: they may have
    /// been read before that.
    pub(crate) fn changed_meanwhile(&self, files: &[PathBuf]) -> Vec<PathBuf> {
        let now = SystemTime::now();
        let written = |file: &&PathBuf| {
            let written = std::fs::metadata(file).and_then(|metadata| metadata.modified());
            // A date in the future would be one for ever.
            written.is_ok_and(|written| (self.began..=now).contains(&written))
        };
        files.iter().filter(written).filter_map(|file| file.canonicalize().ok()).collect()
    }

    pub(crate) fn step(&self) -> Step {
        lock(&self.shared).0
    }

    /// What came of it, once it is there.
    pub(crate) fn take(&self) -> Option<Opened> {
        // Asked first: what has ended has left what came of it, unless it broke off.
        let ended = self.thread.is_finished();
        let opened = lock(&self.shared).1.take();
        let broken = || Err("the reading broke off; please report it as a bug".to_owned());
        opened.or_else(|| ended.then(broken))
    }
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Reads a scene and makes it traceable.
pub(crate) fn open(
    file: Option<&Path>,
    reading: &Reading,
    step: impl Fn(Step),
) -> Result<(Stage, Document), String> {
    let begin = Instant::now();
    let (text, mut loaded) = read(file, reading)?;
    let filed = loaded.settings.clone();
    (reading.adjust)(&mut loaded.settings);
    if let Some(size) = reading.size {
        loaded.settings.size = size;
    }
    let settings = window_settings(&loaded.settings, None);
    settings.validate().map_err(|problem| problem.to_string())?;
    let read = begin.elapsed();

    let triangles = loaded.scene.meshes.iter().map(|mesh| mesh.triangles.len() as u64).sum();
    step(Step::Building(triangles));
    let look = loaded.look();
    // What a pixel means depends on the size, which may be another than the file's.
    loaded.scene.camera = look.camera.camera(look.settings.size).map_err(|p| p.to_string())?;
    let prepared = Prepared::new(&loaded.scene).map_err(|problem| problem.to_string())?;
    let prepared = Arc::new(prepared);
    let took = [read, begin.elapsed() - read];

    let shown = file.unwrap_or(Path::new(reading.built_in.file));
    let report = prepared.report();
    let mended = report.notes.iter().map(|note| loaded.locate(note, shown));
    let notes = loaded.notes.iter().cloned().chain(mended).collect();
    let (bounds, triangles) = (report.bounds, report.triangles);
    let LoadedScene { scene, cameras, image_names, texture_names, files, .. } = loaded;
    let textures = (scene.textures.clone(), texture_names);
    let added = usize::from(matches!(reading.sky, SkyChoice::Picture(_)));
    let own_images = image_names.len().saturating_sub(added);
    let document = Document {
        file: file.map(Path::to_owned),
        text,
        look: look.clone(),
        filed,
        cameras,
        own_images,
        image_names,
        textures,
        files,
        notes,
        bounds,
        triangles,
        took,
    };
    Ok((Stage { scene, prepared, look: Arc::new(look) }, document))
}

/// The scene and, if it is a native one, its text.
fn read(file: Option<&Path>, reading: &Reading) -> Result<(Option<String>, LoadedScene), String> {
    let options = ReadOptions {
        size: reading.size,
        camera: &reading.camera,
        sky: &reading.sky,
        ..reading.of_the_scene(file)
    };
    let error = |error: rutilant_formats::SceneError| error.to_string();
    let Some(file) = file else {
        let BuiltIn { text, file, .. } = reading.built_in;
        let loaded = parse_native(text, Path::new(file), &options).map_err(error)?;
        return Ok((Some(text.to_owned()), loaded));
    };
    if is_native(file) {
        // Read once: this text is that of this scene, whatever happens to the file meanwhile.
        let text = native_text(file, &options.limits).map_err(error)?;
        let loaded = parse_native(&text, file, &options).map_err(error)?;
        return Ok((Some(text), loaded));
    }
    Ok((None, read_scene(file, &options).map_err(error)?))
}

/// Whether a file is a native scene, by its name.
pub(crate) fn is_native(file: &Path) -> bool {
    file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"))
}

/// Whether a file is a glTF document, or a scene of pbrt or Mitsuba, by its name: no scene can name
/// it as what it is, with lights and cameras.
fn is_document(file: &Path) -> bool {
    let extension = file.extension().unwrap_or_default();
    ["gltf", "glb", "pbrt", "xml"].iter().any(|name| extension.eq_ignore_ascii_case(name))
}

/// The scene as it looks now, to be written to `to`; `image_names` are those of all
/// images by number, as the scene names them where it is now.
pub(crate) fn text_of(
    document: &Document,
    look: &Look,
    image_names: &[String],
    to: &Path,
    reading: &Reading,
) -> Result<Converted, String> {
    let camera = match &*look.camera.name {
        "" => CameraChoice::First,
        name => CameraChoice::Named(name.to_owned()),
    };
    let options = ReadOptions { camera: &camera, ..reading.of_the_scene(document.file.as_deref()) };
    let error = |error: rutilant_formats::SceneError| error.to_string();
    // What the window was opened with is no part of the scene: where that has not been changed, the
    // file keeps its own.
    let look = |before: &LoadedScene| {
        let (mut look, filed) = (look.clone(), before.look());
        let was = &document.look;
        look.settings = changed_over(&was.settings, &look.settings, &filed.settings);
        look.settings.planned_spp = None;
        if reading.sky != SkyChoice::Own && look.environment == was.environment {
            look.environment = filed.environment;
        }
        if reading.camera == CameraChoice::Auto {
            if look.camera == was.camera {
                look.camera = filed.camera;
            } else {
                look.camera.name = filed.camera.name;
            }
        }
        look
    };
    // Images that were added are seen from another folder, perhaps.
    let folder_of = |file: &Path| file.parent().unwrap_or(Path::new("")).to_owned();
    let here = document.file.as_deref().map(folder_of).unwrap_or_default();
    let (own, added) = image_names.split_at(document.own_images.min(image_names.len()));
    let added = added.iter().map(|name| named_from(&folder_of(to), &here.join(name)));
    let image_names: Vec<String> = own.iter().cloned().chain(added).collect();
    let image_names = &*image_names;
    let alone = |text: String| Converted { text, assets: Vec::new(), notes: Vec::new() };
    match (&document.text, &document.file) {
        (Some(text), _) => {
            // All that it names must be found from where it will stand.
            let before = parse_native(text, to, &options).map_err(error)?;
            let look = look(&before);
            rutilant_formats::rewrite(text, to, &options, &before, &look, image_names)
                .map(alone)
                .map_err(error)
        }
        (None, Some(file)) if is_document(file) => {
            let before = read_scene(file, &options).map_err(error)?;
            let look = look(&before);
            let images = image_names.iter().map(|name| folder_of(to).join(name));
            let edited = edited(before, look, images, &options.limits)?;
            let how = ConvertOptions { copy: false, limits: options.limits };
            rutilant_formats::convert(&edited, file, to, &how).map_err(error)
        }
        (None, Some(file)) => {
            let before = read_scene(file, &options).map_err(error)?;
            let look = look(&before);
            let name = named_from(&folder_of(to), file);
            rutilant_formats::native_for_mesh(&name, to, &options, &before, &look, image_names)
                .map(alone)
                .map_err(error)
        }
        (None, None) => Err("there is nothing to save".to_owned()),
    }
}

/// A scene with another look; `images` are the files of images that have been added since it was read.
fn edited(
    before: LoadedScene,
    look: Look,
    images: impl Iterator<Item = PathBuf>,
    limits: &Limits,
) -> Result<LoadedScene, String> {
    let mut edited = before;
    for file in images.skip(edited.scene.images.len()) {
        let image = rutilant_formats::image::read(&file, limits).map_err(|e| e.to_string())?;
        edited.scene.add_image(image);
        let file = file.canonicalize().map_err(|e| format!("{}: {e}", file.display()))?;
        edited.origins.images.push(PictureOrigin::File(file));
    }
    let Look { camera, environment, materials, lights, settings, display } = look;
    edited.scene.camera = camera.camera(settings.size).map_err(|problem| problem.to_string())?;
    if let Some(own) = edited.cameras.get_mut(edited.camera) {
        *own = camera;
    }
    (edited.scene.environment, edited.scene.materials) = (environment, materials);
    edited.scene.lights = lights;
    (edited.settings, edited.display) = (settings, display);
    edited.scene.validate().map_err(|problem| problem.to_string())?;
    Ok(edited)
}
