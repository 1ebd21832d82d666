//! What caustics come from is looked for in a scene: lights, and what throws their light.

use super::casters::{Caster, Casters, Casting};
use super::prepared::{Prepared, PreparedObject};
use crate::light::{Emitter, EmitterSelection};
use crate::medium::Border;
use rutilant_geom::{Aabb, Frame, Ray, Vec2, Vec3, offset_origin};

impl Prepared {
    /// Finds lights, and what sends light on in single directions. Nothing where surfaces do to light
    /// what only a path from the camera knows.
    pub(super) fn find_casting(&self) -> Option<Casting> {
        /// A point and a direction that nothing which people place by round numbers touches.
        const SOMEWHERE: (Vec2, Vec3) = (Vec2::new(0.37, 0.61), Vec3::new(0.31, 0.17, 1.0));
        let (on_lamp, outward) = SOMEWHERE;
        let casters = self.is_plain.then(|| self.casters())?;
        if casters.is_empty() {
            return None;
        }
        // Glowing borders are left out: which medium their light starts in depends on its side.
        let mut shines = vec![false; self.emitters.len()];
        let absorbs = |b: &Border| !(b.absorption(true) + b.absorption(false)).is_black();
        let some_absorb = self.materials.iter().filter_map(|m| m.border).any(|b| absorbs(&b));
        let (mut media, mut known) = (Vec::new(), vec![false; self.objects.len()]);
        for (primitive, &number) in (0..).zip(&self.object_of_primitive) {
            let object = &self.objects[number as usize];
            let Some(emitter) = object.emitter_of(primitive) else { continue };
            let lamp = &self.emitters[emitter as usize];
            let border = self.materials[object.material as usize].border;
            let Some(point) = lamp.point(on_lamp).filter(|_| lamp.area() > 0.0 && border.is_none())
            else {
                continue;
            };
            shines[emitter as usize] = true;
            if some_absorb && !std::mem::replace(&mut known[number as usize], true) {
                let origin = offset_origin(point.position, point.normal, point.normal);
                let direction = Frame::around(point.normal).to_world(outward).normalize();
                media.push((emitter, self.media_at(Ray::new(origin, direction))));
            }
        }
        media.sort_unstable_by_key(|(emitter, _)| *emitter);
        let lamps = EmitterSelection::of(&self.emitters, |i| shines[i]);
        // Of an even sky, scattered rays see more than light paths would bring.
        let sky = self
            .environment()
            .filter(|(i, sky)| sky.brightest() > 0.0 && !self.emitters[*i].is_even_sky());
        let radiance = |e: &Emitter| e.glow().map_or(0.0, |glow| glow.radiance.max_channel());
        let radiances =
            self.emitters.iter().zip(shines).filter(|(_, s)| *s).map(|(e, _)| radiance(e));
        let brightest = radiances.chain(sky.map(|(_, sky)| sky.brightest())).fold(0.0, f32::max);
        let sky = sky.map(|(i, _)| i as u32);
        let none = matches!(lamps, EmitterSelection::None) && sky.is_none();
        (!none).then_some(Casting { casters, lamps, sky, media, brightest })
    }

    /// Balls around everything that sends light on in single directions.
    fn casters(&self) -> Casters {
        let casts =
            |object: &PreparedObject| self.materials[object.material as usize].bsdf.delta_pmf();
        if !self.objects.iter().any(|object| casts(object) > 0.0) {
            return Casters::default();
        }
        let count = self.objects.len();
        let (mut bounds, mut reach) = (vec![Aabb::EMPTY; count], vec![0.0_f32; count]);
        self.each_piece(|object, point, radius| {
            let whole = &mut bounds[object];
            *whole = whole.grown(point - radius).grown(point + radius);
        });
        self.each_piece(|object, point, radius| {
            let reach = &mut reach[object];
            *reach = reach.max(bounds[object].center().distance(point) + radius);
        });
        let casters = self.objects.iter().zip(bounds).zip(reach);
        let casters = casters.filter(|((object, _), reach)| casts(object) > 0.0 && *reach > 0.0);
        let caster = |((object, bounds), reach)| Caster::around(&bounds, reach, casts(object));
        Casters::new(casters.map(caster).collect())
    }

    /// Tells the balls that hold all surfaces of each object, by the object's number: corners of
    /// triangles are balls without a radius.
    fn each_piece(&self, mut piece: impl FnMut(usize, Vec3, f32)) {
        let mut objects = self.object_of_primitive.iter().map(|&object| object as usize);
        let mut tell = |object: Option<usize>, center: Vec3, radius: f32| {
            if let Some(object) = object.filter(|_| center.is_finite() && radius.is_finite()) {
                piece(object, center, radius);
            }
        };
        for triangle in self.surfaces.triangles() {
            let object = objects.next();
            for &vertex in triangle {
                tell(object, self.surfaces.positions()[vertex as usize], 0.0);
            }
        }
        for sphere in self.surfaces.spheres() {
            tell(objects.next(), sphere.center, sphere.radius);
        }
        for disk in self.surfaces.disks() {
            let radius = (disk.u.length_squared() + disk.v.length_squared()).sqrt();
            tell(objects.next(), disk.center, radius);
        }
        for custom in self.surfaces.customs() {
            let bounds = custom.bounds();
            tell(objects.next(), bounds.center(), 0.5 * bounds.extent().length());
        }
    }
}
