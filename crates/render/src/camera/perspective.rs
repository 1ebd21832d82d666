//! A pinhole camera, or one with a thin lens.
//!
//! The film stands upright in front of the eye; with a lens, everything on the
//! plane at the focus distance is sharp and a point off it becomes a disk.
//!
//! Source: Pharr, Jakob, Humphreys, *Physically Based Rendering*, 4th ed.,
//! section 5.2.3; Shirley and Chiu, "A Low Distortion Map Between Disk and
//! Square", JGT 2(3), 1997.

use crate::math::warp;
use crate::problem::{FINITE, NOT_NEGATIVE, POSITIVE, Place, SceneProblem};
use rutilant_geom::{Ray, Transform, Vec2, Vec3, real};

/// The widest lens, in focus distances.
const MAX_APERTURE: f32 = 1e6;

/// A camera that sees a pyramid in front of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Perspective {
    /// Where it stands; it looks along −z, with +y up. Made by [`Transform::look_at`].
    pub world_from_camera: Transform,
    /// The angle between the top and the bottom of the picture, in radians, above 0 and below π.
    pub fov_y: f32,
    /// Radius of the lens in metres; 0 is a pinhole, which sees everything sharp.
    pub aperture_radius: f32,
    /// Distance from the eye to the plane that is sharp, in metres along the view direction.
    pub focus_distance: f32,
}

impl Perspective {
    /// A pinhole at `position` that looks at `target`, upright, with `fov_y` radians from top to
    /// bottom. `None` when the two points are the same or not finite.
    pub fn look_at(position: Vec3, target: Vec3, fov_y: f32) -> Option<Self> {
        Some(Self {
            world_from_camera: Transform::look_at(position, target, Vec3::Y)?,
            fov_y,
            aperture_radius: 0.0,
            focus_distance: position.distance(target),
        })
    }

    pub(super) fn validate(&self) -> Result<(), SceneProblem> {
        let place = Place::Camera;
        let pose = self.world_from_camera;
        let numbers =
            pose.linear().to_cols_array().into_iter().chain(pose.translation().to_array());
        place.check("position", numbers, FINITE)?;
        if pose.inverse().is_none() {
            return Err(place.problem("position", "the camera's transform flattens space"));
        }
        if !(self.fov_y > 0.0 && self.fov_y < std::f32::consts::PI) {
            let degrees = self.fov_y.to_degrees();
            return Err(place.problem(
                "fov_degrees",
                format!("fov_degrees is {degrees}, but must be more than 0 and less than 180"),
            ));
        }
        place.check("aperture_radius", [self.aperture_radius], NOT_NEGATIVE)?;
        place.check("focus_distance", [self.focus_distance], POSITIVE)?;
        // Otherwise the lens would be infinitely far away in terms of the focus.
        if self.aperture_radius / self.focus_distance > MAX_APERTURE {
            return Err(place.problem(
                "aperture_radius",
                format!(
                    "aperture_radius is {}, but must be at most {MAX_APERTURE} times the focus distance of {}",
                    self.aperture_radius, self.focus_distance
                ),
            ));
        }
        Ok(())
    }

    pub(super) fn axis(&self) -> Ray {
        let pose = &self.world_from_camera;
        Ray::new(pose.translation(), pose.vector(Vec3::NEG_Z).normalize())
    }

    pub(super) fn prepare(&self, [width, height]: [u32; 2]) -> PreparedPerspective {
        let half_height = real::tan(0.5 * self.fov_y);
        let per_pixel = 2.0 * half_height / height as f32;
        PreparedPerspective {
            world_from_camera: self.world_from_camera,
            per_pixel,
            corner: Vec2::new(-0.5 * width as f32 * per_pixel, half_height),
            aperture_radius: self.aperture_radius,
            focus_distance: self.focus_distance,
        }
    }
}

/// A [`Perspective`] with its film at distance 1.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PreparedPerspective {
    world_from_camera: Transform,
    /// The side of a pixel on the film.
    per_pixel: f32,
    /// The upper left corner of the film.
    corner: Vec2,
    aperture_radius: f32,
    focus_distance: f32,
}

impl PreparedPerspective {
    pub(super) fn ray(&self, film: Vec2, u: Vec2) -> Ray {
        let through = Vec3::new(
            self.corner.x + film.x * self.per_pixel,
            self.corner.y - film.y * self.per_pixel,
            -1.0,
        );
        let (origin, direction) = if self.aperture_radius > 0.0 {
            let lens = warp::concentric_disk(u) * self.aperture_radius;
            let lens = Vec3::new(lens.x, lens.y, 0.0);
            (lens, through - lens / self.focus_distance)
        } else {
            (Vec3::ZERO, through)
        };
        let pose = &self.world_from_camera;
        Ray::new(pose.point(origin), pose.vector(direction).normalize())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points in front of the camera come back to their pixels at any pitch. The old
    /// program's field of view shrank with the cosine of the pitch.
    #[test]
    fn rays_point_where_the_projection_says() {
        for pitch_degrees in [-89.0_f32, -45.0, 0.0, 30.0, 89.0] {
            let (s, c) = real::sin_cos(pitch_degrees.to_radians());
            let camera = Perspective::look_at(Vec3::ZERO, Vec3::new(0.0, s, -c), 0.9).unwrap();
            let prepared = camera.prepare([800, 600]);
            let scale = 300.0 / real::tan(0.45);
            for film in [[0.0, 0.0], [400.0, 300.0], [800.0, 600.0], [123.4, 567.8]] {
                let film = Vec2::from(film);
                let ray = prepared.ray(film, Vec2::splat(0.5));
                let back = camera.world_from_camera.inverse().unwrap().vector(ray.direction);
                let projected =
                    Vec2::new(400.0 + scale * back.x / -back.z, 300.0 - scale * back.y / -back.z);
                assert!((projected - film).length() < 1e-3, "{pitch_degrees}: {film} {projected}");
            }
        }
    }

    /// A focus as good as infinitely far away, or as near, is a view like any other.
    #[test]
    fn any_focus_gives_unit_directions() {
        for (focus, aperture) in [(1e20, 0.1), (f32::MAX, 10.0), (1e-6, 1e-3), (1e-30, 1e-30)] {
            let mut camera = Perspective::look_at(Vec3::ZERO, Vec3::NEG_Z, 1.0).unwrap();
            (camera.aperture_radius, camera.focus_distance) = (aperture, focus);
            camera.validate().unwrap();
            for u in [[0.0, 0.3], [0.9, 0.1]] {
                let ray = camera.prepare([100, 100]).ray(Vec2::new(20.0, 70.0), u.into());
                assert!((ray.direction.length() - 1.0).abs() < 1e-5, "{focus}: {ray:?}");
            }
        }
    }

    /// Looking straight down is a view like any other.
    #[test]
    fn straight_down_is_finite() {
        let camera = Perspective::look_at(Vec3::Y, Vec3::ZERO, 1.0).unwrap();
        let ray = camera.prepare([10, 10]).ray(Vec2::splat(5.0), Vec2::splat(0.5));
        assert!((ray.direction - Vec3::NEG_Y).length() < 1e-6);
    }

    /// Rays through all of the lens meet in one point of the focal plane.
    #[test]
    fn the_focal_plane_is_sharp() {
        let mut camera = Perspective::look_at(Vec3::ZERO, Vec3::NEG_Z, 1.0).unwrap();
        (camera.aperture_radius, camera.focus_distance) = (0.3, 4.0);
        let prepared = camera.prepare([100, 100]);
        let meet = |u: Vec2| {
            let ray = prepared.ray(Vec2::new(20.0, 70.0), u);
            ray.at((-4.0 - ray.origin.z) / ray.direction.z)
        };
        let first = meet(Vec2::splat(0.5));
        for u in [[0.0, 0.0], [0.9, 0.1], [0.3, 0.99]] {
            assert!((meet(u.into()) - first).length() < 1e-5);
        }
    }
}
