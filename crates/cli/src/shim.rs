//! Stand-in for what is not merged yet.
#![allow(dead_code, unused_variables, missing_docs, clippy::all)]
use rutilant::{
    image::Image,
    scene::{Scene, SceneProblem},
    settings::Settings,
};
use rutilant_formats::{ImageError, Limits, SceneError};
use rutilant_geom::{Ray, Vec3};
use std::{path::Path, sync::Arc, time::Duration};

#[derive(Clone, Copy)]
pub enum Curve {
    Clip,
    Filmic,
}
#[derive(Clone, Copy)]
pub struct Display {
    pub exposure: f32,
    pub curve: Curve,
}
impl Display {
    pub fn encode(&self, rgb: [f32; 3]) -> [u8; 3] {
        [0; 3]
    }
}
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
    unreachable!()
}
pub fn parse_native(t: &str, p: &Path, o: &ReadOptions<'_>) -> Result<LoadedScene, SceneError> {
    unreachable!()
}
pub mod image_files {
    use super::*;
    pub fn read(p: &Path, l: &Limits) -> Result<Image, ImageError> {
        unreachable!()
    }
    pub fn write(p: &Path, i: &Image, d: &Display) -> Result<(), ImageError> {
        unreachable!()
    }
    pub fn check_writable(p: &Path) -> Result<(), ImageError> {
        unreachable!()
    }
}
pub struct BuildReport {
    pub nodes: usize,
    pub leaves: usize,
    pub depth: usize,
    pub sah_cost: f32,
    pub bytes: usize,
    pub left_out: usize,
}
pub struct Report {
    pub bvh: BuildReport,
    pub triangles: u64,
    pub lights: u64,
    pub notes: Vec<String>,
}
pub struct Prepared(Report);
impl Prepared {
    pub fn new(s: &Scene) -> Result<Self, SceneProblem> {
        unreachable!()
    }
    pub fn report(&self) -> &Report {
        &self.0
    }
}
pub struct At {
    pub x: u32,
    pub y: u32,
    pub sample: u64,
}
pub struct Dropped {
    pub count: u64,
    pub first: Option<At>,
}
pub struct Progress {
    pub samples: u64,
    pub target: u64,
    pub finished: bool,
    pub paths: u64,
    pub rays: u64,
    pub dropped: Dropped,
}
pub struct Session;
impl Session {
    pub fn start(p: Arc<Prepared>, s: Settings, threads: usize) -> Result<Self, SceneProblem> {
        unreachable!()
    }
    pub fn progress(&self) -> Progress {
        unreachable!()
    }
    pub fn snapshot(&self) -> Image {
        unreachable!()
    }
    pub fn finish_pass(&self) {}
    pub fn wait(&self, d: Duration) -> bool {
        true
    }
}
#[derive(Default)]
pub struct BuildOptions;
pub struct Hit {
    pub t: f32,
}
pub struct Surfaces(BuildReport);
impl Surfaces {
    pub fn new(p: Vec<Vec3>, t: Vec<[u32; 3]>, s: Vec<()>, d: Vec<()>, o: &BuildOptions) -> Self {
        unreachable!()
    }
    pub fn closest(&self, r: &Ray) -> Option<Hit> {
        None
    }
    pub fn occluded(&self, r: &Ray) -> bool {
        false
    }
    pub fn report(&self) -> &BuildReport {
        &self.0
    }
}
