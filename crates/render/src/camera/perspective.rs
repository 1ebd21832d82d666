//! A camera that sees as an eye does: near things large, far things small.
//!
//! The film stands upright in front of the eye, which is a pinhole or a lens.
//!
//! Source: Pharr, Jakob, Humphreys, *Physically Based Rendering*, 4th ed.,
//! section 5.2.3.

use super::lens::{Chief, Lens, PreparedLens};
use super::pose::{self, Seen, Sight};
use crate::problem::{Place, SceneProblem};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8};
use rutilant_geom::lanes::{LANES, Xyz8};
use rutilant_geom::{Ray, RayPacket, Transform, Vec2, Vec3, real};

/// A camera that sees a pyramid in front of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Perspective {
    /// Where it stands; it looks along −z, with +y up. Made by [`Transform::look_at`].
    pub world_from_camera: Transform,
    /// The angle between the top and the bottom of the picture, in radians, above 0 and below π.
    pub fov_y: f32,
    /// The lens.
    pub lens: Lens,
}

impl Perspective {
    /// A pinhole at `position` that looks at `target`, upright, with `fov_y` radians from top to
    /// bottom. `None` when the two points are the same or not finite.
    pub fn look_at(position: Vec3, target: Vec3, fov_y: f32) -> Option<Self> {
        Some(Self {
            world_from_camera: Transform::look_at(position, target, Vec3::Y)?,
            fov_y,
            lens: Lens::pinhole(position.distance(target)),
        })
    }

    pub(super) fn validate(&self) -> Result<(), SceneProblem> {
        pose::validate(&self.world_from_camera)?;
        if !(self.fov_y > 0.0 && self.fov_y < std::f32::consts::PI) {
            let degrees = self.fov_y.to_degrees();
            return Err(Place::Camera.problem(
                "fov_degrees",
                format!("fov_degrees is {degrees}, but must be more than 0 and less than 180"),
            ));
        }
        self.lens.validate()
    }

    pub(super) fn prepare(&self, [width, height]: [u32; 2]) -> PreparedPerspective {
        let half_height = real::tan(0.5 * self.fov_y);
        let per_pixel = 2.0 * half_height / height as f32;
        PreparedPerspective {
            world_from_camera: self.world_from_camera,
            per_pixel,
            corner: Vec2::new(-0.5 * width as f32 * per_pixel, half_height),
            lens: self.lens.prepare(),
            sight: Sight::new(&self.world_from_camera),
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
    lens: PreparedLens,
    sight: Sight,
}

impl PreparedPerspective {
    pub(super) fn chief(&self, film: Vec2) -> Chief {
        let direction = Vec3::new(
            self.corner.x + film.x * self.per_pixel,
            self.corner.y - film.y * self.per_pixel,
            -1.0,
        );
        Chief { origin: Vec3::ZERO, direction }
    }

    pub(super) fn ray(&self, film: Vec2, u: Vec2) -> Ray {
        self.lens.ray(&self.chief(film), &self.world_from_camera, u)
    }

    pub(super) fn has_lens(&self) -> bool {
        self.lens.is_open()
    }

    /// Where `point` is seen through the point of the lens that `u` stands for.
    pub(super) fn seen(&self, point: Vec3, u: Vec2) -> Option<Seen> {
        let [lens, bend] = self.lens.bend(u);
        let way = self.sight.point(point) - lens;
        let ahead = (way.z < 0.0).then_some(-way.z)?;
        let chief = way / ahead - bend;
        let film = Vec2::new(chief.x - self.corner.x, self.corner.y - chief.y) / self.per_pixel;
        Some(Seen { film, eye: self.world_from_camera.point(lens) })
    }

    /// How many pixels a m² fills, of a surface that faces the ray of direction `direction` which
    /// sees it at `distance`.
    pub(super) fn pixels_per_area(&self, direction: Vec3, distance: f32) -> f32 {
        let length = self.sight.length_to_plane(direction);
        let larger = length / (distance * self.per_pixel);
        self.sight.volume() * length * larger * larger
    }

    /// The rays of a pinhole through eight points of the film.
    #[inline(always)]
    pub(super) fn pinhole_rays<S: Simd>(&self, [x, y]: [f32x8<S>; 2]) -> RayPacket {
        let simd = x.token();
        let right = x * self.per_pixel + self.corner.x;
        let up = f32x8::splat(simd, self.corner.y) - y * self.per_pixel;
        let back = f32x8::splat(simd, -1.0);
        let [a, b, c] = self.world_from_camera.linear().to_cols_array_2d();
        let direction = Xyz8::splat(simd, a).scaled(right)
            + Xyz8::splat(simd, b).scaled(up)
            + Xyz8::splat(simd, c).scaled(back);
        let eye = self.world_from_camera.point(Vec3::ZERO);
        RayPacket {
            origin: eye.to_array().map(|v| [v; LANES]),
            direction: direction.normalized().store(),
            t_min: [0.0; LANES],
            t_max: [f32::INFINITY; LANES],
            ..RayPacket::NONE
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Eight points of the room come out on the pixels that trigonometry in f64 says, within a
    /// thousandth of a pixel, at any pitch. The old program's field of view shrank with the cosine
    /// of the pitch.
    #[test]
    #[expect(clippy::disallowed_methods, reason = "expected values are computed in f64")]
    fn rays_point_where_the_projection_says() {
        let (fov, [width, height]) = (0.9_f64, [800_u32, 600]);
        let eye = [0.3_f64, -0.2, 0.5];
        for pitch_degrees in [-89.0_f64, -60.0, -45.0, -1.0, 0.0, 30.0, 75.0, 89.0] {
            for yaw in [0.0_f64, 2.0] {
                let (sp, cp) = pitch_degrees.to_radians().sin_cos();
                let (sy, cy) = yaw.sin_cos();
                // Right, up and forward of a head that is turned by the yaw, then lifted.
                let (right, up) = ([cy, 0.0, sy], [-sp * sy, cp, sp * cy]);
                let forward = [cp * sy, sp, -cp * cy];
                let at = |depth: f64, x: f64, y: f64| -> [f64; 3] {
                    std::array::from_fn(|i| {
                        eye[i] + depth * (forward[i] + x * right[i] + y * up[i])
                    })
                };
                let as_vec = |p: [f64; 3]| Vec3::from(p.map(|c| c as f32));
                let camera =
                    Perspective::look_at(as_vec(eye), as_vec(at(2.0, 0.0, 0.0)), fov as f32)
                        .unwrap();
                let prepared = camera.prepare([width, height]);
                let scale = 0.5 * f64::from(height) / (0.5 * fov).tan();
                for (k, depth) in
                    [1.0, 1.0, 1.0, 1.0, 30.0, 30.0, 30.0, 30.0].into_iter().enumerate()
                {
                    let (x, y) = ([0.55, -0.55][k % 2], [0.4, -0.33][k / 2 % 2]);
                    let film = Vec2::new((400.0 + scale * x) as f32, (300.0 - scale * y) as f32);
                    let ray = prepared.ray(film, Vec2::splat(0.5));
                    let seen = ray.direction.as_dvec3();
                    let part = |axis: [f64; 3]| seen.dot(axis.into());
                    let ahead = part(forward);
                    let error =
                        (scale * (part(right) / ahead - x)).hypot(scale * (part(up) / ahead - y));
                    assert!(error < 1e-3, "pitch {pitch_degrees}, point {k}: {error} pixels off");
                    let miss = (as_vec(at(depth, x, y)) - ray.origin).normalize() - ray.direction;
                    assert!(miss.length() < 1e-6, "pitch {pitch_degrees}, point {k}: {miss}");
                }
            }
        }
    }

    /// A focus as good as infinitely far away, or as near, is a view like any other.
    #[test]
    fn any_focus_gives_unit_directions() {
        for (focus, aperture) in [(1e20, 0.1), (f32::MAX, 10.0), (1e-6, 1e-3), (1e-30, 1e-30)] {
            let mut camera = Perspective::look_at(Vec3::ZERO, Vec3::NEG_Z, 1.0).unwrap();
            (camera.lens.aperture_radius, camera.lens.focus_distance) = (aperture, focus);
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
        (camera.lens.aperture_radius, camera.lens.focus_distance) = (0.3, 4.0);
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
