//! Rays meet surfaces: which one first, or whether any.
//!
//! On the way through the tree single precision sorts out most triangles and
//! keeps a few that may be the first one (`packs.rs`); double precision decides
//! among those at the end. For eight rays at once each of these is done for
//! eight of them.

use crate::bvh::{
    BoxRay, Inside, Met, Order, PACK, RoomyBoxRay, SLACK, Visit, WideNode, limit_of, traverse,
    traverse_in_turn, traverse_packet, way,
};
use crate::custom::CustomHit;
use crate::lanes::{LANES, each_lane};
use crate::packet::{HitPacket, NearestPacket, RayPacket, RaysReady, TriangleRays};
use crate::packs::{Pack, PackRay, turned};
use crate::surfaces::{Hit, INSTANCE, Primitive, Surfaces, triangle_normal};
use crate::triangle::TriangleRay;
use crate::with_vectors;
use crate::{Ray, Sphere, Vec3};
use arrayvec::ArrayVec;
use fearless_simd::prelude::*;
use fearless_simd::{Fallback, Simd, f32x8, mask32x8, u32x8};
use glam::DVec3;

/// Trees of as many nodes, a megabyte of them, are not all in the nearer caches.
const FAR: usize = 4096;

/// A triangle that may be the first one met.
#[derive(Clone, Copy)]
struct Candidate {
    /// Four times the number of its pack, and its place there.
    at: u32,
    /// It is met no sooner.
    from: f32,
}

/// What has been found for one ray.
#[derive(Default)]
struct Search {
    candidates: ArrayVec<Candidate, 8>,
    /// Of all others.
    nearest: Option<Nearest>,
    custom: Option<CustomHit>,
}

/// The nearest hit so far.
#[derive(Clone, Copy)]
struct Nearest {
    t: f64,
    turn: Turn,
    primitive: u32,
    uv: [f64; 2],
}

/// Which of several surfaces at the same place counts: the least. As if all instances were copies
/// of their meshes, among the other triangles in the order of their making: after so many of
/// those, then the number of the instance. The number of the primitive comes last.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Turn(u64);

impl Turn {
    /// Of a primitive that is none of an instance: after all instances that come before it.
    #[inline(always)]
    fn alone(primitive: u32) -> Self {
        Self(u64::from(primitive) << 32 | u64::from(u32::MAX))
    }

    /// Of what is in the instance number `i`.
    #[inline(always)]
    fn within(i: u32, after: u32) -> Self {
        Self(u64::from(after) << 32 | u64::from(i))
    }

    /// The number of the instance, if it is one.
    #[inline(always)]
    fn instance(self) -> Option<u32> {
        let number = self.0 as u32;
        (number != u32::MAX).then_some(number)
    }
}

/// Where a ray stands that has passed a surface.
struct Passed {
    t: f64,
    turn: Turn,
    primitive: u32,
}

impl Passed {
    /// Whether a hit comes after it.
    fn is_before(&self, hit: &Nearest) -> bool {
        (self.t, self.turn, self.primitive) < (hit.t, hit.turn, hit.primitive)
    }
}

impl Nearest {
    /// Takes the place of what is farther, and tells whether it did; of equal ones the first stays.
    #[inline(always)]
    fn keep(self, nearest: &mut Option<Self>) -> bool {
        let sooner = |n: &Self| {
            let first = || (self.turn, self.primitive) < (n.turn, n.primitive);
            self.t < n.t || (self.t == n.t && first())
        };
        let keep = nearest.as_ref().is_none_or(sooner);
        if keep {
            *nearest = Some(self);
        }
        keep
    }
}

impl Surfaces {
    /// The first surface that the ray meets, from either side: the hit with the
    /// least `t` in double precision, of equal ones that with the smallest number, where
    /// instances count as if they were copies (see [`Instance::after`](crate::Instance)).
    ///
    /// A ray with a NaN, an infinite origin or direction, or none, meets nothing.
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        let mut search = Search::default();
        with_vectors!(
            self.level,
            simd => self.search_alone(simd, ray, &mut search),
            else self.search_alone(Fallback::new(), ray, &mut search)
        );
        self.finish(ray, search.nearest?, search.custom)
    }

    /// The surface that the ray meets next, after the one that it met at `hit`: in the order in which
    /// [`closest`](Self::closest) chooses, so that of several at the same place none is left out.
    ///
    /// What a custom shape has at the same distance, to single precision, as a hit on one does not
    /// count: it need not give the same answer twice.
    pub fn closest_after(&self, ray: &Ray, hit: &Hit) -> Option<Hit> {
        let passed = self.passed(ray, hit);
        // Begins a little before, for `passed` decides.
        let ahead = Ray { t_min: (passed.t as f32).next_down().max(ray.t_min), ..*ray };
        let beyond = Ray { t_min: (passed.t as f32).next_up(), ..*ray };
        let exact = TriangleRay::new(&ahead);
        let (mut nearest, mut said) = (None, None);
        self.each_near(&ahead, Order::Nearest, &mut |instance, primitive, surface| {
            let turn = self.turn_of(instance, primitive);
            let at = |t, uv| Nearest { t, turn, primitive, uv };
            let end = f64::from(ray.t_max);
            let next = |found: &Nearest| passed.is_before(found) && found.t < end;
            let met = match surface {
                Primitive::Triangle([a, b, c]) => {
                    exact.intersect(a, b, c).map(|met| at(met.t, [met.u, met.v])).filter(next)
                }
                Primitive::Sphere(sphere) => {
                    let both = sphere.crossings(&ahead).into_iter().flatten();
                    both.map(|t| at(t, [0.0, 0.0])).find(next)
                }
                Primitive::Disk(disk) => {
                    disk.intersect(&ahead).map(|met| at(met.t, [met.a, met.b])).filter(next)
                }
                Primitive::Custom(custom) => {
                    let from = |ray: &Ray| {
                        let met = custom.intersect(ray)?;
                        let found = at(met.t, met.uv);
                        next(&found).then_some((found, met))
                    };
                    let met = from(&ahead).or_else(|| from(&beyond));
                    if let Some((found, met)) = met
                        && found.keep(&mut nearest)
                    {
                        said = Some(met);
                    }
                    None
                }
            };
            if let Some(found) = met {
                found.keep(&mut nearest);
            }
            nearest.map_or(f64::INFINITY, |nearest: Nearest| nearest.t)
        });
        self.finish(ray, nearest?, said)
    }

    /// Where a ray stands after what it met at `hit`.
    fn passed(&self, ray: &Ray, hit: &Hit) -> Passed {
        let Hit { instance, primitive, t, .. } = *hit;
        let surface = match instance {
            Some(i) => Primitive::Triangle(self.triangle_of_instance(i, primitive)),
            None => self.primitive(primitive),
        };
        let exactly = match surface {
            Primitive::Triangle([a, b, c]) => {
                TriangleRay::new(ray).intersect(a, b, c).map(|met| met.t)
            }
            // If nothing tells its two sides apart, both were passed.
            Primitive::Sphere(sphere) => {
                let is_this = |&side: &f64| {
                    side as f32 == t && sphere.surface_at(ray, side).1.as_vec3() == hit.normal
                };
                sphere.crossings(ray).into_iter().flatten().rfind(is_this)
            }
            Primitive::Disk(disk) => disk.intersect(ray).map(|met| met.t),
            Primitive::Custom(_) => None,
        };
        // Else all that is rounded to the same number.
        let t = exactly.unwrap_or_else(|| 0.5 * (f64::from(t) + f64::from(t.next_up())));
        Passed { t, turn: self.turn_of(instance, primitive), primitive }
    }

    /// Which turn a primitive has among those at the same place.
    fn turn_of(&self, instance: Option<u32>, primitive: u32) -> Turn {
        match instance {
            Some(i) => Turn::within(i, self.instances()[i as usize].after),
            None => Turn::alone(primitive),
        }
    }

    /// Whether the ray meets anything at all; the same as `closest(ray).is_some()`, but sooner.
    pub fn occluded(&self, ray: &Ray) -> bool {
        with_vectors!(
            self.level,
            simd => self.blocked(simd, ray),
            else self.blocked(Fallback::new(), ray)
        )
    }

    /// What [`closest`](Self::closest) finds for each of eight rays.
    pub fn closest_packet(&self, rays: &RayPacket) -> HitPacket {
        with_vectors!(self.level, simd => self.closest_of(simd, rays), else {
            let mut hits = HitPacket::NONE;
            for lane in 0..LANES {
                hits.set(lane, self.closest(&rays.ray(lane)).as_ref());
            }
            hits
        })
    }

    /// Which of eight rays are [`occluded`](Self::occluded), a bit for each.
    pub fn occluded_packet(&self, rays: &RayPacket) -> u32 {
        with_vectors!(self.level, simd => self.blocked_of(simd, rays), else {
            (0..LANES).fold(0, |all, i| all | u32::from(self.occluded(&rays.ray(i))) << i)
        })
    }

    #[inline(always)]
    fn search_alone<S: Simd>(&self, simd: S, ray: &Ray, search: &mut Search) {
        let Some(boxes) = BoxRay::new(simd, ray) else { return };
        let packs = PackRay::new(simd, ray, boxes.scale);
        let mut limit = limit_of(f64::from(ray.t_max), boxes.scale);
        self.search(&boxes, &packs, ray, (Inside::node(0), 0.0), &mut limit, search);
        self.settle(ray, limit, search);
    }

    /// Searches part of the tree.
    #[inline(always)]
    fn search<S: Simd>(
        &self,
        boxes: &BoxRay<S>,
        packs: &PackRay<S>,
        ray: &Ray,
        from: (Inside, f32),
        limit: &mut f32,
        search: &mut Search,
    ) {
        traverse(
            &self.nodes,
            boxes,
            Order::Nearest,
            from,
            limit,
            #[inline(always)]
            |leaf, limit| {
                let all = self.packs_of(leaf.inside);
                self.search_packs(packs, ray, leaf.way, all, limit, search);
                self.search_singles(ray, leaf, boxes.scale, limit, search);
                false
            },
        );
    }

    /// Searches the packs of a leaf, which start with number `first`.
    #[inline(always)]
    fn search_packs<S: Simd>(
        &self,
        packs: &PackRay<S>,
        ray: &Ray,
        way: f32,
        (first, all): (usize, &[Pack]),
        limit: &mut f32,
        search: &mut Search,
    ) {
        for (i, pack) in all.iter().enumerate() {
            let sorted = packs.meet(pack, way, *limit);
            let sure = sorted.sure.to_bitmask();
            for lane in each_lane(sorted.may.to_bitmask() as u32) {
                if pack.primitives[lane % PACK] == packs.leaves {
                    continue;
                }
                let at = ((first + i) * PACK + lane % PACK) as u32;
                self.note(Candidate { at, from: sorted.from[lane % PACK] }, ray, *limit, search);
                if sure >> lane & 1 == 1 {
                    *limit = limit.min(sorted.until[lane % PACK] * SLACK);
                }
            }
        }
    }

    /// Searches a leaf whose primitives are met one by one.
    #[inline(always)]
    fn search_singles(
        &self,
        ray: &Ray,
        leaf: Met,
        scale: f32,
        limit: &mut f32,
        search: &mut Search,
    ) {
        for number in self.singles_of(leaf) {
            if number & INSTANCE != 0 {
                let reach = f64::from(*limit) / f64::from(scale);
                self.meet_instance(ray, number & !INSTANCE, reach, &mut search.nearest);
            } else {
                self.meet_single(ray, *number, &mut search.nearest, &mut search.custom);
            }
            if let Some(nearest) = search.nearest {
                *limit = limit.min(limit_of(nearest.t, scale));
            }
        }
    }

    /// Keeps a candidate.
    #[inline(always)]
    fn note(&self, candidate: Candidate, ray: &Ray, limit: f32, search: &mut Search) {
        if search.candidates.is_full() {
            self.settle(ray, limit, search);
        }
        search.candidates.push(candidate);
    }

    /// Decides among the candidates.
    #[inline(never)]
    fn settle(&self, ray: &Ray, limit: f32, search: &mut Search) {
        let exact = TriangleRay::new(ray);
        for candidate in search.candidates.drain(..) {
            if candidate.from <= limit {
                let (pack, lane) = self.pack_of(candidate.at);
                let [a, b, c] = pack.triangle(lane);
                if let Some(hit) = exact.intersect(a, b, c) {
                    let primitive = pack.primitives[lane % PACK];
                    let (turn, uv) = (Turn::alone(primitive), [hit.u, hit.v]);
                    Nearest { t: hit.t, turn, primitive, uv }.keep(&mut search.nearest);
                }
            }
        }
    }

    #[inline(always)]
    fn blocked<S: Simd>(&self, simd: S, ray: &Ray) -> bool {
        let Some(boxes) = BoxRay::new(simd, ray) else { return false };
        let packs = PackRay::new(simd, ray, boxes.scale);
        let limit = limit_of(f64::from(ray.t_max), boxes.scale);
        self.blocked_from(&boxes, &packs, ray, (Inside::node(0), 0.0), limit)
    }

    /// Whether anything in part of the tree is in the way.
    #[inline(always)]
    fn blocked_from<S: Simd>(
        &self,
        boxes: &BoxRay<S>,
        packs: &PackRay<S>,
        ray: &Ray,
        from: (Inside, f32),
        mut limit: f32,
    ) -> bool {
        let mut blocked = false;
        traverse(
            &self.nodes,
            boxes,
            Order::Any,
            from,
            &mut limit,
            #[inline(always)]
            |leaf, limit| {
                blocked = self.blocks(packs, ray, leaf, *limit);
                blocked
            },
        );
        blocked
    }

    /// Whether anything in a leaf is in the way.
    #[inline(always)]
    fn blocks<S: Simd>(&self, packs: &PackRay<S>, ray: &Ray, leaf: Met, limit: f32) -> bool {
        let (first, all) = self.packs_of(leaf.inside);
        for (i, pack) in all.iter().enumerate() {
            let sorted = packs.meet(pack, leaf.way, limit);
            if sorted.sure.any_true() {
                return true;
            }
            let mut may = sorted.may.to_bitmask() as u32;
            for lane in each_lane(may) {
                let leaves = pack.primitives[lane % PACK] == packs.leaves;
                may &= !(u32::from(leaves) << lane);
            }
            if may != 0 && self.meets(ray, (first + i) * PACK, may) {
                return true;
            }
        }
        self.singles_of(leaf).iter().any(|number| {
            if number & INSTANCE != 0 {
                return self.instance_blocks(ray, number & !INSTANCE);
            }
            let mut nearest = None;
            self.meet_single(ray, *number, &mut nearest, &mut None);
            nearest.is_some()
        })
    }

    /// Whether a ray meets some of the triangles of a pack.
    #[inline(never)]
    fn meets(&self, ray: &Ray, first: usize, mut which: u32) -> bool {
        let exact = TriangleRay::new(ray);
        while which != 0 {
            let (pack, lane) = self.pack_of(first as u32 + which.trailing_zeros());
            which &= which - 1;
            let [a, b, c] = pack.triangle(lane);
            if exact.intersect(a, b, c).is_some() {
                return true;
            }
        }
        false
    }

    /// The packs of a leaf, and the number of the first.
    #[inline(always)]
    fn packs_of(&self, leaf: Inside) -> (usize, &[Pack]) {
        let (first, count) = leaf.as_leaf();
        (first, self.packs.get(first..first + count).unwrap_or_default())
    }

    #[inline(always)]
    fn pack_of(&self, at: u32) -> (&Pack, usize) {
        (&self.packs[at as usize / PACK], at as usize % PACK)
    }

    /// Closest hits of eight rays.
    #[inline(always)]
    fn closest_of<S: Simd>(&self, simd: S, packet: &RayPacket) -> HitPacket {
        let rays = RaysReady::new(simd, packet);
        let mut searches: [Search; LANES] = Default::default();
        if self.goes_apart(&rays) {
            return self.closest_in_turn(&rays, packet, &mut searches);
        }
        let mut limit = rays.limit;
        traverse_packet(
            &self.nodes,
            &rays.boxes,
            &mut limit,
            #[inline(always)]
            |visit: Visit<S>, limit| {
                if visit.inside.as_node().is_some() {
                    for lane in each_lane(visit.mask) {
                        let from = (visit.inside, visit.enter[lane]);
                        let (boxes, packs) = (rays.boxes.one(lane), rays.packs(packet, lane));
                        let (search, ray) = (&mut searches[lane], packet.ray(lane));
                        self.search(&boxes, &packs, &ray, from, &mut limit[lane], search);
                    }
                    return;
                }
                let (first, all) = self.packs_of(visit.inside);
                if all.is_empty() {
                    for lane in each_lane(visit.mask) {
                        let leaf = Met { inside: visit.inside, way: 0.0 };
                        let (search, scale) = (&mut searches[lane], rays.boxes.scale[lane]);
                        let limit = &mut limit[lane];
                        self.search_singles(&packet.ray(lane), leaf, scale, limit, search);
                    }
                } else if !visit.together(all) {
                    for lane in each_lane(visit.mask) {
                        let (search, packs) = (&mut searches[lane], rays.packs(packet, lane));
                        let way = way(visit.enter[lane]);
                        let ray = packet.ray(lane);
                        self.search_packs(
                            &packs,
                            &ray,
                            way,
                            (first, all),
                            &mut limit[lane],
                            search,
                        );
                    }
                } else {
                    for (i, pack) in all.iter().enumerate() {
                        for lane in 0..pack.len() {
                            let sorted = rays.sort_out(pack, lane, visit.enter, *limit);
                            let mut may = sorted.may.to_bitmask() as u32 & visit.mask;
                            if may == 0 {
                                continue;
                            }
                            may &= !rays.leaving(pack.primitives[lane % PACK]);
                            let at = ((first + i) * PACK + lane) as u32;
                            for ray in each_lane(may) {
                                let candidate = Candidate { at, from: sorted.from[ray] };
                                let search = &mut searches[ray];
                                self.note(candidate, &packet.ray(ray), limit[ray], search);
                            }
                            let nearer = limit.min(sorted.until * SLACK);
                            *limit = sorted.sure.select(nearer, *limit);
                        }
                    }
                }
            },
        );
        self.decide(&rays, packet, &limit, &mut searches)
    }

    /// Whether rays have little to share, and the tree is too large to be at hand.
    #[inline(always)]
    fn goes_apart<S: Simd>(&self, rays: &RaysReady<S>) -> bool {
        self.nodes.len() >= FAR && !rays.boxes.go_alike(rays.there())
    }

    /// Closest hits of eight rays that go each its own way.
    #[inline(always)]
    fn closest_in_turn<S: Simd>(
        &self,
        rays: &RaysReady<S>,
        packet: &RayPacket,
        searches: &mut [Search; LANES],
    ) -> HitPacket {
        let mut limits: [f32; LANES] = rays.limit.into();
        self.in_turn(
            rays,
            packet,
            Order::Nearest,
            &mut limits,
            #[inline(always)]
            |lane, packs, leaf, limit| {
                let all = self.packs_of(leaf.inside);
                let (search, ray) = (&mut searches[lane], packet.ray(lane));
                self.search_packs(packs, &ray, leaf.way, all, limit, search);
                self.search_singles(&ray, leaf, rays.boxes.scale[lane], limit, search);
                false
            },
        );
        self.decide(rays, packet, &limits, searches)
    }

    /// Which of eight rays that go each its own way are blocked.
    #[inline(always)]
    fn blocked_in_turn<S: Simd>(&self, rays: &RaysReady<S>, packet: &RayPacket) -> u32 {
        let mut blocked = 0;
        self.in_turn(
            rays,
            packet,
            Order::Any,
            &mut rays.limit.into(),
            #[inline(always)]
            |lane, packs, leaf, limit| {
                let blocks = self.blocks(packs, &packet.ray(lane), leaf, *limit);
                blocked |= u32::from(blocks) << lane;
                blocks
            },
        );
        blocked
    }

    /// Takes eight rays through the tree in turn.
    #[inline(always)]
    fn in_turn<S: Simd>(
        &self,
        rays: &RaysReady<S>,
        packet: &RayPacket,
        order: Order,
        limits: &mut [f32; LANES],
        mut leaf: impl FnMut(usize, &PackRay<S>, Met, &mut f32) -> bool,
    ) {
        let boxes: [_; LANES] = std::array::from_fn(|lane| rays.boxes.one(lane));
        let packs: [_; LANES] = std::array::from_fn(|lane| rays.packs(packet, lane));
        traverse_in_turn(
            &self.nodes,
            &boxes,
            rays.there(),
            order,
            limits,
            #[inline(always)]
            |inside| self.touch(inside),
            #[inline(always)]
            |lane, met, limit| leaf(lane, &packs[lane], met, limit),
        );
    }

    /// Reads from each cache line of what will be visited soon.
    #[inline(always)]
    fn touch(&self, inside: Inside) -> u32 {
        if let Some(number) = inside.as_node() {
            let Some(WideNode { sides, inside }) = self.nodes.get(number) else { return 0 };
            let [x, y, z] = sides.map(
                #[inline(always)]
                |of_axis| of_axis[0][0].to_bits(),
            );
            x ^ y ^ z ^ inside[0].bits()
        } else {
            let Some(pack) = self.packs.get(inside.as_leaf().0) else { return 0 };
            let [a, b, c] = &pack.vertices;
            a[0][0].to_bits() ^ b[1][0].to_bits() ^ c[2][0].to_bits() ^ pack.extent.to_bits()
        }
    }

    /// The nearest of the candidates of eight rays.
    #[inline(always)]
    fn nearest_of<S: Simd>(
        &self,
        simd: S,
        packet: &RayPacket,
        limit: &[f32; LANES],
        searches: &mut [Search; LANES],
    ) -> NearestPacket<S> {
        let exact = TriangleRays::new(simd, packet);
        let mut nearest = NearestPacket::none(simd, packet);
        let mut corners = [[[0.0; LANES]; 3]; 3];
        let has_some = |lane: &usize| !searches[*lane].candidates.is_empty();
        let mut open = (0..LANES).filter(has_some).fold(0, |open, lane| open | 1 << lane);
        while open != 0 {
            let mut primitive = [HitPacket::NOTHING; LANES];
            for lane in each_lane(open) {
                let candidates = &mut searches[lane].candidates;
                if let Some(candidate) = candidates.pop()
                    && candidate.from <= limit[lane]
                {
                    let (pack, place) = self.pack_of(candidate.at);
                    primitive[lane] = pack.primitives[place % PACK];
                    for (corner, vertex) in corners.iter_mut().zip(&pack.vertices) {
                        corner[0][lane] = vertex[0][place % PACK];
                        corner[1][lane] = vertex[1][place % PACK];
                        corner[2][lane] = vertex[2][place % PACK];
                    }
                }
                open &= !(u32::from(candidates.is_empty()) << lane);
            }
            let primitive: u32x8<S> = primitive.simd_into(simd);
            if primitive.simd_ne(u32x8::splat(simd, HitPacket::NOTHING)).any_true() {
                exact.meet(&corners, primitive, &mut nearest);
            }
        }
        nearest
    }

    /// Decides among the candidates of eight rays.
    #[inline(always)]
    fn decide<S: Simd>(
        &self,
        rays: &RaysReady<S>,
        packet: &RayPacket,
        limit: &[f32; LANES],
        searches: &mut [Search; LANES],
    ) -> HitPacket {
        let nearest = self.nearest_of(rays.boxes.simd, packet, limit, searches);
        let mut hits = nearest.finished();
        for (lane, search) in searches.iter().enumerate() {
            if let Some(other) = search.nearest {
                let found = (nearest.t[lane], Turn::alone(nearest.primitive[lane]));
                if (other.t, other.turn) < found {
                    hits.set(lane, self.finish(&packet.ray(lane), other, search.custom).as_ref());
                }
            }
        }
        hits
    }

    /// Which of eight rays are blocked.
    #[inline(always)]
    fn blocked_of<S: Simd>(&self, simd: S, packet: &RayPacket) -> u32 {
        let gone = f32x8::splat(simd, f32::NEG_INFINITY);
        let rays = RaysReady::new(simd, packet);
        if self.goes_apart(&rays) {
            return self.blocked_in_turn(&rays, packet);
        }
        let mut searches: [Search; LANES] = Default::default();
        let mut limit = rays.limit;
        let mut blocked = 0;
        traverse_packet(
            &self.nodes,
            &rays.boxes,
            &mut limit,
            #[inline(always)]
            |visit: Visit<S>, limit| {
                let (first, all) = self.packs_of(visit.inside);
                let together =
                    visit.inside.as_node().is_none() && !all.is_empty() && visit.together(all);
                if !together {
                    for lane in each_lane(visit.mask) {
                        let from = (visit.inside, visit.enter[lane]);
                        let (boxes, packs) = (rays.boxes.one(lane), rays.packs(packet, lane));
                        let ray = packet.ray(lane);
                        if self.blocked_from(&boxes, &packs, &ray, from, limit[lane]) {
                            blocked |= 1 << lane;
                            limit[lane] = f32::NEG_INFINITY;
                        }
                    }
                    return;
                }
                for (i, pack) in all.iter().enumerate() {
                    for lane in 0..pack.len() {
                        let sorted = rays.sort_out(pack, lane, visit.enter, *limit);
                        let mut may = sorted.may.to_bitmask() as u32 & visit.mask & !blocked;
                        if may == 0 {
                            continue;
                        }
                        may &= !rays.leaving(pack.primitives[lane % PACK]);
                        let sure = sorted.sure.to_bitmask() as u32 & may;
                        blocked |= sure;
                        *limit = mask32x8::from_bitmask(simd, u64::from(sure)).select(gone, *limit);
                        // What is not certain waits until the others are done.
                        let at = ((first + i) * PACK + lane) as u32;
                        for ray in each_lane(may & !sure) {
                            let candidate = Candidate { at, from: f32::NEG_INFINITY };
                            let search = &mut searches[ray];
                            self.note(candidate, &packet.ray(ray), f32::INFINITY, search);
                            if search.nearest.is_some() {
                                blocked |= 1 << ray;
                                limit[ray] = f32::NEG_INFINITY;
                            }
                        }
                    }
                }
            },
        );
        let mut open = false;
        for (lane, search) in searches.iter_mut().enumerate() {
            if blocked >> lane & 1 == 1 {
                search.candidates.clear();
            }
            open |= !search.candidates.is_empty();
        }
        if open {
            let nearest = self.nearest_of(simd, packet, &[f32::INFINITY; LANES], &mut searches);
            let none = u32x8::splat(simd, HitPacket::NOTHING);
            blocked |= nearest.primitive.simd_ne(none).to_bitmask() as u32;
        }
        blocked
    }

    /// Where exactly, in double precision; rounded once at the end.
    fn finish(&self, ray: &Ray, nearest: Nearest, custom: Option<CustomHit>) -> Option<Hit> {
        let Nearest { t, turn, primitive, uv: [u, v] } = nearest;
        let instance = turn.instance();
        let surface = match instance {
            Some(instance) => Primitive::Triangle(self.triangle_of_instance(instance, primitive)),
            None => self.primitive(primitive),
        };
        let (position, normal, [u, v]) = match surface {
            Primitive::Triangle(corners) => {
                let [a, b, c] = corners.map(Vec3::as_dvec3);
                let position = a + (b - a) * u + (c - a) * v;
                (position, unit(triangle_normal(corners)), [u as f32, v as f32])
            }
            Primitive::Sphere(sphere) => {
                let (position, normal) = sphere.surface_at(ray, t);
                (position, normal, Sphere::uv(normal.as_vec3()))
            }
            Primitive::Disk(disk) => (disk.point(u, v), unit(disk.normal()), [u as f32, v as f32]),
            Primitive::Custom(_) => {
                let hit = custom?;
                (hit.position, hit.normal, [u as f32, v as f32])
            }
        };
        let (position, normal) = (position.as_vec3(), normal.as_vec3());
        Some(Hit { primitive, instance, t: t as f32, u, v, position, normal })
    }

    /// The primitives of a leaf that are met one by one.
    #[inline(always)]
    fn singles_of(&self, leaf: Met) -> &[u32] {
        match leaf.inside.as_leaf() {
            (number, 0) => &self.singles[self.others[number].clone()],
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
        let turn = Turn::alone(primitive);
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
                if (Nearest { t: hit.t, turn, primitive, uv: hit.uv }).keep(nearest) {
                    *said = Some(hit);
                }
                return;
            }
        };
        Nearest { t, turn, primitive, uv }.keep(nearest);
    }

    /// Meets the triangles of an instance, and keeps the nearest hit. What lies beyond `reach` need
    /// not be found.
    #[inline(never)]
    fn meet_instance(&self, ray: &Ray, i: u32, reach: f64, nearest: &mut Option<Nearest>) {
        let turn = Turn::within(i, self.instances()[i as usize].after);
        let exact = TriangleRay::new(ray);
        let reach = nearest.map_or(reach, |nearest| reach.min(nearest.t));
        self.each_in_instance(
            ray,
            i,
            Order::Nearest,
            reach,
            #[inline(always)]
            |primitive, [a, b, c]| {
                if let Some(hit) = exact.intersect(a, b, c) {
                    Nearest { t: hit.t, turn, primitive, uv: [hit.u, hit.v] }.keep(nearest);
                }
                match nearest {
                    Some(nearest) => nearest.t,
                    None => f64::INFINITY,
                }
            },
        );
    }

    /// Whether a ray meets anything in an instance.
    #[inline(never)]
    fn instance_blocks(&self, ray: &Ray, i: u32) -> bool {
        let exact = TriangleRay::new(ray);
        let mut blocked = false;
        self.each_in_instance(
            ray,
            i,
            Order::Any,
            f64::INFINITY,
            #[inline(always)]
            |_, [a, b, c]| {
                blocked = exact.intersect(a, b, c).is_some();
                if blocked { ENOUGH } else { f64::INFINITY }
            },
        );
        blocked
    }

    /// Calls `look_at` for every triangle of an instance that the ray may meet before `reach`, with
    /// its number and its corners in the world. It says how far the ray reaches from then on.
    fn each_in_instance(
        &self,
        ray: &Ray,
        i: u32,
        order: Order,
        reach: f64,
        look_at: impl FnMut(u32, [Vec3; 3]) -> f64,
    ) {
        with_vectors!(
            self.level,
            simd => self.each_in_instance_with(simd, ray, i, order, reach, look_at),
            else self.each_in_instance_with(Fallback::new(), ray, i, order, reach, look_at)
        );
    }

    #[inline(always)]
    fn each_in_instance_with<S: Simd>(
        &self,
        simd: S,
        ray: &Ray,
        i: u32,
        order: Order,
        reach: f64,
        mut look_at: impl FnMut(u32, [Vec3; 3]) -> f64,
    ) {
        let instance = &self.instances()[i as usize];
        let mesh = self.mesh_of(instance);
        let Some(entered) = instance.enter(mesh, ray, reach) else { return };
        let (origin, direction) = (entered.origin, entered.direction);
        let boxes = RoomyBoxRay::new(simd, origin, direction, entered.room);
        let axes = turned(direction);
        let along = Vec3::from_array(axes.map(|axis| direction[axis]));
        let shear = Vec3::new(along.x / along.z, along.y / along.z, 1.0 / along.z);
        let ends = [0.0, f32::INFINITY];
        let packs = PackRay::turned(simd, axes, origin, shear, ends, HitPacket::NOTHING);
        let longer = entered.longer_way();
        let mut limit = entered.limit_of(reach.min(f64::from(ray.t_max)));
        let root = (Inside::node(0), 0.0);
        traverse(
            &mesh.nodes,
            &boxes,
            order,
            root,
            &mut limit,
            #[inline(always)]
            |leaf, limit| {
                let (first, count) = leaf.inside.as_leaf();
                for pack in mesh.packs.get(first..first + count).unwrap_or_default() {
                    let mut may = packs.meet(pack, leaf.way + longer, *limit).may.to_bitmask();
                    while may != 0 {
                        let lane = may.trailing_zeros() as usize % PACK;
                        may &= may - 1;
                        let corners = instance.placed(pack.triangle(lane));
                        let reach = look_at(pack.primitives[lane], corners);
                        if reach == ENOUGH {
                            return true;
                        }
                        *limit = limit.min(entered.limit_of(reach));
                    }
                }
                false
            },
        );
    }

    /// Every surface that the ray meets at the same place as `hit`, in no order to rely on: the
    /// number of its instance, if it is of one, its own number, and whether the ray comes from its
    /// front. The same place means: between `before`
    /// and `beyond`, points next to the hit on its two sides. `hit` itself is among them.
    ///
    /// Of surfaces that touch a ray meets just one, and the next ray starts beyond all of them:
    /// this tells of the others.
    pub fn at_the_same_place(
        &self,
        ray: &Ray,
        hit: &Hit,
        [before, beyond]: [Vec3; 2],
        mut met: impl FnMut(Option<u32>, u32, bool),
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
        self.each_near(&near, Order::Any, &mut |instance, primitive, surface| {
            let surface = match surface {
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
                met(instance, primitive, normal.dot(direction) < 0.0);
            }
            f64::INFINITY
        });
    }

    /// Calls `look_at` for one primitive, or for those of an instance that the ray may meet before
    /// `reach`.
    #[inline(never)]
    fn near_single(
        &self,
        ray: &Ray,
        number: u32,
        (order, reach): (Order, f64),
        look_at: &mut Look<'_>,
    ) -> f64 {
        if number & INSTANCE == 0 {
            return look_at(None, number, self.primitive(number));
        }
        let instance = number & !INSTANCE;
        let mut left = reach;
        self.each_in_instance(ray, instance, order, reach, |primitive, corners| {
            left = look_at(Some(instance), primitive, Primitive::Triangle(corners));
            left
        });
        left
    }

    /// Calls `look_at` for every primitive that the ray may meet. It says how far the ray reaches
    /// from then on.
    fn each_near(&self, ray: &Ray, order: Order, look_at: &mut Look<'_>) {
        with_vectors!(
            self.level,
            simd => self.each_near_with(simd, ray, order, look_at),
            else self.each_near_with(Fallback::new(), ray, order, look_at)
        );
    }

    #[inline(always)]
    fn each_near_with<S: Simd>(&self, simd: S, ray: &Ray, order: Order, look_at: &mut Look<'_>) {
        let Some(boxes) = BoxRay::new(simd, ray) else { return };
        let packs = PackRay::new(simd, ray, boxes.scale);
        let mut reach = f64::from(ray.t_max);
        let mut limit = limit_of(reach, boxes.scale);
        let root = (Inside::node(0), 0.0);
        traverse(
            &self.nodes,
            &boxes,
            order,
            root,
            &mut limit,
            #[inline(always)]
            |leaf, limit| {
                for pack in self.packs_of(leaf.inside).1 {
                    let may = packs.meet(pack, leaf.way, *limit).may.to_bitmask() as u32;
                    for lane in each_lane(may) {
                        let (number, corners) = (pack.primitives[lane % PACK], pack.triangle(lane));
                        reach = reach.min(look_at(None, number, Primitive::Triangle(corners)));
                    }
                }
                for number in self.singles_of(leaf) {
                    reach = reach.min(self.near_single(ray, *number, (order, reach), look_at));
                }
                *limit = limit.min(limit_of(reach, boxes.scale));
                false
            },
        );
    }
}

/// What is done with a primitive, which has the number of its instance, if it is of one, and its
/// own.
type Look<'a> = dyn FnMut(Option<u32>, u32, Primitive<'_>) -> f64 + 'a;

/// Nothing else need be looked at.
const ENOUGH: f64 = f64::NEG_INFINITY;

/// The same direction with length one. Scaled first: squares of tiny areas would vanish.
fn unit(n: DVec3) -> DVec3 {
    let n = n / n.abs().max_element();
    n / n.length()
}
