//! A camera that sees in all directions at once: panoramas, sky maps, light probes.
//!
//! Its picture is the latitude-longitude map that an environment takes: rendered
//! from where it stands, the surroundings of a scene become the sky of another.
//!
//! Its eye is a point: a lens would need a direction.

use super::pose::{self, Seen, Sight};
use crate::math::lat_long;
use crate::problem::SceneProblem;
use rutilant_geom::{Ray, Transform, Vec2, Vec3};

/// A camera that sees the full sphere around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Equirectangular {
    /// Where it stands. Its −z is the middle of the picture, +y the upper edge.
    pub world_from_camera: Transform,
}

impl Equirectangular {
    /// A camera at `position` whose picture has `target` in the middle, upright. `None` when the
    /// two points are the same or not finite.
    pub fn look_at(position: Vec3, target: Vec3) -> Option<Self> {
        Some(Self { world_from_camera: Transform::look_at(position, target, Vec3::Y)? })
    }

    pub(super) fn validate(&self) -> Result<(), SceneProblem> {
        pose::validate(&self.world_from_camera)
    }

    pub(super) fn prepare(&self, size: [u32; 2]) -> PreparedEquirectangular {
        let uv_per_pixel = size.map(|side| 1.0 / side as f32).into();
        PreparedEquirectangular {
            world_from_camera: self.world_from_camera,
            uv_per_pixel,
            sight: Sight::new(&self.world_from_camera),
        }
    }
}

/// An [`Equirectangular`] camera with its film.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PreparedEquirectangular {
    world_from_camera: Transform,
    uv_per_pixel: Vec2,
    sight: Sight,
}

impl PreparedEquirectangular {
    pub(super) fn ray(&self, film: Vec2) -> Ray {
        let pose = &self.world_from_camera;
        let direction = lat_long::direction_from_uv(film * self.uv_per_pixel);
        Ray::new(pose.translation(), pose.vector(direction).normalize())
    }

    /// Where `point` is seen.
    pub(super) fn seen(&self, point: Vec3) -> Option<Seen> {
        let way = self.sight.point(point).try_normalize()?;
        let film = lat_long::uv_from_direction(way) / self.uv_per_pixel;
        Some(Seen { film, eye: self.world_from_camera.translation() })
    }

    /// How many pixels a m² fills, of a surface that faces the ray of direction `direction` which
    /// sees it at `distance`.
    pub(super) fn pixels_per_area(&self, direction: Vec3, distance: f32) -> f32 {
        let way = self.sight.vector(direction);
        let length = way.length();
        let per_solid_angle = lat_long::uv_per_solid_angle(way / length)
            / (self.uv_per_pixel.x * self.uv_per_pixel.y);
        per_solid_angle * self.sight.volume() / (length * length * length * distance * distance)
    }
}
