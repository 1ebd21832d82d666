//! Custom shapes: as good as the built-in ones, and harmless when they are not.

#![expect(clippy::unwrap_used, reason = "a test may")]

mod common;

use common::Random;
use rutilant_geom::{
    Aabb, BuildOptions, Custom, CustomHit, CustomRay, CustomShape, DVec3, Mat3, Ray, Sphere,
    Surfaces, Transform, Vec3, offset_origin,
};
use std::sync::Arc;

/// A sphere around its origin, met by the formula of school, in double precision.
#[derive(Debug)]
struct Ball(f64);

impl CustomShape for Ball {
    fn bounds(&self) -> Aabb {
        let r = Vec3::splat(self.0 as f32);
        Aabb { min: -r, max: r }
    }

    fn intersect(&self, ray: &CustomRay) -> Option<CustomHit> {
        let (o, d) = (ray.origin, ray.direction);
        let (a, b, c) = (d.dot(d), o.dot(d), o.dot(o) - self.0 * self.0);
        let on = c.abs() < 1e-14 * self.0 * self.0;
        let root = (b * b - a * if on { 0.0 } else { c }).max(0.0).sqrt();
        let missed = b * b < a * c;
        let found = [(-b - root) / a, (-b + root) / a];
        let t = found.into_iter().find(|&t| ray.holds(t) && !(on && t.abs() * a < 1e-9))?;
        let normal = ray.at(t).normalize();
        let hit = CustomHit { t, position: normal * self.0, normal: normal * 3.0, uv: [0.25, 7.0] };
        (!missed).then_some(hit)
    }
}

/// The same sphere by steps of its distance.
#[derive(Debug)]
struct Marched(f64);

impl CustomShape for Marched {
    fn bounds(&self) -> Aabb {
        Ball(self.0).bounds()
    }

    fn intersect(&self, ray: &CustomRay) -> Option<CustomHit> {
        let on = 1e-12 * self.0;
        let (start, end) = ray.within(&self.bounds())?;
        let (mut t, mut leaving) = (start, start == ray.t_min);
        for _ in 0..100_000 {
            let distance = (ray.at(t).length() - self.0).abs();
            leaving &= distance <= 4.0 * on;
            if distance <= on && !leaving {
                let normal = ray.at(t).normalize();
                let hit = CustomHit { t, position: normal * self.0, normal, uv: [0.0; 2] };
                return ray.holds(t).then_some(hit);
            }
            t += distance.max(on) / ray.direction.length();
            if t > end {
                return None;
            }
        }
        None
    }
}

fn with(customs: Vec<Custom>, spheres: Vec<Sphere>) -> Surfaces {
    Surfaces::with_custom(vec![], vec![], spheres, vec![], customs, &BuildOptions::default())
}

/// Turned, scaled, mirrored and moved, a custom sphere is met where the built-in one is, however
/// it finds its hits; and a ray that leaves it does not meet it again. A map that is applied in
/// single precision, a normal that is turned inside out by a mirror, or a `t` that counts in
/// other lengths shows here.
#[test]
fn custom_spheres_are_met_as_built_in_ones_are() {
    let random = &mut Random(11);
    let shapes: [Arc<dyn CustomShape>; 2] = [Arc::new(Ball(2.0)), Arc::new(Marched(2.0))];
    for (i, shape) in (0..40).flat_map(|i| shapes.iter().map(move |s| (i, s))) {
        let size = random.size(-3, 3);
        let center = random.point() * size * random.size(-2, 2);
        let mirror = if i % 2 == 0 { Vec3::ONE } else { Vec3::new(-1.0, 1.0, 1.0) };
        let place = Transform::translate(center)
            * Transform::rotate(random.direction(), random.between(-3.0, 3.0))
            * Transform::scale(mirror * size);
        let sphere = Sphere { center, radius: 2.0 * size };
        let custom = with(vec![Custom::new(Arc::clone(shape), &place)], vec![]);
        let built_in = with(vec![], vec![sphere]);
        let mut met = 0;
        for _ in 0..300 {
            let origin = center + random.point() * size * 6.0;
            let target = center + random.point() * size * 2.0;
            let ray = Ray::new(origin, (target - origin) * random.size(-2, 2));
            // So near to the rim that rounding decides: leave it out.
            let nearest = ray.direction.normalize().cross(center - origin).length();
            if (nearest / (2.0 * size) - 1.0).abs() < 1e-3 {
                continue;
            }
            let (a, b) = (custom.closest(&ray), built_in.closest(&ray));
            assert_eq!(a.is_some(), b.is_some(), "{ray:?}\n{a:?}\n{b:?}");
            assert_eq!(a.is_some(), custom.occluded(&ray));
            let (Some(a), Some(b)) = (a, b) else { continue };
            met += 1;
            assert!((a.t - b.t).abs() <= 1e-4 * b.t, "{ray:?}\n{a:?}\n{b:?}");
            assert!((a.normal - b.normal).length() < 1e-3, "{a:?}\n{b:?}");
            assert!((a.position - b.position).length() < 1e-3 * size, "{a:?}\n{b:?}");
            let out = (a.normal + random.direction() * 0.9).normalize();
            let away = Ray::new(offset_origin(a.position, a.normal, out), out);
            let again = custom.closest(&away);
            // A squeezed rotation is a sphere to single precision only: what is met again may
            // be met far away, never where the ray starts.
            assert!(again.is_none_or(|h| h.t > 1e-2 * size), "{a:?}\n{again:?}");
        }
        assert!(met > 50, "only {met} met");
    }
}

/// A shape that answers what it is told to.
#[derive(Debug)]
struct Says(Aabb, CustomHit);

impl CustomShape for Says {
    fn bounds(&self) -> Aabb {
        self.0
    }

    fn intersect(&self, _: &CustomRay) -> Option<CustomHit> {
        Some(self.1)
    }
}

/// Whatever a shape says that cannot be, it is not met, and what stands behind it is.
#[test]
fn nonsense_is_no_hit() {
    let bounds = Aabb { min: Vec3::splat(-1.0), max: Vec3::ONE };
    let good = CustomHit { t: 4.5, position: DVec3::Z * 0.5, normal: DVec3::Z, uv: [0.5; 2] };
    let ray = Ray { t_max: 9.0, ..Ray::new(Vec3::Z * 5.0, Vec3::NEG_Z) };
    let behind = Sphere { center: Vec3::Z * -3.0, radius: 1.0 };
    let met = |bounds: Aabb, hit: CustomHit, place: &Transform| {
        let shape = Custom::new(Arc::new(Says(bounds, hit)), place);
        let scene = with(vec![shape], vec![behind]);
        assert!(scene.occluded(&ray));
        let hit = scene.closest(&ray).unwrap();
        assert!(hit.normal.is_normalized() && hit.position.is_finite());
        hit.primitive == 1
    };
    let here = Transform::IDENTITY;
    assert!(met(bounds, good, &here));
    // Normals of any length are meant.
    for scale in [1e-300, 1e300] {
        assert!(met(bounds, CustomHit { normal: DVec3::Z * scale, ..good }, &here));
    }
    for t in [f64::NAN, f64::INFINITY, -1.0, 0.0, 9.0] {
        assert!(!met(bounds, CustomHit { t, ..good }, &here), "t = {t}");
    }
    for position in [DVec3::NAN, DVec3::Z * 1.1, DVec3::INFINITY] {
        assert!(!met(bounds, CustomHit { position, ..good }, &here), "{position}");
    }
    for normal in [DVec3::NAN, DVec3::ZERO, DVec3::INFINITY] {
        assert!(!met(bounds, CustomHit { normal, ..good }, &here), "{normal}");
    }
    for u in [f64::NAN, f64::INFINITY, 1e300] {
        assert!(!met(bounds, CustomHit { uv: [u, 0.0], ..good }, &here), "{u}");
    }
    let nan = Vec3::new(0.0, f32::NAN, 0.0);
    for min in [nan, Vec3::NEG_INFINITY, Vec3::splat(2.0)] {
        assert!(!met(Aabb { min, ..bounds }, good, &here), "{min}");
    }
    let flat = Transform::new(Mat3::from_diagonal(Vec3::new(1.0, 0.0, 1.0)), Vec3::ZERO);
    for place in [flat, Transform::translate(Vec3::MAX), Transform::scale(Vec3::splat(f32::MAX))] {
        assert!(!met(bounds, good, &place), "{place:?}");
    }
}

/// Of custom shapes that are met at the same distance the first counts, in whatever order the
/// tree comes to them.
#[test]
fn the_first_of_equal_custom_shapes_counts() {
    let bounds = Aabb { min: Vec3::splat(-1.0), max: Vec3::ONE };
    let shapes = (0..50).map(|i| {
        let hit =
            CustomHit { t: 5.0, position: DVec3::ZERO, normal: DVec3::Z, uv: [f64::from(i), 0.0] };
        Custom::new(Arc::new(Says(bounds, hit)), &Transform::IDENTITY)
    });
    let scene = with(shapes.collect(), vec![]);
    let hit = scene.closest(&Ray::new(Vec3::Z * 5.0, Vec3::NEG_Z)).unwrap();
    assert_eq!((hit.primitive, hit.u), (0, 0.0));
}

/// A ray that goes on from hit to hit comes to the far side of a custom shape, however that finds
/// its hits, and to everything behind it, and to an end.
#[test]
fn a_ray_goes_on_through_custom_shapes() {
    for shape in [Arc::new(Ball(1.5)) as Arc<dyn CustomShape>, Arc::new(Marched(1.5))] {
        let balls = [-5.0, 0.0, 5.0].map(|z| {
            Custom::new(Arc::clone(&shape), &Transform::translate(Vec3::new(0.3, -0.2, z)))
        });
        let scene = with(balls.to_vec(), vec![Sphere { center: Vec3::Z * 2.5, radius: 1.0 }]);
        let ray = Ray::new(Vec3::new(0.1, 0.2, 20.0), Vec3::NEG_Z);
        let first = scene.closest(&ray);
        let all = std::iter::successors(first, |hit| scene.closest_after(&ray, hit));
        let met: Vec<u32> = all.take(20).map(|hit| hit.primitive).collect();
        assert_eq!(met, [3, 3, 0, 0, 2, 2, 1, 1]);
    }
}
