//! Focusing on what is seen in a pixel, through glass and in mirrors.
//!
//! The ray through the middle of the lens is followed until it meets something
//! that is neither mirror nor clear glass. What makes that point sharp is not
//! how far the ray went: glass makes things seem nearer, a ball of it turns
//! them into a picture within the ball, a curved mirror shrinks the room behind
//! it. So the ray's neighbours go along, as derivatives: how far apart two rays
//! arrive that leave the lens side by side, and two that leave one point of it
//! in different directions. The quotient is the distance at which the lens has
//! to make rays meet for all of them to arrive together.
//!
//! For a flat mirror this is the unfolded way, for flat glass of index n seen
//! head on each metre inside counts 1/n. Where rays cannot all arrive together
//! (glass seen at an angle), the circle of least confusion is made smallest.
//!
//! Source: Igehy, "Tracing Ray Differentials", SIGGRAPH 1999.

use crate::camera::{Beam, PreparedCamera};
use crate::follow::follow;
use crate::prepare::Prepared;
use rutilant_geom::{DVec3, Ray, Vec2, Vec3};

/// Something that a camera can focus on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Focus {
    /// The focus distance that makes it sharp, in metres along the view direction.
    pub distance: f32,
    /// The point itself.
    pub point: Vec3,
    /// Metres that the ray went to get there, all segments together.
    pub path_length: f32,
    /// How many mirrors and borders of glass were on its way.
    pub bounces: u32,
}

/// Behind so many mirrors and borders of glass nothing is focused on.
const MAX_BOUNCES: u32 = 64;

/// With this choice clear glass is gone through, unless it reflects everything.
const TRANSMISSION: f32 = 1.0 - 0.5 * f32::EPSILON;

impl Prepared {
    /// What the scene's camera sees at `place`, from (0, 0) in the upper left corner of the
    /// picture to (1, 1) in the lower right one, and how it is focused on; the picture has `size`
    /// pixels.
    ///
    /// `None` where there is nothing but sky, where the way through mirrors and glass does not
    /// end, where no distance makes the point sharp (in a concave mirror for example, whose image
    /// of it lies behind the camera), and for cameras without a lens.
    pub fn focus_on(&self, size: [u32; 2], place: Vec2) -> Option<Focus> {
        let film = place * Vec2::new(size[0] as f32, size[1] as f32);
        let beam = self.camera.beam(size, film)?;
        let mut ray = Ray::new(beam.origin, beam.direction.normalize());
        let mut neighbours = Neighbours::of(&beam);
        let (mut media, mut path_length) = (self.camera_media(), 0.0_f64);
        for bounces in 0..=MAX_BOUNCES {
            let (start, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
            let mut made = None;
            let met = follow(self, &mut ray, &mut media, &mut made, &mut 0, &mut |_| {}).met?;
            let (hit, at) = (&met.hit, &met.at);
            let distance = start.distance(hit.position.as_dvec3());
            path_length += distance;
            neighbours.travel(distance);

            // Go on where light has one way to go; there the ray's neighbours turn as well.
            let bsdf = &met.material.bsdf;
            let go_on = bsdf.is_delta().then(|| {
                bsdf.sample(at.wo_local(), TRANSMISSION, Vec2::ZERO).filter(|sample| sample.delta)
            });
            let Some(sample) = go_on.flatten() else {
                let distance = neighbours.focus_distance(direction)?;
                let path_length = path_length as f32;
                return Some(Focus { distance, point: hit.position, path_length, bounces });
            };
            let crossed = sample.is_transmission(at.wo_local());
            if crossed {
                met.cross(&mut media);
            }
            let next = at.scattered_ray(bsdf, &sample, crossed);
            let normal = at.shading.z.as_dvec3();
            neighbours.meet(direction, hit.normal.as_dvec3());
            neighbours.turn(
                direction,
                next.direction.as_dvec3(),
                normal,
                |step| self.normal_change(hit, step),
                1.0 / f64::from(sample.eta),
            );
            ray = next;
        }
        None
    }

    /// The scene's camera on a film of `size` pixels, focused on what its lens is to focus on.
    pub(crate) fn focused_camera(&self, size: [u32; 2]) -> PreparedCamera {
        let mut camera = self.camera;
        if let Some(lens) = camera.lens_mut()
            && let Some(place) = lens.focus_on
            && let Some(focus) = self.focus_on(size, place)
        {
            lens.focus_distance = focus.distance;
        }
        camera.prepare(size)
    }
}

/// How a ray's position and direction change: with the place on the lens, in the directions of
/// its two axes (`by_place`), and with the direction in which it leaves the middle (`by_tilt`).
struct Neighbours {
    by_place: [Differential; 2],
    by_tilt: [Differential; 2],
}

#[derive(Clone, Copy)]
struct Differential {
    position: DVec3,
    direction: DVec3,
}

impl Neighbours {
    fn of(beam: &Beam) -> Self {
        let (way, axes) = (beam.direction.as_dvec3(), beam.lens_axes.map(Vec3::as_dvec3));
        let unit = way.normalize();
        Self {
            by_place: axes.map(|axis| Differential { position: axis, direction: DVec3::ZERO }),
            // How the unit direction changes where `way` changes by `axis`.
            by_tilt: axes.map(|axis| Differential {
                position: DVec3::ZERO,
                direction: (axis - unit * axis.dot(unit)) / way.length(),
            }),
        }
    }

    fn all(&mut self) -> impl Iterator<Item = &mut Differential> {
        self.by_place.iter_mut().chain(&mut self.by_tilt)
    }

    /// After `distance` along the ray (Igehy 1999, eq. 10), on a plane that goes along.
    fn travel(&mut self, distance: f64) {
        self.all().for_each(|d| d.position += d.direction * distance);
    }

    /// Where the neighbours meet the surface with this normal (eq. 12).
    fn meet(&mut self, direction: DVec3, normal: DVec3) {
        let cos = direction.dot(normal);
        if cos != 0.0 {
            self.all().for_each(|d| d.position -= direction * (d.position.dot(normal) / cos));
        }
    }

    /// After the ray has turned from `before` to `after`. `index` is the index of refraction
    /// before the surface over that beyond it, 1 for a mirror; the unit `normal` changes by
    /// `change` of a step along the surface.
    ///
    /// Mirrors and glass obey one law: `after = index · before + μ · normal`. It is
    /// differentiated here; how μ changes follows from `after` staying a unit vector.
    fn turn(
        &mut self,
        before: DVec3,
        after: DVec3,
        normal: DVec3,
        change: impl Fn(DVec3) -> DVec3,
        index: f64,
    ) {
        let mu = (after - before * index).dot(normal);
        let cos = after.dot(normal);
        for d in self.all() {
            let free = d.direction * index + change(d.position) * mu;
            let along = if cos != 0.0 { free.dot(after) / cos } else { 0.0 };
            d.direction = free - normal * along;
        }
    }

    /// The focus distance that makes the rays through the lens arrive closest together, if there
    /// is one in front of it.
    ///
    /// A ray from place x on the lens tilts by −x / distance and arrives at
    /// (by place − by tilt / distance) x; the sum of the squares over both axes is least.
    fn focus_distance(&self, direction: DVec3) -> Option<f32> {
        let across = |d: &Differential| d.position - direction * d.position.dot(direction);
        let (mut both, mut tilt) = (0.0, 0.0);
        for (by_place, by_tilt) in self.by_place.iter().zip(&self.by_tilt) {
            both += across(by_place).dot(across(by_tilt));
            tilt += across(by_tilt).length_squared();
        }
        let distance = (tilt / both) as f32;
        (distance >= f32::MIN_POSITIVE && distance.is_finite()).then_some(distance)
    }
}
