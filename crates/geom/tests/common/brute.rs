//! Hits by other means: every primitive in turn, by textbook formulas in double
//! precision, each with a bound of its own rounding error.

use glam::DVec3;
use rutilant_geom::{Disk, Hit, Ray, Sphere, Surfaces, Vec3};

/// What the textbook says about a ray and a primitive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Verdict {
    Miss,
    /// At `t`, give or take `error`.
    Hit {
        t: f64,
        error: f64,
    },
    /// Too near to an edge, to the plane or to an end of the ray to tell.
    Unsure,
}

/// Three-valued truth: `x` is above zero for sure, below for sure, or `None`.
fn positive(x: f64, error: f64) -> Option<bool> {
    if x > error {
        Some(true)
    } else if x < -error {
        Some(false)
    } else {
        None
    }
}

fn verdict(t: f64, error: f64, ray: &Ray, mut inside: Vec<Option<bool>>) -> Verdict {
    inside.push(positive(t - f64::from(ray.t_min), error));
    if ray.t_max.is_finite() {
        inside.push(positive(f64::from(ray.t_max) - t, error));
    }
    if inside.contains(&Some(false)) {
        Verdict::Miss
    } else if inside.contains(&None) || t.is_nan() {
        Verdict::Unsure
    } else {
        Verdict::Hit { t, error }
    }
}

/// Rounding, with room for a dozen operations.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Möller and Trumbore, "Fast, Minimum Storage Ray-Triangle Intersection", 1997.
fn triangle([a, b, c]: [DVec3; 3], ray: &Ray) -> Verdict {
    let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let (e1, e2, s) = (b - a, c - a, o - a);
    let size = |vectors: [DVec3; 3]| vectors.iter().map(|v| v.length()).product::<f64>();
    let (p, q) = (d.cross(e2), s.cross(e1));
    let det = e1.dot(p);
    let det_error = ROUNDING * size([d, e1, e2]);
    if det.abs() <= 4.0 * det_error {
        // Seen edge-on: a miss if the whole triangle is to one side, else who knows.
        return Verdict::Unsure;
    }
    let relative = det_error / det.abs();
    let (u, v, t) = (s.dot(p) / det, d.dot(q) / det, e2.dot(q) / det);
    let error = |vectors, value: f64| ROUNDING * size(vectors) / det.abs() + relative * value.abs();
    let (u_error, v_error) = (error([s, d, e2], u), error([d, s, e1], v));
    let inside = vec![
        positive(u, u_error),
        positive(v, v_error),
        positive(1.0 - u - v, u_error + v_error + ROUNDING),
    ];
    verdict(t, error([e2, s, e1], t), ray, inside)
}

/// The quadratic formula of school: the first hit from outside, the second from inside.
fn sphere(sphere: &Sphere, ray: &Ray) -> Verdict {
    let f = ray.origin.as_dvec3() - sphere.center.as_dvec3();
    let d = ray.direction.as_dvec3();
    let r = f64::from(sphere.radius);
    let (a, b, c) = (d.dot(d), 2.0 * f.dot(d), f.dot(f) - r * r);
    let discriminant = b * b - 4.0 * a * c;
    let size = 4.0 * a * (f.dot(f) + r * r);
    match positive(discriminant, ROUNDING * size) {
        None => return Verdict::Unsure,
        Some(false) => return Verdict::Miss,
        Some(true) => {}
    }
    let root = discriminant.sqrt();
    // The error of the root, by the derivative of the square root.
    let error = (ROUNDING * size / root + ROUNDING * size.sqrt()) / a;
    let both = [(-b - root) / (2.0 * a), (-b + root) / (2.0 * a)];
    match both.map(|t| verdict(t, error, ray, vec![])) {
        [Verdict::Miss, second] => second,
        [first, _] => first,
    }
}

/// The plane first, then the place in it by a 2 × 2 system of scalar products.
fn disk(disk: &Disk, ray: &Ray) -> Verdict {
    let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let (c, u, v) = (disk.center.as_dvec3(), disk.u.as_dvec3(), disk.v.as_dvec3());
    let n = u.cross(v);
    let below = n.dot(d);
    let below_error = ROUNDING * n.length() * d.length();
    if below.abs() <= 4.0 * below_error {
        return Verdict::Unsure;
    }
    let t = n.dot(c - o) / below;
    let t_error = (ROUNDING * n.length() * (c - o).length() + t.abs() * below_error) / below.abs();
    let p = (o - c) + d * t;
    let (uu, uv, vv, pu, pv) = (u.dot(u), u.dot(v), v.dot(v), p.dot(u), p.dot(v));
    let det = uu * vv - uv * uv;
    let (a, b) = ((pu * vv - pv * uv) / det, (pv * uu - pu * uv) / det);
    let shift = t_error * d.length() + ROUNDING * (o - c).length();
    let error = 4.0
        * (1.0 + a.abs() + b.abs())
        * (uu + vv)
        * (shift * (uu + vv).sqrt() + ROUNDING * (uu + vv))
        / det;
    verdict(t, t_error, ray, vec![positive(1.0 - a * a - b * b, error)])
}

/// What the textbook says about a ray and the primitive number `i`.
pub(crate) fn primitive(scene: &Surfaces, i: usize, ray: &Ray) -> Verdict {
    let (triangles, spheres) = (scene.triangles().len(), scene.spheres().len());
    if i < triangles {
        triangle(scene.triangle(i as u32).map(Vec3::as_dvec3), ray)
    } else if i < triangles + spheres {
        sphere(&scene.spheres()[i - triangles], ray)
    } else {
        disk(&scene.disks()[i - triangles - spheres], ray)
    }
}

/// Checks one answer against the textbook. Gives whether the textbook was sure;
/// panics where it was, and the answer is another.
pub(crate) fn check(name: &str, scene: &Surfaces, ray: &Ray, hit: Option<&Hit>) -> bool {
    let count = scene.triangles().len() + scene.spheres().len() + scene.disks().len();
    let rounding = |t: f64| t.abs() * f64::from(f32::EPSILON);
    let mut sure = true;
    for i in 0..count {
        match (primitive(scene, i, ray), hit) {
            (Verdict::Miss, Some(hit)) => {
                assert!(hit.primitive as usize != i, "{name}: {hit:?} is a miss, {ray:?}");
            }
            (Verdict::Hit { t, error }, Some(hit)) => {
                let got = f64::from(hit.t);
                assert!(
                    got <= t + error + rounding(t),
                    "{name}: {hit:?} is not the first of {ray:?}, {i} at {t} ± {error}"
                );
                if hit.primitive as usize == i {
                    assert!(
                        got >= t - error - rounding(t),
                        "{name}: {hit:?} is not at {t} ± {error}, {ray:?}"
                    );
                }
            }
            (Verdict::Hit { t, .. }, None) => {
                panic!("{name}: {ray:?} lost {i} at {t}");
            }
            (Verdict::Unsure, Some(hit)) => sure &= hit.primitive as usize != i,
            (Verdict::Unsure, None) => sure = false,
            (Verdict::Miss, None) => {}
        }
    }
    sure
}
