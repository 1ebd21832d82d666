//! Shapes and materials of others' making give the pictures of the built-in ones.

mod common;

use common::{disagreement, render_with, settings};
use rutilant::bsdf::{Bsdf, Lambert, Lobe, PerfectMirror};
use rutilant::camera::Perspective;
use rutilant::color::{Rgb, Spectrum};
use rutilant::geom::{Aabb, DVec3, Transform, Vec2, Vec3};
use rutilant::image::Image;
use rutilant::light::Environment;
use rutilant::material::{
    Absorption, CustomMaterial, Dielectric, Emission, Matte, Mirror, SurfacePoint,
};
use rutilant::scene::{MaterialId, Scene};
use rutilant::settings::{IntegratorKind, Settings, Strategy};
use rutilant::shape::{CustomHit, CustomRay, CustomShape, Object, Shape};
use rutilant::{Prepared, Progress, Session};
use std::sync::Arc;
use std::time::Duration;

/// Nonsense.
#[derive(Debug)]
struct Broken;

impl CustomMaterial for Broken {
    fn bsdf(&self, _: &SurfacePoint) -> Bsdf {
        Lobe::Lambert(Lambert { albedo: Spectrum::splat(f32::NAN) }).into()
    }
}

/// Panics.
#[derive(Debug)]
struct Panicking;

impl CustomMaterial for Panicking {
    fn bsdf(&self, _: &SurfacePoint) -> Bsdf {
        panic!("on purpose");
    }
}

/// A ball of this material before an even sky, rendered to its end.
fn progress_of(material: Arc<dyn CustomMaterial>) -> Progress {
    let camera = Perspective::look_at(Vec3::Z * 4.0, Vec3::ZERO, 0.2).expect("two points");
    let mut scene = Scene::new(camera);
    scene.environment = Some(Environment::constant(Rgb::WHITE));
    let material = scene.add_material(material);
    scene.objects.push(Object::new(Shape::Sphere { radius: 1.0 }, material));
    let prepared = Arc::new(Prepared::new(&scene).expect("a sound scene"));
    let settings = Settings { size: [8, 8], spp: 4, ..Settings::default() };
    let session = Session::start(prepared, settings, 2).expect("sound settings");
    while !session.wait(Duration::from_secs(1)) {}
    session.progress()
}

/// A panic in what strangers wrote ends the rendering, and is told.
#[test]
fn panics_are_told() {
    let progress = progress_of(Arc::new(Panicking));
    assert!(progress.panicked && progress.samples < 4, "{progress:?}");
}

/// What a custom material gives that is no number is counted, and not taken for black.
#[test]
fn nonsense_is_counted() {
    let progress = progress_of(Arc::new(Broken));
    assert!(!progress.panicked);
    assert_eq!(progress.dropped.count, 8 * 8 * 4);
}

/// A ball of radius 1 by the quadratic formula.
#[derive(Debug)]
struct Ball;

/// The same by steps as long as the distance to the surface, which is its own Lipschitz bound.
#[derive(Debug)]
struct Marched;

fn box_of_ball() -> Aabb {
    Aabb { min: Vec3::NEG_ONE, max: Vec3::ONE }
}

fn hit_at(ray: &CustomRay, t: f64) -> Option<CustomHit> {
    let normal = ray.at(t).normalize();
    ray.holds(t).then_some(CustomHit { t, position: normal, normal, uv: [0.0; 2] })
}

impl CustomShape for Ball {
    fn bounds(&self) -> Aabb {
        box_of_ball()
    }

    fn intersect(&self, ray: &CustomRay) -> Option<CustomHit> {
        let (o, d) = (ray.origin, ray.direction);
        let (a, b, c) = (d.dot(d), o.dot(d), o.dot(o) - 1.0);
        if c.abs() < 1e-13 {
            // On the surface: only the other side is met.
            return hit_at(ray, -2.0 * b / a);
        }
        let discriminant = b * b - a * c;
        if discriminant < 0.0 {
            return None;
        }
        let root = discriminant.sqrt();
        hit_at(ray, (-b - root) / a).or_else(|| hit_at(ray, (-b + root) / a))
    }
}

impl CustomShape for Marched {
    fn bounds(&self) -> Aabb {
        box_of_ball()
    }

    fn intersect(&self, ray: &CustomRay) -> Option<CustomHit> {
        const ON: f64 = 1e-12;
        let distance = |p: DVec3| (p.length() - 1.0).abs();
        let (start, end) = ray.within(&self.bounds())?;
        let (mut t, mut leaving) = (start, start == ray.t_min);
        for _ in 0..10_000 {
            let d = distance(ray.at(t));
            leaving &= d <= 4.0 * ON;
            if d <= ON && !leaving {
                return hit_at(ray, t);
            }
            t += d.max(ON) / ray.direction.length();
            if t > end {
                return None;
            }
        }
        None
    }
}

fn looking(from: Vec3, to: Vec3) -> Scene {
    let mut scene = Scene::new(Perspective::look_at(from, to, 0.7).expect("two points"));
    scene.environment = Some(Environment::constant(Rgb::new(0.2, 0.3, 0.4)));
    scene
}

fn floor(scene: &mut Scene, material: MaterialId, side: f32, x: f32, z: f32) {
    let flat = Transform::rotate_degrees(Vec3::X, -90.0);
    let place = Transform::translate(Vec3::new(x, 0.0, z));
    let shape = Shape::Rectangle { size: Vec2::splat(side) };
    scene.objects.push(Object::new(shape, material).transformed(&(place * flat)));
}

/// A matte ball, one of coloured glass and one that glows, over a floor. It glows little brighter
/// than the sky: where light is found by chance alone, glints of a bright lamp are too rare for
/// scores to be normal.
fn balls(shape: &dyn Fn(f32) -> (Shape, Transform)) -> Scene {
    let mut s = looking(Vec3::new(0.0, 1.5, 5.0), Vec3::new(0.0, 0.6, 0.0));
    let white = s.add_material(Matte::new(Rgb::grey(0.7)));
    let mut glass = Dielectric::new(1.5);
    glass.interior.absorption = Absorption::Coefficient(Rgb::new(0.8, 0.2, 0.1));
    let glass = s.add_material(glass);
    let lamp = s.add_material(Emission::radiance(Rgb::new(1.5, 1.2, 0.9)));
    floor(&mut s, white, 8.0, 0.0, 0.0);
    for (material, x, radius) in [(white, -1.3, 0.6), (glass, 0.0, 0.65), (lamp, 1.4, 0.7)] {
        let (shape, own) = shape(radius);
        let place = Transform::translate(Vec3::new(x, 0.7, 0.0));
        s.objects.push(Object::new(shape, material).transformed(&(place * own)));
    }
    s
}

/// In every pixel a custom ball looks, refracts and glows as the built-in one does, solved or
/// marched, for every way of finding light; though light samples never find its light.
#[test]
fn custom_balls_are_balls() {
    let built_in = balls(&|radius| (Shape::Sphere { radius }, Transform::IDENTITY));
    let custom = |ball: Arc<dyn CustomShape>| {
        balls(&|radius| {
            // Mirrored and turned on the way, which a ball does not show.
            let own = Transform::rotate(Vec3::ONE, 1.0)
                * Transform::scale(Vec3::new(-radius, radius, radius));
            (Shape::Custom(Arc::clone(&ball)), own)
        })
    };
    let [solved, marched] = [custom(Arc::new(Ball)), custom(Arc::new(Marched))];
    let path = |strategy, seed| Settings {
        strategy,
        spp: 8192,
        ..settings(IntegratorKind::Path, None, seed)
    };
    let ways = [
        ("both", &solved, path(Strategy::Both, 1)),
        ("light", &solved, path(Strategy::LightOnly, 2)),
        ("bsdf", &solved, path(Strategy::BsdfOnly, 3)),
        ("naive", &solved, settings(IntegratorKind::Naive, None, 4)),
        ("marched", &marched, path(Strategy::Both, 5)),
    ];
    let reference = render_with(&built_in, path(Strategy::Both, 16));
    for (name, scene, way) in &ways {
        if let Some(worst) = disagreement(&reference, &render_with(scene, way.clone()), 6) {
            panic!("{name}: {worst}");
        }
    }
    // Direct light by a separate integrator.
    let two = render_with(&built_in, settings(IntegratorKind::Path, Some(2), 7));
    let direct = render_with(&marched, settings(IntegratorKind::Direct, None, 8));
    if let Some(worst) = disagreement(&two, &direct, 6) {
        panic!("direct: {worst}");
    }
}

/// Matte and mirror in turn, on squares of side 1.
#[derive(Debug)]
struct Checker;

impl CustomMaterial for Checker {
    fn bsdf(&self, point: &SurfacePoint) -> Bsdf {
        assert!((point.normal - Vec3::Y).length() < 1e-6, "{}", point.normal);
        if (point.position.x.floor() + point.position.z.floor()) % 2.0 == 0.0 {
            Lobe::Lambert(Lambert { albedo: Spectrum::splat(0.8) }).into()
        } else {
            Lobe::Mirror(PerfectMirror { reflectance: [0.9, 0.7, 0.5].into() }).into()
        }
    }
}

/// A checker of two BSDFs is the same as tiles of two materials.
#[test]
fn a_checker_is_tiles() {
    let room = || {
        let mut s = looking(Vec3::new(1.0, 2.5, 5.0), Vec3::new(0.0, 0.2, 0.0));
        let lamp = s.add_material(Emission::radiance(Rgb::new(3.0, 3.5, 4.0)));
        let place = Transform::translate(Vec3::new(0.3, 1.2, -0.8));
        s.objects.push(Object::new(Shape::Sphere { radius: 0.6 }, lamp).transformed(&place));
        s
    };
    let mut custom = room();
    let checker: Arc<dyn CustomMaterial> = Arc::new(Checker);
    let checker = custom.add_material(checker);
    floor(&mut custom, checker, 4.0, 0.0, 0.0);

    let mut tiles = room();
    let matte = tiles.add_material(Matte::new(Rgb::grey(0.8)));
    let mirror = tiles.add_material(Mirror { reflectance: Rgb::new(0.9, 0.7, 0.5) });
    for (x, z) in (-2..2).flat_map(|x| (-2..2).map(move |z| (x, z))) {
        let material = if (x + z) % 2 == 0 { matte } else { mirror };
        floor(&mut tiles, material, 1.0, x as f32 + 0.5, z as f32 + 0.5);
    }

    for (i, integrator) in [
        IntegratorKind::Path,
        IntegratorKind::Naive,
        IntegratorKind::Direct,
        IntegratorKind::Albedo,
    ]
    .into_iter()
    .enumerate()
    {
        let by = |scene: &Scene, seed| -> Image {
            render_with(scene, settings(integrator, None, seed + 2 * i as u64))
        };
        if let Some(worst) = disagreement(&by(&custom, 0), &by(&tiles, 1), 4) {
            panic!("{integrator:?}: {worst}");
        }
    }
}
