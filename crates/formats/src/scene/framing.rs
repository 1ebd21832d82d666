//! A camera for a scene that has none.

use crate::camera::{AuthoredCamera, FocusOn};
use crate::error::SceneError;
use rutilant::camera::Camera;
use rutilant::scene::Scene;
use rutilant::shape::Shape;
use rutilant_geom::{Aabb, Transform, Vec3};
use std::path::Path;

/// From the middle of what there is towards the eye: the front and the right side at
/// unequal angles, a little from above. This is what illustrators call a three-quarter view.
const TOWARDS_EYE: Vec3 = Vec3::new(0.55, 0.4, 1.0);
/// Vertical field of view; a narrow one bends perspective less.
const FOV_DEGREES: f32 = 35.0;
/// Air around the bounds.
const MARGIN: f32 = 1.05;

/// A camera that was chosen.
pub(super) struct Chosen {
    /// In words.
    pub(super) authored: AuthoredCamera,
    /// The same.
    pub(super) camera: Camera,
}

/// Why no camera sees everything.
pub(super) enum Unseen {
    /// There is nothing to see.
    Nothing,
    /// See [`TOO_LARGE`].
    TooLarge,
}

/// Said of what no camera can see as a whole.
pub(super) const TOO_LARGE: &str = "it is too large: a camera that sees all of it would be farther away than single precision \
     reaches";

/// The camera that sees all of the scene in the file at `path`, in words.
pub(super) fn seen_whole(
    scene: &Scene,
    size: [u32; 2],
    path: &Path,
) -> Result<AuthoredCamera, SceneError> {
    let chosen = frame_all(scene, size).map_err(|why| match why {
        Unseen::Nothing => SceneError::invalid_file(path, "there is nothing to see in it"),
        Unseen::TooLarge => SceneError::invalid_file(path, TOO_LARGE),
    })?;
    Ok(chosen.authored)
}

/// A camera that sees all objects in a picture of `size` pixels.
pub(super) fn frame_all(scene: &Scene, size: [u32; 2]) -> Result<Chosen, Unseen> {
    let bounds = bounds_of_all(scene);
    if bounds.is_empty() {
        return Err(Unseen::Nothing);
    }
    // A sphere around the bounds fits where the picture is narrowest.
    let radius = bounds.max.distance(bounds.center());
    let radius = if radius > 0.0 { radius } else { 1.0 };
    let fov_y = FOV_DEGREES.to_radians();
    let [width, height] = size.map(|side| side.max(1) as f32);
    let half_height = rutilant_geom::real::tan(0.5 * fov_y);
    let narrowest = half_height * (width / height).min(1.0);
    let sine = narrowest / (1.0 + narrowest * narrowest).sqrt();
    let distance = MARGIN * radius / sine;
    let eye = bounds.center() + TOWARDS_EYE.normalize() * distance;
    let mut authored = AuthoredCamera::perspective(eye, bounds.center(), FOV_DEGREES);
    if let Some(lens) = authored.kind.lens_mut() {
        lens.focus = FocusOn::Distance(eye.distance(bounds.center()));
    }
    let camera = authored.camera(size).map_err(|_| Unseen::TooLarge)?;
    Ok(Chosen { authored, camera })
}

/// The pixel on a side of `new` pixels that is where `pixel` is on one of `old`.
pub(super) fn rescaled(pixel: u32, old: u32, new: u32) -> u32 {
    let (pixel, old, new) = (u64::from(pixel), u64::from(old.max(1)), u64::from(new));
    u32::try_from((pixel * new + old / 2) / old).unwrap_or(u32::MAX)
}

/// The box around all objects in the world.
fn bounds_of_all(scene: &Scene) -> Aabb {
    let meshes: Vec<_> = scene.meshes.iter().map(|m| bounds_of(&m.positions)).collect();
    scene.objects.iter().fold(Aabb::EMPTY, |all, object| {
        let centered = |half: Vec3| Aabb { min: -half, max: half };
        let local = match &object.shape {
            Shape::Mesh(id) => meshes.get(id.0 as usize).copied().unwrap_or(Aabb::EMPTY),
            Shape::Sphere { radius } => centered(Vec3::splat(*radius)),
            Shape::Rectangle { size } => centered((0.5 * *size).extend(0.0)),
            Shape::Disk { radius } => centered(Vec3::new(*radius, *radius, 0.0)),
            Shape::Box { size } => centered(0.5 * *size),
            Shape::Custom(shape) => shape.bounds(),
        };
        all.union(moved(local, &object.world_from_object))
    })
}

/// The box around some points; those that are not finite do not count.
pub(super) fn bounds_of(points: &[Vec3]) -> Aabb {
    Aabb::around(points.iter().copied().filter(|p| p.is_finite()))
}

/// The box around a moved box.
fn moved(b: Aabb, map: &Transform) -> Aabb {
    if b.is_empty() {
        return b;
    }
    Aabb::around((0..8).map(|i| {
        let pick = |bit: u32, low: f32, high: f32| if i & bit == 0 { low } else { high };
        map.point(Vec3::new(
            pick(1, b.min.x, b.max.x),
            pick(2, b.min.y, b.max.y),
            pick(4, b.min.z, b.max.z),
        ))
    }))
}
