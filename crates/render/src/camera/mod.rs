//! The eye: which ray each point of the film sees along.

mod equirectangular;
mod lens;
mod orthographic;
mod perspective;
mod pose;

pub use equirectangular::Equirectangular;
pub use lens::Lens;
pub use orthographic::Orthographic;
pub use perspective::Perspective;

use crate::problem::SceneProblem;
use equirectangular::PreparedEquirectangular;
use fearless_simd::{Simd, f32x8};
use lens::Chief;
use orthographic::PreparedOrthographic;
use perspective::PreparedPerspective;
pub(crate) use pose::Seen;
use rutilant_geom::lanes::LANES;
use rutilant_geom::{Ray, RayPacket, Transform, Vec2, Vec3};

/// A camera as the author describes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Camera {
    /// What is far is small, as for the eye.
    Perspective(Perspective),
    /// What is far is as large as what is near, as on a plan.
    Orthographic(Orthographic),
    /// Everything around, as on a map.
    Equirectangular(Equirectangular),
}

impl From<Perspective> for Camera {
    fn from(camera: Perspective) -> Self {
        Self::Perspective(camera)
    }
}

impl From<Orthographic> for Camera {
    fn from(camera: Orthographic) -> Self {
        Self::Orthographic(camera)
    }
}

impl From<Equirectangular> for Camera {
    fn from(camera: Equirectangular) -> Self {
        Self::Equirectangular(camera)
    }
}

impl Camera {
    /// Where it stands; it looks along −z, with +y up.
    pub fn world_from_camera(&self) -> &Transform {
        match self {
            Self::Perspective(c) => &c.world_from_camera,
            Self::Orthographic(c) => &c.world_from_camera,
            Self::Equirectangular(c) => &c.world_from_camera,
        }
    }

    /// Its lens, where it can have one.
    pub fn lens(&self) -> Option<&Lens> {
        match self {
            Self::Perspective(c) => Some(&c.lens),
            Self::Orthographic(c) => Some(&c.lens),
            Self::Equirectangular(_) => None,
        }
    }

    /// Its lens, to be changed.
    pub fn lens_mut(&mut self) -> Option<&mut Lens> {
        match self {
            Self::Perspective(c) => Some(&mut c.lens),
            Self::Orthographic(c) => Some(&mut c.lens),
            Self::Equirectangular(_) => None,
        }
    }

    pub(crate) fn validate(&self) -> Result<(), SceneProblem> {
        match self {
            Self::Perspective(c) => c.validate(),
            Self::Orthographic(c) => c.validate(),
            Self::Equirectangular(c) => c.validate(),
        }
    }

    /// The ray from the middle of the lens through the middle of the picture.
    pub(crate) fn axis(&self) -> Ray {
        let pose = self.world_from_camera();
        Ray::new(pose.translation(), pose.vector(Vec3::NEG_Z).normalize())
    }

    /// The rays through all of the lens that see the point `film`, in pixels, of a film of `size`
    /// pixels; `None` without a lens.
    pub(crate) fn beam(&self, size: [u32; 2], film: Vec2) -> Option<Beam> {
        let chief = match self.prepare(size) {
            PreparedCamera::Perspective(c) => c.chief(film),
            PreparedCamera::Orthographic(c) => c.chief(film),
            PreparedCamera::Equirectangular(_) => return None,
        };
        let (Chief { origin, direction }, pose) = (chief, self.world_from_camera());
        Some(Beam {
            origin: pose.point(origin),
            direction: pose.vector(direction),
            lens_axes: [Vec3::X, Vec3::Y].map(|axis| pose.vector(axis)),
        })
    }

    /// This camera on a film of `size` pixels.
    pub(crate) fn prepare(&self, size: [u32; 2]) -> PreparedCamera {
        match self {
            Self::Perspective(c) => PreparedCamera::Perspective(c.prepare(size)),
            Self::Orthographic(c) => PreparedCamera::Orthographic(c.prepare(size)),
            Self::Equirectangular(c) => PreparedCamera::Equirectangular(c.prepare(size)),
        }
    }
}

/// All rays through a lens that meet in one point. That `offset` metres from the middle along a
/// lens axis starts at `origin + offset · axis` and runs along `direction − offset / focus · axis`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Beam {
    /// The middle of the lens.
    pub(crate) origin: Vec3,
    /// Along the middle ray, to the plane at distance 1.
    pub(crate) direction: Vec3,
    /// To the right and up.
    pub(crate) lens_axes: [Vec3; 2],
}

/// A camera that knows its film.
#[derive(Clone, Copy, Debug)]
pub(crate) enum PreparedCamera {
    Perspective(PreparedPerspective),
    Orthographic(PreparedOrthographic),
    Equirectangular(PreparedEquirectangular),
}

impl PreparedCamera {
    /// The ray seen at `film` (in pixels from the upper left corner), through the point of the
    /// lens that `u`, two numbers in [0, 1), stands for. Its direction has unit length.
    pub(crate) fn ray(&self, film: Vec2, u: Vec2) -> Ray {
        match self {
            Self::Perspective(c) => c.ray(film, u),
            Self::Orthographic(c) => c.ray(film, u),
            Self::Equirectangular(c) => c.ray(film),
        }
    }

    /// Whether it matters through which point of a lens a ray goes.
    pub(crate) fn has_lens(&self) -> bool {
        match self {
            Self::Perspective(c) => c.has_lens(),
            Self::Orthographic(c) => c.has_lens(),
            Self::Equirectangular(_) => false,
        }
    }

    /// Whether its picture is a map of all directions, whose edges join: left and right, and over
    /// the poles.
    pub(crate) fn sees_all_around(&self) -> bool {
        match self {
            Self::Perspective(_) | Self::Orthographic(_) => false,
            Self::Equirectangular(_) => true,
        }
    }

    /// Where `point` is seen, through the point of the lens that `u` stands for: there
    /// [`ray`](Self::ray) sees it. `None` behind the camera.
    pub(crate) fn seen(&self, point: Vec3, u: Vec2) -> Option<Seen> {
        match self {
            Self::Perspective(c) => c.seen(point, u),
            Self::Orthographic(c) => c.seen(point, u),
            Self::Equirectangular(c) => c.seen(point),
        }
    }

    /// How many pixels a m² fills, of a surface that faces the ray which sees it at `distance`
    /// metres along the unit vector `direction`.
    pub(crate) fn pixels_per_area(&self, direction: Vec3, distance: f32) -> f32 {
        match self {
            Self::Perspective(c) => c.pixels_per_area(direction, distance),
            Self::Orthographic(c) => c.pixels_per_area(direction),
            Self::Equirectangular(c) => c.pixels_per_area(direction, distance),
        }
    }

    /// [`ray`](Self::ray) for eight points of the film.
    #[inline(always)]
    pub(crate) fn rays<S: Simd>(&self, film: [f32x8<S>; 2], u: [f32x8<S>; 2]) -> RayPacket {
        match self {
            Self::Perspective(c) if !c.has_lens() => c.pinhole_rays(film),
            Self::Perspective(_) | Self::Orthographic(_) | Self::Equirectangular(_) => {
                let mut packet = RayPacket::NONE;
                for lane in 0..LANES {
                    let [film, u] = [film, u].map(|v| Vec2::new(v[0][lane], v[1][lane]));
                    packet.set(lane, &self.ray(film, u));
                }
                packet
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One of each kind, with and without a lens, upright, tilted and stretched.
    fn cameras() -> Vec<Camera> {
        let (eye, target) = (Vec3::new(0.3, 1.2, 2.0), Vec3::new(-0.2, 0.4, -1.0));
        let mut cameras = Vec::new();
        for stretch in [Vec3::ONE, Vec3::new(1.4, 0.7, 1.2), Vec3::new(-2.0, 3.0, 0.5)] {
            for aperture in [0.0, 0.2] {
                let mut perspective = Perspective::look_at(eye, target, 0.9).unwrap();
                let mut plan = Orthographic::look_at(eye, target, 3.0).unwrap();
                for lens in [&mut perspective.lens, &mut plan.lens] {
                    (lens.aperture_radius, lens.blades, lens.aperture_ratio) = (aperture, 5, 1.5);
                }
                cameras.extend([Camera::from(perspective), Camera::from(plan)]);
            }
            cameras.push(Equirectangular::look_at(eye, target).unwrap().into());
            for camera in cameras.iter_mut().rev().take(5) {
                let pose = match camera {
                    Camera::Perspective(c) => &mut c.world_from_camera,
                    Camera::Orthographic(c) => &mut c.world_from_camera,
                    Camera::Equirectangular(c) => &mut c.world_from_camera,
                };
                *pose = *pose * Transform::scale(stretch);
            }
        }
        cameras
    }

    /// A point on the ray of a place of the film is seen there, and a small piece of the film
    /// covers as much of a surface that faces it as the density says.
    #[test]
    fn points_are_seen_where_their_rays_come_from() {
        for camera in cameras() {
            let prepared = camera.prepare([200, 100]);
            for i in 0..40 {
                let part = |k: u32| (i * k % 41) as f32 / 41.0;
                let film = Vec2::new(15.0 + 170.0 * part(7), 10.0 + 80.0 * part(11));
                let (u, distance) = (Vec2::new(part(5), part(13)), 0.5 + 3.0 * part(17));
                let ray = prepared.ray(film, u);
                let point = ray.at(distance);
                let seen = prepared.seen(point, u).unwrap();
                assert!(seen.film.distance(film) < 2e-3, "{camera:?}: {film} {seen:?}");
                assert!(seen.eye.distance(ray.origin) < 1e-5, "{camera:?}: {seen:?}");

                // Where the rays of two neighbours meet the plane that faces this one.
                let meet = |step: Vec2| {
                    let ray = prepared.ray(film + step, u);
                    let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
                    let n = prepared.ray(film, u).direction.as_dvec3();
                    o + d * ((point.as_dvec3() - o).dot(n) / d.dot(n))
                };
                let across = |axis: Vec2| (meet(axis) - meet(-axis)) / 2.0;
                let area = across(Vec2::X * 0.5).cross(across(Vec2::Y * 0.5)).length() * 4.0;
                let density = prepared.pixels_per_area(ray.direction, distance);
                let covered = area * f64::from(density);
                assert!((covered - 1.0).abs() < 0.01, "{camera:?}: {film} covers {covered}");
            }
            let behind = camera.axis().at(-0.1);
            let all_around = matches!(camera, Camera::Equirectangular(_));
            assert_eq!(prepared.seen(behind, Vec2::splat(0.5)).is_some(), all_around);
        }
    }
}
