//! A camera whose rays are parallel: plans, elevations, game sprites.
//!
//! The film stands in the scene, as large as what it sees. With a lens every
//! point of it sees a bundle of rays that meet on the focal plane; how large a
//! point is blurred then depends on its distance from there alone.
//!
//! What lies behind the camera's position is not seen: rays start there.
//!
//! Source: Pharr, Jakob, Humphreys, *Physically Based Rendering*, 4th ed.,
//! section 5.2.2.

use super::lens::{Chief, Lens, PreparedLens};
use super::pose::{self, Seen, Sight};
use crate::problem::{POSITIVE, Place, SceneProblem};
use rutilant_geom::{Ray, Transform, Vec2, Vec3};

/// A camera that sees a box in front of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orthographic {
    /// Where the middle of the film stands; it looks along −z, with +y up.
    pub world_from_camera: Transform,
    /// Metres from the bottom of the picture to its top.
    pub height: f32,
    /// The lens.
    pub lens: Lens,
}

impl Orthographic {
    /// A camera at `position` that looks towards `target`, upright, and sees `height` metres from
    /// top to bottom. `None` when the two points are the same or not finite.
    pub fn look_at(position: Vec3, target: Vec3, height: f32) -> Option<Self> {
        Some(Self {
            world_from_camera: Transform::look_at(position, target, Vec3::Y)?,
            height,
            lens: Lens::pinhole(position.distance(target)),
        })
    }

    pub(super) fn validate(&self) -> Result<(), SceneProblem> {
        pose::validate(&self.world_from_camera)?;
        Place::Camera.check("height", [self.height], POSITIVE)?;
        self.lens.validate()
    }

    pub(super) fn prepare(&self, [width, height]: [u32; 2]) -> PreparedOrthographic {
        let per_pixel = self.height / height as f32;
        PreparedOrthographic {
            world_from_camera: self.world_from_camera,
            per_pixel,
            corner: Vec2::new(-0.5 * width as f32 * per_pixel, 0.5 * self.height),
            lens: self.lens.prepare(),
            sight: Sight::new(&self.world_from_camera),
        }
    }
}

/// An [`Orthographic`] camera with its film.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PreparedOrthographic {
    world_from_camera: Transform,
    /// The side of a pixel in metres.
    per_pixel: f32,
    /// The upper left corner of the film.
    corner: Vec2,
    lens: PreparedLens,
    sight: Sight,
}

impl PreparedOrthographic {
    pub(super) fn chief(&self, film: Vec2) -> Chief {
        let origin = Vec3::new(
            self.corner.x + film.x * self.per_pixel,
            self.corner.y - film.y * self.per_pixel,
            0.0,
        );
        Chief { origin, direction: Vec3::NEG_Z }
    }

    pub(super) fn has_lens(&self) -> bool {
        self.lens.is_open()
    }

    pub(super) fn ray(&self, film: Vec2, u: Vec2) -> Ray {
        self.lens.ray(&self.chief(film), &self.world_from_camera, u)
    }

    /// Where `point` is seen through the point of the lens that `u` stands for.
    pub(super) fn seen(&self, point: Vec3, u: Vec2) -> Option<Seen> {
        let [lens, bend] = self.lens.bend(u);
        let point = self.sight.point(point);
        let ahead = (point.z < 0.0).then_some(-point.z)?;
        let origin = (point - ahead * (Vec3::NEG_Z + bend)).with_z(0.0);
        let chief = origin - lens;
        let film = Vec2::new(chief.x - self.corner.x, self.corner.y - chief.y) / self.per_pixel;
        Some(Seen { film, eye: self.world_from_camera.point(origin) })
    }

    /// How many pixels a m² fills, of a surface that faces the ray of direction `direction`.
    pub(super) fn pixels_per_area(&self, direction: Vec3) -> f32 {
        self.sight.volume() * self.sight.length_to_plane(direction)
            / (self.per_pixel * self.per_pixel)
    }
}
