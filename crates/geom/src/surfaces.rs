//! All surfaces of one space under one tree: triangles, spheres, disks and custom shapes.

use crate::bvh::{Inside, PACK, WideNode, report, widened};
use crate::custom::Custom;
use crate::disk::Disk;
use crate::packs::{Pack, fits};
use crate::simd::Simd;
use crate::sphere::Sphere;
use crate::{Aabb, BuildOptions, BuildReport, Bvh, Vec3};
use arrayvec::ArrayVec;
use fearless_simd::Level;
use glam::DVec3;
use rayon::prelude::*;
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
    pub(crate) nodes: Vec<WideNode>,
    pub(crate) packs: Vec<Pack>,
    /// The numbers of the primitives that are met one by one, leaf after leaf.
    pub(crate) singles: Vec<u32>,
    /// The leaves they are in, as places among them.
    pub(crate) others: Vec<Range<usize>>,
    bounds: Aabb,
    report: BuildReport,
    /// The instructions that traversal uses.
    pub(crate) level: Level,
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
        let sphere_bounds = |s: &Sphere| if s.is_proper() { s.bounds() } else { Aabb::EMPTY };
        let disk_bounds = |d: &Disk| if d.is_proper() { d.bounds() } else { Aabb::EMPTY };
        let others = spheres.iter().map(sphere_bounds).chain(disks.iter().map(disk_bounds));
        let others: Vec<Aabb> = others.chain(customs.iter().map(Custom::bounds)).collect();
        let bounds = |i: usize| match triangles.get(i) {
            Some(triangle) => triangle_bounds(triangle),
            None => others[i - triangles.len()],
        };
        let bvh = Bvh::over(triangles.len() + others.len(), bounds, options);
        // Triangles in packs where all of a leaf are, all else one by one.
        let corners = |i: &u32| {
            let indices = triangles.get(*i as usize)?;
            Some(indices.map(|vertex| positions[vertex as usize]))
        };
        let all_fit = fits([bvh.bounds().min, bvh.bounds().max, Vec3::ZERO]);
        let cost = |places: &Range<usize>| {
            let only =
                || bvh.order()[places.clone()].iter().all(|i| (*i as usize) < triangles.len());
            let most = if places.len() <= MOST_IN_LEAF && only() { MOST_IN_LEAF } else { 1 };
            (places.len() <= most).then(|| places.len().div_ceil(PACK) as f32)
        };
        let mut planned = Vec::<(Places, u8)>::new();
        let (mut singles, mut others) = (Vec::new(), Vec::new());
        let nodes = widened(&bvh, cost, |places| {
            let packs = places.len().div_ceil(PACK);
            let fits = |i: &u32| match all_fit {
                true => (*i as usize) < triangles.len(),
                false => corners(i).is_some_and(fits),
            };
            if packs <= Inside::MOST_PACKS as usize && bvh.order()[places.clone()].iter().all(fits)
            {
                let before = planned.len() as u32;
                let leaf = Places { first: places.start as u32, count: places.len() as u8 };
                planned.extend((0..packs as u8).map(|i| (leaf, i)));
                Inside::leaf(before, packs as u32)
            } else {
                let before = singles.len();
                singles.extend(&bvh.order()[places]);
                others.push(before..singles.len());
                Inside::leaf(others.len() as u32 - 1, 0)
            }
        });
        let report = report(&bvh, &nodes, |inside: Inside| match inside.as_leaf() {
            (other, 0) => others[other].len(),
            (first, _) => usize::from(planned[first].0.count),
        });
        let bounds = bvh.bounds();
        let order = bvh.into_order();
        let pack = |(leaf, i): &(Places, u8)| {
            let first = leaf.first as usize;
            let numbers = &order[first..first + usize::from(leaf.count)];
            let numbered = |number: &u32| Some((*number, corners(number)?));
            let all: ArrayVec<_, { PACK * Inside::MOST_PACKS as usize }> =
                numbers.iter().filter_map(numbered).collect();
            let bounds = Aabb::around(all.iter().flat_map(|(_, corners)| *corners));
            Pack::new(&all[usize::from(*i) * PACK..], &bounds)
        };
        let packs: Vec<Pack> = planned.par_iter().map(pack).collect();

        let bytes = size_of_val(&*nodes)
            + size_of_val(&*packs)
            + size_of_val(&*singles)
            + size_of_val(&*others)
            + size_of_val(&*positions)
            + size_of_val(&*triangles)
            + size_of_val(&*spheres)
            + size_of_val(&*disks)
            + size_of_val(&*customs);
        let report = BuildReport { bytes, ..report };
        let level = Simd::Auto.level().unwrap_or_else(Level::new);
        Self {
            positions,
            triangles,
            spheres,
            disks,
            customs,
            nodes,
            packs,
            singles,
            others,
            bounds,
            report,
            level,
        }
    }

    /// Whether these are the very surfaces that the tree was built over, bit by bit and in the same
    /// order, so that there is no need for another.
    pub fn are_of(
        &self,
        positions: &[Vec3],
        triangles: &[[u32; 3]],
        spheres: &[Sphere],
        disks: &[Disk],
        customs: &[Custom],
    ) -> bool {
        let bits = |v: &Vec3| v.to_array().map(f32::to_bits);
        let ball = |s: &Sphere| (bits(&s.center), s.radius.to_bits());
        let plate = |d: &Disk| [d.center, d.u, d.v].map(|v| bits(&v));
        let in_place = |(a, b): (&Custom, &Custom)| a.is_same(b);
        self.triangles == triangles
            && self.positions.iter().map(bits).eq(positions.iter().map(bits))
            && self.spheres.iter().map(ball).eq(spheres.iter().map(ball))
            && self.disks.iter().map(plate).eq(disks.iter().map(plate))
            && self.customs.len() == customs.len()
            && self.customs.iter().zip(customs).all(in_place)
    }

    /// The same, met with other instructions of the processor; what rays find has the same bits.
    /// `None` where the processor has none of these.
    pub fn with_simd(self, simd: Simd) -> Option<Self> {
        simd.level().map(|level| Self { level, ..self })
    }

    /// The same, met with the instructions that `other` surfaces are met with.
    #[must_use]
    pub fn at_level_of(self, other: &Self) -> Self {
        Self { level: other.level, ..self }
    }

    /// The instructions that rays are traced with.
    pub fn level(&self) -> Level {
        self.level
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
    pub(crate) fn primitive(&self, i: u32) -> Primitive<'_> {
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
}

/// What one number stands for.
pub(crate) enum Primitive<'a> {
    Triangle([Vec3; 3]),
    Sphere(&'a Sphere),
    Disk(&'a Disk),
    Custom(&'a Custom),
}

/// Places in the order of the tree.
#[derive(Clone, Copy)]
struct Places {
    first: u32,
    count: u8,
}

/// The most triangles in a leaf.
const MOST_IN_LEAF: usize = 16;

/// Twice the area along the normal; zero exactly for a triangle without area.
pub(crate) fn triangle_normal(corners: [Vec3; 3]) -> DVec3 {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    (b - a).cross(c - a)
}
