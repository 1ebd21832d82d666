//! The meshes of `scenes/nested-dielectrics.toml`: a tumbler, water, an ice cube and a straw.
//!
//! ```sh
//! cargo run --release -p rutilant-formats --example drink -- scenes/meshes
//! ```
//!
//! All are closed. The water is a body of its own that reaches a millimetre into the wall and the
//! bottom of the tumbler, as people model it; which of the two is there is told by priorities.
//! Lengths are metres, y is up.

use rutilant_geom::{Vec2, Vec3, real};
use std::f32::consts::{FRAC_PI_2, PI};
use std::fmt::Write as _;
use std::path::Path;

/// How tall the tumbler is.
const HEIGHT: f32 = 0.105;
/// How thick its wall is; the rim is a half circle of it.
const WALL: f32 = 0.0026;
/// How thick its bottom is.
const BOTTOM: f32 = 0.011;
/// How high the water stands.
const LEVEL: f32 = 0.078;
/// How far the water reaches into the glass.
const OVERLAP: f32 = 0.001;
/// Corners around an axis.
const AROUND: usize = 72;

fn main() -> std::io::Result<()> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| "scenes/meshes".into());
    let write = |name: &str, obj: String| std::fs::write(Path::new(&folder).join(name), obj);
    write("tumbler.obj", lathe(&tumbler()))?;
    write("water.obj", lathe(&water()))?;
    write("straw.obj", lathe(&straw()))?;
    write("ice.obj", ice(7))
}

/// Radius of the outside at a height: a little wider above.
fn outside(y: f32) -> f32 {
    0.033 + 0.006 * y / HEIGHT
}

/// A part of a circle around `center`, from one angle to another, counter-clockwise from +x.
fn arc(center: Vec2, radius: f32, from: f32, to: f32, steps: u16) -> Vec<Vec2> {
    let point = |i: u16| {
        let (s, c) = real::sin_cos(from + (to - from) * f32::from(i) / f32::from(steps));
        center + radius * Vec2::new(c, s)
    };
    (0..=steps).map(point).collect()
}

/// From the middle of the foot along the outside to the rim, and back along the inside.
fn tumbler() -> Vec<Vec2> {
    let (foot, inner) = (0.004, 0.007);
    let inside = outside(BOTTOM) - WALL;
    let rim = Vec2::new(outside(HEIGHT) - 0.5 * WALL, HEIGHT - 0.5 * WALL);
    [
        vec![Vec2::ZERO],
        arc(Vec2::new(outside(0.0) - foot, foot), foot, -FRAC_PI_2, 0.0, 6),
        arc(rim, 0.5 * WALL, 0.0, PI, 8),
        arc(Vec2::new(inside - inner, BOTTOM + inner), inner, 0.0, -FRAC_PI_2, 8),
        vec![Vec2::new(0.0, BOTTOM)],
    ]
    .concat()
}

/// The inside of the tumbler and a little more.
fn water() -> Vec<Vec2> {
    let (inner, more) = (0.007, OVERLAP);
    let inside = |y: f32| outside(y) - WALL + more;
    [
        vec![Vec2::new(0.0, BOTTOM - more)],
        arc(
            Vec2::new(inside(BOTTOM) - inner - more, BOTTOM + inner),
            inner + more,
            -FRAC_PI_2,
            0.0,
            8,
        ),
        vec![Vec2::new(inside(LEVEL), LEVEL), Vec2::new(0.0, LEVEL)],
    ]
    .concat()
}

/// A tube; the profile comes back to where it began, off the axis.
fn straw() -> Vec<Vec2> {
    let (thick, thin, length) = (0.0034, 0.003, 0.15);
    [(thick, 0.0), (thick, length), (thin, length), (thin, 0.0), (thick, 0.0)]
        .map(|(r, y)| Vec2::new(r, y))
        .to_vec()
}

/// Turns a profile of (radius, height), which has its outside to the right, around the y axis.
fn lathe(profile: &[Vec2]) -> String {
    let mut obj = String::new();
    // Each point is a ring, or one vertex on the axis; the number of its first vertex, from 1.
    let mut rings = Vec::new();
    let mut count = 0;
    for (i, p) in profile.iter().enumerate() {
        if i + 1 == profile.len() && Some(p) == profile.first() && p.x > 0.0 {
            rings.push(1);
            continue;
        }
        rings.push(count + 1);
        let corners = if p.x > 0.0 { AROUND } else { 1 };
        for k in 0..corners {
            let (s, c) = real::sin_cos(2.0 * PI * k as f32 / AROUND as f32);
            let _ = writeln!(obj, "v {:.6} {:.6} {:.6}", p.x * c, p.y, p.x * s);
        }
        count += corners;
    }
    for (pair, from) in profile.windows(2).zip(rings.windows(2)) {
        let on_axis = [pair[0].x <= 0.0, pair[1].x <= 0.0];
        for k in 0..AROUND {
            let next = (k + 1) % AROUND;
            let [a, b] = [from[0], from[1]];
            let _ = match on_axis {
                [true, _] => writeln!(obj, "f {a} {} {}", b + k, b + next),
                [_, true] => writeln!(obj, "f {} {b} {}", a + k, a + next),
                [false, false] => {
                    writeln!(obj, "f {} {} {} {}", a + k, b + k, b + next, a + next)
                }
            };
        }
    }
    obj
}

/// A cube of side 1 with round edges, each face a grid: points of equal 8-norm.
fn ice(grid: usize) -> String {
    let mut obj = String::new();
    let mut known = Vec::<Vec3>::new();
    let mut faces = Vec::new();
    for (axis, sign) in (0..3).flat_map(|axis| [(axis, 1.0), (axis, -1.0)]) {
        let point = |i: usize, k: usize| {
            // Denser towards the edges, where it bends.
            let place = |i: usize| real::tan((i as f32 / grid as f32 - 0.5) * FRAC_PI_2);
            let mut p = Vec3::ZERO;
            p[axis] = sign;
            p[(axis + 1) % 3] = place(i) * sign;
            p[(axis + 2) % 3] = place(k);
            let eighth = p.to_array().map(|c| (c * c) * (c * c) * (c * c) * (c * c));
            p * 0.5 / eighth.iter().sum::<f32>().sqrt().sqrt().sqrt()
        };
        for (i, k) in (0..grid).flat_map(|i| (0..grid).map(move |k| (i, k))) {
            faces.push([(i, k), (i + 1, k), (i + 1, k + 1), (i, k + 1)].map(|(i, k)| {
                // Faces share the points along their edges.
                let p = point(i, k);
                let same = known.iter().position(|q| (*q - p).length() < 1e-4);
                same.unwrap_or_else(|| {
                    known.push(p);
                    known.len() - 1
                })
            }));
        }
    }
    for p in &known {
        let _ = writeln!(obj, "v {:.5} {:.5} {:.5}", p.x, p.y, p.z);
    }
    for [a, b, c, d] in faces {
        let _ = writeln!(obj, "f {} {} {} {}", a + 1, b + 1, c + 1, d + 1);
    }
    obj
}
