//! A mesh that stands in many places, stored once.
//!
//! Each place is an [`Instance`]: the mesh's number and an affine map. The mesh
//! has a tree of its own, in its own space; the tree of the world holds a box
//! for each instance.
//!
//! Where a ray meets an instance is where it would meet a copy of the mesh, to
//! the bit. The exact test is made in the world, on the three vertices as a copy
//! would have them: mapped and rounded to single precision. The mesh's tree only
//! finds the triangles that it is made on, and must not lose one. A ray is
//! mapped back to it in double precision, starts anew where it enters the mesh's
//! box, and meets boxes and triangles that are larger by all that rounding can
//! have done:
//!
//! - to a vertex when it was mapped and rounded. The three products and their
//!   sum are wrong by less than 4u (Σ |L p| + |T|), u = 2⁻²⁴, along each axis of
//!   the world; the inverse map says how much that is in the mesh's space.
//! - to the ray when it was mapped, and in the exact test: less than 2⁻⁴⁸ of the
//!   way from the ray's origin to the instance's, mapped likewise. Cofactors of
//!   the matrix are exact but for one rounding, since products of two single
//!   numbers are exact in double precision. The determinant may lose more: what
//!   that does is the same as another scale, and matrices for which it were
//!   more than 2⁻³⁰ are refused.
//! - to the ray when it was rounded to single precision: its new origin and its
//!   way through the box by less than 8u of the mesh's largest coordinate.
//!
//! Not for meshes that stand once or are small: a copy is met faster.

use crate::aabb::rounded_up;
use crate::bvh::{Inside, MAX_DEPTH, SLACK, WIDTH, WideNode};
use crate::packs::{LARGEST, Pack, fits};
use crate::surfaces::{Tree, TreeOf};
use crate::{Aabb, BuildOptions, BuildReport, Ray, Transform, Vec3};
use arrayvec::ArrayVec;
use glam::DVec3;

/// Triangles under a tree of their own, which instances place in the world.
#[derive(Clone, Debug)]
pub struct SharedMesh {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    pub(crate) nodes: Vec<WideNode>,
    pub(crate) packs: Vec<Pack>,
    bounds: Aabb,
    report: BuildReport,
}

impl SharedMesh {
    /// Builds the tree. `None` where a triangle has finite coordinates of 10¹⁷ or more.
    ///
    /// Left out, and counted in the [`report`](Self::report), are triangles with a number that is
    /// NaN or infinite, and those with an index beyond `positions`. Triangles without area are
    /// counted as left out as well, but kept: once mapped and rounded they may have one.
    ///
    /// # Panics
    ///
    /// If there are 2³¹ triangles or more.
    pub fn new(
        positions: Vec<Vec3>,
        triangles: Vec<[u32; 3]>,
        options: &BuildOptions,
    ) -> Option<Self> {
        let of = TreeOf { positions: &positions, triangles: &triangles, others: &[], flat: true };
        let Tree { nodes, packs, singles, bounds, report, .. } = of.build(options);
        if !singles.is_empty() {
            return None;
        }
        let bytes = size_of_val(&*nodes)
            + size_of_val(&*packs)
            + size_of_val(&*positions)
            + size_of_val(&*triangles);
        let report = BuildReport { bytes, ..report };
        Some(Self { positions, triangles, nodes, packs, bounds, report })
    }

    /// Whether this is the very mesh that the tree was built over, bit by bit and in the same order.
    pub fn is_of(&self, positions: &[Vec3], triangles: &[[u32; 3]]) -> bool {
        let bits = |v: &Vec3| v.to_array().map(f32::to_bits);
        self.triangles == triangles
            && self.positions.len() == positions.len()
            && self.positions.iter().map(bits).eq(positions.iter().map(bits))
    }

    /// What was built and what was left out. `bytes` counts the mesh as well as the tree.
    pub fn report(&self) -> &BuildReport {
        &self.report
    }

    /// The box around everything in the mesh's own space; [`Aabb::EMPTY`] if there is nothing.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// All vertices, in the mesh's own space.
    pub fn positions(&self) -> &[Vec3] {
        &self.positions
    }

    /// All triangles as three places in [`positions`](Self::positions), also those left out.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The largest that `value` says of a vertex of a triangle in the tree. `most` says what it
    /// cannot exceed within a box, and should be no more than that: of vertices that are all as far,
    /// on a plane for instance, one is looked at then. Negative infinity if there are no triangles.
    fn largest(&self, most: impl Fn(&Aabb) -> f32, value: impl Fn(Vec3) -> f32) -> f32 {
        let mut largest = f32::NEG_INFINITY;
        let mut pending = ArrayVec::<(f32, Inside), { (WIDTH - 1) * (MAX_DEPTH + 1) }>::new();
        let mut next = (!self.nodes.is_empty()).then_some((f32::INFINITY, Inside::node(0)));
        while let Some((most_in_it, inside)) = next {
            if most_in_it > largest {
                if let Some(node) = inside.as_node().and_then(|number| self.nodes.get(number)) {
                    let before = pending.len();
                    for (bounds, inside) in node.parts() {
                        pending.push((most(&bounds), inside));
                    }
                    // The most promising is looked at first.
                    pending[before..].sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
                } else {
                    let (first, count) = inside.as_leaf();
                    for pack in self.packs.get(first..first + count).unwrap_or_default() {
                        let corners = (0..pack.len()).flat_map(|lane| pack.triangle(lane));
                        largest = corners.map(&value).fold(largest, f32::max);
                    }
                }
            }
            next = pending.pop();
        }
        largest
    }
}

/// A place where a mesh stands. 60 bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    /// The number of the mesh.
    pub mesh: u32,
    /// Whether the second and the third vertex of each triangle change places, so that its back
    /// becomes its front.
    pub turned: bool,
    /// Of the triangles that stand alone, how many come before this: where several surfaces are met
    /// at the same place, the first of all counts.
    pub after: u32,
    /// Where it stands.
    pub world_from_mesh: Transform,
}

impl Instance {
    /// Whether a mesh within `bounds` can be placed by this map: it does not flatten space, its
    /// inverse is known well enough, and all that it places stays below 10¹⁷.
    pub fn can_place(world_from_mesh: &Transform, bounds: &Aabb) -> bool {
        /// What the determinant may lose to cancellation, as a factor.
        const MOST_LOST: f64 = (1 << 20) as f64;
        let [x, y, z] = axes(world_from_mesh);
        let first = y.cross(z);
        let determinant = x.dot(first);
        let known = x.abs().dot(first.abs()) <= MOST_LOST * determinant.abs();
        let corner = size(world_from_mesh, bounds).max_element();
        let inverse = [first, z.cross(x), x.cross(y)].map(|row| row / determinant);
        let reversible = inverse.iter().all(|row| row.abs().max_element() < 1e30);
        determinant != 0.0 && known && reversible && corner < f64::from(LARGEST)
    }

    /// All of it, to be compared.
    pub(crate) fn bits(&self) -> ([u32; 12], u32, bool, u32) {
        let linear = self.world_from_mesh.linear().to_cols_array();
        let all = linear.into_iter().chain(self.world_from_mesh.translation().to_array());
        let mut bits = [0; 12];
        bits.iter_mut().zip(all).for_each(|(bits, number)| *bits = number.to_bits());
        (bits, self.mesh, self.turned, self.after)
    }

    /// The corners of a triangle, from those in the mesh's own space.
    #[inline(always)]
    pub fn placed(&self, corners: [Vec3; 3]) -> [Vec3; 3] {
        let [a, b, c] = corners.map(|corner| self.world_from_mesh.point(corner));
        if self.turned { [a, c, b] } else { [a, b, c] }
    }

    /// The smallest box around all its triangles in the world.
    pub(crate) fn bounds(&self, mesh: &SharedMesh) -> Aabb {
        let side = |axis: usize, sign: f32| {
            let most = |part: &Aabb| sign * self.farthest(part, axis, sign);
            sign * mesh.largest(most, |p| sign * self.world_from_mesh.point(p)[axis])
        };
        let corner = |sign| Vec3::from_array([0, 1, 2].map(|axis| side(axis, sign)));
        let bounds = Aabb { min: corner(-1.0), max: corner(1.0) };
        if mesh.nodes.is_empty() { Aabb::EMPTY } else { bounds }
    }

    /// How far its triangles reach from `center`, in the world.
    pub(crate) fn reach(&self, mesh: &SharedMesh, center: Vec3) -> f32 {
        let most = |part: &Aabb| {
            let side = |sign| Vec3::from([0, 1, 2].map(|axis| self.farthest(part, axis, sign)));
            (center - side(-1.0)).abs().max((center - side(1.0)).abs()).length()
        };
        mesh.largest(most, |p| center.distance(self.world_from_mesh.point(p)))
    }

    /// How far what is within a box reaches along an axis of the world, or against it where `sign` is
    /// −1: exactly as single precision places it, for rounding keeps the order of numbers.
    fn farthest(&self, part: &Aabb, axis: usize, sign: f32) -> f32 {
        let row = self.world_from_mesh.linear().row(axis) * sign;
        let corner = Vec3::select(row.cmpge(Vec3::ZERO), part.max, part.min);
        self.world_from_mesh.point(corner)[axis]
    }

    /// How far off single precision may place what is within `bounds`, along each axis of the world.
    #[inline(always)]
    fn rounding(&self, bounds: &Aabb) -> DVec3 {
        /// A little more than four roundings, and what is lost where numbers are too small for one.
        const ROUNDINGS: f64 = 4.1 * (f32::EPSILON / 2.0) as f64;
        const TINY: f64 = f32::MIN_POSITIVE as f64;
        size(&self.world_from_mesh, bounds) * ROUNDINGS + TINY
    }

    /// The ray in the mesh's own space, from where it enters the mesh's box on. `None` where it does
    /// not come to it before `reach`.
    #[inline(always)]
    pub(crate) fn enter(&self, mesh: &SharedMesh, ray: &Ray, reach: f64) -> Option<Entered> {
        const U: f64 = (f32::EPSILON / 2.0) as f64;
        let [x, y, z] = axes(&self.world_from_mesh);
        let rows = [y.cross(z), z.cross(x), x.cross(y)];
        let part = 1.0 / x.dot(rows[0]);
        let rows = rows.map(|row| row * part);
        let map = |v: DVec3| DVec3::new(rows[0].dot(v), rows[1].dot(v), rows[2].dot(v));

        // How much room rounding needs.
        let from = ray.origin.as_dvec3() - self.world_from_mesh.translation().as_dvec3();
        let far = from.abs().max_element() / (1_u64 << 48) as f64;
        let lost = self.rounding(&mesh.bounds) + DVec3::splat(far);
        let within = mesh.bounds.min.abs().max(mesh.bounds.max.abs()).as_dvec3();
        let lost = DVec3::from_array(rows.map(|row| row.abs().dot(lost)));
        let room = lost + within * (8.0 * U) + f64::from(f32::MIN_POSITIVE);

        // Where the ray is within the box, with twice that room.
        let (origin, direction) = (map(from), map(ray.direction.as_dvec3()));
        let (low, high) =
            (mesh.bounds.min.as_dvec3() - 2.0 * room, mesh.bounds.max.as_dvec3() + 2.0 * room);
        let (a, b) = ((low - origin) / direction, (high - origin) / direction);
        let (mut enter, mut exit) = (f64::from(ray.t_min), f64::from(ray.t_max).min(reach));
        for axis in 0..3 {
            enter = enter.max(a[axis].min(b[axis]));
            exit = exit.min(a[axis].max(b[axis]));
        }
        if enter > exit {
            return None;
        }

        // The direction gets a size near one, by a power of two.
        let longest = direction.abs().max_element();
        let exponent = longest.to_bits() & 0x7ff0_0000_0000_0000;
        let speed = f64::from_bits(exponent);
        let entered = Entered {
            origin: (origin + direction * enter).as_vec3(),
            direction: (direction / speed).as_vec3(),
            room: rounded_up(room),
            at: enter,
            speed,
        };
        // Not for directions that the map makes zero or infinite.
        let sound = exponent != 0 && entered.direction.is_finite() && entered.origin.is_finite();
        sound.then_some(entered)
    }
}

/// A ray in the space of a mesh, from where it enters the mesh's box on.
pub(crate) struct Entered {
    pub(crate) origin: Vec3,
    /// Its longest coordinate is between one and two.
    pub(crate) direction: Vec3,
    /// What boxes have to be larger by, on each side.
    pub(crate) room: Vec3,
    /// The `t` of the ray in the world where it enters.
    at: f64,
    /// So many lengths of `direction` are one of that of the ray in the world.
    speed: f64,
}

impl Entered {
    /// A box that is entered beyond this holds no hit before `reach`, a `t` of the ray in the world.
    #[inline(always)]
    pub(crate) fn limit_of(&self, reach: f64) -> f32 {
        ((reach - self.at) * self.speed) as f32 * SLACK
    }

    /// What [`Pack`]s have to be told that the way to them is longer by, so that they make up for
    /// the room that triangles need. See `packs.rs`: for vertices that are off by δ along each
    /// axis, sheared by 2δ, and a way W that is told longer by 2δ/u, an edge function is wrong by
    /// less than what is allowed there for the longer way, and so is the distance.
    #[inline(always)]
    pub(crate) fn longer_way(&self) -> f32 {
        self.room.max_element() * (4.0 / f32::EPSILON)
    }
}

/// The images of the three axes.
#[inline(always)]
fn axes(transform: &Transform) -> [DVec3; 3] {
    let linear = transform.linear();
    [linear.x_axis, linear.y_axis, linear.z_axis].map(Vec3::as_dvec3)
}

/// How large the terms are, all together, that make up what is placed within `bounds`.
#[inline(always)]
fn size(transform: &Transform, bounds: &Aabb) -> DVec3 {
    let [x, y, z] = axes(transform).map(DVec3::abs);
    let most = bounds.min.abs().max(bounds.max.abs()).as_dvec3();
    let translation = transform.translation().abs().as_dvec3();
    x * most.x + y * most.y + z * most.z + translation
}

/// Whether the positions of a mesh are small enough for a [`SharedMesh`], NaN and infinity aside.
pub fn can_be_shared(positions: &[Vec3]) -> bool {
    positions.iter().all(|p| !p.is_finite() || fits([*p; 3]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    /// Of a turned plane, all of whose vertices reach as far but for rounding, a few are looked at, and
    /// what is found is what all of them say.
    #[test]
    fn a_plane_is_not_walked_through() {
        let side = 64;
        let positions = (0..side * side)
            .map(|i| Vec3::new((i % side) as f32, (i / side) as f32, 0.0) * 0.37)
            .collect::<Vec<_>>();
        let corner = |x: u32, y: u32| y * side + x;
        let triangles = (0..side - 1)
            .flat_map(|y| (0..side - 1).map(move |x| (x, y)))
            .map(|(x, y)| [corner(x, y), corner(x + 1, y), corner(x, y + 1)])
            .collect::<Vec<_>>();
        let mesh = SharedMesh::new(positions, triangles, &BuildOptions::default()).unwrap();
        for turn in [0.0, 0.3, 2.0] {
            let world_from_mesh =
                Transform::translate(Vec3::splat(0.1)) * Transform::rotate(Vec3::Z, turn);
            let instance = Instance { mesh: 0, turned: false, after: 0, world_from_mesh };
            let looked = Cell::new(0);
            let height = |p: Vec3| {
                looked.set(looked.get() + 1);
                world_from_mesh.point(p).z
            };
            let found = mesh.largest(|part| instance.farthest(part, 2, 1.0), height);
            let placed = || mesh.positions().iter().map(|p| world_from_mesh.point(*p));
            assert_eq!(found, placed().map(|p| p.z).fold(f32::NEG_INFINITY, f32::max));
            assert!(looked.get() < 100, "{}", looked.get());
            // The last corner of the grid belongs to no triangle.
            let used = || placed().take((side * side - 1) as usize);
            let bounds = used().fold(Aabb::EMPTY, |all, p| all.union(Aabb { min: p, max: p }));
            assert_eq!(instance.bounds(&mesh), bounds);
            let center = Vec3::new(3.0, -1.0, 2.0);
            let farthest = used().map(|p| center.distance(p)).fold(0.0, f32::max);
            assert_eq!(instance.reach(&mesh, center), farthest);
        }
    }
}
