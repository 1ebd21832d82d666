//! All surfaces of one space under one tree: triangles, spheres, disks, custom shapes, and meshes
//! that stand in several places.

use crate::bvh::{Inside, PACK, WideNode, report, widened};
use crate::custom::Custom;
use crate::disk::Disk;
use crate::instance::{Instance, SharedMesh};
use crate::packs::{Pack, fits};
use crate::simd::Simd;
use crate::sphere::Sphere;
use crate::{Aabb, BuildOptions, BuildReport, Bvh, Vec3};
use arrayvec::ArrayVec;
use fearless_simd::Level;
use glam::DVec3;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

/// Triangles, spheres, disks, custom shapes and instances of meshes, ready to be met by rays.
///
/// Primitives are numbered: the triangles first, then the spheres, then the
/// disks, then the custom shapes, each in the order they were given. The
/// triangles of an instance have the numbers that they have in its mesh.
#[derive(Clone, Debug)]
pub struct Surfaces {
    contents: Contents,
    pub(crate) nodes: Vec<WideNode>,
    pub(crate) packs: Vec<Pack>,
    /// The numbers of the primitives that are met one by one, leaf after leaf; those of instances
    /// have the bit [`INSTANCE`].
    pub(crate) singles: Vec<u32>,
    /// The leaves they are in, as places among them.
    pub(crate) others: Vec<Range<usize>>,
    bounds: Aabb,
    report: BuildReport,
    /// The instructions that traversal uses.
    pub(crate) level: Level,
}

/// What surfaces are made of.
#[derive(Clone, Debug, Default)]
pub struct Contents {
    /// The vertices of the triangles.
    pub positions: Vec<Vec3>,
    /// Three places in `positions` each.
    pub triangles: Vec<[u32; 3]>,
    /// Spheres.
    pub spheres: Vec<Sphere>,
    /// Disks.
    pub disks: Vec<Disk>,
    /// Custom shapes.
    pub customs: Vec<Custom>,
    /// Meshes that are stored once.
    pub meshes: Vec<Arc<SharedMesh>>,
    /// Where those stand. Of each `after` is no smaller than that of the one before.
    pub instances: Vec<Instance>,
}

/// Where a ray met a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The number of the primitive, within its mesh if it is one of an instance.
    pub primitive: u32,
    /// The number of the instance, if it is one.
    pub instance: Option<u32>,
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

impl Hit {
    /// The barycentric weights of a triangle's three vertices.
    pub fn weights(&self) -> [f32; 3] {
        [1.0 - self.u - self.v, self.u, self.v]
    }
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
        let contents = Contents { positions, triangles, spheres, disks, ..Contents::default() };
        Self::of(contents, options)
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
        let contents =
            Contents { positions, triangles, spheres, disks, customs, ..Contents::default() };
        Self::of(contents, options)
    }

    /// The same with meshes that are stored once. Instances of no mesh, or that
    /// [`cannot be placed`](Instance::can_place), are left out as well.
    ///
    /// # Panics
    ///
    /// As for [`new`](Self::new), instances being primitives too; what is in them does not count.
    pub fn of(contents: Contents, options: &BuildOptions) -> Self {
        let Contents { positions, triangles, spheres, disks, customs, meshes, instances } =
            &contents;
        let sphere_bounds = |s: &Sphere| if s.is_proper() { s.bounds() } else { Aabb::EMPTY };
        let disk_bounds = |d: &Disk| if d.is_proper() { d.bounds() } else { Aabb::EMPTY };
        let instance_bounds = |i: &Instance| match meshes.get(i.mesh as usize) {
            Some(mesh) if Instance::can_place(&i.world_from_mesh, &mesh.bounds()) => i.bounds(mesh),
            _ => Aabb::EMPTY,
        };
        let others = spheres.iter().map(sphere_bounds).chain(disks.iter().map(disk_bounds));
        let mut others: Vec<Aabb> = others.chain(customs.iter().map(Custom::bounds)).collect();
        let first_instance = (triangles.len() + others.len()) as u32;
        others.par_extend(instances.par_iter().map(instance_bounds));

        // A ray that comes to an instance has far more to do than at a triangle: none shares a leaf.
        let alone = BuildOptions { max_leaf: 1, ..*options };
        let options = if instances.is_empty() { options } else { &alone };
        let of = TreeOf { positions, triangles, others: &others, flat: false };
        let Tree { nodes, packs, mut singles, others, bounds, report } = of.build(options);
        for number in singles.iter_mut().filter(|number| **number >= first_instance) {
            *number = (*number - first_instance) | INSTANCE;
        }
        let own = size_of_val(&*nodes)
            + size_of_val(&*packs)
            + size_of_val(&*singles)
            + size_of_val(&*others)
            + size_of_val(&**positions)
            + size_of_val(&**triangles)
            + size_of_val(&**spheres)
            + size_of_val(&**disks)
            + size_of_val(&**customs)
            + size_of_val(&**instances);
        let bytes = own + meshes.iter().map(|mesh| mesh.report().bytes).sum::<usize>();
        let mut report = BuildReport { bytes, ..report };
        report.left_out.count += meshes.iter().map(|m| m.report().left_out.count).sum::<usize>();
        let level = Simd::Auto.level().unwrap_or_else(Level::new);
        Self { contents, nodes, packs, singles, others, bounds, report, level }
    }

    /// Whether these are the very surfaces that the tree was built over, bit by bit and in the same
    /// order, so that there is no need for another.
    pub fn are_of(&self, contents: &Contents) -> bool {
        let (own, other) = (&self.contents, contents);
        let bits = |v: &Vec3| v.to_array().map(f32::to_bits);
        let ball = |s: &Sphere| (bits(&s.center), s.radius.to_bits());
        let plate = |d: &Disk| [d.center, d.u, d.v].map(|v| bits(&v));
        let in_place = |(a, b): (&Custom, &Custom)| a.is_same(b);
        let same_mesh = |(a, b): (&Arc<SharedMesh>, &Arc<SharedMesh>)| {
            Arc::ptr_eq(a, b) || a.is_of(b.positions(), b.triangles())
        };
        own.triangles == other.triangles
            && own.positions.iter().map(bits).eq(other.positions.iter().map(bits))
            && own.spheres.iter().map(ball).eq(other.spheres.iter().map(ball))
            && own.disks.iter().map(plate).eq(other.disks.iter().map(plate))
            && own.customs.len() == other.customs.len()
            && own.customs.iter().zip(&other.customs).all(in_place)
            && own
                .instances
                .iter()
                .map(Instance::bits)
                .eq(other.instances.iter().map(Instance::bits))
            && own.meshes.len() == other.meshes.len()
            && own.meshes.iter().zip(&other.meshes).all(same_mesh)
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
        &self.contents.positions
    }

    /// All triangles as three places in [`positions`](Self::positions), also those left out.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.contents.triangles
    }

    /// All spheres, also those left out.
    pub fn spheres(&self) -> &[Sphere] {
        &self.contents.spheres
    }

    /// All disks, also those left out.
    pub fn disks(&self) -> &[Disk] {
        &self.contents.disks
    }

    /// All custom shapes, also those left out.
    pub fn customs(&self) -> &[Custom] {
        &self.contents.customs
    }

    /// The meshes that are stored once.
    pub fn meshes(&self) -> &[Arc<SharedMesh>] {
        &self.contents.meshes
    }

    /// Where those stand, also those left out.
    pub fn instances(&self) -> &[Instance] {
        &self.contents.instances
    }

    /// The mesh that an instance places.
    ///
    /// # Panics
    ///
    /// If there is none.
    #[inline(always)]
    pub fn mesh_of(&self, instance: &Instance) -> &SharedMesh {
        &self.contents.meshes[instance.mesh as usize]
    }

    /// The smallest box around all that the instance number `i` places in the world.
    ///
    /// # Panics
    ///
    /// If there is no such instance, or no mesh for it.
    pub fn bounds_of_instance(&self, i: u32) -> Aabb {
        let instance = &self.instances()[i as usize];
        instance.bounds(self.mesh_of(instance))
    }

    /// How far what the instance number `i` places in the world reaches from `center`.
    ///
    /// # Panics
    ///
    /// As for [`bounds_of_instance`](Self::bounds_of_instance).
    pub fn reach_of_instance(&self, i: u32, center: Vec3) -> f32 {
        let instance = &self.instances()[i as usize];
        instance.reach(self.mesh_of(instance), center)
    }

    /// The vertices of the triangle number `i`.
    ///
    /// # Panics
    ///
    /// If there is no such triangle, or it was left out for its indices.
    pub fn triangle(&self, i: u32) -> [Vec3; 3] {
        self.contents.triangles[i as usize].map(|vertex| self.contents.positions[vertex as usize])
    }

    /// The vertices of the triangle number `i` of an instance, in the world and in the order in
    /// which their weights count.
    ///
    /// # Panics
    ///
    /// As for [`triangle`](Self::triangle).
    pub fn triangle_of_instance(&self, instance: u32, i: u32) -> [Vec3; 3] {
        let instance = &self.instances()[instance as usize];
        let mesh = self.mesh_of(instance);
        let corners = mesh.triangles()[i as usize].map(|v| mesh.positions()[v as usize]);
        instance.placed(corners)
    }

    /// The primitive number `i`, which is none of an instance.
    #[inline]
    pub(crate) fn primitive(&self, i: u32) -> Primitive<'_> {
        let Contents { triangles, spheres, disks, customs, .. } = &self.contents;
        if (i as usize) < triangles.len() {
            return Primitive::Triangle(self.triangle(i));
        }
        let i = i as usize - triangles.len();
        if let Some(sphere) = spheres.get(i) {
            return Primitive::Sphere(sphere);
        }
        let i = i - spheres.len();
        match disks.get(i) {
            Some(disk) => Primitive::Disk(disk),
            None => Primitive::Custom(&customs[i - disks.len()]),
        }
    }
}

/// Marks the number of an instance among those that are met one by one.
pub(crate) const INSTANCE: u32 = 1 << 31;

/// What one number stands for.
pub(crate) enum Primitive<'a> {
    Triangle([Vec3; 3]),
    Sphere(&'a Sphere),
    Disk(&'a Disk),
    Custom(&'a Custom),
}

/// What a tree is built over.
#[derive(Clone, Copy)]
pub(crate) struct TreeOf<'a> {
    pub(crate) positions: &'a [Vec3],
    pub(crate) triangles: &'a [[u32; 3]],
    /// The boxes of all that is no triangle; their numbers come after those of the triangles.
    pub(crate) others: &'a [Aabb],
    /// Whether triangles without area are in the tree as well. They are counted as left out.
    pub(crate) flat: bool,
}

/// A tree for rays; the fields as in [`Surfaces`].
pub(crate) struct Tree {
    pub(crate) nodes: Vec<WideNode>,
    pub(crate) packs: Vec<Pack>,
    pub(crate) singles: Vec<u32>,
    pub(crate) others: Vec<Range<usize>>,
    pub(crate) bounds: Aabb,
    /// But for `bytes`.
    pub(crate) report: BuildReport,
}

impl TreeOf<'_> {
    /// The corners of a triangle, unless there is none or one of them is nowhere.
    fn corners(&self, i: u32) -> Option<[Vec3; 3]> {
        let [a, b, c] = (*self.triangles.get(i as usize)?).map(|v| self.positions.get(v as usize));
        Some([*a?, *b?, *c?])
    }

    pub(crate) fn build(&self, options: &BuildOptions) -> Tree {
        let (triangles, others) = (self.triangles, self.others);
        // An empty box tells the builder to leave something out.
        let triangle_bounds = |i: usize| {
            let Some([a, b, c]) = self.corners(i as u32) else { return Aabb::EMPTY };
            let finite = a.is_finite() && b.is_finite() && c.is_finite();
            if finite && (self.flat || triangle_normal([a, b, c]) != DVec3::ZERO) {
                Aabb::around([a, b, c])
            } else {
                Aabb::EMPTY
            }
        };
        let bounds = |i: usize| match i.checked_sub(triangles.len()) {
            None => triangle_bounds(i),
            Some(other) => others[other],
        };
        let bvh = Bvh::over(triangles.len() + others.len(), bounds, options);
        // Triangles in packs where all of a leaf are, all else one by one.
        let corners = |i: &u32| self.corners(*i);
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
        let mut report = report(&bvh, &nodes, |inside: Inside| match inside.as_leaf() {
            (other, 0) => others[other].len(),
            (first, _) => usize::from(planned[first].0.count),
        });
        if self.flat {
            let is_flat =
                |i: &u32| corners(i).is_some_and(|corners| triangle_normal(corners) == DVec3::ZERO);
            let flat = bvh.order().par_iter().copied().filter(is_flat);
            let (count, first) = (flat.clone().count(), flat.min());
            report.left_out.count += count;
            report.left_out.first = report.left_out.first.into_iter().chain(first).min();
        }
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
        Tree { nodes, packs, singles, others, bounds, report }
    }
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
