//! All surfaces of one space under one tree: triangles, spheres, disks and custom shapes.

use crate::custom::{Custom, CustomHit};
use crate::disk::Disk;
use crate::sphere::Sphere;
use crate::triangle::TriangleRay;
use crate::{Aabb, BuildOptions, BuildReport, Bvh, Ray, Vec3, real};
use glam::DVec3;
use rayon::prelude::*;
use std::f32::consts::{FRAC_1_PI, PI};

/// Triangles, spheres, disks and custom shapes, ready to be met by rays.
///
/// Primitives are numbered: the triangles first, then the spheres, then the
/// disks, then the custom shapes, each in the order they were given.
#[derive(Clone, Debug)]
pub struct Surfaces {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    spheres: Vec<Sphere>,
    disks: Vec<Disk>,
    customs: Vec<Custom>,
    bvh: Bvh,
    /// The primitives in the order of the tree's leaves.
    leaves: Vec<Leaf>,
    report: BuildReport,
}

/// Where a ray met a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The number of the primitive.
    pub primitive: u32,
    /// Distance along the ray, in lengths of its direction, rounded once. The
    /// unrounded one lies strictly between the ray's `t_min` and `t_max`; this
    /// one may equal either.
    pub t: f32,
    /// On a triangle the barycentric weight of the second vertex, on a disk the
    /// coordinate along its `u`, both as they are. On a sphere the longitude as
    /// a part of the full turn: 0.5 at +z, growing towards +x, within [0, 1].
    /// On a custom shape the first texture coordinate.
    pub u: f32,
    /// On a triangle the barycentric weight of the third vertex, on a disk the
    /// coordinate along its `v`. On a sphere the latitude: 0 at -y, 1 at +y.
    /// On a custom shape the second texture coordinate.
    pub v: f32,
    /// The exact hit point but for double precision's rounding, each coordinate
    /// rounded once: what [`offset_origin`](crate::offset_origin) relies on.
    pub position: Vec3,
    /// The geometric normal, of unit length, each coordinate rounded once. On a
    /// triangle it points to where the vertices run counter-clockwise, on a
    /// sphere outwards, on a disk along `u × v`, on a custom shape as that says.
    pub normal: Vec3,
}

impl Surfaces {
    /// Builds the tree over all surfaces.
    ///
    /// Left out, and counted in the [`report`](Self::report), are triangles,
    /// spheres and disks without area or with a number that is NaN or infinite,
    /// and triangles with an index beyond `positions`.
    ///
    /// # Panics
    ///
    /// If there are 2³¹ primitives or more.
    pub fn new(
        positions: Vec<Vec3>,
        triangles: Vec<[u32; 3]>,
        spheres: Vec<Sphere>,
        disks: Vec<Disk>,
        options: &BuildOptions,
    ) -> Self {
        Self::with_custom(positions, triangles, spheres, disks, Vec::new(), options)
    }

    /// The same with custom shapes; those without a finite box are left out as well.
    ///
    /// # Panics
    ///
    /// As for [`new`](Self::new).
    pub fn with_custom(
        positions: Vec<Vec3>,
        triangles: Vec<[u32; 3]>,
        spheres: Vec<Sphere>,
        disks: Vec<Disk>,
        customs: Vec<Custom>,
        options: &BuildOptions,
    ) -> Self {
        // An empty box tells the builder to leave something out.
        let triangle_bounds = |indices: &[u32; 3]| {
            let corners = indices.map(|i| positions.get(i as usize).copied());
            let [Some(a), Some(b), Some(c)] = corners else { return Aabb::EMPTY };
            let finite = a.is_finite() && b.is_finite() && c.is_finite();
            if finite && triangle_normal([a, b, c]) != DVec3::ZERO {
                Aabb::around([a, b, c])
            } else {
                Aabb::EMPTY
            }
        };
        let mut bounds: Vec<Aabb> = triangles.par_iter().map(triangle_bounds).collect();
        let spheres_bounds =
            spheres.iter().map(|s| if s.is_proper() { s.bounds() } else { Aabb::EMPTY });
        let disks_bounds =
            disks.iter().map(|d| if d.is_proper() { d.bounds() } else { Aabb::EMPTY });
        bounds.extend(spheres_bounds.chain(disks_bounds).chain(customs.iter().map(Custom::bounds)));

        let bvh = Bvh::build(&bounds, options);
        let leaf = |&primitive: &u32| {
            let i = primitive as usize;
            let (first_sphere, first_disk) = (triangles.len(), triangles.len() + spheres.len());
            let first_custom = first_disk + disks.len();
            if i < first_sphere {
                Leaf::Triangle(triangles[i])
            } else if i < first_disk {
                Leaf::Sphere((i - first_sphere) as u32)
            } else if i < first_custom {
                Leaf::Disk((i - first_disk) as u32)
            } else {
                Leaf::Custom((i - first_custom) as u32)
            }
        };
        let leaves: Vec<Leaf> = bvh.order().par_iter().map(leaf).collect();

        let bytes = bvh.report().bytes
            + size_of_val(&*leaves)
            + size_of_val(&*positions)
            + size_of_val(&*triangles)
            + size_of_val(&*spheres)
            + size_of_val(&*disks)
            + size_of_val(&*customs);
        let report = BuildReport { bytes, ..*bvh.report() };
        Self { positions, triangles, spheres, disks, customs, bvh, leaves, report }
    }

    /// What was built and what was left out. `bytes` counts the surfaces as well as the tree.
    pub fn report(&self) -> &BuildReport {
        &self.report
    }

    /// The box around everything; [`Aabb::EMPTY`] if there is nothing.
    pub fn bounds(&self) -> Aabb {
        self.bvh.bounds()
    }

    /// The tree.
    pub fn bvh(&self) -> &Bvh {
        &self.bvh
    }

    /// All vertices.
    pub fn positions(&self) -> &[Vec3] {
        &self.positions
    }

    /// All triangles as three places in [`positions`](Self::positions), also those left out.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// All spheres, also those left out.
    pub fn spheres(&self) -> &[Sphere] {
        &self.spheres
    }

    /// All disks, also those left out.
    pub fn disks(&self) -> &[Disk] {
        &self.disks
    }

    /// All custom shapes, also those left out.
    pub fn customs(&self) -> &[Custom] {
        &self.customs
    }

    /// The vertices of the triangle number `i`.
    ///
    /// # Panics
    ///
    /// If there is no such triangle, or it was left out for its indices.
    pub fn triangle(&self, i: u32) -> [Vec3; 3] {
        self.triangles[i as usize].map(|vertex| self.positions[vertex as usize])
    }

    /// The first surface that the ray meets, from either side: the hit with the
    /// least `t` in double precision, of equal ones that with the smallest number.
    ///
    /// A ray with a NaN, an infinite origin or direction, or none, meets nothing.
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        let triangle_ray = TriangleRay::new(ray);
        // What the nearest custom shape said. If that is the closest of all, it is needed again.
        let mut custom: Option<(u32, CustomHit)> = None;
        let closest = self.bvh.closest(ray, |place| {
            // Triangles first: most are.
            if let Leaf::Triangle(indices) = self.leaves[place] {
                let [a, b, c] = indices.map(|i| self.positions[i as usize]);
                return triangle_ray.intersect(a, b, c).map(|hit| (hit.t, [hit.u, hit.v]));
            }
            self.meet_other(place, ray, &mut custom)
        })?;

        // Where exactly, in double precision; rounded once at the end.
        let primitive = closest.primitive;
        let [u, v] = closest.what;
        let i = primitive as usize;
        let (position, normal, [u, v]) = if i < self.triangles.len() {
            let corners = self.triangle(primitive);
            let [a, b, c] = corners.map(Vec3::as_dvec3);
            let position = a + (b - a) * u + (c - a) * v;
            (position, unit(triangle_normal(corners)), [u as f32, v as f32])
        } else if let Some(sphere) = self.spheres.get(i - self.triangles.len()) {
            let (position, normal) = sphere.surface_at(ray, closest.t);
            (position, normal, longitude_latitude(normal.as_vec3()))
        } else if let Some(disk) = self.disks.get(i - self.triangles.len() - self.spheres.len()) {
            (disk.point(u, v), unit(disk.normal()), [u as f32, v as f32])
        } else {
            let (_, hit) = custom?;
            (hit.position, hit.normal, [u as f32, v as f32])
        };
        let (position, normal) = (position.as_vec3(), normal.as_vec3());
        Some(Hit { primitive, t: closest.t as f32, u, v, position, normal })
    }

    /// Whether the ray meets anything at all; the same as `closest(ray).is_some()`, but sooner.
    pub fn occluded(&self, ray: &Ray) -> bool {
        let triangle_ray = TriangleRay::new(ray);
        self.bvh.occluded(ray, |place| {
            if let Leaf::Triangle(indices) = self.leaves[place] {
                let [a, b, c] = indices.map(|i| self.positions[i as usize]);
                return triangle_ray.intersect(a, b, c).is_some();
            }
            self.meet_other(place, ray, &mut None).is_some()
        })
    }

    /// Every surface that the ray meets at the same place as `hit`, in no order to rely on: its
    /// number, and whether the ray comes from its front. The same place means: between `before`
    /// and `beyond`, points next to the hit on its two sides. `hit` itself is among them.
    ///
    /// Of surfaces that touch a ray meets just one, and the next ray starts beyond all of them:
    /// this tells of the others.
    pub fn at_the_same_place(
        &self,
        ray: &Ray,
        hit: &Hit,
        [before, beyond]: [Vec3; 2],
        mut met: impl FnMut(u32, bool),
    ) {
        // Where on the ray that is: generous, for the sides below decide. Of rays nearly in the
        // surface no more is looked at than of those at a thousandth to it.
        let speed = ray.direction.length();
        let cos = (hit.normal.dot(ray.direction) / speed).abs().max(1e-3);
        let reach = 2.0 * before.distance(beyond) / (cos * speed) + 4.0 * f32::EPSILON * hit.t;
        let near = Ray {
            t_min: (hit.t - reach).max(ray.t_min),
            t_max: (hit.t + reach).next_up().min(ray.t_max),
            ..*ray
        };
        let triangle_ray = TriangleRay::new(&near);
        let direction = ray.direction.as_dvec3();
        // How high the ends stand above the surface, and its normal.
        let ends = [before.as_dvec3(), beyond.as_dvec3()];
        let plane = |point: DVec3, normal: DVec3| (ends.map(|e| normal.dot(e - point)), normal);
        self.bvh.occluded(&near, |place| {
            let surface = match self.leaves[place] {
                Leaf::Triangle(indices) => {
                    let corners = indices.map(|i| self.positions[i as usize]);
                    let [a, b, c] = corners;
                    let met = triangle_ray.intersect(a, b, c);
                    met.map(|_| plane(a.as_dvec3(), triangle_normal(corners)))
                }
                Leaf::Sphere(i) => self.spheres[i as usize].intersect(&near).map(|t| {
                    let Sphere { center, radius } = self.spheres[i as usize];
                    let height = |e: DVec3| e.distance(center.as_dvec3()) - f64::from(radius);
                    (ends.map(height), self.spheres[i as usize].surface_at(&near, t).1)
                }),
                Leaf::Disk(i) => {
                    let disk = &self.disks[i as usize];
                    let met = disk.intersect(&near);
                    met.map(|_| plane(disk.center.as_dvec3(), disk.normal()))
                }
                Leaf::Custom(i) => {
                    let met = self.customs[i as usize].intersect(&near);
                    met.map(|hit| plane(hit.position, hit.normal))
                }
            };
            // Both ends stand on it where it runs through the scene's origin, and no offset moves.
            if let Some(([start, end], normal)) = surface
                && start * end <= 0.0
            {
                met(self.bvh.order()[place], normal.dot(direction) < 0.0);
            }
            false
        });
    }

    /// Meets what is no triangle. Of custom shapes it keeps what they said, if that is nearer than
    /// `nearest`. Apart, so that the loop over triangles stays tight.
    #[inline(never)]
    fn meet_other(
        &self,
        place: usize,
        ray: &Ray,
        nearest: &mut Option<(u32, CustomHit)>,
    ) -> Option<(f64, [f64; 2])> {
        match self.leaves[place] {
            // Met by those who call this, with what they know of the ray.
            Leaf::Triangle(_) => None,
            Leaf::Sphere(i) => self.spheres[i as usize].intersect(ray).map(|t| (t, [0.0, 0.0])),
            Leaf::Disk(i) => {
                self.disks[i as usize].intersect(ray).map(|hit| (hit.t, [hit.a, hit.b]))
            }
            Leaf::Custom(i) => {
                let hit = self.customs[i as usize].intersect(ray)?;
                if nearest.is_none_or(|(j, nearest)| (hit.t, i) < (nearest.t, j)) {
                    *nearest = Some((i, hit));
                }
                Some((hit.t, hit.uv))
            }
        }
    }
}

/// One primitive in a leaf of the tree.
#[derive(Clone, Copy, Debug)]
enum Leaf {
    /// Places in the positions, copied here so that a leaf's triangles lie together.
    Triangle([u32; 3]),
    Sphere(u32),
    Disk(u32),
    Custom(u32),
}

/// Twice the area along the normal; zero exactly for a triangle without area.
fn triangle_normal(corners: [Vec3; 3]) -> DVec3 {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    (b - a).cross(c - a)
}

/// The same direction with length one. Scaled first: squares of tiny areas would vanish.
fn unit(n: DVec3) -> DVec3 {
    let n = n / n.abs().max_element();
    n / n.length()
}

/// The place of a sphere's normal on a map of the world, both 0 to 1.
fn longitude_latitude(n: Vec3) -> [f32; 2] {
    [0.5 + 0.5 * FRAC_1_PI * real::atan2(n.x, n.z), real::acos(-n.y.clamp(-1.0, 1.0)) / PI]
}
