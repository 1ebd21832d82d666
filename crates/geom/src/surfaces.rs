//! All surfaces of one space under one tree: triangles, spheres, disks and custom shapes.

use crate::bvh::{Inside, Met, Order, PACK, WideNode, report, traverse, widened};
use crate::custom::{Custom, CustomHit};
use crate::disk::Disk;
use crate::packs::{Pack, PackRay, fits};
use crate::simd::Simd;
use crate::sphere::Sphere;
use crate::triangle::TriangleRay;
use crate::{Aabb, BuildOptions, BuildReport, Bvh, Ray, Vec3, real};
use fearless_simd::{Level, dispatch};
use glam::DVec3;
use rayon::prelude::*;
use std::f32::consts::{FRAC_1_PI, PI};
use std::ops::Range;

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
    nodes: Vec<WideNode>,
    packs: Vec<Pack>,
    /// The numbers of all primitives in the tree, leaf after leaf.
    order: Vec<u32>,
    /// Leaves whose primitives are met one by one, as places in the order.
    others: Vec<Range<usize>>,
    bounds: Aabb,
    report: BuildReport,
    /// The instructions that traversal uses.
    level: Level,
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
        // Triangles in packs where all of a leaf are, all else one by one.
        let (mut packs, mut others) = (Vec::new(), Vec::new());
        let corners = |i: &u32| {
            let indices = triangles.get(*i as usize)?;
            Some(indices.map(|vertex| positions[vertex as usize])).filter(|c| fits(*c))
        };
        let cost = |places: &Range<usize>| {
            let triangles =
                bvh.order()[places.clone()].iter().all(|i| (*i as usize) < triangles.len());
            let most = if triangles { MOST_IN_LEAF } else { 1 };
            (places.len() <= most).then(|| places.len().div_ceil(PACK) as f32)
        };
        let nodes = widened(&bvh, cost, |places, bounds| {
            let leaf: Option<Vec<_>> = bvh.order()[places.clone()].iter().map(corners).collect();
            match leaf {
                Some(leaf) if leaf.len() <= PACK * Inside::MOST_PACKS as usize => {
                    let before = packs.len() as u32;
                    let starts = places.step_by(PACK);
                    let packed = leaf.chunks(PACK).zip(starts);
                    packs.extend(
                        packed.map(|(triangles, first)| Pack::new(triangles, first, bounds)),
                    );
                    Inside::leaf(before, packs.len() as u32 - before)
                }
                _ => {
                    others.push(places);
                    Inside::leaf(others.len() as u32 - 1, 0)
                }
            }
        });
        let order = bvh.order().to_vec();

        let in_leaf = |inside: Inside| match inside.as_leaf() {
            (other, 0) => others[other].len(),
            (first, count) => packs[first..first + count].iter().map(Pack::len).sum(),
        };
        let bytes = size_of_val(&*nodes)
            + size_of_val(&*packs)
            + size_of_val(&*order)
            + size_of_val(&*others)
            + size_of_val(&*positions)
            + size_of_val(&*triangles)
            + size_of_val(&*spheres)
            + size_of_val(&*disks)
            + size_of_val(&*customs);
        let report = BuildReport { bytes, ..report(&bvh, &nodes, in_leaf) };
        let bounds = bvh.bounds();
        let level = Simd::Auto.level().unwrap_or_else(Level::new);
        Self {
            positions,
            triangles,
            spheres,
            disks,
            customs,
            nodes,
            packs,
            order,
            others,
            bounds,
            report,
            level,
        }
    }

    /// The same, met with other instructions of the processor; what rays find has the same bits.
    /// `None` where the processor has none of these.
    pub fn with_simd(self, simd: Simd) -> Option<Self> {
        simd.level().map(|level| Self { level, ..self })
    }

    /// What was built and what was left out. `bytes` counts the surfaces as well as the tree.
    pub fn report(&self) -> &BuildReport {
        &self.report
    }

    /// The box around everything; [`Aabb::EMPTY`] if there is nothing.
    pub fn bounds(&self) -> Aabb {
        self.bounds
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

    /// The primitive number `i`.
    #[inline]
    fn primitive(&self, i: u32) -> Primitive<'_> {
        let triangles = self.triangles.len();
        if (i as usize) < triangles {
            return Primitive::Triangle(self.triangle(i));
        }
        let i = i as usize - triangles;
        if let Some(sphere) = self.spheres.get(i) {
            return Primitive::Sphere(sphere);
        }
        let i = i - self.spheres.len();
        match self.disks.get(i) {
            Some(disk) => Primitive::Disk(disk),
            None => Primitive::Custom(&self.customs[i - self.disks.len()]),
        }
    }

    /// The first surface that the ray meets, from either side: the hit with the
    /// least `t` in double precision, of equal ones that with the smallest number.
    ///
    /// A ray with a NaN, an infinite origin or direction, or none, meets nothing.
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        let mut custom = None;
        let nearest = dispatch!(self.level, simd => self.nearest(simd, ray, &mut custom))?;

        // Where exactly, in double precision; rounded once at the end.
        let Nearest { t, primitive, uv: [u, v] } = nearest;
        let (position, normal, [u, v]) = match self.primitive(primitive) {
            Primitive::Triangle(corners) => {
                let [a, b, c] = corners.map(Vec3::as_dvec3);
                let position = a + (b - a) * u + (c - a) * v;
                (position, unit(triangle_normal(corners)), [u as f32, v as f32])
            }
            Primitive::Sphere(sphere) => {
                let (position, normal) = sphere.surface_at(ray, t);
                (position, normal, longitude_latitude(normal.as_vec3()))
            }
            Primitive::Disk(disk) => (disk.point(u, v), unit(disk.normal()), [u as f32, v as f32]),
            Primitive::Custom(_) => {
                let hit = custom?;
                (hit.position, hit.normal, [u as f32, v as f32])
            }
        };
        let (position, normal) = (position.as_vec3(), normal.as_vec3());
        Some(Hit { primitive, t: t as f32, u, v, position, normal })
    }

    /// Whether the ray meets anything at all; the same as `closest(ray).is_some()`, but sooner.
    pub fn occluded(&self, ray: &Ray) -> bool {
        dispatch!(self.level, simd => self.blocked(simd, ray))
    }

    #[inline(always)]
    fn nearest<S: fearless_simd::Simd>(
        &self,
        simd: S,
        ray: &Ray,
        custom: &mut Option<CustomHit>,
    ) -> Option<Nearest> {
        let pack_ray = PackRay::new(simd, ray);
        let mut exact_ray = None;
        let mut nearest: Option<Nearest> = None;
        traverse(
            simd,
            &self.nodes,
            ray,
            Order::Nearest,
            #[inline(always)]
            |leaf| {
                self.each_pack(&pack_ray, leaf, |pack, lane| {
                    let [a, b, c] = pack.triangle(lane);
                    let ray = exact_ray.get_or_insert_with(|| TriangleRay::new(ray));
                    if let Some(hit) = ray.intersect(a, b, c) {
                        let primitive = self.order[pack.place(lane)];
                        Nearest { t: hit.t, primitive, uv: [hit.u, hit.v] }.keep(&mut nearest);
                    }
                    false
                });
                for number in self.singles_of(leaf) {
                    self.meet_single(ray, *number, &mut nearest, custom);
                }
                Some(nearest.map_or(f64::from(ray.t_max), |n| n.t))
            },
        );
        nearest
    }

    #[inline(always)]
    fn blocked<S: fearless_simd::Simd>(&self, simd: S, ray: &Ray) -> bool {
        let pack_ray = PackRay::new(simd, ray);
        let mut exact_ray = None;
        let mut blocked = false;
        traverse(
            simd,
            &self.nodes,
            ray,
            Order::Any,
            #[inline(always)]
            |leaf| {
                blocked = self.each_pack(&pack_ray, leaf, |pack, lane| {
                    let [a, b, c] = pack.triangle(lane);
                    let ray = exact_ray.get_or_insert_with(|| TriangleRay::new(ray));
                    ray.intersect(a, b, c).is_some()
                });
                blocked = blocked
                    || self.singles_of(leaf).iter().any(|number| {
                        let mut nearest = None;
                        self.meet_single(ray, *number, &mut nearest, &mut None);
                        nearest.is_some()
                    });
                (!blocked).then_some(f64::from(ray.t_max))
            },
        );
        blocked
    }

    /// Calls `met` for each triangle of a leaf's packs that the ray may meet, until it says that it
    /// is enough; tells whether it did.
    #[inline(always)]
    fn each_pack<S: fearless_simd::Simd>(
        &self,
        ray: &PackRay<S>,
        leaf: Met,
        mut met: impl FnMut(&Pack, usize) -> bool,
    ) -> bool {
        let (first, count) = leaf.inside.as_leaf();
        let Some(packs) = self.packs.get(first..first + count) else { return false };
        for pack in packs {
            let mut lanes = ray.meet(pack, leaf.way);
            while lanes != 0 {
                let lane = lanes.trailing_zeros() as usize % PACK;
                if met(pack, lane) {
                    return true;
                }
                lanes &= lanes - 1;
            }
        }
        false
    }

    /// The primitives of a leaf that are met one by one.
    #[inline(always)]
    fn singles_of(&self, leaf: Met) -> &[u32] {
        match leaf.inside.as_leaf() {
            (number, 0) => &self.order[self.others[number].clone()],
            _ => &[],
        }
    }

    /// Meets one primitive of any kind, and keeps the hit if it is the nearest, with what a custom
    /// shape `said`.
    #[inline(never)]
    fn meet_single(
        &self,
        ray: &Ray,
        primitive: u32,
        nearest: &mut Option<Nearest>,
        said: &mut Option<CustomHit>,
    ) {
        let (t, uv) = match self.primitive(primitive) {
            Primitive::Triangle([a, b, c]) => {
                let Some(hit) = TriangleRay::new(ray).intersect(a, b, c) else { return };
                (hit.t, [hit.u, hit.v])
            }
            Primitive::Sphere(sphere) => {
                let Some(t) = sphere.intersect(ray) else { return };
                (t, [0.0, 0.0])
            }
            Primitive::Disk(disk) => {
                let Some(hit) = disk.intersect(ray) else { return };
                (hit.t, [hit.a, hit.b])
            }
            Primitive::Custom(custom) => {
                let Some(hit) = custom.intersect(ray) else { return };
                if (Nearest { t: hit.t, primitive, uv: hit.uv }).keep(nearest) {
                    *said = Some(hit);
                }
                return;
            }
        };
        Nearest { t, primitive, uv }.keep(nearest);
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
        let mut look_at = |primitive: u32| {
            let surface = match self.primitive(primitive) {
                Primitive::Triangle(corners) => {
                    let [a, b, c] = corners;
                    let met = triangle_ray.intersect(a, b, c);
                    met.map(|_| plane(a.as_dvec3(), triangle_normal(corners)))
                }
                Primitive::Sphere(sphere) => sphere.intersect(&near).map(|t| {
                    let Sphere { center, radius } = *sphere;
                    let height = |e: DVec3| e.distance(center.as_dvec3()) - f64::from(radius);
                    (ends.map(height), sphere.surface_at(&near, t).1)
                }),
                Primitive::Disk(disk) => {
                    let met = disk.intersect(&near);
                    met.map(|_| plane(disk.center.as_dvec3(), disk.normal()))
                }
                Primitive::Custom(custom) => {
                    custom.intersect(&near).map(|hit| plane(hit.position, hit.normal))
                }
            };
            // Both ends stand on it where it runs through the scene's origin, and no offset moves.
            if let Some(([start, end], normal)) = surface
                && start * end <= 0.0
            {
                met(primitive, normal.dot(direction) < 0.0);
            }
        };
        dispatch!(self.level, simd => {
            let pack_ray = PackRay::new(simd, &near);
            traverse(simd, &self.nodes, &near, Order::Any, |leaf| {
                self.each_pack(&pack_ray, leaf, |pack, lane| {
                    look_at(self.order[pack.place(lane)]);
                    false
                });
                self.singles_of(leaf).iter().for_each(|number| look_at(*number));
                Some(f64::from(near.t_max))
            });
        });
    }
}

/// What one number stands for.
enum Primitive<'a> {
    Triangle([Vec3; 3]),
    Sphere(&'a Sphere),
    Disk(&'a Disk),
    Custom(&'a Custom),
}

/// The most triangles in a leaf.
const MOST_IN_LEAF: usize = 16;

/// The nearest hit so far.
#[derive(Clone, Copy)]
struct Nearest {
    t: f64,
    primitive: u32,
    uv: [f64; 2],
}

impl Nearest {
    /// Takes the place of what is farther, and tells whether it did; of equal ones the smallest
    /// number stays.
    fn keep(self, nearest: &mut Option<Self>) -> bool {
        let keep = nearest.is_none_or(|n| (self.t, self.primitive) < (n.t, n.primitive));
        if keep {
            *nearest = Some(self);
        }
        keep
    }
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
