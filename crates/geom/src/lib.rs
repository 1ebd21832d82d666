//! Where rays meet geometry.
//!
//! This is the lowest floor of Rutilant: it knows rays, boxes, triangles,
//! spheres, disks and the tree that finds the nearest of them. It knows no
//! scene, no colour and no light.
//!
//! Two promises hold for every function here. Results have the same bits on
//! every machine and for any number of threads ([`real`] replaces the standard
//! library's transcendental functions for that). And whether a ray meets a
//! surface is decided in double precision on the stored single-precision
//! numbers, so that closed meshes have no cracks and a ray that leaves a
//! surface by [`offset_origin`] never meets that surface again.

pub mod aabb;
pub mod bvh;
pub mod custom;
pub mod disk;
pub mod frame;
pub mod instance;
pub mod lanes;
mod meet;
pub mod packet;
mod packs;
pub mod ray;
pub mod real;
pub mod simd;
pub mod sphere;
pub mod surfaces;
pub mod transform;
pub mod triangle;

pub use aabb::Aabb;
pub use bvh::{BuildOptions, BuildReport, Bvh, Quality};
pub use custom::{Custom, CustomHit, CustomRay, CustomShape};
pub use disk::Disk;
pub use frame::{Frame, Frames};
pub use glam::{DVec3, Mat3, Vec2, Vec3};
pub use instance::{Instance, SharedMesh};
pub use packet::{HitPacket, RayPacket};
pub use ray::{Ray, offset_end, offset_ends, offset_origin, offset_origins};
pub use simd::Simd;
pub use sphere::Sphere;
pub use surfaces::{Contents, Hit, Surfaces};
pub use transform::Transform;
