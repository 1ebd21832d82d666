//! What caustics come from is looked for in a scene: lights, and what throws their light.

use super::casters::{Caster, Casters};
use super::material::PreparedMaterial;
use super::prepared::{ObjectEmitters, Prepared, PreparedObject};
use crate::dispersion::Bands;
use crate::light::{Emitter, EmitterSelection, LampPoint};
use crate::medium::{Border, Media};
use rayon::prelude::*;
use rutilant_geom::{Aabb, Frame, Ray, Vec2, Vec3, offset_origin};

/// How far an object extends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    bounds: Aabb,
    /// From the middle of the box.
    reach: f32,
}

/// What caustics come from.
#[derive(Clone, Debug)]
pub(crate) struct Casting {
    /// What light is aimed at.
    pub(crate) casters: Casters,
    /// The lamps that light paths start from.
    pub(crate) lamps: EmitterSelection,
    /// The number of the sky among the emitters, where it is one that light paths start from.
    sky: Option<u32>,
    /// What the lamps stand in, by the number of the first emitter of each object: only where
    /// something absorbs, and `None` where that may differ from point to point.
    media: Vec<(u32, Option<Media>)>,
    /// The largest radiance of a light that they start from.
    pub(crate) brightest: f32,
}

impl Casting {
    /// The number of the sky, and how often light paths start from there: as often as from all
    /// lamps together.
    pub(crate) fn sky(&self) -> Option<(usize, f32)> {
        let alone = matches!(self.lamps, EmitterSelection::None);
        Some((self.sky? as usize, if alone { 1.0 } else { 0.5 }))
    }
}

impl Prepared {
    /// What the light of a lamp starts in, at one of its points.
    pub(crate) fn lamp_media(&self, casting: &Casting, emitter: u32, point: &LampPoint) -> Media {
        let after = casting.media.partition_point(|(first, _)| *first <= emitter);
        let known = after.checked_sub(1).map(|i| casting.media[i].1);
        known.map_or(Media::NONE, |media| media.unwrap_or_else(|| self.media_above(point)))
    }

    /// What there is in front of a point of a lamp.
    fn media_above(&self, &LampPoint { position, normal }: &LampPoint) -> Media {
        /// A direction that nothing which people place by round numbers touches.
        const OUTWARD: Vec3 = Vec3::new(0.31, 0.17, 1.0);
        let direction = Frame::around(normal).to_world(OUTWARD).normalize();
        self.media_at(Ray::new(offset_origin(position, normal, direction), direction))
    }

    /// Finds lights, and what sends light on in single directions. Nothing where surfaces do to light
    /// what only a path from the camera knows.
    pub(super) fn find_casting(&self) -> Option<Casting> {
        /// A point of a lamp.
        const SOMEWHERE: Vec2 = Vec2::new(0.37, 0.61);
        if !self.is_plain || !self.materials.iter().any(PreparedMaterial::casts) {
            return None;
        }
        let extents = self.extents.get_or_init(|| self.find_extents());
        let casters = self.casters(extents);
        if casters.is_empty() {
            return None;
        }
        // Glowing borders are left out: which medium their light starts in depends on its side.
        let mut shines = vec![false; self.emitters.len()];
        let absorbs = |b: &Border| !(b.absorption(true) + b.absorption(false)).is_black();
        let some_absorb = self.materials.iter().filter_map(|m| m.border).any(|b| absorbs(&b));
        let bodies = || {
            let objects = self.objects.iter().enumerate();
            objects
                .filter(|(_, o)| self.materials[o.material as usize].border.is_some())
                .map(|o| o.0)
        };
        let (mut media, mut known) = (Vec::new(), vec![false; self.objects.len()]);
        for (primitive, number) in self.primitives_of_objects() {
            let object = &self.objects[number as usize];
            let Some(emitter) = object.emitter_of(primitive) else { continue };
            let lamp = &self.emitters[emitter as usize];
            let border = self.materials[object.material as usize].border;
            let Some(point) =
                lamp.point(SOMEWHERE).filter(|_| lamp.area() > 0.0 && border.is_none())
            else {
                continue;
            };
            shines[emitter as usize] = true;
            if some_absorb && !std::mem::replace(&mut known[number as usize], true) {
                // One border through its box, and it may stand on both sides.
                let bounds = &extents[number as usize].bounds;
                let crossed = bodies().any(|other| extents[other].bounds.overlaps(bounds));
                media.push((emitter, (!crossed).then(|| self.media_above(&point))));
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
        let brightest = if self.disperses() { brightest * Bands::MOST_WORTH } else { brightest };
        let sky = sky.map(|(i, _)| i as u32);
        let none = matches!(lamps, EmitterSelection::None) && sky.is_none();
        (!none).then_some(Casting { casters, lamps, sky, media, brightest })
    }

    /// Balls around everything that sends light on in single directions.
    fn casters(&self, extents: &[Extent]) -> Casters {
        let casts = |object: &PreparedObject| {
            let material = &self.materials[object.material as usize];
            if material.casts() { material.bsdf.delta_pmf() } else { 0.0 }
        };
        let mut reaches: Vec<f32> = extents.iter().map(|extent| extent.reach).collect();
        let reach = |(i, object): (usize, &u32)| {
            let center = extents[*object as usize].bounds.center();
            let casts = casts(&self.objects[*object as usize]) > 0.0 && center.is_finite();
            let reach = || self.surfaces.reach_of_instance(i as u32, center);
            (*object, if casts { reach() } else { 0.0 })
        };
        let instances = self.object_of_instance.par_iter().enumerate();
        for (object, reach) in instances.map(reach).collect::<Vec<_>>() {
            reaches[object as usize] = reach;
        }
        let casters = self.objects.iter().zip(extents.iter().zip(reaches));
        let casters = casters.filter(|(object, (_, reach))| casts(object) > 0.0 && *reach > 0.0);
        let caster = |(object, (e, reach)): (_, (&Extent, f32))| {
            Caster::around(&e.bounds, reach, casts(object))
        };
        Casters::new(casters.map(caster).collect())
    }

    /// All primitives with the number of the object that each belongs to; of instances only those
    /// that glow.
    fn primitives_of_objects(&self) -> impl Iterator<Item = (u32, u32)> {
        let alone = (0..).zip(self.object_of_primitive.iter().copied());
        let instances = self.object_of_instance.iter().zip(self.surfaces.instances());
        let glowing = instances.filter(|(object, _)| {
            !matches!(self.objects[**object as usize].emitters, ObjectEmitters::None)
        });
        alone.chain(glowing.flat_map(|(object, instance)| {
            let triangles = self.surfaces.mesh_of(instance).triangles().len() as u32;
            (0..triangles).map(move |primitive| (primitive, *object))
        }))
    }

    /// How far each object extends; of instances only their boxes.
    fn find_extents(&self) -> Vec<Extent> {
        let mut extents = vec![Extent { bounds: Aabb::EMPTY, reach: 0.0 }; self.objects.len()];
        self.each_piece(|object, point, radius| {
            let bounds = &mut extents[object].bounds;
            *bounds = bounds.grown(point - radius).grown(point + radius);
        });
        self.each_piece(|object, point, radius| {
            let Extent { bounds, reach } = &mut extents[object];
            *reach = reach.max(bounds.center().distance(point) + radius);
        });
        let instances = (0..self.object_of_instance.len() as u32).into_par_iter();
        let bounds: Vec<Aabb> = instances.map(|i| self.surfaces.bounds_of_instance(i)).collect();
        for (object, bounds) in self.object_of_instance.iter().zip(bounds) {
            extents[*object as usize].bounds = bounds;
        }
        extents
    }

    /// Tells the balls that hold all surfaces of each object that is no instance, by the object's
    /// number: corners of triangles are balls without a radius.
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
