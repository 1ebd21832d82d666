//! All of a scene that can be edited without moving a surface.

use crate::camera::AuthoredCamera;
use crate::scene::loaded::LoadedScene;
use rutilant::display::Display;
use rutilant::light::{Environment, Light};
use rutilant::material::Material;
use rutilant::settings::Settings;

/// How a scene looks: who sees it, in which light, of which materials it is, how it is rendered
/// and shown. What stands where is not part of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    /// The camera that sees the scene.
    pub camera: AuthoredCamera,
    /// The sky.
    pub environment: Option<Environment>,
    /// All materials, by [`MaterialId`](rutilant::scene::MaterialId).
    pub materials: Vec<Material>,
    /// Lights without a surface.
    pub lights: Vec<Light>,
    /// How it is rendered.
    pub settings: Settings,
    /// How the picture is shown.
    pub display: Display,
}

impl LoadedScene {
    /// How the scene looks by its file.
    pub fn look(&self) -> Look {
        // A reader gives at least one camera; somebody's own scene may have none.
        let camera = self.cameras.get(self.camera).or(self.cameras.first()).cloned();
        let Self { scene, settings, display, .. } = self;
        Look {
            camera: camera.unwrap_or_else(|| {
                let pose = scene.camera.world_from_camera();
                let ahead = pose.point(rutilant_geom::Vec3::NEG_Z);
                AuthoredCamera::perspective(pose.translation(), ahead, 45.0)
            }),
            environment: scene.environment,
            materials: scene.materials.clone(),
            lights: scene.lights.clone(),
            settings: settings.clone(),
            display: *display,
        }
    }
}
