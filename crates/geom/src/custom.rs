//! Surfaces of others' making: the stranger's door into the tree.
//!
//! Whoever can say where a ray meets a shape, and within which box that must
//! be, writes two functions and has a primitive like the built-in ones. What
//! they answer is checked here: nonsense is no hit, and breaks nothing.
//!
//! Not for shapes that triangles, spheres or disks describe: those are faster.
//!
//! ```
//! use rutilant_geom::{Aabb, CustomHit, CustomRay, CustomShape, DVec3, Vec3};
//!
//! /// A torus around the z axis, by its signed distance: how far a point is from the surface,
//! /// less than zero inside. No point is nearer than that, so a ray may step as far at once.
//! #[derive(Debug)]
//! struct Torus {
//!     ring: f64,
//!     tube: f64,
//! }
//!
//! impl Torus {
//!     fn distance(&self, p: DVec3) -> f64 {
//!         let off_ring = (p.x * p.x + p.y * p.y).sqrt() - self.ring;
//!         (off_ring * off_ring + p.z * p.z).sqrt() - self.tube
//!     }
//! }
//!
//! impl CustomShape for Torus {
//!     fn bounds(&self) -> Aabb {
//!         let (r, h) = ((self.ring + self.tube) as f32, self.tube as f32);
//!         Aabb { min: Vec3::new(-r, -r, -h), max: Vec3::new(r, r, h) }
//!     }
//!
//!     fn intersect(&self, ray: &CustomRay) -> Option<CustomHit> {
//!         // Near enough to count as on the surface: far less than single precision tells apart.
//!         let on = 1e-12 * (self.ring + self.tube);
//!         let speed = ray.direction.length();
//!         let (start, end) = ray.within(&self.bounds())?;
//!         let mut t = start;
//!         // A ray that starts on the surface does not meet it there.
//!         let mut leaving = start == ray.t_min;
//!         for _ in 0..10_000 {
//!             let distance = self.distance(ray.at(t)).abs();
//!             leaving &= distance <= 4.0 * on;
//!             if distance <= on && !leaving {
//!                 let (x, y, z) = ray.at(t).into();
//!                 let on_ring = DVec3::new(x, y, 0.0).normalize() * self.ring;
//!                 let normal = (DVec3::new(x, y, z) - on_ring).normalize();
//!                 let position = on_ring + normal * self.tube;
//!                 return ray.holds(t).then(|| CustomHit { t, position, normal, uv: [0.0; 2] });
//!             }
//!             t += distance.max(on) / speed;
//!             if t > end {
//!                 return None;
//!             }
//!         }
//!         None
//!     }
//! }
//!
//! use rutilant_geom::{BuildOptions, Custom, Ray, Surfaces, Transform};
//! use std::sync::Arc;
//!
//! let torus = Arc::new(Torus { ring: 1.0, tube: 0.25 });
//! let lifted = Custom::new(torus, &Transform::translate(Vec3::new(0.0, 0.0, 5.0)));
//! let options = BuildOptions::default();
//! let scene = Surfaces::with_custom(vec![], vec![], vec![], vec![], vec![lifted], &options);
//! let down = |x| scene.closest(&Ray::new(Vec3::new(x, 0.0, 9.0), Vec3::NEG_Z));
//! assert!((down(1.0).unwrap().t - 3.75).abs() < 1e-6);
//! assert_eq!(down(0.5), None); // through the hole
//! ```

use crate::aabb::{rounded_down, rounded_up};
use crate::{Aabb, Ray, Transform, Vec3};
use glam::{DMat3, DVec3};
use std::fmt;
use std::sync::Arc;

/// A surface in a space of its own, which a [`Custom`] places in the world.
///
/// The same question must always get the same answer, on every machine: use
/// [`real`](crate::real) instead of the standard library's sine and its kin.
pub trait CustomShape: fmt::Debug + Send + Sync {
    /// A finite box around the whole surface. What lies outside of it is never met.
    fn bounds(&self) -> Aabb;

    /// The first point on the ray with `t_min < t < t_max`, from either side.
    ///
    /// A ray whose origin lies on the surface, but for the rounding of double precision, must not
    /// meet it there. It may well start very near: a few roundings of single precision off.
    fn intersect(&self, ray: &CustomRay) -> Option<CustomHit>;
}

/// The same if it is the very same shape.
impl PartialEq for dyn CustomShape {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::addr_eq(self, other)
    }
}

/// The points `origin + t * direction` with `t_min < t < t_max`, in the space of a custom shape.
///
/// `direction` has any length but zero; `t` counts in its lengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CustomRay {
    /// Where `t` is zero.
    pub origin: DVec3,
    /// Where the ray goes.
    pub direction: DVec3,
    /// Hits at `t_min` and before do not count. At least zero.
    pub t_min: f64,
    /// Hits at `t_max` and beyond do not count. May be infinite.
    pub t_max: f64,
}

impl CustomRay {
    /// The point at `t`.
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + self.direction * t
    }

    /// Whether `t` lies on the ray, its ends not included.
    pub fn holds(&self, t: f64) -> bool {
        t > self.t_min && t < self.t_max
    }

    /// From which `t` to which the ray runs within a box, if it does at all.
    pub fn within(&self, bounds: &Aabb) -> Option<(f64, f64)> {
        let (mut enter, mut exit) = (self.t_min, self.t_max);
        for axis in 0..3 {
            let to =
                |corner: Vec3| (f64::from(corner[axis]) - self.origin[axis]) / self.direction[axis];
            let (a, b) = (to(bounds.min), to(bounds.max));
            // 0 / 0, for a ray within a side of the box, is taken over by neither.
            enter = enter.max(a.min(b));
            exit = exit.min(a.max(b));
        }
        (enter <= exit).then_some((enter, exit))
    }
}

/// Where a ray met a custom shape, in that shape's space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CustomHit {
    /// Distance along the ray, in lengths of its direction.
    pub t: f64,
    /// The point. It must lie on the surface but for the rounding of double precision: the next
    /// ray starts there, moved off by no more than what single precision may have lost.
    pub position: DVec3,
    /// The normal of the surface there, of any length but zero, on its front (its outside).
    pub normal: DVec3,
    /// Texture coordinates; zeros if there are none.
    pub uv: [f64; 2],
}

/// A custom shape with its place in the world.
#[derive(Clone, Debug)]
pub struct Custom {
    shape: Arc<dyn CustomShape>,
    linear: DMat3,
    inverse: DMat3,
    translation: DVec3,
    bounds: Aabb,
}

impl Custom {
    /// Places a shape in the world, by any map but a flattening one. All is computed in double
    /// precision, so that the shape loses nothing by it; its outside stays outside.
    pub fn new(shape: Arc<dyn CustomShape>, world_from_shape: &Transform) -> Self {
        let linear = world_from_shape.linear().as_dmat3();
        let inverse = linear.inverse();
        let translation = world_from_shape.translation().as_dvec3();
        let own = shape.bounds();
        let usable = own.is_finite() && !own.is_empty() && inverse.is_finite();
        let bounds = if usable && translation.is_finite() {
            let corners = (0..8).map(|i| {
                let pick = |axis: usize| if i >> axis & 1 == 1 { own.max } else { own.min };
                let corner = Vec3::new(pick(0).x, pick(1).y, pick(2).z);
                linear * corner.as_dvec3() + translation
            });
            corners.fold(Aabb::EMPTY, |b, c| b.grown(rounded_down(c)).grown(rounded_up(c)))
        } else {
            Aabb::EMPTY
        };
        // What is too large for single precision is no box either.
        let bounds = if bounds.is_finite() { bounds } else { Aabb::EMPTY };
        Self { shape, linear, inverse, translation, bounds }
    }

    /// Whether this is the very same shape in the same place.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.shape, &other.shape)
            && (self.linear, self.translation) == (other.linear, other.translation)
    }

    /// The box around it in the world; empty if its own is empty or not finite.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Where the ray meets it, in the world, with a normal of unit length. An answer that is not
    /// finite, off the ray or outside the box is no hit.
    pub fn intersect(&self, ray: &Ray) -> Option<CustomHit> {
        let ray = CustomRay {
            origin: self.inverse * (ray.origin.as_dvec3() - self.translation),
            direction: self.inverse * ray.direction.as_dvec3(),
            t_min: f64::from(ray.t_min),
            t_max: f64::from(ray.t_max),
        };
        let CustomHit { t, position, normal, uv } = self.shape.intersect(&ray)?;
        let position = self.linear * position + self.translation;
        // Scaled first: squares of tiny or huge normals would vanish or overflow.
        let normal = normal / normal.abs().max_element();
        let normal = (self.inverse.transpose() * normal).normalize();
        let rounded = position.as_vec3();
        let inside = rounded.cmpge(self.bounds.min).all() && rounded.cmple(self.bounds.max).all();
        let sound = t.is_finite() && ray.holds(t) && normal.is_finite() && inside;
        (sound && uv.iter().all(|&c| (c as f32).is_finite())).then_some(CustomHit {
            t,
            position,
            normal,
            uv,
        })
    }
}
