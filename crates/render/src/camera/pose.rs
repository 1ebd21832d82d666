//! Where a camera stands: what can be wrong with it, and how the world is seen from there.

use crate::problem::{FINITE, Place, SceneProblem};
use rutilant_geom::{Transform, Vec2, Vec3};

/// A camera's transform must be finite and must not flatten space.
pub(super) fn validate(world_from_camera: &Transform) -> Result<(), SceneProblem> {
    let place = Place::Camera;
    let linear = world_from_camera.linear().to_cols_array();
    let numbers = linear.into_iter().chain(world_from_camera.translation().to_array());
    place.check("position", numbers, FINITE)?;
    if world_from_camera.inverse().is_none() {
        return Err(place.problem("position", "the camera's transform flattens space"));
    }
    Ok(())
}

/// The world in the camera's own space.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sight {
    camera_from_world: Transform,
    /// The volume of a cubic metre there.
    volume: f32,
}

impl Sight {
    pub(super) fn new(world_from_camera: &Transform) -> Self {
        let inverse = world_from_camera.inverse().unwrap_or(Transform::translate(Vec3::ZERO));
        Self { camera_from_world: inverse, volume: inverse.linear().determinant().abs() }
    }

    /// A point of the world.
    pub(super) fn point(&self, world: Vec3) -> Vec3 {
        self.camera_from_world.point(world)
    }

    /// A direction of the world.
    pub(super) fn vector(&self, world: Vec3) -> Vec3 {
        self.camera_from_world.vector(world)
    }

    /// The unit vector `direction` of the world, as long as it is when it comes to the plane at
    /// distance 1; infinite if it never does.
    pub(super) fn length_to_plane(&self, direction: Vec3) -> f32 {
        1.0 / (-self.vector(direction).z).max(0.0)
    }

    /// The volume, in the camera's own space, of a cubic metre of the world.
    pub(super) fn volume(&self) -> f32 {
        self.volume
    }
}

/// Where a point of the scene is seen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seen {
    /// The point of the film, in pixels from the upper left corner, inside the picture or not.
    pub(crate) film: Vec2,
    /// Where the ray that sees it starts.
    pub(crate) eye: Vec3,
}
