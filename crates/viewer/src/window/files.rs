//! What is read from files and written into them, beside the interface.

use super::state::{Dialog, Saved, Window, Work};
use crate::picture::samples_of;
use crate::source::{Document, text_of};
use eframe::egui;
use rutilant::display::Display;
use rutilant::image::Image;
use rutilant::light::{Environment, EnvironmentLight};
use rutilant::scene::ImageId;
use rutilant::settings::Settings;
use rutilant_formats::image::{Format, Pixels, WriteOptions};
use rutilant_formats::{Look, named_from, replace_file};
use std::path::{Path, PathBuf};
use std::sync::Arc;

impl Window {
    /// A scene or mesh is opened; any image becomes the sky.
    pub(super) fn dropped(&mut self, file: PathBuf) {
        if Format::from_path(&file).is_ok() {
            self.read_sky(file, self.new_sky());
        } else {
            self.open_if_saved(Some(file));
        }
    }

    /// A sky from an image, turned as the present one is.
    pub(super) fn new_sky(&self) -> Environment {
        let sky = self.history.as_ref().and_then(|history| history.present().environment);
        let rotation = sky.map_or(0.0, |sky| sky.rotation);
        Environment { rotation, ..Environment::image(ImageId(0)) }
    }

    /// Reads an image that is to be the sky as `like` says.
    pub(super) fn read_sky(&self, file: PathBuf, like: Environment) {
        let of = self.document.as_ref().and_then(|d| d.file.clone());
        self.read_image(file, move |file, image| Work::Sky { file, image, like, of });
    }

    /// The number of the sky among the images that were added, where it is one of those.
    pub(super) fn added_sky(&self) -> Option<u32> {
        added_sky(self.document.as_ref()?, self.history.as_ref()?.present())
    }

    pub(super) fn read_image(
        &self,
        file: PathBuf,
        then: impl FnOnce(PathBuf, Image) -> Work + Send + 'static,
    ) {
        let limits = self.reading.limits;
        self.beside_the_interface(move || match rutilant_formats::image::read(&file, &limits) {
            Ok(image) if image.rgb().is_some() => then(file, image),
            Ok(_) => Work::Failed(format!("{}: no channels R, G, B (or Y)", file.display())),
            Err(error) => Work::Failed(error.to_string()),
        });
    }

    /// Reads, without the interface waiting for it.
    fn beside_the_interface(&self, work: impl FnOnce() -> Work + Send + 'static) {
        self.spawn((), work);
    }

    /// Writes, without the interface waiting for it; but the window is not closed before.
    fn write_beside(&self, work: impl FnOnce() -> Work + Send + 'static) {
        self.spawn(Arc::clone(&self.writing), work);
    }

    /// Works on a thread of its own, which holds something until what came of it can be heard.
    fn spawn(&self, held: impl Send + 'static, work: impl FnOnce() -> Work + Send + 'static) {
        let (sender, wake) = (self.work.0.clone(), self.context.clone());
        std::thread::spawn(move || {
            // Nobody hears it any more once the window is closed.
            drop(sender.send(work()));
            drop(held);
            wake.request_repaint();
        });
    }

    pub(super) fn use_sky(&mut self, file: &Path, picture: Image, like: Environment) {
        let Some(document) = &self.document else {
            self.message = Some("a sky needs a scene below it: open one first".into());
            return;
        };
        let (id, picture) = (ImageId(self.image_names.len() as u32), Arc::new(picture));
        self.image_names.push(name_in(document, file));
        self.added_images.push((file.to_owned(), Arc::clone(&picture)));
        self.live.add_image(picture);
        self.edit(|look| {
            let light = match like.light {
                EnvironmentLight::Image { projection, .. } => {
                    EnvironmentLight::Image { image: id, projection }
                }
                EnvironmentLight::Constant(_) => like.light,
            };
            look.environment = Some(Environment { light, ..like });
        });
    }

    /// The folder that dialogs begin in.
    pub(super) fn folder(&self) -> String {
        let file = self.document.as_ref().and_then(|d| d.file.as_deref());
        let folder = file.and_then(Path::parent).filter(|f| !f.as_os_str().is_empty());
        folder.map(|f| format!("{}/", f.display())).unwrap_or_default()
    }

    pub(super) fn save(&mut self) {
        let Some(document) = &self.document else { return };
        match &document.file {
            Some(file) if document.text.is_some() => self.save_scene(file.clone()),
            _ => self.save_as(),
        }
    }

    pub(super) fn save_as(&mut self) {
        let Some(document) = &self.document else { return };
        let stem = Path::new(&document.name(&self.reading)).with_extension("toml");
        self.dialog = Some(Dialog::SaveScene(format!("{}{}", self.folder(), stem.display())));
    }

    pub(super) fn save_scene(&mut self, to: PathBuf) {
        let (Some(document), Some(history)) = (&self.document, &self.history) else { return };
        let (document, look) = (document.clone(), Arc::clone(history.present()));
        let (image_names, reading) = (self.image_names.clone(), self.reading.clone());
        self.write_beside(move || {
            let in_place = document.file.as_deref() == Some(&*to);
            if in_place
                && let Some(text) = &document.text
                && std::fs::read(&to).is_ok_and(|now| now != text.as_bytes())
            {
                return Work::Stale { file: to };
            }
            let written = text_of(&document, &look, &image_names, &to, &reading).and_then(|new| {
                if !new.assets.is_empty() {
                    // Whoever writes over a scene means the files that came with it as well.
                    new.write(&to, to.exists()).map_err(|error| error.to_string())?;
                    return Ok(new.text);
                }
                let text = new.text;
                // The built-in scene takes along the images that it uses.
                let images = if document.file.is_none() { reading.built_in.images } else { &[] };
                let used = |(name, _): &&(&str, _)| text.contains(&format!("{name:?}"));
                write_scene(&to, &text, images.iter().filter(used))?;
                Ok(text)
            });
            match written {
                Ok(text) => {
                    let saved = Some(Saved { of: document.file, look, text });
                    Work::Wrote { file: to, hash: None, saved }
                }
                Err(what) => Work::Failed(what),
            }
        });
    }

    /// Writes a picture that was rendered with these settings.
    pub(super) fn write_image(
        &self,
        image: Arc<Image>,
        settings: &Settings,
        display: Display,
        file: PathBuf,
        mattes: &[(String, String)],
    ) {
        let mut metadata = (self.describe)(settings, samples_of(&image));
        metadata.extend_from_slice(mattes);
        self.write_beside(move || {
            let hash = Some(format!("{:016x}", image.hash()));
            let (width, height) = (image.width(), image.height());
            let options = WriteOptions { metadata, ..WriteOptions::default() };
            let for_display = Format::from_path(&file).is_ok_and(Format::is_for_display);
            let written = if for_display {
                let light = image.rgb().unwrap_or_default();
                let rgb8: Vec<u8> = light.iter().flat_map(|rgb| display.encode(*rgb)).collect();
                let pixels = Pixels::Display { width, height, rgb8: &rgb8 };
                rutilant_formats::image::write(&file, pixels, &options)
            } else {
                rutilant_formats::image::write(&file, &*image, &options)
            };
            match written {
                Ok(()) => Work::Wrote { file, hash, saved: None },
                Err(error) => Work::Failed(error.to_string()),
            }
        });
    }

    pub(super) fn copy_image(&mut self) {
        if let Some(shown) = &self.shown {
            self.context.copy_image(egui::ColorImage::clone(&shown.picture.pixels));
            self.message = Some("the picture is in the clipboard".into());
        }
    }
}

/// Writes a scene, and those of its images that are not there yet, by their names.
fn write_scene<'i>(
    file: &Path,
    text: &str,
    images: impl Iterator<Item = &'i (&'i str, &'i [u8])>,
) -> Result<(), String> {
    let failed = |file: &Path, error: std::io::Error| format!("{}: {error}", file.display());
    replace_file(file, text.as_bytes()).map_err(|error| failed(file, error))?;
    for (name, bytes) in images {
        let image = file.with_file_name(name);
        if !image.exists() {
            let folder = image.parent().map_or(Ok(()), std::fs::create_dir_all);
            folder
                .and_then(|()| replace_file(&image, bytes))
                .map_err(|error| failed(&image, error))?;
        }
    }
    Ok(())
}

/// The number of the sky among the images that were added to a scene, where it is one of those.
pub(super) fn added_sky(document: &Document, look: &Look) -> Option<u32> {
    match look.environment?.light {
        EnvironmentLight::Image { image: ImageId(id), .. } => {
            id.checked_sub(document.image_names.len() as u32)
        }
        EnvironmentLight::Constant(_) => None,
    }
}

/// The name by which a scene knows an image.
pub(super) fn name_in(document: &Document, image: &Path) -> String {
    let folder = document.file.as_deref().and_then(Path::parent).unwrap_or(Path::new(""));
    named_from(folder, image)
}
