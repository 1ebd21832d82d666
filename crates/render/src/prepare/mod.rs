//! From what the author wrote to what can be traced: slow, once, and the last place that can fail.
//!
//! A [`Prepared`] scene is flat: arrays that point into each other by number.
//! Shapes become triangles, spheres, disks and custom surfaces in the world under one tree,
//! materials become BSDFs, everything that shines becomes an emitter.

mod assembly;
mod casters;
mod casting;
mod lacking;
mod material;
mod open;
mod painted;
mod prepared;
mod texture;
mod varying;

pub(crate) use casters::{Aim, Outlook};
pub(crate) use casting::Casting;
pub(crate) use material::PreparedMaterial;
pub use prepared::{PrepareReport, Prepared};

use crate::camera::Camera;
use crate::scene::{Scene, SceneProblem};
use assembly::Assembly;
use rutilant_geom::{BuildOptions, Simd};
use std::sync::Arc;

impl Prepared {
    /// Makes a scene traceable.
    ///
    /// # Errors
    /// What [`Scene::validate`] finds. Broken triangles are no error: they are left out, counted
    /// and reported.
    pub fn new(scene: &Scene) -> Result<Self, SceneProblem> {
        Self::with_options(scene, &BuildOptions::default())
    }

    /// The same with a say in how the tree is built.
    ///
    /// # Errors
    /// As for [`new`](Self::new).
    pub fn with_options(scene: &Scene, options: &BuildOptions) -> Result<Self, SceneProblem> {
        scene.validate()?;
        scene.check_size(options.copies)?;
        Ok(Assembly::default().finish(scene, options, None))
    }

    /// Makes an edited scene traceable, as [`new`](Self::new) would, with the same instructions of
    /// the processor and the same say in how its tree is built. The tree, which takes most of the
    /// time, is taken over where every surface is where it was: when only materials, lights, the sky
    /// or the camera are others.
    ///
    /// # Errors
    /// As for [`new`](Self::new).
    pub fn edited(&self, scene: &Scene) -> Result<Self, SceneProblem> {
        scene.validate()?;
        scene.check_size(self.build.copies)?;
        Ok(Assembly::default().finish(scene, &self.build, Some(self)))
    }

    /// The same scene seen by another camera, as [`new`](Self::new) would prepare it; everything else
    /// is shared.
    ///
    /// # Errors
    /// A camera that [`Scene::validate`] would refuse.
    pub fn seen_by(&self, camera: &Camera) -> Result<Self, SceneProblem> {
        camera.validate()?;
        let mut seen = self.clone();
        seen.look_through(*camera);
        Ok(seen)
    }

    /// The same, its rays traced with other instructions of the processor: no picture changes by a
    /// bit. `None` where the processor has none of these.
    pub fn with_simd(self, simd: Simd) -> Option<Self> {
        let surfaces = Arc::unwrap_or_clone(self.surfaces).with_simd(simd)?;
        Some(Self { surfaces: Arc::new(surfaces), ..self })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Perspective;
    use crate::color::Rgb;
    use crate::material::{Emission, Matte};
    use crate::shape::{Mesh, Object, Shape};
    use rutilant_geom::{Transform, Vec2, Vec3};

    /// The tree is kept through edits of how things look, and made anew when one of them moves, or
    /// when one is no longer there.
    #[test]
    fn edits_keep_the_tree_where_they_can() {
        let camera = Perspective::look_at(Vec3::Z * 3.0, Vec3::ZERO, 0.7).unwrap();
        let mut scene = Scene::new(camera);
        let matte = scene.add_material(Matte::new(Rgb::grey(0.5)));
        let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
        let mesh =
            scene.add_mesh(Mesh { positions, triangles: vec![[0, 1, 2]], ..Mesh::default() });
        for shape in [
            Shape::Mesh(mesh),
            Shape::Sphere { radius: 0.5 },
            Shape::Disk { radius: 0.3 },
            Shape::Rectangle { size: Vec2::ONE },
        ] {
            scene.objects.push(Object::new(shape, matte));
        }
        let built = Prepared::new(&scene).unwrap();
        let keeps =
            |scene: &Scene| Arc::ptr_eq(&built.surfaces, &built.edited(scene).unwrap().surfaces);
        let lamp = scene.add_material(Emission::radiance(Rgb::WHITE));
        scene.objects[1].material = lamp;
        scene.camera = Perspective::look_at(Vec3::X * 3.0, Vec3::ZERO, 0.7).unwrap().into();
        assert!(keeps(&scene));
        for number in 0..scene.objects.len() {
            let mut moved = scene.clone();
            let step = Transform::translate(Vec3::new(0.0, 1e-3, 0.0));
            moved.objects[number].world_from_object = step;
            assert!(!keeps(&moved), "{number}");
            let mut fewer = scene.clone();
            fewer.objects.remove(number);
            assert!(!keeps(&fewer), "{number}");
        }
        // Both kept and made anew it is met with the same instructions.
        let scalar = built.clone().with_simd(Simd::Scalar).unwrap();
        let level = |prepared: &Prepared| format!("{:?}", prepared.surfaces.level());
        assert_eq!(level(&scalar.edited(&scene).unwrap()), level(&scalar));
        scene.objects.pop();
        assert_eq!(level(&scalar.edited(&scene).unwrap()), level(&scalar));
    }
}
