//! Polygons to triangles, by ear clipping.
//!
//! A corner is an ear if the polygon turns left there and no other corner lies
//! in its triangle; an ear can be cut off, and what is left is a polygon again.
//! That is right for every simple polygon, convex or not, and for holes joined
//! to the outline by a seam. A polygon that crosses itself has no right answer;
//! it still becomes `n - 2` triangles.
//!
//! Source: Meisters, *Polygons Have Ears*, 1975; the projection is Newell's
//! (Sutherland, Sproull, Schumacker, 1974).

use rutilant_geom::Vec3;

/// Cuts polygons into triangles. One serves a whole file: it owns the scratch memory and
/// counts the work, so that a hostile file cannot ask for the square of its size.
pub(super) struct Triangulator {
    corners: Vec<[f64; 2]>,
    next: Vec<u32>,
    previous: Vec<u32>,
    reflex: Vec<u32>,
    work_left: u64,
    /// Polygons that were too large to be cut properly, given how many came before.
    pub(super) cut_short: u64,
}

/// Looks at a corner per file: enough for an outline of ten thousand corners, and done in less
/// than a second.
const MOST_WORK: u64 = 1 << 27;

impl Triangulator {
    pub(super) fn new() -> Self {
        Self {
            corners: Vec::new(),
            next: Vec::new(),
            previous: Vec::new(),
            reflex: Vec::new(),
            work_left: MOST_WORK,
            cut_short: 0,
        }
    }

    /// Calls `emit` with the corner numbers of each triangle; they run the way the polygon runs.
    ///
    /// `polygon` holds the positions of its corners in order; there are `polygon.len() - 2`
    /// triangles, or none for fewer than three corners.
    pub(super) fn triangulate(&mut self, polygon: &[Vec3], mut emit: impl FnMut([u32; 3])) {
        match polygon.len() {
            0..3 => {}
            3 => emit([0, 1, 2]),
            4 => {
                let triangles = if splits_at_second(polygon) {
                    [[0, 1, 3], [1, 2, 3]]
                } else {
                    [[0, 1, 2], [0, 2, 3]]
                };
                triangles.into_iter().for_each(emit);
            }
            _ => self.clip_ears(polygon, emit),
        }
    }

    fn clip_ears(&mut self, polygon: &[Vec3], mut emit: impl FnMut([u32; 3])) {
        // Look along the axis that sees most of the polygon, so that it runs counter-clockwise.
        let normal = newell_normal(polygon);
        let magnitude = normal.map(f64::abs);
        let axis = if magnitude[0] > magnitude[1] && magnitude[0] > magnitude[2] {
            0
        } else if magnitude[1] > magnitude[2] {
            1
        } else {
            2
        };
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let (u, v) = if normal[axis] < 0.0 { (v, u) } else { (u, v) };
        self.corners.clear();
        self.corners.extend(polygon.iter().map(|p| {
            let p = p.to_array().map(f64::from);
            [p[u], p[v]]
        }));

        // A ring of corners, and those that turn right: only they can lie inside an ear. A corner
        // that turns left keeps doing so when others are cut off.
        let count = polygon.len() as u32;
        self.next.clear();
        self.next.extend((0..count).map(|i| (i + 1) % count));
        self.previous.clear();
        self.previous.extend((0..count).map(|i| (i + count - 1) % count));
        let mut reflex = std::mem::take(&mut self.reflex);
        reflex.clear();
        reflex.extend((0..count).filter(|&i| self.turn(i) <= 0.0));

        let mut left = count;
        let mut corner = 0;
        let mut visited = 0;
        while left > 3 {
            // With no ear in a whole round the polygon crosses itself, or is flat: cut anywhere.
            let stuck = visited > left || self.work_left == 0;
            if !stuck && (self.turn(corner) <= 0.0 || self.blocked(corner, &mut reflex)) {
                corner = self.next[corner as usize];
                visited += 1;
                self.work_left = self.work_left.saturating_sub(1);
                continue;
            }
            let (before, after) = (self.previous[corner as usize], self.next[corner as usize]);
            emit([before, corner, after]);
            self.next[before as usize] = after;
            self.previous[after as usize] = before;
            // Out of the ring: corners point to themselves, and `blocked` forgets them.
            self.next[corner as usize] = corner;
            left -= 1;
            visited = 0;
            // Passing over a neighbour gives rounder triangles than a fan would have.
            corner = if self.work_left == 0 { after } else { self.next[after as usize] };
        }
        emit([self.previous[corner as usize], corner, self.next[corner as usize]]);
        self.reflex = reflex;
        self.cut_short += u64::from(self.work_left == 0);
    }

    /// Twice the signed area of the triangle at `corner`: positive for a left turn.
    fn turn(&self, corner: u32) -> f64 {
        let at = |i: u32| self.corners[i as usize];
        area(at(self.previous[corner as usize]), at(corner), at(self.next[corner as usize]))
    }

    /// Whether a corner of the polygon lies in the triangle at `corner`, border included.
    /// A corner at the very place of one of the triangle's does not count: seams have those.
    fn blocked(&mut self, corner: u32, reflex: &mut Vec<u32>) -> bool {
        let (before, after) = (self.previous[corner as usize], self.next[corner as usize]);
        let [a, b, c] = [before, corner, after].map(|i| self.corners[i as usize]);
        let (low, high) = (
            [a[0].min(b[0]).min(c[0]), a[1].min(b[1]).min(c[1])],
            [a[0].max(b[0]).max(c[0]), a[1].max(b[1]).max(c[1])],
        );
        self.work_left = self.work_left.saturating_sub(reflex.len() as u64 + 1);
        let mut i = 0;
        while i < reflex.len() {
            let other = reflex[i];
            if self.next[other as usize] == other {
                reflex.swap_remove(i); // It was cut off.
                continue;
            }
            let p = self.corners[other as usize];
            let outside_box = p[0] < low[0] || p[0] > high[0] || p[1] < low[1] || p[1] > high[1];
            if !outside_box
                && p != a
                && p != b
                && p != c
                && area(a, b, p) >= 0.0
                && area(b, c, p) >= 0.0
                && area(c, a, p) >= 0.0
            {
                if self.turn(other) > 0.0 {
                    reflex.swap_remove(i); // By now it turns left.
                    continue;
                }
                return true;
            }
            i += 1;
        }
        false
    }
}

/// Whether a quadrilateral is better cut from its second corner to its fourth: the diagonal
/// that lies inside, and the shorter one if both do.
fn splits_at_second(quad: &[Vec3]) -> bool {
    let [a, b, c, d] = [0, 1, 2, 3].map(|i| quad[i].to_array().map(f64::from));
    let normal = newell_normal(quad);
    let faces_us = |p, q, r| dot(cross(minus(q, p), minus(r, p)), normal) > 0.0;
    let first = faces_us(a, b, c) && faces_us(a, c, d);
    let second = faces_us(a, b, d) && faces_us(b, c, d);
    let length = |p, q| {
        let side = minus(q, p);
        dot(side, side)
    };
    second && (!first || length(b, d) < length(a, c))
}

/// A normal of a polygon that need not be flat; its length is twice the area. Coordinates count
/// from the first corner, so that nothing is lost far from the origin.
fn newell_normal(polygon: &[Vec3]) -> [f64; 3] {
    let origin = polygon[0].to_array().map(f64::from);
    let at = |i: usize| minus(polygon[i % polygon.len()].to_array().map(f64::from), origin);
    let mut normal = [0.0; 3];
    for i in 0..polygon.len() {
        let part = cross(at(i), at(i + 1));
        for axis in 0..3 {
            normal[axis] += part[axis];
        }
    }
    normal
}

fn area(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangles(polygon: &[Vec3]) -> Vec<[u32; 3]> {
        let mut all = Vec::new();
        Triangulator::new().triangulate(polygon, |t| all.push(t));
        all
    }

    fn flat(points: &[[f32; 2]]) -> Vec<Vec3> {
        points.iter().map(|p| Vec3::new(p[0], p[1], 0.0)).collect()
    }

    /// Signed areas of the triangles of a polygon in the x-y plane.
    fn areas(polygon: &[Vec3]) -> Vec<f64> {
        let at = |i: u32| {
            let p = polygon[i as usize];
            [f64::from(p.x), f64::from(p.y)]
        };
        triangles(polygon).iter().map(|t| 0.5 * area(at(t[0]), at(t[1]), at(t[2]))).collect()
    }

    fn assert_covers(polygon: &[Vec3]) {
        let areas = areas(polygon);
        let whole = 0.5 * newell_normal(polygon)[2];
        assert_eq!(areas.len(), polygon.len() - 2);
        assert!(areas.iter().all(|a| a * whole >= 0.0), "a triangle runs the other way: {areas:?}");
        let sum: f64 = areas.iter().sum();
        assert!((sum - whole).abs() <= 1e-6 * whole.abs(), "{sum} of {whole} covered");
    }

    /// Triangles of a simple polygon run its way and have its area, so they cover it without
    /// overlap. A fan from the first corner fails for the arrow, the comb, the spiral, the star.
    #[test]
    fn concave_polygons_are_covered_once() {
        let arrow = [[0.0, 0.0], [4.0, 2.0], [0.0, 4.0], [1.0, 2.0]];
        let comb: Vec<[f32; 2]> = (0..40)
            .map(|i| [i as f32, if i % 2 == 0 { 1.0 } else { 5.0 }])
            .chain([[39.0, 0.0], [0.0, 0.0]])
            .rev()
            .collect();
        let star: Vec<[f32; 2]> = (0..50)
            .map(|i| {
                let (angle, radius) = (i as f32 * 0.125_663_7, if i % 2 == 0 { 5.0 } else { 1.0 });
                [radius * angle.cos(), radius * angle.sin()]
            })
            .collect();
        let spiral: Vec<[f32; 2]> = (0..30)
            .map(|i| (i as f32 * 0.4, 1.0 + i as f32 * 0.2))
            .chain((0..30).rev().map(|i| (i as f32 * 0.4, 0.7 + i as f32 * 0.2)))
            .map(|(angle, radius)| [radius * angle.cos(), radius * angle.sin()])
            .rev()
            .collect();
        // A square with a square hole, joined by a seam.
        let holed = [
            [0.0, 0.0],
            [9.0, 0.0],
            [9.0, 9.0],
            [0.0, 9.0],
            [0.0, 0.0],
            [3.0, 3.0],
            [3.0, 6.0],
            [6.0, 6.0],
            [6.0, 3.0],
            [3.0, 3.0],
        ];
        // Corners in a straight line.
        let ruler = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0], [3.0, 1.0], [0.0, 1.0]];
        for points in [&arrow[..], &comb, &star, &spiral, &holed, &ruler] {
            let polygon = flat(points);
            assert_covers(&polygon);
            // From every first corner, and in the other direction.
            for turn in 0..polygon.len() {
                let mut turned = polygon.clone();
                turned.rotate_left(turn);
                assert_covers(&turned);
                turned.reverse();
                assert_covers(&turned);
            }
        }
    }

    /// A concave quadrilateral is cut at its reflex corner, a convex one along its shorter diagonal.
    #[test]
    fn quadrilaterals_are_cut_along_the_right_diagonal() {
        let first = vec![[0, 1, 2], [0, 2, 3]];
        let second = vec![[0, 1, 3], [1, 2, 3]];
        let arrow = [[0.0, 0.0], [4.0, 2.0], [0.0, 4.0], [1.0, 2.0]];
        assert_eq!(triangles(&flat(&arrow)), second);
        let kite = [[0.0, 0.0], [1.0, -1.0], [5.0, 0.0], [1.0, 1.0]];
        assert_eq!(triangles(&flat(&kite)), second);
        let turned = [[1.0, -1.0], [5.0, 0.0], [1.0, 1.0], [0.0, 0.0]];
        assert_eq!(triangles(&flat(&turned)), first);
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        assert_eq!(triangles(&flat(&square)), first);
    }

    /// Polygons without a right answer still end, with the right number of triangles.
    #[test]
    fn hopeless_polygons_still_end() {
        let nan = vec![Vec3::NAN; 9];
        let point = vec![Vec3::ONE; 9];
        let pentagram: Vec<Vec3> = (0..5)
            .map(|i| i as f32 * 2.513_274)
            .map(|angle| Vec3::new(angle.cos(), angle.sin(), 0.0))
            .collect();
        let huge: Vec<Vec3> =
            (0..7).map(|i| Vec3::new(f32::MAX, i as f32, f32::INFINITY)).collect();
        for polygon in [nan, point, pentagram, huge] {
            assert_eq!(triangles(&polygon).len(), polygon.len() - 2);
        }
    }
}
