//! Path tracing with optimal weights for light and BSDF sampling.
//!
//! Paths are those of the balance heuristic. Each tells besides what each way of finding light
//! left to the other, and the film learns how to cancel noise with that.
//!
//! Not for few samples: there is little to learn from. See `control.rs`.

use super::caustics::Caustics;
use super::control::FirstSurface;
use super::estimate::{Integrator, Watched};
use super::first::View;
use super::path::Path;
use super::witness::Witness;
use crate::color::Spectrum;
use crate::prepare::Prepared;
use crate::sampler::Sampler;
use rutilant_geom::Ray;

/// A path tracer in which both ways of finding light are combined by
/// [`Heuristic::Optimal`](crate::settings::Heuristic::Optimal).
pub(crate) struct Optimal<'a>(pub(crate) Path<'a>);

impl Integrator for Optimal<'_> {
    fn radiance<S: Sampler>(
        &self,
        scene: &Prepared,
        ray: Ray,
        sampler: &S,
        rays: &mut u64,
    ) -> Spectrum {
        self.controlled(scene, ray, sampler, rays).0
    }

    fn controlled<S: Sampler>(
        &self,
        scene: &Prepared,
        ray: Ray,
        sampler: &S,
        rays: &mut u64,
    ) -> (Spectrum, f32) {
        let mut control = FirstSurface::new();
        let radiance = self.0.trace(scene, ray, sampler, rays, &mut control);
        (radiance, control.value)
    }

    fn watched<S: Sampler>(
        &self,
        scene: &Prepared,
        ray: Ray,
        sampler: &S,
        (view, look): (&View, bool),
        groups: &mut [Spectrum],
        rays: &mut u64,
    ) -> Watched {
        let mut both = (FirstSurface::new(), Witness::new(scene, view, look, groups));
        let radiance = self.0.trace(scene, ray, sampler, rays, &mut both);
        both.1.told(radiance, both.0.value)
    }

    fn caustics(&self) -> Option<&Caustics<'_>> {
        self.0.caustics()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Perspective;
    use crate::color::Rgb;
    use crate::light::{EmitterSelection, Environment, Light};
    use crate::material::{
        Dielectric, Emission, Material, MaterialKind, Matte, Metal, Mirror, Mix,
    };
    use crate::sampler::{Independent, Sequence};
    use crate::scene::{MaterialId, Scene};
    use crate::settings::{Heuristic, LightSelection, Roulette, Strategy};
    use crate::shape::{Object, Shape};
    use rutilant_geom::{Transform, Vec2, Vec3};

    fn put(scene: &mut Scene, shape: Shape, material: MaterialId, [x, y, z]: [f32; 3]) {
        let place = Transform::translate(Vec3::new(x, y, z));
        scene.objects.push(Object::new(shape, material).transformed(&place));
    }

    /// Rough gold, a half mirror and frosted glass on a clay floor, in the light of a lamp that is
    /// partly hidden, a point, a flame and a sky that is black in two channels.
    fn scene() -> Scene {
        let eye = Vec3::new(0.0, 1.2, 4.0);
        let camera = Perspective::look_at(eye, Vec3::new(0.0, 0.4, 0.0), 0.8);
        let mut s = Scene::new(camera.expect("two different points"));
        s.environment = Some(Environment::constant(Rgb::new(0.0, 0.0, 0.4)));
        s.lights.push(Light::Point {
            position: Vec3::new(2.0, 2.0, 1.0),
            intensity: Rgb::WHITE,
            group: None,
        });
        let clay = s.add_material(Matte { roughness: 0.5, ..Matte::new(Rgb::new(0.7, 0.5, 0.0)) });
        let gold = s.add_material(Metal::Gold.conductor(0.4));
        let mirror = s.add_material(Mirror { reflectance: Rgb::grey(0.9) });
        let half = s.add_material(Mix { first: clay, second: mirror, amount: 0.5 });
        let frosted = s.add_material(Dielectric { roughness: 0.6, ..Dielectric::new(1.5) });
        let lamp = s.add_material(Emission::radiance(Rgb::new(4.0, 3.0, 2.0)));
        let flame = Emission { two_sided: true, ..Emission::radiance(Rgb::new(2.0, 1.0, 0.2)) };
        let flame = s.add_material(Material::new(MaterialKind::Null).emitting(flame));
        let rectangle = |side| Shape::Rectangle { size: Vec2::splat(side) };
        put(&mut s, Shape::Box { size: Vec3::new(9.0, 0.1, 9.0) }, clay, [0.0, -0.05, 0.0]);
        put(&mut s, Shape::Sphere { radius: 0.5 }, gold, [-1.2, 0.5, 0.0]);
        put(&mut s, Shape::Sphere { radius: 0.5 }, half, [0.0, 0.5, 0.0]);
        put(&mut s, Shape::Sphere { radius: 0.5 }, frosted, [1.2, 0.5, 0.0]);
        put(&mut s, rectangle(3.0), lamp, [0.0, 1.5, -2.0]);
        put(&mut s, rectangle(1.0), mirror, [0.5, 1.2, -1.5]);
        put(&mut s, rectangle(0.8), flame, [-0.6, 0.5, 0.8]);
        s
    }

    /// The control is zero on average, in every row of the picture: δ then cannot shift a mean,
    /// whatever it is. A roulette that is not made up for, light that only one of the ways counts
    /// (hidden, black, behind a flame, on mirrors), or a second surface that is counted shows here.
    #[test]
    fn the_control_is_zero_on_average() {
        const SIZE: u32 = 16;
        const SAMPLES: u64 = 2000;
        let scene = Prepared::new(&scene()).expect("a sound scene");
        let camera = scene.focused_camera([SIZE; 2]);
        for (kind, roulette) in [
            (LightSelection::Power, Roulette::Throughput),
            (LightSelection::Uniform, Roulette::Albedo),
            (LightSelection::Tree, Roulette::Throughput),
        ] {
            let selection = EmitterSelection::new(kind, scene.emitters(), scene.radius());
            let (strategy, heuristic) = (Strategy::Both, Heuristic::Optimal);
            let max_depth = u32::MAX;
            let path = Path { selection, strategy, heuristic, roulette, max_depth, caustics: None };
            let optimal = Optimal(path);
            let (mut whole, mut whole_squared) = (0.0, 0.0);
            for y in 0..SIZE {
                let (mut sum, mut squares) = (0.0, 0.0);
                for (x, i) in (0..SIZE).flat_map(|x| (0..SAMPLES).map(move |i| (x, i))) {
                    let sampler = Independent::new(&Sequence::new(3, 1), [x, y], i);
                    let film = Vec2::new(x as f32, y as f32) + sampler.d2(0);
                    let ray = camera.ray(film, Vec2::splat(0.5));
                    let (_, control) = optimal.controlled(&scene, ray, &sampler, &mut 0);
                    assert!((-10.0..=10.0).contains(&control), "{control}");
                    sum += f64::from(control);
                    squares += f64::from(control * control);
                }
                let z = if squares > 0.0 { sum / squares.sqrt() } else { 0.0 };
                assert!(z.abs() < 4.0, "{kind:?}, row {y}: {z} standard errors");
                whole += sum;
                whole_squared += squares;
            }
            let z = whole / whole_squared.sqrt();
            println!("{kind:?}: {z} of {whole_squared}");
            assert!(whole_squared > 1000.0, "{whole_squared}");
            assert!(z.abs() < 3.3, "{kind:?}: {z} standard errors");
        }
    }
}
