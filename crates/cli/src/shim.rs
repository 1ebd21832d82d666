//! Stand-in for what is not merged yet.
#![allow(dead_code, unused_variables, missing_docs, unreachable_pub, clippy::all)]
use rutilant::display::Display;
use rutilant::{image::Image, scene::Scene, settings::Settings};
use rutilant_formats::{ImageError, Limits, SceneError};
use std::path::Path;

pub struct LoadedScene {
    pub scene: Scene,
    pub settings: Settings,
    pub display: Display,
    pub notes: Vec<String>,
}
#[derive(Default, Clone, Copy)]
pub struct ReadOptions<'a> {
    pub limits: Limits,
    pub allow_outside: bool,
    pub embedded: &'a [(&'a str, &'a [u8])],
}
pub fn read_scene(p: &Path, o: &ReadOptions<'_>) -> Result<LoadedScene, SceneError> {
    use rutilant::{
        camera::Perspective, color::Rgb, geom::Vec3, light::Environment, material::Matte, shape::*,
    };
    let eye = Vec3::new(0.0, 0.0, 3.0);
    let mut scene = Scene::new(Perspective::look_at(eye, Vec3::ZERO, 0.5).unwrap());
    scene.environment = Some(Environment::constant(Rgb::WHITE));
    let grey = scene.add_material(Matte { albedo: Rgb::grey(0.5) });
    scene.objects.push(Object::new(Shape::Sphere { radius: 1.0 }, grey));
    Ok(LoadedScene {
        scene,
        settings: Settings::default(),
        display: Display::default(),
        notes: vec![],
    })
}
pub fn parse_native(t: &str, p: &Path, o: &ReadOptions<'_>) -> Result<LoadedScene, SceneError> {
    read_scene(p, o)
}
pub mod image_files {
    use super::*;
    pub fn read(p: &Path, l: &Limits) -> Result<Image, ImageError> {
        Err(ImageError { file: p.into(), what: "images are not read yet".into() })
    }
    pub fn write(p: &Path, i: &Image, d: &Display) -> Result<(), ImageError> {
        Ok(())
    }
    pub fn check_writable(p: &Path) -> Result<(), ImageError> {
        Ok(())
    }
}
