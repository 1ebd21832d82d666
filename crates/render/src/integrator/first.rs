//! What a camera ray meets first, for pictures of albedo, normals, places and ids.
//!
//! Integrators that trace such rays anyway tell of what they met; for all
//! others the ray is followed once more. Mirrors and glass are told as they
//! are, not what is seen in them: the "first hit" of denoisers. Glass is white
//! then, and a mirror its reflectance.
//!
//! Source: *Intel Open Image Denoise*, documentation of version 2, sections
//! "Albedo" and "Normal".

use crate::camera::Camera;
use crate::color::Spectrum;
use crate::film::{Layer, Layers};
use crate::follow::{Met, follow};
use crate::prepare::Prepared;
use rutilant_geom::{Hit, Ray, Vec2, Vec3};

/// What stands for an object where there is none.
pub(crate) const NOTHING: u32 = u32::MAX;

/// A surface that a camera ray met first. What is not asked for is zero.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct First {
    /// The part of white light that is sent back, 0 to 1.
    pub(crate) albedo: Spectrum,
    /// The shading normal in the world, on the camera's side.
    pub(crate) normal: Vec3,
    /// In the world, in metres.
    pub(crate) position: Vec3,
    /// Texture coordinates.
    pub(crate) uv: Vec2,
    /// In metres: see [`View`].
    pub(crate) depth: f32,
}

/// What is asked about each camera path beside its light, and from where it is seen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View {
    pub(crate) layers: Layers,
    /// How many groups of lights are told apart.
    pub(crate) groups: usize,
    eye: Vec3,
    /// Depth is measured along this unit vector, as compositors expect it; of a camera that sees
    /// all around it is the distance.
    forward: Option<Vec3>,
}

impl View {
    pub(crate) fn new(camera: &Camera, layers: Layers, groups: usize) -> Self {
        let axis = camera.axis();
        let forward = match camera {
            Camera::Perspective(_) | Camera::Orthographic(_) => Some(axis.direction),
            Camera::Equirectangular(_) => None,
        };
        Self { layers, groups, eye: axis.origin, forward }
    }

    /// Whether anything is asked that samples are to be looked at for.
    pub(super) fn looks(&self) -> bool {
        let asking = [Layer::Albedo, Layer::Normal, Layer::Depth, Layer::Position, Layer::Uv];
        asking.into_iter().any(|layer| self.layers.has(layer))
    }

    /// The surface at `hit`, with its shading `normal` on either side, seen from the unit vector
    /// `wo`.
    pub(super) fn first(
        &self,
        scene: &Prepared,
        hit: &Hit,
        normal: Vec3,
        wo: Vec3,
        albedo: impl FnOnce() -> Spectrum,
    ) -> First {
        let from_eye = hit.position - self.eye;
        First {
            albedo: if self.layers.has(Layer::Albedo) { albedo() } else { Spectrum::BLACK },
            normal: if normal.dot(wo) < 0.0 { -normal } else { normal },
            position: hit.position,
            uv: if self.layers.has(Layer::Uv) { scene.uv(hit) } else { Vec2::ZERO },
            depth: self.forward.map_or(from_eye.length(), |forward| forward.dot(from_eye)),
        }
    }

    /// The number of the object that `ray` meets first, and more of that if it is to be looked at.
    pub(super) fn along(
        &self,
        scene: &Prepared,
        mut ray: Ray,
        look: bool,
        rays: &mut u64,
    ) -> Option<(u32, Option<First>)> {
        if !self.layers.tell_firsts() {
            return None;
        }
        let (mut media, mut made) = (scene.camera_media(), None);
        let way = follow(scene, &mut ray, &mut media, &mut made, rays, &mut |_| ());
        Some(self.told(scene, &way.met?, look))
    }

    /// The number of the object that was met, and more of it if it is to be looked at.
    pub(super) fn told(&self, scene: &Prepared, met: &Met<'_>, look: bool) -> (u32, Option<First>) {
        let (hit, at) = (&met.hit, &met.at);
        let first = || self.first(scene, hit, at.shading.z, at.wo, || met.material.albedo());
        (scene.object_of(hit.instance, hit.primitive), (look && self.looks()).then(first))
    }
}
